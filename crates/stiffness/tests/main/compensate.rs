//! The compensation, step by step.

use crate::common::{STIFFNESS, milling::robot, rng};
use bracketry_stiffness::{
    CompensationError, CompensationSettings, Compensator, Deformation, Fault, FilterOrder, ForceSensor, JointSpring,
    Kinematics, Payload, Robot, Springs, Wrench, WrenchFilter, displaced, displacement_between, stability,
    wrench_adjoint,
};
use nalgebra::{Isometry3, Matrix6, UnitQuaternion, Vector3};
use rand::{RngExt, rngs::StdRng};
use std::f64::consts::{PI, TAU};

fn uniform(random: &mut StdRng, size: f64) -> f64 {
    random.random_range(-size..size)
}

fn vector(random: &mut StdRng, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| uniform(random, size))
}

fn coordinates(random: &mut StdRng) -> Vec<f64> {
    vec![
        uniform(random, 1.0),
        uniform(random, 0.5),
        0.6 + uniform(random, 0.4),
        uniform(random, 1.0),
        0.9 + uniform(random, 0.4),
        uniform(random, 2.0),
    ]
}

fn sensor(random: &mut StdRng) -> ForceSensor {
    let turn = UnitQuaternion::new(vector(random, 1.0));
    let pose = Isometry3::from_parts(vector(random, 0.3).into(), turn);
    ForceSensor { pose, force_range: 3000.0, moment_range: 2000.0 }
}

/// What a sensor reads when a wrench acts on the tool point of a robot in a pose.
fn read(tool: &Isometry3<f64>, sensor: &ForceSensor, wrench: &Wrench) -> Wrench {
    let at = tool * sensor.pose;
    let seen = Isometry3::from_parts((at.translation.vector - tool.translation.vector).into(), at.rotation);
    wrench_adjoint(&seen).try_inverse().unwrap() * wrench
}

/// Holds a reference under a steady wrench until the filter has settled; gives where the loaded tool then stands, seen from the
/// reference, and where it would stand uncorrected.
fn hold(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench, random: &mut StdRng) -> [Wrench; 2] {
    let sensor = sensor(random);
    let settings = CompensationSettings { correction_limit: 1.0, rate_limit: 100.0, ..CompensationSettings::default() };
    let mut compensator = Compensator::new(robot.clone(), springs.clone(), sensor, Payload::none(), settings).unwrap();
    let target = robot.tool_pose(q).unwrap();
    let stands = |command: &[f64]| {
        let bent = Deformation::equilibrium(robot, springs, command, wrench).unwrap();
        displaced(&robot.tool_pose(command).unwrap(), &bent.tool)
    };
    let mut command = q.to_vec();
    for _ in 0..400 {
        let reading = read(&stands(&command), &sensor, wrench);
        let step = compensator.step(&command, &reading, q);
        assert!(step.status.is_good(), "{:?}", step.status);
        command = step.reference.to_vec();
    }
    [displacement_between(&target, &stands(&command)), displacement_between(&target, &stands(q))]
}

fn wrench(random: &mut StdRng) -> Wrench {
    let (f, m) = (vector(random, 600.0), vector(random, 50.0));
    Wrench::new(f.x, f.y, f.z, m.x, m.y, m.z)
}

#[test]
fn the_loaded_tool_stands_at_the_reference() {
    let mut random = rng(1);
    let robot = robot();
    for round in 0..6 {
        let joints = STIFFNESS.iter().map(|k| match round % 3 {
            0 => JointSpring::linear(*k),
            1 => JointSpring::Stiffening { stiffness: 0.5 * k, cubic: 1e4 * k * k / 1e6 },
            _ => JointSpring::Backlash { stiffness: *k, gap: 3e-4, engaged: 40.0 },
        });
        let springs = Springs::of_joints(joints.collect());
        let q = coordinates(&mut random);
        let load = wrench(&mut random);
        let [with, without] = hold(&robot, &springs, &q, &load, &mut random);
        assert!(without.amax() > 1e-4);
        assert!(with.amax() < 1e-10, "{with}");
    }
}

#[test]
fn the_loaded_tool_stands_at_the_reference_in_a_singular_pose() {
    // Both wrist axes in line: no correction of joints gives every displacement, but the springs' own is undone exactly.
    let mut random = rng(2);
    let robot = robot();
    let q = [0.3, -0.2, 0.7, 0.4, 0.0, 0.1];
    assert!(Kinematics::new(&robot, &q).unwrap().jacobian().clone().singular_values().min() < 1e-12);
    let load = wrench(&mut random);
    let [with, without] = hold(&robot, &Springs::linear(&STIFFNESS), &q, &load, &mut random);
    assert!(without.amax() > 1e-4);
    assert!(with.amax() < 1e-10, "{with}");
}

