//! Linear systems, where the solution is known.

use crate::common::double_integrator;
use approx::assert_relative_eq;
use bracketry_mpc::controller::{FallbackReason, StepStatus};
use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::qp::QpStatus;
use bracketry_mpc::rti::Horizon;
use bracketry_mpc::{
    CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, Rti, RtiSettings, SolveStatus, Sqp, SqpSettings,
    SymbolicDynamics, TerminalTarget,
};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector, Matrix2, RowVector2, Vector2};

const DT: f64 = 0.1;

fn dynamics(system: &System) -> Box<SymbolicDynamics> {
    Box::new(SymbolicDynamics::new(system).unwrap())
}

fn regulator(steps: usize) -> (System, Ocp) {
    let system = double_integrator();
    let mut ocp = Ocp::new(2, 1, steps, DT);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "2*p^2 + p*v + v^2 + 0.3*u^2").unwrap());
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &[], "5*p^2 + v^2").unwrap());
    (system, ocp)
}

/// Exact discretization of the double integrator: the Runge–Kutta method is exact on it.
fn discrete() -> (Matrix2<f64>, Vector2<f64>) {
    (Matrix2::new(1.0, DT, 0.0, 1.0), Vector2::new(DT * DT / 2.0, DT))
}

/// First gain and cost-to-go matrix of the Riccati recursion for x'Qx + u'Ru, per interval.
fn riccati(steps: usize) -> (RowVector2<f64>, Matrix2<f64>) {
    let (a, b) = discrete();
    let q = DT * Matrix2::new(2.0, 0.5, 0.5, 1.0);
    let r = DT * 0.3;
    let mut p = Matrix2::new(5.0, 0.0, 0.0, 1.0);
    let mut k = RowVector2::zeros();
    for _ in 0..steps {
        k = (b.transpose() * p * a) / (r + (b.transpose() * p * b)[0]);
        p = q + a.transpose() * p * (a - b * k);
    }
    (k, p)
}

#[test]
fn the_unconstrained_regulator_is_the_riccati_solution() {
    let x0 = [1.0, -0.5];
    let (system, ocp) = regulator(30);
    let mut sqp = Sqp::new(dynamics(&system), ocp, SqpSettings::default()).unwrap();
    let s = sqp.solve(&x0, &PlannedTrajectory::constant(30, &x0, &[0.0])).unwrap();
    let (k, p) = riccati(30);
    let x = Vector2::from(x0);
    assert_eq!(s.status, SolveStatus::Converged);
    assert_relative_eq!(s.trajectory.u(0)[0], -(k * x)[0], epsilon = 1e-6);
    assert_relative_eq!(s.cost, (x.transpose() * p * x)[0], max_relative = 1e-8);
}

#[test]
fn one_real_time_iteration_is_the_regulator_from_any_measured_state() {
    let (system, ocp) = regulator(30);
    let start = PlannedTrajectory::constant(30, &[0.0; 2], &[0.0]);
    let mut rti = Rti::new(dynamics(&system), ocp, start, RtiSettings::default()).unwrap();
    let (k, _) = riccati(30);
    for x in [[1.0, -0.5], [-2.0, 3.0], [0.1, 0.0]] {
        rti.prepare().unwrap();
        let step = rti.feedback(&x).unwrap().clone();
        rti.shift();
        assert_eq!(step.status, StepStatus::Solved);
        assert_relative_eq!(step.u[0], -(k * Vector2::from(x))[0], epsilon = 1e-5);
    }
}

#[test]
fn a_constrained_solution_satisfies_the_optimality_conditions() {
    // min Σ q(x, u) with |u| ≤ 1: stationarity of the condensed problem, bounds, complementarity.
    let (steps, x0) = (15, [1.0, 0.8]);
    let (system, mut ocp) = regulator(steps);
    ocp.input_bounds = vec![(-1.0, 1.0)];
    let mut sqp = Sqp::new(dynamics(&system), ocp, SqpSettings::default()).unwrap();
    let s = sqp.solve(&x0, &PlannedTrajectory::constant(steps, &x0, &[0.0])).unwrap();
    let (a, b) = discrete();
    // x_k = A^k x0 + Σ A^(k−1−j) B u_j; gradient of the cost with respect to u by the adjoint recursion.
    let u: Vec<f64> = (0..steps).map(|k| s.trajectory.u(k)[0]).collect();
    let mut x = vec![Vector2::from(x0)];
    for k in 0..steps {
        x.push(a * x[k] + b * u[k]);
    }
    let q = 2.0 * DT * Matrix2::new(2.0, 0.5, 0.5, 1.0);
    let mut adjoint = Matrix2::new(10.0, 0.0, 0.0, 2.0) * x[steps];
    let mut gradient = vec![0.0; steps];
    for k in (0..steps).rev() {
        gradient[k] = 2.0 * DT * 0.3 * u[k] + b.dot(&adjoint);
        adjoint = q * x[k] + a.transpose() * adjoint;
    }
    let mut active = 0;
    for k in 0..steps {
        assert!(u[k].abs() <= 1.0);
        if u[k].abs() > 1.0 - 1e-6 {
            active += 1;
            assert!(gradient[k] * u[k] <= 1e-6, "the multiplier of an active bound has the right sign");
        } else {
            assert!(gradient[k].abs() < 1e-5, "{k}: {}", gradient[k]);
        }
    }
    assert!(active > 0 && active < steps);
}

