//! The equations of motion of a rigid body on the moving plate, derived from its energies.

use bracketry_system::symbolic::{Expr, Func, Pool, Symbol};
use rustc_hash::FxHashMap;

type Matrix = [[Expr; 3]; 3];

/// What Lagrange's equations give for a rigid body that lies flat on the moving plate. Everything is per mass.
///
/// Symbols of the pool: the state `x, y, phi, vx, vy, w`; the plate's `X, Xd, Xdd, theta, thetad, thetadd`; gravity `g`; the
/// height `h` of the center of mass above the plate; the body's second moments per mass `Sa, Sb, Sc` along its own x, y and
/// normal; the friction force `fx, fy` and its yaw torque `n`; the offset `rx, ry` of a contact point from the center of mass,
/// plate axes.
#[derive(Clone)]
pub struct FlatContact {
    /// The arena of the expressions.
    pub pool: Pool,
    /// `x'', y'', phi''`.
    pub accelerations: [Expr; 3],
    /// Normal force `N`.
    pub load: Expr,
    /// First moments `∫ rx p`, `∫ ry p` of the contact pressure about the center of mass.
    pub pressure_moments: [Expr; 2],
    /// Contact pressure at the offset `rx, ry`, the one affine in the offset: pressure times the body's area over its mass.
    pub pressure: Expr,
    /// Kinetic and potential energy in the inertial frame.
    pub energy: Expr,
    /// Power of all contact forces on the body in the inertial frame; it is the rate of `energy`.
    pub contact_power: Expr,
}

/// Derives the equations of a rigid body in flat contact with the moving plate.
///
/// The body has six coordinates relative to the plate: its center of mass `x, y, z` and its attitude `Rz(phi) Ry(pitch)
/// Rx(roll)`. The kinetic energy is the integral of the squared velocities of its points, by second moments; the contact acts
/// on points of the bottom face. `d/dt ∂L/∂q' − ∂L/∂q = Q` is restricted to `z = h`, `roll = pitch = 0` and solved: three
/// equations give the motion in the plane, three the load and the moments of the pressure.
///
/// ```
/// let mut flat = bracketry_plate::model::flat_contact();
/// assert_eq!(flat.pool.text(flat.accelerations[0]), "fx - Xdd");
/// ```
pub fn flat_contact() -> FlatContact {
    Body::new().flat()
}

/// The free body with everything that moves.
struct Body {
    pool: Pool,
    /// x, y, z, roll, pitch, phi.
    coordinates: [Symbol; 6],
    rates: [Symbol; 6],
    /// What depends on time, and its rate.
    moving: (Vec<Symbol>, Vec<Expr>),
    /// Center of mass in the inertial frame.
    center: [Expr; 3],
    /// Attitude in the inertial frame.
    attitude: Matrix,
    /// Turns plate axes into inertial ones.
    tilt: Matrix,
}

impl Body {
    fn new() -> Self {
        let mut pool = Pool::new();
        let coordinates = ["x", "y", "z", "roll", "pitch", "phi"].map(|name| pool.symbol(name));
        let rates = ["vx", "vy", "vz", "rollrate", "pitchrate", "w"].map(|name| pool.symbol(name));
        let accelerations = ["ax", "ay", "az", "rollacc", "pitchacc", "aphi"].map(|name| pool.symbol(name));
        let plate = ["X", "Xd", "Xdd", "theta", "thetad", "thetadd"].map(|name| pool.symbol(name));
        let mut moving = (Vec::new(), Vec::new());
        let chains = coordinates.iter().zip(&rates).chain(rates.iter().zip(&accelerations));
        for (&symbol, &rate) in chains.chain([0, 1, 3, 4].map(|i| (&plate[i], &plate[i + 1]))) {
            moving.0.push(symbol);
            moving.1.push(pool.sym(rate));
        }
        let [x, y, z, roll, pitch, phi] = coordinates.map(|s| pool.sym(s));
        let (displacement, theta) = (pool.sym(plate[0]), pool.sym(plate[3]));
        let tilt = rotation(&mut pool, 0, theta);
        let mut attitude = tilt;
        for (axis, angle) in [(2, phi), (1, pitch), (0, roll)] {
            let factor = rotation(&mut pool, axis, angle);
            attitude = product(&mut pool, &attitude, &factor);
        }
        let mut center = apply(&mut pool, &tilt, [x, y, z]);
        center[0] = pool.add(displacement, center[0]);
        Self { pool, coordinates, rates, moving, center, attitude, tilt }
    }