#[test]
fn newtons_steps_undo_what_links_yield() {
    let mut random = rng(3);
    let robot = robot();
    for _ in 0..5 {
        let links = (0..6).map(|_| {
            let root = Matrix6::from_fn(|i, j| uniform(&mut random, 3e-4) * if i < 3 && j < 3 { 1.0 } else { 0.3 });
            root * root.transpose()
        });
        let springs = Springs::linear(&STIFFNESS).with_links(links.collect());
        let q = coordinates(&mut random);
        let load = wrench(&mut random);
        let joints_alone = Deformation::linear(&robot, &Springs::linear(&STIFFNESS), &q, &load).unwrap().tool;
        let [with, without] = hold(&robot, &springs, &q, &load, &mut random);
        let links_alone = (without - joints_alone).amax();
        assert!(links_alone > 5e-5, "{links_alone}");
        // The sensor is taken to stand where the joints' springs put it, which turns the wrench by the links' yielding.
        assert!(with.amax() < 2e-3 * without.amax(), "{with} {without}");
    }
}

#[test]
fn weight_and_bias_move_nothing() {
    let mut random = rng(4);
    let robot = robot();
    let sensor = sensor(&mut random);
    let bias = wrench(&mut random);
    let payload = Payload { mass: 37.0, center: vector(&mut random, 0.2), bias };
    let settings = CompensationSettings::default();
    let springs = Springs::linear(&STIFFNESS);
    let mut compensator = Compensator::new(robot.clone(), springs, sensor, payload, settings).unwrap();
    for _ in 0..50 {
        let q = coordinates(&mut random);
        let orientation = (robot.tool_pose(&q).unwrap() * sensor.pose).rotation;
        // The weight in base axes hangs below, whatever the pose.
        let weight = orientation.inverse() * Vector3::new(0.0, 0.0, -9.81 * 37.0);
        let moment = payload.center.cross(&weight);
        let reading = bias + Wrench::new(weight.x, weight.y, weight.z, moment.x, moment.y, moment.z);
        let step = compensator.step(&q, &reading, &q);
        assert!(step.wrench.amax() < 1e-10, "{}", step.wrench);
        for (command, q) in step.reference.iter().zip(&q) {
            assert!((command - q).abs() < 1e-14);
        }
    }
}

#[test]
fn the_filter_passes_half_the_power_at_its_cutoff_and_all_of_what_stands() {
    for (order, cutoff, period) in
        [(FilterOrder::First, 5.0, 0.004), (FilterOrder::Second, 5.0, 0.004), (FilterOrder::Second, 40.0, 0.01)]
    {
        let gain = |frequency: f64| {
            let mut filter = WrenchFilter::new(order, cutoff, period).unwrap();
            let settle = (20.0 / (cutoff * period)) as usize;
            let whole = (50.0 / (frequency * period)).round() as usize;
            // Correlation with sine and cosine over whole periods.
            let (mut sine, mut cosine) = (0.0, 0.0);
            for k in 0..settle + whole {
                let phase = TAU * frequency * period * k as f64;
                let y = filter.step(&Wrench::repeat(phase.sin()))[2];
                if k >= settle {
                    sine += y * phase.sin();
                    cosine += y * phase.cos();
                }
            }
            2.0 * f64::hypot(sine, cosine) / whole as f64
        };
        assert!((gain(cutoff) - 0.5f64.sqrt()).abs() < 1e-6, "{}", gain(cutoff));
        // Butterworth: 1/√(1 + Ω²ⁿ), the frequency as the bilinear transform sees it.
        for share in [0.3, 0.7, 1.2] {
            let warped = (PI * share * cutoff * period).tan() / (PI * cutoff * period).tan();
            let expected = match order {
                FilterOrder::First => 1.0 / (1.0 + warped.powi(2)).sqrt(),
                FilterOrder::Second => 1.0 / (1.0 + warped.powi(4)).sqrt(),
            };
            let found = gain(share * cutoff);
            assert!((found - expected).abs() < 5e-3, "{found} {expected}");
        }
        let mut filter = WrenchFilter::new(order, cutoff, period).unwrap();
        let mut y = Wrench::zeros();
        for _ in 0..2000 {
            y = filter.step(&Wrench::repeat(3.0));
        }
        assert!((y - Wrench::repeat(3.0)).amax() < 1e-9);
    }
}

