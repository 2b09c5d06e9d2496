//! Programs solved ahead of the measurement.

use approx::assert_relative_eq;
use bracketry_mpc::closed_loop::{LoopSettings, RungeKuttaPlant};
use bracketry_mpc::controller::InputSource;
use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::rti::Preparation;
use bracketry_mpc::{
    CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings, SymbolicDynamics,
    TerminalTarget, run_closed_loop,
};
use bracketry_system::System;
use std::f64::consts::PI;

const STEPS: usize = 40;

/// Cart-pole near the upright position with a weak input, a soft bound and a target: inequalities are active.
fn problem() -> (System, Ocp) {
    let system = crate::common::cart_pole();
    let mut ocp = Ocp::new(4, 1, STEPS, 0.02);
    ocp.substeps = Substeps::Fixed(1);
    let cost = |kind, text| Some(CostFunction::parse(&system, kind, &[], text).unwrap());
    ocp.stage = cost(CostKind::Stage, "10*p^2 + 50*th^2 + 0.3*th*u + 0.1*v^2 + 0.1*w^2 + 1e-2*u^2");
    ocp.terminal = cost(CostKind::Terminal, "100*p^2 + 100*th^2 + v^2 + w^2");
    ocp.input_bounds = vec![(-6.0, 6.0)];
    ocp.state_bounds[2] = Bounds { min: -0.5, max: 0.5, softness: Softness::Soft { linear: 20.0, quadratic: 5.0 } };
    ocp.targets = vec![TerminalTarget { state: 3, value: 0.0, linear: 0.5, quadratic: 0.1 }];
    (system, ocp)
}

fn dynamics(system: &System) -> Box<SymbolicDynamics> {
    Box::new(SymbolicDynamics::new(system).unwrap())
}

/// The converged first input from `x`.
fn converged(x: &[f64]) -> f64 {
    let (system, ocp) = problem();
    let settings = SqpSettings { tolerance: 1e-12, ..SqpSettings::default() };
    let mut sqp = Sqp::new(dynamics(&system), ocp, settings).unwrap();
    sqp.solve(x, &PlannedTrajectory::constant(STEPS, x, &[0.0])).unwrap().trajectory.u(0)[0]
}

/// A controller that stands before its second sample; its model predicts that the second sample finds `predicted`.
fn before_the_second_sample(preparation: Preparation) -> (Rti, Vec<f64>) {
    let (system, ocp) = problem();
    let x0 = [0.3, 0.1, 0.0, 0.0];
    let mut sqp = Sqp::new(dynamics(&system), ocp.clone(), SqpSettings::default()).unwrap();
    let plan = sqp.solve(&x0, &PlannedTrajectory::constant(STEPS, &x0, &[0.0])).unwrap().trajectory;
    let settings = RtiSettings { preparation, ..RtiSettings::default() };
    let mut rti = Rti::new(dynamics(&system), ocp, plan, settings).unwrap();
    rti.feedback(&x0).unwrap();
    let predicted = rti.trajectory().x(1).to_vec();
    rti.shift();
    rti.prepare().unwrap();
    (rti, predicted)
}

#[test]
fn the_solution_ahead_is_the_converged_one_for_the_predicted_state() {
    let (mut rti, predicted) = before_the_second_sample(Preparation::AdvancedStepTangential { programs: 8 });
    let step = rti.feedback(&predicted).unwrap().clone();
    assert_eq!(step.source, InputSource::Tangent);
    assert_relative_eq!(step.u[0], converged(&predicted), epsilon = 1e-4);
}

#[test]
fn the_tangential_predictor_is_the_derivative_of_the_converged_solution() {
    let (_, predicted) = before_the_second_sample(Preparation::Linearize);
    let base = converged(&predicted);
    assert!(base.abs() < 5.9, "the first input is free to move: {base}");
    for i in 0..4 {
        for h in [1e-3, -1e-3] {
            let mut x = predicted.clone();
            x[i] += h;
            let (mut rti, _) = before_the_second_sample(Preparation::AdvancedStepTangential { programs: 8 });
            let step = rti.feedback(&x).unwrap();
            assert_eq!(step.source, InputSource::Tangent);
            // The remainder of a derivative is quadratic in h; the input itself changes by up to 0.1.
            assert_relative_eq!(step.u[0], converged(&x), epsilon = 2e-3);
        }
    }
}

