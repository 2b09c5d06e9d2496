//! What drives the inputs of a model: expressions in time, samples, or values held until they are set.

use std::collections::BTreeMap;

use bracketry_system::{Document, FileError, Table};

/// How a sampled signal continues between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// Each value is held until the next sample (zero-order hold).
    #[default]
    Previous,
    /// Straight lines between samples.
    Linear,
}

impl Hold {
    /// The key `hold` of a table: `"previous"`, which is the default, or `"linear"`.
    ///
    /// # Errors
    /// [`FileError`] for another value.
    pub fn read(doc: &Document, table: &Table<'_>) -> Result<Self, FileError> {
        let text = doc.string(table, "hold")?;
        match (text.as_deref(), table.get("hold")) {
            (Some("linear"), _) => Ok(Hold::Linear),
            (Some(other), Some(at)) if other != "previous" => {
                let remedy = "write hold = \"previous\" or hold = \"linear\"";
                Err(doc.error(at.span(), format!("`{other}` is not a hold of samples"), remedy))
            }
            _ => Ok(Hold::Previous),
        }
    }
}

/// A sampled signal. Before the first and after the last sample it keeps the value there.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    pub(crate) times: Vec<f64>,
    pub(crate) values: Vec<f64>,
    pub(crate) hold: Hold,
}

impl Samples {
    /// A signal with `values[i]` at `times[i]` (seconds).
    ///
    /// # Errors
    /// [`InputError::BadSamples`] unless there are as many values as times, at least one, all finite, and the times increase.
    pub fn new(times: Vec<f64>, values: Vec<f64>, hold: Hold) -> Result<Self, InputError> {
        if times.len() != values.len() || times.is_empty() {
            return Err(InputError::BadSamples {
                row: times.len().min(values.len()),
                problem: "times and values differ in number, or there are none",
            });
        }
        for (row, (t, v)) in times.iter().zip(&values).enumerate() {
            if !t.is_finite() || !v.is_finite() {
                return Err(InputError::BadSamples { row, problem: "not a finite number" });
            }
            if row > 0 && times[row - 1] >= *t {
                return Err(InputError::BadSamples { row, problem: "the time does not increase" });
            }
        }
        Ok(Self { times, values, hold })
    }

    /// Value at a time.
    pub fn at(&self, t: f64) -> f64 {
        self.value(self.interval(t), t)
    }

    /// Slope at a time; at a sample, that of the interval after it.
    pub fn slope_at(&self, t: f64) -> f64 {
        self.slope(self.interval(t))
    }

    /// Mean of the value from one time to a later one.
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        self.means(from, to).0
    }

    /// The same, later by a delay in seconds.
    pub(crate) fn delayed(mut self, delay: f64) -> Self {
        if delay != 0.0 {
            for t in &mut self.times {
                *t += delay;
            }
        }
        self
    }

    /// A signal that has had a value for ever, to be continued.
    pub(crate) fn ever(value: f64) -> Self {
        Self { times: vec![f64::NEG_INFINITY], values: vec![value], hold: Hold::Previous }
    }

    /// Goes on with another value from `t` on; what was to come after that is dropped, as is what has ended before `now`.
    pub(crate) fn go_on(&mut self, now: f64, t: f64, value: f64) {
        let kept = self.times.partition_point(|&at| at < t);
        self.times.truncate(kept);
        self.values.truncate(kept);
        self.times.push(t);
        self.values.push(value);
        let ended = self.interval(now).saturating_sub(1);
        self.times.drain(..ended);
        self.values.drain(..ended);
    }

    /// Index of the interval that starts at or before `t`, from 0 (before the first sample) to `len`.
    pub(crate) fn interval(&self, t: f64) -> usize {
        self.times.partition_point(|&at| at <= t)
    }

    /// As [`Samples::interval`], where `t` is probably in the interval `near` or the next one.
    pub(crate) fn interval_near(&self, near: usize, t: f64) -> usize {
        let holds = |i: usize| {
            (i == 0 || self.times.get(i - 1).is_some_and(|from| *from <= t))
                && self.times.get(i).is_none_or(|to| t < *to)
        };
        [near, near + 1].into_iter().find(|&i| i <= self.times.len() && holds(i)).unwrap_or_else(|| self.interval(t))
    }

    /// The formula of the given interval.
    pub(crate) fn line(&self, interval: usize) -> Line {
        let left = interval.saturating_sub(1).min(self.values.len() - 1);
        Line { from: self.times[left], value: self.values[left], slope: self.slope(interval) }
    }

    /// Value at `t` by the formula of the given interval.
    pub(crate) fn value(&self, interval: usize, t: f64) -> f64 {
        self.line(interval).at(t)
    }

    /// Mean of the value and of the slope from one time to a later one.
    pub(crate) fn means(&self, from: f64, to: f64) -> (f64, f64) {
        let (mut value, mut slope, mut t) = (0.0, 0.0, from);
        let mut interval = self.interval(from);
        while t < to {
            let end = self.times.get(interval).map_or(to, |next| next.min(to));
            value += (end - t) * self.value(interval, 0.5 * (t + end));
            slope += (end - t) * self.slope(interval);
            t = end;
            interval += 1;
        }
        (value / (to - from), slope / (to - from))
    }

    /// Slope in the given interval.
    pub(crate) fn slope(&self, interval: usize) -> f64 {
        if self.hold == Hold::Previous || interval == 0 || interval >= self.values.len() {
            return 0.0;
        }
        let (a, b) = (interval - 1, interval);
        (self.values[b] - self.values[a]) / (self.times[b] - self.times[a])
    }
}

