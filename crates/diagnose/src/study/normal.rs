//! Sensitivities of one window, and its normal equations.

use super::compiled::{Compiled, Target};
use super::runner::{Failure, Runner};
use super::unknown::Unknown;
use crate::effect::Path;
use crate::settings::SolverSettings;
use bracketry_numerics::least_squares::{Damping, Trial};
use nalgebra::{Cholesky, DMatrix, DVector};

/// A window with the values at which it was simulated last.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) x0: Vec<f64>,
    /// Simulated columns over their noise.
    pub(super) simulated: Vec<f64>,
    /// Sum of squared residuals over noise.
    pub(super) square: f64,
}

/// `[J_x J_θ]ᵀ[J_x J_θ]` and `[J_x J_θ]ᵀ r` of one window in scaled units, initial state first.
#[derive(Clone, Debug)]
pub(super) struct Full {
    pub(super) gram: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    pub(super) square: f64,
}

/// Initial state, first guess of it and its scales.
pub(super) struct States<'a> {
    pub(super) guess: &'a [f64],
    pub(super) scales: &'a [f64],
    /// Weight of the prior, in scaled units.
    pub(super) weight: f64,
}

impl<'a> States<'a> {
    /// The prior's standard deviation, over the scales, is `prior`.
    pub(super) fn new(guess: &'a [f64], scales: &'a [f64], prior: f64) -> Self {
        Self { guess, scales, weight: 1.0 / (prior * prior) }
    }

    pub(super) fn penalty(&self, x0: &[f64]) -> f64 {
        let off = |i: usize| (x0[i] - self.guess[i]) / self.scales[i];
        (0..x0.len()).map(|i| self.weight * off(i) * off(i)).sum()
    }
}

/// Simulates a window.
pub(super) fn simulate(runner: &mut Runner<'_>, theta: &[f64], x0: &[f64]) -> Result<Point, Failure> {
    let mut simulated = vec![0.0; runner.target.len()];
    runner.simulate(theta, x0, &mut simulated)?;
    let square: f64 = runner.target.iter().zip(&simulated).map(|(y, s)| (y - s) * (y - s)).sum();
    // A start that is fitted takes the noise of one sample away.
    let square = square + runner.fitted_starts() as f64;
    Ok(Point { x0: x0.to_vec(), simulated, square })
}

/// A step for finite differences in an unknown, in the direction in which there is room.
pub(super) fn step_of(unknown: &Unknown, value: f64, size: f64) -> f64 {
    if value + size <= unknown.max { size } else { -size }
}

/// Sensitivities by the initial state in scaled units, then by the unknowns if wanted: propagated along the trajectory where the model has
/// derivatives, by finite differences otherwise.
pub(super) fn sensitivities(
    runner: &mut Runner<'_>,
    compiled: &Compiled,
    theta: &[f64],
    point: &Point,
    scales: &[f64],
    with_unknowns: bool,
) -> Result<DMatrix<f64>, Failure> {
    let n = scales.len();
    let unknowns = if with_unknowns { theta.len() } else { 0 };
    let rows = runner.target.len();
    let mut jacobian = DMatrix::zeros(rows, n + unknowns);
    let mut moved = vec![0.0; rows];
    let step = compiled.settings.solver.difference_step;
    let mut propagated = if runner.map(theta, &point.x0)? {
        runner.by_state_and_equations(with_unknowns).into_iter()
    } else {
        Vec::new().into_iter()
    };
    for i in 0..n {
        if let Some(by_state) = propagated.next() {
            let mut column = jacobian.column_mut(i);
            column.copy_from_slice(&by_state);
            column *= scales[i];
            continue;
        }
        let mut x0 = point.x0.clone();
        x0[i] += step * scales[i];
        runner.simulate(theta, &x0, &mut moved)?;
        difference(&moved, &point.simulated, step, jacobian.column_mut(i).as_mut_slice());
    }
    for j in 0..unknowns {
        let unknown = &compiled.unknowns[j];
        let mut column = jacobian.column_mut(n + j);
        if compiled.targets[j] == Target::Equations
            && let Some(by_number) = propagated.next()
        {
            column.copy_from_slice(&by_number);
            column *= unknown.scale;
            continue;
        }
        if unknown.is_settled() {
            continue;
        }
        if runner.offset_column(j, column.as_mut_slice()) {
            column *= unknown.scale;
            continue;
        }
        let step = step_of(unknown, theta[j], compiled.step(j, runner.sampling()));
        if let Target::Column(path @ (Path::SensorLag | Path::DigitalFilter), names) = &compiled.targets[j]
            && runner.trajectory.is_of(theta, &point.x0)
        {
            let moved = runner.filtered_more(*path, names, step);
            difference(&moved, &point.simulated, step / unknown.scale, column.as_mut_slice());
            continue;
        }
        let mut values = theta.to_vec();
        values[j] += step;
        runner.simulate(&values, &point.x0, &mut moved)?;
        difference(&moved, &point.simulated, step / unknown.scale, column.as_mut_slice());
    }
    Ok(jacobian)
}

