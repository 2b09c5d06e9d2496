//! Data that say nothing, or something else than they seem to, are refused with the reason.

use crate::common::{
    STIFFNESS, kr125, measured,
    measured::{compared, compliance, linear_measurements, noise, noisy, robot_measurements},
    pose, rng,
};
use bracketry_stiffness::{
    Advice, CartesianEstimator, IdentificationError, JointSpring, Measurement, MeasurementNoise, MeasurementSet,
    Method, Outliers, Place, PoseInformation, Robot, SpringFitSettings, Springs, fit_springs, identify_cartesian,
};

fn measurements() -> Vec<Measurement> {
    linear_measurements(&mut rng(1), &compliance(), 40)
}

fn refusal(measurements: Vec<Measurement>) -> IdentificationError {
    MeasurementSet::new(measurements, noise()).unwrap_err()
}

#[test]
fn a_number_that_is_none_is_named_by_row_and_column() {
    for (value, change, column) in [
        (f64::NAN, (|m, v| m.wrench[4] = v) as fn(&mut Measurement, f64), "moment y"),
        (f64::INFINITY, |m, v| m.displacement[2] = v, "translation z"),
        (f64::NAN, |m, v| m.q[5] = v, "joint 6"),
    ] {
        let mut data = measurements();
        change(&mut data[12], value);
        let refused = refusal(data);
        assert!(matches!(refused, IdentificationError::NotFinite { row: Place::Row(13), .. }));
        assert!(refused.to_string().starts_with(&format!("row 13, {column}:")), "{refused}");
    }
}

#[test]
fn units_off_by_a_thousand_are_noticed() {
    let scaled = |wrench: [f64; 2], displacement: [f64; 2]| {
        let mut data = measurements();
        for m in &mut data {
            for i in 0..6 {
                m.wrench[i] *= wrench[i / 3];
                m.displacement[i] *= displacement[i / 3];
            }
        }
        MeasurementSet::new(data, noise())
    };
    assert!(scaled([1.0, 1.0], [1.0, 1.0]).is_ok());
    for (wrench, displacement, hint) in [
        ([1.0, 1.0], [1e3, 1.0], "mm"),
        ([1.0, 1.0], [1.0, 1e3], "mrad"),
        ([1.0, 1.0], [1e3, 1e3], "mm"),
        ([1.0, 1.0], [1e-3, 1.0], "mm for m"),
        ([1.0, 1.0], [1.0, 57.3], "degrees"),
        ([1e-3, 1.0], [1.0, 1.0], "kN for N"),
        ([1e-3, 1e-3], [1.0, 1.0], "kN for N"),
        ([1.0, 1e3], [1.0, 1.0], "N·mm for N·m"),
    ] {
        match scaled(wrench, displacement) {
            Err(refused @ IdentificationError::Units { .. }) => {
                assert!(refused.to_string().contains(hint), "{wrench:?} {displacement:?}: {refused}");
            }
            Err(other) => panic!("{wrench:?} {displacement:?}: {other}"),
            Ok(_) => panic!("{wrench:?} {displacement:?}: taken for good"),
        }
    }
}

#[test]
fn a_range_from_zero_has_only_an_upper_end() {
    let mut data = measurements();
    for m in &mut data {
        m.displacement *= 1e3;
    }
    let words = refusal(data).to_string();
    assert!(words.contains("which is at most 0.05 for robots"), "{words}");
}

#[test]
fn a_comparison_counts_all_measurements() {
    let springs = Springs::linear(&STIFFNESS);
    let compared = |count| {
        let data = linear_measurements(&mut rng(8), &compliance(), count);
        let set = MeasurementSet::new(data, noise()).unwrap();
        let comparison = compared(&set, &springs, Outliers::Keep).unwrap();
        let positive = Method::Cartesian(CartesianEstimator::PositiveDefinite);
        comparison.methods.into_iter().find(|(method, _)| *method == positive).unwrap().1.map(|report| report.held_out)
    };
    for count in [7, 8] {
        let refused = compared(count).unwrap_err();
        assert!(matches!(refused, IdentificationError::TooFew { found, needed: 9, .. } if found == count), "{refused}");
    }
    let refused = compared(9);
    assert!(!matches!(refused, Err(IdentificationError::TooFew { .. })), "{refused:?}");
}

