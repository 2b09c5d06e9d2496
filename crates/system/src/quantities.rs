//! What the quantities of a model are called and measured in.

use crate::time_unit::TimeUnit;

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
        with_unit(&format!("{label}{name}"), self.unit(name))
    }

    /// The title of the axis of a time, such as `time` or `duration`: `time [s]`.
    pub fn time_title(&self, what: &str) -> String {
        with_unit(what, Some(self.time_unit.name()))
    }
}

/// A quantity with its unit behind it in brackets, as at an axis: `x [m]`; alone where it has none.
pub fn with_unit(quantity: &str, unit: Option<&str>) -> String {
    match unit {
        None | Some("") => quantity.to_owned(),
        Some(unit) => format!("{quantity} [{unit}]"),
    }
}
