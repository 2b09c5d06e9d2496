//! Real numbers in exact arithmetic: rational ones, and others known by a residue and an interval.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use std::rc::Rc;

use dashu_ratio::RBig;

use super::constant_sign::MAX_NODES;
use super::field::{Residue, SECOND_OFFSET};
use super::field_element::{FieldElement, OrderedField};
use super::interval::Interval;
use super::{Bindings, SEED, Samples};
use crate::node::Expr;
use crate::pool::Pool;

/// Bits of the ends of intervals, and those of a constant that so many do not tell from zero.
const BITS: usize = 256;
const MORE_BITS: usize = 1024;
/// Operations in the formula of a number, beyond which it has none.
const MAX_OPERATIONS: u32 = 100;

type Class = Residue<SECOND_OFFSET>;

/// A real number of a computation that starts with [`Pool::reals`].
///
/// It is zero where its residue is, and has the sign of its interval. Where the residue is not zero but the interval does not leave 0, the
/// sign is not known.
#[derive(Clone, Debug)]
pub struct Real(Value);

#[derive(Clone, Debug)]
enum Value {
    Rational(RBig),
    /// Not seen to be rational, and not zero.
    Other(Box<Other>),
}

#[derive(Clone, Debug, Default)]
struct Other {
    /// `None` where nothing is known, because the prime divides a denominator, residue and interval contradict each other, or residues do
    /// not belong together.
    residue: Option<Class>,
    /// `None` where it is too wide.
    interval: Option<Interval>,
    /// How the number was computed, while that is short.
    formula: Option<Rc<Formula>>,
    /// The same for all numbers whose residues belong together; none for a rational number.
    sample: Option<Rc<()>>,
}

#[derive(Debug)]
struct Formula {
    operations: u32,
    last: Operation,
}

#[derive(Debug)]
enum Operation {
    Constant(Expr),
    Rational(RBig),
    Sum(Rc<Formula>, Rc<Formula>),
    Product(Rc<Formula>, Rc<Formula>),
    Inverse(Rc<Formula>),
}

impl Formula {
    fn leaf(last: Operation) -> Rc<Self> {
        Rc::new(Self { operations: 0, last })
    }

    fn of_two(a: Option<Rc<Self>>, b: Option<Rc<Self>>, last: fn(Rc<Self>, Rc<Self>) -> Operation) -> Option<Rc<Self>> {
        let (a, b) = (a?, b?);
        let operations = a.operations + b.operations + 1;
        (operations <= MAX_OPERATIONS).then(|| Rc::new(Self { operations, last: last(a, b) }))
    }

    fn expression(&self, pool: &mut Pool) -> Expr {
        match &self.last {
            Operation::Constant(e) => *e,
            Operation::Rational(q) => pool.rational(q.clone()),
            Operation::Sum(a, b) => {
                let (a, b) = (a.expression(pool), b.expression(pool));
                pool.add(a, b)
            }
            Operation::Product(a, b) => {
                let (a, b) = (a.expression(pool), b.expression(pool));
                pool.mul(a, b)
            }
            Operation::Inverse(a) => {
                let a = a.expression(pool);
                pool.powi(a, -1)
            }
        }
    }
}

impl Pool {
    /// Constants as real numbers to compute with, all those of a computation together: residues of different calls do not belong together.
    /// With them the sample that tells which are zero, unless all are rational. `None` where one has no value, or no residue.
    ///
    /// ```
    /// use bracketry_symbolic::{OrderedField, Pool};
    /// let mut p = Pool::new();
    /// let list = ["sqrt(2)", "sqrt(3)", "sqrt(6)"].map(|e| p.parse(e).unwrap());
    /// let (x, _) = p.reals(&list).unwrap();
    /// assert!(&x[0] * &x[1] == x[2]);
    /// assert_eq!((&x[0] * &x[0] - &x[1]).sign(), Some(std::cmp::Ordering::Greater));
    /// let quotient = (&x[2] / &x[1]).expression(&mut p).unwrap();
    /// assert_eq!(p.text(quotient), "sqrt(6)/sqrt(3)");
    /// ```
    pub fn reals(&mut self, list: &[Expr]) -> Option<(Vec<Real>, Option<Samples<SECOND_OFFSET>>)> {
        let (mut values, mut open) = (Vec::new(), Vec::new());
        for &e in list {
            let e = self.simplify(e);
            let rational = self.constant_rational(e);
            if rational.is_none() {
                open.push((values.len(), e));
            }
            values.push(rational.map_or(Real::ZERO, Real::from));
        }
        if open.is_empty() {
            return Some((values, None));
        }
        let roots: Vec<Expr> = open.iter().map(|o| o.1).collect();
        if !self.symbols_of(&roots).is_empty() {
            return None;
        }
        let samples = self.sample_in::<SECOND_OFFSET>(&roots, &Bindings::new(), 1, SEED).ok()?;
        if samples.ambiguous_signs > 0 {
            return None;
        }
        let sample = Some(Rc::new(()));
        for (&(place, e), &residue) in open.iter().zip(samples.values.first()?) {
            let interval = Some(self.long_interval(e)?);
            let formula = Some(Formula::leaf(Operation::Constant(e)));
            values[place] = Real::made(Other { residue: Some(residue), interval, formula, sample: sample.clone() });
        }
        Some((values, Some(samples)))
    }

