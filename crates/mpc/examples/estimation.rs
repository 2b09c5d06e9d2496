//! How well friction and velocities are known from positions, and how long an update takes.
//!
//! `cargo run --release -p bracketry-mpc --example estimation --features measure`
#![allow(clippy::print_stdout)]

use bracketry_mpc::estimation::{
    EstimatedParameter, EstimationProblem, Estimator, ExtendedKalman, MeasuredOutput, MovingHorizon,
    MovingHorizonSettings,
};
use bracketry_sim::{ExactPlant, SimulationSettings};
use bracketry_symbolic::Rational;
use bracketry_system::System;
use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::time::Instant;

const DEG: f64 = PI / 180.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "Plate (reduced model, exact stick and slip), 3 Hz, noise 0.5 mm and 0.5 deg, mu of the model wrong by up to 20 %"
    );
    println!("errors from 1.0 s to 1.5 s, root mean square over 20 runs; update: median");
    println!("{:<22} {:>7} {:>8} {:>9} {:>9} {:>9} {:>10}", "", "period", "mu", "vx", "vy", "yaw rate", "update");
    for dt in [0.02, 0.01] {
        for horizon in [None, Some(5), Some(15)] {
            plate(dt, horizon)?;
        }
    }
    println!();
    println!(
        "Pendulum on a cart swinging freely, positions measured with 1 mm and 0.5 deg every 20 ms; errors from 1 s to 2 s"
    );
    for horizon in [None, Some(10)] {
        pendulum(horizon)?;
    }
    Ok(())
}

fn name(horizon: Option<usize>) -> String {
    horizon.map_or("Kalman filter".into(), |n| format!("moving horizon, N = {n}"))
}

fn estimator(problem: &EstimationProblem, horizon: Option<usize>) -> Result<Box<dyn Estimator>, Box<dyn Error>> {
    Ok(match horizon {
        None => Box::new(ExtendedKalman::new(problem)?),
        Some(horizon) => Box::new(MovingHorizon::new(
            problem,
            MovingHorizonSettings { horizon, ..MovingHorizonSettings::default() },
        )?),
    })
}

