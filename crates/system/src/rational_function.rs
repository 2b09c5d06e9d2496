//! Functions of one input that are rational in the input, in its sine and cosine, or in its exponential.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, RealRoot, Symbol, UnivariatePolynomial};

use crate::images::Images;
use crate::interval::{End, Interval};

/// What a function is rational in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Variable {
    /// The input itself.
    Input,
    /// Another subexpression.
    Plain(Expr),
    /// τ = tan(t/2), with sin t = 2τ/(1+τ²) and cos t = (1−τ²)/(1+τ²).
    HalfTangent(Expr),
    /// E = exp(t), with sinh, cosh and tanh of t as rational functions of it.
    Exponential(Expr),
    /// E > 0 with u = c (E − 1/E)/2, and √base = s (E + 1/E)/2, for base = (s/c)² (c² + u²).
    Hyperbola {
        /// The radicand.
        base: Expr,
    },
}

/// p/q without common factors, in one [`Variable`].
#[derive(Clone, Debug)]
pub(crate) struct RationalFunction {
    numerator: UnivariatePolynomial,
    denominator: UnivariatePolynomial,
    variable: Option<Variable>,
    input: Symbol,
    /// c and s of a hyperbola.
    scales: [Rational; 2],
}

/// Degree beyond which a function is given up.
const MAX_DEGREE: usize = 24;

/// √x where that is rational.
fn rational_root(x: &Rational) -> Option<Rational> {
    let root = Rational::simplest_from_f64(x.to_f64().value().sqrt())?;
    (root.clone() * root.clone() == *x).then_some(root)
}

fn integers(c: &[i64]) -> UnivariatePolynomial {
    UnivariatePolynomial::new(c.iter().map(|&k| Rational::from(k)).collect())
}

impl RationalFunction {
    /// `e` as a rational function, if it is one with rational coefficients.
    pub(crate) fn of(pool: &mut Pool, e: Expr, input: Symbol) -> Option<Self> {
        let mut f = RationalFunction {
            numerator: integers(&[]),
            denominator: integers(&[1]),
            variable: None,
            input,
            scales: [Rational::ONE, Rational::ONE],
        };
        f.find_hyperbola(pool, e);
        let (p, q) = f.read(pool, e)?;
        let common = p.gcd(&q);
        let reduced = |p: &UnivariatePolynomial| p.quotient(&common);
        f.numerator = reduced(&p);
        f.denominator = reduced(&q);
        Some(f)
    }

    /// Takes the hyperbola as variable where the root of a sum of squares occurs.
    fn find_hyperbola(&mut self, pool: &mut Pool, e: Expr) {
        for n in pool.reachable(&[e]) {
            let Node::Pow(base, k) = pool.node(n) else { continue };
            let half = pool.number(k).is_some_and(|k| !k.is_int() && (k.clone() * Rational::from(2)).is_int());
            if !half || !pool.depends_on(base, self.input) {
                continue;
            }
            let Some(inside) = RationalFunction::of(pool, base, self.input) else { continue };
            let p = &inside.numerator;
            let square_sum = inside.is_polynomial_of_input()
                && p.degree() == 2
                && p.derivative().at(&Rational::ZERO) == Rational::ZERO;
            let (a, b) =
                (p.at(&Rational::ZERO) / inside.denominator.leading(), p.leading() / inside.denominator.leading());
            if !square_sum || a <= Rational::ZERO || b <= Rational::ZERO {
                continue;
            }
            if let (Some(c), Some(s)) = (rational_root(&(a.clone() / b)), rational_root(&a)) {
                self.variable = Some(Variable::Hyperbola { base });
                self.scales = [c, s];
                return;
            }
        }
    }

    /// Powers of the root of the radicand, and the input, on the hyperbola.
    fn read_on_hyperbola(
        &self,
        pool: &mut Pool,
        e: Expr,
        base: Expr,
    ) -> Option<(UnivariatePolynomial, UnivariatePolynomial)> {
        let two_e = integers(&[0, 2]);
        match pool.node(e) {
            Node::Sym(s) if s == self.input => Some((integers(&[-1, 0, 1]).scaled(&self.scales[0]), two_e)),
            Node::Pow(b, k) if b == base => {
                let k = pool.number(k)?.clone() * Rational::from(2);
                let k = i64::try_from(k.numerator()).ok().filter(|k| k.unsigned_abs() <= MAX_DEGREE as u64 / 2)?;
                let root = (integers(&[1, 0, 1]).scaled(&self.scales[1]), two_e);
                let power = |p: &UnivariatePolynomial| (0..k.unsigned_abs()).fold(integers(&[1]), |m, _| m.mul(p));
                let (p, q) = (power(&root.0), power(&root.1));
                Some(if k > 0 { (p, q) } else { (q, p) })
            }
            _ => None,
        }
    }

