//! The estimation problem as data.

use crate::error::{MpcError, check_length, check_value};
use crate::integrator::Integrator;
use crate::ocp::Substeps;
use bracketry_system::System;

/// A measured output.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredOutput {
    /// An expression of states, parameters, named outputs of the model and the time `t`; often the name of a state.
    pub expression: String,
    /// Standard deviation of the noise of a sample, positive. What is known exactly gets a tiny one.
    pub std: f64,
    /// Period of an angle that is measured within one turn: residuals are taken to the nearest turn.
    pub period: Option<f64>,
}

impl MeasuredOutput {
    /// An output that is no angle.
    pub fn new(expression: impl Into<String>, std: f64) -> Self {
        Self { expression: expression.into(), std, period: None }
    }
}

/// A parameter of the model that is estimated: a random walk p' = w.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimatedParameter {
    /// Its name; the model's value is where the estimate starts.
    pub name: String,
    /// Standard deviation of the model's value.
    pub std: f64,
    /// Standard deviation of its change over one second, in unit/√s; 0 for a constant.
    pub walk: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl EstimatedParameter {
    /// A constant parameter without bounds.
    pub fn new(name: impl Into<String>, std: f64) -> Self {
        Self { name: name.into(), std, walk: 0.0, min: f64::NEG_INFINITY, max: f64::INFINITY }
    }
}

/// Where a disturbance is added.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DisturbanceChannel {
    /// To the input of this name.
    Input(String),
    /// To the derivative of the state of this name.
    State(String),
    /// To the measured output with this index.
    Output(usize),
}

/// An additive disturbance: a random walk d' = w that starts at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Disturbance {
    /// Where it is added.
    pub channel: DisturbanceChannel,
    /// Standard deviation at the start.
    pub std: f64,
    /// Standard deviation of its change over one second, in unit/√s.
    pub walk: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Disturbance {
    /// A disturbance without bounds.
    pub fn new(channel: DisturbanceChannel, std: f64, walk: f64) -> Self {
        Self { channel, std, walk, min: f64::NEG_INFINITY, max: f64::INFINITY }
    }
}

/// What is done about measurements that lie far off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outliers {
    /// They count like all others.
    Trust,
    /// Huber's function: beyond this many standard deviations a residual counts linearly, not squared.
    Huber(f64),
}

/// Model, sensors and what is known beforehand.
///
/// The estimator's model is x' = f(t, x, u; p) + d + w with white noise w of the given intensities, held constant over a
/// sampling period, and y = h(t, x; p) + d + v with white noise v.
#[derive(Clone)]
pub struct EstimationProblem {
    /// The model, free of input derivatives.
    pub system: System,
    /// Sampling period, s.
    pub dt: f64,
    /// The method of integration.
    pub integrator: Integrator,
    /// Integration steps per sampling period.
    pub substeps: Substeps,
    /// Width that replaces `sign` and unit vectors in the estimator's model; the controller's may be another.
    pub smoothing: f64,
    /// The measured outputs.
    pub outputs: Vec<MeasuredOutput>,
    /// State at the start.
    pub initial: Vec<f64>,
    /// Its standard deviations; 0 for what is known exactly.
    pub initial_std: Vec<f64>,
    /// Intensity of the noise on every state's derivative: standard deviation of its integral over one second, in unit/√s.
    pub process_noise: Vec<f64>,
    /// Smallest and largest value of every state.
    pub bounds: Vec<(f64, f64)>,
    /// Parameters to be estimated.
    pub parameters: Vec<EstimatedParameter>,
    /// Disturbances to be estimated.
    pub disturbances: Vec<Disturbance>,
    /// What is done about outliers.
    pub outliers: Outliers,
}

impl EstimationProblem {
    /// A problem without sensors: the state starts at `initial`, known exactly, without process noise and bounds.
    pub fn new(system: &System, dt: f64, initial: &[f64]) -> Self {
        let n = system.states.len();
        Self {
            system: system.clone(),
            dt,
            integrator: Integrator::default(),
            substeps: Substeps::AtLeast(1),
            smoothing: 0.005,
            outputs: Vec::new(),
            initial: initial.to_vec(),
            initial_std: vec![0.0; n],
            process_noise: vec![0.0; n],
            bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); n],
            parameters: Vec::new(),
            disturbances: Vec::new(),
            outliers: Outliers::Trust,
        }
    }

    /// Whether an estimator can be made of it.
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn check(&self) -> Result<(), MpcError> {
        let n = self.system.states.len();
        check_length("the estimator's initial state", self.initial.len(), n)?;
        check_length("the initial standard deviations", self.initial_std.len(), n)?;
        check_length("the process noise", self.process_noise.len(), n)?;
        check_length("the estimator's bounds", self.bounds.len(), n)?;
        number("the sampling period", self.dt, self.dt > 0.0, "give a positive number")?;
        self.integrator.check()?;
        number("the smoothing width", self.smoothing, self.smoothing > 0.0, "give a positive number")?;
        for &v in &self.initial {
            number("an initial state", v, true, "give a finite number")?;
        }
        for &v in self.initial_std.iter().chain(&self.process_noise) {
            number("a standard deviation", v, v >= 0.0, "give a number that is not negative")?;
        }
        for o in &self.outputs {
            let remedy = "give a positive number; for an exact output, use a tiny one, 1e-6 of its range";
            number(&format!("the standard deviation of `{}`", o.expression), o.std, o.std > 0.0, remedy)?;
            if let Some(p) = o.period {
                number(&format!("the period of `{}`", o.expression), p, p > 0.0, "give a positive number")?;
            }
        }
        let walks = self.parameters.iter().map(|p| (p.std, p.walk));
        for (std, walk) in walks.chain(self.disturbances.iter().map(|d| (d.std, d.walk))) {
            number("the standard deviation of a parameter or disturbance", std, std >= 0.0, "give 0 or more")?;
            number("the random walk of a parameter or disturbance", walk, walk >= 0.0, "give 0 or more")?;
        }
        for (index, b) in self.all_bounds().into_iter().enumerate() {
            if b.0.is_nan() || b.1.is_nan() || b.0 > b.1 {
                return Err(MpcError::EmptyBounds { what: "estimated state", index, name: None, min: b.0, max: b.1 });
            }
        }
        if let Outliers::Huber(threshold) = self.outliers {
            number("Huber's threshold", threshold, threshold > 0.0, "give a number of standard deviations")?;
        }
        Ok(())
    }

    /// Names of the estimated parameters, then of the disturbances.
    pub(crate) fn live_parameters(&self) -> Vec<String> {
        let disturbances = (0..self.disturbances.len()).map(|j| format!("disturbance#{j}"));
        self.parameters.iter().map(|p| p.name.clone()).chain(disturbances).collect()
    }

    /// Bounds of states, parameters and disturbances.
    pub(crate) fn all_bounds(&self) -> Vec<(f64, f64)> {
        let parameters = self.parameters.iter().map(|p| (p.min, p.max));
        self.bounds.iter().copied().chain(parameters).chain(self.disturbances.iter().map(|d| (d.min, d.max))).collect()
    }
}

fn number(what: &str, value: f64, good: bool, remedy: &'static str) -> Result<(), MpcError> {
    check_value(good && value.is_finite(), what, value, remedy)
}
