//! The simulation of a setup.

use std::ops::ControlFlow;
use std::time::Instant;

use super::equations::Equations;
use super::error::PlateRunError;
use super::footprint_model::FootprintModel;
use super::imposed_motion::{ImposedMotion, Schedule};
use super::object_model::ObjectModel;
use super::result::{PlateRow, PlateRun, PlateStop};
use super::setup::{PlateModel, PlateSetup};
use crate::experiment::REACHED;
use crate::{
    AmplitudeStep, Friction, Jump, PlateKinematics, PlateLog, PlateMotion, Terms, first_principles, normal_load,
    published, reduced,
};

/// Times closer than this are the same, in seconds.
const SAME: f64 = 1e-10;
/// Rows between two calls of `watch`.
const WATCHED: usize = 100;

impl PlateSetup {
    /// Runs the experiment; with a log, on the plate motion of the log. `watch` is told the time now and then, and
    /// can break the run off.
    ///
    /// # Errors
    /// [`PlateRunError`] if something does not fit. What stops a run is an answer, not an error.
    pub fn run(
        &self,
        driven_by: Option<&PlateLog>,
        mut watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<PlateRun, PlateRunError> {
        let mut simulation = Simulation::new(self, driven_by)?;
        let clock = Instant::now();
        let mut rows = Vec::new();
        loop {
            let k = rows.len();
            let sample = self.from + k as f64 * self.sample;
            let sample = if sample > self.end() - 1e-6 * self.sample { self.end() } else { sample };
            let mut stopped = simulation.advance(sample)?;
            let row = simulation.row();
            // Without a load there is no friction; equations of an object that lies on the plate end here.
            let lies = !matches!(self.model, PlateModel::Area | PlateModel::Body);
            if stopped.is_none() && lies && row.normal_force < 0.0 {
                stopped = Some(PlateStop::NoLoad { t: row.t });
            }
            rows.push(row);
            let t = simulation.object.time();
            if k % WATCHED == 0 && watch(t).is_break() && stopped.is_none() {
                stopped = Some(PlateStop::Canceled { t });
            }
            if stopped.is_some() || sample >= self.end() {
                return Ok(simulation.into_run(rows, stopped, clock));
            }
        }
    }

    fn motion(&self, driven_by: Option<&PlateLog>) -> Result<ImposedMotion, PlateRunError> {
        let Some(log) = driven_by else {
            return Ok(ImposedMotion::Formula(self.experiment.motion(self.from)?));
        };
        let motion = log.motion()?;
        let (from, to) = motion.span();
        if self.from < from - SAME || self.end() > to + SAME {
            return Err(PlateRunError::LogTooShort { log: log.name.clone(), from, to, until: self.end() });
        }
        Ok(ImposedMotion::Logged(motion, self.from))
    }

    /// First time at which 98 % of the distance is covered, by straight lines between the rows.
    fn reached(&self, rows: &[PlateRow]) -> Option<f64> {
        let k = self.coordinate();
        let distance = self.experiment.target - self.start[k];
        if distance == 0.0 {
            return Some(0.0);
        }
        let covered = |row: &PlateRow| (row.state[k] - self.start[k]) / distance;
        let after = rows.iter().position(|row| covered(row) >= REACHED)?;
        let before = &rows[after.max(1) - 1];
        let (low, high) = (covered(before), covered(&rows[after]));
        let part = if high > low { (REACHED - low) / (high - low) } else { 1.0 };
        Some(before.t + part * (rows[after].t - before.t) - self.from)
    }
}

/// A run under way.
struct Simulation<'a> {
    setup: &'a PlateSetup,
    object: Box<dyn ObjectModel>,
    schedule: Schedule,
    amplitude: f64,
    jumps: Vec<Jump>,
}

impl<'a> Simulation<'a> {
    fn new(setup: &'a PlateSetup, driven_by: Option<&PlateLog>) -> Result<Self, PlateRunError> {
        let motion = setup.motion(driven_by)?;
        let schedule = Schedule::new(setup, &motion);
        let object = object_model(setup, motion)?;
        Ok(Self { setup, object, schedule, amplitude: f64::NAN, jumps: Vec::new() })
    }

