//! Models and the data that none of them has seen.

use crate::study::{Fit, Window};

/// Models and the stretches on which they are tried.
pub(super) struct Trial {
    pub(super) as_given: Fit,
    pub(super) refitted: Fit,
    pub(super) extended: Fit,
    pub(super) held_out: Vec<Window>,
}
