//! Finding events: a sliding switch reaches zero, or a sticking one needs more than the full sign.
//!
//! Every switch has a *gap* that is positive while its mode lasts: `±σ` for a sign, `1 − |s|` sticking (static over sliding
//! level in place of 1). It is sampled on the step's continuous extension; the event itself is then reached by a step of its
//! own, corrected by Newton's rule.

use super::search::{minimum, root};
use crate::friction::{Field, FrictionMode, NEGLIGIBLE, SIMULTANEOUS, norm};
use crate::integrate::{Method, Step};

/// Where in a step the gaps are sampled.
const SAMPLES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// How many times its range over the stages of a step a sticking sign must stay from ±1 to need no samples between.
const CALM: f64 = 2.0;

/// What the gaps do during a step.
pub(crate) enum Scan {
    /// Nothing happens.
    Clear,
    /// A gap varies too fast for its samples to be trusted.
    Unresolved,
    /// The gap of `switch` closes at `theta ∈ [0, 1]`.
    Event {
        /// Fraction of the step.
        theta: f64,
        /// The switch.
        switch: usize,
    },
}

/// The gaps of all switches, where they were evaluated last and at the samples of a step.
#[derive(Debug, Clone)]
pub(crate) struct Locator {
    gaps: Vec<f64>,
    samples: [Vec<f64>; 5],
    /// Change of the gaps per step at both ends.
    rates: [Vec<f64>; 2],
    /// Rounding to expect in them.
    noise: Vec<f64>,
    /// State and velocity within the step.
    x: Vec<f64>,
    dx: Vec<f64>,
}

/// A step of length `h` that is searched for events.
struct Search<'a, 's> {
    locator: &'a mut Locator,
    field: &'a mut Field<'s>,
    step: &'a Step,
    h: f64,
}

impl Locator {
    /// For `n` states.
    pub(crate) fn new(n: usize, switches: usize) -> Self {
        let row = || vec![0.0; switches];
        Self {
            gaps: row(),
            samples: std::array::from_fn(|_| row()),
            rates: [row(), row()],
            noise: row(),
            x: vec![0.0; n],
            dx: vec![0.0; n],
        }
    }

    /// Samples the gaps over the attempted step of length `h` and finds the first event. `atol` is the absolute tolerance of the
    /// states.
    pub(crate) fn scan(&mut self, field: &mut Field<'_>, step: &Step, h: f64, atol: f64) -> Scan {
        if field.modes.iter().all(|&mode| mode == FrictionMode::Sliding) {
            return Scan::Clear;
        }
        Search { locator: self, field, step, h }.first_event(atol)
    }

    /// By how much the gap of `switch` changes per second shortly before the fraction `theta` of the attempted step.
    pub(crate) fn secant(&mut self, field: &mut Field<'_>, step: &Step, (theta, h): (f64, f64), switch: usize) -> f64 {
        let near = theta * (1.0 - 1e-3);
        let mut search = Search { locator: self, field, step, h };
        (search.gap(switch, theta) - search.gap(switch, near)) / ((theta - near) * h)
    }
}

/// The gap of a switch at the end of the attempted step of length `h`, and its slope there: of a sliding gap by the gradient, of a
/// sticking one by the `secant`.
pub(crate) fn gap_at_end(field: &mut Field<'_>, step: &Step, h: f64, switch: usize, secant: f64) -> (f64, f64) {
    match field.modes[switch] {
        FrictionMode::Sticking | FrictionMode::Sliding => (field.reserve(switch, &step.signs[6]), secant),
        sliding => {
            let t = step.t + h;
            field.surfaces.evaluate(&mut field.system, t, &step.end);
            field.surfaces.differentiate(&mut field.system, t, &step.end);
            let c = field.surfaces.parts[switch].start;
            let rate = field.surfaces.rate(c, &step.k[6]);
            (sliding.sign() * field.surfaces.sigma[c], sliding.sign() * rate)
        }
    }
}

