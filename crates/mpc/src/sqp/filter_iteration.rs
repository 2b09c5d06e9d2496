//! Sequential quadratic programming globalized by a filter.
//!
//! Steps are whole where the filter allows it, if need be after a second-order correction, and shortened otherwise. Where no
//! step is acceptable, or only a short one, a proximal term grows; its size follows the change that the programs promise, so that
//! it does not depend on the unit of the cost.
//!
//! Where the choice of the Hessian is automatic, the first steps have that of Gauss and Newton, which leads far; what has not
//! converged by then goes on with that of the Lagrangian, which converges quadratically.
//!
//! The iteration ends when a program promises too little, or without that program where its promise is known: dᵀHd of two whole
//! steps in a row tells the rate at which the iteration contracts, and so what is left of the change of the objective; the
//! defects of the last step are evaluated anyway, and the multipliers tell what removing them changes.
//!
//! Where the filter accepts no step, the defects alone decide until they are smaller than ever (feasibility restoration). Where a
//! program fails, they are removed by simulating the inputs.

use super::filter::{Filter, Verdict, WIDEST};
use super::solution::Iteration;
use super::solver::{Sqp, Stop};
use crate::error::{MpcError, check_flag};
use crate::qp::QpStatus;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::Merit;

/// Factor by which the proximal weight grows when no step is acceptable, and falls after a whole step.
const GROWTH: f64 = 8.0;
const SHRINKAGE: f64 = 5.0;
/// Factor by which it grows when the step had to be shortened to less than a third.
const DAMPING: f64 = 2.0;
/// Proximal weight after the first program without that fails, relative to what counts.
const FIRST_PROXIMAL: f64 = 1e-2;
/// Programs in a row without an acceptable step before the Hessian is changed.
const PATIENCE: usize = 4;
/// Shortest fraction of a step that is tried.
const SHORTEST: f64 = 0.01;
/// The same where only the defects count, and the share of what the linearization promises of them that has to be removed.
const SHORTEST_RESTORATION: f64 = 1e-3;
const RESTORED: f64 = 0.1;
/// Steps with the Gauss–Newton Hessian after which an automatic choice falls on the exact one, and the largest defect at which it
/// does; farther away, where its multipliers mean less, after more.
const GAUSS_NEWTON_STEPS: usize = 8;
const NEAR: f64 = 0.1;
const FAR_STEPS: usize = 50;
/// Curvature of a step, relative to the change of the objective, below which the program counts as linear.
const FLAT: f64 = 1e-2;
/// Largest defect after a step, in units of the state scale, that a second-order correction is tried on: farther away, the
/// corrected step leads as far astray as the other.
const CORRECTABLE: f64 = 1e-2;
/// Ratio of what two whole steps in a row cost by curvature below which the iteration counts as contracting.
const CONTRACTING: f64 = 0.1;
/// Largest step of states and inputs that counts as none, in units of their sizes.
const STILL: f64 = 1e-7;
/// Programs in a row without an acceptable step.
const MAX_FAILURES: usize = 12;

/// The iteration at work.
struct Iterate {
    at: PlannedTrajectory,
    now: Merit,
    filter: Filter,
    /// Whether the defects were removed by simulation.
    restored: bool,
    /// Programs in a row without an acceptable step.
    failures: usize,
    /// Weight of the proximal term.
    lambda: f64,
    /// Weight of the defects in the merit.
    weight: f64,
    /// A proximal weight of this size counts: the term is as large as the change of the objective when every input moves by
    /// its trust.
    unit: f64,
    /// ½ dᵀHd of the last step, if it was a whole one of a program without proximal term.
    curvature: Option<f64>,
    /// Steps with the Gauss–Newton Hessian.
    gauss_newton: usize,
    /// Whether the proximal term was left out at the end, to see whether it was all that kept steps short.
    confirmed: bool,
}

impl Iterate {
    fn damp(&mut self, factor: f64) {
        self.lambda = (self.lambda * factor).max(FIRST_PROXIMAL * self.unit);
    }

    /// After feasibility restoration.
    fn restart(&mut self) {
        self.restored = true;
        self.filter = Filter::new(&self.now, WIDEST[0]);
    }
}

/// A fraction of a program's step.
struct Step {
    end: PlannedTrajectory,
    merit: Merit,
    fraction: f64,
    /// Decrease of the objective that the whole step promised.
    promised: f64,
    verdict: Verdict,
}

