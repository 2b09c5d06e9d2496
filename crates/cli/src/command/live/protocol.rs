//! The messages, each one line of JSON.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Version of the protocol; it changes when a peer of the version before would misunderstand something.
pub(super) const PROTOCOL: u32 = 1;

/// What a peer asks for.
#[derive(Debug)]
pub(super) enum Request {
    Hello(Hello),
    Measure(Measure),
    Set(Set),
    Predict,
    Reset(Reset),
    Heartbeat,
    End,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hello {
    pub(super) protocol: u32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Measure {
    pub(super) y: Numbers,
    pub(super) t: Option<Number>,
    #[serde(default)]
    pub(super) predict: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Set {
    #[serde(default)]
    pub(super) references: BTreeMap<String, OverTime>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, Number>,
    #[serde(default)]
    pub(super) bounds: BTreeMap<String, Bounds>,
    #[serde(default)]
    pub(super) targets: BTreeMap<String, Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Reset {
    pub(super) x0: Option<Numbers>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Nothing {}

/// A number, which may be infinite or NaN: JSON has no such numbers, but some languages write them.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "a number was expected")]
pub(super) enum Number {
    Finite(f64),
    Other(NotFinite),
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) enum NotFinite {
    #[serde(alias = "nan")]
    NaN,
    Infinity,
    #[serde(rename = "-Infinity")]
    MinusInfinity,
}

impl Number {
    pub(super) fn value(self) -> f64 {
        match self {
            Self::Finite(value) => value,
            Self::Other(NotFinite::NaN) => f64::NAN,
            Self::Other(NotFinite::Infinity) => f64::INFINITY,
            Self::Other(NotFinite::MinusInfinity) => f64::NEG_INFINITY,
        }
    }
}

/// Numbers in order or by name; `null` is not measured.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a list of numbers was expected, or an object with numbers by name")]
pub(super) enum Numbers {
    InOrder(Vec<Option<Number>>),
    ByName(BTreeMap<String, Option<Number>>),
}

/// A value from now on, or the values of the next samples.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "a number was expected, or a list of the numbers at the next samples")]
pub(super) enum OverTime {
    Constant(Number),
    Ahead(Vec<Number>),
}

/// Lower and upper bound; `null` is none.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "bounds are [min, max], with null for none")]
pub(super) enum Bounds {
    Both(Option<Number>, Option<Number>),
}

/// What is answered.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Answer<'a> {
    Hello {
        protocol: u32,
        version: &'static str,
        period: f64,
        steps: usize,
        compensated_delay: usize,
        measured: Vec<String>,
        states: Vec<String>,
        inputs: Vec<String>,
        references: Vec<String>,
        parameters: Vec<String>,
        targets: Vec<String>,
    },
    Input {
        sample: usize,
        t: f64,
        u: &'a [f64],
        status: &'static str,
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<&'static str>,
        source: &'static str,
        missed: usize,
        #[serde(skip_serializing_if = "Option::is_none")]
        x: Option<&'a [f64]>,
        feedback_ms: f64,
        prepare_ms: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        prediction: Option<Prediction>,
    },
    Prediction(Prediction),
    Done,
    Heartbeat {
        sample: usize,
    },
    Error {
        code: &'static str,
        message: String,
    },
    End {
        reason: &'static str,
        samples: usize,
        u: &'a [f64],
        status: bracketry::mpc::closed_loop::Counts,
        late: bracketry::mpc::closed_loop::LateSamples,
    },
}

/// What the last plan predicts.
#[derive(Serialize)]
pub(super) struct Prediction {
    pub(super) t: Vec<f64>,
    pub(super) x: Vec<Vec<f64>>,
    pub(super) u: Vec<Vec<f64>>,
}

/// Why a line is no request, with the code of the error.
pub(super) type Refusal = (&'static str, String);

impl Request {
    /// Reads a line. A message without a type is a measurement.
    pub(super) fn read(line: &str) -> Result<Self, Refusal> {
        let value = read_json(line).map_err(|e| ("json", format!("not a JSON object on one line: {e}")))?;
        let Value::Object(mut fields) = value else {
            return Err(("json", "a message must be an object, such as {\"y\": [0, 0]}".to_owned()));
        };
        let kind = match fields.remove("type") {
            None => "measure".to_owned(),
            Some(Value::String(kind)) => kind,
            Some(other) => return Err(("message", format!("the type is {other}: write a name in quotes"))),
        };
        let fields = Value::Object(fields);
        Ok(match kind.as_str() {
            "hello" => Self::Hello(body(&kind, fields)?),
            "measure" => Self::Measure(body(&kind, fields)?),
            "set" => Self::Set(body(&kind, fields)?),
            "predict" => body(&kind, fields).map(|_: Nothing| Self::Predict)?,
            "reset" => Self::Reset(body(&kind, fields)?),
            "heartbeat" => body(&kind, fields).map(|_: Nothing| Self::Heartbeat)?,
            "end" => body(&kind, fields).map(|_: Nothing| Self::End)?,
            _ => {
                let known = "hello, measure, set, predict, reset, heartbeat, end";
                return Err(("message", format!("there is no message of type `{kind}`: the types are {known}")));
            }
        })
    }
}

fn body<T: DeserializeOwned>(kind: &str, fields: Value) -> Result<T, Refusal> {
    serde_json::from_value(fields).map_err(|e| ("message", format!("a message of type `{kind}`: {e}")))
}

/// Some languages write numbers that are not finite as NaN and Infinity, which JSON does not have: they are put in quotes, which
/// [`Number`] reads.
fn read_json(line: &str) -> serde_json::Result<Value> {
    serde_json::from_str(line).or_else(|error| {
        let tolerant = quote_infinite(line);
        if tolerant == line { Err(error) } else { serde_json::from_str(&tolerant).map_err(|_| error) }
    })
}

/// The line with NaN and infinities in quotes.
fn quote_infinite(line: &str) -> String {
    let mut out = String::with_capacity(line.len() + 8);
    let (mut rest, mut quoted) = (line, false);
    while let Some(c) = rest.chars().next() {
        let word = ["-Infinity", "Infinity", "NaN", "nan"].into_iter().find(|w| !quoted && rest.starts_with(w));
        if let Some(word) = word {
            out.extend(["\"", word, "\""]);
            rest = &rest[word.len()..];
            continue;
        }
        quoted ^= c == '"' && !out.ends_with('\\');
        out.push(c);
        rest = &rest[c.len_utf8()..];
    }
    out
}
