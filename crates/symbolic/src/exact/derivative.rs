//! Derivatives of registers at trial points, along a random direction of the symbols.

use rustc_hash::FxHashMap;

use super::field::Residue;
use super::kernels::{AngleKind, Power};
use super::lower::inverse_modulo;
use super::lowering::Lowering;
use super::program::{MAX_POWER, Reg, Step, turned};
use crate::func::Func;
use crate::node::Node;
use crate::random::SplitMix64;

/// How the value of a generator changes with the registers that it is a function of.
#[derive(Clone, Copy)]
enum Rule {
    /// A symbol.
    Free,
    /// cos and sin (the register is the first or the second) of the part of an angle.
    Circle { point: (Reg, Reg), angle: Reg, parts: u64 },
    /// Exponential of the part of an exponent.
    Exponential { exponent: Reg, parts: u64 },
    /// Logarithm.
    Logarithm { of: Reg },
    /// Angle of a point (x, y) in the plane.
    Angle { x: Option<Reg>, y: Reg },
    /// No rule is known.
    Unknown,
}

impl<const C: u64> Lowering<'_, C> {
    /// Derivatives of `registers` at up to `most` of the trial points, at which all of them exist.
    pub(super) fn derivatives(&self, registers: &[Reg], most: usize) -> Vec<Vec<Residue<C>>> {
        let rules = self.rules();
        let all = self.trials(registers, usize::MAX).into_iter();
        all.filter_map(|i| self.derivatives_at(&rules, registers, i).into_iter().collect()).take(most).collect()
    }

    /// At the trial point of number `i`; `None` where a value or a rule is missing.
    fn derivatives_at(&self, rules: &FxHashMap<Reg, Rule>, registers: &[Reg], i: usize) -> Vec<Option<Residue<C>>> {
        let mut rng = SplitMix64::new(i as u64 + 1);
        let last = registers.iter().copied().max().map_or(0, |r| r + 1);
        let mut known: Vec<Option<Residue<C>>> = Vec::with_capacity(last);
        for r in 0..last {
            let d = |a: Reg| known[a];
            let mut derivative = || -> Option<Residue<C>> {
                Some(match self.program.steps[r] {
                    Step::Const(_) => Residue::ZERO,
                    Step::Slot(_) => match rules.get(&r) {
                        None => Residue::ZERO,
                        Some(Rule::Free) => rng.residue(),
                        Some(rule) => self.by_rule(rule, r, i, d)?,
                    },
                    Step::Add(a, b) => d(a)? + d(b)?,
                    Step::Mul(a, b) => d(a)? * self.trial(b, i)? + self.trial(a, i)? * d(b)?,
                    Step::Inverse(a) => {
                        let y = self.trial(r, i)?;
                        -(y * y * d(a)?)
                    }
                    // y = a^k: y' = k y a'/a, also for the k that stands for 1/d in the exponent of an odd root.
                    Step::Power(a, k) => {
                        let k = if k < MAX_POWER {
                            Residue::new(k)
                        } else {
                            Residue::new(inverse_modulo(k, Residue::<C>::MODULUS - 1)?).inv()?
                        };
                        k * self.trial(r, i)? * d(a)? * self.trial(a, i)?.inv()?
                    }
                    Step::Root(a, levels) => {
                        let k = Residue::new(1 << levels).inv()?;
                        k * self.trial(r, i)? * d(a)? * self.trial(a, i)?.inv()?
                    }
                    Step::Turn { x, y, turn, sine } => {
                        let (vx, vy) = (self.trial(x, i)?, self.trial(y, i)?);
                        let odd = Residue::new(inverse_modulo(turn, Residue::<C>::MODULUS + 1)?);
                        let angle = (d(y)? * vx - d(x)? * vy) * odd.inv()?;
                        let (c, s) = turned((vx, vy), turn);
                        if sine { c * angle } else { -(s * angle) }
                    }
                })
            };
            let value = derivative();
            known.push(value);
        }
        registers.iter().map(|&r| known[r]).collect()
    }

    fn by_rule(&self, rule: &Rule, r: Reg, i: usize, d: impl Fn(Reg) -> Option<Residue<C>>) -> Option<Residue<C>> {
        let at = |r: Reg| self.trial(r, i);
        Some(match *rule {
            Rule::Free | Rule::Unknown => return None,
            Rule::Circle { point: (c, s), angle, parts } => {
                let turn = d(angle)? * Residue::new(parts).inv()?;
                if r == c { -(at(s)? * turn) } else { at(c)? * turn }
            }
            Rule::Exponential { exponent, parts } => at(r)? * d(exponent)? * Residue::new(parts).inv()?,
            Rule::Logarithm { of } => d(of)? * at(of)?.inv()?,
            Rule::Angle { x: None, y } => {
                let t = at(y)?;
                d(y)? * (Residue::ONE + t * t).inv()?
            }
            Rule::Angle { x: Some(x), y } => {
                let (a, b) = (at(x)?, at(y)?);
                (d(y)? * a - d(x)? * b) * (a * a + b * b).inv()?
            }
        })
    }

    /// What the registers of generators are; those of constants are missing.
    fn rules(&self) -> FxHashMap<Reg, Rule> {
        let mut rules = FxHashMap::default();
        for (&e, &r) in &self.registers {
            if matches!(self.pool.node(e), Node::Sym(_)) && !self.exact.contains_key(&e) {
                rules.insert(r, Rule::Free);
            }
        }
        for a in &self.circle.basis {
            if let AngleKind::Free(point) = a.kind {
                let rule = Rule::Circle { point, angle: a.value, parts: a.parts };
                rules.extend([(point.0, rule), (point.1, rule)]);
            }
        }
        for (kind, operands, r) in &self.circle.inverses {
            let rule = match (kind, operands.as_slice()) {
                (Func::Atan, &[y]) => Rule::Angle { x: None, y: self.registers[&y] },
                (Func::Atan, &[y, x]) => Rule::Angle { x: Some(self.registers[&x]), y: self.registers[&y] },
                _ => Rule::Unknown,
            };
            rules.insert(*r, rule);
        }
        for &(exponent, power) in &self.explog.basis {
            match power {
                Power::Free(g, parts) => rules.insert(g, Rule::Exponential { exponent, parts }),
                Power::Argument(of, _) => rules.insert(exponent, Rule::Logarithm { of }),
                Power::Integer(..) => None,
            };
        }
        rules
    }
}
