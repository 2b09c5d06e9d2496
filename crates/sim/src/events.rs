//! Finding and handling events: a sliding switch reaches zero, or a sticking one needs more than the full sign.
//!
//! Every switch has a *gap* that is positive while its mode lasts: `±σ` for a sign, `1 − |s|` sticking (static over sliding level in place of 1). It is sampled on the
//! step's continuous extension; the event itself is then reached by a step of its own, corrected by Newton's rule.

use crate::multipliers::norm;
use crate::stepper::Stepper;
use crate::trajectory::{Trajectory, interpolate};
use crate::{Mode, StopReason, Switched};

/// Where in a step the gaps are sampled.
const SAMPLES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Events closer than this (times the time, from 1 s on) are one.
const SIMULTANEOUS: f64 = 1e-12;

/// Part of the absolute tolerance below which a switching function is rounding: what hangs on a sticking velocity
/// stays there.
pub(crate) const NEGLIGIBLE: f64 = 1e-4;

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

impl<S: Switched> Stepper<S> {
    /// Evaluates the gaps at fraction `theta` of the step of length `h` into `self.gaps`.
    fn evaluate_gaps(&mut self, theta: f64, h: f64) {
        interpolate(&self.coefficients, self.x.len(), theta, &mut self.stage);
        let t = self.t + theta * h;
        self.system.switching(t, &self.stage, &mut self.sigma);
        let sticks = self.modes.contains(&Mode::Sticking);
        if sticks && self.implicit {
            self.interpolate_directions(theta);
        }
        let solved = !sticks || self.multipliers.field(&mut self.system, t, &self.stage, &mut self.end_velocity);
        self.multipliers.held.fill(false);
        self.gaps_by_signs(solved);
    }

    /// The gaps at the start (stage 0) or at the end (stage 6) of the attempted step, whose signs are known.
    fn gaps_at_stage(&mut self, stage: usize, t: f64) {
        let x = if stage == 0 { &self.x } else { &self.end };
        self.system.switching(t, x, &mut self.sigma);
        self.multipliers.s.copy_from_slice(&self.signs[stage]);
        self.gaps_by_signs(true);
    }

    /// The gaps of the signs that slide, at fraction `theta` of the step; of what sticks those before.
    fn evaluate_sliding_gaps(&mut self, theta: f64, h: f64) {
        if self.modes.iter().any(|mode| mode.sign() != 0.0) {
            interpolate(&self.coefficients, self.x.len(), theta, &mut self.stage);
            self.system.switching(self.t + theta * h, &self.stage, &mut self.sigma);
            self.gaps_by_signs(true);
        }
    }

    /// The gaps by the last σ and the last signs, which hold if they are `solved`.
    fn gaps_by_signs(&mut self, solved: bool) {
        for (i, mode) in self.modes.iter().enumerate() {
            self.gaps[i] = match mode {
                Mode::Sticking if solved => self.multipliers.reserve(i, self.multipliers.size(i)),
                Mode::Sticking => -1.0,
                // Its σ reaches zero without a change of sign.
                Mode::Sliding => 1.0,
                sliding => sliding.sign() * self.sigma[self.multipliers.parts[i].start],
            };
        }
    }

    /// Whether what sticks stays away from breaking loose by more than it varies, over all stages of an explicit step.
    fn sticks_calmly(&self) -> bool {
        let calm = |i: usize| {
            let part = self.multipliers.parts[i].clone();
            let largest = self.signs.iter().map(|signs| norm(&signs[part.clone()])).fold(0.0, f64::max);
            let range = part.map(|c| {
                let of_stages = self.signs.iter().map(|signs| signs[c]);
                of_stages.clone().fold(f64::NEG_INFINITY, f64::max) - of_stages.fold(f64::INFINITY, f64::min)
            });
            largest + CALM * range.map(|r| r * r).sum::<f64>().sqrt() < 1.0
        };
        !self.implicit && (0..self.modes.len()).filter(|&i| self.modes[i] == Mode::Sticking).all(calm)
    }

    fn gap(&mut self, switch: usize, theta: f64, h: f64) -> f64 {
        self.evaluate_gaps(theta, h);
        self.gaps[switch]
    }

