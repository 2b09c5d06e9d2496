//! Weighing: the payload of a force sensor from its readings at rest.

use super::payload::Payload;
use crate::error::{StiffnessError, check_finite};
use crate::robot::{Wrench, check_wrench, cross_matrix};
use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};

/// Spread of the direction of gravity in the sensor's axes, as a share of gravity, below which readings count as one.
const LEAST_SPREAD: f64 = 0.05;
/// Farthest plausible center of mass (m).
const FARTHEST_CENTER: f64 = 3.0;
/// Heaviest plausible payload (kg).
const HEAVIEST: f64 = 5000.0;
/// Standard deviations a mass has to differ from nothing.
const SIGNIFICANT: f64 = 4.0;

/// A reading at rest, with nothing touching the payload.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticReading {
    /// Orientation of the sensor's axes in the base.
    pub orientation: UnitQuaternion<f64>,
    /// What the sensor reads, in its axes at its origin: what pulls on the robot.
    pub wrench: Wrench,
}

/// A payload from readings, with what is known about its errors.
#[derive(Clone, Debug, PartialEq)]
pub struct PayloadEstimate {
    /// The payload.
    pub payload: Payload,
    /// Standard deviation of the mass (kg).
    pub mass_deviation: f64,
    /// Standard deviation of the center (m).
    pub center_deviation: Vector3<f64>,
    /// Standard deviation of the bias.
    pub bias_deviation: Wrench,
    /// Standard deviation of one reading about the fit: force (N), moment (N·m).
    pub residual: [f64; 2],
    /// Reading, from 1, that fits worst.
    pub worst: usize,
}

/// Why readings do not give a payload.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PayloadError {
    /// A reading that is no number.
    #[error("reading {reading}: {source}")]
    Reading {
        /// Number of the reading, from 1.
        reading: usize,
        /// What is wrong.
        source: StiffnessError,
    },
    /// Gravity that pulls nowhere.
    #[error("gravity is {0:?} m/s²; give its acceleration in base axes, as (0, 0, -9.81)")]
    Gravity([f64; 3]),
    /// The weight always pulls in the same direction in the sensor.
    #[error(
        "{readings} readings, all with the weight along the same direction of the sensor (spread {spread:.3} of gravity): \
         mass and force bias cannot be separated; add readings with the sensor tilted by 30° or more about \
         a horizontal axis"
    )]
    OneOrientation {
        /// How many there are.
        readings: usize,
        /// Spread of the direction of gravity.
        spread: f64,
    },
    /// The weight was moved along one direction of the sensor only.
    #[error(
        "{readings} readings that differ along one direction of the sensor only, ({:.2}, {:.2}, {:.2}): \
         the center of mass along it and the moment bias cannot be separated; add a reading with the sensor tilted \
         about another of its axes", direction[0], direction[1], direction[2]
    )]
    OneDirection {
        /// How many there are.
        readings: usize,
        /// The direction in the sensor's axes.
        direction: [f64; 3],
    },
    /// A weight that pulls upwards.
    #[error(
        "the readings weigh {mass:.3} kg: either the sensor reads what the robot exerts instead of what acts on it \
         (change all signs), or gravity points in the wrong direction"
    )]
    PullsUp {
        /// Mass in kg.
        mass: f64,
    },
    /// Nothing was weighed.
    #[error(
        "the mass of {mass:.4} kg is no larger than its error {deviation:.4} kg: there is no payload, or forces are in kN"
    )]
    NoWeight {
        /// Mass in kg.
        mass: f64,
        /// Its standard deviation.
        deviation: f64,
    },
    /// A mass or a center of mass that no robot holds.
    #[error(
        "the readings make a payload of {mass:.3} kg with its center {distance:.3} m from the sensor: give forces in N and \
         moments in N·m (not mN, N·mm)"
    )]
    Units {
        /// Its mass.
        mass: f64,
        /// Distance of its center.
        distance: f64,
    },
}

