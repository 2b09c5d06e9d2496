//! The problem on its grid: multiple shooting over an integrator.

mod merit;
mod multiple_shooting;
mod shooting;

pub(crate) use merit::Merit;
pub(crate) use multiple_shooting::{STABLE_STEP, Transcription};
pub use shooting::ShootingLinearization;
pub(crate) use shooting::{Shooter, carry_block, spread_flow};
