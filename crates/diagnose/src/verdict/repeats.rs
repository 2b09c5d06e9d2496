//! The same data given twice.

use crate::Record;
use crate::report::{Note, Repetition};

/// Records of which each is there once, and what was left out.
#[derive(Clone)]
pub(super) struct Distinct {
    /// Records to fit.
    pub(super) records: Vec<Record>,
    /// Records that no fit sees.
    pub(super) validate: Vec<Record>,
    /// One per record left out.
    pub(super) notes: Vec<Note>,
}

/// Leaves out records with the same numbers as an earlier one: windows that are there twice are taken for independent and
/// feign certainty, and data that the fit has seen validate nothing.
pub(super) fn distinct(records: &[Record], validate: &[Record]) -> Distinct {
    let mut kept = Distinct { records: Vec::new(), validate: Vec::new(), notes: Vec::new() };
    let twice = |record: &Record, first: &Record, place| Note::Repeated {
        record: record.name.clone(),
        first: first.name.clone(),
        place,
    };
    let find = |list: &[Record], record: &Record| list.iter().find(|r| same(r, record)).cloned();
    for record in records {
        match find(&kept.records, record) {
            Some(first) => kept.notes.push(twice(record, &first, Repetition::InFit)),
            None => kept.records.push(record.clone()),
        }
    }
    for record in validate {
        if let Some(first) = find(&kept.records, record) {
            kept.notes.push(twice(record, &first, Repetition::FitAndValidation));
        } else if let Some(first) = find(&kept.validate, record) {
            kept.notes.push(twice(record, &first, Repetition::InValidation));
        } else {
            kept.validate.push(record.clone());
        }
    }
    kept
}

/// Whether times, inputs and measured columns agree bit by bit.
fn same(a: &Record, b: &Record) -> bool {
    let equal = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    equal(&a.times, &b.times)
        && a.inputs.len() == b.inputs.len()
        && a.inputs.iter().zip(&b.inputs).all(|(a, b)| equal(&a.values, &b.values))
        && a.measured.len() == b.measured.len()
        && a.measured.iter().zip(&b.measured).all(|(a, b)| a.quantity == b.quantity && equal(&a.values, &b.values))
}
