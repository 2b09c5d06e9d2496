//! In which round of brackets each state comes under the influence of the inputs.

use bracketry_lie::{Evidence, Field, ModeFields, VectorFields, mode_fields};
use bracketry_symbolic::{Expr, Pool};
use serde::Serialize;

use crate::Analysis;

/// What the inputs do to a function of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Influence {
    /// Nothing.
    None,
    /// They change it, and other states with it.
    Moves,
    /// They can change this state while all others stay as they are: ∂/∂x_i lies in the span.
    Free,
}

/// A state, or a function that no input influences within one mode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reached {
    /// The state or the function.
    pub name: String,
    /// Whether it is a function found by the analysis and not a state of the model.
    pub function: bool,
    /// Entry k: what the brackets of the first k rounds do to it.
    pub influence: Vec<Influence>,
}

/// The rounds of one subject: a mode, or all modes together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReachTable {
    /// Signs of the mode as a text; none for a smooth system and for all modes together.
    pub mode: Option<String>,
    /// Whether the fields of all modes together are meant.
    pub all_modes: bool,
    /// How many of the modes have the same table; 1 for a smooth system and for all modes together.
    pub alike: usize,
    /// States first, functions after them.
    pub rows: Vec<Reached>,
}

/// More states than this make no readable table.
const MOST_STATES: usize = 40;

impl Analysis {
    /// In which round of brackets each state, and each function that no input influences within a mode, comes under the
    /// influence of the inputs: for the first mode and, where the system switches, for all modes together. Generic, as
    /// the ranks; empty where something cannot be decided or there are more than 40 states.
    ///
    /// ```
    /// use bracketry::Influence::{Free, Moves, None};
    /// use bracketry::system::System;
    /// let text = "states = ['p', 'v']\ninputs = ['u']\ndynamics = { p = 'v', v = 'u' }";
    /// let cart = System::parse("cart", text).unwrap();
    /// let table = &bracketry::analyze(&cart, &Default::default()).unwrap().reach()[0];
    /// assert_eq!(table.rows[0].influence, [None, Free]); // p: by [f, g1]
    /// assert_eq!(table.rows[1].influence, [Free, Free]); // v: by g1 itself
    /// ```
    pub fn reach(&self) -> Vec<ReachTable> {
        if self.states > MOST_STATES {
            return Vec::new();
        }
        let mut system = self.affinization.model.clone();
        let Ok(modes) = mode_fields(&mut system) else { return Vec::new() };
        let names = system.state_names();
        let pool = &mut system.pool;
        let functions: Vec<(String, Expr)> = self.report.modes[..1]
            .iter()
            .filter_map(|m| m.autonomous.known())
            .flatten()
            // A state has its row already.
            .filter(|f| !names.contains(f))
            .filter_map(|f| Some((f.clone(), pool.parse(f).ok()?)))
            .collect();
        let mut tables = Vec::new();
        if let Some(rows) = modes.first().and_then(|m| rows(pool, &m.fields, &names, &functions)) {
            let first = &self.report.modes[0];
            let alike = |m: &&bracketry_lie::ModeReport| {
                m.dimensions.strong_growth == first.dimensions.strong_growth && m.autonomous == first.autonomous
            };
            let alike = self.report.modes.iter().filter(alike).count();
            tables.push(ReachTable { mode: modes.first().and_then(mode_name), all_modes: false, alike, rows });
        }
        if modes.len() > 1 {
            let family: Vec<VectorFields> = modes.into_iter().map(|m| m.fields).collect();
            let all = VectorFields::switched(pool, &family).ok();
            if let Some(rows) = all.and_then(|all| rows(pool, &all, &names, &functions)) {
                tables.push(ReachTable { mode: None, all_modes: true, alike: 1, rows });
            }
        }
        tables
    }
}

fn mode_name(m: &ModeFields) -> Option<String> {
    let signs: Vec<String> = m.signs.iter().map(|(s, v)| format!("{s} {} 0", if *v > 0 { ">" } else { "<" })).collect();
    (!signs.is_empty()).then(|| signs.join(", "))
}

/// What the rounds of the strong accessibility algebra do to each state and function; none if that is undecided.
fn rows(
    pool: &mut Pool,
    fields: &VectorFields,
    names: &[String],
    functions: &[(String, Expr)],
) -> Option<Vec<Reached>> {
    let closure = fields.strong_accessibility(pool, &mut Evidence::default()).ok()?;
    let zero = pool.int(0);
    let one = pool.int(1);
    let mut out = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let unit: Field = (0..names.len()).map(|k| if k == i { one } else { zero }).collect();
        let mut influence = Vec::new();
        for &known in &closure.growth {
            let mut span = closure.basis[..known].to_vec();
            let moved: Field = span.iter().map(|b| b[i]).collect();
            let state = if !nonzero(pool, &moved, fields)? {
                Influence::None
            } else if influence.last() == Some(&Influence::Free) || {
                span.push(unit.clone());
                pool.rank(&span, &fields.bindings).ok()?.rank == known
            } {
                Influence::Free
            } else {
                Influence::Moves
            };
            influence.push(state);
        }
        out.push(Reached { name: name.clone(), function: false, influence });
    }
    for (name, function) in functions {
        let along: Field = closure.basis.iter().map(|b| pool.lie_derivative(*function, &fields.states, b)).collect();
        let mut influence = Vec::new();
        for &known in &closure.growth {
            let moves = nonzero(pool, &along[..known], fields)?;
            influence.push(match moves {
                // In all directions there is one that moves this function alone.
                true if known == names.len() => Influence::Free,
                true => Influence::Moves,
                false => Influence::None,
            });
        }
        out.push(Reached { name: name.clone(), function: true, influence });
    }
    Some(out)
}

/// Whether any of the functions is not zero at a generic point; none if that is undecided.
fn nonzero(pool: &mut Pool, functions: &[Expr], fields: &VectorFields) -> Option<bool> {
    if functions.is_empty() {
        return Some(false);
    }
    Some(pool.rank(&[functions.to_vec()], &fields.bindings).ok()?.rank > 0)
}