fn model(file: &str) -> Result<System, Box<dyn Error>> {
    Ok(System::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models").join(file))?)
}

fn plate(dt: f64, horizon: Option<usize>) -> Result<(), Box<dyn Error>> {
    let runs = 20;
    let mut noise = Noise(1);
    let (mut squares, mut count, mut times, mut stopped) = ([0.0; 4], 0.0, Vec::new(), 0);
    for run in 0..runs {
        let with = |mu: f64| -> Result<System, Box<dyn Error>> {
            let mut system = model("plate_reduced.toml")?;
            system.set_parameter("mu", Rational::from_parts(((mu * 1e4) as i64).into(), 10_000u32.into()));
            Ok(system.affinize()?.system)
        };
        let (mu, wrong) = (0.3, 0.8 + 0.4 * run as f64 / (runs - 1) as f64);
        let (plant_model, system) = (with(mu)?, with(mu * wrong)?);
        let mut x = vec![0.0; system.states.len()];
        x[0] = 0.1 * (2.0 * noise.uniform() - 1.0);
        x[1] = 0.1 * (2.0 * noise.uniform() - 1.0);
        x[2] = TAU * noise.uniform();
        let mut problem = EstimationProblem::new(&system, dt, &x);
        problem.initial_std[..3].copy_from_slice(&[1e-3, 1e-3, 0.02]);
        problem.process_noise[3..6].copy_from_slice(&[0.05, 0.05, 0.3]);
        let std = [5e-4, 5e-4, 0.5 * DEG, 1e-6, 1e-6, 1e-6, 1e-6];
        let outputs = ["x", "y", "phi", "X", "Xd", "theta", "thetad"];
        problem.outputs = outputs.iter().zip(std).map(|(name, std)| MeasuredOutput::new(*name, std)).collect();
        problem.parameters = vec![EstimatedParameter { min: 0.0, ..EstimatedParameter::new("mu", 0.06) }];
        let measured: Vec<usize> = outputs.iter().filter_map(|name| system.state_index(name)).collect();
        let mut estimator = estimator(&problem, horizon)?;
        let mut plant = ExactPlant::new(&plant_model, &x, &SimulationSettings::default())?;
        let omega = 6.0 * PI;
        for k in 0..(1.5 / dt) as usize {
            let t = k as f64 * dt;
            let wave = omega * omega * (omega * t).sin() * (t / 0.2).min(1.0);
            let u = [-0.03 * wave, -6.0 * DEG * wave];
            if !plant.hold(&u, dt)?.is_finished() {
                stopped += 1;
                break;
            }
            let x = plant.state();
            let y: Vec<f64> = measured
                .iter()
                .enumerate()
                .map(|(i, &state)| x[state] + if i < 3 { std[i] * noise.normal() } else { 0.0 })
                .collect();
            let start = Instant::now();
            let estimate = estimator.update(&u, &y)?;
            times.push(start.elapsed().as_secs_f64());
            if t > 1.0 {
                count += 1.0;
                squares[0] += (estimate.parameters[0] - mu).powi(2);
                for i in 0..3 {
                    squares[1 + i] += (estimate.x[3 + i] - x[3 + i]).powi(2);
                }
            }
        }
    }
    let [mu, vx, vy, w] = squares.map(|s: f64| (s / count).sqrt());
    println!(
        "{:<22} {:>4} ms {:>6.1} % {:>4.1} mm/s {:>4.1} mm/s {:>5.1} °/s {:>7.0} us{}",
        name(horizon),
        1e3 * dt,
        100.0 * mu / 0.3,
        1e3 * vx,
        1e3 * vy,
        w / DEG,
        1e6 * median(&mut times),
        if stopped > 0 { format!("   ({stopped} plants stopped)") } else { String::new() }
    );
    Ok(())
}

fn pendulum(horizon: Option<usize>) -> Result<(), Box<dyn Error>> {
    let dt = 0.02;
    let system = model("cart_pole.toml")?;
    let index = |name: &str| system.state_index(name).ok_or("no such state");
    let (p, th, v, w) = (index("p")?, index("th")?, index("v")?, index("w")?);
    let mut x = vec![0.0; 4];
    x[th] = 0.5;
    let mut problem = EstimationProblem::new(&system, dt, &[0.0; 4]);
    problem.initial_std = vec![1.0; 4];
    problem.process_noise[v] = 0.01;
    problem.process_noise[w] = 0.01;
    problem.outputs = vec![MeasuredOutput::new("p", 1e-3), MeasuredOutput::new("th", 0.5 * DEG)];
    let mut estimator = estimator(&problem, horizon)?;
    let mut plant = ExactPlant::new(&system, &x, &SimulationSettings::default())?;
    let mut noise = Noise(1);
    let (mut squares, mut count, mut times) = ([0.0; 2], 0.0, Vec::new());
    for k in 0..100 {
        let u = [(0.3 * k as f64).sin()];
        plant.hold(&u, dt)?;
        let x = plant.state();
        let y = [x[p] + 1e-3 * noise.normal(), x[th] + 0.5 * DEG * noise.normal()];
        let start = Instant::now();
        let estimate = estimator.update(&u, &y)?;
        times.push(start.elapsed().as_secs_f64());
        if k >= 50 {
            count += 1.0;
            squares[0] += (estimate.x[v] - x[v]).powi(2);
            squares[1] += (estimate.x[w] - x[w]).powi(2);
        }
    }
    let [v, w] = squares.map(|s: f64| (s / count).sqrt());
    println!(
        "{:<22} v {:.1} mm/s, w {:.2} °/s, update {:.0} us",
        name(horizon),
        1e3 * v,
        w / DEG,
        1e6 * median(&mut times)
    );
    Ok(())
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Gaussian noise: a linear congruential generator with the Box–Muller transform.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}
