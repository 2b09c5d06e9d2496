//! Normal equations of a fit with candidates, so that screening is linear algebra.

use nalgebra::{DMatrix, DVector};

/// What a column of a linearization belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Column {
    /// A refitted parameter: place in [`super::Study::parameters`].
    Parameter(usize),
    /// A coefficient of an effect in the fit.
    Coefficient {
        /// Place of the effect in the fit.
        effect: usize,
        /// Place of the coefficient in the effect.
        coefficient: usize,
    },
    /// An amplitude of a candidate.
    Candidate {
        /// Place in the list of candidates.
        candidate: usize,
        /// Place of the amplitude among the candidate's coefficients.
        coefficient: usize,
        /// Place in [`Linearization::trials`] of the candidate.
        trial: usize,
    },
}

/// Normal equations of a fit with candidates, one set per window, with the initial state of the window eliminated.
///
/// With `J` the sensitivity of the simulated columns over their noise, in scaled units, `r` measured − simulated over noise and
/// `P` the projection off the sensitivities by the initial state, the step of all columns that explains the residuals best is
/// `(Σ gram + prior)⁻¹ (Σ gradient + prior·pull)`: a step `δ` changes the sum of squares by `−2 gᵀδ + δᵀGδ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    /// What the columns belong to.
    pub columns: Vec<Column>,
    /// A step in the natural unit is its scale times the step in the unit of the normal equations.
    pub scales: Vec<f64>,
    /// Weight of the prior, in scaled units: `1/std²`; 0 for candidates.
    pub prior: Vec<f64>,
    /// Distance to the mean of the prior, in scaled units: the prior's part of the cost is `prior·(step − pull)²`.
    pub pull: Vec<f64>,
    /// For each candidate and each of its trials the values of all its coefficients between which and the nominal amplitudes the
    /// column was taken.
    pub trials: Vec<Vec<Vec<f64>>>,
    /// The windows that could be simulated.
    pub windows: Vec<Normal>,
    /// Columns that could not be simulated in a window, with the reason; they are zero there.
    pub failures: Vec<(Column, usize, String)>,
}

/// Normal equations of one window after elimination of its initial state.
#[derive(Clone, Debug, PartialEq)]
pub struct Normal {
    /// Index of the window.
    pub window: usize,
    /// `JᵀPJ`.
    pub gram: DMatrix<f64>,
    /// `JᵀPr`.
    pub gradient: DVector<f64>,
    /// `rᵀPr`.
    pub square: f64,
    /// Number of residuals.
    pub count: usize,
}
