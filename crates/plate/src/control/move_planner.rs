//! Moves planned beforehand.

use super::limits::PlateLimits;
use super::move_problem::MoveProblem;
use super::planner::{Plan, Planner};
use super::shortest::{PlanningBudget, Search};
use crate::{Friction, Object, PlateError};
use std::time::Instant;

/// Interval in s over which a plan's accelerations are constant.
const INTERVAL: f64 = 0.04;
/// Share of the bounds that plans leave free.
const MARGIN: f64 = 0.05;

/// Plans moves of an object from rest to rest on the level plate, as short as it finds them.
#[derive(Clone)]
pub struct MovePlanner {
    planner: Planner,
    mu: f64,
}

/// A move from rest to rest.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedMove {
    /// Duration in s.
    pub duration: f64,
    /// Where it shall end: the target, its yaw with the whole turns that make the move short.
    pub target: [f64; 3],
    /// Error of x, y (m) and yaw (rad) at its end with exact friction.
    pub miss: [f64; 3],
    /// Whether that error is small: the plan arrives.
    pub arrives: bool,
    /// The accelerations `X''` (m/s²) and `θ''` (rad/s²) of each interval.
    pub accelerations: Vec<[f64; 2]>,
    /// Quadratic programs solved.
    pub programs: usize,
    /// Wall time in s.
    pub seconds: f64,
}

impl MovePlanner {
    /// A planner for an object and its friction coefficient on a plate with bounds.
    ///
    /// # Errors
    /// [`PlateError`] if one of them has no meaning.
    pub fn new(object: &Object, mu: f64, limits: &PlateLimits) -> Result<Self, PlateError> {
        Friction::Coulomb { mu }.validate()?;
        Ok(Self { planner: Planner::new(MoveProblem::new(object, limits, INTERVAL, MARGIN)?), mu })
    }

    /// The shortest move found from a pose to another, x, y (m), yaw (rad) but for whole turns; absent if no program could be
    /// solved at all.
    ///
    /// # Errors
    /// [`PlateError`] if a pose has no meaning.
    pub fn plan(
        &self,
        start: [f64; 3],
        target: [f64; 3],
        budget: &PlanningBudget,
    ) -> Result<Option<PlannedMove>, PlateError> {
        if let Some(value) = start.iter().chain(&target).find(|v| !v.is_finite()) {
            return Err(PlateError::BadState { value: *value });
        }
        let clock = Instant::now();
        let [x, y, yaw] = start;
        let search = Search {
            planner: &self.planner,
            start: [x, y, yaw, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            target,
            mu: self.mu,
            budget: *budget,
        };
        let plan = search.run()?;
        Ok(plan.map(|plan| Self::told(&plan, clock.elapsed().as_secs_f64())))
    }

    fn told(plan: &Plan, seconds: f64) -> PlannedMove {
        let steps = plan.trajectory.steps();
        PlannedMove {
            duration: steps as f64 * INTERVAL,
            target: plan.target,
            miss: plan.miss,
            arrives: plan.is_good(),
            accelerations: (0..steps).map(|k| [plan.trajectory.u(k)[0], plan.trajectory.u(k)[1]]).collect(),
            programs: plan.programs,
            seconds,
        }
    }
}
