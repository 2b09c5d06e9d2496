//! The amplitude that an experiment holds over each period.

use super::protocol::{AmplitudeStep, Experiment};
use crate::driven::Course;
use crate::driven::least_load;
use crate::motion::ExpressionMotion;
use crate::{DrivenObject, PlateError, PlateMotion};

/// The amplitude of an experiment on an object, from period to period.
pub(super) struct HeldAmplitude<'a> {
    experiment: &'a Experiment,
    index: usize,
    motion: ExpressionMotion,
    amplitude: Option<f64>,
}

impl<'a> HeldAmplitude<'a> {
    /// Starts the experiment's motion at the time of the object.
    pub(super) fn start<P: DrivenObject>(experiment: &'a Experiment, object: &mut P) -> Result<Self, PlateError> {
        if !(experiment.period.is_finite() && experiment.period > 0.0) {
            return Err(PlateError::BadNumber { name: "period", value: experiment.period });
        }
        let index = experiment.index();
        object.drive(&experiment.drive(object.time()))?;
        Ok(Self { experiment, index, motion: experiment.motion(object.time())?, amplitude: None })
    }

    /// Sets the amplitude for the period that begins now and returns it.
    pub(super) fn update<P: DrivenObject>(&mut self, object: &mut P) -> Result<f64, PlateError> {
        let (t, mut state) = (object.time(), object.state());
        let amplitude = self.experiment.amplitude(state[self.index] - self.experiment.target);
        let changed = self.amplitude.filter(|before| *before != amplitude);
        if let (AmplitudeStep::WorldFixed, Some(before)) = (self.experiment.step, changed) {
            self.motion.set("A", before);
            let old = self.motion.at(t);
            self.motion.set("A", amplitude);
            let new = self.motion.at(t);
            let jump = [old.displacement - new.displacement, old.velocity - new.velocity];
            if jump != [0.0; 2] {
                state[0] += jump[0];
                state[3] += jump[1];
                object.set_state(t, state)?;
            }
        }
        object.set_number("A", amplitude);
        self.motion.set("A", amplitude);
        self.amplitude = Some(amplitude);
        Ok(amplitude)
    }

    /// The least normal load over a course of this period.
    pub(super) fn least_load<C: Course>(&mut self, course: &C) -> f64 {
        least_load(course, &mut self.motion, 0.0)
    }
}
