//! A step of a fit: of the unknowns that all windows share, and of the initial state of each.

use super::normal::{Eliminated, Full, Point, simulate};
use super::runner::Failure;
use super::slot::Slot;
use super::unknown::{Range, Unknown};
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// Windows that are simulated at once where the sum of their squares may come to be too large: the same number on every machine,
/// so that the same windows are simulated.
const AT_ONCE: usize = 8;

/// A step of the unknowns and of the initial states.
pub(super) struct Step {
    pub(super) theta: Vec<f64>,
    x0: Vec<Option<Vec<f64>>>,
    /// By how much the cost falls if it is quadratic.
    pub(super) fall: f64,
}

impl Step {
    pub(super) fn new(
        slots: &[Slot<'_>],
        unknowns: &[Unknown],
        theta: &[f64],
        ranges: &[Range],
        normals: &[Option<Full>],
        lambda: f64,
    ) -> Option<Self> {
        let p = unknowns.len();
        let mut gram = DMatrix::zeros(p, p);
        let mut gradient = DVector::zeros(p);
        let mut eliminated = Vec::with_capacity(slots.len());
        let mut fall = 0.0;
        for (slot, normal) in slots.iter().zip(normals) {
            let (Some(full), Ok(point)) = (normal, &slot.state) else {
                eliminated.push(None);
                continue;
            };
            let e = Eliminated::new(full, &point.x0, &slot.states(), lambda)?;
            gram += &e.gram;
            gradient += &e.gradient;
            fall += e.gain;
            eliminated.push(Some((e, point)));
        }
        for (j, u) in unknowns.iter().enumerate() {
            let weight = (u.scale / u.prior).powi(2);
            gram[(j, j)] += weight + lambda * (gram[(j, j)] + weight);
            gradient[j] += weight * (u.nominal - theta[j]) / u.scale;
        }
        let next = bounded_step(&gram, &gradient, unknowns, theta, ranges)?;
        let step = DVector::from_iterator(p, (0..p).map(|j| (next[j] - theta[j]) / unknowns[j].scale));
        fall += 2.0 * gradient.dot(&step) - step.dot(&(&gram * &step));
        let x0 = slots
            .iter()
            .zip(&eliminated)
            .map(|(slot, e)| {
                e.as_ref().map(|(e, point)| {
                    let own = e.step(&step);
                    (0..own.len()).map(|i| point.x0[i] + own[i] * slot.scales[i]).collect()
                })
            })
            .collect();
        Some(Self { theta: next, x0, fall })
    }

    /// Where it leads and the cost of the windows; none if a window cannot be simulated there or the cost is not below `limit`. No
    /// window lowers the cost, so that those which are left when it has come to the limit are not simulated.
    pub(super) fn simulate(&self, slots: &mut [Slot<'_>], limit: f64) -> Option<(Vec<Option<Point>>, f64)> {
        let mut cost = 0.0;
        let mut kept = Vec::with_capacity(slots.len());
        for (slots, x0) in slots.chunks_mut(AT_ONCE).zip(self.x0.chunks(AT_ONCE)) {
            let points: Vec<Option<Result<Point, Failure>>> = slots
                .par_iter_mut()
                .zip(x0)
                .map(|(slot, x0)| x0.as_ref().map(|x0| simulate(&mut slot.runner, &self.theta, x0)))
                .collect();
            for (slot, point) in slots.iter().zip(points) {
                let point = point.transpose().ok()?;
                cost += point.as_ref().map_or(0.0, |p| p.square + slot.states().penalty(&p.x0));
                kept.push(point);
            }
            if cost.is_nan() || cost >= limit {
                return None;
            }
        }
        Some((kept, cost))
    }
}

/// The minimum of the quadratic model with what would leave its bounds kept on them.
fn bounded_step(
    gram: &DMatrix<f64>,
    gradient: &DVector<f64>,
    unknowns: &[Unknown],
    theta: &[f64],
    ranges: &[Range],
) -> Option<Vec<f64>> {
    let p = unknowns.len();
    let mut fixed: Vec<Option<f64>> = vec![None; p];
    loop {
        let free: Vec<usize> = (0..p).filter(|&j| fixed[j].is_none()).collect();
        if free.is_empty() {
            return Some((0..p).map(|j| fixed[j].unwrap_or(theta[j])).collect());
        }
        let mut next: Vec<f64> = (0..p).map(|j| fixed[j].unwrap_or(theta[j])).collect();
        let reduced = gram.select_rows(&free).select_columns(&free);
        let held = DVector::from_iterator(p, (0..p).map(|j| (next[j] - theta[j]) / unknowns[j].scale));
        let rhs = (gradient - gram * held).select_rows(&free);
        let step = Cholesky::new(reduced)?.solve(&rhs);
        let mut hit = false;
        for (k, &j) in free.iter().enumerate() {
            let value = theta[j] + step[k] * unknowns[j].scale;
            let bounded = ranges[j].bounded(value);
            if bounded != value {
                fixed[j] = Some(bounded);
                hit = true;
            }
            next[j] = value;
        }
        if !hit {
            return next.iter().all(|v| v.is_finite()).then_some(next);
        }
    }
}
