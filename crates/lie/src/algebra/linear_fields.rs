//! Linear systems as sparse matrices.

use bracketry_symbolic::{Expr, Node, Pool, Rational};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;

/// Most nodes that are visited to read one rate; shared sums may be visited often.
const MAX_VISITS: usize = 1_000_000;

/// The fields of x' = A x + d + B u, with rational entries; d is not kept.
pub(crate) struct LinearFields {
    /// The columns of A: row and entry.
    pub(crate) columns: Vec<Vec<(usize, Rational)>>,
    /// The columns of B.
    pub(crate) inputs: Vec<Vec<(usize, Rational)>>,
}

impl LinearFields {
    /// None where the fields are not seen to be of this form, parameters at their values.
    pub(crate) fn of(pool: &Pool, fields: &VectorFields) -> Option<Self> {
        let n = fields.states.len();
        let place: FxHashMap<_, _> = fields.states.iter().enumerate().map(|(j, &s)| (s, j)).collect();
        let roots: Vec<Expr> = fields.drift.iter().chain(fields.controls.iter().flatten()).copied().collect();
        let constants = constants(pool, &roots, fields);
        let mut linear = LinearFields { columns: vec![Vec::new(); n], inputs: Vec::new() };
        for (i, &rate) in fields.drift.iter().enumerate() {
            let mut row: FxHashMap<usize, Rational> = FxHashMap::default();
            let (mut pending, mut visits) = (vec![(rate, Rational::ONE)], 0);
            while let Some((e, factor)) = pending.pop() {
                visits += 1;
                if visits > MAX_VISITS {
                    return None;
                }
                if constants.contains_key(&e) {
                    continue;
                }
                match pool.node(e) {
                    Node::Sym(s) => *row.entry(*place.get(&s)?).or_insert(Rational::ZERO) += factor,
                    Node::Add(a, b) => pending.extend([(a, factor.clone()), (b, factor)]),
                    Node::Mul(a, b) => match (constants.get(&a), constants.get(&b)) {
                        (Some(c), _) => pending.push((b, factor * c)),
                        (_, Some(c)) => pending.push((a, factor * c)),
                        _ => return None,
                    },
                    _ => return None,
                }
            }
            for (j, c) in row.into_iter().filter(|(_, c)| *c != Rational::ZERO) {
                linear.columns[j].push((i, c));
            }
        }
        for control in &fields.controls {
            let entries = control.iter().enumerate().map(|(i, e)| Some((i, constants.get(e)?.clone())));
            let column: Option<Vec<_>> = entries.collect();
            linear.inputs.push(column?.into_iter().filter(|(_, c)| *c != Rational::ZERO).collect());
        }
        Some(linear)
    }
}

/// The values of all nodes below `roots` that have rational ones.
fn constants(pool: &Pool, roots: &[Expr], fields: &VectorFields) -> FxHashMap<Expr, Rational> {
    let mut values: FxHashMap<Expr, Rational> = FxHashMap::default();
    for e in pool.reachable(roots) {
        let value = match pool.node(e) {
            Node::Num(_) => pool.number(e).cloned(),
            Node::Sym(s) if !fields.states.contains(&s) => fields.bindings.get(s).cloned(),
            Node::Add(a, b) => values.get(&a).zip(values.get(&b)).map(|(a, b)| a + b),
            Node::Mul(a, b) => values.get(&a).zip(values.get(&b)).map(|(a, b)| a * b),
            Node::Pow(a, k) => values.get(&a).zip(pool.integer(k)).and_then(|(a, k)| power(a, k)),
            Node::Pi | Node::Sym(_) | Node::Call(..) | Node::Call2(..) => None,
        };
        if let Some(value) = value {
            values.insert(e, value);
        }
    }
    values
}

/// Largest exponent, in size, of which a power is formed.
const MAX_EXPONENT: i64 = 64;

fn power(base: &Rational, k: i64) -> Option<Rational> {
    if k.abs() > MAX_EXPONENT || k < 0 && *base == Rational::ZERO {
        return None;
    }
    Some(base.pow(isize::try_from(k).ok()?))
}
