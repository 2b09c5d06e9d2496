//! A flag that ends long computations early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag between who asks for work and who does it: once raised, the work ends at its next look at the flag, with an error or
/// an outcome that says so. Clones share the flag.
///
/// ```
/// use bracketry_symbolic::StopFlag;
/// let flag = StopFlag::default();
/// let other = flag.clone();
/// other.raise();
/// assert!(flag.is_raised());
/// ```
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Asks the work to end.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to end.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Who may stop the work is no part of what the work is: settings that differ in their flags alone are equal.
impl PartialEq for StopFlag {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
