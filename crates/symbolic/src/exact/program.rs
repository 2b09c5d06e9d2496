//! Straight-line programs over a prime field, with a bound of the degrees they compute.

use super::field::Residue;
use crate::random::SplitMix64;

/// Cosine and sine in the field.
pub(super) type Point<const C: u64> = (Residue<C>, Residue<C>);

/// A register of a [`Program`]: the result of the step of that number.
pub(super) type Reg = usize;

/// One field operation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step<const C: u64> {
    Const(Residue<C>),
    /// A coordinate of the sample point.
    Slot(usize),
    Add(Reg, Reg),
    Mul(Reg, Reg),
    Inverse(Reg),
    Power(Reg, u64),
    /// The 2^levels-th root that is a square itself.
    Root(Reg, u32),
    /// Cosine or sine of `turn` times the angle of the point (x, y) of the unit circle.
    Turn {
        x: Reg,
        y: Reg,
        turn: u64,
        sine: bool,
    },
}

/// Larger powers and turns stand for roots: by 1/d modulo the order of the group.
pub(super) const MAX_POWER: u64 = 1 << 40;

/// What makes up a sample point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Generator {
    /// A random value other than 0: one slot.
    Free,
    /// (cos, sin) = ((1 − t²)/(1 + t²), 2t/(1 + t²)) for a random t: two slots.
    Circle,
    /// 1 or −1: one slot.
    Sign,
}

/// Why a point has no value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Fault {
    DivisionByZero,
    /// The radicand is no square in the field.
    NoRoot,
}

/// Degree of a rational function written as N / Π V_j^(e_j) over the divisors V_j of the program.
#[derive(Clone, Debug, Default)]
struct Degree {
    numerator: f64,
    /// (j, e_j), ascending.
    divisors: Vec<(u32, f64)>,
}

/// Straight-line program: steps in order, each of which may use the ones before.
#[derive(Clone, Debug, Default)]
pub(super) struct Program<const C: u64> {
    pub(super) steps: Vec<Step<C>>,
    pub(super) generators: Vec<Generator>,
    slots: usize,
    degrees: Vec<Degree>,
    divisor_degrees: Vec<f64>,
    divisor_of: Vec<(Reg, u32)>,
    slot_degrees: Vec<Degree>,
}

impl<const C: u64> Program<C> {
    /// Adds a generator; the first of its slots.
    pub(super) fn generator(&mut self, g: Generator) -> usize {
        let first = self.slots;
        self.generators.push(g);
        match g {
            Generator::Free => self.slot_degrees.push(Degree { numerator: 1.0, divisors: Vec::new() }),
            Generator::Sign => self.slot_degrees.push(Degree::default()),
            Generator::Circle => {
                let j = self.divisor_degrees.len() as u32;
                self.divisor_degrees.push(2.0);
                let d = Degree { numerator: 2.0, divisors: vec![(j, 1.0)] };
                self.slot_degrees.extend([d.clone(), d]);
            }
        }
        self.slots = self.slot_degrees.len();
        first
    }

    /// SplitMix64 values of all generators but of those that have theirs.
    pub(super) fn point(&self, start: &[Residue<C>], rng: &mut SplitMix64) -> Vec<Residue<C>> {
        let mut p = Vec::with_capacity(self.slots);
        p.extend_from_slice(&start[..start.len().min(self.slots)]);
        let mut slots = 0;
        for &g in &self.generators {
            if slots >= start.len() {
                draw(g, rng, &mut p);
            }
            slots += if matches!(g, Generator::Circle) { 2 } else { 1 };
        }
        p
    }

    pub(super) fn push(&mut self, step: Step<C>) -> Reg {
        let d = self.degree_of(step);
        self.steps.push(step);
        self.degrees.push(d);
        self.steps.len() - 1
    }

    /// True if the register has the same value at all points.
    pub(super) fn is_constant(&self, r: Reg) -> bool {
        self.degrees[r].numerator == 0.0 && self.degrees[r].divisors.is_empty()
    }

    /// Degree of the numerator after multiplication by the common denominator of `rs`, for the largest of them.
    pub(super) fn common_degree(&self, rs: &[Reg]) -> f64 {
        let mut common: Vec<(u32, f64)> = Vec::new();
        for &r in rs {
            common = merge(&common, &self.degrees[r].divisors, f64::max);
        }
        rs.iter().fold(0.0, |d, &r| d.max(self.lifted(&self.degrees[r], &common)))
    }

    fn lifted(&self, d: &Degree, common: &[(u32, f64)]) -> f64 {
        let weight = |v: &[(u32, f64)]| v.iter().map(|&(j, e)| e * self.divisor_degrees[j as usize]).sum::<f64>();
        d.numerator + weight(common) - weight(&d.divisors)
    }

