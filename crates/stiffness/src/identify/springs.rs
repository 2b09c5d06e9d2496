//! Springs of the joints from measurements over many poses.

use super::error::{IdentificationError, Place};
use super::levenberg_marquardt::{Minimum, minimise};
use super::outliers::{Outliers, agreeing};
use super::parameters::{DeformationModel, Parameter, links_alone, logarithms, parameters, springs_at};
use crate::kinematics::Kinematics;
use crate::loaded::loaded_compliance;
use crate::measurement::{Measurement, MeasurementNoise, MeasurementSet};
use crate::robot::Robot;
use crate::spring::{JointSpring, Springs};
use crate::{Twist, Wrench};
use nalgebra::{DMatrix, DVector, Matrix6};
use std::fmt;

/// 97.5 % point of the normal distribution.
const TWO_SIDED: f64 = 1.959_964;
/// Standard deviation of a logarithm from which on a parameter is not identified: its 95 % interval spans a factor of 7.
const NOT_IDENTIFIED: f64 = 0.5;
/// Standard deviation of a logarithm about the linear start: a factor of 20 up or down. It binds only what the data do not tell, which would
/// run off to a rigid joint otherwise and leave its compliance to another; it is no part of the information reported.
const LOOSE: f64 = 3.0;
/// Eigenvalue of the information, scaled to a unit diagonal, that is zero but for rounding and differences.
const DEPENDENT: f64 = 1e-12;
/// Product of components from which on two parameters take part in a direction: below, it is rounding.
const TAKES_PART: f64 = 1e-8;
/// Most others that a parameter is said not to be told from.
const MOST_NAMED: usize = 3;
/// Times the noise's covariance is renewed from the springs.
const REWEIGHTED: usize = 3;

/// How springs are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringFitSettings {
    /// The prediction they are fitted with.
    pub model: DeformationModel,
    /// What to do about outliers.
    pub outliers: Outliers,
    /// Most iterations of a fit.
    pub most_iterations: usize,
}

impl Default for SpringFitSettings {
    fn default() -> Self {
        Self { model: DeformationModel::default(), outliers: Outliers::default(), most_iterations: 100 }
    }
}

/// What the data say about a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Identified {
    /// A number.
    Yes {
        /// Its value.
        value: f64,
        /// Lower end of its 95 % interval.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Nothing useful.
    No {
        /// Standard deviation of its logarithm; infinite where it does not show at all.
        log_std: f64,
        /// Why, in words.
        why: String,
    },
}

/// A parameter of a joint's spring.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringParameter {
    /// Joint, from 1.
    pub joint: usize,
    /// `stiffness`, `cubic`, `gap` or `engaged`.
    pub name: &'static str,
    /// What is known of it, in the units of [`JointSpring`].
    pub identified: Identified,
}

impl fmt::Display for SpringParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "joint {}, {}: ", self.joint, self.name)?;
        match &self.identified {
            Identified::Yes { value, low, high } => write!(f, "{value:.4e} (95 %: {low:.4e} … {high:.4e})"),
            Identified::No { why, .. } => write!(f, "not identified, {why}"),
        }
    }
}

/// Springs fitted to measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringFit {
    /// All parameters, joint by joint.
    pub parameters: Vec<SpringParameter>,
    /// Covariance of their logarithms; where the data say nothing its entries are large or infinite.
    pub log_covariance: DMatrix<f64>,
    /// Mean square of the residuals of displacements in units of their noise; near 1 where model and noise are right.
    pub chi_square: f64,
    /// Ratio of the largest to the smallest standard deviation of a combination of logarithms: the condition of the set of poses.
    pub condition: f64,
    /// Measurements left out (from 0).
    pub outliers: Vec<usize>,
    /// Iterations of the last fit.
    pub iterations: usize,
    springs: Springs,
}

