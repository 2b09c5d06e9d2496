//! Rational values for states and for the functions of them, at which a matrix becomes one of parameters alone.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, SplitMix64, Symbol};
use rustc_hash::FxHashMap;

/// Draws values that keep all algebraic relations between states, sines, cosines, and exponentials of linear
/// combinations of them. States, their sines, and their exponentials are algebraically independent, so that what
/// vanishes for all states vanishes at these values.
pub(crate) struct StateValues {
    states: Vec<Symbol>,
    kernels: Vec<Kernel>,
    /// Common denominator of the coefficients in arguments.
    unit: i64,
}

struct Kernel {
    node: Expr,
    function: Func,
    /// Multiples of state / unit.
    multiples: Vec<i64>,
}

/// Larger multiples take too long numbers.
const MAX_MULTIPLE: i64 = 12;

/// A function that is not covered.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Uncovered(pub(crate) Expr);

impl StateValues {
    /// For expressions in the states; other symbols are left as they are.
    ///
    /// # Errors
    /// [`Uncovered`] for a function of states that has no rational values.
    pub(crate) fn new(pool: &mut Pool, states: &[Symbol], roots: &[Expr]) -> Result<Self, Uncovered> {
        let mut arguments = Vec::new();
        for e in pool.reachable(roots) {
            let inside = match pool.node(e) {
                Node::Call(_, a) => a,
                Node::Call2(..) => e,
                Node::Pow(_, k) if pool.integer(k).is_none() => e,
                _ => continue,
            };
            if !states.iter().any(|&s| pool.depends_on(inside, s)) {
                continue;
            }
            let Node::Call(function, a) = pool.node(e) else { return Err(Uncovered(e)) };
            if !matches!(function, Func::Sin | Func::Cos | Func::Tan | Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh)
            {
                return Err(Uncovered(e));
            }
            let Some(slopes) = linear(pool, a, states) else { return Err(Uncovered(e)) };
            arguments.push((e, function, slopes));
        }
        let mut unit = 1_i64;
        for c in arguments.iter().flat_map(|a| &a.2) {
            let d = i64::try_from(c.denominator().clone()).ok().filter(|d| *d <= MAX_MULTIPLE);
            let Some(d) = d else { return Err(Uncovered(arguments[0].0)) };
            unit = lcm(unit, d);
        }
        let mut kernels = Vec::new();
        for (node, function, slopes) in arguments {
            let multiple = |c: &Rational| {
                let scaled = c * Rational::from(unit);
                i64::try_from(scaled.numerator().clone()).ok().filter(|k| k.abs() <= MAX_MULTIPLE)
            };
            let Some(multiples) = slopes.iter().map(multiple).collect::<Option<Vec<i64>>>() else {
                return Err(Uncovered(node));
            };
            kernels.push(Kernel { node, function, multiples });
        }
        Ok(StateValues { states: states.to_vec(), kernels, unit })
    }

    /// Numbers in place of states and functions of them; `seed` selects them.
    pub(crate) fn draw(&self, pool: &mut Pool, seed: u64) -> FxHashMap<Expr, Expr> {
        let mut random = SplitMix64::new(seed);
        let mut map = FxHashMap::default();
        let mut circles = Vec::new();
        let mut powers = Vec::new();
        for &s in &self.states {
            let x = pool.sym(s);
            let value = random.integer(3, 40);
            map.insert(x, pool.int(value));
            // cos = (1 − t²)/(1 + t²), sin = 2t/(1 + t²)
            let t = Rational::from(random.integer(2, 9)) / Rational::from(random.integer(10, 14));
            let bottom = Rational::ONE + &t * &t;
            circles.push(((Rational::ONE - &t * &t) / &bottom, (&t + &t) / &bottom));
            powers.push(Rational::from(random.integer(2, 9)));
        }
        debug_assert!(self.unit > 0);
        for k in &self.kernels {
            let value = match k.function {
                Func::Sin | Func::Cos | Func::Tan => {
                    let (mut c, mut s) = (Rational::ONE, Rational::ZERO);
                    for ((x, y), &n) in circles.iter().zip(&k.multiples) {
                        for _ in 0..n.abs() {
                            let y = if n > 0 { y.clone() } else { -y.clone() };
                            (c, s) = (&c * x - &s * &y, &s * x + &c * &y);
                        }
                    }
                    match k.function {
                        Func::Sin => s,
                        Func::Cos => c,
                        _ => s / c,
                    }
                }
                _ => {
                    let mut e = Rational::ONE;
                    for (x, &n) in powers.iter().zip(&k.multiples) {
                        for _ in 0..n.abs() {
                            e = if n > 0 { e * x } else { e / x };
                        }
                    }
                    let inverse = Rational::ONE / &e;
                    let two = Rational::from(2);
                    match k.function {
                        Func::Sinh => (e - inverse) / two,
                        Func::Cosh => (e + inverse) / two,
                        Func::Tanh => (&e - &inverse) / (&e + &inverse),
                        _ => e,
                    }
                }
            };
            map.insert(k.node, pool.rational(value));
        }
        map
    }
}

/// Coefficients of a linear form in the states with rational numbers and no constant part.
fn linear(pool: &mut Pool, e: Expr, states: &[Symbol]) -> Option<Vec<Rational>> {
    let mut slopes = Vec::new();
    let mut rest = e;
    for &s in states {
        let d = pool.diff(e, s);
        let d = pool.simplify(d);
        let c = pool.number(d)?.clone();
        let (x, c2) = (pool.sym(s), pool.rational(c.clone()));
        let term = pool.mul(c2, x);
        rest = pool.sub(rest, term);
        slopes.push(c);
    }
    let rest = pool.simplify(rest);
    pool.is_zero(rest).then_some(slopes)
}

fn lcm(a: i64, b: i64) -> i64 {
    let (mut x, mut y) = (a, b);
    while y != 0 {
        (x, y) = (y, x % y);
    }
    a / x * b
}
