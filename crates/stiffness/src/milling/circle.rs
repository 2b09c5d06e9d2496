//! A milled circle, simulated: what the compensation is worth.

use super::cutting::{Cutting, Directions};
use super::cutting_robot::CuttingRobot;
use crate::compensate::{CompensationError, Compensator, Stability, Status, positive, stability};
use crate::compliance::{Springs, loaded_compliance};
use crate::robot::{Kinematics, Robot, Wrench, wrench_in};
use crate::sensor::{ForceSensor, Payload, PayloadError, PayloadEstimate, StaticReading, identify_payload};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

/// A circle that a robot mills in the plane across its tool, from the inside of the material.
///
/// The robot follows its command after a pure lag; its springs are in equilibrium with the cutting force at every sample
/// (no vibration), which depends on the depth of cut and thereby on where the tool really is.
#[derive(Clone, Debug, PartialEq)]
pub struct MillingCircle {
    /// Pose of the tool point at the center of the circle; its z axis points into the work.
    pub center: Isometry3<f64>,
    /// Radius (m).
    pub radius: f64,
    /// Speed along the circle (m/s).
    pub feed: f64,
    /// Angle that is milled before the circle counts (rad).
    pub run_in: f64,
    /// Control period (s).
    pub period: f64,
    /// Lag from command to motion (s), rounded to whole periods.
    pub lag: f64,
    /// The cutting force.
    pub cutting: Cutting,
    /// The force sensor.
    pub sensor: ForceSensor,
    /// What the sensor really carries, and its bias.
    pub payload: Payload,
    /// Gravity in base axes (m/s²).
    pub gravity: Vector3<f64>,
    /// Standard deviation of the sensor's noise per sample: force (N), moment (N·m).
    pub noise: [f64; 2],
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for MillingCircle {
    /// A circle of radius 35 mm milled at 30 mm/s in a horizontal plane by a robot of reach 2 m: 200 N away from the material, 300 N against
    /// the feed, the teeth's ripple 8 %; 4 ms, 12 ms of lag; a spindle of 12 kg on the sensor, whose bias is as large as a tenth of its load.
    fn default() -> Self {
        let down = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), PI);
        let cutting = Cutting {
            depth: 0.004,
            radial: 5.0e4,
            tangential: 7.5e4,
            axial: 1.5e4,
            ripple: 0.08,
            ripple_frequency: 97.0,
        };
        let pose = Isometry3::translation(0.0, 0.0, -0.25);
        let bias = Wrench::new(15.0, -22.0, 31.0, 1.5, -0.8, 0.4);
        Self {
            center: Isometry3::from_parts(Translation3::new(1.5, 0.0, 0.9), down),
            radius: 0.035,
            feed: 0.03,
            run_in: 0.8,
            period: 0.004,
            lag: 0.012,
            cutting,
            sensor: ForceSensor { pose, force_range: 2000.0, moment_range: 500.0 },
            payload: Payload { mass: 12.0, center: Vector3::new(0.01, -0.02, 0.12), bias },
            gravity: Vector3::new(0.0, 0.0, -9.81),
            noise: [2.0, 0.1],
            seed: 1,
        }
    }
}

/// A sample on the circle.
#[derive(Clone, Debug, PartialEq)]
pub struct CircleSample {
    /// Time since the circle counts (s).
    pub time: f64,
    /// Angle of the point that the tool is to be at (rad).
    pub angle: f64,
    /// That point: the reference, one lag ago (m, base axes).
    pub reference: Vector3<f64>,
    /// Where the tool point is.
    pub actual: Vector3<f64>,
    /// Distance from the center, in the plane, less the radius (m).
    pub radial_error: f64,
    /// Distance of the two points (m).
    pub point_error: f64,
    /// True wrench of the process at the tool point, in base axes.
    pub wrench: Wrench,
    /// What the sensor read, in its axes, with noise, weight and bias.
    pub reading: Wrench,
    /// Measured coordinates of the joints (rad).
    pub coordinates: Vec<f64>,
    /// Displacement of the tool point by the springs (m, base axes).
    pub displacement: Vector3<f64>,
    /// What the compensation said at this sample.
    pub status: Status,
}

/// Root mean square and largest magnitude of an error along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathError {
    /// Root mean square (m).
    pub rms: f64,
    /// Largest magnitude (m).
    pub max: f64,
}

