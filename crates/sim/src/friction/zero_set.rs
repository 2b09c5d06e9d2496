//! The switches whose functions vanish together.

use super::dependence::Span;
use super::filippov::Field;
use super::modes::FrictionMode;

/// Events closer than this (times the time, from 1 s on) are one.
pub(crate) const SIMULTANEOUS: f64 = 1e-12;

/// A switch whose function vanishes, with what is known of it.
#[derive(Debug, Clone)]
pub(crate) struct Zero {
    pub(crate) switch: usize,
    /// The sliding mode to try first: the side to which it passes or breaks loose.
    pub(crate) preferred: FrictionMode,
    /// Whether sticking is known to have ended.
    pub(crate) loose: bool,
}

/// All of them at one instant.
#[derive(Debug, Clone, Default)]
pub(crate) struct ZeroSet {
    pub(crate) entries: Vec<Zero>,
}

impl ZeroSet {
    pub(crate) fn switches(&self) -> Vec<usize> {
        self.entries.iter().map(|entry| entry.switch).collect()
    }

    fn push(&mut self, switch: usize, preferred: FrictionMode, loose: bool) {
        self.entries.push(Zero { switch, preferred, loose });
    }

    /// At the start of a segment at `(t, x)`: what sticks and has not moved off, what is leaving, and what is within rounding.
    /// All others get the mode of their σ. `atol` is the absolute tolerance of the states. False where σ is not finite.
    pub(crate) fn at_start(&mut self, field: &mut Field<'_>, (t, x): (f64, &[f64]), atol: f64) -> bool {
        field.surfaces.evaluate(&mut field.system, t, x);
        if !field.surfaces.sigma.iter().all(|v| v.is_finite()) {
            return false;
        }
        field.surfaces.differentiate(&mut field.system, t, x);
        self.entries.clear();
        for i in 0..field.modes.len() {
            let surfaces = &field.surfaces;
            let tiny =
                if surfaces.is_vector(i) { surfaces.arrival_size(i, x, atol) } else { surfaces.negligible(i, x, atol) };
            let sigma = surfaces.size(i);
            match field.modes[i] {
                FrictionMode::Sticking if sigma <= 1e5 * surfaces.rounding(i, x) + tiny => {
                    self.push(i, field.sliding_mode(i), false);
                }
                sliding if sliding != FrictionMode::Sticking && (field.departing[i] || sigma <= tiny) => {
                    self.push(i, sliding, false);
                }
                _ => field.modes[i] = field.mode_of(i, false),
            }
        }
        self.complete(field, x, atol);
        true
    }

    /// At an event of `switch` at `(t, x)`, with the field `dx` and the signs there: this one, which `breaks` loose or reaches
    /// zero, those that stick, and those within the resolution of time from zero.
    pub(crate) fn at_event(
        &mut self,
        field: &mut Field<'_>,
        (t, x): (f64, &[f64]),
        (dx, signs): (&[f64], &[f64]),
        (switch, breaks): (usize, bool),
        atol: f64,
    ) {
        self.entries.clear();
        field.surfaces.differentiate(&mut field.system, t, x);
        field.surfaces.evaluate(&mut field.system, t, x);
        field.s.copy_from_slice(signs);
        let window = SIMULTANEOUS * t.abs().max(1.0);
        let surfaces = &field.surfaces;
        for (i, &mode) in field.modes.iter().enumerate() {
            match mode {
                FrictionMode::Sticking => {
                    let loose = i == switch && breaks || field.is_overloaded(i);
                    self.push(i, field.sliding_mode(i), loose);
                }
                FrictionMode::Sliding => {
                    if i == switch || surfaces.size(i) <= surfaces.arrival_size(i, x, atol) {
                        self.push(i, mode, false);
                    }
                }
                sliding => {
                    let c = surfaces.parts[i].start;
                    let rate = sliding.sign() * surfaces.rate(c, dx);
                    let here = surfaces.sigma[c].abs() <= surfaces.negligible(i, x, atol) + rate.abs() * window;
                    if i == switch || here {
                        let passes = i == switch || rate < 0.0;
                        self.push(i, if passes { sliding.opposite() } else { sliding }, false);
                    }
                }
            }
        }
        self.complete(field, x, atol);
    }

    /// Takes in what vanishes with the others because it depends on them. Its own rounding does not tell: a unit vector has
    /// arrived well before its components are that small.
    fn complete(&mut self, field: &Field<'_>, x: &[f64], atol: f64) {
        if self.entries.is_empty() || self.entries.len() == field.modes.len() {
            return;
        }
        let surfaces = &field.surfaces;
        let mut span: Option<Span> = None;
        for (i, &mode) in field.modes.iter().enumerate() {
            if self.entries.iter().any(|entry| entry.switch == i)
                || !field.system.sticks(i)
                || !surfaces.may_follow(i, x, atol)
            {
                continue;
            }
            let span = span.get_or_insert_with(|| {
                let mut span = Span::default();
                for c in self.entries.iter().flat_map(|entry| surfaces.parts[entry.switch].clone()) {
                    span.add(surfaces, c);
                }
                span
            });
            if span.contains_switch(surfaces, i) {
                self.push(i, mode, false);
            }
        }
    }

    /// Where the present modes have no solution at `(t, x)`: what sticks, what is leaving, and what has not left zero at all.
    pub(crate) fn of_unsolvable(&mut self, field: &mut Field<'_>, (t, x): (f64, &[f64])) {
        self.entries.clear();
        field.surfaces.evaluate(&mut field.system, t, x);
        for (i, mode) in field.modes.iter().enumerate() {
            let stays = field.surfaces.size(i) == 0.0 && field.system.sticks(i);
            if *mode == FrictionMode::Sticking || *mode == FrictionMode::Sliding && field.departing[i] || stays {
                self.push(i, field.sliding_mode(i), false);
            }
        }
    }
}
