//! Free end times and free parameters: known optima, what the loop makes of them, and what is refused.

use crate::common::reports::{close, read_with_model as read, run_with_found as run};
use bracketry_mpc::{ControlProblem, control};
use bracketry_system::System;

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

/// A folder with a table of a function over 0 … 6 s.
fn folder_of_table(name: &str, f: impl Fn(f64) -> f64) -> std::path::PathBuf {
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let row = |k: u32| format!("{},{}\n", f64::from(k) * 0.3, f(f64::from(k) * 0.3));
    let rows: String = (0..=20).map(row).collect();
    std::fs::write(folder.join("table.csv"), format!("t,value\n{rows}")).unwrap();
    folder
}

fn problem_beside(folder: &std::path::Path, model: &str, text: &str) -> ControlProblem {
    let file = folder.join("problem.toml");
    let text = format!("model = \"model.toml\"\n{text}");
    let problem = ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, model).map_err(Box::new));
    problem.unwrap_or_else(|e| panic!("{e}"))
}

/// A reference, also one of a table, is known at the end time that the plan decides on: |x'| ≤ 1 meets a + b t at a/(1 − b).
#[test]
fn a_moving_goal_is_met_in_minimum_time() {
    for (number, (a, b)) in [(1.0, 0.5), (2.0, -0.25), (0.6, 0.0)].into_iter().enumerate() {
        let folder = folder_of_table(&format!("free_goal_{number}"), |t| a + b * t);
        for goal in [
            format!("\"{a} + {b}*t\""),
            "{ file = \"table.csv\", column = \"value\", hold = \"linear\" }".to_owned(),
            "{ file = \"table.csv\", column = \"value\", hold = \"cubic\" }".to_owned(),
        ] {
            let problem = problem_beside(
                &folder,
                "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }",
                &format!(
                    r#"
                    horizon = {{ steps = 10, end_time = {{ free = true, min = 0.1, max = 5, guess = 1 }} }}
                    references = {{ goal = {goal} }}
                    cost = {{ stage = "1" }}
                    constraints = {{ u = {{ min = -1, max = 1 }}, met = {{ expression = "x - goal", at = "end", min = 0, max = 0, hard = true }} }}
                    run = {{}}
                    "#
                ),
            );
            let report = control(&problem).unwrap().run.report;
            let found = report.found.clone().unwrap();
            assert!(found.status == "converged" && found.interior_point_steps > 0, "{goal}: {found:?}");
            close(found.end_time.unwrap(), a / (1.0 - b), 1e-5);
            assert!(report.succeeded, "{goal}: {:?}", report.notes);
        }
    }
}

/// A parameter that varies over time is held between the samples: x' = 1 − c t gives x(T) = T − c T²/2 (1 − 1/N).
#[test]
fn a_parameter_over_time_is_that_of_the_end_time_found() {
    let (c, distance, steps) = (0.4, 0.8, 8);
    let folder = folder_of_table("free_drift", |t| -c * t);
    for drift in [format!("\"-{c}*t\""), "{ file = \"table.csv\", column = \"value\", hold = \"linear\" }".to_owned()] {
        let problem = problem_beside(
            &folder,
            "states = [\"x\"]\ninputs = [\"u\"]\nparameters = { d = 0 }\ndynamics = { x = \"u + d\" }",
            &format!(
                r#"
                horizon = {{ steps = {steps}, end_time = {{ free = true, min = 0.1, max = 2, guess = 0.5 }} }}
                parameters = {{ d = {drift} }}
                cost = {{ terminal = "t" }}
                constraints = {{ u = {{ min = -1, max = 1 }} }}
                target = {{ x = {{ value = {distance}, tolerance = 1e-4 }} }}
                run = {{}}
                "#
            ),
        );
        let found = control(&problem).unwrap().run.report.found.unwrap();
        assert!(found.status == "converged" && found.interior_point_steps > 0, "{drift}: {found:?}");
        let half = c / 2.0 * (1.0 - 1.0 / f64::from(steps));
        close(found.end_time.unwrap(), (1.0 - (1.0 - 4.0 * half * distance).sqrt()) / (2.0 * half), 1e-5);
    }
}

