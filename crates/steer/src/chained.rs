//! Steering in the chained form.

use bracketry_lie::Evidence;
use bracketry_lie::analysis::ModeFields;
use bracketry_lie::forms::ChainedForm;
use bracketry_sim::Hold;
use bracketry_symbolic::{Expr, Function, Tape};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::chain::{chain_inputs, runge_kutta};
use crate::problem::{Outcome, Planned, Problem};
use crate::roll_out::distance;
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Steps of the motion of one leg, and rows of its inputs.
const STEPS: usize = 400;
/// Most chained forms that are tried.
const MAX_FORMS: usize = 10;
/// Random way points where no form is regular from one end to the other, and how many of them may succeed before the best is taken.
const WAY_POINTS: usize = 60;
const ENOUGH: usize = 6;
/// Most plans that are corrected one after the other.
const PLANS: usize = 8;
/// How far aside z1 swings, relative to a typical size.
const SWINGS: [f64; 11] = [0.0, 0.3, -0.3, 0.7, -0.7, 1.5, -1.5, 3.0, -3.0, 6.0, -6.0];
/// A function of the singular set below this is zero.
const SINGULAR: f64 = 1e-9;
/// A motion whose end is farther away than this, relative to the size of the states, has changed the branch.
const BRANCH: f64 = 1e-3;

/// A chained form compiled: coordinates, and motion with its inputs.
struct Chart {
    coordinates: Tape,
    /// Of states and v: rates of the states, inputs, functions of the singular set.
    motion: Tape,
    functions: Vec<Function>,
    singular: usize,
}

/// A motion in one chart over the time from 0 to 1.
struct Leg {
    chart: usize,
    inputs: Vec<[f64; 2]>,
    cost: f64,
}

/// Plans sinusoids in the chained form of the model.
pub(crate) fn plan(problem: &Problem, mode: &ModeFields, system: &mut System) -> Outcome {
    let known: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let found = mode.fields.chained_forms(&mut system.pool, &known, &mut Evidence::default());
    let found = found.map_err(SteerReason::Undecided)?;
    if let Some(reason) = found.reason {
        return Err(if problem.is_over() { SteerReason::Stopped } else { SteerReason::NoChainedForm(reason) });
    }
    let charts: Vec<Chart> =
        found.forms.iter().take(MAX_FORMS).filter_map(|form| chart(system, &mode.fields.controls, form)).collect();
    let (from, to) = (&problem.options.from, &problem.options.to);
    let direct = legs(problem, &charts, from, to);
    if !direct.is_empty() {
        // Where trailers are pushed, small errors grow: a more expensive plan may be the better one.
        return Ok(direct.into_iter().take(PLANS).map(|leg| joined(&charts, vec![leg], Vec::new())).collect());
    }
    let mut best: Option<(f64, Vec<Leg>, Vec<f64>)> = None;
    let mut successes = 0;
    let mut random = StdRng::seed_from_u64(problem.options.seed);
    let size = distance(from, to).max(0.3);
    for k in 0..WAY_POINTS {
        if problem.is_over() || successes == ENOUGH {
            break;
        }
        let spread = size * 0.15 * (1 + k / 6) as f64 * f64::from(u8::from(k > 0));
        let middle: Vec<f64> =
            from.iter().zip(to).map(|(a, b)| f64::midpoint(*a, *b) + spread * random.random_range(-1.0..1.0)).collect();
        let Some(first) = legs(problem, &charts, from, &middle).into_iter().next() else { continue };
        let Some(second) = legs(problem, &charts, &middle, to).into_iter().next() else { continue };
        successes += 1;
        let cost = first.cost + second.cost;
        if best.as_ref().is_none_or(|b| cost < b.0) {
            best = Some((cost, vec![first, second], middle));
        }
    }
    match best {
        Some((_, legs, middle)) => Ok(vec![joined(&charts, legs, vec![middle])]),
        None if problem.is_over() => Err(SteerReason::Stopped),
        None => Err(SteerReason::Singular),
    }
}

fn chart(system: &mut System, controls: &[Vec<Expr>], form: &ChainedForm) -> Option<Chart> {
    let pool = &mut system.pool;
    // No model can use these names.
    let v = [pool.symbol("first input"), pool.symbol("second input")];
    let inputs = v.map(|s| pool.sym(s));
    let u = form.inputs(pool, inputs)?;
    let mut outputs: Vec<Expr> = (0..system.states.len())
        .map(|i| {
            let terms = [pool.mul(controls[0][i], u[0]), pool.mul(controls[1][i], u[1])];
            pool.add(terms[0], terms[1])
        })
        .collect();
    outputs.extend(u);
    let singular = form.singular_factors.clone()?;
    outputs.extend(&singular);
    let functions = form.coordinates.iter().map(|&e| Function::new(&system.pool, e)).collect();
    let arguments: Vec<_> = system.states.iter().copied().chain(v).collect();
    let coordinates = system.compile(&system.states, &form.coordinates).ok()?;
    let motion = system.compile(&arguments, &outputs).ok()?;
    Some(Chart { coordinates, motion, functions, singular: singular.len() })
}