    /// The value of a constant in an interval that does not hold 0, if so many bits tell that.
    fn long_interval(&self, e: Expr) -> Option<Interval> {
        let nodes = self.reachable(&[e]);
        if nodes.len() > MAX_NODES {
            return None;
        }
        let of = |bits| Interval::of_constant(self, &nodes, &Bindings::new(), bits);
        of(BITS).filter(|i| !i.holds_zero()).or_else(|| of(MORE_BITS))
    }
}

impl From<RBig> for Real {
    fn from(q: RBig) -> Self {
        Self(Value::Rational(q))
    }
}

impl From<i64> for Real {
    fn from(n: i64) -> Self {
        Self::from(RBig::from(n))
    }
}

impl Real {
    /// The number, if it is seen to be rational.
    pub fn rational(&self) -> Option<&RBig> {
        match &self.0 {
            Value::Rational(q) => Some(q),
            Value::Other(_) => None,
        }
    }

    /// The number as an expression of the constants of [`Pool::reals`], if that is short.
    pub fn expression(&self, pool: &mut Pool) -> Option<Expr> {
        match &self.0 {
            Value::Rational(q) => Some(pool.rational(q.clone())),
            Value::Other(x) => {
                let e = x.formula.as_ref()?.expression(pool);
                Some(pool.simplify(e))
            }
        }
    }

    fn made(x: Other) -> Self {
        let interval = x.interval.and_then(Interval::moderate);
        let other = match x.residue {
            Some(r) if r.is_zero() && interval.as_ref().is_none_or(Interval::holds_zero) => return Self::ZERO,
            Some(r) if !r.is_zero() => Other { interval, ..x },
            _ => Other::default(),
        };
        Self(Value::Other(Box::new(other)))
    }

    /// A sum or product.
    fn of_two(
        &self,
        other: &Self,
        residue: fn(Class, Class) -> Class,
        interval: fn(&Interval, &Interval) -> Interval,
        operation: fn(Rc<Formula>, Rc<Formula>) -> Operation,
    ) -> Self {
        let (a, b) = (self.parts(), other.parts());
        let sample = match (a.sample, b.sample) {
            (Some(a), Some(b)) if !Rc::ptr_eq(&a, &b) => return Self::made(Other::default()),
            (a, b) => a.or(b),
        };
        Self::made(Other {
            residue: a.residue.zip(b.residue).map(|(a, b)| residue(a, b)),
            interval: a.interval.zip(b.interval).map(|(a, b)| interval(&a, &b)),
            formula: Formula::of_two(a.formula, b.formula, operation),
            sample,
        })
    }

    /// Residue, interval, and formula also of a rational number.
    fn parts(&self) -> Other {
        match &self.0 {
            Value::Rational(q) => Other {
                residue: Class::from_rational(q),
                interval: Some(Interval::of(q, BITS)),
                formula: Some(Formula::leaf(Operation::Rational(q.clone()))),
                sample: None,
            },
            Value::Other(x) => (**x).clone(),
        }
    }

    fn is_rational(&self, q: &RBig) -> bool {
        self.rational() == Some(q)
    }

    fn sum(&self, other: &Self) -> Self {
        if let (Value::Rational(a), Value::Rational(b)) = (&self.0, &other.0) {
            return Self::from(a + b);
        }
        if self.is_zero() {
            return other.clone();
        }
        if other.is_zero() {
            return self.clone();
        }
        self.of_two(other, |a, b| a + b, Interval::plus, Operation::Sum)
    }

    fn difference(&self, other: &Self) -> Self {
        self.sum(&other.opposite())
    }

