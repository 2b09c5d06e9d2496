//! The end time, parameters, and initial states that a plan decides on.

use super::control_problem::{ControlProblem, FreeValues};
use super::found_values::FoundValues;
use crate::error::MpcError;
use crate::sqp::SolveStatus;
use crate::trajectory::PlannedTrajectory;
use bracketry_symbolic::Named;
use std::borrow::Cow;
use std::time::Instant;

/// Tolerance of the programs of the search. Where a cost has no curvature, as that of time alone, an end is found as well as the
/// programs are solved: errors of 1e-8 keep the iteration from its end.
const QP_TOLERANCE: f64 = 1e-10;
/// How often targets that a plan misses get heavier, and by which factor.
const FIRMER: usize = 3;
const FIRMNESS: f64 = 100.0;
/// First step of the line search for a single value, relative to its size, most steps until a minimum is bracketed, and the width at which it
/// ends.
const FIRST_STEP: f64 = 1e-4;
const BRACKETING: usize = 8;
const PRECISION: f64 = 1e-7;
/// 2 − (1 + √5)/2.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

impl ControlProblem {
    /// Whether an end time, parameters, or initial states are free, for which no values have been found yet.
    pub fn has_free_values(&self) -> bool {
        self.free.is_some()
    }

    /// The problem with the end time, parameters, and initial states that its plan decides on, and this plan as its guess; the problem itself where
    /// nothing is free. Whatever runs or steps a problem does this first; do it yourself to see `dt` and the parameters of the
    /// plant.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together, for the values found either. How the solution ended is in
    /// [`ControlProblem::found`].
    pub fn with_free_values(&self) -> Result<Cow<'_, Self>, MpcError> {
        let Some(free) = &self.free else { return Ok(Cow::Borrowed(self)) };
        let mut extended = free.extended.clone();
        extended.x0.clone_from(&self.x0);
        extended.stop = self.stop.clone();
        extended.qp.tolerance = extended.qp.tolerance.min(QP_TOLERANCE);
        let mut solution = extended.plan()?;
        for _ in 0..FIRMER {
            let missed = self.ocp.targets.iter().zip(&solution.miss).any(|(t, miss)| (miss * t.linear).abs() > 1.0);
            if solution.status != SolveStatus::Converged || !missed {
                break;
            }
            // The cost outweighs the targets: an end time that costs much would shrink to nothing.
            for target in &mut extended.ocp.targets {
                target.linear *= FIRMNESS;
                target.quadratic *= FIRMNESS;
            }
            solution = extended.plan()?;
        }
        let inputs = self.ocp.inputs();
        let values = &solution.trajectory.u(0)[inputs..];
        let found = FoundValues {
            end_time: None,
            parameters: Named(Vec::new()),
            initial_states: Named(Vec::new()),
            status: solution.status.to_string(),
            converged: solution.status == SolveStatus::Converged,
            interior_point_steps: solution.interior_point_steps,
            programs: solution.iterations.len(),
            cost: solution.cost,
            seconds: solution.seconds,
        };
        let found = free.valued(found, values);
        if let (false, [value]) = (found.converged, values) {
            let size = extended.ocp.input_trust[inputs].max(value.abs());
            let bounds = extended.ocp.input_bounds[inputs];
            return self.along_the_line(free, &found, &solution.trajectory, (*value, size, bounds)).map(Cow::Owned);
        }
        self.with_found(free, &found, &solution.trajectory).map(Cow::Owned)
    }

    /// The problem with the values found, and the inputs of a trajectory as its guess.
    fn with_found(&self, free: &FreeValues, found: &FoundValues, inputs: &PlannedTrajectory) -> Result<Self, MpcError> {
        let mut problem = (free.with_found)(found).map_err(|e| MpcError::ValuesFound { reason: e.to_string() })?;
        let m = self.ocp.inputs();
        for (k, row) in problem.guess.iter_mut().enumerate() {
            row.copy_from_slice(&inputs.u(k)[..m]);
        }
        for (i, (to, given)) in problem.x0.iter_mut().zip(&self.x0).enumerate() {
            if !free.extended.ocp.free_starts.iter().any(|(state, _)| *state == i) {
                *to = *given;
            }
        }
        problem.samples = self.samples;
        problem.conditions = self.conditions.clone();
        problem.stop = self.stop.clone();
        Ok(problem)
    }

    /// As [`ControlProblem::with_found`] where the search for one value did not converge: at the value near it whose plan costs least, if
    /// plans converge there.
    fn along_the_line(
        &self,
        free: &FreeValues,
        found: &FoundValues,
        inputs: &PlannedTrajectory,
        (start, size, bounds): (f64, f64, (f64, f64)),
    ) -> Result<Self, MpcError> {
        let clock = Instant::now();
        let mut plans = 0;
        // What the best plan costs with its penalties, and without.
        let mut best = (f64::INFINITY, f64::NAN);
        let mut cost = |value: f64| -> Result<f64, MpcError> {
            if !(bounds.0..=bounds.1).contains(&value) {
                return Ok(f64::INFINITY);
            }
            plans += 1;
            let problem = self.with_found(free, &free.valued(found.clone(), &[value]), inputs)?;
            let plan = problem.plan()?;
            if plan.status != SolveStatus::Converged {
                return Ok(f64::INFINITY);
            }
            let with_penalties = problem.value(&plan.trajectory);
            if with_penalties < best.0 {
                best = (with_penalties, plan.cost);
            }
            Ok(with_penalties)
        };
        let Some(value) = line_minimum(&mut cost, start, size)? else { return self.with_found(free, found, inputs) };
        let refined = FoundValues {
            status: format!("converged along a line search over {plans} plans"),
            converged: true,
            cost: best.1,
            seconds: found.seconds + clock.elapsed().as_secs_f64(),
            ..free.valued(found.clone(), &[value])
        };
        self.with_found(free, &refined, inputs)
    }
}

