//! What a linear system tells: poles, zeros, ranks, Gramians, distances, and gains.

use bracketry_symbolic::Echelon;
use bracketry_system::System;
use nalgebra::DMatrix;
use serde::Serialize;

use crate::linear::distance::{Distance, distance};
use crate::linear::matrix::RationalMatrix;
use crate::linear::spectrum::Spectrum;
use crate::operating::gains::{Gain, Gramians, NoGain, estimator, gramians, regulator};
use crate::operating::linear_model::{LinearModel, NotLinearizable};
use crate::residues::{Fp, times};
use bracketry_numerics::eigen::eigenvalues;

/// Weights of the gains, each one number for all or one for each; 1 where there is none.
#[derive(Clone, Debug, Default)]
pub struct LinearizeOptions {
    /// Diagonal of Q: states.
    pub state_weights: Vec<f64>,
    /// Diagonal of R: inputs.
    pub input_weights: Vec<f64>,
    /// Process noise of each state.
    pub process_noise: Vec<f64>,
    /// Noise of each output.
    pub measurement_noise: Vec<f64>,
    /// Upper end of the Gramians' integrals.
    pub horizon: Option<f64>,
}

/// A pole.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pole {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// How often it occurs; 1 each where the matrices are not rational.
    pub multiplicity: usize,
    /// The pole itself, where it is rational.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<String>,
}

/// A rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Rank {
    /// Its value.
    pub rank: usize,
    /// The rank that it can have at most.
    pub of: usize,
    /// Whether it was computed in exact arithmetic (for irrational entries modulo a prime); else up to rounding.
    pub exact: bool,
}

/// The linear system around a point, and what it tells.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinearAnalysis {
    /// A, B, C, D.
    #[serde(flatten)]
    pub system: LinearModel,
    /// Whether A, B, C, D are rational, so that ranks and multiplicities are exact.
    pub exact: bool,
    /// Eigenvalues of A, by falling real part; none where the QR algorithm did not converge.
    pub poles: Option<Vec<Pole>>,
    /// Poles with negative, zero, and positive real part, where they are counted exactly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_planes: Option<[usize; 3]>,
    /// Finite invariant zeros: λ at which [A − λ, B; C, D] loses rank; none where a decomposition did not converge.
    pub zeros: Option<Vec<(f64, f64)>>,
    /// Of [B, A B, A² B, …].
    pub controllability: Rank,
    /// Of [C; C A; C A²; …].
    pub observability: Rank,
    /// Gramians, where they were found.
    pub gramians: Option<Gramians>,
    /// How far (A, B) is from an uncontrollable pair, in the spectral norm.
    pub distance_to_uncontrollable: Option<Distance>,
    /// How far (A, C) is from an unobservable pair.
    pub distance_to_unobservable: Option<Distance>,
    /// The linear-quadratic regulator.
    #[serde(skip)]
    pub regulator: Result<Gain, NoGain>,
    /// The steady-state Kalman filter.
    #[serde(skip)]
    pub estimator: Result<Gain, NoGain>,
}

