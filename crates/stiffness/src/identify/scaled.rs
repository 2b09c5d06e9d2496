//! Measurements in coordinates in which forces and moments, translations and rotations can be compared.

use super::error::{IdentificationError, Place, Unloaded};
use super::measurement::MeasurementSet;
use nalgebra::{Matrix6, Vector6};

/// Largest difference of coordinates (rad, m) within one pose: it changes a compliance by as much in relation.
const ONE_POSE: f64 = 0.01;
/// Root mean square of a load, in standard deviations of its noise, below which it is none.
const LEAST_LOAD: f64 = 2.0;

/// A measurement with noise in scaled coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) wrench: Vector6<f64>,
    pub(super) displacement: Vector6<f64>,
    pub(super) wrench_noise: Matrix6<f64>,
    pub(super) displacement_noise: Matrix6<f64>,
}

impl Row {
    /// Covariance of `ΔX − C W`.
    pub(super) fn covariance(&self, compliance: &Matrix6<f64>) -> Matrix6<f64> {
        self.displacement_noise + compliance * self.wrench_noise * compliance.transpose()
    }

    /// Squared Mahalanobis distance of the displacement from the one predicted; infinite for a compliance that makes no sense.
    pub(super) fn distance(&self, compliance: &Matrix6<f64>) -> f64 {
        let residual = self.displacement - compliance * self.wrench;
        self.covariance(compliance).cholesky().map_or(f64::INFINITY, |v| residual.dot(&v.solve(&residual)))
    }
}

/// All measurements of one pose, displacements in units of their noise: `X̄ = L⁻¹ X`, `W̄ = Lᵀ W` with `L Lᵀ` their mean
/// covariance. Work stays what it is, hence `C = L C̄ Lᵀ` keeps symmetry and definiteness.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scaled {
    pub(super) rows: Vec<Row>,
    scale: Matrix6<f64>,
    inverse: Matrix6<f64>,
}

impl Scaled {
    /// Refuses too few measurements and several poses.
    pub(super) fn new(set: &MeasurementSet) -> Result<Self, IdentificationError> {
        let found = set.len();
        check_count(found)?;
        one_pose(set)?;
        let mean = set.noise().iter().fold(Matrix6::zeros(), |sum, n| sum + n.displacement) / found as f64;
        let noise = || IdentificationError::Noise { what: "displacement" };
        let scale = mean.cholesky().ok_or_else(noise)?.l();
        let inverse = scale.try_inverse().ok_or_else(noise)?;
        let rows = set.measurements().iter().zip(set.noise());
        let rows = rows.map(|(m, noise)| Row {
            wrench: scale.transpose() * m.wrench,
            displacement: inverse * m.displacement,
            wrench_noise: scale.transpose() * noise.wrench * scale,
            displacement_noise: inverse * noise.displacement * inverse.transpose(),
        });
        Ok(Self { rows: rows.collect(), scale, inverse })
    }

    /// A compliance in N, m, rad.
    pub(super) fn compliance(&self, scaled: &Matrix6<f64>) -> Matrix6<f64> {
        self.scale * scaled * self.scale.transpose()
    }

    /// A stiffness in N, m, rad.
    pub(super) fn stiffness(&self, scaled: &Matrix6<f64>) -> Matrix6<f64> {
        self.inverse.transpose() * scaled * self.inverse
    }

    /// `L`, and what scales stiffnesses: `L⁻ᵀ`.
    pub(super) fn factors(&self) -> (Matrix6<f64>, Matrix6<f64>) {
        (self.scale, self.inverse.transpose())
    }

    pub(super) fn subset(&self, indices: &[usize]) -> Vec<Row> {
        indices.iter().map(|i| self.rows[*i].clone()).collect()
    }
}

/// One measurement more than the six that a compliance needs.
pub(super) fn check_count(found: usize) -> Result<(), IdentificationError> {
    if found < 7 {
        Err(IdentificationError::TooFew { what: "a Cartesian stiffness", found, needed: 7 })
    } else {
        Ok(())
    }
}

fn one_pose(set: &MeasurementSet) -> Result<(), IdentificationError> {
    let Some(first) = set.measurements().first() else { return Ok(()) };
    for (i, m) in set.measurements().iter().enumerate() {
        let differences = m.q.iter().zip(&first.q).map(|(a, b)| (a - b).abs());
        if let Some((joint, by)) = differences.enumerate().find(|(_, by)| *by > ONE_POSE) {
            let (row, first) = (Place::Row(i + 1), Place::Row(1));
            return Err(IdentificationError::PosesDiffer { row, first, joint: joint + 1, by });
        }
    }
    Ok(())
}

/// Ratio of the largest to the smallest root mean square load over all directions, in units of its noise.
///
/// Refuses loads that leave out a direction, naming it.
pub(super) fn check_loads(rows: &[Row]) -> Result<f64, IdentificationError> {
    let mut second_moment = Matrix6::zeros();
    let mut mean = Matrix6::zeros();
    for row in rows {
        second_moment += row.wrench * row.wrench.transpose() / rows.len() as f64;
        mean += row.wrench_noise / rows.len() as f64;
    }
    let noise = || IdentificationError::Noise { what: "wrench" };
    let whiten = mean.cholesky().ok_or_else(noise)?.l().try_inverse().ok_or_else(noise)?;
    let eigen = (whiten * second_moment * whiten.transpose()).symmetric_eigen();
    let missing: Vec<Vector6<f64>> = (0..6)
        .filter(|k| eigen.eigenvalues[*k] < LEAST_LOAD * LEAST_LOAD)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .collect();
    if missing.is_empty() {
        return Ok((eigen.eigenvalues.max() / eigen.eigenvalues.min()).sqrt());
    }
    Err(IdentificationError::NotLoaded { directions: unloaded(&missing) })
}

/// A space of wrenches: the axes that lie in it, then what else there is.
fn unloaded(space: &[Vector6<f64>]) -> Vec<Unloaded> {
    let within = |axis: usize| space.iter().map(|v| v[axis] * v[axis]).sum::<f64>();
    let axes: Vec<usize> = (0..6).filter(|axis| within(*axis) > 0.9).collect();
    let mut directions: Vec<Unloaded> = axes.iter().copied().map(Unloaded::Axis).collect();
    for direction in space {
        let mut rest = *direction;
        for axis in &axes {
            rest[*axis] = 0.0;
        }
        if rest.norm() > 0.7 {
            let sign = if rest[rest.iamax()] < 0.0 { -1.0 } else { 1.0 };
            directions.push(Unloaded::Combination((sign * rest).into()));
        }
    }
    directions
}
