//! The simulation of a setup.

use std::ops::ControlFlow;
use std::time::Instant;

use super::equations::Equations;
use super::error::PlateRunError;
use super::footprint_model::FootprintModel;
use super::imposed_motion::{ImposedMotion, Schedule};
use super::log_signs::LogSigns;
use super::object_model::ObjectModel;
use super::period_start::{PeriodStart, SignSource};
use super::result::{PlateRow, PlateRun, PlateStop};
use super::setup::{PlateModel, PlateSetup};
use crate::experiment::REACHED;
use crate::experiment::{AmplitudeStep, Experiment};
use crate::log::Jump;
use crate::model::{Terms, normal_load};
use crate::{Friction, PlateKinematics, PlateLog, PlateMotion, first_principles, published, reduced};

/// Times closer than this are the same, in seconds.
const SAME: f64 = 1e-10;
/// Rows between two calls of `watch`.
const WATCHED: usize = 100;
/// Most times in a period at which two signs of the amplitude are compared with a log.
const COMPARED: usize = 50;
/// How many times nearer to the log the motion with one sign must be, in mean square, than that with the other.
const NEARER: f64 = 2.0;

impl PlateSetup {
    /// Runs the experiment; with a log, on the plate motion of the log. `watch` is told the time now and then, and
    /// can break the run off.
    ///
    /// # Errors
    /// [`PlateRunError`] if something does not fit. What stops a run is an answer, not an error.
    pub fn run(
        &self,
        driven_by: Option<&PlateLog>,
        watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<PlateRun, PlateRunError> {
        self.simulate(Simulation::new(self, driven_by, None)?, watch)
    }

    /// Runs the experiment with the signs of the amplitude that a log has, as far as they can be read from it.
    pub(super) fn run_with_signs(
        &self,
        signs: &LogSigns,
        watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<PlateRun, PlateRunError> {
        self.simulate(Simulation::new(self, None, Some(signs))?, watch)
    }

    fn simulate(
        &self,
        mut simulation: Simulation,
        mut watch: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<PlateRun, PlateRunError> {
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
    /// Where the signs of the amplitude are taken from, if not from the error of the run.
    signs: Option<&'a LogSigns<'a>>,
    amplitude: f64,
    starts: Vec<PeriodStart>,
    jumps: Vec<Jump>,
}

impl<'a> Simulation<'a> {
    fn new(
        setup: &'a PlateSetup,
        driven_by: Option<&PlateLog>,
        signs: Option<&'a LogSigns<'a>>,
    ) -> Result<Self, PlateRunError> {
        let motion = setup.motion(driven_by)?;
        let schedule = Schedule::new(setup, &motion);
        let object = object_model(setup, motion)?;
        Ok(Self { setup, object, schedule, signs, amplitude: f64::NAN, starts: Vec::new(), jumps: Vec::new() })
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
        let t = self.object.time();
        let jump = if matches!(self.object.motion(), ImposedMotion::Formula(_)) {
            let start = self.period_start(t)?;
            if self.setup.experiment.law.is_some() {
                self.starts.push(start);
            }
            let before = std::mem::replace(&mut self.amplitude, start.held);
            hold(self.object.as_mut(), &self.setup.experiment, before, start.held)?
        } else {
            let before = self.object.motion().at(t);
            self.object.start_piece(t)?;
            stay(self.object.as_mut(), &before)?
        };
        self.jumps.extend(jump);
        Ok(())
    }

    /// The error at `t`, where a period starts, and the amplitude that is held from there on.
    fn period_start(&self, t: f64) -> Result<PeriodStart, PlateRunError> {
        let experiment = &self.setup.experiment;
        let error = self.object.state()[self.setup.coordinate()] - experiment.target;
        let natural = experiment.amplitude(error);
        let own = PeriodStart { t, error, natural, held: natural, sign: SignSource::Run };
        let (Some(signs), Some(law)) = (self.signs, experiment.law) else { return Ok(own) };
        let size = if natural == 0.0 { law.offset.abs() } else { natural.abs() };
        let known = match signs.known(t)? {
            None => self.nearer_sign(signs, t, size)?.map(|sign| (sign, SignSource::LoggedMotion)),
            known => known,
        };
        Ok(known.map_or(own, |(sign, source)| PeriodStart { held: sign * size, sign: source, ..own }))
    }

    /// The sign of the amplitude with which the object moves like that of the log in the period that starts at `t`; none where
    /// neither is clearly nearer.
    fn nearer_sign(&self, signs: &LogSigns, t: f64, size: f64) -> Result<Option<f64>, PlateRunError> {
        let (Some(motion), Some(error)) = (signs.motion_after(t, COMPARED), signs.error(t)) else { return Ok(None) };
        let (k, experiment) = (self.setup.coordinate(), &self.setup.experiment);
        let (here, logged) = (self.object.state()[k], error.value + experiment.target);
        let mut squares = [0.0; 2];
        for (square, sign) in squares.iter_mut().zip([1.0, -1.0]) {
            let mut object = self.object.fork();
            hold(object.as_mut(), experiment, self.amplitude, sign * size)?;
            for (at, value) in &motion {
                if object.advance(*at)?.is_some() {
                    *square = f64::INFINITY;
                    break;
                }
                *square += ((object.state()[k] - here) - (value - logged)).powi(2);
            }
        }
        let [plus, minus] = squares;
        Ok(match () {
            () if NEARER * plus < minus => Some(1.0),
            () if NEARER * minus < plus => Some(-1.0),
            () => None,
        })
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
            starts: self.starts,
            stopped,
            flat: self.object.flat(),
            jumps: self.jumps,
            events: self.object.events(),
            energy_closure: self.object.energy_closure(),
            wall_seconds: clock.elapsed().as_secs_f64(),
        }
    }
}

/// Holds an amplitude from now on, after another one or none.
fn hold(
    object: &mut dyn ObjectModel,
    experiment: &Experiment,
    before: f64,
    amplitude: f64,
) -> Result<Option<Jump>, PlateRunError> {
    if amplitude == before {
        return Ok(None);
    }
    let t = object.time();
    let plate = object.motion().at(t);
    object.set_amplitude(amplitude);
    if before.is_nan() || experiment.step == AmplitudeStep::Smooth {
        return Ok(None);
    }
    stay(object, &plate)
}

/// Lets the object stay where it is in the world, if the plate has jumped from `before`.
fn stay(object: &mut dyn ObjectModel, before: &PlateKinematics) -> Result<Option<Jump>, PlateRunError> {
    let t = object.time();
    let after = object.motion().at(t);
    let jump =
        Jump { t, displacement: after.displacement - before.displacement, velocity: after.velocity - before.velocity };
    if jump.displacement == 0.0 && jump.velocity == 0.0 {
        return Ok(None);
    }
    object.shift(-jump.displacement, -jump.velocity)?;
    Ok(Some(jump))
}

/// The object of a setup, at its start.
fn object_model(setup: &PlateSetup, motion: ImposedMotion) -> Result<Box<dyn ObjectModel>, PlateRunError> {
    setup.object.validate()?;
    setup.friction.validate()?;
    if setup.model != PlateModel::Area && setup.object.stands_evenly().is_err() {
        return Err(PlateRunError::EvenBearingOnly { model: setup.model });
    }
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
