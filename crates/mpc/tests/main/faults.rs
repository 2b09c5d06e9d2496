//! Closed loops in which something fails: the named policy decides, the counts say what happened.

use crate::common::double_integrator;
use approx::assert_relative_eq;
use bracketry_mpc::closed_loop::{ClosedLoop, DelayCompensated, Fault, LoopSettings, RungeKuttaPlant};
use bracketry_mpc::controller::{Brake, FailurePolicy, FallbackReason, InputSource, StepStatus};
use bracketry_mpc::estimation::{Estimate, EstimateStatus, Estimator, OutputFeedback};
use bracketry_mpc::ocp::{Bounds, Softness};
use bracketry_mpc::sqp::SqpController;
use bracketry_mpc::{
    Controller, CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings,
    SymbolicDynamics, run_closed_loop,
};

const DT: f64 = 0.1;
const STEPS: usize = 20;

fn dynamics() -> Box<SymbolicDynamics> {
    Box::new(SymbolicDynamics::new(&double_integrator()).unwrap())
}

fn problem() -> Ocp {
    let system = double_integrator();
    let mut ocp = Ocp::new(2, 1, STEPS, DT);
    let cost = |kind, text| Some(CostFunction::parse(&system, kind, &["goal"], text).unwrap());
    ocp.stage = cost(CostKind::Stage, "(p - goal)^2 + 0.1*v^2 + 0.1*u^2");
    ocp.terminal = cost(CostKind::Terminal, "3*(p - goal)^2 + v^2");
    ocp.references = vec![vec![0.0]];
    ocp.input_bounds = vec![(-1.0, 1.0)];
    ocp
}

fn rti(ocp: Ocp, settings: RtiSettings) -> Rti {
    Rti::new(dynamics(), ocp, PlannedTrajectory::constant(STEPS, &[0.0; 2], &[0.0]), settings).unwrap()
}

/// A run from (1, 0) in which `faults` happen at the samples it names.
fn run(controller: &mut dyn Controller, samples: usize, faults: impl Fn(usize) -> Vec<Fault>) -> ClosedLoop {
    let settings = LoopSettings { faults: Some(Box::new(faults)), ..LoopSettings::default() };
    let mut plant = RungeKuttaPlant::new(dynamics(), 1);
    let run = run_closed_loop(controller, &mut plant, &[1.0, 0.0], samples, settings).unwrap();
    let bounds = controller.ocp().input_bounds[0];
    assert!(run.u.iter().all(|u| bounds.0 <= u[0] && u[0] <= bounds.1));
    assert_eq!(run.counts.samples(), samples);
    assert_eq!(run.counts.reasons.total(), run.counts.fallback);
    assert_eq!(run.counts.sources.total(), samples);
    run
}

/// Samples 10, 11 and 12 suffer from the fault.
fn three(fault: &Fault) -> impl Fn(usize) -> Vec<Fault> + '_ {
    |k| if (10..13).contains(&k) { vec![fault.clone()] } else { Vec::new() }
}

fn assert_home(run: &ClosedLoop) {
    let end = run.x.last().unwrap();
    assert!(end.iter().all(|v| v.abs() < 1e-3), "{end:?}");
}

#[test]
fn every_fault_is_counted_by_its_reason_and_the_plan_takes_over() {
    type Count = fn(&ClosedLoop) -> usize;
    let cases: [(Fault, FallbackReason, Count); 4] = [
        (Fault::LostSample, FallbackReason::LostSample, |r| r.counts.reasons.lost_sample),
        (Fault::NotANumber { outputs: vec![1] }, FallbackReason::Measurement, |r| r.counts.reasons.measurement),
        (Fault::SolverLimit(1), FallbackReason::Qp(bracketry_mpc::qp::QpStatus::Limit), |r| r.counts.reasons.qp_limit),
        (Fault::TimeLimit(1e-9), FallbackReason::TimeLimit, |r| r.counts.reasons.time_limit),
    ];
    for (fault, reason, count) in cases {
        let run = run(&mut rti(problem(), RtiSettings::default()), 120, three(&fault));
        assert_eq!((run.counts.fallback, count(&run), run.counts.sources.plan), (3, 3, 3), "{fault:?}");
        assert_eq!(run.steps[11].status, StepStatus::Fallback(reason));
        assert_eq!(run.steps[11].source, InputSource::Plan);
        assert_eq!(run.steps[13].status, StepStatus::Solved);
        assert_home(&run);
    }
}

#[test]
fn the_converging_controller_survives_the_same_faults() {
    for fault in [Fault::LostSample, Fault::NotANumber { outputs: vec![0] }, Fault::SolverLimit(1)] {
        let sqp = Sqp::new(dynamics(), problem(), SqpSettings::default()).unwrap();
        let mut controller = SqpController::new(sqp, PlannedTrajectory::constant(STEPS, &[0.0; 2], &[0.0]));
        let run = run(&mut controller, 120, three(&fault));
        assert_eq!((run.counts.fallback, run.counts.sources.plan), (3, 3), "{fault:?}");
        assert_home(&run);
    }
}

