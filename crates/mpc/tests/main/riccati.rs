//! The infinite horizon as a terminal cost.

use approx::assert_relative_eq;
use bracketry_mpc::riccati::dare;
use bracketry_mpc::{
    CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, SolveStatus, Sqp, SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;
use nalgebra::DMatrix;

use crate::common::dense;

fn zeros(n: usize, m: usize) -> DMatrix<f64> {
    DMatrix::zeros(n, m)
}

#[test]
fn the_solution_satisfies_the_equation_and_stabilizes() {
    let a = dense([[1.1, 0.3, 0.0], [-0.2, 0.9, 0.5], [0.0, 0.1, 1.2]]);
    let b = dense([[0.0, 1.0], [0.5, 0.0], [1.0, 0.2]]);
    let q = dense([[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 0.5]]);
    let r = dense([[1.0, 0.2], [0.2, 0.4]]);
    let s = dense([[0.1, 0.0], [0.0, 0.2], [-0.1, 0.1]]);
    let x = dare(&a, &b, &q, &r, &s).unwrap();
    let (p, k) = (&x.cost_to_go, &x.gain);
    let right = a.transpose() * p * &a - (a.transpose() * p * &b + &s) * k + &q;
    assert_relative_eq!(*p, right, epsilon = 1e-12);
    assert!(p.clone().cholesky().is_some());
    let radius = (&a - &b * k).complex_eigenvalues().iter().map(|l| l.norm()).fold(0.0, f64::max);
    assert!(radius < 1.0, "{radius}");
}

#[test]
fn a_singular_and_an_unstable_transition_matrix_are_served() {
    // Laub 1979, example 2.
    let (a, b, q) = (dense([[0.0, 1.0], [0.0, 0.0]]), dense([[0.0], [1.0]]), dense([[1.0, 2.0], [2.0, 4.0]]));
    let x = dare(&a, &b, &q, &dense([[1.0]]), &zeros(2, 1)).unwrap();
    assert_relative_eq!(x.cost_to_go, dense([[1.0, 2.0], [2.0, 2.0 + 5f64.sqrt()]]), epsilon = 1e-13);
    // p = a²p/(1 + p) + 1 with a = 2 has the root p = 2 + √5.
    let x = dare(&dense([[2.0]]), &dense([[1.0]]), &dense([[1.0]]), &dense([[1.0]]), &zeros(1, 1)).unwrap();
    assert_relative_eq!(x.cost_to_go[(0, 0)], 2.0 + 5f64.sqrt(), max_relative = 1e-14);
}

#[test]
fn what_has_no_solution_is_an_error_with_its_reason() {
    let one = dense([[1.0]]);
    let solve =
        |a: f64, b: f64, q: f64, r: f64| dare(&dense([[a]]), &dense([[b]]), &dense([[q]]), &dense([[r]]), &zeros(1, 1));
    assert!(matches!(solve(1.5, 0.0, 1.0, 1.0), Err(MpcError::NotStabilizable)));
    assert!(matches!(solve(1.0, 0.0, 1.0, 1.0), Err(MpcError::NotStabilizable)));
    assert!(matches!(solve(1.0, 1.0, 0.0, 1.0), Err(MpcError::NotDetectable)));
    assert!(matches!(solve(1.0, 1.0, 1.0, 0.0), Err(MpcError::Value { .. })));
    assert!(matches!(solve(f64::NAN, 1.0, 1.0, 1.0), Err(MpcError::Value { .. })));
    assert!(matches!(dare(&one, &dense([[1.0], [1.0]]), &one, &one, &one), Err(MpcError::Length { .. })));
}

fn double_integrator(stage: &str, references: &[&str], steps: usize) -> (SymbolicDynamics, Ocp) {
    let text = "states = [\"p\", \"v\"]\ninputs = [\"u\"]\ndynamics = { p = \"v\", v = \"u\" }";
    let system = System::parse("double_integrator.toml", text).unwrap();
    let mut ocp = Ocp::new(2, 1, steps, 0.1);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, references, stage).unwrap());
    (SymbolicDynamics::new(&system).unwrap(), ocp)
}