impl PathError {
    fn of(errors: impl Iterator<Item = f64>) -> Self {
        let (mut count, mut squares, mut max) = (0usize, 0.0, 0.0f64);
        for error in errors {
            count += 1;
            squares += error * error;
            max = max.max(error.abs());
        }
        Self { rms: (squares / count.max(1) as f64).sqrt(), max }
    }

    /// The share by which the root mean square is less than that of `before`.
    pub fn reduction_from(&self, before: &Self) -> f64 {
        1.0 - self.rms / before.rms
    }
}

/// A milled circle.
#[derive(Clone, Debug, PartialEq)]
pub struct CircleRun {
    /// Samples of one turn.
    pub samples: Vec<CircleSample>,
}

impl CircleRun {
    /// Error of the radius.
    pub fn radial(&self) -> PathError {
        PathError::of(self.samples.iter().map(|s| s.radial_error))
    }

    /// Error from point to point.
    pub fn point(&self) -> PathError {
        PathError::of(self.samples.iter().map(|s| s.point_error))
    }

    /// Samples at which the compensation was limited or held.
    pub fn limited(&self) -> usize {
        self.samples.iter().filter(|s| !s.status.is_good()).count()
    }
}

impl MillingCircle {
    /// References of the joints (rad), one per period, by inverse kinematics from near `start`.
    ///
    /// # Errors
    /// [`CompensationError`] where the circle cannot be reached or its numbers make none.
    pub fn path(&self, robot: &Robot, start: &[f64]) -> Result<Vec<Vec<f64>>, CompensationError> {
        for (what, value) in [("the radius", self.radius), ("the feed", self.feed), ("the control period", self.period)]
        {
            positive(what, value)?;
        }
        self.cutting.check()?;
        let samples =
            ((self.run_in + TAU) * self.radius / (self.feed * self.period)).ceil() as usize + self.lag_periods();
        let mut path: Vec<Vec<f64>> = Vec::with_capacity(samples + 1);
        for k in 0..=samples {
            let near = path.last().map_or(start, Vec::as_slice);
            path.push(robot.inverse(&self.reference(self.angle(k)), near)?);
        }
        Ok(path)
    }

    /// The payload as readings at rest find it, each the mean of `count` samples, with the robot at the given coordinates.
    ///
    /// # Errors
    /// [`PayloadError`] as [`identify_payload`].
    pub fn weigh(&self, robot: &Robot, poses: &[Vec<f64>], count: usize) -> Result<PayloadEstimate, PayloadError> {
        let mut noise = Noise::new(self, self.seed.wrapping_add(1), 1.0 / (count.max(1) as f64).sqrt());
        let readings: Result<Vec<StaticReading>, PayloadError> = poses
            .iter()
            .enumerate()
            .map(|(i, q)| {
                let tool = robot.tool_pose(q).map_err(|source| PayloadError::Reading { reading: i + 1, source })?;
                let orientation = (tool * self.sensor.pose).rotation;
                let wrench = self.payload.reading(&orientation, &self.gravity) + noise.sample();
                Ok(StaticReading { orientation, wrench })
            })
            .collect();
        identify_payload(&readings?, &self.gravity)
    }

    /// Largest gains of the loop through the process along the circle, for a robot of `springs` and a compensation that
    /// believes in `modeled`.
    ///
    /// # Errors
    /// [`CompensationError`] for springs that do not fit the robot.
    pub fn stability(
        &self,
        robot: &Robot,
        path: &[Vec<f64>],
        springs: &Springs,
        modeled: &Springs,
    ) -> Result<Stability, CompensationError> {
        let mut worst = Stability::NONE;
        for (k, q) in path.iter().enumerate().step_by((path.len() / 72).max(1)) {
            let kinematics = Kinematics::new(robot, q)?;
            let at = self.directions(self.angle(k));
            let load = self.cutting.wrench(&at, self.cutting.depth, 0.0);
            let compliance = loaded_compliance(robot, springs, &kinematics, &load)?;
            let believed = loaded_compliance(robot, modeled, &kinematics, &load)?;
            worst = worst.worse(stability(&self.cutting.stiffness(&at), &compliance, &believed)?);
        }
        Ok(worst)
    }

