//! The area contact with rounded friction, as differential equations for an optimizer.

use crate::object::Patch;
use crate::{GRAVITY, Object, PlateError};
use bracketry_mpc::{Dynamics, MpcError, PlannedTrajectory};

/// States of [`RoundedContact`]: `x, y, phi, vx, vy, w` of the object in the plate frame, `X, X', θ, θ'` of the plate.
const CONTROL_STATES: usize = 10;
/// Inputs of [`RoundedContact`]: `X''`, `θ''`.
const CONTROL_INPUTS: usize = 2;
/// Variables of states and inputs.
const VARIABLES: usize = CONTROL_STATES + CONTROL_INPUTS;

/// Largest product of step and relaxation rate of an explicit method of order 4.
const STABLE_STEP: f64 = 2.0;

const Y: usize = 1;
const PHI: usize = 2;
const VX: usize = 3;
const VY: usize = 4;
const W: usize = 5;
const TILT: usize = 8;
const TILT_RATE: usize = 9;
const TILT_ACCELERATION: usize = 11;

/// A flat object under dry friction over its footprint ([`crate::area::AreaContact`]) with `v/|v|` at each point rounded to
/// `v/√(v² + ε²)`, and the accelerations of the plate as inputs. The derivatives are exact.
///
/// ```text
/// x'' = −X'' + Σ w_i fx_i
/// y'' = −g sin θ + y θ'² + h θ'' + Σ w_i fy_i
/// I φ'' = Sxy θ'² + Σ w_i (x̃_i fy_i − ỹ_i fx_i)
/// f_i = −μ p_i v_i/√(v_i² + ε²)
/// p_i = α_i (g cos θ + y θ'' + 2 θ' y' − h θ'²) + β_iy θ'' + 2 θ' φ' β_ix
/// ```
///
/// These are the equations of the center of mass. On the whole footprint `α_i = 1` and `β_i = (x̃_i, ỹ_i)`; another
/// [`crate::object::Bearing`] has others, so that force and moments are the same. Where the center of mass is not that of the shape, states are
/// those of the center of the shape all the same. All points are taken to carry; the moment of friction about the center of mass
/// (of the order `μ h/R`) is left out.
#[derive(Debug, Clone)]
pub struct RoundedContact {
    points: Vec<ModelPoint>,
    moments: (f64, f64),
    /// Angle of the principal axes in rad.
    principal: f64,
    center_of_mass: [f64; 2],
    height: f64,
    mu: f64,
    width: f64,
    pattern: Vec<(usize, usize)>,
}

/// A contact point: from the center of mass (m), its share, and what inertia makes of its pressure.
#[derive(Debug, Clone, Copy)]
struct ModelPoint {
    at: [f64; 2],
    share: f64,
    level: f64,
    slope: [f64; 2],
}

/// A value with its derivatives with respect to states and inputs.
#[derive(Clone, Copy)]
struct Row {
    value: f64,
    slope: [f64; VARIABLES],
}

impl Row {
    const ZERO: Row = Row { value: 0.0, slope: [0.0; VARIABLES] };
}

/// Variables on which friction depends.
const FRICTION_VARIABLES: [usize; 8] = [Y, PHI, VX, VY, W, TILT, TILT_RATE, TILT_ACCELERATION];

impl RoundedContact {
    /// Equations with about `points` contact points; ε is 0.01 m/s at first.
    ///
    /// # Errors
    /// [`PlateError`] if the object or the coefficient has no meaning.
    pub fn new(object: &Object, mu: f64, points: usize) -> Result<Self, PlateError> {
        if !(mu.is_finite() && mu >= 0.0) {
            return Err(PlateError::NegativeNumber { name: "mu", value: mu });
        }
        let patch = Patch::of(object, points)?;
        let point = |(at, share): (&[f64; 2], &f64)| {
            let (level, slope) = patch.response(object, *at);
            ModelPoint { at: *at, share: *share, level, slope }
        };
        let points = patch.rule.points.iter().zip(&patch.rule.weights).map(point).collect();
        let mut pattern: Vec<(usize, usize)> = [(0, VX), (1, VY), (2, W), (6, 7), (7, 10), (8, 9), (9, 11)].into();
        pattern.push((VX, 10));
        for row in [VX, VY, W] {
            pattern.extend(FRICTION_VARIABLES.map(|column| (row, column)));
        }
        pattern.sort_unstable();
        Ok(Self {
            points,
            moments: object.shape.second_moments(),
            principal: object.shape.principal_angle(),
            center_of_mass: object.center_of_mass,
            height: object.height,
            mu,
            width: 0.01,
            pattern,
        })
    }

