//! Scenarios: ranges from which trials are drawn.

use super::criterion::Tolerance;
use crate::TrialError;
use bracketry_plate::control::PlateLimits;
use bracketry_plate::recording::{Random, seed_of};
use bracketry_plate::{Object, PlateError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Uniform ranges of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseRange {
    /// Least and greatest `x` in m.
    pub x: [f64; 2],
    /// Least and greatest `y` in m.
    pub y: [f64; 2],
    /// Least and greatest yaw in degrees.
    pub yaw_deg: [f64; 2],
}

impl PoseRange {
    fn draw(&self, random: &mut Random) -> [f64; 3] {
        [random.between(self.x), random.between(self.y), random.between(self.yaw_deg).to_radians()]
    }
}

/// Pushes at random times in random directions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushRange {
    /// How many.
    pub count: usize,
    /// Earliest and latest time in s.
    pub time: [f64; 2],
    /// Least and greatest speed given to the object in m/s.
    pub speed: [f64; 2],
    /// Least and greatest spin given to the object in rad/s, in either direction.
    pub spin: [f64; 2],
}

/// What trials are drawn from, and when they count as successful.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Where the object lies at first.
    pub start: PoseRange,
    /// Where it should go.
    pub target: PoseRange,
    /// Friction coefficient that the controller believes in.
    pub mu: f64,
    /// The plant's friction coefficient is `mu` times a number between these two.
    pub mu_factor: [f64; 2],
    /// Standard deviation of the measured position along each axis, in m.
    #[serde(default)]
    pub position_noise: f64,
    /// Standard deviation of the measured yaw in degrees.
    #[serde(default)]
    pub angle_noise_deg: f64,
    /// Samples from a measurement to the start of its command.
    #[serde(default)]
    pub delay: usize,
    /// Probability of a sample being lost.
    #[serde(default)]
    pub lost: f64,
    /// Disturbances.
    #[serde(default)]
    pub pushes: Option<PushRange>,
    /// Greatest error along x and y in m.
    pub position_tolerance: f64,
    /// Greatest error of the yaw in degrees.
    pub angle_tolerance_deg: f64,
    /// Longest time in s.
    pub duration: f64,
    /// Bounds of the plate's motion.
    #[serde(default)]
    pub limits: PlateLimits,
}

/// A velocity change at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// When, in s.
    pub t: f64,
    /// What is added to `vx, vy` (m/s) and `w` (rad/s).
    pub velocity: [f64; 3],
}

/// One trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Its number in the series.
    pub index: usize,
    /// Seed of its noise.
    pub seed: u64,
    /// Pose of the object at first, at rest: `x, y` (m), `phi` (rad).
    pub start: [f64; 3],
    /// Pose to be reached.
    pub target: [f64; 3],
    /// Friction coefficient that the controller believes in.
    pub model_mu: f64,
    /// Standard deviation of what the controller does not know of it, as a share of it.
    pub mu_deviation: f64,
    /// Friction coefficient of the plant.
    pub plant_mu: f64,
    /// Standard deviation of the measured position along each axis, in m.
    pub position_noise: f64,
    /// Standard deviation of the measured yaw in rad.
    pub angle_noise: f64,
    /// Samples from a measurement to the start of its command.
    pub delay: usize,
    /// Probability of a sample being lost.
    pub lost: f64,
    /// Disturbances in order of time.
    pub pushes: Vec<Push>,
}

impl Scenario {
    /// How close to the target is close enough.
    pub fn tolerance(&self) -> Tolerance {
        Tolerance { position: self.position_tolerance, angle: self.angle_tolerance_deg.to_radians() }
    }

