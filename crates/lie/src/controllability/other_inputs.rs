//! Other values of the inputs at an equilibrium.

use bracketry_symbolic::{Expr, Function, Pool, Rational};

use crate::answer::Answer;
use crate::controllability::at_equilibrium::AtEquilibrium;
use crate::controllability::holding::deviations;
use crate::controllability::input_values::InputValues;
use crate::controllability::linearization::{Linearization, uncontrollable};
use crate::controllability::local_accessibility::Frame;
use crate::evidence::Evidence;
use crate::reason::StabilizableReason;

/// Constants that are added to inputs without a finite range.
const OTHER_VALUES: [(i64, i64); 6] = [(-1, 1), (1, 1), (-10, 1), (10, 1), (-1, 4), (1, 4)];
/// Places within finite ranges.
const PLACES: [f64; 3] = [0.5, 0.25, 0.75];
/// Most choices that are tried.
const MAX_CHOICES: usize = 100;

/// Whether constants added to inputs, which together do not move the state at the point, make all modes that no input reaches decay, with
/// all inputs inside their ranges: x' = x u is stabilized by u = −1.
///
/// Tried are values inside the ranges that hold the point, and constants of the inputs of which each alone does not move the state.
pub(crate) fn with_other_inputs(
    pool: &mut Pool,
    at: &AtEquilibrium,
    evidence: &mut Evidence,
) -> Option<StabilizableReason> {
    let held = deviations(pool, at.frame, at.sides, evidence).ok().flatten();
    for moves in held.into_iter().chain(idle(pool, at)?) {
        if moves.iter().all(|m| pool.is_zero(*m)) {
            continue;
        }
        let values: Vec<Expr> = at.values.iter().zip(&moves).map(|(&u, &c)| pool.add(u, c)).collect();
        if !at.set.inside(pool, at.frame, &values) {
            continue;
        }
        let frame = Frame::new(pool, &at.frame.fields, at.frame.point(), &moves).ok()?;
        let rank = Linearization::at(pool, &frame, evidence).ok()?.controllable().rank();
        if uncontrollable(pool, &frame, rank, evidence).ok()?.decays == Answer::Known(true) {
            let changed = (0..moves.len()).filter(|&i| !pool.is_zero(moves[i])).collect::<Vec<_>>();
            let inputs = changed.into_iter().map(|i| {
                let value = frame.constants_in(pool, values[i]);
                let value = pool.simplify(value);
                (at.set.names[i].clone(), Function::new(pool, value))
            });
            return Some(StabilizableReason::OtherInputs { inputs: inputs.collect() });
        }
    }
    None
}

/// Choices of constants that are added to the inputs whose fields vanish at the point: of one input before those of several.
fn idle(pool: &mut Pool, at: &AtEquilibrium) -> Option<Vec<Vec<Expr>>> {
    let zero = pool.int(0);
    let mut choices = vec![vec![zero; at.inputs.len()]];
    for i in (0..at.inputs.len()).filter(|&i| at.inputs[i].iter().all(|v| v.is_zero())) {
        let mut constants = Vec::new();
        match at.set.values[i].and_then(InputValues::finite) {
            Some((lower, upper)) => {
                for place in PLACES {
                    let value = pool.rational(Rational::simplest_from_f64(lower + place * (upper - lower))?);
                    constants.push(pool.sub(value, at.values[i]));
                }
            }
            None => constants.extend(OTHER_VALUES.map(|(p, q)| pool.ratio(p, q))),
        }
        for k in 0..choices.len() {
            for &c in &constants {
                let mut with = choices[k].clone();
                with[i] = c;
                choices.push(with);
            }
        }
        choices.truncate(MAX_CHOICES);
    }
    choices.sort_by_key(|c| c.iter().filter(|e| **e != zero).count());
    Some(choices)
}
