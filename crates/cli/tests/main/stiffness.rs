//! `bracketry stiffness` as other programs see it.

use std::fmt::Write;
use std::fs;

use crate::common::pages::assert_page;
use crate::common::{
    bracketry, code, file, json, model,
    robots::{HEADER, log, measured, measured_at, measurements, unknown},
    scratch,
};
use bracketry::stiffness::{Deformation, JointSpring, RobotFile, Wrench};

/// A table whose numbers are changed by row and column.
fn edited(table: &str, change: impl Fn(usize, usize, f64) -> f64) -> String {
    let mut text = HEADER.to_owned();
    for (k, line) in table.lines().skip(1).enumerate() {
        let numbers = line.split(',').map(|v| v.parse().unwrap());
        let changed: Vec<String> = numbers.enumerate().map(|(c, v)| format!("{:e}", change(k, c, v))).collect();
        writeln!(text, "{}", changed.join(",")).unwrap();
    }
    text
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
        ("tool", measured(&springs, 1, [1.0; 3], 2.5e-7), 0, "predicts better than the joint springs"),
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
fn the_report_has_condition_fit_and_intervals() {
    let dir = scratch("stiffness_intervals");
    let data = file(&dir, "data.csv", &measurements(1, [1.0; 3]));
    let v = json(&["stiffness", "identify", &data, &model("kr125.toml"), "--json"]);
    for method in v["methods"].as_array().unwrap() {
        // Measured without noise.
        assert!(method["condition"].as_f64().unwrap() >= 1.0, "{method}");
        assert!((0.0..1.0).contains(&method["chi_square"].as_f64().unwrap()), "{method}");
    }
    let number = |name: &str, i: usize, j: usize| v[name][i][j].as_f64().unwrap();
    for i in 0..6 {
        for j in 0..6 {
            for name in ["compliance", "stiffness"] {
                let interval = &v[format!("{name}_interval")][i][j];
                let (low, high) = (interval[0].as_f64().unwrap(), interval[1].as_f64().unwrap());
                assert!(low < number(name, i, j) && number(name, i, j) < high, "{name} {i} {j}");
            }
            let product: f64 = (0..6).map(|k| number("compliance", i, k) * number("stiffness", k, j)).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-6, "{product}");
        }
    }
    let out = dir.join("out");
    let o = bracketry(&["stiffness", "identify", &data, &model("kr125.toml"), "--out", out.to_str().unwrap()]);
    let text = String::from_utf8(o.stdout).unwrap();
    let page = fs::read_to_string(out.join("identification.md")).unwrap();
    for part in ["| joint springs |", "| 1 | stiffness | 1.4098e6 |", "## Compliance", "## Stiffness [", "| Mz |"] {
        assert!(page.contains(part), "{part}: {page}");
    }
    // The tables have as many columns in each row as in their header.
    for block in page.split("\n\n").filter(|block| block.starts_with('|')) {
        let columns: Vec<usize> = block.lines().map(|line| line.matches('|').count()).collect();
        assert!(columns.iter().all(|count| *count == columns[0]), "{block}");
    }
    for part in
        ["condition", "χ²/dof", "stiffness, its inverse", " ± ", "times the stated noise", "nothing remains to be"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn figures_show_joints_that_are_not_identified_and_what_was_left_out() {
    let dir = scratch("stiffness_marks");
    // Forces alone never turn the last joint, whose axis runs through the tool point.
    let forces =
        |k: usize, c: usize, v: f64| if (9..12).contains(&c) { 1e-3 * (1.0 + (k + c) as f64).sin() } else { v };
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let springs = robot.springs.clone().unwrap();
    let mut text = HEADER.to_owned();
    for line in edited(&measurements(12, [1.0; 3]), forces).lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let moved = Deformation::equilibrium(&robot.robot, &springs, &row[..6], &Wrench::from_row_slice(&row[6..12]));
        let row: Vec<String> = row[..12].iter().chain(moved.unwrap().tool.iter()).map(|v| format!("{v:e}")).collect();
        writeln!(text, "{}", row.join(",")).unwrap();
    }
    // A displacement that contradicts the rest.
    let text = edited(&text, |k, c, v| if k == 20 && c == 12 { v + 4e-3 } else { v });
    let (data, out) = (file(&dir, "data.csv", &text), dir.join("out"));
    let o = bracketry(&["stiffness", "identify", &data, &model("kr125.toml"), "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 1);
    let drawn = fs::read_to_string(out.join("stiffness.svg")).unwrap();
    assert!(drawn.contains("joint 6: not identified") && drawn.contains("joint 5"), "{drawn}");
    assert!(fs::read_to_string(out.join("identification.txt")).unwrap().contains("outliers: lines 22"));

    let spoiled = edited(&measurements(12, [1.0; 3]), |k, c, v| if k == 20 && c == 12 { v + 4e-3 } else { v });
    let (data, out) = (file(&dir, "spoiled.csv", &spoiled), dir.join("spoiled"));
    let v = json(&["stiffness", "identify", &data, &model("kr125.toml"), "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(v["outliers"], serde_json::json!([22]));
    let drawn = fs::read_to_string(out.join("residuals.svg")).unwrap();
    assert!(drawn.contains("excluded as outlier (outside the axes: drawn at the edge)"), "{drawn}");
    // Nothing to mark, nothing in the legend.
    let (data, out) = (file(&dir, "good.csv", &measurements(12, [1.0; 3])), dir.join("good"));
    json(&["stiffness", "identify", &data, &model("kr125.toml"), "--json", "--out", out.to_str().unwrap()]);
    assert!(!fs::read_to_string(out.join("residuals.svg")).unwrap().contains("outlier"));
    assert!(!fs::read_to_string(out.join("stiffness.svg")).unwrap().contains("not identified"));
}

#[test]
fn lost_motion_is_named_and_identified_from_what_the_report_says() {
    let dir = scratch("stiffness_lost_motion");
    let mut springs = RobotFile::read(model("kr125.toml")).unwrap().springs.unwrap();
    springs.joints[0] = JointSpring::Backlash { stiffness: 1_409_800.0, gap: 3e-4, engaged: 200.0 };
    let data = file(&dir, "data.csv", &measured_at(&springs, 12, 150, [1.0; 3], 0.0));
    let o = bracketry(&["stiffness", "identify", &data, &model("kr125.toml"), "--json"]);
    assert_eq!(code(&o), 1, "{}", String::from_utf8_lossy(&o.stderr));
    let v: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
    let rest = &v["unexplained"];
    assert!(rest["share"].as_f64().unwrap() > 0.005, "{rest}");
    assert!(v["withheld"].as_str().unwrap().starts_with("lost motion in joints explains"), "{v}");
    let found = rest["lost_motion"].as_array().unwrap();
    assert_eq!((found.len(), found[0]["joint"].as_u64()), (1, Some(1)), "{rest}");
    let (gap, engaged) = (found[0]["gap"].as_f64().unwrap(), found[0]["engaged"].as_f64().unwrap());
    assert!((gap / 3e-4 - 1.0).abs() < 0.3 && (engaged / 200.0 - 1.0).abs() < 0.5, "{gap} {engaged}");
    // With them to start from the fit finds what it was.
    let text = fs::read_to_string(model("kr125.toml")).unwrap();
    let text = text.replacen("1_409_800.0 ", &format!("1_409_800.0\ngap = {gap:.2e}\nengaged = {engaged:.1}\n# "), 1);
    let robot = file(&dir, "robot.toml", &text);
    let v = json(&["stiffness", "identify", &data, &robot, "--json"]);
    let value = |k: usize| v["parameters"][k]["value"][0].as_f64().unwrap();
    assert!((value(1) / 3e-4 - 1.0).abs() < 0.01 && (value(2) / 200.0 - 1.0).abs() < 0.01, "{} {}", value(1), value(2));
    assert_eq!(v["unexplained"]["share"], 0.0);
    // So much of it that most measurements contradict linear springs: they are no outliers, and are not refused for it.
    for i in [0, 4] {
        springs.joints[i] = JointSpring::Backlash { stiffness: 1e6, gap: 2e-3, engaged: 20.0 };
    }
    let data = file(&dir, "much.csv", &measured_at(&springs, 12, 150, [1.0; 3], 0.0));
    let o = bracketry(&["stiffness", "identify", &data, &model("kr125.toml"), "--json"]);
    assert_eq!(code(&o), 1, "{}", String::from_utf8_lossy(&o.stderr));
    let v: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
    assert!(v["outliers_kept"].as_str().unwrap().contains("too many to be outliers"), "{v}");
    assert!(v["withheld"].as_str().unwrap().starts_with("lost motion in joints explains"), "{v}");
    let found = v["unexplained"]["lost_motion"].as_array().unwrap();
    let mut joints: Vec<u64> = found.iter().map(|lost| lost["joint"].as_u64().unwrap()).collect();
    joints.sort_unstable();
    assert_eq!(joints, [1, 5], "{v}");
}

#[test]
fn links_of_the_robot_file_yield_and_stay_in_it() {
    let dir = scratch("stiffness_links");
    let with_links = |text: String| {
        let link = "link_compliance = [3e-8, 2e-8, 1e-8, 2e-7, 3e-7, 0]";
        text.replace("[[joint]]", &format!("[[joint]]\n{link}\nstiffness = 1e6"))
    };
    // The springs to start from are those of no joint.
    let robot = file(&dir, "robot.toml", &with_links(unknown()));
    let links = RobotFile::read(&robot).unwrap().springs.unwrap().links;
    let truth = RobotFile::read(model("kr125.toml")).unwrap().springs.unwrap();
    let data = file(&dir, "data.csv", &measured(&truth.clone().with_links(links.clone()), 12, [1.0; 3], 0.0));
    let out = dir.join("out");
    json(&["stiffness", "identify", &data, &robot, "--json", "--out", out.to_str().unwrap()]);
    let found = RobotFile::read(out.join("identified.toml")).unwrap().springs.unwrap();
    assert_eq!(found.links, links);
    for (found, truth) in found.joints.iter().zip(&truth.joints) {
        assert!((found.deflection(100.0) / truth.deflection(100.0) - 1.0).abs() < 1e-4);
    }
    // Without them the springs of the joints do not explain what was measured.
    let bare = file(&dir, "bare.toml", &unknown());
    assert_eq!(code(&bracketry(&["stiffness", "identify", &data, &bare])), 1);
    // The compensation reckons with them.
    let log = file(&dir, "log.csv", &log(|_, _, v| v));
    let moved =
        |robot: &str| json(&["stiffness", "compensate", &log, robot, "--json"])["displacement_rms_m"].as_f64().unwrap();
    let identified = out.join("identified.toml");
    assert!(moved(identified.to_str().unwrap()) > 1.02 * moved(&model("kr125.toml")));
}

#[test]
fn poses_are_chosen_from_those_that_can_be_reached() {
    let dir = scratch("stiffness_poses");
    let table = measurements(12, [1.0; 3]);
    let candidates: Vec<String> =
        table.lines().map(|line| line.split(',').take(12).collect::<Vec<_>>().join(",")).collect();
    let candidates = file(&dir, "candidates.csv", &(candidates.join("\n") + "\n"));
    let (robot, out) = (model("kr125.toml"), dir.join("out"));
    let v =
        json(&["stiffness", "poses", &candidates, &robot, "--count", "8", "--json", "--out", out.to_str().unwrap()]);
    assert_eq!((v["lines"].as_array().unwrap().len(), v["candidates"].as_u64()), (8, Some(60)));
    for k in 0..6 {
        // What is measured more often is known better.
        let [some, all] = ["chosen", "all"].map(|of| v[of]["errors"][k].as_f64().unwrap());
        assert!(all < some && some < 0.3, "{some} {all}");
    }
    let chosen = fs::read_to_string(out.join("poses.csv")).unwrap();
    assert!(chosen.starts_with("q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz\n") && chosen.lines().count() == 9);
    for (count, exit) in [("1", 1), ("61", 2), ("0", 2)] {
        let o = bracketry(&["stiffness", "poses", &candidates, &robot, "--count", count]);
        assert_eq!(code(&o), exit, "{count}: {}", String::from_utf8_lossy(&o.stderr));
    }
}

#[test]
fn the_payload_is_weighed_from_readings_at_rest() {
    let dir = scratch("stiffness_weigh");
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let (sensor, gravity) = (robot.sensor.unwrap(), robot.compensation.gravity);
    let readings = |wrists: &[[f64; 3]], scale: f64| {
        let mut text = "q1,q2,q3,q4,q5,q6,Fx,Fy,Fz,Mx,My,Mz\n".to_owned();
        for wrist in wrists {
            let q: Vec<f64> = [0.0, -0.3, 0.9].iter().chain(wrist).copied().collect();
            let orientation = (robot.robot.tool_pose(&q).unwrap() * sensor.pose).rotation;
            let reading = robot.payload.reading(&orientation, &gravity) * scale;
            let row: Vec<String> = q.iter().chain(reading.iter()).map(|v| format!("{v:e}")).collect();
            writeln!(text, "{}", row.join(",")).unwrap();
        }
        text
    };
    let wrists = [[0.0, 0.9, 0.0], [0.8, 0.3, 0.5], [-0.8, 1.4, -0.5], [1.5, 0.9, 1.5]];
    let (data, out) = (file(&dir, "rest.csv", &readings(&wrists, 1.0)), dir.join("out"));
    let v = json(&["stiffness", "weigh", &data, &model("kr125.toml"), "--json", "--out", out.to_str().unwrap()]);
    assert!((v["mass"][0].as_f64().unwrap() - 12.0).abs() < 1e-6);
    assert_page(&fs::read_to_string(out.join("weighing.html")).unwrap(), Some(&out));
    // What it writes is what the robot file had.
    let text = fs::read_to_string(model("kr125.toml")).unwrap();
    let (before, after) = (text.find("[payload]").unwrap(), text.find("[noise]").unwrap());
    let written = fs::read_to_string(out.join("payload.toml")).unwrap();
    let again = file(&dir, "again.toml", &format!("{}{written}\n{}", &text[..before], &text[after..]));
    assert_eq!(RobotFile::read(&again).unwrap().payload, robot.payload);
    for (name, text, said, exit) in [
        ("one", readings(&wrists[..1], 1.0), "cannot be separated", 1),
        ("sign", readings(&wrists, -1.0), "change all signs", 2),
    ] {
        let data = file(&dir, &format!("{name}.csv"), &text);
        let o = bracketry(&["stiffness", "weigh", &data, &model("kr125.toml")]);
        let message = String::from_utf8(o.stderr.clone()).unwrap();
        assert!(code(&o) == exit && message.contains(said) && message.contains(&format!("{name}.csv")), "{message}");
    }
}

#[test]
fn the_robot_file_may_come_first_or_last() {
    let dir = scratch("stiffness_order");
    let (robot, log) = (model("kr125.toml"), file(&dir, "log.csv", &log(|_, _, v| v)));
    let either = [[&log, &robot], [&robot, &log]].map(|[a, b]| json(&["stiffness", "compensate", a, b, "--json"]));
    assert_eq!(either[0], either[1]);
    for (files, said) in [([&log, &log], "neither"), ([&robot, &robot], "both")] {
        let o = bracketry(&["stiffness", "compensate", files[0], files[1]]);
        let message = String::from_utf8(o.stderr.clone()).unwrap();
        assert!(code(&o) == 2 && message.contains(said) && message.contains("DATA.csv ROBOT.toml"), "{message}");
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
        ("millimeters", measurements(12, [1.0, 1000.0, 1.0]), &["mm for m"]),
        ("milliradians", measurements(12, [1.0, 1.0, 1000.0]), &["mrad or degrees for rad"]),
        ("lost", good.replace(line, &line.replacen('e', "x", 1)), &["line 5", "not a finite number"]),
        ("column", good.replace("rz", "wz"), &["column rz is missing"]),
        ("joints", format!("q7,{}", good.trim_end().replace('\n', "\n0,")), &["q7", "the robot has 6"]),
        ("twice", format!("{good}{line}\n"), &["line 62 equals line 5 in every digit"]),
        ("kilonewton meters", edited(&good, |_, c, v| if (9..12).contains(&c) { 1e-3 * v } else { v }), &["by 1000"]),
        ("rotations", edited(&good, |_, c, v| if c >= 15 { -v } else { v }), &["the sign of rx, ry, rz"]),
        ("moments", edited(&good, |_, c, v| if (9..12).contains(&c) { -v } else { v }), &["the sign of Mx, My, Mz"]),
        ("unmeasured", edited(&good, |_, c, v| if c >= 15 { 0.0 } else { v }), &["all rotations are exactly 0"]),
        ("unmoved", edited(&good, |k, c, v| if k == 9 && c >= 12 { 0.0 } else { v }), &["line 11: a displacement of"]),
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