    /// Time derivative by the chain rule.
    fn rate(&mut self, e: Expr) -> Expr {
        self.pool.lie_derivative(e, &self.moving.0, &self.moving.1)
    }

    /// Kinetic and potential energy: `½|r'|² + ½ Σ_k S_k |R' e_k|²` and `g` times the height.
    fn energies(&mut self) -> (Expr, Expr) {
        let moments = ["Sa", "Sb", "Sc"].map(|name| self.pool.var(name));
        let mut twice = self.pool.int(0);
        for i in 0..3 {
            let v = self.rate(self.center[i]);
            let square = self.pool.powi(v, 2);
            twice = self.pool.add(twice, square);
            for k in 0..3 {
                let v = self.rate(self.attitude[i][k]);
                let square = self.pool.powi(v, 2);
                let term = self.pool.mul(moments[k], square);
                twice = self.pool.add(twice, term);
            }
        }
        let half = self.pool.ratio(1, 2);
        let g = self.pool.var("g");
        (self.pool.mul(half, twice), self.pool.mul(g, self.center[2]))
    }

    /// A point of the bottom face in the inertial frame, body coordinates `xi, eta`.
    fn contact_point(&mut self) -> [Expr; 3] {
        let (xi, eta, h) = (self.pool.var("xi"), self.pool.var("eta"), self.pool.var("h"));
        let down = self.pool.neg(h);
        let offset = apply(&mut self.pool, &self.attitude, [xi, eta, down]);
        [0, 1, 2].map(|i| self.pool.add(self.center[i], offset[i]))
    }

    /// Force on a contact point in the inertial frame: friction `qx, qy` and pressure `p`, plate axes.
    fn contact_force(&mut self) -> [Expr; 3] {
        let force = ["qx", "qy", "p"].map(|name| self.pool.var(name));
        apply(&mut self.pool, &self.tilt, force)
    }

    /// The expression where the body lies flat and moves in the plane only, contact points by their offset in plate axes.
    fn restricted(&mut self, e: Expr) -> Expr {
        let pool = &mut self.pool;
        let zero = pool.int(0);
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        for name in ["roll", "pitch", "vz", "rollrate", "pitchrate", "az", "rollacc", "pitchacc"] {
            map.insert(pool.var(name), zero);
        }
        map.insert(pool.var("z"), pool.var("h"));
        let (c, s) = cosine_and_sine(pool);
        let (rx, ry) = (pool.var("rx"), pool.var("ry"));
        let terms = [pool.mul(c, rx), pool.mul(s, ry), pool.mul(c, ry), pool.mul(s, rx)];
        map.insert(pool.var("xi"), pool.add(terms[0], terms[1]));
        map.insert(pool.var("eta"), pool.sub(terms[2], terms[3]));
        let flat = pool.substitute(e, &map);
        pool.simplify(flat)
    }

