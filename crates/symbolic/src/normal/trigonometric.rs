//! Trigonometric normal form: products of sines and cosines as sums (Fourier form).

use std::collections::BTreeMap;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::{Form, MAX_TERMS, accumulate, normal_form};
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Larger powers of sines and cosines stay as they are.
const MAX_POWER: i64 = 24;

impl Pool {
    /// `e` with the products of sines and cosines written as sums of sines and cosines of multiple angles, over a
    /// common denominator: identities between trigonometric functions of rational multiples of the same angles,
    /// their sums and differences become visible.
    ///
    /// Equal to `e` wherever `e` has a value. What would become very long stays as it is.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let mut form = |t: &str| {
    ///     let e = p.parse(t).unwrap();
    ///     let f = p.trig_form(e);
    ///     p.text(f)
    /// };
    /// assert_eq!(form("m*sin(q)^2 + m*cos(q)^2"), "m");
    /// assert_eq!(form("sin(a)*cos(b) - cos(a)*sin(b)"), "sin(a - b)");
    /// assert_eq!(form("tan(x/2) - sin(x)/(1 + cos(x))"), "0");
    /// assert_eq!(form("cos(x)^3"), "0.75*cos(x) + 0.25*cos(3*x)");
    /// ```
    pub fn trig_form(&mut self, e: Expr) -> Expr {
        normal_form::<Trigonometric>(self, e, MAX_TERMS)
    }
}

pub(super) struct Trigonometric;

/// The functions of Fourier sums.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Wave {
    One,
    Cos(Expr),
    Sin(Expr),
}

/// Σ coefficient · factor · wave
type Fourier = BTreeMap<(Expr, Wave), RBig>;

impl Form for Trigonometric {
    fn function(pool: &mut Pool, e: Expr) -> Expr {
        match pool.node(e) {
            Node::Call(Func::Tan, a) => {
                let (s, c) = (pool.sin(a), pool.cos(a));
                pool.div(s, c)
            }
            _ => e,
        }
    }

    fn concerns(pool: &Pool, base: Expr) -> bool {
        let wave = |&n: &Expr| matches!(pool.node(n), Node::Call(Func::Sin | Func::Cos, _));
        match pool.node(base) {
            Node::Add(..) => pool.reachable(&[base]).iter().any(wave),
            _ => wave(&base),
        }
    }

    fn polynomial(pool: &mut Pool, e: Expr, limit: usize) -> Option<BTreeMap<Expr, RBig>> {
        let mut waves = Waves { known: FxHashMap::default(), limit };
        let mut sum = Fourier::new();
        for t in pool.expanded_terms(e) {
            for (key, c) in waves.term(pool, t)? {
                add(&mut sum, key, &c);
            }
            if sum.len() > limit {
                return None;
            }
        }
        let mut out = BTreeMap::new();
        for ((factor, wave), c) in sum {
            let w = match wave {
                Wave::One => pool.int(1),
                Wave::Cos(a) => pool.cos(a),
                Wave::Sin(a) => pool.sin(a),
            };
            let product = pool.mul(factor, w);
            let product = pool.collected(product);
            accumulate(&mut out, product, &c);
        }
        Some(out)
    }
}

fn add(sum: &mut Fourier, key: (Expr, Wave), c: &RBig) {
    let total = sum.remove(&key).unwrap_or(RBig::ZERO) + c;
    if total != RBig::ZERO {
        sum.insert(key, total);
    }
}

/// Sines and cosines in their Fourier forms.
struct Waves {
    known: FxHashMap<(Func, Expr), Fourier>,
    /// Longest sum.
    limit: usize,
}

impl Waves {
    /// The Fourier form of a product.
    fn term(&mut self, pool: &mut Pool, t: Expr) -> Option<Fourier> {
        let (coefficient, powers) = pool.factored(t);
        let mut factor = pool.int(1);
        let mut product: Option<Fourier> = None;
        for (base, k) in powers {
            let n = i64::try_from(k.numerator()).ok().filter(|n| k.is_int() && (1..=MAX_POWER).contains(n));
            if let (Some(n), Node::Call(f @ (Func::Sin | Func::Cos), a)) = (n, pool.node(base)) {
                let wave = self.wave(pool, f, a);
                for _ in 0..n {
                    product = Some(match product {
                        None => wave.clone(),
                        Some(p) => self.product(pool, &p, &wave)?,
                    });
                }
            } else {
                let k = pool.rational(k);
                let p = pool.pow(base, k);
                factor = pool.mul(factor, p);
            }
        }
        let one = pool.int(1);
        let product = product.unwrap_or_else(|| [((one, Wave::One), RBig::ONE)].into());
        let mut out = Fourier::new();
        for ((f, w), c) in product {
            let f = pool.mul(f, factor);
            let f = pool.collected(f);
            add(&mut out, (f, w), &(c * &coefficient));
        }
        Some(out)
    }

