//! What counts as finding a hidden effect.

use bracketry_diagnose::Cause::{self, ConstantBias, QuadraticDrag, SensorDelay, Tilt, UnknownTerm, ViscousFriction};
use bracketry_diagnose::{Effort, Evidence, NamedCause, Outcome, Report, Verdict, VerdictReason};
use bracketry_system::symbolic::Named;
use bracketry_trials::Score;

/// The score of a report that names these causes, with those that they may be confused with.
fn score(hidden: &[Option<Cause>], named: &[(Cause, &[Cause])], unexplained: bool) -> Score {
    let cause = |&(name, confusable): &(Cause, &[Cause])| NamedCause {
        name,
        equation: String::new(),
        term: "".into(),
        parameters: Named(Vec::new()),
        p_value: None,
        confusable_with: confusable.to_vec(),
        separating_experiment: String::new(),
        rivals: Vec::new(),
        share: None,
        flags: Vec::new(),
        combination: None,
    };
    let verdict = match (unexplained, named) {
        (true, _) => Verdict::Unexplained,
        (false, []) => Verdict::NothingFound,
        _ => Verdict::CauseFound,
    };
    let report = Report {
        model: String::new(),
        quantities: bracketry_system::Quantities::default(),
        verdict,
        reason: VerdictReason { outcome: Outcome::Explained, caveats: Vec::new() },
        causes: named.iter().map(cause).collect(),
        places: Vec::new(),
        regimes: Vec::new(),
        residual_acceleration: Vec::new(),
        gain: None,
        parameters: Vec::new(),
        excess: None,
        candidates: Vec::new(),
        windows: None,
        data: Vec::new(),
        notes: Vec::new(),
        effort: Effort::default(),
        seconds: 0.0,
        evidence: Evidence::default(),
    };
    Score::of_causes(hidden, &report)
}

#[test]
fn nothing_hidden_must_stay_nothing() {
    assert_eq!(score(&[], &[], false), Score::Exact);
    assert_eq!(score(&[], &[], true), Score::FalseAlarm);
    assert_eq!(score(&[], &[(Tilt, &[])], false), Score::FalseAlarm);
}

#[test]
fn a_name_counts_before_its_set() {
    let hidden = [Some(Tilt)];
    assert_eq!(score(&hidden, &[(Tilt, &[ConstantBias])], false), Score::Exact);
    assert_eq!(score(&hidden, &[(ConstantBias, &[Tilt])], false), Score::InSet);
    assert_eq!(score(&hidden, &[(ConstantBias, &[])], false), Score::WrongName);
    assert_eq!(score(&hidden, &[(Tilt, &[]), (SensorDelay, &[])], false), Score::WrongName);
    assert_eq!(score(&hidden, &[], false), Score::Missed);
    assert_eq!(score(&hidden, &[], true), Score::Unexplained);
    assert_eq!(score(&hidden, &[(UnknownTerm, &[])], false), Score::Unexplained);
}

#[test]
fn of_two_effects_both_must_be_found() {
    let hidden = [Some(Tilt), Some(ViscousFriction)];
    assert_eq!(score(&hidden, &[(ViscousFriction, &[]), (Tilt, &[])], false), Score::Exact);
    assert_eq!(score(&hidden, &[(QuadraticDrag, &[ViscousFriction]), (Tilt, &[])], false), Score::InSet);
    assert_eq!(score(&hidden, &[(Tilt, &[])], false), Score::Partly);
    assert_eq!(score(&hidden, &[(Tilt, &[ViscousFriction])], false), Score::Partly);
    assert_eq!(score(&hidden, &[(Tilt, &[]), (QuadraticDrag, &[])], false), Score::WrongName);
}

#[test]
fn what_has_no_name_must_not_get_one() {
    assert_eq!(score(&[None], &[(UnknownTerm, &[])], false), Score::Exact);
    assert_eq!(score(&[None], &[], true), Score::Exact);
    assert_eq!(score(&[None], &[(Tilt, &[UnknownTerm])], false), Score::WrongName);
    assert_eq!(score(&[None, Some(Tilt)], &[(Tilt, &[])], false), Score::Partly);
    assert_eq!(score(&[None, Some(Tilt)], &[(Tilt, &[]), (UnknownTerm, &[])], false), Score::Exact);
}
