//! Stiffnesses of one pose from noisy measurements.

use crate::common::{
    STIFFNESS,
    measured::{
        NOISE, compared, compliance, linear_measurements, load, noise, noisy, random_pose, relative,
        robot_measurements, set, spoil,
    },
    pose, rng,
};
use bracketry_stiffness::{
    Advice, CartesianEstimator, Found, Measurement, MeasurementNoise, MeasurementSet, Method, Outliers, Springs,
    compare, identify_cartesian,
};
use nalgebra::{Matrix6, Vector6};
use rand::RngExt;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median error of K over data sets.
fn stiffness_error(estimator: CartesianEstimator, count: usize) -> f64 {
    let truth = compliance().try_inverse().unwrap();
    let error = |seed| {
        let set = set(linear_measurements(&mut rng(seed), &compliance(), count));
        relative(&identify_cartesian(&set, estimator, Outliers::Keep).unwrap().stiffness, &truth)
    };
    median((0..15).map(error).collect())
}

#[test]
fn without_noise_every_estimator_finds_the_truth() {
    let truth = compliance();
    let mut rng = rng(1);
    let exact =
        (0..20).map(|_| load(&mut rng)).map(|wrench| Measurement { q: pose(), wrench, displacement: truth * wrench });
    let set = set(exact.collect());
    for estimator in CartesianEstimator::ALL {
        let estimate = identify_cartesian(&set, estimator, Outliers::Keep).unwrap();
        assert!(
            relative(&estimate.compliance, &truth) < 1e-6,
            "{estimator}: {}",
            relative(&estimate.compliance, &truth)
        );
        assert!(estimate.symmetric && estimate.positive_definite);
    }
}

#[test]
fn the_published_estimator_is_biased_and_the_others_are_not() {
    let published = [200, 3200].map(|n| stiffness_error(CartesianEstimator::WrenchOnDisplacement, n));
    assert!((0.68..0.78).contains(&published[0]), "{published:?}");
    assert!((published[1] - published[0]).abs() < 0.02, "{published:?}");
    for estimator in CartesianEstimator::ALL.into_iter().skip(1) {
        let errors = [200, 3200].map(|n| stiffness_error(estimator, n));
        assert!(errors[0] < 0.2, "{estimator} {errors:?}");
        // 16 times the measurements: a quarter of the error.
        assert!(errors[1] < 0.4 * errors[0], "{estimator} {errors:?}");
    }
}

#[test]
fn a_positive_definite_fit_is_always_one_and_predicts_no_worse() {
    let truth = compliance();
    let (mut free, mut definite) = (Vec::new(), Vec::new());
    for seed in 0..20 {
        let set = set(linear_measurements(&mut rng(100 + seed), &truth, 20));
        let estimate = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap();
        assert!(estimate.positive_definite && estimate.symmetric);
        assert!((estimate.stiffness - estimate.stiffness.transpose()).norm() < 1e-9 * estimate.stiffness.norm());
        definite.push(relative(&estimate.compliance, &truth));
        let other = identify_cartesian(&set, CartesianEstimator::DisplacementOnWrench, Outliers::Keep).unwrap();
        free.push(relative(&other.compliance, &truth));
    }
    assert!(median(definite.clone()) <= median(free.clone()), "{definite:?} {free:?}");
}

#[test]
fn a_boundary_case_stays_positive_definite() {
    // A direction so stiff that noise decides the sign of its compliance.
    let mut truth = compliance();
    for i in 0..6 {
        truth[(i, 2)] *= 1e-3;
        truth[(2, i)] *= 1e-3;
    }
    let mut indefinite = 0;
    for seed in 0..10 {
        let set = set(linear_measurements(&mut rng(200 + seed), &truth, 12));
        let estimate = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap();
        assert!(estimate.compliance.symmetric_eigenvalues().min() > 0.0);
        let free = identify_cartesian(&set, CartesianEstimator::DisplacementOnWrench, Outliers::Keep).unwrap();
        indefinite += usize::from(!free.positive_definite);
    }
    assert!(indefinite > 0);
}