/// The value of samples over one interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    from: f64,
    value: f64,
    slope: f64,
}

impl Line {
    /// Value at `t`.
    pub(crate) fn at(self, t: f64) -> f64 {
        // What does not change may have started at minus infinity.
        if self.slope == 0.0 { self.value } else { self.value + self.slope * (t - self.from) }
    }

    pub(crate) fn slope(self) -> f64 {
        self.slope
    }
}

/// What drives one input.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Drive {
    /// An expression in `t`, in parameters and in live names; its derivatives are symbolic.
    Expression(String),
    /// Samples.
    Samples(Samples),
}

/// What drives the inputs of a model, by name. An input that is not mentioned is *held*: it is zero until
/// [`crate::Model::set_input`] gives it another value, and its derivatives are zero. Where only derivatives are given, the
/// model must not use the input itself.
///
/// Where the model gives an input a delay, all of this is what is commanded, and acts later: expressions are taken at t − d, the
/// breaks of samples are shifted, and a held value acts d after it was set. What was commanded before the start is what
/// the expression gives there, the first sample, or zero. A delay has its value at the time the model is compiled.
///
/// ```
/// use bracketry_sim::{Hold, Inputs, Samples};
/// let inputs = Inputs::new()
///     .expression("theta", "A*sin(6*pi*t)*(1 - exp(-t))")
///     .live("A", 0.1)
///     .samples("X", Samples::new(vec![0.0, 0.5], vec![0.0, 0.01], Hold::Linear)?);
/// # Ok::<(), bracketry_sim::InputError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inputs {
    pub(crate) drives: BTreeMap<String, Drive>,
    pub(crate) derivatives: BTreeMap<(String, u32), Samples>,
    pub(crate) live: Vec<(String, f64)>,
}

impl Inputs {
    /// Whether anything drives `input` or one of its derivatives.
    pub fn mentions(&self, input: &str) -> bool {
        self.drives.contains_key(input) || self.derivatives.keys().any(|(name, _)| name == input)
    }

    /// Whether derivatives of `input` are given, but not the input itself.
    pub fn only_derivatives(&self, input: &str) -> bool {
        self.mentions(input) && !self.drives.contains_key(input)
    }

    /// Whether samples drive `input`.
    pub(crate) fn is_sampled(&self, input: &str) -> bool {
        matches!(self.drives.get(input), Some(Drive::Samples(_)))
    }

    /// All inputs held.
    pub fn new() -> Self {
        Self::default()
    }

