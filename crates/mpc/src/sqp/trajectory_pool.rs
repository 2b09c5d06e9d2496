//! Memory of trajectories and logs that are no longer needed, for those that follow: a sample allocates nothing.

use super::solution::{Iteration, Solution};
use crate::trajectory::PlannedTrajectory;

/// Trajectories that are kept: more are not in use at a time.
const KEPT: usize = 8;

/// What is no longer needed.
#[derive(Default)]
pub(super) struct TrajectoryPool {
    trajectories: Vec<PlannedTrajectory>,
    logs: Vec<Vec<Iteration>>,
    misses: Vec<Vec<f64>>,
    entries: Vec<Vec<(f64, f64)>>,
}

impl TrajectoryPool {
    /// A copy of a trajectory.
    pub(super) fn copy(&mut self, of: &PlannedTrajectory) -> PlannedTrajectory {
        match self.trajectories.pop() {
            Some(mut copy) if (copy.states(), copy.inputs()) == (of.states(), of.inputs()) => {
                copy.copy_from(of);
                copy
            }
            _ => of.clone(),
        }
    }

    /// Keeps a trajectory.
    pub(super) fn give(&mut self, trajectory: PlannedTrajectory) {
        if self.trajectories.len() < KEPT {
            self.trajectories.push(trajectory);
        }
    }

    /// Puts a trajectory in the place of another, which is kept.
    pub(super) fn replace(&mut self, old: &mut PlannedTrajectory, new: PlannedTrajectory) {
        let old = std::mem::replace(old, new);
        self.give(old);
    }

    /// An empty log.
    pub(super) fn log(&mut self) -> Vec<Iteration> {
        self.logs.pop().unwrap_or_default()
    }

    /// An empty list of misses.
    pub(super) fn miss(&mut self) -> Vec<f64> {
        self.misses.pop().unwrap_or_default()
    }

    /// Empty entries of a filter.
    pub(super) fn entries(&mut self) -> Vec<(f64, f64)> {
        self.entries.pop().unwrap_or_default()
    }

    /// Keeps entries of a filter.
    pub(super) fn give_entries(&mut self, mut entries: Vec<(f64, f64)>) {
        if self.entries.is_empty() {
            entries.clear();
            self.entries.push(entries);
        }
    }

    /// Keeps the memory of a solution.
    pub(super) fn give_solution(&mut self, solution: Solution) {
        let Solution { trajectory, mut iterations, mut miss, .. } = solution;
        self.give(trajectory);
        if self.logs.is_empty() {
            iterations.clear();
            self.logs.push(iterations);
        }
        if self.misses.is_empty() {
            miss.clear();
            self.misses.push(miss);
        }
    }
}
