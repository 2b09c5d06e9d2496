//! A switched system in given modes: its field, with the signs and directions of the switches resolved.
//!
//! What slides has the sign ±1 or the direction `σ/|σ|`; what sticks has the `s_K` that solves `σ̇_K = 0` ([`Forces`]).

use super::dependence::Span;
use super::forces::{At, Forces};
use super::modes::FrictionMode;
use super::surfaces::{Surfaces, divide, norm};
use crate::Switched;
use bracketry_numerics::eigen::pseudo_inverse;
use nalgebra::DMatrix;

/// How far a sticking sign may pass 1 before the switch breaks loose: far above its rounding, far below notice.
const STICKING_EXCESS: f64 = 1e-11;

/// A system with the modes of its switches.
#[derive(Debug, Clone)]
pub(crate) struct Filippov<S: ?Sized> {
    pub(crate) surfaces: Surfaces,
    pub(crate) modes: Vec<FrictionMode>,
    /// Switches that have just left zero: their sign is known although `σ` is still rounding.
    pub(crate) departing: Vec<bool>,
    /// The signs and directions, `k`: ±1 or a unit vector where sliding, the solution where sticking.
    pub(crate) s: Vec<f64>,
    /// Static over sliding level of each switch.
    ratios: Vec<f64>,
    /// Unit vectors that slide along their σ.
    aimed: Vec<usize>,
    /// Unit vectors that slide in a direction that is kept, because σ has just left zero or is about to reach it.
    held: Vec<bool>,
    pub(crate) forces: Forces,
    /// Last, so that a field of any system is one of a system behind a pointer.
    pub(crate) system: S,
}

/// A field whose system is behind a pointer: what works with it is compiled once, not for each system again.
pub(crate) type Field<'s> = Filippov<dyn Switched + 's>;

impl<S: Switched> Filippov<S> {
    /// All switches stick until modes are given.
    pub(crate) fn new(system: S) -> Self {
        let surfaces = Surfaces::new(&system);
        let (n, k, switches) = (system.dim(), surfaces.sigma.len(), system.switches());
        let ratios: Vec<f64> = (0..switches).map(|i| system.static_ratio(i).max(1.0)).collect();
        Self {
            modes: vec![FrictionMode::Sticking; switches],
            departing: vec![false; switches],
            s: vec![1.0; k],
            aimed: Vec::new(),
            held: vec![false; switches],
            forces: Forces::new(n, &surfaces.parts, &ratios),
            ratios,
            surfaces,
            system,
        }
    }

    /// The same with the system behind a pointer.
    pub(crate) fn any(&mut self) -> &mut Field<'_> {
        self
    }
}