/// What follows a program.
enum Next {
    Program,
    Converged,
    Failed(Stop),
}

impl Sqp {
    /// How the method ends at the smoothing width that is set, for the log `width`, with defects no larger than `widest` and so many programs. Where it
    /// does not converge, the trajectory is the last one if its merit is less than at first, else as it was.
    pub(super) fn filter_method(
        &mut self,
        z: &mut PlannedTrajectory,
        width: f64,
        (widest, programs): (f64, usize),
        log: &mut Vec<Iteration>,
    ) -> Result<Stop, MpcError> {
        self.problem.choose_substeps(z);
        self.problem.linearize(z, 0, z.steps(), &mut self.lin);
        let first = self.problem.merit_with(z, &self.lin.end, self.settings.qp.hard_weight);
        let mut run = Iterate {
            at: self.spare.copy(z),
            now: first,
            filter: Filter::with_entries(self.spare.entries(), &first, widest),
            restored: false,
            failures: 0,
            lambda: 0.0,
            weight: 0.0,
            unit: 1.0,
            curvature: None,
            gauss_newton: 0,
            confirmed: false,
        };
        let mut end = Stop::Limit;
        for _ in 0..programs {
            check_flag(&self.settings.stop)?;
            match self.filter_step(&mut run, width, log)? {
                Next::Program => {}
                Next::Converged => {
                    end = Stop::Converged;
                    break;
                }
                Next::Failed(stop) => {
                    end = stop;
                    break;
                }
            }
        }
        self.spare.give_entries(run.filter.into_entries());
        if end == Stop::Converged || run.now.value(run.weight) < first.value(run.weight) {
            self.spare.replace(z, run.at);
        } else {
            self.spare.give(run.at);
        }
        Ok(end)
    }

    /// One program and its step.
    fn filter_step(&mut self, run: &mut Iterate, width: f64, log: &mut Vec<Iteration>) -> Result<Next, MpcError> {
        let proximal = if run.lambda < self.settings.min_proximal { 0.0 } else { run.lambda };
        self.assemble(&run.at, proximal);
        let qp = self.qp.solve()?;
        let mut line = self.line(width, &run.now, proximal, qp);
        if !qp.is_usable() {
            log.push(line);
            return self.after_failure(run, qp);
        }
        let whole = self.trial(&run.at, 1.0);
        let promised = run.now.objective - whole.1.objective;
        if promised.is_finite() {
            let horizon = self.problem.ocp.offset(run.at.steps());
            run.unit = promised.abs().min(run.now.objective.abs()) / horizon;
        }
        if self.is_within_tolerance(promised.abs(), &run.now) && proximal > 0.0 && !run.confirmed {
            // The proximal term may be all that keeps the step short.
            run.confirmed = true;
            run.lambda = 0.0;
            line.predicted = promised;
            log.push(line);
            self.spare.give(whole.0);
            return Ok(Next::Program);
        }
        // A proximal term makes any step small.
        let near = proximal == 0.0 && run.now.worst_defect <= self.settings.defect_tolerance;
        if near && self.is_still() || self.is_within_tolerance(promised.abs(), &run.now) {
            line.predicted = promised;
            log.push(line);
            // The last step is still worth taking unless it leaves the tolerance.
            if whole.1.worst_defect <= self.settings.defect_tolerance {
                self.spare.replace(&mut run.at, whole.0);
            } else {
                self.spare.give(whole.0);
            }
            return Ok(Next::Converged);
        }
        run.weight = self.problem.penalty_weight(&self.qp.solution.multipliers).max(0.8 * run.weight);
        let curvature = self.curvature();
        let step = self.search(run, whole, promised, &mut line, log)?;
        let rejected = step.verdict == Verdict::Rejected;
        line.predicted = run.now.value(run.weight) - run.now.objective + step.fraction * promised;
        line.ratio = (run.now.value(run.weight) - step.merit.value(run.weight)) / line.predicted.max(f64::MIN_POSITIVE);
        line.fraction = if rejected { 0.0 } else { step.fraction };
        log.push(line);
        if rejected {
            self.spare.give(step.end);
            self.after_rejection(run)
        } else {
            self.take(run, step, curvature, &line)
        }
    }