    /// Simulates to `t`, by way of the periods or pieces that start until then.
    fn advance(&mut self, t: f64) -> Result<Option<PlateStop>, PlateRunError> {
        while let Some(start) = self.schedule.next_until(t + SAME) {
            if let Some(stopped) = self.object.advance(start)? {
                return Ok(Some(stopped));
            }
            self.start_period()?;
        }
        self.object.advance(t)
    }

    /// What happens where a period or a smooth piece of a logged motion starts: the amplitude follows the error, and if
    /// the plate jumps the object stays where it is in the world.
    fn start_period(&mut self) -> Result<(), PlateRunError> {
        let object = self.object.as_mut();
        let t = object.time();
        let before = object.motion().at(t);
        match object.motion() {
            ImposedMotion::Formula(_) => {
                let experiment = &self.setup.experiment;
                let new = experiment.amplitude(object.state()[self.setup.coordinate()] - experiment.target);
                let first = self.amplitude.is_nan();
                if new == self.amplitude {
                    return Ok(());
                }
                self.amplitude = new;
                object.set_amplitude(new);
                if first || experiment.step == AmplitudeStep::Smooth {
                    return Ok(());
                }
            }
            ImposedMotion::Logged(..) => object.start_piece(t)?,
        }
        let after = object.motion().at(t);
        let jump = Jump {
            t,
            displacement: after.displacement - before.displacement,
            velocity: after.velocity - before.velocity,
        };
        if jump.displacement != 0.0 || jump.velocity != 0.0 {
            object.shift(-jump.displacement, -jump.velocity)?;
            self.jumps.push(jump);
        }
        Ok(())
    }

    fn row(&mut self) -> PlateRow {
        let (t, state) = (self.object.time(), self.object.state());
        let plate = self.object.motion().at(t);
        let touch = self.object.touch();
        let load = touch.load.unwrap_or_else(|| self.load(&plate, &state));
        PlateRow {
            t,
            plate,
            state,
            amplitude: self.amplitude,
            normal_force: self.setup.object.mass * load,
            stick_fraction: touch.stick_fraction,
            gap: touch.gap,
            lean: touch.lean,
        }
    }

    /// Normal force per mass that the model has: `g cos θ + y θ''` as published, first principles otherwise.
    fn load(&self, plate: &PlateKinematics, state: &[f64; 6]) -> f64 {
        match self.setup.model {
            PlateModel::Published => normal_load(state, &PlateKinematics { tilt_rate: 0.0, ..*plate }, 0.0),
            _ => normal_load(state, plate, self.setup.object.height),
        }
    }

    fn into_run(self, rows: Vec<PlateRow>, stopped: Option<PlateStop>, clock: Instant) -> PlateRun {
        PlateRun {
            reached: self.setup.reached(&rows),
            rows,
            stopped,
            flat: self.object.flat(),
            jumps: self.jumps,
            events: self.object.events(),
            energy_closure: self.object.energy_closure(),
            wall_seconds: clock.elapsed().as_secs_f64(),
        }
    }
}

/// The object of a setup, at its start.
fn object_model(setup: &PlateSetup, motion: ImposedMotion) -> Result<Box<dyn ObjectModel>, PlateRunError> {
    setup.object.validate()?;
    setup.friction.validate()?;
    let coulomb = || match setup.friction {
        Friction::Coulomb { mu } => Ok(mu),
        _ => Err(PlateRunError::CoulombOnly { model: setup.model }),
    };
    let system = match setup.model {
        PlateModel::Area | PlateModel::Body => return Ok(Box::new(FootprintModel::new(setup, motion)?)),
        PlateModel::Published => published(&setup.object.shape, coulomb()?)?,
        PlateModel::Point => first_principles(&setup.object, &setup.friction, Terms::default())?,
        PlateModel::Reduced => reduced(&setup.object, coulomb()?, Terms::default())?,
    };
    Ok(Box::new(Equations::new(setup, system, motion)?))
}