/// The values of a tape.
pub(crate) fn values(tape: &Tape, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; tape.n_outputs()];
    tape.eval(x, &mut Vec::new(), &mut out);
    out
}

/// Motions from one state to another in any chart, the least expensive first.
fn legs(problem: &Problem, charts: &[Chart], from: &[f64], to: &[f64]) -> Vec<Leg> {
    let mut found: Vec<Leg> = Vec::new();
    for (k, chart) in charts.iter().enumerate() {
        let (start, end) = (values(&chart.coordinates, from), values(&chart.coordinates, to));
        if !start.iter().chain(&end).all(|v| v.is_finite()) {
            continue;
        }
        let typical = distance(&start, &end).max(0.1);
        for swing in SWINGS {
            if problem.is_over() {
                break;
            }
            if let Some((inputs, cost)) = motion(problem, chart, from, to, [&start, &end], swing * typical) {
                found.push(Leg { chart: k, inputs, cost });
            }
        }
        // A chart that is regular everywhere is as good as any.
        if !found.is_empty() && chart.singular == 0 {
            break;
        }
    }
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

/// The inputs of the model along one plan, with their cost ∫|u|² ds; `None` where it leaves the chart.
fn motion(
    problem: &Problem,
    chart: &Chart,
    from: &[f64],
    to: &[f64],
    [start, end]: [&[f64]; 2],
    swing: f64,
) -> Option<(Vec<[f64; 2]>, f64)> {
    let plan = chain_inputs(start, end, swing)?;
    let n = from.len();
    let evaluate = |s: f64, x: &[f64]| {
        let arguments: Vec<f64> = x.iter().copied().chain(plan.at(s)).collect();
        values(&chart.motion, &arguments)
    };
    let signs = |out: &[f64]| -> Option<Vec<bool>> {
        let factors = &out[n + 2..];
        (out.iter().all(|v| v.is_finite()) && factors.iter().all(|f| f.abs() > SINGULAR))
            .then(|| factors.iter().map(|f| *f > 0.0).collect())
    };
    let h = 1.0 / STEPS as f64;
    let mut x = from.to_vec();
    let mut now = evaluate(0.0, &x);
    let component = signs(&now)?;
    let mut inputs = vec![[now[n], now[n + 1]]];
    let mut cost = 0.0;
    for i in 0..STEPS {
        let s = i as f64 * h;
        x = runge_kutta(s, &x, h, |s, x| evaluate(s, x)[..n].to_vec());
        now = evaluate(s + h, &x);
        if signs(&now).as_ref() != Some(&component) {
            return None;
        }
        inputs.push([now[n], now[n + 1]]);
        cost += h * (now[n] * now[n] + now[n + 1] * now[n + 1]);
    }
    let size = to.iter().chain(from).fold(1.0f64, |m, v| m.max(v.abs()));
    let candidate = Signals {
        times: (0..=STEPS).map(|i| i as f64 * h).collect(),
        values: inputs.iter().map(|u| u.to_vec()).collect(),
        hold: Hold::Linear,
    };
    let fits = distance(&x, to) < BRANCH * size && problem.ranges.one_sided(&candidate).is_none();
    fits.then_some((inputs, cost))
}

/// Legs one after the other, each as long as its inputs ask for.
fn joined(charts: &[Chart], legs: Vec<Leg>, way_points: Vec<Vec<f64>>) -> Planned {
    let mut signals = Signals { times: vec![0.0], values: vec![vec![0.0; 2]], hold: Hold::Linear };
    let mut coordinates = Vec::new();
    let mut t = 0.0;
    for leg in legs {
        let length = leg.inputs.iter().flatten().fold(1e-9f64, |most, u| most.max(u.abs()));
        for (i, u) in leg.inputs.iter().enumerate().skip(1) {
            signals.times.push(t + length * i as f64 / STEPS as f64);
            signals.values.push(u.iter().map(|u| u / length).collect());
        }
        t += length;
        coordinates.push(charts[leg.chart].functions.clone());
    }
    Planned { signals, plan: Plan::Chained { coordinates, way_points } }
}
