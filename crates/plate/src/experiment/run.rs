//! An experiment run on an object.

use super::held_amplitude::HeldAmplitude;
use super::protocol::{Experiment, REACHED};
use crate::driven::Course;
use crate::driven::crossing;
use crate::{DrivenObject, ModelObject, PlateError};
use bracketry_sim::{Outcome, SimulationSettings, Trajectory};
use bracketry_system::System;

impl Experiment {
    /// Runs the experiment on a model in the form of differential equations from the state `x0`; see
    /// [`Experiment::run_on`].
    ///
    /// # Errors
    /// [`PlateError`] if the model does not fit.
    pub fn run(
        &self,
        system: &System,
        x0: &[f64],
        duration: f64,
        settings: &SimulationSettings,
    ) -> Result<Run, PlateError> {
        self.run_on(&mut ModelObject::new(system, six(x0)?, settings)?, duration)
    }

    /// Runs the experiment for `duration` seconds on any object, from the state and time at which it stands.
    ///
    /// The amplitude is read at the start of each period and held; [`AmplitudeStep`](super::AmplitudeStep) says what happens where it changes. An
    /// object that rests on the plate at the start is taken along by the rate that the motion begins with.
    ///
    /// # Errors
    /// [`PlateError`] if the experiment does not fit the object.
    pub fn run_on<P: DrivenObject>(&self, object: &mut P, duration: f64) -> Result<Run<P::Course>, PlateError> {
        self.run_until(object, duration, |_, _| false)
    }

    /// The same, ended at the end of a period after which `ends(t, state)` holds.
    ///
    /// # Errors
    /// [`PlateError`] if the experiment does not fit the object.
    pub fn run_until<P: DrivenObject>(
        &self,
        object: &mut P,
        duration: f64,
        mut ends: impl FnMut(f64, &[f64; 6]) -> bool,
    ) -> Result<Run<P::Course>, PlateError> {
        let mut held = HeldAmplitude::start(self, object)?;
        let (from, index) = (object.time(), self.index());
        let (mut trajectory, mut outcome) = object.record(from)?;
        let level = self.start + REACHED * (self.target - self.start);
        let direction = (self.target - self.start).signum();
        let (mut amplitudes, mut reached, mut least_load) = (Vec::new(), None, f64::INFINITY);
        let mut period = 0u32;
        while outcome.is_finished() && object.time() - from < duration {
            amplitudes.push((object.time(), held.update(object)?));
            period += 1;
            let end = from + (f64::from(period) * self.period).min(duration);
            let (piece, ended) = object.record(end)?;
            reached = reached.or_else(|| crossing(&piece, index, level, direction));
            least_load = least_load.min(held.least_load(&piece));
            trajectory.join(&piece);
            outcome = ended;
            if ends(object.time(), &object.state()) {
                break;
            }
        }
        Ok(Run { trajectory, outcome, amplitudes, reached, least_load, coordinate: index, target: self.target })
    }
}

/// The six states of an object.
pub(super) fn six(x: &[f64]) -> Result<[f64; 6], PlateError> {
    x.try_into()
        .map_err(|_| bracketry_sim::SimError::WrongLength { what: "the state", expected: 6, found: x.len() }.into())
}

/// What an experiment did.
#[derive(Debug, Clone)]
pub struct Run<C = Trajectory> {
    /// States at any time.
    pub trajectory: C,
    /// How the simulation ended.
    pub outcome: Outcome,
    /// Start and amplitude of each period.
    pub amplitudes: Vec<(f64, f64)>,
    /// First time at which 98 % of the distance was covered, in seconds.
    pub reached: Option<f64>,
    /// Least normal load per mass in m/s² met in the run, without thickness; see [`normal_load`](crate::model::normal_load). Where
    /// it is negative, the object lifts off in truth, whatever a model without flight says.
    pub least_load: f64,
    coordinate: usize,
    target: f64,
}

impl<C: Course> Run<C> {
    /// Index of the moved coordinate among the states.
    pub fn coordinate(&self) -> usize {
        self.coordinate
    }

    /// Error of the coordinate at the end, `q − q_desired`.
    pub fn final_error(&self) -> f64 {
        self.trajectory.state_at(self.trajectory.end())[self.coordinate] - self.target
    }

    /// Least and greatest value of the coordinate from `from` to the end, sampled every millisecond.
    pub fn range(&self, from: f64) -> (f64, f64) {
        let end = self.trajectory.end();
        let samples = ((end - from) / 1e-3).max(0.0).floor() as usize;
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..=samples {
            let q = self.trajectory.state_at(from + 1e-3 * i as f64)[self.coordinate];
            range = (range.0.min(q), range.1.max(q));
        }
        range
    }
}
