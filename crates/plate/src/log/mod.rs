//! Logs of an object on the plate, and the plate motion in them.

mod logged_motion;
mod plate_log;
mod spline;

pub use logged_motion::{Jump, LoggedMotion};
pub use plate_log::{PlateColumns, PlateLog};
pub(crate) use spline::noise;
