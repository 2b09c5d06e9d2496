//! Which quotients σ/|σ| are dry friction, and which are smooth: decided here and nowhere else.
//!
//! A unit vector is set-valued where σ = 0 if it is written `unit(…)`, or if it acts against the rate of its own σ however
//! slow σ is: with the equations x' = f(x, s) and s in place of σ/|σ|, the power
//!
//! ```text
//! P(s) = −sᵀ·∂σ/∂x·(f(x, s) − f(x, 0))
//! ```
//!
//! is nowhere negative near σ = 0, and does not vanish with |σ|. This is what friction does to a velocity σ: it brings σ to
//! zero in finite time, and holds it there (Filippov 1988, *Differential Equations with Discontinuous Righthand Sides*, §15).
//! The direction of a spring acts on the rate of another quantity than the length it is the direction of: the motion passes
//! σ = 0 and never stays. Drag `c*|v|*v` acts against v, but vanishes with it. Both are smooth.

use bracketry_symbolic::{Expr, Symbol, Tape};

use crate::system::System;
use crate::unit_vector::Root;

/// How a quotient σ/|σ| behaves where σ = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum QuotientKind {
    /// It acts against σ with a force that does not vanish: set-valued.
    DryFriction,
    /// What it is multiplied by vanishes with σ: continuous.
    Continuous,
    /// It jumps, but the motion passes: smooth everywhere else.
    Singular,
}

/// Points at which the equations are looked at.
const SAMPLES: u64 = 24;
/// Sizes of σ at which they are: one small, one ten times smaller.
const SIZES: [f64; 2] = [1e-6, 1e-7];
/// Share of a jump at the first size below which it vanishes toward the second: what is linear in |σ| has 0.1.
const VANISHED: f64 = 0.5;
/// Distance of the points from the model's own, absolute and per size of the value there.
const SPREAD: f64 = 0.1;
/// Corrections that bring a point to the wanted σ.
const CORRECTIONS: usize = 60;
/// Largest share of the power by which rounding may make it negative.
const ROUNDING: f64 = 1e-6;

/// The equations with the directions s of one root as arguments, compiled.
struct Probe {
    tape: Tape,
    arguments: Vec<Symbol>,
    /// Where the components of s stand among the arguments.
    directions: Vec<usize>,
    states: usize,
    equations: usize,
    work: Vec<f64>,
    out: Vec<f64>,
}

/// What the unit vector does at a point.
struct Act {
    /// Largest change of an equation.
    jump: f64,
    /// P(s); none where σ has no gradient.
    power: f64,
}

impl System {
    /// How the quotients of `root` behave in `rows` (the dynamics, then the outputs), where directions stand for all of
    /// `roots`.
    pub(crate) fn quotient_kind(&mut self, rows: &[Expr], roots: &[Root], root: usize) -> QuotientKind {
        let Some(mut probe) = Probe::new(self, rows, roots, root) else { return QuotientKind::Singular };
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let nominal = self.nominal(&probe.arguments);
        let (mut met, mut against, mut lasting, mut continuous) = (0, true, false, true);
        for _ in 0..SAMPLES {
            let mut x: Vec<f64> = nominal.iter().map(|range| range.0 + (range.1 - range.0) * random.next()).collect();
            let mut direction: Vec<f64> = probe.directions.iter().map(|_| 2.0 * random.next() - 1.0).collect();
            let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            for d in &mut direction {
                *d /= size;
            }
            let acts = SIZES.map(|size| probe.act(&mut x, &direction, size));
            let [Some(wide), Some(near)] = acts else { continue };
            met += 1;
            continuous &= near.jump <= VANISHED * wide.jump;
            against &= near.power >= -ROUNDING * near.jump;
            lasting |= near.power > ROUNDING * near.jump && near.power > VANISHED * wide.power;
        }
        match met {
            0 => QuotientKind::Singular,
            _ if continuous => QuotientKind::Continuous,
            _ if against && lasting => QuotientKind::DryFriction,
            _ => QuotientKind::Singular,
        }
    }

