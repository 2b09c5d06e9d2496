//! Robots, their measurements and a milled circle, as the tests set them up.

pub(crate) mod kr125;
pub(crate) mod measured;
pub(crate) mod milling;

pub(crate) use kr125::{STIFFNESS, kr125, pose};

use rand::SeedableRng;
use rand::rngs::StdRng;

pub(crate) fn rng(seed: u64) -> StdRng {
    StdRng::seed_from_u64(seed)
}