impl SpringFit {
    /// The springs, if all of their parameters are identified.
    ///
    /// # Errors
    /// [`IdentificationError::NotIdentified`] with those that are not, and why.
    pub fn springs(&self) -> Result<&Springs, IdentificationError> {
        let unknown = self.parameters.iter().filter(|p| matches!(p.identified, Identified::No { .. }));
        let unknown: Vec<String> = unknown.map(ToString::to_string).collect();
        if unknown.is_empty() {
            Ok(&self.springs)
        } else {
            Err(IdentificationError::NotIdentified { parameters: unknown })
        }
    }
}

impl SpringFit {
    /// The springs as they were fitted: good for predictions near the poses and loads of the fit, whether all of their parameters are
    /// identified or not.
    pub fn fitted(&self) -> &Springs {
        &self.springs
    }
}

impl fmt::Display for SpringFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parameters.iter().try_for_each(|parameter| writeln!(f, "{parameter}"))?;
        writeln!(f, "condition {:.1}, residuals {:.2} σ", self.condition, self.chi_square.sqrt())?;
        write!(f, "{} measurements left out as outliers", self.outliers.len())
    }
}

/// Fits the parameters of the joints' springs: those of `start`, of the same kinds; compliances of links stay as they are.
///
/// Minimises `Σ rᵀ (Σ_X + C Σ_W Cᵀ)⁻¹ r`, r the measured less the predicted displacement, over the logarithms of the parameters, from
/// the linear solution of `ΔX = Σ_j c_j J_j J_jᵀ W` where it is positive. The torque at which a gap is engaged must start among the torques of
/// the loads: below all of them it changes nothing, and is found not identified.
///
/// # Errors
/// [`IdentificationError`] for springs, poses or starts that do not fit, fewer than one measurement more than parameters need, too many
/// outliers, or a fit that does not settle. Parameters that the data do not tell are no error: see [`Identified`] and [`SpringFit::springs`].
pub fn fit_springs(
    robot: &Robot,
    set: &MeasurementSet,
    start: &Springs,
    settings: &SpringFitSettings,
) -> Result<SpringFit, IdentificationError> {
    start.check(robot.joints.len())?;
    let listed = parameters(start)?;
    let needed = listed.len().div_ceil(6) + 1;
    let enough = |found: usize| {
        if found < needed {
            Err(IdentificationError::TooFew { what: "a fit of these springs", found, needed })
        } else {
            Ok(())
        }
    };
    enough(set.len())?;
    for (i, m) in set.measurements().iter().enumerate() {
        if m.q.len() != robot.joints.len() {
            let (found, expected) = (m.q.len(), robot.joints.len());
            let row = Place::Row(i + 1);
            return Err(IdentificationError::Count { row, what: "joint coordinates", found, expected });
        }
    }
    let fitted = |indices: &[usize]| fit(robot, &set.subset(indices), start, settings);
    let kept = match settings.outliers {
        Outliers::Keep => (0..set.len()).collect::<Vec<_>>(),
        Outliers::Reject => agreeing(
            set.len(),
            2 * needed,
            |indices| fitted(indices).ok(),
            |fit| (0..set.len()).map(|i| squared_distance(robot, set, i, &fit.springs, settings.model)).collect(),
        )?,
    };
    enough(kept.len())?;
    let fit = fitted(&kept)?;
    let residuals: f64 = kept.iter().map(|i| squared_distance(robot, set, *i, &fit.springs, settings.model)).sum();
    let chi_square = residuals / (6 * kept.len() - listed.len()) as f64;
    let told = fit.minimum.jacobian.rows(0, 6 * kept.len());
    let information = told.tr_mul(&told) / chi_square.max(1.0);
    if information.iter().any(|v| !v.is_finite()) {
        return Err(IdentificationError::NotConverged { iterations: fit.minimum.iterations });
    }
    let known = Known::from(&information);
    let last = parameters(&fit.springs)?;
    Ok(SpringFit {
        parameters: last.iter().enumerate().map(|(k, p)| known.parameter(k, p, &last)).collect(),
        log_covariance: known.covariance,
        chi_square,
        condition: known.condition,
        outliers: (0..set.len()).filter(|i| kept.binary_search(i).is_err()).collect(),
        iterations: fit.minimum.iterations,
        springs: fit.springs,
    })
}

struct Fit {
    springs: Springs,
    minimum: Minimum,
}

