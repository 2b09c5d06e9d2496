//! The method of control that a problem needs, where its file names none.

use super::control_problem::ControlProblem;
use super::method::{Convergence, Feedback, Method, MethodReason};
use super::open_loop::Rehearsal;
use super::signs::jumps;
use super::start::Prepared;
use crate::controller::StepStatus;
use crate::error::{MpcError, check_flag};
use crate::exact_friction::StickSlipController;
use crate::integrator::Integrator;
use crate::ocp::HorizonCost;
use crate::sqp::{Solution, SolveStatus};
use crate::trajectory::PlannedTrajectory;

/// Programs after which the plan of the first one is looked at again, where there is no converged one.
const MORE_PROGRAMS: usize = 4;
/// Change of the inputs, as a share of what they may change, below which another program would not change them either.
const UNCHANGED: f64 = 1e-6;
/// Largest change of the plan, as a share of its cost or of what an input may change, with which one program per sample
/// settles.
const SETTLED: f64 = 0.01;
/// Share of its largest value below which a switching function counts as reached.
const NEAR: f64 = 0.05;

/// A plan with its cost and penalties: as predicted, and as its inputs really have it.
struct Rated {
    predicted: f64,
    real: f64,
    plan: PlannedTrajectory,
}

/// The real-time iteration, tried at the first sample.
struct Trial {
    /// Stage and terminal cost of the first plan.
    predicted: HorizonCost,
    /// The first plan, and the one to compare it with; fewer where a program fails.
    plans: Vec<Rated>,
}

impl ControlProblem {
    /// The problem with the method that it needs, and the controller of that method at its start: exact friction where friction is
    /// in reach; else a plan where the run ends with the horizon and its targets, or with all of its cost; else one program per sample where the plan settles
    /// with it; else converged solutions. What is solved on the way is not solved again.
    pub(super) fn choose_method(&self, convergence: Convergence) -> Result<(Self, Prepared), MpcError> {
        let iterations = convergence.max_iterations;
        if self.has_exact_friction() {
            let mut exact = self.with_method(Method::StickSlip { iterations }, MethodReason::Given);
            let mut controller = exact.stick_slip(iterations)?;
            let names = self.friction_in_reach(&mut controller)?;
            if !names.is_empty() {
                if let Some(planned) = self.plan_through_friction(convergence)? {
                    return Ok(planned);
                }
                exact.method_reason = MethodReason::Friction { names };
                let prepared = exact.on_exact_flow(controller)?;
                return Ok((exact, prepared));
            }
        }
        let targets = self.ends_with_targets();
        if targets || self.ends_with_cost() {
            let reason = if targets { MethodReason::Targets } else { MethodReason::TerminalCost };
            // Friction is not in reach: one width is enough.
            return Self { smoothing: self.widths(), ..self.clone() }.planned(convergence, reason);
        }
        let feedback = Feedback::default();
        let converged = self.with_method(Method::Sqp { convergence, first: feedback }, MethodReason::Given);
        let mut sqp = converged.solver()?;
        // By the interior-point method, a converged plan takes less than the programs that would show whether the first one settles.
        let plan =
            if sqp.prepare_interior_point() { Some(converged.first_solution(&mut sqp, feedback)?) } else { None };
        let reference = plan.as_ref().filter(|plan| is_solved(plan)).map(|plan| &plan.trajectory);
        let trial = self.try_one_program(feedback, self.start(), reference)?;
        let change = self.change(&trial, feedback, reference.is_none())?;
        // Programs that agree with each other show nothing where the solution that they are to agree with was not found.
        let comparable = reference.is_some() || plan.is_none();
        let single = |reason| -> Result<(Self, Prepared), MpcError> {
            let problem = self.with_method(Method::Rti { initial_iterations: 1, feedback }, reason);
            let controller = Box::new(problem.receding(feedback, problem.start())?);
            Ok((problem, Prepared { controller, plan: None, predicted: trial.predicted }))
        };
        if let Some(change) = change.filter(|c| comparable && *c <= SETTLED) {
            return single(MethodReason::Settled { change });
        }
        let solution = match plan {
            Some(plan) => plan,
            None => converged.first_solution(&mut sqp, feedback)?,
        };
        let solution = converged.best_first_solution(&mut sqp, solution)?;
        if !is_solved(&solution) {
            return single(MethodReason::NotConverging);
        }
        let prepared = converged.converged(sqp, solution)?;
        Ok((Self { method_reason: MethodReason::NotSettled { change }, ..converged }, prepared))
    }

