//! What every model must keep to, wherever it is written.

use bracketry_files::{Document, FileError};
use bracketry_symbolic::Rational;
use rustc_hash::FxHashMap;

use crate::switching::SwitchedForm;
use crate::system::{StaticLevel, System};

/// Names that a model may not declare.
pub const RESERVED: [&str; 20] = [
    "pi", "der", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt",
    "abs", "sign", "min", "max", "unit",
];

/// What is wrong with a model, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}\n   = {remedy}")]
pub struct ModelError {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl ModelError {
    pub(crate) fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        ModelError { message: message.into(), remedy: remedy.into() }
    }

    /// With its place in a file.
    pub(crate) fn at(self, doc: &Document, span: std::ops::Range<usize>) -> FileError {
        doc.error(span, self.message, self.remedy)
    }
}

/// The names that a model has declared, and as what.
#[derive(Default)]
pub(crate) struct Declared(FxHashMap<String, &'static str>);

impl Declared {
    /// Takes a name, which must be well formed, not reserved and new.
    pub(crate) fn add(&mut self, name: &str, kind: &'static str) -> Result<(), ModelError> {
        let mut chars = name.chars();
        let well_formed = chars.next().is_some_and(|c| c.is_alphabetic() || c == '_')
            && chars.all(|c| c.is_alphanumeric() || c == '_');
        if !well_formed {
            return Err(ModelError::new(
                format!("`{name}` is not a name"),
                "use letters, digits, and _, not starting with a digit",
            ));
        }
        if RESERVED.contains(&name) {
            return Err(ModelError::new(format!("`{name}` is reserved"), "choose another name"));
        }
        if let Some(other) = self.0.insert(name.to_owned(), kind) {
            let message = format!("{kind} `{name}` is already declared as a {other}");
            return Err(ModelError::new(message, "names must be unique; rename one of them"));
        }
        Ok(())
    }
}

/// The value of a parameter lies between its bounds, ends included.
pub(crate) fn check_parameter(
    name: &str,
    value: &Rational,
    min: Option<&Rational>,
    max: Option<&Rational>,
) -> Result<(), ModelError> {
    if min.zip(max).is_some_and(|(lo, hi)| lo > hi) {
        return Err(ModelError::new(format!("parameter `{name}` has min above max"), "exchange them"));
    }
    if min.is_some_and(|m| value < m) || max.is_some_and(|m| value > m) {
        return Err(ModelError::new(
            format!("parameter `{name}` lies outside its own min…max"),
            "correct the value or the bounds",
        ));
    }
    Ok(())
}

/// The range of an input holds more than one value.
pub(crate) fn check_range(name: &str, min: Option<&Rational>, max: Option<&Rational>) -> Result<(), ModelError> {
    if min.zip(max).is_some_and(|(lo, hi)| lo >= hi) {
        return Err(ModelError::new(format!("the range of `{name}` is empty or a single value"), "set min below max"));
    }
    Ok(())
}

impl System {
    /// The delay of an input is a time.
    pub(crate) fn check_delay(&self, name: &str, delay: bracketry_symbolic::Expr) -> Result<(), ModelError> {
        match self.value(delay) {
            Some(d) if d >= 0.0 && d.is_finite() => Ok(()),
            _ => Err(ModelError::new(format!("the delay of `{name}` is not a valid time"), "give seconds, at least 0")),
        }
    }

    /// Dry friction acts on what a static level is of.
    pub(crate) fn check_switch(&self, name: &str, form: &SwitchedForm, level: &StaticLevel) -> Result<(), ModelError> {
        if self.switch_of(form, level).is_some() {
            return Ok(());
        }
        let known = form.set_valued_names();
        let remedy = match known.len() {
            0 => "the equations contain no sign and no unit vector".to_owned(),
            _ => format!("write one of: {}", known.join("; ")),
        };
        Err(ModelError::new(format!("no dry friction acts on `{name}`"), remedy))
    }

    /// A static level is constant and not below the sliding level.
    pub(crate) fn check_ratio(&self, name: &str, level: &StaticLevel) -> Result<(), ModelError> {
        let used = self.pool.symbols_of(&[level.ratio]);
        if !used.iter().all(|s| self.parameters.iter().any(|p| p.symbol == *s)) {
            return Err(ModelError::new(
                format!("the static level of `{name}` is not constant"),
                "write a number, or an expression of parameters",
            ));
        }
        match self.value(level.ratio) {
            Some(v) if v >= 1.0 && v.is_finite() => Ok(()),
            _ => Err(ModelError::new(
                format!("the static level of `{name}` is below its sliding level"),
                "give static over sliding level, at least 1",
            )),
        }
    }
}