impl Search<'_, '_> {
    fn first_event(&mut self, atol: f64) -> Scan {
        self.differentiate(atol);
        let calm = self.sticks_calmly();
        for (a, theta) in SAMPLES.into_iter().enumerate() {
            match a {
                0 => self.evaluate_at_stage(0),
                4 => self.evaluate_at_stage(6),
                _ if calm => self.evaluate_sliding(theta),
                _ => self.evaluate(theta),
            }
            self.locator.samples[a].copy_from_slice(&self.locator.gaps);
        }
        let mut first: Option<(f64, usize)> = None;
        for i in 0..self.field.modes.len() {
            let g: [f64; 5] = std::array::from_fn(|a| self.locator.samples[a][i]);
            let sticking = self.field.modes[i] == FrictionMode::Sticking;
            if sticking && calm {
                continue;
            }
            if g.iter().any(|v| v.is_nan()) || !sticking && self.is_coarse(i, &g) {
                return Scan::Unresolved;
            }
            let noise = if sticking { 0.0 } else { self.locator.noise[i] };
            let bracket = match (1..5).find(|&a| g[a] < -noise) {
                Some(1) if g[0] <= noise => Some(self.bracket_near_start(i, noise)),
                Some(a) => Some((SAMPLES[a - 1], SAMPLES[a])),
                None => self.bracket_below_minimum(i, &g, noise),
            };
            if let Some((a, b)) = bracket {
                let resolution = (0.1 * SIMULTANEOUS * self.step.t.abs().max(1.0) / self.h).clamp(1e-15, 1e-3);
                let theta = if b > a { root(|theta| self.gap(i, theta), a, b, resolution) } else { a };
                if first.is_none_or(|(earliest, _)| theta < earliest) {
                    first = Some((theta, i));
                }
            }
        }
        first.map_or(Scan::Clear, |(theta, switch)| Scan::Event { theta, switch })
    }

    /// The rates of the gaps at both ends of the step, and the rounding to expect in them.
    fn differentiate(&mut self, atol: f64) {
        let Locator { rates, noise, .. } = &mut *self.locator;
        noise.fill(0.0);
        rates[0].fill(0.0);
        rates[1].fill(0.0);
        let (Field { surfaces, system, modes, .. }, step, h) = (&mut *self.field, self.step, self.h);
        if modes.iter().all(|mode| mode.sign() == 0.0) {
            return;
        }
        let ends = [(step.t, &step.x, &step.k[0]), (step.t + h, &step.end, &step.k[6])];
        for (end, (t, x, dx)) in ends.into_iter().enumerate() {
            surfaces.differentiate(system, t, x);
            for (i, mode) in modes.iter().enumerate().filter(|(_, mode)| mode.sign() != 0.0) {
                let c = surfaces.parts[i].start;
                rates[end][i] = h * mode.sign() * surfaces.rate(c, dx);
                if end == 0 {
                    noise[i] = surfaces.noise(c, x, dx, h) + surfaces.spread(c, NEGLIGIBLE * atol);
                }
            }
        }
    }

    fn gap(&mut self, switch: usize, theta: f64) -> f64 {
        self.evaluate(theta);
        self.locator.gaps[switch]
    }

    /// Evaluates the gaps at fraction `theta` of the step.
    fn evaluate(&mut self, theta: f64) {
        let t = self.surfaces_at(theta);
        let sticks = self.field.modes.contains(&FrictionMode::Sticking);
        if sticks && self.step.method == Method::Directions {
            self.field.set_directions(&self.step.interpolate_directions(theta));
        }
        let solved = !sticks || self.field.evaluate((t, &self.locator.x), &mut self.locator.dx);
        self.field.release_directions();
        self.gaps_by_signs(solved);
    }

    /// Evaluates σ at fraction `theta` of the step; the time.
    fn surfaces_at(&mut self, theta: f64) -> f64 {
        let t = self.step.t + theta * self.h;
        self.step.interpolate(theta, &mut self.locator.x);
        self.field.surfaces.evaluate(&mut self.field.system, t, &self.locator.x);
        t
    }

    /// The gaps at the start (stage 0) or at the end (stage 6) of the step, whose signs are known.
    fn evaluate_at_stage(&mut self, stage: usize) {
        let step = self.step;
        let (t, x) = if stage == 0 { (step.t, &step.x) } else { (step.t + self.h, &step.end) };
        self.field.surfaces.evaluate(&mut self.field.system, t, x);
        self.field.s.copy_from_slice(&step.signs[stage]);
        self.gaps_by_signs(true);
    }

    /// The gaps of the signs that slide, at fraction `theta` of the step; of what sticks those before.
    fn evaluate_sliding(&mut self, theta: f64) {
        if self.field.modes.iter().any(|mode| mode.sign() != 0.0) {
            self.surfaces_at(theta);
            self.gaps_by_signs(true);
        }
    }

    /// The gaps by the last σ and the last signs, which hold if they are `solved`.
    fn gaps_by_signs(&mut self, solved: bool) {
        let field = &*self.field;
        for (i, (gap, mode)) in self.locator.gaps.iter_mut().zip(&field.modes).enumerate() {
            *gap = match mode {
                FrictionMode::Sticking if solved => field.reserve(i, &field.s),
                FrictionMode::Sticking => -1.0,
                // Its σ reaches zero without a change of sign.
                FrictionMode::Sliding => 1.0,
                sliding => sliding.sign() * field.surfaces.sigma[field.surfaces.parts[i].start],
            };
        }
    }

