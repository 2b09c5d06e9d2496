//! Draws cycle-averaged velocity fields of periodic plate motions for `docs/records/plate_terms.md`:
//! `cargo run --release -p bracketry-plate --example plate_velocity_field --features measure [FOLDER]`
#![allow(clippy::print_stdout, dead_code)]

mod common;

use bracketry_plate::experiment::{Establishing, Map, MeanVelocity, linspace, mean_velocity};
use bracketry_plate::model::Terms;
use bracketry_plate::{Harmonic, Object, PeriodicMotion, PlateError};
use bracketry_plot::{Arrow, ColorMap, HeatMap, VectorField};
use common::{Progress, folder, reduced_plant, save};
use std::f64::consts::{PI, TAU};

const MU: f64 = 0.3;

/// `X = 25 mm sin ωt`, `theta = 6° sin(ωt + phase) + 3° sin(2ωt + phase)` at 3 Hz.
fn motion(phase: f64) -> PeriodicMotion {
    let degree = PI / 180.0;
    PeriodicMotion {
        frequency: 3.0,
        displacement: vec![Harmonic { amplitude: 0.025, phase: 0.0 }],
        tilt: vec![Harmonic { amplitude: 6.0 * degree, phase }, Harmonic { amplitude: 3.0 * degree, phase }],
        mean_tilt: 0.0,
    }
}

fn mean(motion: &PeriodicMotion, place: [f64; 3]) -> Result<MeanVelocity, PlateError> {
    mean_velocity(
        &mut reduced_plant(&Object::REFERENCE, Terms::default(), MU, [0.0; 6])?,
        motion,
        place,
        Establishing::default(),
    )
}

/// What a mean velocity is good for in a figure: nothing if it was not established.
fn established(result: Option<&Result<MeanVelocity, PlateError>>) -> [f64; 3] {
    match result {
        Some(Ok(mean)) if mean.established && mean.least_load > 0.0 => mean.mean,
        _ => [f64::NAN; 3],
    }
}

fn main() -> anyhow::Result<()> {
    let folder = folder()?;

    // Over the plate: with tilt, the mean velocity depends on y, and on the phase between the two motions.
    let (phases, places) = (linspace(0.0, TAU, 25), linspace(-0.08, 0.08, 17));
    let progress = Progress::new("velocities over phase and place", phases.len() * places.len());
    let over_phase =
        Map::compute(&phases, &places, |phase, y| mean(&motion(phase), [0.0, y, 0.0]), |n| progress.tell(n));
    drop(progress);
    let degrees: Vec<f64> = phases.iter().map(|p| p.to_degrees()).collect();
    let millimeters: Vec<f64> = places.iter().map(|y| 1e3 * y).collect();
    let mut arrows = Vec::new();
    for (j, y) in millimeters.iter().enumerate() {
        for (i, phase) in degrees.iter().enumerate() {
            let [vx, vy, w] = established(over_phase.get(i, j));
            arrows.push(Arrow::new((*phase, *y), (1e3 * vx, 1e3 * vy), w.to_degrees()));
        }
    }
    let drawing = VectorField::new("phase of the tilt [°]", "y [mm]", "mean velocity", "mm/s")
        .arrows(arrows)
        .color_label("mean yaw rate [°/s]")
        .missing("lifts off")
        .title("Mean velocity (x to the right, y upward) under X and two harmonics of the tilt, 3 Hz")
        .draw()?;
    save(&drawing, &folder, "velocity_field")?;

    // The spin alone, over phase and frequency, at the axis.
    let frequencies = linspace(1.0, 4.0, 16);
    let progress = Progress::new("velocities over phase and frequency", phases.len() * frequencies.len());
    let over_frequency = Map::compute(
        &phases,
        &frequencies,
        |phase, frequency| mean(&PeriodicMotion { frequency, ..motion(phase) }, [0.0; 3]),
        |n| progress.tell(n),
    );
    drop(progress);
    let spin = over_frequency.numbers(|result| established(result)[2].to_degrees());
    let drawing = HeatMap::new("phase of the tilt [°]", "frequency [Hz]", "mean yaw rate [°/s]")
        .values(degrees.clone(), frequencies, spin.chunks(phases.len()).map(<[f64]>::to_vec))
        .color_map(ColorMap::Diverging)
        .missing("lifts off")
        .title("Mean spin on the axis of the plate, under X and two harmonics of the tilt")
        .draw()?;
    save(&drawing, &folder, "velocity_spin")?;

    println!("phase, mean velocity at y = 0 and y = 50 mm: x', y' in mm/s, phi' in °/s");
    for phase in [0.0, 0.5 * PI, PI, 1.5 * PI] {
        let row = [0.0, 0.05].map(|y| mean(&motion(phase), [0.0, y, 0.0]));
        for result in row {
            let m = result?;
            let [x, y, w] = [1e3 * m.mean[0], 1e3 * m.mean[1], m.mean[2].to_degrees()];
            println!(
                "{:5.0}° {x:+8.2} {y:+8.2} {w:+8.2}  {} periods, load at least {:.1} m/s²",
                phase.to_degrees(),
                m.periods,
                m.least_load
            );
        }
    }
    Ok(())
}
