//! What is asked for.

use std::time::Duration;

use bracketry_symbolic::{Expr, StopFlag};
use bracketry_system::{PointError, System, point};
use serde::Serialize;

use crate::from_rest::Bound;

/// A way of finding inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SteerMethod {
    /// Sinusoids in the chained form (Murray and Sastry 1993; Tilbury, Murray, and Sastry 1995).
    Chained,
    /// Piecewise constant inputs by Philip Hall coordinates (Lafferriere and Sussmann 1991).
    Nilpotent,
    /// Polynomials in flat outputs (Fliess, Lévine, Martin, and Rouchon 1995).
    Flat,
    /// Loops of the inputs from rest to rest, under dry friction ([`crate::from_rest`]); they need
    /// [bounds](SteerOptions::bounds).
    Loops,
    /// Sinusoids whose amplitudes are found by Levenberg–Marquardt iterations on the end error.
    Shooting,
}

/// From where to where, and how.
#[derive(Clone, Debug)]
pub struct SteerOptions {
    /// Initial state, in the order of the model.
    pub from: Vec<f64>,
    /// State at the end.
    pub to: Vec<f64>,
    /// Inputs at the start; `None` for those at which the state rests, or moves least.
    pub from_inputs: Option<Vec<f64>>,
    /// Inputs at the end.
    pub to_inputs: Option<Vec<f64>>,
    /// Length of the motion in seconds. A model without drift takes longer where the ranges of its inputs ask for it.
    pub duration: Option<f64>,
    /// Bounds of inputs and of their derivatives for [`SteerMethod::Loops`], beside the ranges of the model.
    pub bounds: Vec<Bound>,
    /// The method; `None` for the first that reaches the end.
    pub method: Option<SteerMethod>,
    /// Largest difference of a state from its value at the end, for which it is reached.
    pub tolerance: f64,
    /// Wall-clock time after which no further plan is tried.
    pub time_limit: Option<Duration>,
    /// Seed of random waypoints and initial guesses.
    pub seed: u64,
    /// Once it is raised, the search ends.
    pub stop: StopFlag,
}

impl SteerOptions {
    /// From one state to another, everything else left open.
    pub fn between(from: &[f64], to: &[f64]) -> Self {
        SteerOptions {
            from: from.to_vec(),
            to: to.to_vec(),
            from_inputs: None,
            to_inputs: None,
            duration: None,
            bounds: Vec::new(),
            method: None,
            tolerance: 1e-6,
            time_limit: Some(Duration::from_mins(2)),
            seed: 1,
            stop: StopFlag::default(),
        }
    }
}

impl SteerOptions {
    /// From a point to another, given by name as in `x=0.1, th=pi/2`: states that are not named are 0, and inputs count where any
    /// is named. Without the first, from the model's point, or 0.
    ///
    /// # Errors
    /// [`SteerError::Point`] for a text that does not give a point.
    pub fn named(system: &mut System, from: Option<&str>, to: &str) -> Result<Self, SteerError> {
        let (start, from_inputs) = match from {
            Some(text) => by_name(system, text, "the initial state")?,
            None => (system.point_values().map_or_else(|| vec![0.0; system.states.len()], |(x, _)| x), None),
        };
        let (end, to_inputs) = by_name(system, to, "the final state")?;
        Ok(SteerOptions { from_inputs, to_inputs, ..SteerOptions::between(&start, &end) })
    }
}

/// States, and the inputs if any is named.
fn by_name(system: &mut System, text: &str, what: &'static str) -> Result<(Vec<f64>, Option<Vec<f64>>), SteerError> {
    let at = point(system, text).map_err(|source| SteerError::Point { what, text: text.to_owned(), source })?;
    let values = |list: &[Expr]| list.iter().map(|&e| system.value(e).unwrap_or(f64::NAN)).collect();
    let names = system.input_names();
    let inputs = text.split(',').any(|e| e.split_once('=').is_some_and(|(n, _)| names.iter().any(|u| u == n.trim())));
    Ok((values(&at.states), inputs.then(|| values(&at.inputs))))
}

/// Misuse.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SteerError {
    /// A list of the wrong length.
    #[error("{what}: {found} values are given, but {expected} are needed")]
    Length {
        /// What is given.
        what: &'static str,
        /// Number needed.
        expected: usize,
        /// Number given.
        found: usize,
    },
    /// A number that is not finite.
    #[error("{what}: give finite numbers")]
    NotFinite {
        /// What is given.
        what: &'static str,
    },
    /// A number that is not positive.
    #[error("{what} = {value}: give a positive number")]
    NotPositive {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The model has no states, or no inputs.
    #[error("the model has no {what}: there is nothing to steer")]
    Nothing {
        /// What is missing.
        what: &'static str,
    },
    /// A text that does not give a point.
    #[error("{what} {text}")]
    Point {
        /// Which end.
        what: &'static str,
        /// The text.
        text: String,
        /// What is wrong with it.
        source: PointError,
    },
    /// The model cannot be simulated.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// Derivatives of inputs that cannot be replaced by integrators.
    #[error(transparent)]
    Affine(#[from] bracketry_system::AffineError),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] bracketry_system::ZeroDenominator),
}
