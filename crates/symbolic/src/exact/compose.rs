//! Functions of their inverses, roots of squares, and known values, rewritten into what the field represents.
//!
//! Each rule holds at all real points at which the left-hand side has a value.

use dashu_int::UBig;
use dashu_ratio::RBig;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;

/// Angles are taken up to this multiple.
const MAX_MULTIPLE: i64 = 16;
/// And down to this power of one half.
const MAX_HALVINGS: usize = 6;

/// Inverse functions of which parts are needed that are no powers of one half, such as 13/10 θ.
#[derive(Default)]
struct Parts {
    /// How often θ must be halved.
    halvings: FxHashMap<Expr, usize>,
    /// The halved angles, as angles of points of the unit circle.
    points: FxHashMap<Expr, (Expr, Expr)>,
}

impl Pool {
    /// `roots` with sines of inverse functions, roots of squares, nested roots of constants and known angles replaced.
    pub(super) fn composed(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let mut parts = Parts::default();
        let mut composed = self.composed_with(roots, &mut parts);
        if !parts.halvings.is_empty() {
            // Every θ of which parts are needed becomes a multiple of its finest half.
            composed = self.composed_with(roots, &mut parts);
        }
        self.with_arctangents(&composed)
    }

    fn composed_with(&mut self, roots: &[Expr], parts: &mut Parts) -> Vec<Expr> {
        let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
        for n in self.reachable(roots) {
            let made = self.rebuild(n, |x| image[&x]);
            let r = match self.node(made) {
                Node::Call(f @ (Func::Sin | Func::Cos | Func::Tan), a) => self.function_of_inverse(f, a, parts),
                Node::Call(f @ (Func::Asin | Func::Acos | Func::Atan), a) => {
                    self.known_angle(f, a).or_else(|| self.halved(made, parts))
                }
                Node::Call2(Func2::Atan2, ..) => self.halved(made, parts),
                Node::Pow(b, k) => self.root_of_powers(b, k),
                _ => None,
            };
            image.insert(n, r.unwrap_or(made));
        }
        roots.iter().map(|r| image[r]).collect()
    }

    /// The terms of a sum with rational coefficients; arguments of functions stay as they are.
    fn linear_terms(&mut self, e: Expr) -> Vec<(RBig, Expr)> {
        let (mut open, mut terms) = (vec![(RBig::ONE, e)], Vec::new());
        while let Some((c, e)) = open.pop() {
            let (factor, x) = self.coefficient(e);
            let c = c * factor;
            match self.node(x) {
                Node::Add(a, b) => open.extend([(c.clone(), b), (c, a)]),
                _ => terms.push((c, x)),
            }
        }
        terms
    }

    /// θ as a multiple of the angle of a point.
    fn halved(&mut self, theta: Expr, parts: &mut Parts) -> Option<Expr> {
        let halvings = *parts.halvings.get(&theta)?;
        let mut point = self.point_of_inverse(theta)?;
        for _ in 0..halvings {
            point = self.half_of_angle(point);
        }
        let angle = self.call2(Func2::Atan2, point.1, point.0);
        parts.points.insert(angle, point);
        let k = self.int(1 << halvings);
        Some(self.mul(k, angle))
    }

    /// `roots` with asin and acos replaced by arctangents, of which several are told apart, if there are other angles.
    fn with_arctangents(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let nodes = self.reachable(roots);
        let (mut angles, mut replaced) = (FxHashSet::default(), false);
        for &n in &nodes {
            match self.node(n) {
                Node::Call(Func::Asin | Func::Acos, a) => {
                    angles.insert(a);
                    replaced = true;
                }
                Node::Call(Func::Sin | Func::Cos | Func::Tan, a) => drop(angles.insert(a)),
                Node::Call(Func::Atan, _) | Node::Call2(Func2::Atan2, ..) => drop(angles.insert(n)),
                _ => {}
            }
        }
        if !replaced || angles.len() < 2 {
            return roots.to_vec();
        }
        let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
        for n in nodes {
            let made = self.rebuild(n, |x| image[&x]);
            let r = match self.node(made) {
                Node::Call(f @ (Func::Asin | Func::Acos), a) => self.as_arctangent(f, a),
                _ => made,
            };
            image.insert(n, r);
        }
        roots.iter().map(|r| image[r]).collect()
    }

    /// sin, cos or tan of a sum in which inverse functions have rational coefficients.
    fn function_of_inverse(&mut self, f: Func, a: Expr, parts: &mut Parts) -> Option<Expr> {
        let (mut rest, mut angles) = (Vec::new(), Vec::new());
        for (c, x) in self.linear_terms(a) {
            let inverse = matches!(
                self.node(x),
                Node::Call(Func::Asin | Func::Acos | Func::Atan, _) | Node::Call2(Func2::Atan2, ..)
            );
            if inverse {
                angles.push((c, x));
            } else {
                let c = self.rational(c);
                rest.push(self.mul(c, x));
            }
        }
        if angles.is_empty() {
            return None;
        }
        let rest = self.sum(rest);
        let mut point = (self.cos(rest), self.sin(rest));
        for (c, x) in angles {
            let p = self.part_of_angle(x, &c, parts)?;
            point = self.rotated_point(point, p);
        }
        Some(match f {
            Func::Cos => point.0,
            Func::Sin => point.1,
            _ => self.div(point.1, point.0),
        })
    }

