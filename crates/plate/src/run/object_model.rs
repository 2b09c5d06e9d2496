//! The object on the plate, whichever model it follows.

use super::error::PlateRunError;
use super::imposed_motion::ImposedMotion;
use super::result::PlateStop;

/// How object and plate touch at one time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touch {
    /// Normal force per mass in m/s², where the model has one of its own; NaN where it is not known.
    pub(super) load: Option<f64>,
    /// Share of the contact that sticks.
    pub(super) stick_fraction: f64,
    /// Gap in meters.
    pub(super) gap: f64,
    /// Tilt against the plate about its x axis, in radians.
    pub(super) lean: f64,
}

/// An object on a moving plate.
pub(super) trait ObjectModel {
    fn time(&self) -> f64;
    /// `x, y, phi` and their rates.
    fn state(&self) -> [f64; 6];
    fn motion(&mut self) -> &mut ImposedMotion;
    /// Simulates to `t`; tells what stopped it before.
    fn advance(&mut self, t: f64) -> Result<Option<PlateStop>, PlateRunError>;
    /// Sets the amplitude of the experiment's formula.
    fn set_amplitude(&mut self, amplitude: f64);
    /// Takes the smooth piece of a logged motion that starts at `t`.
    fn start_piece(&mut self, t: f64) -> Result<(), PlateRunError>;
    /// Shifts the object along the plate's x axis and changes its rate.
    fn shift(&mut self, x: f64, vx: f64) -> Result<(), PlateRunError>;
    fn touch(&mut self) -> Touch;
    /// The same object as it is now, to go another way.
    fn fork(&self) -> Box<dyn ObjectModel>;
    /// Whether the object lies flat on the plate.
    fn flat(&self) -> bool {
        true
    }
    /// Number of events so far, where the model tells it.
    fn events(&self) -> Option<usize>;
    /// Error of the energy balance, where the model tells it.
    fn energy_closure(&self) -> Option<f64> {
        None
    }
}