    fn read(&mut self, pool: &mut Pool, e: Expr) -> Option<(UnivariatePolynomial, UnivariatePolynomial)> {
        let one = integers(&[1]);
        if let Some(c) = pool.number(e) {
            return Some((UnivariatePolynomial::new(vec![c.clone()]), one));
        }
        if let Some(Variable::Hyperbola { base }) = self.variable
            && let Some(found) = self.read_on_hyperbola(pool, e, base)
        {
            return Some(found);
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
                let power = |p: &UnivariatePolynomial| {
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
                let n = self.take_exponential(pool, t)?;
                // E^n and E^(−n) as numerator and denominator.
                let power = |k: u64| (0..k).fold(integers(&[1]), |m, _| m.mul(&integers(&[0, 1])));
                let (up, square) = (power(n.unsigned_abs()), power(2 * n.unsigned_abs()));
                let sum = square.add(&one);
                let difference = square.sub(&one).scaled(&Rational::from(n.signum()));
                let twice = up.scaled(&Rational::from(2));
                match f {
                    Func::Exp if n > 0 => (up, one),
                    Func::Exp => (one, up),
                    Func::Sinh => (difference, twice),
                    Func::Cosh => (sum, twice),
                    _ => (difference, sum),
                }
            }
            Node::Sym(_) => {
                self.take(Variable::Input)?;
                (integers(&[0, 1]), one)
            }
            _ => {
                self.take(Variable::Plain(e))?;
                (integers(&[0, 1]), one)
            }
        };
        (found.0.degree().max(found.1.degree()) <= MAX_DEGREE).then_some(found)
    }

    /// n ≠ 0 with t = n·t₀ for the exponential exp(t₀) that is the variable; `None` if the function is rational in
    /// something else.
    fn take_exponential(&mut self, pool: &mut Pool, t: Expr) -> Option<i64> {
        let Some(Variable::Exponential(first)) = self.variable else {
            return self.take(Variable::Exponential(t)).map(|()| 1);
        };
        let ratio = pool.div(t, first);
        let ratio = pool.simplify(ratio);
        pool.integer(ratio).filter(|n| *n != 0 && n.unsigned_abs() <= MAX_DEGREE as u64 / 2)
    }

    /// `None` if the function is already rational in something else.
    fn take(&mut self, v: Variable) -> Option<()> {
        (*self.variable.get_or_insert(v) == v).then_some(())
    }

    /// Whether it is a polynomial in the input itself.
    pub(crate) fn is_polynomial_of_input(&self) -> bool {
        self.denominator.degree() == 0 && self.variable == Some(Variable::Input)
    }

    /// The zeros in the variable.
    pub(crate) fn zeros(&self) -> Vec<RealRoot> {
        self.numerator.roots()
    }

    /// The interval of the variable.
    pub(crate) fn domain(&self, images: &mut Images<'_>) -> Option<Interval> {
        match self.variable? {
            Variable::Input => images.domain.get(&self.input).cloned(),
            Variable::Plain(e) => images.of(e).ok(),
            Variable::Exponential(t) => {
                let on = images.of(t).ok()?;
                on.image(images.pool, Func::Exp)
            }
            Variable::Hyperbola { .. } => {
                let whole = images.domain.get(&self.input).is_some_and(Interval::is_all);
                let positive =
                    Interval { lower: End::rational(images.pool, &Rational::ZERO, false), ..Interval::all() };
                whole.then_some(positive)
            }
            // A whole turn is needed, and the point at infinity with it.
            Variable::HalfTangent(t) => images.of(t).ok().filter(Interval::is_all),
        }
    }

    /// The input's values at the zeros, ascending: exactly, else rounded. `None` for a function of something else.
    pub(crate) fn zeros_of_input(&self) -> Option<Vec<RealRoot>> {
        (self.variable == Some(Variable::Input)).then(|| self.zeros())
    }

    /// The set of values on an interval of the variable; `None` if there is a pole.
    pub(crate) fn image(&self, pool: &mut Pool, on: &Interval) -> Option<Interval> {
        let (p, q) = (&self.numerator, &self.denominator);
        let near = |r: &RealRoot| {
            on.holds_inside(r.value) || [&on.lower, &on.upper].iter().any(|e| crate::interval::close(e.value, r.value))
        };
        // A pole at an open end 0 is a limit, that of an exponential at −∞.
        let limit = |r: &RealRoot| r.exact == Some(Rational::ZERO) && on.lower.value == 0.0 && !on.lower.closed;
        if q.roots().iter().any(|r| near(r) && !limit(r)) {
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
        if exact == Some(Rational::ZERO) && q.at(&Rational::ZERO) == Rational::ZERO {
            let rises = (p.at(&Rational::ZERO) > Rational::ZERO) == (q.lowest() > Rational::ZERO);
            return Some(End::infinite(if rises { f64::INFINITY } else { f64::NEG_INFINITY }));
        }
        Some(if let Some(x) = exact {
            End::rational(pool, &self.value(&x), end.closed)
        } else {
            let x = Rational::simplest_from_f64(end.value)?;
            End { value: self.value(&x).to_f64().value(), exact: None, closed: end.closed }
        })
    }

    /// The value at a zero of the derivative; exact where it is rational.
    fn at_critical(&self, pool: &mut Pool, c: &RealRoot, slope: &UnivariatePolynomial) -> End {
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