#[test]
fn a_soft_target_with_a_strong_linear_weight_is_exact() {
    let system = double_integrator();
    let mut ocp = Ocp::new(2, 1, 20, DT);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "u^2").unwrap());
    let target = |state, value| TerminalTarget { state, value, linear: 100.0, quadratic: 10.0 };
    ocp.targets = vec![target(0, 1.0), target(1, 0.0)];
    let mut sqp = Sqp::new(dynamics(&system), ocp, SqpSettings::default()).unwrap();
    let s = sqp.solve(&[0.0; 2], &PlannedTrajectory::constant(20, &[0.0; 2], &[0.0])).unwrap();
    assert!(s.miss.iter().all(|e| e.abs() < 1e-7), "{:?}", s.miss);
    // Least-norm inputs: u = G'(GG')⁻¹ target, G the columns A^(N−1−j) B.
    let (a, b) = discrete();
    let mut g = DMatrix::zeros(2, 20);
    let mut column = b;
    for j in (0..20).rev() {
        g.set_column(j, &column);
        column = a * column;
    }
    let gram = &g * g.transpose();
    let least = g.transpose() * gram.try_inverse().unwrap() * DVector::from_column_slice(&[1.0, 0.0]);
    for j in 0..20 {
        assert_relative_eq!(s.trajectory.u(j)[0], least[j], epsilon = 1e-6);
    }
}

#[test]
fn a_hard_bound_that_cannot_be_kept_is_reported_as_infeasible() {
    let (system, mut ocp) = regulator(10);
    ocp.input_bounds = vec![(-1.0, 1.0)];
    ocp.state_bounds[0] = Bounds { min: f64::NEG_INFINITY, max: 1.0, softness: Softness::Hard };
    let mut sqp = Sqp::new(dynamics(&system), ocp, SqpSettings::default()).unwrap();
    // From p = 1 with v = 2 and |u| ≤ 1 the position grows by at least 2·1 − 1/2 within the second: p reaches 2.5.
    let s = sqp.solve(&[1.0, 2.0], &PlannedTrajectory::constant(10, &[1.0, 2.0], &[0.0])).unwrap();
    let SolveStatus::Infeasible { violation } = s.status else { panic!("{:?}", s.status) };
    assert_relative_eq!(violation, 1.5, epsilon = 1e-5);
    for k in 0..10 {
        assert_relative_eq!(s.trajectory.u(k)[0], -1.0, epsilon = 1e-5);
    }
}

#[test]
fn a_hard_bound_that_can_be_kept_is_kept() {
    let (system, mut ocp) = regulator(20);
    ocp.state_bounds[1] = Bounds { min: -0.4, max: f64::INFINITY, softness: Softness::Hard };
    let mut sqp = Sqp::new(dynamics(&system), ocp, SqpSettings::default()).unwrap();
    let s = sqp.solve(&[1.0, 0.0], &PlannedTrajectory::constant(20, &[1.0, 0.0], &[0.0])).unwrap();
    assert_eq!(s.status, SolveStatus::Converged);
    let slowest = (0..=20).map(|k| s.trajectory.x(k)[1]).fold(0.0, f64::min);
    assert_relative_eq!(slowest, -0.4, epsilon = 1e-6);
}

#[test]
fn a_measurement_that_is_not_a_number_falls_back_to_the_plan_and_then_to_rest() {
    let (system, mut ocp) = regulator(3);
    ocp.input_bounds = vec![(-5.0, 5.0)];
    let start = PlannedTrajectory::constant(3, &[0.0; 2], &[0.0]);
    let settings = RtiSettings { rest_input: vec![-0.25], ..RtiSettings::default() };
    let mut rti = Rti::new(dynamics(&system), ocp, start, settings).unwrap();
    rti.feedback(&[1.0, 0.0]).unwrap();
    let plan: Vec<f64> = (0..3).map(|k| rti.trajectory().u(k)[0]).collect();
    rti.shift();
    for expected in [plan[1], plan[2], -0.25, -0.25] {
        let step = rti.feedback(&[f64::NAN, 0.0]).unwrap().clone();
        rti.shift();
        assert_eq!(step.status, StepStatus::Fallback(FallbackReason::Measurement));
        assert_eq!(step.u, [expected]);
    }
    assert_eq!(rti.feedback(&[1.0, 0.0]).unwrap().status, StepStatus::Solved);
}

