//! A simulation ends where it is once its flag is raised.

use bracketry_sim::{Inputs, Model, Outcome, SimulationSettings, StopReason, simulate};
use bracketry_system::System;

fn falling() -> Model {
    let text = "states = ['h', 'v']\ndynamics = { h = 'v', v = '-9.81' }";
    Model::new(&System::parse("falling", text).unwrap(), &Inputs::new()).unwrap()
}

#[test]
fn a_raised_flag_stops_before_the_first_step() {
    let settings = SimulationSettings::default();
    settings.stop.raise();
    let run = simulate(falling(), 0.0, &[1.0, 0.0], 1.0, &settings).unwrap();
    assert_eq!(run.outcome, Outcome::Stopped { reason: StopReason::Asked, t: 0.0, state: vec![1.0, 0.0] });
}

#[test]
fn a_flag_that_is_not_raised_changes_nothing() {
    let run = simulate(falling(), 0.0, &[1.0, 0.0], 1.0, &SimulationSettings::default()).unwrap();
    assert_eq!(run.outcome, Outcome::Finished);
    assert!((run.trajectory.final_state()[1] + 9.81).abs() < 1e-12);
}
