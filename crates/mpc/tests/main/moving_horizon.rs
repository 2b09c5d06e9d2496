//! Moving-horizon estimation: where all is linear it is the Kalman filter, and with the whole past in its horizon batch least
//! squares; bounds, outliers, stick and slip are where it differs.

use crate::common::noise::Noise;
use bracketry_mpc::estimation::{
    Disturbance, DisturbanceChannel, EstimatedParameter, EstimationProblem, Estimator, ExtendedKalman, MeasuredOutput,
    MovingHorizon, MovingHorizonSettings, Outliers,
};
use bracketry_mpc::qp::QpSettings;
use bracketry_system::System;
use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix3, OMatrix, RowVector3, Vector3};

const DT: f64 = 0.1;
const NOISE: f64 = 0.4;
const SENSOR: f64 = 0.02;
const WALK: f64 = 0.3;

/// A mass whose acceleration is known but for noise and a bias that walks at random; its position is measured.
fn mass() -> EstimationProblem {
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a" }
    "#;
    let mut problem = EstimationProblem::new(&System::parse("mass.toml", text).unwrap(), DT, &[0.1, -0.2]);
    problem.initial_std = vec![0.5, 1.0];
    problem.process_noise = vec![0.0, NOISE];
    problem.outputs = vec![MeasuredOutput::new("x", SENSOR)];
    problem.disturbances = vec![Disturbance::new(DisturbanceChannel::Input("a".into()), 0.7, WALK)];
    problem
}

/// Its matrices by hand: x⁺ = F x + b u + G w with noise held over the interval.
fn matrices() -> (Matrix3<f64>, Vector3<f64>, [Vector3<f64>; 2], RowVector3<f64>) {
    let half = DT * DT / 2.0;
    let f = Matrix3::new(1.0, DT, half, 0.0, 1.0, DT, 0.0, 0.0, 1.0);
    let g =
        [Vector3::new(half, DT, 0.0) * NOISE / DT.sqrt(), Vector3::new(DT.powi(3) / 6.0, half, DT) * WALK / DT.sqrt()];
    (f, Vector3::new(half, DT, 0.0), g, RowVector3::new(1.0, 0.0, 0.0))
}

/// Inputs and measured positions, some of them lost.
fn data(samples: usize) -> (f64, Vec<(f64, f64)>) {
    let mut noise = Noise::new(11);
    let mut rows = Vec::new();
    for k in 0..samples {
        let y = (0.3 * k as f64).sin() + SENSOR * noise.normal();
        rows.push(((0.7 * k as f64).cos(), if k % 7 == 3 { f64::NAN } else { y }));
    }
    (0.05, rows)
}

/// The Kalman filter, in its textbook form.
fn kalman(y0: f64, rows: &[(f64, f64)]) -> Vec<(Vector3<f64>, Matrix3<f64>)> {
    let (f, b, g, c) = matrices();
    let mut x = Vector3::new(0.1, -0.2, 0.0);
    let mut p = Matrix3::from_diagonal(&Vector3::new(0.25, 1.0, 0.49));
    let q = g[0] * g[0].transpose() + g[1] * g[1].transpose();
    let mut all = Vec::new();
    for (k, y) in std::iter::once(y0).chain(rows.iter().map(|r| r.1)).enumerate() {
        if k > 0 {
            x = f * x + b * rows[k - 1].0;
            p = f * p * f.transpose() + q;
        }
        if !y.is_nan() {
            let s = (c * p * c.transpose())[(0, 0)] + SENSOR * SENSOR;
            let gain = p * c.transpose() / s;
            x += gain * (y - (c * x)[(0, 0)]);
            p = (Matrix3::identity() - gain * c) * p;
        }
        all.push((x, p));
    }
    all
}

fn accurate() -> QpSettings {
    QpSettings { tolerance: 1e-12, refine: true, ..QpSettings::default() }
}

#[test]
fn on_a_linear_model_the_extended_kalman_filter_is_the_kalman_filter() {
    let (y0, rows) = data(60);
    let mut filter = ExtendedKalman::new(&mass()).unwrap();
    let expected = kalman(y0, &rows);
    let mut estimate = filter.correct(&[y0]).unwrap();
    for (k, (x, p)) in expected.iter().enumerate() {
        if k > 0 {
            estimate = filter.update(&[rows[k - 1].0], &[rows[k - 1].1]).unwrap();
        }
        let z = [estimate.x[0], estimate.x[1], estimate.disturbance[0]];
        for i in 0..3 {
            assert!((z[i] - x[i]).abs() < 1e-10, "sample {k}: {z:?} and {x}");
            assert!((estimate.std[i] - p[(i, i)].sqrt()).abs() < 1e-10);
        }
    }
}

