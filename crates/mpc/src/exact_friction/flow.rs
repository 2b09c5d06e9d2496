//! The exact flow of stick–slip dynamics over an interval, and its derivative across events.
//!
//! Between events the classical Runge–Kutta method of order 4 integrates the field with fixed signs; where a switching
//! function stays zero, its sign solves σ̇ = 0 (Filippov). An event is a sliding σ that reaches zero or a sticking sign that
//! leaves [−1, 1]. The derivative S of the state with respect to start and input jumps where the field does (saltation):
//! S⁺ = S⁻ + (f⁻ − f⁺)·∂τ, ∂τ = −∇σ·S⁻/σ̇⁻; see Leine and Nijmeijer 2004. On a sticking surface ∇σ·S = 0: what sticks forgets
//! how it came there.

use super::switched_field::SwitchedField;
use crate::integrator::Interval;
use bracketry_numerics::dense::Lu;
use bracketry_sim::{FrictionMode, ModeChange};

/// A switching function this small is zero: its sign is chosen, not read.
const ZERO: f64 = 1e-9;
/// How far a sticking sign may lie beyond ±1.
pub(super) const SIGN_TOLERANCE: f64 = 1e-9;
/// Most events within one interval; beyond it the switches chatter.
const MAX_EVENTS: usize = 60;

/// Where the integration stands in an interval.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub(super) t: f64,
    pub(super) h: f64,
}

/// Exact flow with its working memory.
#[derive(Clone)]
pub(crate) struct StickSlipFlow {
    pub(crate) field: SwitchedField,
    pub(super) modes: Vec<FrictionMode>,
    pub(super) signs: Vec<f64>,
    /// Switches whose sign is kept whatever their σ does.
    pub(super) held: Vec<bool>,
    pub(super) stuck: Vec<usize>,
    /// x', σ̇ at the resolved signs.
    pub(super) f: Vec<f64>,
    pub(super) rates: Vec<f64>,
    stage: Vec<f64>,
    pub(super) trial: Vec<f64>,
    k: [Vec<f64>; 4],
    d: [Vec<f64>; 4],
    pub(super) s: Vec<f64>,
    moved: Vec<f64>,
    factors: Lu,
    right: Vec<f64>,
    /// The field before an event, then its jump there.
    pub(super) jump: Vec<f64>,
    /// ∇σ of the switch at an event.
    pub(super) gradient: Vec<f64>,
    pub(super) modes_before: Vec<FrictionMode>,
    /// Modes and signs at the start of the last interval, and ∂s/∂(x, u) of those that stick (k rows of n + m).
    pub(crate) start_modes: Vec<FrictionMode>,
    pub(crate) start_signs: Vec<f64>,
    pub(crate) start_rows: Vec<f64>,
    /// Changes of mode within the last interval.
    pub(crate) changes: Vec<ModeChange>,
}

const FRACTION: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHT: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

impl StickSlipFlow {
    pub(crate) fn new(field: SwitchedField) -> Self {
        let (n, m, k) = (field.states, field.inputs, field.switches);
        let w = n + m;
        let row = || vec![0.0; n];
        let block = || vec![0.0; n * w];
        Self {
            modes: vec![FrictionMode::Sticking; k],
            signs: vec![0.0; k],
            held: vec![false; k],
            stuck: Vec::with_capacity(k),
            f: row(),
            rates: vec![0.0; k],
            stage: row(),
            trial: row(),
            k: [row(), row(), row(), row()],
            d: [block(), block(), block(), block()],
            s: block(),
            moved: block(),
            factors: Lu::default(),
            right: vec![0.0; k * w.max(1)],
            jump: row(),
            gradient: row(),
            modes_before: Vec::with_capacity(k),
            start_modes: vec![FrictionMode::Sticking; k],
            start_signs: vec![0.0; k],
            start_rows: vec![0.0; k * w],
            changes: Vec::new(),
            field,
        }
    }

