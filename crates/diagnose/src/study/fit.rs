//! Fits by simulation error over windows: multiple shooting with the initial states eliminated.

use super::compiled::Compiled;
use super::normal::{Eliminated, Full, Point, SETTLED, States, full, residual, sensitivities, settle, simulate};
use super::runner::{Failure, Runner};
use super::unknown::Unknown;
use crate::effect::Effect;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

/// A fitted number.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Name of the parameter or coefficient.
    pub name: String,
    /// Its value in the model, or where the effect vanishes.
    pub nominal: f64,
    /// Fitted value.
    pub value: f64,
    /// Standard deviation, from the noise and the prior; larger where the residuals are larger than the noise.
    pub std: f64,
}

/// How a window is explained.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowFit {
    /// Index of the window.
    pub window: usize,
    /// Fitted initial state, at the window's first sample (earlier by the longest sensor delay).
    pub x0: Vec<f64>,
    /// Sum of squared residuals over noise, `Σ(r/σ)²`.
    pub square: f64,
    /// Number of residuals.
    pub count: usize,
    /// Measured − simulated over noise, one list per measured column of the record; NaN where the measurement was lost.
    pub residuals: Vec<Vec<f64>>,
    /// Why the window could not be simulated, and when; then there are no residuals.
    pub failure: Option<String>,
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitStatus {
    /// The sum of squares does not fall any more.
    Converged,
    /// The limit of iterations came first.
    IterationLimit,
}

/// A model with effects, fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The effects in the model.
    pub effects: Vec<Effect>,
    /// Refitted parameters, in the order of [`super::Study::parameters`], then the coefficients of the effects, in order.
    pub values: Vec<Estimate>,
    /// Covariance of `values`.
    pub covariance: DMatrix<f64>,
    /// The windows that were asked for.
    pub windows: Vec<WindowFit>,
    /// Places in `values` that the data do not tell: what is known of them is the prior.
    pub unidentified: Vec<usize>,
    /// How the iteration ended.
    pub status: FitStatus,
}

/// A window in a fit.
pub(super) struct Slot<'a> {
    pub(super) index: usize,
    pub(super) runner: Runner<'a>,
    /// Where the fit of the initial state begins.
    pub(super) start: Vec<f64>,
    /// Mean of the initial state's prior.
    pub(super) guess: Vec<f64>,
    pub(super) scales: Vec<f64>,
    pub(super) state: Result<Point, Failure>,
}

impl Slot<'_> {
    fn cost(&self) -> f64 {
        let states = States { guess: &self.guess, scales: &self.scales };
        self.state.as_ref().map_or(0.0, |p| p.square + states.penalty(&p.x0))
    }

    pub(super) fn settle(&mut self, compiled: &Compiled, theta: &[f64]) {
        let states = States { guess: &self.guess, scales: &self.scales };
        self.state = settle(&mut self.runner, compiled, theta, &self.start, &states);
    }

    pub(super) fn report(&self) -> WindowFit {
        let samples = self.runner.samples();
        match &self.state {
            Ok(point) => {
                let r = residual(&self.runner, point);
                let residuals = (0..self.runner.weights.len())
                    .map(|c| {
                        (c * samples..(c + 1) * samples)
                            .map(|at| if self.runner.present[at] { r[at] } else { f64::NAN })
                            .collect()
                    })
                    .collect();
                WindowFit {
                    window: self.index,
                    x0: point.x0.clone(),
                    square: point.square,
                    count: self.runner.present.iter().filter(|p| **p).count(),
                    residuals,
                    failure: None,
                }
            }
            Err(failure) => WindowFit {
                window: self.index,
                x0: self.guess.clone(),
                square: 0.0,
                count: 0,
                residuals: Vec::new(),
                failure: Some(failure.to_string()),
            },
        }
    }
}

/// Sum of the priors of the unknowns.
fn penalty(unknowns: &[Unknown], theta: &[f64]) -> f64 {
    unknowns.iter().zip(theta).map(|(u, v)| ((v - u.nominal) / u.prior).powi(2)).sum()
}

/// The outcome of the iteration.
pub(super) struct Solution {
    pub(super) theta: Vec<f64>,
    pub(super) status: FitStatus,
    /// Covariance in natural units.
    pub(super) covariance: DMatrix<f64>,
    pub(super) unidentified: Vec<usize>,
}

