//! Free end times and free parameters: known optima, what the loop makes of them, and what is refused.

use crate::common::reports::read_with_model as read;
use bracketry_mpc::control;
use bracketry_mpc::problem::{ControlRun, FoundValues};

const MASS: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    dynamics = { x = "v", v = "u" }
"#;
const DRIFT: &str = r#"
    states = ["x"]
    inputs = ["u"]
    parameters = { p = 1 }
    dynamics = { x = "p + 0*u" }
"#;

fn run(model: &str, text: &str) -> (FoundValues, ControlRun) {
    let run = control(&read(model, text).unwrap()).unwrap().run;
    let found = run.report.found.clone().unwrap();
    assert!(found.converged, "{found:?}");
    (found, run)
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn a_mass_moves_from_rest_to_rest_in_minimum_time() {
    for (distance, force, guess) in [(1.0, 1.0, 3.0), (5.0, 0.4, 3.0), (0.02, 30.0, 0.2)] {
        let (found, run) = run(
            MASS,
            &format!(
                r#"
                horizon = {{ steps = 20, end_time = {{ free = true, guess = {guess} }} }}
                cost = {{ stage = "1" }}
                constraints = {{ u = {{ min = -{force}, max = {force} }} }}
                target = {{ x = {distance}, v = 0 }}
                run = {{}}
                "#
            ),
        );
        let minimum = 2.0 * f64::sqrt(distance / force);
        close(found.end_time.unwrap(), minimum, 1e-4);
        close(found.cost, minimum, 1e-4);
        // The loop tracks the plan on the grid of the end time found.
        let report = &run.report;
        assert!(report.succeeded, "{report:?}");
        close(report.period_ms, 1e3 * minimum / 20.0, 1e-4);
        close(*run.closed_loop.t.last().unwrap(), minimum, 1e-4);
        assert_eq!(run.closed_loop.u[0].len(), 1);
    }
}

/// The end time is a variable of the interior-point method: neither a far guess nor the unit of the cost decides whether it is found.
#[test]
fn minimum_times_are_found_from_far_guesses_and_in_any_unit_of_the_cost() {
    for guess in [0.5, 2.0, 10.0] {
        for price in ["1e-4", "1", "1e4"] {
            let (found, run) = run(
                MASS,
                &format!(
                    r#"
                    horizon = {{ steps = 30, end_time = {{ free = true, guess = {guess} }} }}
                    cost = {{ stage = "{price}" }}
                    constraints = {{ u = {{ min = -1, max = 1 }} }}
                    target = {{ x = 1, v = 0 }}
                    run = {{}}
                    "#
                ),
            );
            close(found.end_time.unwrap(), 2.0, 1e-4);
            assert!((1..=60).contains(&found.interior_point_steps), "{guess} {price}: {found:?}");
            assert_eq!(found.status, "converged", "{guess} {price}");
            assert!(run.report.succeeded, "{guess} {price}: {:?}", run.report.notes);
        }
    }
}

#[test]
fn the_brachistochrone_is_a_cycloid() {
    let bead = r#"
        states = ["x", "y", "v"]
        inputs = ["th"]
        parameters = { g = 9.81 }
        dynamics = { x = "v*sin(th)", y = "v*cos(th)", v = "g*cos(th)" }
    "#;
    let (found, run) = run(
        bead,
        r#"
        horizon = { steps = 40, end_time = { free = true, min = 0.2, max = 5, guess = 2 } }
        cost = { terminal = "t" }
        constraints = { th = { min = 0, max = 3 } }
        target = { x = "pi", y = 2 }
        guess = { th = "0.5 + 0.5*t" }
        run = {}
        "#,
    );
    // A cycloid of radius 1 down to its lowest point.
    close(found.end_time.unwrap(), std::f64::consts::PI / 9.81f64.sqrt(), 1e-3);
    assert!(run.report.succeeded, "{:?}", run.report);
}

#[test]
fn time_and_effort_are_weighed_against_each_other() {
    // Effort 12 d²/T³ (1 + O(1/N²)) of a move from rest to rest, and c per second: T⁴ = 36 d²/c.
    for (distance, weight) in [(1f64, 1.0), (3.0, 0.2)] {
        let (found, _) = run(
            MASS,
            &format!(
                r#"
                horizon = {{ steps = 50, end_time = {{ free = true, min = 0.5, max = 20, guess = 1.5 }} }}
                cost = {{ stage = "u^2 + {weight}" }}
                target = {{ x = {distance}, v = 0 }}
                run = {{}}
                "#
            ),
        );
        close(found.end_time.unwrap(), (36.0 * distance * distance / weight).powf(0.25), 1e-3);
    }
}

#[test]
fn a_move_with_the_least_effort_and_time_has_the_end_time_of_its_grid() {
    // Effort 12 d²/T³·N²/(N² − 1) with inputs held over N intervals, and c per second.
    for (distance, price, steps) in [(1f64, 0.5, 100), (0.3, 2.0, 30), (4.0, 0.1, 60), (2.0, 1.0, 12)] {
        let (found, run) = run(
            MASS,
            &format!(
                r#"
                horizon = {{ steps = {steps}, end_time = {{ free = true, guess = 2 }} }}
                cost = {{ stage = "u^2", terminal = "{price}*t" }}
                target = {{ x = {{ value = {distance}, tolerance = 1e-4 }}, v = {{ value = 0, tolerance = 1e-4 }} }}
                run = {{}}
                "#
            ),
        );
        let effort = 12.0 * distance * distance / (1.0 - f64::from(steps).powi(-2));
        let end = (3.0 * effort / price).powf(0.25);
        close(found.end_time.unwrap(), end, 2e-5);
        close(found.cost, effort / end.powi(3) + price * end, 1e-6);
        close(run.report.open_loop_cost, found.cost, 1e-6);
    }
}

#[test]
fn time_in_the_equations_is_that_of_the_end_time_found() {
    let ramp = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }";
    // The cost follows the clock: u = t, x(T) = T²/2 = 2.
    let (found, run) = run(
        ramp,
        r#"
        horizon = { steps = 40, end_time = { free = true, guess = 1 } }
        cost = { stage = "100*(u - t)^2", terminal = "(x - 2)^2 + (t - 2)^2" }
        run = {}
        "#,
    );
    close(found.end_time.unwrap(), 2.0, 2e-2);
    close(run.closed_loop.x[40][0], 2.0, 2e-2);
}