/// The plan with the end time found costs less than those with end times beside it, as a parabola through three of them has it.
#[test]
fn end_times_beside_the_one_found_cost_more_with_curved_references() {
    let folder = folder_of_table("free_curved", |t| (1.3 * t).sin());
    let table = |hold: &str| format!("{{ file = \"table.csv\", column = \"value\", hold = \"{hold}\" }}");
    for (r, cost) in [
        ("\"sin(1.3*t)\"".to_owned(), "(x - r)^2 + 0.1*u^2 + 0.3"),
        ("\"sin(1.3*t)\"".to_owned(), "(u - der(r))^2 + (x - r)^2 + 0.1*u^2 + 0.3"),
        (table("cubic"), "(x - r)^2 + 0.1*u^2 + 0.3"),
        (table("cubic"), "(u - der(r))^2 + (x - r)^2 + 0.1*u^2 + 0.3"),
    ] {
        let plan = |end_time: &str| {
            problem_beside(
                &folder,
                "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }",
                &format!(
                    r#"
                    horizon = {{ steps = 15, end_time = {end_time} }}
                    references = {{ r = {r} }}
                    cost = {{ stage = "{cost}", terminal = "2*(x - r)^2 + (t - 3)^2" }}
                    solve = {{ method = "plan", margin = 0, tolerance = 1e-8 }}
                    run = {{ x0 = {{ x = 0.4 }} }}
                    "#
                ),
            )
        };
        let problem = plan("{ free = true, min = 1, max = 6, guess = 2 }");
        let found = problem.with_free_values().unwrap().found.clone().unwrap();
        assert!(found.status == "converged" && found.interior_point_steps > 0, "{r}: {found:?}");
        let end = found.end_time.unwrap();
        let step = 1e-3 * end;
        let [before, at, after] = [-1.0, 0.0, 1.0].map(|k| plan(&format!("{}", end + k * step)).plan().unwrap().cost);
        close(at, found.cost, 1e-7);
        let vertex = 0.5 * (before - after) / (before - 2.0 * at + after);
        assert!(before > at && after > at && vertex.abs() < 0.1, "{r} {cost}: {end} {before} {at} {after}");
    }
}

#[test]
fn numbers_that_depend_on_what_is_free_are_refused_by_its_name() {
    for (entry, line) in [("run = { x0 = { x = \"2*p\" } }", 5), ("target = { x = \"p\" }\nrun = {}", 5)] {
        let text = format!(
            "horizon = {{ steps = 5, dt = 0.1 }}\nparameters = {{ p = {{ free = true, guess = 1 }} }}\n\
             cost = {{ stage = \"x^2\" }}\n{entry}"
        );
        let error = read(DRIFT, &text).err().unwrap().to_string();
        assert!(
            error.contains("the free parameter `p`") && error.contains(&format!("problem.toml:{line}:")),
            "{error}"
        );
    }
}

#[test]
fn a_table_that_jumps_is_refused_where_the_end_time_is_free() {
    let folder = folder_of_table("free_jumps", |t| t);
    let file = folder.join("problem.toml");
    for (hold, refused) in [("", true), (", hold = \"previous\"", true), (", hold = \"linear\"", false)] {
        let text = format!(
            "model = \"model.toml\"\nhorizon = {{ steps = 5, end_time = {{ free = true, guess = 2 }} }}\n\
             references = {{ r = {{ file = \"table.csv\", column = \"value\"{hold} }} }}\n\
             cost = {{ stage = \"(x - r)^2 + u^2\" }}\nrun = {{}}"
        );
        let read = ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, MASS).map_err(Box::new));
        let error = read.err().map(|e| e.to_string()).unwrap_or_default();
        assert_eq!(error.contains("problem.toml:3:") && error.contains("`r` jumps"), refused, "{hold}: {error}");
    }
}

/// Where only parameters are free, references vary over the given time: p t is closest to r = c t for p = c.
#[test]
fn parameters_are_found_with_references_over_time() {
    let folder = folder_of_table("free_fit", |t| 0.7 * t);
    for r in ["\"0.7*t\"", "{ file = \"table.csv\", column = \"value\", hold = \"linear\" }"] {
        let problem = problem_beside(
            &folder,
            DRIFT,
            &format!(
                r#"
                horizon = {{ steps = 12, dt = 0.3 }}
                parameters = {{ p = {{ free = true, min = -5, max = 5, guess = 3 }} }}
                references = {{ r = {r} }}
                cost = {{ stage = "(x - r)^2" }}
                run = {{}}
                "#
            ),
        );
        let report = control(&problem).unwrap().run.report;
        let found = report.found.unwrap();
        assert!(found.converged && report.succeeded, "{r}: {found:?} {:?}", report.notes);
        close(found.parameters.0[0].1, 0.7, 1e-6);
    }
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
            format!(
                "horizon = {{ steps = 5, end_time = {free} }}\ncost = {{ stage = \"x^2 + v^2 + u^2\", terminal = \"riccati\" }}\nrun = {{}}"
            ),
            "infinite horizon",
            3,
        ),
        (
            format!("horizon = {{ steps = 5, end_time = {free} }}\ntarget = {{ x = 1, v = \"w\" }}\n{rest}"),
            "unknown name `w`",
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