/// `(a − b)/step`.
pub(super) fn difference(a: &[f64], b: &[f64], step: f64, out: &mut [f64]) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = (a - b) / step;
    }
}

/// The normal equations of a window.
pub(super) fn full(runner: &Runner<'_>, point: &Point, jacobian: &DMatrix<f64>) -> Full {
    let residual = residual(runner, point);
    // The product of matrices works by blocks, `tr_mul` column by column.
    Full { gram: jacobian.transpose() * jacobian, gradient: jacobian.tr_mul(&residual), square: point.square }
}

/// Measured − simulated, over the noise.
pub(super) fn residual(runner: &Runner<'_>, point: &Point) -> DVector<f64> {
    DVector::from_iterator(runner.target.len(), runner.target.iter().zip(&point.simulated).map(|(y, s)| y - s))
}

/// The initial state eliminated: `S = G_θθ − G_θx G_xx⁻¹ G_xθ` and the same of the gradient, and what gives its step back.
pub(super) struct Eliminated {
    pub(super) gram: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    /// `G_xx⁻¹ G_xθ`.
    back: DMatrix<f64>,
    /// `G_xx⁻¹ g_x`.
    own: DVector<f64>,
    /// By how much the square falls when the initial state makes its own step.
    pub(super) gain: f64,
}

impl Eliminated {
    /// With damping `λ` of the initial state and its prior; `None` if that is not positive definite (not finite).
    pub(super) fn new(full: &Full, x0: &[f64], states: &States<'_>, lambda: f64) -> Option<Self> {
        let n = x0.len();
        let p = full.gradient.len() - n;
        let mut gxx = full.gram.view((0, 0), (n, n)).into_owned();
        let mut gx = full.gradient.rows(0, n).into_owned();
        for i in 0..n {
            gxx[(i, i)] += lambda * gxx[(i, i)] + states.weight;
            gx[i] += states.weight * (states.guess[i] - x0[i]) / states.scales[i];
        }
        let cholesky = Cholesky::new(gxx)?;
        let cross = full.gram.view((0, n), (n, p)).into_owned();
        let back = cholesky.solve(&cross);
        let own = cholesky.solve(&gx);
        let gram = full.gram.view((n, n), (p, p)) - cross.tr_mul(&back);
        let gradient = full.gradient.rows(n, p) - cross.tr_mul(&own);
        Some(Self { gram, gradient, gain: gx.dot(&own), back, own })
    }

    /// The step of the initial state, in scaled units, that goes with a step of the unknowns.
    pub(super) fn step(&self, unknowns: &DVector<f64>) -> DVector<f64> {
        &self.own - &self.back * unknowns
    }
}

/// How the steps of a fit are damped, as far as `most`.
pub(super) fn damping(solver: &SolverSettings, most: f64) -> Damping {
    Damping { value: solver.first_damping, least: solver.least_damping, most, ..Damping::default() }
}

/// Fits the initial state of a window with the unknowns kept: Levenberg–Marquardt, until the sum of squares falls by less than
/// `share` of it.
pub(super) fn settle(
    runner: &mut Runner<'_>,
    compiled: &Compiled,
    theta: &[f64],
    start: &[f64],
    states: &States<'_>,
    share: f64,
) -> Result<Point, Failure> {
    let mut point = simulate(runner, theta, start)?;
    let mut cost = point.square + states.penalty(start);
    let solver = &compiled.settings.solver;
    let mut damping = damping(solver, solver.most_state_damping);
    let rough = share > solver.settled_share;
    let iterations = if rough { solver.rough_state_iterations } else { solver.state_iterations };
    for _ in 0..iterations {
        let jacobian = sensitivities(runner, compiled, theta, &point, states.scales, false)?;
        let full = full(runner, &point, &jacobian);
        let settled = solver.settled_fall + share * cost;
        if Eliminated::new(&full, &point.x0, states, 0.0).is_some_and(|e| e.gain < settled) {
            break;
        }
        let improved = damping.search(|lambda| {
            let Some(eliminated) = Eliminated::new(&full, &point.x0, states, lambda) else { return Trial::Last };
            let step = eliminated.step(&DVector::zeros(0));
            let x0: Vec<f64> = (0..start.len()).map(|i| point.x0[i] + step[i] * states.scales[i]).collect();
            let next = simulate(runner, theta, &x0).map(|next| (next.square + states.penalty(&x0), next));
            match next {
                Ok((next_cost, next)) if next_cost < cost => Trial::Accepted((next, next_cost)),
                _ => Trial::Rejected,
            }
        });
        let Some((next, next_cost)) = improved else { break };
        let fall = cost - next_cost;
        point = next;
        cost = next_cost;
        if fall < settled {
            break;
        }
    }
    Ok(point)
}