/// The filtered wrench of a stiff robot at rest whose sensor reads a force along x.
fn filtered(settings: CompensationSettings, force: impl Fn(f64) -> f64, samples: usize) -> Vec<f64> {
    let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 1e6, moment_range: 1e6 };
    let robot = Robot::from_modified_dh("arm", &[bracketry_stiffness::DhParameters::default()]);
    let mut compensator = Compensator::new(robot, Springs::linear(&[1e12]), sensor, Payload::none(), settings).unwrap();
    let read = |k: usize| Wrench::new(force(k as f64 * settings.period), 0.0, 0.0, 0.0, 0.0, 0.0);
    (0..samples).map(|k| compensator.step(&[0.0], &read(k), &[0.0]).wrench[0]).collect()
}

#[test]
fn a_steady_change_of_the_wrench_is_predicted_ahead_of_filter_and_lag() {
    let lag = 0.017;
    for order in [FilterOrder::First, FilterOrder::Second] {
        let settings = CompensationSettings { order, lag: Some(lag), ..CompensationSettings::default() };
        let found = filtered(settings, |t| 50.0 * t, 500);
        assert!((found[499] - 50.0 * (499.0 * settings.period + lag)).abs() < 1e-6, "{}", found[499]);
        // Without a lag the filter alone is undone, without a prediction it delays.
        let settings = CompensationSettings { lag: Some(0.0), ..settings };
        assert!((filtered(settings, |t| 50.0 * t, 500)[499] - 50.0 * 499.0 * settings.period).abs() < 1e-6);
        let delayed = filtered(CompensationSettings { lag: None, ..settings }, |t| 50.0 * t, 500)[499];
        assert!(delayed < 50.0 * (499.0 * settings.period - 0.02), "{delayed}");
    }
}

#[test]
fn no_frequency_passes_with_more_than_the_largest_gain() {
    for order in [FilterOrder::First, FilterOrder::Second] {
        let settings = CompensationSettings { order, lag: Some(0.012), ..CompensationSettings::default() };
        let gain = |frequency: f64| {
            let found = filtered(settings, |t| (TAU * frequency * t).sin(), 2000);
            found[1000..].iter().fold(0.0f64, |m, v| m.max(v.abs()))
        };
        let largest =
            [1.0, 2.0, 3.0, 3.6, 4.2, 4.8, 5.5, 7.0, 10.0, 30.0, 100.0].map(gain).into_iter().fold(0.0, f64::max);
        let stated = settings.largest_gain();
        assert!(largest <= stated + 1e-6 && largest > 0.98 * stated && stated > 1.2, "{largest} {stated}");
        assert_eq!(CompensationSettings { lag: None, ..settings }.largest_gain(), 1.0);
        assert!(
            (CompensationSettings { stiffness_error: 0.5, ..settings }.largest_gain() - 0.75 * stated).abs() < 1e-12
        );
    }
}

#[test]
fn an_error_reckoned_with_shortens_the_correction() {
    let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 1000.0, moment_range: 200.0 };
    let q = [0.1, -0.3, 0.9, 0.2, 0.9, 0.3];
    let correction = |stiffness_error: f64| {
        let settings = CompensationSettings { stiffness_error, ..CompensationSettings::default() };
        let springs = Springs::linear(&STIFFNESS);
        let mut compensator = Compensator::new(robot(), springs, sensor, Payload::none(), settings).unwrap();
        let reading = Wrench::new(100.0, -50.0, 80.0, 5.0, 3.0, -4.0);
        (0..500).for_each(|_| {
            compensator.step(&q, &reading, &q);
        });
        compensator.step(&q, &reading, &q).correction.to_vec()
    };
    for (full, less) in correction(0.0).iter().zip(correction(0.3)) {
        assert!((less - 0.91 * full).abs() < 1e-12 && *full != 0.0, "{less} {full}");
    }
}

#[test]
fn a_cutoff_beyond_the_sampling_is_refused() {
    for (cutoff, period) in
        [(125.0, 0.004), (0.0, 0.004), (-1.0, 0.004), (5.0, 0.0), (f64::NAN, 0.004), (5.0, f64::NAN)]
    {
        let refused = WrenchFilter::new(FilterOrder::First, cutoff, period);
        assert!(matches!(refused, Err(CompensationError::Cutoff { .. })), "{cutoff} {period}");
    }
    let message = WrenchFilter::new(FilterOrder::First, 5000.0, 0.004).unwrap_err().to_string();
    assert!(message.contains("125.000 Hz"), "{message}");
}

