//! Events of the exact flow: where they lie, and how modes and derivative change there.

use super::flow::{SIGN_TOLERANCE, Span, StickSlipFlow};
use bracketry_sim::{FrictionMode, ModeChange, Saltation};

/// How far a located σ may lie beyond zero.
const SURFACE_TOLERANCE: f64 = 1e-12;

impl StickSlipFlow {
    /// Smallest room that any switch has to its event at `x`, in units of its tolerance, and which it is. Negative beyond
    /// the event.
    fn room(&mut self, t: f64, x: &[f64], u: &[f64]) -> (f64, usize) {
        self.resolve(t, x, u);
        let mut least = (f64::INFINITY, usize::MAX);
        for i in 0..self.modes.len() {
            if self.held[i] {
                continue;
            }
            let room = match self.modes[i] {
                FrictionMode::Sticking => (1.0 - self.signs[i].abs()) / SIGN_TOLERANCE,
                mode => mode.sign() * self.field.surface(i) / SURFACE_TOLERANCE,
            };
            if room < least.0 {
                least = (room, i);
            }
        }
        least
    }

    /// Time after the start of the step and switch of the event within it, if `trial`, its end, lies beyond one.
    pub(super) fn first_event(&mut self, span: Span, x: &[f64], u: &[f64]) -> Option<(f64, usize)> {
        if self.modes.is_empty() {
            return None;
        }
        let end = std::mem::take(&mut self.trial);
        let at_end = self.room(span.t + span.h, &end, u);
        self.trial = end;
        if at_end.0 >= -1.0 {
            return None;
        }
        let (mut high, mut at_high, mut switch) = (span.h, at_end.0, at_end.1);
        // A switch that starts at its event (just broken loose, just stopped) has to be seen to move away from it first.
        let (mut low, mut at_low) = (0.0, self.room(span.t, x, u).0);
        for fraction in [1e-2, 1e-4, 1e-7] {
            if at_low > 1.0 {
                break;
            }
            (low, at_low) = (fraction * span.h, self.room_after(span.t, x, u, fraction * span.h).0);
            if at_low < -1.0 {
                (high, at_high) = (low, at_low);
                (low, at_low) = (0.0, 0.0);
            }
        }
        if at_low <= 1.0 {
            return Some((0.0, switch));
        }
        // Illinois variant of the false-position method.
        let mut side = 0;
        for _ in 0..80 {
            if high - low <= 1e-15 * span.h.max(1e-3) {
                break;
            }
            let at = (low * at_high - high * at_low) / (at_high - at_low);
            let at = if at > low && at < high { at } else { 0.5 * (low + high) };
            let (room, which) = self.room_after(span.t, x, u, at);
            if room.abs() <= 0.5 {
                return Some((at, which));
            }
            if room < 0.0 {
                (high, at_high, switch) = (at, room, which);
                if side == -1 {
                    at_low *= 0.5;
                }
                side = -1;
            } else {
                (low, at_low) = (at, room);
                if side == 1 {
                    at_high *= 0.5;
                }
                side = 1;
            }
        }
        Some((high, switch))
    }

    fn room_after(&mut self, t: f64, x: &[f64], u: &[f64], h: f64) -> (f64, usize) {
        self.step(Span { t, h }, x, u);
        let end = std::mem::take(&mut self.trial);
        let room = self.room(t + h, &end, u);
        self.trial = end;
        room
    }

    /// Changes modes at the event of `switch`, and the derivative with them.
    pub(super) fn cross(&mut self, t: f64, x: &[f64], u: &[f64], switch: usize, derive: bool) -> bool {
        self.resolve(t, x, u);
        self.jump.copy_from_slice(&self.f);
        let slid = self.modes[switch] != FrictionMode::Sticking;
        let rate = self.rates[switch];
        if derive && slid {
            self.field.differentiate(t, x, u, &self.signs);
            self.gradient.copy_from_slice(self.field.gradient_of(switch));
        }
        let mut old = std::mem::take(&mut self.modes_before);
        old.clone_from(&self.modes);
        let zero = self.stuck.iter().fold(1u64 << switch, |z, &i| z | 1 << i);
        self.modes[switch] = if slid { FrictionMode::Sticking } else { FrictionMode::of_sign(self.signs[switch]) };
        if slid && !self.field.sticks[switch] {
            self.modes[switch] = FrictionMode::of_sign(-old[switch].sign());
        }
        let settled = self.settle(t, x, u, zero);
        if derive && slid && rate != 0.0 {
            self.jump.iter_mut().zip(&self.f).for_each(|(before, after)| *before = after - *before);
            Saltation { jump: &self.jump, gradient: &self.gradient, rate }.apply(&mut self.s);
        }
        for (i, &from) in old.iter().enumerate() {
            if self.modes[i] != from {
                self.changes.push(ModeChange { t, switch: i, from, to: self.modes[i] });
            }
        }
        self.modes_before = old;
        settled
    }
}
