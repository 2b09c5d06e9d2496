//! The infinite horizon as a terminal cost: the discrete algebraic Riccati equation at a steady state.

use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::integrator::Interval;
use crate::ocp::{CostFunction, CostPoint, Ocp};
use crate::transcription::Shooter;
use bracketry_numerics::linear_equations::solve;
use bracketry_symbolic::{Expr, Pool, Rational};
use nalgebra::{DMatrix, DVector};

/// Doublings after which the iteration has failed; each squares the closed loop.
const MAX_DOUBLINGS: usize = 60;
/// Relative change of P at which the iteration has converged.
const TOLERANCE: f64 = 1e-14;
/// Size of the doubled closed loop at which it counts as stable.
const STABLE: f64 = 1e-6;

/// The stabilizing solution of the Riccati equation and its gain.
#[derive(Clone, Debug, PartialEq)]
pub struct Riccati {
    /// P, the cost-to-go xᵀPx; symmetric, n rows of n.
    pub cost_to_go: DMatrix<f64>,
    /// K of the optimal input u = −Kx, m rows of n.
    pub gain: DMatrix<f64>,
}

/// Solves P = AᵀPA − (AᵀPB + S)(R + BᵀPB)⁻¹(BᵀPA + Sᵀ) + Q, the infinite horizon of x⁺ = Ax + Bu with the cost
/// Σ xᵀQx + 2xᵀSu + uᵀRu.
///
/// Structure-preserving doubling (Chu, Fan, Lin, and Wang 2004), quadratically
/// convergent.
///
/// ```
/// use bracketry_mpc::riccati::dare;
/// use nalgebra::DMatrix;
/// let (one, zero) = (DMatrix::identity(1, 1), DMatrix::zeros(1, 1));
/// let solution = dare(&one, &one, &one, &one, &zero).unwrap();
/// assert!((solution.cost_to_go[(0, 0)] - (1.0 + 5f64.sqrt()) / 2.0).abs() < 1e-14);
/// ```
///
/// # Errors
/// [`MpcError::NotStabilizable`] if the inputs cannot bring the state to rest, [`MpcError::NotDetectable`] if a motion that does
/// not decay costs nothing, [`MpcError::Value`] if R is not positive definite, [`MpcError::Length`] for matrices of other sizes.
pub fn dare(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    s: &DMatrix<f64>,
) -> Result<Riccati, MpcError> {
    let (n, m) = (a.nrows(), b.ncols());
    for (what, matrix, rows, columns) in
        [("A", a, n, n), ("B", b, n, m), ("Q", q, n, n), ("R", r, m, m), ("S", s, n, m)]
    {
        check_length(what, matrix.nrows(), rows)?;
        check_length(what, matrix.ncols(), columns)?;
        if let Some(&value) = matrix.iter().find(|v| !v.is_finite()) {
            return Err(MpcError::Value { what: what.into(), value, remedy: "give finite numbers" });
        }
    }
    let Some(factor) = r.clone().cholesky() else {
        return Err(MpcError::Value {
            what: "an eigenvalue of the weight R of the inputs".into(),
            value: r.clone().symmetric_eigenvalues().min(),
            remedy: "give every input a positive cost",
        });
    };
    // Without the cross term: the input is −R⁻¹Sᵀx + v.
    let cross = factor.solve(&s.transpose());
    let mut closed = a - b * &cross;
    let mut g = b * factor.solve(&b.transpose());
    let mut h = symmetric(&(q - s * &cross));
    let identity = DMatrix::identity(n, n);
    for _ in 0..MAX_DOUBLINGS {
        let Some(inverse) = (&identity + &g * &h).try_inverse() else { return Err(MpcError::NotStabilizable) };
        let step = &inverse * &closed;
        let rise = closed.transpose() * &h * &step;
        g = symmetric(&(&g + &closed * &inverse * &g * closed.transpose()));
        closed = &closed * step;
        h = symmetric(&(&h + &rise));
        if h.iter().chain(closed.iter()).any(|v| !v.is_finite()) {
            return Err(MpcError::NotStabilizable);
        }
        if rise.norm() <= TOLERANCE * h.norm() && closed.norm() < STABLE {
            let weight = r + b.transpose() * &h * b;
            let right = b.transpose() * &h * a + s.transpose();
            let Some(gain) = solve(weight, &right) else { return Err(MpcError::NotStabilizable) };
            return Ok(Riccati { cost_to_go: h, gain });
        }
    }
    // The cost-to-go of a state that cannot be brought to rest grows without bound; else a motion costs nothing.
    let bounded = h.norm() <= 1e12 * (q.norm() + s.norm() + r.norm());
    Err(if bounded { MpcError::NotDetectable } else { MpcError::NotStabilizable })
}

fn symmetric(m: &DMatrix<f64>) -> DMatrix<f64> {
    (m + m.transpose()) * 0.5
}

