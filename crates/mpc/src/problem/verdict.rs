//! What speaks against a run whose every sample has a solution: it does not do what its plan says, or something simple does
//! better.

use super::cause::Cause;
use super::control_problem::ControlProblem;
use super::method::{Feedback, Method, MethodReason};
use super::notes::Note;
use super::open_loop::{Held, OTHER_START, Rehearsal};
use super::progress::{GROSS, Progress};
use super::signs::{has_friction, jumps};
use crate::closed_loop::ClosedLoop;
use crate::error::MpcError;
use crate::ocp::{HorizonCost, Ocp};
use crate::sqp::{SolveStatus, Sqp};
use crate::trajectory::PlannedTrajectory;

/// Share of the larger of two costs by which a simple input does better than a loop with one program per sample: it costs less than half.
const BETTER: f64 = 0.5;
/// The same where the loop does next to nothing.
const IDLE: f64 = 0.1;
/// The same for a simple input that does better than a converged plan, which is then not the best one.
const BEST: f64 = 0.01;
/// The same for the plan from another start: solutions that differ less are other ways to do the same.
const ELSEWHERE: f64 = 0.3;
/// Violation of a hard bound, as a share of its scale, below which it does not count: the plant bends otherwise between samples.
const KEPT: f64 = 0.01;
/// Share of its size beyond which a state or an input has no bound.
const DIVERGED: f64 = 1e8;
/// Motion, as a share of a state's scale, below which nothing moves.
const STILL: f64 = 1e-6;
/// Share of what moving every state by its scale costs, below which costs are not worth mentioning.
const FLOOR: f64 = 0.01;

/// The cost of what was done, of what was planned, and what a cost has to reach to be worth mentioning.
struct Balance {
    /// Over the first `intervals`, with penalties, and with the terminal cost where these are the horizon.
    realized: HorizonCost,
    planned: HorizonCost,
    /// Terminal cost of the first and the last state of the run.
    ends: (f64, f64),
    intervals: usize,
    floor: f64,
}

