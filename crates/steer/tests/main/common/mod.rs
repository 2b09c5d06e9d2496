//! Models and checks of the tests.

use bracketry_sim::{Model, SimulationSettings, simulate};
use bracketry_steer::{SteerOptions, SteerStatus, Steering, steer};
use bracketry_system::System;

pub(crate) fn model(name: &str) -> System {
    System::read(format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// x' = rates from text.
pub(crate) fn system(states: &[&str], inputs: &[&str], rates: &[&str]) -> System {
    let list = |names: &[&str]| names.iter().map(|s| format!("'{s}'")).collect::<Vec<_>>().join(", ");
    let rates: Vec<String> = states.iter().zip(rates).map(|(s, r)| format!("{s} = '{r}'")).collect();
    let text = format!("states = [{}]\ninputs = [{}]\n[dynamics]\n{}\n", list(states), list(inputs), rates.join("\n"));
    System::parse("test.toml", &text).unwrap()
}

/// Numbers between −1 and 1 from a linear congruence.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub(crate) fn list(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// The end of an independent simulation of the model under the inputs of the result, with tolerances of its own.
pub(crate) fn replayed(system: &System, found: &Steering) -> Vec<f64> {
    let signals = found.signals.as_ref().unwrap();
    let inputs = signals.inputs(&found.system.input_names()).unwrap();
    let model = Model::new(&bracketry_steer::own_inputs(system).unwrap(), &inputs).unwrap();
    let settings = SimulationSettings::default().with_tolerance(1e-10, 1e-12);
    let run = simulate(model, 0.0, &found.from, signals.duration(), &settings).unwrap();
    assert!(run.outcome.is_finished());
    run.trajectory.final_state().to_vec()
}

/// Steers and checks the end by a simulation of its own.
pub(crate) fn reached(system: &System, options: &SteerOptions) -> Steering {
    let found = steer(system, options).unwrap();
    assert_eq!(found.status, SteerStatus::Reached, "{}: {:?} {:?}", system.name, found.end_error, found.attempts);
    for (i, (x, to)) in replayed(system, &found).iter().zip(&options.to).enumerate() {
        assert!((x - to).abs() < 1e-6, "{}: state {i} ends at {x}, not {to}", system.name);
    }
    found
}
