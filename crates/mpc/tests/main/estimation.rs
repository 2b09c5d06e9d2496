//! Estimation against exact stick and slip, and against the Kalman filter where all is linear.

use crate::common::{exact_plant, noise::Noise};
use bracketry_mpc::Plant;
use bracketry_mpc::estimation::{
    Disturbance, DisturbanceChannel, Estimate, EstimateStatus, EstimatedParameter, EstimationProblem, Estimator,
    ExtendedKalman, MeasuredOutput, MovingHorizon, MovingHorizonSettings,
};
use bracketry_symbolic::Rational;
use bracketry_system::System;
use std::f64::consts::PI;

const DEG: f64 = PI / 180.0;
const DT: f64 = 0.02;
/// States of the plate model.
const STATES: usize = 10;

/// The reduced plate model, made affine: states x, y, phi, vx, vy, w, then the plate's own.
fn plate(mu: f64) -> System {
    let mut system = System::read(crate::common::model_path("plate_reduced.toml")).unwrap();
    let percent = (mu * 1000.0).round() as i64;
    assert!(system.set_parameter("mu", Rational::from_parts(percent.into(), 1000u16.into())));
    system.affinize().unwrap().system
}

/// State of the plant and estimate after every sample of a run of 1.5 s in which the plate oscillates with 3 Hz.
fn oscillation(seed: u64, mu_plant: f64, mu_model: f64) -> Vec<(Vec<f64>, Estimate)> {
    let plant_model = plate(mu_plant);
    let model = plate(mu_model);
    let mut x = vec![0.0; STATES];
    x[..2].copy_from_slice(&[0.05, -0.03]);
    let mut plant = exact_plant(&plant_model, &x);
    let mut problem = EstimationProblem::new(&model, DT, &x);
    problem.initial_std[..3].copy_from_slice(&[1e-3, 1e-3, 0.02]);
    problem.process_noise[3..6].copy_from_slice(&[0.05, 0.05, 0.3]);
    let std = [5e-4, 5e-4, 0.5 * DEG, 1e-6, 1e-6, 1e-6, 1e-6];
    let outputs = ["x", "y", "phi", "X", "Xd", "theta", "thetad"];
    problem.outputs = outputs.iter().zip(std).map(|(name, std)| MeasuredOutput::new(*name, std)).collect();
    problem.parameters = vec![EstimatedParameter { min: 0.0, ..EstimatedParameter::new("mu", 0.06) }];
    let measured: Vec<usize> = outputs.iter().map(|name| model.state_index(name).unwrap()).collect();
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    let mut noise = Noise::new(seed);
    let mut measure = |x: &[f64]| -> Vec<f64> {
        // The plate's own motion is known exactly.
        let noisy = |(k, &i): (usize, &usize)| x[i] + if k < 3 { std[k] * noise.normal() } else { 0.0 };
        measured.iter().enumerate().map(noisy).collect()
    };
    filter.correct(&measure(&x)).unwrap();
    let omega = 6.0 * PI;
    let mut run = Vec::new();
    for k in 0..75 {
        let t = f64::from(k) * DT;
        let wave = omega * omega * (omega * t).sin() * (t / 0.2).min(1.0);
        let u = [-0.03 * wave, -6.0 * DEG * wave];
        plant.step(t, &mut x, &u, DT).unwrap();
        run.push((x.clone(), filter.update(&u, &measure(&x)).unwrap()));
    }
    run
}

#[test]
fn friction_and_velocities_of_the_plate_are_found_from_positions_alone() {
    for (seed, mu_model) in [(1, 0.36), (2, 0.24)] {
        let run = oscillation(seed, 0.3, mu_model);
        for (x, estimate) in &run[50..] {
            let mu = estimate.parameters[0];
            assert!((mu - 0.3).abs() < 0.009, "3 % of mu: {mu}");
            let spread = &estimate.std;
            assert!((mu - 0.3).abs() < 4.0 * spread[STATES], "{mu} ± {}", spread[STATES]);
            for i in 3..6 {
                let error = estimate.x[i] - x[i];
                assert!(error.abs() < 4.0 * spread[i] + 1e-3, "velocity {i}: {error} ± {}", spread[i]);
            }
        }
        for (i, limit) in [(3, 0.01), (4, 0.01), (5, 4.0 * DEG)] {
            let squares: f64 = run[50..].iter().map(|(x, e)| (e.x[i] - x[i]).powi(2)).sum();
            let rms = (squares / (run.len() - 50) as f64).sqrt();
            assert!(rms < limit, "velocity {i}: {rms}");
        }
    }
}

/// A block on a plate that is pushed with the acceleration a.
fn block() -> System {
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        parameters = { mu = 0.3, g = 9.81 }
        dynamics = { x = "v", v = "a - mu*g*sign(v)" }
    "#;
    System::parse("block.toml", text).unwrap()
}