/// What speaks against the run; `plan` is the trajectory that the controller started from.
///
/// # Errors
/// If the pieces of the problem do not fit together.
pub(super) fn verdict(
    problem: &ControlProblem,
    run: &ClosedLoop,
    plan: &PlannedTrajectory,
    planned: bool,
    predicted: HorizonCost,
) -> Result<Vec<Note>, MpcError> {
    let mut notes = Vec::new();
    // What noise, faults and delays cost cannot be told from what the controller does.
    let conditions = &problem.conditions;
    let undisturbed = conditions.noise.iter().all(|s| *s == 0.0)
        && conditions.faults.is_empty()
        && (conditions.delay == 0 || acts_late(problem))
        && problem.estimation.is_none()
        && problem.is_alone()
        // Nor do intervals that are no samples have a counterpart in the run.
        && problem.ocp.is_uniform()
        && run.x.iter().flatten().all(|v| v.is_finite());
    let balance = undisturbed.then(|| balance(problem, run, plan, predicted));
    let as_planned = planned && balance.as_ref().is_some_and(|b| b.is_as_planned(problem, run));
    let answered = run.steps.len() - run.counts.played_out;
    let inaccurate = answered > 1 && 2 * run.counts.inaccurate > answered;
    if inaccurate && !as_planned && !(one_program(problem) && undisturbed && is_as_good_as_a_plan(problem, run)?) {
        notes.push(Note::MostlyInaccurate { count: run.counts.inaccurate, of: answered });
    }
    let unfound = problem.found.as_ref().filter(|found| !found.converged);
    // Targets that are met do not say at what cost.
    let met = !problem.ocp.targets.is_empty() && !problem.ends_early();
    let proven = met && (unfound.is_some() || undisturbed && !planned && is_as_good_as_a_plan(problem, run)?);
    if !planned && !proven {
        notes.push(Note::PlanNotConverged);
    }
    if let Some(found) = unfound {
        notes.push(Note::SearchNotConverged { status: found.status.clone(), programs: found.programs });
    }
    if let Some(note) = diverges(problem, run, plan) {
        // Whatever else is wrong follows from it.
        notes.push(note);
        return Ok(notes);
    }
    if let Some(note) = held(problem, run)? {
        // Whatever else is wrong follows from it.
        notes.push(note);
        return Ok(notes);
    }
    if matches!(problem.method_reason, MethodReason::NotConverging) && !is_as_good_as_a_plan(problem, run)? {
        notes.push(Note::ChosenWithoutPlan);
    }
    let cause = cause(problem, run, planned);
    let end = run.x.last().unwrap_or(&problem.x0);
    for t in problem.ocp.targets.iter().filter(|_| !problem.ends_early()) {
        let miss = end[t.state] - t.value;
        if miss.abs() * t.linear > 1.0 {
            let state = problem.system.symbol_name(problem.system.states[t.state]).to_owned();
            let moves_on = !matches!(problem.method, Method::Plan { .. });
            let cause = if moves_on && cause != Cause::Plant { Cause::MovingHorizon } else { cause };
            notes.push(Note::MissedTarget { state, miss: miss.abs(), cause });
        }
    }
    if problem.ends_early() && planned {
        notes.extend(targets_of_plan(problem, plan));
    }
    if !one_program(problem) && planned && problem.is_alone() {
        notes.extend(plan_outdone(problem, plan)?);
        let converged = matches!(problem.method, Method::Sqp { .. } | Method::Plan { .. });
        if converged && notes.is_empty() && answered >= OTHER_START && !problem.tries_elsewhere() {
            notes.extend(other_start(problem, problem.value(plan))?);
        }
    }
    let Some(balance) = balance else { return Ok(notes) };
    // The trajectory that one program per sample starts from is no plan to be judged by.
    let judge = if one_program(problem) && differs(problem) { converged_plan(problem)? } else { None };
    let progress = Progress::of(problem, run, judge.as_ref().unwrap_or(plan));
    let Progress { first, last, .. } = progress;
    let falls = last < 0.5 * first;
    let ends_with_plan = matches!(problem.method, Method::Plan { .. });
    notes.extend(balance.note(ends_with_plan, GROSS, cause).filter(|_| !one_program(problem) || !falls));
    notes.extend(not_held(problem, run, balance.floor));
    let per_interval = balance.floor / (problem.ocp.dt * balance.intervals.max(1) as f64);
    // References and live parameters may make a cost grow that was well served.
    let constant = problem.ocp.references.is_empty() && problem.ocp.parameters.is_empty();
    // A target met, and a plan followed, are what was asked for, whatever is paid on the way.
    let done = as_planned || !problem.ocp.targets.is_empty() && !problem.ends_early();
    if notes.is_empty() && constant && !done && progress.grows(per_interval) {
        notes.push(Note::Grows { first, last, cause });
    }
    if notes.is_empty() && constant && progress.does_not_settle(acts_late(problem), differs(problem), per_interval) {
        notes.push(Note::NotSettling { last, planned: progress.planned_last, cause });
    }
    let same = problem.plant.dynamics.len() == problem.system.dynamics.len() && !differs(problem);
    let whole = balance.intervals == problem.ocp.steps && problem.ocp.targets.is_empty();
    if whole && same && one_program(problem) && notes.is_empty() && !acts_late(problem) {
        notes.extend(loop_outdone(problem, run, &balance)?);
        if notes.is_empty() && problem.stays(run.u.iter().map(Vec::as_slice)) {
            notes.extend(other_start(problem, balance.realized.total())?);
        }
    }
    Ok(notes)
}