/// Mass, center and bias from readings at rest in several orientations, by least squares: forces
/// `f = b_f + m Rᵀg`, moments `μ = b_m + m c × Rᵀg`, linear in `(m, b_f)` and `(m c, b_m)`. Three orientations that turn the
/// sensor about two axes are enough.
///
/// `gravity` is the acceleration in base axes (m/s²).
///
/// # Errors
/// [`PayloadError`] that names what the readings do not determine, or which numbers cannot be.
pub fn identify_payload(readings: &[StaticReading], gravity: &Vector3<f64>) -> Result<PayloadEstimate, PayloadError> {
    for (i, reading) in readings.iter().enumerate() {
        let place = |source| PayloadError::Reading { reading: i + 1, source };
        check_wrench(&reading.wrench).map_err(place)?;
        check_finite("the orientation", &reading.orientation.coords).map_err(place)?;
    }
    let g = gravity.norm();
    if !(g.is_finite() && g > 0.0) {
        return Err(PayloadError::Gravity((*gravity).into()));
    }
    let pulls: Vec<Vector3<f64>> = readings.iter().map(|r| r.orientation.inverse() * gravity).collect();
    check_spread(&pulls, g)?;

    let rows = 3 * readings.len();
    let mut forces = (DMatrix::zeros(rows, 4), DVector::zeros(rows));
    let mut moments = (DMatrix::zeros(rows, 6), DVector::zeros(rows));
    for (i, (reading, pull)) in readings.iter().zip(&pulls).enumerate() {
        let at = 3 * i;
        forces.0.fixed_view_mut::<3, 1>(at, 0).copy_from(pull);
        forces.0.fixed_view_mut::<3, 3>(at, 1).copy_from(&Matrix3::identity());
        forces.1.fixed_rows_mut::<3>(at).copy_from(&reading.wrench.fixed_rows::<3>(0));
        moments.0.fixed_view_mut::<3, 3>(at, 0).copy_from(&-cross_matrix(pull));
        moments.0.fixed_view_mut::<3, 3>(at, 3).copy_from(&Matrix3::identity());
        moments.1.fixed_rows_mut::<3>(at).copy_from(&reading.wrench.fixed_rows::<3>(3));
    }
    let lost = PayloadError::OneOrientation { readings: readings.len(), spread: 0.0 };
    let force = fit(&forces.0, &forces.1).ok_or_else(|| lost.clone())?;
    let moment = fit(&moments.0, &moments.1).ok_or(lost)?;

    let (mass, deviation) = (force.x[0], force.deviation[0]);
    if mass < -SIGNIFICANT * deviation {
        return Err(PayloadError::PullsUp { mass });
    }
    if mass <= SIGNIFICANT * deviation {
        return Err(PayloadError::NoWeight { mass, deviation });
    }
    let center: Vector3<f64> = moment.x.fixed_rows::<3>(0) / mass;
    if center.norm() > FARTHEST_CENTER || mass > HEAVIEST {
        return Err(PayloadError::Units { mass, distance: center.norm() });
    }
    let both = |x: &DVector<f64>, y: &DVector<f64>| Wrench::new(x[1], x[2], x[3], y[3], y[4], y[5]);
    let misfit = |i: usize| {
        let of = |fit: &Fit, scale: f64| fit.residuals.fixed_rows::<3>(3 * i).norm() / scale.max(f64::MIN_POSITIVE);
        of(&force, force.sigma) + of(&moment, moment.sigma)
    };
    let worst = (0..readings.len()).max_by(|a, b| misfit(*a).total_cmp(&misfit(*b))).map_or(0, |i| i + 1);
    Ok(PayloadEstimate {
        payload: Payload { mass, center, bias: both(&force.x, &moment.x) },
        mass_deviation: deviation,
        center_deviation: moment.deviation.fixed_rows::<3>(0) / mass + center.abs() * (deviation / mass),
        bias_deviation: both(&force.deviation, &moment.deviation),
        residual: [force.sigma, moment.sigma],
        worst,
    })
}

/// Refuses directions of gravity that do not separate weight from bias.
fn check_spread(pulls: &[Vector3<f64>], g: f64) -> Result<(), PayloadError> {
    let readings = pulls.len();
    let mean = pulls.iter().sum::<Vector3<f64>>() / readings.max(1) as f64;
    let scatter: Matrix3<f64> = pulls.iter().map(|u| (u - mean) * (u - mean).transpose()).sum();
    let eigen = (scatter / readings.max(1) as f64).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let spread = |i: usize| eigen.eigenvalues[order[i]].max(0.0).sqrt() / g;
    if spread(0) < LEAST_SPREAD {
        return Err(PayloadError::OneOrientation { readings, spread: spread(0) });
    }
    if spread(1) < LEAST_SPREAD {
        let along: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
        return Err(PayloadError::OneDirection { readings, direction: along.into() });
    }
    Ok(())
}

/// A least-squares fit.
struct Fit {
    x: DVector<f64>,
    deviation: DVector<f64>,
    residuals: DVector<f64>,
    sigma: f64,
}

/// Least squares of full column rank; none where rounding has eaten the rank.
fn fit(design: &DMatrix<f64>, values: &DVector<f64>) -> Option<Fit> {
    let unknowns = design.ncols();
    let inverse = (design.transpose() * design).cholesky()?.inverse();
    let x = &inverse * design.transpose() * values;
    let residuals = values - design * &x;
    let sigma = (residuals.norm_squared() / (values.len() - unknowns).max(1) as f64).sqrt();
    let deviation = DVector::from_fn(unknowns, |i, _| sigma * inverse[(i, i)].sqrt());
    Some(Fit { x, deviation, residuals, sigma })
}
