//! What switching between modes reaches that no mode reaches alone.

use std::sync::Arc;

use bracketry_symbolic::{Expr, Function, Pool};
use serde::Serialize;

use crate::algebra::closure::Closure;
use crate::algebra::field::VectorFields;
use crate::algebra::word::{Bracket, Generator};
use crate::answer::Answer;
use crate::dimensions::Dimensions;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

/// Most functions of single modes that are followed.
const MAX_FUNCTIONS: usize = 40;

/// A function that no input influences in some modes, yet switching between modes does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Switchable {
    /// The function of the state.
    pub function: Function,
    /// The modes in which no input influences it, by number from 1.
    pub modes: Vec<usize>,
    /// The shortest bracket of fields of several modes, or difference of their drifts, that changes it.
    pub reached_by: Bracket,
}

/// All modes together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SwitchedReport {
    /// Generic dimensions.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Independent functions of the state that neither the inputs nor switching influences.
    pub autonomous: Answer<Vec<Function>>,
    /// How many more such functions exist than were found in closed form; absent if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autonomous_not_found: Option<usize>,
    /// Functions that no input influences in single modes and that switching does.
    pub only_by_switching: Answer<Vec<Switchable>>,
}

/// The family `all` of several modes with its strong accessibility distribution and
/// its generators; `in_modes` are the functions that no input influences in each mode.
pub(crate) fn switched_report(
    pool: &mut Pool,
    dimensions: Dimensions,
    all: &VectorFields,
    strong: Result<&Closure, &Undecided>,
    generators: &Arc<[Generator]>,
    in_modes: &[Vec<Expr>],
    evidence: &mut Evidence,
) -> SwitchedReport {
    let mut report = SwitchedReport {
        dimensions,
        autonomous: Answer::Known(Vec::new()),
        autonomous_not_found: None,
        only_by_switching: Answer::Known(Vec::new()),
    };
    let found = strong.map_err(Clone::clone).and_then(|s| all.autonomous(pool, &s.basis, evidence));
    report.autonomous_not_found = found.as_ref().ok().map(|a| a.missing).filter(|&m| m > 0);
    report.autonomous = found.map(|a| Function::list(pool, &a.functions)).into();
    let switchable =
        strong.map_err(Clone::clone).and_then(|s| switchable(pool, all, s, generators, in_modes, evidence));
    report.only_by_switching = switchable.into();
    report
}

fn switchable(
    pool: &mut Pool,
    all: &VectorFields,
    strong: &Closure,
    generators: &Arc<[Generator]>,
    in_modes: &[Vec<Expr>],
    evidence: &mut Evidence,
) -> Result<Vec<Switchable>, Undecided> {
    let mut functions: Vec<(Expr, Vec<usize>)> = Vec::new();
    for (k, list) in in_modes.iter().enumerate() {
        for &phi in list {
            match functions.iter_mut().find(|f| f.0 == phi) {
                Some(f) => f.1.push(k + 1),
                None => functions.push((phi, vec![k + 1])),
            }
        }
    }
    let mut result = Vec::new();
    if functions.is_empty() {
        return Ok(result);
    }
    let brackets = strong.brackets(pool, &all.states, &all.generators(), &all.bindings, evidence)?;
    for (phi, modes) in functions.into_iter().take(MAX_FUNCTIONS) {
        let reached = brackets.iter().zip(&strong.words).find(|(y, _)| {
            let along = pool.lie_derivative(phi, &all.states, y);
            !pool.is_zero(along) && pool.zero_test(along, &all.bindings).is_nonzero()
        });
        if let Some((_, word)) = reached {
            let reached_by = Bracket { word: word.clone(), generators: generators.clone() };
            result.push(Switchable { function: Function::new(pool, phi), modes, reached_by });
        }
    }
    Ok(result)
}
