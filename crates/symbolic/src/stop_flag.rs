//! A flag that ends long computations early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag between who asks for work and who does it. Clones share it.
///
/// [Raised](Self::raise), it ends the work at its next look at the flag, with an error or an outcome that says so. Told that
/// [memory runs out](Self::memory_runs_out), the work ends as at its time limit: what is undecided then is unknown.
///
/// ```
/// use bracketry_symbolic::StopFlag;
/// let flag = StopFlag::default();
/// let other = flag.clone();
/// other.raise();
/// assert!(flag.is_raised());
/// assert!(!flag.is_out_of_memory());
/// ```
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<Causes>);

#[derive(Debug, Default)]
struct Causes {
    raised: AtomicBool,
    out_of_memory: AtomicBool,
}

impl StopFlag {
    /// Asks the work to end.
    pub fn raise(&self) {
        self.0.raised.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to end.
    pub fn is_raised(&self) -> bool {
        self.0.raised.load(Ordering::Relaxed)
    }

    /// Tells the work that it may take no more memory. Who measures the memory is up to the program.
    pub fn memory_runs_out(&self) {
        self.0.out_of_memory.store(true, Ordering::Relaxed);
    }

    /// Whether the work may take no more memory.
    pub fn is_out_of_memory(&self) -> bool {
        self.0.out_of_memory.load(Ordering::Relaxed)
    }
}

/// Who may stop the work is no part of what the work is: settings that differ in their flags alone are equal.
impl PartialEq for StopFlag {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
