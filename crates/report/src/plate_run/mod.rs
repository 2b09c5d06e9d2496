//! One experiment on the vibrating plate, on one of the models of the object's contact.

mod area;
mod carried;
mod compare;
mod experiment;
mod figures;
mod log;
mod options;
mod report;
mod spline;

use std::ops::ControlFlow;
use std::time::Instant;

use bracketry_plate::{
    AmplitudeStep, Experiment, ExpressionMotion, Friction, Object, PlateError, PlateKinematics, PlateMotion, STATES,
    normal_load,
};
use bracketry_system::FileError;
use serde::Serialize;

use carried::{Carried, carried};
pub use compare::{Comparison, Deviation};
pub use experiment::PlateExperiment;
pub use figures::outline;
pub use log::{Jump, LoggedMotion, PlateLog};
pub use options::{PlateOptions, SetupError};
pub use report::PlateReport;

/// Share of the way to the target that counts as reached.
const REACHED: f64 = 0.98;
/// Most rows of a result.
const MAX_ROWS: f64 = 2e6;
/// Most steps of a run.
const MAX_STEPS: f64 = 2e7;
/// Longest time between rows, in seconds.
const MAX_SAMPLE: f64 = 0.02;
/// Longest step of area contact, in seconds.
const MAX_STEP: f64 = 0.01;
/// Times closer than this are the same, in seconds.
const SAME: f64 = 1e-10;

/// How object and plate touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlateModel {
    /// As published: per-axis friction, no yaw friction, no centrifugal and thickness terms.
    Published,
    /// First principles with the friction of one point of contact under the centre of mass.
    Point,
    /// The area contact reduced to an ordinary differential equation with yaw friction.
    Reduced,
    /// Friction over the whole footprint, under the pressure that the balance of moments asks for.
    Area,
    /// The same; what tips or lifts off goes on as a free rigid body.
    Body,
}

impl PlateModel {
    /// All models, as they are called in files and on the command line.
    pub const ALL: [(&'static str, Self); 5] = [
        ("published", Self::Published),
        ("point", Self::Point),
        ("reduced", Self::Reduced),
        ("area", Self::Area),
        ("body", Self::Body),
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, model)| *model == self).map_or("", |(name, _)| name)
    }
}

/// One experiment to be run on one model.
#[derive(Clone, Debug)]
pub struct PlateSetup {
    /// What the plate does and where the object should go.
    pub experiment: Experiment,
    /// How object and plate touch.
    pub model: PlateModel,
    /// The object.
    pub object: Object,
    /// The law of friction.
    pub friction: Friction,
    /// Where the object starts, at rest on the plate: x, y (m) and yaw (rad).
    pub start: [f64; 3],
    /// Time of the start in seconds; the inputs of the experiment begin there.
    pub from: f64,
    /// Duration in seconds.
    pub seconds: f64,
    /// Points of contact of the area model.
    pub points: usize,
    /// Time step of the models with time stepping, in seconds.
    pub dt: f64,
    /// Restitution of impacts of the body model.
    pub restitution: f64,
    /// Time between two rows of the result, in seconds.
    pub sample: f64,
}

/// Object and plate at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateRow {
    /// Time in seconds.
    pub t: f64,
    /// The plate.
    pub plate: PlateKinematics,
    /// `x, y, phi` and their rates.
    pub state: [f64; 6],
    /// Amplitude held in this period; 1 for experiments without amplitude law, not a number for a logged motion.
    pub amplitude: f64,
    /// Normal force in N; NaN where the body is free to tip and fly, and its model tells impulses only.
    pub normal_force: f64,
    /// Share of the contact that sticks, 0 to 1; NaN where the body is free to tip and fly.
    pub stick_fraction: f64,
    /// Gap between plate and object in metres.
    pub gap: f64,
    /// Tilt of the object against the plate about the plate's x axis, in radians.
    pub lean: f64,
}

/// What one experiment did.
#[derive(Clone, Debug)]
pub struct PlateRun {
    /// Rows at equal times, the start included.
    pub rows: Vec<PlateRow>,
    /// First time after the start at which 98 % of the way was covered, in seconds.
    pub reached: Option<f64>,
    /// Why it ended early, if it did.
    pub stopped: Option<String>,
    /// Whether the object lies flat on the plate at the end.
    pub flat: bool,
    /// Jumps of the plate that the object did not follow.
    pub jumps: Vec<Jump>,
    /// Changes between sticking and sliding and other events, where the model tells them.
    pub events: Option<usize>,
    /// Error of the energy balance relative to the energy that was exchanged, where the model tells it.
    pub energy_closure: Option<f64>,
    /// Time that the simulation took, in seconds.
    pub wall_seconds: f64,
    /// What was assumed where the experiment's description leaves a choice.
    pub assumptions: Vec<String>,
}

