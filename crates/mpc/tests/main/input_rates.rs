//! Costs and bounds of the rates of inputs: what they are, whatever the method and whatever stands between controller and plant.

use crate::common::{dense, reports::read};
use bracketry_mpc::control;
use bracketry_mpc::controller::InputSource;
use bracketry_mpc::riccati::dare;
use nalgebra::{DMatrix, DVector};

const INTEGRATOR: &str = r#"
    states = ["x"]
    inputs = ["u"]
    dynamics = { x = "u" }
"#;
const BLOCK: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    dynamics = { x = "v", v = "u - sign(v)" }
"#;

/// Largest change of the applied input per second; `before` is that before the run.
fn largest_rate(u: &[Vec<f64>], before: f64, dt: f64) -> f64 {
    let mut last = before;
    u.iter().map(|u| (u[0] - std::mem::replace(&mut last, u[0])).abs() / dt).fold(0.0, f64::max)
}

#[test]
fn every_method_keeps_the_rate_of_a_step() {
    for method in ["rti", "sqp", "plan", "stick-slip"] {
        for (model, extra) in [(INTEGRATOR, ""), (BLOCK, " + 0.1*v^2")] {
            let text = format!(
                r#"
                model = "model.toml"
                horizon = {{ steps = 20, dt = 0.1 }}
                cost = {{ stage = "(x - 1)^2{extra} + 1e-4*u^2" }}
                constraints = {{ u = {{ min = -4, max = 4, rate = {{ min = -20, max = 5 }} }} }}
                solve = {{ method = "{method}" }}
                run = {{ u0 = {{ u = 0.5 }} }}
                "#
            );
            let run = control(&read(model, &text).unwrap()).unwrap().run;
            let u = &run.closed_loop.u;
            let rates: Vec<f64> =
                std::iter::once(u[0][0] - 0.5).chain(u.windows(2).map(|w| w[1][0] - w[0][0])).collect();
            for r in &rates {
                assert!((-2.0 - 1e-4..=0.5 + 1e-4).contains(r), "{method} {extra}: {rates:?}");
            }
            // A step to 1 is worth as much as the rate allows; a plan keeps a margin.
            // (Where friction is smoothed, a plan may prefer to rest.)
            let pushes = extra.is_empty() || method == "stick-slip";
            assert!(rates[0] > 0.45 || !pushes, "{method} {extra}: {rates:?}");
            assert_eq!(run.closed_loop.counts.fallback, 0);
            assert_eq!(run.closed_loop.x[0].len(), if extra.is_empty() { 1 } else { 2 });
        }
    }
}

#[test]
fn a_cost_of_the_rate_is_that_of_the_riccati_equation_with_the_input_as_a_state() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 5, dt = 0.1 }
        cost = { stage = "x^2", residuals = ["rate(u)", "u"], weights = [0.05, 0.01], terminal = "riccati" }
        run = { x0 = { x = 2 }, u0 = { u = 1 }, steps = 300 }
        solve = { method = "rti" }
    "#;
    let run = control(&read(INTEGRATOR, text).unwrap()).unwrap().run;
    // State (x, p), p the input before: x⁺ = x + dt·u, p⁺ = u; cost dt·(x² + 0.05 (u − p)²/dt² + 0.01 u²).
    let dt: f64 = 0.1;
    let rate = 0.05 / dt;
    let a = dense([[1.0, 0.0], [0.0, 0.0]]);
    let b = dense([[dt], [1.0]]);
    let q = dense([[dt, 0.0], [0.0, rate]]);
    let r = dense([[rate + 0.01 * dt]]);
    let s: DMatrix<f64> = dense([[0.0], [-rate]]);
    let solution = dare(&a, &b, &q, &r, &s).unwrap();
    let mut z = DVector::from_vec(vec![2.0, 1.0]);
    let cost = (z.transpose() * &solution.cost_to_go * &z)[(0, 0)];
    assert!((run.report.closed_loop_cost / cost - 1.0).abs() < 1e-6, "{} {cost}", run.report.closed_loop_cost);
    assert!((run.report.open_loop_cost / cost - 1.0).abs() < 1e-6, "{} {cost}", run.report.open_loop_cost);
    for u in &run.closed_loop.u[..50] {
        let optimal = -(&solution.gain * &z)[(0, 0)];
        assert!((u[0] - optimal).abs() < 1e-5, "{} {optimal}", u[0]);
        z = &a * &z + &b * u[0];
    }
}