    /// Trial number `index` of the series `seed`, which does not depend on any other.
    pub fn trial(&self, seed: u64, index: usize) -> Trial {
        let seed = seed_of(seed, index as u64);
        let mut random = Random::new(seed);
        let (start, target) = (self.start.draw(&mut random), self.target.draw(&mut random));
        let plant_mu = self.mu * random.between(self.mu_factor);
        let mut pushes = Vec::new();
        if let Some(range) = self.pushes {
            for _ in 0..range.count {
                let (t, speed, direction) =
                    (random.between(range.time), random.between(range.speed), random.between([0.0, TAU]));
                let spin = random.between(range.spin);
                let spin = if random.happens(0.5) { spin } else { -spin };
                pushes.push(Push { t, velocity: [speed * direction.cos(), speed * direction.sin(), spin] });
            }
            pushes.sort_by(|a, b| a.t.total_cmp(&b.t));
        }
        Trial {
            index,
            // The noise takes up a series of its own.
            seed: seed_of(seed, 0),
            start,
            target,
            model_mu: self.mu,
            // Of a uniform distribution.
            mu_deviation: (self.mu_factor[1] - self.mu_factor[0]) / 12f64.sqrt(),
            plant_mu,
            position_noise: self.position_noise,
            angle_noise: self.angle_noise_deg.to_radians(),
            delay: self.delay,
            lost: self.lost,
            pushes,
        }
    }

    /// The first `count` trials of the series `seed`.
    pub fn trials(&self, seed: u64, count: usize) -> Vec<Trial> {
        (0..count).map(|index| self.trial(seed, index)).collect()
    }

    /// Checks that ranges are in order and numbers have a meaning.
    ///
    /// # Errors
    /// [`TrialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), TrialError> {
        let mut ranges = vec![("mu_factor", self.mu_factor)];
        for (x, y, yaw, range) in [
            ("start.x", "start.y", "start.yaw_deg", self.start),
            ("target.x", "target.y", "target.yaw_deg", self.target),
        ] {
            ranges.extend([(x, range.x), (y, range.y), (yaw, range.yaw_deg)]);
        }
        if let Some(p) = self.pushes {
            ranges.extend([("pushes.time", p.time), ("pushes.speed", p.speed), ("pushes.spin", p.spin)]);
        }
        for (name, [low, high]) in ranges {
            if !(low.is_finite() && high.is_finite() && low <= high) {
                return Err(TrialError::BadRange { name, low, high });
            }
        }
        let positive = [
            ("mu", self.mu),
            ("mu_factor", self.mu_factor[0]),
            ("position_tolerance", self.position_tolerance),
            ("angle_tolerance_deg", self.angle_tolerance_deg),
            ("duration", self.duration),
        ];
        if let Some((name, value)) = positive.into_iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
            return Err(PlateError::BadNumber { name, value }.into());
        }
        let not_negative = [("position_noise", self.position_noise), ("angle_noise_deg", self.angle_noise_deg)];
        if let Some((name, value)) = not_negative.into_iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)) {
            return Err(PlateError::NegativeNumber { name, value }.into());
        }
        if !(0.0..=1.0).contains(&self.lost) {
            return Err(TrialError::BadRange { name: "lost", low: self.lost, high: 1.0 });
        }
        Ok(self.limits.validate()?)
    }
}

/// A file of scenarios and objects by name.
///
/// ```
/// use bracketry_trials::TrialFile;
/// let file = TrialFile::parse(include_str!("../../../../models/plate_trials.toml")).unwrap();
/// assert_eq!(file.cases["robust"].delay, 1);
/// assert!(file.objects.contains_key("ellipse"));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialFile {
    /// Objects that trials are run with.
    pub objects: BTreeMap<String, Object>,
    /// Scenarios.
    pub cases: BTreeMap<String, Scenario>,
}

impl TrialFile {
    /// Reads and checks the text of a file.
    ///
    /// # Errors
    /// [`TrialError::File`] with line and column for text that cannot be read; [`TrialError`] for numbers without meaning.
    pub fn parse(text: &str) -> Result<Self, TrialError> {
        let file: Self = toml::from_str(text).map_err(|error| TrialError::File(Box::new(error)))?;
        file.objects.values().try_for_each(Object::validate)?;
        file.cases.values().try_for_each(Scenario::validate)?;
        Ok(file)
    }
}