#[test]
fn intervals_contain_the_truth_as_often_as_they_say() {
    let truth = compliance();
    for estimator in CartesianEstimator::ALL.into_iter().skip(1) {
        let (mut inside, mut all) = (0, 0);
        for seed in 0..40 {
            let set = set(linear_measurements(&mut rng(300 + seed), &truth, 100));
            let estimate = identify_cartesian(&set, estimator, Outliers::Keep).unwrap();
            for i in 0..6 {
                for j in 0..6 {
                    let (low, high) = estimate.compliance_interval(i, j);
                    all += 1;
                    inside += u32::from((low..=high).contains(&truth[(i, j)]));
                }
            }
        }
        let share = f64::from(inside) / f64::from(all);
        assert!((0.92..0.98).contains(&share), "{estimator}: {share}");
    }
}

#[test]
fn intervals_of_stiffnesses_hold_where_measurements_are_many() {
    let stiffness = compliance().try_inverse().unwrap();
    let (mut inside, mut all) = (0, 0);
    for seed in 0..20 {
        let set = set(linear_measurements(&mut rng(350 + seed), &compliance(), 2000));
        let estimate = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let (low, high) = estimate.stiffness_interval(i, j);
                all += 1;
                inside += u32::from((low..=high).contains(&stiffness[(i, j)]));
            }
        }
    }
    let share = f64::from(inside) / f64::from(all);
    assert!((0.9..0.99).contains(&share), "{share}");
}

#[test]
fn residuals_tell_the_noise_and_intervals_follow_it() {
    let measurements = linear_measurements(&mut rng(360), &compliance(), 400);
    let stated = |factor: f64| {
        let noise =
            MeasurementNoise::from_std(factor * NOISE[0], factor * NOISE[1], factor * NOISE[2], factor * NOISE[3]);
        let set = MeasurementSet::new(measurements.clone(), noise).unwrap();
        identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap()
    };
    let (right, half) = (stated(1.0), stated(0.5));
    assert!((right.chi_square - 1.0).abs() < 0.1, "{}", right.chi_square);
    assert!((half.chi_square - 4.0 * right.chi_square).abs() < 1e-3);
    let ratio = half.compliance_std.component_div(&right.compliance_std);
    assert!(ratio.iter().all(|r| (r - 1.0).abs() < 0.1), "{ratio}");
}

/// `Σ rᵀ (Σ_X + C Σ_W Cᵀ)⁻¹ r`.
fn squares(set: &MeasurementSet, compliance: &Matrix6<f64>) -> f64 {
    let noise = noise();
    let weight = (noise.displacement + compliance * noise.wrench * compliance.transpose()).try_inverse().unwrap();
    let residuals = set.measurements().iter().map(|m| m.displacement - compliance * m.wrench);
    residuals.map(|r| r.dot(&(weight * r))).sum()
}

#[test]
fn total_and_definite_least_squares_are_minima_of_the_likelihood() {
    let mut draw = rng(370);
    let set = set(linear_measurements(&mut draw, &compliance(), 50));
    for (estimator, symmetric) in
        [(CartesianEstimator::TotalLeastSquares, false), (CartesianEstimator::PositiveDefinite, true)]
    {
        let found = identify_cartesian(&set, estimator, Outliers::Keep).unwrap().compliance;
        let least = squares(&set, &found);
        for size in [1e-3, 1e-2, 0.1] {
            for _ in 0..50 {
                let mut step = Matrix6::from_fn(|i, j| {
                    size * (found[(i, i)] * found[(j, j)]).sqrt() * draw.random_range(-1.0..1.0)
                });
                if symmetric {
                    step += step.transpose();
                }
                assert!(squares(&set, &(found + step)) > least, "{estimator} {size}");
            }
        }
    }
}

