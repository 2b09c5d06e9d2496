//! Curves through or near samples, with their derivatives.

mod natural;
mod reinsch;
mod smoothing;

pub use natural::NaturalSpline;
pub use reinsch::{ReinschSpline, noise};
pub use smoothing::{Bandwidth, SmoothingSpline, smooth};