#[test]
fn the_wrench_that_the_robot_exerts_is_not_the_one_on_it() {
    let mut data = measurements();
    for m in &mut data {
        m.wrench = -m.wrench;
    }
    let refused = refusal(data.clone());
    assert!(matches!(refused, IdentificationError::Sign { found: 40, of: 40 }), "{refused}");
    assert!(refused.to_string().contains("change the sign"), "{refused}");
    // A few rows of the wrong sign are outliers.
    for m in &mut data[5..] {
        m.wrench = -m.wrench;
    }
    assert!(MeasurementSet::new(data, noise()).is_ok());
}

#[test]
fn moments_in_kilonewton_meters_look_like_none() {
    let mut data = measurements();
    for m in &mut data {
        m.wrench.fixed_rows_mut::<3>(3).scale_mut(1e-3);
    }
    let set = MeasurementSet::new(data, noise()).unwrap();
    let refused = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap_err();
    assert!(matches!(refused, IdentificationError::NotLoaded { .. }), "{refused}");
    assert!(refused.to_string().contains("no moment about y") && refused.to_string().contains("check the units"));
}

#[test]
fn a_part_with_another_sign_or_unit_is_named_by_the_fit_of_joint_springs() {
    let start = Springs::linear(&[1e6; 6]);
    let mut rng = rng(21);
    let poses: Vec<Vec<f64>> = (0..8).map(|_| measured::random_pose(&mut rng)).collect();
    let mut data = robot_measurements(&mut rng, &Springs::linear(&STIFFNESS), &poses, 60, 1.0);
    measured::spoil(&mut rng, &mut data);
    let compared = |[force, moment, translation, rotation]: [f64; 4]| {
        let mut data = data.clone();
        for m in &mut data {
            for i in 0..6 {
                m.wrench[i] *= if i < 3 { force } else { moment };
                m.displacement[i] *= if i < 3 { translation } else { rotation };
            }
        }
        let set = MeasurementSet::new(data, noise()).unwrap();
        compared(&set, &start, Outliers::Reject)
    };
    assert!(compared([1.0; 4]).is_ok());
    for (factors, said) in [
        ([1.0, 1e-3, 1.0, 1.0], "multiply Mx, My, Mz by 1000"),
        ([1.0, 1.0, 1.0, -1.0], "change the sign of rx, ry, rz"),
        ([1.0, -1.0, 1.0, 1.0], "change the sign of Mx, My, Mz"),
    ] {
        let refused = compared(factors).unwrap_err();
        assert!(matches!(refused, IdentificationError::Convention { .. }), "{refused}");
        assert!(refused.to_string().contains(said), "{refused}");
    }
}

#[test]
fn another_model_is_not_taken_for_another_sign() {
    // Lost motion, and links that yield: the joint springs miss something, but no sign.
    let start = Springs::linear(&[1e6; 6]);
    let mut rng = rng(22);
    let poses: Vec<Vec<f64>> = (0..8).map(|_| measured::random_pose(&mut rng)).collect();
    let mut lost = Springs::linear(&STIFFNESS);
    lost.joints[0] = JointSpring::Backlash { stiffness: STIFFNESS[0], gap: 3e-4, engaged: 40.0 };
    let link = nalgebra::Matrix6::from_diagonal(&nalgebra::Vector6::new(2e-7, 2e-7, 2e-7, 5e-7, 5e-7, 5e-7));
    let links = Springs::linear(&STIFFNESS).with_links(vec![link; 6]);
    for springs in [lost, links] {
        let data = robot_measurements(&mut rng, &springs, &poses, 60, 1.0);
        let set = MeasurementSet::new(data, noise()).unwrap();
        let compared = compared(&set, &start, Outliers::Keep);
        assert!(!matches!(compared, Err(IdentificationError::Convention { .. })), "{compared:?}");
    }
}

