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
//! zero in finite time, and holds it there (Filippov 1988, §15).
//! The direction of a spring acts on the rate of another quantity than the length it is the direction of: the motion passes
//! σ = 0 and never stays. Drag `c*|v|*v` acts against v, but vanishes with it. Both are smooth.
//!
//! Parameters have values that are fitted, swept, or not yet known, and the kind does not change with them: a quotient is dry
//! friction if it is so for any values within their ranges. A parameter without a range may have either sign.

use bracketry_symbolic::{Expr, Rational, SplitMix64, Symbol, Tape};

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
/// Most parameters that are looked at alone, and draws of all at once.
const MOST_ALONE: usize = 24;
const DRAWS: usize = 16;

/// The equations that the directions s of one root are in, compiled with s as arguments.
struct Probe {
    tape: Tape,
    arguments: Vec<Symbol>,
    /// Where the components of s stand among the arguments.
    directions: Vec<usize>,
    /// Where the constants stand that s is multiplied by in a rate of σ; none where s acts on no rate of σ.
    factors: Vec<usize>,
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
        let mut random = SplitMix64::new(0x9E37_79B9_7F4A_7C15);
        let others: Vec<Symbol> = roots.iter().flat_map(|r| &r.directions).copied().collect();
        let nominal = self.nominal(&probe.arguments, &others);
        let mut kinds = probe.trials(&nominal, &mut random).into_iter().map(|v| probe.kind(&v, &mut random));
        let mut kind = kinds.next().unwrap_or(QuotientKind::Singular);
        for other in kinds {
            match other {
                _ if kind == QuotientKind::DryFriction => return kind,
                QuotientKind::DryFriction | QuotientKind::Singular => kind = other,
                QuotientKind::Continuous => (),
            }
        }
        kind
    }

    /// Between which values each argument is taken: states around the model's point, inputs and parameters within their ranges.
    fn nominal(&self, arguments: &[Symbol], directions: &[Symbol]) -> Vec<Domain> {
        let point = self.point_values();
        let around = |value: f64| {
            let spread = SPREAD * (1.0 + value.abs());
            (value - spread, value + spread)
        };
        let end = |end: &Option<Rational>| end.as_ref().map(|e| e.to_f64().value());
        let fixed = |(low, high): (f64, f64)| Domain { low, high, constant: None };
        let of = |s: &Symbol| {
            if let Some(i) = self.states.iter().position(|x| x == s) {
                return fixed(around(point.as_ref().and_then(|p| p.0.get(i).copied()).unwrap_or(0.0)));
            }
            if let Some(p) = self.parameters.iter().find(|p| p.symbol == *s) {
                return Domain::of_parameter(p.value.to_f64().value(), end(&p.min), end(&p.max));
            }
            let Some(j) = self.inputs.iter().position(|u| u == s) else {
                // A derivative of an input vanishes at rest; what else is no state is a number that became an argument.
                return match () {
                    () if directions.contains(s) => fixed(around(1.0)),
                    () if self.input_derivatives.iter().any(|d| d.symbol == *s) => fixed(around(0.0)),
                    () => Domain::of_parameter(1.0, None, None),
                };
            };
            let value = point.as_ref().and_then(|p| p.1.get(j).copied()).unwrap_or(0.0);
            let range = self.input_ranges.iter().find(|r| r.input == *s);
            fixed(match range.map(|r| (end(&r.min), end(&r.max))) {
                Some((Some(min), Some(max))) => (min, max),
                Some((Some(min), None)) => (min, around(min.max(value)).1),
                Some((None, Some(max))) => (around(max.min(value)).0, max),
                _ => around(value),
            })
        };
        arguments.iter().map(of).collect()
    }
}

/// Between which values an argument is taken.
#[derive(Clone, Copy, Debug)]
struct Domain {
    low: f64,
    high: f64,
    /// Its own value, of one that does not change while the system moves.
    constant: Option<f64>,
}

impl Domain {
    /// Of a parameter with a range; where it has none, its size with either sign. One that is zero has the size 1.
    fn of_parameter(value: f64, min: Option<f64>, max: Option<f64>) -> Self {
        let size = if value == 0.0 { 1.0 } else { value.abs() };
        let (low, high) = match (min, max) {
            (Some(min), Some(max)) => (min, max),
            (Some(min), None) => (min, min.abs().max(size)),
            (None, Some(max)) => (-max.abs().max(size), max),
            (None, None) => (-size, size),
        };
        let other = if high > 0.0 { high } else { low };
        Self { low, high, constant: Some(if value == 0.0 { other } else { value }) }
    }

