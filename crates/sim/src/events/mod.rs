//! Events: where they lie in a step, and the guard against too many of them.

mod guard;
mod locator;
mod search;

pub(crate) use guard::Guard;
pub(crate) use locator::{Locator, Scan, gap_at_end};