/// The factor that whitens residuals: of `Σ_X + C Σ_W Cᵀ`.
fn whitening(
    robot: &Robot,
    springs: &Springs,
    measurement: &Measurement,
    noise: &MeasurementNoise,
) -> Result<Matrix6<f64>, IdentificationError> {
    let kinematics = Kinematics::new(robot, &measurement.q)?;
    let compliance = loaded_compliance(robot, springs, &kinematics, &measurement.wrench)
        .or_else(|_| loaded_compliance(robot, springs, &kinematics, &Wrench::zeros()))?;
    let covariance = noise.displacement + compliance * noise.wrench * compliance.transpose();
    let factor = covariance.cholesky().ok_or(IdentificationError::Noise { what: "displacement" })?;
    factor.l().try_inverse().ok_or(IdentificationError::Noise { what: "displacement" })
}

/// Squared Mahalanobis distance of a measurement (from 0) from its prediction.
pub(super) fn squared_distance(
    robot: &Robot,
    set: &MeasurementSet,
    index: usize,
    springs: &Springs,
    model: DeformationModel,
) -> f64 {
    let m = &set.measurements()[index];
    let predicted = model.displacement(robot, springs, &m.q, &m.wrench);
    match (predicted, whitening(robot, springs, m, &set.noise()[index])) {
        (Ok(predicted), Ok(whiten)) => (whiten * (m.displacement - predicted)).norm_squared(),
        _ => f64::INFINITY,
    }
}

fn fit(
    robot: &Robot,
    set: &MeasurementSet,
    start: &Springs,
    settings: &SpringFitSettings,
) -> Result<Fit, IdentificationError> {
    let whiten = |springs: &Springs| -> Result<Vec<Matrix6<f64>>, IdentificationError> {
        let rows = set.measurements().iter().zip(set.noise());
        rows.map(|(m, noise)| whitening(robot, springs, m, noise)).collect()
    };
    let mut springs = linear_start(robot, set, start, &whiten(start)?)?;
    let center = logarithms(&parameters(&springs)?);
    let rows = 6 * set.len();
    let mut last = None;
    for _ in 0..REWEIGHTED {
        let weights = whiten(&springs)?;
        let residuals = |p: &DVector<f64>| {
            let springs = springs_at(start, p);
            let mut stacked = DVector::zeros(rows + p.len());
            for (n, (m, whiten)) in set.measurements().iter().zip(&weights).enumerate() {
                let predicted: Twist = settings.model.displacement(robot, &springs, &m.q, &m.wrench).ok()?;
                stacked.fixed_rows_mut::<6>(6 * n).copy_from(&(whiten * (predicted - m.displacement)));
            }
            stacked.rows_mut(rows, p.len()).copy_from(&((p - &center) / LOOSE));
            stacked.iter().all(|v| v.is_finite()).then_some(stacked)
        };
        let begin = logarithms(&parameters(&springs)?);
        let iterations = settings.most_iterations;
        let minimum = minimise(residuals, begin, iterations).ok_or(IdentificationError::NotConverged { iterations })?;
        if !minimum.settled {
            return Err(IdentificationError::NotConverged { iterations });
        }
        springs = springs_at(start, &minimum.parameters);
        last = Some(minimum);
    }
    let iterations = settings.most_iterations;
    let minimum = last.ok_or(IdentificationError::NotConverged { iterations })?;
    Ok(Fit { springs, minimum })
}