#[test]
fn a_plan_is_used_up_after_its_length_and_feedback_takes_over_again() {
    let settings = RtiSettings { rest_input: vec![0.01], ..RtiSettings::default() };
    let lost = |k| if (5..35).contains(&k) { vec![Fault::LostSample] } else { Vec::new() };
    let run = run(&mut rti(problem(), settings), 160, lost);
    // The program of sample 4 plans the inputs of samples 4 … 23.
    for (k, step) in run.steps.iter().enumerate() {
        let expected = match k {
            5..24 => InputSource::Plan,
            24..35 => InputSource::Rest,
            _ => InputSource::Program,
        };
        assert_eq!(step.source, expected, "sample {k}");
    }
    assert!(run.steps[24..35].iter().all(|s| s.u == [0.01]));
    assert_home(&run);
}

#[test]
fn the_brake_stops_the_mass_on_the_shortest_way_and_holds_it() {
    let brakes = vec![Brake { input: 0, velocity: 1, rate: 1.0 / DT }];
    let policy = FailurePolicy::BrakeToRest { after: 2, brakes };
    let settings = RtiSettings { policy, ..RtiSettings::default() };
    let lost = |k| if k >= 5 { vec![Fault::LostSample] } else { Vec::new() };
    let run = run(&mut rti(problem(), settings), 40, lost);
    assert_eq!((run.counts.sources.program, run.counts.sources.plan, run.counts.sources.brake), (5, 2, 33));
    // After the two planned inputs the full input brakes until the rest is less than one sample's worth.
    let v = run.x[7][1];
    let full = (v.abs() / DT).floor() as usize;
    for k in 7..7 + full {
        assert_relative_eq!(run.u[k][0], -v.signum(), epsilon = 1e-9);
    }
    assert!(v.abs() > 0.1 && run.x[7 + full + 1][1].abs() < 1e-12);
    assert_relative_eq!(run.x[40][0], run.x[7 + full + 1][0], epsilon = 1e-12);
}

#[test]
fn the_policy_of_rest_applies_its_input_at_once() {
    let settings = RtiSettings { policy: FailurePolicy::RestInput, ..RtiSettings::default() };
    let run = run(&mut rti(problem(), settings), 120, three(&Fault::LostSample));
    assert_eq!((run.counts.sources.rest, run.counts.sources.plan), (3, 0));
    assert!(run.u[10..13].iter().all(|u| u == &[0.0]));
    assert_home(&run);
}

#[test]
fn bounds_that_cannot_be_kept_are_counted_until_they_are_kept_again() {
    let mut ocp = problem();
    ocp.state_bounds[0] = Bounds { min: -10.0, max: 1.2, softness: Softness::Hard };
    let blow = |k| if k == 20 { vec![Fault::Disturbance(vec![3.0, 0.5])] } else { Vec::new() };
    let run = run(&mut rti(ocp, RtiSettings::default()), 160, blow);
    assert_eq!(run.counts.fallback, 0);
    for (k, step) in run.steps.iter().enumerate() {
        // A program is infeasible when even the position at the end of its first interval is too large.
        let next = run.x[k][0] + DT * run.x[k][1] + DT * DT / 2.0 * step.u[0];
        let expected = if next > 1.2 + 1e-3 { StepStatus::Infeasible } else { StepStatus::Solved };
        assert_eq!(step.status, expected, "sample {k} on the way to {next}");
    }
    assert!(run.counts.infeasible > 5);
    assert_home(&run);
}

#[test]
fn a_hundredfold_disturbance_is_made_up_for() {
    let blow = |k| if k == 20 { vec![Fault::Disturbance(vec![100.0, -10.0])] } else { Vec::new() };
    let run = run(&mut rti(problem(), RtiSettings::default()), 900, blow);
    assert_eq!(run.counts.solved, 900);
    assert_home(&run);
}

