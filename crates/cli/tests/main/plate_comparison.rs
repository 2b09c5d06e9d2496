//! What `plate --compare` says where the sign of an amplitude hangs on less than the noise, and where it does not.

use std::fmt::Write as _;
use std::fs;

use crate::common::{bracketry, code, file, number, scratch};
use serde_json::Value;

const RUN: [&str; 6] = ["plate", "3", "--model", "published", "--seconds", "4"];

/// Times, poses and amplitudes of a run, by the table that it writes.
fn table(name: &str) -> Vec<[f64; 5]> {
    let out = scratch(name).join("out");
    bracketry(&[&RUN[..], &["--out", out.to_str().unwrap()]].concat());
    let text = fs::read_to_string(out.join("trajectory.csv")).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let columns = ["t", "x_plate", "y_plate", "phi_plate", "amp"];
    let places = columns.map(|name| header.iter().position(|h| *h == name).unwrap());
    text.lines()
        .skip(1)
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            places.map(|k| values[k])
        })
        .collect()
}

/// A log of the object's pose alone.
fn log(name: &str, rows: &[[f64; 5]]) -> String {
    let mut text = String::from("t,x_plate,y_plate,phi_plate\n");
    for [t, x, y, phi, _] in rows {
        writeln!(text, "{t},{x},{y},{phi}").unwrap();
    }
    file(&scratch(name), "log.csv", &text)
}

#[test]
fn a_log_that_is_mirrored_from_a_start_on_is_undecided_with_exit_code_one() {
    let mut rows = table("plate_mirrored_run");
    // The row in which a period starts with the least error: the amplitude is sgn(e)(20 + 200|e|)°, the target y = 0.
    let starts = (1..rows.len()).filter(|k| rows[*k][4] != rows[*k - 1][4]);
    let first = starts.min_by(|a, b| rows[*a][2].abs().total_cmp(&rows[*b][2].abs())).unwrap();
    let [t, _, least, ..] = rows[first];
    rows[first..].iter_mut().for_each(|row| row[2] = -row[2]);
    let (log, noise) = (log("plate_mirrored", &rows), (3.0 * least.abs()).to_string());
    let out = scratch("plate_mirrored_out").join("out");
    let options = ["--compare", &log, "--noise", &noise, "--start", "0.3,-0.03,0"];
    let json = bracketry(&[&RUN[..], &options, &["--json", "--out", out.to_str().unwrap()]].concat());
    let v: Value = serde_json::from_slice(&json.stdout).unwrap();
    let (c, period) = (&v["comparison"], 1.0 / 3.0);
    assert_eq!((code(&json), v["outcome"].as_str(), c["status"].as_str()), (1, Some("reached"), Some("undecided")));
    assert_eq!((c["signs"]["status"].as_str(), c["signs"]["input"].as_str()), (Some("undecided"), Some("theta")));
    let at = number(c, "/signs/opposite/t");
    assert!((at / period - (at / period).round()).abs() < 1e-9 && at <= t + 1e-9 && t - at < 0.002 + 1e-9, "{at} {t}");
    assert_eq!(c["signs"]["opposite"]["sign_of_log"], "logged_motion");
    // The run is that of the log before, its mirror image after, and the log's own with the signs of the log.
    assert!(number(c, "/signs/opposite/before/y_mm/rms") < 1e-6, "{c}");
    let [after, given, depending] = ["after/y_mm/rms", "after_with_signs_of_log/y_mm/rms", "depending/y_mm/rms"]
        .map(|path| number(c, &format!("/signs/opposite/{path}")));
    assert!(given < 0.2 * after && (depending / after - 1.0).abs() < 0.2, "{given} {after} {depending}");
    assert!(fs::metadata(out.join("comparison.png")).unwrap().len() > 500);
    let report = bracketry(&[&RUN[..], &options].concat());
    let text = String::from_utf8_lossy(&report.stdout);
    for part in [
        &format!("undecided from t = {at:.3} s on: opposite signs of the amplitude of θ"),
        "only the comparison before this time counts",
        "after, with the signs of the log",
        "affected by the sign             y by",
        "(given)",
    ] {
        assert!(text.contains(part), "`{part}` in {text}");
    }
    assert_eq!(code(&report), 1);
}

#[test]
fn nothing_is_said_about_signs_that_errors_beyond_the_noise_decide() {
    let rows = table("plate_own_run");
    let log = log("plate_own", &rows);
    let options = ["--compare", &log, "--start", "0.3,-0.03,0"];
    let json = bracketry(&[&RUN[..], &options, &["--json"]].concat());
    let v: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((code(&json), v["comparison"]["status"].as_str()), (0, Some("compared")));
    assert_eq!(v["comparison"]["signs"]["status"], "decided", "{}", v["comparison"]);
    assert!(number(&v, "/comparison/signs/starts") >= 11.0 && v["comparison"]["signs"]["opposite"].is_null());
    let report = bracketry(&[&RUN[..], &options].concat());
    let text = String::from_utf8_lossy(&report.stdout);
    assert!(text.contains("compared    with") && !text.contains("signs"), "{text}");
}

#[test]
fn noise_without_a_log_or_below_zero_is_refused() {
    let log = log("plate_noise", &[[0.0; 5], [1.0, 0.0, 0.0, 0.0, 0.0]]);
    for (options, part) in [
        (vec!["--noise", "1e-3"], "--noise: no log is given; add --compare LOG.csv"),
        (vec!["--noise", "-1", "--compare", &log], "--noise: noise = -1 must not be negative"),
    ] {
        let o = bracketry(&[&["plate", "3"], &options[..]].concat());
        let message = String::from_utf8_lossy(&o.stderr);
        assert!(code(&o) == 2 && message.contains(part), "`{part}` in {message}");
    }
}
