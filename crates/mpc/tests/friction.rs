//! Control on dry friction, judged on the exact stick–slip plant alone.
#![allow(clippy::unwrap_used)]

mod common;

use bracketry_mpc::{
    ClosedLoop, CostFunction, CostKind, LoopSettings, MpcError, Ocp, StickSlipController, StickSlipSettings,
    Trajectory, run_closed_loop,
};
use bracketry_system::System;

/// A mass on a spring with Coulomb friction of the given level.
fn spring_mass(friction: f64) -> System {
    let text = format!(
        r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = {{ x = "v", v = "-0.8*x - 0.5*v + u - {friction}*sign(v)" }}
    "#
    );
    System::parse("spring_mass.toml", &text).unwrap()
}

fn benchmark(system: &System) -> Ocp {
    let mut ocp = Ocp::new(2, 1, 20, 0.15);
    let stage = "(x - 2)^2 + v^2 + 0.1*(u - 1.8)^2";
    ocp.stage = Some(CostFunction::parse(system, CostKind::Stage, &[], stage).unwrap());
    ocp.input_bounds = vec![(-2.0, 2.0)];
    ocp
}

fn run(model: &System, plant: &System, ocp: Ocp, x0: &[f64], samples: usize) -> ClosedLoop {
    let guess = Trajectory::constant(ocp.steps, x0, &vec![0.0; ocp.inputs()]);
    let mut controller = StickSlipController::new(model, ocp, guess, StickSlipSettings::default()).unwrap();
    let mut plant = common::ExactPlant::new(plant, x0);
    run_closed_loop(&mut controller, &mut plant, x0, samples, LoopSettings::default()).unwrap()
}

#[test]
fn the_spring_mass_arrives_at_the_receding_horizon_optimum() {
    // 5.791733 and 1.996371: every sample minimised to convergence on a closed-form event-driven flow (SciPy, L-BFGS-B).
    let system = spring_mass(0.2);
    let run = run(&system, &system, benchmark(&system), &[0.0, 0.0], 40);
    assert!((run.cost - 5.791733).abs() < 2e-5, "{}", run.cost);
    assert!((run.x[40][0] - 1.996371).abs() < 5e-5, "{}", run.x[40][0]);
    assert_eq!(run.counts.solved, 40);
}

#[test]
fn a_guess_of_the_wrong_length_is_refused() {
    let system = spring_mass(0.2);
    let guess = Trajectory::constant(7, &[0.0, 0.0], &[0.0]);
    let refused = StickSlipController::new(&system, benchmark(&system), guess, StickSlipSettings::default());
    assert!(matches!(refused.err(), Some(MpcError::Length { what: "the guess", found: 7, expected: 20 })));
}
