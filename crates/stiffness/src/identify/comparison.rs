//! All estimators on the same data: which one predicts what it has not seen, and which one to trust.

use super::cartesian::{CartesianEstimate, CartesianEstimator, identify_cartesian};
use super::conventions::check_conventions;
use super::error::IdentificationError;
use super::estimators::noise_sums;
use super::measurement::MeasurementSet;
use super::outliers::{Draw, Outliers};
use super::scaled::{Row, Scaled};
use super::springs::{SpringFit, SpringFitSettings, fit_springs, squared_distance};
use crate::compliance::Springs;
use crate::robot::Robot;
use nalgebra::Matrix6;
use std::fmt;

/// Parts of the cross-validation.
const FOLDS: usize = 5;
/// Predictions as good as the best, relative: less than what chance makes in a few hundred numbers.
const AS_GOOD: f64 = 1.02;
/// Mean square of the residuals, in units of their noise, above which a model misses something (or the noise is larger than stated).
const MISSES: f64 = 1.5;
/// The same below which the noise is smaller than stated, if there are enough numbers to tell.
const OVERSTATED: f64 = 0.25;
const ENOUGH: usize = 36;

/// A way to identify the stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Of one pose.
    Cartesian(CartesianEstimator),
    /// Springs of the joints.
    JointSprings,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cartesian(estimator) => estimator.fmt(f),
            Self::JointSprings => f.pad("joint springs"),
        }
    }
}

/// What a method found.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Stiffness and compliance of the pose.
    Cartesian(Box<CartesianEstimate>),
    /// Springs.
    Springs(Box<SpringFit>),
}

/// A method that worked.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodReport {
    /// What it found in all data.
    pub found: Found,
    /// Root mean square error of the prediction of held-out displacements, in units of the noise of the difference: 1 is perfect. Five-fold
    /// cross-validation.
    pub held_out: f64,
    /// What the noise of its regressor takes away.
    pub attenuation: Option<Attenuation>,
}

/// How much too small the noise of the regressor makes an estimate, however many measurements there are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attenuation {
    /// Expected factor in the direction where it is worst; 1 is none.
    pub worst: f64,
    /// Expected error of the matrix, ‖estimate − truth‖ / ‖truth‖ (Frobenius, N, m, rad).
    pub error: f64,
}

/// All methods on the same data.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Each with what it found, or why it did not.
    pub methods: Vec<(Method, Result<MethodReport, IdentificationError>)>,
    /// The one to trust.
    pub trusted: Method,
    /// Why, and what is wrong with the others.
    pub reasons: Vec<String>,
    /// Measurements left out (from 0).
    pub outliers: Vec<usize>,
}

/// Runs all Cartesian estimators (where there is one pose) and the fit of joint springs (where a robot and springs to start from are
/// given), predicts held-out displacements, and says which one to trust.
///
/// The best prediction wins; of those as good as it within 2 % the one with the fewest parameters.
///
/// # Errors
/// [`IdentificationError::Convention`] for data that joint springs explain far better with another sign of their forces, moments, translations
/// or rotations, or with moments a thousand times as large; else the first method's [`IdentificationError`] where none works.
pub fn compare(
    set: &MeasurementSet,
    robot: Option<(&Robot, &Springs, &SpringFitSettings)>,
    outliers: Outliers,
) -> Result<Comparison, IdentificationError> {
    if let Some((robot, start, _)) = robot {
        check_conventions(robot, set, start)?;
    }
    let left_out = match outliers {
        Outliers::Keep => Vec::new(),
        Outliers::Reject => find_outliers(set, robot)?,
    };
    let kept: Vec<usize> = (0..set.len()).filter(|i| !left_out.contains(i)).collect();
    let set = set.subset(&kept);
    let folds = folds(set.len());
    let mut methods = Vec::new();
    if let Some((robot, start, settings)) = robot {
        let settings = SpringFitSettings { outliers: Outliers::Keep, ..*settings };
        methods.push((Method::JointSprings, joint_springs(robot, &set, start, &settings, &folds)));
    }
    // From few parameters to many, so that the first of equals is the simplest.
    for estimator in CartesianEstimator::ALL.into_iter().rev() {
        methods.push((Method::Cartesian(estimator), cartesian(&set, estimator, &folds)));
    }
    let works = |(method, report): &(Method, Result<MethodReport, _>)| Some((*method, report.as_ref().ok()?.held_out));
    let working: Vec<(Method, f64)> = methods.iter().filter_map(works).collect();
    let best = working.iter().map(|(_, error)| *error).fold(f64::INFINITY, f64::min);
    let Some((trusted, error)) = working.iter().find(|(_, error)| *error <= AS_GOOD * best).copied() else {
        let first = methods.into_iter().find_map(|(_, report)| report.err());
        return Err(first.unwrap_or(IdentificationError::TooFew { what: "a comparison", found: 0, needed: 7 }));
    };
    let mut reasons = reasons(&methods, trusted, error);
    reasons.extend(overstated(&methods, trusted, set.len()));
    Ok(Comparison { methods, trusted, reasons, outliers: left_out })
}