    /// Drives `input` by an expression in `t` (seconds), the model's parameters and live names. Its time derivatives
    /// are taken symbolically; `sign`, `abs`, `min`, `max` in it become switching functions.
    #[must_use]
    pub fn expression(mut self, input: &str, text: &str) -> Self {
        self.drives.insert(input.to_owned(), Drive::Expression(text.to_owned()));
        self
    }

    /// Drives `input` by samples. Time derivatives that the model uses must be given by [`Inputs::derivative`], except
    /// the first derivative of a linear signal.
    #[must_use]
    pub fn samples(mut self, input: &str, samples: Samples) -> Self {
        self.drives.insert(input.to_owned(), Drive::Samples(samples));
        self
    }

    /// Gives the derivative of `order` of an `input` by samples, as from a column `der(X,2)`. The input itself may be
    /// sampled too, and must be if the model uses it.
    #[must_use]
    pub fn derivative(mut self, input: &str, order: u32, samples: Samples) -> Self {
        self.derivatives.insert((input.to_owned(), order), samples);
        self
    }

    /// Keeps `name` as a number that can be changed while the model runs ([`crate::Model::set_live`]): a parameter of
    /// the model, or a new name that expressions use.
    #[must_use]
    pub fn live(mut self, name: &str, value: f64) -> Self {
        self.live.push((name.to_owned(), value));
        self
    }
}

/// Inputs that do not fit the model, or that mean nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputError {
    /// The model has no such input.
    #[error("the model has no input `{name}`; its inputs are: {}", .known.join(", "))]
    UnknownInput {
        /// The name given.
        name: String,
        /// The inputs of the model.
        known: Vec<String>,
    },
    /// There is no such live name.
    #[error("`{name}` is not a live name of this model")]
    UnknownLive {
        /// The name given.
        name: String,
    },
    /// A live name that is a state or an input.
    #[error("`{name}` is a state or an input and cannot be a live number")]
    NameTaken {
        /// The name given.
        name: String,
    },
    /// An expression that cannot be read.
    #[error("input `{input}`: {source}")]
    Expression {
        /// The input.
        input: String,
        /// What is wrong with it.
        source: bracketry_symbolic::ParseError,
    },
    /// A quantity to keep account of that cannot be read.
    #[error("`{text}`: {source}")]
    Quantity {
        /// The expression.
        text: String,
        /// What is wrong with it.
        source: bracketry_symbolic::ParseError,
    },
    /// A sampled input whose derivative the model uses and nothing gives.
    #[error("the model uses der({input}, {order}), which is not given: add a column der({input},{order})")]
    MissingDerivative {
        /// The input.
        input: String,
        /// Order of the derivative.
        order: u32,
    },
    /// A model that is discrete in time, which is not integrated.
    #[error("the model is discrete in time: it is iterated, not integrated")]
    DiscreteTime,
    /// An input that the model uses, of which only derivatives are given.
    #[error("the model uses `{input}` itself, but only its derivatives are given: add a column {input}")]
    OnlyDerivatives {
        /// The input.
        input: String,
    },
    /// Samples that are no signal.
    #[error("sample {row}: {problem}")]
    BadSamples {
        /// Index of the sample, from 0.
        row: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// The delay of an input is no time.
    #[error("the delay of the input `{input}` is not a valid time: give seconds, at least 0")]
    Delay {
        /// The input.
        input: String,
    },
    /// A static level of dry friction below the sliding level.
    #[error("the static level of `{switch}` is {ratio} times the sliding level: it must be at least 1")]
    StaticLevel {
        /// The switch.
        switch: String,
        /// Static over sliding level.
        ratio: f64,
    },
    /// A switching function that depends on the sign of another.
    #[error("the switching function `{outer}` depends on the sign of `{inner}`, which jumps")]
    NestedJump {
        /// The outer switching function.
        outer: String,
        /// The inner one.
        inner: String,
    },
    /// An expression of the model that cannot be compiled.
    #[error(transparent)]
    Compile(#[from] bracketry_symbolic::CompileError),
    /// A vector has the wrong length.
    #[error("{found} input values for {expected} inputs")]
    WrongLength {
        /// Number of inputs.
        expected: usize,
        /// Number of values.
        found: usize,
    },
}
