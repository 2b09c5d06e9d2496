//! Fits by simulation error over windows: multiple shooting with the initial states eliminated.

use super::compiled::Compiled;
use super::linearization::Normal;
use super::normal::{Full, damping, full, sensitivities};
use super::slot::{Slot, WindowFit};
use super::step::Step;
use super::unknown::{Range, Unknown};
use crate::effect::Effect;
use crate::settings::SolverSettings;
use bracketry_numerics::least_squares::Trial;
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

impl Estimate {
    /// The standard deviation that is stated of the estimate where correlation within windows widens it by a factor.
    pub(crate) fn widened(&self, width: f64) -> f64 {
        self.std * width
    }
}

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitStatus {
    /// The sum of squares does not fall any more.
    Converged,
    /// No step lowers the sum of squares although its slope promises it: it has a kink there, as where sticking starts.
    Stalled,
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
    /// Places in `values` that the data hardly tell: their standard deviation is more than half of the prior's.
    pub unidentified: Vec<usize>,
    /// Places in `values` that stopped at the end of their range: a limit of the model file or of the effect, or as far as a
    /// refit goes. Their standard deviations are those of values that are free to move.
    pub limited: Vec<usize>,
    /// How the iteration ended.
    pub status: FitStatus,
}

impl Fit {
    /// The estimate of a parameter or coefficient.
    pub(crate) fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.values.iter().find(|e| e.name == name)
    }

    /// The fit without its initial states, which belong to windows of one length and to inputs with one hold.
    pub(crate) fn without_windows(&self) -> Self {
        Self { windows: Vec::new(), ..self.clone() }
    }

    /// How many states its effects add to the model.
    pub(crate) fn hidden_states(&self) -> usize {
        self.effects.iter().map(|e| e.hidden().len()).sum()
    }

    /// Sum of squares over all windows.
    pub(crate) fn square(&self) -> f64 {
        self.windows.iter().map(|w| w.square).sum()
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
    pub(super) limited: Vec<usize>,
    /// At the solution, in scaled units.
    pub(super) normals: Vec<Normal>,
}

