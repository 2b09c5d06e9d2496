//! A controller that is stepped from outside is the one of the closed loop, and outlives whatever is measured.

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::controller::InputSource;
use bracketry_mpc::live::Change;
use bracketry_mpc::{ControlProblem, LiveController, MpcError, Plant, SymbolicDynamics};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    parameters = { g = 9.81, d = 0.1 }
    dynamics = { th = "w", w = "g*sin(th) - d*w + u" }
"#;

fn problem(rest: &str) -> ControlProblem {
    let text = format!("model = \"pendulum.toml\"\nhorizon = {{ steps = 30, dt = 0.05 }}\n{rest}");
    ControlProblem::parse("problem.toml", &text, |f| System::parse(f, PENDULUM).map_err(Box::new)).unwrap()
}

const STATES: &str = r#"
    cost = { stage = "10*(th - r)^2 + 0.1*w^2 + 0.01*u^2" }
    references = { r = "0.3*sin(2*t)" }
    constraints = { u = { min = -12, max = 12 }, w = { min = -6, max = 6, soft = [10, 10] } }
    run = { x0 = { th = 2.5 }, steps = 60 }
"#;

/// The problem by each method, with an estimator and a delay too.
fn variants() -> Vec<(&'static str, ControlProblem)> {
    let estimation = r#"
        cost = { stage = "10*(th - r)^2 + 0.1*w^2 + 0.01*u^2" }
        references = { r = "0.3*sin(2*t)" }
        constraints = { u = { min = -12, max = 12 } }
        run = { x0 = { th = 2.5 }, steps = 60, delay = 2 }
        estimation = { kind = "ekf", outputs = { th = 0.01 }, disturbances = { u = { std = 0.1 } } }
    "#;
    let target = r#"
        cost = { stage = "0.1*w^2 + 0.01*u^2" }
        target = { th = 0, w = 0 }
        solve = { method = "plan" }
        constraints = { u = { min = -12, max = 12 } }
        run = { x0 = { th = 0.5 }, steps = 40 }
    "#;
    vec![
        ("rti", problem(&format!("{STATES}\nsolve = {{ method = \"rti\", initial_iterations = 5 }}"))),
        ("sqp", problem(&format!("{STATES}\nsolve = {{ method = \"sqp\" }}"))),
        ("stick-slip", problem(&format!("{STATES}\nsolve = {{ method = \"stick-slip\" }}"))),
        ("plan", problem(target)),
        ("estimator and delay", problem(estimation)),
    ]
}

fn plant(problem: &ControlProblem) -> RungeKuttaPlant {
    RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&problem.plant).unwrap()), problem.plant_substeps)
}

#[test]
fn every_live_step_is_that_of_the_closed_loop_bit_for_bit() {
    for (name, problem) in variants() {
        let run = problem.run(&mut plant(&problem)).unwrap().closed_loop;
        for apart in [false, true] {
            let mut controller = problem.controller().unwrap();
            for (k, y) in run.y.iter().enumerate() {
                let step = if apart {
                    controller.prepare().unwrap();
                    controller.feedback(y).unwrap()
                } else {
                    controller.step_at(y, 7.0 + k as f64 * 0.05).unwrap()
                };
                assert_eq!(step.step.u, run.steps[k].u, "{name}, sample {k}");
                assert_eq!((step.sample, step.missed), (k, 0));
                assert_eq!(step.step.status, run.steps[k].status);
            }
        }
    }
}

#[test]
fn a_reset_controller_answers_as_at_first() {
    for (name, problem) in variants() {
        let run = problem.run(&mut plant(&problem)).unwrap().closed_loop;
        let mut controller = problem.controller().unwrap();
        let inputs = |controller: &mut LiveController| -> Vec<Vec<f64>> {
            run.y.iter().take(8).map(|y| controller.step(y).unwrap().step.u.clone()).collect()
        };
        let first = inputs(&mut controller);
        controller.reset_to(&vec![0.1; controller.states().len()]).unwrap();
        inputs(&mut controller);
        controller.reset().unwrap();
        assert_eq!(inputs(&mut controller), first, "{name}");
    }
}

#[test]
fn known_references_go_on_after_the_run_of_the_file() {
    let problem = problem(&format!("{STATES}\nsolve = {{ method = \"rti\" }}"));
    let mut longer = problem.clone();
    longer.samples = 1400;
    let points = longer.samples + longer.ocp.steps;
    longer.schedule.write(&mut longer.ocp, 0, points);
    let run = longer.run(&mut plant(&longer)).unwrap().closed_loop;
    let mut controller = problem.controller().unwrap();
    for (k, y) in run.y.iter().enumerate() {
        assert_eq!(controller.step(y).unwrap().step.u, run.u[k], "sample {k}");
    }
}

