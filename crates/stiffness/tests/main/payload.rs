//! What a sensor carries, from readings at rest.

use bracketry_stiffness::{Payload, PayloadError, StaticReading, Wrench, identify_payload};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};

/// Gravity for a base that stands on a slope.
fn gravity() -> Vector3<f64> {
    Vector3::new(1.0, -2.0, -9.55)
}

fn payload() -> Payload {
    let bias = Wrench::new(15.0, -22.0, 31.0, 1.5, -0.8, 0.4);
    Payload { mass: 12.4, center: Vector3::new(0.013, -0.021, 0.118), bias }
}

fn turn(x: f64, y: f64, z: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new(Vector3::new(x, y, z))
}

/// Readings from first principles: the weight pulls at the center of mass.
fn readings(
    payload: &Payload,
    orientations: &[UnitQuaternion<f64>],
    noise: f64,
    random: &mut StdRng,
) -> Vec<StaticReading> {
    let read = |orientation: &UnitQuaternion<f64>| {
        let weight = payload.mass * gravity();
        let moment = (orientation * payload.center).cross(&weight);
        let (f, m) = (orientation.inverse() * weight, orientation.inverse() * moment);
        let mut wrench = payload.bias + Wrench::new(f.x, f.y, f.z, m.x, m.y, m.z);
        for i in 0..6 {
            let z: f64 = StandardNormal.sample(random);
            wrench[i] += noise * z * if i < 3 { 1.0 } else { 0.05 };
        }
        StaticReading { orientation: *orientation, wrench }
    };
    orientations.iter().map(read).collect()
}

fn several(count: usize, random: &mut StdRng) -> Vec<UnitQuaternion<f64>> {
    (0..count)
        .map(|_| turn(random.random_range(-1.5..1.5), random.random_range(-1.5..1.5), random.random_range(-1.5..1.5)))
        .collect()
}

#[test]
fn three_orientations_give_mass_center_and_bias() {
    let mut random = StdRng::seed_from_u64(1);
    let orientations = [turn(0.0, 0.0, 0.0), turn(0.6, 0.0, 0.0), turn(0.0, 0.7, 0.0)];
    let found = identify_payload(&readings(&payload(), &orientations, 0.0, &mut random), &gravity()).unwrap().payload;
    assert!((found.mass - 12.4).abs() < 1e-11);
    assert!((found.center - payload().center).amax() < 1e-12);
    assert!((found.bias - payload().bias).amax() < 1e-10);
}

#[test]
fn errors_are_as_large_as_they_are_said_to_be() {
    let mut random = StdRng::seed_from_u64(2);
    let rounds = 400;
    let mut squares = [0.0; 10];
    for _ in 0..rounds {
        let orientations = several(12, &mut random);
        let estimate = identify_payload(&readings(&payload(), &orientations, 0.8, &mut random), &gravity()).unwrap();
        let found = estimate.payload;
        let mut score = vec![(found.mass - 12.4) / estimate.mass_deviation];
        score.extend((found.center - payload().center).component_div(&estimate.center_deviation).iter());
        score.extend((found.bias - payload().bias).component_div(&estimate.bias_deviation).iter());
        for (sum, z) in squares.iter_mut().zip(&score) {
            *sum += z * z / rounds as f64;
        }
    }
    // Each score has variance 1 but for few degrees of freedom; that of the center is a bound.
    for (i, mean) in squares.iter().enumerate() {
        let least = if (1..4).contains(&i) { 0.3 } else { 0.8 };
        assert!(*mean > least && *mean < 1.3, "{i}: {squares:?}");
    }
}

#[test]
fn the_reading_that_does_not_fit_is_named() {
    let mut random = StdRng::seed_from_u64(3);
    let mut given = readings(&payload(), &several(10, &mut random), 0.1, &mut random);
    given[6].wrench[1] += 30.0;
    assert_eq!(identify_payload(&given, &gravity()).unwrap().worst, 7);
}

#[test]
fn readings_that_leave_something_open_are_refused_by_name() {
    let mut random = StdRng::seed_from_u64(4);
    let mut refused = |orientations: &[UnitQuaternion<f64>]| {
        identify_payload(&readings(&payload(), orientations, 0.1, &mut random), &gravity()).unwrap_err()
    };
    assert!(matches!(refused(&[]), PayloadError::OneOrientation { readings: 0, .. }));
    // Turned about gravity: the weight pulls the same way in the sensor.
    let axis = nalgebra::Unit::new_normalize(gravity());
    let about: Vec<_> = (0..6).map(|k| UnitQuaternion::from_axis_angle(&axis, k as f64)).collect();
    let message = refused(&about).to_string();
    assert!(message.contains("mass and force bias cannot be separated"), "{message}");
    let two = [turn(0.0, 0.0, 0.0), turn(0.8, 0.0, 0.0), turn(0.0, 0.0, 0.0), turn(0.8, 0.0, 0.0)];
    let error = refused(&two);
    let PayloadError::OneDirection { readings: 4, direction } = &error else { unreachable!("{error}") };
    // The direction is that in which the weight moved between the two.
    let moved = turn(0.8, 0.0, 0.0).inverse() * gravity() - gravity();
    assert!(Vector3::from(*direction).cross(&moved.normalize()).norm() < 1e-9);
}

#[test]
fn impossible_numbers_are_refused_with_the_reason() {
    let mut random = StdRng::seed_from_u64(5);
    let orientations = several(8, &mut random);
    let good = readings(&payload(), &orientations, 0.1, &mut random);
    let changed = |change: &dyn Fn(&mut Wrench)| {
        let mut readings = good.clone();
        for r in &mut readings {
            change(&mut r.wrench);
        }
        identify_payload(&readings, &gravity()).unwrap_err().to_string()
    };
    let millimeters = changed(&|w| w.fixed_rows_mut::<3>(3).scale_mut(1000.0));
    assert!(millimeters.contains("N·mm"), "{millimeters}");
    let millinewtons = changed(&|w| w.scale_mut(1000.0));
    assert!(millinewtons.contains("forces in N"), "{millinewtons}");
    let turned = changed(&|w| w.neg_mut());
    assert!(turned.contains("change all signs"), "{turned}");
    let mut spoilt = good.clone();
    spoilt[4].wrench[3] = f64::NAN;
    let message = identify_payload(&spoilt, &gravity()).unwrap_err().to_string();
    assert!(message.contains("reading 5") && message.contains("entry 4"), "{message}");
    let light = readings(&Payload { mass: 0.0, ..payload() }, &orientations, 0.5, &mut random);
    assert!(matches!(
        identify_payload(&light, &gravity()),
        Err(PayloadError::NoWeight { .. } | PayloadError::PullsUp { .. })
    ));
    assert!(matches!(identify_payload(&good, &Vector3::zeros()), Err(PayloadError::Gravity(_))));
}