    /// The whole step, if need be after a correction of second order, else the longest fraction that the filter accepts. Where it
    /// accepts none because of what the objective was before, the longest one that removes its share of the defects, until they are
    /// smaller than ever (feasibility restoration).
    fn search(
        &mut self,
        run: &Iterate,
        (mut end, mut merit): (PlannedTrajectory, Merit),
        promised: f64,
        line: &mut Iteration,
        log: &mut Vec<Iteration>,
    ) -> Result<Step, MpcError> {
        let (at, now) = (&run.at, &run.now);
        let mut fraction = 1.0;
        let mut verdict = run.filter.judge(now, &merit, promised);
        let correctable = self.settings.second_order_correction && self.is_curved(now, &merit);
        if verdict == Verdict::Rejected && correctable {
            let step = self.qp.solution.clone();
            self.qp.correct(&mut self.problem.ocp, self.problem.k0, &end, &self.problem.ends, &self.lin);
            let qp = self.qp.solve()?;
            log.push(*line);
            line.correction = true;
            (line.qp, line.qp_iterations) = (qp, self.qp.solution.iterations);
            if qp.is_usable() {
                self.try_again(at, 1.0, &mut end, &mut merit);
                verdict = run.filter.judge(now, &merit, promised);
            }
            self.qp.solution = step;
        }
        while verdict == Verdict::Rejected && fraction > SHORTEST {
            fraction /= 2.0;
            self.try_again(at, fraction, &mut end, &mut merit);
            verdict = run.filter.judge(now, &merit, fraction * promised);
        }
        if verdict == Verdict::Rejected && now.worst_defect > self.settings.defect_tolerance {
            fraction = 1.0;
            while fraction > SHORTEST_RESTORATION {
                self.try_again(at, fraction, &mut end, &mut merit);
                if merit.objective.is_finite() && merit.defects <= (1.0 - RESTORED * fraction) * now.defects {
                    verdict = Verdict::Progress;
                    break;
                }
                fraction /= 2.0;
            }
        }
        Ok(Step { end, merit, fraction, promised, verdict })
    }

    /// After a program without a solution.
    fn after_failure(&mut self, run: &mut Iterate, qp: QpStatus) -> Result<Next, MpcError> {
        run.curvature = None;
        if self.is_exact() && self.change_hessian()? {
            run.gauss_newton = 0;
            run.failures += 1;
            return Ok(if run.failures > MAX_FAILURES { Next::Failed(Stop::QpFailed(qp)) } else { Next::Program });
        }
        if !run.restored
            && (qp == QpStatus::NotANumber || run.failures >= PATIENCE)
            && self.restore(&mut run.at, &mut run.now)
        {
            run.restart();
            return Ok(Next::Program);
        }
        if qp == QpStatus::NotANumber || run.failures > MAX_FAILURES {
            return Ok(Next::Failed(Stop::QpFailed(qp)));
        }
        run.failures += 1;
        run.damp(GROWTH);
        Ok(Next::Program)
    }

    /// After a program no fraction of whose step is acceptable.
    fn after_rejection(&mut self, run: &mut Iterate) -> Result<Next, MpcError> {
        run.failures += 1;
        run.curvature = None;
        run.damp(GROWTH);
        if run.failures == PATIENCE && self.change_hessian()? {
            run.gauss_newton = 0;
            run.lambda = 0.0;
        }
        Ok(if run.failures > MAX_FAILURES { Next::Failed(Stop::Stalled) } else { Next::Program })
    }

    /// Takes an acceptable step, of a program whose whole step has the given curvature.
    fn take(&mut self, run: &mut Iterate, step: Step, curvature: f64, line: &Iteration) -> Result<Next, MpcError> {
        let Step { end, merit, fraction, promised, verdict } = step;
        if verdict == Verdict::Progress {
            run.filter.add(&run.now);
        }
        run.failures = 0;
        self.spare.replace(&mut run.at, end);
        run.now = merit;
        let whole = fraction == 1.0 && line.proximal == 0.0 && !line.correction && line.qp == QpStatus::Solved;
        if let Some(before) = run.curvature.replace(curvature).filter(|_| whole) {
            let contraction = curvature / before;
            let promise = contraction * curvature.max(promised.abs()) + self.price_of_defects(&run.at);
            if contraction <= CONTRACTING
                && self.is_within_tolerance(promise, &run.now)
                && !self.has_curved_constraints()
            {
                return Ok(Next::Converged);
            }
        }
        if !whole {
            run.curvature = None;
        }
        self.problem.linearize(&run.at, 0, run.at.steps(), &mut self.lin);
        if !self.is_exact() {
            run.gauss_newton += 1;
            let near = run.now.worst_defect < NEAR;
            let slow = run.gauss_newton >= if near { GAUSS_NEWTON_STEPS } else { FAR_STEPS };
            if slow && self.change_hessian()? {
                run.curvature = None;
            }
        }
        // Whether the merit fell says little while iterates pass through large defects: the filter decides. A program without
        // curvature, however, goes as far as its bounds let it, and has no other measure of how far its linearization is good.
        let flat = curvature <= FLAT * promised.abs();
        if fraction < 0.3 || (flat && line.ratio < 0.25) {
            run.damp(DAMPING);
        } else if fraction == 1.0 && !(flat && line.ratio < 0.7) {
            run.lambda /= SHRINKAGE;
        }
        Ok(Next::Program)
    }

