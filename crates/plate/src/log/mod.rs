//! Logs of an object on the plate, and the plate motion in them.

mod logged_motion;
mod plate_log;

pub use logged_motion::{Jump, LoggedMotion};
pub use plate_log::{PlateColumns, PlateLog};
