//! Exact points on a set of parameters, and where equations have no value.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, SplitMix64, Symbol};
use rustc_hash::FxHashMap;
use serde::{Serialize, Serializer};

use crate::algebra::rational::parametric::{expression, quotient};
use crate::algebra::rational::polynomial::Budget;
use crate::evidence::Evidence;
use crate::parameters::aspect::{Aspect, AspectValue, Subject};
use crate::parameters::factor::factors;
use crate::parameters::state_values::StateValues;

/// Values of the parameters by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Confirmed(pub Vec<(String, Rational)>);

impl Confirmed {
    /// Whether there is no point.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for Confirmed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value.to_string())))
    }
}

/// Points that are tried.
const TRIES: u64 = 4;

/// A random rational point of the set {parameter = function of the others} at which the analysis gives the value.
pub(crate) fn point_with(
    pool: &mut Pool,
    subject: &Subject,
    aspect: Aspect,
    value: &AspectValue,
    symbols: &[Symbol],
    solved: &[(Symbol, Expr)],
    evidence: &mut Evidence,
) -> Confirmed {
    for seed in 1..=TRIES {
        let mut random = SplitMix64::new(seed);
        let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
        for &s in symbols.iter().filter(|s| !solved.iter().any(|x| x.0 == **s)) {
            let (x, n) = (pool.sym(s), random.integer(1, 29));
            values.insert(x, pool.ratio(n, 7));
        }
        let given = values.clone();
        let mut rational = true;
        for &(s, e) in solved {
            let number = pool.substitute(e, &given);
            let number = pool.simplify(number);
            rational &= pool.number(number).is_some();
            let x = pool.sym(s);
            values.insert(x, number);
        }
        if !rational {
            continue;
        }
        let there = subject.with(pool, &values);
        if there.generic(pool, aspect, evidence).is_ok_and(|g| g.value == *value) {
            let mut list = Vec::new();
            for &s in symbols {
                let x = pool.sym(s);
                if let Some(v) = pool.number(values[&x]) {
                    list.push((pool.name(s).to_owned(), v.clone()));
                }
            }
            return Confirmed(list);
        }
    }
    Confirmed::default()
}

/// Functions of the parameters whose zeros leave the equations without a value for all states: factors of denominators as they are
/// written, also of those that would cancel, arguments of logarithms, and what denominators have in common at different states.
pub(crate) fn undefined_factors(pool: &mut Pool, subject: &Subject, symbols: &[Symbol]) -> Vec<Expr> {
    let roots = subject.roots();
    let mut budget = Budget::new(100_000);
    let mut list = written(pool, &roots, symbols, &mut budget);
    let Ok(values) = StateValues::new(pool, &subject.fields.states, &roots) else { return list };
    let maps = [values.draw(pool, 101), values.draw(pool, 102)];
    for &root in &roots {
        let mut common: Option<Vec<_>> = None;
        for map in &maps {
            let e = pool.substitute(root, map);
            let Some((_, bottom)) = quotient(pool, e, symbols, &mut budget) else { return list };
            let Some(found) = factors(&bottom, &mut budget) else { return list };
            common = Some(match common {
                None => found,
                Some(old) => old.into_iter().filter(|f| found.contains(f)).collect(),
            });
        }
        for f in common.unwrap_or_default() {
            let e = expression(pool, &f.polynomial, symbols);
            if !list.contains(&e) {
                list.push(e);
            }
        }
    }
    list
}

/// Factors of the denominators, and arguments of logarithms, that hold parameters alone.
fn written(pool: &mut Pool, roots: &[Expr], symbols: &[Symbol], budget: &mut Budget) -> Vec<Expr> {
    let mut list = Vec::new();
    for node in pool.reachable(roots) {
        let base = match pool.node(node) {
            Node::Pow(base, k) if pool.number(k).is_some_and(|k| *k < Rational::ZERO) => base,
            Node::Call(Func::Log, argument) => argument,
            _ => continue,
        };
        let used = pool.symbols_of(&[base]);
        if used.is_empty() || !used.iter().all(|s| symbols.contains(s)) {
            continue;
        }
        let top = quotient(pool, base, symbols, budget).map(|q| q.0);
        let found = match top.and_then(|top| factors(&top, budget)) {
            Some(found) => found.iter().map(|f| expression(pool, &f.polynomial, symbols)).collect(),
            None => vec![base],
        };
        for e in found {
            if !list.contains(&e) {
                list.push(e);
            }
        }
    }
    list
}