    /// Advances `x` over the interval in its steps and more at events; `jacobian` receives the derivative of the end state with
    /// respect to (x, u), n rows of n + m. `hold` keeps the signs of some switches, whatever their σ do (empty: none). False
    /// where no mode is consistent or the switches chatter.
    pub(crate) fn advance(
        &mut self,
        interval: Interval<'_>,
        x: &mut [f64],
        jacobian: Option<&mut [f64]>,
        hold: &[Option<FrictionMode>],
    ) -> bool {
        let Interval { t, dt, substeps, u } = interval;
        let (n, m) = (self.field.states, self.field.inputs);
        let w = n + m;
        let derive = jacobian.is_some();
        self.changes.clear();
        if x.iter().chain(u).any(|v| !v.is_finite()) || !self.start(t, x, u, hold) {
            x.fill(f64::NAN);
            return false;
        }
        if derive {
            self.s.fill(0.0);
            self.s.iter_mut().step_by(w + 1).for_each(|v| *v = 1.0);
            self.start_derivative(t, x, u);
        }
        // The method of order 4 is stable up to 2.78 on the negative real axis.
        let rate = self.field.relaxation_rate(t, x, u, &self.signs);
        let longest = dt / (substeps as f64).max((0.5 * dt * rate).ceil().min(1e4));
        let mut done = 0.0;
        let mut events = 0;
        while done < dt * (1.0 - 1e-14) {
            let left = dt - done;
            let h = left / (left / longest - 1e-9).ceil().max(1.0);
            let span = Span { t: t + done, h };
            self.step(span, x, u);
            let event = self.first_event(span, x, u);
            let h = event.as_ref().map_or(h, |e| e.0);
            if h > 0.0 {
                let span = Span { t: t + done, h };
                if derive {
                    self.step_with_sensitivity(span, x, u);
                } else if event.is_some() {
                    self.step(span, x, u);
                }
                x.copy_from_slice(&self.trial);
                done += h;
            }
            if x.iter().any(|v| !v.is_finite()) {
                return false;
            }
            if let Some((_, switch)) = event {
                events += 1;
                if events > MAX_EVENTS || !self.cross(t + done, x, u, switch, derive) {
                    x.fill(f64::NAN);
                    return false;
                }
            }
            self.project(t + done, x, u);
        }
        if let Some(j) = jacobian {
            j.copy_from_slice(&self.s);
        }
        true
    }

    /// Reads the modes off the state; what is zero is settled by its consistent signs.
    fn start(&mut self, t: f64, x: &mut [f64], u: &[f64], hold: &[Option<FrictionMode>]) -> bool {
        self.held.fill(false);
        self.field.evaluate(t, x, u, &self.signs);
        for i in 0..self.modes.len() {
            let sigma = self.field.surface(i);
            self.modes[i] = if sigma.abs() > ZERO { FrictionMode::of_sign(sigma) } else { FrictionMode::Sticking };
        }
        for (i, mode) in hold.iter().enumerate() {
            if let Some(mode) = *mode {
                self.held[i] = true;
                self.modes[i] = mode;
            }
        }
        let zero: u64 = (0..self.modes.len())
            .filter(|&i| self.modes[i] == FrictionMode::Sticking && !self.held[i])
            .fold(0, |z, i| z | 1 << i);
        if !self.settle(t, x, u, zero) {
            return false;
        }
        self.project(t, x, u);
        self.start_modes.copy_from_slice(&self.modes);
        self.start_signs.copy_from_slice(&self.signs);
        true
    }

    /// Finds consistent modes for the switches in `zero` (a bit set), from the modes they have as a guess: an active-set
    /// search, then every combination.
    pub(super) fn settle(&mut self, t: f64, x: &[f64], u: &[f64], zero: u64) -> bool {
        let members: Vec<usize> = (0..self.modes.len()).filter(|i| zero >> i & 1 == 1).collect();
        for &i in &members {
            if !self.field.sticks[i] && self.modes[i] == FrictionMode::Sticking {
                self.modes[i] = FrictionMode::Positive;
            }
        }
        for _ in 0..=4 * members.len() {
            self.resolve(t, x, u);
            let worst = members
                .iter()
                .map(|&i| (self.inconsistency(i), i))
                .fold((0.0, usize::MAX), |a, b| if b.0 > a.0 { b } else { a });
            if worst.1 == usize::MAX {
                return true;
            }
            let i = worst.1;
            self.modes[i] = match self.modes[i] {
                FrictionMode::Sticking => FrictionMode::of_sign(self.signs[i]),
                _ if self.field.sticks[i] => FrictionMode::Sticking,
                slides => slides.opposite(),
            };
        }
        if members.len() > 8 {
            return false;
        }
        for code in 0..3usize.pow(members.len() as u32) {
            let mut rest = code;
            for &i in &members {
                self.modes[i] = [FrictionMode::Sticking, FrictionMode::Positive, FrictionMode::Negative][rest % 3];
                rest /= 3;
            }
            if members.iter().any(|&i| self.modes[i] == FrictionMode::Sticking && !self.field.sticks[i]) {
                continue;
            }
            self.resolve(t, x, u);
            if members.iter().all(|&i| self.inconsistency(i) <= 0.0) {
                return true;
            }
        }
        false
    }