/// A run that could not begin.
#[derive(Debug, thiserror::Error)]
pub enum PlateRunError {
    /// The object, the friction or the model.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// The log.
    #[error(transparent)]
    File(#[from] FileError),
    /// The inputs.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// The simulation was misused.
    #[error(transparent)]
    Sim(#[from] bracketry_sim::SimError),
    /// The model does not know what was asked of it.
    #[error("the model `{model}` {cannot}; {remedy}")]
    Unsuited {
        /// The model.
        model: &'static str,
        /// What it cannot do.
        cannot: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// The log does not cover the time.
    #[error(
        "the log `{log}` has the plate's motion from {from} s to {to} s, the run needs it until {until} s; shorten --seconds"
    )]
    LogTooShort {
        /// The log.
        log: String,
        /// Its first time.
        from: f64,
        /// Its last time.
        to: f64,
        /// The end of the run.
        until: f64,
    },
    /// The log has no row within the run.
    #[error("{log}: the log has no time in common with the run; shift its column t or give --seconds")]
    NoCommonTime {
        /// The log.
        log: String,
    },
}

/// What moves the plate.
#[derive(Clone, Debug)]
pub(crate) enum Moving {
    /// The experiment's formula with live numbers.
    Formula(ExpressionMotion),
    /// A logged motion, and the time whose smooth piece holds.
    Logged(LoggedMotion, f64),
}

impl Moving {
    pub(crate) fn set_amplitude(&mut self, amplitude: f64) {
        if let Self::Formula(motion) = self {
            motion.set("A", amplitude);
        }
    }

    /// Takes the smooth piece that begins at `t`.
    pub(crate) fn begin_piece(&mut self, t: f64) {
        if let Self::Logged(_, piece) = self {
            *piece = t;
        }
    }
}

impl PlateMotion for Moving {
    fn at(&mut self, t: f64) -> PlateKinematics {
        match self {
            Self::Formula(motion) => motion.at(t),
            Self::Logged(motion, piece) => motion.within(*piece, t),
        }
    }
}

impl PlateSetup {
    /// End of the run, in seconds.
    pub fn end(&self) -> f64 {
        self.from + self.seconds
    }

    /// Index of the coordinate that the experiment moves.
    pub fn coordinate(&self) -> usize {
        STATES.iter().position(|name| *name == self.experiment.coordinate).unwrap_or(0)
    }

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
        let moving = match driven_by {
            None => Moving::Formula(self.experiment.motion(self.from)?),
            Some(log) => {
                let motion = log.motion()?;
                let (from, to) = motion.span();
                if self.from < from - SAME || self.end() > to + SAME {
                    return Err(PlateRunError::LogTooShort { log: log.name.clone(), from, to, until: self.end() });
                }
                Moving::Logged(motion, self.from)
            }
        };
        let mut object = carried(self, moving)?;
        let clock = Instant::now();
        let mut run = PlateRun {
            rows: Vec::new(),
            reached: None,
            stopped: None,
            flat: true,
            jumps: Vec::new(),
            events: None,
            energy_closure: None,
            wall_seconds: 0.0,
            assumptions: self.assumptions(driven_by.is_some()),
        };
        let mut schedule = Schedule::new(self, object.moving());
        let mut amplitude = f64::NAN;
        for k in 0.. {
            let sample = self.from + k as f64 * self.sample;
            let sample = if sample > self.end() - 1e-6 * self.sample { self.end() } else { sample };
            while schedule.next().is_some_and(|t| t <= sample + SAME) && run.stopped.is_none() {
                let t = schedule.take().unwrap_or(sample);
                run.stopped = object.advance(t)?;
                if run.stopped.is_none() {
                    self.renew(object.as_mut(), &mut amplitude, &mut run.jumps)?;
                }
            }
            if run.stopped.is_none() {
                run.stopped = object.advance(sample)?;
            }
            let row = self.row(object.as_mut(), amplitude);
            // Without a load there is no friction; equations of an object that lies on the plate end here.
            if run.stopped.is_none()
                && !matches!(self.model, PlateModel::Area | PlateModel::Body)
                && row.normal_force < 0.0
            {
                run.stopped = Some(format!(
                    "lift-off by t = {:.3} s: the normal force became negative, which this model cannot follow; take --model body",
                    row.t
                ));
            }
            run.rows.push(row);
            if k % 100 == 0 && watch(object.time()).is_break() && run.stopped.is_none() {
                run.stopped = Some(format!("broken off at t = {:.3} s", object.time()));
            }
            if run.stopped.is_some() || sample >= self.end() {
                break;
            }
        }
        run.wall_seconds = clock.elapsed().as_secs_f64();
        run.reached = self.reached(&run.rows);
        run.events = object.events();
        run.energy_closure = object.energy_closure();
        run.flat = object.flat();
        Ok(run)
    }

