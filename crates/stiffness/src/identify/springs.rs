//! Joint springs from measurements over many poses.

use super::error::{IdentificationError, Place};
use super::measurement::{Measurement, MeasurementNoise, MeasurementSet};
use super::minimum::{Minimum, minimize};
use super::outliers::{Outliers, consensus};
use super::parameters::{links_alone, logarithms, parameters, springs_at};
use super::spring_parameter::{Identified, SpringParameter};
use super::uncertainty::Uncertainty;
use crate::compliance::{DeformationModel, Springs, loaded_compliance};
use crate::robot::{Kinematics, Robot, Wrench};
use nalgebra::{DMatrix, DVector, Matrix6};

/// Standard deviation of a logarithm about the linear start: a factor of 20 up or down. It binds only what the data do not tell, which would
/// run off to a rigid joint otherwise and leave its compliance to another; it is no part of the information reported.
const PRIOR_STD: f64 = 3.0;
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
        let unknown: Vec<SpringParameter> = unknown.cloned().collect();
        if unknown.is_empty() {
            Ok(&self.springs)
        } else {
            Err(IdentificationError::NotIdentified { parameters: unknown })
        }
    }

    /// The springs as they were fitted: good for predictions near the poses and loads of the fit, whether all of their parameters are
    /// identified or not.
    pub fn fitted(&self) -> &Springs {
        &self.springs
    }
}

/// Fits the parameters of the joints' springs: those of `start`, of the same kinds; compliances of links stay as they are.
///
/// Minimizes `Σ rᵀ (Σ_X + C Σ_W Cᵀ)⁻¹ r`, r the measured less the predicted displacement, over the logarithms of the parameters, from
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
        Outliers::Reject => consensus(
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
    let known = Uncertainty::from(&information);
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
                let predicted = settings.model.displacement(robot, &springs, &m.q, &m.wrench).ok()?;
                stacked.fixed_rows_mut::<6>(6 * n).copy_from(&(whiten * (predicted - m.displacement)));
            }
            stacked.rows_mut(rows, p.len()).copy_from(&((p - &center) / PRIOR_STD));
            stacked.iter().all(|v| v.is_finite()).then_some(stacked)
        };
        let start_point = logarithms(&parameters(&springs)?);
        let iterations = settings.most_iterations;
        let minimum =
            minimize(residuals, &start_point, iterations).ok_or(IdentificationError::NotConverged { iterations })?;
        if !minimum.converged {
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
            *spring.stiffness_mut() = 1.0 / compliances[j];
        }
    }
    Ok(springs)
}
