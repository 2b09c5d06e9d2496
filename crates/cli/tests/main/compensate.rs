//! `bracketry stiffness compensate` as other programs see it.

use std::fs;

use crate::common::{
    bracketry, code, file, json, model,
    robots::{log, unknown},
    scratch,
};
use bracketry::report::stiffness::text;
use bracketry::stiffness::{CompensatedLog, Fault, RobotFile, RobotLog};

#[test]
fn a_process_that_the_compensation_would_drive_up_is_named() {
    let dir = scratch("stiffness_process");
    let (robot, log) = (model("kr125.toml"), file(&dir, "log.csv", &log(|_, _, v| v)));
    let run = |stiffness: &str| bracketry(&["stiffness", "compensate", &log, &robot, "--process-stiffness", stiffness]);
    for (stiffness, exit, said) in [
        ("5e4", 0, "stable with any lag"),
        ("5e4,5e4,1e4", 0, "stable with any lag"),
        ("2e6", 1, "may become unstable"),
        ("5e4,5e4", 2, "2 numbers for --process-stiffness"),
        ("-1", 2, "50 N/mm is 5e4"),
    ] {
        let o = run(stiffness);
        let message = String::from_utf8([o.stdout.clone(), o.stderr.clone()].concat()).unwrap();
        assert!(code(&o) == exit && message.contains(said), "{stiffness}: {message}");
    }
}

#[test]
fn a_correction_is_held_where_coordinates_are_lost() {
    let dir = scratch("stiffness_held");
    let lost = log(|k, c, v| if (100..110).contains(&k) && c == 3 { String::new() } else { v });
    let robot = RobotFile::read(model("kr125.toml")).unwrap();
    let read = RobotLog::read(std::path::Path::new(&file(&dir, "log.csv", &lost)), &robot.robot).unwrap();
    let run = CompensatedLog::new(&robot, &read, None).unwrap();
    for k in 100..110 {
        assert!(run.rows[k].held);
        assert_eq!(run.rows[k].correction, run.rows[99].correction);
        assert!(run.rows[k].correction.iter().any(|c| c.abs() > 1e-5));
    }
    assert_eq!(run.faults[0].fault, Fault::Measured(2));
    assert_eq!(text::fault(run.faults[0].fault), "no measured q3");
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
