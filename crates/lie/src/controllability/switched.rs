//! What switching between modes reaches that no mode reaches alone.

use std::sync::Arc;

use bracketry_symbolic::{Expr, Function, Pool};
use serde::Serialize;

use crate::algebra::closure::Closure;
use crate::algebra::field::VectorFields;
use crate::algebra::word::{Bracket, Generator};
use crate::answer::Answer;
use crate::controllability::invariants::glued;
use crate::controllability::occurrence::Occurrence;
use crate::controllability::orbit::{Orbit, Space, SwitchingTheorem};
use crate::controllability::uninfluenced::Reach;
use crate::dimensions::Dimensions;
use crate::evidence::Evidence;
use crate::modes::ModeFields;
use crate::reason::SwitchingReason;
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

/// What is known of all modes, for [`switched_report`].
pub(crate) struct AllModes<'a> {
    pub(crate) modes: &'a [ModeFields],
    pub(crate) reaches: &'a [Reach],
    /// The fields of all modes together.
    pub(crate) all: &'a VectorFields,
    pub(crate) union: &'a Reach,
    /// What the words of the union are made of.
    pub(crate) generators: &'a Arc<[Generator]>,
    pub(crate) occurrence: &'a Occurrence,
    /// The functions that no input influences in each mode.
    pub(crate) in_modes: &'a [Vec<Expr>],
}

/// All modes together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SwitchedReport {
    /// Generic dimensions of the orbit: the states that motions forward and backward in time reach, each mode in its own
    /// region. The lists of growth and of brackets are empty where the fields do not act together.
    #[serde(flatten)]
    pub dimensions: Dimensions,
    /// Which theorem gives the accessible dimension.
    pub accessible_by: SwitchingTheorem,
    /// Which theorem gives the strongly accessible dimension.
    pub strongly_accessible_by: SwitchingTheorem,
    /// Independent functions of the state that neither the inputs nor switching influences.
    pub autonomous: Answer<Vec<Function>>,
    /// How many more such functions exist than were found in closed form; absent if none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autonomous_not_found: Option<usize>,
    /// Functions that no input influences in single modes and that switching does.
    pub only_by_switching: Answer<Vec<Switchable>>,
    /// Those of `autonomous` that never change, where they have one piece for each mode.
    #[serde(skip)]
    pub(crate) invariants: Vec<Invariant>,
}

/// A continuous function that never changes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Invariant {
    pub(crate) whole: Function,
    /// One piece per mode.
    pub(crate) pieces: Vec<Function>,
}

/// What all modes together reach, with functions that stay as they are.
pub(crate) fn switched_report(pool: &mut Pool, given: &AllModes, evidence: &mut Evidence) -> SwitchedReport {
    let orbit = |pool: &mut Pool, strong: bool, evidence: &mut Evidence| {
        let space = Space::new(pool, given.modes, given.occurrence, strong);
        space.map(|s| s.orbit(pool, given.reaches, given.union, evidence))
    };
    let (all, strong) = (orbit(pool, false, evidence), orbit(pool, true, evidence));
    let together = given.union.dimensions(given.generators);
    let single = |mode: usize| given.reaches[mode].dimensions(&of_mode(given.generators, given.modes, mode));
    let (growth, basis, accessible_by, accessible) = match all {
        Some(orbit) => {
            let lists = orbit.lists(&together, &single, &together.accessible_dimension);
            let (growth, basis) = lists.map_or_else(Default::default, |d| (d.growth, d.basis));
            (growth, basis, orbit.theorem, orbit.dimension.into())
        }
        None => (Vec::new(), Vec::new(), SwitchingTheorem::Bounds, Answer::Unknown(SwitchingReason::NoMode.into())),
    };
    let union = given.union.strong.as_ref().map(Closure::dimension).ok();
    let mut by_union = false;
    let (strong_growth, strong_basis, strongly_accessible_by, strongly) = match strong {
        Some(orbit) => {
            let lists = orbit.lists(&together, &single, &together.strongly_accessible_dimension);
            let (growth, basis) = lists.map_or_else(Default::default, |d| (d.strong_growth, d.strong_basis));
            by_union = union.is_some() && orbit.dimension.as_ref().ok() == union.as_ref();
            (growth, basis, orbit.theorem, orbit.dimension.into())
        }
        None => (Vec::new(), Vec::new(), SwitchingTheorem::Bounds, Answer::Unknown(SwitchingReason::NoMode.into())),
    };
    let gain = strongly_accessible_by != SwitchingTheorem::NoGain;
    let known = strongly.clone();
    let dimensions = Dimensions { basis, strong_basis, ..Dimensions::new(growth, accessible, strong_growth, strongly) };
    let mut report = SwitchedReport {
        dimensions,
        accessible_by,
        strongly_accessible_by,
        autonomous: Answer::Known(Vec::new()),
        autonomous_not_found: None,
        only_by_switching: Answer::Known(Vec::new()),
        invariants: Vec::new(),
    };
    match known {
        Answer::Known(dimension) if !by_union => report.keep_glued(pool, given, dimension, gain, evidence),
        Answer::Unknown(why) if given.union.strong.is_ok() => {
            report.autonomous = Answer::Unknown(why.clone());
            report.only_by_switching = Answer::Unknown(why);
        }
        _ => report.of_union(pool, given, evidence),
    }
    report
}

