//! A milling robot and its circle.
#![allow(dead_code)]

use bracketry_stiffness::{
    CompensationSettings, Compensator, Cutting, DhParameters, ForceSensor, JointSpring, MillingCircle, Payload, Robot,
    Springs, Wrench,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// Stiffnesses of the joints of the KR 125 (N·m/rad).
pub(crate) const STIFFNESS: [f64; 6] = [1_409_800.0, 400_760.0, 935_280.0, 360_000.0, 370_000.0, 380_000.0];

/// KUKA KR 125 with a spindle.
pub(crate) fn robot() -> Robot {
    let row = |alpha: f64, a: f64, d: f64, offset: f64| DhParameters {
        alpha: alpha.to_radians(),
        a,
        d,
        offset: offset.to_radians(),
    };
    let rows = [
        row(0.0, 0.0, 0.75, 0.0),
        row(-90.0, 0.35, 0.0, -90.0),
        row(0.0, 1.25, 0.0, 0.0),
        row(-90.0, -0.055, 1.1, 0.0),
        row(90.0, 0.0, 0.0, 0.0),
        row(-90.0, 0.0, 0.23, 0.0),
    ];
    Robot::from_modified_dh("KR 125", &rows).with_tool(Isometry3::translation(0.0, 0.0, 0.3))
}

/// Near the coordinates of the circle.
pub(crate) const START: [f64; 6] = [0.0, -0.3, 0.9, 0.0, 0.9, 0.0];

/// A circle of radius 35 mm on a horizontal plane, the spindle pointing down.
pub(crate) fn circle(seed: u64) -> MillingCircle {
    MillingCircle {
        centre: Isometry3::from_parts(
            Translation3::new(1.5, 0.0, 0.9),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI),
        ),
        radius: 0.035,
        feed: 0.03,
        run_in: 0.8,
        period: 0.004,
        lag: 0.012,
        cutting: Cutting {
            depth: 0.004,
            radial: 0.5e5,
            tangential: 0.75e5,
            axial: 0.15e5,
            ripple: 0.08,
            ripple_frequency: 97.0,
        },
        sensor: ForceSensor { pose: Isometry3::translation(0.0, 0.0, -0.25), force_range: 2000.0, moment_range: 500.0 },
        payload: Payload {
            mass: 12.0,
            centre: Vector3::new(0.01, -0.02, 0.12),
            bias: Wrench::new(15.0, -22.0, 31.0, 1.5, -0.8, 0.4),
        },
        gravity: Vector3::new(0.0, 0.0, -9.81),
        noise: [2.0, 0.1],
        seed,
    }
}

/// The circle with its sensor weighed out, and a compensation that believes in `springs`.
pub(crate) fn compensator(circle: &MillingCircle, robot: &Robot, springs: Springs) -> Compensator {
    let poses: Vec<Vec<f64>> = [[0.0, 0.9, 0.0], [0.8, 0.3, 0.5], [-0.8, 1.4, -0.5], [1.5, 0.9, 1.5], [-1.5, 1.2, 0.7]]
        .iter()
        .map(|wrist| START[..3].iter().chain(wrist).copied().collect())
        .collect();
    let payload = circle.weigh(robot, &poses, 250).unwrap().payload;
    let settings = CompensationSettings { period: circle.period, ..CompensationSettings::default() };
    Compensator::new(robot.clone(), springs, circle.sensor, payload, settings).unwrap()
}

/// Springs whose stiffnesses are wrong by at most a share, at random per joint.
pub(crate) fn wrong(springs: &Springs, share: f64, random: &mut StdRng) -> Springs {
    let mut wrong = springs.clone();
    for spring in &mut wrong.joints {
        let factor = 1.0 + share * random.random_range(-1.0..1.0);
        match spring {
            JointSpring::Linear { stiffness }
            | JointSpring::Stiffening { stiffness, .. }
            | JointSpring::Backlash { stiffness, .. } => *stiffness *= factor,
        }
    }
    wrong
}

pub(crate) fn random(seed: u64) -> StdRng {
    StdRng::seed_from_u64(seed)
}
