//! Columns that are not what the model takes them for.

use std::f64::consts::PI;

use crate::effect::Cause;

/// What is wrong with the columns of the data.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnFault {
    /// A column has another sign or another unit.
    Scaled {
        /// What.
        columns: ScaledColumn,
        /// By what it has to be multiplied.
        by: Rescaling,
    },
    /// Two columns have each other's values.
    Swapped {
        /// One, by name.
        first: String,
        /// The other.
        second: String,
    },
    /// A measured column holds another quantity of the model.
    OtherQuantity {
        /// The column, by name.
        column: String,
        /// What it holds: a state or an output.
        quantity: String,
    },
}

impl ColumnFault {
    /// Its name.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Scaled { by: Rescaling::Sign, .. } => Cause::WrongSign,
            Self::Scaled { .. } => Cause::WrongUnit,
            Self::Swapped { .. } => Cause::SwappedColumns,
            Self::OtherQuantity { .. } => Cause::WrongColumn,
        }
    }

    /// The names of its columns; empty where all that is measured is meant.
    pub fn columns(&self) -> Vec<&str> {
        match self {
            Self::Scaled { columns: ScaledColumn::Column(name), .. } => vec![name],
            Self::Scaled { columns: ScaledColumn::AllMeasured, .. } => Vec::new(),
            Self::Swapped { first, second } => vec![first, second],
            Self::OtherQuantity { column, .. } => vec![column],
        }
    }
}

/// What may have another unit or sign.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScaledColumn {
    /// A measured column or an input, by name.
    Column(String),
    /// Everything measured.
    AllMeasured,
}

/// By what a column is multiplied if it has another unit or sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rescaling {
    /// −1: the other sign.
    Sign,
    /// 10ⁿ: it is in multiples or parts of the unit, as in thousandths with n = −3.
    PowerOfTen(i32),
    /// Another unit of the same quantity.
    Unit(OtherUnit),
    /// The model has that unit, and the column is in the unit of the International System.
    UnitOfModel(OtherUnit),
    /// A temperature on another scale.
    Temperature {
        /// The scale of the column.
        from: TemperatureScale,
        /// That of the model.
        to: TemperatureScale,
    },
}

/// Scales of temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemperatureScale {
    /// K.
    Kelvin,
    /// °C.
    Celsius,
    /// °F.
    Fahrenheit,
}

impl TemperatureScale {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Kelvin, Self::Celsius, Self::Fahrenheit];

    /// The size of a degree in K, and the number at absolute zero.
    fn degree_and_zero(self) -> (f64, f64) {
        match self {
            Self::Kelvin => (1.0, 0.0),
            Self::Celsius => (1.0, -273.15),
            Self::Fahrenheit => (1.0 / 1.8, -459.67),
        }
    }
}

/// Units beside those of the International System.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherUnit {
    /// π/180 rad.
    Degrees,
    /// 2π rad, or 2π rad/s.
    Revolutions,
    /// 2π/60 rad/s.
    RevolutionsPerMinute,
    /// 60 s; a rate per minute is a sixtieth of one per second.
    Minutes,
    /// 0.0254 m.
    Inches,
    /// 1/3.6 m/s: kilometers per hour.
    KilometersPerHour,
    /// 9.80665 m/s², or the weight of a kilogram in N.
    StandardGravity,
}

impl OtherUnit {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Degrees,
        Self::Revolutions,
        Self::RevolutionsPerMinute,
        Self::Minutes,
        Self::Inches,
        Self::KilometersPerHour,
        Self::StandardGravity,
    ];

    /// Its size in the unit of the International System.
    pub fn size(self) -> f64 {
        match self {
            Self::Degrees => PI / 180.0,
            Self::Revolutions => 2.0 * PI,
            Self::RevolutionsPerMinute => PI / 30.0,
            Self::Minutes => 60.0,
            Self::Inches => 0.0254,
            Self::KilometersPerHour => 1.0 / 3.6,
            Self::StandardGravity => 9.80665,
        }
    }
}

impl Rescaling {
    /// All of them, the sign first.
    pub fn all() -> impl Iterator<Item = Self> {
        let tens = [-1, 1, -2, 2, -3, 3, -6, 6, -9, 9].map(Self::PowerOfTen);
        let units = OtherUnit::ALL.into_iter().flat_map(|unit| [Self::Unit(unit), Self::UnitOfModel(unit)]);
        std::iter::once(Self::Sign).chain(tens).chain(units)
    }

    /// All changes of the scale of a temperature.
    pub fn temperatures() -> impl Iterator<Item = Self> {
        let pairs = TemperatureScale::ALL.into_iter().flat_map(|from| TemperatureScale::ALL.map(|to| (from, to)));
        pairs.filter(|(from, to)| from != to).map(|(from, to)| Self::Temperature { from, to })
    }

    /// What is added after the factor: 0 but for temperatures.
    pub fn offset(self) -> f64 {
        match self {
            Self::Temperature { from, to } => to.degree_and_zero().1 - self.factor() * from.degree_and_zero().1,
            _ => 0.0,
        }
    }

    /// The factor.
    pub fn factor(self) -> f64 {
        match self {
            Self::Temperature { from, to } => from.degree_and_zero().0 / to.degree_and_zero().0,
            Self::Sign => -1.0,
            Self::PowerOfTen(n) => 10f64.powi(n),
            Self::Unit(unit) => unit.size(),
            Self::UnitOfModel(unit) => 1.0 / unit.size(),
        }
    }
}