    fn product(&mut self, pool: &mut Pool, p: &Fourier, q: &Fourier) -> Option<Fourier> {
        let mut out = Fourier::new();
        let half = RBig::ONE / RBig::from(2);
        for ((f, v), a) in p {
            for ((g, w), b) in q {
                let c = a * b;
                let factor = pool.mul(*f, *g);
                let factor = pool.collected(factor);
                // cos A cos B = (cos(A − B) + cos(A + B))/2 and so on.
                let (x, y, kind, lower, upper) = match (*v, *w) {
                    (Wave::One, w) | (w, Wave::One) => {
                        add(&mut out, (factor, w), &c);
                        continue;
                    }
                    (Wave::Cos(x), Wave::Cos(y)) => (x, y, Func::Cos, 1, 1),
                    (Wave::Sin(x), Wave::Sin(y)) => (x, y, Func::Cos, 1, -1),
                    (Wave::Sin(x), Wave::Cos(y)) | (Wave::Cos(y), Wave::Sin(x)) => (x, y, Func::Sin, 1, 1),
                };
                let (difference, sum) = (pool.sub(x, y), pool.add(x, y));
                for (angle, sign) in [(difference, lower), (sum, upper)] {
                    for ((f, w), k) in self.wave(pool, kind, angle) {
                        let f = pool.mul(f, factor);
                        let f = pool.collected(f);
                        add(&mut out, (f, w), &(k * &c * &half * RBig::from(sign)));
                    }
                }
                if out.len() > self.limit {
                    return None;
                }
            }
        }
        Some(out)
    }

    /// sin or cos of an angle, with multiples of π/6 and π/4 taken out.
    fn wave(&mut self, pool: &mut Pool, f: Func, angle: Expr) -> Fourier {
        if let Some(known) = self.known.get(&(f, angle)) {
            return known.clone();
        }
        let made = Self::new_wave(pool, f, angle);
        self.known.insert((f, angle), made.clone());
        made
    }

    fn new_wave(pool: &mut Pool, f: Func, angle: Expr) -> Fourier {
        let one = pool.int(1);
        let (mut twelfths, mut rest) = (RBig::ZERO, Vec::new());
        for t in pool.expanded_terms(angle) {
            let (c, x) = pool.coefficient(t);
            if pool.node(x) == Node::Pi { twelfths += c * RBig::from(12) } else { rest.push(t) }
        }
        // cos(r + φ) = cos r cos φ − sin r sin φ, for the φ whose cosine and sine are roots of rationals.
        let known =
            i64::try_from(twelfths.numerator()).ok().filter(|k| twelfths.is_int() && (k % 2 == 0 || k % 3 == 0));
        let Some(k) = known else { return single(pool, f, angle) };
        let (c, s) = (special(k), special(k - 6));
        if rest.is_empty() {
            let (v, n) = if f == Func::Cos { c } else { s };
            let root = root(pool, n);
            let mut out = Fourier::new();
            add(&mut out, (root, Wave::One), &v);
            return out;
        }
        let rest = pool.sum(rest);
        let parts = if f == Func::Cos {
            [(Func::Cos, c.0, c.1), (Func::Sin, -s.0, s.1)]
        } else {
            [(Func::Sin, c.0, c.1), (Func::Cos, s.0, s.1)]
        };
        let mut out = Fourier::new();
        for (g, v, n) in parts {
            let root = if n == 1 { one } else { root(pool, n) };
            for ((_, w), c) in single(pool, g, rest) {
                add(&mut out, (root, w), &(c * &v));
            }
        }
        out
    }
}

/// sin or cos of an angle as a wave; the sign of the angle is that of the canonical form.
fn single(pool: &mut Pool, f: Func, angle: Expr) -> Fourier {
    let angle = pool.expand(angle);
    let value = pool.call(f, angle);
    let value = pool.collected(value);
    let (c, e) = pool.coefficient(value);
    let one = pool.int(1);
    let mut out = Fourier::new();
    match pool.node(e) {
        Node::Call(Func::Cos, a) => add(&mut out, (one, Wave::Cos(a)), &c),
        Node::Call(Func::Sin, a) => add(&mut out, (one, Wave::Sin(a)), &c),
        _ => add(&mut out, (e, Wave::One), &c),
    }
    out
}

/// cos(kπ/12) = c √n, for k a multiple of 2 or 3.
fn special(k: i64) -> (RBig, u64) {
    let k = k.rem_euclid(24);
    let k = if k > 12 { 24 - k } else { k };
    let (k, sign) = if k > 6 { (12 - k, -1) } else { (k, 1) };
    let half = RBig::from(sign) / RBig::from(2);
    match k {
        0 => (RBig::from(sign), 1),
        2 => (half, 3),
        3 => (half, 2),
        4 => (half, 1),
        _ => (RBig::ZERO, 1),
    }
}

fn root(pool: &mut Pool, n: u64) -> Expr {
    let n = pool.rational(RBig::from(n));
    if pool.is_one(n) { n } else { pool.sqrt(n) }
}