#[test]
fn rates_are_per_second_of_the_end_time_found() {
    let (n, model) = (20f64, "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }");
    let (found, _) = run(
        model,
        r#"
        horizon = { steps = 20, end_time = { free = true, guess = 3 } }
        cost = { stage = "1" }
        constraints = { u = { rate = { min = -1, max = 1 } } }
        target = { x = 1 }
        run = {}
        "#,
    );
    // u_k = (k + 1) h, x = h² N (N + 1)/2 = 1.
    close(found.end_time.unwrap(), n * (2.0 / (n * (n + 1.0))).sqrt(), 1e-4);
}

#[test]
fn parameters_are_decided_on_and_used_by_model_and_plant() {
    let problem = |cost: &str, constraints: &str| {
        format!(
            r"
            horizon = {{ steps = 10, dt = 0.2 }}
            parameters = {{ p = {{ free = true, min = -5, max = 5, guess = 1 }} }}
            cost = {{ {cost} }}
            constraints = {{ {constraints} }}
            run = {{}}
            "
        )
    };
    for (cost, constraints, p) in [
        ("terminal = \"(x - 3)^2\"", "", 1.5),
        ("terminal = \"(x - 3)^2 + p^2\"", "", 1.2),
        ("stage = \"(p - 2)^2\", terminal = \"(p + 1)^2\"", "", 1.0),
        ("terminal = \"(p - 1)^2\"", "end = { expression = \"x - p\", at = \"end\", max = -1, hard = true }", -1.0),
        ("terminal = \"(p - 1)^2\"", "path = { expression = \"x\", max = \"2 - p\", hard = true }", 2.0 / 3.0),
        ("terminal = \"(p - 9)^2\"", "", 5.0),
    ] {
        let (found, run) = run(DRIFT, &problem(cost, constraints));
        close(found.parameters.0[0].1, p, 1e-5);
        close(run.closed_loop.x[10][0], 2.0 * p, 1e-4);
    }
}

#[test]
fn an_end_time_and_a_parameter_are_found_together() {
    // x(T) = p T = 1 with the cost T + p²: T = 1/p, p = 2^(−1/3).
    let (found, _) = run(
        DRIFT,
        r#"
        horizon = { steps = 10, end_time = { free = true, min = 0.1, max = 10, guess = 1 } }
        parameters = { p = { free = true, guess = 2, min = 0.1 } }
        cost = { terminal = "t + p^2" }
        target = { x = 1 }
        run = {}
        "#,
    );
    let p = 2f64.powf(-1.0 / 3.0);
    close(found.parameters.0[0].1, p, 1e-4);
    close(found.end_time.unwrap(), 1.0 / p, 1e-4);
}

#[test]
fn a_given_end_time_is_that_of_the_horizon() {
    let problem =
        read(MASS, "horizon = { steps = 20, end_time = 3 }\ncost = { stage = \"x^2 + u^2\" }\nrun = {}").unwrap();
    assert_eq!((problem.ocp.dt, problem.has_free_values()), (0.15, false));
}

#[test]
fn what_cannot_be_free_is_refused_at_its_place() {
    let free = "{ free = true, guess = 2 }";
    let rest = "cost = { stage = \"1 + u^2\" }\nrun = {}";
    for (text, message, line) in [
        (format!("horizon = {{ steps = 5, dt = 0.1, end_time = {free} }}\n{rest}"), "both define the horizon", 2),
        (format!("horizon = {{ steps = 5, end_time = {{ free = true }} }}\n{rest}"), "has no `guess`", 2),
        (format!("horizon = {{ steps = 5, end_time = {{ guess = 1 }} }}\n{rest}"), "is not free", 2),
        (format!("horizon = {{ steps = 5, end_time = {{ free = true, guess = -1 }} }}\n{rest}"), "positive", 2),
        (format!("horizon = {{ steps = 5, end_time = {{ free = true, guess = 1, min = 2 }} }}\n{rest}"), "between", 2),
        (
            format!("horizon = {{ steps = 5, end_time = {free} }}\n{rest}\nsolve = {{ method = \"rti\" }}"),
            "cannot optimize an end time",
            5,
        ),
        (
            format!("horizon = {{ steps = 5, end_time = {free} }}\n{rest}\nreferences = {{ r = \"sin(t)\" }}"),
            "vary over time",
            0,
        ),
        (
            format!(
                "horizon = {{ steps = 5, end_time = {free} }}\ncost = {{ stage = \"x^2 + v^2 + u^2\", terminal = \"riccati\" }}\nrun = {{}}"
            ),
            "infinite horizon",
            3,
        ),
        (
            format!("horizon = {{ steps = 5, dt = 0.1 }}\nparameters = {{ q = {free} }}\n{rest}"),
            "`q` is not a parameter",
            3,
        ),
    ] {
        let error = read(MASS, &text).err().unwrap().to_string();
        let place = if line == 0 { "problem.toml".to_owned() } else { format!("problem.toml:{line}") };
        assert!(error.contains(message) && error.contains(&place), "{error}");
    }
}