/// Measurements that contradict the springs; the free matrix, where that explains the rest better. A model that misses something takes
/// good measurements for bad.
fn find_outliers(
    set: &MeasurementSet,
    robot: Option<(&Robot, &Springs, &SpringFitSettings)>,
) -> Result<Vec<usize>, IdentificationError> {
    let outliers = Outliers::Reject;
    let springs = robot
        .map(|(robot, start, settings)| fit_springs(robot, set, start, &SpringFitSettings { outliers, ..*settings }));
    if let Some(Ok(fit)) = &springs
        && fit.chi_square <= MISSES
    {
        return Ok(fit.outliers.clone());
    }
    match (springs, identify_cartesian(set, CartesianEstimator::DisplacementOnWrench, outliers)) {
        (Some(Ok(fit)), Ok(free)) if fit.chi_square <= free.chi_square => Ok(fit.outliers),
        (_, Ok(free)) => Ok(free.outliers),
        (Some(springs), Err(_)) => Ok(springs?.outliers),
        (None, Err(why)) => Err(why),
    }
}

/// Indices held out together; drawn, as rows next to each other may belong to one direction of load.
fn folds(count: usize) -> Vec<Vec<usize>> {
    let all: Vec<usize> = (0..count).collect();
    let order = Draw(0x2545_f491_4f6c_dd1d).subset(&all, count);
    (0..FOLDS).map(|fold| order.iter().copied().skip(fold).step_by(FOLDS).collect()).collect()
}

fn all_but(count: usize, fold: &[usize]) -> Vec<usize> {
    (0..count).filter(|i| !fold.contains(i)).collect()
}

/// Why a fold cannot be predicted, in numbers of the whole set: what is held out must leave enough.
fn of_all(why: IdentificationError, found: usize) -> IdentificationError {
    match why {
        IdentificationError::TooFew { needed, .. } => IdentificationError::TooFew {
            what: "predicting each fifth of them from the others",
            found,
            needed: (FOLDS * needed).div_ceil(FOLDS - 1),
        },
        other => other,
    }
}

fn joint_springs(
    robot: &Robot,
    set: &MeasurementSet,
    start: &Springs,
    settings: &SpringFitSettings,
    folds: &[Vec<usize>],
) -> Result<MethodReport, IdentificationError> {
    let fit = fit_springs(robot, set, start, settings)?;
    let mut sum = 0.0;
    for fold in folds {
        let without = fit_springs(robot, &set.subset(&all_but(set.len(), fold)), start, settings);
        let without = without.map_err(|why| of_all(why, set.len()))?;
        sum += fold.iter().map(|i| squared_distance(robot, set, *i, without.fitted(), settings.model)).sum::<f64>();
    }
    let held_out = (sum / (6 * set.len()) as f64).sqrt();
    Ok(MethodReport { found: Found::Springs(Box::new(fit)), held_out, attenuation: None })
}

