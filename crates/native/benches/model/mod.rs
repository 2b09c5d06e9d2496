//! A plate model with friction coupled over all directions, and its 6 × 7 Jacobian written by hand.

use bracketry_symbolic::{Expr, Names, Pool, Tape};

/// Rows: d/dt of x, y, φ and of their velocities; columns: y, φ, the velocities, θ and its acceleration.
pub(crate) const ROWS: usize = 6;
/// Columns of the Jacobian.
pub(crate) const COLUMNS: usize = 7;

const G: f64 = 9.81;
const H: f64 = 0.0025;
const MU: f64 = 0.3;
const SA: f64 = 0.005625;
const SB: f64 = 0.0025;
const INERTIA: f64 = SA + SB;
/// Squared width of the rounded friction law.
const EPS2: f64 = 1e-4;

const DEFINITIONS: [(&str, &str); 11] = [
    ("N", "9.81*cos(th) + y*al + 2*vy*om - 0.0025*om^2"),
    ("s", "sqrt(vx^2 + vy^2 + 1e-4)"),
    ("ex", "vx/s"),
    ("ey", "vy/s"),
    ("Sxx", "cos(phi)^2*0.005625 + sin(phi)^2*0.0025"),
    ("Syy", "sin(phi)^2*0.005625 + cos(phi)^2*0.0025"),
    ("Sxy", "0.003125*cos(phi)*sin(phi)"),
    ("See", "Sxx*ex^2 + 2*Sxy*ex*ey + Syy*ey^2"),
    ("ax", "-A - 0.3*N*ex"),
    ("ay", "-9.81*sin(th) + y*om^2 + 0.0025*al - 0.3*N*ey"),
    (
        "aw",
        "(-0.3*al*(Sxy*ey - Syy*ex) + Sxy*om^2 - 0.3*9.81*cos(th)*See*w/sqrt(vx^2 + vy^2 + 1e-4 + 0.008125*w^2/4))/0.008125",
    ),
];

/// Arguments of the Jacobian: its seven variables, then the tilt rate and the acceleration of the plate.
pub(crate) const ARGUMENTS: [&str; 9] = ["y", "phi", "vx", "vy", "w", "th", "al", "om", "A"];

/// Definitions that were read so far; any other name is an indeterminate.
struct Scope(Vec<(&'static str, Expr)>);

impl Names for Scope {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        let known = self.0.iter().find(|(n, _)| *n == name).map(|(_, e)| *e);
        Some(known.unwrap_or_else(|| pool.var(name)))
    }
    fn known(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The Jacobian, row by row, derived symbolically.
pub(crate) fn tape() -> Tape {
    repeated(1)
}

/// `copies` Jacobians, the k-th at `vx + k`, in one tape.
pub(crate) fn repeated(copies: usize) -> Tape {
    let mut p = Pool::new();
    let mut scope = Scope(Vec::new());
    for (name, text) in DEFINITIONS {
        let e = p.parse_with(text, &mut scope).expect("an expression");
        scope.0.push((name, e));
    }
    let field = ["vx", "vy", "w", "ax", "ay", "aw"].map(|t| p.parse_with(t, &mut scope).expect("an expression"));
    let arguments = ARGUMENTS.map(|n| p.symbol(n));
    let jacobian = p.jacobian(&field, &arguments[..COLUMNS]).concat();
    let vx = p.var("vx");
    let mut outputs = Vec::new();
    for k in 0..copies {
        let shift = p.int(k as i64);
        let moved = p.add(vx, shift);
        let map = [(vx, moved)].into_iter().collect();
        outputs.extend(p.substitute_all(&jacobian, &map));
    }
    Tape::compile(&p, &arguments, &outputs).expect("all names are arguments")
}

/// The same Jacobian as someone would write it.
#[inline(never)]
pub(crate) fn by_hand(v: &[f64; 9], out: &mut [f64; ROWS * COLUMNS]) {
    let [y, phi, vx, vy, w, th, al, om, _] = *v;
    let (sth, cth) = (th.sin(), th.cos());
    let (sp, cp) = (phi.sin(), phi.cos());
    let n = G * cth + y * al + 2.0 * vy * om - H * om * om;
    let q = vx * vx + vy * vy + EPS2;
    let s = q.sqrt();
    let (ex, ey) = (vx / s, vy / s);
    // Derivatives of the slip direction.
    let r = 1.0 / (q * s);
    let (ex_vx, ex_vy, ey_vy) = ((q - vx * vx) * r, -vx * vy * r, (q - vy * vy) * r);
    let ey_vx = ex_vy;
    let (sxx, syy, sxy) = (cp * cp * SA + sp * sp * SB, sp * sp * SA + cp * cp * SB, cp * sp * (SA - SB));
    let sxx_p = -2.0 * sxy;
    let sxy_p = (cp * cp - sp * sp) * (SA - SB);
    let see = sxx * ex * ex + 2.0 * sxy * ex * ey + syy * ey * ey;
    let see_p = sxx_p * (ex * ex - ey * ey) + 2.0 * sxy_p * ex * ey;
    let see_ex = 2.0 * (sxx * ex + sxy * ey);
    let see_ey = 2.0 * (sxy * ex + syy * ey);
    let see_vx = see_ex * ex_vx + see_ey * ey_vx;
    let see_vy = see_ex * ex_vy + see_ey * ey_vy;
    let d = q + INERTIA * w * w / 4.0;
    let root = d.sqrt();
    let spin = w / root;
    let spin_v = -w / (d * root);
    let spin_w = 1.0 / root - w * w * INERTIA / 4.0 / (d * root);
    let k = MU * G * cth;
    out.fill(0.0);
    out[2] = 1.0;
    out[COLUMNS + 3] = 1.0;
    out[2 * COLUMNS + 4] = 1.0;
    let (n_th, n_vy) = (-G * sth, 2.0 * om);
    out[3 * COLUMNS..4 * COLUMNS].copy_from_slice(&[
        -MU * al * ex,
        0.0,
        -MU * n * ex_vx,
        -MU * (n_vy * ex + n * ex_vy),
        0.0,
        -MU * n_th * ex,
        -MU * y * ex,
    ]);
    out[4 * COLUMNS..5 * COLUMNS].copy_from_slice(&[
        om * om - MU * al * ey,
        0.0,
        -MU * n * ey_vx,
        -MU * (n_vy * ey + n * ey_vy),
        0.0,
        -G * cth - MU * n_th * ey,
        H - MU * y * ey,
    ]);
    out[5 * COLUMNS..].copy_from_slice(&[
        0.0,
        (-MU * al * (sxy_p * ey + sxx_p * ex) + sxy_p * om * om - k * see_p * spin) / INERTIA,
        (-MU * al * (sxy * ey_vx - syy * ex_vx) - k * (see_vx * spin + see * spin_v * vx)) / INERTIA,
        (-MU * al * (sxy * ey_vy - syy * ex_vy) - k * (see_vy * spin + see * spin_v * vy)) / INERTIA,
        -k * see * spin_w / INERTIA,
        MU * G * sth * see * spin / INERTIA,
        -MU * (sxy * ey - syy * ex) / INERTIA,
    ]);
}
