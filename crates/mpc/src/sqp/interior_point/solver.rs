//! The iteration.

use super::super::filter::{Filter, Verdict, WIDEST};
use super::direction::{Direction, Model, System, corrected};
use super::iterate::{Evaluator, Iterate, Values};
use crate::error::{MpcError, check_flag};
use crate::ocp::FINEST_ROUNDING;
use crate::qp::NonlinearProgram;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{Merit, Transcription};
use bracketry_symbolic::StopFlag;

/// Most steps.
const STEPS: usize = 250;
/// First barriers. A large one keeps the first steps from the bounds, which leads to better solutions from far away; a small one stays near a
/// guess that is good. In this order.
pub(crate) const BARRIERS: [f64; 3] = [0.1, 1.0, 1e-3];
/// The error relative to the barrier at which it falls, and how it does.
const CENTERED: f64 = 10.0;
const FALL: f64 = 0.2;
/// The first width of norms, as a share of their sizes.
const WIDEST_ROUNDING: f64 = 0.1;
/// The last barrier, relative to the tolerance.
const LEAST_BARRIER: f64 = 0.1;
/// What all distances may cost at the end, relative to the objective; where they cost more, the objective gets another unit if that is so
/// much smaller.
const GAP: f64 = 1e-6;
const RESCALED: f64 = 2.0;
const FASTER_FALL: f64 = 1.5;
/// Least share of its way to zero that a distance may go.
const BOUNDARY: f64 = 0.99;
/// Distance of the start from its bounds, in units of their size.
const PUSH: f64 = 1e-2;
/// What is acceptable where more steps do not help: error, relative to the tolerance and at most; steps in a row with it, and the largest
/// relative change of the objective by one of them.
const ACCEPTABLE: f64 = 1e3;
const LARGEST_ACCEPTABLE: f64 = 1e-5;
const ACCEPTABLE_STEPS: usize = 10;
const UNCHANGED: f64 = 1e-7;
/// Largest slope of the objective at the start, in units of the sizes.
const STEEPEST: f64 = 100.0;
/// Largest multiplier of the dynamics that is estimated at the start.
const LARGEST_ESTIMATE: f64 = 1e3;
/// How far the multiplier of a distance may be from what the barrier asks for.
const SPREAD: f64 = 1e10;
/// Corrections of second order of one step, and the share of the infeasibility that one has to remove.
const CORRECTIONS: usize = 4;
const CORRECTED: f64 = 0.99;
/// Shortest fraction of a step.
const SHORTEST: f64 = 1e-5;
/// Fraction of an almost feasible step below which curvature is added first: how often, how much in units of the sizes, by which factor it grows and
/// falls from try to try and from step to step.
const SHORT: f64 = 0.1;
const DAMPED: usize = 4;
const FIRST_DAMPING: f64 = 1e-6;
const SMALLEST_DAMPING: f64 = 1e-8;
const DAMPING: f64 = 10.0;
const SHRINKAGE: f64 = 5.0;

/// A solution.
pub(crate) struct InteriorSolution {
    pub(crate) trajectory: PlannedTrajectory,
    /// Multipliers of the dynamics, and of all rows of the stage program.
    pub(crate) multipliers: Vec<f64>,
    pub(crate) row_multipliers: Vec<f64>,
    /// Number of steps.
    pub(crate) steps: usize,
    /// How far it is from the conditions of optimality, without units.
    pub(crate) error: f64,
}

/// The method at work.
pub(crate) struct InteriorPoint<'a> {
    pub(super) of: Evaluator<'a>,
    pub(super) system: System,
    pub(super) filter: Filter,
    pub(super) first: Merit,
    pub(super) at: Iterate,
    pub(super) now: Values,
    pub(super) barrier: f64,
    /// Width of the norms of the cost as a share of their sizes: it falls with the barrier, which keeps first steps from the edges of norms too.
    rounding: f64,
    /// Whether the inputs were simulated in place of a restoration.
    pub(super) simulated: bool,
    /// Curvature that was added because steps were short.
    damping: f64,
    tolerance: f64,
}

/// The factor of an objective with this largest slope.
fn factor_for(steepest: f64) -> f64 {
    if steepest > STEEPEST { STEEPEST / steepest } else { 1.0 }
}