#[test]
fn whatever_is_measured_the_input_is_finite_and_within_its_bounds() {
    let mut random = StdRng::seed_from_u64(5);
    for (name, problem) in variants() {
        let mut controller = problem.controller().unwrap();
        let measured = controller.measured().len();
        for _ in 0..150 {
            let y: Vec<f64> = (0..measured)
                .map(|_| match random.random_range(0..8) {
                    0 => f64::NAN,
                    1 => f64::INFINITY,
                    2 => 1e200 * random.random_range(-1.0..1.0),
                    _ => random.random_range(-3.0..3.0),
                })
                .collect();
            let u = controller.step(&y).unwrap().step.u[0];
            assert!((-12.0..=12.0).contains(&u), "{name}: {u} after {y:?}");
        }
        assert!(matches!(controller.step(&vec![0.0; measured + 1]), Err(MpcError::Length { .. })));
    }
}

#[test]
fn a_refused_measurement_leaves_the_controller_as_it_was() {
    for (name, problem) in variants() {
        let (mut controller, mut other) = (problem.controller().unwrap(), problem.controller().unwrap());
        let y = vec![0.4; controller.measured().len()];
        for k in 0..5 {
            let t = k as f64 * 0.05;
            if k > 0 {
                for wrong in [f64::NAN, f64::INFINITY, t - 0.05, -1.0, t + 100.0] {
                    assert!(matches!(controller.step_at(&y, wrong), Err(MpcError::Time { .. })), "{name}, t = {wrong}");
                }
            }
            assert!(controller.step_at(&[], t).is_err());
            let u = controller.step_at(&y, t).unwrap().step.u.clone();
            assert_eq!(u, other.step(&y).unwrap().step.u, "{name}");
        }
    }
}

/// While samples pass without a measurement, the last input is held; the horizon moves on, so that what is known of later times
/// is used at the right time.
#[test]
fn passed_samples_move_the_horizon() {
    let problem = problem(&format!("{STATES}\nsolve = {{ method = \"sqp\" }}"));
    let mut plant = plant(&problem);
    let mut controller = problem.controller().unwrap();
    let (mut x, mut k) = (vec![0.1, 0.0], 0);
    for passed in [0, 3, 0, 1, 7, 0, 2] {
        k += passed;
        let step = controller.step_at(&x, k as f64 * 0.05).unwrap();
        assert_eq!((step.sample, step.missed), (k, passed));
        let u = step.step.u.clone();
        // A controller that starts at this sample, from the same state, agrees once converged.
        let mut fresh = problem.clone();
        fresh.x0.clone_from(&x);
        fresh.schedule.references[0] = {
            let (start, reference) = (k as f64 * 0.05, problem.schedule.references[0].clone());
            bracketry_mpc::problem::Scheduled::new("r", move |t| reference.at(t + start))
        };
        fresh.schedule.write(&mut fresh.ocp, 0, 100);
        let expected = fresh.controller().unwrap().step(&x).unwrap().step.u[0];
        assert!((u[0] - expected).abs() < 1e-3 * (1.0 + expected.abs()), "sample {k}: {} ≠ {expected}", u[0]);
        plant.step(k as f64 * 0.05, &mut x, &u, 0.05).unwrap();
        k += 1;
    }
}

#[test]
fn a_sample_without_a_measurement_gets_the_plan() {
    let problem = problem(&format!("{STATES}\nsolve = {{ method = \"rti\", initial_iterations = 5 }}"));
    let mut controller = problem.controller().unwrap();
    controller.step(&[2.5, 0.0]).unwrap();
    let planned = controller.prediction().u(1).to_vec();
    let step = controller.lost().unwrap();
    assert_eq!((step.step.u.clone(), step.step.source), (planned, InputSource::Plan));
    assert_eq!(step.step.status.name(), "fallback");
}

