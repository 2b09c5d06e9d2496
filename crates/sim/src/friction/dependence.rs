//! Switching functions that depend on each other: what `vx = 0` and `vy = 0` say of `|(vx, vy)|`.

use super::surfaces::{Surfaces, divide, norm};

/// What is left of a gradient of unit length across the others that means a direction of its own.
const INDEPENDENT: f64 = 1e-8;

/// What some switching functions span by their derivatives by state and time, as an orthonormal basis.
#[derive(Debug, Clone, Default)]
pub(crate) struct Span {
    /// Vectors one after the other.
    basis: Vec<f64>,
    rest: Vec<f64>,
}

impl Span {
    pub(crate) fn clear(&mut self) {
        self.basis.clear();
    }

    /// Whether the rate of the component `c` follows from those in the span, by the gradients of the last point. One that has no
    /// gradient there follows from none: its rate says nothing of where it goes.
    pub(crate) fn contains(&mut self, surfaces: &Surfaces, c: usize) -> bool {
        self.rest.clear();
        self.rest.extend_from_slice(surfaces.gradient(c));
        self.rest.push(surfaces.partial_t(c));
        let size = norm(&self.rest);
        if size == 0.0 {
            return false;
        }
        divide(&mut self.rest, size);
        // Twice, for orthogonality to rounding.
        for _ in 0..2 {
            for known in self.basis.chunks_exact(self.rest.len()) {
                let along: f64 = self.rest.iter().zip(known).map(|(r, k)| r * k).sum();
                self.rest.iter_mut().zip(known).for_each(|(r, k)| *r -= along * k);
            }
        }
        norm(&self.rest) <= INDEPENDENT
    }

    /// Takes in the component `c`; whether it was independent.
    pub(crate) fn add(&mut self, surfaces: &Surfaces, c: usize) -> bool {
        if self.contains(surfaces, c) {
            return false;
        }
        let size = norm(&self.rest);
        if size > 0.0 {
            divide(&mut self.rest, size);
            self.basis.extend_from_slice(&self.rest);
        }
        true
    }

    /// Whether the rates of all components of a switch follow from those in the span.
    pub(crate) fn contains_switch(&mut self, surfaces: &Surfaces, switch: usize) -> bool {
        surfaces.parts[switch].clone().all(|c| self.contains(surfaces, c))
    }
}