#[test]
fn a_pole_falls_and_is_caught_again_after_a_hundredfold_blow() {
    let system = crate::common::cart_pole();
    let mut ocp = Ocp::new(4, 1, 40, 0.02);
    ocp.stage = Some(
        CostFunction::parse(&system, CostKind::Stage, &[], "100*p^2 + 100*th^2 + 0.1*v^2 + 0.1*w^2 + 1e-3*u^2")
            .unwrap(),
    );
    ocp.input_bounds = vec![(-80.0, 80.0)];
    let model = || Box::new(SymbolicDynamics::new(&system).unwrap());
    let start = PlannedTrajectory::constant(40, &[0.0; 4], &[0.0]);
    let mut rti = Rti::new(model(), ocp, start, RtiSettings::default()).unwrap();
    // Ordinary pushes change w by 0.05 rad/s; this one by 5 rad/s, with every fourth sample lost.
    let faults = |k: usize| {
        let mut faults = vec![Fault::Disturbance(vec![0.0, 0.0, 0.0, if k == 50 { 5.0 } else { 0.05 }])];
        if k % 4 == 3 {
            faults.push(Fault::LostSample);
        }
        if k >= 150 { Vec::new() } else { faults }
    };
    let settings = LoopSettings { faults: Some(Box::new(faults)), ..LoopSettings::default() };
    let mut plant = RungeKuttaPlant::new(model(), 2);
    let run = run_closed_loop(&mut rti, &mut plant, &[0.0; 4], 1000, settings).unwrap();
    assert_eq!(run.counts.reasons.lost_sample, 37);
    assert_eq!(run.counts.samples(), 1000);
    let end = run.x.last().unwrap();
    assert!(end.iter().all(|v| v.abs() < 1e-3), "{end:?}");
}

#[test]
fn a_compensated_delay_is_the_undelayed_loop_from_where_the_first_inputs_lead() {
    let delay = 3;
    let mut plain = rti(problem(), RtiSettings::default());
    // Three intervals with u = 0.5 from (1, 0).
    let start = [1.0 + 0.5 * 0.5 * 0.09, 0.15];
    let mut plant = RungeKuttaPlant::new(dynamics(), 1);
    let undelayed = run_closed_loop(&mut plain, &mut plant, &start, 40, LoopSettings::default()).unwrap();
    let inside = rti(problem(), RtiSettings::default());
    let mut compensated = DelayCompensated::new(inside, dynamics(), delay, &[0.5]).unwrap();
    let settings = LoopSettings { delay, initial_input: vec![0.5], ..LoopSettings::default() };
    let run = run_closed_loop(&mut compensated, &mut plant, &[1.0, 0.0], 40 + delay, settings).unwrap();
    for k in 0..=40 {
        for i in 0..2 {
            assert_relative_eq!(run.x[k + delay][i], undelayed.x[k][i], epsilon = 1e-6);
        }
    }
    assert_eq!(compensated.controller().start(), 40 + 2 * delay);
}

#[test]
fn a_delay_that_nobody_compensates_costs_more() {
    let mut cost = [0.0; 2];
    for (i, compensate) in [true, false].into_iter().enumerate() {
        let inside = rti(problem(), RtiSettings::default());
        let mut controller: Box<dyn Controller> = if compensate {
            Box::new(DelayCompensated::new(inside, dynamics(), 4, &[0.0]).unwrap())
        } else {
            Box::new(inside)
        };
        let settings = LoopSettings { delay: 4, ..LoopSettings::default() };
        let mut plant = RungeKuttaPlant::new(dynamics(), 1);
        cost[i] = run_closed_loop(controller.as_mut(), &mut plant, &[1.0, 0.0], 150, settings).unwrap().cost;
    }
    assert!(cost[1] > 1.1 * cost[0], "{cost:?}");
}

/// Differentiates a measured position, and notes what it is given.
struct Differentiator {
    last: f64,
    inputs: Vec<f64>,
    corrections: usize,
}

impl Estimator for Differentiator {
    fn correct_into(&mut self, y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        self.corrections += 1;
        self.last = y[0];
        *estimate = Estimate {
            x: vec![y[0], 0.0],
            parameters: Vec::new(),
            disturbance: Vec::new(),
            std: Vec::new(),
            status: EstimateStatus::Updated { lost: 0 },
        };
        Ok(())
    }
    fn update_into(&mut self, u: &[f64], y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        self.inputs.push(u[0]);
        // Exact for a constant input: v = Δp/dt + u·dt/2.
        let v = (y[0] - self.last) / DT + u[0] * DT / 2.0;
        self.corrections -= 1;
        self.correct_into(y, estimate)?;
        estimate.x[1] = v;
        Ok(())
    }
}

#[test]
fn an_estimator_gets_the_applied_inputs_and_makes_states_of_outputs() {
    let delay = 2;
    let inside = rti(problem(), RtiSettings::default());
    let compensated = DelayCompensated::new(inside, dynamics(), delay, &[0.0]).unwrap();
    let estimator = Differentiator { last: 0.0, inputs: Vec::new(), corrections: 0 };
    let mut controller = OutputFeedback::new(compensated, estimator, false, delay, &[0.0]).unwrap();
    let settings = LoopSettings { measurement: Some(Box::new(|_, x| vec![x[0]])), delay, ..LoopSettings::default() };
    let mut plant = RungeKuttaPlant::new(dynamics(), 1);
    let run = run_closed_loop(&mut controller, &mut plant, &[1.0, 0.0], 120, settings).unwrap();
    let estimator = controller.estimator();
    assert_eq!(estimator.corrections, 1);
    assert_eq!(estimator.inputs.len(), 119);
    for k in 0..119 {
        assert_eq!(estimator.inputs[k], run.u[k][0]);
        assert_relative_eq!(run.estimates[k + 1][1], run.x[k + 1][1], epsilon = 1e-9);
        assert_eq!(run.y[k].len(), 1);
    }
    assert_home(&run);
}