#[test]
fn noise_that_is_smaller_than_stated_is_remarked() {
    let start = Springs::linear(&[1e6; 6]);
    let data = linear_measurements(&mut rng(23), &compliance(), 40);
    for (factor, remarked) in [(1.0, false), (5.0, true)] {
        let [a, b, c, d] = measured::NOISE.map(|n| factor * n);
        let set = MeasurementSet::new(data.clone(), MeasurementNoise::from_std(a, b, c, d)).unwrap();
        let found = compared(&set, &start, Outliers::Keep).unwrap();
        let said = found.advice.iter().any(|advice| matches!(advice, Advice::NoiseOverstated { .. }));
        assert_eq!(said, remarked, "{:?}", found.advice);
    }
}

#[test]
fn loads_of_forces_alone_or_moments_alone_are_no_mistake_of_units() {
    // Only as much of the other as the sensor's noise.
    for strong in [0, 3] {
        let mut rng = rng(9);
        let data = (0..40).map(|_| {
            let mut wrench = measured::load(&mut rng);
            wrench.fixed_rows_mut::<3>(3).scale_mut(10.0);
            wrench.fixed_rows_mut::<3>(3 - strong).fill(0.0);
            let displacement = noisy(&mut rng, &(compliance() * wrench), 20e-6, 50e-6);
            Measurement { q: pose(), wrench: noisy(&mut rng, &wrench, 2.0, 0.5), displacement }
        });
        assert!(MeasurementSet::new(data.collect(), noise()).is_ok());
    }
}

#[test]
fn a_single_displacement_or_load_beyond_any_robot_s_is_named() {
    let mut data = measurements();
    data[3].displacement[0] = 0.2;
    assert!(matches!(refusal(data), IdentificationError::Implausible { row: Place::Row(4), what: "translation", .. }));
    let mut data = measurements();
    data[5].wrench[4] = 1e200;
    assert!(matches!(refusal(data), IdentificationError::Implausible { row: Place::Row(6), what: "moment", .. }));
}

#[test]
fn copies_and_rows_of_another_length_are_named() {
    let mut data = measurements();
    data.push(data[5].clone());
    assert_eq!(refusal(data), IdentificationError::Repeated { row: Place::Row(41), first: Place::Row(6) });
    let mut data = measurements();
    data[7].q.pop();
    assert!(matches!(refusal(data), IdentificationError::Count { row: Place::Row(8), found: 5, expected: 6, .. }));
    let set = MeasurementSet::new(measurements(), noise()).unwrap();
    assert!(matches!(set.with_noise_of_each(vec![noise(); 3]), Err(IdentificationError::Count { .. })));
}

#[test]
fn a_noise_that_is_none_is_refused() {
    for bad in [
        MeasurementNoise::from_std(0.0, 5e-5, 2.0, 0.5),
        MeasurementNoise::from_std(2e-5, 5e-5, 2.0, f64::NAN),
        MeasurementNoise::from_std(2e-5, 1e200, 2.0, 0.5),
        MeasurementNoise::from_std(2e-5, 5e-5, 1e-160, 0.5),
    ] {
        assert!(matches!(MeasurementSet::new(measurements(), bad), Err(IdentificationError::Noise { .. })));
    }
    let mut skewed = noise();
    skewed.wrench[(0, 1)] = 1.0;
    assert_eq!(MeasurementSet::new(measurements(), skewed), Err(IdentificationError::Noise { what: "wrench" }));
}