    /// Samples the gaps over the attempted step and finds the first event.
    pub(crate) fn scan(&mut self, h: f64) -> Scan {
        let switches = self.modes.len();
        if self.modes.iter().all(|&mode| mode == Mode::Sliding) {
            return Scan::Clear;
        }
        // Rates at both ends, and the rounding to expect.
        let sliding = self.modes.iter().any(|&mode| mode.sign() != 0.0);
        self.noise.fill(0.0);
        self.rates.iter_mut().for_each(|rates| rates.fill(0.0));
        if sliding {
            self.multipliers.gradients(&mut self.system, self.t, &self.x);
            for i in (0..switches).filter(|&i| self.modes[i].sign() != 0.0) {
                let c = self.multipliers.parts[i].start;
                self.rates[0][i] = h * self.modes[i].sign() * self.multipliers.rate(c, &self.k[0]);
                self.noise[i] = self.multipliers.noise(c, &self.x, &self.k[0], h)
                    + self.multipliers.spread(c, NEGLIGIBLE * self.settings.atol);
            }
            self.multipliers.gradients(&mut self.system, self.t + h, &self.end);
            for i in 0..switches {
                let c = self.multipliers.parts[i].start;
                self.rates[1][i] = h * self.modes[i].sign() * self.multipliers.rate(c, &self.k[6]);
            }
        }
        let calm = self.sticks_calmly();
        for (a, theta) in SAMPLES.into_iter().enumerate() {
            match a {
                0 => self.gaps_at_stage(0, self.t),
                4 => self.gaps_at_stage(6, self.t + h),
                _ if calm => self.evaluate_sliding_gaps(theta, h),
                _ => self.evaluate_gaps(theta, h),
            }
            self.samples[a * switches..(a + 1) * switches].copy_from_slice(&self.gaps);
        }
        let mut first: Option<(f64, usize)> = None;
        for i in 0..switches {
            let g: [f64; 5] = std::array::from_fn(|a| self.samples[a * switches + i]);
            let sticking = self.modes[i] == Mode::Sticking;
            if sticking && calm {
                continue;
            }
            let noise = if sticking { 0.0 } else { self.noise[i] };
            if g.iter().any(|v| v.is_nan()) {
                return Scan::Unresolved;
            }
            if !sticking && self.coarse(i, &g) {
                return Scan::Unresolved;
            }
            let bracket = match (1..5).find(|&a| g[a] < -noise) {
                Some(1) if g[0] <= noise => Some(self.bracket_near_start(i, noise, h)),
                Some(a) => Some((SAMPLES[a - 1], SAMPLES[a])),
                None => self.bracket_below_minimum(i, &g, noise, h),
            };
            if let Some((a, b)) = bracket {
                let theta = if b > a { self.root(i, a, b, h) } else { a };
                if first.is_none_or(|(earliest, _)| theta < earliest) {
                    first = Some((theta, i));
                }
            }
        }
        match first {
            Some((theta, switch)) => Scan::Event { theta, switch },
            None => Scan::Clear,
        }
    }

    /// Whether the samples of a gap disagree with the cubic through its ends so much that a zero may hide.
    fn coarse(&self, i: usize, g: &[f64; 5]) -> bool {
        let (r0, r1) = (self.rates[0][i], self.rates[1][i]);
        let (mut deviation, mut size, mut least) = (0.0f64, 0.0f64, f64::INFINITY);
        for (theta, value) in SAMPLES.into_iter().zip(g) {
            let (p, q) = (theta, 1.0 - theta);
            let cubic = q * q * ((1.0 + 2.0 * p) * g[0] + p * r0) + p * p * ((1.0 + 2.0 * q) * g[4] - q * r1);
            deviation = deviation.max((cubic - value).abs());
            size = size.max(value.abs());
            least = least.min(*value);
        }
        deviation > 0.02 * size && least < 4.0 * deviation && deviation > 100.0 * self.noise[i]
    }

    /// For a gap that starts at zero and is negative at the first sample: where it is positive in between, or the start
    /// itself if it is nowhere.
    fn bracket_near_start(&mut self, i: usize, noise: f64, h: f64) -> (f64, f64) {
        let mut above = SAMPLES[1];
        for _ in 0..30 {
            let theta = 0.5 * above;
            let gap = self.gap(i, theta, h);
            if gap > noise {
                return (theta, above);
            }
            above = theta;
        }
        (0.0, 0.0)
    }

