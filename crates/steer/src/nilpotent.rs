//! Steering by Philip Hall coordinates (Lafferriere and Sussmann 1991).
//!
//! The extended system x' = Σ vᵢ Bᵢ(x), with an input for every bracket Bᵢ of a Hall basis, follows the straight line to the end. Its
//! series up to the degree of the basis is written as a product of flows of single input fields: piecewise constant inputs. For a
//! nilpotent system that is exact; for others, rounds from where the one before ended come closer each time.

use bracketry_lie::algebra::HallBasis;
use bracketry_lie::analysis::ModeFields;
use bracketry_lie::{Evidence, Undecided};
use bracketry_numerics::least_squares::Factored;
use bracketry_sim::Hold;
use bracketry_symbolic::{Expr, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::chained::values;
use crate::hall_algebra::{HallAlgebra, Series, Step};
use crate::problem::{Outcome, Planned, Problem};
use crate::roll_out::{RollOut, distance};
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// Longest brackets, and most elements of a basis.
const MAX_DEGREE: usize = 6;
const MAX_ELEMENTS: usize = 40;
/// Steps along the straight line.
const STEPS: usize = 400;
/// Rounds toward the end.
const MAX_ROUNDS: usize = 60;
/// Ways around where the brackets span too little.
const DETOURS: usize = 12;
/// Most pieces of constant input.
const MAX_PIECES: usize = 3000;
/// Below this end error a Newton correction takes over.
const NEAR: f64 = 1e-3;
/// Singular values below this part of the largest are taken for zero.
const RANK: f64 = 1e-9;

/// The brackets of a Hall basis, compiled.
struct Brackets {
    algebra: HallAlgebra,
    tape: Tape,
    /// Elements whose fields are not zero.
    present: Vec<usize>,
    is_nilpotent: bool,
    states: usize,
}

/// Plans piecewise constant inputs for a model without drift.
pub(crate) fn plan(problem: &Problem, mode: &ModeFields, system: &mut System, plant: &mut RollOut) -> Outcome {
    let brackets = brackets(mode, system)?;
    let (from, to, inputs) = (&problem.options.from, &problem.options.to, system.inputs.len());
    let mut best = approach(problem, &brackets, plant, from, to);
    let mut random = StdRng::seed_from_u64(problem.options.seed);
    // Where the brackets span too little along the line, both ends move aside by the same inputs, which are taken back at last.
    for k in 0..DETOURS {
        if best.error < NEAR || problem.is_over() {
            break;
        }
        let aside: Vec<Step> = (0..inputs)
            .map(|j| (j, random.random_range(0.3..1.0) * if (k >> (j % 2)) & 1 == 0 { 1.0 } else { -1.0 }))
            .collect();
        let signals = pieces(problem, inputs, &aside);
        let (Some(a), Some(b)) = (plant.end(from, &signals), plant.end(to, &signals)) else { continue };
        let found = approach(problem, &brackets, plant, &a, &b);
        let back: Vec<Step> = aside.iter().rev().map(|&(j, a)| (j, -a)).collect();
        let steps = [aside, found.steps, back].concat();
        let end = plant.end(from, &pieces(problem, inputs, &steps));
        let error = end.map_or(f64::INFINITY, |end| distance(&end, to));
        if error < best.error {
            best = Approach { steps, rounds: found.rounds, error };
        }
    }
    if best.steps.is_empty() && best.error <= problem.options.tolerance {
        let signals = Signals { times: vec![0.0, 1.0], values: vec![vec![0.0; inputs]; 2], hold: Hold::Previous };
        let (degree, is_nilpotent) = (brackets.algebra.degree, brackets.is_nilpotent);
        let plan = Plan::Nilpotent { degree, is_nilpotent, rounds: 0, pieces: 0 };
        return Ok(vec![Planned { signals, plan }]);
    }
    if best.steps.is_empty() {
        let stopped = problem.is_over();
        return Err(if stopped { SteerReason::Stopped } else { SteerReason::EndError { error: best.error } });
    }
    let signals = pieces(problem, inputs, &best.steps);
    if let Some(input) = problem.ranges.one_sided(&signals) {
        return Err(SteerReason::OneSided { input: system.input_names()[input].clone() });
    }
    let (degree, is_nilpotent) = (brackets.algebra.degree, brackets.is_nilpotent);
    let plan = Plan::Nilpotent { degree, is_nilpotent, rounds: best.rounds, pieces: signals.times.len() - 1 };
    Ok(vec![Planned { signals, plan }])
}

/// Flows from one state toward another, and how far from it they end.
struct Approach {
    steps: Vec<Step>,
    rounds: usize,
    error: f64,
}

/// Rounds along straight lines, each from where the one before ended.
fn approach(problem: &Problem, brackets: &Brackets, plant: &mut RollOut, from: &[f64], goal: &[f64]) -> Approach {
    let inputs = brackets.algebra.letters;
    let mut x = from.to_vec();
    let mut error = distance(&x, goal);
    let (mut steps, mut rounds, mut part) = (Vec::<Step>::new(), 0, 1.0f64);
    while error > problem.options.tolerance * 0.1 && rounds < MAX_ROUNDS && !problem.is_over() {
        rounds += 1;
        let target: Vec<f64> = x.iter().zip(goal).map(|(x, g)| x + part * (g - x)).collect();
        let reached = brackets.line(&x, &target).and_then(|series| {
            let flows = brackets.algebra.flows(&series);
            let signals = pieces(problem, inputs, &flows);
            let end = if flows.is_empty() { Some(x.clone()) } else { plant.end(&x, &signals) };
            end.map(|end| (flows, end))
        });
        // A round that does not come much closer is repeated toward a nearer point.
        match reached {
            Some((flows, end)) if distance(&end, goal) <= (1.0 - 0.3 * part) * error => {
                steps.extend(flows);
                x = end;
                error = distance(&x, goal);
                part = (2.0 * part).min(1.0);
            }
            _ => part *= 0.5,
        }
        if part < 1e-3 || steps.len() > MAX_PIECES || (error < NEAR && steps.len() > 100) {
            break;
        }
    }
    Approach { steps, rounds, error }
}

/// The shortest basis that spans all directions at a generic point, and all brackets of a nilpotent system.
fn brackets(mode: &ModeFields, system: &mut System) -> Result<Brackets, SteerReason> {
    let (n, m) = (system.states.len(), system.inputs.len());
    let fields = &mode.fields;
    let (mut degree, mut dimension, mut spanned) = (0, 0, None);
    let mut kept: Vec<Vec<Expr>> = Vec::new();
    let mut is_nilpotent = false;
    for d in 1..=MAX_DEGREE + 1 {
        let Ok(basis) = HallBasis::new(m, d) else { break };
        if basis.len() > MAX_ELEMENTS && d > 2 {
            break;
        }
        let all = match basis.fields(&mut system.pool, &fields.states, &fields.controls) {
            Ok(all) => all,
            Err(_) if spanned.is_some() => break,
            Err(why) => return Err(SteerReason::Undecided(why)),
        };
        let mut longest_vanish = true;
        for i in basis.of_length(d) {
            longest_vanish &= all[i].iter().all(|&e| system.pool.zero_test(e, &fields.bindings).is_zero());
        }
        if longest_vanish {
            is_nilpotent = true;
            break;
        }
        if d > MAX_DEGREE {
            break;
        }
        // Brackets longer than needed serve only where no longer ones follow.
        (degree, kept) = (d, all);
        if spanned.is_none() {
            dimension = rank(system, mode, &kept).map_err(SteerReason::Undecided)?;
            if dimension == n {
                spanned = Some((d, kept.clone()));
            }
        }
    }
    let Some((shortest, shorter)) = spanned else {
        return Err(SteerReason::Brackets { dimension, states: n, degree });
    };
    if !is_nilpotent {
        (degree, kept) = (shortest, shorter);
    }
    let algebra = HallAlgebra::new(m, degree).ok_or(SteerReason::Brackets { dimension, states: n, degree })?;
    let present: Vec<usize> = (0..kept.len()).filter(|&i| kept[i].iter().any(|&e| !system.pool.is_zero(e))).collect();
    let flat: Vec<Expr> = present.iter().flat_map(|&i| kept[i].clone()).collect();
    let tape = system.compile(&system.states, &flat).map_err(|_| SteerReason::NotAffine)?;
    Ok(Brackets { algebra, tape, present, is_nilpotent, states: n })
}

fn rank(system: &mut System, mode: &ModeFields, rows: &[Vec<Expr>]) -> Result<usize, Undecided> {
    let rank = system.pool.rank(rows, &mode.fields.bindings)?;
    Evidence::default().add(&rank.certificate);
    Ok(rank.rank)
}

impl Brackets {
    /// The series of the extended system along the straight line; `None` where the brackets do not span it.
    fn line(&self, from: &[f64], to: &[f64]) -> Option<Series> {
        let direction: Vec<f64> = from.iter().zip(to).map(|(a, b)| b - a).collect();
        let rate_at = |s: f64| -> Option<Series> {
            let x: Vec<f64> = from.iter().zip(&direction).map(|(a, d)| a + s * d).collect();
            let v = self.inputs(&x, &direction)?;
            let mut rate = Series::zero(self.algebra.letters, self.algebra.degree);
            for (&i, v) in self.present.iter().zip(&v) {
                rate = rate.plus(*v, &self.algebra.elements[i]);
            }
            Some(rate)
        };
        let h = 1.0 / STEPS as f64;
        let mut series = Series::one(self.algebra.letters, self.algebra.degree);
        let mut left = rate_at(0.0)?;
        for k in 0..STEPS {
            let s = k as f64 * h;
            let (middle, right) = (rate_at(s + h / 2.0)?, rate_at(s + h)?);
            let k1 = series.product(&left);
            let k2 = series.plus(h / 2.0, &k1).product(&middle);
            let k3 = series.plus(h / 2.0, &k2).product(&middle);
            let k4 = series.plus(h, &k3).product(&right);
            series = series.plus(h / 6.0, &k1).plus(h / 3.0, &k2).plus(h / 3.0, &k3).plus(h / 6.0, &k4);
            left = right;
        }
        Some(series)
    }

    /// Inputs of the extended system that move x along a direction, those of least norm.
    fn inputs(&self, x: &[f64], direction: &[f64]) -> Option<Vec<f64>> {
        let matrix = DMatrix::from_vec(self.states, self.present.len(), values(&self.tape, x));
        let right = DVector::from_column_slice(direction);
        let v = Factored::new(&matrix, RANK)?.solve(&right, 0.0);
        let left = (&matrix * &v - &right).amax();
        (left <= 1e-7 * right.amax().max(1e-12)).then(|| v.iter().copied().collect())
    }
}

/// Flows one after the other, each with the speed that the range of its input allows, 1 without a range.
fn pieces(problem: &Problem, inputs: usize, steps: &[Step]) -> Signals {
    let mut signals = Signals { times: vec![0.0], values: Vec::new(), hold: Hold::Previous };
    let mut t = 0.0;
    for &(letter, a) in steps {
        let limit = problem.ranges.limit(letter, a > 0.0);
        let speed = if limit.is_finite() && limit > 0.0 { limit } else { 1.0 };
        let mut row = vec![0.0; inputs];
        row[letter] = speed * a.signum();
        t += a.abs() / speed;
        signals.times.push(t);
        signals.values.push(row);
    }
    signals.values.push(vec![0.0; inputs]);
    signals
}
