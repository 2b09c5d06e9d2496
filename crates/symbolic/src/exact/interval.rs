//! Intervals whose ends have long mantissas.

use std::cmp::Ordering;

use dashu_float::FBig;
use dashu_float::round::mode::{Down, Up};
use dashu_int::IBig;
use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::Bindings;
use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Larger powers, and values with longer exponents, are not looked at.
const MAX_POWER: u64 = 1 << 20;
const MAX_EXPONENT: isize = 1 << 14;

type Low = FBig<Down, 2>;
type High = FBig<Up, 2>;

/// All numbers from `low` to `high`: every operation rounds outward.
#[derive(Clone, Debug)]
pub(super) struct Interval {
    low: Low,
    high: High,
}

impl Interval {
    /// The value of the last of some nodes.
    pub(super) fn of_constant(pool: &Pool, nodes: &[Expr], bindings: &Bindings, bits: usize) -> Option<Self> {
        let mut values: FxHashMap<Expr, Interval> = FxHashMap::default();
        for &e in nodes {
            let at = |e: Expr| &values[&e];
            let value = match pool.node(e) {
                Node::Num(_) => Self::of(pool.number(e)?, bits),
                Node::Pi => Self::pi(bits),
                Node::Sym(s) => Self::of(bindings.get(s)?, bits),
                Node::Add(a, b) => at(a).plus(at(b)),
                Node::Mul(a, b) if a == b => at(a).square(),
                Node::Mul(a, b) => at(a).times(at(b)),
                Node::Pow(a, k) => match pool.number(k) {
                    Some(k) => at(a).power(k, bits)?,
                    None => at(a).logarithm()?.times(at(k)).exponential()?,
                },
                Node::Call(f, a) => at(a).image(f, bits)?,
                Node::Call2(f, a, b) => at(a).image2(f, at(b), bits)?,
            };
            values.insert(e, value.moderate()?);
        }
        values.remove(nodes.last()?)
    }

    pub(super) fn of(q: &RBig, bits: usize) -> Self {
        Self { low: q.to_float(bits).value(), high: q.to_float(bits).value() }
    }

    fn pi(bits: usize) -> Self {
        Self { low: Low::pi(bits), high: High::pi(bits) }
    }

    /// The sign of all its numbers; `None` where they differ.
    pub(super) fn sign(&self) -> Option<Ordering> {
        if self.low > Low::ZERO {
            Some(Ordering::Greater)
        } else if self.high < High::ZERO {
            Some(Ordering::Less)
        } else {
            (self.low == Low::ZERO && self.high == High::ZERO).then_some(Ordering::Equal)
        }
    }

    /// A number of type `f64` in it, where its ends round to the same one, or to one and those beside it: about such a number, no interval
    /// is so small that both ends round to it.
    pub(super) fn value(&self) -> Option<f64> {
        let (low, high) = (self.low.to_f64().value(), self.high.to_f64().value());
        let middle = low.next_up().min(high);
        (low.is_finite() && high.is_finite() && high <= middle.next_up()).then_some(middle)
    }

    /// The mean of its ends.
    pub(super) fn middle(&self) -> RBig {
        let exact = |significand: &IBig, exponent: isize| {
            let power = IBig::ONE << exponent.unsigned_abs();
            let x = RBig::from(significand.clone());
            if exponent < 0 { x / RBig::from(power) } else { x * RBig::from(power) }
        };
        let (low, high) = (self.low.repr(), self.high.repr());
        let sum = exact(low.significand(), low.exponent()) + exact(high.significand(), high.exponent());
        sum / RBig::from(2)
    }

    /// Itself, unless its ends are too large or too small to compute with.
    pub(super) fn moderate(self) -> Option<Self> {
        let size = |digits: usize, exponent: isize| (exponent.saturating_add(digits as isize)).abs();
        let (low, high) = (self.low.repr(), self.high.repr());
        let fits =
            size(low.digits(), low.exponent()) < MAX_EXPONENT && size(high.digits(), high.exponent()) < MAX_EXPONENT;
        (fits && !low.is_infinite() && !high.is_infinite()).then_some(self)
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { low: &self.low + &other.low, high: &self.high + &other.high }
    }

    pub(super) fn negative(&self) -> Self {
        Self { low: -self.high.clone().with_rounding(), high: -self.low.clone().with_rounding() }
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        // Where signs are known, two products suffice.
        match (self.sign(), other.sign()) {
            (Some(Ordering::Greater), Some(Ordering::Greater)) => {
                Self { low: &self.low * &other.low, high: &self.high * &other.high }
            }
            (Some(Ordering::Less), Some(_)) => self.negative().times(other).negative(),
            (Some(_), Some(Ordering::Less)) => self.times(&other.negative()).negative(),
            _ => self.times_of_any_sign(other),
        }
    }

    fn times_of_any_sign(&self, other: &Self) -> Self {
        let [a, b, c, d] =
            [&self.low, &self.high.clone().with_rounding(), &other.low, &other.high.clone().with_rounding()];
        let low = [a * c, a * d, b * c, b * d].into_iter().reduce(|x, y| if y < x { y } else { x });
        let [a, b, c, d] =
            [&self.low.clone().with_rounding(), &self.high, &other.low.clone().with_rounding(), &other.high];
        let high: Option<High> = [a * c, a * d, b * c, b * d].into_iter().reduce(|x, y| if y > x { y } else { x });
        Self { low: low.unwrap_or_default(), high: high.unwrap_or_default() }
    }