    /// Searches below a gap whose samples are all positive: at interior minima, and next to the ends by the rates.
    fn bracket_below_minimum(&mut self, i: usize, g: &[f64; 5], noise: f64, h: f64) -> Option<(f64, f64)> {
        let sticking = self.modes[i] == Mode::Sticking;
        let size = g.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for a in 0..5 {
            // Slope and second difference of the parabola at sample a, in units of the sampling width.
            let (lower, upper, least) = if a == 0 || a == 4 {
                let next = if a == 0 { g[1] } else { g[3] };
                if g[a] > next || g[a] > 0.1 * size || self.departing[i] && a == 0 {
                    continue;
                }
                // Towards the interior of the step.
                let rate = match (sticking, a) {
                    (true, 0) => (self.gap(i, 1e-3, h) - g[0]) / 1e-3,
                    (true, _) => (self.gap(i, 1.0 - 1e-3, h) - g[4]) / 1e-3,
                    (false, 0) => self.rates[0][i],
                    (false, _) => -self.rates[1][i],
                };
                let slope = 0.25 * rate;
                let curvature = next - g[a] - slope;
                if slope >= 0.0 || curvature <= 0.0 {
                    continue;
                }
                let dip = slope * slope / (4.0 * curvature);
                (SAMPLES[a.max(1) - 1], SAMPLES[a.min(3) + 1], g[a] - dip)
            } else {
                if g[a] > g[a - 1] || g[a] > g[a + 1] {
                    continue;
                }
                let slope = 0.5 * (g[a + 1] - g[a - 1]);
                let curvature = g[a + 1] - 2.0 * g[a] + g[a - 1];
                let dip = if curvature > 0.0 { slope * slope / (2.0 * curvature) } else { 0.0 };
                (SAMPLES[a - 1], SAMPLES[a + 1], g[a] - dip)
            };
            if least > 0.1 * size {
                continue;
            }
            let at = self.minimum(i, lower, upper, h);
            if self.gap(i, at, h) < -noise && self.gap(i, lower, h) >= -noise {
                return Some((lower, at));
            }
        }
        None
    }

    /// Golden-section search for the least gap.
    fn minimum(&mut self, i: usize, mut a: f64, mut b: f64, h: f64) -> f64 {
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
        let (mut gc, mut gd) = (self.gap(i, c, h), self.gap(i, d, h));
        while b - a > 1e-7 {
            if gc < 0.0 {
                return c;
            }
            if gd < 0.0 {
                return d;
            }
            if gc < gd {
                (b, d, gd) = (d, c, gc);
                c = b - golden * (b - a);
                gc = self.gap(i, c, h);
            } else {
                (a, c, gc) = (c, d, gd);
                d = a + golden * (b - a);
                gd = self.gap(i, d, h);
            }
        }
        0.5 * (a + b)
    }

    /// The zero of a gap that is positive at `a` and negative at `b` (regula falsi, Illinois rule, safeguarded).
    fn root(&mut self, i: usize, mut a: f64, mut b: f64, h: f64) -> f64 {
        let resolution = (0.1 * SIMULTANEOUS * self.t.abs().max(1.0) / h).clamp(1e-15, 1e-3);
        let (mut ga, mut gb) = (self.gap(i, a, h), self.gap(i, b, h));
        if ga <= 0.0 {
            return a;
        }
        let mut side = 0;
        for iteration in 0..100 {
            if b - a <= resolution || gb == 0.0 {
                break;
            }
            let mut m = if iteration % 8 == 7 { 0.5 * (a + b) } else { b - gb * (b - a) / (gb - ga) };
            if !(m > a && m < b) {
                m = 0.5 * (a + b);
            }
            let gm = self.gap(i, m, h);
            if gm > 0.0 {
                (a, ga) = (m, gm);
                if side == 1 {
                    gb *= 0.5;
                }
                side = 1;
            } else {
                if b - m <= resolution * 0.5 && m - a > resolution {
                    // Creeping from the right: close in from the left as well.
                    let probe = m - resolution;
                    let gp = self.gap(i, probe, h);
                    if gp > 0.0 {
                        return m;
                    }
                    (b, gb) = (probe, gp);
                    continue;
                }
                (b, gb) = (m, gm);
                if side == -1 {
                    ga *= 0.5;
                }
                side = -1;
            }
        }
        b
    }

