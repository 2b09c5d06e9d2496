//! A static level of dry friction above the sliding level.

use bracketry_sim::{FrictionMode, InputError, Inputs, Model, Simulation, SimulationSettings, simulate};
use bracketry_system::System;

fn run(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64) -> Simulation {
    let system = System::parse("test.toml", text).unwrap();
    let model = Model::new(&system, inputs).unwrap();
    let run = simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

const BLOCK: &str = r#"
    states = ["v"]
    inputs = ["a"]
    parameters = { f = 2, r = 1.25 }
    dynamics = { v = "a - f*sign(v)" }
    static = { v = "r" }
"#;

#[test]
fn a_block_breaks_loose_at_the_static_level_and_slides_at_the_other() {
    let run = run(BLOCK, &Inputs::new().expression("a", "t"), &[0.0], 4.0);
    let event = run.trajectory.mode_changes()[0];
    assert!((event.t - 2.5).abs() < 1e-10);
    assert_eq!((event.from, event.to), (FrictionMode::Sticking, FrictionMode::Positive));
    // v' = t − 2 from 2.5 on.
    assert!((run.trajectory.final_state()[0] - (2.0 - 0.125)).abs() < 1e-9);
}

#[test]
fn a_sliding_block_is_caught_below_the_static_level() {
    // It comes to rest under a push between both levels, and stays.
    let run = run(BLOCK, &Inputs::new().expression("a", "-2.2"), &[4.2], 5.0);
    let event = run.trajectory.mode_changes()[0];
    assert!((event.t - 1.0).abs() < 1e-10);
    assert_eq!(event.to, FrictionMode::Sticking);
    assert_eq!(run.trajectory.final_state()[0], 0.0);
}

#[test]
fn on_a_plane_the_static_level_is_a_circle() {
    let text = r#"
        states = ["vx", "vy"]
        inputs = ["a", "b"]
        parameters = { f = 2, r = 1.25 }
        dynamics = { vx = "a - f*unit(vx, vy)", vy = "b - f*unit(vy, vx)" }
        [static]
        "vx, vy" = "r"
    "#;
    let inputs = Inputs::new().expression("a", "0.6*t").expression("b", "-0.8*t");
    let slide = run(text, &inputs, &[0.0, 0.0], 4.0);
    let events = slide.trajectory.mode_changes();
    assert_eq!(events.len(), 1, "{events:?}");
    assert!((events[0].t - 2.5).abs() < 1e-10);
    assert_eq!((events[0].from, events[0].to), (FrictionMode::Sticking, FrictionMode::Sliding));
    let v = slide.trajectory.final_state();
    assert!((v[0] - 0.6 * 1.875).abs() < 1e-9 && (v[1] + 0.8 * 1.875).abs() < 1e-9, "{v:?}");
}

#[test]
fn a_static_level_below_the_sliding_level_is_refused() {
    let mut system = System::parse("test.toml", BLOCK).unwrap();
    assert!(system.set_parameter("r", 0.into()));
    let refused = Model::new(&system, &Inputs::new()).unwrap_err();
    assert_eq!(refused, InputError::StaticLevel { switch: "v".into(), ratio: 0.0 });
}