#[test]
fn the_variance_of_a_random_walk_settles_where_the_riccati_equation_says() {
    // P = Q + P R/(P + R) before a measurement: P = (Q + √(Q² + 4QR))/2, and P R/(P + R) after it.
    let text = "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }";
    let mut problem = EstimationProblem::new(&System::parse("walk.toml", text).unwrap(), 0.5, &[0.0]);
    problem.initial_std = vec![10.0];
    problem.process_noise = vec![0.3];
    problem.outputs = vec![MeasuredOutput::new("x", 0.2)];
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    for _ in 0..60 {
        filter.update(&[0.1], &[0.0]).unwrap();
    }
    let (q, r) = (0.3f64.powi(2) * 0.5, 0.2f64.powi(2));
    let p = f64::midpoint(q, (q * q + 4.0 * q * r).sqrt());
    assert!((filter.covariance()[(0, 0)] - p * r / (p + r)).abs() < 1e-12);
}

#[test]
fn on_a_linear_model_moving_horizon_estimation_is_the_kalman_filter() {
    let (y0, rows) = data(40);
    let expected = kalman(y0, &rows);
    for horizon in [1, 4, 10] {
        let settings = MovingHorizonSettings { horizon, qp: accurate(), ..MovingHorizonSettings::default() };
        let mut estimator = MovingHorizon::new(&mass(), settings).unwrap();
        let mut estimate = estimator.correct(&[y0]).unwrap();
        for (k, (x, _)) in expected.iter().enumerate() {
            if k > 0 {
                estimate = estimator.update(&[rows[k - 1].0], &[rows[k - 1].1]).unwrap();
            }
            let z = [estimate.x[0], estimate.x[1], estimate.disturbance[0]];
            for i in 0..3 {
                assert!(
                    (z[i] - x[i]).abs() < 1e-8,
                    "horizon {horizon}, sample {k}: {z:?} and {x} {:?}",
                    estimate.status
                );
            }
        }
    }
}

#[test]
fn with_the_whole_past_in_its_horizon_it_is_batch_least_squares() {
    let samples = 12;
    let (y0, rows) = data(samples);
    let settings = MovingHorizonSettings { horizon: samples, qp: accurate(), ..MovingHorizonSettings::default() };
    let mut estimator = MovingHorizon::new(&mass(), settings).unwrap();
    estimator.correct(&[y0]).unwrap();
    for (u, y) in &rows {
        estimator.update(&[*u], &[*y]).unwrap();
    }
    // Unknowns: the initial state and the noise of every interval. Residuals: prior, noise, outputs; all of unit variance.
    let (f, b, g, c) = matrices();
    let unknowns = 3 + 2 * samples;
    let mut lines: Vec<(DVector<f64>, f64)> = Vec::new();
    let unit = |i: usize, scale: f64| DVector::from_fn(unknowns, |j, _| if i == j { scale } else { 0.0 });
    for (i, (mean, std)) in [(0.1, 0.5), (-0.2, 1.0), (0.0, 0.7)].into_iter().enumerate() {
        lines.push((unit(i, 1.0 / std), mean / std));
    }
    lines.extend((3..unknowns).map(|i| (unit(i, 1.0), 0.0)));
    let mut state = OMatrix::<f64, Const<3>, Dyn>::identity_generic(Const::<3>, Dyn(unknowns));
    let mut offset = Vector3::zeros();
    let mut states = vec![(state.clone(), offset)];
    for (k, (u, _)) in rows.iter().enumerate() {
        state = f * &state;
        offset = f * offset + b * *u;
        for (j, g) in g.iter().enumerate() {
            let mut column = state.column_mut(3 + 2 * k + j);
            column += g;
        }
        states.push((state.clone(), offset));
    }
    for (y, (state, offset)) in std::iter::once(y0).chain(rows.iter().map(|r| r.1)).zip(&states) {
        if !y.is_nan() {
            lines.push(((c * state).transpose() / SENSOR, (y - (c * offset)[(0, 0)]) / SENSOR));
        }
    }
    let a = DMatrix::from_fn(lines.len(), unknowns, |i, j| lines[i].0[j]);
    let rhs = DVector::from_fn(lines.len(), |i, _| lines[i].1);
    let solution = a.svd(true, true).solve(&rhs, 1e-14).unwrap();
    for (z, (state, offset)) in estimator.horizon().iter().zip(&states) {
        let expected = state * &solution + offset;
        for i in 0..3 {
            assert!((z[i] - expected[i]).abs() < 1e-8, "{z:?} and {expected}");
        }
    }
}

