//! Values at a point, second derivatives, and Taylor polynomials.

use std::collections::BTreeMap;

use dashu_base::Sign;
use rustc_hash::FxHashMap;

use crate::exact::Bindings;
use crate::func::{Func, Func2};
use crate::node::{Expr, Node, Symbol};
use crate::pool::Pool;

/// Terms of a Taylor polynomial beyond which it is refused.
const MAX_TERMS: usize = 20_000;

/// Why an expression has no value, or no Taylor polynomial, at a point.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EvaluationError {
    /// A quotient or logarithm whose divisor or argument is zero there.
    #[error("`{text}` has no value at this point")]
    NoValue {
        /// The sub-expression, before the point is put in.
        text: String,
    },
    /// A function that has no derivatives there: `abs`, `sign`, `min`, `max` where they switch, a root of zero.
    #[error("`{text}` is not smooth at this point")]
    NotSmooth {
        /// The sub-expression, before the point is put in.
        text: String,
    },
    /// The polynomial would have too many terms.
    #[error("a Taylor polynomial of degree {degree} in {variables} variables has more than {MAX_TERMS} terms")]
    TooManyTerms {
        /// Number of variables.
        variables: usize,
        /// Total degree asked for.
        degree: u32,
    },
}

/// Exponents of the variables, and the coefficients of these monomials: a polynomial in the deviations from the point.
type Jet = BTreeMap<Vec<u32>, Expr>;

impl Pool {
    /// Second derivatives of `e`: entry `[i][j]` is ∂²e/∂v_i∂v_j. Symmetric, and each entry is made once.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("x^2*y + y^3").unwrap();
    /// let (x, y) = (p.symbol("x"), p.symbol("y"));
    /// let h = p.hessian(e, &[x, y]);
    /// assert_eq!(p.text(h[0][1]), "2*x");
    /// assert_eq!(h[0][1], h[1][0]);
    /// ```
    pub fn hessian(&mut self, e: Expr, variables: &[Symbol]) -> Vec<Vec<Expr>> {
        let gradient = self.gradient(e, variables);
        let zero = self.int(0);
        let mut h = vec![vec![zero; variables.len()]; variables.len()];
        for i in 0..variables.len() {
            for j in i..variables.len() {
                h[i][j] = self.diff(gradient[i], variables[j]);
                h[j][i] = h[i][j];
            }
        }
        h
    }

    /// `e` with values in place of symbols, all at once. Symbols that are not in `point` stay.
    ///
    /// # Errors
    /// [`EvaluationError::NoValue`] if a divisor or the argument of a logarithm becomes the number 0.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("x/y + cos(x)").unwrap();
    /// let (x, y) = (p.symbol("x"), p.symbol("y"));
    /// let zero = p.int(0);
    /// let v = p.at(e, &[(x, zero)]).unwrap();
    /// assert!(p.is_one(v));
    /// assert_eq!(p.at(e, &[(y, zero)]).unwrap_err().to_string(), "`1/y` has no value at this point");
    /// ```
    pub fn at(&mut self, e: Expr, point: &[(Symbol, Expr)]) -> Result<Expr, EvaluationError> {
        Ok(self.at_all(&[e], point)?[0])
    }

    /// [`Pool::at`] for many expressions, sharing the work.
    ///
    /// # Errors
    /// [`EvaluationError::NoValue`] if a divisor or the argument of a logarithm becomes the number 0.
    pub fn at_all(&mut self, roots: &[Expr], point: &[(Symbol, Expr)]) -> Result<Vec<Expr>, EvaluationError> {
        let values: FxHashMap<Symbol, Expr> = point.iter().copied().collect();
        let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
        for n in self.reachable(roots) {
            let missing = match self.node(n) {
                Node::Pow(b, k) => {
                    self.is_zero(image[&b]) && self.number(image[&k]).is_some_and(|k| k.sign() == Sign::Negative)
                }
                Node::Call(Func::Log, a) => self.is_zero(image[&a]),
                _ => false,
            };
            if missing {
                return Err(EvaluationError::NoValue { text: self.text(n) });
            }
            let r = match self.node(n) {
                Node::Sym(s) => values.get(&s).copied().unwrap_or(n),
                _ => self.rebuild(n, |x| image[&x]),
            };
            image.insert(n, r);
        }
        Ok(roots.iter().map(|r| image[r]).collect())
    }