fn cartesian(
    set: &MeasurementSet,
    estimator: CartesianEstimator,
    folds: &[Vec<usize>],
) -> Result<MethodReport, IdentificationError> {
    let estimate = identify_cartesian(set, estimator, Outliers::Keep)?;
    // The same yardstick for all: a compliance that is too large would make its own too long.
    let reference = identify_cartesian(set, CartesianEstimator::PositiveDefinite, Outliers::Keep)?.compliance;
    let mut sum = 0.0;
    for fold in folds {
        let without = identify_cartesian(&set.subset(&all_but(set.len(), fold)), estimator, Outliers::Keep);
        let without = without.map_err(|why| of_all(why, set.len()))?;
        for i in fold {
            let (m, noise) = (&set.measurements()[*i], &set.noise()[*i]);
            let residual = m.displacement - without.compliance * m.wrench;
            let covariance = noise.displacement + reference * noise.wrench * reference.transpose();
            let factor = covariance.cholesky().ok_or(IdentificationError::Noise { what: "displacement" })?;
            sum += residual.dot(&factor.solve(&residual));
        }
    }
    let scaled = Scaled::new(set)?;
    let held_out = (sum / (6 * set.len()) as f64).sqrt();
    let attenuation = attenuation(&scaled, estimator, &reference);
    Ok(MethodReport { found: Found::Cartesian(Box::new(estimate)), held_out, attenuation })
}

/// Least squares on a regressor z with noise finds A z-true with `A = S (S + N)⁻¹`, S the sum of `z zᵀ` and N that of its noise.
fn attenuation(scaled: &Scaled, estimator: CartesianEstimator, reference: &Matrix6<f64>) -> Option<Attenuation> {
    let (wrench_noise, displacement_noise) = noise_sums(&scaled.rows);
    let loads = scaled
        .rows
        .iter()
        .fold(Matrix6::zeros(), |sum: Matrix6<f64>, row: &Row| sum + row.wrench * row.wrench.transpose());
    let (inverse, _) = scaled.factors();
    let inverse = inverse.try_inverse()?;
    let compliance = inverse * reference * inverse.transpose();
    let (signal, noise, truth) = match estimator {
        CartesianEstimator::WrenchOnDisplacement => {
            (compliance * loads * compliance.transpose(), displacement_noise, reference.try_inverse()?)
        }
        CartesianEstimator::DisplacementOnWrench | CartesianEstimator::Weighted => {
            (loads - wrench_noise, wrench_noise, *reference)
        }
        CartesianEstimator::TotalLeastSquares | CartesianEstimator::PositiveDefinite => return None,
    };
    let factor = signal * (signal + noise).try_inverse()?;
    // A is similar to the symmetric L⁻¹ S L⁻ᵀ with L Lᵀ = S + N.
    let whiten = (signal + noise).cholesky()?.l().try_inverse()?;
    let worst = (whiten * signal * whiten.transpose()).symmetric_eigenvalues().min();
    let found = match estimator {
        CartesianEstimator::WrenchOnDisplacement => scaled.stiffness(&(compliance.try_inverse()? * factor)),
        _ => scaled.compliance(&(compliance * factor)),
    };
    Some(Attenuation { worst, error: (found - truth).norm() / truth.norm() })
}