/// Levenberg–Marquardt over unknowns and initial states. Windows that cannot be simulated leave.
pub(super) fn solve(slots: &mut [Slot<'_>], compiled: &Compiled, start: Vec<f64>, iterations: usize) -> Solution {
    let unknowns = &compiled.unknowns;
    let p = unknowns.len();
    let mut theta = start;
    let mut lambda = 1e-4;
    let mut status = FitStatus::IterationLimit;
    if p == 0 {
        return Solution {
            theta,
            status: FitStatus::Converged,
            covariance: DMatrix::zeros(0, 0),
            unidentified: Vec::new(),
        };
    }
    for _ in 0..iterations {
        let normals = linearise(slots, compiled, &theta);
        let cost = slots.iter().map(Slot::cost).sum::<f64>() + penalty(unknowns, &theta);
        let mut fall = None;
        while lambda < 1e8 {
            if let Some(next) = trial(slots, compiled, &theta, &normals, lambda) {
                let next_cost = next.cost + penalty(unknowns, &next.theta);
                if next_cost < cost {
                    theta = next.theta;
                    for (slot, point) in slots.iter_mut().zip(next.points) {
                        if let Some(point) = point {
                            slot.state = Ok(point);
                        }
                    }
                    fall = Some((cost - next_cost, next_cost));
                    lambda = (0.1 * lambda).max(1e-9);
                    break;
                }
            }
            lambda *= 10.0;
        }
        if fall.is_none_or(|(fall, cost)| fall < SETTLED + 1e-6 * cost) {
            status = FitStatus::Converged;
            break;
        }
    }
    let normals = linearise(slots, compiled, &theta);
    let (covariance, unidentified) = uncertainty(slots, unknowns, &normals);
    Solution { theta, status, covariance, unidentified }
}

/// The normal equations of every window that can be simulated; the others are marked.
fn linearise(slots: &mut [Slot<'_>], compiled: &Compiled, theta: &[f64]) -> Vec<Option<Full>> {
    slots
        .par_iter_mut()
        .map(|slot| {
            let point = slot.state.as_ref().ok()?;
            match sensitivities(&mut slot.runner, compiled, theta, point, &slot.scales, true) {
                Ok(jacobian) => Some(full(&slot.runner, point, &jacobian)),
                Err(failure) => {
                    slot.state = Err(failure);
                    None
                }
            }
        })
        .collect()
}

/// A step that has been tried.
struct Trial {
    theta: Vec<f64>,
    points: Vec<Option<Point>>,
    cost: f64,
}

fn trial(
    slots: &mut [Slot<'_>],
    compiled: &Compiled,
    theta: &[f64],
    normals: &[Option<Full>],
    lambda: f64,
) -> Option<Trial> {
    let unknowns = &compiled.unknowns;
    let p = unknowns.len();
    let mut gram = DMatrix::zeros(p, p);
    let mut gradient = DVector::zeros(p);
    let mut eliminated = Vec::with_capacity(slots.len());
    for (slot, normal) in slots.iter().zip(normals) {
        let (Some(full), Ok(point)) = (normal, &slot.state) else {
            eliminated.push(None);
            continue;
        };
        let states = States { guess: &slot.guess, scales: &slot.scales };
        let e = Eliminated::new(full, &point.x0, &states, lambda)?;
        gram += &e.gram;
        gradient += &e.gradient;
        eliminated.push(Some(e));
    }
    for (j, u) in unknowns.iter().enumerate() {
        let weight = (u.scale / u.prior).powi(2);
        gram[(j, j)] += weight + lambda * (gram[(j, j)] + weight);
        gradient[j] += weight * (u.nominal - theta[j]) / u.scale;
    }
    let next = bounded_step(&gram, &gradient, unknowns, theta)?;
    let step = DVector::from_iterator(p, (0..p).map(|j| (next[j] - theta[j]) / unknowns[j].scale));
    let points: Vec<Option<Result<Point, Failure>>> = slots
        .par_iter_mut()
        .zip(&eliminated)
        .map(|(slot, eliminated)| {
            let (Some(e), Ok(point)) = (eliminated, &slot.state) else { return None };
            let own = e.step(&step);
            let x0: Vec<f64> = (0..own.len()).map(|i| point.x0[i] + own[i] * slot.scales[i]).collect();
            Some(simulate(&mut slot.runner, &next, &x0))
        })
        .collect();
    let mut cost = 0.0;
    let mut kept = Vec::with_capacity(points.len());
    for (slot, point) in slots.iter().zip(points) {
        match point.transpose().ok()? {
            Some(point) => {
                let states = States { guess: &slot.guess, scales: &slot.scales };
                cost += point.square + states.penalty(&point.x0);
                kept.push(Some(point));
            }
            None => kept.push(None),
        }
    }
    Some(Trial { theta: next, points: kept, cost })
}

/// The minimum of the quadratic model with what would leave its bounds kept on them.
fn bounded_step(gram: &DMatrix<f64>, gradient: &DVector<f64>, unknowns: &[Unknown], theta: &[f64]) -> Option<Vec<f64>> {
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
            let bounded = unknowns[j].bounded(value);
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

/// Covariance in natural units, and the unknowns of which the data tell less than the prior does.
fn uncertainty(slots: &[Slot<'_>], unknowns: &[Unknown], normals: &[Option<Full>]) -> (DMatrix<f64>, Vec<usize>) {
    let p = unknowns.len();
    let mut gram = DMatrix::zeros(p, p);
    let (mut square, mut freedom) = (0.0, -(p as f64));
    for (slot, normal) in slots.iter().zip(normals) {
        let (Some(full), Ok(point)) = (normal, &slot.state) else { continue };
        let states = States { guess: &slot.guess, scales: &slot.scales };
        if let Some(e) = Eliminated::new(full, &point.x0, &states, 0.0) {
            gram += &e.gram;
            square += full.square;
            freedom += slot.runner.present.iter().filter(|p| **p).count() as f64 - point.x0.len() as f64;
        }
    }
    // Misfit beyond the noise makes the estimates less certain.
    let inflation = if freedom > 0.0 { (square / freedom).max(1.0) } else { 1.0 };
    gram /= inflation;
    for (j, u) in unknowns.iter().enumerate() {
        gram[(j, j)] += (u.scale / u.prior).powi(2);
    }
    let scaled = Cholesky::new(gram).map_or_else(
        || DMatrix::from_diagonal(&DVector::from_iterator(p, unknowns.iter().map(|u| (u.prior / u.scale).powi(2)))),
        |c| c.inverse(),
    );
    let covariance = DMatrix::from_fn(p, p, |i, j| scaled[(i, j)] * unknowns[i].scale * unknowns[j].scale);
    let unidentified = (0..p).filter(|&j| covariance[(j, j)] > 0.5 * unknowns[j].prior.powi(2)).collect();
    (covariance, unidentified)
}
