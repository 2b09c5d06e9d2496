//! Robots and their logs.

use std::fmt::Write;
use std::fs;

use bracketry::stiffness::{MillingCircle, RobotFile};

use super::model;

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
