//! Springs of the joints from measurements over many poses.

use crate::common::{
    STIFFNESS, kr125, measured,
    measured::{load, noise, random_pose, robot_measurements, set, spoil},
    pose, rng,
};
use bracketry_stiffness::{
    DeformationModel, IdentificationError, Identified, JointSpring, Measurement, MeasurementSet, Outliers,
    PoseInformation, SpringFit, SpringFitSettings, Springs, Wrench, fit_springs,
};

fn poses(seed: u64, count: usize) -> Vec<Vec<f64>> {
    let mut rng = rng(seed);
    (0..count).map(|_| random_pose(&mut rng)).collect()
}

fn fit(set: &MeasurementSet, start: &Springs, outliers: Outliers) -> SpringFit {
    let settings = SpringFitSettings { outliers, ..SpringFitSettings::default() };
    fit_springs(&kr125(), set, start, &settings).unwrap()
}

fn values(fit: &SpringFit) -> Vec<(f64, f64, f64)> {
    fit.parameters
        .iter()
        .map(|p| match p.identified {
            Identified::Yes { value, low, high } => (value, low, high),
            Identified::No { .. } => panic!("{p}"),
        })
        .collect()
}

fn root_mean_square(fit: &SpringFit, truth: &[f64]) -> f64 {
    let errors = values(fit).iter().zip(truth).map(|((value, ..), k)| (value / k - 1.0).powi(2)).sum::<f64>();
    (errors / truth.len() as f64).sqrt()
}

#[test]
fn two_hundred_measurements_tell_joint_stiffnesses_to_one_percent() {
    let mut errors = vec![Vec::new(); 6];
    for seed in 0..15 {
        let measurements =
            robot_measurements(&mut rng(1000 + seed), &Springs::linear(&STIFFNESS), &poses(seed, 20), 200, 1.0);
        let fit = fit(&set(measurements), &Springs::linear(&[5e5; 6]), Outliers::Keep);
        assert!((0.85..1.15).contains(&fit.chi_square), "{fit:?}");
        for (errors, ((value, ..), k)) in errors.iter_mut().zip(values(&fit).iter().zip(STIFFNESS)) {
            errors.push((value / k - 1.0).abs());
        }
    }
    for (joint, errors) in errors.iter_mut().enumerate() {
        errors.sort_by(f64::total_cmp);
        // Forces at the tool point have little lever about joint 4 and none about joint 6, whose axis runs through it: 60 N·m turn that one
        // by 160 µrad at most, noise is 50.
        let limit = [0.01, 0.01, 0.01, 0.015, 0.01, 0.04][joint];
        assert!(errors[7] < limit, "joint {}: {errors:?}", joint + 1);
    }
}

#[test]
fn intervals_of_stiffnesses_contain_the_truth_as_often_as_they_say() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..40 {
        let measurements =
            robot_measurements(&mut rng(1100 + seed), &Springs::linear(&STIFFNESS), &poses(seed, 5), 25, 1.0);
        let fit = fit(&set(measurements), &Springs::linear(&[5e5; 6]), Outliers::Keep);
        for ((_, low, high), k) in values(&fit).into_iter().zip(STIFFNESS) {
            all += 1;
            inside += u32::from((low..=high).contains(&k));
        }
    }
    let share = f64::from(inside) / f64::from(all);
    assert!((0.91..0.99).contains(&share), "{share}");
}

#[test]
fn a_start_far_off_leads_to_the_same_springs() {
    let measurements = robot_measurements(&mut rng(2), &Springs::linear(&STIFFNESS), &poses(20, 10), 60, 1.0);
    let set = set(measurements);
    let near = values(&fit(&set, &Springs::linear(&STIFFNESS), Outliers::Keep));
    for far in [1e4, 1e8] {
        for (a, b) in values(&fit(&set, &Springs::linear(&[far; 6]), Outliers::Keep)).iter().zip(&near) {
            assert!((a.0 / b.0 - 1.0).abs() < 1e-4, "{far}: {a:?} {b:?}");
        }
    }
}

