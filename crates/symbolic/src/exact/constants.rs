//! Exact values of the sub-expressions that are rational constants, and factors of integers.

use std::cmp::Ordering;

use dashu_base::{BitTest, UnsignedAbs};
use dashu_int::UBig;
use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::Bindings;
use super::field::gcd;
use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Larger numerators and denominators are not followed.
const MAX_BITS: usize = 4096;

/// Rational value of `e` under the bindings, given those of its operands; `None` if it has none or is not a constant.
pub(super) fn exact_value(pool: &Pool, e: Expr, bindings: &Bindings, known: &FxHashMap<Expr, RBig>) -> Option<RBig> {
    let value = match pool.node(e) {
        Node::Num(_) => return pool.number(e).cloned(),
        Node::Sym(s) => return bindings.get(s).cloned(),
        Node::Pi => None,
        Node::Add(a, b) => Some(known.get(&a)? + known.get(&b)?),
        Node::Mul(a, b) => {
            let (x, y) = (known.get(&a), known.get(&b));
            Some(x? * y?)
        }
        Node::Pow(a, b) => power(known.get(&a)?, known.get(&b)?),
        Node::Call(f, a) => {
            let x = known.get(&a)?;
            match (f, x.cmp(&RBig::ZERO)) {
                (Func::Abs, Ordering::Less) => Some(-x.clone()),
                (Func::Abs, _) => Some(x.clone()),
                (Func::Sign, s) => Some(RBig::from(s as i64)),
                (Func::Cos | Func::Cosh | Func::Exp, Ordering::Equal) => Some(RBig::ONE),
                (Func::Sin | Func::Tan | Func::Asin | Func::Atan | Func::Sinh | Func::Tanh, Ordering::Equal) => {
                    Some(RBig::ZERO)
                }
                (Func::Log | Func::Acos, _) if *x == RBig::ONE => Some(RBig::ZERO),
                _ => None,
            }
        }
        Node::Call2(f, a, b) => {
            let (x, y) = (known.get(&a)?, known.get(&b)?);
            match f {
                Func2::Min => Some(x.min(y).clone()),
                Func2::Max => Some(x.max(y).clone()),
                Func2::Atan2 => (*x == RBig::ZERO && *y > RBig::ZERO).then_some(RBig::ZERO),
            }
        }
    }?;
    let size = value.numerator().clone().unsigned_abs().bit_len().max(value.denominator().bit_len());
    (size <= MAX_BITS).then_some(value)
}

fn power(x: &RBig, k: &RBig) -> Option<RBig> {
    let (x, k) =
        if k.is_int() { (x.clone(), k.clone()) } else { (exact_root(x, k)?, RBig::from(k.numerator().clone())) };
    let k = i64::try_from(k.numerator()).ok()?;
    if k.unsigned_abs() > MAX_BITS as u64 || (x == RBig::ZERO && k <= 0) {
        return None;
    }
    let p = x.pow(k.unsigned_abs() as isize);
    Some(if k < 0 { RBig::ONE / p } else { p })
}

/// The root of a rational that is not negative, of the degree in the denominator of `k`, if it is rational.
pub(super) fn exact_root(x: &RBig, k: &RBig) -> Option<RBig> {
    let degree = usize::try_from(k.denominator()).ok().filter(|d| *d <= MAX_BITS)?;
    let root = |n: UBig| {
        let r = n.nth_root(degree);
        (r.pow(degree) == n).then_some(r)
    };
    let (n, d) = (root(x.numerator().clone().unsigned_abs())?, root(x.denominator().clone())?);
    (*x >= RBig::ZERO).then(|| RBig::from_parts(n.into(), d))
}

/// A positive rational as Π n_i^(k_i) with pairwise coprime n_i > 1, none of which is a perfect power that matters:
/// each is a prime, or a product of two primes above 2^16.
///
/// `None` if the number is too large for that. `found` collects the larger
/// factors of earlier numbers; a common factor of two of them is not split
/// and gives `None` as well.
pub(super) fn factors(r: &RBig, found: &mut Vec<u64>) -> Option<Vec<(u64, i64)>> {
    let mut out = Vec::new();
    for (n, sign) in [(r.numerator().clone().unsigned_abs(), 1), (r.denominator().clone(), -1)] {
        integer_factors(n, sign, found, &mut out)?;
    }
    Some(out)
}

const TRIAL: u64 = 1 << 16;

fn integer_factors(n: UBig, sign: i64, found: &mut Vec<u64>, out: &mut Vec<(u64, i64)>) -> Option<()> {
    // Decimal numbers have large powers of ten below the line: take 2 and 5 out while the number is big.
    let mut n = n;
    for q in [2_u64, 3, 5, 7] {
        let mut k = 0;
        while n > UBig::ONE && (&n % q) == 0 {
            n /= q;
            k += 1;
        }
        if k > 0 {
            out.push((q, sign * k));
        }
    }
    let mut n = u64::try_from(n).ok()?;
    let mut q = 11;
    while q < TRIAL && q * q <= n {
        let mut k = 0;
        while n % q == 0 {
            n /= q;
            k += 1;
        }
        if k > 0 {
            out.push((q, sign * k));
        }
        q += 2;
    }
    if n == 1 {
        return Some(());
    }
    let root = n.isqrt();
    let (n, k) = if root * root == n { (root, 2) } else { (n, 1) };
    // Without divisors below 2^16, a number below 2^48 has at most two prime factors.
    if n >= 1 << 48 {
        return None;
    }
    if n >= TRIAL && !found.contains(&n) {
        if found.iter().any(|&m| gcd(m, n) != 1) {
            return None;
        }
        found.push(n);
    }
    out.push((n, sign * k));
    Some(())
}