    /// The Taylor polynomial of `e` about a point in the given variables, up to and including total degree `degree`:
    /// Σ_|α|≤degree ∂^α e(a)/α! · (x − a)^α.
    ///
    /// `about` holds the variables with their values, which may be any expressions that do not depend on the
    /// variables; other symbols stay as they are. It is found by arithmetic with truncated power series (Griewank and
    /// Walther 2008, chapter 13), so no high derivatives of the whole expression are made.
    ///
    /// # Errors
    /// [`EvaluationError`] if `e` has no value there, is not smooth there, or the polynomial has too many terms.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("cos(x)/(1 - y)").unwrap();
    /// let (x, y) = (p.symbol("x"), p.symbol("y"));
    /// let zero = p.int(0);
    /// let t = p.taylor(e, &[(x, zero), (y, zero)], 2).unwrap();
    /// assert_eq!(p.text(t), "y^2 - 0.5*x^2 + y + 1");
    /// ```
    pub fn taylor(&mut self, e: Expr, about: &[(Symbol, Expr)], degree: u32) -> Result<Expr, EvaluationError> {
        let variables = about.len();
        let mut count = 1.0;
        for i in 1..=variables {
            count *= (f64::from(degree) + i as f64) / i as f64;
        }
        if count > MAX_TERMS as f64 {
            return Err(EvaluationError::TooManyTerms { variables, degree });
        }
        let jet = self.jet(e, about, degree)?;
        let mut deviations = Vec::with_capacity(variables);
        for &(s, a) in about {
            let x = self.sym(s);
            deviations.push(self.sub(x, a));
        }
        let mut total = Vec::with_capacity(jet.len());
        for (powers, c) in jet {
            let mut term = self.simplify(c);
            for (&d, &k) in deviations.iter().zip(&powers) {
                let p = self.powi(d, i64::from(k));
                term = self.mul(term, p);
            }
            total.push(term);
        }
        let sum = self.sum(total);
        Ok(self.collected(sum))
    }

    /// Power series of `e` in the deviations from the point.
    fn jet(&mut self, e: Expr, about: &[(Symbol, Expr)], degree: u32) -> Result<Jet, EvaluationError> {
        let variables = about.len();
        let mut jets: FxHashMap<Expr, Jet> = FxHashMap::default();
        for n in self.reachable(&[e]) {
            let jet = match self.node(n) {
                Node::Num(_) | Node::Pi => constant(n, variables),
                Node::Sym(s) => match about.iter().position(|(v, _)| *v == s) {
                    None => constant(n, variables),
                    Some(i) => {
                        let mut jet = constant(about[i].1, variables);
                        if degree > 0 {
                            let mut power = vec![0; variables];
                            power[i] = 1;
                            let one = self.int(1);
                            jet.insert(power, one);
                        }
                        jet
                    }
                },
                Node::Add(a, b) => {
                    let mut sum = jets[&a].clone();
                    for (power, &c) in &jets[&b] {
                        self.accumulate(&mut sum, power.clone(), c);
                    }
                    sum
                }
                Node::Mul(a, b) => self.jet_product(&jets[&a], &jets[&b], degree),
                Node::Pow(a, k) => {
                    if is_constant(&jets[&k]) {
                        let exponent = value(self, &jets[&k], variables);
                        self.jet_power(n, &jets[&a], exponent, variables, degree)?
                    } else {
                        // a^k = exp(k log a)
                        let log = self.jet_call(n, Func::Log, &jets[&a], variables, degree)?;
                        let exponent = self.jet_product(&jets[&k], &log, degree);
                        self.jet_call(n, Func::Exp, &exponent, variables, degree)?
                    }
                }
                Node::Call(f, a) => self.jet_call(n, f, &jets[&a], variables, degree)?,
                Node::Call2(f, a, b) => self.jet_call2(n, f, (&jets[&a], &jets[&b]), variables, degree)?,
            };
            jets.insert(n, jet);
        }
        Ok(jets.remove(&e).unwrap_or_default())
    }

