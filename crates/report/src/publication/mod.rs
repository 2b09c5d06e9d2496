//! The publication that the plate and the compensation of robots come from, equation by equation: where each is here, how it
//! is checked, and whether it is right.
//!
//! ```
//! use bracketry_report::publication::{Verdict, found};
//! let entries = found("3.16");
//! assert_eq!((entries.len(), entries[0].verdict), (1, Verdict::Wrong));
//! ```

mod entry;
mod plate;
mod question;
mod robot;
mod text;

pub use entry::{Entry, Kind, Place, Verdict};
pub use text::{entry_text, list_text, page};

/// The publication.
pub const CITATION: &str = "M. Momeni Kelageri, Training and Research Activities Report, First Year, XXIX Cycle, PhD in Information \
                            Technology and Electrical Engineering, Università degli Studi di Napoli Federico II, 2015, chapter 3";

/// All entries: equations and figures in their order, then the points of the open question.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    robot::ENTRIES.iter().chain(plate::ENTRIES).chain(question::ENTRIES)
}

/// The entries of a number, such as `3.1` (the equation and the figure), or of a label, such as `figure 3.1`.
pub fn found(wanted: &str) -> Vec<&'static Entry> {
    let wanted = wanted.trim();
    entries().filter(|e| e.number == wanted || e.label().eq_ignore_ascii_case(wanted)).collect()
}