#[test]
fn the_prediction_starts_at_the_measurement_and_obeys_the_model() {
    let problem = problem(&format!("{STATES}\nsolve = {{ method = \"sqp\" }}"));
    let (mut plant, mut controller) = (plant(&problem), problem.controller().unwrap());
    let u = controller.step(&[1.0, 0.5]).unwrap().step.u.clone();
    for prepared in [false, true] {
        if prepared {
            controller.prepare().unwrap();
        }
        let plan = controller.prediction();
        assert_eq!((plan.x(0), plan.u(0)), ([1.0, 0.5].as_slice(), u.as_slice()));
        let mut x = plan.x(0).to_vec();
        for k in 0..plan.steps() {
            plant.step(k as f64 * 0.05, &mut x, plan.u(k), 0.05).unwrap();
            assert!(x.iter().zip(plan.x(k + 1)).all(|(a, b)| (a - b).abs() < 1e-4), "interval {k}");
        }
    }
}

#[test]
fn references_parameters_bounds_and_targets_change_while_it_runs() {
    let text = r#"
        live_parameters = ["g"]
        cost = { stage = "10*(th - r)^2 + 0.1*w^2 + 0.001*(u + g*sin(th))^2" }
        references = { r = 0 }
        constraints = { u = { min = -12, max = 12 } }
        run = { x0 = { th = 0.2 }, steps = 60 }
        solve = { method = "rti" }
    "#;
    let problem = problem(text);
    let mut heavier = problem.plant.clone();
    let mut controller = problem.controller().unwrap();
    let mut x = vec![0.2, 0.0];
    let mut go = |controller: &mut LiveController, system: &System| {
        let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(system).unwrap()), 1);
        let mut largest = 0.0f64;
        for _ in 0..80 {
            let u = controller.step(&x).unwrap().step.u.clone();
            largest = largest.max(u[0].abs());
            plant.step(0.0, &mut x, &u, 0.05).unwrap();
        }
        (x[0], largest)
    };
    assert!(go(&mut controller, &heavier).0.abs() < 1e-3);
    controller.set_reference("r", 0.5).unwrap();
    assert!((go(&mut controller, &heavier).0 - 0.5).abs() < 1e-3);
    heavier.set_parameter("g", bracketry_symbolic::Rational::from(4));
    let wrong = (go(&mut controller, &heavier).0 - 0.5).abs();
    controller.set_parameters(&[("g", 4.0)]).unwrap();
    let right = (go(&mut controller, &heavier).0 - 0.5).abs();
    assert!(right < 1e-3 && wrong > 1e-2, "{right} {wrong}");
    controller.set_bounds("u", -2.5, 2.5).unwrap();
    controller.set_reference("r", 0.0).unwrap();
    let (end, largest) = go(&mut controller, &heavier);
    assert!(end.abs() < 1e-3 && largest <= 2.5, "{end} {largest}");
    for error in [
        controller.set_reference("q", 1.0),
        controller.set_reference("r", f64::NAN),
        controller.set_parameters(&[("g", 9.0), ("d", 1.0)]),
        controller.change(&[
            Change::Reference { name: "r", value: 1.0 },
            Change::Bounds { name: "u", min: -0.1, max: 0.1 },
            Change::Bounds { name: "w", min: 1.0, max: -1.0 },
        ]),
        controller.set_bounds("u", 1.0, -1.0),
        controller.set_bounds("z", 0.0, 1.0),
        controller.set_target("th", 1.0),
        controller.set_reference_ahead("r", &[]),
    ] {
        assert!(error.is_err());
    }
    for (name, what) in [("u", "input `u`"), ("w", "state `w`")] {
        let error = controller.set_bounds(name, 1.0, -1.0).err().unwrap().to_string();
        assert!(error.contains(what), "{error}");
    }
    assert!(go(&mut controller, &heavier).0.abs() < 1e-3, "what was refused changed nothing");
}

