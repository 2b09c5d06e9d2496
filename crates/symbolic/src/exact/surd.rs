//! Exact arithmetic with square roots of rationals, in which nested roots of constants are taken apart.

use std::collections::BTreeMap;

use dashu_base::UnsignedAbs;
use dashu_int::UBig;
use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::field::gcd;
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Longest sum.
const MAX_TERMS: usize = 32;
/// Larger powers are not taken.
const MAX_POWER: i64 = 32;
/// Numbers under roots are factored by trial division up to this.
const TRIAL: u64 = 1 << 12;
/// Roots within roots that are looked into.
const MAX_NESTING: u32 = 6;

/// Σ c_n √n over square-free n.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Surd(BTreeMap<u64, RBig>);

impl Surd {
    pub(super) fn rational(q: RBig) -> Self {
        Self::term(1, q)
    }

    fn term(n: u64, c: RBig) -> Self {
        Self(if c == RBig::ZERO { BTreeMap::new() } else { [(n, c)].into() })
    }

    /// c √n for an integer n.
    fn root(n: u64, c: i64, over: i64) -> Self {
        Self::term(n, RBig::from(c) / RBig::from(over))
    }

    fn as_rational(&self) -> Option<RBig> {
        match self.0.len() {
            0 => Some(RBig::ZERO),
            1 => self.0.get(&1).cloned(),
            _ => None,
        }
    }

    fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        let mut sum = self.0.clone();
        for (&n, c) in &other.0 {
            let total = sum.remove(&n).unwrap_or(RBig::ZERO) + c;
            if total != RBig::ZERO {
                sum.insert(n, total);
            }
        }
        (sum.len() <= MAX_TERMS).then_some(Self(sum))
    }

    fn times(&self, other: &Self) -> Option<Self> {
        let mut product = Self(BTreeMap::new());
        for (&m, a) in &self.0 {
            for (&n, b) in &other.0 {
                let g = gcd(m, n);
                let radicand = (m / g).checked_mul(n / g)?;
                product = product.plus(&Self::term(radicand, a * b * RBig::from(g)))?;
            }
        }
        Some(product)
    }

    fn scaled(&self, c: &RBig) -> Self {
        Self(self.0.iter().map(|(&n, x)| (n, x * c)).collect())
    }

    /// (a, b, p) with self = a + b √p, where p is the largest prime under a root.
    fn split(&self) -> Option<(Self, Self, u64)> {
        let p = self.0.keys().filter_map(|&n| largest_prime(n)).max()?;
        let (with, without): (BTreeMap<_, _>, BTreeMap<_, _>) =
            self.0.clone().into_iter().partition(|(n, _)| n.is_multiple_of(p));
        Some((Self(without), Self(with.into_iter().map(|(n, c)| (n / p, c)).collect()), p))
    }

    /// 1/(a + b√p) = (a − b√p)/(a² − p b²)
    fn inverse(&self) -> Option<Self> {
        if let Some(q) = self.as_rational() {
            return (q != RBig::ZERO).then(|| Self::rational(RBig::ONE / q));
        }
        let (a, b, p) = self.split()?;
        let root = Self::term(p, RBig::from(-1));
        let conjugate = a.plus(&b.times(&root)?)?;
        conjugate.times(&a.norm(&b, p)?.inverse()?)
    }

    /// a² − p b²
    fn norm(&self, b: &Self, p: u64) -> Option<Self> {
        self.times(self)?.plus(&b.times(b)?.scaled(&-RBig::from(p)))
    }

    fn power(&self, k: i64) -> Option<Self> {
        if k.abs() > MAX_POWER {
            return None;
        }
        let base = if k < 0 { self.inverse()? } else { self.clone() };
        (0..k.abs()).try_fold(Self::rational(RBig::ONE), |p, _| p.times(&base))
    }

    /// −1, 0 or 1; `None` if the value is too near to zero for floating point.
    pub(super) fn sign(&self) -> Option<i64> {
        if self.is_zero() {
            return Some(0);
        }
        let terms = || self.0.iter().map(|(&n, c)| c.to_f64().value() * (n as f64).sqrt());
        let (sum, size) = (terms().sum::<f64>(), terms().map(f64::abs).sum::<f64>());
        // Each of at most 32 terms is off by less than 4 roundings, and so is each sum.
        (sum.is_finite() && sum.abs() > 1e-13 * size).then_some(if sum > 0.0 { 1 } else { -1 })
    }

    /// The positive root, if it is a sum of square roots of rationals (Borodin, Fagin, Hopcroft, and Tompa
    /// 1985).
    fn sqrt(&self, nesting: u32) -> Option<Self> {
        if let Some(q) = self.as_rational() {
            return root_of_rational(&q);
        }
        if nesting == 0 || self.sign()? < 0 {
            return None;
        }
        // √(a + b√p) = x + y√p has x² = (a ± c)/2 with c² = a² − p b², and y = b/(2x).
        let (a, b, p) = self.split()?;
        let c = a.norm(&b, p)?.sqrt(nesting - 1)?;
        let half = RBig::ONE / RBig::from(2);
        [c.clone(), c.scaled(&RBig::from(-1))].into_iter().find_map(|c| {
            let x = a.plus(&c)?.scaled(&half).sqrt(nesting - 1)?;
            let y = b.times(&x.inverse()?)?.scaled(&half);
            let root = x.plus(&y.times(&Self::term(p, RBig::ONE))?)?;
            if root.times(&root)? != *self {
                return None;
            }
            Some(if root.sign()? < 0 { root.scaled(&RBig::from(-1)) } else { root })
        })
    }

    /// cos(k π/12)
    fn cosine(k: i64) -> Option<Self> {
        let k = k.rem_euclid(24);
        let k = if k > 12 { 24 - k } else { k };
        if k > 6 {
            return Some(Self::cosine(12 - k)?.scaled(&RBig::from(-1)));
        }
        match k {
            0 => Some(Self::root(1, 1, 1)),
            1 => Self::root(6, 1, 4).plus(&Self::root(2, 1, 4)),
            2 => Some(Self::root(3, 1, 2)),
            3 => Some(Self::root(2, 1, 2)),
            4 => Some(Self::root(1, 1, 2)),
            5 => Self::root(6, 1, 4).plus(&Self::root(2, -1, 4)),
            _ => Some(Self(BTreeMap::new())),
        }
    }

    /// k with tan(kπ/12) or sin(kπ/12) equal to this, −6 ≤ k ≤ 6.
    fn angle(&self, f: Func) -> Option<i64> {
        (-6..=6).find(|&k| {
            let (c, s) = (Self::cosine(k), Self::cosine(k - 6));
            match (f, c, s) {
                (Func::Atan, Some(c), Some(s)) if !c.is_zero() => self.times(&c) == Some(s),
                (Func::Asin, _, Some(s)) => *self == s,
                _ => false,
            }
        })
    }
}

