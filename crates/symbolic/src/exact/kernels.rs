//! Kernels met so far: angles, exponents and radicands that are independent of each other.

use rustc_hash::{FxHashMap, FxHashSet};

use super::program::Reg;
use crate::func::Func;
use crate::node::{Expr, Symbol};

/// A register of an angle, and what is known of its D-th part.
#[derive(Clone, Copy)]
pub(super) struct Angle {
    pub(super) value: Reg,
    pub(super) kind: AngleKind,
    pub(super) parts: u64,
}

/// Cosine and sine of the part of an angle.
#[derive(Clone, Copy)]
pub(super) enum AngleKind {
    /// They are generators.
    Free((Reg, Reg)),
    /// The angle is that of a point of the unit circle.
    OfPoint((Reg, Reg)),
    /// The angle is an inverse function whose cosine is no expression of the field.
    Inverse,
}

/// Angles met so far that are no rational combinations of each other and π.
#[derive(Default)]
pub(super) struct Circle {
    pub(super) basis: Vec<Angle>,
    /// The indeterminates on which the basis depends.
    pub(super) symbols: FxHashSet<Symbol>,
    pub(super) points: FxHashMap<Expr, (Reg, Reg)>,
    /// Inverse functions (atan also for atan2), their operands, and their values.
    pub(super) inverses: Vec<(Func, Vec<Expr>, Reg)>,
    /// Constant angles: by primes of the Gaussian integers, and the quadratic fields of others.
    pub(super) primes: FxHashMap<u64, Reg>,
    pub(super) fields: FxHashSet<Vec<u64>>,
}

/// Where the exponential of an exponent comes from.
#[derive(Clone, Copy)]
pub(super) enum Power {
    /// The generator (in this register) to this power.
    Free(Reg, u64),
    /// The argument of a logarithm.
    Argument(Reg, Expr),
    /// An integer constant.
    Integer(u64, Reg),
}

impl Power {
    pub(super) fn base(self) -> Reg {
        match self {
            Power::Free(r, _) | Power::Argument(r, _) | Power::Integer(_, r) => r,
        }
    }
}

/// Exponents met so far that are no rational combinations of each other.
#[derive(Default)]
pub(super) struct ExpLog {
    pub(super) basis: Vec<(Reg, Power)>,
    pub(super) exponentials: FxHashMap<Reg, Reg>,
    pub(super) logarithms: FxHashMap<Expr, Reg>,
}

/// A radicand that is no square times a product of others.
pub(super) struct Radicand {
    pub(super) base: Expr,
    pub(super) value: Reg,
    pub(super) root: Reg,
    pub(super) levels: u32,
}

/// Radicands met so far.
#[derive(Default)]
pub(super) struct Roots {
    pub(super) free: Vec<Radicand>,
    pub(super) known: FxHashMap<Expr, (Reg, u32)>,
    /// Number of roots of squares, whose sign differs from point to point.
    pub(super) ambiguous: u32,
    /// Number of square roots that must exist at a point, each with probability one half.
    pub(super) conditions: u32,
    /// Degree of the field extension that the roots generate (less one is 0).
    pub(super) extension: f64,
}