impl Iterate {
    pub(super) fn moved(&self, d: &Direction, fraction: f64) -> Self {
        let add = |a: &[f64], d: &[f64]| a.iter().zip(d).map(|(a, d)| a + fraction * d).collect();
        let z = self.z.moved(fraction, &d.dx, &d.du);
        Self { z, s: add(&self.s, &d.ds), t: add(&self.t, &d.dt), y: self.y.clone(), v: self.v.clone() }
    }
}

impl<'a> InteriorPoint<'a> {
    /// Solves from a guess whose first state is the initial one; `None` where the method does not converge.
    ///
    /// # Errors
    /// Where it is stopped.
    pub(crate) fn solve(
        problem: &mut Transcription,
        program: &mut NonlinearProgram,
        field: &[(usize, usize)],
        guess: &PlannedTrajectory,
        settings: (f64, f64, &StopFlag),
    ) -> Result<Option<InteriorSolution>, MpcError> {
        let solution = InteriorPoint::iterate(problem, program, field, guess, settings);
        problem.ocp.round_norms(FINEST_ROUNDING);
        solution
    }

    fn iterate(
        problem: &'a mut Transcription,
        program: &'a mut NonlinearProgram,
        field: &'a [(usize, usize)],
        guess: &PlannedTrajectory,
        (barrier, tolerance, stop): (f64, f64, &StopFlag),
    ) -> Result<Option<InteriorSolution>, MpcError> {
        problem.choose_substeps(guess);
        let Some(mut method) = Self::start(Evaluator::new(problem, program, field), guess, (barrier, tolerance)) else {
            return Ok(None);
        };
        let (mut acceptable, mut objective) = (0, f64::INFINITY);
        for steps in 0..STEPS {
            check_flag(stop)?;
            method.now = method.of.differentiate(&method.at, true);
            let error = method.of.error(&method.at, &method.now, 0.0);
            let gap: f64 = method.at.t.iter().zip(&method.at.v).map(|(t, v)| t * v).sum();
            let small = gap <= GAP * method.now.objective.abs();
            if error <= tolerance && (!small && method.rescale() || method.round_norms(FALL * method.rounding)) {
                continue;
            }
            if error <= tolerance {
                return Ok(Some(method.solution(steps, error)));
            }
            let change = (method.now.objective - objective).abs();
            objective = method.now.objective;
            let unchanged = change <= UNCHANGED * objective.abs();
            let near = error <= (ACCEPTABLE * tolerance).min(LARGEST_ACCEPTABLE);
            acceptable = if near && unchanged { acceptable + 1 } else { 0 };
            if acceptable == ACCEPTABLE_STEPS {
                return Ok(Some(method.solution(steps, error)));
            }
            if !error.is_finite() {
                return Ok(None);
            }
            method.lower_barrier();
            if method.round_norms(method.barrier) {
                method.now = method.of.differentiate(&method.at, true);
            }
            if !method.step() {
                return Ok(None);
            }
        }
        Ok(None)
    }

    fn start(of: Evaluator<'a>, guess: &PlannedTrajectory, (barrier, tolerance): (f64, f64)) -> Option<Self> {
        let (n, m, steps) = (guess.states(), guess.inputs(), guess.steps());
        let mut z = guess.clone();
        for (j, &(low, high)) in of.problem.ocp.input_bounds.iter().enumerate() {
            // The range of an input may be much smaller than its size; without one, it is no variable.
            let push = PUSH * of.program.size(n + j).min(high - low);
            (0..steps).for_each(|k| z.u_mut(k)[j] = z.u(k)[j].clamp(low + push, high - push));
        }
        of.problem.ocp.start_as_decided(&mut z);
        for (j, state) in of.problem.ocp.carried() {
            let value = z.u(0)[j];
            for k in 0..steps {
                z.u_mut(k)[j] = value;
                z.x_mut(k + 1)[state] = value;
            }
        }
        let s: Vec<f64> = of.program.slacks.iter().map(|p| PUSH * p.scale).collect();
        let v = of.program.rows.iter().map(|row| 1.0 / row.scale).collect();
        let at = Iterate { z, s, t: Vec::new(), y: vec![0.0; n * steps], v };
        let rounding = if of.problem.ocp.round_norms(WIDEST_ROUNDING) { WIDEST_ROUNDING } else { FINEST_ROUNDING };
        let mut method = Self {
            of,
            system: System::new(n, m, steps),
            filter: Filter::new(&Merit { objective: 0.0, defects: 0.0, worst_defect: 0.0 }, WIDEST[0]),
            first: Merit { objective: 0.0, defects: 0.0, worst_defect: 0.0 },
            at,
            now: Values::default(),
            barrier,
            rounding,
            simulated: false,
            damping: 0.0,
            tolerance,
        };
        method.at.t = method.distances(&method.at.z.clone(), &method.at.s.clone());
        method.now = method.of.differentiate(&method.at, false);
        let steepest = method.of.steepest();
        method.of.factor = factor_for(steepest);
        if !(steepest.is_finite() && method.now.is_finite()) {
            return None;
        }
        method.estimate_multipliers();
        method.now = method.of.values(&method.at);
        method.first = method.merit();
        method.filter = Filter::new(&method.first, WIDEST[0]);
        Some(method)
    }

