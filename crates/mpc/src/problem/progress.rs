//! What the stage cost does over a run: whether it grows, and whether it settles.

use super::control_problem::ControlProblem;
use crate::closed_loop::ClosedLoop;
use crate::trajectory::PlannedTrajectory;

/// Share of the larger of two costs beyond which they differ grossly: one is more than ten times the other.
pub(super) const GROSS: f64 = 0.9;
/// Share of the stage cost that has to go over a run, if the plan loses as much.
const LOST: f64 = 0.5;

/// Mean stage costs of quarters of the samples.
pub(super) struct Progress {
    /// Of the first and the last quarter of the run.
    pub(super) first: f64,
    pub(super) last: f64,
    /// Of the third one.
    third: f64,
    /// Of the first and the last quarter of the plan.
    planned_first: f64,
    pub(super) planned_last: f64,
    /// Whether the run is as long as the plan.
    whole: bool,
}

impl Progress {
    pub(super) fn of(problem: &ControlProblem, run: &ClosedLoop, plan: &PlannedTrajectory) -> Self {
        let mut ocp = problem.ocp.clone();
        let costs: Vec<f64> =
            run.u.iter().enumerate().map(|(k, u)| ocp.stage_cost(k, run.t[k], &run.x[k], u)).collect();
        let planned = (0..plan.steps()).map(|k| ocp.stage_cost(k, k as f64 * ocp.dt, plan.x(k), plan.u(k)));
        let planned: Vec<f64> = planned.collect();
        let ([first, third, last], [planned_first, _, planned_last]) = (quarters(&costs), quarters(&planned));
        Self { first, last, third, planned_first, planned_last, whole: costs.len() >= planned.len() }
    }

    /// Whether the stage cost at the end is more than ten times that at the start.
    pub(super) fn grows(&self, floor: f64) -> bool {
        exceeds(self.last, self.first, GROSS, floor)
    }

    /// Whether the stage cost stays far above what the plan falls to. On another plant, that may be as good as it gets. There, the loop is
    /// judged by itself: its stage cost stays while that of the plan falls by half, or falls by less than nine tenths and then no more.
    pub(super) fn does_not_settle(&self, late: bool, other_plant: bool, floor: f64) -> bool {
        let above = self.whole && exceeds(self.last, self.planned_last, LOST, floor);
        let far = above && exceeds(self.last, self.planned_last, GROSS, floor);
        let falls = exceeds(self.planned_first, self.planned_last, LOST, floor);
        let stays = falls && !exceeds(self.first, self.last, LOST, 0.0);
        let swings = !exceeds(self.first, self.last, GROSS, 0.0) && !exceeds(self.third, self.last, LOST, 0.0);
        late && far || other_plant && (above && stays || far && swings)
    }
}

/// Whether `a` is larger than `b` by more than this share of the larger one.
fn exceeds(a: f64, b: f64, share: f64, floor: f64) -> bool {
    a - b > share * a.abs().max(b.abs()) + floor
}

/// Means of the first, the third, and the last quarter.
fn quarters(costs: &[f64]) -> [f64; 3] {
    let (quarter, count) = (costs.len().div_ceil(4), costs.len());
    let mean = |from: usize| costs[from..from + quarter].iter().sum::<f64>() / quarter as f64;
    [mean(0), mean(count.saturating_sub(2 * quarter)), mean(count - quarter)]
}