    /// Steps to the event of `switch` at fraction `theta` of the step `h`, and settles the modes there.
    pub(crate) fn event(
        &mut self,
        theta: f64,
        h: f64,
        switch: usize,
        trajectory: &mut Option<&mut Trajectory>,
    ) -> Result<(), StopReason> {
        let breaks = self.modes[switch] == Mode::Sticking;
        let mut length = theta * h;
        if length <= self.shortest() {
            self.failed.push(self.modes.clone());
        } else {
            let near = theta * (1.0 - 1e-3);
            let secant = (self.gap(switch, theta, h) - self.gap(switch, near, h)) / ((theta - near) * h);
            let mut solved = self.attempt_to_event(length);
            for _ in 0..3 {
                if !solved {
                    break;
                }
                let (gap, slope) = self.gap_at_end(switch, length, secant);
                let correction = -gap / slope;
                let next = length + correction;
                if !(slope < 0.0 && correction.abs() < 1e-2 * h && next > self.shortest())
                    || correction.abs() <= 0.01 * SIMULTANEOUS * self.t.abs().max(1.0)
                {
                    break;
                }
                length = next;
                solved = self.attempt_to_event(length);
            }
            if !solved {
                // The field ends before the event: approach it by shorter steps.
                self.h = 0.5 * length;
                return if self.h > self.shortest() { Ok(()) } else { self.unsolvable(trajectory) };
            }
            self.accept(length, trajectory);
        }
        self.gather(switch, breaks);
        self.count_event()?;
        let before = self.modes.clone();
        // What breaks loose does so without a jump of the field.
        let jump = if breaks { None } else { self.before_jump(switch) };
        self.settle(&before, trajectory)?;
        self.record_jump(jump);
        Ok(())
    }

    /// The gap at the end of the attempted step, and its slope there: of a sliding gap by the gradient, of a sticking one
    /// by the secant.
    fn gap_at_end(&mut self, switch: usize, length: f64, secant: f64) -> (f64, f64) {
        match self.modes[switch] {
            Mode::Sticking | Mode::Sliding => {
                let size = norm(&self.signs[6][self.multipliers.parts[switch].clone()]);
                (self.multipliers.reserve(switch, size), secant)
            }
            sliding => {
                let t = self.t + length;
                self.system.switching(t, &self.end, &mut self.sigma);
                self.multipliers.gradients(&mut self.system, t, &self.end);
                let c = self.multipliers.parts[switch].start;
                let rate = self.multipliers.rate(c, &self.k[6]);
                (sliding.sign() * self.sigma[c], sliding.sign() * rate)
            }
        }
    }

    /// All switches whose functions vanish now: the one of the event, those that stick, those within the resolution of
    /// time from zero.
    pub(crate) fn gather(&mut self, switch: usize, breaks: bool) {
        self.zero.clear();
        self.multipliers.gradients(&mut self.system, self.t, &self.x);
        self.system.switching(self.t, &self.x, &mut self.sigma);
        self.multipliers.s.copy_from_slice(&self.signs[0]);
        let window = SIMULTANEOUS * self.t.abs().max(1.0);
        for (i, &mode) in self.modes.iter().enumerate() {
            let part = self.multipliers.parts[i].clone();
            match mode {
                Mode::Sticking => {
                    let loose = i == switch && breaks || self.multipliers.reserve(i, self.multipliers.size(i)) < 0.0;
                    self.zero.push(i, self.multipliers.sliding_mode(i), loose);
                }
                Mode::Sliding => {
                    if i == switch || norm(&self.sigma[part]) <= self.arrival_size(i) {
                        self.zero.push(i, mode, false);
                    }
                }
                sliding => {
                    let rate = sliding.sign() * self.multipliers.rate(part.start, &self.k[0]);
                    let here = self.sigma[part.start].abs() <= self.negligible(i) + rate.abs() * window;
                    if i == switch || here {
                        let passes = i == switch || rate < 0.0;
                        self.zero.push(i, if passes { sliding.opposite() } else { sliding }, false);
                    }
                }
            }
        }
    }
}
