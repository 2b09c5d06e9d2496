//! Control of models that are discrete in time: the discrete Riccati equation, exact discretizations, and what is refused.

use approx::assert_relative_eq;
use bracketry_mpc::{ControlProblem, Controlled, control};
use bracketry_system::{Accepted, System};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

fn problem(model: &str, text: &str) -> Result<ControlProblem, String> {
    let accepted = Accepted { discrete: true, ..Accepted::default() };
    let read = |name: &str| {
        let text = if name == "plant.toml" { PLANT } else { model };
        System::parse_accepting(name, text, accepted).map_err(Box::new)
    };
    ControlProblem::parse("problem.toml", text, read).map_err(|e| e.to_string())
}

fn run(model: &str, text: &str) -> Controlled {
    control(&problem(model, text).unwrap()).unwrap()
}

/// A mass in continuous time.
const PLANT: &str = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u' }";
/// Its exact discretization with a period of 0.2 s.
const MASS: &str = "time = 'discrete'\nperiod = 0.2\nstates = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'x + 0.2*v + 0.02*u', v = 'v + 0.2*u' }";

fn linear_model(a: &DMatrix<f64>, b: &DMatrix<f64>) -> String {
    let row = |i: usize| {
        let states = (0..a.ncols()).map(|j| format!("({:?})*x{j}", a[(i, j)]));
        let inputs = (0..b.ncols()).map(|j| format!("({:?})*u{j}", b[(i, j)]));
        format!("x{i} = '{}'", states.chain(inputs).collect::<Vec<_>>().join(" + "))
    };
    let names =
        |letter: char, count: usize| (0..count).map(|i| format!("'{letter}{i}'")).collect::<Vec<_>>().join(", ");
    format!(
        "time = 'discrete'\nperiod = 0.5\nstates = [{}]\ninputs = [{}]\n[dynamics]\n{}",
        names('x', a.nrows()),
        names('u', b.ncols()),
        (0..a.nrows()).map(row).collect::<Vec<_>>().join("\n")
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    /// With the infinite horizon as terminal cost, every horizon is the infinite one: u = −Kx and the cost of the loop is x'Px,
    /// with P from the value iteration.
    #[test]
    fn a_linear_loop_costs_what_the_riccati_equation_says(
        entries in prop::collection::vec(-1.0f64..1.0, 15),
        x0 in prop::collection::vec(-2.0f64..2.0, 3),
        method in prop::sample::select(vec!["rti", "sqp"]),
    ) {
        let a = DMatrix::from_row_slice(3, 3, &entries[..9]);
        let b = DMatrix::from_row_slice(3, 2, &entries[9..]);
        let (q, r) = (DMatrix::identity(3, 3) * 0.5, DMatrix::identity(2, 2) * 0.1);
        let mut p = q.clone();
        let mut gain = DMatrix::zeros(2, 3);
        for _ in 0..4000 {
            gain = (&r + b.transpose() * &p * &b).try_inverse().unwrap() * b.transpose() * &p * &a;
            p = &q + a.transpose() * &p * (&a - &b * &gain);
        }
        // Weakly controllable unstable systems have no usable reference.
        prop_assume!(p.norm() < 1e3 && (&a - &b * &gain).complex_eigenvalues().iter().all(|l| l.norm() < 0.8));
        let text = format!(
            "model = 'm'\nhorizon = {{ steps = 4, dt = 0.5 }}\nsolve = {{ method = '{method}' }}\n\
             cost = {{ stage = 'x0^2 + x1^2 + x2^2 + 0.2*(u0^2 + u1^2)', terminal = 'riccati' }}\n\
             run = {{ x0 = {{ x0 = {:?}, x1 = {:?}, x2 = {:?} }}, steps = 60 }}",
            x0[0], x0[1], x0[2]
        );
        let loop_ = run(&linear_model(&a, &b), &text).run;
        let x = DVector::from_vec(x0);
        let first = -&gain * &x;
        let value = (x.transpose() * &p * &x)[(0, 0)];
        for j in 0..2 {
            prop_assert!((loop_.closed_loop.u[0][j] - first[j]).abs() < 1e-5 * (1.0 + value));
        }
        prop_assert!((loop_.report.closed_loop_cost - value).abs() < 1e-5 * (1.0 + value), "{} {value}", loop_.report.closed_loop_cost);
        prop_assert!((loop_.report.open_loop_cost - value).abs() < 1e-5 * (1.0 + value));
        // The plant is the map itself.
        for k in 0..10 {
            let rows = |v: &[f64]| DVector::from_row_slice(v);
            let next = &a * rows(&loop_.closed_loop.x[k]) + &b * rows(&loop_.closed_loop.u[k]);
            prop_assert!((next - rows(&loop_.closed_loop.x[k + 1])).norm() < 1e-12 * (1.0 + value));
        }
    }
}

const MOVE: &str =
    "cost = { stage = '10*(x - 1)^2 + v^2 + 0.1*u^2' }\nconstraints = { u = { min = -1, max = 1 }, v = { max = 0.5 } }";

#[test]
fn an_exact_discretization_moves_as_the_continuous_model() {
    for method in ["rti", "sqp", "plan"] {
        let text = format!(
            "model = 'm'\nhorizon = {{ steps = 20, dt = 0.2 }}\nsolve = {{ method = '{method}' }}\n{MOVE}\nrun = {{ steps = 30 }}"
        );
        let (discrete, continuous) = (run(MASS, &text), run(PLANT, &text));
        for (a, b) in discrete.run.closed_loop.x.iter().zip(&continuous.run.closed_loop.x) {
            assert_relative_eq!(a[0], b[0], epsilon = 1e-5);
            assert_relative_eq!(a[1], b[1], epsilon = 1e-5);
        }
        assert_eq!(discrete.run.report.succeeded, continuous.run.report.succeeded);
        assert_eq!(discrete.recording.trajectory.final_state(), discrete.run.closed_loop.x[30]);
    }
}

#[test]
fn an_input_is_held_over_several_steps_and_on_a_continuous_plant() {
    // Two steps of 0.2 s under one input are one step of 0.4 s of the continuous model.
    let text = format!(
        "model = 'm'\nhorizon = {{ steps = 12, dt = 0.4 }}\nsolve = {{ method = 'sqp' }}\n{MOVE}\n[run]\nsteps = 15\n"
    );
    let (discrete, continuous) = (run(MASS, &text), run(PLANT, &text));
    let (steps, mixed) =
        (discrete.recording.statistics.steps, run(MASS, &format!("plant = 'plant.toml'\n{text}plant_substeps = 1")));
    assert_eq!(steps, 30);
    for ((a, b), c) in
        discrete.run.closed_loop.x.iter().zip(&continuous.run.closed_loop.x).zip(&mixed.run.closed_loop.x)
    {
        assert_relative_eq!(a[0], b[0], epsilon = 1e-5);
        assert_relative_eq!(a[0], c[0], epsilon = 1e-5);
    }
}

#[test]
fn a_nonlinear_map_is_planned_to_its_optimum() {
    // x⁺ = x + x² u from 1 to 2 in two steps with the least u0² + u1²: x1 = 1 + u0, 2 = x1 + x1² u1. With a = u0, the optimum of
    // a² + ((1 − a)/(1 + a)²)² has a = 0.3 or so; the derivative vanishes at the plan's value.
    let model = "time = 'discrete'\nperiod = 1\nstates = ['x']\ninputs = ['u']\ndynamics = { x = 'x + x^2*u' }";
    let text = "model = 'm'\nhorizon = { steps = 2, dt = 1 }\ncost = { stage = 'u^2' }\ntarget = { x = 2 }\nsolve = { method = 'plan', margin = 0, tolerance = 1e-10 }\nrun = { x0 = { x = 1 } }";
    let plan = run(model, text).run.plan.unwrap();
    let cost = |a: f64| a * a + ((1.0 - a) / (1.0 + a).powi(2)).powi(2);
    let (a, b) = (plan.trajectory.u(0)[0], plan.trajectory.u(1)[0]);
    assert_relative_eq!(b, (1.0 - a) / (1.0 + a).powi(2), epsilon = 1e-6);
    assert_relative_eq!((cost(a + 1e-4) - cost(a - 1e-4)) / 2e-4, 0.0, epsilon = 1e-4);
    assert!(cost(a) < cost(a + 0.05) && cost(a) < cost(a - 0.05));
}

#[test]
fn what_belongs_to_continuous_time_is_refused_with_its_place() {
    let with = |horizon: &str, rest: &str| {
        format!(
            "model = 'm'\nhorizon = {{ steps = 5, {horizon} }}\ncost = {{ stage = 'x^2 + u^2' }}\n{rest}\nrun = {{}}"
        )
    };
    for (text, said, place) in [
        (with("dt = 0.3", ""), "not a multiple", "problem.toml:2:"),
        (with("dt = 0.2, integrator = 'radau'", ""), "`integrator`", "problem.toml:2:"),
        (with("dt = 0.2, substeps = 3", ""), "`substeps`", "problem.toml:2:"),
        (with("dt = 0.2, growth = 2", ""), "`growth`", "problem.toml:2:"),
        (with("end_time = { free = true, guess = 1 }", "target = { x = 1 }"), "cannot be free", "problem.toml:2:"),
        (with("dt = 0.2", "solve = { method = 'stick-slip' }"), "stick-slip", "problem.toml:4:"),
        (with("dt = 0.2", "estimation = { kind = 'ekf', outputs = { x = 0.1 } }"), "estimators", "problem.toml:4:"),
        (with("dt = 0.2", "plant = 'plant.toml'"), "plant_substeps", "problem.toml:4:"),
    ] {
        let error = problem(MASS, &text).err().unwrap();
        assert!(error.contains(said) && error.contains(place), "{error}");
    }
    let jump = "time = 'discrete'\nperiod = 0.2\nstates = ['x']\ninputs = ['u']\ndynamics = { x = 'x - sign(x) + u' }";
    let error = problem(jump, &with("dt = 0.2", "")).err().unwrap();
    assert!(error.contains("smooth"), "{error}");
}
