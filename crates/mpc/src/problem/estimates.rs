//! Whether the estimates of a run are near the true states, which a simulated plant knows.

use super::control_problem::ControlProblem;
use super::notes::Note;
use crate::closed_loop::ClosedLoop;

/// Error, in standard deviations that the estimator states, beyond which it does not know what it does not know.
const UNBELIEVABLE: f64 = 10.0;
/// Error, as a share of the size of a state, beyond which it is worth mentioning, and beyond which the controller acts on something else
/// than the state.
const NOTABLE: f64 = 0.1;
const RUINOUS: f64 = 0.5;

/// The state whose estimate is farthest from the truth in the last quarter of the run, if it is far beyond what the estimator states.
pub(super) fn estimate_off(problem: &ControlProblem, run: &ClosedLoop) -> Option<Note> {
    let estimation = problem.estimation.as_ref()?;
    let samples = run.estimates.len();
    let last = samples - samples.div_ceil(4)..samples;
    let names = problem.system.state_names();
    let mut worst: Option<(f64, Note)> = None;
    for (i, name) in names.iter().enumerate() {
        // An angle is known up to whole turns.
        let mut outputs = estimation.problem.outputs.iter().filter(|o| o.expression.trim() == name);
        let period = outputs.find_map(|o| o.period);
        let (mut square, mut normalized) = (0.0, 0.0);
        for k in last.clone() {
            let (Some(estimate), Some(std)) = (run.estimates[k].get(i), run.deviations[k].get(i)) else { return None };
            let mut error = estimate - run.x[k][i];
            if let Some(period) = period {
                error -= period * (error / period).round();
            }
            square += error * error;
            normalized += (error / std.max(f64::MIN_POSITIVE)).powi(2);
        }
        let mean = |sum: f64| (sum / last.len() as f64).sqrt();
        let (error, deviations) = (mean(square), mean(normalized));
        let share = error / problem.ocp.sizes()[i];
        let off = deviations > UNBELIEVABLE && share > NOTABLE;
        if off && worst.as_ref().is_none_or(|w| share > w.0) {
            let note = Note::EstimateOff { state: name.clone(), error, deviations, ruined: share > RUINOUS };
            worst = Some((share, note));
        }
    }
    worst.map(|w| w.1)
}
