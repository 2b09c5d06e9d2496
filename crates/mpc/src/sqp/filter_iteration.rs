//! Sequential quadratic programming globalized by a filter.
//!
//! Steps are whole where the filter allows it, if need be after a second-order correction, and shortened otherwise. Where the
//! linearization was a poor guide, or no step is acceptable, a proximal term grows; its size follows the change that the
//! programs promise, so that it does not depend on the unit of the cost.
//!
//! The iteration ends when a program promises too little, or without that program where its promise is known: dᵀHd of two whole
//! steps in a row tells the rate at which the iteration contracts, and so what is left of the change of the objective; the
//! defects of the last step are evaluated anyway, and the multipliers tell what removing them changes.
//!
//! Where programs fail, the defects are removed by simulating the inputs (feasibility restoration).

use super::filter::{Filter, Verdict};
use super::solution::Iteration;
use super::solver::Sqp;
use crate::error::{MpcError, check_flag};
use crate::qp::QpStatus;
use crate::trajectory::Trajectory;
use crate::transcription::Merit;

/// Factor by which the proximal weight grows when no step is acceptable, and falls after a whole step.
const GROWTH: f64 = 8.0;
const SHRINKAGE: f64 = 5.0;
/// Factor by which it grows when the linearization was a poor guide.
const DAMPING: f64 = 2.0;
/// Proximal weight after the first program without that fails, relative to what counts.
const FIRST_PROXIMAL: f64 = 1e-2;
/// Programs in a row without an acceptable step before the defects are removed by simulation.
const PATIENCE: usize = 4;
/// Shortest fraction of a step that is tried.
const SHORTEST: f64 = 0.1;
/// Largest defect after a step, in units of the state scale, that a second-order correction is tried on: farther away, the
/// corrected step leads as far astray as the other.
const CORRECTABLE: f64 = 1e-2;
/// Ratio of what two whole steps in a row cost by curvature below which the iteration counts as contracting.
const CONTRACTING: f64 = 0.1;
/// Programs in a row without an acceptable step.
const MAX_FAILURES: usize = 12;

