//! One step from the present point: its stages, its end, its continuous extension.

use super::dense::{interpolate, node_weights};
use super::newton::Newton;
use crate::friction::{Field, FrictionMode};
use crate::settings::SimulationSettings;

/// Error allowed in the sticking signs from one order to the other: enough to see every excursion toward ±1.
const SIGN_TOLERANCE: f64 = 1e-4;

/// Where the start and the stages of an implicit step are kept among the stages.
pub(crate) const RADAU_STAGES: [usize; 4] = [0, 1, 2, 6];

/// What the error of a step is judged by.
#[derive(Clone, Copy)]
pub(crate) struct Control<'a> {
    pub(crate) settings: &'a SimulationSettings,
    /// Whether the errors of the sticking signs count.
    pub(crate) signs: bool,
}

/// How a step is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// The explicit pair of Dormand and Prince (1980).
    Explicit,
    /// Radau IIA with the directions of unit vectors near zero as unknowns.
    Directions,
    /// Radau IIA with the states as unknowns.
    Stiff,
}

/// What became of an attempted step.
pub(crate) enum Attempt {
    /// The scaled error of the step.
    Error(f64),
    /// No sticking signs at a stage.
    Unsolvable,
    /// Something is not finite.
    NonFinite,
}

/// The present point, and the step attempted from it.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// Time in seconds and state at the start, which is the present point.
    pub(crate) t: f64,
    pub(crate) x: Vec<f64>,
    /// Field and signs at the stages: the first are those of the start, the last those of the end.
    pub(crate) k: [Vec<f64>; 7],
    pub(crate) signs: [Vec<f64>; 7],
    /// Whether the first stage is that of the present point and modes.
    pub(crate) started: bool,
    pub(crate) method: Method,
    pub(crate) newton: Newton,
    pub(crate) end: Vec<f64>,
    /// Five vectors of the continuous extension.
    pub(crate) coefficients: Vec<f64>,
}

impl Step {
    /// At `(t, x)`, for `k` components of switches.
    pub(crate) fn new(t: f64, x: &[f64], k: usize) -> Self {
        let n = x.len();
        Self {
            t,
            x: x.to_vec(),
            k: std::array::from_fn(|_| vec![0.0; n]),
            signs: std::array::from_fn(|_| vec![0.0; k]),
            started: false,
            method: Method::Explicit,
            newton: Newton::default(),
            end: vec![0.0; n],
            coefficients: vec![0.0; 5 * n],
        }
    }

    /// The shortest step that the resolution of time allows.
    pub(crate) fn shortest(&self) -> f64 {
        4.0 * f64::EPSILON * self.t.abs().max(1e-3)
    }

    /// The first stage at the present point in the present modes; false if nothing holds what should stick.
    pub(crate) fn start(&mut self, field: &mut Field<'_>) -> bool {
        field.apply_modes();
        field.hold_departing();
        self.newton.break_off();
        self.started = field.evaluate((self.t, &self.x), &mut self.k[0]);
        self.signs[0].copy_from_slice(&field.s);
        self.started
    }

    /// The length of the first step, the first guess of Hairer, Nørsett, and Wanner (1993, section II.4): one per cent of the time in
    /// which the state changes by itself.
    pub(crate) fn first_length(&self, settings: &SimulationSettings, remaining: f64) -> f64 {
        let (mut d0, mut d1) = (0.0f64, 0.0f64);
        for (x, v) in self.x.iter().zip(&self.k[0]) {
            d0 = d0.max(x.abs() / settings.scale(x.abs()));
            d1 = d1.max(v.abs() / settings.scale(x.abs()));
        }
        let h = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        // Far from t = 0 even the shortest step is long.
        h.min(1e-2).max(10.0 * self.shortest()).min(remaining)
    }

    /// The continuous extension through both ends with their fields, of which `fifth` gives the last coefficient by state: from
    /// the state and its first three.
    pub(crate) fn extend(&mut self, h: f64, fifth: impl Fn(&[Vec<f64>; 7], usize, [f64; 3]) -> f64) {
        let n = self.x.len();
        for j in 0..n {
            let difference = self.end[j] - self.x[j];
            let bend = h * self.k[0][j] - difference;
            let third = difference - h * self.k[6][j] - bend;
            self.coefficients[j] = self.x[j];
            self.coefficients[n + j] = difference;
            self.coefficients[2 * n + j] = bend;
            self.coefficients[3 * n + j] = third;
            self.coefficients[4 * n + j] = fifth(&self.k, j, [difference, bend, third]);
        }
    }

    /// The error of the step, scaled by the tolerances: root mean square of those of the states and, if they count, largest of
    /// those of the sticking signs.
    pub(crate) fn judge(
        &self,
        field: &Field<'_>,
        control: Control<'_>,
        of_state: impl Fn(usize) -> f64,
        of_sign: impl Fn(usize) -> f64,
    ) -> Attempt {
        let mut sum = 0.0;
        for j in 0..self.x.len() {
            let e = of_state(j) / control.settings.scale(self.x[j].abs().max(self.end[j].abs()));
            sum += e * e;
        }
        let mut error = (sum / self.x.len().max(1) as f64).sqrt();
        let controlled = field.in_mode(FrictionMode::Sticking).filter(|_| control.signs);
        for c in controlled.flat_map(|i| field.surfaces.parts[i].clone()) {
            error = error.max(of_sign(c).abs() / SIGN_TOLERANCE);
        }
        if error.is_nan() { Attempt::NonFinite } else { Attempt::Error(error) }
    }

    /// The state at fraction `theta` of the step.
    pub(crate) fn interpolate(&self, theta: f64, x: &mut [f64]) {
        interpolate(&self.coefficients, self.x.len(), theta, x);
    }

    /// Signs and directions at the start and the nodes of a step that solves for directions; none of others, where the states tell
    /// them.
    pub(crate) fn implicit_signs(&self) -> Option<[&[f64]; 4]> {
        (self.method == Method::Directions).then(|| RADAU_STAGES.map(|stage| &self.signs[stage][..]))
    }

    /// Signs and directions at fraction `theta` of a step that solves for directions, not of unit length.
    pub(crate) fn interpolate_directions(&self, theta: f64) -> Vec<f64> {
        let weights = node_weights(theta);
        let of = |c: usize| (0..4).map(|l| weights[l] * self.signs[RADAU_STAGES[l]][c]).sum();
        (0..self.signs[0].len()).map(of).collect()
    }

    /// Goes to the end of the attempted step of length `h`, where what sticks is projected.
    pub(crate) fn accept(&mut self, field: &mut Field<'_>, h: f64) {
        if self.method == Method::Stiff {
            self.newton.accept(h, &self.coefficients);
        } else {
            self.newton.break_off();
        }
        std::mem::swap(&mut self.x, &mut self.end);
        self.t += h;
        field.project(self.t, &mut self.x);
        self.k.swap(0, 6);
        self.signs.swap(0, 6);
        field.s.copy_from_slice(&self.signs[0]);
        field.departing.fill(false);
        field.release_directions();
    }
}
