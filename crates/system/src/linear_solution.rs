//! Equations g(z) = 0 solved for those unknowns z that stand linearly in them.

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};
use rustc_hash::FxHashMap;

/// Most unknowns of a coupled linear block that is solved by Cramer's rule, whose determinants grow with the factorial.
const LARGEST_BLOCK: usize = 6;
/// Blocks up to this size are short enough to be simplified.
const SIMPLIFIED_BLOCK: usize = 3;

/// What was solved, and what is left.
pub(crate) struct Solution {
    /// Unknowns with their values, which contain only unknowns that are left.
    pub(crate) found: Vec<(Symbol, Expr)>,
    /// Equations that are left, by index, with what was found put in.
    pub(crate) open: Vec<(usize, Expr)>,
    /// Unknowns that are left.
    pub(crate) unknowns: Vec<Symbol>,
}

/// An equation that, together with the others, does not determine the unknowns: ∂g/∂z is singular everywhere.
pub(crate) struct Singular {
    /// Its index.
    pub(crate) equation: usize,
}

/// Solves as many equations, symbolically, as there are unknowns.
///
/// A pivot that vanishes somewhere would add a singularity that the equations do not have. So unknowns with a number as
/// coefficient go first, then those that are alone in their equation, then what is linear together, by Cramer's rule, which divides by
/// the determinant alone. A parameter serves as pivot where nothing else is left.
pub(crate) fn solve(
    pool: &mut Pool,
    equations: &[Expr],
    unknowns: &[Symbol],
    parameters: &[Symbol],
) -> Result<Solution, Singular> {
    let mut left = Solution {
        found: Vec::new(),
        open: equations.iter().map(|&g| pool.simplify(g)).enumerate().collect(),
        unknowns: unknowns.to_vec(),
    };
    left.check_rank(pool)?;
    while !left.unknowns.is_empty() {
        let pivot = [Pivot::Number, Pivot::Alone].into_iter().find_map(|kind| left.pivot(pool, kind, parameters));
        if let Some((equation, unknown, value)) = pivot {
            left.put(pool, equation, unknown, value);
        } else if let Some(values) = left.jointly(pool) {
            left.found.iter_mut().for_each(|(_, e)| *e = pool.substitute(*e, &values));
            for s in std::mem::take(&mut left.unknowns) {
                let value = values[&pool.sym(s)];
                left.found.push((s, value));
            }
            left.open.clear();
        } else if let Some((equation, unknown, value)) = left.pivot(pool, Pivot::Parameters, parameters) {
            left.put(pool, equation, unknown, value);
        } else {
            break;
        }
    }
    Ok(left)
}

/// Which coefficients may be divided by.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pivot {
    /// Numbers.
    Number,
    /// Any, in an equation with one unknown.
    Alone,
    /// Expressions of parameters.
    Parameters,
}

impl Solution {
    /// The equations determine the unknowns at almost all points, as far as this can be decided.
    fn check_rank(&self, pool: &mut Pool) -> Result<(), Singular> {
        let open: Vec<Expr> = self.open.iter().map(|o| o.1).collect();
        let rows = pool.jacobian(&open, &self.unknowns);
        // What cannot be decided is left to the equations themselves.
        let Ok(rank) = pool.rank(&rows, &Bindings::default()) else { return Ok(()) };
        match (0..rows.len()).find(|row| !rank.independent.contains(row)) {
            None => Ok(()),
            Some(row) => Err(Singular { equation: self.open[row].0 }),
        }
    }

    /// The place of an equation, the unknown that it is solved for, and its value.
    fn pivot(&self, pool: &mut Pool, kind: Pivot, parameters: &[Symbol]) -> Option<(usize, Symbol, Expr)> {
        for (place, &(_, g)) in self.open.iter().enumerate() {
            let used = pool.symbols_of(&[g]);
            let inside: Vec<Symbol> = self.unknowns.iter().copied().filter(|s| used.contains(s)).collect();
            if kind == Pivot::Alone && inside.len() != 1 {
                continue;
            }
            for unknown in inside {
                let Some((coefficient, rest)) = affine_in(pool, g, unknown, &self.unknowns) else { continue };
                let allowed = match kind {
                    Pivot::Number => pool.number(coefficient).is_some(),
                    Pivot::Alone => true,
                    Pivot::Parameters => pool.symbols_of(&[coefficient]).iter().all(|s| parameters.contains(s)),
                };
                if allowed && !vanishes(pool, coefficient) {
                    let quotient = pool.div(rest, coefficient);
                    let value = pool.neg(quotient);
                    return Some((place, unknown, pool.simplify(value)));
                }
            }
        }
        None
    }

    /// Puts a value in the place of an unknown.
    fn put(&mut self, pool: &mut Pool, equation: usize, unknown: Symbol, value: Expr) {
        self.open.remove(equation);
        self.unknowns.retain(|s| *s != unknown);
        let map = FxHashMap::from_iter([(pool.sym(unknown), value)]);
        for e in self.open.iter_mut().map(|o| &mut o.1).chain(self.found.iter_mut().map(|f| &mut f.1)) {
            let image = pool.substitute(*e, &map);
            *e = pool.simplify(image);
        }
        self.found.push((unknown, value));
    }

    /// The values of all unknowns that are left, where all equations are linear in all of them.
    fn jointly(&self, pool: &mut Pool) -> Option<FxHashMap<Expr, Expr>> {
        let k = self.unknowns.len();
        if k > LARGEST_BLOCK {
            return None;
        }
        let zero = pool.int(0);
        let origin: FxHashMap<Expr, Expr> = self.unknowns.iter().map(|&s| (pool.sym(s), zero)).collect();
        let (mut matrix, mut right) = (Vec::new(), Vec::new());
        for &(_, g) in &self.open {
            let mut row = Vec::new();
            for &s in &self.unknowns {
                row.push(affine_in(pool, g, s, &self.unknowns)?.0);
            }
            let constant = pool.substitute(g, &origin);
            right.push(pool.neg(constant));
            matrix.push(row);
        }
        let determinant = pool.determinant(&matrix, |_, e| e);
        if vanishes(pool, determinant) {
            return None;
        }
        let mut values = FxHashMap::default();
        for (&s, mut value) in self.unknowns.iter().zip(pool.cramer(&matrix, &right, determinant, |_, e| e)) {
            if k <= SIMPLIFIED_BLOCK {
                value = pool.simplify(value);
            }
            values.insert(pool.sym(s), value);
        }
        Some(values)
    }
}

/// (c, b) with g = c·z + b, where c contains none of the `unknowns` and b not z.
fn affine_in(pool: &mut Pool, g: Expr, z: Symbol, unknowns: &[Symbol]) -> Option<(Expr, Expr)> {
    let derivative = pool.diff(g, z);
    let c = pool.simplify(derivative);
    let used = pool.symbols_of(&[c]);
    if unknowns.iter().any(|s| used.contains(s)) {
        return None;
    }
    // The derivative of a sign is 0, so that it does not tell.
    let zero = pool.int(0);
    let variable = pool.sym(z);
    let b = pool.substitute(g, &FxHashMap::from_iter([(variable, zero)]));
    let linear = pool.mul(c, variable);
    let model = pool.add(linear, b);
    let difference = pool.sub(g, model);
    vanishes(pool, difference).then_some((c, b))
}

/// Whether an expression is zero everywhere, as far as this is decided.
fn vanishes(pool: &mut Pool, e: Expr) -> bool {
    let simple = pool.simplify(e);
    pool.is_zero(simple) || pool.zero_test(simple, &Bindings::default()).is_zero()
}
