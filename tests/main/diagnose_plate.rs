//! Effects hidden in logs of an object on the vibrating plate: the diagnosis sees the columns of the log and nothing else.
//!
//! Fixed seeds and short logs; `cargo run --release --example diagnose_plate` draws as many effects as one likes.

use bracketry::plate::recording::{PlateMismatch, RecordingSettings, multisine, synthetic_log};
use bracketry_diagnose::{Cause, DiagnosisSettings, Record, RecordSettings, Study, StudySettings, Verdict, diagnose};
use bracketry_system::System;

fn disk() -> System {
    System::parse("plate_disk.toml", include_str!("../../models/plate_disk.toml")).unwrap()
}

/// A multisine of a few seconds with an effect hidden in it.
fn record(effect: &PlateMismatch, duration: f64, seed: u64) -> Record {
    let settings = RecordingSettings::default();
    let start = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let shaken = multisine(start, duration, &settings, seed).unwrap();
    let log = synthetic_log(&shaken, start, duration, effect, &settings, seed).unwrap().log;
    let columns = log.by_name();
    Record::from_columns("multisine", log.t, columns, &disk(), &RecordSettings::default()).unwrap()
}

fn half_seconds() -> StudySettings {
    StudySettings { window: Some(0.5), ..StudySettings::default() }
}

#[test]
fn a_disk_with_nothing_hidden_leaves_white_noise_and_its_friction() {
    let study = Study::new(&disk(), &[record(&PlateMismatch::None, 3.0, 1)], &half_seconds()).unwrap();
    let windows: Vec<usize> = (0..study.windows().len()).collect();
    let fit = study.fit(&[], &windows, None).unwrap();
    let mu = fit.values.iter().find(|v| v.name == "mu").unwrap();
    assert!((mu.value - 0.3).abs() < 4.0 * mu.std && mu.std < 0.005, "{mu:?}");
    let square: f64 = fit.windows.iter().map(|w| w.square).sum();
    let count: f64 = fit.windows.iter().map(|w| w.count as f64).sum();
    // Each window takes six initial states; the standard deviation of χ² is √(2 n), and the noise is estimated to a few percent.
    let expected = count - 6.0 * windows.len() as f64;
    assert!((square / expected - 1.0).abs() < 5.0 * (2.0 / expected).sqrt() + 0.05, "{square} for {expected}");
}

#[test]
fn friction_that_is_off_by_a_tenth_is_the_parameter_that_is_wrong() {
    let effect = PlateMismatch::draw_kind("friction", 2).unwrap();
    let PlateMismatch::Friction(factor) = effect else { unreachable!("the kind was asked for") };
    let settings = DiagnosisSettings { study: half_seconds(), ..DiagnosisSettings::default() };
    let report = diagnose(&disk(), &[record(&effect, 3.0, 2)], &[], &settings, &mut |_| ()).unwrap();
    assert_eq!(report.verdict, Verdict::CauseFound);
    assert_eq!(report.causes.iter().map(|c| c.name).collect::<Vec<_>>(), [Cause::ParameterError]);
    let mu = report.parameters.iter().find(|p| p.name == "mu").unwrap();
    assert!((mu.after - 0.3 * factor).abs() < 4.0 * mu.std, "{mu:?} for {factor}");
}