/// While changes make no sense, the input stays finite and within its bounds; once they are taken back, the controller controls.
#[test]
fn absurd_changes_are_outlived() {
    for method in ["rti", "sqp"] {
        let problem = problem(&format!(
            "live_parameters = [\"g\"]\ncost = {{ stage = \"10*(th - r)^2 + 0.1*w^2 + 0.01*u^2\" }}\nreferences = {{ r = 0 }}\n\
             constraints = {{ u = {{ min = -12, max = 12 }} }}\nrun = {{ x0 = {{ th = 0.3 }} }}\nsolve = {{ method = \"{method}\" }}"
        ));
        let parameter = |value| Change::Parameter { name: "g", value };
        let reference = |value| Change::Reference { name: "r", value };
        let bounds = |name, min, max| Change::Bounds { name, min, max };
        let free = bounds("th", f64::NEG_INFINITY, f64::INFINITY);
        for (absurd, sane) in [
            (parameter(1e300), parameter(9.81)),
            (reference(-1e300), reference(0.0)),
            (reference(1e9), reference(0.0)),
            (bounds("u", 1e9, 1e10), bounds("u", -12.0, 12.0)),
            (bounds("u", 0.0, 0.0), bounds("u", -12.0, 12.0)),
            (bounds("th", 5.0, 6.0), free),
            (bounds("th", 1e300, 1e301), free),
        ] {
            let (mut plant, mut controller) = (plant(&problem), problem.controller().unwrap());
            controller.step(&[0.3, 0.0]).unwrap();
            controller.change(&[absurd]).unwrap();
            for _ in 0..3 {
                let u = controller.step(&[0.3, 0.0]).unwrap().step.u[0];
                let (min, max) = controller.problem().ocp.input_bounds[0];
                assert!(min <= u && u <= max, "{method}, {absurd:?}: {u}");
            }
            controller.change(&[sane]).unwrap();
            let mut x = vec![0.3, 0.0];
            for _ in 0..60 {
                let u = controller.step(&x).unwrap().step.u.clone();
                plant.step(0.0, &mut x, &u, 0.05).unwrap();
            }
            assert!(x[0].abs() < 1e-2, "{method}, {absurd:?}: ends at {}", x[0]);
        }
    }
}

/// A sensor that lies once, by any amount, costs no more than the sample after, or with an estimator that counts outliers linearly, none.
#[test]
fn one_absurd_measurement_is_outlived() {
    let plain = format!("{STATES}\nsolve = {{ method = \"rti\" }}");
    let estimated = r#"
        cost = { stage = "10*(th - r)^2 + 0.1*w^2 + 0.01*u^2" }
        references = { r = 0 }
        constraints = { u = { min = -12, max = 12 } }
        run = { x0 = { th = 0.2 } }
        estimation = { kind = "ekf", outputs = { th = 0.01 }, outliers = 3 }
    "#;
    for (text, spoiled) in [(plain.as_str(), 1), (estimated, 0)] {
        let problem = problem(text);
        for lie in [1e3, -1e12, 1e300] {
            let mut controller = problem.controller().unwrap();
            let mut y = vec![0.2; controller.measured().len()];
            controller.step(&y).unwrap();
            y[0] = lie;
            controller.step(&y).unwrap();
            y[0] = 0.2;
            for k in 0..4 {
                let status = controller.step(&y).unwrap().step.status;
                assert!(k < spoiled || status.name() == "solved", "{lie}, {k} samples after: {status:?}");
            }
        }
    }
}

#[test]
fn a_reference_given_ahead_is_that_of_the_file() {
    let problem = problem(&format!("{STATES}\nsolve = {{ method = \"sqp\" }}"));
    let mut ahead = problem.controller().unwrap();
    let mut known = problem.controller().unwrap();
    for k in 0..20 {
        let values: Vec<f64> = (0..=30).map(|i| 0.3 * (2.0 * (f64::from(k + i) * 0.05)).sin()).collect();
        ahead.set_reference_ahead("r", &values).unwrap();
        let (a, b) = (ahead.step(&[0.2, 0.0]).unwrap().step.u[0], known.step(&[0.2, 0.0]).unwrap().step.u[0]);
        assert!((a - b).abs() < 1e-7, "sample {k}: {a} {b}");
    }
}

#[test]
fn the_log_keeps_the_last_samples_with_the_inputs_that_acted() {
    let (_, problem) = variants().pop().unwrap();
    let run = problem.run(&mut plant(&problem)).unwrap().closed_loop;
    let mut controller = problem.controller().unwrap();
    controller.keep_log(20);
    for y in &run.y {
        controller.step(y).unwrap();
    }
    let log = controller.log().unwrap();
    assert_eq!(log.names(), ["t", "th", "u"]);
    assert_eq!(log.rows().len(), 20);
    for (row, k) in log.rows().zip(run.y.len() - 20..) {
        assert_eq!(row, [run.t[k], run.y[k][0], run.u[k][0]]);
    }
}

