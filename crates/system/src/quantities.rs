//! What the quantities of a model are called and measured in: `time_unit` and the tables `[units]` and `[labels]` of model files.

use bracketry_files::{Document, FileError, Table, Value};
use bracketry_symbolic::closest_name;
use serde::{Serialize, Serializer};

use crate::rules::ModelError;
use crate::system::System;

/// The unit of time in a model's equations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeUnit {
    /// Nanoseconds, `ns`.
    Nanosecond,
    /// Microseconds, `us`.
    Microsecond,
    /// Milliseconds, `ms`.
    Millisecond,
    /// Seconds, `s`.
    #[default]
    Second,
    /// Minutes, `min`.
    Minute,
    /// Hours, `h`.
    Hour,
    /// Days, `d`.
    Day,
    /// Years of 365.25 days, `a`.
    Year,
    /// Time without a unit, `1`: it has been divided by a time that the equations do not contain.
    Dimensionless,
}

impl TimeUnit {
    /// All of them, from short to long.
    const ALL: [TimeUnit; 9] = [
        Self::Nanosecond,
        Self::Microsecond,
        Self::Millisecond,
        Self::Second,
        Self::Minute,
        Self::Hour,
        Self::Day,
        Self::Year,
        Self::Dimensionless,
    ];

    /// The unit of this symbol, as [`TimeUnit::symbol`] gives it.
    ///
    /// # Errors
    /// [`ModelError`] with the symbols that there are.
    pub fn parse(text: &str) -> Result<TimeUnit, ModelError> {
        let found = Self::ALL.into_iter().find(|unit| unit.symbol() == text.replace(['µ', 'μ'], "u"));
        found.ok_or_else(|| {
            let known = Self::ALL.map(|unit| format!("\"{}\"", unit.symbol())).join(", ");
            ModelError::new(format!("`{text}` is not a unit of time"), format!("write one of {known}"))
        })
    }

    /// Its symbol, as it is written in model files and printed.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Nanosecond => "ns",
            Self::Microsecond => "us",
            Self::Millisecond => "ms",
            Self::Second => "s",
            Self::Minute => "min",
            Self::Hour => "h",
            Self::Day => "d",
            Self::Year => "a",
            Self::Dimensionless => "1",
        }
    }

    /// How many seconds it has; none without a unit.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Nanosecond => Some(1e-9),
            Self::Microsecond => Some(1e-6),
            Self::Millisecond => Some(1e-3),
            Self::Second => Some(1.0),
            Self::Minute => Some(60.0),
            Self::Hour => Some(3600.0),
            Self::Day => Some(86_400.0),
            Self::Year => Some(365.25 * 86_400.0),
            Self::Dimensionless => None,
        }
    }

    /// The unit of frequencies: `Hz`, or `1/h`.
    pub fn frequency(self) -> String {
        match self {
            Self::Second => "Hz".to_owned(),
            Self::Dimensionless => "per unit of time".to_owned(),
            unit => format!("1/{}", unit.symbol()),
        }
    }

    /// Whether it is the second, which is what models mean that state no unit.
    pub fn is_second(&self) -> bool {
        *self == Self::Second
    }

    /// A time in this unit as text: `3 h`, or the number alone where there is no unit.
    pub fn text(self, time: impl std::fmt::Display) -> String {
        match self {
            Self::Dimensionless => time.to_string(),
            unit => format!("{time} {}", unit.symbol()),
        }
    }
}

impl Serialize for TimeUnit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.symbol())
    }
}

/// What one quantity is called and measured in, as free text.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Quantity {
    /// A state, input, output, or algebraic variable.
    name: String,
    /// Its unit.
    unit: Option<String>,
    /// What it is, in words.
    label: Option<String>,
}

/// What the quantities of a model are called and measured in. Reports and axes show it; nothing is converted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Quantities {
    /// The unit of the time.
    pub time_unit: TimeUnit,
    list: Vec<Quantity>,
}

impl Quantities {
    fn entry(&mut self, name: &str) -> &mut Quantity {
        let place = self.list.iter().position(|q| q.name == name).unwrap_or_else(|| {
            self.list.push(Quantity { name: name.to_owned(), unit: None, label: None });
            self.list.len() - 1
        });
        &mut self.list[place]
    }

    /// States the unit of a quantity.
    pub fn set_unit(&mut self, name: &str, unit: impl Into<String>) {
        self.entry(name).unit = Some(unit.into());
    }

    /// States in words what a quantity is.
    pub fn set_label(&mut self, name: &str, label: impl Into<String>) {
        self.entry(name).label = Some(label.into());
    }

    /// The unit of a quantity, if it is stated.
    pub fn unit(&self, name: &str) -> Option<&str> {
        self.list.iter().find(|q| q.name == name)?.unit.as_deref()
    }

    /// What a quantity is, if it is stated.
    pub fn label(&self, name: &str) -> Option<&str> {
        self.list.iter().find(|q| q.name == name)?.label.as_deref()
    }