    /// Whether a change of the objective is negligible, and the defects are.
    fn is_within_tolerance(&self, change: f64, now: &Merit) -> bool {
        change <= self.settings.tolerance * now.objective.abs().max(1e-12)
            && now.worst_defect <= self.settings.defect_tolerance
    }

    /// Whether the program's step is negligible in units of the sizes: at rest, where the cost vanishes, no change is small beside it.
    fn is_still(&self) -> bool {
        let (ocp, step) = (&self.problem.ocp, &self.qp.solution);
        let small = |step: &[f64], sizes: &[f64]| {
            let mut all = step.iter().zip(sizes.iter().cycle());
            all.all(|(d, size)| d.abs() <= STILL * if size.is_finite() { *size } else { 1.0 })
        };
        small(&step.dx, ocp.sizes()) && small(&step.du, &ocp.input_trust)
    }

    /// Whether the defects, or the violations of curved constraints, may be why a step is not acceptable, and are small enough
    /// for a correction of second order.
    fn is_curved(&self, now: &Merit, after: &Merit) -> bool {
        let close = after.worst_defect <= CORRECTABLE && after.objective.is_finite();
        close && (after.defects > now.defects || self.has_curved_constraints())
    }

    fn has_curved_constraints(&self) -> bool {
        let ocp = &self.problem.ocp;
        !ocp.path_constraints.is_empty() || !ocp.norm_constraints.is_empty()
    }

    /// ½ dᵀHd of the program's step: what a step to the solution gains.
    fn curvature(&self) -> f64 {
        let (program, step) = self.qp.stage_program();
        let term = |((i, j), h): ((usize, usize), f64)| if i == j { 0.5 * h } else { h } * step[i] * step[j];
        program.hessian().map(term).sum()
    }

    /// What removing the defects of the trajectory whose merit was computed last may change in the objective, to first order.
    fn price_of_defects(&self, z: &PlannedTrajectory) -> f64 {
        let n = z.states();
        let (y, ends) = (&self.qp.solution.multipliers, &self.problem.ends);
        y.iter().zip(ends).enumerate().map(|(i, (y, end))| (y * (end - z.x(i / n + 1)[i % n])).abs()).sum()
    }

    /// Feasibility restoration: the trajectory of the same inputs, which has no defects, unless the dynamics leave the numbers
    /// on the way.
    fn restore(&mut self, z: &mut PlannedTrajectory, now: &mut Merit) -> bool {
        let mut simulated = z.clone();
        self.problem.roll_out(&mut simulated);
        self.problem.shooter.take_failure();
        if !simulated.is_finite() {
            return false;
        }
        self.problem.linearize(&simulated, 0, simulated.steps(), &mut self.lin);
        *now = self.problem.merit_with(&simulated, &self.lin.end, self.settings.qp.hard_weight);
        *z = simulated;
        now.objective.is_finite()
    }

    /// The iterate after a fraction of the program's step, with its inputs within their bounds.
    pub(crate) fn trial(&mut self, z: &PlannedTrajectory, fraction: f64) -> (PlannedTrajectory, Merit) {
        let mut trial = self.spare.copy(z);
        trial.add(fraction, &self.qp.solution.dx, &self.qp.solution.du);
        trial.clamp_inputs(&self.problem.ocp.input_bounds);
        self.problem.ocp.start_as_decided(&mut trial);
        let merit = self.problem.merit(&trial, self.settings.qp.hard_weight);
        (trial, merit)
    }

    /// Another fraction of the step in the place of one that was tried before.
    fn try_again(&mut self, z: &PlannedTrajectory, fraction: f64, end: &mut PlannedTrajectory, merit: &mut Merit) {
        let (trial, found) = self.trial(z, fraction);
        self.spare.replace(end, trial);
        *merit = found;
    }
}
