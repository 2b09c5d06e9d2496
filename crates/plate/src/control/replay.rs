//! The object with exact friction on a plate that is moved by constant accelerations over each period.

use super::interface::Command;
use crate::area::{AreaContact, AreaSettings};
use crate::{Friction, Object, PlateError, PlateKinematics};

/// Time step of replays in s.
const STEP: f64 = 4e-3;
/// Contact points of replays.
const POINTS: usize = 16;

/// An object with set-valued friction, advanced from sample to sample.
#[derive(Debug, Clone)]
pub(super) struct Replay {
    contact: AreaContact,
    /// Whether contact has ended: from then on the object stays where it is.
    ended: bool,
}

impl Replay {
    /// The object at rest in the origin.
    pub(super) fn new(object: &Object, mu: f64) -> Result<Self, PlateError> {
        let settings = AreaSettings::default().with_step(STEP).with_points(POINTS);
        Ok(Self { contact: AreaContact::new(object, &Friction::Coulomb { mu }, &settings)?, ended: false })
    }

    /// Puts the object into a state.
    pub(super) fn set_state(&mut self, state: [f64; 6]) -> Result<(), PlateError> {
        self.ended = false;
        self.contact.set_state(state)
    }

    /// The state `x, y, phi, vx, vy, w`.
    pub(super) fn state(&self) -> [f64; 6] {
        self.contact.state()
    }

    /// Whether the object tipped or lifted off.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// Moves on by a period.
    pub(super) fn advance(&mut self, plate: &PlateKinematics, command: Command, period: f64) -> Result<(), PlateError> {
        if self.ended {
            return Ok(());
        }
        let start = self.contact.time();
        let plate = command.applied_to(plate);
        let mut motion = |t: f64| plate.after(t - start);
        let outcome = self.contact.advance(&mut motion, start + period)?;
        if !outcome.is_finished() {
            let [x, y, phi, ..] = self.contact.state();
            self.contact.set_state([x, y, phi, 0.0, 0.0, 0.0])?;
            self.ended = true;
        }
        Ok(())
    }
}
