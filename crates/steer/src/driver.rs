//! One method after the other, and the check of what it gave.

use bracketry_lie::Error as LieError;
use bracketry_lie::analysis::{ModeFields, mode_fields};
use bracketry_sim::Hold;
use bracketry_symbolic::{Limit, ZeroTest};
use bracketry_system::System;

use crate::correction::corrected;
use crate::integrators::own_inputs;
use crate::options::{SteerError, SteerMethod, SteerOptions};
use crate::problem::{Outcome, Planned, Problem};
use crate::ranges::Ranges;
use crate::roll_out::{RollOut, distance};
use crate::signals::Signals;
use crate::steering::{Attempt, SteerNote, SteerReason, SteerStatus, Steering};
use crate::{chained, flat, loops, nilpotent, shooting};

/// Inputs are slowed a little more than needed, so that corrections find room.
const ROOM: f64 = 1.002;

/// Inputs that move a model from one state to another.
///
/// The states of the options are those of [`own_inputs`] of the model. Every motion that is returned is a simulation of the
/// system itself under the returned inputs.
///
/// # Errors
/// [`SteerError`] for lists of the wrong length, numbers that are not finite, and models that cannot be simulated. That no
/// motion is found is a result, not an error.
pub fn steer(given: &System, options: &SteerOptions) -> Result<Steering, SteerError> {
    let system = own_inputs(given)?;
    check(&system, options)?;
    system.check_denominators()?;
    let limit = Limit::new(options.time_limit, &options.stop);
    let ranges = Ranges::of(&system);
    let problem = Problem { given: given.clone(), system: system.clone(), options: options.clone(), ranges, limit };
    let mut result = Steering {
        status: SteerStatus::NotFound,
        plan: None,
        from: options.from.clone(),
        to: options.to.clone(),
        signals: None,
        motion: None,
        end_error: f64::INFINITY,
        corrections: 0,
        attempts: Vec::new(),
        notes: Vec::new(),
        system,
    };
    let methods = match options.method {
        Some(method) => vec![method],
        None if options.bounds.is_empty() => {
            vec![SteerMethod::Chained, SteerMethod::Nilpotent, SteerMethod::Flat, SteerMethod::Shooting]
        }
        // The bounds are for loops.
        None => vec![
            SteerMethod::Chained,
            SteerMethod::Nilpotent,
            SteerMethod::Flat,
            SteerMethod::Loops,
            SteerMethod::Shooting,
        ],
    };
    let view = View::of(&problem);
    for method in methods {
        if problem.is_over() {
            result.attempts.push(Attempt { method, reason: SteerReason::Stopped });
            break;
        }
        let reason = match run(&problem, &view, method) {
            Err(reason) => reason,
            Ok(plans) => match tried(&problem, &view, plans, &mut result)? {
                None => break,
                Some(reason) => reason,
            },
        };
        result.attempts.push(Attempt { method, reason });
    }
    Ok(result)
}

/// Keeps the best of the plans of a method, and says why none of them reaches the end, if so.
fn tried(
    problem: &Problem,
    view: &View,
    plans: Vec<Planned>,
    result: &mut Steering,
) -> Result<Option<SteerReason>, SteerError> {
    let (mut best, mut why): (f64, Option<SteerReason>) = (f64::INFINITY, None);
    for planned in plans {
        if why.is_some() && problem.is_over() {
            break;
        }
        let (candidate, reason) = finished(problem, view.driftless, planned)?;
        let (reached, error) = (reason.is_none(), candidate.end_error);
        if rank(&candidate) < rank(result) {
            let attempts = std::mem::take(&mut result.attempts);
            *result = Steering { attempts, ..candidate };
        }
        if reached {
            return Ok(None);
        }
        if why.is_none() || error < best {
            (best, why) = (error, reason);
        }
    }
    Ok(why)
}

/// Better ones first.
fn rank(s: &Steering) -> (u8, f64) {
    let status = match s.status {
        SteerStatus::Reached => 0,
        SteerStatus::FirstGuess => 1,
        SteerStatus::NotFound => 2,
    };
    (status, s.end_error)
}

fn check(system: &System, options: &SteerOptions) -> Result<(), SteerError> {
    if system.states.is_empty() {
        return Err(SteerError::Nothing { what: "states" });
    }
    if system.inputs.is_empty() {
        return Err(SteerError::Nothing { what: "inputs" });
    }
    let lists = [
        ("the initial state", system.states.len(), Some(&options.from)),
        ("the state at the end", system.states.len(), Some(&options.to)),
        ("the inputs at the start", system.inputs.len(), options.from_inputs.as_ref()),
        ("the inputs at the end", system.inputs.len(), options.to_inputs.as_ref()),
    ];
    for (what, expected, list) in lists {
        let Some(list) = list else { continue };
        if list.len() != expected {
            return Err(SteerError::Length { what, expected, found: list.len() });
        }
        if !list.iter().all(|v| v.is_finite()) {
            return Err(SteerError::NotFinite { what });
        }
    }
    for (what, value) in [("duration", options.duration), ("tolerance", Some(options.tolerance))] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(SteerError::NotPositive { what, value });
        }
    }
    Ok(())
}

/// The fields of a smooth affine model, or why there are none.
struct View {
    system: System,
    mode: Result<ModeFields, SteerReason>,
    driftless: bool,
}

