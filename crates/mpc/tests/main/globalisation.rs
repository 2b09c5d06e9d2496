//! The filter method: second-order correction, damping, and the end of the iteration.

use bracketry_mpc::ocp::{Bounds, PathConstraint, Softness, Substeps, VectorFunction};
use bracketry_mpc::sqp::{Iteration, Solution};
use bracketry_mpc::{CostFunction, CostKind, Ocp, PlannedTrajectory, SolveStatus, Sqp, SqpSettings, SymbolicDynamics};
use bracketry_system::System;
use std::f64::consts::PI;

fn solver(system: &System, ocp: Ocp, settings: SqpSettings) -> Sqp {
    Sqp::new(Box::new(SymbolicDynamics::new(system).unwrap()), ocp, settings).unwrap()
}

fn filter_alone() -> SqpSettings {
    SqpSettings { interior_point: false, ..SqpSettings::default() }
}

/// min ½(u² + v²) − u on the circle u² + v² = 1, from the angle 0.3 on it. The Hessian is that of the Lagrangian, yet every
/// whole step leaves the circle by the square of its length and the exact penalty rises (Maratos 1978).
fn maratos(second_order_correction: bool) -> Solution {
    let text = r#"
        states = ["p"]
        inputs = ["u", "v"]
        dynamics = { p = "u" }
    "#;
    let system = System::parse("maratos.toml", text).unwrap();
    let mut ocp = Ocp::new(1, 2, 1, 1.0);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "(u^2 + v^2)/2 - u").unwrap());
    let function = VectorFunction::parse(&system, &[], &["u^2 + v^2"]).unwrap();
    let bounds = Bounds { min: 1.0, max: 1.0, softness: Softness::Hard };
    ocp.path_constraints = vec![PathConstraint { name: String::new(), function, bounds, at_end: false }];
    let angle = 0.3_f64;
    let guess =
        PlannedTrajectory::from_rows(&[vec![0.0], vec![angle.cos()]], &[vec![angle.cos(), angle.sin()]]).unwrap();
    // The penalty is exact from the multiplier 1/2 on. What a correction leaves of the violation, of the third order, shall cost less than
    // the step gains.
    let mut settings = SqpSettings { second_order_correction, ..filter_alone() };
    settings.qp.hard_weight = 10.0;
    solver(&system, ocp, settings).solve(&[0.0], &guess).unwrap()
}

fn is_whole(step: &Iteration) -> bool {
    step.fraction == 1.0
}

#[test]
fn a_second_order_correction_lets_the_maratos_problem_take_whole_steps() {
    let s = maratos(true);
    assert_eq!(s.status, SolveStatus::Converged);
    assert!((s.cost + 0.5).abs() < 1e-7 && s.trajectory.u(0)[1].abs() < 1e-4, "{:?}", s.trajectory.u(0));
    assert!(s.iterations[1].correction && is_whole(&s.iterations[1]), "{:?}", s.iterations);
    assert!(!s.iterations.iter().any(|i| i.fraction > 0.0 && !is_whole(i)), "{:?}", s.iterations);
}

#[test]
fn without_it_whole_steps_are_rejected() {
    let s = maratos(false);
    assert!(!is_whole(&s.iterations[0]), "{:?}", s.iterations);
    assert!(maratos(true).iterations.len() < s.iterations.len(), "{:?}", s.iterations);
}

#[test]
fn steps_are_shortened_where_whole_ones_go_in_circles() {
    // Newton's method for u/√(1 + u²) = 0 is u → −u³: it jumps between 1 and −1 for ever.
    let text = r#"
        states = ["z"]
        inputs = ["u"]
        dynamics = { z = "u/sqrt(1 + u^2)" }
    "#;
    let system = System::parse("sigmoid.toml", text).unwrap();
    let mut ocp = Ocp::new(1, 1, 1, 1.0);
    ocp.state_bounds = vec![Bounds { min: 0.0, max: 0.0, softness: Softness::Hard }];
    let guess = PlannedTrajectory::constant(1, &[0.0], &[1.0]);
    let s = solver(&system, ocp, filter_alone()).solve(&[0.0], &guess).unwrap();
    assert_eq!(s.status, SolveStatus::Converged);
    assert!(s.trajectory.u(0)[0].abs() < 1e-6, "{:?}", s.trajectory.u(0));
    assert_eq!(s.iterations[0].fraction, 0.5, "{:?}", s.iterations);
}

#[test]
fn a_solution_close_by_takes_two_programs_and_keeps_the_tolerance() {
    let system = crate::common::cart_pole();
    let mut ocp = Ocp::new(4, 1, 40, 0.02);
    let stage = "1e3*p^2 + 1e3*th^2 + 1e-2*v^2 + 1e-2*w^2 + 1e-2*u^2";
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], stage).unwrap());
    ocp.input_bounds = vec![(-80.0, 80.0)];
    let mut sqp = solver(&system, ocp.clone(), filter_alone());
    let far = [0.0, PI, 0.0, 0.0];
    let swing_up = sqp.solve(&far, &PlannedTrajectory::constant(40, &far, &[0.0])).unwrap();
    let near = [1e-3, PI - 1e-3, 0.0, 1e-2];
    let s = sqp.solve(&near, &swing_up.trajectory).unwrap();
    assert_eq!((s.status, s.iterations.len()), (SolveStatus::Converged, 2), "{:?}", s.iterations);
    let exact = SqpSettings { tolerance: 1e-13, defect_tolerance: 1e-11, ..filter_alone() };
    let reference = solver(&system, ocp, exact).solve(&near, &s.trajectory).unwrap();
    assert!((s.cost / reference.cost - 1.0).abs() < 1e-8, "{} against {}", s.cost, reference.cost);
    assert!(s.defect < 1e-6, "{}", s.defect);
}

#[test]
fn an_economic_cost_without_curvature_converges_from_a_reactor_that_nothing_flows_through() {
    let text = r#"
        states = ["x", "s"]
        inputs = ["D"]
        dynamics = { x = "0.5*s/(0.2 + s)*x - D*x", s = "-0.5*s/(0.2 + s)*x/0.6 + D*(5 - s)" }
    "#;
    let system = System::parse("bioreactor.toml", text).unwrap();
    let mut ocp = Ocp::new(2, 1, 30, 0.5);
    ocp.substeps = Substeps::Fixed(2);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "-D*x + 0.05*D^2").unwrap());
    ocp.input_bounds = vec![(0.0, 1.0)];
    let at_least = |min: f64| Bounds { min, max: f64::INFINITY, softness: Softness::Hard };
    ocp.state_bounds = vec![at_least(0.5), at_least(0.0)];
    let guess = PlannedTrajectory::constant(30, &[1.0, 1.0], &[0.0]);
    let s = solver(&system, ocp, SqpSettings::default()).solve(&[1.0, 1.0], &guess).unwrap();
    assert_eq!(s.status, SolveStatus::Converged);
    // IPOPT stops at -13.319 from the same guess.
    assert!(s.cost < -13.319, "{}", s.cost);
}