#[test]
fn a_blow_that_leads_out_of_the_bounds_is_answered_by_a_program() {
    let (mut rti, mut x) = before_the_second_sample(Preparation::AdvancedStepTangential { programs: 3 });
    x[3] += 2.0;
    let step = rti.feedback(&x).unwrap().clone();
    assert_eq!(step.source, InputSource::Program);
    let (mut plain, _) = before_the_second_sample(Preparation::AdvancedStep { programs: 3 });
    assert_relative_eq!(step.u[0], plain.feedback(&x).unwrap().u[0], epsilon = 1e-9);
}

#[test]
fn a_lost_sample_gets_the_solution_for_the_predicted_state() {
    let (mut rti, predicted) = before_the_second_sample(Preparation::AdvancedStep { programs: 8 });
    let step = rti.feedback(&[f64::NAN; 4]).unwrap();
    assert_eq!(step.source, InputSource::Plan);
    assert_relative_eq!(step.u[0], converged(&predicted), epsilon = 1e-4);
}

/// Cost of the swing-up of the published benchmark from a cold start.
fn swing_up(preparation: Preparation) -> (f64, usize) {
    let system = crate::common::cart_pole();
    let mut ocp = Ocp::new(4, 1, STEPS, 0.02);
    ocp.substeps = Substeps::Fixed(1);
    let cost = |kind, text| Some(CostFunction::parse(&system, kind, &[], text).unwrap());
    ocp.stage = cost(CostKind::Stage, "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2");
    ocp.terminal = cost(CostKind::Terminal, "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2");
    ocp.input_bounds = vec![(-80.0, 80.0)];
    let x0 = [0.0, PI, 0.0, 0.0];
    let settings = RtiSettings { preparation, ..RtiSettings::default() };
    let start = PlannedTrajectory::constant(STEPS, &x0, &[0.0]);
    let mut rti = Rti::new(dynamics(&system), ocp, start, settings).unwrap();
    for _ in 1..30 {
        rti.feedback(&x0).unwrap();
    }
    let mut plant = RungeKuttaPlant::new(dynamics(&system), 2);
    let run = run_closed_loop(&mut rti, &mut plant, &x0, 100, LoopSettings::default()).unwrap();
    assert_eq!(run.counts.fallback, 0);
    (run.cost, run.counts.sources.tangent)
}

#[test]
fn the_advanced_step_costs_as_much_as_full_convergence() {
    let (cost, _) = swing_up(Preparation::AdvancedStep { programs: 1 });
    assert!((cost / 2047.463 - 1.0).abs() < 1e-3, "{cost}");
    let (cost, tangents) = swing_up(Preparation::AdvancedStepTangential { programs: 1 });
    assert!((cost / 2047.463 - 1.0).abs() < 1e-3, "{cost}");
    assert!(tangents > 50, "{tangents}");
}

#[test]
fn what_the_tangent_cannot_hold_is_refused() {
    let (system, mut ocp) = problem();
    let start = PlannedTrajectory::constant(STEPS, &[0.0; 4], &[0.0]);
    let settings =
        RtiSettings { preparation: Preparation::AdvancedStepTangential { programs: 0 }, ..RtiSettings::default() };
    assert!(matches!(Rti::new(dynamics(&system), ocp.clone(), start.clone(), settings), Err(MpcError::Value { .. })));
    ocp.move_blocks = vec![STEPS / 2, STEPS / 2];
    let settings =
        RtiSettings { preparation: Preparation::AdvancedStepTangential { programs: 1 }, ..RtiSettings::default() };
    let error = Rti::new(dynamics(&system), ocp, start, settings).err().unwrap();
    assert!(error.to_string().contains("move blocks"), "{error}");
}