    fn degree_of(&mut self, step: Step<C>) -> Degree {
        match step {
            Step::Const(_) => Degree::default(),
            Step::Slot(s) => self.slot_degrees[s].clone(),
            Step::Add(a, b) => {
                let (a, b) = (&self.degrees[a], &self.degrees[b]);
                let divisors = merge(&a.divisors, &b.divisors, f64::max);
                let numerator = self.lifted(a, &divisors).max(self.lifted(b, &divisors));
                Degree { numerator, divisors }
            }
            Step::Mul(a, b) => {
                let (a, b) = (&self.degrees[a], &self.degrees[b]);
                let divisors = merge(&a.divisors, &b.divisors, |x, y| x + y);
                Degree { numerator: a.numerator + b.numerator, divisors }
            }
            Step::Inverse(a) => {
                let d = self.degrees[a].clone();
                let numerator = self.lifted(&Degree::default(), &d.divisors);
                if d.numerator == 0.0 {
                    return Degree { numerator, divisors: Vec::new() };
                }
                let known = self.divisor_of.iter().find(|(r, _)| *r == a).map(|d| d.1);
                let j = known.unwrap_or_else(|| {
                    let j = self.divisor_degrees.len() as u32;
                    self.divisor_degrees.push(d.numerator);
                    self.divisor_of.push((a, j));
                    j
                });
                Degree { numerator, divisors: vec![(j, 1.0)] }
            }
            Step::Power(a, k) => {
                let d = &self.degrees[a];
                // An odd root is the power by an inverse modulo p − 1; its degree is below that of the base.
                let k = if k >= MAX_POWER { 1.0 } else { k as f64 };
                let divisors = d.divisors.iter().map(|&(j, e)| (j, e * k)).collect();
                Degree { numerator: d.numerator * k, divisors }
            }
            Step::Root(a, _) => self.degrees[a].clone(),
            // Used for roots only.
            Step::Turn { x, y, .. } => {
                let (a, b) = (&self.degrees[x], &self.degrees[y]);
                let divisors = merge(&a.divisors, &b.divisors, f64::max);
                let numerator = self.lifted(a, &divisors).max(self.lifted(b, &divisors));
                Degree { numerator, divisors }
            }
        }
    }

    /// Value of one step at a point, given the registers before it.
    pub(super) fn value(
        step: Step<C>,
        point: &[Residue<C>],
        get: impl Fn(Reg) -> Residue<C>,
    ) -> Result<Residue<C>, Fault> {
        Ok(match step {
            Step::Const(c) => c,
            Step::Slot(s) => point[s],
            Step::Add(a, b) => get(a) + get(b),
            Step::Mul(a, b) => get(a) * get(b),
            Step::Inverse(a) => get(a).inv().ok_or(Fault::DivisionByZero)?,
            Step::Power(a, k) => get(a).pow(k),
            Step::Root(a, levels) => {
                let mut r = get(a);
                for _ in 0..levels {
                    r = r.sqrt().ok_or(Fault::NoRoot)?;
                }
                r
            }
            Step::Turn { x, y, turn, sine } => {
                let p = turned((get(x), get(y)), turn);
                if sine { p.1 } else { p.0 }
            }
        })
    }

    /// All registers at a point.
    pub(super) fn run(&self, point: &[Residue<C>], registers: &mut Vec<Residue<C>>) -> Result<(), Fault> {
        registers.clear();
        for &s in &self.steps {
            let v = Self::value(s, point, |r| registers[r])?;
            registers.push(v);
        }
        Ok(())
    }
}

/// (cos, sin) of the sum of two angles.
pub(super) fn rotated<const C: u64>(p: Point<C>, q: Point<C>) -> Point<C> {
    (p.0 * q.0 - p.1 * q.1, p.1 * q.0 + p.0 * q.1)
}

/// (cos, sin) of k times an angle.
pub(super) fn turned<const C: u64>(mut p: Point<C>, mut k: u64) -> Point<C> {
    let mut r = (Residue::ONE, Residue::ZERO);
    while k > 0 {
        if k & 1 == 1 {
            r = rotated(r, p);
        }
        p = rotated(p, p);
        k >>= 1;
    }
    r
}

/// Appends random values for one generator.
pub(super) fn draw<const C: u64>(g: Generator, rng: &mut SplitMix64, point: &mut Vec<Residue<C>>) {
    match g {
        Generator::Free => point.push(rng.residue()),
        Generator::Sign => point.push(if rng.next_u64() >> 63 == 0 { Residue::ONE } else { -Residue::ONE }),
        Generator::Circle => loop {
            let t: Residue<C> = rng.residue();
            // −1 is no square, so 1 + t² is never 0.
            if let Some(d) = (Residue::ONE + t * t).inv() {
                point.extend([(Residue::ONE - t * t) * d, (t + t) * d]);
                return;
            }
        },
    }
}

/// Joins two sparse exponent vectors.
fn merge(a: &[(u32, f64)], b: &[(u32, f64)], join: impl Fn(f64, f64) -> f64) -> Vec<(u32, f64)> {
    if a.is_empty() {
        return b.to_vec();
    }
    if b.is_empty() {
        return a.to_vec();
    }
    let (mut i, mut k) = (0, 0);
    let mut out = Vec::with_capacity(a.len() + b.len());
    while i < a.len() || k < b.len() {
        match (a.get(i), b.get(k)) {
            (Some(&(ja, ea)), Some(&(jb, eb))) if ja == jb => {
                out.push((ja, join(ea, eb)));
                i += 1;
                k += 1;
            }
            (Some(&x), Some(y)) if x.0 < y.0 => {
                out.push(x);
                i += 1;
            }
            (Some(&x), None) => {
                out.push(x);
                i += 1;
            }
            (_, Some(&y)) => {
                out.push(y);
                k += 1;
            }
            (None, None) => break,
        }
    }
    out
}
