//! The object with contact over its whole footprint as the plant of a control loop.

use bracketry_mpc::{Plant, PlantError};
use bracketry_plate::{AreaContact, AreaOutcome, HiddenEffect, LogSettings, PlateError, PlateKinematics};

use crate::plate_move::RESOLUTION;

/// The plate with [`AreaContact`] under held accelerations: states x, y, phi, vx, vy, w, X, Xd, theta, thetad, inputs the
/// second derivatives of X and theta. It keeps the states of every millisecond.
///
/// Where the object tips or lifts off, what this plant knows ends: the object stays where it is on the moving plate, no more states
/// are kept, and [`AreaLoopPlant::stopped`] says why.
pub struct AreaLoopPlant {
    contact: AreaContact,
    effect: HiddenEffect,
    gravity: f64,
    states: Vec<[f64; 10]>,
    stopped: Option<AreaOutcome>,
}

impl AreaLoopPlant {
    /// The plant of these settings with an effect hidden in it.
    ///
    /// # Errors
    /// [`PlateError`] for settings without meaning.
    pub fn new(effect: HiddenEffect, settings: &LogSettings) -> Result<Self, PlateError> {
        let contact = effect.contact(settings)?;
        Ok(Self { contact, effect, gravity: settings.area.gravity, states: Vec::new(), stopped: None })
    }

    /// The states of every millisecond since the first step.
    pub fn states(&self) -> &[[f64; 10]] {
        &self.states
    }

    /// How contact ended, if it did.
    pub fn stopped(&self) -> Option<&AreaOutcome> {
        self.stopped.as_ref()
    }
}

impl Plant for AreaLoopPlant {
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        let (&[a, b, phi, va, vb, w, displacement, velocity, tilt, tilt_rate], &[acceleration, tilt_acceleration]) =
            (&*x, u)
        else {
            return Err("the plate has ten states and two inputs".into());
        };
        let begin = PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration };
        let end = begin.after(dt);
        x[6..].copy_from_slice(&[end.displacement, end.velocity, end.tilt, end.tilt_rate]);
        if self.stopped.is_some() {
            return Ok(());
        }
        self.contact.set_state([a, b, phi, va, vb, w])?;
        self.contact.set_time(t)?;
        if self.states.is_empty() {
            self.states.push([a, b, phi, va, vb, w, displacement, velocity, tilt, tilt_rate]);
        }
        let (effect, gravity) = (self.effect, self.gravity);
        let pieces = (dt / RESOLUTION).round().max(1.0);
        for piece in 1..=pieces as u32 {
            let after = dt * f64::from(piece) / pieces;
            let mut motion = |s: f64| effect.inclined(begin.after(s - t), gravity);
            let outcome = self.contact.advance(&mut motion, t + after)?;
            if !outcome.is_finished() {
                self.stopped = Some(outcome);
                x[..3].copy_from_slice(&self.contact.state()[..3]);
                x[3..6].fill(0.0);
                return Ok(());
            }
            let [a, b, phi, va, vb, w] = self.contact.state();
            let plate = begin.after(after);
            self.states.push([a, b, phi, va, vb, w, plate.displacement, plate.velocity, plate.tilt, plate.tilt_rate]);
        }
        x[..6].copy_from_slice(&self.contact.state());
        Ok(())
    }
}
