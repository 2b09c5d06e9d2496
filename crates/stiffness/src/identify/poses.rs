//! Which poses and loads tell the most.

use super::error::{IdentificationError, Place};
use super::measurement::MeasurementNoise;
use super::parameters::{logarithms, parameters, springs_at};
use super::uncertainty::Uncertainty;
use crate::compliance::{Deformation, Springs, loaded_compliance};
use crate::error::StiffnessError;
use crate::robot::{Kinematics, Robot, Wrench};
use bracketry_numerics::least_squares::central_differences;
use nalgebra::{DMatrix, DVector};

/// Step of the central differences; the parameters are logarithms.
const DIFFERENCE: f64 = 1e-5;

/// A choice from candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseChoice {
    /// The chosen candidates (from 0), ascending.
    pub chosen: Vec<usize>,
    /// Logarithm of the determinant of the information about the parameters' logarithms.
    pub log_determinant: f64,
    /// Standard deviation to expect of each parameter's logarithm, that is its relative error, joint by joint.
    pub log_std: Vec<f64>,
    /// Ratio of the largest to the smallest standard deviation of a combination of them.
    pub condition: f64,
}

/// Information that measurements at some poses and loads give about joint springs.
#[derive(Clone, Debug)]
pub struct PoseInformation {
    parameters: usize,
    each: Vec<DMatrix<f64>>,
}

impl PoseInformation {
    /// For springs expected near `springs`; a candidate is joint coordinates and a wrench at the tool point in base axes.
    ///
    /// # Errors
    /// [`IdentificationError`] for candidates or springs that do not fit the robot, or loads without equilibrium.
    pub fn new(
        robot: &Robot,
        springs: &Springs,
        candidates: &[(Vec<f64>, Wrench)],
        noise: &MeasurementNoise,
    ) -> Result<Self, IdentificationError> {
        springs.check(robot.joints.len())?;
        let point = logarithms(&parameters(springs)?);
        let each = candidates.iter().enumerate().map(|(candidate, (q, wrench))| {
            let kinematics = Kinematics::new(robot, q)?;
            let compliance = loaded_compliance(robot, springs, &kinematics, wrench)?;
            let covariance = noise.displacement + compliance * noise.wrench * compliance.transpose();
            let whiten = covariance.cholesky().ok_or(IdentificationError::Noise { what: "displacement" })?;
            let displacement = |p: &DVector<f64>| {
                let tool = Deformation::product(robot, &springs_at(springs, p), q, wrench)?.tool;
                Ok::<_, StiffnessError>(DVector::from_column_slice(tool.as_slice()))
            };
            let sensitivity = central_differences(displacement, &point, DIFFERENCE)?;
            let information = sensitivity.tr_mul(&whiten.solve(&sensitivity));
            match information.iter().find(|v| !v.is_finite()) {
                Some(v) => Err(IdentificationError::NotFinite {
                    row: Place::Row(candidate + 1),
                    column: "information".to_owned(),
                    value: *v,
                }),
                None => Ok(information),
            }
        });
        Ok(Self { parameters: point.len(), each: each.collect::<Result<_, IdentificationError>>()? })
    }

    /// What the given candidates (from 0) tell together; those that do not exist tell nothing.
    pub fn of(&self, candidates: &[usize]) -> PoseChoice {
        let information = self.sum(candidates);
        let known = Uncertainty::from(&information);
        let mut chosen = candidates.to_vec();
        chosen.sort_unstable();
        PoseChoice {
            chosen,
            log_determinant: log_determinant(&information),
            log_std: known.covariance.diagonal().iter().map(|v| v.sqrt()).collect(),
            condition: known.condition,
        }
    }

    /// `count` different candidates with the largest determinant of information (D-optimal), by greedy choice and exchange (Fedorov
    /// 1972) until no exchange gains.
    ///
    /// # Errors
    /// [`IdentificationError::TooFew`] for fewer candidates than that.
    pub fn choose(&self, count: usize) -> Result<PoseChoice, IdentificationError> {
        let found = self.each.len();
        if count == 0 || found < count {
            return Err(IdentificationError::TooFew { what: "the choice of poses", found, needed: count.max(1) });
        }
        let mut chosen: Vec<usize> = Vec::with_capacity(count);
        // A trace of information about everything makes the determinant of the first few tell something.
        let least = 1e-9 * self.each.iter().fold(0.0, |largest: f64, m| largest.max(m.amax()));
        let mut sum = DMatrix::identity(self.parameters, self.parameters) * least;
        for _ in 0..count {
            let Some((best, _)) = self.best(&sum, &chosen) else { break };
            sum += &self.each[best];
            chosen.push(best);
        }
        loop {
            let mut gained = false;
            for place in 0..chosen.len() {
                let without = &sum - &self.each[chosen[place]];
                let now = log_determinant(&sum);
                if let Some((best, value)) = self.best(&without, &chosen)
                    && value > now + 1e-9 * now.abs().max(1.0)
                {
                    chosen[place] = best;
                    sum = without + &self.each[best];
                    gained = true;
                }
            }
            if !gained {
                return Ok(self.of(&chosen));
            }
        }
    }

    /// The candidate not yet chosen that adds most.
    fn best(&self, sum: &DMatrix<f64>, chosen: &[usize]) -> Option<(usize, f64)> {
        let free = (0..self.each.len()).filter(|i| !chosen.contains(i));
        free.map(|i| (i, log_determinant(&(sum + &self.each[i])))).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn sum(&self, candidates: &[usize]) -> DMatrix<f64> {
        let size = self.parameters;
        let each = candidates.iter().filter_map(|i| self.each.get(*i));
        each.fold(DMatrix::zeros(size, size), |sum, m| sum + m)
    }
}

fn log_determinant(information: &DMatrix<f64>) -> f64 {
    match information.clone().cholesky() {
        Some(factor) => 2.0 * factor.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>(),
        None => f64::NEG_INFINITY,
    }
}
