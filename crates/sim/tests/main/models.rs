//! Compiled models against closures and closed forms; inputs by expression, by samples, held.

use bracketry_sim::{
    Closures, ExactPlant, FrictionMode, Hold, InputError, Inputs, Model, Outcome, Samples, Simulation,
    SimulationSettings, Stepper, StopReason, simulate,
};
use bracketry_system::System;

fn system(text: &str) -> System {
    System::parse("test.toml", text).unwrap()
}

/// A block whose base moves by X(t): v' = −X'' − μ g sgn(v).
fn shaken() -> System {
    system(
        r#"
        states = ["x", "v"]
        inputs = ["X"]
        parameters = { mu = 0.3, g = 9.81 }
        dynamics = { x = "v", v = "-der(X, 2) - mu*g*sign(v)" }
        outputs = { place = "x + X", distance = "abs(x)" }
        "#,
    )
}

fn run(model: Model, x0: &[f64], t_end: f64) -> Simulation {
    let run = simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

fn close(a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (p, q) in a.iter().zip(b) {
        assert!((p - q).abs() < tolerance, "{a:?} {b:?}");
    }
}

#[test]
fn an_expression_gives_its_derivatives_to_the_model() {
    let inputs = Inputs::new().expression("X", "0.05*sin(4*pi*t)*(1 - exp(-t))");
    let compiled = run(Model::new(&shaken(), &inputs).unwrap(), &[0.1, 0.0], 3.0);
    let w = 4.0 * std::f64::consts::PI;
    let by_hand = Closures {
        dim: 2,
        switches: 1,
        rhs: move |t: f64, x: &[f64], s: &[f64], dx: &mut [f64]| {
            let (sin, cos) = (w * t).sin_cos();
            let decay = (-t).exp();
            let second = 0.05 * (-w * w * sin * (1.0 - decay) + 2.0 * w * cos * decay - sin * decay);
            dx[0] = x[1];
            dx[1] = -second - 0.3 * 9.81 * s[0];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[1],
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[1] = 1.0,
    };
    let reference = simulate(by_hand, 0.0, &[0.1, 0.0], 3.0, &SimulationSettings::default()).unwrap();
    close(compiled.trajectory.final_state(), reference.trajectory.final_state(), 1e-10);
    assert!(compiled.trajectory.mode_changes().len() > 10);
    assert_eq!(compiled.trajectory.mode_changes().len(), reference.trajectory.mode_changes().len());
}

#[test]
fn samples_are_held_or_joined_by_lines() {
    let push = system(
        r#"
        states = ["v"]
        inputs = ["a"]
        dynamics = { v = "a" }
        "#,
    );
    let times = vec![0.5, 1.0, 2.0];
    let values = vec![1.0, 3.0, -2.0];
    // Before the first sample its value holds, after the last one that.
    let held = Samples::new(times.clone(), values.clone(), Hold::Previous).unwrap();
    let lines = Samples::new(times, values, Hold::Linear).unwrap();
    let end = |samples| {
        let model = Model::new(&push, &Inputs::new().samples("a", samples)).unwrap();
        run(model, &[0.0], 3.0).trajectory.final_state()[0]
    };
    assert!((end(held) - (0.5 + 0.5 + 3.0 - 2.0)).abs() < 1e-12);
    assert!((end(lines) - (0.5 + 1.0 + 0.5 - 2.0)).abs() < 1e-12);
}

#[test]
fn a_derivative_comes_from_its_own_samples_or_is_asked_for() {
    let x = Samples::new(vec![0.0, 1.0], vec![0.0, 0.1], Hold::Linear).unwrap();
    let missing = Model::new(&shaken(), &Inputs::new().samples("X", x.clone())).unwrap_err();
    assert_eq!(missing, InputError::MissingDerivative { input: "X".into(), order: 2 });
    // X'' = −(μ g + 1) for a second: v' = 1.
    let second = Samples::new(vec![0.0, 1.0], vec![-3.943, 0.0], Hold::Previous).unwrap();
    let inputs = Inputs::new().samples("X", x).derivative("X", 2, second);
    let run = run(Model::new(&shaken(), &inputs).unwrap(), &[0.0, 0.0], 3.0);
    let stop = 1.0 + 1.0 / 2.943;
    close(run.trajectory.final_state(), &[0.5 + 0.5 / 2.943, 0.0], 1e-9);
    let events = run.trajectory.mode_changes();
    assert!((events.last().unwrap().t - stop).abs() < 1e-10);
}

#[test]
fn a_linear_signal_gives_its_first_derivative_and_moves_a_switching_surface() {
    // A block on a belt with sampled place: v' = −sgn(v − B').
    let belt = system(
        r#"
        states = ["v"]
        inputs = ["B"]
        dynamics = { v = "-sign(v - der(B))" }
        "#,
    );
    let b = Samples::new(vec![0.0, 1.0, 3.0], vec![0.0, 0.4, 4.4], Hold::Linear).unwrap();
    let belt_run = run(Model::new(&belt, &Inputs::new().samples("B", b)).unwrap(), &[0.0], 4.0);
    let times: Vec<f64> = belt_run.trajectory.mode_changes().iter().map(|e| e.t).collect();
    // Catches up with 0.4 at 0.4; the belt runs at 2 from 1 on, caught at 2.6; stands from 3 on: slides on to 4.
    close(&times, &[0.4, 1.0, 2.6, 3.0], 1e-10);
    close(belt_run.trajectory.final_state(), &[1.0], 1e-10);
    // A belt whose speed is the sampled signal: the surface moves within the segment, the block sticks to it.
    let belt = system("states = [\"v\"]\ninputs = [\"b\"]\ndynamics = { v = \"-sign(v - b)\" }");
    let b = Samples::new(vec![0.0, 1.0, 2.0], vec![0.0, 0.5, 2.5], Hold::Linear).unwrap();
    let run = run(Model::new(&belt, &Inputs::new().samples("b", b)).unwrap(), &[0.0], 1.5);
    assert_eq!(run.trajectory.mode(0, 0.7), Some(FrictionMode::Sticking));
    close(&run.trajectory.sample(0.7), &[0.35], 1e-10);
    assert_eq!(run.trajectory.mode(0, 1.2), Some(FrictionMode::Negative));
    close(run.trajectory.final_state(), &[1.0], 1e-10);
}

#[test]
fn abs_min_and_max_are_crossed_and_sign_sticks() {
    let model = system(
        r#"
        states = ["x", "v"]
        dynamics = { x = "v", v = "-x - 0.2*v*abs(v) - max(x, 0.5) + min(x, 0.3) - 0.1*sign(v)" }
        "#,
    );
    let run = run(Model::new(&model, &Inputs::new()).unwrap(), &[2.0, 0.0], 20.0);
    // Explicit fixed steps of 2 µs as reference, until it rests.
    let (mut x, mut v, dt) = (2.0f64, 0.0f64, 2e-6);
    for _ in 0..5_000_000 {
        let force = -x - 0.2 * v * v.abs() - x.max(0.5) + x.min(0.3);
        let free = v + dt * force;
        let after = free.signum() * (free.abs() - 0.1 * dt).max(0.0);
        x += 0.5 * dt * (v + after);
        v = after;
    }
    close(&run.trajectory.sample(10.0), &[x, v], 1e-5);
    let model = Model::new(&model, &Inputs::new()).unwrap();
    let names: Vec<&str> = model.switch_names().collect();
    for event in run.trajectory.mode_changes() {
        assert!(event.to != FrictionMode::Sticking || names[event.switch] == "v");
    }
}

#[test]
fn a_sign_in_an_input_switches_at_its_own_time() {
    let push = system("states = [\"v\"]\ninputs = [\"a\"]\ndynamics = { v = \"a\" }");
    let inputs = Inputs::new().expression("a", "2*sign(t - 1/3) + abs(t - 1)");
    let run = run(Model::new(&push, &inputs).unwrap(), &[0.0], 2.0);
    let times: Vec<f64> = run.trajectory.mode_changes().iter().map(|e| e.t).collect();
    close(&times, &[1.0 / 3.0, 1.0], 1e-10);
    close(run.trajectory.final_state(), &[2.0 * (5.0 - 1.0) / 3.0 + 1.0], 1e-10);
}

#[test]
fn live_numbers_change_while_the_model_runs() {
    let inputs = Inputs::new().expression("X", "-A*t^2/2").live("A", 4.0).live("mu", 0.2);
    let mut stepper =
        Stepper::new(Model::new(&shaken(), &inputs).unwrap(), 0.0, &[0.0, 0.0], &SimulationSettings::default())
            .unwrap();
    assert!(stepper.advance(1.0).is_finished());
    let v = 4.0 - 0.2 * 9.81;
    close(stepper.state(), &[v / 2.0, v], 1e-10);
    assert!(stepper.system_mut().set_live("A", 0.0) && stepper.system_mut().set_live("mu", 0.4));
    assert!(!stepper.system_mut().set_live("nothing", 0.4));
    assert!(stepper.advance(5.0).is_finished());
    close(stepper.state(), &[v / 2.0 + v * v / (0.8 * 9.81), 0.0], 1e-10);
}

#[test]
fn outputs_and_inputs_can_be_read_along_a_run() {
    let inputs = Inputs::new().expression("X", "0.1*t^2");
    let mut model = Model::new(&shaken(), &inputs).unwrap();
    close(&model.input_values(2.0), &[0.4], 1e-15);
    close(&model.output_values(2.0, &[-1.0, 0.0]), &[-0.6, 1.0], 1e-15);
}

#[test]
fn a_plant_keeps_its_modes_from_sample_to_sample() {
    let block = system(
        r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a - sign(v)" }
        "#,
    );
    let mut plant = ExactPlant::new(&block, &[0.3, 0.0], &SimulationSettings::default()).unwrap();
    // Below the friction for a minute: not a nanometer.
    for i in 0..6000 {
        let u = 0.99 * (0.37 * f64::from(i)).sin();
        assert!(plant.hold(&[u], 0.01).unwrap().is_finished());
    }
    assert_eq!((plant.state(), plant.modes()), (&[0.3, 0.0][..], &[FrictionMode::Sticking][..]));
    // A push of 3 for 0.1 s: v = 0.2, then 0.2 s to rest.
    for i in 0..50 {
        let u = if i < 10 { 3.0 } else { 0.0 };
        assert!(plant.hold(&[u], 0.01).unwrap().is_finished());
    }
    close(plant.state(), &[0.3 + 0.01 + 0.02, 0.0], 1e-12);
    plant.set_state(&[0.0, -1.0]).unwrap();
    assert!(plant.hold(&[0.0], 0.5).unwrap().is_finished());
    close(plant.state(), &[-0.375, -0.5], 1e-12);
    assert!(plant.hold(&[0.0, 0.0], 0.1).is_err());
    assert!(plant.hold(&[0.0], -0.1).is_err());
    let outcome = plant.hold(&[f64::NAN], 0.1).unwrap();
    assert!(matches!(outcome, Outcome::Stopped { .. }));
}

#[test]
fn a_plant_goes_on_from_where_it_stopped() {
    let block =
        system("states = [\"x\", \"v\"]\ninputs = [\"a\"]\ndynamics = { x = \"v\", v = \"sqrt(a) - sign(v)\" }");
    for (v0, bad) in [(0.0, f64::NAN), (0.0, f64::INFINITY), (0.5, f64::NAN), (0.5, -1.0)] {
        let mut plant = ExactPlant::new(&block, &[0.0, v0], &SimulationSettings::default()).unwrap();
        assert!(plant.hold(&[0.25], 0.1).unwrap().is_finished());
        let before = plant.state().to_vec();
        for _ in 0..3 {
            assert!(matches!(plant.hold(&[bad], 0.1).unwrap(), Outcome::Stopped { .. }));
            assert_eq!(plant.state(), before);
        }
        assert!(plant.hold(&[0.25], 0.1).unwrap().is_finished());
        // Friction 1 against a push of 0.5.
        let v = (v0 - 0.1f64).max(0.0);
        close(plant.state(), &[v0 * v0 - v * v, v], 1e-10);
        assert_eq!(plant.modes(), &[if v > 0.0 { FrictionMode::Positive } else { FrictionMode::Sticking }]);
        assert!((plant.time() - 0.2).abs() < 1e-15);
    }
}

#[test]
fn wrong_inputs_are_named() {
    let model = |inputs: &Inputs| Model::new(&shaken(), inputs).unwrap_err();
    assert_eq!(
        model(&Inputs::new().expression("Y", "t")),
        InputError::UnknownInput { name: "Y".into(), known: vec!["X".into()] }
    );
    assert!(matches!(model(&Inputs::new().expression("X", "sin(")), InputError::Expression { .. }));
    assert!(matches!(model(&Inputs::new().expression("X", "x")), InputError::Expression { .. }));
    assert_eq!(model(&Inputs::new().live("v", 1.0)), InputError::NameTaken { name: "v".into() });
    let nested = system("states = [\"v\"]\ndynamics = { v = \"-sign(v - sign(v))\" }");
    assert!(matches!(Model::new(&nested, &Inputs::new()), Err(InputError::NestedJump { .. })));
    for (times, values) in
        [(vec![0.0, 0.0], vec![1.0, 2.0]), (vec![], vec![]), (vec![0.0], vec![f64::NAN]), (vec![0.0], vec![])]
    {
        assert!(matches!(Samples::new(times, values, Hold::Linear), Err(InputError::BadSamples { .. })));
    }
}

#[test]
fn derivatives_without_the_input_drive_the_model() {
    // X'' = −(μ g + 1) for a second: v' = 1.
    let second = Samples::new(vec![0.0, 1.0], vec![-3.943, 0.0], Hold::Previous).unwrap();
    let first = Samples::new(vec![0.0, 1.0], vec![0.0, 0.0], Hold::Previous).unwrap();
    let inputs = Inputs::new().derivative("X", 2, second.clone());
    let mut shaken = shaken();
    let model = |system: &System, inputs: &Inputs| Model::new(system, inputs);
    assert_eq!(model(&shaken, &inputs).unwrap_err(), InputError::OnlyDerivatives { input: "X".into() });
    shaken.outputs.clear();
    let run = run(model(&shaken, &inputs).unwrap(), &[0.0, 0.0], 3.0);
    close(run.trajectory.final_state(), &[0.5 + 0.5 / 2.943, 0.0], 1e-9);
    let other = Inputs::new().derivative("X", 1, first);
    assert_eq!(model(&shaken, &other).unwrap_err(), InputError::MissingDerivative { input: "X".into(), order: 2 });
}

#[test]
fn impulses_that_are_left_out_are_known() {
    let left_out =
        |x: &str| Model::new(&shaken(), &Inputs::new().expression("X", x)).unwrap().impulses_left_out().to_vec();
    let second = vec![("X".to_owned(), 2)];
    for x in ["0.1*sign(sin(3*t))", "abs(t - 1)", "max(0, t - 1)", "max(t - 1, 0)", "min(t, 2)^3", "t*abs(cos(t))"] {
        assert_eq!(left_out(x), second, "{x}");
    }
    for x in ["sin(3*t)", "abs(t - 1)^3", "max(0, t - 1)^2", "max(t - 1, 0)^3", "sign(g)*t^2", "abs(t - 1)*(t - 1)"] {
        assert_eq!(left_out(x), [], "{x}");
    }
}

#[test]
fn a_rate_that_is_no_number_at_the_start_is_reported_as_such() {
    let block = system("states = [\"v\"]\ninputs = [\"F\"]\ndynamics = { v = \"F - sign(v)\" }");
    let model = Model::new(&block, &Inputs::new().expression("F", "log(t - 3)")).unwrap();
    let run = simulate(model, 0.0, &[0.0], 1.0, &SimulationSettings::default()).unwrap();
    assert!(matches!(run.outcome, Outcome::Stopped { reason: StopReason::NonFinite, t: 0.0, .. }), "{:?}", run.outcome);
}
