//! Where the object is, how fast, and how strong friction is, from measured positions.
//!
//! Since the object starts from rest, its motion is known up to the friction coefficient and a small offset: one exact
//! simulation for each of several coefficients gives the motion as a function of it (a multiple-model estimator,
//! Magill 1965, with the coefficient continuous), and an extended Kalman filter estimates coefficient and offset.

use super::interface::Command;
use super::replay::Replay;
use super::settings::PoseSettings;
use crate::{Object, PlateError, PlateKinematics};
use nalgebra::{Matrix4, Vector4};

/// Coefficients on either side of the first belief.
const SIDE: usize = 4;
/// Distance between neighbors as a share of the first belief, when it is uncertain.
const SPACING: f64 = 0.09;
/// Growth of the offset's standard deviation in the first second of motion (a random walk): m and rad.
const DRIFT: [f64; 2] = [2e-3, 2e-2];
/// Growth of the coefficient's standard deviation in the first second of motion, as a share of the first belief.
const WANDER: f64 = 0.01;
/// Innovations beyond this many standard deviations are taken for a push or an outlier.
const GATE: f64 = 6.0;
/// Least standard deviation of a measurement: m and rad.
const LEAST_NOISE: [f64; 2] = [1e-6, 1e-5];

#[derive(Debug, Clone)]
pub(super) struct FrictionBank {
    /// Coefficients, equally spaced, and the object under each.
    coefficients: Vec<f64>,
    models: Vec<Replay>,
    /// Offset of the pose and position on the list of coefficients.
    estimate: Vector4<f64>,
    covariance: Matrix4<f64>,
    noise: [f64; 3],
    surprises: usize,
}

impl FrictionBank {
    /// The object at rest at a measured pose.
    pub(super) fn new(object: &Object, settings: &PoseSettings, pose: [f64; 3]) -> Result<Self, PlateError> {
        let side = if settings.mu_deviation > 0.0 { SIDE } else { 0 };
        let coefficients: Vec<f64> =
            (0..=2 * side).map(|j| settings.mu * (1.0 + SPACING * (j as f64 - side as f64))).collect();
        let models = coefficients.iter().map(|&mu| Replay::new(object, mu)).collect::<Result<Vec<_>, _>>()?;
        let [position, yaw] = [0, 1].map(|i| settings.noise[i].max(LEAST_NOISE[i]));
        let noise = [position, position, yaw];
        let deviation = settings.mu_deviation / SPACING;
        let mut covariance = Matrix4::zeros();
        for i in 0..3 {
            covariance[(i, i)] = noise[i] * noise[i];
        }
        covariance[(3, 3)] = deviation * deviation;
        let mut bank = Self {
            coefficients,
            models,
            estimate: Vector4::new(0.0, 0.0, 0.0, side as f64),
            covariance,
            noise,
            surprises: 0,
        };
        bank.place(pose)?;
        Ok(bank)
    }

    fn place(&mut self, [x, y, phi]: [f64; 3]) -> Result<(), PlateError> {
        self.models.iter_mut().try_for_each(|model| model.set_state([x, y, phi, 0.0, 0.0, 0.0]))
    }

    /// Begins anew from the estimated pose, at rest.
    pub(super) fn restart(&mut self) -> Result<(), PlateError> {
        let state = self.state();
        self.place([state[0], state[1], state[2]])?;
        for i in 0..3 {
            self.estimate[i] = 0.0;
            self.covariance[(i, 3)] = 0.0;
            self.covariance[(3, i)] = 0.0;
        }
        Ok(())
    }

    /// Believes the next measurements of the pose, whatever was estimated before.
    pub(super) fn forget_pose(&mut self) {
        for i in 0..3 {
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = (100.0 * DRIFT[i / 2]).powi(2);
        }
    }

    /// The friction coefficient.
    pub(super) fn mu(&self) -> f64 {
        let (j, part) = self.place_on_list();
        match self.coefficients.get(j + 1) {
            Some(next) => self.coefficients[j] + part * (next - self.coefficients[j]),
            None => self.coefficients[j],
        }
    }