fn reasons(
    methods: &[(Method, Result<MethodReport, IdentificationError>)],
    trusted: Method,
    error: f64,
) -> Vec<String> {
    let mut reasons = vec![format!(
        "trust {trusted}: it predicts held-out displacements to {error:.2} σ, and of the methods that do so it has the fewest parameters"
    )];
    for (method, report) in methods {
        let report = match report {
            Ok(report) => report,
            Err(why) => {
                reasons.push(format!("{method}: does not apply, {why}"));
                continue;
            }
        };
        match (method, report.attenuation) {
            (Method::Cartesian(CartesianEstimator::WrenchOnDisplacement), Some(a)) => reasons.push(format!(
                "{method}: the noise of ΔX makes K too small, by a factor of {:.3} in the worst direction and {:.1} % in all, \
                 however many measurements there are",
                a.worst,
                100.0 * a.error
            )),
            (Method::Cartesian(_), Some(a)) if a.error > 0.01 => reasons.push(format!(
                "{method}: the noise of W makes C too small, by a factor of {:.3} in the worst direction and {:.1} % in all",
                a.worst,
                100.0 * a.error
            )),
            _ => {}
        }
        match &report.found {
            Found::Cartesian(estimate) => {
                if !estimate.positive_definite {
                    reasons
                        .push(format!("{method}: not positive definite, some load would be answered by a push back"));
                }
                if !estimate.symmetric {
                    reasons.push(format!(
                        "{method}: not symmetric, more than noise explains: a circle of loads would gain energy"
                    ));
                }
            }
            Found::Springs(fit) => {
                if let Err(why) = fit.springs() {
                    reasons.push(format!("{method}: {why}"));
                }
                if fit.chi_square > MISSES {
                    let off = fit.chi_square.sqrt();
                    reasons.push(format!(
                        "{method}: residuals of {off:.1} σ, the model misses something or the noise is larger"
                    ));
                }
            }
        }
    }
    reasons
}

impl Found {
    /// Mean square of the residuals of displacements in units of their noise, by degree of freedom.
    pub fn chi_square(&self) -> f64 {
        match self {
            Self::Cartesian(estimate) => estimate.chi_square,
            Self::Springs(fit) => fit.chi_square,
        }
    }

    /// Ratio of the largest to the smallest: of the loads over all directions (Cartesian), of the standard deviations of combinations of
    /// logarithms (springs).
    pub fn condition(&self) -> f64 {
        match self {
            Self::Cartesian(estimate) => estimate.condition,
            Self::Springs(fit) => fit.condition,
        }
    }
}

/// A remark on noise that is smaller than stated, as the residuals of the trusted method tell.
fn overstated(
    methods: &[(Method, Result<MethodReport, IdentificationError>)],
    trusted: Method,
    measurements: usize,
) -> Option<String> {
    let (_, report) = methods.iter().find(|(method, _)| *method == trusted)?;
    let chi_square = report.as_ref().ok()?.found.chi_square();
    (chi_square < OVERSTATED && 6 * measurements >= 2 * ENOUGH).then(|| {
        format!(
            "the residuals are {:.2} of the stated noise: the measurements are better than that, and the intervals wider than need be",
            chi_square.sqrt()
        )
    })
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:24} {:>12} {:>10} {:>8} {:>10} {:>10}",
            "method", "held out [σ]", "condition", "χ²/dof", "symmetric", "pos. def."
        )?;
        for (method, report) in &self.methods {
            let yes = |b: bool| if b { "yes" } else { "no" };
            match report {
                Ok(MethodReport { found, held_out, .. }) => {
                    let (symmetric, definite) = match found {
                        Found::Cartesian(estimate) => (yes(estimate.symmetric), yes(estimate.positive_definite)),
                        Found::Springs(_) => ("yes", "yes"),
                    };
                    let (condition, chi_square) = (found.condition(), found.chi_square());
                    writeln!(
                        f,
                        "{method:24} {held_out:12.3} {condition:10.1} {chi_square:8.2} {symmetric:>10} {definite:>10}"
                    )?;
                }
                Err(_) => writeln!(f, "{method:24} {:>12}", "–")?,
            }
        }
        self.reasons.iter().try_for_each(|reason| writeln!(f, "{reason}"))?;
        write!(f, "{} measurements left out as outliers", self.outliers.len())
    }
}
