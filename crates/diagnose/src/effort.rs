//! What a diagnosis costs, in counts that are the same on every machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use bracketry_sim::Statistics;
use bracketry_symbolic::StopFlag;
use serde::Serialize;

/// What a diagnosis has cost, in counts that depend neither on the machine nor on how threads share the work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Exact fits of a model with effects.
    pub fits: u64,
    /// Linearized problems with candidates.
    pub linearizations: u64,
    /// Simulations of one window.
    pub simulations: u64,
    /// Steps of the integrator that were accepted.
    pub steps: u64,
    /// Steps that were rejected.
    pub rejected: u64,
    /// Evaluations of the equations by the integrator.
    pub evaluations: u64,
}

/// Counts the effort of all studies that share it, and knows when the search for causes is to end.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counter {
    counts: Arc<Counts>,
    deadline: Option<Instant>,
    end: StopFlag,
}

#[derive(Debug, Default)]
struct Counts {
    fits: AtomicU64,
    linearizations: AtomicU64,
    simulations: AtomicU64,
    steps: AtomicU64,
    rejected: AtomicU64,
    evaluations: AtomicU64,
    /// Fits that were not made, or not to their end, because the time was over.
    left_out: AtomicU64,
    /// Whether the search for causes has ended.
    ended: AtomicBool,
}

/// Sums alone are read, so that no order matters.
fn add(count: &AtomicU64, more: usize) {
    count.fetch_add(more as u64, Ordering::Relaxed);
}

impl Counter {
    /// With a time at which the search for causes ends, and a flag that ends it.
    pub(crate) fn until(deadline: Option<Instant>, end: StopFlag) -> Self {
        Self { deadline, end, ..Self::default() }
    }

    /// Whether the time of the search is over, or its flag is raised.
    pub(crate) fn is_over(&self) -> bool {
        self.end.is_raised() || self.deadline.is_some_and(|end| Instant::now() >= end)
    }

    /// Whether a fit is to end early: those that measure the gain of what was found are not.
    pub(crate) fn cuts_fits(&self) -> bool {
        !self.counts.ended.load(Ordering::Relaxed) && self.is_over()
    }

    /// A search begins, or it ends.
    pub(crate) fn set_ended(&self, ended: bool) {
        self.counts.ended.store(ended, Ordering::Relaxed);
    }

    /// Some fits were left out.
    pub(crate) fn leave_out(&self, fits: usize) {
        add(&self.counts.left_out, fits);
    }

    /// How many fits were left out.
    pub(crate) fn left_out(&self) -> u64 {
        self.counts.left_out.load(Ordering::Relaxed)
    }

    pub(crate) fn fit(&self) {
        add(&self.counts.fits, 1);
    }

    pub(crate) fn linearization(&self) {
        add(&self.counts.linearizations, 1);
    }

    /// A simulation, by the work of the integrator before and after it.
    pub(crate) fn simulation(&self, before: Statistics, after: Statistics) {
        add(&self.counts.simulations, 1);
        add(&self.counts.steps, after.steps - before.steps);
        add(&self.counts.rejected, after.rejected - before.rejected);
        add(&self.counts.evaluations, after.rhs - before.rhs);
    }

    /// What has been counted so far.
    pub(crate) fn effort(&self) -> Effort {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Effort {
            fits: of(&self.counts.fits),
            linearizations: of(&self.counts.linearizations),
            simulations: of(&self.counts.simulations),
            steps: of(&self.counts.steps),
            rejected: of(&self.counts.rejected),
            evaluations: of(&self.counts.evaluations),
        }
    }
}
