//! An object with area contact.

use super::interface::DrivenObject;
use crate::PlateError;
use crate::area::{AreaContact, AreaOutcome, AreaRecord};
use crate::motion::{Drive, ExpressionMotion};
use bracketry_sim::{Outcome, StopReason};

/// A flat object with area contact on a plate whose motion is given by expressions.
#[derive(Debug, Clone)]
pub struct AreaObject {
    contact: AreaContact,
    motion: ExpressionMotion,
    outcome: AreaOutcome,
}

impl AreaObject {
    /// The object on a plate that stays still.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if the motion cannot be compiled.
    pub fn new(contact: AreaContact) -> Result<Self, PlateError> {
        Ok(Self { contact, motion: Drive::still().motion()?, outcome: AreaOutcome::Finished })
    }

    /// The object.
    pub fn contact(&self) -> &AreaContact {
        &self.contact
    }

    /// How the last recorded span ended, with the numbers of tipping or lift-off.
    pub fn area_outcome(&self) -> &AreaOutcome {
        &self.outcome
    }
}

impl DrivenObject for AreaObject {
    type Course = AreaRecord;

    fn time(&self) -> f64 {
        self.contact.time()
    }

    fn state(&self) -> [f64; 6] {
        self.contact.state()
    }

    fn set_state(&mut self, t: f64, state: [f64; 6]) -> Result<(), PlateError> {
        self.contact.set_time(t)?;
        self.contact.set_state(state)
    }

    fn drive(&mut self, drive: &Drive) -> Result<(), PlateError> {
        self.motion = drive.motion()?;
        Ok(())
    }

    fn set_number(&mut self, name: &str, value: f64) -> bool {
        self.motion.set(name, value)
    }

    /// As [`AreaContact::record`]. Tipping and lift-off stop the simulation with [`StopReason::Departed`].
    fn record(&mut self, t_end: f64) -> Result<(AreaRecord, Outcome), PlateError> {
        let (record, outcome) = self.contact.record(&mut self.motion, t_end)?;
        self.outcome = outcome;
        let stopped = |reason, t| Outcome::Stopped { reason, t, state: self.contact.state().to_vec() };
        let outcome = match outcome {
            AreaOutcome::Finished => Outcome::Finished,
            AreaOutcome::NotFinite { t } => stopped(StopReason::NonFinite, t),
            AreaOutcome::Tipping { t, .. } | AreaOutcome::LiftOff { t } => {
                stopped(StopReason::Departed { what: outcome.to_string() }, t)
            }
        };
        Ok((record, outcome))
    }
}
