//! Set-valued switches: their modes, the forces that hold what sticks, and which modes follow when some vanish together.

mod departure;
mod dependence;
mod elimination;
mod filippov;
mod forces;
mod modes;
mod relaxation;
mod resolution;
mod sharing;
mod surfaces;
mod zero_set;

pub use modes::{FrictionMode, ModeChange, ModeInterval};

pub(crate) use elimination::eliminate;
pub(crate) use filippov::{Field, Filippov};
pub(crate) use resolution::resolve;
pub(crate) use surfaces::{NEGLIGIBLE, Surfaces, divide, norm};
pub(crate) use zero_set::{SIMULTANEOUS, ZeroSet};