    /// The unit of a time derivative of a quantity, if that of the quantity is stated: `m/s²` for order 2 of `m`.
    pub fn unit_of_derivative(&self, name: &str, order: u32) -> Option<String> {
        const EXPONENTS: [char; 8] = ['²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
        let (unit, time) = (self.unit(name)?, self.time_unit.symbol());
        if order == 0 || self.time_unit == TimeUnit::Dimensionless {
            return Some(unit.to_owned());
        }
        let written = EXPONENTS.iter().zip(2..);
        let unit = written.fold(unit.to_owned(), |u, (e, k)| u.replace(&format!("^{k}"), &e.to_string()));
        let unit = unit.as_str();
        // m/s once more is m/s².
        let digit = EXPONENTS.iter().position(|&e| unit.ends_with(e));
        let (base, power) = digit.map_or((unit, 1), |k| (unit.trim_end_matches(EXPONENTS[k]), k as u32 + 2));
        let (numerator, before) = match base.strip_suffix(&format!("/{time}")) {
            Some("") | None => (unit, 0),
            Some(numerator) => (numerator, power),
        };
        Some(match before + order {
            1 => format!("{numerator}/{time}"),
            total => match EXPONENTS.get(total as usize - 2) {
                Some(exponent) => format!("{numerator}/{time}{exponent}"),
                None => format!("{numerator}/{time}^{total}"),
            },
        })
    }

    /// The title of an axis: `x [m]`, with the label before the name where there is one.
    pub fn title(&self, name: &str) -> String {
        let label = self.label(name).map_or_else(String::new, |label| format!("{label} "));
        format!("{label}{name}{}", bracketed(self.unit(name)))
    }

    /// The title of an axis for a time derivative: `X'' [m/s²]`.
    pub fn title_of_derivative(&self, name: &str, order: u32) -> String {
        let label = self.label(name).map_or_else(String::new, |label| format!("{label} "));
        let primes = "'".repeat(order as usize);
        format!("{label}{name}{primes}{}", bracketed(self.unit_of_derivative(name, order).as_deref()))
    }

    /// The title of the axis of a time, such as `time` or `duration`: `time [s]`.
    pub fn time_title(&self, what: &str) -> String {
        format!("{what}{}", bracketed(Some(self.time_unit.symbol())))
    }
}

/// A unit as it stands behind the name of a quantity.
fn bracketed(unit: Option<&str>) -> String {
    unit.filter(|unit| !unit.is_empty()).map_or_else(String::new, |unit| format!(" [{unit}]"))
}

impl System {
    /// Everything that has a unit and a label: states, inputs, outputs, algebraic variables.
    pub fn quantity_names(&self) -> Vec<String> {
        let algebraic = self.algebraic.iter().map(|z| self.symbol_name(z.symbol).to_owned());
        let outputs = self.outputs.iter().map(|o| o.0.clone());
        let own = self.state_names().into_iter().chain(self.input_names());
        // An output with the name of a state is that state.
        let mut names: Vec<String> = Vec::new();
        for name in own.chain(outputs).chain(algebraic) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// The units and labels of everything, also of parameters.
    pub fn all_quantities(&self) -> Quantities {
        let mut all = self.quantities.clone();
        for p in &self.parameters {
            if let Some(unit) = p.unit.as_ref().filter(|unit| *unit != "1") {
                all.set_unit(self.symbol_name(p.symbol), unit.clone());
            }
        }
        all
    }

    /// Whether units and labels can be stated of this name.
    ///
    /// # Errors
    /// [`ModelError`] with the names that there are.
    pub(crate) fn check_quantity(&self, name: &str) -> Result<(), ModelError> {
        let known = self.quantity_names();
        // What was eliminated is a definition now.
        if self.definitions.iter().any(|d| d.0 == name) || known.iter().any(|k| k == name) {
            return Ok(());
        }
        if self.parameter_names().iter().any(|p| p == name) {
            let message = format!("the unit of the parameter `{name}` has another place");
            let remedy = format!("write {name} = {{ value = 1.0, unit = \"…\", about = \"…\" }} in [parameters]");
            return Err(ModelError::new(message, remedy));
        }
        let remedy = match closest_name(name, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the model has {}", known.join(", ")),
        };
        Err(ModelError::new(format!("`{name}` is not a state, input, or output"), remedy))
    }
}

/// Reads `time_unit`, `[units]`, and `[labels]`.
pub(crate) fn read_quantities(doc: &Document, table: &Table<'_>, system: &mut System) -> Result<(), FileError> {
    if let (Some(text), Some(value)) = (doc.string(table, "time_unit")?, table.get("time_unit")) {
        system.quantities.time_unit = TimeUnit::parse(&text).map_err(|e| e.at(doc, value.span()))?;
    }
    for (key, set) in [
        ("units", Quantities::set_unit as fn(&mut Quantities, &str, String)),
        ("labels", Quantities::set_label as fn(&mut Quantities, &str, String)),
    ] {
        for (name, value) in doc.sub_table(table, key)?.into_iter().flatten() {
            system.check_quantity(name.get_ref()).map_err(|e| e.at(doc, name.span()))?;
            let Value::String(text) = value.get_ref() else {
                let message = format!("the entry of `{}` in [{key}] is not a text", name.get_ref());
                return Err(doc.error(value.span(), message, format!("write {} = \"…\" in quotes", name.get_ref())));
            };
            set(&mut system.quantities, name.get_ref(), text.to_string());
        }
    }
    Ok(())
}
