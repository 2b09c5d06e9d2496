//! The object with contact over its whole footprint as the plant of a control loop.

use bracketry_mpc::{Plant, PlantFailure};

use crate::PlateKinematics;
use crate::area::{AreaContact, AreaOutcome};

/// Resolution at which the states are kept (s).
pub const RESOLUTION: f64 = 1e-3;

/// The plate with [`AreaContact`] under held accelerations: states x, y, phi, vx, vy, w, X, Xd, theta, thetad, inputs the
/// second derivatives of X and theta. It keeps the states of every millisecond.
///
/// Where the object tips or lifts off, what this plant knows ends: the object stays where it is on the moving plate, no more states
/// are kept, and [`AreaLoopPlant::stopped`] says why.
pub struct AreaLoopPlant {
    contact: AreaContact,
    actual_motion: Box<dyn Fn(PlateKinematics) -> PlateKinematics + Send + Sync>,
    states: Vec<[f64; 10]>,
    stopped: Option<AreaOutcome>,
}

impl AreaLoopPlant {
    /// The plant of an object on a plate that moves as it is commanded.
    pub fn new(contact: AreaContact) -> Self {
        Self { contact, actual_motion: Box::new(|commanded| commanded), states: Vec::new(), stopped: None }
    }

    /// The same with a plate that moves otherwise than commanded: the motion that acts on the object, from the commanded one.
    #[must_use]
    pub fn with_actual_motion(
        mut self,
        actual: impl Fn(PlateKinematics) -> PlateKinematics + Send + Sync + 'static,
    ) -> Self {
        self.actual_motion = Box::new(actual);
        self
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
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        let (&[a, b, phi, va, vb, w, displacement, velocity, tilt, tilt_rate], &[acceleration, tilt_acceleration]) =
            (&*x, u)
        else {
            return Err("the plate has ten states and two inputs".into());
        };
        let start = PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration };
        let end = start.after(dt);
        x[6..].copy_from_slice(&[end.displacement, end.velocity, end.tilt, end.tilt_rate]);
        if self.stopped.is_some() {
            return Ok(());
        }
        self.contact.set_state([a, b, phi, va, vb, w])?;
        self.contact.set_time(t)?;
        if self.states.is_empty() {
            self.states.push([a, b, phi, va, vb, w, displacement, velocity, tilt, tilt_rate]);
        }
        let actual = &self.actual_motion;
        let pieces = (dt / RESOLUTION).round().max(1.0);
        for piece in 1..=pieces as u32 {
            let after = dt * f64::from(piece) / pieces;
            let mut motion = |s: f64| actual(start.after(s - t));
            let outcome = self.contact.advance(&mut motion, t + after)?;
            if !outcome.is_finished() {
                self.stopped = Some(outcome);
                x[..3].copy_from_slice(&self.contact.state()[..3]);
                x[3..6].fill(0.0);
                return Ok(());
            }
            let [a, b, phi, va, vb, w] = self.contact.state();
            let plate = start.after(after);
            self.states.push([a, b, phi, va, vb, w, plate.displacement, plate.velocity, plate.tilt, plate.tilt_rate]);
        }
        x[..6].copy_from_slice(&self.contact.state());
        Ok(())
    }
}