    /// Values of a constant to look at alone.
    fn ends(&self) -> impl Iterator<Item = f64> {
        let value = self.constant.unwrap_or_default();
        [self.low, self.high].into_iter().filter(move |&end| end != value && end != 0.0)
    }

    fn draw(&self, random: &mut SplitMix64) -> f64 {
        self.low + (self.high - self.low) * random.uniform()
    }
}

impl Probe {
    /// None if σ does not depend on the states, so that nothing acts on its rate.
    fn new(system: &mut System, rows: &[Expr], roots: &[Root], root: usize) -> Option<Self> {
        let states = system.states.clone();
        let own = &roots[root].directions;
        let components: Vec<Expr> = roots[root].components.iter().map(|c| system.pool.mul(c.scale, c.base)).collect();
        let gradients: Vec<Expr> = components.iter().flat_map(|&c| system.pool.gradient(c, &states)).collect();
        if gradients.iter().all(|&g| system.pool.is_zero(g)) {
            return None;
        }
        // Equations without s do not change with it.
        let (zero, pool) = (system.pool.int(0), &system.pool);
        let changes = |e: Expr| own.iter().any(|&s| pool.depends_on(e, s));
        let kept: Vec<Expr> = rows.iter().map(|&e| if changes(e) { e } else { zero }).collect();
        let n = states.len();
        let acts = |i: usize| kept[i] != zero && gradients.iter().skip(i).step_by(n).any(|&g| !system.pool.is_zero(g));
        let acting: Vec<Expr> = (0..n).filter(|&i| acts(i)).map(|i| kept[i]).collect();
        let by: Vec<Expr> = acting.iter().flat_map(|&e| system.pool.gradient(e, own)).collect();
        let mut factors = system.pool.symbols_of(&by);
        factors.retain(|s| !states.contains(s) && !system.inputs.contains(s));
        let all = [&kept[..], &components, &gradients].concat();
        let mut arguments = states;
        let rest: Vec<Symbol> = system.pool.symbols_of(&all).into_iter().filter(|s| !arguments.contains(s)).collect();
        arguments.extend(rest);
        let tape = Tape::compile(&system.pool, &arguments, &all).ok()?;
        let position = |s: &Symbol| arguments.iter().position(|a| a == s);
        // A component that no equation uses has no argument: any place will do behind the others.
        let directions = own.iter().map(|s| position(s).unwrap_or(arguments.len())).collect();
        let factors = factors.iter().filter_map(position).collect();
        let out = vec![0.0; tape.n_outputs()];
        Some(Self { tape, arguments, directions, factors, states: n, equations: rows.len(), work: Vec::new(), out })
    }

    /// Between which values the arguments are taken each time that the quotient is judged: constants are single numbers, their own
    /// first; then each factor at the ends of its range, and all of them within.
    fn trials(&self, nominal: &[Domain], random: &mut SplitMix64) -> Vec<Vec<Domain>> {
        let at = |d: &Domain, value: f64| Domain { low: value, high: value, ..*d };
        let own: Vec<Domain> = nominal.iter().map(|d| d.constant.map_or(*d, |value| at(d, value))).collect();
        let free: Vec<usize> = self.factors.iter().copied().filter(|&i| nominal[i].constant.is_some()).collect();
        let with = |values: &mut dyn Iterator<Item = (usize, f64)>| {
            let mut domains = own.clone();
            values.for_each(|(i, value)| domains[i] = at(&nominal[i], value));
            domains
        };
        let mut trials = vec![own.clone()];
        for &i in free.iter().take(MOST_ALONE) {
            trials.extend(nominal[i].ends().map(|end| with(&mut std::iter::once((i, end)))));
        }
        if free.len() > 1 {
            trials.extend((0..DRAWS).map(|_| with(&mut free.iter().map(|&i| (i, nominal[i].draw(random))))));
        }
        trials
    }

    /// The kind with arguments of these values. Friction resists wherever the system is.
    fn kind(&mut self, domains: &[Domain], random: &mut SplitMix64) -> QuotientKind {
        let (mut met, mut against, mut lasting, mut continuous) = (0, true, false, true);
        for _ in 0..SAMPLES {
            let mut x: Vec<f64> = domains.iter().map(|d| d.draw(random)).collect();
            let mut direction: Vec<f64> = self.directions.iter().map(|_| random.symmetric()).collect();
            let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            for d in &mut direction {
                *d /= size;
            }
            let acts = SIZES.map(|size| self.act(&mut x, &direction, size));
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
