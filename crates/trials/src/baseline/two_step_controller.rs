//! The published two-step method as a feedback controller.

use super::halt::{Pipeline, halt};
use crate::{Tolerance, Trial, TrialSetup, pose_error};
use bracketry_plate::control::{Command, Measurement, PlateController};
use bracketry_plate::experiment::Experiment;
use bracketry_plate::motion::ExpressionMotion;
use bracketry_plate::{GRAVITY, PlateError, PlateMotion};

/// Sampling period in s.
const PERIOD: f64 = 5e-3;
/// Longest stage in s.
const STAGE_LIMIT: f64 = 30.0;
/// Samples at rest over which the pose is averaged.
const LOOK: usize = 30;
/// Share of the tolerance within which a coordinate is left alone.
const MARGIN: f64 = 0.6;
/// Share of the friction that the plate's motion makes use of while it comes to rest.
const GENTLE: f64 = 0.4;
/// Tilt acceleration in rad/s² while the plate comes to rest.
const TILT_HALT: f64 = 50.0;
/// Largest amplitude of the tilt in rad: that of the published experiment, 26°.
const TILT_LIMIT: f64 = 26.0 * std::f64::consts::PI / 180.0;

/// The published inputs one after the other, the orientation first, then x, then y, from any start to any target.
///
/// Each stage moves its coordinate by the inputs of its experiment ([`Experiment`]) with the sign that moves it toward the
/// target, the amplitude held over each period, and ends as soon as the coordinate is seen to cross its target. The plate then
/// comes to rest gently, the pose is averaged, and the next coordinate that is out of tolerance has its turn. As a stage moves
/// the other coordinates as well, stages are repeated until all are within their tolerance. The amplitude of the tilt is kept
/// to that of the published experiment; the bounds of the plate's motion are not otherwise heeded.
#[derive(Debug, Clone)]
pub struct TwoStepController {
    target: [f64; 3],
    tolerance: Tolerance,
    /// Gentle accelerations: of the displacement in m/s², of the tilt in rad/s².
    gentle: [f64; 2],
    pipeline: Pipeline,
    phase: Phase,
    /// The last pose that was seen, for samples that are lost.
    seen: [f64; 3],
    /// Coordinate of the last stage.
    last: usize,
}

#[derive(Debug, Clone)]
enum Phase {
    /// Moves a coordinate.
    Stage(Box<Stage>),
    /// Comes to rest and looks.
    Rest { looked: usize, sum: [f64; 3] },
    /// Nothing is left to do.
    Finished,
}

#[derive(Debug, Clone)]
struct Stage {
    experiment: Experiment,
    index: usize,
    motion: ExpressionMotion,
    /// Number of the sample in this stage.
    sample: u32,
    /// Number of the period.
    period: u32,
    /// Sign of the error at its start.
    side: f64,
}

impl TwoStepController {
    /// The controller of a trial; it knows the friction of the model, not that of the plant.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for a friction coefficient that is not positive.
    pub fn new(trial: &Trial, setup: &TrialSetup) -> Result<Self, PlateError> {
        let mu = trial.model_mu;
        if !(mu.is_finite() && mu > 0.0) {
            return Err(PlateError::BadNumber { name: "mu", value: mu });
        }
        Ok(Self {
            target: trial.target,
            tolerance: setup.tolerance,
            gentle: [GENTLE * mu * GRAVITY, TILT_HALT],
            pipeline: Pipeline::new(trial.delay, PERIOD),
            phase: Phase::Rest { looked: 0, sum: [0.0; 3] },
            seen: trial.target,
            last: 1,
        })
    }

    /// Whether the coordinate may be left alone.
    fn close(&self, index: usize, error: f64) -> bool {
        let tolerance = if index == 2 { self.tolerance.angle } else { self.tolerance.position };
        error.abs() <= MARGIN * tolerance
    }

    /// The next coordinate in the order yaw, x, y that is not close, beginning after the last one.
    fn next(&self, error: [f64; 3]) -> Result<Phase, PlateError> {
        let order = (1..=3).map(|step| (self.last + step) % 3);
        let Some(index) = order.into_iter().find(|&index| !self.close(index, error[index])) else {
            return Ok(Phase::Finished);
        };
        let mut experiment = match index {
            0 => Experiment::translation_x(3),
            1 => Experiment::translation_y(),
            _ => Experiment::orientation(),
        };
        // Experiment 1 turns from x toward y.
        if index == 2 && error[2] > 0.0 {
            experiment = experiment.with_reversed_tilt();
        }
        let motion = experiment.motion(0.0)?;
        let side = error[index].signum();
        Ok(Phase::Stage(Box::new(Stage { experiment, index, motion, sample: 0, period: 0, side })))
    }
}

impl Stage {
    /// The command of the next sample; absent when the stage is over.
    fn command(&mut self, error: f64, tilt: [f64; 2]) -> Option<Command> {
        let t = PERIOD * f64::from(self.sample);
        if error * self.side <= 0.0 || t > STAGE_LIMIT {
            return None;
        }
        let period = (t / self.experiment.period + 1e-9) as u32;
        if self.sample == 0 || period != self.period {
            let amplitude = self.experiment.amplitude(error);
            self.motion.set("A", if self.index == 1 { amplitude.clamp(-TILT_LIMIT, TILT_LIMIT) } else { amplitude });
            self.period = period;
        }
        self.sample += 1;
        let (now, next) = (self.motion.at(t), self.motion.at(t + PERIOD));
        // The displacement follows in its rate alone: where the amplitude changes it would jump. The tilt follows itself.
        let ahead = tilt[0] + 0.5 * PERIOD * (tilt[1] + next.tilt_rate);
        Some(Command {
            displacement_acceleration: (next.velocity - now.velocity) / PERIOD,
            tilt_acceleration: (next.tilt_rate + (next.tilt - ahead) - tilt[1]) / PERIOD,
        })
    }
}

impl PlateController for TwoStepController {
    fn period(&self) -> f64 {
        PERIOD
    }

    fn command(&mut self, measurement: &Measurement) -> Result<Command, PlateError> {
        let fresh = measurement.object.iter().all(|q| q.is_finite());
        if fresh {
            self.seen = measurement.object;
        }
        let error = pose_error(self.seen, self.target);
        let plate = self.pipeline.predict(&measurement.plate);
        if let Phase::Stage(stage) = &mut self.phase {
            if let Some(command) = stage.command(error[stage.index], [plate.tilt, plate.tilt_rate]) {
                return Ok(self.pipeline.send(command));
            }
            self.last = stage.index;
            self.phase = Phase::Rest { looked: 0, sum: [0.0; 3] };
        }
        let rests = |value: f64| value.abs() < 1e-9;
        let still = rests(plate.velocity) && rests(plate.tilt_rate) && rests(plate.tilt) && rests(plate.displacement);
        if let Phase::Rest { looked, sum } = &mut self.phase
            && still
            && fresh
        {
            *looked += 1;
            (0..3).for_each(|i| sum[i] += error[i]);
            // The first half lets the object come to rest.
            if *looked == LOOK {
                *sum = [0.0; 3];
            }
            if *looked == 2 * LOOK {
                let mean = sum.map(|s| s / LOOK as f64);
                self.phase = self.next(mean)?;
            }
        }
        let command = Command {
            displacement_acceleration: halt(plate.displacement, plate.velocity, PERIOD, self.gentle[0]),
            tilt_acceleration: halt(plate.tilt, plate.tilt_rate, PERIOD, self.gentle[1]),
        };
        Ok(self.pipeline.send(command))
    }

    fn finished(&self) -> bool {
        matches!(self.phase, Phase::Finished)
    }
}