#[test]
fn inputs_of_the_failure_policy_keep_the_rate_and_count_as_applied() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 20, dt = 0.1 }
        cost = { stage = "(x - 3)^2 + 1e-3*u^2" }
        constraints = { u = { min = -4, max = 4, rate = { min = -3, max = 3 } } }
        solve = { method = "rti", policy = "rest" }
        run = { steps = 30, faults = [{ at = 5, until = 7, lost = true }, { at = 12, nan = ["x"] }] }
    "#;
    let run = control(&read(INTEGRATOR, text).unwrap()).unwrap().run.closed_loop;
    assert_eq!((run.counts.fallback, run.steps[5].source), (4, InputSource::Rest));
    // The input of rest is zero: it falls as fast as it may, and rises from there.
    for k in [5, 6, 7] {
        assert!((run.u[k - 1][0] - run.u[k][0] - 0.3).abs() < 1e-9, "{:?}", run.u);
    }
    assert!((run.u[8][0] - run.u[7][0] - 0.3).abs() < 1e-4, "{:?}", run.u);
    assert!(largest_rate(&run.u, 0.0, 0.1) < 3.0 + 1e-3);
}

#[test]
fn with_a_delay_and_an_estimator_the_rate_is_that_of_the_applied_input() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 20, dt = 0.1 }
        cost = { stage = "(x - 1)^2 + 0.02*rate(u)^2 + 1e-3*u^2" }
        constraints = { u = { min = -4, max = 4, rate = { min = -3, max = 3 } } }
        estimation = { kind = "ekf", outputs = { x = 0.01 } }
        solve = { method = "sqp" }
        run = { x0 = { x = -2 }, steps = 60, delay = 2, u0 = { u = -0.2 } }
    "#;
    let run = control(&read(INTEGRATOR, text).unwrap()).unwrap().run;
    let u = &run.closed_loop.u;
    assert_eq!((u[0][0], u[1][0]), (-0.2, -0.2));
    assert!(largest_rate(u, -0.2, 0.1) < 3.0 + 1e-3, "{u:?}");
    assert!((run.closed_loop.x[60][0] - 1.0).abs() < 0.01);
    // The cost counts the rates of what was applied.
    let mut before = -0.2;
    let cost: f64 = run
        .closed_loop
        .x
        .iter()
        .zip(u)
        .map(|(x, u)| {
            let rate = (u[0] - std::mem::replace(&mut before, u[0])) / 0.1;
            0.1 * ((x[0] - 1.0).powi(2) + 0.02 * rate * rate + 1e-3 * u[0] * u[0])
        })
        .sum();
    assert!((run.report.closed_loop_cost / cost - 1.0).abs() < 1e-9);
}

#[test]
fn a_live_controller_remembers_what_it_decided() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 10, dt = 0.1 }
        cost = { stage = "(x - 1)^2" }
        constraints = { u = { min = -4, max = 4, rate = { min = -2, max = 2 } } }
        solve = { method = "rti" }
    "#;
    let problem = read(INTEGRATOR, &format!("{text}\nrun = {{}}")).unwrap();
    let mut controller = problem.controller().unwrap();
    let first = controller.step(&[0.0]).unwrap().step.u[0];
    let second = controller.step(&[0.0]).unwrap().step.u[0];
    assert!((first - 0.2).abs() < 1e-4 && (second - first - 0.2).abs() < 1e-4, "{first} {second}");
    assert_eq!(controller.prediction().states(), 1);
    controller.reset().unwrap();
    assert!((controller.step(&[0.0]).unwrap().step.u[0] - 0.2).abs() < 1e-4);
    assert!(controller.step(&[0.0, 0.0]).is_err(), "what was applied is not measured");
}

#[test]
fn what_is_no_rate_of_an_input_is_refused_at_its_place() {
    let with = |cost: &str, constraints: &str| {
        let text = format!(
            "model = \"model.toml\"\nhorizon = {{ steps = 5, dt = 0.1 }}\ncost = {cost}\nconstraints = {constraints}\nrun = {{}}"
        );
        read(INTEGRATOR, &text).err().unwrap().to_string()
    };
    for (cost, constraints, message, line) in [
        ("{ stage = \"rate(x)^2\" }", "{}", "`x` in `rate(x)` is not an input of the model", 3),
        ("{ stage = \"x^2\", terminal = \"rate(u)^2\" }", "{}", "the end of the horizon has no input", 3),
        ("{ stage = \"der(u)^2\" }", "{}", "write `rate(u)`", 3),
        ("{ stage = \"x^2\" }", "{ x = { max = 1, rate = { max = 1 } } }", "`rate` applies to an input", 4),
        ("{ stage = \"x^2\" }", "{ u = { rate = 3 } }", "the rate of `u` must be a table", 4),
        ("{ stage = \"x^2\" }", "{ u = { rate = {} } }", "has no bounds", 4),
        ("{ stage = \"x^2\" }", "{ u = { rate = { min = 1, max = 2 } } }", "forbids holding it", 4),
        ("{ stage = \"x^2\" }", "{ u = { rate = { low = 1 } } }", "low", 4),
    ] {
        let error = with(cost, constraints);
        assert!(error.contains(message) && error.contains(&format!("problem.toml:{line}")), "{error}");
    }
}