/// Levenberg–Marquardt over unknowns and initial states, once more from where it has come if parameters without a limit in the
/// model file stop at the end of their range. That is kept where the data tell the value and it lies inside the moved range, or
/// where it has gone all the way toward zero (a term that is not there: `k` in `k h` where the law is another); else the
/// parameters have no bounds to find, and stay at the end of the first range.
///
/// A fit that would not come down to `reach` in the iterations that are left, each as good as the last, ends there.
pub(super) fn solve(
    slots: &mut [Slot<'_>],
    compiled: &Compiled,
    start: &[f64],
    (iterations, reach): (usize, f64),
) -> Solution {
    let (unknowns, priors) = (&compiled.unknowns, &compiled.settings.priors);
    let mut ranges: Vec<Range> = unknowns.iter().zip(start).map(|(u, v)| u.first_range(*v, priors)).collect();
    let initial = start.iter().zip(&ranges).map(|(v, r)| r.bounded(*v)).collect();
    let first = minimize(slots, compiled, initial, &ranges, (iterations, reach));
    let stopped = |s: &Solution, ranges: &[Range]| -> Vec<usize> {
        (0..unknowns.len()).filter(|&j| unknowns[j].ends_on(ranges[j], s.theta[j])).collect()
    };
    let mut ends = stopped(&first, &ranges);
    if ends.is_empty() {
        return first;
    }
    let states: Vec<_> = slots.iter().map(|s| s.state.clone()).collect();
    let mut theta = first.theta.clone();
    let mut moved = ends.clone();
    for round in 1..=priors.range_moves {
        for &j in &ends {
            ranges[j] = unknowns[j].range(theta[j], priors);
        }
        let next = minimize(slots, compiled, theta, &ranges, (iterations, reach));
        ends = stopped(&next, &ranges);
        moved.extend(&ends);
        let last = round == priors.range_moves;
        let vanished = last && ends.iter().all(|&j| next.theta[j].abs() < unknowns[j].nominal.abs());
        if ends.is_empty() || vanished {
            if moved.iter().any(|j| next.unidentified.contains(j)) {
                break;
            }
            return next;
        }
        theta = next.theta;
    }
    for (slot, state) in slots.iter_mut().zip(states) {
        slot.state = state;
    }
    first
}

/// Levenberg–Marquardt over unknowns in their ranges and initial states. Windows that cannot be simulated leave.
fn minimize(
    slots: &mut [Slot<'_>],
    compiled: &Compiled,
    start: Vec<f64>,
    ranges: &[Range],
    (iterations, reach): (usize, f64),
) -> Solution {
    let (unknowns, solver) = (&compiled.unknowns, &compiled.settings.solver);
    let p = unknowns.len();
    let mut theta = start;
    let mut damping = damping(solver, solver.most_damping);
    let mut status = FitStatus::IterationLimit;
    if p == 0 {
        return Solution {
            theta,
            status: FitStatus::Converged,
            covariance: DMatrix::zeros(0, 0),
            unidentified: Vec::new(),
            limited: Vec::new(),
            normals: Vec::new(),
        };
    }
    let mut normals = linearize(slots, compiled, &theta);
    for iteration in 1..=iterations {
        if iteration > 1 && compiled.counter.cuts_fits() {
            compiled.counter.leave_out(1);
            break;
        }
        let cost = slots.iter().map(Slot::cost).sum::<f64>() + penalty(unknowns, &theta);
        let settled = settled(slots, cost, solver);
        let mut rejected = false;
        let found = damping.search(|lambda| {
            let Some(step) = Step::new(slots, unknowns, &theta, ranges, &normals, lambda) else { return Trial::Last };
            if step.fall < settled {
                if !rejected {
                    status = FitStatus::Converged;
                }
                return Trial::Last;
            }
            let own = penalty(unknowns, &step.theta);
            let Some((points, squares)) = step.simulate(slots, cost - own) else {
                rejected = true;
                return Trial::Rejected;
            };
            Trial::Accepted((step.theta, points, cost - own - squares))
        });
        let Some((next, points, fall)) = found else {
            if status != FitStatus::Converged {
                status = FitStatus::Stalled;
            }
            break;
        };
        theta = next;
        for (slot, point) in slots.iter_mut().zip(points) {
            if let Some(point) = point {
                slot.state = Ok(point);
            }
        }
        normals = linearize(slots, compiled, &theta);
        if fall < settled {
            status = FitStatus::Converged;
            break;
        }
        let left = (iterations - iteration) as f64;
        if iteration >= solver.fewest_iterations && cost - fall - left * fall > reach {
            break;
        }
    }
    let normals = eliminate(slots, &normals);
    let covariance = covariance(&normals, unknowns, slots.first().map_or(0, |s| s.scales.len()));
    let vague =
        |&j: &usize| covariance[(j, j)] > (compiled.settings.priors.unidentified_share * unknowns[j].prior).powi(2);
    let unidentified = (0..p).filter(vague).collect();
    let limited = (0..p).filter(|&j| ranges[j].ends_at(theta[j]) && !unknowns[j].is_settled()).collect();
    Solution { theta, status, covariance, unidentified, limited, normals }
}

/// A fall of the cost that ends the iteration. What exceeds the noise is the model's error, which stays alike throughout a window: it
/// says as much as one number per window and column, and a hundredth of such a number does not matter.
fn settled(slots: &[Slot<'_>], cost: f64, solver: &SolverSettings) -> f64 {
    let running = slots.iter().filter(|s| s.state.is_ok());
    let (count, numbers) = running.fold((0, 0), |(count, numbers), slot| {
        (count + slot.runner.present.iter().filter(|p| **p).count(), numbers + slot.runner.weights.len())
    });
    let fall = solver.settled_fall;
    fall + solver.settled_share * cost + fall * (cost - count as f64).max(0.0) / numbers.max(1) as f64
}

/// The Jacobian of every window that can be simulated, initial state first; the others are marked.
fn linearize(slots: &mut [Slot<'_>], compiled: &Compiled, theta: &[f64]) -> Vec<Option<Full>> {
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

/// The normal equations of the windows with their initial states eliminated.
fn eliminate(slots: &[Slot<'_>], normals: &[Option<Full>]) -> Vec<Normal> {
    slots.iter().zip(normals).filter_map(|(slot, normal)| slot.normal(normal.as_ref()?)).collect()
}

/// Covariance in natural units.
fn covariance(normals: &[Normal], unknowns: &[Unknown], states: usize) -> DMatrix<f64> {
    let p = unknowns.len();
    let mut gram = DMatrix::zeros(p, p);
    let (mut square, mut freedom) = (0.0, -(p as f64));
    for normal in normals {
        gram += &normal.gram;
        square += normal.square;
        freedom += normal.count as f64 - states as f64;
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
    let unit = |j: usize| if unknowns[j].is_settled() { 0.0 } else { unknowns[j].scale };
    DMatrix::from_fn(p, p, |i, j| scaled[(i, j)] * unit(i) * unit(j))
}