    /// Whether the run ends with the horizon and its targets, or with constraints of its end.
    fn ends_with_targets(&self) -> bool {
        let ocp = &self.ocp;
        let at_end = !ocp.targets.is_empty() || ocp.path_constraints.iter().any(|c| c.at_end);
        at_end && self.samples <= ocp.steps && ocp.is_uniform()
    }

    /// Whether the run ends with the horizon, and the cost is terminal only.
    fn ends_with_cost(&self) -> bool {
        let ocp = &self.ocp;
        ocp.stage.is_none() && ocp.terminal.is_some() && self.samples == ocp.steps && ocp.is_uniform()
    }

    /// The problem with a plan that is tracked to its end.
    fn planned(&self, convergence: Convergence, reason: MethodReason) -> Result<(Self, Prepared), MpcError> {
        let feedback = Feedback { guarded: true, ..Feedback::default() };
        let method = Method::Plan { convergence, margin: 0.0, feedback };
        let plan = self.with_method(method, reason);
        let prepared = plan.tracker(0.0, feedback)?;
        Ok((plan, prepared))
    }

    /// The same through dry friction, where the inputs of the plan reach the targets on the exact flow too: a horizon that moves on
    /// does not arrive.
    fn plan_through_friction(&self, convergence: Convergence) -> Result<Option<(Self, Prepared)>, MpcError> {
        // A constraint has no tolerance to judge the exact motion by.
        if self.ocp.targets.is_empty() || !self.ends_with_targets() {
            return Ok(None);
        }
        let (problem, prepared) = self.planned(convergence, MethodReason::Targets)?;
        let Some(mut motion) = prepared.plan.as_ref().map(|plan| plan.trajectory.clone()) else { return Ok(None) };
        let cost = Rehearsal::exact(&problem)?.cost(&mut motion);
        let end = motion.x(motion.steps());
        // The linear weight of a target is the inverse of its tolerance.
        let met = self.ocp.targets.iter().all(|t| (end[t.state] - t.value).abs() * t.linear <= 1.0);
        Ok((met && cost.is_finite()).then_some((problem, prepared)))
    }

    fn with_method(&self, method: Method, method_reason: MethodReason) -> Self {
        Self { method, method_reason, ..self.clone() }
    }

    /// Whether the controller's model has friction that the exact flow treats.
    fn has_exact_friction(&self) -> bool {
        // The exact flow has one state of sticking and slipping, not one per branch.
        self.ocp.integrator == Integrator::Rk4 && self.ocp.branching.is_none() && !self.system.is_smooth()
    }

    /// The arguments of `sign` that vanish or change their sign along the first plan, as it is with smoothed friction.
    fn friction_in_reach(&self, controller: &mut StickSlipController) -> Result<Vec<String>, MpcError> {
        let mut system = self.system.clone();
        let (names, surfaces): (Vec<String>, Vec<_>) = jumps(&mut system).into_iter().unzip();
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let mut arguments = vec![system.pool.symbol("t")];
        arguments.extend(system.states.iter().chain(&system.inputs));
        // A switching function of another one has its sign in it; along a plan the outer one alone says enough.
        let Ok(tape) = system.compile(&arguments, &surfaces) else { return Ok(names) };
        let plan = controller.smoothed_plan(&self.initial_state())?;
        let mut work = Vec::new();
        let mut values = vec![0.0; names.len()];
        let mut extent = vec![(0.0_f64, f64::INFINITY, false); names.len()];
        let mut before: Option<Vec<f64>> = None;
        for k in 0..plan.steps() {
            let mut at = vec![self.ocp.time(0, k)];
            at.extend(plan.x(k)[..self.ocp.model_states()].iter().chain(plan.u(k)));
            tape.eval(&at, &mut work, &mut values);
            for (i, v) in values.iter().enumerate() {
                let crossed = before.as_ref().is_some_and(|b| b[i] * v <= 0.0);
                extent[i] = (extent[i].0.max(v.abs()), extent[i].1.min(v.abs()), extent[i].2 || crossed);
            }
            before = Some(values.clone());
        }
        // Where there is no plan to look at, friction is not ruled out.
        let reached =
            extent.iter().map(|(most, least, crossed)| *crossed || *least <= NEAR * most || !most.is_finite());
        Ok(names.into_iter().zip(reached).filter(|(_, reached)| *reached).map(|(name, _)| name).collect())
    }

