//! The area contact with rounded friction, as differential equations for an optimizer.

use crate::{GRAVITY, Object, PlateError};
use bracketry_mpc::{Dynamics, MpcError, Trajectory};

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

/// A flat object under dry friction over its footprint ([`crate::AreaContact`]) with `v/|v|` at each point rounded to
/// `v/√(v² + ε²)`, and the accelerations of the plate as inputs. The derivatives are exact.
///
/// ```text
/// x'' = −X'' + Σ w_i fx_i
/// y'' = −g sin θ + y θ'² + h θ'' + Σ w_i fy_i
/// I φ'' = Sxy θ'² + Σ w_i (x̃_i fy_i − ỹ_i fx_i)
/// f_i = −μ p_i v_i/√(v_i² + ε²),   p_i = g cos θ + (y + ỹ_i) θ'' + 2 θ'(y' + φ' x̃_i) − h θ'²
/// ```
///
/// The whole footprint is taken to carry; the moment of friction about the center of mass (of the order `μ h/R`) is left out.
#[derive(Debug, Clone)]
pub struct RoundedContact {
    points: Vec<[f64; 3]>,
    moments: (f64, f64),
    height: f64,
    mu: f64,
    width: f64,
    pattern: Vec<(usize, usize)>,
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
        object.validate()?;
        if !(mu.is_finite() && mu >= 0.0) {
            return Err(PlateError::NegativeNumber { name: "mu", value: mu });
        }
        let rule = object.shape.quadrature(points)?;
        let points = rule.points.iter().zip(&rule.weights).map(|(p, w)| [p[0], p[1], *w]).collect();
        let mut pattern: Vec<(usize, usize)> = [(0, VX), (1, VY), (2, W), (6, 7), (7, 10), (8, 9), (9, 11)].into();
        pattern.push((VX, 10));
        for row in [VX, VY, W] {
            pattern.extend(FRICTION_VARIABLES.map(|column| (row, column)));
        }
        pattern.sort_unstable();
        Ok(Self { points, moments: object.shape.second_moments(), height: object.height, mu, width: 0.01, pattern })
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
        trajectory: &Trajectory,
        interval: f64,
    ) -> Result<Trajectory, MpcError> {
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
        Trajectory::from_rows(&states, &inputs)
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

    /// The three accelerations; with slopes if `slopes`.
    fn accelerations(&self, x: &[f64], u: &[f64], slopes: bool) -> [Row; 3] {
        let (h, g) = (self.height, GRAVITY);
        let (y, phi, vx, vy, w) = (x[1], x[2], x[3], x[4], x[5]);
        let (tilt, rate, turning) = (x[8], x[9], u[1]);
        let (st, ct) = tilt.sin_cos();
        let (s, c) = phi.sin_cos();
        let (sa, sb) = self.moments;
        let inertia = sa + sb;
        let (sxy, slope_sxy) = (c * s * (sa - sb), (c * c - s * s) * (sa - sb));
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
        for &[a, b, weight] in &self.points {
            let (px, py) = (c * a - s * b, s * a + c * b);
            let (ux, uy) = (vx - w * py, vy + w * px);
            let pressure = uniform + py * turning + 2.0 * rate * w * px;
            let inverse = 1.0 / (ux * ux + uy * uy + square).sqrt();
            let (ex, ey) = (ux * inverse, uy * inverse);
            let scale = -self.mu * weight;
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
            add(Y, turning, 0.0, 0.0);
            add(PHI, px * turning - 2.0 * rate * w * py, -w * px, -w * py);
            add(VX, 0.0, 1.0, 0.0);
            add(VY, 2.0 * rate, 0.0, 1.0);
            add(W, 2.0 * rate * px, -py, px);
            add(TILT, -g * st, 0.0, 0.0);
            add(TILT_RATE, 2.0 * (vy + w * px) - 2.0 * h * rate, 0.0, 0.0);
            add(TILT_ACCELERATION, y + py, 0.0, 0.0);
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
