//! Sines and cosines: points on the unit circle over the field, one generator per base angle.

use super::combinations::Kernels;
use super::field::{Residue, THIRD_OFFSET, gcd};
use super::kernels::{Angle, AngleKind};
use super::lowering::{Lowering, Stop};
use super::program::{Generator, Point, Reg, Step, turned};
use crate::node::{Expr, Node};

/// Larger multiples of a base angle are refused.
pub(super) const MAX_MULTIPLE: u64 = 1 << 32;
/// Most terms of a sum among which a new indeterminate is sought.
const MAX_TERMS: usize = 32;

impl<const C: u64> Lowering<'_, C> {
    /// Registers of the cosine and sine of `arg`.
    pub(super) fn angle(&mut self, arg: Expr) -> Result<(Reg, Reg), Stop> {
        if let Some(&p) = self.circle.points.get(&arg) {
            return Ok(p);
        }
        let value = self.registers[&arg];
        let relation = if self.has_new_symbol(arg) {
            None
        } else {
            let mut basis = vec![self.pi()];
            basis.extend(self.circle.basis.iter().map(|a| a.value));
            self.relation(arg, Kernels::Angles, &basis, value)?
        };
        let point = match relation {
            None => {
                let parts = self.requirements.angles.get(&self.circle.basis.len()).copied().unwrap_or(1);
                let slot = self.generator(Generator::Circle);
                let base = (self.push(Step::Slot(slot)), self.push(Step::Slot(slot + 1)));
                self.circle.basis.push(Angle { value, kind: AngleKind::Free(base), parts });
                self.circle.symbols.extend(self.pool.symbols_of(&[arg]));
                self.multiple(base, parts as i64)
            }
            Some(coefficients) => self.combined(arg, &coefficients)?,
        };
        self.circle.points.insert(arg, point);
        Ok(point)
    }

    /// A sum with an indeterminate, or a multiple of one, that neither its other terms nor the angles so far depend on is no
    /// combination of them; seeing that saves the elimination.
    fn has_new_symbol(&self, arg: Expr) -> bool {
        let mut terms = vec![arg];
        let mut open = 0;
        while open < terms.len() && terms.len() <= MAX_TERMS {
            match self.pool.node(terms[open]) {
                Node::Add(a, b) => {
                    terms[open] = a;
                    terms.push(b);
                }
                _ => open += 1,
            }
        }
        let indeterminate = |e: Expr| match self.pool.node(e) {
            Node::Sym(s) => (!self.exact.contains_key(&e) && !self.circle.symbols.contains(&s)).then_some(s),
            _ => None,
        };
        let new = |t: Expr| match self.pool.node(t) {
            Node::Mul(a, b) if self.pool.number(a).is_some() => indeterminate(b),
            Node::Mul(a, b) if self.pool.number(b).is_some() => indeterminate(a),
            _ => indeterminate(t),
        };
        (0..terms.len()).any(|k| {
            new(terms[k]).is_some_and(|s| (0..terms.len()).all(|l| l == k || !self.pool.depends_on(terms[l], s)))
        })
    }

    /// cos and sin of a rational combination of π and the base angles.
    fn combined(&mut self, arg: Expr, coefficients: &[(i64, i64)]) -> Result<(Reg, Reg), Stop> {
        let mut restart = false;
        for (j, &(n, d)) in coefficients[1..].iter().enumerate().filter(|(_, c)| c.0 != 0) {
            let Angle { kind, parts, .. } = self.circle.basis[j];
            if matches!(kind, AngleKind::Inverse) {
                return Err(self.kernel(arg, "it is a function of its inverse"));
            }
            let d = d.unsigned_abs();
            if !parts.is_multiple_of(d) {
                let finer = parts / gcd(parts, d) * d;
                if finer > MAX_MULTIPLE || n.unsigned_abs() > MAX_MULTIPLE {
                    return Err(self.kernel(arg, "its argument is too fine a multiple of others"));
                }
                if matches!(kind, AngleKind::OfPoint(_)) && finer.is_multiple_of(2) {
                    return Err(self.kernel(arg, "it is a function of half of an inverse"));
                }
                self.requirements.angles.insert(j, finer);
                restart = true;
            }
        }
        if restart {
            return Err(Stop::Restart);
        }
        let (c, s) = self.part_of_pi(arg, coefficients[0])?;
        let mut point = (self.constant(c), self.constant(s));
        let mut trivial = s.is_zero() && c == Residue::ONE;
        for (j, &(n, d)) in coefficients[1..].iter().enumerate().filter(|(_, c)| c.0 != 0) {
            let a = &self.circle.basis[j];
            let (AngleKind::Free(base) | AngleKind::OfPoint(base)) = a.kind else { continue };
            let multiple = n.unsigned_abs().saturating_mul(a.parts / d.unsigned_abs());
            if multiple > MAX_MULTIPLE {
                return Err(self.kernel(arg, "its argument is too large a multiple of others"));
            }
            let p = self.multiple(base, multiple as i64 * n.signum());
            point = if trivial { p } else { self.rotated(point, p) };
            trivial = false;
        }
        Ok(point)
    }

    /// Point of the sum of two angles.
    fn rotated(&mut self, p: (Reg, Reg), q: (Reg, Reg)) -> (Reg, Reg) {
        let cc = self.push(Step::Mul(p.0, q.0));
        let ss = self.push(Step::Mul(p.1, q.1));
        let minus = self.scaled(-Residue::ONE, ss);
        let sc = self.push(Step::Mul(p.1, q.0));
        let cs = self.push(Step::Mul(p.0, q.1));
        (self.push(Step::Add(cc, minus)), self.push(Step::Add(sc, cs)))
    }

    /// Point of n times an angle.
    fn multiple(&mut self, p: (Reg, Reg), n: i64) -> (Reg, Reg) {
        let mut base = if n < 0 { (p.0, self.scaled(-Residue::ONE, p.1)) } else { p };
        let mut k = n.unsigned_abs();
        let mut result = None;
        while k > 0 {
            if k & 1 == 1 {
                result = Some(result.map_or(base, |r| self.rotated(r, base)));
            }
            k >>= 1;
            if k > 0 {
                base = self.rotated(base, base);
            }
        }
        result.unwrap_or_else(|| (self.constant(Residue::ONE), self.constant(Residue::ZERO)))
    }

    /// cos and sin of n/d·π.
    fn part_of_pi(&mut self, arg: Expr, (n, d): (i64, i64)) -> Result<(Residue<C>, Residue<C>), Stop> {
        let unknown =
            |l: &Self| l.other_prime(arg, "only multiples of pi/1800 and pi/4320 have known sines and cosines");
        let parts = parts_of_pi::<C>();
        if !parts.is_multiple_of(d.unsigned_abs()) {
            return Err(unknown(self));
        }
        let Some(unit) = unit_angle::<C>() else {
            return Err(unknown(self));
        };
        let multiple = (i128::from(n) * i128::from(parts / d.unsigned_abs())).rem_euclid(2 * i128::from(parts));
        Ok(turned(unit, multiple as u64))
    }
}

