//! asin, acos, atan, atan2: angles whose points on the unit circle are known.
//!
//! e^(2iθ) is a function z of what the field holds, such as (1 + i f)/(1 − i f) for θ = atan f. By the structure theorem for
//! elementary extensions (Risch 1979, Rosenlicht 1976) such angles are algebraically independent unless a product of powers of
//! their z and of the e^(ib) of the sines and cosines is constant, that is, unless Σ c_j dθ_j = 0 with rational c_j. Since all
//! functions are real and every z has modulus 1, exponentials and logarithms of real functions do not enter.

use dashu_ratio::RBig;

use super::constants::{exact_root, factors};
use super::echelon::Echelon;
use super::field::Residue;
use super::gaussian::GaussianAngle;
use super::kernels::{Angle, AngleKind};
use super::linear_relation::SPARE;
use super::lower::inverse_modulo;
use super::lowering::{FRACTION_BOUND, Lowering, Stop};
use super::program::{Generator, Reg, Step};
use crate::func::{Func, Func2};
use crate::node::{Expr, Node};

impl<const C: u64> Lowering<'_, C> {
    /// Register of an inverse function: a generator, or a combination of such.
    pub(super) fn inverse_angle(&mut self, e: Expr) -> Result<Reg, Stop> {
        let (kind, operands) = match self.pool.node(e) {
            Node::Call(Func::Acos, a) => (Func::Asin, vec![a]),
            Node::Call(f, a) => (f, vec![a]),
            Node::Call2(Func2::Atan2, a, b) => (Func::Atan, vec![a, b]),
            _ => return Err(self.kernel(e, "which operand it takes depends on the point")),
        };
        let value = match self.known_inverse(kind, &operands) {
            Some((value, false)) => value,
            Some((value, true)) => self.scaled(-Residue::ONE, value),
            None if self.is_constant_angle(&operands) => self.constant_angle(e, kind, &operands)?,
            None => self.new_inverse(e, kind, operands)?,
        };
        if matches!(self.pool.node(e), Node::Call(Func::Acos, _)) {
            // acos = π/2 − asin
            let pi = self.pi();
            let quarter = self.scaled(Residue::new(2).inv().unwrap_or_default(), pi);
            let minus = self.scaled(-Residue::ONE, value);
            return Ok(self.push(Step::Add(quarter, minus)));
        }
        Ok(value)
    }

    /// Register of an angle whose operands have the same values, and whether the first has the opposite one.
    fn known_inverse(&self, kind: Func, operands: &[Expr]) -> Option<(Reg, bool)> {
        let same = |a: Expr, b: Expr, sign: Residue<C>| {
            let (a, b) = (self.registers[&a], self.registers[&b]);
            let at = self.trials(&[a, b], SPARE);
            a == b && sign == Residue::ONE
                || at.len() == SPARE && at.iter().all(|&i| self.trial(a, i) == self.trial(b, i).map(|v| sign * v))
        };
        self.circle.inverses.iter().filter(|(f, known, _)| *f == kind && known.len() == operands.len()).find_map(
            |(_, known, value)| {
                let others = known[1..].iter().zip(&operands[1..]).all(|(&a, &b)| same(a, b, Residue::ONE));
                let with = |sign| others && same(known[0], operands[0], sign);
                if with(Residue::ONE) { Some((*value, false)) } else { with(-Residue::ONE).then_some((*value, true)) }
            },
        )
    }

    fn new_inverse(&mut self, e: Expr, kind: Func, operands: Vec<Expr>) -> Result<Reg, Stop> {
        let slot = self.generator(Generator::Free);
        let value = self.push(Step::Slot(slot));
        let kind_of_angle = self.point_of(&operands, self.circle.basis.len())?;
        let (symbols, others) = (self.pool.symbols_of(&operands), !self.circle.basis.is_empty());
        self.circle.inverses.push((kind, operands, value));
        if others && !self.is_independent_angle(e, value)? {
            return Err(self.kernel(e, "it may be related to other angles and trigonometric functions"));
        }
        let (kind, parts) = kind_of_angle;
        self.circle.basis.push(Angle { value, kind, parts });
        self.circle.symbols.extend(symbols);
        Ok(value)
    }

    /// Cosine and sine of the part of the angle that earlier attempts asked for, if the operands of atan2 are a point of the
    /// unit circle.
    fn point_of(&mut self, operands: &[Expr], number: usize) -> Result<(AngleKind, u64), Stop> {
        let &[y, x] = operands else { return Ok((AngleKind::Inverse, 1)) };
        let (ry, rx) = (self.registers[&y], self.registers[&x]);
        let at = self.trials(&[rx, ry], SPARE);
        let on_circle = |&i: &usize| {
            let (a, b) = (self.trial(rx, i).unwrap_or_default(), self.trial(ry, i).unwrap_or_default());
            a * a + b * b == Residue::ONE
        };
        if at.is_empty() || !at.iter().all(on_circle) {
            return Ok((AngleKind::Inverse, 1));
        }
        let parts = self.requirements.angles.get(&number).copied().unwrap_or(1);
        if parts == 1 {
            return Ok((AngleKind::OfPoint((rx, ry)), 1));
        }
        // In the circle of p + 1 points, one point has a given multiple if the factor is prime to p + 1.
        let Some(turn) = inverse_modulo(parts, Residue::<C>::MODULUS + 1) else {
            return Err(self.other_prime(y, "the field has no unique part of this angle"));
        };
        self.roots.extension = self.roots.extension.max(1.0) * parts as f64;
        let mut part = |sine| self.push(Step::Turn { x: rx, y: ry, turn, sine });
        Ok((AngleKind::OfPoint((part(false), part(true))), parts))
    }

    /// Whether the derivative of the angle is no linear combination, with constant coefficients, of those of the angles so far;
    /// errors name `e`.
    fn is_independent_angle(&mut self, e: Expr, value: Reg) -> Result<bool, Stop> {
        let mut angles: Vec<Reg> = self.circle.basis.iter().map(|a| a.value).collect();
        angles.push(value);
        let needed = angles.len() + SPARE;
        let rows = self.derivatives(&angles, needed);
        if rows.len() < needed {
            return Err(self.few_trials(
                e,
                2 * needed,
                "it may be related to other angles and trigonometric functions",
            ));
        }
        let column = |j: usize| -> Vec<Residue<C>> { rows.iter().map(|r| r[j]).collect() };
        let mut span = Echelon::empty(needed);
        let last = angles.len() - 1;
        for j in 0..last {
            span.insert(column(j));
        }
        Ok(span.insert(column(last)))
    }

    /// True if the operand, or the ratio of two operands, has the same value at all trial points.
    fn is_constant_angle(&self, operands: &[Expr]) -> bool {
        let registers: Vec<Reg> = operands.iter().map(|o| self.registers[o]).collect();
        let mut ratios = self.trials(&registers, SPARE).into_iter().map(|i| {
            let v = registers.iter().map(|&r| self.trial(r, i).unwrap_or_default());
            v.reduce(|y, x| y * x.inv().unwrap_or_default())
        });
        let first = ratios.next();
        ratios.all(|r| Some(r) == first)
    }

    /// A constant angle: of a rational point, or one whose e^(2iθ) lies in an imaginary quadratic field.
    fn constant_angle(&mut self, e: Expr, kind: Func, operands: &[Expr]) -> Result<Reg, Stop> {
        let unknown = |l: &Self| l.kernel(e, "it is a constant angle of unknown relation to pi");
        let one = RBig::ONE;
        let exact: Option<Vec<RBig>> = operands.iter().map(|o| self.exact.get(o).cloned()).collect();
        let half = RBig::ONE / RBig::from(2);
        let point = match (kind, exact.as_deref()) {
            (Func::Atan, Some([y])) => Some((one, y.clone())),
            (Func::Atan, Some([y, x])) => Some((x.clone(), y.clone())),
            (Func::Asin, Some([y])) => exact_root(&(RBig::ONE - y * y), &half).map(|x| (x, y.clone())),
            _ => None,
        };
        if let Some((x, y)) = point {
            let angle = GaussianAngle::of(&x, &y, &mut self.found).ok_or_else(|| unknown(self))?;
            return Ok(self.gaussian(&angle));
        }
        // tan² θ = q: e^(2iθ) = (1 − q + 2i√q)/(1 + q).
        let square = self.square_of_tangent(kind, operands).ok_or_else(|| unknown(self))?;
        let field = factors(&square, &mut self.found).ok_or_else(|| unknown(self))?;
        let field: Vec<u64> = field.into_iter().filter(|(_, k)| k % 2 != 0).map(|(n, _)| n).collect();
        let three = RBig::from(3);
        // Roots of unity, and a second angle of the same field, have relations; numbers of different fields have none, as is
        // seen from the automorphisms of the field that they generate.
        if field.is_empty() || square == three || square == RBig::ONE / three || !self.circle.fields.insert(field) {
            return Err(unknown(self));
        }
        let value = self.constant_generator();
        self.circle.inverses.push((kind, operands.to_vec(), value));
        Ok(value)
    }

    /// tan² of a constant angle, if it is rational.
    fn square_of_tangent(&self, kind: Func, operands: &[Expr]) -> Option<RBig> {
        let &[f] = operands else { return None };
        let r = self.registers[&f];
        let v = self.trial(r, *self.trials(&[r], 1).first()?)?;
        let square = if kind == Func::Asin { v * v * (Residue::ONE - v * v).inv()? } else { v * v };
        square.to_rational(FRACTION_BOUND).filter(|q| *q > RBig::ZERO)
    }

    /// Σ k_p arg p + m π/4
    fn gaussian(&mut self, angle: &GaussianAngle) -> Reg {
        let pi = self.pi();
        let share = Residue::from_i64(angle.eighths) * Residue::new(4).inv().unwrap_or_default();
        let mut sum = self.scaled(share, pi);
        for &(p, k) in &angle.primes {
            let known = self.circle.primes.get(&p).copied();
            let generator = known.unwrap_or_else(|| self.constant_generator());
            self.circle.primes.insert(p, generator);
            let term = self.scaled(Residue::from_i64(k), generator);
            sum = self.push(Step::Add(sum, term));
        }
        sum
    }

    /// A generator for a constant angle.
    fn constant_generator(&mut self) -> Reg {
        let slot = self.generator(Generator::Free);
        let value = self.push(Step::Slot(slot));
        self.circle.basis.push(Angle { value, kind: AngleKind::Inverse, parts: 1 });
        value
    }
}
