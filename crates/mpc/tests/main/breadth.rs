//! Rates of inputs, intervals of different lengths, and free end times on a pendulum: the costs that IPOPT finds for the same
//! discretized problem (`python benches/peers/breadth_references.py`).

use bracketry_mpc::{ControlProblem, control};
use bracketry_system::{Accepted, System};

const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "9.81*sin(th) - 0.1*w + u" }
"#;

fn read(text: &str) -> ControlProblem {
    let text = format!("model = \"pendulum.toml\"\n{text}");
    ControlProblem::parse("problem.toml", &text, |file| System::parse(file, PENDULUM).map_err(Box::new)).unwrap()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a / b - 1.0).abs() <= tolerance, "{a} is not {b}");
}

#[test]
fn a_swing_with_limited_and_weighed_rates_costs_what_ipopt_finds() {
    let run = control(&read(
        r#"
        horizon = { steps = 50, dt = 0.04, substeps = 2 }
        cost = { stage = "10*th^2 + 0.1*w^2 + 0.01*u^2", residuals = ["rate(u)"], weights = [1e-4] }
        constraints = { u = { min = -10, max = 10, rate = { min = -60, max = 60 } } }
        solve = { method = "sqp" }
        run = { x0 = { th = 2 }, steps = 1 }
        "#,
    ));
    close(run.unwrap().run.report.open_loop_cost, 68.10873463368233, 1e-6);
}

#[test]
fn a_swing_on_a_growing_grid_costs_what_ipopt_finds() {
    let run = control(&read(
        r#"
        horizon = { steps = 25, dt = 0.04, growth = 1.055, substeps = 2 }
        cost = { stage = "10*th^2 + 0.1*w^2 + 0.01*u^2" }
        constraints = { u = { min = -10, max = 10 } }
        solve = { method = "sqp" }
        run = { x0 = { th = 2 }, steps = 1 }
        "#,
    ));
    close(run.unwrap().run.report.open_loop_cost, 54.639596861456575, 1e-6);
}

#[test]
fn time_and_effort_to_the_top_are_those_that_ipopt_finds() {
    for (effort, guess, cost, end_time) in
        [(0.01, 1.5, 1.6253937616171956, 0.9268364035989023), (0.1, 3.3, 3.7326464047937042, 3.3046221317275766)]
    {
        let text = format!(
            r#"
            horizon = {{ steps = 30, substeps = 2, end_time = {{ free = true, guess = {guess}, min = 0.2, max = 10 }} }}
            cost = {{ stage = "1 + {effort}*u^2" }}
            constraints = {{ u = {{ min = -12, max = 12 }} }}
            target = {{ th = 0, w = 0 }}
            run = {{ x0 = {{ th = 1 }} }}
            "#
        );
        let report = control(&read(&text)).unwrap().run.report;
        let found = report.found.as_ref().unwrap();
        close(found.end_time.unwrap(), end_time, 1e-4);
        close(found.cost, cost, 1e-5);
        assert!(found.converged && report.succeeded, "{report:?}");
    }
}

#[test]
fn the_examples_of_the_guide_do_what_they_say() {
    let guide = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/mpc.md");
    let guide = std::fs::read_to_string(guide).unwrap();
    let blocks = guide.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap());
    let (problems, models): (Vec<&str>, Vec<&str>) =
        blocks.filter(|b| b.contains("states =") || b.contains("model =")).partition(|b| b.contains("model ="));
    let model = |name: &str| {
        let names = ["pendulum.toml", "mass.toml", "van_der_pol.toml", "stock.toml"];
        models[names.iter().position(|known| *known == name).unwrap()]
    };
    let accepted = Accepted { discrete: true, ..Accepted::default() };
    let runs: Vec<_> = problems[1..]
        .iter()
        .map(|text| {
            let read = |file: &str| System::parse_accepting(file, model(file), accepted).map_err(Box::new);
            control(&ControlProblem::parse("problem.toml", text, read).unwrap()).unwrap().run
        })
        .collect();
    assert_eq!(runs.len(), 6, "references, rates, intervals, end time, periodic motion, discrete time");
    assert!(runs.iter().all(|r| r.report.succeeded), "{:?}", runs.iter().map(|r| &r.report).collect::<Vec<_>>());
    // The pendulum follows angle and rate of the reference.
    let tracking = &runs[0].closed_loop;
    for (t, x) in tracking.t.iter().zip(&tracking.x).skip(40) {
        assert!((x[0] - 0.5 * t.sin()).abs() < 0.02 && (x[1] - 0.5 * t.cos()).abs() < 0.05, "{t}: {x:?}");
    }
    let rates = runs[1].closed_loop.u.windows(2).map(|u| (u[1][0] - u[0][0]).abs() / 0.04);
    assert!(rates.fold(0.0, f64::max) < 60.01);
    close(runs[3].report.found.as_ref().unwrap().end_time.unwrap(), 2.0, 1e-4);
    close(runs[4].report.found.as_ref().unwrap().end_time.unwrap(), 6.6634, 1e-5);
}
