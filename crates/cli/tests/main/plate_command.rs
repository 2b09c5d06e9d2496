//! What `plate` runs, says, writes and refuses, and how it agrees with logs of an independent engine.
#![allow(clippy::print_stderr)]

use std::fmt::Write as _;
use std::fs;

use crate::common::{bracketry, code, file, json, number, scratch};
use serde_json::Value;

/// A log of the shared folder; without the folder the test has nothing to compare with.
fn log(name: &str) -> Option<String> {
    let shared = std::env::var("BRACKETRY_SHARED").unwrap_or_else(|_| "../shared".into());
    let path = crate::common::root().join(shared).join("data/plate").join(name);
    if path.is_file() {
        return Some(path.to_str().unwrap().to_owned());
    }
    eprintln!("ignored: {} is not there", path.display());
    None
}

#[test]
fn a_run_says_what_it_ran_and_what_it_gave() {
    let v = json(&["plate", "2", "--model", "published", "--seconds", "4", "--json"]);
    assert_eq!(v["experiment"], "2, x with ω = 3π");
    assert_eq!(v["model"], "published");
    assert_eq!(v["friction"], serde_json::json!({"law": "coulomb", "mu": 0.3}));
    assert_eq!(v["shape"], serde_json::json!({"kind": "disk", "radius": 0.12}));
    assert_eq!((number(&v, "/start/x"), number(&v, "/target"), v["coordinate"].as_str()), (0.48, 0.54, Some("x")));
    // The reference: 2.4 s.
    assert!((number(&v, "/reached") - 2.4).abs() < 0.05, "{v}");
    assert_eq!(v["outcome"], "reached");
    assert!((number(&v, "/drift/x") - (number(&v, "/final/x") - 0.48)).abs() < 1e-12);
    assert_eq!((number(&v, "/final/y"), number(&v, "/final/phi")), (0.0, 0.0));
    assert!(number(&v, "/times_real_time") > 0.0 && number(&v, "/stick_share") > 0.0);
    let assumed = v["assumptions"].as_array().unwrap();
    assert!(assumed.iter().any(|a| a.as_str().unwrap().contains("e = q - q_desired")));
    assert!(v["comparison"].is_null() && v["stopped"].is_null());
    let report = bracketry(&["plate", "2", "--model", "published", "--seconds", "4"]);
    let text = String::from_utf8_lossy(&report.stdout);
    for part in ["reached after 2.3", "coulomb, mu 0.3", "keeps its place in the inertial frame", "times real time"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn what_is_not_reached_is_an_answer_with_exit_code_one() {
    let o = bracketry(&["plate", "2", "--model", "published", "--seconds", "1", "--json"]);
    let v: Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!((code(&o), v["outcome"].as_str(), v["reached"].is_null()), (1, Some("not reached"), true));
}

#[test]
fn a_scenario_file_says_the_same_as_options_and_options_have_the_last_word() {
    let dir = scratch("plate_scenario");
    fs::write(dir.join("box.csv"), "x,y\n-0.1,-0.05\n0.1,-0.05\n0.1,0.05\n-0.1,0.05\n").unwrap();
    let text = "experiment = 2\nomega = 4\nmodel = 'published'\nmu = 0.25\nshape = 'polygon:box.csv'\n\
                start = '0.5, 0, 90deg'\nseconds = 3.0\n";
    let scenario = file(&dir, "s.toml", text);
    let options = ["plate", "2", "--omega", "4", "--model", "published", "--mu", "0.25", "--seconds", "3", "--json"];
    let options = [&options[..], &["--shape", "rectangle:0.2x0.1", "--start", "0.5,0,90deg"]].concat();
    let read = |arguments: &[&str]| -> Value { serde_json::from_slice(&bracketry(arguments).stdout).unwrap() };
    let (from_file, from_options) = (read(&["plate", &scenario, "--json"]), read(&options));
    assert_eq!(from_file["shape"]["kind"], "polygon");
    assert_eq!(from_options["shape"]["sides"], serde_json::json!([0.2, 0.1]));
    assert!((number(&from_file, "/start/phi") - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    for path in ["/final/x", "/final/phi"] {
        assert!((number(&from_file, path) - number(&from_options, path)).abs() < 1e-9, "{path}");
    }
    let changed = read(&["plate", &scenario, "--mu", "0.2", "--json"]);
    assert_eq!(number(&changed, "/friction/mu"), 0.2);
    assert!(number(&changed, "/final/x") != number(&from_file, "/final/x"));
}

#[test]
fn tables_and_plots_are_written_and_a_run_agrees_with_its_own_table() {
    let dir = scratch("plate_files");
    let out = dir.join("first");
    let base = ["plate", "3", "--model", "published", "--seconds", "2"];
    let o = bracketry(&[&base[..], &["--out", out.to_str().unwrap(), "--gif"]].concat());
    assert_eq!(code(&o), 1, "{}", String::from_utf8_lossy(&o.stderr));
    for name in ["plate.json", "trajectory.csv", "motion.svg", "motion.png", "plan_view.png", "plate.gif"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 500, "{name}");
    }
    assert!(fs::read(out.join("plate.gif")).unwrap().starts_with(b"GIF89a"));
    let table = out.join("trajectory.csv");
    let text = fs::read_to_string(&table).unwrap();
    assert_eq!(
        text.lines().next().unwrap(),
        "t,plate_X,plate_theta,x_plate,y_plate,phi_plate,vx,vy,w,amp,normal_force,stick_fraction,gap,lean"
    );
    // 2 s by 2 ms, start included.
    assert_eq!(text.lines().count(), 1002);
    // The same run on the motion of its own table: only the sampling is between them.
    let again = dir.join("again");
    let arguments =
        ["--compare", table.to_str().unwrap(), "--motion", "log", "--json", "--out", again.to_str().unwrap()];
    let v: Value = serde_json::from_slice(&bracketry(&[&base[..], &arguments].concat()).stdout).unwrap();
    assert_eq!(v["motion"], "log");
    assert!(number(&v, "/comparison/y_mm/rms") < 0.01 && number(&v, "/comparison/x_mm/rms") < 1e-9, "{v}");
    assert!(fs::metadata(again.join("comparison.png")).unwrap().len() > 500);
}

#[test]
fn deviations_are_those_of_the_columns() {
    let dir = scratch("plate_deviations");
    let out = dir.join("out");
    let base = ["plate", "3", "--model", "published", "--seconds", "1"];
    bracketry(&[&base[..], &["--out", out.to_str().unwrap()]].concat());
    let table = fs::read_to_string(out.join("trajectory.csv")).unwrap();
    let mut shifted = String::from("t,x_plate,y_plate,phi_plate\n");
    for (k, line) in table.lines().skip(1).enumerate() {
        let f: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let side = if k % 2 == 0 { 3e-3 } else { -3e-3 };
        writeln!(shifted, "{},{},{},{}", f[0], f[3] - 2e-3, f[4] + side, f[5] + 0.5 * f[0]).unwrap();
    }
    let log = file(&dir, "shifted.csv", &shifted);
    let start = ["--start", "0.3,-0.03,0", "--compare", &log, "--json"];
    let v: Value = serde_json::from_slice(&bracketry(&[&base[..], &start].concat()).stdout).unwrap();
    let c = &v["comparison"];
    assert!((number(c, "/x_mm/rms") - 2.0).abs() < 1e-6 && (number(c, "/x_mm/at_end") - 2.0).abs() < 1e-6);
    assert!((number(c, "/y_mm/rms") - 3.0).abs() < 1e-6 && (number(c, "/y_mm/largest").abs() - 3.0).abs() < 1e-6);
    assert!((number(c, "/phi_deg/at_end") + 0.5f64.to_degrees()).abs() < 1e-6);
    // The run did not turn, the log turned by half a radian: all of it is missing.
    assert!((number(c, "/phi_percent") + 100.0).abs() < 1e-6);
    assert_eq!(number(c, "/rows"), 501.0);
}

#[test]
fn bad_input_is_refused_with_place_and_remedy() {
    let dir = scratch("plate_bad");
    let good = "t,x_plate,y_plate,phi_plate\n0,0,0,0\n1,0,0,0\n2,0,0,0\n";
    let csv = |name: &str, text: &str| file(&dir, name, text);
    let no_y = csv("no_y.csv", &good.replace("y_plate", "y"));
    let nan = csv("nan.csv", &good.replace("1,0,0,0", "1,0,NaN,0"));
    let order = csv("order.csv", &good.replace("2,0", "0.5,0"));
    let short = csv("short.csv", "t,x_plate,y_plate,phi_plate\n0,0,0,0\n");
    let no_plate = csv("no_plate.csv", good);
    let moving = "t,x_plate,y_plate,phi_plate,plate_X,plate_theta\n0,0,0,0,0,0\n1,0,0,0,0,0\n";
    let one_second = csv("one_second.csv", moving);
    let bow = csv("bow.csv", "0,0\n1,1\n1,0\n0,1\n");
    let letters = csv("letters.csv", "0,0\n1,a\n");
    let scenario = csv("bad.toml", "experiment = 1\nmu = -0.3\n");
    let unknown = csv("unknown.toml", "experiment = 1\nfriktion = 'coulomb'\n");
    let polygon = |file: &str| format!("polygon:{file}");
    let (bow, letters, absent) = (polygon(&bow), polygon(&letters), polygon("/nowhere.csv"));
    let cases: [(&[&str], &str); 30] = [
        (&["--compare", &no_y], "no_y.csv: the column y_plate is missing; the table has phi_plate, t, x_plate, y"),
        (&["--compare", &nan], "line 3, column `y_plate`: `NaN` is not a finite number"),
        (&["--compare", &order], "line 4: the time 0.5 does not exceed 1 before it"),
        (&["--compare", &short], "fewer than two rows"),
        (&["--compare", "/nowhere.csv"], "/nowhere.csv: cannot be read"),
        (&["--compare", &no_plate, "--motion", "log"], "no columns plate_X and plate_theta"),
        (&["--compare", &one_second, "--motion", "log", "--seconds", "2"], "shorten --seconds"),
        (&["--motion", "log"], "add --compare LOG.csv"),
        (&["--mu", "-0.3"], "--mu: mu = -0.3 must not be negative; give a number"),
        (&["--mu", "nan"], "--mu: mu = NaN must not be negative"),
        (&["--shape", "circle:0.1"], "--shape: `circle:0.1` is not a shape; give disk:RADIUS"),
        (&["--shape", "disk:-0.1"], "must be a positive number"),
        (&["--shape", "ellipse:0.1"], "is not a shape; give"),
        (&["--shape", &bow], "bow.csv: "),
        (&["--shape", &letters], "letters.csv, line 2: `a` is not a finite number"),
        (&["--shape", &absent], "/nowhere.csv cannot be read"),
        (&["--friction", "sticky:1"], "--friction: `sticky:1` is not a friction law; give coulomb"),
        (&["--friction", "static:0.1"], "mu_static = 0.1 is below mu = 0.3"),
        (&["--model", "published", "--friction", "viscous:1"], "supports Coulomb friction only; omit --friction"),
        (&["--model", "rigid"], "--model: there is no model `rigid`; name one of published"),
        (&["--experiment", "4"], "--experiment: there is no experiment `4`; name 1"),
        (&["--omega", "2.5", "--experiment", "2"], "omega = 2.5 is not a whole number"),
        (&["--start", "1"], "--start: `1` has 1 numbers; give x,y,phi"),
        (&["--seconds", "-1"], "--seconds: seconds = -1 must be positive"),
        (&["--seconds", "1e9", "--dt", "0.01"], "steps would be taken; enlarge --dt or shorten --seconds"),
        (&["--seconds", "1e4", "--dt", "0.01", "--sample", "1e-4"], "rows would be written; enlarge --sample"),
        (&["--sample", "0.5"], "sample = 0.5 is not between 0 and 0.02 s"),
        (&["--dt", "1e9"], "dt = 1000000000 is not between 0 and 0.01 s"),
        (&["--points", "2.5"], "points = 2.5 is not a count"),
        (&["--gif"], "add --out DIR"),
    ];
    for (arguments, part) in cases {
        let arguments = [&["plate"], arguments].concat();
        let o = bracketry(&arguments);
        let message = String::from_utf8_lossy(&o.stderr);
        assert_eq!(code(&o), 2, "{arguments:?}: {message}");
        assert!(message.contains(part), "`{part}` in: {message}");
    }
    for (scenario, part) in [(scenario, "bad.toml:2:6: mu = -0.3"), (unknown, "unknown.toml:2:1")] {
        let o = bracketry(&["plate", &scenario]);
        let message = String::from_utf8_lossy(&o.stderr);
        assert!(code(&o) == 2 && message.contains(part), "`{part}` in: {message}");
    }
}

/// The comparison of a run of the area model with a log of the shared folder.
fn compared(experiment: &str, name: &str, motion: &str) -> Option<Value> {
    let log = log(name)?;
    let arguments = ["plate", experiment, "--dt", "0.002", "--compare", &log, "--motion", motion, "--json"];
    let o = bracketry(&arguments);
    let v: Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!(v["model"], "area", "{}", String::from_utf8_lossy(&o.stderr));
    Some(v["comparison"].clone())
}

#[test]
fn the_orientation_agrees_with_an_independent_engine_within_ten_percent() {
    let Some(c) = compared("1", "exp1_disk_mu0.3.csv", "formula") else { return };
    assert!(number(&c, "/phi_percent").abs() < 10.0, "{c}");
    // In x and y as the other experiments.
    assert!(number(&c, "/x_mm/rms") < 3.0 && number(&c, "/y_mm/rms") < 3.0, "{c}");
    assert_eq!((number(&c, "/from"), number(&c, "/to"), number(&c, "/rows")), (0.0, 15.0, 7501.0));
}

#[test]
fn positions_agree_with_an_independent_engine_within_three_millimeters() {
    for (experiment, name) in [("2", "exp2_disk_w3pi_mu0.3.csv"), ("3", "exp3_disk_mu0.3.csv")] {
        for motion in ["formula", "log"] {
            let Some(c) = compared(experiment, name, motion) else { return };
            assert!(number(&c, "/x_mm/rms") < 3.0 && number(&c, "/y_mm/rms") < 3.0, "{name}, {motion}: {c}");
            // Signs are compared where the run decides on them, and none is mirrored.
            assert_eq!((c["signs"].is_null(), c["status"].as_str()), (motion == "log", Some("compared")), "{c}");
        }
    }
}

#[test]
fn what_tips_ends_the_area_model_and_goes_on_as_a_body() {
    // A column 40 mm wide and 200 mm high tips beyond g · 40/200 = 2 m/s²; the plate comes to shake with 3.9 m/s².
    let column =
        ["plate", "1", "--shape", "rectangle:0.04x0.04", "--thickness", "0.2", "--mu", "0.5", "--seconds", "0.4"];
    let run = |more: &[&str]| -> (i32, Value) {
        let o = bracketry(&[&column[..], more, &["--dt", "0.002", "--json"]].concat());
        (code(&o), serde_json::from_slice(&o.stdout).unwrap())
    };
    let (exit, area) = run(&[]);
    assert_eq!((exit, area["outcome"].as_str()), (1, Some("stopped")));
    let tips = number(&area, "/t_final");
    assert!(area["stopped"].as_str().unwrap().contains("tips at t = "), "{area}");
    assert!(tips > 0.2 && tips < 0.4);
    let (exit, body) = run(&["--model", "body"]);
    assert_eq!(exit, 1);
    assert_eq!((number(&body, "/t_final"), body["outcome"].as_str()), (0.4, Some("not flat")));
    assert!(number(&body, "/events") > 0.0);
}

#[test]
fn what_loses_its_load_ends_the_models_that_lie_on_the_plate() {
    // Half a meter from the axis experiment 3 tilts by more than 100°.
    for model in ["published", "point", "reduced"] {
        let o = bracketry(&["plate", "3", "--model", model, "--start", "0.3,-0.5,0", "--seconds", "4", "--json"]);
        let v: Value = serde_json::from_slice(&o.stdout).unwrap();
        assert_eq!((code(&o), v["outcome"].as_str()), (1, Some("stopped")), "{v}");
        assert!(v["stopped"].as_str().unwrap().contains("the normal force became negative"), "{v}");
        assert!(number(&v, "/t_final") < 4.0);
    }
}
