//! Units of time.

use serde::{Serialize, Serializer};

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
    pub(crate) const ALL: [TimeUnit; 9] = [
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
    pub fn parse(text: &str) -> Option<TimeUnit> {
        Self::ALL.into_iter().find(|unit| unit.symbol() == text.replace(['µ', 'μ'], "u"))
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

    /// Its symbol where it has one: nothing for a time without unit.
    pub fn name(self) -> &'static str {
        if self == Self::Dimensionless { "" } else { self.symbol() }
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
