//! Where new inputs do not determine the old ones.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational};

use crate::images::flattened;
use crate::range::image;
use crate::rational_function::RationalFunction;
use crate::switching::is_switch;
use crate::system::System;

/// Largest number of minors of the Jacobian that are written out.
const MAX_MINORS: usize = 6;

/// Where the Jacobian of w with respect to u loses rank, printed; `None` where it never does or no short condition was
/// found.
pub(crate) fn singular_set(system: &mut System, functions: &[Expr]) -> Option<String> {
    let jacobian = system.pool.jacobian(functions, &system.inputs.clone());
    let columns = subsets(system.inputs.len(), functions.len(), MAX_MINORS)?;
    let mut conditions: Vec<String> = Vec::new();
    for chosen in columns {
        let minor: Vec<Vec<Expr>> = jacobian.iter().map(|row| chosen.iter().map(|&j| row[j]).collect()).collect();
        let d = determinant(&mut system.pool, &minor)?;
        let d = system.pool.simplify(d);
        if system.pool.is_zero(d) {
            continue;
        }
        if system.pool.reachable(&[d]).into_iter().any(|n| is_switch(system.pool.node(n))) {
            return None;
        }
        let mut factors: Vec<String> = Vec::new();
        for f in flattened(&system.pool, d, false) {
            factors.extend(zeros(system, f));
        }
        if factors.is_empty() {
            return None;
        }
        factors.dedup();
        let condition = factors.join(" or ");
        if !conditions.contains(&condition) {
            conditions.push(condition);
        }
    }
    let several = conditions.len() > 1;
    let bracketed = conditions.into_iter().map(|c| if several && c.contains(" or ") { format!("({c})") } else { c });
    let text = bracketed.collect::<Vec<_>>().join(" and ");
    (!text.is_empty() && text.len() < 2000).then_some(text)
}

/// The conditions, one of which holds where the factor vanishes; none if it vanishes nowhere.
fn zeros(system: &mut System, factor: Expr) -> Vec<String> {
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
        return zeros.into_iter().map(|x| format!("{} = {x}", system.pool.name(u))).collect();
    }
    let inputs = system.inputs.clone();
    let nowhere = image(&mut system.pool, value, &inputs)
        .is_ok_and(|i| i.lower.value > 0.0 || i.upper.value < 0.0 || i.excludes_zero_at_end());
    if nowhere { Vec::new() } else { vec![format!("{} = 0", system.pool.text(base))] }
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

/// Largest matrix whose determinant is expanded.
const MAX_EXPANDED: usize = 4;

/// Determinant by expansion along the first row.
fn determinant(pool: &mut Pool, rows: &[Vec<Expr>]) -> Option<Expr> {
    let n = rows.len();
    if n > MAX_EXPANDED {
        return None;
    }
    if n == 0 {
        return Some(pool.int(1));
    }
    let mut total = pool.int(0);
    for j in 0..n {
        if pool.is_zero(rows[0][j]) {
            continue;
        }
        let minor: Vec<Vec<Expr>> =
            rows[1..].iter().map(|r| (0..n).filter(|&k| k != j).map(|k| r[k]).collect()).collect();
        let d = determinant(pool, &minor)?;
        let term = pool.mul(rows[0][j], d);
        total = if j % 2 == 0 { pool.add(total, term) } else { pool.sub(total, term) };
    }
    Some(total)
}