/// A plan or a run that goes far beyond the sizes of the problem: its scales, its start, its targets, and its bounds.
fn diverges(problem: &ControlProblem, run: &ClosedLoop, plan: &PlannedTrajectory) -> Option<Note> {
    let ocp = &problem.ocp;
    let size = |scale: f64, value: f64, (min, max): (f64, f64)| {
        let finite = [min, max].into_iter().filter(|b| b.is_finite()).map(f64::abs);
        finite.fold(scale.max(value.abs()), f64::max)
    };
    let of_input = |j: usize| size(ocp.input_trust[j], 0.0, ocp.input_bounds[j]);
    let of_state = |i: usize| {
        let target = ocp.targets.iter().filter(|t| t.state == i).map(|t| t.value.abs()).fold(0.0, f64::max);
        let bounds = ocp.state_bounds[i];
        size(ocp.sizes()[i], problem.x0[i].abs().max(target), (bounds.min, bounds.max))
    };
    let beyond = |names: &[String], values: &[f64], size: &dyn Fn(usize) -> f64, in_plan: bool| {
        let sized = names.iter().zip(values).enumerate().map(|(i, (name, &value))| (name, value, size(i)));
        let far = |(_, value, size): &(&String, f64, f64)| value.is_finite() && value.abs() > DIVERGED * size;
        let worst = sized.filter(far).max_by(|a, b| (a.1.abs() / a.2).total_cmp(&(b.1.abs() / b.2)));
        worst.map(|(name, value, size)| Note::Diverges { name: name.clone(), value, size, in_plan })
    };
    let (states, inputs) = (problem.system.state_names(), problem.system.input_names());
    (0..plan.steps())
        .find_map(|k| beyond(&inputs, plan.u(k), &of_input, true))
        .or_else(|| beyond(&states, plan.x(plan.steps()), &of_state, true))
        .or_else(|| beyond(&states, run.x.last()?, &of_state, false))
}

/// Friction that holds everything where it is, whatever the inputs, though something else is asked.
fn held(problem: &ControlProblem, run: &ClosedLoop) -> Result<Option<Note>, MpcError> {
    let moves = |x: &[f64]| {
        let scale = &problem.ocp.state_scale;
        x.iter().zip(&problem.x0).zip(scale).any(|((x, x0), s)| (x - x0).abs() > STILL * s)
    };
    let asked = run.cost.abs() > floor(problem, problem.ocp.steps)
        || problem.ocp.targets.iter().any(|t| (problem.x0[t.state] - t.value).abs() * t.linear > 1.0);
    // An input without bounds overcomes what it has to, if its cost allows.
    let bounded = problem.ocp.input_bounds.iter().all(|b| b.0.is_finite() && b.1.is_finite());
    if !has_friction(&problem.system) || !asked || !bounded || run.x.iter().any(|x| moves(x)) {
        return Ok(None);
    }
    let mut rehearsal = Rehearsal::exact(problem)?;
    if !matches!(rehearsal, Rehearsal::Exact(_)) {
        return Ok(None);
    }
    for motion in rehearsal.at_bounds(problem) {
        if (0..=motion.steps()).any(|k| moves(motion.x(k))) {
            return Ok(None);
        }
    }
    let names = jumps(&mut problem.system.clone()).into_iter().map(|(name, _)| name).collect();
    Ok(Some(Note::Held { names }))
}

/// Whether the plan of a run that ends before it reaches the targets.
fn targets_of_plan(problem: &ControlProblem, plan: &PlannedTrajectory) -> Vec<Note> {
    let end = plan.x(plan.steps());
    let missed = problem.ocp.targets.iter().filter(|t| (end[t.state] - t.value).abs() * t.linear > 1.0);
    let notes: Vec<Note> = missed
        .map(|t| Note::PlanMisses {
            state: problem.system.symbol_name(problem.system.states[t.state]).to_owned(),
            miss: (end[t.state] - t.value).abs(),
        })
        .collect();
    if problem.ocp.targets.is_empty() || !(notes.is_empty() || one_program(problem)) {
        return notes;
    }
    // The plan of one program may miss what the loop does not.
    let (run, horizon) = (problem.samples as f64 * problem.ocp.dt, problem.ocp.offset(problem.ocp.steps));
    vec![Note::TargetsLater { run, horizon, reached: !one_program(problem) }]
}

