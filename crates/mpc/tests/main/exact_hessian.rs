//! The exact Hessian of the Lagrangian: convergence, and the same solutions as without it.

use bracketry_mpc::dynamics::FieldDynamics;
use bracketry_mpc::qp::{ProgramForm, QpSettings};
use bracketry_mpc::sqp::{Hessian, Solution};
use bracketry_mpc::{
    CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, SolveStatus, Sqp, SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;

/// A pendulum driven far from its cost's reference: strong curvature of the dynamics and large multipliers.
const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "-sin(th)*(1 + 0.5*u) - 0.1*w^3 + u" }
"#;

fn pendulum() -> (System, Ocp) {
    let system = System::parse("pendulum.toml", PENDULUM).unwrap();
    let mut ocp = Ocp::new(2, 1, 20, 0.2);
    let (stage, terminal) = ("(th - 2)^2 + 0.1*w^2 + u^2", "20*(th - 2)^2 + 5*w^2");
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], stage).unwrap());
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &[], terminal).unwrap());
    (system, ocp)
}

fn settings(hessian: Hessian) -> SqpSettings {
    let qp = QpSettings { form: ProgramForm::Sparse, tolerance: 1e-12, refine: true, ..QpSettings::default() };
    SqpSettings { hessian, tolerance: 1e-15, interior_point: false, qp, ..SqpSettings::default() }
}

fn solve(system: &System, ocp: &Ocp, settings: SqpSettings, x0: &[f64]) -> Solution {
    let dynamics = SymbolicDynamics::new(system).unwrap();
    let mut sqp = Sqp::new(Box::new(dynamics), ocp.clone(), settings).unwrap();
    let guess = PlannedTrajectory::constant(ocp.steps, x0, &vec![0.0; ocp.inputs()]);
    sqp.solve(x0, &guess).unwrap()
}

#[test]
fn both_hessians_lead_to_the_same_solution() {
    let (system, ocp) = pendulum();
    let [one, other] = [Hessian::GaussNewton, Hessian::Exact].map(|h| solve(&system, &ocp, settings(h), &[0.5, 0.0]));
    assert_eq!([one.status, other.status], [SolveStatus::Converged; 2]);
    assert!((one.cost / other.cost - 1.0).abs() < 1e-12, "{} {}", one.cost, other.cost);
    for k in 0..ocp.steps {
        let (u, v) = (one.trajectory.u(k)[0], other.trajectory.u(k)[0]);
        assert!((u - v).abs() < 1e-6, "{k}: {u} {v}");
    }
}

#[test]
fn dynamics_without_second_derivatives_are_refused() {
    let field = FieldDynamics::new(2, 1, |_t, x, u, dx, jac| {
        dx.copy_from_slice(&[x[1], u[0]]);
        jac.copy_from_slice(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    });
    let error = Sqp::new(Box::new(field), pendulum().1, settings(Hessian::Exact)).err().unwrap();
    assert!(matches!(error, MpcError::NoSecondDerivatives));
}

/// What the programs promise, one after another: it falls with the square of the distance from the solution.
fn promises(hessian: Hessian) -> Vec<f64> {
    let (system, ocp) = pendulum();
    let solution = solve(&system, &ocp, settings(hessian), &[0.5, 0.0]);
    solution.iterations.iter().map(|i| i.predicted.abs()).collect()
}

#[test]
fn convergence_is_quadratic_where_that_of_gauss_newton_is_linear() {
    let (linear, quadratic) = (promises(Hessian::GaussNewton), promises(Hessian::Exact));
    assert!(quadratic.len() <= 9 && linear.len() >= 25, "{quadratic:?} {linear:?}");
    // Promises are squares of distances e: e⁺ ≤ c e² makes them p⁺ ≤ c² p².
    let last = &quadratic[quadratic.len() - 3..];
    for pair in last.windows(2) {
        assert!(pair[1] < pair[0].powf(1.8), "{quadratic:?}");
    }
    // A constant factor.
    for pair in linear[15..25].windows(2) {
        assert!((0.2..0.5).contains(&(pair[1] / pair[0])), "{linear:?}");
    }
}