    /// `e`, linear in the force on a contact point and affine in its offset, integrated over the contact.
    fn integrated(&mut self, e: Expr) -> Expr {
        let pool = &mut self.pool;
        let zero = pool.int(0);
        let centered: FxHashMap<Expr, Expr> = ["rx", "ry"].map(|r| (pool.var(r), zero)).into_iter().collect();
        // Resultant and first moments of each component.
        let integrals = [("qx", "fx", "rx*qx", "ry*qx"), ("qy", "fy", "rx*qy", "ry*qy"), ("p", "N", "rx*p", "ry*p")];
        let mut total = zero;
        for (component, resultant, moment_x, moment_y) in integrals {
            let component = pool.symbol(component);
            let factor = pool.diff(e, component);
            let value = pool.substitute(factor, &centered);
            let (rx, ry) = (pool.symbol("rx"), pool.symbol("ry"));
            let slopes = [pool.diff(factor, rx), pool.diff(factor, ry)];
            for (factor, integral) in [(value, resultant), (slopes[0], moment_x), (slopes[1], moment_y)] {
                let integral = pool.var(integral);
                let term = pool.mul(factor, integral);
                total = pool.add(total, term);
            }
        }
        // Friction has a yaw torque n = ∫ (rx qy − ry qx).
        let (n, other) = (pool.var("n"), pool.var("ry*qx"));
        let torque = (pool.var("rx*qy"), pool.add(n, other));
        let with_torque = pool.substitute(total, &[torque].into_iter().collect());
        pool.simplify(with_torque)
    }

    /// Lagrange's equations `d/dt ∂L/∂q' − ∂L/∂q − Q = 0` in flat contact, one per coordinate.
    fn equations(&mut self, kinetic: Expr, potential: Expr) -> [Expr; 6] {
        let lagrangian = self.pool.sub(kinetic, potential);
        let (point, force) = (self.contact_point(), self.contact_force());
        [0, 1, 2, 3, 4, 5].map(|i| {
            let (q, v) = (self.coordinates[i], self.rates[i]);
            let momentum = self.pool.diff(lagrangian, v);
            let change = self.rate(momentum);
            let slope = self.pool.diff(lagrangian, q);
            let inertial = self.pool.sub(change, slope);
            let inertial = self.restricted(inertial);
            let shares = [0, 1, 2].map(|j| {
                let lever = self.pool.diff(point[j], q);
                self.pool.mul(force[j], lever)
            });
            let generalized = self.pool.add(shares[0], shares[1]);
            let generalized = self.pool.add(generalized, shares[2]);
            let generalized = self.restricted(generalized);
            let generalized = self.integrated(generalized);
            self.pool.sub(inertial, generalized)
        })
    }

    /// The unknown from the equation `e = 0`, linear in it.
    fn solved(&mut self, e: Expr, unknown: &str) -> Expr {
        let pool = &mut self.pool;
        let unknown = pool.symbol(unknown);
        let slope = pool.diff(e, unknown);
        let none = [(pool.sym(unknown), pool.int(0))].into_iter().collect();
        let rest = pool.substitute(e, &none);
        let quotient = pool.div(rest, slope);
        let value = pool.neg(quotient);
        pool.simplify(value)
    }

    fn flat(mut self) -> FlatContact {
        let (kinetic, potential) = self.energies();
        let [along, across, normal, roll, pitch, yaw] = self.equations(kinetic, potential);
        let accelerations = [(along, "ax"), (across, "ay"), (yaw, "aphi")].map(|(e, unknown)| self.solved(e, unknown));
        let load = self.solved(normal, "N");
        // Roll and pitch turn about the body's axes; about those of the plate each pressure moment stands alone.
        let (cosine, sine) = cosine_and_sine(&mut self.pool);
        let about = |this: &mut Self, a: Expr, b: Expr, unknown: &str| {
            let (p, q) = (this.pool.mul(a, roll), this.pool.mul(b, pitch));
            let sum = this.pool.add(p, q);
            let sum = this.pool.simplify(sum);
            this.solved(sum, unknown)
        };
        let minus_sine = self.pool.neg(sine);
        let moment_y = about(&mut self, cosine, minus_sine, "ry*p");
        let moment_x = about(&mut self, sine, cosine, "rx*p");
        let energy = self.pool.add(kinetic, potential);
        let energy = self.restricted(energy);
        let contact_power = self.contact_power(load, [moment_x, moment_y]);
        let pressure = affine_pressure(&mut self.pool, load, [moment_x, moment_y]);
        FlatContact {
            pool: self.pool,
            accelerations,
            load,
            pressure_moments: [moment_x, moment_y],
            pressure,
            energy,
            contact_power,
        }
    }

