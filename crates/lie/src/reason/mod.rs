//! What verdicts rest on, and why questions stay open.

mod contradiction;
mod feedback;
mod open;
mod stabilizable;
mod stlc;
mod text;
mod zero_dynamics;

pub use contradiction::Contradiction;
pub use feedback::{FlatnessReason, MinimumPhaseReason};
pub use open::{AtSwitch, BracketLimit, FamilyReason, Reason, SwitchingReason};
pub use stabilizable::StabilizableReason;
pub use stlc::{InputCombination, Monotone, StlcReason};
pub use zero_dynamics::NoZeroDynamics;
