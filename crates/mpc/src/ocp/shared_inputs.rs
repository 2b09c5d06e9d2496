//! Copies of one system in one problem, whose inputs are the same until the branches of its scenario tree part.

use super::problem::Ocp;
use crate::trajectory::PlannedTrajectory;

impl Ocp {
    /// The parameters of the branches over interval k of the horizon; empty where they keep theirs.
    pub(crate) fn branch_parameters(&self, k: usize) -> &[f64] {
        let rows = self.branching.as_ref().map_or(&[][..], |b| &b.parameters);
        rows.get(k).or(rows.last()).map_or(&[], Vec::as_slice)
    }

    /// Puts what differs between two problems of one branch, of the numbers that may change while a controller runs, into the problem
    /// of all branches.
    pub(crate) fn take_over_changes(&mut self, before: &Self, after: &Self) {
        let (n, m) = (after.model_states(), after.inputs());
        let count = self.inputs() / m.max(1);
        let changed =
            |old: (f64, f64), new: (f64, f64)| old.0.to_bits() != new.0.to_bits() || old.1.to_bits() != new.1.to_bits();
        for (i, (old, new)) in before.state_bounds.iter().zip(&after.state_bounds).enumerate().take(n) {
            if changed((old.min, old.max), (new.min, new.max)) {
                for s in 0..count {
                    let b = &mut self.state_bounds[s * n + i];
                    (b.min, b.max) = (new.min, new.max);
                }
            }
        }
        for (j, (old, new)) in before.input_bounds.iter().zip(&after.input_bounds).enumerate() {
            if changed(*old, *new) {
                (0..count).for_each(|s| self.input_bounds[s * m + j] = *new);
            }
        }
        for (i, (old, new)) in before.targets.iter().zip(&after.targets).enumerate() {
            if changed((old.value, 0.0), (new.value, 0.0)) {
                (0..count).for_each(|s| self.targets[s * after.targets.len() + i].value = new.value);
            }
        }
        self.references.clone_from(&after.references);
        self.parameters.clone_from(&after.parameters);
        self.first_row = after.first_row;
    }

    /// Number of inputs of one branch.
    pub(crate) fn inputs_of_branch(&self) -> usize {
        self.inputs() / self.branching.as_ref().map_or(1, |b| b.branches.max(1))
    }

    /// The input that input j is equal to over interval k: its own number where it is free.
    pub(crate) fn shared_with(&self, k: usize, j: usize) -> usize {
        let own = self.inputs_of_branch();
        self.branching.as_ref().map_or(j, |b| b.leader(k, j / own) * own + j % own)
    }

    /// The same by interval and input.
    pub(crate) fn shared_inputs(&self, steps: usize) -> Vec<usize> {
        (0..steps).flat_map(|k| (0..self.inputs()).map(move |j| self.shared_with(k, j))).collect()
    }

    /// Gives shared inputs the mean of their branches, as after a shift, which moves inputs of parted branches before the parting.
    pub(crate) fn merge_shared_inputs(&self, trajectory: &mut PlannedTrajectory) {
        let Some(b) = &self.branching else { return };
        let own = self.inputs_of_branch();
        for (k, leaders) in b.leaders.iter().enumerate().take(trajectory.steps()) {
            let row = trajectory.u_mut(k);
            for leader in (0..b.branches).filter(|s| leaders[*s] == *s) {
                let members = || (0..b.branches).filter(|s| leaders[*s] == leader);
                for j in 0..own {
                    let mean = members().map(|s| row[s * own + j]).sum::<f64>() / members().count() as f64;
                    members().for_each(|s| row[s * own + j] = mean);
                }
            }
        }
    }
}
