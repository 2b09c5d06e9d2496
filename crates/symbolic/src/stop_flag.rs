//! When long computations end early.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

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

/// When work is to end: at a time, or when a flag is raised or tells that memory runs out. By default never.
#[derive(Clone, Debug, Default)]
pub struct Limit {
    /// The time.
    pub deadline: Option<Instant>,
    /// The flag.
    pub stop: StopFlag,
}

impl Limit {
    /// So long from now.
    pub fn new(time_limit: Option<Duration>, stop: &StopFlag) -> Self {
        Self { deadline: time_limit.and_then(|limit| Instant::now().checked_add(limit)), stop: stop.clone() }
    }

    /// Why work is to end, if it is.
    pub fn reached(&self) -> Option<Reached> {
        if self.stop.is_raised() {
            return Some(Reached::Flag);
        }
        if self.stop.is_out_of_memory() {
            return Some(Reached::Memory);
        }
        self.deadline.is_some_and(|end| Instant::now() >= end).then_some(Reached::Time)
    }

    /// Whether work is to end.
    pub fn is_reached(&self) -> bool {
        self.reached().is_some()
    }
}

/// What ends work early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// The flag was raised.
    Flag,
    /// Memory runs out.
    Memory,
    /// The time has passed.
    Time,
}
