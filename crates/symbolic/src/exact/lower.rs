//! Expressions to field programs: rational operations directly, kernels through algebraically independent generators.
//!
//! While the program is written, every sub-expression below the argument of a
//! kernel is also evaluated at a number of trial points; relations between
//! the kernels are found from these values.

use dashu_ratio::RBig;
use rustc_hash::{FxHashMap, FxHashSet};

use super::constants::exact_value;
use super::field::Residue;
use super::lowering::{FRACTION_BOUND, Lowering, Requirements, Stop};
use super::program::{Generator, MAX_POWER, Program, Reg, Step};
use super::{Bindings, Undecided};
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Trial points beyond the number of kernels.
const SPARE_POINTS: usize = 24;
/// Trial points when signs of squares have to be told apart; each level of nesting halves them.
const SIGN_POINTS: usize = 512;
const MAX_RESTARTS: usize = 64;

/// A finished program.
pub(super) struct Lowered<const C: u64> {
    pub(super) program: Program<C>,
    pub(super) first: Vec<Reg>,
    pub(super) outputs: Vec<Reg>,
    /// Exact values of those roots that are rational constants.
    pub(super) exact: Vec<Option<RBig>>,
    /// Roots whose sign could not be fixed: √(s²) is s or −s.
    pub(super) ambiguous: u32,
    /// Roots that must exist at a point (log2 of the expected number of tries).
    pub(super) conditions: u32,
    /// Degree of the algebraic extension.
    pub(super) extension: f64,
}

/// Writes the program for `first` and `roots`. The generators of `first` come before all others, in its order.
pub(super) fn lower<const C: u64>(
    pool: &Pool,
    first: &[Expr],
    roots: &[Expr],
    bindings: &Bindings,
) -> Result<Lowered<C>, Stop> {
    let nodes = ordered(pool, first, roots);
    let mut exact = FxHashMap::default();
    for &e in &nodes {
        if let Some(v) = exact_value(pool, e, bindings, &exact) {
            exact.insert(e, v);
        }
    }
    let kernels: Vec<Expr> = nodes.iter().copied().filter(|&e| is_kernel(pool, &exact, e)).collect();
    let arguments: Vec<Expr> = kernels.iter().flat_map(|&k| pool.node(k).operands()).collect();
    let below: FxHashSet<Expr> = pool.reachable(&arguments).into_iter().collect();
    let signs = kernels.iter().any(|&k| matches!(pool.node(k), Node::Pow(..)));
    let trials = kernels.len() + if signs { SIGN_POINTS } else { SPARE_POINTS };
    let mut requirements = Requirements::default();
    for &k in &kernels {
        if let Node::Pow(base, exponent) = pool.node(k)
            && let Some(q) = exact.get(&exponent)
        {
            let level = q.denominator().trailing_zeros().unwrap_or(0) as u32;
            let known = requirements.levels.entry(base).or_insert(0);
            *known = level.max(*known);
        }
    }
    for _ in 0..MAX_RESTARTS {
        let trials = if kernels.is_empty() { 0 } else { trials.max(requirements.trials) };
        let mut l = Lowering::new(pool, std::mem::take(&mut exact), trials, &mut requirements);
        match l.nodes(&nodes, &below) {
            Ok(()) => {
                return Ok(Lowered {
                    first: first.iter().map(|r| l.registers[r]).collect(),
                    outputs: roots.iter().map(|r| l.registers[r]).collect(),
                    exact: roots.iter().map(|r| l.exact.get(r).cloned()).collect(),
                    ambiguous: l.roots.ambiguous,
                    conditions: l.roots.conditions,
                    extension: l.roots.extension,
                    program: l.program,
                });
            }
            Err(Stop::Restart) => exact = l.exact,
            Err(stop) => return Err(stop),
        }
    }
    Err(Undecided::TooComplex.into())
}

/// All nodes below, operands before users: those of `first` in its order before the others.
fn ordered(pool: &Pool, first: &[Expr], roots: &[Expr]) -> Vec<Expr> {
    let mut nodes = Vec::new();
    let mut seen = FxHashSet::default();
    for below in first.iter().map(|e| pool.reachable(&[*e])) {
        nodes.extend(below.into_iter().filter(|e| seen.insert(*e)));
    }
    nodes.extend(pool.reachable(roots).into_iter().filter(|e| first.is_empty() || seen.insert(*e)));
    nodes
}

/// True if `e` may be, or need, a generator: a symbol, π, or a function.
pub(super) fn is_generator(pool: &Pool, e: Expr) -> bool {
    matches!(pool.node(e), Node::Sym(_) | Node::Pi)
        || is_kernel(pool, &FxHashMap::default(), e) && !is_integer_power(pool, e)
}

fn is_integer_power(pool: &Pool, e: Expr) -> bool {
    matches!(pool.node(e), Node::Pow(_, k) if pool.number(k).is_some_and(RBig::is_int))
}

/// True if `e` is not a rational operation.
fn is_kernel(pool: &Pool, exact: &FxHashMap<Expr, RBig>, e: Expr) -> bool {
    if exact.contains_key(&e) {
        return false;
    }
    match pool.node(e) {
        Node::Call(..) | Node::Call2(..) => true,
        Node::Pow(_, k) => exact.get(&k).is_none_or(|k| !k.is_int()),
        _ => false,
    }
}

