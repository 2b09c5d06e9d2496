//! What is found in a run, whatever its costs: values that are not finite, samples without a good solution, a problem that says
//! something else than its model.

use super::control_problem::ControlProblem;
use super::estimates::estimate_off;
use super::notes::{FirstSample, Note};
use crate::closed_loop::ClosedLoop;
use crate::controller::{FallbackReason, StepStatus};
use crate::error::MpcError;
use crate::ocp::Softness;
use bracketry_system::System;

/// What the controller is told of inputs that act later than they are commanded.
fn note_on_delays(problem: &ControlProblem) -> Option<Note> {
    let longest = |system: &System| system.delay_values().into_iter().flatten().fold(0.0, f64::max);
    let (plant, model) = (longest(&problem.plant), longest(&problem.system));
    let (samples, compensated) = problem.delay_of_plant();
    // A delay of the run that the controller predicts over is as it should be.
    let of_run = problem.conditions.delay > 0 && !problem.conditions.compensate_delay;
    (plant > 0.0 || model > 0.0 || of_run).then_some(Note::Delays {
        longest: samples * problem.ocp.dt,
        samples,
        compensated,
    })
}

/// Tables that end before the last sample.
fn notes_on_tables(problem: &ControlProblem) -> impl Iterator<Item = Note> {
    let dt = problem.ocp.dt;
    let (last_sample, end) = ((problem.samples - 1) as f64 * dt, problem.samples as f64 * dt);
    let tables = problem.schedule.parameters.iter().chain(&problem.schedule.references);
    // Times are rounded.
    let short = tables
        .clone()
        .filter(|s| !s.one_row)
        .filter_map(move |s| Some((s, s.last.filter(|last| *last < last_sample - 1e-6 * dt)?)));
    let one_row = tables.clone().filter(|s| s.one_row).map(|s| Note::OneRow { name: s.name.clone() });
    one_row.chain(short.map(move |(s, last)| Note::TableEnds { name: s.name.clone(), last, end }))
}

/// Hard bounds that the initial state violates.
fn notes_on_start(problem: &ControlProblem) -> impl Iterator<Item = Note> {
    let states = problem.system.states.iter().zip(&problem.x0).zip(&problem.ocp.state_bounds);
    let outside = states.filter(|((_, x), b)| b.softness == Softness::Hard && b.violation(**x) > 0.0);
    outside.map(|((s, x), b)| Note::StartsOutside {
        state: problem.system.symbol_name(*s).to_owned(),
        value: *x,
        bounds: (b.min, b.max),
    })
}

/// What went wrong in a run: quantities that are not finite, then samples without a good solution; and what the
/// controller is told of delays.
pub(super) fn findings(problem: &ControlProblem, run: &ClosedLoop, open_loop_cost: f64) -> Vec<Note> {
    let mut notes = problem.remarks.clone();
    let unused = problem.references.iter().filter(|r| !r.used);
    notes.extend(unused.map(|r| Note::UnusedReference { name: r.name.clone() }));
    let sample = |k: usize| FirstSample { index: k, time: run.t[k] };
    let names = problem.system.state_names();
    let mut states = run.x.iter().enumerate();
    if let Some((k, i)) = states.find_map(|(k, x)| x.iter().position(|v| !v.is_finite()).map(|i| (k, i))) {
        notes.push(Note::State { name: names[i].clone(), first: sample(k) });
    }
    notes.extend(problem.system.eliminated.iter().cloned().map(Note::Eliminated));
    notes.extend(note_on_delays(problem));
    notes.extend(estimate_off(problem, run));
    for (j, &bounds) in problem.ocp.input_bounds.iter().enumerate() {
        let Some(range) = problem.system.range_of_input(j) else { continue };
        if bounds.0 < range.0 || bounds.1 > range.1 {
            notes.push(Note::BeyondRange { input: problem.system.input_names()[j].clone(), bounds, range });
        }
    }
    notes.extend(notes_on_tables(problem));
    notes.extend(notes_on_start(problem));
    let last = run.u.last().map_or(&[][..], Vec::as_slice);
    let inputs = run.u.iter().map(Vec::as_slice).chain(std::iter::repeat(last));
    for near in problem.plant.closest_approaches(run.x.iter().map(Vec::as_slice).zip(inputs)) {
        notes.push(Note::Singular { name: near.name, length: near.length, first: sample(near.row) });
    }
    let mut ocp = problem.ocp.clone();
    let mut inputs = run.u.iter().enumerate();
    let x = ocp.with_previous(&run.x, &run.u, &problem.first_input());
    if let Some((k, _)) = inputs.find(|&(k, u)| !ocp.stage_cost(k, run.t[k], &x[k], u).is_finite()) {
        notes.push(Note::StageCost { first: sample(k) });
    }
    if let Some(estimation) = &problem.estimation {
        // What moves nowhere on the way cannot be told; at some points alone anything may be hidden.
        let samples = run.u.len();
        let hidden = [0, samples / 3, 2 * samples / 3]
            .map(|k| estimation.problem.check_observability(&run.x[k], &run.u[k]).err());
        if let [Some(_), Some(_), Some(MpcError::NotObservable { names })] = hidden {
            notes.push(Note::Unobservable { names });
        }
    }
    if !open_loop_cost.is_finite() {
        notes.push(Note::NoPlan);
    }
    // One note per reason, in the order of their appearance.
    let mut fallbacks: Vec<(FallbackReason, usize, usize)> = Vec::new();
    for (k, step) in run.steps.iter().enumerate() {
        if let StepStatus::Fallback(reason) = step.status {
            match fallbacks.iter_mut().find(|f| f.0 == reason) {
                Some(f) => f.1 += 1,
                None => fallbacks.push((reason, 1, k)),
            }
        }
    }
    let fallback = |(reason, count, k)| Note::Fallback { reason, count, first: sample(k) };
    notes.extend(fallbacks.into_iter().map(fallback));
    let first = |status: StepStatus| run.steps.iter().position(|s| s.status == status).map(sample);
    let infeasible = first(StepStatus::Infeasible);
    notes.extend(infeasible.map(|first| Note::Infeasible { count: run.counts.infeasible, first }));
    let inaccurate = first(StepStatus::Inaccurate);
    notes.extend(inaccurate.map(|first| Note::Inaccurate { count: run.counts.inaccurate, first }));
    notes
}
