//! What may spoil a conclusion from data.

use bracketry_system::{counted, readable};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// Something about the data that may spoil a conclusion.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A column never changes.
    Constant {
        /// The column.
        name: String,
        /// Its value.
        value: f64,
        /// Whether it drives the model.
        input: bool,
    },
    /// Values were lost.
    Lost {
        /// The column.
        name: String,
        /// How many values.
        count: usize,
        /// Number of samples.
        samples: usize,
    },
    /// A number stands for lost values.
    Sentinel {
        /// The column.
        name: String,
        /// The number.
        value: f64,
        /// How often.
        count: usize,
    },
    /// Samples stand alone, far from their neighbors.
    Outliers {
        /// The column.
        name: String,
        /// How many.
        count: usize,
        /// Number of samples.
        samples: usize,
        /// Times of the first ones, s.
        at: Vec<f64>,
        /// Whether they are left out; too many are kept.
        left_out: bool,
    },
    /// A sensor shows a new value less often than there are rows.
    HeldReadings {
        /// The column.
        name: String,
        /// Rows from one reading to the next.
        every: usize,
    },
    /// Entries of inputs were lost.
    LostInputs {
        /// Entries that are taken from their neighbors.
        filled: usize,
        /// Rows that are left out.
        left_out: usize,
    },
    /// Rows are missing, one at a time.
    MissingRows {
        /// How many.
        count: usize,
    },
    /// Rows are there twice.
    Repeated {
        /// How many.
        count: usize,
    },
    /// Several rows have one time.
    RoundedTimes {
        /// How many have that of a row before.
        count: usize,
    },
    /// Rows of a long run are left out.
    Decimated {
        /// Rows that there were.
        rows: usize,
        /// Rows from one that is kept to the next.
        every: usize,
    },
    /// A column stays at its smallest or largest value.
    Saturated {
        /// The column.
        name: String,
        /// Samples there.
        count: usize,
    },
    /// A column is rounded as coarsely as its noise.
    Coarse {
        /// The column.
        name: String,
        /// Distance of neighboring values.
        step: f64,
    },
    /// A column is mostly noise.
    Noisy {
        /// The column.
        name: String,
    },
    /// The noise of a column is correlated.
    Correlated {
        /// The column.
        name: String,
        /// Time over which it is, s.
        time: f64,
    },
    /// The steps in time vary.
    Uneven {
        /// Standard deviation of the step, over the step.
        jitter: f64,
    },
    /// There are gaps in time.
    Gaps {
        /// How many.
        count: usize,
        /// Times after the first ones, s.
        after: Vec<f64>,
    },
    /// The samples are far apart.
    Slow {
        /// Distance, s.
        step: f64,
    },
    /// A state does not move as its rate says.
    Unrelated {
        /// The state.
        name: String,
        /// Its rate.
        rate: String,
        /// Their correlation.
        correlation: f64,
    },
    /// A state moves against its rate.
    Reversed {
        /// The state.
        name: String,
        /// Its rate.
        rate: String,
    },
    /// A state moves in proportion to what its rate says.
    Scaled {
        /// The state.
        name: String,
        /// Its rate.
        rate: String,
        /// How many times as far.
        factor: f64,
    },
    /// A column is read under another name, or in another unit.
    ReadAs {
        /// The column.
        column: String,
        /// The name in the model.
        name: String,
        /// The units from and to which it is converted.
        units: Option<(String, String)>,
    },
    /// An angle turns very far.
    LargeAngle {
        /// The state.
        name: String,
        /// Its largest size, rad.
        largest: f64,
    },
}

impl Warning {
    /// Whether it says of a column that entries are read as lost.
    pub(super) fn marks_as_lost(&self, column: &str) -> bool {
        match self {
            Warning::Sentinel { name, .. }
            | Warning::HeldReadings { name, .. }
            | Warning::Outliers { name, left_out: true, .. } => name == column,
            _ => false,
        }
    }

    /// How many rows were put where they are missing: nothing counts as measured there.
    pub(super) fn inserted_rows(&self) -> usize {
        if let Warning::MissingRows { count } = self { *count } else { 0 }
    }

    /// How many samples of a column stand alone, if it says so.
    pub(super) fn outliers(&self, column: &str) -> Option<usize> {
        match self {
            Warning::Outliers { name, count, .. } if name == column => Some(*count),
            _ => None,
        }
    }

