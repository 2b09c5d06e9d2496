//! Data in another unit or with another sign than they should have, as the springs of the joints tell.

use super::error::IdentificationError;
use super::measurement::{Measurement, MeasurementSet};
use super::parameters::links_alone;
use super::statistics::CHI_SQUARE_MEDIAN;
use crate::compliance::Springs;
use crate::error::StiffnessError;
use crate::robot::{Kinematics, Robot, Twist, Wrench};
use bracketry_numerics::statistics::median;
use nalgebra::{DMatrix, DVector};

/// Residual, in units of the noise, from which on a mistake is looked for.
const SUSPICIOUS: f64 = 1.5;
/// Share of the residual below which a change of the data has found it.
const EXPLAINED: f64 = 0.5;
/// Share of the measurements that a refit keeps, the best; and how many refits there are.
const TRUSTED: f64 = 0.7;
const REFITS: usize = 2;

/// A change of the data that may make sense of them.
struct Change {
    what: &'static str,
    remedy: &'static str,
    /// Factors of forces, moments, translations and rotations.
    factors: [f64; 4],
}

const AS_THEY_ARE: [f64; 4] = [1.0; 4];
const CHANGES: [Change; 5] = [
    Change {
        what: "the moments look like kN·m for N·m",
        remedy: "multiply Mx, My, Mz by 1000",
        factors: [1.0, 1000.0, 1.0, 1.0],
    },
    Change {
        what: "the rotations seem to have the opposite sign",
        remedy: "change the sign of rx, ry, rz: rotation vectors by the right-hand rule, from the unloaded to the loaded pose",
        factors: [1.0, 1.0, 1.0, -1.0],
    },
    Change {
        what: "the moments seem to have the opposite sign",
        remedy: "change the sign of Mx, My, Mz: the moment on the robot, by the right-hand rule",
        factors: [1.0, -1.0, 1.0, 1.0],
    },
    Change {
        what: "the forces seem to have the opposite sign",
        remedy: "change the sign of Fx, Fy, Fz: the force on the robot",
        factors: [-1.0, 1.0, 1.0, 1.0],
    },
    Change {
        what: "the translations seem to have the opposite sign",
        remedy: "change the sign of dx, dy, dz: from the unloaded to the loaded pose",
        factors: [1.0, 1.0, -1.0, 1.0],
    },
];

/// Refuses data that joint springs explain far better with another sign or unit of one of their parts.
pub(super) fn check_conventions(
    robot: &Robot,
    set: &MeasurementSet,
    start: &Springs,
) -> Result<(), IdentificationError> {
    let misfit = |factors: [f64; 4]| misfit(robot, set, start, factors);
    // What cannot be fitted at all is told by the fit itself.
    let Some(found) = misfit(AS_THEY_ARE).filter(|found| *found > SUSPICIOUS) else { return Ok(()) };
    let changed = CHANGES.iter().filter_map(|change| Some((change, misfit(change.factors)?)));
    match changed.min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((change, changed)) if changed < EXPLAINED * found => {
            Err(IdentificationError::Convention { what: change.what, remedy: change.remedy, found, changed })
        }
        _ => Ok(()),
    }
}

/// Middle residual, in units of the noise of displacements, of `ΔX = Σ_j c_j J_j J_jᵀ W` with c ≥ 0 fitted to the changed data; refitted to
/// the better part of them.
fn misfit(robot: &Robot, set: &MeasurementSet, start: &Springs, factors: [f64; 4]) -> Option<f64> {
    let joints = robot.joints.len();
    let rows: Vec<(DMatrix<f64>, DVector<f64>)> = set
        .measurements()
        .iter()
        .zip(set.noise())
        .map(|(m, noise)| {
            let (columns, rest) = regressor(robot, start, m, factors).ok()?;
            let whiten = noise.displacement.cholesky()?.l().try_inverse()?;
            let columns = DMatrix::from_column_slice(6, joints, (whiten * columns).as_slice());
            Some((columns, DVector::from_column_slice((whiten * rest).as_slice())))
        })
        .collect::<Option<_>>()?;
    let mut kept: Vec<usize> = (0..rows.len()).collect();
    let mut squared = Vec::new();
    for _ in 0..=REFITS {
        let mut normal = DMatrix::zeros(joints, joints);
        let mut right = DVector::zeros(joints);
        for (columns, rest) in kept.iter().map(|i| &rows[*i]) {
            normal += columns.tr_mul(columns);
            right += columns.tr_mul(rest);
        }
        // Joints that do not show stay rigid.
        let ridge = 1e-9 * normal.diagonal().max();
        (0..joints).for_each(|j| normal[(j, j)] += ridge);
        let compliances = normal.cholesky()?.solve(&right).map(|c| c.max(0.0));
        squared = rows.iter().map(|(columns, rest)| (rest - columns * &compliances).norm_squared()).collect();
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by(|a, b| squared[*a].total_cmp(&squared[*b]));
        order.truncate(((TRUSTED * rows.len() as f64).ceil() as usize).max(1));
        kept = order;
    }
    let middle = (median(squared).unwrap_or(0.0) / CHI_SQUARE_MEDIAN).sqrt();
    middle.is_finite().then_some(middle)
}

/// Displacement per compliance of each joint, and the displacement that links leave to the joints.
fn regressor(
    robot: &Robot,
    start: &Springs,
    m: &Measurement,
    [force, moment, translation, rotation]: [f64; 4],
) -> Result<(nalgebra::Matrix6xX<f64>, Twist), StiffnessError> {
    let scaled = |v: &nalgebra::Vector6<f64>, first: f64, last: f64| {
        Wrench::from_fn(|i, _| v[i] * if i < 3 { first } else { last })
    };
    let wrench = scaled(&m.wrench, force, moment);
    let kinematics = Kinematics::new(robot, &m.q)?;
    let mut columns = kinematics.jacobian().clone();
    for j in 0..robot.joints.len() {
        columns.column_mut(j).scale_mut(kinematics.torque(j, &wrench));
    }
    let links = links_alone(robot, start, &m.q, &wrench)?;
    Ok((columns, scaled(&m.displacement, translation, rotation) - links))
}