    /// Forces on contact points times the inertial velocity of the body there, integrated.
    fn contact_power(&mut self, load: Expr, moments: [Expr; 2]) -> Expr {
        let (point, force) = (self.contact_point(), self.contact_force());
        let mut power = self.pool.int(0);
        for i in 0..3 {
            let velocity = self.rate(point[i]);
            let share = self.pool.mul(force[i], velocity);
            power = self.pool.add(power, share);
        }
        let power = self.restricted(power);
        let power = self.integrated(power);
        let names = ["N", "rx*p", "ry*p"].map(|name| self.pool.var(name));
        let values = [load, moments[0], moments[1]];
        let power = self.pool.substitute(power, &names.into_iter().zip(values).collect());
        self.pool.simplify(power)
    }
}

/// `N + px rx + py ry` with the first moments given: `(px, py) = S⁻¹ (∫ rx p, ∫ ry p)`.
fn affine_pressure(pool: &mut Pool, load: Expr, [mx, my]: [Expr; 2]) -> Expr {
    let (c, s) = cosine_and_sine(pool);
    let (sa, sb) = (pool.var("Sa"), pool.var("Sb"));
    let (cc, ss, cs) = (pool.powi(c, 2), pool.powi(s, 2), pool.mul(c, s));
    let sum = |pool: &mut Pool, p: Expr, q: Expr| {
        let (a, b) = (pool.mul(p, sa), pool.mul(q, sb));
        pool.add(a, b)
    };
    let (sxx, syy) = (sum(pool, cc, ss), sum(pool, ss, cc));
    let difference = pool.sub(sa, sb);
    let (sxy, determinant) = (pool.mul(cs, difference), pool.mul(sa, sb));
    let mut pressure = load;
    for (r, diagonal, own, other) in [("rx", syy, mx, my), ("ry", sxx, my, mx)] {
        let (p, q) = (pool.mul(diagonal, own), pool.mul(sxy, other));
        let slope = pool.sub(p, q);
        let slope = pool.div(slope, determinant);
        let slope = pool.simplify(slope);
        let r = pool.var(r);
        let term = pool.mul(slope, r);
        pressure = pool.add(pressure, term);
    }
    pressure
}

/// Cosine and sine of the yaw angle.
fn cosine_and_sine(pool: &mut Pool) -> (Expr, Expr) {
    let phi = pool.var("phi");
    (pool.call(Func::Cos, phi), pool.call(Func::Sin, phi))
}

/// Rotation about a coordinate axis.
fn rotation(pool: &mut Pool, axis: usize, angle: Expr) -> Matrix {
    let (c, s) = (pool.call(Func::Cos, angle), pool.call(Func::Sin, angle));
    let mut matrix = [[pool.int(0); 3]; 3];
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    matrix[axis][axis] = pool.int(1);
    (matrix[i][i], matrix[j][j]) = (c, c);
    (matrix[i][j], matrix[j][i]) = (pool.neg(s), s);
    matrix
}

fn apply(pool: &mut Pool, matrix: &Matrix, v: [Expr; 3]) -> [Expr; 3] {
    matrix.map(|row| {
        let mut total = pool.int(0);
        for (a, b) in row.into_iter().zip(v) {
            let term = pool.mul(a, b);
            total = pool.add(total, term);
        }
        total
    })
}

fn product(pool: &mut Pool, a: &Matrix, b: &Matrix) -> Matrix {
    let columns = [0, 1, 2].map(|j| apply(pool, a, [b[0][j], b[1][j], b[2][j]]));
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i]))
}