    /// What was seen.
    pub fn message(&self) -> String {
        match self {
            Warning::Constant { name, value, .. } => format!("`{name}` is {} throughout", readable(*value)),
            Warning::Lost { name, count, samples } => format!("`{name}`: {count} of {samples} values were lost"),
            Warning::Sentinel { name, value, count } => {
                let value = if value.abs() < 1e10 { value.to_string() } else { readable(*value) };
                format!("`{name}` has the value {value} {}, far from all other values", times(*count))
            }
            Warning::Outliers { name, count, samples, at, .. } => {
                let at: Vec<String> = at.iter().map(|t| readable(*t)).collect();
                format!(
                    "`{name}`: {} of {samples} {} alone, far from {} neighbors, first at t = {}",
                    count,
                    if *count == 1 { "value stands" } else { "values stand" },
                    if *count == 1 { "its" } else { "their" },
                    at.join(", ")
                )
            }
            Warning::HeldReadings { name, every } => format!("`{name}` shows a new value only every {every} rows"),
            Warning::LostInputs { filled, left_out } => {
                let parts = [
                    (*filled > 0).then(|| {
                        format!("{} of inputs taken from the neighbors", counted(*filled, "lost entry", "lost entries"))
                    }),
                    (*left_out > 0).then(|| format!("{} without an input left out", counted(*left_out, "row", "rows"))),
                ];
                parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
            }
            Warning::MissingRows { count } => {
                format!("{} missing from an even clock", counted(*count, "single row is", "single rows are"))
            }
            Warning::Repeated { count } => format!("{} left out", counted(*count, "repeated row", "repeated rows")),
            Warning::RoundedTimes { count } => {
                format!("{} the time of the row before", counted(*count, "row has", "rows have"))
            }
            Warning::Decimated { rows, every } => {
                format!("one of every {every} rows is used, of {rows}, with the means of the inputs")
            }
            Warning::Saturated { name, count } => {
                format!("`{name}` stays at its smallest or largest value for {count} samples in runs")
            }
            Warning::Coarse { name, step } => {
                format!("`{name}` is rounded to multiples of {step:.3e}, as coarse as its noise")
            }
            Warning::Noisy { name } => format!("`{name}` is mostly noise"),
            Warning::Correlated { name, time } => {
                format!("the noise of `{name}` is correlated over a time of about {time:.2e}")
            }
            Warning::Uneven { jitter } => format!("the steps in time vary by {:.0} %", 100.0 * jitter),
            Warning::Gaps { count, after } => {
                let at: Vec<String> = after.iter().map(ToString::to_string).collect();
                format!("{} in time: the run continues at t = {}", counted(*count, "gap", "gaps"), at.join(", "))
            }
            Warning::Slow { step } => format!("the samples are {step} s apart"),
            Warning::Unrelated { name, rate, correlation } => {
                format!("`{name}` does not move as `{rate}` indicates (correlation {correlation:.2})")
            }
            Warning::Reversed { name, rate } => format!("`{name}` moves against `{rate}`"),
            Warning::Scaled { name, rate, factor } => {
                format!("`{name}` moves {factor:.3} times as far as `{rate}` indicates")
            }
            Warning::ReadAs { column, name, units: Some((from, to)) } => {
                format!("`{column}` is read as `{name}`, converted from {from} to {to}")
            }
            Warning::ReadAs { column, name, units: None } => format!("`{column}` is read as `{name}`"),
            Warning::LargeAngle { name, largest } => format!("the angle `{name}` reaches {largest:.4} rad"),
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Warning::Constant { input: true, .. } => {
                "its effect cannot be distinguished from an offset; vary it in the experiment"
            }
            Warning::Constant { .. } => {
                "it contains no information on the motion; if it should move, its sensor is dead: remove the column"
            }
            Warning::Sentinel { .. } => "it is read as a lost value; leave such entries empty",
            Warning::HeldReadings { .. } => {
                "the rows between are read as lost values: each reading counts once, at the row where it appears"
            }
            Warning::LostInputs { .. } => {
                "nothing is simulated across rows that are left out; record the inputs at all times"
            }
            Warning::MissingRows { .. } => {
                "inputs there are taken halfway between their neighbors, and nothing counts as measured; check the logger"
            }
            Warning::Repeated { .. } => "check the logger",
            Warning::Outliers { left_out: true, .. } => {
                "they are left out as lost values are; check the sensor and its cable"
            }
            Warning::Outliers { .. } => {
                "they are kept, because they are too many to be outliers; leave these entries empty if they are not measurements"
            }
            Warning::RoundedTimes { .. } => {
                "they are spread evenly until the next time; record the times with more digits"
            }
            Warning::Decimated { .. } => {
                "the measurements between them are on straight lines within their noise; split the run to use all rows"
            }
            Warning::Lost { .. } => "they are omitted; check the sensor if there are many",
            Warning::Saturated { .. } => "if the sensor saturates there, leave these entries empty",
            Warning::Coarse { .. } => "record it with more digits if available",
            Warning::Noisy { .. } => "use larger motions or a better sensor",
            Warning::Correlated { .. } => "it is filtered: a delay of the sensor may be that of the filter",
            Warning::Uneven { .. } => {
                "the times are taken as exact; check that they are measurement times, not logging times"
            }
            Warning::Gaps { .. } => "each part is used with its own initial state",
            Warning::Slow { .. } => {
                "right for a slow process; t is in seconds: divide it by 1000 if it counts milliseconds, by the rate if it counts samples"
            }
            Warning::Unrelated { .. } => "check that these columns belong together and to the same axis",
            Warning::Reversed { .. } => "one of them has the wrong sign",
            Warning::Scaled { .. } => "check the units and the calibration of these columns",
            Warning::ReadAs { .. } => "if this is wrong, rename the column, or correct the unit",
            Warning::LargeAngle { .. } => "multiply it by pi/180 if it is in degrees",
        }
    }
}

/// `once`, `7 times`.
fn times(count: usize) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut s = serializer.serialize_struct("Warning", 2)?;
        s.serialize_field("message", &self.message())?;
        s.serialize_field("remedy", self.remedy())?;
        s.end()
    }
}
