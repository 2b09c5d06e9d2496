//! Models that are discrete in time: the iteration by hand, and what a scenario of one may say.

use bracketry_sim::{Hold, InputError, Inputs, Model, Outcome, Samples, Scenario, SimulationSettings};
use bracketry_system::{Accepted, System};

fn model(text: &str) -> System {
    System::parse_accepting("model.toml", text, Accepted { discrete: true, ..Accepted::default() }).unwrap()
}

const LOGISTIC: &str =
    "time = 'discrete'\nperiod = 0.1\nstates = ['x']\nparameters = { r = 3.7 }\ndynamics = { x = 'r*x*(1 - x)' }";

#[test]
fn the_logistic_map_is_iterated() {
    let system = model(LOGISTIC);
    let scenario = Scenario::parse("s.toml", "duration = 10\nx0 = { x = 0.2 }", &system).unwrap();
    let run = scenario.run(&system, &SimulationSettings::default()).unwrap();
    let mut x = 0.2;
    assert_eq!(run.states.len(), 101);
    for (k, row) in run.states.iter().enumerate() {
        assert!((row[0] - x).abs() < 1e-12 * 2f64.powi(k.min(30) as i32), "{k}");
        // From the run's own state: chaos doubles every rounding error.
        x = 3.7 * row[0] * (1.0 - row[0]);
        assert!((run.times[k] - 0.1 * k as f64).abs() < 1e-12);
    }
    assert_eq!(run.simulation.statistics.steps, 100);
    // Between its steps, the state holds.
    assert_eq!(run.simulation.trajectory.sample(0.25), run.states[2]);
}

#[test]
fn a_discretized_integrator_adds_up_its_inputs() {
    let text = "time = 'discrete'\nperiod = 0.1\nstates = ['s', 'n']\ninputs = ['u', 'w']\ndynamics = { s = 's + 0.1*u + w', n = 'n + 1' }\n\
                outputs = { twice = '2*s + u' }";
    let system = model(text);
    // Decimal times of samples, none of which a multiple of 0.1 may miss by rounding.
    let times: Vec<f64> = (0..=200).map(|k| format!("{:.1}", 0.1 * f64::from(k)).parse().unwrap()).collect();
    let values: Vec<f64> = (0..=200).map(|k| f64::from(k * k)).collect();
    let inputs =
        Inputs::new().samples("u", Samples::new(times, values, Hold::Previous).unwrap()).expression("w", "sign(t - 1)");
    let scenario = Scenario { x0: vec![0.0, 0.0], inputs, start: 0.0, end: 20.0, sample: 0.5, parameters: Vec::new() };
    let run = scenario.run(&system, &SimulationSettings::default()).unwrap();
    assert_eq!(run.states.len(), 41);
    for (row, x) in run.states.iter().enumerate() {
        let k = 5 * row;
        let sum: f64 = (0..k).map(|i| 0.1 * (i * i) as f64).sum();
        let steps: f64 = (0..k).map(|i| f64::from(i32::from(i > 10) - i32::from(i < 10))).sum();
        assert!((x[0] - sum - steps).abs() < 1e-9 * (1.0 + sum), "{k}");
        assert_eq!(x[1], k as f64);
        assert!((run.outputs[row][0] - 2.0 * x[0] - (k * k) as f64).abs() < 1e-9 * (1.0 + sum));
    }
}

#[test]
fn times_are_multiples_of_the_period() {
    let system = model(LOGISTIC);
    for (text, key) in [("duration = 1.05", "duration"), ("duration = 1\nsample = 0.15", "sample")] {
        let error = Scenario::parse("s.toml", text, &system).unwrap_err().to_string();
        assert!(error.contains(&format!("`{key}` is not a multiple of the model's period 0.1")), "{error}");
        assert!(error.contains("s.toml:"), "{error}");
    }
}

#[test]
fn a_run_ends_before_a_state_that_is_not_finite() {
    let system = model("time = 'discrete'\nperiod = 1\nstates = ['x']\ndynamics = { x = 'x^2' }");
    let scenario = Scenario::parse("s.toml", "duration = 50\nx0 = { x = 2 }", &system).unwrap();
    let run = scenario.run(&system, &SimulationSettings::default()).unwrap();
    let Outcome::Stopped { t, state, .. } = &run.simulation.outcome else { panic!("it should stop") };
    // 2^(2^9) is a number, 2^(2^10) is none.
    assert_eq!((*t, state[0]), (9.0, 2f64.powi(512)));
    assert_eq!(run.times.last(), Some(&9.0));
}

#[test]
fn a_map_is_not_integrated() {
    assert!(matches!(Model::new(&model(LOGISTIC), &Inputs::new()), Err(InputError::DiscreteTime)));
}