/// Measurements whose loads went through a change before they acted.
fn loaded(change: impl Fn(&mut bracketry_stiffness::Wrench)) -> MeasurementSet {
    let truth = compliance();
    let mut rng = rng(2);
    let data = (0..60).map(|_| {
        let mut wrench = measured::load(&mut rng);
        change(&mut wrench);
        let displacement = noisy(&mut rng, &(truth * wrench), 20e-6, 50e-6);
        Measurement { q: pose(), wrench: noisy(&mut rng, &wrench, 2.0, 0.5), displacement }
    });
    MeasurementSet::new(data.collect(), noise()).unwrap()
}

#[test]
fn directions_that_were_never_loaded_are_named() {
    let told = |set: &MeasurementSet| {
        CartesianEstimator::ALL.map(|estimator| match identify_cartesian(set, estimator, Outliers::Reject) {
            Err(IdentificationError::NotLoaded { directions }) => {
                directions.iter().map(ToString::to_string).collect::<Vec<_>>()
            }
            other => panic!("{estimator}: {other:?}"),
        })
    };
    for words in told(&loaded(|w| w[3] = 0.0)) {
        assert_eq!(words, ["no moment about x"]);
    }
    for words in told(&loaded(|w| (w[1], w[5]) = (0.0, 0.0))) {
        assert_eq!(words, ["no force along y", "no moment about z"]);
    }
    // A force on a fixed lever of 0.1 m: its moment is never free of it.
    for words in told(&loaded(|w| w[4] = 0.1 * w[2])) {
        assert_eq!(words.len(), 1);
        assert!(words[0].contains("moment y") && words[0].contains("force z"), "{words:?}");
    }
}

#[test]
fn too_few_measurements_and_several_poses_are_refused() {
    let few = MeasurementSet::new(measurements()[..6].to_vec(), noise()).unwrap();
    let refused = identify_cartesian(&few, CartesianEstimator::DisplacementOnWrench, Outliers::Keep).unwrap_err();
    assert!(matches!(refused, IdentificationError::TooFew { found: 6, needed: 7, .. }));
    let none = MeasurementSet::new(Vec::new(), noise()).unwrap();
    assert!(identify_cartesian(&none, CartesianEstimator::PositiveDefinite, Outliers::Reject).is_err());
    assert!(fit_springs(&kr125(), &none, &Springs::linear(&STIFFNESS), &SpringFitSettings::default()).is_err());
    let mut data = measurements();
    data[9].q[2] += 0.1;
    let set = MeasurementSet::new(data, noise()).unwrap();
    let refused = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Keep).unwrap_err();
    assert!(matches!(refused, IdentificationError::PosesDiffer { row: Place::Row(10), joint: 3, .. }));
}

#[test]
fn what_outliers_leave_must_still_be_enough() {
    for count in [7, 8, 9, 12] {
        let mut data = linear_measurements(&mut rng(6), &compliance(), count);
        data[0].displacement *= -3.0;
        data[3].displacement *= -2.0;
        let set = MeasurementSet::new(data, noise()).unwrap();
        for estimator in CartesianEstimator::ALL {
            // Found or refused, never a panic; what is found comes from enough.
            if let Ok(estimate) = identify_cartesian(&set, estimator, Outliers::Reject) {
                assert!(count - estimate.outliers.len() >= 7);
            }
        }
    }
}

#[test]
fn displacements_that_nobody_measured_are_no_stiffness() {
    let without = |part: usize, rows: std::ops::Range<usize>| {
        let mut data = measurements();
        data[rows].iter_mut().for_each(|m| m.displacement.fixed_rows_mut::<3>(part).fill(0.0));
        data
    };
    for (part, what) in [(0, "translations"), (3, "rotations")] {
        let refused = refusal(without(part, 0..40));
        assert!(matches!(refused, IdentificationError::Zero { what: found, .. } if found == what), "{refused}");
    }
    // Those that are known not to be measured count for nothing.
    let unmeasured = MeasurementNoise::from_std(2e-5, 0.05, 2.0, 0.5);
    assert!(MeasurementSet::new(without(3, 0..40), unmeasured).is_ok());
    // A row without a displacement under a load is not measured either; without a load it is the pose it is measured against.
    let mut data = without(0, 7..9);
    data[7..9].iter_mut().for_each(|m| m.displacement.fill(0.0));
    let refused = refusal(data.clone());
    assert_eq!(refused, IdentificationError::Unmoved { row: Place::Row(8), found: 2, of: 40 });
    (data[7].wrench, data[8].wrench) = (nalgebra::Vector6::repeat(0.3), nalgebra::Vector6::zeros());
    assert!(MeasurementSet::new(data, noise()).is_ok());
}