    /// How far the mode of a switch with σ = 0 contradicts its sign or its rate; 0 if it does not.
    fn inconsistency(&self, i: usize) -> f64 {
        match self.modes[i] {
            // A surface that cannot be held (no friction force) has a residual rate.
            FrictionMode::Sticking if self.rates[i].abs() > 1e-6 * (1.0 + self.rates[i].abs()) => f64::MAX,
            FrictionMode::Sticking => self.signs[i].abs() - 1.0 - SIGN_TOLERANCE,
            mode => -mode.sign() * self.rates[i] - 1e-9,
        }
        .max(0.0)
    }

    /// Field and rates at the signs of the current modes; sticking signs are solved for.
    pub(super) fn resolve(&mut self, t: f64, x: &[f64], u: &[f64]) {
        self.stuck.clear();
        for (i, mode) in self.modes.iter().enumerate() {
            if *mode == FrictionMode::Sticking {
                self.stuck.push(i);
            } else {
                self.signs[i] = mode.sign();
            }
        }
        let z = self.stuck.len();
        for _ in 0..8 {
            self.field.evaluate(t, x, u, &self.signs);
            self.f.copy_from_slice(self.field.field());
            for i in 0..self.rates.len() {
                self.rates[i] = self.field.rate(i);
            }
            let residual = self.stuck.iter().fold(0.0_f64, |r, &i| r.max(self.rates[i].abs()));
            if z == 0 || residual == 0.0 {
                return;
            }
            for (a, &i) in self.stuck.iter().enumerate() {
                self.right[a] = -self.rates[i];
            }
            if !self.solve_for_signs(1) {
                return;
            }
            let mut change = 0.0_f64;
            for (a, &i) in self.stuck.iter().enumerate() {
                self.signs[i] += self.right[a];
                change = change.max(self.right[a].abs());
            }
            if self.field.affine {
                for (a, &i) in self.stuck.iter().enumerate() {
                    for j in 0..self.f.len() {
                        self.f[j] += self.field.field_by_sign(j, i) * self.right[a];
                    }
                    for j in 0..self.rates.len() {
                        self.rates[j] += self.field.rate_by_sign(j, i) * self.right[a];
                    }
                }
                return;
            }
            if change < 1e-13 {
                return;
            }
        }
    }

    /// One step of the integrator from `x` into `trial`.
    pub(super) fn step(&mut self, span: Span, x: &[f64], u: &[f64]) {
        for q in 0..4 {
            let c = FRACTION[q] * span.h;
            for i in 0..x.len() {
                self.stage[i] = if q == 0 { x[i] } else { x[i] + c * self.k[q - 1][i] };
            }
            let stage = std::mem::take(&mut self.stage);
            self.resolve(span.t + c, &stage, u);
            self.stage = stage;
            self.k[q].copy_from_slice(&self.f);
        }
        for i in 0..x.len() {
            self.trial[i] = x[i] + span.h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
        }
    }

    /// As [`StickSlipFlow::step`], and the derivative is propagated.
    fn step_with_sensitivity(&mut self, span: Span, x: &[f64], u: &[f64]) {
        let n = x.len();
        let w = n + u.len();
        for q in 0..4 {
            let c = FRACTION[q] * span.h;
            for i in 0..n {
                self.stage[i] = if q == 0 { x[i] } else { x[i] + c * self.k[q - 1][i] };
            }
            for e in 0..n * w {
                self.moved[e] = if q == 0 { self.s[e] } else { self.s[e] + c * self.d[q - 1][e] };
            }
            let stage = std::mem::take(&mut self.stage);
            self.resolve(span.t + c, &stage, u);
            self.k[q].copy_from_slice(&self.f);
            self.field.differentiate(span.t + c, &stage, u, &self.signs);
            self.stage = stage;
            let mut d = std::mem::take(&mut self.d[q]);
            along(&self.field.field_pattern, self.field.field_entries(), &self.moved, n, w, &mut d);
            self.add_sign_derivative(w, &mut d);
            self.d[q] = d;
        }
        for i in 0..n {
            self.trial[i] = x[i] + span.h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
        }
        for e in 0..n * w {
            self.s[e] += span.h * (0..4).map(|q| WEIGHT[q] * self.d[q][e]).sum::<f64>();
        }
    }

