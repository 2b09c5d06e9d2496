//! What a reader of exported source has to know.

use std::fmt;

use bracketry_system::readable;
use serde::Serialize;

/// Something that functions cannot express, or express otherwise than the model does. Its `Display` is the sentence that
/// stands in the exported file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ExportNote {
    /// `sign` and unit vectors have the value 0, and derivatives 0, where they are set-valued.
    SetValued {
        /// The terms, as they are written.
        terms: Vec<String>,
    },
    /// The slope of `abs`, `min`, `max` jumps.
    Kinks,
    /// An input acts later than it is commanded, which a function of the present does not express.
    InputDelay {
        /// Name of the input.
        input: String,
        /// Seconds, as they are written.
        delay: String,
        /// Seconds, parameters at their values; none if that is no number.
        seconds: Option<f64>,
    },
    /// Derivatives of inputs are further entries of u.
    InputDerivatives {
        /// Their names.
        names: Vec<String>,
    },
    /// A static level of friction above the sliding one, which the equations do not contain.
    StaticLevel {
        /// The term that sticks, as it is written.
        term: String,
    },
    /// The model measures nothing: there is no h.
    NoOutputs,
}

impl fmt::Display for ExportNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ExportNote::SetValued { terms } => write!(
                f,
                "set-valued in the model, here 0 with derivatives 0 where the argument is 0: {}. An integrator without \
                 events chatters there; `bracketry simulate` keeps the friction exact",
                terms.join(", ")
            ),
            ExportNote::Kinks => f.write_str(
                "at the kink of abs, min, or max, the Jacobians contain the mean of the slopes on both sides",
            ),
            ExportNote::InputDelay { input, delay, seconds } => {
                let value = match seconds {
                    Some(s) if readable(*s) != *delay => format!("{delay} = {} s", readable(*s)),
                    _ => format!("{delay} s"),
                };
                let simple = delay.chars().all(|c| c.is_alphanumeric() || "._".contains(c));
                let back = if simple { delay.clone() } else { format!("({delay})") };
                write!(
                    f,
                    "the input {input} acts {value} after its command: pass the delayed value, {input}(t - {back})"
                )
            }
            ExportNote::InputDerivatives { names } => {
                write!(
                    f,
                    "the equations use derivatives of inputs, which are additional entries of u: {}",
                    names.join(", ")
                )
            }
            ExportNote::StaticLevel { term } => {
                write!(f, "the static level of {term} is omitted: the functions contain the sliding level only")
            }
            ExportNote::NoOutputs => f.write_str("the model has no outputs: there is no h"),
        }
    }
}
