//! Where new inputs do not determine the old ones.

use std::fmt;

use bracketry_symbolic::{Expr, Func, Function, Node, Rational};
use serde::{Serialize, Serializer};

use crate::images::{flattened, input_domain};
use crate::range::image;
use crate::rational_function::RationalFunction;
use crate::switching::is_switch;
use crate::system::System;
use bracketry_symbolic::RealRoot;

/// Largest minors of the Jacobian that are written out.
const MAX_EXPANDED: usize = 4;

/// Largest number of minors of the Jacobian that are written out.
const MAX_MINORS: usize = 6;

/// Longer conditions, by the characters of their functions, are not given.
const MAX_LENGTH: u64 = 2000;

/// Where new inputs do not determine the old ones locally: of each list, one function takes its value.
#[derive(Clone, Debug, PartialEq)]
pub struct SingularSet(pub Vec<Vec<Level>>);

/// Where a function takes a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The function.
    pub function: Function,
    /// The value.
    pub value: f64,
    /// The exact value, where it is known.
    pub exact: Option<Rational>,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.exact {
            Some(exact) => write!(f, "{} = {exact}", self.function.text()),
            None => write!(f, "{} = {:.6}", self.function.text(), self.value),
        }
    }
}

impl fmt::Display for SingularSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let any = |levels: &Vec<Level>| {
            let text = levels.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or ");
            if self.0.len() > 1 && levels.len() > 1 { format!("({text})") } else { text }
        };
        f.write_str(&self.0.iter().map(any).collect::<Vec<_>>().join(" and "))
    }
}

impl Serialize for SingularSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Where the Jacobian of w with respect to u loses rank; `None` where it never does or no short condition was
/// found.
pub(crate) fn singular_set(system: &mut System, functions: &[Expr]) -> Option<SingularSet> {
    let jacobian = system.pool.jacobian(functions, &system.inputs.clone());
    if functions.len() > MAX_EXPANDED {
        return None;
    }
    let columns = subsets(system.inputs.len(), functions.len(), MAX_MINORS)?;
    let mut conditions: Vec<Vec<Level>> = Vec::new();
    for chosen in columns {
        let minor: Vec<Vec<Expr>> = jacobian.iter().map(|row| chosen.iter().map(|&j| row[j]).collect()).collect();
        let d = system.pool.determinant(&minor, |_, e| e);
        let d = system.pool.simplify(d);
        if system.pool.is_zero(d) {
            continue;
        }
        if system.pool.reachable(&[d]).into_iter().any(|n| is_switch(system.pool.node(n))) {
            return None;
        }
        let mut factors: Vec<Level> = Vec::new();
        for f in flattened(&system.pool, d, false) {
            factors.extend(zeros(system, f));
        }
        if factors.is_empty() {
            return None;
        }
        factors.dedup();
        if !conditions.contains(&factors) {
            conditions.push(factors);
        }
    }
    let lengths = conditions.iter().flatten().map(|l| l.function.pool().text_size(l.function.expr()).length);
    (!conditions.is_empty() && lengths.fold(0, u64::saturating_add) < MAX_LENGTH).then_some(SingularSet(conditions))
}

/// The conditions, one of which holds where the factor vanishes; none if it vanishes nowhere.
fn zeros(system: &mut System, factor: Expr) -> Vec<Level> {
    let base = match system.pool.node(factor) {
        Node::Pow(a, k) => match system.pool.number(k) {
            Some(k) if *k < Rational::ZERO => return Vec::new(),
            Some(_) => a,
            None => factor,
        },
        Node::Call(Func::Exp | Func::Cosh, _) => return Vec::new(),
        _ => factor,
    };
    let value = system.with_values(&[base])[0];
    let uses = system.pool.symbols_of(&[value]);
    if uses.is_empty() {
        return Vec::new();
    }
    if let [u] = uses[..]
        && let Some(f) = RationalFunction::of(&mut system.pool, value, u)
        && let Some(zeros) = f.zeros_of_input()
    {
        let input = system.pool.sym(u);
        let function = Function::new(&system.pool, input);
        let level = |x: RealRoot| Level { function: function.clone(), value: x.value, exact: x.exact };
        return zeros.into_iter().map(level).collect();
    }
    let domain = input_domain(system);
    let nowhere = image(&mut system.pool, value, &domain)
        .is_ok_and(|i| i.lower.value > 0.0 || i.upper.value < 0.0 || i.excludes_zero_at_end());
    if nowhere {
        return Vec::new();
    }
    vec![Level { function: Function::new(&system.pool, base), value: 0.0, exact: Some(Rational::ZERO) }]
}

/// The subsets of k of n numbers, if they are not too many.
fn subsets(n: usize, k: usize, most: usize) -> Option<Vec<Vec<usize>>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for i in 0..n {
        let more: Vec<Vec<usize>> =
            all.iter().filter(|s| s.len() < k).map(|s| s.iter().copied().chain([i]).collect()).collect();
        all.extend(more);
        all.retain(|s| s.len() + (n - 1 - i) >= k);
        if all.len() > 4 * most {
            return None;
        }
    }
    (all.len() <= most).then_some(all)
}
