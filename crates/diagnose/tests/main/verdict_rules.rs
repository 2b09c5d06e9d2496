//! What a verdict needs: evidence that is not counted twice, causes that held-out data bear out.

use std::collections::BTreeMap;

use bracketry_diagnose::{
    DiagnosisSettings, GainSettings, Note, Outcome, Record, RecordSettings, Repetition, Report, Verdict, diagnose,
};
use bracketry_system::System;
use bracketry_trials::{Slider, SliderSensors};
use rand::SeedableRng;
use rand::rngs::StdRng;

/// A slider that the model describes but for its parameters, and a constant force that the log does not know of.
fn pushed(name: &str, force: f64, seed: u64) -> (System, Record) {
    let mut slider = Slider::basic(SliderSensors::PositionAndVelocity, &mut StdRng::seed_from_u64(seed));
    (slider.rate, slider.duration) = (200.0, 3.0);
    let log = slider.run(&[], seed).unwrap();
    let mut columns: BTreeMap<String, Vec<f64>> = log.columns.into_iter().collect();
    columns.get_mut("u").unwrap().iter_mut().for_each(|u| *u -= force);
    let times = columns.remove("t").unwrap();
    let system = System::parse("slider.toml", &log.model).unwrap();
    let record = Record::from_columns(name, times, columns, &system, &RecordSettings::default()).unwrap();
    (system, record)
}

fn verdict(system: &System, records: &[&Record], validate: &[&Record]) -> Report {
    let cloned = |list: &[&Record]| list.iter().map(|r| (*r).clone()).collect::<Vec<_>>();
    diagnose(system, &cloned(records), &cloned(validate), &DiagnosisSettings::default(), &mut |_| {}).unwrap()
}

#[test]
fn the_same_record_twice_is_evidence_once() {
    let (system, record) = pushed("first.csv", 0.0, 1);
    let copy = Record { name: "copy.csv".into(), ..record.clone() };
    let (once, twice) = (verdict(&system, &[&record], &[]), verdict(&system, &[&record, &copy], &[]));
    assert_eq!(twice.verdict, Verdict::NothingFound, "{twice:?}");
    assert_eq!(once.parameters, twice.parameters);
    let repeated = Note::Repeated { record: "copy.csv".into(), first: "first.csv".into(), place: Repetition::InFit };
    let said = |r: &Report| r.notes.contains(&repeated);
    assert!(said(&twice) && !said(&once), "{:?}", twice.notes);
    assert!(twice.candidates.iter().all(|c| c.share.is_none_or(f64::is_finite)));
}

#[test]
fn the_data_of_the_fit_validate_nothing() {
    let (system, record) = pushed("first.csv", 0.6, 2);
    let (alone, itself) = (verdict(&system, &[&record], &[]), verdict(&system, &[&record], &[&record]));
    assert_eq!(alone.verdict, Verdict::CauseFound, "{alone:?}");
    assert_eq!(alone.causes, itself.causes);
    assert_eq!(alone.gain, itself.gain);
    assert!(
        itself.notes.iter().any(|n| matches!(n, Note::Repeated { place: Repetition::FitAndValidation, .. })),
        "{:?}",
        itself.notes
    );
    // What is named is significant, larger than its standard deviation, and improves some prediction.
    for cause in &alone.causes {
        assert!(cause.p_value.is_some_and(|p| p < DiagnosisSettings::default().significance), "{alone:?}");
        assert!(cause.parameters.iter().any(|(_, v)| v.value.abs() > v.std), "{alone:?}");
    }
    let gain = alone.gain.unwrap();
    assert!(gain.before.iter().zip(&gain.after).any(|(before, after)| before > after), "{gain:?}");
}

#[test]
fn a_force_that_turns_round_in_the_held_out_run_is_no_cause() {
    let (system, record) = pushed("first.csv", 0.6, 4);
    let (_, other) = pushed("other.csv", -0.6, 4);
    let report = verdict(&system, &[&record], &[&other]);
    assert!(matches!(report.verdict, Verdict::Unexplained | Verdict::NoGain), "{report:?}");
    assert!(report.causes.is_empty() && report.evidence.model.is_none());
    let outcome = &report.reason.outcome;
    let refuted = match outcome {
        Outcome::NotBorneOut { share, .. } => *share >= 0.005,
        other => matches!(other, Outcome::NoGain { .. }),
    };
    assert!(refuted, "{outcome:?}");
}

#[test]
fn a_horizon_that_no_prediction_reaches_is_stated() {
    let (system, record) = pushed("first.csv", 0.6, 2);
    let settings =
        DiagnosisSettings { gain: GainSettings::with_horizons(&[0.2, 100.0]), ..DiagnosisSettings::default() };
    let report = diagnose(&system, &[record], &[], &settings, &mut |_| {}).unwrap();
    assert_eq!(report.gain.unwrap().horizons_s, [0.2]);
    assert!(report.notes.contains(&Note::HorizonsTooLong(vec![100.0])), "{:?}", report.notes);
}
