//! The grid of a horizon, whose intervals may differ in length.

use super::bounds::positive;
use super::problem::Ocp;
use crate::error::{MpcError, check_length};
use crate::trajectory::PlannedTrajectory;

/// Share of an interval by which rounding may put a grid point beside a sample.
const ROUNDING: f64 = 1e-9;

impl Ocp {
    /// Whether every interval is dt long.
    pub fn is_uniform(&self) -> bool {
        self.lengths.is_empty()
    }

    /// Length of interval k, s.
    pub fn length(&self, k: usize) -> f64 {
        self.lengths.get(k).copied().unwrap_or(self.dt)
    }

    /// Time from the start of the horizon to its grid point k, s.
    pub fn offset(&self, k: usize) -> f64 {
        if self.is_uniform() { k as f64 * self.dt } else { self.lengths.iter().take(k).sum() }
    }

    /// Time of grid point k of a horizon that starts at sample `k0` of the run, s.
    pub(crate) fn time(&self, k0: usize, k: usize) -> f64 {
        if self.is_uniform() { (k0 + k) as f64 * self.dt } else { k0 as f64 * self.dt + self.offset(k) }
    }

    /// The last sample of the run at or before grid point k of a horizon that starts at sample `k0`.
    pub(crate) fn sample(&self, k0: usize, k: usize) -> usize {
        if self.is_uniform() { k0 + k } else { k0 + (self.offset(k) / self.dt + ROUNDING).floor() as usize }
    }

    /// Samples of the run that the horizon covers, the last one in part.
    pub(crate) fn samples_of_horizon(&self) -> usize {
        if self.is_uniform() { self.steps } else { (self.offset(self.steps) / self.dt - ROUNDING).ceil() as usize }
    }

    /// Length of what a violation at grid point k counts for: the interval that starts there, or the last one.
    pub(crate) fn share(&self, k: usize) -> f64 {
        self.length(k.min(self.steps.saturating_sub(1)))
    }

    /// Longest interval, s.
    pub(crate) fn longest(&self) -> f64 {
        self.lengths.iter().fold(self.dt, |l, v| l.max(*v))
    }

    pub(super) fn check_lengths(&self) -> Result<(), MpcError> {
        if self.is_uniform() {
            return Ok(());
        }
        check_length("the list of lengths of intervals", self.lengths.len(), self.steps)?;
        self.lengths.iter().try_for_each(|l| positive("the length of an interval", *l))
    }

    /// Moves a trajectory on by dt: every interval takes the mean of the inputs over it, every grid point the state in between.
    /// The last input is kept, and the last state must be filled in.
    pub(crate) fn move_on(&self, trajectory: &mut PlannedTrajectory) {
        if self.is_uniform() {
            trajectory.shift();
            self.merge_shared_inputs(trajectory);
            return;
        }
        let old = trajectory.clone();
        let ends: Vec<f64> = (0..=self.steps).map(|k| self.offset(k)).collect();
        let horizon = ends[self.steps];
        for k in 0..self.steps {
            let at = (ends[k] + self.dt).min(horizon);
            let i = ends.partition_point(|e| *e <= at).clamp(1, self.steps) - 1;
            let share = (at - ends[i]) / (ends[i + 1] - ends[i]);
            let between = old.x(i).iter().zip(old.x(i + 1)).map(|(a, b)| a + share * (b - a));
            trajectory.x_mut(k).iter_mut().zip(between).for_each(|(x, v)| *x = v);
            let (from, to) = (ends[k] + self.dt, ends[k + 1] + self.dt);
            let u = trajectory.u_mut(k);
            u.fill(0.0);
            for i in 0..self.steps {
                // After its end the last input holds.
                let end = if i + 1 == self.steps { f64::INFINITY } else { ends[i + 1] };
                let covered = end.min(to) - ends[i].max(from);
                if covered > 0.0 {
                    u.iter_mut().zip(old.u(i)).for_each(|(u, v)| *u += v * covered / (to - from));
                }
            }
        }
        self.merge_shared_inputs(trajectory);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_trajectory_moves_on_by_the_sampling_period() {
        let mut ocp = Ocp::new(1, 1, 3, 1.0);
        ocp.lengths = vec![1.0, 2.0, 4.0];
        let rows = |values: &[f64]| values.iter().map(|v| vec![*v]).collect::<Vec<_>>();
        // x = t, u = 1, 2, 3.
        let mut z = PlannedTrajectory::from_rows(&rows(&[0.0, 1.0, 3.0, 7.0]), &rows(&[1.0, 2.0, 3.0])).unwrap();
        ocp.move_on(&mut z);
        assert_eq!([z.x(0)[0], z.x(1)[0], z.x(2)[0]], [1.0, 2.0, 4.0]);
        assert_eq!([z.u(0)[0], z.u(1)[0], z.u(2)[0]], [2.0, 2.5, 3.0]);
        assert_eq!((ocp.sample(2, 2), ocp.samples_of_horizon(), ocp.time(1, 3)), (5, 7, 8.0));
    }
}
