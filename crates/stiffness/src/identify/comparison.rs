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
/// Expected error of a matrix, relative, from which on its attenuation is worth a word.
const NOTABLE: f64 = 0.01;

/// A method to identify the stiffness.
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

/// What a comparison says of its methods.
#[derive(Clone, Debug, PartialEq)]
pub enum Advice {
    /// The method to trust: of those that predict as well it has the fewest parameters.
    Trust {
        /// The method.
        method: Method,
        /// Error of its prediction of held-out displacements, in units of their noise.
        held_out: f64,
        /// Whether that error is noise; else the method is only the best of those that all miss something.
        explains: bool,
    },
    /// A method that does not apply.
    DoesNotApply {
        /// The method.
        method: Method,
        /// Why not.
        why: IdentificationError,
    },
    /// The noise of its regressor makes the estimate too small.
    Attenuated {
        /// The estimator.
        estimator: CartesianEstimator,
        /// By how much.
        attenuation: Attenuation,
    },
    /// An estimate by which some load would be answered by a push back.
    NotPositiveDefinite(CartesianEstimator),
    /// An estimate that is less symmetric than noise explains.
    NotSymmetric(CartesianEstimator),
    /// Parameters of springs that the data do not tell.
    NotIdentified(IdentificationError),
    /// Springs that leave more than noise.
    Misfit {
        /// Root mean square of their residuals, in units of their noise.
        residual: f64,
    },
    /// Noise that is smaller than stated.
    NoiseOverstated {
        /// Root mean square of the residuals of the trusted method, in units of the stated noise.
        residual: f64,
    },
}

/// All methods on the same data.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Each with what it found, or why it did not.
    pub methods: Vec<(Method, Result<MethodReport, IdentificationError>)>,
    /// The one to trust.
    pub trusted: Method,
    /// Why, and what is wrong with the others.
    pub advice: Vec<Advice>,
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
    let mut advice = vec![Advice::Trust { method: trusted, held_out: error, explains: error * error <= MISSES }];
    advice.extend(methods.iter().flat_map(|(method, report)| advice_on(*method, report)));
    advice.extend(noise_overstated(&methods, trusted, set.len()));
    Ok(Comparison { methods, trusted, advice, outliers: left_out })
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

/// What is wrong with a method.
fn advice_on(method: Method, report: &Result<MethodReport, IdentificationError>) -> Vec<Advice> {
    let report = match report {
        Ok(report) => report,
        Err(why) => return vec![Advice::DoesNotApply { method, why: why.clone() }],
    };
    let mut advice = Vec::new();
    if let (Method::Cartesian(estimator), Some(attenuation)) = (method, report.attenuation)
        && (estimator == CartesianEstimator::WrenchOnDisplacement || attenuation.error > NOTABLE)
    {
        advice.push(Advice::Attenuated { estimator, attenuation });
    }
    match &report.found {
        Found::Cartesian(estimate) => {
            advice.extend((!estimate.positive_definite).then_some(Advice::NotPositiveDefinite(estimate.estimator)));
            advice.extend((!estimate.symmetric).then_some(Advice::NotSymmetric(estimate.estimator)));
        }
        Found::Springs(fit) => {
            advice.extend(fit.springs().err().map(Advice::NotIdentified));
            advice.extend((fit.chi_square > MISSES).then(|| Advice::Misfit { residual: fit.chi_square.sqrt() }));
        }
    }
    advice
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

/// Whether the noise is smaller than stated, as the residuals of the trusted method tell.
fn noise_overstated(
    methods: &[(Method, Result<MethodReport, IdentificationError>)],
    trusted: Method,
    measurements: usize,
) -> Option<Advice> {
    let (_, report) = methods.iter().find(|(method, _)| *method == trusted)?;
    let chi_square = report.as_ref().ok()?.found.chi_square();
    let overstated = chi_square < OVERSTATED && 6 * measurements >= 2 * ENOUGH;
    overstated.then(|| Advice::NoiseOverstated { residual: chi_square.sqrt() })
}