impl Field<'_> {
    /// The switches in a mode.
    pub(crate) fn in_mode(&self, mode: FrictionMode) -> impl Iterator<Item = usize> {
        self.modes.iter().enumerate().filter(move |(_, m)| **m == mode).map(|(i, _)| i)
    }

    /// The mode of a switch by its σ (the last evaluated), which vanishes or not.
    pub(crate) fn mode_of(&self, switch: usize, vanishes: bool) -> FrictionMode {
        match self.surfaces.parts[switch].start {
            _ if vanishes => FrictionMode::Sticking,
            _ if self.surfaces.is_vector(switch) => FrictionMode::Sliding,
            first => FrictionMode::of_sign(self.surfaces.sigma[first]),
        }
    }

    /// Modes by σ alone, at a point; those that vanish stick.
    pub(crate) fn guess_modes(&mut self, t: f64, x: &[f64]) {
        self.surfaces.evaluate(&mut self.system, t, x);
        for i in 0..self.modes.len() {
            self.departing[i] = false;
            self.modes[i] = self.mode_of(i, self.surfaces.size(i) == 0.0);
        }
    }

    /// Makes the signs those of the modes.
    pub(crate) fn apply_modes(&mut self) {
        let (parts, modes) = (&self.surfaces.parts, &self.modes);
        let sticking = parts.iter().zip(modes).filter(|(_, mode)| **mode == FrictionMode::Sticking);
        self.forces.hold(sticking.flat_map(|(part, _)| part.clone()));
        self.aimed.clear();
        for (i, mode) in self.modes.iter().enumerate() {
            let part = parts[i].clone();
            match mode {
                FrictionMode::Sticking => {
                    let excess = (norm(&self.s[part.clone()]) / self.ratios[i]).max(1.0);
                    divide(&mut self.s[part], excess);
                }
                _ if part.len() > 1 => self.aimed.push(i),
                sliding => self.s[part.start] = sliding.sign(),
            }
        }
    }

    /// How much further a sticking switch may be loaded before it breaks loose, with these signs.
    pub(crate) fn reserve(&self, switch: usize, signs: &[f64]) -> f64 {
        self.ratios[switch] + STICKING_EXCESS - norm(&signs[self.surfaces.parts[switch].clone()])
    }

    /// Whether a switch needs more than what may hold it.
    pub(crate) fn is_overloaded(&self, switch: usize) -> bool {
        self.reserve(switch, &self.s) < 0.0
    }

    /// The sliding mode that a switch takes when it breaks loose with its present sign or direction.
    pub(crate) fn sliding_mode(&self, switch: usize) -> FrictionMode {
        if self.surfaces.is_vector(switch) {
            FrictionMode::Sliding
        } else {
            FrictionMode::of_sign(self.s[self.surfaces.parts[switch].start])
        }
    }

    /// Keeps the directions of the unit vectors that have just left zero.
    pub(crate) fn hold_departing(&mut self) {
        for (i, held) in self.held.iter_mut().enumerate() {
            *held = self.departing[i] && self.modes[i] == FrictionMode::Sliding;
        }
    }

    /// The sliding unit vectors that are at zero where `switch` arrives there, by the last σ and gradients: those that are near, and those
    /// that depend on it.
    pub(crate) fn arriving_with(&self, switch: usize, x: &[f64], atol: f64) -> Vec<usize> {
        let surfaces = &self.surfaces;
        let mut span = Span::default();
        surfaces.parts[switch].clone().for_each(|c| _ = span.add(surfaces, c));
        let mut arrives = |i: usize| {
            surfaces.size(i) <= surfaces.arrival_size(i, x, atol)
                || surfaces.may_follow(i, x, atol) && span.contains_switch(surfaces, i)
        };
        self.in_mode(FrictionMode::Sliding).filter(|&i| arrives(i)).collect()
    }

    /// Keeps the directions of some unit vectors, which otherwise follow σ.
    pub(crate) fn hold_directions(&mut self, switches: impl IntoIterator<Item = usize>) {
        switches.into_iter().for_each(|i| self.held[i] = true);
    }

    /// Keeps the directions that slide at given values, scaled to unit length.
    pub(crate) fn set_directions(&mut self, directions: &[f64]) {
        for &i in &self.aimed {
            self.held[i] = true;
            let part = self.surfaces.parts[i].clone();
            let size = norm(&directions[part.clone()]);
            for c in part {
                self.s[c] = directions[c] / size;
            }
        }
    }

    /// Lets all directions follow σ again.
    pub(crate) fn release_directions(&mut self) {
        self.held.fill(false);
    }

    /// Points the directions that are not held along σ; where σ is exactly zero they stay.
    fn aim(&mut self, t: f64, x: &[f64]) {
        if self.aimed.iter().all(|&i| self.held[i]) {
            return;
        }
        self.surfaces.evaluate(&mut self.system, t, x);
        for &i in &self.aimed {
            let size = self.surfaces.size(i);
            if !self.held[i] && size != 0.0 {
                for c in self.surfaces.parts[i].clone() {
                    self.s[c] = self.surfaces.sigma[c] / size;
                }
            }
        }
    }

    /// Writes `f(t, x, s)` with the sticking signs solved for; false if there is no solution (or nothing finite).
    pub(crate) fn evaluate(&mut self, (t, x): (f64, &[f64]), dx: &mut [f64]) -> bool {
        self.aim(t, x);
        if self.forces.sticking.is_empty() {
            self.system.rhs(t, x, &self.s, dx);
            self.forces.evaluations += 1;
            return true;
        }
        self.surfaces.differentiate(&mut self.system, t, x);
        let mut at = At { system: &mut self.system, surfaces: &self.surfaces, t, x };
        self.forces.solve(&mut at, &mut self.s, dx)
    }

    /// Whether the right-hand side at a point, with some signs, is finite; where it is not, no mode fits.
    pub(crate) fn is_finite(&mut self, t: f64, x: &[f64]) -> bool {
        let (mut signs, mut dx) = (vec![0.0; self.s.len()], vec![0.0; x.len()]);
        for (part, mode) in self.surfaces.parts.iter().zip(&self.modes) {
            signs[part.start] = mode.sign();
        }
        self.system.rhs(t, x, &signs, &mut dx);
        dx.iter().all(|v| v.is_finite())
    }

    /// Forgets signs and forces, which may not be finite.
    pub(crate) fn reset(&mut self) {
        self.s.fill(0.0);
        self.forces.forget();
    }

    /// For a sliding unit vector at a point with velocity `dx`: the rate `s·σ̇` of `|σ|`, by the gradients of the last point.
    pub(crate) fn radial_rate(&self, switch: usize, dx: &[f64]) -> f64 {
        self.surfaces.parts[switch].clone().map(|c| self.s[c] * self.surfaces.rate(c, dx)).sum()
    }

    /// `∂σ̇/∂s` for some components, by unit differences; what sticks gives way as it would. `dx` becomes the field.
    pub(crate) fn influence(
        &mut self,
        (t, x): (f64, &[f64]),
        components: &[usize],
        dx: &mut [f64],
    ) -> Option<DMatrix<f64>> {
        let k = components.len();
        let mut jacobian = DMatrix::zeros(k, k);
        if !self.evaluate((t, x), dx) {
            return None;
        }
        self.surfaces.differentiate(&mut self.system, t, x);
        let before: Vec<f64> = components.iter().map(|&c| self.surfaces.rate(c, dx)).collect();
        let mut velocity = dx.to_vec();
        for (b, &d) in components.iter().enumerate() {
            let s = self.s[d];
            let step = if s > 0.0 { -1.0 } else { 1.0 };
            self.s[d] = s + step;
            let solved = self.evaluate((t, x), &mut velocity);
            self.s[d] = s;
            if !solved {
                return None;
            }
            for (a, &c) in components.iter().enumerate() {
                jacobian[(a, b)] = (self.surfaces.rate(c, &velocity) - before[a]) / step;
            }
        }
        jacobian.iter().all(|v: &f64| v.is_finite()).then_some(jacobian)
    }

    /// [`Filippov::influence`] of the unit vectors that slide, for the signs and directions `s`.
    pub(crate) fn influence_of_directions(&mut self, point: (f64, &[f64]), s: &[f64]) -> Option<DMatrix<f64>> {
        let sliding: Vec<usize> = self.in_mode(FrictionMode::Sliding).collect();
        let components: Vec<usize> = sliding.iter().flat_map(|&i| self.surfaces.parts[i].clone()).collect();
        self.s.copy_from_slice(s);
        self.hold_directions(sliding);
        let influence = self.influence(point, &components, &mut vec![0.0; point.1.len()]);
        self.release_directions();
        influence
    }

    /// Moves `x` by the least change to `σ_K(t, x) = 0`, so that what sticks does not creep.
    pub(crate) fn project(&mut self, t: f64, x: &mut [f64]) {
        if self.forces.sticking.is_empty() {
            return;
        }
        for _ in 0..3 {
            self.surfaces.evaluate(&mut self.system, t, x);
            if self.forces.sticking.iter().all(|&i| self.surfaces.sigma[i] == 0.0) {
                return;
            }
            self.surfaces.differentiate(&mut self.system, t, x);
            let independent;
            let sticking = if self.forces.redundant {
                // Those that depend on others vanish with them.
                let mut span = Span::default();
                let add = |&c: &usize| span.add(&self.surfaces, c);
                independent = self.forces.sticking.iter().copied().filter(add).collect::<Vec<usize>>();
                &independent
            } else {
                &self.forces.sticking
            };
            let m = sticking.len();
            let row = |a: usize| self.surfaces.gradient(sticking[a]);
            let dot = |a: usize, b: usize| -> f64 { row(a).iter().zip(row(b)).map(|(p, q)| p * q).sum() };
            let sigma = |a: usize| self.surfaces.sigma[sticking[a]];
            let mut shift = |a: usize, gain: f64| x.iter_mut().zip(row(a)).for_each(|(x, g)| *x -= gain * g);
            if m == 1 {
                let gain = sigma(0) / dot(0, 0);
                if !gain.is_finite() {
                    return;
                }
                shift(0, gain);
                continue;
            }
            let gram = DMatrix::from_fn(m, m, dot);
            let size = gram.amax();
            let Some(inverse) = pseudo_inverse(&gram, 1e-12 * size) else {
                return;
            };
            for a in 0..m {
                shift(a, (0..m).map(|b| inverse[(a, b)] * sigma(b)).sum());
            }
        }
    }
}