/// What continues a problem beyond its horizon: feedback and cost-to-go about a steady state.
#[derive(Clone, Debug, PartialEq)]
pub struct InfiniteHorizon {
    /// Cost-to-go and gain.
    pub riccati: Riccati,
    /// The steady state c that minimizes the stage cost, for the first references.
    pub state: Vec<f64>,
    /// Its input.
    pub input: Vec<f64>,
}

impl Ocp {
    /// The problem with the infinite horizon as its terminal cost: (x − c)ᵀP(x − c) + λᵀ(x − c), where P solves the Riccati
    /// equation of dynamics and stage cost at the steady state (`state`, `input`), per interval, c is the steady state that
    /// minimizes the stage cost and λ the multiplier of being steady there, zero where the stage cost has its minimum.
    ///
    /// c and λ are found by one Newton step from the given point, and follow the references of the stage cost: exactly, for a
    /// linear system with a quadratic cost; for others, give the best steady state itself.
    ///
    /// # Errors
    /// If the point is not a steady state ([`MpcError::NotSteady`]), there is no stage cost, or as [`dare`].
    pub fn with_terminal_cost_at(
        mut self,
        dynamics: &mut dyn Dynamics,
        state: &[f64],
        input: &[f64],
    ) -> Result<(Self, InfiniteHorizon), MpcError> {
        let (n, m) = (self.states(), self.inputs());
        check_length("the steady state", state.len(), n)?;
        check_length("the steady input", input.len(), m)?;
        self.check(dynamics.states(), dynamics.inputs())?;
        let Some(mut stage) = self.stage.clone() else { return Err(MpcError::NoStageCost) };
        let flow = self.flow_at_steady_state(dynamics, state, input)?;
        let (a, b) = (flow.columns(0, n).into_owned(), flow.columns(n, m).into_owned());
        let references = self.reference(0)[..stage.references()].to_vec();
        let (dt, pattern) = (self.dt, stage.hessian_pattern().to_vec());
        let mut derivatives = |r: &[f64]| {
            let (mut gradient, mut values) = (vec![0.0; n + m], vec![0.0; pattern.len()]);
            stage.add_derivatives(CostPoint { x: state, u: input, t: 0.0, r }, dt, &mut gradient, &mut values);
            (DVector::from_vec(gradient), values)
        };
        let mut hessian = DMatrix::zeros(n + m, n + m);
        for (&(i, j), v) in pattern.iter().zip(derivatives(&references).1) {
            hessian[(i, j)] = v;
            hessian[(j, i)] = v;
        }
        let block = |i, j, rows, columns| hessian.view((i, j), (rows, columns)) * 0.5;
        let riccati = dare(&a, &b, &block(0, 0, n, n), &block(n, n, m, m), &block(0, n, n, m))?;

        // The best steady state z_s + d and the multiplier λ of being steady, which is the slope of the cost-to-go there:
        // H d + Gᵀλ = −g(r), G d = 0, G = (A − I, B); both are affine in the references of a quadratic cost.
        let mut optimality = DMatrix::zeros(2 * n + m, 2 * n + m);
        optimality.view_mut((0, 0), (n + m, n + m)).copy_from(&hessian);
        let mut steady = flow;
        for i in 0..n {
            steady[(i, i)] -= 1.0;
        }
        optimality.view_mut((n + m, 0), (n, n + m)).copy_from(&steady);
        optimality.view_mut((0, n + m), (n + m, n)).copy_from(&steady.transpose());
        let factors = optimality.lu();
        let respond = |gradient: &DVector<f64>| {
            let mut right = DVector::zeros(2 * n + m);
            right.rows_mut(0, n + m).copy_from(&(-gradient));
            let solution = factors.solve(&right).filter(|s| s.iter().all(|v| v.is_finite()));
            solution.ok_or(MpcError::SteadyStateNotUnique)
        };
        let here = derivatives(&references).0;
        // Where the cost is least at the point itself, nothing needs to be unique.
        let shift = if here.amax() == 0.0 { DVector::zeros(2 * n + m) } else { respond(&here)? };
        let mut slopes = Vec::new();
        for k in 0..references.len() {
            let shifted = |by: f64| {
                let mut r = references.clone();
                r[k] += by;
                r
            };
            // Central differences are exact for quadratic costs.
            slopes.push(respond(&(derivatives(&shifted(0.5)).0 - derivatives(&shifted(-0.5)).0))?);
        }
        let mut best = state.iter().chain(input).zip(shift.iter()).map(|(z, d)| z + d);
        let center: Vec<f64> = best.by_ref().take(n).collect();
        let rest: Vec<f64> = best.collect();
        let tilt: Vec<f64> = shift.iter().skip(n + m).copied().collect();
        let slope = |i: usize, k: usize| slopes[k][i];
        let tilting = |i: usize, k: usize| slopes[k][n + m + i];
        let at = Affine { at: &center, slope: &slope };
        let tilt = Affine { at: &tilt, slope: &tilting };
        self.terminal = Some(cost_to_go(&riccati.cost_to_go, &at, &tilt, &references)?);
        Ok((self, InfiniteHorizon { riccati, state: center, input: rest }))
    }