#[test]
fn weighting_listens_to_the_better_measurements() {
    let truth = compliance();
    let (mut plain, mut weighted) = (Vec::new(), Vec::new());
    for seed in 0..20 {
        let mut rng = rng(400 + seed);
        let mut noises = Vec::new();
        let measurements = (0..100).map(|n| {
            let bad = if n % 2 == 0 { 1.0 } else { 10.0 };
            noises.push(MeasurementNoise::from_std(bad * NOISE[0], bad * NOISE[1], NOISE[2], NOISE[3]));
            let wrench = load(&mut rng);
            let displacement = noisy(&mut rng, &(truth * wrench), bad * NOISE[0], bad * NOISE[1]);
            Measurement { q: pose(), wrench: noisy(&mut rng, &wrench, NOISE[2], NOISE[3]), displacement }
        });
        let measurements = measurements.collect();
        let set = MeasurementSet::new(measurements, noise()).unwrap().with_noise_of_each(noises).unwrap();
        let error = |estimator| {
            let estimate = identify_cartesian(&set, estimator, Outliers::Keep).unwrap();
            relative(&estimate.compliance, &truth)
        };
        plain.push(error(CartesianEstimator::DisplacementOnWrench));
        weighted.push(error(CartesianEstimator::Weighted).max(error(CartesianEstimator::PositiveDefinite)));
    }
    // Half of the data at a tenth of the noise: 7 times better at best.
    assert!(median(weighted.clone()) < 0.3 * median(plain.clone()), "{weighted:?} {plain:?}");
}

#[test]
fn estimates_do_not_depend_on_units_or_axes() {
    // Another frame: C' = A C Aᵀ for X' = A X, W' = A⁻ᵀ W, and noise carried along.
    let truth = compliance();
    let a = Matrix6::from_fn(|i, j| if i == j { 1.0 } else { 0.2 * ((i * 5 + j * 3) as f64).sin() });
    let inverse = a.try_inverse().unwrap();
    let measurements = linear_measurements(&mut rng(500), &truth, 60);
    let moved = measurements.iter().map(|m| Measurement {
        q: m.q.clone(),
        wrench: inverse.transpose() * m.wrench,
        displacement: a * m.displacement,
    });
    let own = noise();
    let carried = MeasurementNoise {
        displacement: symmetric(&(a * own.displacement * a.transpose())),
        wrench: symmetric(&(inverse.transpose() * own.wrench * inverse)),
    };
    let moved = MeasurementSet::new(moved.collect(), carried).unwrap();
    let set = set(measurements);
    for estimator in CartesianEstimator::ALL {
        let here = identify_cartesian(&set, estimator, Outliers::Keep).unwrap();
        let there = identify_cartesian(&moved, estimator, Outliers::Keep).unwrap();
        let expected = a * here.compliance * a.transpose();
        assert!(relative(&there.compliance, &expected) < 1e-5, "{estimator}");
        assert!((there.chi_square - here.chi_square).abs() < 1e-5 * here.chi_square, "{estimator}");
    }
}

fn symmetric(m: &Matrix6<f64>) -> Matrix6<f64> {
    0.5 * (m + m.transpose())
}

#[test]
fn five_percent_of_outliers_are_found_and_do_no_harm() {
    let truth = compliance();
    for seed in 0..5 {
        let mut rng = rng(600 + seed);
        let mut measurements = linear_measurements(&mut rng, &truth, 200);
        let wrong = spoil(&mut rng, &mut measurements);
        let clean: Vec<Measurement> =
            measurements.iter().enumerate().filter(|(n, _)| !wrong.contains(n)).map(|(_, m)| m.clone()).collect();
        let (all, clean) = (set(measurements), set(clean));
        for estimator in CartesianEstimator::ALL.into_iter().skip(1) {
            let robust = identify_cartesian(&all, estimator, Outliers::Reject).unwrap();
            assert!(wrong.iter().all(|n| robust.outliers.contains(n)), "{:?}", robust.outliers);
            assert!(robust.outliers.len() <= wrong.len() + 3, "{:?}", robust.outliers);
            let best = identify_cartesian(&clean, estimator, Outliers::Keep).unwrap();
            let spoiled = identify_cartesian(&all, estimator, Outliers::Keep).unwrap();
            let error = relative(&robust.compliance, &truth);
            assert!(error < 1.3 * relative(&best.compliance, &truth), "{estimator}");
            assert!(relative(&spoiled.compliance, &truth) > 3.0 * error, "{estimator}");
        }
    }
}