    /// Rounds norms by no more than this share of their sizes; false where they are as sharp.
    fn round_norms(&mut self, share: f64) -> bool {
        let share = share.max(FINEST_ROUNDING);
        if share >= self.rounding {
            return false;
        }
        self.rounding = share;
        self.of.problem.ocp.round_norms(share);
        self.filter = Filter::new(&self.first, WIDEST[0]);
        true
    }

    /// Gives the objective the unit that fits where the iterate is; false where it has it. A target that costs much from afar makes that of the
    /// start too large for the cost of meeting it.
    fn rescale(&mut self) -> bool {
        let ratio = factor_for(self.of.steepest() / self.of.factor) / self.of.factor;
        if ratio < RESCALED {
            return false;
        }
        self.of.factor *= ratio;
        self.barrier *= ratio;
        self.at.y.iter_mut().chain(&mut self.at.v).for_each(|v| *v *= ratio);
        self.first.objective *= ratio;
        self.filter = Filter::new(&self.first, WIDEST[0]);
        true
    }

    /// Distances of constraints from their bounds, where there are too small ones larger.
    pub(super) fn distances(&mut self, z: &PlannedTrajectory, s: &[f64]) -> Vec<f64> {
        let c = self.of.constraints(z, s);
        c.iter().zip(&self.of.program.rows).map(|(c, row)| c.max(PUSH * row.scale)).collect()
    }

    pub(super) fn merit(&self) -> Merit {
        self.now.merit(&self.at.t, self.barrier)
    }

    /// Multipliers of the dynamics that come closest to the conditions of optimality with those of the rows; zero where they are large.
    pub(super) fn estimate_multipliers(&mut self) {
        self.of.differentiate(&self.at, false);
        let mut point = self.at.clone();
        // Distances count as given: their rows add forces alone.
        point.v.fill(0.0);
        let n = self.of.states();
        self.at.y.fill(0.0);
        if self.system.factorize(&self.of, &point, Model::Distance(1.0), 0.0).is_none() {
            return;
        }
        self.system.slope = self.of.gradient();
        let w = self.of.width();
        for (i, v) in self.at.v.iter().enumerate() {
            let block = self.of.program.rows[i].k * w;
            self.of.program.row(i).for_each(|(place, a)| self.system.slope[block + place] -= a * v);
        }
        let zero = (vec![0.0; self.at.y.len()], vec![0.0; self.at.t.len()]);
        let d = self.system.solve(&self.of, &point, 0.0, (&zero.0, &zero.1));
        let largest = d.y.iter().enumerate().map(|(i, y)| (y * self.of.program.size(i % n)).abs()).fold(0.0, f64::max);
        if largest <= LARGEST_ESTIMATE {
            self.at.y = d.y;
        }
    }

    fn lower_barrier(&mut self) {
        let least = self.tolerance * LEAST_BARRIER;
        let before = self.barrier;
        while self.barrier > least && self.of.error(&self.at, &self.now, self.barrier) <= CENTERED * self.barrier {
            self.barrier = (FALL * self.barrier).min(self.barrier.powf(FASTER_FALL)).max(least);
        }
        if self.barrier < before {
            self.filter = Filter::new(&self.first, WIDEST[0]);
        }
    }

    /// Longest fraction of a step that leaves enough of every distance.
    pub(super) fn longest(&self, t: &[f64], dt: &[f64]) -> f64 {
        let share = BOUNDARY.max(1.0 - self.barrier);
        t.iter().zip(dt).filter(|(_, d)| **d < 0.0).fold(1.0, |f: f64, (t, d)| f.min(-share * t / d))
    }

