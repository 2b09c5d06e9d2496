//! The least-squares problem around a fit, window by window.

use nalgebra::{DMatrix, DVector};

/// What a column of a [`Linearization`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Column {
    /// A refitted parameter of the model: its place in `Study::parameters`.
    Parameter(usize),
    /// A coefficient of an effect that is in the fit.
    Coefficient {
        /// Place of the effect in the fit.
        effect: usize,
        /// Place of the coefficient in the effect.
        coefficient: usize,
    },
    /// An amplitude of an effect that is not in the fit.
    Candidate {
        /// Place of the effect among the candidates.
        candidate: usize,
        /// Place of the coefficient in the effect.
        coefficient: usize,
        /// Which of the trial values of [`Linearization::trials`].
        trial: usize,
    },
}

/// Normal equations of one window, its initial state eliminated.
///
/// With `r` the residual (measured − simulated)/σ, `J` the derivative of simulated/σ by the columns and `P` the projection
/// onto what the initial state cannot explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Normal {
    /// The window.
    pub window: usize,
    /// `JᵀPJ`.
    pub gram: DMatrix<f64>,
    /// `JᵀPr`.
    pub gradient: DVector<f64>,
    /// `rᵀPr`.
    pub square: f64,
    /// Samples in `r`.
    pub count: usize,
}

/// The least-squares problem around a fit.
///
/// A step `δ` of the columns, in units of `scales`, changes the sum of squares by `−2 gᵀδ + δᵀGδ`, summed over windows, plus
/// `Σ prior (δ − pull)²`.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// What the columns stand for: parameters, coefficients, candidates.
    pub columns: Vec<Column>,
    /// Size of a unit step of each column in its natural unit.
    pub scales: Vec<f64>,
    /// Weight of the prior of each column, 1/std² with std in units of `scales`; 0 without a prior.
    pub prior: Vec<f64>,
    /// Where the prior wants each column, (nominal − current)/scale.
    pub pull: Vec<f64>,
    /// By candidate and trial: values of all its coefficients at which the amplitudes' columns were taken.
    pub trials: Vec<Vec<Vec<f64>>>,
    /// One per window.
    pub windows: Vec<Normal>,
}