    /// Index of the coefficient below, and the fraction of the step to the next.
    fn place_on_list(&self) -> (usize, f64) {
        let last = self.coefficients.len() - 1;
        let at = self.estimate[3].clamp(0.0, last as f64);
        let j = (at.floor() as usize).min(last.saturating_sub(1));
        (j, at - j as f64)
    }

    /// The state `x, y, phi, vx, vy, w`.
    pub(super) fn state(&self) -> [f64; 6] {
        let (j, part) = self.place_on_list();
        let below = self.models[j].state();
        let above = self.models.get(j + 1).map_or(below, Replay::state);
        std::array::from_fn(|i| {
            let between = below[i] + part * (above[i] - below[i]);
            if i < 3 { between + self.estimate[i] } else { between }
        })
    }

    /// Standard deviations of x, y and yaw.
    pub(super) fn deviation(&self) -> [f64; 3] {
        let (j, _) = self.place_on_list();
        let below = self.models[j].state();
        let slope = self.models.get(j + 1).map_or([0.0; 6], |m| {
            let above = m.state();
            std::array::from_fn(|i| above[i] - below[i])
        });
        std::array::from_fn(|i| {
            let mut row = Vector4::zeros();
            row[i] = 1.0;
            row[3] = slope[i];
            (row.transpose() * self.covariance * row)[(0, 0)].max(0.0).sqrt()
        })
    }

    /// Whether the object rests whatever the coefficient.
    pub(super) fn at_rest(&self) -> bool {
        self.models.iter().all(|model| model.state()[3..].iter().all(|v| *v == 0.0))
    }

    /// Moves on by a period of the plate's motion.
    pub(super) fn advance(&mut self, plate: &PlateKinematics, command: Command, period: f64) -> Result<(), PlateError> {
        for model in &mut self.models {
            model.advance(plate, command, period)?;
        }
        if !self.at_rest() {
            for i in 0..3 {
                self.covariance[(i, i)] += DRIFT[i / 2].powi(2) * period;
            }
            if self.coefficients.len() > 1 {
                self.covariance[(3, 3)] += (WANDER / SPACING).powi(2) * period;
            }
        }
        Ok(())
    }

    /// Takes in a measured pose; false if it has a number that is not finite, or does not fit at all.
    pub(super) fn update(&mut self, pose: &[f64; 3]) -> bool {
        if pose.iter().any(|v| !v.is_finite()) {
            return false;
        }
        let state = self.state();
        let (j, _) = self.place_on_list();
        let below = self.models[j].state();
        let above = self.models.get(j + 1).map_or(below, Replay::state);
        let rows: [Vector4<f64>; 3] = std::array::from_fn(|i| {
            let mut row = Vector4::zeros();
            row[i] = 1.0;
            row[3] = above[i] - below[i];
            row
        });
        let surprising = (0..3).any(|i| {
            let variance = (rows[i].transpose() * self.covariance * rows[i])[(0, 0)] + self.noise[i].powi(2);
            (pose[i] - state[i]).abs() > GATE * variance.sqrt() + 20.0 * LEAST_NOISE[i / 2]
        });
        if surprising {
            self.surprises += 1;
            if self.surprises < 3 {
                return false;
            }
            // Not an outlier: something has pushed the object, or the model is wrong.
            for i in 0..3 {
                self.covariance[(i, i)] += (10.0 * DRIFT[i / 2]).powi(2);
            }
        } else {
            self.surprises = 0;
        }
        let before = self.estimate;
        for i in 0..3 {
            let row = rows[i];
            let gain_of = self.covariance * row;
            let variance = (row.transpose() * gain_of)[(0, 0)] + self.noise[i].powi(2);
            let gain = gain_of / variance;
            let predicted = state[i] + row.dot(&(self.estimate - before));
            self.estimate += gain * (pose[i] - predicted);
            self.covariance -= gain * gain_of.transpose();
            self.covariance = 0.5 * (self.covariance + self.covariance.transpose());
        }
        let last = (self.coefficients.len() - 1) as f64;
        self.estimate[3] = self.estimate[3].clamp(0.0, last);
        true
    }
}