#[test]
fn a_short_horizon_with_the_terminal_cost_is_the_infinite_one() {
    let x0 = [1.0, -0.5];
    let solve = |steps| {
        let (mut dynamics, ocp) = double_integrator("2*p^2 + p*v + v^2 + 0.3*u^2", &[], steps);
        let (ocp, beyond) = ocp.with_terminal_cost_at(&mut dynamics, &[0.0; 2], &[0.0]).unwrap();
        let riccati = beyond.riccati;
        let mut sqp = Sqp::new(Box::new(dynamics), ocp, SqpSettings::default()).unwrap();
        let s = sqp.solve(&x0, &PlannedTrajectory::constant(steps, &x0, &[0.0])).unwrap();
        assert_eq!(s.status, SolveStatus::Converged);
        let x = dense([[x0[0]], [x0[1]]]);
        assert_relative_eq!(s.cost, (x.transpose() * &riccati.cost_to_go * &x)[0], max_relative = 1e-8);
        assert_relative_eq!(s.trajectory.u(0)[0], -(&riccati.gain * &x)[0], epsilon = 1e-6);
        s.cost
    };
    assert_relative_eq!(solve(3), solve(80), max_relative = 1e-8);
}

#[test]
fn the_center_follows_references() {
    let (mut dynamics, mut ocp) = double_integrator("(p - 3*goal)^2 + v^2 + 0.3*u^2", &["goal"], 5);
    ocp.references = (0..10).map(|k| vec![f64::from(k)]).collect();
    let (ocp, _) = ocp.with_terminal_cost_at(&mut dynamics, &[0.0; 2], &[0.0]).unwrap();
    let mut terminal = ocp.terminal.clone().unwrap();
    for goal in [0.0, 1.0, -2.5] {
        assert_relative_eq!(terminal.value(&[3.0 * goal, 0.0], &[], 0.0, &[goal]), 0.0, epsilon = 1e-12);
        assert!(terminal.value(&[3.0 * goal + 0.1, 0.0], &[], 0.0, &[goal]) > 1e-3);
    }
}

#[test]
fn the_terminal_set_touches_its_first_bound() {
    let (mut dynamics, mut ocp) = double_integrator("p^2 + v^2 + 0.3*u^2", &[], 5);
    ocp.input_bounds = vec![(-0.5, 2.0)];
    let (ocp, beyond) = ocp.with_terminal_cost_at(&mut dynamics, &[0.0; 2], &[0.0]).unwrap();
    let level = ocp.largest_terminal_level(&beyond);
    let riccati = beyond.riccati;
    let largest = (0..3600)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 3600.0;
            let x = dense([[angle.cos()], [angle.sin()]]);
            let on_border = (level / (x.transpose() * &riccati.cost_to_go * &x)[0]).sqrt();
            (&riccati.gain * &x)[0] * on_border
        })
        .fold(0.0, f64::max);
    assert_relative_eq!(largest, 0.5, max_relative = 1e-5);
}

#[test]
fn a_point_that_moves_is_no_steady_state() {
    let (mut dynamics, ocp) = double_integrator("p^2 + v^2 + u^2", &[], 5);
    let error = ocp.with_terminal_cost_at(&mut dynamics, &[0.0, 1.0], &[0.0]).err().unwrap();
    assert!(matches!(error, MpcError::NotSteady { index: 0, .. }), "{error}");
}

#[test]
fn a_cost_that_is_least_elsewhere_moves_the_center_and_tilts_the_cost_to_go() {
    // x' = u − x; holding x = 2 takes an input that costs, so the best steady state is a compromise: x = u = 20/11.
    let text = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u - x\" }";
    let system = System::parse("lag.toml", text).unwrap();
    let first_input = |steps: usize, point: f64| {
        let mut ocp = Ocp::new(1, 1, steps, 0.1);
        ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "(x - 2)^2 + 0.1*u^2").unwrap());
        let mut dynamics = SymbolicDynamics::new(&system).unwrap();
        let (ocp, beyond) = ocp.with_terminal_cost_at(&mut dynamics, &[point], &[point]).unwrap();
        assert_relative_eq!(beyond.state[0], 20.0 / 11.0, epsilon = 1e-9);
        assert_relative_eq!(beyond.input[0], 20.0 / 11.0, epsilon = 1e-9);
        let mut sqp = Sqp::new(Box::new(dynamics), ocp, SqpSettings::default()).unwrap();
        let solution = sqp.solve(&[0.5], &PlannedTrajectory::constant(steps, &[0.5], &[0.0])).unwrap();
        solution.trajectory.u(0)[0]
    };
    // Bellman's principle: the length of the horizon makes no difference, nor does the point of linearization.
    let long = first_input(200, 0.0);
    for (steps, point) in [(1, 0.0), (3, 0.0), (3, 1.5)] {
        assert_relative_eq!(first_input(steps, point), long, epsilon = 1e-5);
    }
}