    /// Whether what sticks stays away from breaking loose by more than it varies, over all stages of an explicit step.
    fn sticks_calmly(&self) -> bool {
        let signs = &self.step.signs;
        let calm = |i: usize| {
            let part = self.field.surfaces.parts[i].clone();
            let largest = signs.iter().map(|signs| norm(&signs[part.clone()])).fold(0.0, f64::max);
            let range = part.map(|c| {
                let of_stages = signs.iter().map(|signs| signs[c]);
                of_stages.clone().fold(f64::NEG_INFINITY, f64::max) - of_stages.fold(f64::INFINITY, f64::min)
            });
            largest + CALM * range.map(|r| r * r).sum::<f64>().sqrt() < 1.0
        };
        self.step.method == Method::Explicit && self.field.in_mode(FrictionMode::Sticking).all(calm)
    }

    /// Whether the samples of a gap disagree with the cubic through its ends so much that a zero may hide.
    fn is_coarse(&self, i: usize, g: &[f64; 5]) -> bool {
        let [r0, r1] = [0, 1].map(|end| self.locator.rates[end][i]);
        let (mut deviation, mut size, mut least) = (0.0f64, 0.0f64, f64::INFINITY);
        for (theta, value) in SAMPLES.into_iter().zip(g) {
            let (p, q) = (theta, 1.0 - theta);
            let cubic = q * q * ((1.0 + 2.0 * p) * g[0] + p * r0) + p * p * ((1.0 + 2.0 * q) * g[4] - q * r1);
            deviation = deviation.max((cubic - value).abs());
            size = size.max(value.abs());
            least = least.min(*value);
        }
        deviation > 0.02 * size && least < 4.0 * deviation && deviation > 100.0 * self.locator.noise[i]
    }

    /// For a gap that starts at zero and is negative at the first sample: where it is positive in between, or the start
    /// itself if it is nowhere.
    fn bracket_near_start(&mut self, i: usize, noise: f64) -> (f64, f64) {
        let mut above = SAMPLES[1];
        for _ in 0..30 {
            let theta = 0.5 * above;
            if self.gap(i, theta) > noise {
                return (theta, above);
            }
            above = theta;
        }
        (0.0, 0.0)
    }

    /// Searches below a gap whose samples are all positive: at interior minima, and next to the ends by the rates.
    fn bracket_below_minimum(&mut self, i: usize, g: &[f64; 5], noise: f64) -> Option<(f64, f64)> {
        let size = g.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for a in 0..5 {
            let dip = if a == 0 || a == 4 { self.dip_at_end(i, g, a, size) } else { dip_between(g, a) };
            let Some(dip) = dip else { continue };
            if g[a] - dip > 0.1 * size {
                continue;
            }
            let (lower, upper) = (SAMPLES[a.max(1) - 1], SAMPLES[a.min(3) + 1]);
            let at = minimum(|theta| self.gap(i, theta), lower, upper);
            if self.gap(i, at) < -noise && self.gap(i, lower) >= -noise {
                return Some((lower, at));
            }
        }
        None
    }

    /// How far a gap may lie below its first or last sample, by its rate there.
    fn dip_at_end(&mut self, i: usize, g: &[f64; 5], a: usize, size: f64) -> Option<f64> {
        let next = if a == 0 { g[1] } else { g[3] };
        if g[a] > next || g[a] > 0.1 * size || self.field.departing[i] && a == 0 {
            return None;
        }
        // Toward the interior of the step.
        let rate = match (self.field.modes[i] == FrictionMode::Sticking, a) {
            (true, 0) => (self.gap(i, 1e-3) - g[0]) / 1e-3,
            (true, _) => (self.gap(i, 1.0 - 1e-3) - g[4]) / 1e-3,
            (false, 0) => self.locator.rates[0][i],
            (false, _) => -self.locator.rates[1][i],
        };
        // Slope and second difference of the parabola, in units of the sampling width.
        let slope = 0.25 * rate;
        let curvature = next - g[a] - slope;
        (slope < 0.0 && curvature > 0.0).then(|| slope * slope / (4.0 * curvature))
    }
}

/// How far a gap may lie below an interior sample that is least, by the parabola through its neighbors.
fn dip_between(g: &[f64; 5], a: usize) -> Option<f64> {
    if g[a] > g[a - 1] || g[a] > g[a + 1] {
        return None;
    }
    let slope = 0.5 * (g[a + 1] - g[a - 1]);
    let curvature = g[a + 1] - 2.0 * g[a] + g[a - 1];
    Some(if curvature > 0.0 { slope * slope / (2.0 * curvature) } else { 0.0 })
}