/// Why there is no linearization.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearizeError {
    /// The equations are not smooth at the point.
    #[error(transparent)]
    NotLinearizable(#[from] NotLinearizable),
    /// A list of weights of the wrong length.
    #[error("{found} {what} are given, but {expected} are needed: give one for all, or one for each")]
    Weights {
        /// What is given.
        what: &'static str,
        /// Their number.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A weight that does not give a cost or a covariance.
    #[error("the {what} contain {value}: give {} numbers", if *.positive { "positive" } else { "nonnegative" })]
    Weight {
        /// What is given.
        what: &'static str,
        /// The value.
        value: f64,
        /// Whether zero is refused too.
        positive: bool,
    },
}

fn diagonal(list: &[f64], n: usize, what: &'static str, positive: bool) -> Result<Vec<f64>, LinearizeError> {
    let bad = |v: &&f64| !v.is_finite() || **v < 0.0 || positive && **v == 0.0;
    if let Some(&value) = list.iter().find(bad) {
        return Err(LinearizeError::Weight { what, value, positive });
    }
    match list {
        [] => Ok(vec![1.0; n]),
        [all] => Ok(vec![*all; n]),
        list if list.len() == n => Ok(list.to_vec()),
        list => Err(LinearizeError::Weights { what, found: list.len(), expected: n }),
    }
}

/// The linear system at the model's point, with poles, zeros, ranks, Gramians, margins, and gains.
///
/// ```
/// use bracketry_lie::linearize;
/// use bracketry_lie::operating::LinearizeOptions;
/// use bracketry_system::System;
/// let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - sin(x)' }\noutputs = { y = 'x' }";
/// let result = linearize(&System::parse("pendulum", text).unwrap(), &LinearizeOptions::default()).unwrap();
/// assert_eq!(result.system.a.formulas[1][0].text(), "-1");
/// assert_eq!((result.controllability.rank, result.observability.rank), (2, 2));
/// ```
///
/// # Errors
/// [`LinearizeError`] where the equations are not smooth at the point, or weights do not fit.
pub fn linearize(system: &System, options: &LinearizeOptions) -> Result<LinearAnalysis, LinearizeError> {
    let model = LinearModel::new(system)?;
    let (n, m, p) = (model.states.len(), model.inputs.len(), model.outputs.len());
    let q = diagonal(&options.state_weights, n, "weights of states", false)?;
    let r = diagonal(&options.input_weights, m, "weights of inputs", true)?;
    let v = diagonal(&options.process_noise, n, "process noises", false)?;
    let w = diagonal(&options.measurement_noise, p, "measurement noises", true)?;
    let [a, b, c] = [&model.a.values, &model.b.values, &model.c.values];
    let spectrum = model.rational.as_ref().map(|[a, ..]| Spectrum::of(a));
    let numbers = eigenvalues(a);
    let poles = poles(spectrum.as_ref(), numbers.as_deref());
    let values: Option<Vec<(f64, f64)>> = poles.as_ref().map(|list| list.iter().map(|p| (p.re, p.im)).collect());
    let (controllability, observability) = match (&model.rational, &model.residues) {
        (Some([a, b, c, _]), _) => (rank_exactly(a, &b.transposed()), rank_exactly(&a.transposed(), c)),
        (None, Some([a, b, c])) => (rank_of_residues(a, &transposed(b, m)), rank_of_residues(&transposed(a, n), c)),
        (None, None) => (rank(a, b), rank(&a.transpose(), &c.transpose())),
    };
    let gramians = values.and_then(|poles| gramians(a, b, c, &poles, options.horizon));
    let (regulator, estimator) = (regulator(a, b, &q, &r), estimator(a, c, &v, &w));
    // These take the longest, and are bounds whenever they end.
    let stopped = || system.pool.reached_limit().is_some();
    // Where the rank is known to be deficient, nothing is left of the distance but rounding.
    let exactly = |d: Distance, r: Rank| {
        if r.exact && r.rank < r.of { Distance { lower: 0.0, upper: 0.0, ..d } } else { d }
    };
    let to_uncontrollable = distance(a, b, &stopped).map(|d| exactly(d, controllability));
    let to_unobservable = distance(&a.transpose(), &c.transpose(), &stopped).map(|d| exactly(d, observability));
    Ok(LinearAnalysis {
        exact: model.rational.is_some(),
        half_planes: spectrum.map(|s| [s.left, s.on_axis, s.right]),
        zeros: sorted(model.quadruple().zeros()),
        controllability,
        observability,
        gramians,
        distance_to_uncontrollable: to_uncontrollable,
        distance_to_unobservable: to_unobservable,
        regulator,
        estimator,
        poles,
        system: model,
    })
}

fn sorted(list: Option<Vec<(f64, f64)>>) -> Option<Vec<(f64, f64)>> {
    let mut list = list?;
    list.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
    Some(list)
}

fn poles(spectrum: Option<&Spectrum>, numbers: Option<&[(f64, f64)]>) -> Option<Vec<Pole>> {
    if let Some(spectrum) = spectrum {
        let pole = |r: &crate::linear::spectrum::Root| Pole {
            re: r.re,
            im: r.im,
            multiplicity: r.multiplicity,
            exact: r.exact.as_ref().map(ToString::to_string),
        };
        return Some(spectrum.roots.iter().map(pole).collect());
    }
    let numbers = sorted(numbers.map(<[_]>::to_vec))?;
    Some(numbers.into_iter().map(|(re, im)| Pole { re, im, multiplicity: 1, exact: None }).collect())
}

/// The dimension of span{A^k v} over the rows v of `start`. The full rank modulo a prime is one of the rational numbers, too.
fn rank_exactly(a: &RationalMatrix, start: &RationalMatrix) -> Rank {
    let n = a.rows().len();
    let residues = |m: &RationalMatrix| -> Option<Vec<Vec<Fp>>> {
        m.rows().iter().map(|row| row.iter().map(Fp::from_rational).collect()).collect()
    };
    // A denominator may vanish modulo the prime.
    let modulo = residues(a).zip(residues(start)).map(|(a, start)| rank_of_residues(&a, &start).rank);
    let rank = if modulo == Some(n) { n } else { Echelon::invariant(start.rows(), n, |v| a.times(v)).rank() };
    Rank { rank, of: n, exact: true }
}

/// The same of constants modulo the prime. It is never more than that of the constants, and less with a probability below 1e-15.
fn rank_of_residues(a: &[Vec<Fp>], start: &[Vec<Fp>]) -> Rank {
    Rank { rank: Echelon::invariant(start, a.len(), |v| times(a, v)).rank(), of: a.len(), exact: true }
}

fn transposed(rows: &[Vec<Fp>], columns: usize) -> Vec<Vec<Fp>> {
    (0..columns).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

/// Vectors whose part outside of the span so far is smaller than this, relative to their size, belong to it.
const INSIDE: f64 = 1e-10;

/// The same in floating point, by orthogonalization.
fn rank(a: &DMatrix<f64>, start: &DMatrix<f64>) -> Rank {
    let n = a.nrows();
    let mut basis: Vec<nalgebra::DVector<f64>> = Vec::new();
    let scale = a.norm().max(f64::MIN_POSITIVE);
    let mut queue: Vec<nalgebra::DVector<f64>> = start.column_iter().map(nalgebra::Matrix::into_owned).collect();
    while let Some(v) = queue.pop() {
        let size = v.norm();
        let mut rest = v;
        for _ in 0..2 {
            for q in &basis {
                let along = q.dot(&rest);
                rest -= q * along;
            }
        }
        if rest.norm() > INSIDE * size && basis.len() < n {
            rest /= rest.norm();
            queue.insert(0, a * &rest / scale);
            basis.push(rest);
        }
    }
    Rank { rank: basis.len(), of: n, exact: false }
}