/// The D for which the field holds cos(π/D) and sin(π/D); 2D divides p + 1, the order of the circle.
fn parts_of_pi<const C: u64>() -> u64 {
    match C {
        1 => 1024,
        THIRD_OFFSET => 4320,
        _ => 1800,
    }
}

/// (cos, sin) of π/D: a point of order 2D, of all conjugate ones one for which the roots of 2, 3 and 5 that follow
/// from it are those that [`Residue::sqrt`] gives.
fn unit_angle<const C: u64>() -> Option<Point<C>> {
    let parts = parts_of_pi::<C>();
    let order = 2 * parts;
    let one: Residue<C> = Residue::ONE;
    let primes: Vec<u64> = [2, 3, 5].into_iter().filter(|q| order.is_multiple_of(*q)).collect();
    let first = (2..100).find_map(|t| {
        let t = Residue::<C>::new(t);
        let d = (one + t * t).inv()?;
        let p = turned(((one - t * t) * d, (t + t) * d), Residue::<C>::MODULUS.div_ceil(order));
        primes.iter().all(|q| turned(p, order / q) != (one, Residue::ZERO)).then_some(p)
    })?;
    let root = |n: u64| Residue::<C>::new(n).sqrt();
    (1..order).filter(|k| gcd(*k, order) == 1).map(|k| turned(first, k)).find(|&p| {
        let part = |d: u64| turned(p, parts / d);
        part(2) == (Residue::ZERO, one)
            && Some(part(4).0 + part(4).0) == root(2)
            && primes.iter().all(|q| match q {
                3 => Some(part(6).0 + part(6).0) == root(3),
                5 => Some(Residue::new(4) * part(5).0 - one) == root(5),
                _ => true,
            })
    })
}