    fn product(&self, other: &Self) -> Self {
        if let (Value::Rational(a), Value::Rational(b)) = (&self.0, &other.0) {
            return Self::from(a * b);
        }
        if self.is_zero() || other.is_rational(&RBig::ONE) {
            return self.clone();
        }
        if other.is_zero() || self.is_rational(&RBig::ONE) {
            return other.clone();
        }
        self.of_two(other, |a, b| a * b, Interval::times, Operation::Product)
    }

    fn opposite(&self) -> Self {
        match &self.0 {
            Value::Rational(q) => Self::from(-q.clone()),
            Value::Other(_) => self.product(&Self::from(-1)),
        }
    }

    /// The quotient; nothing is known of that by 0.
    fn ratio(&self, divisor: &Self) -> Self {
        match (&self.0, &divisor.0) {
            (Value::Rational(a), Value::Rational(b)) if *b != RBig::ZERO => Self::from(a / b),
            _ => divisor.inverse().map_or(Self(Value::Other(Box::default())), |inverse| self.product(&inverse)),
        }
    }
}

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Value::Rational(a), Value::Rational(b)) => a == b,
            _ => self.difference(other).is_zero(),
        }
    }
}

impl FieldElement for Real {
    const ZERO: Self = Self(Value::Rational(RBig::ZERO));
    const ONE: Self = Self(Value::Rational(RBig::ONE));

    fn inverse(&self) -> Option<Self> {
        match &self.0 {
            Value::Rational(q) => q.inverse().map(Self::from),
            Value::Other(x) => {
                let formula = x
                    .formula
                    .clone()
                    .filter(|f| f.operations < MAX_OPERATIONS)
                    .map(|f| Rc::new(Formula { operations: f.operations + 1, last: Operation::Inverse(f) }));
                let interval = x.interval.as_ref().and_then(|i| i.inverse(BITS));
                let residue = x.residue.and_then(Class::inv);
                Some(Self::made(Other { residue, interval, formula, sample: x.sample.clone() }))
            }
        }
    }

    fn scale(&mut self, factor: &Self) {
        match (&mut self.0, &factor.0) {
            (Value::Rational(q), Value::Rational(f)) => q.scale(f),
            _ => *self = self.product(factor),
        }
    }

    fn subtract_product(&mut self, a: &Self, b: &Self) {
        match (&mut self.0, &a.0, &b.0) {
            (Value::Rational(q), Value::Rational(a), Value::Rational(b)) => q.subtract_product(a, b),
            _ => *self = self.sum(&a.product(b).opposite()),
        }
    }

    fn is_zero(&self) -> bool {
        self.is_rational(&RBig::ZERO)
    }
}

impl OrderedField for Real {
    fn of(q: RBig) -> Self {
        Self::from(q)
    }

    fn plus(&self, other: &Self) -> Self {
        self.sum(other)
    }

    fn times(&self, other: &Self) -> Self {
        self.product(other)
    }

    fn negative(&self) -> Self {
        self.opposite()
    }

    fn sign(&self) -> Option<Ordering> {
        match &self.0 {
            Value::Rational(q) => Some(q.cmp(&RBig::ZERO)),
            Value::Other(x) => x.interval.as_ref().filter(|i| !i.holds_zero()).and_then(Interval::sign),
        }
    }

    fn approximation(&self) -> Option<RBig> {
        match &self.0 {
            Value::Rational(q) => Some(q.clone()),
            Value::Other(x) => x.interval.as_ref().map(Interval::middle),
        }
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $of:ident) => {
        impl $name<&Real> for &Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                self.$of(other)
            }
        }
        impl $name<Real> for &Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                self.$of(&other)
            }
        }
        impl $name<&Real> for Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                self.$of(other)
            }
        }
        impl $name for Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                self.$of(&other)
            }
        }
    };
}

operator!(Add, add, sum);
operator!(Sub, sub, difference);
operator!(Mul, mul, product);
operator!(Div, div, ratio);

impl Neg for Real {
    type Output = Real;
    fn neg(self) -> Real {
        self.opposite()
    }
}

impl Neg for &Real {
    type Output = Real;
    fn neg(self) -> Real {
        self.opposite()
    }
}

impl AddAssign<&Real> for Real {
    fn add_assign(&mut self, other: &Real) {
        *self = self.sum(other);
    }
}

impl AddAssign for Real {
    fn add_assign(&mut self, other: Real) {
        *self = self.sum(&other);
    }
}

impl SubAssign<&Real> for Real {
    fn sub_assign(&mut self, other: &Real) {
        *self = self.difference(other);
    }
}

impl SubAssign for Real {
    fn sub_assign(&mut self, other: Real) {
        *self = self.difference(&other);
    }
}
