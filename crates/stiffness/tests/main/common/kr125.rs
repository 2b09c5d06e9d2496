//! KUKA KR 125 without a tool, the robot of the reference figures: shared by tests, bench and example.
#![allow(dead_code)]

use bracketry_stiffness::{DhParameters, Robot};

/// Stiffnesses of the joints (N·m/rad).
pub(crate) const STIFFNESS: [f64; 6] = [1_409_800.0, 400_760.0, 935_280.0, 360_000.0, 370_000.0, 380_000.0];

/// The robot from its modified Denavit–Hartenberg parameters.
pub(crate) fn kr125() -> Robot {
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
    Robot::from_modified_dh("KR 125", &rows)
}

/// The coordinates of the reference figures (rad).
pub(crate) fn pose() -> Vec<f64> {
    [20.0f64, -25.0, 40.0, 30.0, 45.0, 10.0].iter().map(|q| q.to_radians()).collect()
}
