//! What a run gives.

use bracketry_sim::StopReason;

use super::period_start::PeriodStart;
use crate::PlateKinematics;
use crate::area::AreaOutcome;
use crate::experiment::AmplitudeStep;
use crate::log::Jump;

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
    /// Gap between plate and object in meters.
    pub gap: f64,
    /// Tilt of the object against the plate about the plate's x axis, in radians.
    pub lean: f64,
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq)]
pub enum PlateStop {
    /// The normal force became negative, which equations of an object that lies on the plate cannot follow.
    NoLoad {
        /// By when, in s.
        t: f64,
    },
    /// Tipping or lift-off, which ends area contact.
    Departed(AreaOutcome),
    /// The object lies on its upper face.
    Overturned {
        /// When, in s.
        t: f64,
    },
    /// The free body took too many steps.
    StepLimit {
        /// When, in s.
        t: f64,
    },
    /// The numbers left the range of floating-point numbers.
    NotFinite {
        /// When, in s.
        t: f64,
    },
    /// The object changes between lying flat and tipping faster than can be followed.
    Rocking {
        /// When, in s.
        t: f64,
    },
    /// The integration of the equations stopped.
    Integration {
        /// When, in s.
        t: f64,
        /// Why.
        reason: StopReason,
    },
    /// The caller broke the run off.
    Canceled {
        /// When, in s.
        t: f64,
    },
}

/// What is assumed where the description of an experiment leaves a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assumption {
    /// The plate moves as in the log, smoothed by its own noise; where it jumps, the object stays in the world.
    LoggedMotion,
    /// The inputs swell with a time constant of 1 s from the start of the run.
    TimeConstant,
    /// The amplitude follows `e = q − q_desired`, read at the start of each period and held over it.
    HeldAmplitude,
    /// What happens where the amplitude changes.
    AmplitudeStep(AmplitudeStep),
    /// The object starts at rest on the plate.
    StartAtRest,
    /// The time to target is the first time at 98 % of the distance.
    TimeToTarget,
}

/// What one experiment did.
#[derive(Clone, Debug)]
pub struct PlateRun {
    /// Rows at equal times, the start included.
    pub rows: Vec<PlateRow>,
    /// The starts of the periods of an experiment with an amplitude law.
    pub starts: Vec<PeriodStart>,
    /// First time after the start at which 98 % of the distance was covered, in seconds.
    pub reached: Option<f64>,
    /// Why it ended early, if it did.
    pub stopped: Option<PlateStop>,
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
}

impl PlateRun {
    /// Mean share of the contact that sticks, over the rows in which it is known.
    pub fn stick_share(&self) -> f64 {
        let known = self.rows.iter().map(|r| r.stick_fraction).filter(|v| !v.is_nan());
        let (sum, count) = known.fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
        sum / count.max(1) as f64
    }

    /// Least normal force of the rows in N.
    pub fn least_normal_force(&self) -> f64 {
        self.rows.iter().map(|r| r.normal_force).fold(f64::INFINITY, f64::min)
    }

    /// Largest gap between plate and object in m.
    pub fn largest_gap(&self) -> f64 {
        self.rows.iter().map(|r| r.gap).fold(0.0, f64::max)
    }
}
