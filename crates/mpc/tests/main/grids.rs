//! Horizons whose intervals differ in length.

use crate::common::reports::read_with_model as read;
use bracketry_mpc::control;

const INTEGRATOR: &str = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }";
const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "9.81*sin(th) - 0.1*w + u" }
"#;
const BLOCK: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    dynamics = { x = "v", v = "u - 0.3*sign(v)" }
"#;

#[test]
fn inputs_are_those_of_dynamic_programming_over_the_intervals() {
    let lengths: Vec<f64> = (0..8).map(|k| 0.1 * 1.3f64.powi(k)).collect();
    // Σ L (x² + u²) with x⁺ = x + L u.
    let (mut p, mut gain) = (0.5, 0.0);
    for l in lengths.iter().rev() {
        gain = p / (1.0 + p * l);
        p = l + p / (1.0 + p * l);
    }
    let list = lengths.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    for horizon in ["{ steps = 8, dt = 0.1, growth = 1.3 }".to_owned(), format!("{{ lengths = [{list}] }}")] {
        for method in ["rti", "sqp"] {
            let text = format!(
                r#"
                horizon = {horizon}
                cost = {{ stage = "x^2 + u^2", terminal = "0.5*x^2" }}
                solve = {{ method = "{method}" }}
                run = {{ x0 = {{ x = 2 }}, steps = 12 }}
                "#
            );
            let run = control(&read(INTEGRATOR, &text).unwrap()).unwrap().run;
            assert!((run.report.open_loop_cost - 4.0 * p).abs() < 1e-7, "{} {}", run.report.open_loop_cost, 4.0 * p);
            assert_eq!(run.report.period_ms, 100.0);
            for (x, u) in run.closed_loop.x.iter().zip(&run.closed_loop.u) {
                assert!((u[0] + gain * x[0]).abs() < 1e-6, "{method}: {} {}", u[0], -gain * x[0]);
            }
        }
    }
}

#[test]
fn equal_lengths_are_the_uniform_grid() {
    let run = |horizon: &str| {
        let text = format!(
            "horizon = {horizon}\ncost = {{ stage = \"10*th^2 + 0.1*w^2 + 0.01*u^2\" }}\n\
             constraints = {{ u = {{ min = -10, max = 10 }} }}\nsolve = {{ method = \"rti\" }}\nrun = {{ x0 = {{ th = 2 }}, steps = 20 }}"
        );
        control(&read(PENDULUM, &text).unwrap()).unwrap().run.closed_loop.u
    };
    let uniform = run("{ steps = 4, dt = 0.04 }");
    assert_eq!(uniform, run("{ lengths = [0.04, 0.04, 0.04, 0.04] }"));
    assert_eq!(uniform, run("{ steps = 4, dt = 0.04, growth = 1 }"));
}

#[test]
fn a_growing_grid_sees_as_far_with_fewer_intervals() {
    // 25 intervals of 0.04 to 0.15 s see 2.1 s ahead, as 52 equal ones do.
    for method in ["rti", "sqp"] {
        let text = format!(
            r#"
            horizon = {{ steps = 25, dt = 0.04, growth = 1.055 }}
            cost = {{ stage = "10*th^2 + 0.1*w^2 + 0.01*u^2" }}
            constraints = {{ u = {{ min = -10, max = 10 }} }}
            solve = {{ method = "{method}" }}
            run = {{ x0 = {{ th = 2 }}, steps = 100 }}
            "#
        );
        let run = control(&read(PENDULUM, &text).unwrap()).unwrap().run;
        assert!(run.report.succeeded, "{method}: {:?}", run.report);
        assert!(run.closed_loop.x[100][0].abs() < 1e-3, "{method}: {:?}", run.closed_loop.x[100]);
    }
}

#[test]
fn exact_friction_is_planned_on_intervals_of_any_length() {
    let text = r#"
        horizon = { lengths = [0.1, 0.1, 0.1, 0.2, 0.2, 0.3, 0.5, 0.5] }
        cost = { stage = "(x - 1)^2 + 0.1*v^2 + 1e-3*u^2" }
        constraints = { u = { min = -3, max = 3 } }
        solve = { method = "stick-slip" }
        run = { steps = 60 }
    "#;
    let run = control(&read(BLOCK, text).unwrap()).unwrap().run;
    assert!((run.closed_loop.x[60][0] - 1.0).abs() < 0.02, "{:?}", run.closed_loop.x[60]);
}

#[test]
fn time_and_constraints_belong_to_the_grid_points() {
    // Costs vanish on x = t, and the bound cuts off what comes after t = 1.
    let text = r#"
        horizon = { lengths = [0.1, 0.2, 0.4, 0.8] }
        cost = { stage = "(x - t)^2", terminal = "(x - t)^2" }
        constraints = { x = { max = 0.9, hard = true } }
        solve = { method = "sqp" }
        run = { steps = 1 }
    "#;
    let mut controller = read(INTEGRATOR, text).unwrap().controller().unwrap();
    controller.step(&[0.0]).unwrap();
    let times = controller.prediction_times();
    for (t, expected) in times.iter().zip([0.0, 0.1, 0.3, 0.7, 1.5]) {
        assert!((t - expected).abs() < 1e-12);
    }
    for (k, t) in times.iter().enumerate() {
        assert!((controller.prediction().x(k)[0] - t.min(0.9)).abs() < 1e-4, "{k}");
    }
}

#[test]
fn what_does_not_make_a_grid_is_refused_at_its_place() {
    let rest = "cost = { stage = \"x^2 + u^2\" }\nrun = {}";
    for (horizon, more, message) in [
        ("{ lengths = [0.1, 0.2], dt = 0.1 }", "", "cannot be combined with `dt`"),
        ("{ lengths = [0.1, -0.2] }", "", "a length must be positive"),
        ("{ lengths = [] }", "", "`lengths` is empty"),
        ("{ lengths = 3 }", "", "must be a list"),
        ("{ steps = 200, dt = 0.1, growth = 1.5 }", "", "choose a growth closer to 1"),
        ("{ steps = 5, dt = 0.1, growth = 0 }", "", "`growth` must be positive"),
        ("{ steps = 5, end_time = 2, growth = 1.1 }", "", "give dt instead of end_time"),
        ("{ steps = 5, dt = 0.1, growth = 1.1 }", "solve = { method = \"plan\" }", "cannot be combined"),
        ("{ steps = 5, dt = 0.1, growth = 1.1 }", "constraints = { u = { rate = { max = 1 } } }", "rates of inputs"),
    ] {
        let error = read(INTEGRATOR, &format!("horizon = {horizon}\n{rest}\n{more}")).err().unwrap().to_string();
        assert!(error.contains(message) && error.contains("problem.toml:2"), "{error}");
    }
}