    fn accumulate(&mut self, jet: &mut Jet, power: Vec<u32>, c: Expr) {
        let sum = match jet.get(&power) {
            Some(&old) => self.add(old, c),
            None => c,
        };
        if self.is_zero(sum) {
            jet.remove(&power);
        } else {
            jet.insert(power, sum);
        }
    }

    fn jet_product(&mut self, a: &Jet, b: &Jet, degree: u32) -> Jet {
        let mut out = Jet::new();
        for (p, &x) in a {
            let rest = degree - p.iter().sum::<u32>();
            for (q, &y) in b.iter().filter(|(q, _)| q.iter().sum::<u32>() <= rest) {
                let c = self.mul(x, y);
                self.accumulate(&mut out, p.iter().zip(q).map(|(i, j)| i + j).collect(), c);
            }
        }
        out
    }

    /// Σ_k coefficients\[k\] · (jet − its value)^k by Horner's rule.
    fn jet_series(&mut self, coefficients: &[Expr], jet: &Jet, variables: usize, degree: u32) -> Jet {
        let mut deviation = jet.clone();
        deviation.remove(&vec![0; variables]);
        let mut out = Jet::new();
        for &c in coefficients.iter().rev() {
            out = self.jet_product(&out, &deviation, degree);
            self.accumulate(&mut out, vec![0; variables], c);
        }
        out
    }

    fn jet_power(
        &mut self,
        n: Expr,
        jet: &Jet,
        exponent: Expr,
        variables: usize,
        degree: u32,
    ) -> Result<Jet, EvaluationError> {
        let base = value(self, jet, variables);
        let zero = self.vanishes(base);
        if zero && self.number(exponent).is_some_and(|k| k.sign() == Sign::Negative) {
            return Err(EvaluationError::NoValue { text: self.text(n) });
        }
        if is_constant(jet) {
            return Ok(constant(self.pow(base, exponent), variables));
        }
        let natural = self.integer(exponent).filter(|&k| k >= 0);
        let mut k = match natural {
            // A product of more than `degree` factors that vanish at the point is 0 to this degree.
            Some(k) if zero && k > i64::from(degree) => return Ok(Jet::new()),
            // Repeated squaring needs no value other than 0.
            Some(k) if zero || k <= i64::from(degree) => k,
            None if zero => return Err(EvaluationError::NotSmooth { text: self.text(n) }),
            _ => {
                // t^e = Σ binomial(e, k) base^(e − k) (t − base)^k
                let mut coefficients = Vec::new();
                let (mut factor, mut power) = (self.int(1), exponent);
                for k in 0..=i64::from(degree) {
                    let p = self.pow(base, power);
                    coefficients.push(self.mul(factor, p));
                    let share = self.ratio(1, k + 1);
                    let grown = self.mul(factor, power);
                    factor = self.mul(grown, share);
                    let minus = self.int(-1);
                    power = self.add(power, minus);
                }
                return Ok(self.jet_series(&coefficients, jet, variables, degree));
            }
        };
        let one = self.int(1);
        let mut square = jet.clone();
        let mut out = constant(one, variables);
        while k > 0 {
            if k & 1 == 1 {
                out = self.jet_product(&out, &square, degree);
            }
            k >>= 1;
            if k > 0 {
                square = self.jet_product(&square, &square, degree);
            }
        }
        Ok(out)
    }

    /// True if a constant is zero for certain.
    fn vanishes(&mut self, e: Expr) -> bool {
        self.is_zero(e) || (self.number(e).is_none() && self.zero_test(e, &Bindings::new()).is_zero())
    }

