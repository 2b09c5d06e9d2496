//! Swing-up of a cart-pole: the closed-loop cost of a published benchmark.

use bracketry_mpc::closed_loop::{LoopSettings, RungeKuttaPlant};
use bracketry_mpc::ocp::Substeps;
use bracketry_mpc::sqp::SqpController;
use bracketry_mpc::{
    CostFunction, CostKind, Ocp, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings, SymbolicDynamics,
    run_closed_loop,
};
use bracketry_system::System;
use std::f64::consts::PI;

const X0: [f64; 4] = [0.0, PI, 0.0, 0.0];

fn problem() -> (System, Ocp) {
    let system = crate::common::cart_pole();
    let mut ocp = Ocp::new(4, 1, 40, 0.02);
    ocp.substeps = Substeps::Fixed(1);
    ocp.stage = Some(
        CostFunction::parse(&system, CostKind::Stage, &[], "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2")
            .unwrap(),
    );
    ocp.terminal = Some(
        CostFunction::parse(&system, CostKind::Terminal, &[], "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2").unwrap(),
    );
    ocp.input_bounds = vec![(-80.0, 80.0)];
    (system, ocp)
}

fn rti_cost(initial_iterations: usize) -> f64 {
    let (system, ocp) = problem();
    let guess = PlannedTrajectory::constant(40, &X0, &[0.0]);
    let mut rti =
        Rti::new(Box::new(SymbolicDynamics::new(&system).unwrap()), ocp, guess, RtiSettings::default()).unwrap();
    for _ in 1..initial_iterations {
        rti.feedback(&X0).unwrap();
    }
    let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&system).unwrap()), 2);
    let run = run_closed_loop(&mut rti, &mut plant, &X0, 100, LoopSettings::default()).unwrap();
    assert_eq!(run.counts.fallback, 0);
    run.cost
}

#[test]
fn real_time_iteration_after_thirty_iterations_costs_as_much_as_full_convergence() {
    let cost = rti_cost(30);
    assert!((cost / 2047.463 - 1.0).abs() < 1e-3, "{cost}");
}

#[test]
fn real_time_iteration_from_a_cold_start_costs_a_fifth_more() {
    let cost = rti_cost(1);
    assert!((cost / 2477.99 - 1.0).abs() < 1e-3, "{cost}");
}

#[test]
fn converged_sqp_reaches_the_reference_cost() {
    let (system, ocp) = problem();
    let sqp = Sqp::new(Box::new(SymbolicDynamics::new(&system).unwrap()), ocp, SqpSettings::default()).unwrap();
    let guess = PlannedTrajectory::constant(40, &X0, &[0.0]);
    let mut controller = SqpController::new(sqp, guess);
    let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&system).unwrap()), 2);
    let run = run_closed_loop(&mut controller, &mut plant, &X0, 100, LoopSettings::default()).unwrap();
    assert!((run.cost / 2047.463 - 1.0).abs() < 1e-3, "{}", run.cost);
}