    /// One step; false where there is none.
    fn step(&mut self) -> bool {
        let mut least = if self.damping > SMALLEST_DAMPING { self.damping } else { 0.0 };
        for tries in 0..=DAMPED {
            let Some(shift) = self.system.factorize(&self.of, &self.at, Model::Lagrangian, least) else { break };
            let residuals = (self.now.defects.as_slice(), self.now.residuals.as_slice());
            let d = self.system.solve(&self.of, &self.at, self.barrier, residuals);
            let finite = d.dx.iter().chain(&d.du).chain(&d.dt).all(|v| v.is_finite());
            let narrow = self.filter.is_narrow(&self.merit());
            let shortest = if narrow && tries < DAMPED { SHORT } else { SHORTEST };
            if finite && self.search(&d, shortest) {
                self.damping = if tries > 0 { shift } else { self.damping } / SHRINKAGE;
                return true;
            }
            if !narrow {
                break;
            }
            // The model is not good as far as it leads.
            least = (DAMPING * shift).max(FIRST_DAMPING);
        }
        self.now.infeasibility > self.tolerance && self.restore()
    }

    /// Looks for a fraction of the step that the filter accepts.
    fn search(&mut self, d: &Direction, shortest: f64) -> bool {
        let now = self.merit();
        let promised = -self.system.slope_along(d, &self.at, self.barrier);
        let whole = self.longest(&self.at.t, &d.dt);
        let mut fraction = whole;
        while fraction > shortest * whole {
            let trial = self.at.moved(d, fraction);
            let values = self.of.values(&trial);
            let merit = values.merit(&trial.t, self.barrier);
            let verdict = self.filter.judge(&now, &merit, fraction * promised);
            if verdict != Verdict::Rejected {
                self.take(trial, values, d, fraction, verdict);
                return true;
            }
            if fraction == whole
                && values.is_finite()
                && merit.defects >= now.defects
                && self.correct(d, fraction, promised, &values)
            {
                return true;
            }
            fraction /= 2.0;
        }
        false
    }

    /// Corrections of second order of a step.
    fn correct(&mut self, d: &Direction, fraction: f64, promised: f64, trial: &Values) -> bool {
        let now = self.merit();
        let (mut defects, mut residuals) = corrected(&self.now, trial, fraction);
        let mut infeasibility = trial.infeasibility;
        for _ in 0..CORRECTIONS {
            let c = self.system.solve(&self.of, &self.at, self.barrier, (&defects, &residuals));
            let whole = self.longest(&self.at.t, &c.dt);
            let end = self.at.moved(&c, whole);
            let values = self.of.values(&end);
            if !values.is_finite() {
                return false;
            }
            let verdict = self.filter.judge(&now, &values.merit(&end.t, self.barrier), fraction * promised);
            if verdict != Verdict::Rejected {
                self.take(end, values, &Direction { y: d.y.clone(), dv: d.dv.clone(), ..c }, whole, verdict);
                return true;
            }
            if values.infeasibility > CORRECTED * infeasibility {
                return false;
            }
            infeasibility = values.infeasibility;
            let rest = Values { defects, residuals, ..Values::default() };
            (defects, residuals) = corrected(&rest, &values, whole);
        }
        false
    }

    /// Takes a step with the multipliers that belong to it.
    fn take(&mut self, mut end: Iterate, values: Values, d: &Direction, fraction: f64, verdict: Verdict) {
        if verdict == Verdict::Progress {
            self.filter.add(&self.merit());
        }
        end.y.iter_mut().zip(&d.y).for_each(|(y, to)| *y += fraction * (to - *y));
        let of_multipliers = self.longest(&self.at.v, &d.dv);
        for ((v, dv), t) in end.v.iter_mut().zip(&d.dv).zip(&end.t) {
            let central = self.barrier / t;
            *v = (*v + of_multipliers * dv).clamp(central / SPREAD, central * SPREAD);
        }
        (self.at, self.now) = (end, values);
    }

    fn solution(self, steps: usize, error: f64) -> InteriorSolution {
        let factor = self.of.factor;
        let mut row_multipliers = vec![0.0; self.of.program.all_rows()];
        for (row, v) in self.of.program.rows.iter().zip(&self.at.v) {
            row_multipliers[row.number] = v / factor;
        }
        let multipliers = self.at.y.iter().map(|y| y / factor).collect();
        let mut trajectory = self.at.z;
        trajectory.clamp_inputs(&self.of.problem.ocp.input_bounds);
        self.of.problem.ocp.start_as_decided(&mut trajectory);
        InteriorSolution { trajectory, multipliers, row_multipliers, steps, error }
    }
}
