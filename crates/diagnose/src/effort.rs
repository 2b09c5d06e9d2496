//! What a diagnosis costs, in counts that are the same on every machine.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bracketry_sim::Statistics;
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

/// Counts the effort of all studies that share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counter(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    fits: AtomicU64,
    linearizations: AtomicU64,
    simulations: AtomicU64,
    steps: AtomicU64,
    rejected: AtomicU64,
    evaluations: AtomicU64,
}

/// Sums alone are read, so that no order matters.
fn add(count: &AtomicU64, more: usize) {
    count.fetch_add(more as u64, Ordering::Relaxed);
}

impl Counter {
    pub(crate) fn fit(&self) {
        add(&self.0.fits, 1);
    }

    pub(crate) fn linearization(&self) {
        add(&self.0.linearizations, 1);
    }

    /// A simulation, by the work of the integrator before and after it.
    pub(crate) fn simulation(&self, before: Statistics, after: Statistics) {
        add(&self.0.simulations, 1);
        add(&self.0.steps, after.steps - before.steps);
        add(&self.0.rejected, after.rejected - before.rejected);
        add(&self.0.evaluations, after.rhs - before.rhs);
    }

    /// What has been counted so far.
    pub(crate) fn effort(&self) -> Effort {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Effort {
            fits: of(&self.0.fits),
            linearizations: of(&self.0.linearizations),
            simulations: of(&self.0.simulations),
            steps: of(&self.0.steps),
            rejected: of(&self.0.rejected),
            evaluations: of(&self.0.evaluations),
        }
    }
}