    fn jet_call(&mut self, n: Expr, f: Func, jet: &Jet, variables: usize, degree: u32) -> Result<Jet, EvaluationError> {
        let at = value(self, jet, variables);
        let switches = matches!(f, Func::Abs | Func::Sign);
        if f == Func::Log && self.vanishes(at) {
            return Err(EvaluationError::NoValue { text: self.text(n) });
        }
        if is_constant(jet) {
            return Ok(constant(self.call(f, at), variables));
        }
        if switches && self.vanishes(at) {
            return Err(EvaluationError::NotSmooth { text: self.text(n) });
        }
        // The derivatives of the function itself, at the value of its argument.
        let t = self.symbol("\u{2202}");
        let argument = self.sym(t);
        let mut derivative = self.call(f, argument);
        let mut coefficients = Vec::new();
        let mut factorial = self.int(1);
        for k in 0..=i64::from(degree) {
            // asin and acos end steeply at ±1.
            let v = self.at(derivative, &[(t, at)]).map_err(|_| EvaluationError::NotSmooth { text: self.text(n) })?;
            coefficients.push(self.mul(v, factorial));
            derivative = self.diff(derivative, t);
            let share = self.ratio(1, k + 1);
            factorial = self.mul(factorial, share);
        }
        Ok(self.jet_series(&coefficients, jet, variables, degree))
    }

    fn jet_call2(
        &mut self,
        n: Expr,
        f: Func2,
        (a, b): (&Jet, &Jet),
        variables: usize,
        degree: u32,
    ) -> Result<Jet, EvaluationError> {
        let (x, y) = (value(self, a, variables), value(self, b, variables));
        let minus = self.int(-1);
        let negated = |pool: &mut Self, j: &Jet| pool.jet_product(&constant(minus, variables), j, degree);
        if f == Func2::Atan2 {
            // θ(y, x) = θ₀ + atan((y x₀ − x y₀)/(x x₀ + y y₀)) near (x₀, y₀): the rotation by −θ₀.
            let (y0, x0) = (constant(x, variables), constant(y, variables));
            let minus_y0 = negated(self, &y0);
            let (p, q) = (self.jet_product(a, &x0, degree), self.jet_product(b, &minus_y0, degree));
            let (r, s) = (self.jet_product(b, &x0, degree), self.jet_product(a, &y0, degree));
            let (mut top, mut bottom) = (p, r);
            for (target, other) in [(&mut top, q), (&mut bottom, s)] {
                for (power, c) in other {
                    self.accumulate(target, power, c);
                }
            }
            let inverse = self.jet_power(n, &bottom, minus, variables, degree)?;
            let mut ratio = self.jet_product(&top, &inverse, degree);
            ratio.remove(&vec![0; variables]);
            let mut angle = self.jet_call(n, Func::Atan, &ratio, variables, degree)?;
            let first = self.call2(f, x, y);
            self.accumulate(&mut angle, vec![0; variables], first);
            return Ok(angle);
        }
        // min, max = (a + b ∓ |a − b|)/2
        let mut gap = a.clone();
        for (power, c) in negated(self, b) {
            self.accumulate(&mut gap, power, c);
        }
        let mut size = self.jet_call(n, Func::Abs, &gap, variables, degree)?;
        if f == Func2::Min {
            size = negated(self, &size);
        }
        for jet in [a, b] {
            for (power, &c) in jet {
                self.accumulate(&mut size, power.clone(), c);
            }
        }
        let half = self.ratio(1, 2);
        Ok(self.jet_product(&constant(half, variables), &size, degree))
    }
}

fn constant(e: Expr, variables: usize) -> Jet {
    [(vec![0; variables], e)].into()
}

/// True if no variable takes part.
fn is_constant(jet: &Jet) -> bool {
    jet.keys().all(|power| power.iter().all(|&i| i == 0))
}

/// The value at the point.
fn value(pool: &mut Pool, jet: &Jet, variables: usize) -> Expr {
    jet.get(&vec![0; variables]).copied().unwrap_or_else(|| pool.int(0))
}