impl<const C: u64> Lowering<'_, C> {
    fn nodes(&mut self, nodes: &[Expr], below: &FxHashSet<Expr>) -> Result<(), Stop> {
        for &e in nodes {
            self.watching = below.contains(&e);
            let r = self.node(e)?;
            self.registers.insert(e, r);
        }
        Ok(())
    }

    fn node(&mut self, e: Expr) -> Result<Reg, Stop> {
        if let Some(v) = self.exact.get(&e) {
            let c = Residue::faithful(v, FRACTION_BOUND)
                .ok_or_else(|| self.other_prime(e, "modulo the prime it is another number"))?;
            return Ok(self.constant(c));
        }
        match self.pool.node(e) {
            Node::Num(_) | Node::Sym(_) => {
                let s = self.generator(Generator::Free);
                Ok(self.push(Step::Slot(s)))
            }
            Node::Pi => Ok(self.pi()),
            Node::Add(a, b) => Ok(self.push(Step::Add(self.registers[&a], self.registers[&b]))),
            Node::Mul(a, b) => Ok(self.push(Step::Mul(self.registers[&a], self.registers[&b]))),
            Node::Pow(a, b) => self.power(e, a, b),
            Node::Call(f, a) => self.call(e, f, a),
            Node::Call2(_, a, b) => {
                self.refuse_open_sign(self.registers[&a])?;
                self.refuse_open_sign(self.registers[&b])?;
                self.watched(|l| l.inverse_angle(e))
            }
        }
    }

    fn power(&mut self, e: Expr, a: Expr, b: Expr) -> Result<Reg, Stop> {
        let base = self.registers[&a];
        let exponent = self.exact.get(&b).cloned().or_else(|| self.rational_in_disguise(self.registers[&b]));
        let Some(q) = exponent else {
            // a^b = exp(b log a)
            self.refuse_open_sign(base)?;
            self.refuse_open_sign(self.registers[&b])?;
            return self.watched(|l| {
                let log = l.logarithm(a)?;
                let exponent = l.push(Step::Mul(l.registers[&b], log));
                l.exponential(e, exponent)
            });
        };
        let n = i64::try_from(q.numerator()).ok().filter(|n| n.unsigned_abs() < MAX_POWER);
        let d = u64::try_from(q.denominator()).ok().filter(|&d| d < MAX_POWER);
        let (Some(n), Some(d)) = (n, d) else {
            return Err(self.kernel(e, "its exponent is too large"));
        };
        let mut r = base;
        let levels = d.trailing_zeros();
        if levels > 0 {
            r = self.watched(|l| l.root(a, levels))?;
        }
        let r = self.odd_root(e, r, d >> levels)?;
        Ok(self.integer_power(r, n))
    }

    /// The value of a register that is the same small fraction at all trial points.
    fn rational_in_disguise(&self, r: Reg) -> Option<RBig> {
        let at = self.trials(&[r], SPARE_POINTS);
        let values = self.values(r, &at);
        let first = values.first().filter(|v| values.iter().all(|w| w == *v))?;
        if values.len() < 2 { None } else { first.to_rational(FRACTION_BOUND) }
    }

    /// Register of the root of odd degree; errors name `e`.
    pub(super) fn odd_root(&mut self, e: Expr, r: Reg, degree: u64) -> Result<Reg, Stop> {
        if degree == 1 {
            return Ok(r);
        }
        // The map y → y^degree is one to one in a field of p elements if the degree is prime to p − 1.
        let Some(inverse) = inverse_modulo(degree, Residue::<C>::MODULUS - 1) else {
            return Err(self.other_prime(e, "the field has no unique root of this degree"));
        };
        self.roots.extension = self.roots.extension.max(1.0) * degree as f64;
        Ok(self.push(Step::Power(r, inverse)))
    }

    pub(super) fn integer_power(&mut self, r: Reg, n: i64) -> Reg {
        let r = if n < 0 { self.push(Step::Inverse(r)) } else { r };
        match n.unsigned_abs() {
            1 => r,
            k => self.push(Step::Power(r, k)),
        }
    }

    fn call(&mut self, e: Expr, f: Func, a: Expr) -> Result<Reg, Stop> {
        self.refuse_open_sign(self.registers[&a])?;
        match f {
            Func::Sin | Func::Cos | Func::Tan => {
                let (c, s) = self.watched(|l| l.angle(a))?;
                Ok(match f {
                    Func::Sin => s,
                    Func::Cos => c,
                    _ => self.quotient(s, c),
                })
            }
            Func::Asin | Func::Acos | Func::Atan => self.watched(|l| l.inverse_angle(e)),
            Func::Exp => self.watched(|l| l.exponential(a, l.registers[&a])),
            Func::Sinh | Func::Cosh | Func::Tanh => {
                let x = self.watched(|l| l.exponential(a, l.registers[&a]))?;
                let y = self.push(Step::Inverse(x));
                let minus = self.scaled(-Residue::ONE, y);
                let (sum, difference) = (self.push(Step::Add(x, y)), self.push(Step::Add(x, minus)));
                let half = Residue::new(2).inv().unwrap_or_default();
                Ok(match f {
                    Func::Sinh => self.scaled(half, difference),
                    Func::Cosh => self.scaled(half, sum),
                    _ => self.quotient(difference, sum),
                })
            }
            Func::Log => self.watched(|l| l.logarithm(a)),
            Func::Abs | Func::Sign => Err(self.kernel(e, "its sign depends on the point")),
        }
    }
}

/// 1/a modulo m, if they are coprime.
pub(super) fn inverse_modulo(a: u64, m: u64) -> Option<u64> {
    let (mut r0, mut r1) = (i128::from(m), i128::from(a % m));
    let (mut s0, mut s1) = (0_i128, 1_i128);
    while r1 != 0 {
        let q = r0 / r1;
        (r0, r1) = (r1, r0 - q * r1);
        (s0, s1) = (s1, s0 - q * s1);
    }
    (r0 == 1).then(|| s0.rem_euclid(i128::from(m)) as u64)
}
