//! Results of the literature that are reproduced here: the claim, the command that shows it, our figure, the tests, and a verdict.
//!
//! ```
//! use bracketry_report::reproduced::{Verdict, found};
//! let rows = found("brockett-integrator");
//! assert_eq!((rows.len(), rows[0].verdict), (1, Verdict::Same));
//! assert!(found("Kawski").len() > 1);
//! ```

mod controllability;
mod dynamics;
mod flatness;
mod identifiability;
mod optimal_control;
mod row;
mod text;

pub use row::{Field, Ours, Row, Verdict};
pub use text::{list_text, page, row_text};

/// All rows, by field.
pub fn rows() -> impl Iterator<Item = &'static Row> {
    controllability::ROWS
        .iter()
        .chain(flatness::ROWS)
        .chain(identifiability::ROWS)
        .chain(optimal_control::ROWS)
        .chain(dynamics::ROWS)
}

/// The row of a name, or else the rows whose reference contains the text, such as `Sussmann` or `1990`.
pub fn found(wanted: &str) -> Vec<&'static Row> {
    let wanted = wanted.trim().to_lowercase();
    let named: Vec<&Row> = rows().filter(|row| row.name == wanted).collect();
    if wanted.is_empty() || !named.is_empty() {
        return named;
    }
    rows().filter(|row| row.reference.to_lowercase().contains(&wanted)).collect()
}