#[test]
fn a_skipped_sample_is_skipped_behind_a_delay_too() {
    let estimator = Differentiator { last: 0.0, inputs: Vec::new(), corrections: 0 };
    let inside = OutputFeedback::new(rti(problem(), RtiSettings::default()), estimator, false, 0, &[0.0]).unwrap();
    let mut controller = DelayCompensated::new(inside, dynamics(), 1, &[0.0]).unwrap();
    let u = controller.step(&[1.0, 0.0]).unwrap().u;
    controller.skip().unwrap();
    assert_eq!(controller.controller().estimator().inputs, u);
}

#[test]
fn references_and_bounds_can_change_while_the_loop_runs() {
    let mut controller = rti(problem(), RtiSettings::default());
    run(&mut controller, 100, |_| Vec::new());
    controller.set_references(vec![vec![0.5]]).unwrap();
    let mut plant = RungeKuttaPlant::new(dynamics(), 1);
    let there = run_closed_loop(&mut controller, &mut plant, &[0.0; 2], 120, LoopSettings::default()).unwrap();
    assert_relative_eq!(there.x[120][0], 0.5, epsilon = 1e-3);
    controller.set_bounds(vec![Bounds::FREE; 2], vec![(-0.2, f64::INFINITY)]).unwrap();
    controller.set_references(vec![vec![0.0]]).unwrap();
    let back = run_closed_loop(&mut controller, &mut plant, &[0.5, 0.0], 200, LoopSettings::default()).unwrap();
    assert_relative_eq!(back.x[200][0], 0.0, epsilon = 1e-3);
    let least = back.u.iter().map(|u| u[0]).fold(f64::INFINITY, f64::min);
    assert_relative_eq!(least, -0.2, epsilon = 1e-6);
}

#[test]
fn a_change_that_contradicts_the_problem_is_refused_and_changes_nothing() {
    let mut controller = rti(problem(), RtiSettings::default());
    assert!(matches!(controller.set_references(Vec::new()), Err(MpcError::Length { .. })));
    assert!(matches!(
        controller.set_bounds(vec![Bounds::FREE; 2], vec![(1.0, -1.0)]),
        Err(MpcError::EmptyBounds { .. })
    ));
    assert!(matches!(controller.set_target(0, 1.0), Err(MpcError::Length { found: 0, expected: 1, .. })));
    assert!(matches!(controller.set_parameters(&[1.0]), Err(MpcError::Length { found: 1, expected: 0, .. })));
    let run = run(&mut controller, 120, |_| Vec::new());
    assert_eq!(run.counts.solved, 120);
    assert_home(&run);
}

#[test]
fn settings_out_of_range_are_errors() {
    let refused = |settings: RtiSettings| {
        Rti::new(dynamics(), problem(), PlannedTrajectory::constant(STEPS, &[0.0; 2], &[0.0]), settings).err().unwrap()
    };
    let brake = |b: Brake| RtiSettings {
        policy: FailurePolicy::BrakeToRest { after: 0, brakes: vec![b] },
        ..RtiSettings::default()
    };
    let good = Brake { input: 0, velocity: 1, rate: 1.0 };
    assert!(matches!(refused(brake(Brake { velocity: 2, ..good })), MpcError::NoSuchState { index: 2, states: 2 }));
    assert!(matches!(refused(brake(Brake { input: 1, ..good })), MpcError::Length { .. }));
    assert!(matches!(refused(brake(Brake { rate: f64::NAN, ..good })), MpcError::Value { .. }));
    assert!(matches!(refused(RtiSettings { rest_input: vec![2.0], ..RtiSettings::default() }), MpcError::Value { .. }));
    assert!(matches!(refused(RtiSettings { time_limit: 0.0, ..RtiSettings::default() }), MpcError::Value { .. }));
    assert!(matches!(refused(RtiSettings { iterations: 0, ..RtiSettings::default() }), MpcError::Value { .. }));
}

#[test]
fn the_input_of_rest_is_the_one_closest_to_zero_where_zero_is_forbidden() {
    let mut ocp = problem();
    ocp.input_bounds = vec![(0.25, 1.0)];
    let settings = RtiSettings { policy: FailurePolicy::RestInput, ..RtiSettings::default() };
    let run = run(&mut rti(ocp, settings), 5, |_| vec![Fault::LostSample]);
    assert!(run.u.iter().all(|u| u == &[0.25]));
}
