//! A diagnosis ends once the flag of its model's pool is raised, whatever it was doing, and with what it has at its time limit.

use std::collections::BTreeMap;
use std::time::Duration;

use bracketry_diagnose::{
    Cause, DiagnoseError, DiagnosisSettings, Note, Record, RecordSettings, Report, Stage, diagnose,
};
use bracketry_symbolic::StopFlag;
use bracketry_system::System;

/// A mass that is pushed by a force, with a friction that its model lacks.
fn pushed() -> (System, Record) {
    let model = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1 }\ndynamics = { x = 'v', v = 'u/m' }";
    let system = System::parse("pushed", model).unwrap();
    let times: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    let force: Vec<f64> = times.iter().map(|t| (3.0 * t).sin()).collect();
    let (mut x, mut v) = (0.0, 0.0);
    let mut positions = Vec::new();
    for (k, u) in force.iter().enumerate() {
        positions.push(x + 1e-4 * (12.9898 * k as f64).sin());
        v += 0.01 * (u - 0.4 * v);
        x += 0.01 * v;
    }
    let columns = BTreeMap::from([("u".to_owned(), force), ("x".to_owned(), positions)]);
    let record = Record::from_columns("run", times, columns, &system, &RecordSettings::default()).unwrap();
    (system, record)
}

#[test]
fn every_stage_at_which_the_flag_is_raised_is_the_last() {
    let (system, record) = pushed();
    let mut stages: Vec<Stage> = Vec::new();
    diagnose(&system, std::slice::from_ref(&record), &[], &DiagnosisSettings::default(), &mut |s| stages.push(s))
        .unwrap();
    assert!(stages.len() >= 3, "{stages:?}");
    for last in 0..stages.len() {
        let mut system = system.clone();
        system.pool.set_stop_flag(bracketry_symbolic::StopFlag::default());
        let flag = system.pool.stop_flag().clone();
        let mut seen = 0;
        let stopped = diagnose(&system, std::slice::from_ref(&record), &[], &DiagnosisSettings::default(), &mut |_| {
            if seen == last {
                flag.raise();
            }
            seen += 1;
        });
        assert!(matches!(stopped, Err(DiagnoseError::Stopped)), "raised at {:?}", stages[last]);
    }
}

/// The diagnosis with a limit that is over before its first stage ends, or never.
fn limited(over: bool) -> Report {
    let (system, record) = pushed();
    let limit = if over { Duration::from_millis(1) } else { Duration::from_hours(1) };
    let settings = DiagnosisSettings { time_limit: Some(limit), ..DiagnosisSettings::default() };
    diagnose(&system, &[record], &[], &settings, &mut |_| {
        if over {
            std::thread::sleep(Duration::from_millis(2));
        }
    })
    .unwrap()
}

fn left_out(report: &Report) -> Option<u64> {
    report
        .notes
        .iter()
        .find_map(|note| if let Note::TimeLimit { left_out, .. } = note { Some(*left_out) } else { None })
}

#[test]
fn a_search_that_is_asked_to_end_reports_what_it_has() {
    let (system, record) = pushed();
    let whole = limited(false).effort.fits;
    for last in [Stage::Refit, Stage::Fit { causes: 1 }] {
        let settings = DiagnosisSettings { end_search: StopFlag::default(), ..DiagnosisSettings::default() };
        let end = settings.end_search.clone();
        let report = diagnose(&system, std::slice::from_ref(&record), &[], &settings, &mut |stage| {
            if stage == last {
                end.raise();
            }
        })
        .unwrap();
        let interrupted = |note: &Note| matches!(note, Note::Interrupted { left_out } if *left_out > 0);
        assert!(report.notes.iter().any(interrupted), "{last:?}: {:?}", report.notes);
        assert!(report.effort.fits < whole && !report.places.is_empty(), "{last:?}: {:?}", report.effort);
    }
}

#[test]
fn a_search_that_ends_at_its_time_limit_reports_what_it_has_and_what_was_left_out() {
    let (whole, cut) = (limited(false), limited(true));
    assert_eq!((left_out(&whole), whole.causes[0].name), (None, Cause::ViscousFriction));
    assert!(left_out(&cut).is_some_and(|fits| fits > 0) && cut.causes.is_empty(), "{:?}: {:?}", cut.verdict, cut.notes);
    assert!(cut.effort.fits < whole.effort.fits, "{:?}", cut.effort);
    // Where the model falls short is shown all the same.
    assert!(!cut.places.is_empty());
}
