//! Pressure between a flat object and the plate.

use nalgebra::{Matrix3, Vector3};

use crate::object::Patch;
use crate::{Object, PlateError};

/// Most Newton steps for a pressure that does not pull.
const STEPS: usize = 200;
/// Force and moments, in units of the force and the size, that a pressure may leave where rounding does not let it balance them better.
const BALANCED: f64 = 1e-9;
/// Curvature added to Newton's method, in proportion to the force and the moments left: without it, nothing holds a pressure where
/// fewer than three points carry.
const DAMPING: f64 = 1e-3;

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
    /// The center of pressure lies between the outermost points of the footprint and its rim: one point there carries everything.
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
    ///
    /// # Errors
    /// [`PlateError::NotConverged`] if no pressure was found although there is one.
    pub fn carry(&mut self, load: &Load) -> Result<Support, PlateError> {
        let n = load.normal;
        if n <= 0.0 || !n.is_finite() {
            self.loads.fill(0.0);
            return Ok(Support::LiftOff);
        }
        let at = load.moments.map(|m| m / n);
        let slope = self.patch.slope(at);
        let middle = self.patch.middle(slope);
        let lowest = self.patch.farthest([-slope[0], -slope[1]]);
        let least = middle + slope[0] * lowest[0] + slope[1] * lowest[1];
        let affine = [middle, slope[0] * self.patch.size, slope[1] * self.patch.size];
        if least >= 0.0 {
            self.spread(n, &affine);
            return Ok(Support::Full { least });
        }
        let rim_share = self.patch.rim_share(at);
        if rim_share >= 1.0 {
            self.loads.fill(0.0);
            return Ok(Support::Tipping { at, rim_share });
        }
        if !self.patch.is_inside(at) {
            self.loads.fill(0.0);
            return Ok(Support::Edge { at });
        }
        let pressure = self.unilateral(at, affine)?;
        self.last = pressure;
        self.spread(n, &pressure);
        let carrying = self.loads.iter().zip(&self.patch.rule.weights).filter(|(load, _)| **load > 0.0);
        Ok(Support::Partial { share: carrying.map(|(_, weight)| weight).sum() })
    }

    /// Loads of the pressure `max(0, a + b x + c y)` over the mean, coefficients for lengths in `size`.
    fn spread(&mut self, normal: f64, [a, b, c]: &[f64; 3]) {
        for ((load, [x, y]), weight) in self.loads.iter_mut().zip(&self.patch.rule.points).zip(&self.patch.rule.weights)
        {
            *load = normal * weight * (a + (b * x + c * y) / self.patch.size).max(0.0);
        }
    }

    /// Pressure `max(0, z · (1, x, y))` with mean 1 and center of pressure `at`, a point inside the hull of the points: the minimum of
    /// the convex function `½ Σ w max(0, z · r)² − z · (1, at)`, by Newton's method with a curvature added that vanishes with the
    /// gradient.
    fn unilateral(&self, at: [f64; 2], affine: [f64; 3]) -> Result<[f64; 3], PlateError> {
        let target = Vector3::new(1.0, at[0] / self.patch.size, at[1] / self.patch.size);
        let evaluate = |z: &Vector3<f64>| {
            let (mut value, mut gradient, mut hessian) = (0.0, -target, Matrix3::zeros());
            for ([x, y], weight) in self.patch.rule.points.iter().zip(&self.patch.rule.weights) {
                let r = Vector3::new(1.0, x / self.patch.size, y / self.patch.size);
                let pressure = z.dot(&r);
                if pressure > 0.0 {
                    value += 0.5 * weight * pressure * pressure;
                    gradient += r * (weight * pressure);
                    hessian.ger(*weight, &r, &r, 1.0);
                }
            }
            (value - z.dot(&target), gradient, hessian)
        };
        let (last, affine) = (Vector3::from(self.last), Vector3::from(affine));
        let mut z = if evaluate(&last).0 < evaluate(&affine).0 { last } else { affine };
        let mut here = evaluate(&z);
        for _ in 0..STEPS {
            let (value, gradient, mut hessian) = here;
            let left = gradient.amax();
            if left < 1e-13 {
                return Ok(z.into());
            }
            for i in 0..3 {
                hessian[(i, i)] += DAMPING * left;
            }
            let Some(factor) = hessian.cholesky() else { break };
            let step = factor.solve(&gradient);
            let descent = gradient.dot(&step);
            let mut length = 1.0;
            let next = loop {
                let trial = z - step * length;
                let there = evaluate(&trial);
                if there.0 <= value - 1e-4 * length * descent + 1e-15 * value.abs() {
                    break Some((trial, there));
                }
                length *= 0.5;
                if length < 1e-9 {
                    break None;
                }
            };
            let Some(next) = next else { break };
            (z, here) = next;
        }
        let left = here.1.amax();
        if left <= BALANCED {
            return Ok(z.into());
        }
        Err(PlateError::NotConverged { what: "the pressure under the object", left })
    }
}