impl View {
    fn of(problem: &Problem) -> Self {
        let mut system = problem.system.clone();
        system.pool.set_limit(problem.limit.clone());
        let mode = if system.input_delays.is_empty() {
            match mode_fields(&mut system) {
                Ok(mut modes) if modes.len() == 1 && modes[0].signs.0.is_empty() => Ok(modes.remove(0)),
                Ok(_) | Err(LieError::Modes { .. }) => Err(SteerReason::Switches),
                Err(LieError::Undecided(why)) => Err(SteerReason::Undecided(why)),
                Err(_) => Err(SteerReason::NotAffine),
            }
        } else {
            Err(SteerReason::Delays)
        };
        let mut driftless = false;
        if let Ok(mode) = &mode {
            let bindings = &mode.fields.bindings;
            driftless =
                mode.fields.drift.iter().all(|&f| matches!(system.pool.zero_test(f, bindings), ZeroTest::Zero(_)));
        }
        View { system, mode, driftless }
    }
}

fn run(problem: &Problem, view: &View, method: SteerMethod) -> Outcome {
    let mut system = view.system.clone();
    let simulated = |hold| RollOut::new(&problem.system, hold, problem.stop()).map_err(|_| SteerReason::NotAffine);
    let fields = || view.mode.as_ref().map_err(Clone::clone);
    match method {
        SteerMethod::Chained | SteerMethod::Nilpotent if !view.driftless => {
            fields()?;
            Err(SteerReason::Drift)
        }
        SteerMethod::Chained => chained::plan(problem, fields()?, &mut system),
        SteerMethod::Nilpotent => nilpotent::plan(problem, fields()?, &mut system, &mut simulated(Hold::Previous)?),
        SteerMethod::Flat => flat::plan(problem, fields()?, &mut system),
        SteerMethod::Loops => loops::plan(problem),
        SteerMethod::Shooting if !problem.system.input_delays.is_empty() => Err(SteerReason::Delays),
        SteerMethod::Shooting => shooting::plan(problem, &problem.system, &mut simulated(Hold::Linear)?),
    }
}

/// The inputs in the time that was asked for and within the ranges, corrected, and the motion that they give.
fn finished(
    problem: &Problem,
    driftless: bool,
    planned: Planned,
) -> Result<(Steering, Option<SteerReason>), SteerError> {
    let mut notes = Vec::new();
    let mut signals = planned.signals;
    if driftless {
        signals = in_time(problem, signals, &mut notes);
    }
    let mut plant = RollOut::new(&problem.system, signals.hold, problem.stop())?;
    let (from, to) = (&problem.options.from, &problem.options.to);
    let error = plant.end(from, &signals).map_or(f64::INFINITY, |end| distance(&end, to));
    let (signals, _, corrections) = corrected(problem, &mut plant, signals, error);
    let motion = plant.run(from, &signals);
    let ended = motion.as_ref().filter(|run| run.outcome.is_finished());
    let end_error = ended.map_or(f64::INFINITY, |run| distance(run.trajectory.final_state(), to));
    let outside = problem.ranges.left_by(&signals);
    let reason = if end_error > problem.options.tolerance || end_error.is_nan() {
        Some(if problem.is_over() { SteerReason::Stopped } else { SteerReason::EndError { error: end_error } })
    } else {
        outside.map(|_| SteerReason::Ranges)
    };
    if let Some(input) = outside {
        notes.push(SteerNote::OutOfRange { input: problem.system.input_names()[input].clone() });
    }
    let status = match reason {
        None => SteerStatus::Reached,
        // A motion that ends no closer than it began is no guess.
        Some(_) if end_error < distance(from, to) || end_error <= problem.options.tolerance => SteerStatus::FirstGuess,
        Some(_) => SteerStatus::NotFound,
    };
    let kept = status != SteerStatus::NotFound;
    let steering = Steering {
        system: problem.system.clone(),
        status,
        plan: kept.then_some(planned.plan),
        from: from.clone(),
        to: to.clone(),
        signals: kept.then_some(signals),
        motion: motion.filter(|_| kept),
        end_error,
        corrections,
        attempts: Vec::new(),
        notes,
    };
    Ok((steering, reason))
}

/// A motion without drift, as fast as asked for or as the ranges allow; without either, no input exceeds 1.
fn in_time(problem: &Problem, signals: Signals, notes: &mut Vec<SteerNote>) -> Signals {
    let needed = problem.ranges.slowdown(&signals) * ROOM;
    let natural = signals.duration();
    match problem.options.duration {
        Some(asked) => {
            if needed.is_finite() && needed * natural > asked {
                notes.push(SteerNote::Longer { asked });
                return signals.slowed(needed);
            }
            signals.slowed(asked / natural)
        }
        None if needed > 0.0 && needed.is_finite() => {
            let inputs = problem.system.inputs.len();
            let free = (0..inputs).filter(|&j| problem.ranges.limit(j, true).is_infinite());
            let size = free.map(|j| signals.largest(j)).fold(0.0, f64::max);
            signals.slowed(needed.max(size))
        }
        None => {
            let size = (0..problem.system.inputs.len()).map(|j| signals.largest(j)).fold(0.0, f64::max);
            if size > 0.0 { signals.slowed(size) } else { signals }
        }
    }
}