/// Without `[run]`, the controller does what the one does whose file has the first measured state as x0, by every method, after a
/// reset too.
#[test]
fn a_problem_without_a_run_starts_from_the_first_measurement() {
    let body = r#"
        cost = { stage = "10*(th - r)^2 + 0.1*w^2 + 0.01*u^2" }
        references = { r = "0.3*sin(2*t)" }
        constraints = { u = { min = -12, max = 12 } }
    "#;
    for method in ["", "solve = { method = \"rti\", initial_iterations = 5 }", "solve = { method = \"plan\" }"] {
        let open = problem(&format!("{body}\n{method}"));
        assert!(matches!(open.run(&mut plant(&open)), Err(MpcError::NoRun)));
        let given = problem(&format!("{body}\n{method}\nrun = {{ x0 = {{ th = 1.5, w = -0.5 }} }}"));
        let inputs = |controller: &mut LiveController| {
            let y = |k: usize| [1.5 - 0.02 * k as f64, -0.5];
            (0..8).map(|k| controller.step(&y(k)).unwrap().step.u[0]).collect::<Vec<f64>>()
        };
        let expected = inputs(&mut given.controller().unwrap());
        // The sizes of the states, to which programs are solved, are those of another trial run.
        let same = |found: &[f64]| found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-5);
        let mut controller = open.controller().unwrap();
        let first = inputs(&mut controller);
        assert!(same(&first), "{method}: {first:?} {expected:?}");
        controller.reset().unwrap();
        assert_eq!(inputs(&mut controller), first, "{method}, after a reset");
        controller.reset_to(&[1.5, -0.5]).unwrap();
        assert!(same(&inputs(&mut controller)), "{method}, from a given state");
    }
}

/// A reference that is changed takes its derivative along: 0 for a constant, differences for values known ahead.
#[test]
fn the_derivative_of_a_changed_reference_is_that_of_its_new_values() {
    let with = |reference: &str, derivative: &str| {
        problem(&format!(
            "cost = {{ stage = \"10*(th - r)^2 + 0.1*(w - {derivative})^2 + 0.01*u^2\" }}\nsolve = {{ method = \"rti\" }}\n\
             references = {{ {reference} }}\nrun = {{ x0 = {{ th = 0.1 }} }}"
        ))
    };
    let ahead: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k * k % 17)).collect();
    let slopes: Vec<f64> = ahead.windows(2).map(|w| (w[1] - w[0]) / 0.05).chain([0.0]).collect();
    let mut derived = with("r = \"sin(t)\"", "der(r)").controller().unwrap();
    let mut spelled = with("r = \"sin(t)\", rate_of_r = \"cos(t)\"", "rate_of_r").controller().unwrap();
    assert_eq!(derived.references(), ["r"]);
    assert!(matches!(derived.set_reference("der(r)", 1.0), Err(MpcError::NoSuchName { .. })));
    for k in 0..30 {
        if k == 10 {
            derived.set_reference_ahead("r", &ahead).unwrap();
            spelled.set_reference_ahead("r", &ahead).unwrap();
            spelled.set_reference_ahead("rate_of_r", &slopes).unwrap();
        } else if k == 20 {
            derived.set_reference("r", 0.2).unwrap();
            spelled.set_reference("r", 0.2).unwrap();
            spelled.set_reference("rate_of_r", 0.0).unwrap();
        }
        let y = [0.1 + 0.01 * f64::from(k), 0.0];
        let (a, b) = (derived.step(&y).unwrap().step.u[0], spelled.step(&y).unwrap().step.u[0]);
        assert!((a - b).abs() < 1e-9, "sample {k}: {a} {b}");
    }
}

/// The innovation is what the plant differs by from the model over a sample; there is none to begin with, and after missed samples.
#[test]
fn the_innovation_tells_what_plant_and_model_differ_by() {
    let model = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u' }";
    let problem = "model = 'm'\nhorizon = { steps = 20, dt = 0.1 }\ncost = { stage = 'x^2 + 0.1*v^2 + 0.01*u^2' }\n\
                   constraints = { u = { min = -1, max = 1 } }\nrun = { x0 = { x = 1 } }";
    for mass in [1.0, 1.5] {
        let read = |name: &str| System::parse(name, model).map_err(Box::new);
        let mut controller = ControlProblem::parse("p", problem, read).unwrap().controller().unwrap();
        let (mut x, mut v, mut before) = (1.0, 0.0, 0.0);
        for k in 0..20 {
            let live = controller.step_at(&[x, v], 0.1 * f64::from(if k < 10 { k } else { k + 2 })).unwrap().clone();
            if k == 0 || k == 10 {
                assert!(live.innovation.is_empty());
            } else {
                // The last input acted on another mass.
                assert!((live.innovation[1] - before * (1.0 / mass - 1.0) * 0.1).abs() < 1e-6, "{mass} {k}: {live:?}");
            }
            let u = live.step.u[0];
            before = u;
            (x, v) = (x + 0.1 * v + 0.005 * u / mass, v + 0.1 * u / mass);
        }
        assert!(controller.predicted_cost() >= 0.0);
    }
}
