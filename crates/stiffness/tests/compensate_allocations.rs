//! What a step of the compensation allocates: nothing. A program of its own, because its global allocator counts.
#![allow(clippy::unwrap_used)]

#[path = "main/common/mod.rs"]
#[allow(dead_code, unused_imports)]
mod common;

use allocation_counter::measure;
use bracketry_stiffness::{CompensationSettings, Compensator, ForceSensor, JointSpring, Payload, Springs, Wrench};
use common::STIFFNESS;
use common::milling::robot;
use nalgebra::{Isometry3, Matrix6, Vector3};

#[test]
fn a_step_allocates_nothing() {
    let sensor = ForceSensor { pose: Isometry3::translation(0.0, 0.1, -0.2), force_range: 1000.0, moment_range: 200.0 };
    let payload = Payload { mass: 12.0, center: Vector3::new(0.0, 0.0, 0.1), bias: Wrench::repeat(3.0) };
    let nonlinear = STIFFNESS.map(|stiffness| JointSpring::Stiffening { stiffness, cubic: 1e10 });
    for springs in [
        Springs::linear(&STIFFNESS),
        Springs::of_joints(nonlinear.to_vec()),
        Springs::linear(&STIFFNESS).with_links(vec![Matrix6::identity() * 1e-7; 6]),
    ] {
        let settings = CompensationSettings {
            correction_limit: 5e-4,
            lag: Some(0.012),
            stiffness_error: 0.3,
            ..CompensationSettings::default()
        };
        let mut compensator = Compensator::new(robot(), springs, sensor, payload, settings).unwrap();
        let q = [0.1, -0.3, 0.8, 0.2, 0.9, 0.0];
        let mut moved = 0.0f64;
        let allocated = measure(|| {
            for k in 0..500 {
                // Every seventh reading is lost, every eleventh is an overload.
                let size = if k % 7 == 6 { f64::NAN } else { 1.0 };
                let reading = Wrench::new(100.0, -50.0, 200.0, 5.0, 7.0, -2.0) * if k % 11 == 10 { 1e3 } else { size };
                moved = moved.max((compensator.step(&q, &reading, &q).reference[1] - q[1]).abs());
            }
        });
        assert!(moved > 1e-5);
        assert_eq!(allocated.count_total, 0);
    }
}