    /// The same equations with another friction coefficient.
    #[must_use]
    pub fn with_mu(&self, mu: f64) -> Self {
        Self { mu, ..self.clone() }
    }

    /// A trajectory with the inputs of another and the states that they give from `start`.
    pub(super) fn rolled_out(
        &mut self,
        start: &[f64; CONTROL_STATES],
        trajectory: &PlannedTrajectory,
        interval: f64,
    ) -> Result<PlannedTrajectory, MpcError> {
        let mut x = *start;
        let mut states = vec![x.to_vec()];
        let mut inputs = Vec::with_capacity(trajectory.steps());
        for k in 0..trajectory.steps() {
            let u = trajectory.u(k);
            let parts = (interval * self.relaxation_rate(0.0, &x, u) / STABLE_STEP).ceil().clamp(1.0, 1e3);
            for _ in 0..parts as usize {
                self.step(&mut x, u, interval / parts);
            }
            states.push(x.to_vec());
            inputs.push(u.to_vec());
        }
        PlannedTrajectory::from_rows(&states, &inputs)
    }

    /// One step of the classical Runge–Kutta method.
    fn step(&mut self, x: &mut [f64; CONTROL_STATES], u: &[f64], dt: f64) {
        let mut slopes = [[0.0; CONTROL_STATES]; 4];
        for stage in 0..4 {
            let mut at = *x;
            if stage > 0 {
                let share = if stage == 3 { dt } else { 0.5 * dt };
                for i in 0..CONTROL_STATES {
                    at[i] += share * slopes[stage - 1][i];
                }
            }
            self.field(0.0, &at, u, &mut slopes[stage]);
        }
        for i in 0..CONTROL_STATES {
            x[i] += dt / 6.0 * (slopes[0][i] + 2.0 * slopes[1][i] + 2.0 * slopes[2][i] + slopes[3][i]);
        }
    }

    /// The three accelerations of the center of the shape; with slopes if `slopes`.
    ///
    /// With `ρ` from the center of the shape to that of the mass, the center of mass moves with `v + φ' k × ρ`, and the center of
    /// the shape is accelerated by `a − φ'' k × ρ + φ'² ρ`.
    fn accelerations(&self, x: &[f64], u: &[f64], slopes: bool) -> [Row; 3] {
        if self.center_of_mass == [0.0; 2] {
            return self.accelerations_of_mass(x, u, slopes);
        }
        let ((s, c), [dx, dy], w) = (x[PHI].sin_cos(), self.center_of_mass, x[W]);
        let (rx, ry) = (c * dx - s * dy, s * dx + c * dy);
        let mut of_mass: [f64; CONTROL_STATES] = std::array::from_fn(|i| x[i]);
        of_mass[0] += rx;
        of_mass[Y] += ry;
        of_mass[VX] -= w * ry;
        of_mass[VY] += w * rx;
        let mut rows = self.accelerations_of_mass(&of_mass, u, slopes);
        if slopes {
            for row in &mut rows {
                let (y, vx, vy) = (row.slope[Y], row.slope[VX], row.slope[VY]);
                row.slope[PHI] += y * rx - w * (vx * rx + vy * ry);
                row.slope[W] += vy * rx - vx * ry;
            }
        }
        let spin = rows[2];
        rows[0].value += spin.value * ry + w * w * rx;
        rows[1].value += w * w * ry - spin.value * rx;
        for (column, slope) in spin.slope.into_iter().enumerate() {
            rows[0].slope[column] += slope * ry;
            rows[1].slope[column] -= slope * rx;
        }
        if slopes {
            rows[0].slope[PHI] += spin.value * rx - w * w * ry;
            rows[1].slope[PHI] += w * w * rx + spin.value * ry;
            rows[0].slope[W] += 2.0 * w * rx;
            rows[1].slope[W] += 2.0 * w * ry;
        }
        rows
    }

