//! The stiffness at the tool point, of one pose.

use super::error::{IdentificationError, Unloaded};
use super::estimators::{
    EntryCovariance, displacement_on_wrench, positive_definite, total_least_squares, weighted, wrench_on_displacement,
};
use super::measurement::MeasurementSet;
use super::outliers::{Outliers, consensus};
use super::scaled::{Row, Scaled, check_count, check_loads};
use super::statistics::TWO_SIDED;
use nalgebra::{Matrix6, SMatrix};
use std::fmt;

/// Random subsets of this size look for outliers: twice what a compliance needs.
const SUBSET: usize = 12;
/// Iterations of the positive definite fit.
const MOST_ITERATIONS: usize = 500;

/// How a compliance or stiffness is fitted to wrenches W and displacements ΔX.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CartesianEstimator {
    /// Least squares of W on ΔX, `K = Σ W ΔXᵀ (Σ ΔX ΔXᵀ)⁻¹`: as published (equations 3.8–3.15). The noise of ΔX makes K too
    /// small, however many measurements there are.
    WrenchOnDisplacement,
    /// Least squares of ΔX on W, `C = Σ ΔX Wᵀ (Σ W Wᵀ)⁻¹`. Only the noise of W, small against the loads, makes C too small.
    DisplacementOnWrench,
    /// The same weighted with the covariance of every measurement, `Σ_X + C Σ_W Cᵀ`.
    Weighted,
    /// Total least squares of data in units of their (mean) noise.
    TotalLeastSquares,
    /// Maximum likelihood over symmetric positive definite compliances.
    PositiveDefinite,
}

impl CartesianEstimator {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::WrenchOnDisplacement,
        Self::DisplacementOnWrench,
        Self::Weighted,
        Self::TotalLeastSquares,
        Self::PositiveDefinite,
    ];
}

impl fmt::Display for CartesianEstimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::WrenchOnDisplacement => "W on ΔX (published)",
            Self::DisplacementOnWrench => "ΔX on W",
            Self::Weighted => "ΔX on W, weighted",
            Self::TotalLeastSquares => "total least squares",
            Self::PositiveDefinite => "positive definite",
        })
    }
}

/// Stiffness and compliance at the tool point of one pose, in base axes.
#[derive(Clone, Debug, PartialEq)]
pub struct CartesianEstimate {
    /// How they were fitted.
    pub estimator: CartesianEstimator,
    /// K (N/m, N/rad; N·m/m, N·m/rad).
    pub stiffness: Matrix6<f64>,
    /// C, its inverse (m/N, m/(N·m); rad/N, rad/(N·m)).
    pub compliance: Matrix6<f64>,
    /// Standard deviations of the entries of K, from noise alone: a bias is not in them.
    pub stiffness_std: Matrix6<f64>,
    /// Standard deviations of the entries of C.
    pub compliance_std: Matrix6<f64>,
    /// Ratio of the largest to the smallest root mean square of the regressor over all directions: the loads in units of their noise; for W on
    /// ΔX the displacements.
    pub condition: f64,
    /// Mean square of the residuals of displacements in units of their noise; near 1 where the noise is as stated. Above 1 the
    /// standard deviations are raised by its root.
    pub chi_square: f64,
    /// Whether C equals its transpose within 3.5 standard deviations in every entry.
    pub symmetric: bool,
    /// Whether the symmetric part of C (and of K) is positive definite.
    pub positive_definite: bool,
    /// Measurements left out (from 0).
    pub outliers: Vec<usize>,
}

impl CartesianEstimate {
    /// 95 % interval of an entry of K.
    pub fn stiffness_interval(&self, row: usize, column: usize) -> (f64, f64) {
        interval(&self.stiffness, &self.stiffness_std, (row, column))
    }

    /// 95 % interval of an entry of C.
    pub fn compliance_interval(&self, row: usize, column: usize) -> (f64, f64) {
        interval(&self.compliance, &self.compliance_std, (row, column))
    }
}

fn interval(values: &Matrix6<f64>, std: &Matrix6<f64>, entry: (usize, usize)) -> (f64, f64) {
    let (value, reach) = (values[entry], TWO_SIDED * std[entry]);
    (value - reach, value + reach)
}

