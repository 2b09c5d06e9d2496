//! A block on a shaken table, simulated with exact dry friction: when does it stick, when does it slide?
//!
//! `cargo run --release --example stick_slip`
#![allow(clippy::print_stdout)]

use bracketry::Scenario;
use bracketry::sim::SimulationSettings;
use bracketry::system::System;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // v is the velocity relative to the table, whose acceleration is a.
    let block = System::parse(
        "block.toml",
        r#"
        states = ["x", "v"]
        inputs = ["a"]
        [parameters]
        mu = 0.3
        g = 9.81
        [dynamics]
        x = "v"
        v = "-a - mu*g*sign(v)"
        "#,
    )?;
    let shaken = Scenario::parse("shaken.toml", "duration = 1.0\n[inputs]\na = \"4*sin(2*pi*2*t)\"", &block)?;
    let run = shaken.run(&block, &SimulationSettings::default())?;
    for interval in run.simulation.trajectory.mode_intervals(0) {
        println!("{:7.4} s to {:7.4} s: {:?}", interval.from, interval.to, interval.mode);
    }
    println!("it has moved by {:.3} mm", 1e3 * run.simulation.trajectory.final_state()[0]);
    Ok(())
}
