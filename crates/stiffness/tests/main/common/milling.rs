//! A milling robot and its circle.

use bracketry_stiffness::{CompensationSettings, Compensator, MillingCircle, Robot, RobotFile, Springs};
use rand::{RngExt, rngs::StdRng};
use std::path::Path;

/// The robot file that comes with the models.
pub(crate) const KR125: &str = include_str!("../../../../../models/kr125.toml");

/// KUKA KR 125 with a spindle.
pub(crate) fn robot() -> Robot {
    RobotFile::parse("kr125.toml", KR125, Path::new("")).unwrap().robot
}

/// Near the coordinates of the circle.
pub(crate) const START: [f64; 6] = [0.0, -0.3, 0.9, 0.0, 0.9, 0.0];

/// The circle with another noise.
pub(crate) fn circle(seed: u64) -> MillingCircle {
    MillingCircle { seed, ..MillingCircle::default() }
}

/// The circle with its sensor weighed out, and a compensation that believes in `springs`.
pub(crate) fn compensator(circle: &MillingCircle, robot: &Robot, springs: Springs) -> Compensator {
    compensator_with(circle, robot, springs, CompensationSettings::default())
}

/// The same with other settings than those by default, at the circle's period.
pub(crate) fn compensator_with(
    circle: &MillingCircle,
    robot: &Robot,
    springs: Springs,
    settings: CompensationSettings,
) -> Compensator {
    let poses: Vec<Vec<f64>> = [[0.0, 0.9, 0.0], [0.8, 0.3, 0.5], [-0.8, 1.4, -0.5], [1.5, 0.9, 1.5], [-1.5, 1.2, 0.7]]
        .iter()
        .map(|wrist| START[..3].iter().chain(wrist).copied().collect())
        .collect();
    let payload = circle.weigh(robot, &poses, 250).unwrap().payload;
    let settings = CompensationSettings { period: circle.period, ..settings };
    Compensator::new(robot.clone(), springs, circle.sensor, payload, settings).unwrap()
}

/// Springs whose stiffnesses are wrong by at most a share, at random per joint.
pub(crate) fn wrong(springs: &Springs, share: f64, random: &mut StdRng) -> Springs {
    let factors: Vec<f64> = springs.joints.iter().map(|_| 1.0 + share * random.random_range(-1.0..1.0)).collect();
    springs.scaled(&factors)
}
