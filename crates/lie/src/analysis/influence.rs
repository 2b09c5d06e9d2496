//! In which round of brackets each state comes under the influence of the inputs.

use bracketry_symbolic::{Bindings, Expr, Function, Node, Pool, Symbol};
use serde::Serialize;

use crate::algebra::closure::Closure;
use crate::modes::Signs;
use crate::residues::{Echelon, Fp, OFFSET, times, unit_row};

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
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// The state or the function.
    pub function: Function,
    /// Whether it is a state.
    pub is_state: bool,
    /// Entry k: what the brackets of the first k rounds do to it.
    pub influence: Vec<Influence>,
}

/// The rounds of one subject: a mode, or all modes together.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachTable {
    /// The mode; without signs for a smooth system and for all modes together.
    pub signs: Signs,
    /// Whether the fields of all modes together are meant.
    pub all_modes: bool,
    /// How many of the modes have the same table; 1 for a smooth system and for all modes together.
    pub alike: usize,
    /// States first, functions after them.
    pub rows: Vec<Reached>,
}

/// More states than this make no readable table.
const MOST_STATES: usize = 40;
/// Seed of the generic point.
const SEED: u64 = 0x6272_6163_6b65_7407;

/// What the rounds of the strong accessibility algebra do to each state and to further functions, at a generic point;
/// `None` if that is undecided or there are more than 40 states.
pub(crate) fn influence(
    pool: &mut Pool,
    states: &[Symbol],
    strong: &Closure,
    functions: &[Expr],
    bindings: &Bindings,
) -> Option<Vec<Reached>> {
    let n = states.len();
    if n > MOST_STATES {
        return None;
    }
    // A state has its row already.
    let functions: Vec<Expr> =
        functions.iter().copied().filter(|&e| !matches!(pool.node(e), Node::Sym(s) if states.contains(&s))).collect();
    let gradients: Vec<Expr> = functions.iter().flat_map(|&e| pool.gradient(e, states)).collect();
    let samples = pool.sample_in::<OFFSET>(&[strong.basis.concat(), gradients].concat(), bindings, 1, SEED).ok()?;
    if samples.ambiguous_signs > 0 {
        return None;
    }
    let rows: Vec<Vec<Fp>> = samples.values[0].chunks(n).map(<[Fp]>::to_vec).collect();
    let (basis, gradients) = rows.split_at(strong.basis.len());
    let spans: Vec<Echelon> = strong.growth.iter().map(|&known| Echelon::new(&basis[..known], n)).collect();
    // How each covector changes along the fields of each round.
    let of = |covector: &[Fp], free: &dyn Fn(&Echelon) -> bool| -> Vec<Influence> {
        let along = times(basis, covector);
        let round = |(&known, span): (&usize, &Echelon)| match along[..known].iter().any(|x| !x.is_zero()) {
            false => Influence::None,
            true if free(span) => Influence::Free,
            true => Influence::Moves,
        };
        strong.growth.iter().zip(&spans).map(round).collect()
    };
    let mut table = Vec::new();
    for (i, &s) in states.iter().enumerate() {
        let unit = unit_row(i, n);
        let influence = of(&unit, &|span| span.contains(&unit));
        let e = pool.sym(s);
        table.push(Reached { function: Function::new(pool, e), is_state: true, influence });
    }
    for (&e, gradient) in functions.iter().zip(gradients) {
        // In all directions there is one that moves this function alone.
        let influence = of(gradient, &|span| span.rank() == n);
        table.push(Reached { function: Function::new(pool, e), is_state: false, influence });
    }
    Some(table)
}