/// A simple input that costs less than the converged plan, which shows that there is a better one.
fn plan_outdone(problem: &ControlProblem, plan: &PlannedTrajectory) -> Result<Option<Note>, MpcError> {
    let mut problem = problem.clone();
    problem.ocp = problem.ocp.tightened(problem.method.margin());
    let mut rehearsal = match problem.method {
        Method::StickSlip { .. } => Rehearsal::exact(&problem)?,
        _ => Rehearsal::smoothed(&problem)?,
    };
    let floor = floor(&problem, plan.steps());
    let stays = problem.stays((0..plan.steps()).map(|k| plan.u(k)));
    let planned = problem.value(plan);
    let held = rehearsal.best_held(&problem);
    let better = held.filter(|h| planned - h.cost > BEST * planned.abs().max(h.cost.abs()) + floor);
    Ok(better.map(|held| outdone(&problem, &held, stays, planned)))
}

/// Whether a plan converges from what the loop did over the horizon, and does not cost less; or there is not much to be saved.
fn is_as_good_as_a_plan(problem: &ControlProblem, run: &ClosedLoop) -> Result<bool, MpcError> {
    let steps = problem.ocp.steps;
    if run.u.len() < steps || !problem.ocp.is_uniform() || !problem.is_alone() {
        return Ok(false);
    }
    let Ok(done) = PlannedTrajectory::from_rows(&run.x[..=steps], &run.u[..steps]) else { return Ok(false) };
    let mut sqp = Sqp::new(problem.dynamics()?, problem.ocp.clone(), problem.sqp_settings())?;
    let plan = sqp.solve(&problem.initial_state(), &done)?;
    let (realized, planned) = (problem.value(&done), problem.value(&plan.trajectory));
    let floor = floor(problem, steps);
    let close = realized - planned <= BEST * realized.abs().max(planned.abs()) + floor;
    // Of a cost that is not worth mentioning, there is not much to be saved.
    let settled = plan.status == SolveStatus::Converged || realized.abs() <= floor;
    Ok(settled && close)
}

/// The plan from the guess, where it converges.
fn converged_plan(problem: &ControlProblem) -> Result<Option<PlannedTrajectory>, MpcError> {
    let mut sqp = Sqp::new(problem.dynamics()?, problem.ocp.clone(), problem.sqp_settings())?;
    let plan = problem.first_solution(&mut sqp, Feedback::default())?;
    Ok((plan.status == SolveStatus::Converged).then_some(plan.trajectory))
}

/// A plan from another start that costs much less than `planned`: from inputs at rest, or from waves where those are the guess.
fn other_start(problem: &ControlProblem, planned: f64) -> Result<Option<Note>, MpcError> {
    let steps = problem.ocp.steps;
    let (at_rest, start) = problem.elsewhere();
    let ocp = problem.ocp.tightened(problem.method.margin());
    let solution =
        Sqp::new(problem.dynamics()?, ocp, problem.sqp_settings())?.solve(&problem.initial_state(), &start)?;
    let found = problem.value(&solution.trajectory);
    let better = solution.status == SolveStatus::Converged
        && planned - found > ELSEWHERE * planned.abs().max(found.abs()) + floor(problem, steps);
    Ok(better.then_some(Note::BetterElsewhere { at_rest, planned, found }))
}

/// A simple input that costs much less than what was done with one program per sample, or anything less than doing nothing. What
/// was done costs more than its plan where the horizon is short; that is no fault of the plan.
fn loop_outdone(problem: &ControlProblem, run: &ClosedLoop, balance: &Balance) -> Result<Option<Note>, MpcError> {
    let stays = problem.stays(run.u.iter().map(Vec::as_slice));
    let share = if stays { IDLE } else { BETTER };
    let costs_less =
        |cost: f64, than: f64, share: f64| than - cost > share * than.abs().max(cost.abs()) + balance.floor;
    let held = Rehearsal::exact(problem)?.best_held(problem);
    let better = held.filter(|held| {
        let (realized, planned) = (balance.realized.total(), balance.planned.total());
        costs_less(held.cost, realized, share) && (planned.is_nan() || costs_less(held.cost, planned, BEST))
    });
    Ok(better.map(|held| outdone(problem, &held, stays, balance.realized.total())))
}

