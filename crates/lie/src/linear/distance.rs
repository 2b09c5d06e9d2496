//! How far a pair (A, B) is from losing controllability.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use bracketry_numerics::eigen::smallest_singular_value;
use nalgebra::{Complex, DMatrix};
use serde::Serialize;

/// Bounds of a distance, and where it is small.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distance {
    /// The distance is not smaller.
    pub lower: f64,
    /// The distance is not larger; a perturbation of this size is known.
    pub upper: f64,
    /// The eigenvalue that becomes uncontrollable under that perturbation, real and imaginary part.
    pub at: (f64, f64),
}

/// Singular value decompositions for pairs of up to ten states; fewer for larger ones.
const MAX_DECOMPOSITIONS: usize = 3000;

/// Relative gap between the bounds at which the search ends.
const GAP: f64 = 1e-3;

struct Cell {
    lower: f64,
    center: [f64; 2],
    half: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        other.lower.total_cmp(&self.lower)
    }
}

/// min over complex λ of σ_min[A − λ, B], the norm of the smallest perturbation of A and B that makes the pair
/// uncontrollable (Eising 1984). The singular value changes by no more than λ does, so that its value in the middle of a
/// square bounds it on the square: squares are divided until the bounds meet, the number of decompositions is used up, or
/// `stopped` says so. `None` where a decomposition does not converge.
pub(crate) fn distance(a: &DMatrix<f64>, b: &DMatrix<f64>, stopped: &dyn Fn() -> bool) -> Option<Distance> {
    let (n, m) = (a.nrows(), b.ncols());
    if n == 0 {
        return None;
    }
    let sigma = |z: [f64; 2]| -> Option<f64> {
        let pencil = DMatrix::from_fn(n, n + m, |i, j| {
            let entry = if j < n { a[(i, j)] } else { b[(i, j - n)] };
            let shift = if i == j { Complex::new(z[0], z[1]) } else { Complex::from(0.0) };
            Complex::from(entry) - shift
        });
        smallest_singular_value(pencil)
    };
    // Beyond ‖A‖ + σ(0) the value is larger than at 0, and it is the same at conjugate numbers.
    let start = sigma([0.0, 0.0])?;
    let mut best = Distance { lower: 0.0, upper: start, at: (0.0, 0.0) };
    let radius = a.norm() + start;
    let mut heap = BinaryHeap::new();
    let mut used = 0;
    let most = (MAX_DECOMPOSITIONS as f64 * (10.0 / (n as f64).max(10.0)).powi(3)) as usize;
    let examine = |center: [f64; 2], half: f64, best: &mut Distance| -> Option<Cell> {
        let value = sigma(center)?;
        if value < best.upper {
            (best.upper, best.at) = (value, (center[0], center[1]));
        }
        Some(Cell { lower: (value - half * std::f64::consts::SQRT_2).max(0.0), center, half })
    };
    for x in [-0.5 * radius, 0.5 * radius] {
        if stopped() {
            return Some(best);
        }
        heap.push(examine([x, 0.5 * radius], 0.5 * radius, &mut best)?);
    }
    for z in bracketry_numerics::eigen::eigenvalues(a)? {
        if stopped() {
            break;
        }
        examine([z.0, z.1.abs()], 0.0, &mut best)?;
    }
    while let Some(cell) = heap.pop() {
        best.lower = cell.lower.min(best.upper);
        used += 4;
        if best.upper - cell.lower <= GAP * best.upper || used > most || stopped() {
            break;
        }
        let half = 0.5 * cell.half;
        for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let next = examine([cell.center[0] + i * half, cell.center[1] + j * half], half, &mut best)?;
            if next.lower <= best.upper {
                heap.push(next);
            }
        }
    }
    let mut best = polished(best, sigma, stopped);
    // What a singular value is found to.
    best.upper = best.upper.max(f64::EPSILON * (a.norm_squared() + b.norm_squared()).sqrt());
    Some(best)
}

/// The upper bound lowered by a descent from the best number so far.
fn polished(mut best: Distance, sigma: impl Fn([f64; 2]) -> Option<f64>, stopped: &dyn Fn() -> bool) -> Distance {
    let mut step = 0.1 * best.upper;
    for _ in 0..200 {
        if stopped() {
            break;
        }
        let mut moved = false;
        for (i, j) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            if stopped() {
                break;
            }
            let z = [best.at.0 + i * step, best.at.1 + j * step];
            if let Some(value) = sigma(z).filter(|v| *v < best.upper) {
                (best.upper, best.at, moved) = (value, (z[0], z[1]), true);
            }
        }
        if !moved {
            step *= 0.5;
        }
        if step <= 1e-12 * (1.0 + best.at.0.abs() + best.at.1.abs()) {
            break;
        }
    }
    best.lower = best.lower.min(best.upper);
    best.at.1 = best.at.1.abs();
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// diag(1, 1 + ε) with b = (1, 1) is uncontrollable after the smaller eigenvalue moves by ε; with ε = 0 it is so as it stands.
    #[test]
    fn bounds_enclose_known_distances() {
        let b = DMatrix::from_row_slice(2, 1, &[1.0, 1.0]);
        let mut last = f64::INFINITY;
        for epsilon in [1.0, 0.1, 0.01, 0.0] {
            let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1.0 + epsilon]);
            let Some(d) = distance(&a, &b, &|| false) else { unreachable!() };
            assert!(d.lower <= d.upper && d.upper <= 0.5 * epsilon + 1e-15 && d.upper <= last, "{epsilon}: {d:?}");
            assert!(d.lower >= 0.8 * d.upper - 1e-3, "{epsilon}: {d:?}");
            last = d.upper;
        }
        // One state: σ_min[a − λ, b] is least at λ = a, where it is |b|.
        let Some(d) = distance(&DMatrix::from_element(1, 1, -3.0), &DMatrix::from_element(1, 1, 0.5), &|| false) else {
            unreachable!()
        };
        assert!((d.upper - 0.5).abs() < 1e-12 && d.lower > 0.49 && (d.at.0 + 3.0).abs() < 1e-3, "{d:?}");
    }
}