    /// (cos θ, sin θ) of an inverse function θ, which lies between −π and π.
    fn point_of_inverse(&mut self, theta: Expr) -> Option<(Expr, Expr)> {
        let one = self.int(1);
        let minus_half = self.ratio(-1, 2);
        Some(match self.node(theta) {
            Node::Call(Func::Atan, u) => {
                let q = self.powi(u, 2);
                let s = self.add(one, q);
                let c = self.pow(s, minus_half);
                (c, self.mul(u, c))
            }
            Node::Call(f @ (Func::Asin | Func::Acos), u) => {
                let q = self.powi(u, 2);
                let d = self.sub(one, q);
                let r = self.sqrt(d);
                if f == Func::Asin { (r, u) } else { (u, r) }
            }
            Node::Call2(Func2::Atan2, y, x) => {
                let (p, q) = (self.powi(x, 2), self.powi(y, 2));
                let s = self.add(p, q);
                let i = self.pow(s, minus_half);
                (self.mul(x, i), self.mul(y, i))
            }
            _ => return None,
        })
    }

    /// (cos cθ, sin cθ) for a rational c, where −π ≤ θ ≤ π; parts of the circle of odd order are left to the field.
    fn part_of_angle(&mut self, theta: Expr, c: &RBig, parts: &mut Parts) -> Option<(Expr, Expr)> {
        let halvings = c.denominator().trailing_zeros().unwrap_or(0);
        if halvings > MAX_HALVINGS {
            return None;
        }
        if c.denominator().clone() >> halvings != UBig::ONE {
            if !parts.points.contains_key(&theta) {
                let known = parts.halvings.entry(theta).or_default();
                *known = halvings.max(*known);
                return None;
            }
            let c = self.rational(c.clone());
            let angle = self.mul(c, theta);
            return (halvings == 0).then(|| (self.cos(angle), self.sin(angle)));
        }
        let mut p = match parts.points.get(&theta) {
            Some(&point) => point,
            None => self.point_of_inverse(theta)?,
        };
        for _ in 0..halvings {
            p = self.half_of_angle(p);
        }
        let n = i64::try_from(c.numerator()).ok().filter(|n| n.abs() <= MAX_MULTIPLE)?;
        let step = if n < 0 { (p.0, self.neg(p.1)) } else { p };
        let mut point = (self.int(1), self.int(0));
        for _ in 0..n.abs() {
            point = self.rotated_point(point, step);
        }
        Some(point)
    }

    /// (cos θ/2, sin θ/2): |θ/2| ≤ π/2, so the cosine is √((1 + cos θ)/2), and sin θ = 2 sin(θ/2) cos(θ/2).
    fn half_of_angle(&mut self, p: (Expr, Expr)) -> (Expr, Expr) {
        let (one, half) = (self.int(1), self.ratio(1, 2));
        let s = self.add(one, p.0);
        let h = self.mul(half, s);
        let c = self.sqrt(h);
        let q = self.div(p.1, c);
        (c, self.mul(half, q))
    }

    fn rotated_point(&mut self, p: (Expr, Expr), q: (Expr, Expr)) -> (Expr, Expr) {
        let (cc, ss) = (self.mul(p.0, q.0), self.mul(p.1, q.1));
        let (sc, cs) = (self.mul(p.1, q.0), self.mul(p.0, q.1));
        (self.sub(cc, ss), self.add(sc, cs))
    }

    /// asin f = atan(f/√(1 − f²)) and acos f = π/2 − asin f.
    fn as_arctangent(&mut self, f: Func, a: Expr) -> Expr {
        let (one, square) = (self.int(1), self.powi(a, 2));
        let rest = self.sub(one, square);
        let root = self.sqrt(rest);
        let tangent = self.div(a, root);
        let angle = self.call(Func::Atan, tangent);
        if f == Func::Asin {
            return angle;
        }
        let (half, pi) = (self.ratio(1, 2), self.pi());
        let quarter = self.mul(half, pi);
        self.sub(quarter, angle)
    }

    /// asin, acos, atan where the value is a multiple of π/12.
    fn known_angle(&mut self, f: Func, a: Expr) -> Option<Expr> {
        let inner = if f == Func::Acos { Func::Asin } else { f };
        let k = self.twelfths_of_pi(inner, a)?;
        let k = if f == Func::Acos { 6 - k } else { k };
        let (c, pi) = (self.ratio(k, 12), self.pi());
        Some(self.mul(c, pi))
    }

    /// b^k for a k with even denominator: √(u²) = |u|, √exp(u) = exp(u/2), √(3 + 2√2) = 1 + √2.
    fn root_of_powers(&mut self, b: Expr, k: Expr) -> Option<Expr> {
        let exponent = self.number(k)?.clone();
        let denominator = i64::try_from(exponent.denominator()).ok()?;
        if denominator % 2 != 0 {
            return None;
        }
        if denominator == 2
            && self.symbols_of(&[b]).is_empty()
            && self.number(b).is_none()
            && let Some(root) = self.denested_root(b)
        {
            return Some(self.powi(root, i64::try_from(exponent.numerator()).ok()?));
        }
        let (coefficient, powers) = self.factored(b);
        let (mut inside, mut outside) = (self.rational(coefficient), Vec::new());
        for (base, n) in powers {
            let even = n.is_int() && (n.clone() / RBig::from(2)).is_int();
            match self.node(base) {
                Node::Call(Func::Exp, u) => {
                    let c = self.rational(n * &exponent);
                    let v = self.mul(c, u);
                    outside.push(self.call(Func::Exp, v));
                }
                _ if even => {
                    let (size, c) = (self.call(Func::Abs, base), self.rational(n * &exponent));
                    outside.push(self.pow(size, c));
                }
                _ => {
                    let n = self.rational(n);
                    let f = self.pow(base, n);
                    inside = self.mul(inside, f);
                }
            }
        }
        if outside.is_empty() {
            return None;
        }
        let mut product = self.pow(inside, k);
        for f in outside {
            product = self.mul(product, f);
        }
        Some(product)
    }
}