fn outdone(problem: &ControlProblem, held: &Held, stays: bool, realized: f64) -> Note {
    let input = problem.system.input_names()[held.input].clone();
    Note::Outdone { stays, input, value: held.value, intervals: held.intervals, cost: held.cost, realized }
}

/// Whether inputs at rest lose what the plan reached.
fn not_held(problem: &ControlProblem, run: &ClosedLoop, floor: f64) -> Option<Note> {
    let count = run.counts.played_out;
    let solved = run.u.len() - count;
    if count == 0 || solved == 0 {
        return None;
    }
    let mut ocp = problem.ocp.clone();
    // Both with the last input of the plan: what an input costs is not what it holds.
    let mut stage = |k: usize| ocp.stage_cost(k, run.t[k], &run.x[k], &run.u[solved - 1]);
    let (reached, left) = (stage(solved), stage(run.x.len() - 1));
    let floor = floor / (problem.ocp.dt * problem.ocp.steps as f64);
    let lost = left - reached > BETTER * left.abs().max(reached.abs()) + floor;
    lost.then_some(Note::NotHeld { count, reached, left })
}

/// Costs of what was done and of what was planned.
fn balance(problem: &ControlProblem, run: &ClosedLoop, plan: &PlannedTrajectory, predicted: HorizonCost) -> Balance {
    let mut ocp = problem.ocp.clone();
    // Those of a horizon that moves on are not met on the way.
    ocp.targets.clear();
    let intervals = run.u.len().min(problem.ocp.steps);
    let whole = intervals == problem.ocp.steps;
    let rows = |count: usize| -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        ((0..=count).map(|k| plan.x(k).to_vec()).collect(), (0..count).map(|k| plan.u(k).to_vec()).collect())
    };
    let one_program = one_program(problem);
    let mut cost = |x: &[Vec<f64>], u: &[Vec<f64>]| match PlannedTrajectory::from_rows(x, u) {
        Ok(z) if whole => {
            let HorizonCost { stage, terminal } = ocp.costs(0, &z);
            // The predicted cost has no penalties.
            let hard = if ocp.hard_violation(0, &z) > KEPT { problem.qp.hard_weight } else { 0.0 };
            let penalty = if one_program { 0.0 } else { ocp.penalty(0, &z, hard) };
            HorizonCost { stage: stage + penalty, terminal }
        }
        Ok(z) => {
            let stage = (0..intervals).map(|k| ocp.dt * ocp.stage_cost(k, k as f64 * ocp.dt, z.x(k), z.u(k))).sum();
            HorizonCost { stage, terminal: 0.0 }
        }
        Err(_) => HorizonCost::NONE,
    };
    let realized = cost(&run.x[..=intervals], &run.u[..intervals]);
    // The trajectory that real-time iteration starts from is no plan yet: what is known is the cost of its whole first plan.
    let planned = if one_program {
        if whole { predicted } else { HorizonCost::NONE }
    } else {
        let (x, u) = rows(intervals.min(plan.steps()));
        cost(&x, &u)
    };
    let mut end = |k: usize| ocp.terminal_cost(k, run.t[k], &run.x[k]);
    let ends = if whole { (end(0), end(run.x.len() - 1)) } else { (0.0, 0.0) };
    Balance { realized, planned, ends, intervals, floor: floor(problem, intervals) }
}

impl Balance {
    /// Whether a run within the horizon costs what a converged plan says.
    fn is_as_planned(&self, problem: &ControlProblem, run: &ClosedLoop) -> bool {
        let converged = !one_program(problem) || matches!(problem.method_reason, MethodReason::Settled { .. });
        let (realized, planned) = (self.realized.total(), self.planned.total());
        converged
            && run.u.len() <= self.intervals
            && realized - planned <= BEST * realized.abs().max(planned.abs()) + self.floor
    }

