//! In how short a time the moves of the story are made.

use bracketry::mpc::{ControlProblem, MpcError, SolveStatus};
use bracketry::plate::control::with_duration;

/// Durations of plans: the shortest that is tried (s), the steps of the search in sampling periods, and the longest (s).
const SHORTEST: f64 = 0.8;
const STRIDES: [usize; 2] = [8, 2];
const LONGEST: f64 = 2.4;
/// Frequencies of the guesses (Hz).
const FREQUENCIES: [f64; 2] = [3.0, 2.0];
/// Share of its tolerance by which a plan may miss a target.
const PLANNED: f64 = 0.05;
/// What feedback needs on top of the shortest duration.
const RESERVE: f64 = 0.3;

/// The shortest move of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shortest {
    /// Sampling periods of the shortest plan that arrives, and the frequency of its guess (Hz); none if no plan does.
    found: Option<(usize, f64)>,
    /// Length of these periods (s).
    dt: f64,
    /// Quadratic programs of the search.
    pub(super) programs: usize,
}

impl Shortest {
    /// Searches the shortest duration in which a plan arrives.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together.
    pub(super) fn of(problem: &ControlProblem) -> Result<Self, MpcError> {
        let dt = problem.ocp.dt;
        let mut programs = 0;
        let intervals = |seconds: f64| (seconds / dt).round() as usize;
        let (mut found, mut early) = (None, intervals(SHORTEST));
        let longest = intervals(LONGEST);
        for stride in STRIDES {
            let end = found.map_or(longest, |(steps, _)| steps - 1);
            for steps in (early..=end).step_by(stride) {
                if let Some(frequency) = arrives(problem, steps, &mut programs)? {
                    found = Some((steps, frequency));
                    break;
                }
                early = steps + 1;
            }
        }
        Ok(Self { found, dt, programs })
    }

    /// Its duration (s); none if no plan arrives.
    pub(super) fn seconds(&self) -> Option<f64> {
        self.found.map(|(steps, _)| steps as f64 * self.dt)
    }

    /// Gives a move this duration and a reserve for feedback. Where no plan arrives, the move keeps its own.
    pub(super) fn set(&self, problem: &mut ControlProblem) {
        if let Some((steps, frequency)) = self.found {
            with_duration(problem, ((1.0 + RESERVE) * steps as f64).ceil() as usize, frequency);
        }
    }
}

/// The frequency of a guess from which a plan of so many sampling periods arrives.
fn arrives(problem: &ControlProblem, steps: usize, programs: &mut usize) -> Result<Option<f64>, MpcError> {
    for frequency in FREQUENCIES {
        let mut trial = problem.clone();
        with_duration(&mut trial, steps, frequency);
        let plan = trial.plan()?;
        *programs += plan.iterations.len();
        let end = plan.trajectory.x(plan.trajectory.steps());
        let near = trial.ocp.targets.iter().all(|t| (end[t.state] - t.value).abs() * t.linear <= PLANNED);
        if plan.status == SolveStatus::Converged && near {
            return Ok(Some(frequency));
        }
    }
    Ok(None)
}