    /// (A B) of an interval at a steady state, n rows of n + m.
    fn flow_at_steady_state(
        &self,
        dynamics: &mut dyn Dynamics,
        state: &[f64],
        input: &[f64],
    ) -> Result<DMatrix<f64>, MpcError> {
        let (n, m) = (state.len(), input.len());
        let mut end = state.to_vec();
        let mut jacobian = vec![0.0; n * (n + m)];
        let interval = Interval { t: 0.0, dt: self.dt, substeps: self.substeps.least(), u: input };
        if let Some(row) = self.parameters.first() {
            dynamics.set_parameters(row);
        }
        Shooter::of_problem(dynamics, self).advance_with_sensitivity(dynamics, interval, &mut end, &mut jacobian);
        for (index, (e, x)) in end.iter().zip(state).enumerate() {
            let moved = (e - x).abs() / self.state_scale[index];
            if moved.is_nan() || moved > STEADY * (1.0 + x.abs()) {
                return Err(MpcError::NotSteady { index, name: None, moved: e - x });
            }
        }
        Ok(DMatrix::from_row_slice(n, n + m, &jacobian))
    }

    /// Largest level α of the set (x − c)ᵀP(x − c) ≤ α in which the input u_c − K(x − c) keeps its bounds and the states
    /// keep theirs, about the steady state (c, u_c): for [`TerminalSet`](crate::ocp::TerminalSet). Infinite without bounds; not
    /// positive when the steady state breaks one.
    pub fn largest_terminal_level(&self, beyond: &InfiniteHorizon) -> f64 {
        let n = self.states();
        let InfiniteHorizon { riccati, state, input } = beyond;
        let Some(factor) = riccati.cost_to_go.clone().cholesky() else { return 0.0 };
        // The largest cᵀe over eᵀPe ≤ α is √(α cᵀP⁻¹c).
        let level = |row: DVector<f64>, room: f64| {
            let reach = row.dot(&factor.solve(&row));
            if reach == 0.0 || room == f64::INFINITY { f64::INFINITY } else { room.max(0.0).powi(2) / reach }
        };
        let inputs = self
            .input_bounds
            .iter()
            .enumerate()
            .map(|(j, bound)| level(riccati.gain.row(j).transpose(), (bound.1 - input[j]).min(input[j] - bound.0)));
        let states = self.state_bounds.iter().enumerate().map(|(i, bound)| {
            let axis = DVector::from_fn(n, |k, _| f64::from(k == i));
            level(axis, (bound.max - state[i]).min(state[i] - bound.min))
        });
        inputs.chain(states).fold(f64::INFINITY, f64::min)
    }
}

/// Largest movement of a steady state over one interval, in units of its scale.
const STEADY: f64 = 1e-6;

/// A vector that follows the references: a + D (r − r_s).
struct Affine<'a> {
    at: &'a [f64],
    slope: &'a dyn Fn(usize, usize) -> f64,
}

/// (x − c)ᵀP(x − c) + λᵀ(x − c) with center c and slope λ.
fn cost_to_go(
    p: &DMatrix<f64>,
    center: &Affine<'_>,
    tilt: &Affine<'_>,
    references: &[f64],
) -> Result<CostFunction, MpcError> {
    let mut pool = Pool::new();
    let states: Vec<_> = (0..center.at.len()).map(|i| pool.symbol(&format!("x{i}"))).collect();
    let names: Vec<_> = (0..references.len()).map(|k| pool.symbol(&format!("r{k}"))).collect();
    let time = pool.symbol("t");
    let number = |pool: &mut Pool, v: f64| match Rational::try_from(v) {
        Ok(q) => Ok(pool.rational(q)),
        Err(_) => Err(MpcError::Value { what: "the terminal cost".into(), value: v, remedy: "give finite numbers" }),
    };
    let following = |pool: &mut Pool, vector: &Affine<'_>, i: usize| -> Result<Expr, MpcError> {
        let mut sum = number(pool, vector.at[i])?;
        for (k, &r) in names.iter().enumerate() {
            let (d, at) = (number(pool, (vector.slope)(i, k))?, number(pool, references[k])?);
            let r = pool.sym(r);
            let moved = pool.sub(r, at);
            let shift = pool.mul(d, moved);
            sum = pool.add(sum, shift);
        }
        Ok(sum)
    };
    let mut errors = Vec::new();
    for (i, &x) in states.iter().enumerate() {
        let c = following(&mut pool, center, i)?;
        let x = pool.sym(x);
        errors.push(pool.sub(x, c));
    }
    let mut terms = Vec::new();
    for i in 0..errors.len() {
        for j in 0..errors.len() {
            let w = number(&mut pool, p[(i, j)])?;
            let product = pool.mul(errors[i], errors[j]);
            terms.push(pool.mul(w, product));
        }
        let slope = following(&mut pool, tilt, i)?;
        terms.push(pool.mul(slope, errors[i]));
    }
    let cost = pool.sum(terms);
    CostFunction::compile(&mut pool, time, &states, &[], &names, cost)
}