fn largest_prime(mut n: u64) -> Option<u64> {
    let (mut q, mut largest) = (2, None);
    while q * q <= n {
        if n.is_multiple_of(q) {
            (n, largest) = (n / q, Some(q));
        } else {
            q += 1;
        }
    }
    if n > 1 { Some(n) } else { largest }
}

/// √q = s √n / d, where the number under the root has no large prime factors.
fn root_of_rational(q: &RBig) -> Option<Surd> {
    if *q < RBig::ZERO {
        return None;
    }
    if *q == RBig::ZERO {
        return Some(Surd(BTreeMap::new()));
    }
    let d = q.denominator().clone();
    let mut n = q.numerator().clone().unsigned_abs() * &d;
    let (mut square, mut free) = (UBig::ONE, 1_u64);
    for p in (2..TRIAL).filter(|p| *p == 2 || p % 2 == 1) {
        let mut k = 0;
        while n > UBig::ONE && (&n % p) == 0 {
            n /= p;
            k += 1;
        }
        square *= UBig::from(p).pow(k / 2);
        if k % 2 == 1 {
            free = free.checked_mul(p)?;
        }
        if n == UBig::ONE {
            break;
        }
    }
    // What is left has no divisor below 2^12: below 2^24 it is a prime, which no root makes rational.
    let rest = u64::try_from(&n).ok().filter(|n| *n < TRIAL * TRIAL)?;
    free = free.checked_mul(rest)?;
    Some(Surd::term(free, RBig::from_parts(square.into(), d)))
}

impl Pool {
    /// The value of a constant that is made of rationals and square roots.
    pub(super) fn surd(&mut self, e: Expr) -> Option<Surd> {
        let mut known: FxHashMap<Expr, Surd> = FxHashMap::default();
        for n in self.reachable(&[e]) {
            let value = match self.node(n) {
                Node::Num(_) => Surd::rational(self.number(n)?.clone()),
                // Only as the argument of a sine or cosine, or along with it in an exponent.
                Node::Pi => continue,
                Node::Add(a, b) => match (known.get(&a), known.get(&b)) {
                    (Some(a), Some(b)) => a.plus(b)?,
                    _ => continue,
                },
                Node::Mul(a, b) => match (known.get(&a), known.get(&b)) {
                    (Some(a), Some(b)) => a.times(b)?,
                    _ => continue,
                },
                Node::Pow(a, k) => {
                    let (base, k) = (known.get(&a)?, self.number(k)?);
                    let numerator = i64::try_from(k.numerator()).ok()?;
                    match u64::try_from(k.denominator()).ok()? {
                        1 => base.power(numerator)?,
                        2 => base.sqrt(MAX_NESTING)?.power(numerator)?,
                        _ => return None,
                    }
                }
                Node::Call(f @ (Func::Cos | Func::Sin | Func::Tan), a) => {
                    let (c, rest) = self.coefficient(a);
                    let twelfths = c * RBig::from(12);
                    if self.node(rest) != Node::Pi || !twelfths.is_int() {
                        return None;
                    }
                    let k = i64::try_from(twelfths.numerator()).ok().filter(|k| k.abs() < 1 << 32)?;
                    let (c, s) = (Surd::cosine(k)?, Surd::cosine(k - 6)?);
                    match f {
                        Func::Cos => c,
                        Func::Sin => s,
                        _ => s.times(&c.inverse()?)?,
                    }
                }
                _ => return None,
            };
            known.insert(n, value);
        }
        known.remove(&e)
    }

    /// k with f(v) = kπ/12 for a constant v and f = asin, atan.
    pub(super) fn twelfths_of_pi(&mut self, f: Func, v: Expr) -> Option<i64> {
        self.surd(v)?.angle(f)
    }

    /// The positive root of a constant as a sum of square roots of rationals.
    pub(super) fn denested_root(&mut self, e: Expr) -> Option<Expr> {
        let root = self.surd(e)?.sqrt(MAX_NESTING)?;
        let mut terms = Vec::new();
        for (n, c) in root.0 {
            let n = self.rational(RBig::from(n));
            let (c, r) = (self.rational(c), self.sqrt(n));
            terms.push(if self.is_one(n) { c } else { self.mul(c, r) });
        }
        Some(self.sum(terms))
    }
}
