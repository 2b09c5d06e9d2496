//! What an information matrix tells of the parameters of springs.

use super::parameters::Parameter;
use super::spring_parameter::{Identified, SpringParameter, Unidentified};
use super::statistics::TWO_SIDED;
use nalgebra::{DMatrix, DVector};

/// Standard deviation of a logarithm from which on a parameter is not identified: its 95 % interval spans a factor of 7.
pub(crate) const NOT_IDENTIFIED: f64 = 0.5;
/// Eigenvalue of the information, scaled to a unit diagonal, that is zero but for rounding and differences.
const DEPENDENT: f64 = 1e-12;
/// Product of components from which on two parameters take part in a direction: below, it is rounding.
const TAKES_PART: f64 = 1e-8;
/// Most others that a parameter is said not to be told from.
const MOST_NAMED: usize = 3;

/// Uncertainty of logarithms with a given information matrix.
pub(super) struct Uncertainty {
    pub(super) covariance: DMatrix<f64>,
    pub(super) condition: f64,
    /// Directions among the scaled logarithms, the worst known first, with their standard deviation.
    directions: Vec<(f64, DVector<f64>)>,
    /// Conditional standard deviation of each logarithm, the others known.
    conditional: DVector<f64>,
}

impl From<&DMatrix<f64>> for Uncertainty {
    fn from(information: &DMatrix<f64>) -> Self {
        let count = information.nrows();
        // Each logarithm in units of what it would be known to conditional: two that act alike cancel even where one hardly shows.
        let conditional = information.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { f64::INFINITY });
        let shows = |i: usize| conditional[i].is_finite();
        let shared = DMatrix::from_fn(count, count, |i, j| match (i == j, shows(i) && shows(j)) {
            (true, shows) => f64::from(u8::from(shows)),
            (false, true) => information[(i, j)] * conditional[i] * conditional[j],
            (false, false) => 0.0,
        });
        let eigen = shared.symmetric_eigen();
        let mut directions: Vec<(f64, DVector<f64>)> = eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
            .map(|(v, d)| (if *v > DEPENDENT { v.sqrt().recip() } else { f64::INFINITY }, d.into_owned()))
            .collect();
        directions.sort_by(|a, b| b.0.total_cmp(&a.0));
        let scale = |i: usize| if shows(i) { conditional[i] } else { 0.0 };
        let covariance = DMatrix::from_fn(count, count, |i, j| {
            directions.iter().fold(0.0, |sum: f64, (std, d)| {
                let product = d[i] * d[j];
                if std.is_finite() {
                    sum + std * std * product * scale(i) * scale(j)
                } else if product.abs() > TAKES_PART && sum.is_finite() {
                    product.signum() * f64::INFINITY
                } else {
                    sum
                }
            })
        });
        let eigenvalues = information.symmetric_eigenvalues();
        let condition = (eigenvalues.max() / eigenvalues.min().max(0.0)).sqrt();
        Self { covariance, condition, directions, conditional }
    }
}

impl Uncertainty {
    pub(super) fn parameter(&self, k: usize, parameter: &Parameter, all: &[Parameter]) -> SpringParameter {
        let log_std = self.covariance[(k, k)].sqrt();
        let value = parameter.value;
        let identified = if log_std <= NOT_IDENTIFIED {
            let factor = (TWO_SIDED * log_std).exp();
            Identified::Yes { value, low: value / factor, high: value * factor }
        } else {
            Identified::No { log_std, why: self.why(k, all) }
        };
        SpringParameter { joint: parameter.joint + 1, name: parameter.name, identified }
    }

    /// That it does not show, or the others that it cannot be told apart from.
    fn why(&self, k: usize, all: &[Parameter]) -> Unidentified {
        // Known no better if all others were.
        if self.conditional[k] > NOT_IDENTIFIED {
            return if all[k].name == "stiffness" { Unidentified::NotDeflected } else { Unidentified::NoEffect };
        }
        let part = |direction: &(f64, DVector<f64>)| direction.0.min(f64::MAX.sqrt()) * direction.1[k].abs();
        let worst = self.directions.iter().max_by(|a, b| part(a).total_cmp(&part(b)));
        let mut others: Vec<(f64, usize)> = worst.map_or(Vec::new(), |(_, d)| {
            (0..all.len()).filter(|i| *i != k).map(|i| (d[i].abs() / d[k].abs(), i)).filter(|o| o.0 > 0.3).collect()
        });
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        others.truncate(MOST_NAMED);
        Unidentified::Confounded(others.iter().map(|(_, i)| (all[*i].joint + 1, all[*i].name)).collect())
    }
}