    /// Between which values each argument is taken: around the model's point, inputs within their ranges.
    fn nominal(&self, arguments: &[Symbol]) -> Vec<(f64, f64)> {
        let point = self.point_values();
        let around = |value: f64| {
            let spread = SPREAD * (1.0 + value.abs());
            (value - spread, value + spread)
        };
        let of = |s: &Symbol| {
            if let Some(i) = self.states.iter().position(|x| x == s) {
                return around(point.as_ref().map_or(0.0, |p| p.0[i]));
            }
            let Some(j) = self.inputs.iter().position(|u| u == s) else {
                // A derivative of an input vanishes at rest; what else is no state is a number that became an argument.
                return around(f64::from(u8::from(!self.input_derivatives.iter().any(|d| d.symbol == *s))));
            };
            let value = point.as_ref().map_or(0.0, |p| p.1[j]);
            let range = self.input_ranges.iter().find(|r| r.input == *s);
            let end = |end: &Option<bracketry_symbolic::Rational>| end.as_ref().map(|e| e.to_f64().value());
            match range.map(|r| (end(&r.min), end(&r.max))) {
                Some((Some(min), Some(max))) => (min, max),
                Some((Some(min), None)) => (min, around(min.max(value)).1),
                Some((None, Some(max))) => (around(max.min(value)).0, max),
                _ => around(value),
            }
        };
        arguments.iter().map(of).collect()
    }
}

impl Probe {
    /// None if σ does not depend on the states, so that nothing acts on its rate.
    fn new(system: &mut System, rows: &[Expr], roots: &[Root], root: usize) -> Option<Self> {
        let states = system.states.clone();
        let components: Vec<Expr> = roots[root].components.iter().map(|c| system.pool.mul(c.scale, c.base)).collect();
        let gradients: Vec<Expr> = components.iter().flat_map(|&c| system.pool.gradient(c, &states)).collect();
        if gradients.iter().all(|&g| system.pool.is_zero(g)) {
            return None;
        }
        let all = [rows, &components, &gradients].concat();
        let values = system.with_values(&all);
        let mut arguments = states;
        let rest: Vec<Symbol> =
            system.pool.symbols_of(&values).into_iter().filter(|s| !arguments.contains(s)).collect();
        arguments.extend(rest);
        let tape = system.compile(&arguments, &all).ok()?;
        let position = |s: &Symbol| arguments.iter().position(|a| a == s);
        // A component that no equation uses has no argument: any place will do behind the others.
        let directions = roots[root].directions.iter().map(|s| position(s).unwrap_or(arguments.len())).collect();
        let out = vec![0.0; tape.n_outputs()];
        let states = system.states.len();
        Some(Self { tape, arguments, directions, states, equations: rows.len(), work: Vec::new(), out })
    }

    fn evaluate(&mut self, x: &[f64]) {
        self.tape.eval(x, &mut self.work, &mut self.out);
    }

    /// Moves the states to where σ = size·direction; false if that is not found.
    fn approach(&mut self, x: &mut [f64], direction: &[f64], size: f64) -> bool {
        let (n, k) = (self.states, direction.len());
        for _ in 0..CORRECTIONS {
            let mut missing = 0.0_f64;
            for i in 0..k {
                self.evaluate(x);
                let gap = size * direction[i] - self.out[self.equations + i];
                missing = missing.max(gap.abs());
                let first = self.equations + k + i * n;
                let gradient = &self.out[first..first + n];
                let square: f64 = gradient.iter().map(|g| g * g).sum();
                if square > 0.0 {
                    x.iter_mut().zip(gradient).for_each(|(x, g)| *x += gap * g / square);
                }
            }
            if missing <= 1e-3 * size {
                return true;
            }
        }
        false
    }

    /// What the unit vector along `direction` does where σ has this size; none where that is not found or has no value.
    fn act(&mut self, x: &mut [f64], direction: &[f64], size: f64) -> Option<Act> {
        if !self.approach(x, direction, size) {
            return None;
        }
        let (n, k, m) = (self.states, direction.len(), self.equations);
        let mut with = x.to_vec();
        let mut without = x.to_vec();
        for (&at, &d) in self.directions.iter().zip(direction).filter(|(at, _)| **at < x.len()) {
            with[at] = d;
            without[at] = 0.0;
        }
        self.evaluate(&without);
        let still = self.out[..m].to_vec();
        self.evaluate(&with);
        let change: Vec<f64> = self.out[..m].iter().zip(&still).map(|(f, f0)| f - f0).collect();
        let mut power = 0.0;
        for (i, d) in direction.iter().enumerate() {
            let first = m + k + i * n;
            let gradient = &self.out[first..first + n];
            power -= d * gradient.iter().zip(&change).filter(|(g, _)| **g != 0.0).map(|(g, c)| g * c).sum::<f64>();
        }
        // An equation that has no value here says nothing.
        let jump = change.iter().filter(|c| c.is_finite()).fold(0.0, |m: f64, c| m.max(c.abs()));
        power.is_finite().then_some(Act { jump, power })
    }
}

/// Numbers between 0 and 1, the same in every run (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}