    /// What happens where a period or a smooth piece of a logged motion begins: the amplitude follows the error, and if
    /// the plate jumps the object stays where it is in the world.
    fn renew(&self, object: &mut dyn Carried, amplitude: &mut f64, jumps: &mut Vec<Jump>) -> Result<(), PlateRunError> {
        let t = object.time();
        let before = object.moving().at(t);
        match object.moving() {
            Moving::Formula(_) => {
                let error = object.state()[self.coordinate()] - self.experiment.target;
                let new = self.experiment.amplitude(error);
                let first = amplitude.is_nan();
                if new == *amplitude {
                    return Ok(());
                }
                *amplitude = new;
                object.set_amplitude(new);
                if first || self.experiment.step == AmplitudeStep::Smooth {
                    return Ok(());
                }
            }
            Moving::Logged(..) => object.begin_piece(t)?,
        }
        let after = object.moving().at(t);
        let jump = Jump {
            t,
            displacement: after.displacement - before.displacement,
            velocity: after.velocity - before.velocity,
        };
        if jump.displacement != 0.0 || jump.velocity != 0.0 {
            object.shift(-jump.displacement, -jump.velocity)?;
            jumps.push(jump);
        }
        Ok(())
    }

    fn row(&self, object: &mut dyn Carried, amplitude: f64) -> PlateRow {
        let (t, state) = (object.time(), object.state());
        let plate = object.moving().at(t);
        let touch = object.touch();
        let load = touch.load.unwrap_or_else(|| self.load(&plate, &state));
        PlateRow {
            t,
            plate,
            state,
            amplitude,
            normal_force: self.object.mass * load,
            stick_fraction: touch.stick_fraction,
            gap: touch.gap,
            lean: touch.lean,
        }
    }

    /// Normal force per mass that the model reckons with: `g cos θ + y θ''` as published, first principles otherwise.
    fn load(&self, plate: &PlateKinematics, state: &[f64; 6]) -> f64 {
        match self.model {
            PlateModel::Published => normal_load(state, &PlateKinematics { tilt_rate: 0.0, ..*plate }, 0.0),
            _ => normal_load(state, plate, self.object.height),
        }
    }

    /// First time at which 98 % of the way is covered, by straight lines between the rows.
    fn reached(&self, rows: &[PlateRow]) -> Option<f64> {
        let k = self.coordinate();
        let (start, target) = (self.start[k], self.experiment.target);
        let way = target - start;
        if way == 0.0 {
            return Some(0.0);
        }
        let covered = |row: &PlateRow| (row.state[k] - start) / way;
        let after = rows.iter().position(|row| covered(row) >= REACHED)?;
        let (low, high) = (covered(&rows[after.max(1) - 1]), covered(&rows[after]));
        let part = if high > low { (REACHED - low) / (high - low) } else { 1.0 };
        let before = rows[after.max(1) - 1].t;
        Some(before + part * (rows[after].t - before) - self.from)
    }

    fn assumptions(&self, logged: bool) -> Vec<String> {
        let mut said = Vec::new();
        if logged {
            said.push("the plate moves as in the log, smoothed by its own noise; where it jumps, the object stays in the world".to_owned());
        } else {
            said.push("tau = 1 s; the inputs begin with the run".to_owned());
            if self.experiment.law.is_some() {
                said.push(
                    "the amplitude follows e = q - q_desired, read at the start of each period and held over it"
                        .to_owned(),
                );
                said.push(match self.experiment.step {
                    AmplitudeStep::WorldFixed => {
                        "where the amplitude changes the plate jumps and the object stays in the world: x' and x lose the jump".to_owned()
                    }
                    AmplitudeStep::Smooth => {
                        "where the amplitude changes the plate goes on without the jump".to_owned()
                    }
                });
            }
        }
        said.push("the object starts at rest on the plate".to_owned());
        said.push("time to target: first time at 98 % of the way".to_owned());
        said
    }
}

/// The times at which periods or smooth pieces of the motion begin.
struct Schedule {
    from: f64,
    period: Option<f64>,
    count: usize,
    pieces: Vec<f64>,
}

impl Schedule {
    fn new(setup: &PlateSetup, moving: &Moving) -> Self {
        match moving {
            Moving::Formula(_) => {
                Self { from: setup.from, period: Some(setup.experiment.period), count: 0, pieces: Vec::new() }
            }
            Moving::Logged(motion, _) => {
                let mut pieces: Vec<f64> = motion.jumps().iter().map(|j| j.t).filter(|t| *t > setup.from).collect();
                pieces.reverse();
                Self { from: setup.from, period: None, count: 0, pieces }
            }
        }
    }

    fn next(&self) -> Option<f64> {
        match self.period {
            Some(period) => Some(self.from + self.count as f64 * period),
            None => self.pieces.last().copied(),
        }
    }

    fn take(&mut self) -> Option<f64> {
        let next = self.next();
        self.count += 1;
        self.pieces.pop();
        next
    }
}
