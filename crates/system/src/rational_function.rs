//! Functions of one input that are rational in the input, in its sine and cosine, or in its exponential.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, Symbol};

use crate::interval::{End, Interval};
use crate::polynomial::{Polynomial, Root};
use crate::range::Images;

/// What a function is rational in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Variable {
    /// A subexpression itself.
    Plain(Expr),
    /// τ = tan(t/2), with sin t = 2τ/(1+τ²) and cos t = (1−τ²)/(1+τ²).
    HalfTangent(Expr),
    /// E = exp(t), with sinh, cosh and tanh of t as rational functions of it.
    Exponential(Expr),
}

/// p/q without common factors, in one [`Variable`].
#[derive(Clone, Debug)]
pub(crate) struct RationalFunction {
    numerator: Polynomial,
    denominator: Polynomial,
    variable: Option<Variable>,
    input: Symbol,
}

/// Degree beyond which a function is given up.
const MAX_DEGREE: usize = 24;

fn integers(c: &[i64]) -> Polynomial {
    Polynomial::new(c.iter().map(|&k| Rational::from(k)).collect())
}

impl RationalFunction {
    /// `e` as a rational function, if it is one with rational coefficients.
    pub(crate) fn of(pool: &mut Pool, e: Expr, input: Symbol) -> Option<Self> {
        let mut f = RationalFunction { numerator: integers(&[]), denominator: integers(&[1]), variable: None, input };
        let (p, q) = f.read(pool, e)?;
        let common = p.gcd(&q);
        let reduced = |p: &Polynomial| p.quotient(&common);
        f.numerator = reduced(&p);
        f.denominator = reduced(&q);
        Some(f)
    }

    fn read(&mut self, pool: &mut Pool, e: Expr) -> Option<(Polynomial, Polynomial)> {
        let one = integers(&[1]);
        if let Some(c) = pool.number(e) {
            return Some((Polynomial::new(vec![c.clone()]), one));
        }
        let found = match pool.node(e) {
            Node::Add(a, b) => {
                let ((p, q), (r, s)) = (self.read(pool, a)?, self.read(pool, b)?);
                if q == s { (p.add(&r), q) } else { (p.mul(&s).add(&r.mul(&q)), q.mul(&s)) }
            }
            Node::Mul(a, b) => {
                let ((p, q), (r, s)) = (self.read(pool, a)?, self.read(pool, b)?);
                (p.mul(&r), q.mul(&s))
            }
            Node::Pow(a, k) if pool.integer(k).is_some_and(|k| k.unsigned_abs() <= MAX_DEGREE as u64) => {
                let k = pool.integer(k)?;
                let (p, q) = self.read(pool, a)?;
                let power = |p: &Polynomial| {
                    (0..k.unsigned_abs())
                        .try_fold(one.clone(), |m, _| (m.degree() + p.degree() <= MAX_DEGREE).then(|| m.mul(p)))
                };
                let (p, q) = (power(&p)?, power(&q)?);
                if k > 0 {
                    (p, q)
                } else if p.is_zero() {
                    return None;
                } else {
                    (q, p)
                }
            }
            _ if !pool.depends_on(e, self.input) => return None,
            Node::Call(f @ (Func::Sin | Func::Cos | Func::Tan), t) => {
                self.take(Variable::HalfTangent(t))?;
                match f {
                    Func::Sin => (integers(&[0, 2]), integers(&[1, 0, 1])),
                    Func::Cos => (integers(&[1, 0, -1]), integers(&[1, 0, 1])),
                    _ => (integers(&[0, 2]), integers(&[1, 0, -1])),
                }
            }
            Node::Call(f @ (Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh), t) => {
                self.take(Variable::Exponential(t))?;
                match f {
                    Func::Exp => (integers(&[0, 1]), one),
                    Func::Sinh => (integers(&[-1, 0, 1]), integers(&[0, 2])),
                    Func::Cosh => (integers(&[1, 0, 1]), integers(&[0, 2])),
                    _ => (integers(&[-1, 0, 1]), integers(&[1, 0, 1])),
                }
            }
            _ => {
                self.take(Variable::Plain(e))?;
                (integers(&[0, 1]), one)
            }
        };
        (found.0.degree().max(found.1.degree()) <= MAX_DEGREE).then_some(found)
    }

