//! `bracketry stiffness` as other programs see it.
#![allow(clippy::unwrap_used)]

mod common;

use std::fmt::Write;
use std::fs;

use bracketry::stiffness::{Deformation, JointSpring, MillingCircle, RobotFile, Springs, Wrench};
use common::{bracketry, code, file, json, model, scratch};

const HEADER: &str = "q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz,dx,dy,dz,rx,ry,rz\n";

/// Displacements of the KR 125 without noise, in some poses; the unit of each group of columns.
fn measurements(poses: usize, units: [f64; 3]) -> String {
    let springs = RobotFile::read(model("kr125.toml")).unwrap().springs.unwrap();
    measured(&springs, poses, units, 0.0)
}

/// The same with other springs and a tool that yields by itself (m/N, rad/(N·m)).
fn measured(springs: &Springs, poses: usize, units: [f64; 3], tool: f64) -> String {
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let mut text = HEADER.to_owned();
    for k in 0..60 {
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

/// The robot file without what is known of its springs.
fn unknown() -> String {
    let text = fs::read_to_string(model("kr125.toml")).unwrap();
    text.lines().filter(|line| !line.starts_with("stiffness")).collect::<Vec<_>>().join("\n")
}

#[test]
fn springs_identified_in_many_poses_go_into_the_robot_file() {
    let dir = scratch("stiffness_identify");
    let data = file(&dir, "data.csv", &measurements(12, [1.0; 3]));
    let robot = file(&dir, "robot.toml", &unknown());
    let out = dir.join("out");
    let v = json(&["stiffness", "identify", &data, &robot, "--json", "--out", out.to_str().unwrap()]);
    assert_eq!((v["trusted"].as_str(), v["measurements"].as_u64()), (Some("joint springs"), Some(60)));
    let identified = RobotFile::read(out.join("identified.toml")).unwrap();
    let published = RobotFile::read(model("kr125.toml")).unwrap();
    for (k, joint) in published.springs.unwrap().joints.iter().enumerate() {
        let JointSpring::Linear { stiffness } = joint else { unreachable!() };
        let value = v["parameters"][k]["value"][0].as_f64().unwrap();
        assert!((value / stiffness - 1.0).abs() < 1e-4, "{value} {stiffness}");
        let written = identified.springs.as_ref().unwrap().joints[k].deflection(100.0);
        assert!((written / joint.deflection(100.0) - 1.0).abs() < 1e-4);
    }
    for name in ["identification.json", "identification.txt", "stiffness.svg", "stiffness.png", "residuals.png"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
}

#[test]
fn springs_that_do_not_explain_the_data_are_not_written() {
    let dir = scratch("stiffness_withheld");
    let springs = RobotFile::read(model("kr125.toml")).unwrap().springs.unwrap();
    for (name, text, exit, said) in [
        ("poses", measured(&springs, 12, [1.0; 3], 2.5e-7), 1, "`gap`"),
        ("tool", measured(&springs, 1, [1.0; 3], 2.5e-7), 0, "predicts better than the springs"),
    ] {
        let data = file(&dir, &format!("{name}.csv"), &text);
        let out = dir.join(name);
        let o = bracketry(&["stiffness", "identify", &data, &model("kr125.toml"), "--out", out.to_str().unwrap()]);
        assert_eq!(code(&o), exit, "{name}");
        assert!(!out.join("identified.toml").exists(), "{name}");
        for message in [String::from_utf8(o.stderr).unwrap(), String::from_utf8(o.stdout).unwrap()] {
            assert!(message.contains(said), "{name}: {message}");
        }
        assert!(fs::read_to_string(out.join("identification.txt")).unwrap().contains("not written"), "{name}");
    }
}

#[test]
fn one_pose_gives_its_compliance() {
    let dir = scratch("stiffness_one_pose");
    let data = file(&dir, "data.csv", &measurements(1, [1.0; 3]));
    let v = json(&["stiffness", "identify", &data, &model("kr125.toml"), "--json"]);
    let c = &v["compliance"];
    for i in 0..6 {
        assert!(c[i][i].as_f64().unwrap() > 0.0);
        for j in 0..6 {
            let (a, b) = (c[i][j].as_f64().unwrap(), c[j][i].as_f64().unwrap());
            assert!((a - b).abs() < 1e-12);
        }
    }
}

#[test]
fn other_units_and_broken_tables_are_refused_with_the_remedy() {
    let dir = scratch("stiffness_units");
    let robot = model("kr125.toml");
    let good = measurements(12, [1.0; 3]);
    let line = good.lines().nth(4).unwrap();
    for (name, text, said) in [
        ("degrees", measurements(12, [57.29578, 1.0, 1.0]), &["looks like degrees", "π/180"][..]),
        ("millimetres", measurements(12, [1.0, 1000.0, 1.0]), &["mm for m"]),
        ("milliradians", measurements(12, [1.0, 1.0, 1000.0]), &["mrad or degrees for rad"]),
        ("lost", good.replace(line, &line.replacen('e', "x", 1)), &["line 5", "not a finite number"]),
        ("column", good.replace("rz", "wz"), &["column rz is missing"]),
        ("joints", format!("q7,{}", good.trim_end().replace('\n', "\n0,")), &["q7", "the robot has 6"]),
        ("twice", format!("{good}{line}\n"), &["equal to row 4"]),
    ] {
        let data = file(&dir, &format!("{name}.csv"), &text);
        let o = bracketry(&["stiffness", "identify", &data, &robot]);
        let message = String::from_utf8(o.stderr.clone()).unwrap();
        assert_eq!(code(&o), 2, "{name}: {message}");
        assert!(message.contains(&format!("{name}.csv")), "{message}");
        for part in said {
            assert_eq!(message.matches(part).count(), 1, "{name}: {message}");
        }
    }
}

/// A log of the milled circle, its entries changed by line and column.
fn log(change: impl Fn(usize, usize, String) -> String) -> String {
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

#[test]
fn a_log_is_compensated_and_what_was_lost_is_held() {
    let dir = scratch("stiffness_compensate");
    let lost = log(|k, c, v| match (k, c) {
        (100..110, 8) => "nan".to_owned(),
        (200..205, 12) => "9000".to_owned(),
        _ => v,
    });
    let path = file(&dir, "log.csv", &lost);
    let out = dir.join("out");
    let v = json(&["stiffness", "compensate", &model("kr125.toml"), &path, "--json", "--out", out.to_str().unwrap()]);
    // About what the simulation of this circle moves without compensation.
    let moved = v["displacement_rms_m"].as_f64().unwrap();
    assert!((6e-4..9e-4).contains(&moved), "{moved}");
    assert_eq!((v["faults"][0]["samples"].as_u64(), v["faults"][1]["samples"].as_u64()), (Some(10), Some(5)));
    assert_eq!(v["faults"][0]["fault"], "no reading of Fy");
    let table = fs::read_to_string(out.join("compensation.csv")).unwrap();
    assert_eq!(table.lines().count() as u64, v["samples"].as_u64().unwrap() + 1);
    assert!(table.starts_with("t,c1,c2,c3,c4,c5,c6,Fx,") && !table.contains("NaN"));
    for name in ["compensation.json", "compensation.txt", "compensation.svg", "compensation.png"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
}

#[test]
fn logs_that_cannot_be_used_are_refused_or_answered_in_the_negative() {
    let dir = scratch("stiffness_logs");
    let robot = model("kr125.toml");
    let degrees =
        |_, c: usize, v: String| if (1..7).contains(&c) { format!("{}", 57.3 * v.parse::<f64>().unwrap()) } else { v };
    let bare = file(&dir, "bare.toml", &unknown());
    for (robot, name, text, exit, said) in [
        (&robot, "degrees", log(degrees), 2, "looks like degrees"),
        (
            &robot,
            "kilo",
            log(|_, c, v| if c >= 7 { format!("{}", 1000.0 * v.parse::<f64>().unwrap()) } else { v }),
            1,
            "mN for N",
        ),
        (
            &robot,
            "milli",
            log(|_, c, v| if c >= 7 { format!("{}", 0.001 * v.parse::<f64>().unwrap()) } else { v }),
            2,
            "kN for N",
        ),
        (
            &robot,
            "milliseconds",
            log(|_, c, v| if c == 0 { format!("{}", 1000.0 * v.parse::<f64>().unwrap()) } else { v }),
            2,
            "if it is in ms",
        ),
        (
            &robot,
            "gap",
            log(|k, c, v| if c == 0 && k > 50 { format!("{}", 1.0 + 0.004 * k as f64) } else { v }),
            2,
            "line 53",
        ),
        (&bare, "bare", log(|_, _, v| v), 2, "no springs"),
        (&robot, "references", format!("r2,{}", log(|_, _, v| v).trim_end().replace('\n', "\n0,")), 2, "r1 is missing"),
        (&robot, "seventh", format!("q7,{}", log(|_, _, v| v).trim_end().replace('\n', "\n0,")), 2, "the robot has 6"),
    ] {
        let path = file(&dir, &format!("{name}.csv"), &text);
        let o = bracketry(&["stiffness", "compensate", robot, &path]);
        let message = String::from_utf8([o.stderr.clone(), o.stdout.clone()].concat()).unwrap();
        assert_eq!(code(&o), exit, "{name}: {message}");
        assert!(message.contains(said), "{name}: {message}");
    }
}
