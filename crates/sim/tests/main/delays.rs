//! Inputs that act later than they are commanded, against the same without delay.

use bracketry_sim::{ExactPlant, Hold, InputError, Inputs, Model, Samples, SimulationSettings, Stepper, simulate};
use bracketry_system::System;

const BLOCK: &str = r#"
states = ["x", "v"]
inputs = ["F", "X"]
parameters = { d = 0.013 }
dynamics = { x = "v", v = "F - 0.5*sign(v) - der(X, 2)" }
"#;

fn block(delays: &str) -> System {
    System::parse("block.toml", &format!("{BLOCK}{delays}")).unwrap()
}

fn end(system: &System, inputs: &Inputs) -> Vec<f64> {
    let model = Model::new(system, inputs).unwrap();
    simulate(model, 0.0, &[0.0, 0.2], 2.0, &SimulationSettings::default()).unwrap().trajectory.sample(2.0)
}

fn close(a: &[f64], b: &[f64]) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn an_expression_is_taken_earlier() {
    let delayed = Inputs::new().expression("F", "2*sin(5*t)").expression("X", "0.02*cos(7*t)");
    let earlier = Inputs::new().expression("F", "2*sin(5*(t - 0.013))").expression("X", "0.02*cos(7*(t - 0.1))");
    let system = block("[delays]\nF = \"d\"\nX = 0.1");
    close(&end(&system, &delayed), &end(&block(""), &earlier));
    let no_delay = end(&block(""), &delayed);
    assert!((no_delay[0] - end(&system, &delayed)[0]).abs() > 1e-3);
}

#[test]
fn samples_are_shifted_with_their_breaks() {
    let grid: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01).collect();
    let values: Vec<f64> = grid.iter().map(|t| 2.0 * (5.0 * t).sin()).collect();
    for hold in [Hold::Previous, Hold::Linear] {
        let samples =
            |shift: f64| Samples::new(grid.iter().map(|t| t + shift).collect(), values.clone(), hold).unwrap();
        let drive = |shift: f64| Inputs::new().samples("F", samples(shift)).derivative("X", 2, samples(2.0 * shift));
        let delays = "[delays]\nF = \"d\"\nX = \"2*d\"";
        close(&end(&block(delays), &drive(0.0)), &end(&block(""), &drive(0.013)));
        // Samples given later are shifted too.
        let mut model = Model::new(&block(delays), &drive(5.0)).unwrap();
        assert!(model.set_samples("F", 0, samples(0.0)) && model.set_samples("X", 2, samples(0.0)));
        let run = simulate(model, 0.0, &[0.0, 0.2], 2.0, &SimulationSettings::default()).unwrap();
        close(&run.trajectory.sample(2.0), &end(&block(""), &drive(0.013)));
    }
}

#[test]
fn a_held_value_acts_within_a_later_step() {
    let commands = [1.5, -2.0, 0.7, 0.0, 3.0, -1.0];
    for (delay, text) in [(0.03, "0.03"), (0.07, "0.07"), (0.25, "0.25"), (0.013, "\"d\"")] {
        let mut plant =
            ExactPlant::new(&block(&format!("[delays]\nF = {text}")), &[0.0, 0.2], &SimulationSettings::default())
                .unwrap();
        for u in commands {
            assert!(plant.hold(&[u, 0.0], 0.05).unwrap().is_finished());
        }
        let times: Vec<f64> = std::iter::once(-1.0).chain((0..6).map(|k| f64::from(k) * 0.05 + delay)).collect();
        let values = std::iter::once(0.0).chain(commands).collect();
        let inputs = Inputs::new().samples("F", Samples::new(times, values, Hold::Previous).unwrap());
        let model = Model::new(&block(""), &inputs).unwrap();
        let run = simulate(model, 0.0, &[0.0, 0.2], 0.3, &SimulationSettings::default()).unwrap();
        close(plant.state(), &run.trajectory.sample(0.3));
    }
}

#[test]
fn what_was_set_before_the_beginning_has_been_there_for_ever() {
    let mut model = Model::new(&block("[delays]\nF = 0.5"), &Inputs::new()).unwrap();
    model.set_inputs(&[2.0, 0.0]).unwrap();
    let mut stepper = Stepper::new(model, 3.0, &[0.0, 1.0], &SimulationSettings::default()).unwrap();
    stepper.system_mut().set_inputs(&[0.5, 0.0]).unwrap();
    assert!(stepper.advance(4.0).is_finished());
    // v' = 2 − 0.5 for half a second, then 0.5 − 0.5.
    close(stepper.state(), &[0.5 + 0.5 * 1.5 * 0.25 + 0.5 * 1.75, 1.75]);
}

#[test]
fn a_delay_that_is_no_time_is_refused() {
    let mut system = block("[delays]\nF = \"d\"");
    assert!(system.set_parameter("d", bracketry_symbolic::Rational::from(-1i64)));
    let error = Model::new(&system, &Inputs::new()).unwrap_err();
    assert_eq!(error, InputError::Delay { input: "F".into() });
}

/// x' = u with u held at p before the start and at u after it: x(t) = p t until the delay has passed.
#[test]
fn what_was_held_before_the_start_acts_until_the_delay_has_passed() {
    let text = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }\ndelays = { u = 0.25 }";
    let system = System::parse("m", text).unwrap();
    for (past, held) in [(0.0, 1.0), (-2.0, 1.5), (3.0, -0.5)] {
        let mut plant = ExactPlant::new(&system, &[0.0], &SimulationSettings::default()).unwrap();
        plant.set_past_inputs(&[past]).unwrap();
        for k in 1..=10 {
            assert!(plant.hold(&[held], 0.1).unwrap().is_finished());
            let t = 0.1 * f64::from(k);
            let expected = past * t.min(0.25) + held * (t - 0.25).max(0.0);
            assert!((plant.state()[0] - expected).abs() < 1e-12, "{t}: {} for {expected}", plant.state()[0]);
        }
    }
    let mut plant = ExactPlant::new(&system, &[0.0], &SimulationSettings::default()).unwrap();
    assert!(plant.set_past_inputs(&[]).is_err());
}
