//! Pressure between a flat object and the plate.

use crate::object::Patch;
use crate::{Object, PlateError};

/// Most Newton steps for a pressure that does not pull.
const STEPS: usize = 60;

/// What the plate has to carry: normal force and its moments about the center of mass, all per mass, in the object's own axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Normal force in N/kg.
    pub normal: f64,
    /// `∫ x p dA` and `∫ y p dA` in N m/kg.
    pub moments: [f64; 2],
}

/// How the plate carries a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Support {
    /// Pressure on the whole footprint; `least` is its least value over the mean.
    Full {
        /// Least pressure over mean pressure.
        least: f64,
    },
    /// Part of the footprint carries nothing.
    Partial {
        /// Share of the weight of the points with pressure.
        share: f64,
    },
    /// The center of pressure is so near the rim that one point there carries everything.
    Edge {
        /// The center of pressure from the center of mass, own axes, in m.
        at: [f64; 2],
    },
    /// The center of pressure would lie outside: the object tips.
    Tipping {
        /// Where it would have to be, from the center of mass, own axes, in m.
        at: [f64; 2],
        /// Share of the way to the rim, at least 1; see [`crate::Shape::rim_share`].
        rim_share: f64,
    },
    /// The plate would have to pull: the object lifts off.
    LiftOff,
}

/// The points where an object presses on the plate and the pressure on them.
///
/// The pressure of a load is affine, `p = a + b x + c y`, as a stiff object on a plate of uniform slight compliance presses;
/// where that would pull, it is `p = max(0, a + b x + c y)` with the same force and moments.
#[derive(Debug, Clone)]
pub struct Footprint {
    patch: Patch,
    loads: Vec<f64>,
    /// The last unilateral pressure over the mean, with lengths in `size`.
    last: [f64; 3],
}

impl Footprint {
    /// The bearing of an object with about `points` points; see [`crate::Shape::quadrature`].
    ///
    /// # Errors
    /// [`PlateError`] for an object or a number of points without meaning.
    pub fn new(object: &Object, points: usize) -> Result<Self, PlateError> {
        let patch = Patch::of(object, points)?;
        Ok(Self { loads: vec![0.0; patch.rule.points.len()], patch, last: [1.0, 0.0, 0.0] })
    }

    /// Points from the center of mass, own axes, in m.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.patch.rule.points
    }

    /// The middle of the hull of the points from the center of mass, own axes, in m.
    pub(super) fn center(&self) -> [f64; 2] {
        self.patch.center
    }

    /// Shares of the points in the area.
    pub fn weights(&self) -> &[f64] {
        &self.patch.rule.weights
    }

    /// Normal force on each point, in N/kg, of the last load carried by points of the footprint; their sum is the force.
    pub fn loads(&self) -> &[f64] {
        &self.loads
    }

    /// Finds the pressure that carries the load. At an [`Support::Edge`] no point of the footprint carries anything.
    pub fn carry(&mut self, load: &Load) -> Support {
        let n = load.normal;
        if n <= 0.0 || !n.is_finite() {
            self.loads.fill(0.0);
            return Support::LiftOff;
        }
        let at = load.moments.map(|m| m / n);
        let slope = self.patch.slope(at);
        let middle = self.patch.middle(slope);
        let lowest = self.patch.farthest([-slope[0], -slope[1]]);
        let least = middle + slope[0] * lowest[0] + slope[1] * lowest[1];
        let affine = [middle, slope[0] * self.patch.size, slope[1] * self.patch.size];
        if least >= 0.0 {
            self.spread(n, &affine);
            return Support::Full { least };
        }
        let rim_share = self.patch.rim_share(at);
        if rim_share >= 1.0 {
            self.loads.fill(0.0);
            return Support::Tipping { at, rim_share };
        }
        if let Some(pressure) = self.unilateral(at, affine) {
            self.last = pressure;
            self.spread(n, &pressure);
            let carrying = self.loads.iter().zip(&self.patch.rule.weights).filter(|(load, _)| **load > 0.0);
            return Support::Partial { share: carrying.map(|(_, weight)| weight).sum() };
        }
        self.loads.fill(0.0);
        Support::Edge { at }
    }

    /// Loads of the pressure `max(0, a + b x + c y)` over the mean, coefficients for lengths in `size`.
    fn spread(&mut self, normal: f64, [a, b, c]: &[f64; 3]) {
        for ((load, [x, y]), weight) in self.loads.iter_mut().zip(&self.patch.rule.points).zip(&self.patch.rule.weights)
        {
            *load = normal * weight * (a + (b * x + c * y) / self.patch.size).max(0.0);
        }
    }

    /// Pressure `max(0, z · (1, x, y))` with mean 1 and center of pressure `at`: the minimum of the convex function
    /// `½ Σ w max(0, z · r)² − z · (1, at)`, by Newton's method. Absent if `at` lies outside the hull of the points.
    fn unilateral(&self, at: [f64; 2], affine: [f64; 3]) -> Option<[f64; 3]> {
        let target = [1.0, at[0] / self.patch.size, at[1] / self.patch.size];
        let evaluate = |z: &[f64; 3]| {
            let (mut value, mut gradient, mut hessian) = (0.0, target.map(|t| -t), [[0.0; 3]; 3]);
            for ([x, y], weight) in self.patch.rule.points.iter().zip(&self.patch.rule.weights) {
                let r = [1.0, x / self.patch.size, y / self.patch.size];
                let pressure = z[0] + z[1] * r[1] + z[2] * r[2];
                if pressure > 0.0 {
                    value += 0.5 * weight * pressure * pressure;
                    for i in 0..3 {
                        gradient[i] += weight * pressure * r[i];
                        for j in 0..3 {
                            hessian[i][j] += weight * r[i] * r[j];
                        }
                    }
                }
            }
            (value - z[0] * target[0] - z[1] * target[1] - z[2] * target[2], gradient, hessian)
        };
        let mut z = if evaluate(&self.last).0 < evaluate(&affine).0 { self.last } else { affine };
        let mut here = evaluate(&z);
        for _ in 0..STEPS {
            let (value, gradient, hessian) = here;
            if gradient.iter().all(|g| g.abs() < 1e-13) {
                return Some(z);
            }
            let step = solve3(hessian, gradient)?;
            let descent: f64 = gradient.iter().zip(step).map(|(g, s)| g * s).sum();
            let mut length = 1.0;
            loop {
                let trial = [0, 1, 2].map(|i| z[i] - length * step[i]);
                let there = evaluate(&trial);
                if there.0 <= value - 1e-4 * length * descent + 1e-15 * value.abs() {
                    (z, here) = (trial, there);
                    break;
                }
                length *= 0.5;
                if length < 1e-6 {
                    return None;
                }
            }
        }
        None
    }
}

/// Solves a symmetric positive definite system of three; absent if it is singular.
fn solve3(m: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let minor = |i: usize, j: usize| {
        let (p, q) = ((i + 1) % 3, (i + 2) % 3);
        let (r, s) = ((j + 1) % 3, (j + 2) % 3);
        m[p][r] * m[q][s] - m[p][s] * m[q][r]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    let size = m[0][0] * m[1][1] * m[2][2];
    (determinant > 1e-13 * size)
        .then(|| [0, 1, 2].map(|j| (0..3).map(|i| minor(i, j) * b[i]).sum::<f64>() / determinant))
}
