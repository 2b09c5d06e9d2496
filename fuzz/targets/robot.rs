//! A robot file, or a URDF description where the text begins with `<`; the robot is put into a pose.

#![no_main]

use std::path::Path;

use bracketry_stiffness::{Kinematics, Robot, RobotFile, with_springs};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let robot = if text.starts_with('<') {
        Robot::from_urdf(text, None, None).ok()
    } else if text.contains("urdf") {
        // Would read a file of any name.
        None
    } else {
        RobotFile::parse("robot.toml", text, Path::new("")).ok().map(|file| {
            if let Some(springs) = &file.springs {
                let _ = with_springs("robot.toml", text, springs);
            }
            file.robot
        })
    };
    if let Some(robot) = robot {
        let _ = Kinematics::new(&robot, &vec![0.3; robot.joints.len()]);
    }
});