impl FreeValues {
    /// What was found, with the values of the inputs that stand for what is free: the parameters, the initial states, then the end time by
    /// its guess.
    fn valued(&self, found: FoundValues, values: &[f64]) -> FoundValues {
        let scale = values.last().copied().unwrap_or(1.0);
        let states = self.extended.system.state_names();
        let starts = self.extended.ocp.free_starts.iter().map(|(state, _)| states[*state].clone());
        FoundValues {
            end_time: self.end_time.map(|guess| guess * scale),
            parameters: Named(self.parameters.iter().cloned().zip(values.iter().copied()).collect()),
            initial_states: Named(starts.zip(values.iter().skip(self.parameters.len()).copied()).collect()),
            ..found
        }
    }
}

/// Where a function has its minimum near `start`, by golden sections of a bracket; none where there is no bracket, or the function is not finite.
/// `size` is that of the variable, positive and no less than |start|.
fn line_minimum(
    cost: &mut impl FnMut(f64) -> Result<f64, MpcError>,
    start: f64,
    size: f64,
) -> Result<Option<f64>, MpcError> {
    let mut step = FIRST_STEP * size;
    let (mut middle, mut least) = (start, cost(start)?);
    let (mut low, mut high) = (start - step, start + step);
    let (mut at_low, mut at_high) = (cost(low)?, cost(high)?);
    for _ in 0..BRACKETING {
        step *= 2.0;
        if at_low < least {
            (high, at_high, middle, least) = (middle, least, low, at_low);
            low = middle - step;
            at_low = cost(low)?;
        } else if at_high < least {
            (low, at_low, middle, least) = (middle, least, high, at_high);
            high = middle + step;
            at_high = cost(high)?;
        } else {
            break;
        }
    }
    if !least.is_finite() || at_low < least || at_high < least {
        return Ok(None);
    }
    while high - low > PRECISION * size {
        // The larger of the two parts.
        let right = high - middle > middle - low;
        let at = if right { middle + GOLDEN * (high - middle) } else { middle - GOLDEN * (middle - low) };
        let value = cost(at)?;
        if value < least {
            if right {
                low = middle;
            } else {
                high = middle;
            }
            (middle, least) = (at, value);
        } else if right {
            high = at;
        } else {
            low = at;
        }
    }
    Ok(Some(middle))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::line_minimum;

    #[test]
    fn smooth_and_sharp_minima_are_found_also_at_zero_and_at_a_bound() {
        let starts = [(0.0, 1.0), (3e-4, 1.0), (-2.0, 2.0), (5e6, 5e6)];
        for (start, size) in starts {
            for share in [-0.003, 0.0, 0.01] {
                let least: f64 = start + share * size;
                for shape in [|d: f64| d.abs(), |d: f64| d * d, |d: f64| if d < 0.0 { f64::INFINITY } else { d }] {
                    // A start beyond the bound has no finite cost.
                    let found = line_minimum(&mut |x| Ok(1.0 + shape((x - least) / size)), start, size).unwrap();
                    let expected = shape((start - least) / size).is_finite();
                    assert_eq!(found.is_some(), expected, "{start} {least}");
                    assert!(found.is_none_or(|x| (x - least).abs() < 1e-6 * size), "{start} {least} {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_slope_without_end_has_no_minimum() {
        for slope in [-1.0, 1.0] {
            assert_eq!(line_minimum(&mut |x| Ok(slope * x), 1.0, 1.0).unwrap(), None);
        }
        assert_eq!(line_minimum(&mut |_| Ok(f64::NAN), 1.0, 1.0).unwrap(), None);
    }
}
