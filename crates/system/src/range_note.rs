//! What the ranges of an affine system's inputs do not say.

use std::collections::BTreeMap;
use std::fmt;

use crate::new_input::NewInput;
use crate::range::{Bound, Range};
use crate::system::System;
use crate::unknown_range::UnknownRange;

/// Where the ranges of an affine system's inputs say less than those of the original's.
#[derive(Clone, Debug, PartialEq)]
pub enum RangeNote {
    /// The values of a new input were not found.
    Unknown {
        /// The new input.
        input: String,
        /// Why.
        reason: UnknownRange,
    },
    /// Each new input takes the values of its range, but they do not take all of them together.
    Joint {
        /// The new inputs.
        inputs: Vec<String>,
    },
    /// An input became a state, which has no range in a model file.
    State {
        /// The input.
        input: String,
        /// Its range.
        range: Range,
    },
}

impl RangeNote {
    /// For a model whose inputs have ranges.
    pub(crate) fn of(
        original: &System,
        new: &[NewInput],
        independent: Option<bool>,
        integrators: &BTreeMap<String, u32>,
    ) -> Vec<RangeNote> {
        let mut notes = Vec::new();
        if original.input_ranges.is_empty() {
            return notes;
        }
        for v in new {
            if let Range::Unknown { reason } = &v.values {
                notes.push(RangeNote::Unknown { input: v.name.clone(), reason: reason.clone() });
            }
        }
        if new.len() > 1 && independent != Some(true) {
            notes.push(RangeNote::Joint { inputs: new.iter().map(|v| v.name.clone()).collect() });
        }
        for r in &original.input_ranges {
            let input = original.symbol_name(r.input).to_owned();
            if integrators.contains_key(&input) {
                let end = |e: &Option<bracketry_symbolic::Rational>| {
                    e.as_ref().map(|e| Bound::of_rational(e.clone(), original.pool.clone()))
                };
                let range = Range::Interval { lower: end(&r.min), upper: end(&r.max) };
                notes.push(RangeNote::State { input, range });
            }
        }
        notes
    }
}

impl fmt::Display for RangeNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RangeNote::Unknown { input, reason } => write!(
                f,
                "the values of {input} that the ranges of the old inputs allow were not found ({reason}): bound {input} where it is used"
            ),
            RangeNote::Joint { inputs } => {
                write!(f, "the ranges of {} hold individually; joint ranges were not established", inputs.join(", "))
            }
            RangeNote::State { input, range } => write!(
                f,
                "{input} is a state now: keep {} by a bound on the state",
                range.text(input).unwrap_or_else(|| "its range".to_owned())
            ),
        }
    }
}
