//! Robots, their logs, and measurements of their deformation.

use std::fmt::Write;
use std::fs;

use bracketry::stiffness::{Deformation, MillingCircle, RobotFile, Springs, Wrench};

use super::model;

/// The columns of a table of measurements.
pub(crate) const HEADER: &str = "q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz,dx,dy,dz,rx,ry,rz\n";

/// Displacements of the KR 125 without noise, in some poses; the unit of each group of columns.
pub(crate) fn measurements(poses: usize, units: [f64; 3]) -> String {
    let springs = RobotFile::read(model("kr125.toml")).unwrap().springs.unwrap();
    measured(&springs, poses, units, 0.0)
}

/// The same with other springs and a tool that yields by itself (m/N, rad/(N·m)).
pub(crate) fn measured(springs: &Springs, poses: usize, units: [f64; 3], tool: f64) -> String {
    measured_at(springs, poses, 60, units, tool)
}

/// The same with another number of rows.
pub(crate) fn measured_at(springs: &Springs, poses: usize, count: usize, units: [f64; 3], tool: f64) -> String {
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let mut text = HEADER.to_owned();
    for k in 0..count {
        let wave = |frequency: f64| (1.0 + frequency * k as f64).sin();
        let pose = (k % poses) as f64;
        let q: Vec<f64> =
            (0..6).map(|i| [0.2, -0.4, 0.6, 0.3, 0.8, 0.1][i] + 0.5 * (pose * (i as f64 + 1.3)).sin()).collect();
        let load = Wrench::new(
            800.0 * wave(0.7),
            800.0 * wave(1.9),
            800.0 * wave(2.3),
            50.0 * wave(3.1),
            50.0 * wave(4.7),
            50.0 * wave(5.3),
        );
        let moved = Deformation::equilibrium(&robot.robot, springs, &q, &load).unwrap().tool;
        let moved = moved + tool * load;
        let columns = q
            .iter()
            .map(|v| v * units[0])
            .chain(load.iter().copied())
            .chain(moved.iter().enumerate().map(|(i, v)| v * if i < 3 { units[1] } else { units[2] }));
        let columns: Vec<String> = columns.map(|v| format!("{v:e}")).collect();
        writeln!(text, "{}", columns.join(",")).unwrap();
    }
    text
}

/// A log of the milled circle, its entries changed by line and column.
pub(crate) fn log(change: impl Fn(usize, usize, String) -> String) -> String {
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let circle = MillingCircle { feed: 0.15, ..MillingCircle::default() };
    let path = circle.path(&robot.robot, &[0.0, -0.3, 0.9, 0.0, 0.9, 0.0]).unwrap();
    let run = circle.mill(&robot.robot, &path, &robot.springs.unwrap(), None).unwrap();
    let mut text = "t,q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz\n".to_owned();
    for (k, s) in run.samples.iter().enumerate() {
        let values = [k as f64 * circle.period]
            .into_iter()
            .chain(s.coordinates.iter().copied())
            .chain(s.reading.iter().copied());
        let values: Vec<String> = values.enumerate().map(|(c, v)| change(k, c, format!("{v}"))).collect();
        writeln!(text, "{}", values.join(",")).unwrap();
    }
    text
}

/// The robot file without what is known of its springs.
pub(crate) fn unknown() -> String {
    let text = fs::read_to_string(model("kr125.toml")).unwrap();
    text.lines().filter(|line| !line.starts_with("stiffness")).collect::<Vec<_>>().join("\n")
}
