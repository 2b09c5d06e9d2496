//! What is said about data before anything is concluded from them.

use std::collections::BTreeMap;

use bracketry_diagnose::{Audit, DiagnoseError, Record, RecordSettings};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

const PENDULUM: &str = r#"
name = "pendulum"
states = ["th", "w"]
inputs = ["u"]
dynamics = { th = "w", w = "u - 9.81*sin(th)" }
"#;

/// A swing of a pendulum: angle, rate and torque at 500 samples a second, with noise.
struct Swing {
    times: Vec<f64>,
    th: Vec<f64>,
    w: Vec<f64>,
    u: Vec<f64>,
}

impl Swing {
    fn new(seed: u64) -> Self {
        let mut rng = StdRng::seed_from_u64(seed);
        let times: Vec<f64> = (0..2000).map(|k| f64::from(k) * 2e-3).collect();
        let (a, b) = (rng.random_range(0.5..1.0), rng.random_range(2.0..4.0));
        let mut noisy = |f: &dyn Fn(f64) -> f64, std: f64| -> Vec<f64> {
            times.iter().map(|t| f(*t) + std * Distribution::<f64>::sample(&StandardNormal, &mut rng)).collect()
        };
        let th = noisy(&|t| a * (b * t).sin(), 1e-3);
        let w = noisy(&|t| a * b * (b * t).cos(), 1e-2);
        let u = noisy(&|t| (3.0 * t).sin(), 0.0);
        Self { times, th, w, u }
    }

    fn read(self) -> Result<Audit, DiagnoseError> {
        let columns = BTreeMap::from([("th".into(), self.th), ("w".into(), self.w), ("u".into(), self.u)]);
        let system = System::parse("pendulum.toml", PENDULUM).unwrap();
        let record = Record::from_columns("swing", self.times, columns, &system, &RecordSettings::default())?;
        Ok(record.audit.unwrap())
    }

    fn scaled(mut self, what: &str, factor: f64) -> Self {
        let column = match what {
            "t" => &mut self.times,
            "th" => &mut self.th,
            _ => &mut self.w,
        };
        for v in column {
            *v *= factor;
        }
        self
    }

    /// The warnings, all in one text.
    fn warnings(self) -> String {
        let audit = self.read().unwrap();
        audit.warnings.iter().map(|w| format!("{}; {}", w.message(), w.remedy())).collect::<Vec<_>>().join("\n")
    }
}

#[test]
fn good_data_need_no_warning() {
    for seed in 0..20 {
        assert_eq!(Swing::new(seed).warnings(), "");
    }
}

#[test]
fn other_units_are_refused_where_two_columns_disagree() {
    let degrees = 180.0 / std::f64::consts::PI;
    let cases = [
        ("th", degrees, "degrees"),
        ("w", degrees, "degrees per second"),
        ("t", 1e3, "milliseconds"),
        ("w", 1e3, "milli"),
    ];
    for (what, factor, meaning) in cases {
        let message = Swing::new(1).scaled(what, factor).read().unwrap_err().to_string();
        assert!(message.contains("`th`") && message.contains(meaning), "{what} {factor}: {message}");
    }
}

#[test]
fn columns_that_do_not_fit_are_pointed_out() {
    let against = Swing::new(2).scaled("w", -1.0).warnings();
    assert!(against.contains("`th` moves against `w`") && against.contains("sign"), "{against}");
    let stretched = Swing::new(3).scaled("th", 2.0).warnings();
    assert!(stretched.contains("`th` moves 2.00"), "{stretched}");
    let mut other = Swing::new(4);
    other.w = other.times.iter().map(|t| (17.0 * t).cos()).collect();
    let other = other.warnings();
    assert!(other.contains("does not move as `w` indicates"), "{other}");
}

#[test]
fn angles_in_degrees_and_times_in_milliseconds_are_suspected() {
    let mut far = Swing::new(5).scaled("th", 60.0);
    far.w = far.w.iter().map(|w| w * 60.0).collect();
    let far = far.warnings();
    assert!(far.contains("angle `th`") && far.contains("pi/180"), "{far}");
    let slow = Swing::new(6).scaled("t", 1e3).scaled("w", 1e-3).warnings();
    assert!(slow.contains("2 s apart") && slow.contains("milliseconds"), "{slow}");
}

#[test]
fn a_constant_input_a_saturated_or_coarse_sensor_and_lost_values_are_said() {
    let mut still = Swing::new(7);
    still.u = vec![0.5; 2000];
    let still = still.warnings();
    assert!(still.contains("`u` is 0.5 throughout") && still.contains("offset"), "{still}");

    let mut saturated = Swing::new(8);
    for w in &mut saturated.w {
        *w = w.clamp(-0.8, 0.8);
    }
    let audit = saturated.read().unwrap();
    let w = audit.columns.iter().find(|c| c.name == "w").unwrap();
    assert!(w.saturated.unwrap() > 200, "{audit}");
    assert!(audit.to_string().contains("saturates"), "{audit}");

    let mut coarse = Swing::new(9);
    for th in &mut coarse.th {
        *th = (*th / 0.01).round() * 0.01;
    }
    let coarse = coarse.warnings();
    assert!(coarse.contains("`th` is rounded to multiples of 1.000e-2"), "{coarse}");

    let mut lost = Swing::new(10);
    lost.th[100..130].fill(f64::NAN);
    let lost = lost.warnings();
    assert!(lost.contains("`th`: 30 of 2000"), "{lost}");
}

#[test]
fn an_uneven_clock_and_gaps_are_said() {
    let mut rng = StdRng::seed_from_u64(11);
    let mut swing = Swing::new(11);
    for (k, t) in swing.times.iter_mut().enumerate() {
        *t += rng.random_range(-2e-4..2e-4) + if k < 1500 { 0.0 } else { 5.0 };
    }
    let text = swing.warnings();
    assert!(text.contains("steps in time vary"), "{text}");
    assert!(text.contains("1 gap in time") && text.contains("t = 8.0"), "{text}");
}