    /// The note on a loop that costs more than its plan by more than `share` of the larger one. A plan is tracked to its end, and its
    /// terminal cost counts. A horizon that moves on never ends: its terminal cost stands for what comes after it, so that stage costs
    /// compare, and terminal costs only where that of the loop does not fall over the whole run.
    fn note(&self, ends_with_plan: bool, share: f64, cause: Cause) -> Option<Note> {
        let gross = |a: f64, b: f64| a - b > share * a.abs().max(b.abs()) + self.floor;
        let (realized, planned) = if ends_with_plan {
            (self.realized.total(), self.planned.total())
        } else {
            (self.realized.stage, self.planned.stage)
        };
        if gross(realized, planned) {
            return Some(Note::UnlikePlan { realized, planned, intervals: self.intervals, cause });
        }
        let ((first, last), planned) = (self.ends, self.planned.terminal);
        let stays = !ends_with_plan && last >= BETTER * first && gross(last, planned);
        let cause =
            if matches!(cause, Cause::Plant | Cause::Delay | Cause::Plan) { cause } else { Cause::MovingHorizon };
        stays.then_some(Note::EndCostStays { first, last, planned, cause })
    }
}

/// What costs over some intervals have to differ by to be worth mentioning.
pub(super) fn floor(problem: &ControlProblem, intervals: usize) -> f64 {
    FLOOR * what_scales_cost(&mut problem.ocp.clone(), &problem.initial_state(), &problem.first_input(), intervals)
}

/// What it costs to be off by its scale in every state for some intervals.
fn what_scales_cost(ocp: &mut Ocp, x0: &[f64], u: &[f64], intervals: usize) -> f64 {
    let mut moved = PlannedTrajectory::constant(ocp.steps, x0, u);
    let share = intervals as f64 / ocp.steps as f64;
    let still = ocp.cost(0, &moved);
    let mut sum = 0.0;
    for i in 0..ocp.model_states() {
        for k in 0..=ocp.steps {
            moved.x_mut(k)[i] = x0[i] + ocp.state_scale[i];
        }
        sum += (ocp.cost(0, &moved) - still).abs();
        for k in 0..=ocp.steps {
            moved.x_mut(k)[i] = x0[i];
        }
    }
    if sum.is_finite() { share * sum } else { 0.0 }
}

impl ControlProblem {
    /// Whether the cost of a plan is that of the inputs that are applied: that of a scenario tree is a mean, and inputs of finite
    /// sets are rounded.
    fn is_alone(&self) -> bool {
        self.scenarios.is_none() && !self.has_finite_inputs()
    }
}

fn one_program(problem: &ControlProblem) -> bool {
    matches!(problem.method, Method::Rti { .. })
}

/// Whether plant and controller's model are different.
fn differs(problem: &ControlProblem) -> bool {
    match (problem.plant.to_toml(), problem.system.to_toml()) {
        (Ok(plant), Ok(model)) => plant != model,
        _ => true,
    }
}

/// Whether the inputs act later than the controller takes into account.
fn acts_late(problem: &ControlProblem) -> bool {
    let (delay, compensated) = problem.delay_of_plant();
    delay > compensated as f64 + 0.5
}

/// What probably lies behind a run that does not do what was planned.
fn cause(problem: &ControlProblem, run: &ClosedLoop, planned: bool) -> Cause {
    let exact = matches!(problem.method, Method::StickSlip { .. });
    if acts_late(problem) {
        Cause::Delay
    } else if !planned {
        Cause::Plan
    } else if differs(problem) {
        Cause::Plant
    } else if run.counts.inaccurate > run.counts.solved {
        Cause::Inaccurate
    } else if !exact && has_friction(&problem.system) {
        Cause::SmoothedFriction
    } else if one_program(problem) {
        Cause::OneProgram
    } else {
        Cause::LocalMinimum
    }
}