#[test]
fn friction_is_frozen_while_it_sticks_and_found_once_it_slides() {
    let mut true_block = block();
    assert!(true_block.set_parameter("mu", Rational::from_parts(1.into(), 4u8.into())));
    let mut x = vec![0.0, 0.0];
    let mut plant = exact_plant(&true_block, &x);
    let mut problem = EstimationProblem::new(&block(), DT, &x);
    problem.process_noise[1] = 0.02;
    problem.outputs = vec![MeasuredOutput::new("x", 5e-4)];
    problem.parameters = vec![EstimatedParameter { walk: 0.05, ..EstimatedParameter::new("mu", 0.06) }];
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    let mut noise = Noise::new(7);
    let mut step = |a: f64, x: &mut Vec<f64>| {
        plant.step(0.0, x, &[a], DT).unwrap();
        filter.update(&[a], &[x[0] + 5e-4 * noise.normal()]).unwrap()
    };
    // A push of 0.8 of the friction, for four seconds: the smoothed model would creep, the block does not.
    for _ in 0..200 {
        let estimate = step(2.0, &mut x);
        assert_eq!(x[1], 0.0, "the block sticks");
        assert!((estimate.parameters[0] - 0.3).abs() < 1e-12, "drift to {}", estimate.parameters[0]);
        assert!(estimate.std[2] <= 0.06 + 1e-12, "the uncertainty of what cannot be observed does not grow");
    }
    let mut last = step(0.0, &mut x);
    for k in 0..50 {
        last = step(5.0 * (f64::from(k) * DT * 6.0 * PI).sin(), &mut x);
    }
    assert!((last.parameters[0] - 0.25).abs() < 0.02, "{}", last.parameters[0]);
}

#[test]
fn a_block_that_slides_against_the_model_s_belief_is_noticed() {
    // With the model's friction the push would not move the block at all, so that at first mu seems to be hidden.
    for (percent, push) in [(20u8, 2.6), (24, 2.8)] {
        let mut true_block = block();
        assert!(true_block.set_parameter("mu", Rational::from_parts(percent.into(), 100u8.into())));
        let mut x = vec![0.0, 0.0];
        let mut plant = exact_plant(&true_block, &x);
        let mut problem = EstimationProblem::new(&block(), DT, &x);
        problem.process_noise[1] = 0.05;
        problem.outputs = vec![MeasuredOutput::new("x", 5e-4)];
        problem.parameters = vec![EstimatedParameter { min: 0.0, ..EstimatedParameter::new("mu", 0.06) }];
        let mut estimator = MovingHorizon::new(&problem, MovingHorizonSettings::default()).unwrap();
        let mut noise = Noise::new(7);
        for k in 0..100 {
            let a = if (k / 8) % 2 == 0 { push } else { -push };
            plant.step(0.0, &mut x, &[a], DT).unwrap();
            let estimate = estimator.update(&[a], &[x[0] + 5e-4 * noise.normal()]).unwrap();
            if k >= 50 {
                let (mu, v) = (estimate.parameters[0], estimate.x[1]);
                assert!((mu - f64::from(percent) / 100.0).abs() < 0.01, "sample {k}: {mu}");
                assert!((v - x[1]).abs() < 0.025, "sample {k}: {v} and {}", x[1]);
            }
        }
    }
}

#[test]
fn lost_outputs_are_left_out() {
    let mut problem = EstimationProblem::new(&block(), DT, &[0.0, 1.0]);
    problem.initial_std = vec![1e-3, 0.1];
    problem.outputs = vec![MeasuredOutput::new("x", 1e-3), MeasuredOutput::new("v", 1e-2)];
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    let one = filter.correct(&[f64::NAN, 1.05]).unwrap();
    assert_eq!(one.status, EstimateStatus::Updated { lost: 1 });
    assert_eq!(one.x[0], 0.0);
    // Precision weighting of prior and measurement: (1/0.1² + 1.05/0.01²)/(1/0.1² + 1/0.01²).
    assert!((one.x[1] - (100.0 + 1.05e4) / 1.01e4).abs() < 1e-12);
    let none = filter.update(&[0.0], &[f64::NAN, f64::INFINITY]).unwrap();
    assert_eq!(none.status, EstimateStatus::Predicted);
    assert!(none.x.iter().chain(&none.std).all(|v| v.is_finite()));
    assert!(none.std[0] > one.std[0], "the uncertainty grows");
}

#[test]
fn misuse_is_named() {
    let mut problem = EstimationProblem::new(&block(), DT, &[0.0, 1.0]);
    problem.outputs = vec![MeasuredOutput::new("x", 0.0)];
    let message = |p: &EstimationProblem| ExtendedKalman::new(p).err().unwrap().to_string();
    assert!(message(&problem).contains("a tiny one"));
    problem.outputs = vec![MeasuredOutput::new("x", 1e-3)];
    problem.parameters = vec![EstimatedParameter::new("nu", 0.1)];
    assert_eq!(message(&problem), "there is no parameter `nu`: the problem has mu, g");
    problem.parameters.clear();
    problem.disturbances = vec![Disturbance::new(DisturbanceChannel::Input("b".into()), 0.1, 0.1)];
    assert_eq!(message(&problem), "there is no input `b`: the problem has a");
    problem.disturbances.clear();
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    assert!(filter.correct(&[0.0, 0.0]).is_err());
    assert!(filter.update(&[f64::NAN], &[0.0]).is_err());
}

#[test]
fn a_flow_without_a_derivative_says_nothing_of_observability_and_ends() {
    // The slope of the root has no value at 0.
    let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'sqrt(x) + v', v = 'u' }";
    let system = System::parse("steep.toml", text).unwrap();
    let mut problem = EstimationProblem::new(&system, 0.1, &[0.0, 0.0]);
    problem.outputs = vec![MeasuredOutput::new("v", 1e-3)];
    assert!(problem.check_observability(&[0.0, 0.0], &[0.0]).is_ok());
    assert!(problem.check_observability(&[1.0, 0.0], &[0.0]).is_err(), "v alone does not tell of x");
}