    /// Mills the circle along `path` with a robot whose true springs are `springs`; without a compensator as it is.
    ///
    /// # Errors
    /// [`CompensationError`] for a path or springs that do not fit, or a process that pulls the tool in without end.
    pub fn mill(
        &self,
        robot: &Robot,
        path: &[Vec<f64>],
        springs: &Springs,
        mut compensator: Option<Compensator>,
    ) -> Result<CircleRun, CompensationError> {
        let joints = robot.joints.len();
        springs.check(joints)?;
        for q in path {
            robot.check("coordinates", q)?;
        }
        let lag = self.lag_periods();
        let mut noise = Noise::new(self, self.seed, 1.0);
        let mut milling = CuttingRobot::new(robot, springs);
        let mut commands: Vec<Vec<f64>> = Vec::with_capacity(path.len());
        let mut run = CircleRun { samples: Vec::new() };
        for k in 0..path.len() {
            let sent = k.checked_sub(lag);
            let moved = sent.map_or(&path[0], |at| &commands[at]);
            let angle = self.angle(sent.unwrap_or(0));
            let time = k as f64 * self.period;
            let at = self.directions(angle);
            let outside = |point: &Vector3<f64>| self.distance(point) - self.radius;
            let wrench = milling.cut(&self.cutting, &at, moved, time, outside)?;
            let wrench = wrench.ok_or(CompensationError::NoDepth { angle })?;
            let coordinates = moved.clone();
            let tool = milling.tool();
            let reading = self.reading(&tool, &wrench) + noise.sample();
            let (command, status) = match &mut compensator {
                None => (path[k].clone(), Status::default()),
                Some(compensator) => {
                    let corrected = compensator.step(&coordinates, &reading, &path[k]);
                    (corrected.reference.to_vec(), corrected.status)
                }
            };
            commands.push(command);
            if angle >= 0.0 && sent.is_some() {
                let actual = tool.translation.vector;
                let unloaded = robot.tool_pose(&coordinates)?.translation.vector;
                let reference = self.reference(angle).translation.vector;
                run.samples.push(CircleSample {
                    time: angle * self.radius / self.feed,
                    angle,
                    reference,
                    actual,
                    radial_error: self.distance(&actual) - self.radius,
                    point_error: (actual - reference).norm(),
                    wrench,
                    reading,
                    displacement: actual - unloaded,
                    coordinates,
                    status,
                });
            }
        }
        Ok(run)
    }

    fn lag_periods(&self) -> usize {
        (self.lag / self.period).round().max(0.0) as usize
    }

    fn angle(&self, k: usize) -> f64 {
        k as f64 * self.period * self.feed / self.radius - self.run_in
    }

    fn directions(&self, angle: f64) -> Directions {
        let axes = self.center.rotation;
        Directions {
            outwards: axes * Vector3::new(angle.cos(), angle.sin(), 0.0),
            feed: axes * Vector3::new(-angle.sin(), angle.cos(), 0.0),
            tool: axes * Vector3::z(),
        }
    }

    fn reference(&self, angle: f64) -> Isometry3<f64> {
        let point = self.center.translation.vector + self.radius * self.directions(angle).outwards;
        Isometry3::from_parts(point.into(), self.center.rotation)
    }

    /// Distance from the center in the plane of the circle.
    fn distance(&self, point: &Vector3<f64>) -> f64 {
        let local = self.center.rotation.inverse() * (point - self.center.translation.vector);
        local.x.hypot(local.y)
    }

    /// What the sensor reads without noise.
    fn reading(&self, tool: &Isometry3<f64>, wrench: &Wrench) -> Wrench {
        let sensor = tool * self.sensor.pose;
        wrench_in(&sensor, &tool.translation.vector, wrench) + self.payload.reading(&sensor.rotation, &self.gravity)
    }
}

/// Noise of a force sensor.
struct Noise {
    random: StdRng,
    deviation: [f64; 2],
}

impl Noise {
    fn new(circle: &MillingCircle, seed: u64, scale: f64) -> Self {
        Self { random: StdRng::seed_from_u64(seed), deviation: circle.noise.map(|n| n * scale) }
    }

    fn sample(&mut self) -> Wrench {
        Wrench::from_fn(|i, _| {
            let z: f64 = StandardNormal.sample(&mut self.random);
            z * self.deviation[i / 3]
        })
    }
}
