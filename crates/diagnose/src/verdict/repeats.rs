//! The same data given twice.

use crate::Record;

/// Records of which each is there once, and what was left out.
pub(super) struct Distinct {
    /// Records to fit.
    pub(super) records: Vec<Record>,
    /// Records that no fit sees.
    pub(super) validate: Vec<Record>,
    /// One sentence per record left out.
    pub(super) notes: Vec<String>,
}

/// Leaves out records with the same numbers as an earlier one: windows that are there twice are taken for independent and
/// feign certainty, and data that the fit has seen validate nothing.
pub(super) fn distinct(records: &[Record], validate: &[Record]) -> Distinct {
    let mut kept = Distinct { records: Vec::new(), validate: Vec::new(), notes: Vec::new() };
    for record in records {
        match kept.records.iter().find(|r| same(r, record)) {
            Some(first) => kept.notes.push(format!(
                "{} holds the same data as {}: it is left out, for repeated data are no further evidence",
                record.name, first.name
            )),
            None => kept.records.push(record.clone()),
        }
    }
    for record in validate {
        if let Some(first) = kept.records.iter().find(|r| same(r, record)) {
            kept.notes.push(format!(
                "{} for validation holds the same data as {}, which the fit has seen: it does not count as held out",
                record.name, first.name
            ));
        } else if let Some(first) = kept.validate.iter().find(|r| same(r, record)) {
            kept.notes
                .push(format!("{} for validation holds the same data as {}: it is left out", record.name, first.name));
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