#[test]
fn refusals_of_a_file_name_its_lines() {
    let mut data = measurements();
    data.push(data[5].clone());
    let lines: Vec<u64> = (0..41).map(|i| 3 + 2 * i).collect();
    let refused = refusal(data).in_file(&lines);
    assert!(refused.to_string().starts_with("line 83 equals line 13 in every digit"), "{refused}");
    // What names no measurement stays what it is.
    let other = IdentificationError::Sign { found: 3, of: 4 };
    assert_eq!(other.clone().in_file(&lines), other);
}

#[test]
fn more_outliers_than_measurements_explain_are_a_wrong_model() {
    // Half of the data from another robot.
    let mut rng = rng(3);
    let mut data = linear_measurements(&mut rng, &compliance(), 50);
    data.extend(linear_measurements(&mut rng, &(3.0 * compliance()), 45));
    let set = MeasurementSet::new(data, noise()).unwrap();
    let refused = identify_cartesian(&set, CartesianEstimator::PositiveDefinite, Outliers::Reject).unwrap_err();
    assert!(matches!(refused, IdentificationError::TooManyOutliers { of: 95, .. }), "{refused}");
}

#[test]
fn springs_and_poses_that_do_not_fit_the_robot_are_refused() {
    let (robot, springs) = (kr125(), Springs::linear(&STIFFNESS));
    let settings = SpringFitSettings::default();
    let data = robot_measurements(&mut rng(4), &springs, &[pose()], 10, 1.0);
    let set = MeasurementSet::new(data.clone(), noise()).unwrap();
    assert!(matches!(
        fit_springs(&robot, &set, &Springs::linear(&STIFFNESS[..5]), &settings),
        Err(IdentificationError::Robot(_))
    ));
    let mut start = springs.clone();
    start.joints[3] = JointSpring::Stiffening { stiffness: 1e5, cubic: 0.0 };
    let refused = fit_springs(&robot, &set, &start, &settings).unwrap_err();
    assert_eq!(refused, IdentificationError::Start { joint: 4, name: "cubic", value: 0.0 });
    let short = data.into_iter().map(|mut m| {
        m.q.pop();
        m
    });
    let set = MeasurementSet::new(short.collect(), noise()).unwrap();
    assert!(matches!(
        fit_springs(&robot, &set, &springs, &settings),
        Err(IdentificationError::Count { row: Place::Row(1), found: 5, expected: 6, .. })
    ));
    let candidate = (pose(), measured::load(&mut rng(5)));
    for bad in [f64::NAN, 1e200] {
        let mut spoiled = candidate.clone();
        spoiled.1[2] = bad;
        assert!(PoseInformation::new(&robot, &springs, &[candidate.clone(), spoiled], &noise()).is_err());
    }
    let none = PoseInformation::new(&robot, &springs, &[], &noise()).unwrap();
    assert!(none.of(&[]).log_std.iter().all(|v| v.is_infinite()));
    assert!(none.choose(0).is_err());
    let stump = Robot::from_modified_dh("stump", &[]);
    assert!(PoseInformation::new(&stump, &Springs::linear(&[]), &[], &noise()).is_err());
    let information = PoseInformation::new(&robot, &springs, &[candidate], &noise());
    assert!(matches!(information.unwrap().choose(2), Err(IdentificationError::TooFew { found: 1, needed: 2, .. })));
}
