//! Runs the pose controller on objects, plates and cameras that are not as it believes:
//! `cargo run --release -p bracketry-trials --example plate_stress --features measure -- --trials 100`
#![allow(clippy::print_stdout)]

use anyhow::bail;
use bracketry_plate::control::{PlateLimits, PoseController, PoseSettings};
use bracketry_plate::object::Bearing;
use bracketry_plate::{Object, Shape};
use bracketry_trials::{PoseRange, PushRange, Scenario, TrialReport, TrialSetup, TrialSummary, run_trials};
use clap::Parser;
use std::ops::ControlFlow;

/// Trials of the pose controller on plants that it does not know.
#[derive(Parser)]
struct Arguments {
    /// Number of trials of each case.
    #[arg(long, default_value_t = 100)]
    trials: usize,
    /// Cases, all unless given.
    #[arg(long)]
    case: Vec<String>,
    /// Number of the first trial.
    #[arg(long, default_value_t = 0)]
    first: usize,
    /// Seed of the series.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; all cores unless given.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Prints every trial that fails, and every one with a time above this many seconds.
    #[arg(long)]
    slow: Option<f64>,
}

/// A plant that is not as the controller believes.
struct Case {
    name: &'static str,
    mu: [f64; 2],
    bearing: Bearing,
    center_of_mass: [f64; 2],
    servo_bandwidth: f64,
    latency: f64,
    /// Earliest and latest time of a push in s.
    pushed: Option<[f64; 2]>,
}

/// Assumed friction.
const BELIEVED: f64 = 0.3;

fn cases() -> Vec<Case> {
    let plain = |name| Case {
        name,
        mu: [0.24, 0.36],
        bearing: Bearing::Footprint,
        center_of_mass: [0.0; 2],
        servo_bandwidth: f64::INFINITY,
        latency: 0.0,
        pushed: None,
    };
    let feet = [[0.09, 0.06], [-0.09, 0.06], [-0.09, -0.06], [0.09, -0.06]];
    let along = 5e-3 / 2f64.sqrt();
    vec![
        plain("as assumed"),
        Case { mu: [0.15, 0.5], ..plain("friction") },
        Case { mu: [0.1, 0.17], ..plain("low friction") },
        Case { mu: [0.45, 0.6], ..plain("high friction") },
        Case { bearing: Bearing::Scaled(0.5), ..plain("inner half") },
        Case { bearing: Bearing::Ring(1.0), ..plain("ring") },
        Case { bearing: Bearing::Feet(feet.to_vec()), ..plain("four feet") },
        Case { center_of_mass: [along, along], ..plain("mass off") },
        Case { pushed: Some([0.3, 1.5]), ..plain("pushed on the way") },
        // Long after it has arrived.
        Case { pushed: Some([20.0, 21.0]), ..plain("pushed") },
        Case { servo_bandwidth: 20.0, ..plain("servo 20 Hz") },
        Case { servo_bandwidth: 50.0, ..plain("servo 50 Hz") },
        Case { latency: 0.02, ..plain("latency") },
    ]
}

fn scenario(case: &Case) -> Scenario {
    let range = PoseRange { x: [-0.1, 0.1], y: [-0.1, 0.1], yaw_deg: [-180.0, 180.0] };
    Scenario {
        start: range,
        target: range,
        mu: BELIEVED,
        mu_factor: case.mu.map(|mu| mu / BELIEVED),
        position_noise: 5e-4,
        angle_noise_deg: 0.5,
        delay: 1,
        lost: 0.0,
        pushes: case.pushed.map(|time| PushRange { count: 1, time, speed: [0.1, 0.4], spin: [0.0, 3.0] }),
        position_tolerance: 2e-3,
        angle_tolerance_deg: 2.0,
        duration: 60.0,
        limits: PlateLimits::default(),
    }
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build_global()?;
    let mut cases = cases();
    if let Some(name) = arguments.case.iter().find(|name| cases.iter().all(|case| case.name != **name)) {
        let names: Vec<&str> = cases.iter().map(|case| case.name).collect();
        bail!("there is no case `{name}`; there are {}", names.join(", "));
    }
    cases.retain(|case| arguments.case.is_empty() || arguments.case.iter().any(|name| name == case.name));
    println!("{} trials each, seed {}", arguments.trials, arguments.seed);
    println!(
        "| case | reached and stays (95 %) | time: median, 95 % [s] | bounds kept | slowest sample, median [ms] | failures |"
    );
    println!("|---|---|---|---|---|---|");
    for case in &cases {
        let believed = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };
        let object = Object { bearing: case.bearing.clone(), center_of_mass: case.center_of_mass, ..believed.clone() };
        let scenario = scenario(case);
        let setup = TrialSetup {
            dwell: 1.5,
            servo_bandwidth: case.servo_bandwidth,
            latency: case.latency,
            ..TrialSetup::new(&object, &scenario)
        };
        let make = |trial: &bracketry_trials::Trial| {
            let settings = PoseSettings {
                delay: trial.delay,
                limits: setup.limits,
                mu: BELIEVED,
                noise: [trial.position_noise, trial.angle_noise],
                tolerance: [setup.tolerance.position, setup.tolerance.angle],
                ..PoseSettings::default()
            };
            Ok(PoseController::new(&believed, trial.target, &settings)?)
        };
        let numbers = arguments.first..arguments.first + arguments.trials;
        let trials: Vec<_> = numbers.map(|number| scenario.trial(arguments.seed, number)).collect();
        let reports = run_trials(&trials, &setup, make, |_| ControlFlow::Continue(()))?;
        print_row(case.name, &reports);
        for report in arguments.slow.iter().flat_map(|slow| reports.iter().filter(|r| r.time() > *slow)) {
            let error = report.final_error;
            println!(
                "  trial {}: mu {:.3}, {:?}, error {:.2} mm, {:.2} mm, {:.2}°, simulated {:.1} s, bounds {:.3}",
                report.trial.index,
                report.trial.plant_mu,
                report.outcome,
                1e3 * error[0],
                1e3 * error[1],
                error[2].to_degrees(),
                report.simulated,
                report.utilization.greatest(),
            );
        }
    }
    Ok(())
}

fn print_row(name: &str, reports: &[TrialReport]) {
    let TrialSummary { reached, bounds_kept, time, outcomes, .. } = TrialSummary::of(reports);
    let slowest: Vec<f64> = reports.iter().filter_map(|r| r.wall.max).collect();
    let seconds = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.2}"));
    let failures: Vec<String> =
        outcomes.iter().filter(|o| o.0 != "reached").map(|(label, count)| format!("{count} {label}")).collect();
    println!(
        "| {name} | {}/{}, {:.1} % ({:.1}…{:.1}) | {}, {} | {}/{} | {:.1} | {} |",
        reached.count,
        reached.of,
        100.0 * reached.value(),
        100.0 * reached.low,
        100.0 * reached.high,
        seconds(time.p50),
        seconds(time.p95),
        bounds_kept.count,
        bounds_kept.of,
        1e3 * bracketry_trials::quantile(&slowest, 0.5).unwrap_or(f64::NAN),
        if failures.is_empty() { "none".into() } else { failures.join(", ") },
    );
}