/// Stiffnesses from `ΔX = Σ_j c_j J_j J_jᵀ W`, less what links yield; those whose compliance is not clearly positive stay at the start.
fn linear_start(
    robot: &Robot,
    set: &MeasurementSet,
    start: &Springs,
    weights: &[Matrix6<f64>],
) -> Result<Springs, IdentificationError> {
    let joints = robot.joints.len();
    let mut normal = DMatrix::zeros(joints, joints);
    let mut right = DVector::zeros(joints);
    for (m, whiten) in set.measurements().iter().zip(weights) {
        let kinematics = Kinematics::new(robot, &m.q)?;
        let mut columns = whiten * kinematics.jacobian();
        for j in 0..joints {
            let torque = kinematics.torque(j, &m.wrench);
            columns.column_mut(j).scale_mut(torque);
        }
        normal += columns.tr_mul(&columns);
        let links = links_alone(robot, start, &m.q, &m.wrench)?;
        right += columns.tr_mul(&(whiten * (m.displacement - links)));
    }
    let mut springs = start.clone();
    let Some(inverse) = normal.cholesky().map(|factor| factor.inverse()) else { return Ok(springs) };
    let compliances = &inverse * right;
    for (j, spring) in springs.joints.iter_mut().enumerate() {
        if compliances[j] > 3.0 * inverse[(j, j)].sqrt() {
            let (JointSpring::Linear { stiffness }
            | JointSpring::Stiffening { stiffness, .. }
            | JointSpring::Backlash { stiffness, .. }) = spring;
            *stiffness = 1.0 / compliances[j];
        }
    }
    Ok(springs)
}

/// What an information matrix of logarithms tells.
pub(super) struct Known {
    pub(super) covariance: DMatrix<f64>,
    pub(super) condition: f64,
    /// Directions among the scaled logarithms, the worst known first, with their standard deviation.
    directions: Vec<(f64, DVector<f64>)>,
    /// Standard deviation of each logarithm if the others were known.
    alone: DVector<f64>,
}

impl From<&DMatrix<f64>> for Known {
    fn from(information: &DMatrix<f64>) -> Self {
        let count = information.nrows();
        // Each logarithm in units of what it would be known to alone: two that act alike cancel even where one hardly shows.
        let alone = information.diagonal().map(|v| if v > 0.0 { v.sqrt().recip() } else { f64::INFINITY });
        let shows = |i: usize| alone[i].is_finite();
        let shared = DMatrix::from_fn(count, count, |i, j| match (i == j, shows(i) && shows(j)) {
            (true, shows) => f64::from(u8::from(shows)),
            (false, true) => information[(i, j)] * alone[i] * alone[j],
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
        let scale = |i: usize| if shows(i) { alone[i] } else { 0.0 };
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
        Self { covariance, condition, directions, alone }
    }
}

impl Known {
    fn parameter(&self, k: usize, parameter: &Parameter, all: &[Parameter]) -> SpringParameter {
        let log_std = self.covariance[(k, k)].sqrt();
        let value = parameter.value;
        let identified = if log_std <= NOT_IDENTIFIED {
            let factor = (TWO_SIDED * log_std).exp();
            Identified::Yes { value, low: value / factor, high: value * factor }
        } else {
            Identified::No { log_std, why: self.why(k, log_std, all) }
        };
        SpringParameter { joint: parameter.joint + 1, name: parameter.name, identified }
    }

    /// That it does not show, or the others that it cannot be told apart from.
    fn why(&self, k: usize, log_std: f64, all: &[Parameter]) -> String {
        let size = format!("standard deviation of its logarithm {log_std:.1}");
        // Known no better if all others were.
        if self.alone[k] > NOT_IDENTIFIED {
            return if all[k].name == "stiffness" {
                format!("these loads move the joint by less than the noise in these poses ({size})")
            } else {
                format!(
                    "it changes these displacements by less than the noise; start elsewhere or leave it out ({size})"
                )
            };
        }
        let part = |direction: &(f64, DVector<f64>)| direction.0.min(f64::MAX.sqrt()) * direction.1[k].abs();
        let worst = self.directions.iter().max_by(|a, b| part(a).total_cmp(&part(b)));
        let mut others: Vec<(f64, usize)> = worst.map_or(Vec::new(), |(_, d)| {
            (0..all.len()).filter(|i| *i != k).map(|i| (d[i].abs() / d[k].abs(), i)).filter(|o| o.0 > 0.3).collect()
        });
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        others.truncate(MOST_NAMED);
        let named = others.iter().map(|(_, i)| format!("the {} of joint {}", all[*i].name, all[*i].joint + 1));
        let named: Vec<String> = named.collect();
        format!("these poses and loads do not tell it from {} ({size})", named.join(" and "))
    }
}