#[test]
fn stiffening_and_lost_motion_are_identified() {
    let mut truth = Springs::linear(&STIFFNESS);
    truth.joints[1] = JointSpring::Stiffening { stiffness: 400_760.0, cubic: 4e10 };
    truth.joints[2] = JointSpring::Backlash { stiffness: 935_280.0, gap: 4e-4, engaged: 60.0 };
    let measurements = robot_measurements(&mut rng(3), &truth, &poses(30, 20), 300, 1.0);
    let mut start = Springs::linear(&[5e5; 6]);
    start.joints[1] = JointSpring::Stiffening { stiffness: 5e5, cubic: 1e10 };
    start.joints[2] = JointSpring::Backlash { stiffness: 5e5, gap: 1e-4, engaged: 100.0 };
    let set = set(measurements);
    let fit = fit(&set, &start, Outliers::Keep);
    assert!((0.85..1.15).contains(&fit.chi_square), "{fit:?}");
    let expected = [1_409_800.0, 400_760.0, 4e10, 935_280.0, 4e-4, 60.0, 360_000.0, 370_000.0, 380_000.0];
    for ((value, low, high), truth) in values(&fit).into_iter().zip(expected) {
        // Half an interval more than 95 %: all nine of them hold.
        let slack = (high / low).powf(0.25);
        assert!((low / slack..=high * slack).contains(&truth), "{value} {low} {high}, {truth}");
    }
    // Linear springs do not explain these data, and the residuals say so.
    let linear = self::fit(&set, &Springs::linear(&[5e5; 6]), Outliers::Keep);
    assert!(linear.chi_square > 2.0, "{linear:?}");
}

#[test]
fn the_model_that_made_the_data_fits_them_best() {
    // Soft and heavily loaded, so that the deformed lever shows.
    let soft: Vec<f64> = STIFFNESS.iter().map(|k| 0.2 * k).collect();
    let measurements = robot_measurements(&mut rng(4), &Springs::linear(&soft), &poses(40, 10), 200, 1.5);
    let set = set(measurements);
    let chi_square = |model| {
        let settings = SpringFitSettings { model, ..SpringFitSettings::default() };
        fit_springs(&kr125(), &set, &Springs::linear(&[5e5; 6]), &settings).unwrap().chi_square
    };
    let equilibrium = chi_square(DeformationModel::Equilibrium);
    assert!((0.85..1.15).contains(&equilibrium), "{equilibrium}");
    for model in [DeformationModel::Linear, DeformationModel::Product] {
        assert!(chi_square(model) > 1.5 * equilibrium, "{model:?} {}", chi_square(model));
    }
}

#[test]
fn five_percent_of_outliers_are_found_and_do_no_harm() {
    let mut rng = rng(5);
    let mut measurements = robot_measurements(&mut rng, &Springs::linear(&STIFFNESS), &poses(50, 20), 200, 1.0);
    let wrong = spoil(&mut rng, &mut measurements);
    let clean = measurements.iter().enumerate().filter(|(n, _)| !wrong.contains(n)).map(|(_, m)| m.clone());
    let (clean, set) = (set(clean.collect()), set(measurements));
    let start = Springs::linear(&[5e5; 6]);
    let robust = fit(&set, &start, Outliers::Reject);
    let best = fit(&clean, &start, Outliers::Keep);
    assert!(wrong.iter().all(|n| robust.outliers.contains(n)), "{:?}", robust.outliers);
    assert!(robust.outliers.len() <= wrong.len() + 3, "{:?}", robust.outliers);
    assert!(root_mean_square(&robust, &STIFFNESS) < 1.3 * root_mean_square(&best, &STIFFNESS));
    let spoiled = fit(&set, &start, Outliers::Keep);
    assert!(spoiled.chi_square > 100.0);
}

#[test]
fn a_joint_that_no_load_turns_is_named_instead_of_guessed() {
    // Forces through the axis of joint 1 in one pose: along the base's z axis they exert nothing on it.
    let robot = kr125();
    let springs = Springs::linear(&STIFFNESS);
    let mut rng = rng(6);
    let measurements: Vec<Measurement> = robot_measurements(&mut rng, &springs, &poses(60, 10), 40, 1.0)
        .into_iter()
        .map(|mut m| {
            m.wrench = Wrench::new(0.0, 0.0, m.wrench[2], 0.0, 0.0, 0.0);
            let tool = bracketry_stiffness::Deformation::equilibrium(&robot, &springs, &m.q, &m.wrench).unwrap().tool;
            m.displacement = measured::noisy(&mut rng, &tool, 20e-6, 50e-6);
            m
        })
        .collect();
    let fit = fit(&set(measurements), &Springs::linear(&[5e5; 6]), Outliers::Keep);
    let Identified::No { log_std, why } = &fit.parameters[0].identified else { panic!("{fit:?}") };
    assert!(*log_std > 0.5 && why.to_string().contains("less than the noise"), "{why}");
    assert!(matches!(fit.parameters[1].identified, Identified::Yes { .. }), "{fit:?}");
    let refused = fit.springs().unwrap_err();
    assert!(matches!(&refused, IdentificationError::NotIdentified { parameters } if parameters[0].joint == 1));
}