/// Fits a stiffness to measurements at one pose.
///
/// # Errors
/// [`IdentificationError`] for fewer than seven measurements, several poses, loads that leave out a direction (which is named), too
/// many outliers, or a fit that does not settle.
///
/// ```
/// use bracketry_stiffness::{CartesianEstimator, Measurement, MeasurementNoise, MeasurementSet, Outliers, identify_cartesian};
/// use nalgebra::Vector6;
/// // A tool point of 1 µm/N and 1 µrad/(N·m) in all directions, pushed and turned in both directions.
/// let measurements = (0..12).map(|n| {
///     let mut wrench = Vector6::zeros();
///     wrench[n % 6] = if n < 6 { 200.0 } else { -100.0 };
///     Measurement { q: vec![0.0; 6], wrench, displacement: 1e-6 * wrench }
/// });
/// let set = MeasurementSet::new(measurements.collect(), MeasurementNoise::from_std(2e-5, 5e-5, 2.0, 0.5)).unwrap();
/// let estimate = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap();
/// assert!((estimate.stiffness[(0, 0)] - 1e6).abs() < 1.0);
/// ```
pub fn identify_cartesian(
    set: &MeasurementSet,
    estimator: CartesianEstimator,
    outliers: Outliers,
) -> Result<CartesianEstimate, IdentificationError> {
    let scaled = Scaled::new(set)?;
    let load_condition = check_loads(&scaled.rows)?;
    let kept = match outliers {
        Outliers::Keep => (0..scaled.rows.len()).collect(),
        Outliers::Reject => consensus(
            scaled.rows.len(),
            SUBSET,
            |indices| {
                let rows = scaled.subset(indices);
                check_loads(&rows).ok()?;
                displacement_on_wrench(&rows).map(|(compliance, _)| compliance)
            },
            |compliance| scaled.rows.iter().map(|row| row.distance(compliance)).collect(),
        )?,
    };
    let rows = scaled.subset(&kept);
    check_count(rows.len())?;
    check_loads(&rows)?;
    let fit = fit(&rows, estimator)?;
    let distances: f64 = rows.iter().map(|row| row.distance(&fit.compliance)).sum();
    let parameters = if estimator == CartesianEstimator::PositiveDefinite { 21 } else { 36 };
    let chi_square = distances / (6 * rows.len() - parameters) as f64;
    let raised = chi_square.max(1.0).sqrt();
    let (to_compliance, to_stiffness) = scaled.factors();
    Ok(CartesianEstimate {
        estimator,
        stiffness: scaled.stiffness(&fit.stiffness),
        compliance: scaled.compliance(&fit.compliance),
        stiffness_std: raised * deviations(&fit.stiffness_covariance, &to_stiffness),
        compliance_std: raised * deviations(&fit.compliance_covariance, &to_compliance),
        condition: fit.condition.unwrap_or(load_condition),
        chi_square,
        symmetric: symmetric(&fit.compliance, &fit.compliance_covariance, raised),
        positive_definite: (fit.compliance + fit.compliance.transpose()).symmetric_eigenvalues().min() > 0.0,
        outliers: (0..scaled.rows.len()).filter(|i| kept.binary_search(i).is_err()).collect(),
    })
}

/// A fit in scaled coordinates.
struct Fit {
    stiffness: Matrix6<f64>,
    compliance: Matrix6<f64>,
    stiffness_covariance: EntryCovariance,
    compliance_covariance: EntryCovariance,
    /// Of the regressor, where it is not the loads.
    condition: Option<f64>,
}

fn fit(rows: &[Row], estimator: CartesianEstimator) -> Result<Fit, IdentificationError> {
    let singular = || IdentificationError::NotLoaded { directions: vec![Unloaded::Unknown] };
    let (compliance, compliance_covariance) = match estimator {
        CartesianEstimator::WrenchOnDisplacement => {
            let (stiffness, stiffness_covariance, condition) = wrench_on_displacement(rows).ok_or_else(singular)?;
            let compliance = stiffness.try_inverse().ok_or_else(singular)?;
            let compliance_covariance = of_inverse(&compliance, &stiffness_covariance);
            let condition = Some(condition);
            return Ok(Fit { stiffness, compliance, stiffness_covariance, compliance_covariance, condition });
        }
        CartesianEstimator::DisplacementOnWrench => displacement_on_wrench(rows).ok_or_else(singular)?,
        CartesianEstimator::Weighted => weighted(rows).ok_or_else(singular)?,
        CartesianEstimator::TotalLeastSquares => total_least_squares(rows).ok_or_else(singular)?,
        CartesianEstimator::PositiveDefinite => {
            let (compliance, covariance, settled) = positive_definite(rows, MOST_ITERATIONS).ok_or_else(singular)?;
            if !settled {
                return Err(IdentificationError::NotConverged { iterations: MOST_ITERATIONS });
            }
            (compliance, covariance)
        }
    };
    let stiffness = compliance.try_inverse().ok_or_else(singular)?;
    let stiffness_covariance = of_inverse(&stiffness, &compliance_covariance);
    Ok(Fit { stiffness, compliance, stiffness_covariance, compliance_covariance, condition: None })
}

/// Covariance of the entries of an inverse: `d(A⁻¹) = −A⁻¹ dA A⁻¹`.
fn of_inverse(inverse: &Matrix6<f64>, covariance: &EntryCovariance) -> EntryCovariance {
    let derivative: SMatrix<f64, 36, 36> = inverse.transpose().kronecker(inverse);
    derivative * covariance * derivative.transpose()
}

/// Standard deviations of the entries of `F A Fᵀ` from the covariance of those of A.
fn deviations(covariance: &EntryCovariance, factor: &Matrix6<f64>) -> Matrix6<f64> {
    let map: SMatrix<f64, 36, 36> = factor.kronecker(factor);
    let variances = (map * covariance * map.transpose()).diagonal();
    Matrix6::from_column_slice(variances.as_slice()).map(|v| v.max(0.0).sqrt())
}

fn symmetric(compliance: &Matrix6<f64>, covariance: &EntryCovariance, raised: f64) -> bool {
    (0..6).all(|i| {
        (0..i).all(|j| {
            let (a, b) = (i + 6 * j, j + 6 * i);
            let variance = covariance[(a, a)] + covariance[(b, b)] - 2.0 * covariance[(a, b)];
            // Entries that are equal by construction have no variance of their difference.
            let rounding = 1e-12 * compliance.amax();
            let difference = (compliance[(i, j)] - compliance[(j, i)]).abs();
            difference <= 3.5 * raised * variance.max(0.0).sqrt() + rounding
        })
    })
}
