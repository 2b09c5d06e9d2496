//! Switching functions that depend on each other: what `vx = 0` and `vy = 0` say of `|(vx, vy)|`.

use super::surfaces::{Surfaces, divide, norm};
use bracketry_numerics::eigen::symmetric_eigen;
use nalgebra::DMatrix;

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

    /// Takes off the direction `s` of a unit vector what it cannot have while everything in the span stays: `vy = 0` leaves only
    /// `vx` to `(vx, vy)`. Where its rate vanishes, the rate does not tell.
    pub(crate) fn confine(&mut self, surfaces: &Surfaces, switch: usize, s: &mut [f64]) {
        let mut rows = Vec::new();
        let mut size = 0.0f64;
        for c in surfaces.parts[switch].clone() {
            let row = norm(surfaces.gradient(c)).hypot(surfaces.partial_t(c));
            size = size.max(row);
            self.contains(surfaces, c);
            rows.extend(self.rest.iter().map(|r| r * row));
        }
        let rows = DMatrix::from_row_slice(s.len(), self.rest.len(), &rows);
        let Some(free) = symmetric_eigen(&rows * rows.transpose()) else { return };
        for (square, normal) in free.eigenvalues.iter().zip(free.eigenvectors.column_iter()) {
            if *square <= (INDEPENDENT * size).powi(2) {
                let along: f64 = normal.iter().zip(&*s).map(|(n, s)| n * s).sum();
                s.iter_mut().zip(normal.iter()).for_each(|(s, n)| *s -= along * n);
            }
        }
    }
}