#[test]
fn the_comparison_distrusts_the_published_estimator_and_foresees_its_error() {
    let truth = compliance().try_inverse().unwrap();
    let set = set(linear_measurements(&mut rng(700), &compliance(), 200));
    let start = Springs::linear(&[5e5; 6]);
    let comparison = compared(&set, &start, Outliers::Keep).unwrap();
    assert_eq!(comparison.trusted, Method::JointSprings);
    let report = |wanted: CartesianEstimator| {
        let found = comparison.methods.iter().find(|(method, _)| *method == Method::Cartesian(wanted));
        found.unwrap().1.clone().unwrap()
    };
    let published = report(CartesianEstimator::WrenchOnDisplacement);
    let Found::Cartesian(estimate) = &published.found else { panic!("{published:?}") };
    let foreseen = published.attenuation.unwrap().error;
    assert!((foreseen - relative(&estimate.stiffness, &truth)).abs() < 0.08, "{foreseen}");
    assert!(published.held_out > 1.3 * report(CartesianEstimator::PositiveDefinite).held_out);
    assert!(report(CartesianEstimator::DisplacementOnWrench).attenuation.unwrap().error < 1e-3);
    assert!((0.9..1.1).contains(&report(CartesianEstimator::PositiveDefinite).held_out));
    let published = CartesianEstimator::WrenchOnDisplacement;
    let warned = |advice: &Advice| matches!(advice, Advice::Attenuated { estimator, .. } if *estimator == published);
    assert!(comparison.advice.iter().any(warned), "{:?}", comparison.advice);
}

/// With noise stated as five times smaller than it is, no method leaves only noise, and the best one is not to be trusted.
#[test]
fn the_best_method_explains_the_measurements_or_not() {
    let measurements = linear_measurements(&mut rng(700), &compliance(), 200);
    let small = NOISE.map(|s| s / 5.0);
    let understated = MeasurementNoise::from_std(small[0], small[1], small[2], small[3]);
    for (stated, explained) in [(noise(), true), (understated, false)] {
        let set = MeasurementSet::new(measurements.clone(), stated).unwrap();
        let advice = compared(&set, &Springs::linear(&[5e5; 6]), Outliers::Keep).unwrap().advice;
        assert!(matches!(advice[0], Advice::Trust { explains, .. } if explains == explained), "{:?}", advice[0]);
    }
}

#[test]
fn over_several_poses_only_springs_are_compared() {
    let springs = Springs::linear(&STIFFNESS);
    let mut draw = rng(750);
    let poses: Vec<Vec<f64>> = (0..6).map(|_| random_pose(&mut draw)).collect();
    let set = set(robot_measurements(&mut draw, &springs, &poses, 60, 1.0));
    let comparison = compared(&set, &springs, Outliers::Reject).unwrap();
    assert_eq!(comparison.trusted, Method::JointSprings);
    assert_eq!(comparison.methods.iter().filter(|(_, report)| report.is_ok()).count(), 1);
    assert!(compare(&set, None, Outliers::Keep).is_err());
}

#[test]
fn the_comparison_prefers_a_free_matrix_where_joints_do_not_explain_it() {
    // Links that yield as much as the joints, in the pose of the data only known to a 6 × 6 compliance.
    let truth = compliance() + Matrix6::from_diagonal(&Vector6::new(2e-6, 2e-6, 2e-6, 4e-6, 4e-6, 4e-6));
    let set = set(linear_measurements(&mut rng(800), &truth, 200));
    let start = Springs::linear(&[5e5; 6]);
    let comparison = compared(&set, &start, Outliers::Keep).unwrap();
    assert_eq!(comparison.trusted, Method::Cartesian(CartesianEstimator::PositiveDefinite), "{comparison:?}");
}

#[test]
fn links_that_yield_are_no_outliers_where_there_is_one_pose() {
    // So much that no spring of a joint explains any of it.
    let truth = compliance() + Matrix6::from_diagonal(&Vector6::new(1e-5, 1e-5, 1e-5, 2e-5, 2e-5, 2e-5));
    let mut rng = rng(810);
    let mut measurements = linear_measurements(&mut rng, &truth, 200);
    let wrong = spoil(&mut rng, &mut measurements);
    let set = set(measurements);
    let start = Springs::linear(&[5e5; 6]);
    let comparison = compared(&set, &start, Outliers::Reject).unwrap();
    assert_eq!(comparison.trusted, Method::Cartesian(CartesianEstimator::PositiveDefinite), "{comparison:?}");
    assert!(wrong.iter().all(|n| comparison.outliers.contains(n)), "{comparison:?}");
    assert!(comparison.outliers.len() <= wrong.len() + 3, "{comparison:?}");
}