/// A compensation under load, its filter settled.
fn working(settings: CompensationSettings) -> (Compensator, Vec<f64>, Wrench) {
    let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 1000.0, moment_range: 200.0 };
    let springs = Springs::linear(&STIFFNESS);
    let mut compensator = Compensator::new(robot(), springs, sensor, Payload::none(), settings).unwrap();
    let q = vec![0.1, -0.3, 0.8, 0.2, 0.9, 0.0];
    let reading = Wrench::new(200.0, -100.0, 300.0, 10.0, 20.0, -5.0);
    for _ in 0..300 {
        compensator.step(&q, &reading, &q);
    }
    (compensator, q, reading)
}

#[test]
fn bad_numbers_never_reach_the_command() {
    let (good, q, reading) = working(CompensationSettings::default());
    let held = good.clone().step(&q, &reading, &q).reference.to_vec();
    assert!(held.iter().zip(&q).any(|(c, q)| (c - q).abs() > 1e-4));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..6 {
            let mut compensator = good.clone();
            let (mut spoilt, mut coordinates) = (reading, q.clone());
            spoilt[i] = bad;
            coordinates[i] = bad;
            let mut faults = Vec::new();
            for (measured, reading, reference) in
                [(&q, &spoilt, &q), (&coordinates, &reading, &q), (&q, &reading, &coordinates)]
            {
                let step = compensator.step(measured, reading, reference);
                for (command, held) in step.reference.iter().zip(&held) {
                    assert!((command - held).abs() < 1e-9);
                }
                faults.push((step.status.fault.unwrap(), step.status.held));
            }
            assert_eq!(faults, [(Fault::Reading(i), 1), (Fault::Measured(i), 2), (Fault::Reference(i), 3)]);
            // Nothing of it stays: the next good step is the one that would have been.
            let after = compensator.step(&q, &reading, &q);
            assert!(after.status.is_good() && after.status.held == 0);
            assert_eq!(after.reference, good.clone().step(&q, &reading, &q).reference);
        }
    }
}

#[test]
fn readings_in_other_units_are_out_of_range() {
    let (mut compensator, q, reading) = working(CompensationSettings::default());
    let held = compensator.step(&q, &reading, &q).reference.to_vec();
    let newton_millimeters = Wrench::from_fn(|i, _| reading[i] * if i < 3 { 1.0 } else { 1000.0 });
    let step = compensator.step(&q, &newton_millimeters, &q);
    assert_eq!(step.status.fault, Some(Fault::Range));
    assert_eq!(step.reference, held);
    assert_eq!(compensator.step(&q[..5], &reading, &q).status.fault, Some(Fault::Count));
}

#[test]
fn a_held_correction_goes_with_the_reference() {
    let (mut compensator, q, reading) = working(CompensationSettings::default());
    let correction: Vec<f64> =
        compensator.step(&q, &reading, &q).reference.iter().zip(&q).map(|(c, q)| c - q).collect();
    let moved: Vec<f64> = q.iter().map(|q| q + 0.1).collect();
    let step = compensator.step(&q, &Wrench::repeat(f64::NAN), &moved);
    for i in 0..6 {
        assert!((step.reference[i] - moved[i] - correction[i]).abs() < 1e-15);
    }
}

#[test]
fn limits_hold_and_say_so() {
    let settings = CompensationSettings { correction_limit: 2e-4, rate_limit: 2e-3, ..CompensationSettings::default() };
    let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 1000.0, moment_range: 200.0 };
    let mut random = rng(5);
    let mut compensator =
        Compensator::new(robot(), Springs::linear(&STIFFNESS), sensor, Payload::none(), settings).unwrap();
    let q = coordinates(&mut random);
    let mut last = q.clone();
    let (mut saturated, mut limited) = (0, 0);
    for k in 0..600 {
        let size = if (k / 150) % 2 == 0 { 800.0 } else { 5.0 };
        let f = vector(&mut random, size);
        let step = compensator.step(&q, &Wrench::new(f.x, f.y, size, 0.0, 0.0, 0.0), &q);
        let largest = step.reference.iter().zip(&q).map(|(c, q)| (c - q).abs()).fold(0.0, f64::max);
        let fastest = step.reference.iter().zip(&last).map(|(c, l)| (c - l).abs()).fold(0.0, f64::max);
        assert!(largest <= 2e-4 * (1.0 + 1e-9), "{largest}");
        assert!(fastest <= 2e-3 * 0.004 * (1.0 + 1e-9), "{fastest}");
        assert_eq!(step.status.rate_limited, (fastest - 8e-6).abs() < 1e-15, "{fastest}");
        saturated += usize::from(step.status.saturated);
        limited += usize::from(step.status.rate_limited);
        last = step.reference.to_vec();
    }
    assert!(saturated > 50 && saturated < 550 && limited > 20 && limited < 550, "{saturated} {limited}");
}

