//! Parameters of model files set exactly.

use crate::PlateError;
use bracketry_system::System;
use bracketry_system::symbolic::{Pool, Rational};

/// Sets a parameter that must be positive to the shortest decimal that reads as `value`, exactly.
pub(super) fn set_positive(system: &mut System, name: &'static str, value: f64) -> Result<(), PlateError> {
    let bad = PlateError::BadNumber { name, value };
    if !(value.is_finite() && value > 0.0) {
        return Err(bad);
    }
    system.set_parameter(name, exact(value).ok_or(bad)?);
    Ok(())
}

/// Sets a parameter that must not be negative, as [`set_positive`] does.
pub(super) fn set_not_negative(system: &mut System, name: &'static str, value: f64) -> Result<(), PlateError> {
    let bad = PlateError::NegativeNumber { name, value };
    if !(value.is_finite() && value >= 0.0) {
        return Err(bad);
    }
    system.set_parameter(name, exact(value).ok_or(bad)?);
    Ok(())
}

/// The shortest decimal that reads as `value`.
fn exact(value: f64) -> Option<Rational> {
    let mut pool = Pool::new();
    let number = pool.parse(&format!("{value}")).ok()?;
    pool.number(number).cloned()
}
