//! Limits of a function of one input at both ends, for continuous functions that take every value between.

use bracketry_symbolic::{Expr, Func, Node, Rational, Symbol};

use crate::images::{Images, number};

/// What a function does as its input goes to one end.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Limit {
    /// It goes to a finite value.
    Value(f64),
    /// It stays bounded.
    Bounded,
    /// It goes to +∞ or −∞.
    Infinite { positive: bool },
}

impl Limit {
    fn sum(self, other: Self) -> Option<Self> {
        Some(match (self, other) {
            (Limit::Infinite { positive: a }, Limit::Infinite { positive: b }) => {
                return (a == b).then_some(self);
            }
            (l @ Limit::Infinite { .. }, _) | (_, l @ Limit::Infinite { .. }) => l,
            (Limit::Value(a), Limit::Value(b)) => Limit::Value(a + b),
            _ => Limit::Bounded,
        })
    }

    fn product(self, other: Self) -> Option<Self> {
        Some(match (self, other) {
            (Limit::Infinite { positive: a }, Limit::Infinite { positive: b }) => Limit::Infinite { positive: a == b },
            (Limit::Infinite { positive }, Limit::Value(v)) | (Limit::Value(v), Limit::Infinite { positive }) => {
                if v == 0.0 {
                    return None;
                }
                Limit::Infinite { positive: positive == (v > 0.0) }
            }
            (Limit::Infinite { .. }, _) | (_, Limit::Infinite { .. }) => return None,
            (Limit::Value(a), Limit::Value(b)) => Limit::Value(a * b),
            _ => Limit::Bounded,
        })
    }
}

/// Whether `e` is continuous in `u` on the whole line and goes to opposite infinities at its ends, so that it takes
/// every value.
pub(crate) fn rises_through_all(images: &mut Images<'_>, e: Expr, u: Symbol) -> bool {
    matches!(
        limits(images, e, u),
        Some([Limit::Infinite { positive: a }, Limit::Infinite { positive: b }]) if a != b
    )
}

/// Limits at −∞ and +∞ of a function that is continuous on the whole line; `None` if that is not seen.
fn limits(images: &mut Images<'_>, e: Expr, u: Symbol) -> Option<[Limit; 2]> {
    if !images.pool.depends_on(e, u) {
        return number(images.pool, e).map(|v| [Limit::Value(v); 2]);
    }
    match images.pool.node(e) {
        Node::Sym(_) => Some([Limit::Infinite { positive: false }, Limit::Infinite { positive: true }]),
        Node::Add(a, b) => {
            let (a, b) = (limits(images, a, u)?, limits(images, b, u)?);
            Some([a[0].sum(b[0])?, a[1].sum(b[1])?])
        }
        Node::Mul(a, b) => {
            let (a, b) = (limits(images, a, u)?, limits(images, b, u)?);
            Some([a[0].product(b[0])?, a[1].product(b[1])?])
        }
        Node::Pow(a, k) => {
            let k = images.pool.number(k)?.clone();
            let base = limits(images, a, u)?;
            // Roots and inverse powers are continuous where the base stays positive.
            let mut positive = || images.of(a).is_ok_and(|i| i.lower.value > 0.0);
            let polynomial = k.is_int() && k > Rational::ZERO;
            if !polynomial && !positive() {
                return None;
            }
            let power = |l: Limit| match l {
                Limit::Value(v) => Some(Limit::Value(v.powf(k.to_f64().value()))),
                Limit::Bounded => (k > Rational::ZERO).then_some(Limit::Bounded),
                Limit::Infinite { .. } if k < Rational::ZERO => Some(Limit::Value(0.0)),
                Limit::Infinite { positive } => {
                    let even =
                        k.is_int() && Rational::from((k.clone() / Rational::from(2)).floor()) * Rational::from(2) == k;
                    Some(Limit::Infinite { positive: positive || even })
                }
            };
            Some([power(base[0])?, power(base[1])?])
        }
        Node::Call(f, a) => {
            let inner = limits(images, a, u)?;
            let wave = matches!(f, Func::Sin | Func::Cos);
            let bounded = wave || matches!(f, Func::Tanh | Func::Atan);
            let everywhere = bounded || matches!(f, Func::Exp | Func::Sinh | Func::Cosh);
            let outer = |l: Limit| match (f, l) {
                _ if !everywhere => None,
                (_, Limit::Value(v)) => Some(Limit::Value(f.eval(v))),
                (_, Limit::Bounded) => Some(Limit::Bounded),
                _ if wave => Some(Limit::Bounded),
                (Func::Exp, Limit::Infinite { positive: false }) => Some(Limit::Value(0.0)),
                (Func::Exp | Func::Cosh, Limit::Infinite { .. }) => Some(Limit::Infinite { positive: true }),
                (Func::Sinh, Limit::Infinite { .. }) => Some(l),
                (_, Limit::Infinite { positive }) => {
                    Some(Limit::Value(f.eval(if positive { f64::INFINITY } else { f64::NEG_INFINITY })))
                }
            };
            Some([outer(inner[0])?, outer(inner[1])?])
        }
        _ => None,
    }
}