    fn square(&self) -> Self {
        let product = self.times(self);
        if self.holds_zero() { product } else { Self { low: product.low.max(Low::ZERO), ..product } }
    }

    pub(super) fn holds_zero(&self) -> bool {
        self.low <= Low::ZERO && self.high >= High::ZERO
    }

    pub(super) fn inverse(&self, bits: usize) -> Option<Self> {
        let one = Self::of(&RBig::ONE, bits);
        let ends = || Self {
            low: one.low / self.high.clone().with_rounding::<Down>(),
            high: one.high / self.low.clone().with_rounding::<Up>(),
        };
        (!self.holds_zero()).then(ends)
    }

    /// Of a number above 0; at ends below it, the interval is not one of the function.
    fn logarithm(&self) -> Option<Self> {
        (self.low > Low::ZERO).then(|| Self { low: self.low.ln(), high: self.high.ln() })
    }

    fn exponential(&self) -> Option<Self> {
        let moderate = |x: f64| x.abs() < f64::from(1u16 << 13);
        (moderate(self.low.to_f64().value()) && moderate(self.high.to_f64().value()))
            .then(|| Self { low: self.low.exp(), high: self.high.exp() })
    }

    fn power(&self, k: &RBig, bits: usize) -> Option<Self> {
        let n = u64::try_from(dashu_base::UnsignedAbs::unsigned_abs(k.numerator().clone()))
            .ok()
            .filter(|n| *n <= MAX_POWER)?;
        let d = usize::try_from(k.denominator()).ok().filter(|d| *d as u64 <= MAX_POWER)?;
        let base = match d {
            1 => self.clone(),
            _ if self.low >= Low::ZERO => Self { low: self.low.nth_root(d), high: self.high.nth_root(d) },
            _ => return None,
        };
        let (mut result, mut square, mut left) = (Self::of(&RBig::ONE, bits), base, n);
        while left > 0 {
            if left & 1 == 1 {
                result = result.times(&square).moderate()?;
            }
            left >>= 1;
            if left > 0 {
                square = square.square().moderate()?;
            }
        }
        if *k < RBig::ZERO { result.inverse(bits) } else { Some(result) }
    }

    /// A function with slopes from −1 to 1.
    fn wave(&self, low: impl Fn(&Low) -> Low, high: impl Fn(&High) -> High) -> Self {
        let start: High = self.low.clone().with_rounding();
        let width: High = &self.high - &start;
        Self { low: low(&self.low) - width.clone().with_rounding::<Down>(), high: high(&start) + width }
    }

    fn image(&self, f: Func, bits: usize) -> Option<Self> {
        let within_one = || self.low >= Low::NEG_ONE && self.high <= High::ONE;
        Some(match f {
            Func::Sin => self.wave(Low::sin, High::sin),
            Func::Cos => self.wave(Low::cos, High::cos),
            Func::Tan => self.image(Func::Sin, bits)?.times(&self.image(Func::Cos, bits)?.inverse(bits)?),
            Func::Asin if within_one() => Self { low: self.low.asin(), high: self.high.asin() },
            Func::Acos if within_one() => Self {
                low: self.high.clone().with_rounding::<Down>().acos(),
                high: self.low.clone().with_rounding::<Up>().acos(),
            },
            Func::Atan => Self { low: self.low.atan(), high: self.high.atan() },
            Func::Exp => self.exponential()?,
            Func::Log => self.logarithm()?,
            Func::Sinh | Func::Cosh | Func::Tanh => {
                let (up, half) = (self.exponential()?, Self::of(&RBig::from_parts(1.into(), 2u8.into()), bits));
                let down = up.inverse(bits)?;
                match f {
                    Func::Sinh => up.plus(&down.negative()).times(&half),
                    Func::Cosh => up.plus(&down).times(&half),
                    _ => up.plus(&down.negative()).times(&up.plus(&down).inverse(bits)?),
                }
            }
            Func::Abs if self.low >= Low::ZERO => self.clone(),
            Func::Abs if self.high <= High::ZERO => self.negative(),
            Func::Sign if self.low > Low::ZERO => Self::of(&RBig::ONE, bits),
            Func::Sign if self.high < High::ZERO => Self::of(&RBig::NEG_ONE, bits),
            Func::Abs => {
                let down = self.negative().high;
                Self { low: Low::ZERO, high: down.max(self.high.clone()) }
            }
            Func::Asin | Func::Acos | Func::Sign => return None,
        })
    }

    fn image2(&self, f: Func2, other: &Self, bits: usize) -> Option<Self> {
        Some(match f {
            Func2::Min => {
                Self { low: self.low.clone().min(other.low.clone()), high: self.high.clone().min(other.high.clone()) }
            }
            Func2::Max => {
                Self { low: self.low.clone().max(other.low.clone()), high: self.high.clone().max(other.high.clone()) }
            }
            Func2::Atan2 => {
                let (y, x) = (self, other);
                if x.low > Low::ZERO {
                    return y.times(&x.inverse(bits)?).image(Func::Atan, bits);
                }
                let quarter = Self::pi(bits).times(&Self::of(&RBig::from_parts(1.into(), 2u8.into()), bits));
                let angle = x.times(&y.inverse(bits)?).image(Func::Atan, bits)?.negative();
                if y.low > Low::ZERO { angle.plus(&quarter) } else { angle.plus(&quarter.negative()) }
            }
        })
    }
}