impl Sqp {
    /// Whether the method converges at the smoothing width that is set, for the log `width`; if not, the trajectory is the last one if its merit is less than at first, else as it
    /// was.
    pub(crate) fn filter_method(
        &mut self,
        z: &mut Trajectory,
        width: f64,
        log: &mut Vec<Iteration>,
    ) -> Result<bool, MpcError> {
        let s = self.settings.clone();
        let mut at = z.clone();
        let steps = at.steps();
        self.problem.choose_substeps(&at);
        self.problem.linearize(&at, 0, steps, &mut self.lin);
        let mut now = self.problem.merit_with(&at, &self.lin.end, s.qp.hard_weight);
        let first = now;
        let mut filter = Filter::new(&now);
        let mut restored = false;
        let mut failures = 0;
        let (mut lambda, mut weight) = (0.0_f64, 0.0_f64);
        // A proximal weight of this size counts: the term is as large as the change of the objective when every input moves by
        // its trust.
        let mut unit = 1.0_f64;
        // ½ dᵀHd of the last step, if it was a whole one of a program without proximal term.
        let mut last_curvature = None;
        for _ in 0..s.filter_iterations {
            check_flag(&s.stop)?;
            let proximal = if lambda < s.min_proximal { 0.0 } else { lambda };
            self.assemble(&at, proximal);
            let qp = self.qp.solve()?;
            let mut line = self.line(width, &now, proximal, qp);
            if !qp.is_usable() {
                log.push(line);
                last_curvature = None;
                if !restored && self.restore(&mut at, &mut now) {
                    restored = true;
                    filter = Filter::new(&now);
                    continue;
                }
                if qp == QpStatus::NotANumber || failures > MAX_FAILURES {
                    break;
                }
                failures += 1;
                lambda = (lambda * GROWTH).max(FIRST_PROXIMAL * unit);
                continue;
            }
            let (mut trial, mut after) = self.trial(&at, 1.0);
            let promised = now.objective - after.objective;
            if promised.is_finite() {
                unit = promised.abs().min(now.objective.abs()) / (steps as f64 * self.problem.ocp.dt);
            }
            if promised.abs() <= s.tolerance * now.objective.abs().max(1e-12) && now.worst_defect <= s.defect_tolerance
            {
                line.predicted = promised;
                log.push(line);
                // The last step is still worth taking unless it leaves the tolerance.
                *z = if after.worst_defect <= s.defect_tolerance { trial } else { at };
                return Ok(true);
            }
            weight = self.problem.penalty_weight(&self.qp.solution.multipliers).max(0.8 * weight);
            let curvature = self.curvature();
            let mut fraction = 1.0;
            let mut verdict = filter.judge(&now, &after, promised);
            let correctable = s.second_order_correction && self.is_curved(&now, &after);
            if verdict == Verdict::Rejected && correctable {
                let step = self.qp.solution.clone();
                self.qp.correct(&mut self.problem.ocp, self.problem.k0, &trial, &self.problem.ends, &self.lin);
                let qp = self.qp.solve()?;
                log.push(line);
                line.correction = true;
                (line.qp, line.qp_iterations) = (qp, self.qp.solution.iterations);
                if qp.is_usable() {
                    (trial, after) = self.trial(&at, 1.0);
                    verdict = filter.judge(&now, &after, promised);
                }
                self.qp.solution = step;
            }
            while verdict == Verdict::Rejected && fraction > SHORTEST {
                fraction /= 2.0;
                (trial, after) = self.trial(&at, fraction);
                verdict = filter.judge(&now, &after, fraction * promised);
            }
            line.predicted = now.value(weight) - now.objective + fraction * promised;
            line.ratio = (now.value(weight) - after.value(weight)) / line.predicted.max(f64::MIN_POSITIVE);
            let ratio = line.ratio;
            line.fraction = if verdict == Verdict::Rejected { 0.0 } else { fraction };
            log.push(line);
            if verdict == Verdict::Rejected {
                failures += 1;
                last_curvature = None;
                lambda = (lambda * GROWTH).max(FIRST_PROXIMAL * unit);
                let infeasible = now.worst_defect > s.defect_tolerance;
                if failures == PATIENCE && infeasible && !restored && self.restore(&mut at, &mut now) {
                    restored = true;
                    filter = Filter::new(&now);
                    lambda = 0.0;
                }
                if failures > MAX_FAILURES {
                    break;
                }
                continue;
            }
            if verdict == Verdict::Progress {
                filter.add(&now);
            }
            failures = 0;
            at = trial;
            now = after;
            let whole = fraction == 1.0 && proximal == 0.0 && !line.correction && line.qp == QpStatus::Solved;
            if let Some(before) = last_curvature.replace(curvature).filter(|_| whole) {
                let contraction = curvature / before;
                let promise = contraction * curvature.max(promised.abs()) + self.price_of_defects(&at);
                if contraction <= CONTRACTING
                    && promise <= s.tolerance * now.objective.abs().max(1e-12)
                    && now.worst_defect <= s.defect_tolerance
                    && !self.has_curved_constraints()
                {
                    *z = at;
                    return Ok(true);
                }
            }
            if !whole {
                last_curvature = None;
            }
            self.problem.linearize(&at, 0, steps, &mut self.lin);
            if fraction == 1.0 && ratio > 0.7 {
                lambda /= SHRINKAGE;
            } else if fraction < 0.3 || ratio < 0.25 {
                lambda = (lambda * DAMPING).max(FIRST_PROXIMAL * unit);
            }
        }
        if now.value(weight) < first.value(weight) {
            *z = at;
        }
        Ok(false)
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
    fn price_of_defects(&self, z: &Trajectory) -> f64 {
        let n = z.states();
        let (y, ends) = (&self.qp.solution.multipliers, &self.problem.ends);
        y.iter().zip(ends).enumerate().map(|(i, (y, end))| (y * (end - z.x(i / n + 1)[i % n])).abs()).sum()
    }

    /// Feasibility restoration: the trajectory of the same inputs, which has no defects, unless the dynamics leave the numbers
    /// on the way.
    fn restore(&mut self, z: &mut Trajectory, now: &mut Merit) -> bool {
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
    pub(crate) fn trial(&mut self, z: &Trajectory, fraction: f64) -> (Trajectory, Merit) {
        let mut trial = z.moved(fraction, &self.qp.solution.dx, &self.qp.solution.du);
        trial.clamp_inputs(&self.problem.ocp.input_bounds);
        let merit = self.problem.merit(&trial, self.settings.qp.hard_weight);
        (trial, merit)
    }
}
