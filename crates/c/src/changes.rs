//! What can be changed while a controller runs.

use std::ffi::c_char;

use crate::codes::BracketryCode;
use crate::controller::{BracketryController, with};
use crate::memory::{numbers, text, texts};

/// Gives a reference a value, from the next preparation on.
///
/// # Safety
/// `name` is null or a text that ends with a zero; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_set_reference(
    controller: *mut BracketryController,
    name: *const c_char,
    value: f64,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.set_reference(text(name, "the name")?, value)?)) }
}

/// Gives a reference `n` values at the next samples, one per period from the next sample on; the last one holds.
///
/// # Safety
/// `name` is null or a text that ends with a zero; `values` has `n` numbers; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_set_reference_ahead(
    controller: *mut BracketryController,
    name: *const c_char,
    values: *const f64,
    n: usize,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            Ok(c.live.set_reference_ahead(text(name, "the name")?, numbers(values, n, "the values")?)?)
        })
    }
}

/// Gives `n` parameters of the controller's model values, from the next preparation on: all of them, or none where one is refused.
/// Each has to be one of `live_parameters` in the problem file.
///
/// # Safety
/// `names` has `n` pointers, each null or to a text that ends with a zero; `values` has `n` numbers; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_set_parameters(
    controller: *mut BracketryController,
    names: *const *const c_char,
    values: *const f64,
    n: usize,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            let values = numbers(values, n, "the values")?;
            let names = texts(names, n, "the names")?;
            let pairs: Vec<(&str, f64)> = names.into_iter().zip(values.iter().copied()).collect();
            Ok(c.live.set_parameters(&pairs)?)
        })
    }
}

/// Replaces the bounds of a state or an input; infinite ends are none.
///
/// # Safety
/// `name` is null or a text that ends with a zero; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_set_bounds(
    controller: *mut BracketryController,
    name: *const c_char,
    min: f64,
    max: f64,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.set_bounds(text(name, "the name")?, min, max)?)) }
}

/// Replaces the value of the target of a state.
///
/// # Safety
/// `name` is null or a text that ends with a zero; the handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_set_target(
    controller: *mut BracketryController,
    name: *const c_char,
    value: f64,
) -> BracketryCode {
    // SAFETY: as said above.
    unsafe { with(controller, |c| Ok(c.live.set_target(text(name, "the name")?, value)?)) }
}