#[test]
fn joints_that_act_alike_are_named_together() {
    // With joint 5 straight, joints 4 and 6 turn about one line.
    let mut q = pose();
    q[4] = 0.0;
    let measurements = robot_measurements(&mut rng(7), &Springs::linear(&STIFFNESS), &[q], 60, 1.0);
    let fit = fit(&set(measurements), &Springs::linear(&[5e5; 6]), Outliers::Keep);
    for (joint, other) in [(3, "joint 6"), (5, "joint 4")] {
        let Identified::No { why, .. } = &fit.parameters[joint].identified else { panic!("{fit:?}") };
        assert!(why.to_string().contains(other), "{why}");
    }
    assert!(fit.condition > 1e3, "{}", fit.condition);
}

#[test]
fn lost_motion_where_there_is_none_is_said_not_to_show() {
    let measurements = robot_measurements(&mut rng(70), &Springs::linear(&STIFFNESS), &poses(71, 20), 200, 1.0);
    let mut start = Springs::linear(&[5e5; 6]);
    start.joints[1] = JointSpring::Backlash { stiffness: 5e5, gap: 1e-4, engaged: 50.0 };
    let fit = fit(&set(measurements), &start, Outliers::Keep);
    for parameter in &fit.parameters {
        match (&parameter.identified, parameter.name) {
            (Identified::Yes { value, .. }, "stiffness") => {
                assert!((value / STIFFNESS[parameter.joint - 1] - 1.0).abs() < 0.1, "{parameter}");
            }
            (Identified::No { .. }, "gap" | "engaged") => {}
            _ => panic!("{fit:?}"),
        }
    }
    assert!(fit.log_covariance.iter().all(|v| !v.is_nan()));
    assert!(fit.springs().is_err());
}

#[test]
fn chosen_poses_beat_any_random_choice() {
    let (robot, springs) = (kr125(), Springs::linear(&STIFFNESS));
    let mut rng = rng(8);
    let candidates: Vec<(Vec<f64>, Wrench)> = (0..150).map(|_| (random_pose(&mut rng), load(&mut rng))).collect();
    let information = PoseInformation::new(&robot, &springs, &candidates, &noise()).unwrap();
    let chosen = information.choose(8).unwrap();
    assert_eq!(chosen.chosen.len(), 8);
    let worst = |choice: &[f64]| choice.iter().copied().fold(0.0, f64::max);
    let mut ratios = Vec::new();
    for _ in 0..200 {
        let random = information.of(&rand::seq::index::sample(&mut rng, 150, 8).into_vec());
        assert!(random.log_determinant < chosen.log_determinant);
        ratios.push(worst(&random.log_std) / worst(&chosen.log_std));
    }
    ratios.sort_by(f64::total_cmp);
    assert!(ratios[100] > 1.3, "{}", ratios[100]);
    // No exchange of one gains.
    for place in 0..8 {
        for candidate in (0..150).filter(|c| !chosen.chosen.contains(c)) {
            let mut other = chosen.chosen.clone();
            other[place] = candidate;
            assert!(information.of(&other).log_determinant <= chosen.log_determinant + 1e-6);
        }
    }
}

#[test]
fn the_expected_errors_are_the_measured_ones() {
    let (robot, springs) = (kr125(), Springs::linear(&STIFFNESS));
    let mut draw = rng(9);
    let poses: Vec<Vec<f64>> = (0..12).map(|_| random_pose(&mut draw)).collect();
    let candidates: Vec<(Vec<f64>, Wrench)> = poses.iter().map(|q| (q.clone(), load(&mut draw))).collect();
    let information = PoseInformation::new(&robot, &springs, &candidates, &noise()).unwrap();
    let expected = information.of(&(0..12).collect::<Vec<_>>()).log_std;
    let mut squares = [0.0; 6];
    let trials = 100;
    for _ in 0..trials {
        let measurements = candidates.iter().map(|(q, wrench)| {
            let tool = bracketry_stiffness::Deformation::equilibrium(&robot, &springs, q, wrench).unwrap().tool;
            let displacement = measured::noisy(&mut draw, &tool, 20e-6, 50e-6);
            Measurement { q: q.clone(), wrench: measured::noisy(&mut draw, wrench, 2.0, 0.5), displacement }
        });
        let fit = fit(&set(measurements.collect()), &Springs::linear(&STIFFNESS), Outliers::Keep);
        for ((square, (value, ..)), k) in squares.iter_mut().zip(values(&fit)).zip(STIFFNESS) {
            *square += (value / k).ln().powi(2) / f64::from(trials);
        }
    }
    for (square, expected) in squares.iter().zip(expected) {
        // 100 trials tell a standard deviation to 7 %.
        assert!((square.sqrt() / expected - 1.0).abs() < 0.25, "{} {expected}", square.sqrt());
    }
}