#[test]
fn bounds_hold_and_tell_more_than_the_measurements() {
    // A tank that leaks with a rate that is not negative: with noise alone the unbounded estimate becomes negative.
    let text = r#"
        states = ["h"]
        inputs = ["q"]
        parameters = { c = 0.02 }
        dynamics = { h = "q - c*h" }
    "#;
    let mut problem = EstimationProblem::new(&System::parse("tank.toml", text).unwrap(), 1.0, &[1.0]);
    problem.initial_std = vec![0.1];
    problem.outputs = vec![MeasuredOutput::new("h", 0.05)];
    problem.parameters = vec![EstimatedParameter::new("c", 0.05)];
    let run = |problem: &EstimationProblem| {
        let mut estimator = MovingHorizon::new(problem, MovingHorizonSettings::default()).unwrap();
        let mut noise = Noise::new(5);
        (0..40)
            .map(|_| estimator.update(&[0.0], &[1.0 + 0.05 * noise.normal()]).unwrap().parameters[0])
            .collect::<Vec<_>>()
    };
    let free = run(&problem);
    assert!(free.iter().any(|&c| c < -1e-3), "{free:?}");
    problem.parameters[0].min = 0.0;
    let bounded = run(&problem);
    assert!(bounded.iter().all(|&c| c >= 0.0), "{bounded:?}");
    assert!(bounded.last().unwrap().abs() < 2e-3, "{bounded:?}");
}

#[test]
fn an_outlier_counts_little() {
    for huber in [false, true] {
        let mut problem = mass();
        problem.outliers = if huber { Outliers::Huber(2.0) } else { Outliers::Trust };
        let mut filter = ExtendedKalman::new(&problem).unwrap();
        let mut horizon = MovingHorizon::new(&problem, MovingHorizonSettings::default()).unwrap();
        let mut noise = Noise::new(3);
        let (mut of_filter, mut of_horizon) = (0.0f64, 0.0f64);
        for k in 1..80 {
            // At rest with the bias −1 in the known acceleration; every tenth measurement is far off.
            let outlier = if k % 10 == 0 { 1.0 } else { 0.0 };
            let y = SENSOR * noise.normal() + outlier;
            let a = filter.update(&[1.0], &[y]).unwrap();
            let b = horizon.update(&[1.0], &[y]).unwrap();
            if k > 30 {
                of_filter = of_filter.max(a.x[0].abs());
                of_horizon = of_horizon.max(b.x[0].abs());
            }
        }
        if huber {
            assert!(of_filter < 0.12 && of_horizon < 0.12, "{of_filter} {of_horizon}");
        } else {
            assert!(of_filter > 0.3 && of_horizon > 0.3, "{of_filter} {of_horizon}");
        }
    }
}

#[test]
fn an_angle_is_followed_over_its_turns() {
    let text = "states = [\"phi\", \"w\"]\ninputs = [\"a\"]\ndynamics = { phi = \"w\", w = \"a\" }";
    let turn = std::f64::consts::TAU;
    let mut problem = EstimationProblem::new(&System::parse("wheel.toml", text).unwrap(), 0.1, &[0.0, 0.0]);
    problem.initial_std = vec![0.1, 5.0];
    problem.outputs = vec![MeasuredOutput { period: Some(turn), ..MeasuredOutput::new("phi", 0.01) }];
    let mut filter = ExtendedKalman::new(&problem).unwrap();
    let mut horizon = MovingHorizon::new(&problem, MovingHorizonSettings::default()).unwrap();
    for k in 1..100 {
        let y = (0.4 * f64::from(k)).rem_euclid(turn);
        for e in [filter.update(&[0.0], &[y]).unwrap(), horizon.update(&[0.0], &[y]).unwrap()] {
            assert!(k < 3 || (e.x[0] - 0.4 * f64::from(k)).abs() < 0.02, "{k}: {:?}", e.x);
        }
    }
}

#[test]
fn the_error_is_as_large_as_the_estimator_says() {
    // Normalized estimation error squared: χ² with n degrees of freedom, so that the mean of M runs lies within
    // n ± 3·√(2n/M).
    let problem = mass();
    let (f, b, g, c) = matrices();
    let runs = 200;
    let mut sum = 0.0;
    for seed in 1..=runs {
        let mut noise = Noise::new(seed);
        let std = [0.5, 1.0, 0.7];
        let mut x = Vector3::new(0.1, -0.2, 0.0) + Vector3::from_fn(|i, _| std[i] * noise.normal());
        let mut filter = ExtendedKalman::new(&problem).unwrap();
        let mut last = filter.correct(&[(c * x)[(0, 0)] + SENSOR * noise.normal()]).unwrap();
        for k in 0..30 {
            let u = (0.2 * f64::from(k)).sin();
            x = f * x + b * u + g[0] * noise.normal() + g[1] * noise.normal();
            last = filter.update(&[u], &[(c * x)[(0, 0)] + SENSOR * noise.normal()]).unwrap();
        }
        let e = DVector::from_vec(vec![last.x[0] - x[0], last.x[1] - x[1], last.disturbance[0] - x[2]]);
        let weighted = filter.covariance().clone().cholesky().unwrap().solve(&e);
        sum += e.dot(&weighted);
    }
    let mean = sum / runs as f64;
    assert!((mean - 3.0).abs() < 3.0 * (6.0 / runs as f64).sqrt(), "{mean}");
}
