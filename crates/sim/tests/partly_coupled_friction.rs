//! Friction between that of the axes and that of the plane, `(1 − c) sign(v) + c v/|v|`: switches that depend on each other.
#![allow(clippy::unwrap_used)]

use bracketry_sim::{Inputs, Model, Settings, simulate};
use bracketry_system::System;

/// The published disk, with part `c` of its friction coupled over the plane.
fn disk(c: f64) -> System {
    let mixture = |axis: &str, other: &str| format!("((1 - {c})*sign({axis}) + {c}*unit({axis}, {other}))");
    let text = include_str!("../../../models/plate_published_disk.toml")
        .replace("sign(vx)", &mixture("vx", "vy"))
        .replace("sign(vy)", &mixture("vy", "vx"));
    System::parse("disk.toml", &text).unwrap()
}

#[test]
fn a_disk_on_a_shaken_plate_runs_to_the_end() {
    let inputs = Inputs::new()
        .expression("X", "0.025*sin(4*pi*t)*(1 - exp(-t))")
        .expression("theta", "-pi/12*sin(4*pi*t)*(1 - exp(-t))");
    for c in [0.1, 0.5, 0.9] {
        let model = Model::new(&disk(c), &inputs).unwrap();
        let run = simulate(model, 0.0, &[0.3, 0.0, 0.0, 0.0, 0.0, 0.0], 10.0, &Settings::default()).unwrap();
        assert!(run.outcome.is_finished(), "{c}: {:?}", run.outcome);
    }
}