    /// The first plan of the real-time iteration, and the converged one, or where there is none, the one after more programs.
    fn try_one_program(
        &self,
        feedback: Feedback,
        start: PlannedTrajectory,
        converged: Option<&PlannedTrajectory>,
    ) -> Result<Trial, MpcError> {
        let mut rti = self.receding(feedback, start)?;
        let mut ocp = self.ocp.clone();
        let mut rehearsal = Rehearsal::smoothed(self)?;
        let mut trial = Trial { predicted: HorizonCost::NONE, plans: Vec::new() };
        let mut rated = |mut plan: PlannedTrajectory| {
            let costs = ocp.costs(0, &plan);
            let predicted = costs.total() + ocp.penalty(0, &plan, self.qp.hard_weight);
            // What its inputs really cost shows how far the plan is from the dynamics.
            let real = rehearsal.cost(&mut plan);
            (costs, Rated { predicted, real, plan })
        };
        for programs in [1, MORE_PROGRAMS] {
            if let (false, Some(plan)) = (trial.plans.is_empty(), converged) {
                // Where a model is unstable, a roll-out leaves even a converged plan.
                let Rated { predicted, plan, .. } = rated(plan.clone()).1;
                trial.plans.push(Rated { predicted, real: predicted, plan });
                break;
            }
            for _ in 0..programs {
                check_flag(&self.stop)?;
                let before = rti.trajectory().clone();
                if matches!(rti.feedback(&self.initial_state())?.status, StepStatus::Fallback(_)) {
                    return Ok(trial);
                }
                if self.differ(&before, rti.trajectory()) <= UNCHANGED {
                    break;
                }
            }
            let (costs, plan) = rated(rti.trajectory().clone());
            if trial.plans.is_empty() {
                trial.predicted = costs;
            }
            trial.plans.push(plan);
        }
        Ok(trial)
    }

    /// How much the plan of the first program differs from the other one, as a share of the cost of its inputs or of what an input
    /// may change; none where a program fails. A plan that stays at the guess is looked at from beside it, too, unless the other is
    /// converged: programs do not leave a guess that is stationary, but no minimum. There is none for smooth equations then.
    fn change(&self, trial: &Trial, feedback: Feedback, look_beside: bool) -> Result<Option<f64>, MpcError> {
        let [first, later] = &trial.plans[..] else { return Ok(None) };
        // Roll-outs that end nowhere settle nothing.
        let differ = |a: f64, b: f64| {
            let share = (a - b).abs() / a.abs().max(b.abs()).max(f64::MIN_POSITIVE);
            if share.is_nan() { f64::INFINITY } else { share }
        };
        let mut change = differ(first.predicted, first.real).max(differ(first.real, later.real));
        change = change.max(self.moved(first.plan.u(0), later.plan.u(0)));
        let steps = first.plan.steps();
        if look_beside && change <= SETTLED && self.stays((0..steps).map(|k| first.plan.u(k))) {
            if self.system.is_smooth() {
                // Programs leave negative curvature out and may come back to a maximum; converged plans from waves do not.
                return Ok(None);
            }
            let beside = self.try_one_program(feedback, self.waves(), None)?;
            let [_, other] = &beside.plans[..] else { return Ok(None) };
            change = change.max(self.differ(&first.plan, &other.plan));
        }
        Ok(Some(change).filter(|c| c.is_finite()))
    }

    /// Largest difference of two inputs, in units of what an input may change.
    fn moved(&self, a: &[f64], b: &[f64]) -> f64 {
        let inputs = a.iter().zip(b).zip(&self.ocp.input_trust);
        inputs.fold(0.0, |most: f64, ((a, b), trust)| most.max((a - b).abs() / trust))
    }

    /// The same over two plans.
    fn differ(&self, a: &PlannedTrajectory, b: &PlannedTrajectory) -> f64 {
        (0..a.steps()).fold(0.0, |most: f64, k| most.max(self.moved(a.u(k), b.u(k))))
    }
}

/// Whether a plan is one to follow: a hard bound that cannot be kept is said elsewhere.
fn is_solved(solution: &Solution) -> bool {
    matches!(solution.status, SolveStatus::Converged | SolveStatus::Infeasible { .. })
}