#[test]
fn settings_that_are_none_are_refused() {
    let sensor = ForceSensor { pose: Isometry3::identity(), force_range: 1000.0, moment_range: 200.0 };
    let good = CompensationSettings::default();
    let refused = |sensor: ForceSensor, payload: Payload, springs: Springs, settings: CompensationSettings| {
        Compensator::new(robot(), springs, sensor, payload, settings).unwrap_err().to_string()
    };
    let springs = Springs::linear(&STIFFNESS);
    let none = Payload::none();
    let five = refused(sensor, none, Springs::linear(&STIFFNESS[..5]), good);
    assert!(five.contains("5 springs for a robot with 6 joints"), "{five}");
    let mass = refused(sensor, Payload { mass: f64::NAN, ..none }, springs.clone(), good);
    assert!(mass.contains("mass of the payload"), "{mass}");
    let limit = refused(sensor, none, springs.clone(), CompensationSettings { rate_limit: 0.0, ..good });
    assert!(limit.contains("limit of the rate is 0"), "{limit}");
    let lag = refused(sensor, none, springs.clone(), CompensationSettings { lag: Some(-0.01), ..good });
    assert!(lag.contains("lag of the servo is -0.01 s"), "{lag}");
    for share in [-0.1, 1.0, f64::NAN] {
        let share = refused(sensor, none, springs.clone(), CompensationSettings { stiffness_error: share, ..good });
        assert!(share.contains("a fraction from 0 to below 1"), "{share}");
    }
    let range = refused(ForceSensor { force_range: -5.0, ..sensor }, none, springs, good);
    assert!(range.contains("range of force is -5"), "{range}");
}

#[test]
fn the_loop_through_the_process_converges_where_its_gain_is_below_one() {
    let mut random = rng(6);
    let mut seen = [0, 0];
    for _ in 0..400 {
        let matrix = |random: &mut StdRng, size: f64| Matrix6::from_fn(|_, _| uniform(random, size));
        let root = matrix(&mut random, 1e-3);
        let compliance = root * root.transpose();
        let modeled = compliance * (1.0 + uniform(&mut random, 0.3));
        let cutting = vector(&mut random, 1.0) * 10f64.powf(5.5 + uniform(&mut random, 1.5));
        let mut process = Matrix6::zeros();
        process.fixed_view_mut::<3, 3>(0, 0).copy_from(&(cutting * vector(&mut random, 1.0).transpose()));
        let gains = stability(&process, &compliance, &modeled).unwrap();
        // The tool yields at once, the correction comes one step late.
        let yields = (Matrix6::identity() + process * compliance).try_inverse().unwrap();
        let cut = wrench(&mut random);
        let mut load = Wrench::zeros();
        let mut change = 0.0;
        for _ in 0..400 {
            let next = yields * (cut + process * modeled * load);
            change = (next - load).amax();
            load = next;
        }
        // Close to one nothing has been decided after so many steps.
        if (gains.compensation - 1.0).abs() > 0.05 {
            assert_eq!(change < 1.0, gains.compensation < 1.0, "{gains:?} {change}");
            seen[usize::from(gains.compensation < 1.0)] += 1;
        }
        let product = process * compliance;
        // A process of rank one has one gain: the trace.
        assert!((gains.process - product.trace().abs()).abs() < 1e-9 * (1.0 + gains.process));
        assert_eq!(gains.process_holds, 1.0 + product.trace() > 0.0);
    }
    assert!(seen[0] > 10 && seen[1] > 10, "{seen:?}");
}

#[test]
fn inverse_kinematics_finds_the_coordinates_of_a_pose() {
    let mut random = rng(7);
    let robot = robot();
    for _ in 0..50 {
        let q = coordinates(&mut random);
        let near: Vec<f64> = q.iter().map(|q| q + uniform(&mut random, 0.1)).collect();
        let found = robot.inverse(&robot.tool_pose(&q).unwrap(), &near).unwrap();
        for (found, q) in found.iter().zip(&q) {
            assert!((found - q).abs() < 1e-9);
        }
    }
    let far = Isometry3::translation(9.0, 0.0, 0.0);
    let refused = robot.inverse(&far, &coordinates(&mut random)).unwrap_err().to_string();
    assert!(refused.contains("within reach"), "{refused}");
}