    /// The same for the state and the accelerations of the center of mass.
    fn accelerations_of_mass(&self, x: &[f64], u: &[f64], slopes: bool) -> [Row; 3] {
        let (h, g) = (self.height, GRAVITY);
        let (y, phi, vx, vy, w) = (x[1], x[2], x[3], x[4], x[5]);
        let (tilt, rate, turning) = (x[8], x[9], u[1]);
        let (st, ct) = tilt.sin_cos();
        let (s, c) = phi.sin_cos();
        let (sa, sb) = self.moments;
        let inertia = sa + sb;
        let (ps, pc) = if self.principal == 0.0 { (s, c) } else { (phi + self.principal).sin_cos() };
        let (sxy, slope_sxy) = (pc * ps * (sa - sb), (pc * pc - ps * ps) * (sa - sb));
        let mut rows = [Row::ZERO; 3];
        rows[0].value = -u[0];
        rows[1].value = -g * st + y * rate * rate + h * turning;
        rows[2].value = sxy * rate * rate / inertia;
        if slopes {
            rows[0].slope[10] = -1.0;
            rows[1].slope[TILT] = -g * ct;
            rows[1].slope[Y] = rate * rate;
            rows[1].slope[TILT_RATE] = 2.0 * y * rate;
            rows[1].slope[TILT_ACCELERATION] = h;
            rows[2].slope[PHI] = slope_sxy * rate * rate / inertia;
            rows[2].slope[TILT_RATE] = 2.0 * sxy * rate / inertia;
        }
        let uniform = g * ct - h * rate * rate + 2.0 * rate * vy + y * turning;
        let square = self.width * self.width;
        for &ModelPoint { at: [a, b], share, level, slope: [ba, bb] } in &self.points {
            let (px, py) = (c * a - s * b, s * a + c * b);
            let (bx, by) = (c * ba - s * bb, s * ba + c * bb);
            let (ux, uy) = (vx - w * py, vy + w * px);
            let pressure = level * uniform + by * turning + 2.0 * rate * w * bx;
            let inverse = 1.0 / (ux * ux + uy * uy + square).sqrt();
            let (ex, ey) = (ux * inverse, uy * inverse);
            let scale = -self.mu * share;
            let (fx, fy) = (scale * pressure * ex, scale * pressure * ey);
            rows[0].value += fx;
            rows[1].value += fy;
            rows[2].value += (px * fy - py * fx) / inertia;
            if !slopes {
                continue;
            }
            // f = scale · p · e, de = (1 − e eᵀ) du · inverse.
            let mut add = |column: usize, dp: f64, dux: f64, duy: f64| {
                let along = (ex * dux + ey * duy) * inverse;
                let dfx = scale * (dp * ex + pressure * (dux * inverse - ex * along));
                let dfy = scale * (dp * ey + pressure * (duy * inverse - ey * along));
                rows[0].slope[column] += dfx;
                rows[1].slope[column] += dfy;
                rows[2].slope[column] += (px * dfy - py * dfx) / inertia;
            };
            add(Y, level * turning, 0.0, 0.0);
            add(PHI, bx * turning - 2.0 * rate * w * by, -w * px, -w * py);
            add(VX, 0.0, 1.0, 0.0);
            add(VY, level * 2.0 * rate, 0.0, 1.0);
            add(W, 2.0 * rate * bx, -py, px);
            add(TILT, -level * g * st, 0.0, 0.0);
            add(TILT_RATE, 2.0 * (level * vy + w * bx) - 2.0 * level * h * rate, 0.0, 0.0);
            add(TILT_ACCELERATION, level * y + by, 0.0, 0.0);
            // The lever arm turns with the object: d(x̃ fy − ỹ fx)/dφ has −ỹ fy − x̃ fx.
            rows[2].slope[PHI] += (-py * fy - px * fx) / inertia;
        }
        rows
    }
}

impl Dynamics for RoundedContact {
    fn states(&self) -> usize {
        CONTROL_STATES
    }

    fn inputs(&self) -> usize {
        CONTROL_INPUTS
    }

    fn field(&mut self, _t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
        let rows = self.accelerations(x, u, false);
        dx.copy_from_slice(&[x[3], x[4], x[5], rows[0].value, rows[1].value, rows[2].value, x[7], u[0], x[9], u[1]]);
    }

    fn jacobian_pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }

    fn field_and_jacobian(&mut self, _t: f64, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut [f64]) {
        let rows = self.accelerations(x, u, true);
        dx.copy_from_slice(&[x[3], x[4], x[5], rows[0].value, rows[1].value, rows[2].value, x[7], u[0], x[9], u[1]]);
        for (entry, &(i, j)) in jacobian.iter_mut().zip(&self.pattern) {
            *entry = if (VX..=W).contains(&i) { rows[i - VX].slope[j] } else { 1.0 };
        }
    }

    fn is_smoothed(&self) -> bool {
        true
    }

    fn set_smoothing(&mut self, width: f64) {
        self.width = width;
    }

    fn relaxation_rate(&mut self, _t: f64, x: &[f64], u: &[f64]) -> f64 {
        self.mu * (GRAVITY + (x[1] * u[1]).abs()) / self.width
    }
}
