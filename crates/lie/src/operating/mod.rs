//! Operating points, and the linear system around one.

pub(crate) mod confirm;
mod elimination;
pub(crate) mod equations;
pub(crate) mod gains;
pub(crate) mod linear_model;
pub(crate) mod linearize;
mod location;
pub(crate) mod solver;
pub(crate) mod trim;
mod vanishing;

pub use gains::{Gain, Gramians, NoGain};
pub use linear_model::{LinearMatrix, LinearModel, NotLinearizable, Rest};
pub use linearize::{LinearAnalysis, LinearizeError, LinearizeOptions, Pole, Rank, linearize};
pub use trim::{Trim, TrimError, TrimNote, TrimOptions, TrimRole, TrimStatus, TrimValue, trim};