/// The generators of one mode, under the names that they have in the family.
fn of_mode(family: &Arc<[Generator]>, modes: &[ModeFields], mode: usize) -> Arc<[Generator]> {
    let everywhere = |g: Generator| family.contains(&g);
    let number = Some(mode + 1);
    let mut list = Vec::new();
    let drift = Generator::Drift { mode: None };
    list.push(if everywhere(drift) { drift } else { Generator::Drift { mode: number } });
    for input in 1..=modes[mode].fields.controls.len() {
        let plain = Generator::Input { input, mode: None };
        list.push(if everywhere(plain) { plain } else { Generator::Input { input, mode: number } });
    }
    list.into()
}

impl Orbit {
    /// The dimensions whose lists show this one: those of all fields together, or of the mode that has it alone.
    fn lists(
        &self,
        together: &Dimensions,
        single: &dyn Fn(usize) -> Dimensions,
        of_union: &Answer<usize>,
    ) -> Option<Dimensions> {
        let dimension = *self.dimension.as_ref().ok()?;
        if of_union.known() == Some(&dimension) { Some(together.clone()) } else { self.by_mode.map(single) }
    }
}

impl SwitchedReport {
    /// Where the fields of all modes act together.
    fn of_union(&mut self, pool: &mut Pool, given: &AllModes, evidence: &mut Evidence) {
        let strong = given.union.strong.as_ref();
        let found = strong.map_err(Clone::clone).and_then(|s| given.all.autonomous(pool, &s.basis, evidence));
        self.autonomous_not_found = found.as_ref().ok().map(|a| a.missing).filter(|&m| m > 0);
        self.autonomous = found.map(|a| Function::list(pool, &a.functions)).into();
        let switchable = strong
            .map_err(Clone::clone)
            .and_then(|s| switchable(pool, given.all, s, given.generators, given.in_modes, evidence));
        self.only_by_switching = switchable.into();
    }

    /// Where less is reached than by all fields together.
    fn keep_glued(&mut self, pool: &mut Pool, given: &AllModes, dimension: usize, gain: bool, evidence: &mut Evidence) {
        let wanted = given.all.states.len() - dimension;
        match glued(pool, given.modes, given.occurrence, given.in_modes, evidence) {
            Ok(mut found) => {
                found.truncate(wanted);
                let missing = wanted - found.len();
                self.autonomous_not_found = (missing > 0).then_some(missing);
                let functions: Vec<Expr> = found.iter().map(|g| g.whole).collect();
                self.autonomous = Answer::Known(Function::list(pool, &functions));
                // Without inputs sliding was not looked at.
                let steered = |m: &ModeFields| m.fields.controls.iter().flatten().any(|&e| !pool.is_zero(e));
                let steered = given.modes.iter().any(steered);
                let constant = found.iter().filter(|g| g.constant && steered);
                self.invariants = constant
                    .map(|g| Invariant { whole: Function::new(pool, g.whole), pieces: Function::list(pool, &g.pieces) })
                    .collect();
            }
            Err(why) => self.autonomous = Answer::Unknown(why.into()),
        }
        if gain {
            self.only_by_switching = Answer::Unknown(SwitchingReason::FunctionsOpen.into());
        }
    }
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