    /// `None` if the function is already rational in something else.
    fn take(&mut self, v: Variable) -> Option<()> {
        (*self.variable.get_or_insert(v) == v).then_some(())
    }

    /// Whether it is a polynomial in the input itself.
    pub(crate) fn is_polynomial_of_input(&self) -> bool {
        self.denominator.degree() == 0 && matches!(self.variable, Some(Variable::Plain(_)))
    }

    /// The zeros in the variable.
    pub(crate) fn zeros(&self) -> Vec<Root> {
        self.numerator.roots()
    }

    /// The interval of the variable.
    pub(crate) fn domain(&self, images: &mut Images<'_>) -> Option<Interval> {
        match self.variable? {
            Variable::Plain(e) => match images.pool.node(e) {
                Node::Sym(u) => images.domain.get(&u).cloned(),
                _ => images.of(e).ok(),
            },
            Variable::Exponential(t) => {
                let on = images.of(t).ok()?;
                on.image(images.pool, Func::Exp)
            }
            // A whole turn is needed, and the point at infinity with it.
            Variable::HalfTangent(t) => images.of(t).ok().filter(Interval::is_all),
        }
    }

    /// The set of values on an interval of the variable; `None` if there is a pole.
    pub(crate) fn image(&self, pool: &mut Pool, on: &Interval) -> Option<Interval> {
        let (p, q) = (&self.numerator, &self.denominator);
        let near = |r: &Root| {
            on.holds_inside(r.value) || [&on.lower, &on.upper].iter().any(|e| crate::interval::close(e.value, r.value))
        };
        if q.roots().iter().any(near) {
            return None;
        }
        let mut ends = Vec::new();
        for e in [&on.lower, &on.upper] {
            ends.push(self.at_end(pool, e)?);
        }
        let slope = p.derivative().mul(q).sub(&p.mul(&q.derivative()));
        for c in slope.roots().iter().filter(|c| on.holds_inside(c.value)) {
            ends.push(self.at_critical(pool, c, &slope));
        }
        Interval::hull(&ends)
    }

    fn value(&self, x: &Rational) -> Rational {
        self.numerator.at(x) / self.denominator.at(x)
    }

    fn at_end(&self, pool: &mut Pool, end: &End) -> Option<End> {
        let (p, q) = (&self.numerator, &self.denominator);
        if end.value.is_infinite() {
            let closed = matches!(self.variable, Some(Variable::HalfTangent(_)));
            return Some(match p.degree().cmp(&q.degree()) {
                std::cmp::Ordering::Less => End::rational(pool, &Rational::ZERO, closed),
                std::cmp::Ordering::Equal => End::rational(pool, &(p.leading() / q.leading()), closed),
                std::cmp::Ordering::Greater if closed => return None,
                std::cmp::Ordering::Greater => {
                    let flips = end.value < 0.0 && (p.degree() - q.degree()) % 2 == 1;
                    let rises = (p.leading() / q.leading() > Rational::ZERO) != flips;
                    End::infinite(if rises { f64::INFINITY } else { f64::NEG_INFINITY })
                }
            });
        }
        let exact = end.exact.and_then(|e| pool.number(e).cloned());
        Some(if let Some(x) = exact {
            End::rational(pool, &self.value(&x), end.closed)
        } else {
            let x = Rational::simplest_from_f64(end.value)?;
            End { value: self.value(&x).to_f64().value(), exact: None, closed: end.closed }
        })
    }

    /// The value at a zero of the derivative; exact where it is rational.
    fn at_critical(&self, pool: &mut Pool, c: &Root, slope: &Polynomial) -> End {
        if let Some(x) = &c.exact {
            return End::rational(pool, &self.value(x), true);
        }
        let value = self.value(&c.between[1]).to_f64().value();
        // y is the value at c if p − y q vanishes there too.
        let guess = Rational::simplest_from_f64((value * 1e12).round() / 1e12).filter(|y| {
            let difference = self.numerator.sub(&self.denominator.scaled(y));
            difference.gcd(slope).has_root_between(&c.between)
        });
        match guess {
            Some(y) => End::rational(pool, &y, true),
            None => End { value, exact: None, closed: true },
        }
    }
}
