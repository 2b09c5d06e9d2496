//! Settings of the pose controller and what it tells about its work.

use super::learned::{Learned, Uncertainty};
use super::limits::PlateLimits;
use super::shortest::PlanningBudget;

/// Settings of [`super::PoseController`].
#[derive(Debug, Clone, PartialEq)]
pub struct PoseSettings {
    /// Sampling period in s.
    pub period: f64,
    /// Samples after which a command acts: 0 or more.
    pub delay: usize,
    /// Bounds of the plate's motion.
    pub limits: PlateLimits,
    /// Friction coefficient assumed at first.
    pub mu: f64,
    /// Standard deviation of what is not known of it, as a share of it; 0 if it is exact.
    pub mu_deviation: f64,
    /// What else is not known and can be learned.
    pub uncertainty: Uncertainty,
    /// Standard deviations of the noise of the measured pose: position in m, yaw in rad; 0 without noise.
    pub noise: [f64; 2],
    /// What counts as arrived: greatest error of x and y in m, and of yaw in rad.
    pub tolerance: [f64; 2],
    /// Samples that pass, with the plate at rest, between the decision to correct and the first motion: the time that
    /// planning may take.
    pub planning_samples: usize,
    /// What the first plan may take: it is made at rest, before anything moves.
    pub first_plan: PlanningBudget,
    /// What the plan of a correction may take, which is made within the samples for planning.
    pub correction_plan: PlanningBudget,
    /// Time in s after which the program of a sample is given up and the plan goes on unchanged. Infinite at first, so that
    /// simulated runs do not depend on the machine; at most the period where the plate is real.
    pub time_limit: f64,
    /// Most moves; with more needed, the controller gives up.
    pub moves: usize,
}

impl Default for PoseSettings {
    /// 20 ms, one sample of delay, μ = 0.3 within 30 %, noise of 0.5 mm and 0.5°, tolerance 2 mm and 2°, 10 samples for
    /// planning, 8 moves.
    fn default() -> Self {
        Self {
            period: 0.02,
            delay: 1,
            limits: PlateLimits::default(),
            mu: 0.3,
            mu_deviation: 0.3,
            uncertainty: Uncertainty::default(),
            noise: [5e-4, 0.5f64.to_radians()],
            tolerance: [2e-3, 2f64.to_radians()],
            planning_samples: 10,
            first_plan: PlanningBudget { programs: 300, seconds: f64::INFINITY },
            correction_plan: PlanningBudget { programs: 120, seconds: f64::INFINITY },
            time_limit: f64::INFINITY,
            moves: 8,
        }
    }
}

/// How far the controller is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseStatus {
    /// It still moves the object, or looks where it is.
    Working,
    /// The object rests within the tolerance, as far as measurements tell.
    Arrived,
    /// No plan brings the object closer: what would be left of the error of x, y (m) and yaw (rad).
    Unreachable {
        /// Error at the end of the best plan.
        miss: [f64; 3],
    },
    /// The number of moves is used up: error of x, y (m) and yaw (rad) when it gave up.
    MovesUsedUp {
        /// Error.
        miss: [f64; 3],
    },
}

/// One move from rest to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoveReport {
    /// Planned duration in s.
    pub duration: f64,
    /// Samples by which it was made longer on the way.
    pub extended: usize,
    /// Quadratic programs of the planning.
    pub programs: usize,
    /// Wall time of the planning in s.
    pub seconds: f64,
    /// Error of x, y (m) and yaw (rad) at the end of the plan when replayed with exact friction.
    pub miss: [f64; 3],
    /// Friction coefficient assumed last.
    pub mu: f64,
}

/// What the controller did and why it ended.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseReport {
    /// How far it is.
    pub status: PoseStatus,
    /// Moves, the first and the corrections.
    pub moves: Vec<MoveReport>,
    /// The friction coefficient assumed now.
    pub mu: f64,
    /// What has been learned, with standard deviations.
    pub learned: Learned,
    /// Samples without a measurement.
    pub lost: usize,
    /// Programs that were not solved, so that the plan went on unchanged.
    pub unsolved: usize,
    /// Wall time of every sample of a move in s, estimation included, planning not.
    pub sample_seconds: Vec<f64>,
}
