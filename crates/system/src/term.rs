//! Expressions of a system that is being built, with the operators of Rust.

use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

use bracketry_symbolic::{Expr, Func, Func2, Pool, Rational};

use crate::rules::ModelError;

/// The expressions of a [`Builder`](crate::Builder), and the first thing that was wrong with them.
#[derive(Default)]
pub(crate) struct Sheet {
    pub(crate) pool: RefCell<Pool>,
    pub(crate) error: RefCell<Option<ModelError>>,
}

impl Sheet {
    /// The first error of all is the one that is told.
    pub(crate) fn refuse(&self, error: ModelError) {
        self.error.borrow_mut().get_or_insert(error);
    }

    /// A number by its shortest decimal form, exactly: 0.3 is 3/10, as in a file.
    pub(crate) fn exact(&self, value: f64) -> Rational {
        let mut pool = Pool::new();
        let read = if value.is_finite() { pool.parse(&format!("{value:e}")).ok() } else { None };
        read.and_then(|e| pool.number(e).cloned()).unwrap_or_else(|| {
            self.refuse(ModelError::new(format!("{value} is not a number of a model"), "give a finite number"));
            Rational::ZERO
        })
    }

    pub(crate) fn expr(&self, operand: Operand<'_>) -> Expr {
        match operand {
            Operand::Term(term) => {
                assert!(std::ptr::eq(self, term.sheet), "terms of two builders cannot be combined");
                term.expr
            }
            Operand::Number(value) => {
                let value = self.exact(value);
                self.pool.borrow_mut().rational(value)
            }
        }
    }
}

/// An expression of a [`Builder`](crate::Builder): a state, an input, a parameter, or what operators and functions make
/// of them.
///
/// # Panics
/// Operations panic if their operands are of two builders.
#[derive(Clone, Copy)]
pub struct Term<'b> {
    pub(crate) sheet: &'b Sheet,
    pub(crate) expr: Expr,
}

/// A term or a number.
#[derive(Clone, Copy, Debug)]
pub enum Operand<'b> {
    /// An expression.
    Term(Term<'b>),
    /// A number, taken by its shortest decimal form.
    Number(f64),
}

impl<'b> From<Term<'b>> for Operand<'b> {
    fn from(term: Term<'b>) -> Self {
        Operand::Term(term)
    }
}

impl From<f64> for Operand<'_> {
    fn from(value: f64) -> Self {
        Operand::Number(value)
    }
}

impl From<i32> for Operand<'_> {
    fn from(value: i32) -> Self {
        Operand::Number(f64::from(value))
    }
}

impl<'b> Term<'b> {
    fn unary(self, f: impl FnOnce(&mut Pool, Expr) -> Expr) -> Self {
        Term { sheet: self.sheet, expr: f(&mut self.sheet.pool.borrow_mut(), self.expr) }
    }

    fn binary(self, other: impl Into<Operand<'b>>, f: impl FnOnce(&mut Pool, Expr, Expr) -> Expr) -> Self {
        let other = self.sheet.expr(other.into());
        self.unary(|pool, e| f(pool, e, other))
    }

    /// This to a power: a number or an expression.
    #[must_use]
    pub fn pow(self, exponent: impl Into<Operand<'b>>) -> Self {
        self.binary(exponent, Pool::pow)
    }

    /// Square root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        self.unary(Pool::sqrt)
    }

    /// The angle of the point (`x`, this).
    #[must_use]
    pub fn atan2(self, x: impl Into<Operand<'b>>) -> Self {
        self.binary(x, |pool, a, b| pool.call2(Func2::Atan2, a, b))
    }

    /// The smaller of two.
    #[must_use]
    pub fn min(self, other: impl Into<Operand<'b>>) -> Self {
        self.binary(other, |pool, a, b| pool.call2(Func2::Min, a, b))
    }

    /// The larger of two.
    #[must_use]
    pub fn max(self, other: impl Into<Operand<'b>>) -> Self {
        self.binary(other, |pool, a, b| pool.call2(Func2::Max, a, b))
    }
}

macro_rules! functions {
    ($($(#[$doc:meta])* $name:ident $function:ident;)*) => {
        impl Term<'_> {
            $($(#[$doc])*
            #[must_use]
            pub fn $name(self) -> Self {
                self.unary(|pool, a| pool.call(Func::$function, a))
            })*
        }
    };
}

functions! {
    /// Sine.
    sin Sin;
    /// Cosine.
    cos Cos;
    /// Tangent.
    tan Tan;
    /// Inverse sine.
    asin Asin;
    /// Inverse cosine.
    acos Acos;
    /// Inverse tangent.
    atan Atan;
    /// Hyperbolic sine.
    sinh Sinh;
    /// Hyperbolic cosine.
    cosh Cosh;
    /// Hyperbolic tangent.
    tanh Tanh;
    /// Exponential.
    exp Exp;
    /// Natural logarithm.
    ln Log;
    /// Absolute value.
    abs Abs;
    /// Sign, set-valued at zero (Filippov): how dry friction is written.
    sign Sign;
}

macro_rules! operators {
    ($($operator:ident $name:ident)*) => {$(
        impl<'b, T: Into<Operand<'b>>> $operator<T> for Term<'b> {
            type Output = Term<'b>;
            fn $name(self, other: T) -> Term<'b> {
                self.binary(other, Pool::$name)
            }
        }
        operators!($operator $name f64);
        operators!($operator $name i32);
    )*};
    ($operator:ident $name:ident $number:ident) => {
        impl<'b> $operator<Term<'b>> for $number {
            type Output = Term<'b>;
            fn $name(self, other: Term<'b>) -> Term<'b> {
                let number = other.sheet.expr(Operand::from(self));
                Term { expr: number, ..other }.binary(other, Pool::$name)
            }
        }
    };
}

operators! { Add add Sub sub Mul mul Div div }

impl Neg for Term<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(Pool::neg)
    }
}

impl fmt::Display for Term<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sheet.pool.borrow().text(self.expr))
    }
}

impl fmt::Debug for Term<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Term({self})")
    }
}