    /// Overwrites the first rows of `right`, one of `columns` entries for every sticking switch, by (∂σ̇/∂s)⁻¹ times them.
    /// False where no force holds.
    fn solve_for_signs(&mut self, columns: usize) -> bool {
        let z = self.stuck.len();
        let matrix = self.factors.matrix(z);
        for (a, &i) in self.stuck.iter().enumerate() {
            for (b, &j) in self.stuck.iter().enumerate() {
                matrix[a * z + b] = self.field.rate_by_sign(i, j);
            }
        }
        let regular = self.factors.factorize();
        if regular {
            self.factors.solve(&mut self.right[..z * columns], columns);
        }
        regular
    }

    /// Derivative of the sticking signs along `moved` into `right` (rows in the order of `stuck`); false if it does not exist.
    fn sign_derivative(&mut self, w: usize) -> bool {
        let (n, z) = (self.f.len(), self.stuck.len());
        for a in 0..z {
            self.right[a * w..(a + 1) * w].fill(0.0);
        }
        for (&(i, j), &g) in self.field.rate_pattern.iter().zip(self.field.rate_entries()) {
            let Some(a) = self.stuck.iter().position(|&s| s == i) else { continue };
            if j >= n {
                self.right[a * w + j] -= g;
            } else {
                for c in 0..w {
                    self.right[a * w + c] -= g * self.moved[j * w + c];
                }
            }
        }
        self.solve_for_signs(w)
    }

    fn add_sign_derivative(&mut self, w: usize, d: &mut [f64]) {
        if self.stuck.is_empty() || !self.sign_derivative(w) {
            return;
        }
        for (a, &i) in self.stuck.iter().enumerate() {
            for j in 0..self.f.len() {
                let by = self.field.field_by_sign(j, i);
                if by != 0.0 {
                    for c in 0..w {
                        d[j * w + c] += by * self.right[a * w + c];
                    }
                }
            }
        }
    }

    /// What sticks at the start forgets the σ it came with, whichever side a neighboring start lies on:
    /// S = I − f_s (σ̇_s)⁻¹ ∇σ. The derivative of the sticking signs is kept for the controller.
    fn start_derivative(&mut self, t: f64, x: &[f64], u: &[f64]) {
        let (n, z) = (x.len(), self.stuck.len());
        let w = n + u.len();
        self.start_rows.fill(0.0);
        if z == 0 {
            return;
        }
        self.field.differentiate(t, x, u, &self.signs);
        self.moved.copy_from_slice(&self.s);
        if self.sign_derivative(w) {
            for (a, &i) in self.stuck.iter().enumerate() {
                self.start_rows[i * w..(i + 1) * w].copy_from_slice(&self.right[a * w..(a + 1) * w]);
            }
        }
        for (a, &i) in self.stuck.iter().enumerate() {
            for j in 0..n {
                self.right[a * n + j] = self.field.gradient(i, j);
            }
        }
        if self.solve_for_signs(n) {
            for (a, &i) in self.stuck.iter().enumerate() {
                for r in 0..n {
                    let by = self.field.field_by_sign(r, i);
                    for j in 0..n {
                        self.s[r * w + j] -= by * self.right[a * n + j];
                    }
                }
            }
        }
    }

    /// Brings what sticks back onto σ = 0 along the directions of its force.
    fn project(&mut self, t: f64, x: &mut [f64], u: &[f64]) {
        self.resolve(t, x, u);
        let z = self.stuck.len();
        if z == 0 {
            return;
        }
        for (a, &i) in self.stuck.iter().enumerate() {
            self.right[a] = self.field.surface(i);
        }
        if self.solve_for_signs(1) {
            for (a, &i) in self.stuck.iter().enumerate() {
                for j in 0..x.len() {
                    x[j] -= self.field.field_by_sign(j, i) * self.right[a];
                }
            }
        }
    }
}

/// d = A·moved + \[0 B\] for the entries of (A B).
fn along(pattern: &[(usize, usize)], entries: &[f64], moved: &[f64], n: usize, w: usize, d: &mut [f64]) {
    d.fill(0.0);
    for (&(i, j), &a) in pattern.iter().zip(entries) {
        if j >= n {
            d[i * w + j] += a;
        } else {
            for c in 0..w {
                d[i * w + c] += a * moved[j * w + c];
            }
        }
    }
}
