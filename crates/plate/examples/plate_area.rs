//! Area contact on the published experiments, converged in time step and number of points.
//!
//! `cargo run --release -p bracketry-plate --example plate_area --features measure`
#![allow(clippy::print_stdout)]

use bracketry_plate::area::{AreaContact, AreaRecord, AreaSettings, Scheme};
use bracketry_plate::driven::Course;
use bracketry_plate::experiment::{Experiment, Run};
use bracketry_plate::{AreaObject, DrivenObject, Friction, Object, PlateError, Shape};

/// Runs an experiment from where its coordinate starts, otherwise at `x = 0.3 m`, `y = 0`.
fn run(
    experiment: &Experiment,
    object: &Object,
    mu: f64,
    settings: &AreaSettings,
    duration: f64,
) -> Result<Run<AreaRecord>, PlateError> {
    let mut plant = AreaObject::new(AreaContact::new(object, &Friction::Coulomb { mu }, settings)?)?;
    let mut state = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    state[experiment.index()] = experiment.start;
    plant.set_state(0.0, state)?;
    experiment.run_on(&mut plant, duration)
}

/// First time at which the yaw is a quarter turn.
fn quarter(record: &AreaRecord) -> String {
    let turned = record.samples.iter().find(|s| s.state[2] >= 0.5 * std::f64::consts::PI);
    turned.map_or("never".into(), |s| format!("{:.3} s", s.t))
}

fn main() -> Result<(), PlateError> {
    let disk = |height| Object { shape: Shape::REFERENCE_DISK, height, mass: 0.2, ..Object::REFERENCE };
    let settings = AreaSettings::default();
    let orientation = Experiment::orientation();

    println!("Experiment 1, disk, mu 0.3, 15 s: yaw at the end, time of 90°");
    println!("| scheme | step [ms] | points | h = 0 | | h = 2.5 mm | |");
    println!("|---|---|---|---|---|---|---|");
    let mut steps = Vec::new();
    for scheme in [Scheme::Euler, Scheme::SecondOrder] {
        for step in [4.0, 2.0, 1.0, 0.5, 0.25] {
            steps.push((scheme, step, 48));
        }
    }
    for points in [12, 24, 96, 192, 768] {
        steps.push((Scheme::SecondOrder, 1.0, points));
    }
    for (scheme, step, points) in steps {
        let settings = settings.clone().with_scheme(scheme).with_step(1e-3 * step).with_points(points);
        let mut yaws = Vec::new();
        for height in [0.0, 0.0025] {
            let run = run(&orientation, &disk(height), 0.3, &settings, 15.0)?;
            let record = &run.trajectory;
            yaws.push(format!("{:.2}° | {}", record.state_at(15.0)[2].to_degrees(), quarter(record)));
        }
        let yaws = yaws.join(" | ");
        println!("| {scheme:?} | {step} | {points} | {yaws} |");
    }

    println!("\nExperiment 1 of other objects and coefficients, h = 0");
    println!("| object | mu | yaw at 15 s | 90° | breaks loose | energy balance |");
    println!("|---|---|---|---|---|---|");
    let shapes = [
        ("disk 0.12 m", Shape::REFERENCE_DISK),
        ("ellipse 0.15 × 0.10 m", Shape::REFERENCE_ELLIPSE),
        ("rectangle 0.15 × 0.10 m", Shape::Rectangle { a: 0.15, b: 0.10 }),
    ];
    for (name, shape) in shapes {
        for mu in [0.2, 0.3, 0.5] {
            let object = Object { shape: shape.clone(), height: 0.0, mass: 0.2, ..Object::REFERENCE };
            let run = run(&orientation, &object, mu, &settings, 15.0)?;
            let record = &run.trajectory;
            println!(
                "| {name} | {mu} | {:.2}° | {} | {} times | {:.0e} |",
                record.state_at(15.0)[2].to_degrees(),
                quarter(record),
                record.events.len() / 2,
                record.energy.relative_error()
            );
        }
    }

    println!("\nExperiments 2 and 3, disk, h = 2.5 mm, amplitude held over each period");
    println!(
        "| experiment | mu | step [ms] | 98 % after | error at the end [mm] | peak to peak of the last second [mm] |"
    );
    println!("|---|---|---|---|---|---|");
    for (experiment, mu) in [
        (Experiment::translation_x(3), 0.3),
        (Experiment::translation_x(4), 0.3),
        (Experiment::translation_y(), 0.3),
        (Experiment::translation_y(), 0.4),
    ] {
        for step in [2.0, 1.0, 0.5] {
            let settings = settings.clone().with_step(1e-3 * step);
            let run = run(&experiment, &disk(0.0025), mu, &settings, 15.0)?;
            let (low, high) = run.range(14.0);
            println!(
                "| {} | {mu} | {step} | {} | {:.2} | {:.2} |",
                experiment.name,
                run.reached.map_or("never".into(), |t| format!("{t:.3} s")),
                1e3 * run.final_error(),
                1e3 * (high - low)
            );
        }
    }
    Ok(())
}
