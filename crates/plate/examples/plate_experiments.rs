//! Runs the published experiments on the published model and prints the tables of `docs/records/plate_experiments.md`:
//! `cargo run --release -p bracketry-plate --example plate_experiments --features measure`
#![allow(clippy::print_stdout)]

use bracketry_plate::experiment::{AmplitudeStep, Experiment, Run, two_step};
use bracketry_plate::{PlateError, Shape, published};
use bracketry_sim::SimulationSettings;

const START: [f64; 6] = [0.48, -0.03, 0.0, 0.0, 0.0, 0.0];

fn time(run: &Run) -> String {
    run.reached.map_or_else(|| "never".to_owned(), |t| format!("{t:.2} s"))
}

/// Experiment 2, in which the plate goes on without a jump.
fn along_x(omega_over_pi: u32) -> Experiment {
    Experiment::translation_x(omega_over_pi).with_amplitude_step(AmplitudeStep::Smooth)
}

fn orientation() -> Result<(), PlateError> {
    println!("| tilt | object | friction | 98 % of 90° | after 15 s |\n|---|---|---|---|---|");
    let as_published = Experiment::orientation();
    let turned_round = Experiment::orientation().with_reversed_tilt();
    let cases = [("as published", &as_published), ("turned round", &turned_round)];
    for (tilt, experiment) in cases {
        for (object, shape) in [("ellipse", Shape::REFERENCE_ELLIPSE), ("disk", Shape::REFERENCE_DISK)] {
            for mu in [0.2, 0.3, 0.5] {
                let x0 = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
                let run = experiment.run(&published(&shape, mu)?, &x0, 15.0, &SimulationSettings::default())?;
                let x = run.trajectory.final_state();
                let turns = x[2] / std::f64::consts::TAU;
                println!("| {tilt} | {object} | {mu} | {} | {turns:+.1} turns, {:+.1} rad/s |", time(&run), x[5]);
            }
        }
    }
    Ok(())
}

fn position() -> Result<(), PlateError> {
    println!(
        "| experiment | friction | 98 % of the distance | last second: from … to | peak to peak |\n|---|---|---|---|---|"
    );
    let experiments = [along_x(3), along_x(4), Experiment::translation_y()];
    for experiment in &experiments {
        for mu in [0.2, 0.3, 0.4] {
            let system = published(&Shape::REFERENCE_ELLIPSE, mu)?;
            let run = experiment.run(&system, &START, 15.0, &SimulationSettings::default())?;
            let (low, high) = run.range(14.0);
            let [low, high] = [low, high].map(|q| 1e3 * (q - experiment.target));
            println!(
                "| {} | {mu} | {} | {low:+.1} … {high:+.1} mm | {:.1} mm |",
                experiment.name,
                time(&run),
                high - low
            );
        }
    }
    println!("\n| wrong sign of e | friction | error at the start | after 4 s |\n|---|---|---|---|");
    for experiment in experiments {
        let system = published(&Shape::REFERENCE_ELLIPSE, 0.3)?;
        let run = experiment.clone().with_reversed_error().run(&system, &START, 4.0, &SimulationSettings::default())?;
        let start = 1e3 * (experiment.start - experiment.target);
        println!("| {} | 0.3 | {start:+.0} mm | {:+.0} mm |", experiment.name, 1e3 * run.final_error());
    }
    Ok(())
}

fn two_steps() -> Result<(), PlateError> {
    println!("| friction | stage | time taken | target met |\n|---|---|---|---|");
    let mut results = Vec::new();
    for mu in [0.2, 0.3, 0.4] {
        let stages = [Experiment::orientation().with_reversed_tilt(), along_x(3), Experiment::translation_y()];
        let system = published(&Shape::REFERENCE_ELLIPSE, mu)?;
        let result = two_step(&system, &stages, &START, 15.0, &SimulationSettings::default())?;
        for stage in &result.stages {
            let met = if stage.met { "yes" } else { "no" };
            println!("| {mu} | {} | {:.2} s | {met} |", stage.name, stage.to - stage.from);
        }
        results.push((mu, result));
    }
    println!("\n| friction | in all | error in x | error in y | error in phi | spin left |\n|---|---|---|---|---|---|");
    for (mu, result) in results {
        let e = &result.final_errors;
        let all = result.stages.iter().map(|s| s.to - s.from).sum::<f64>();
        println!(
            "| {mu} | {all:.2} s | {:+.1} mm | {:+.1} mm | {:+.0}° | {:+.3} rad/s |",
            1e3 * e[1],
            1e3 * e[2],
            e[0].to_degrees(),
            result.remaining_spin
        );
    }
    Ok(())
}

fn main() -> Result<(), PlateError> {
    println!("Experiment 1, orientation\n");
    orientation()?;
    println!("\nExperiments 2 and 3, position\n");
    position()?;
    println!("\nTwo steps on one plant: orientation, then x, then y\n");
    two_steps()
}
