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
    /// An angle turns very far.
    LargeAngle {
        /// The state.
        name: String,
        /// Its largest size, rad.
        largest: f64,
    },
}

impl Warning {
    /// What was seen.
    pub fn message(&self) -> String {
        match self {
            Warning::Constant { name, value, .. } => format!("`{name}` is {} throughout", readable(*value)),
            Warning::Lost { name, count, samples } => format!("`{name}`: {count} of {samples} values were lost"),
            Warning::Saturated { name, count } => {
                format!("`{name}` stays at its smallest or largest value for {count} samples in runs")
            }
            Warning::Coarse { name, step } => {
                format!("`{name}` is rounded to multiples of {step:.3e}, as coarse as its noise")
            }
            Warning::Noisy { name } => format!("`{name}` is mostly noise"),
            Warning::Correlated { name, time } => {
                format!("the noise of `{name}` is correlated over about {time:.2e} s")
            }
            Warning::Uneven { jitter } => format!("the steps in time vary by {:.0} %", 100.0 * jitter),
            Warning::Gaps { count, after } => {
                let at: Vec<String> = after.iter().map(ToString::to_string).collect();
                format!("{} in time: the run continues at t = {} s", counted(*count, "gap", "gaps"), at.join(", "))
            }
            Warning::Slow { step } => format!("the samples are {step} s apart"),
            Warning::Unrelated { name, rate, correlation } => {
                format!("`{name}` does not move as `{rate}` indicates (correlation {correlation:.2})")
            }
            Warning::Reversed { name, rate } => format!("`{name}` moves against `{rate}`"),
            Warning::Scaled { name, rate, factor } => {
                format!("`{name}` moves {factor:.3} times as far as `{rate}` indicates")
            }
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
                "t is in seconds: divide it by 1000 if it counts milliseconds, by the rate if it counts samples"
            }
            Warning::Unrelated { .. } => "check that these columns belong together and to the same axis",
            Warning::Reversed { .. } => "one of them has the wrong sign",
            Warning::Scaled { .. } => "check the units and the calibration of these columns",
            Warning::LargeAngle { .. } => "multiply it by pi/180 if it is in degrees",
        }
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut s = serializer.serialize_struct("Warning", 2)?;
        s.serialize_field("message", &self.message())?;
        s.serialize_field("remedy", self.remedy())?;
        s.end()
    }
}