#[test]
fn dynamics_that_are_not_a_number_give_a_status() {
    let text = r#"
        states = ["p"]
        inputs = ["u"]
        dynamics = { p = "log(p) + u" }
    "#;
    let system = System::parse("log.toml", text).unwrap();
    let stage = CostFunction::parse(&system, CostKind::Stage, &[], "p^2 + u^2").unwrap();
    let mut ocp = Ocp::new(1, 1, 5, DT);
    ocp.stage = Some(stage);
    let guess = PlannedTrajectory::constant(5, &[-1.0], &[0.0]);
    let mut sqp = Sqp::new(dynamics(&system), ocp.clone(), SqpSettings::default()).unwrap();
    assert_eq!(sqp.solve(&[-1.0], &guess).unwrap().status, SolveStatus::NotANumber);
    let mut rti = Rti::new(dynamics(&system), ocp, guess, RtiSettings::default()).unwrap();
    let step = rti.feedback(&[-1.0]).unwrap();
    assert_eq!(step.status, StepStatus::Fallback(FallbackReason::Linearization));
}

#[test]
fn a_program_without_iterations_falls_back() {
    let (system, mut ocp) = regulator(30);
    ocp.input_bounds = vec![(-1.0, 1.0)];
    let mut settings = RtiSettings::default();
    settings.qp.max_iterations = 1;
    let start = PlannedTrajectory::constant(30, &[0.0; 2], &[0.5]);
    let mut rti = Rti::new(dynamics(&system), ocp, start, settings).unwrap();
    let step = rti.feedback(&[1.0, 0.0]).unwrap();
    assert_eq!(step.status, StepStatus::Fallback(FallbackReason::Qp(QpStatus::Limit)));
    assert_eq!(step.u, [0.5]);
}

#[test]
fn a_shrinking_horizon_reaches_its_end_and_rests() {
    let system = double_integrator();
    let mut ocp = Ocp::new(2, 1, 12, DT);
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], "u^2").unwrap());
    let target = |state, value| TerminalTarget { state, value, linear: 100.0, quadratic: 10.0 };
    ocp.targets = vec![target(0, 1.0), target(1, 0.0)];
    let settings = RtiSettings { horizon: Horizon::Shrinking { min_steps: 3 }, ..RtiSettings::default() };
    let start = PlannedTrajectory::constant(12, &[0.0; 2], &[0.0]);
    let mut rti = Rti::new(dynamics(&system), ocp, start, settings).unwrap();
    let (a, b) = discrete();
    let mut x = Vector2::zeros();
    for k in 0..14 {
        let step = rti.feedback(&[x[0], x[1]]).unwrap().clone();
        rti.shift();
        assert_eq!(step.status == StepStatus::Solved, k <= 9, "sample {k}");
        assert_eq!(step.u[0] == 0.0, k >= 12, "sample {k}");
        x = a * x + b * step.u[0];
    }
    assert_relative_eq!(x, Vector2::new(1.0, 0.0), epsilon = 1e-6);
}

#[test]
fn contradictions_are_errors() {
    let (system, ocp) = regulator(5);
    let check = |change: &dyn Fn(&mut Ocp)| {
        let mut o = ocp.clone();
        change(&mut o);
        Sqp::new(dynamics(&system), o, SqpSettings::default()).err().unwrap()
    };
    assert!(matches!(check(&|o| o.input_bounds = vec![(1.0, -1.0)]), MpcError::EmptyBounds { index: 0, .. }));
    assert!(matches!(check(&|o| o.dt = f64::NAN), MpcError::Value { .. }));
    assert!(matches!(check(&|o| o.substeps = Substeps::Fixed(0)), MpcError::Value { .. }));
    assert!(matches!(check(&|o| o.state_scale = vec![1.0]), MpcError::Length { found: 1, expected: 2, .. }));
    assert!(matches!(
        check(&|o| o.targets.push(TerminalTarget { state: 7, value: 0.0, linear: 1.0, quadratic: 1.0 })),
        MpcError::NoSuchState { index: 7, states: 2 }
    ));
}
