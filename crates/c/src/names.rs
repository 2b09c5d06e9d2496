//! Sizes and names.

use std::ffi::c_char;

use crate::controller::{BracketryController, with};

/// Number of names of a kind (a `BracketryKind`); 0 for another kind, and for a null pointer.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_count(controller: *mut BracketryController, kind: u32) -> usize {
    let mut count = 0;
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            count = c.names.get(kind as usize).map_or(0, Vec::len);
            Ok(())
        })
    };
    count
}

/// A name by its kind (a `BracketryKind`) and index from 0; null where there is none. It belongs to the controller.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_name(
    controller: *mut BracketryController,
    kind: u32,
    index: usize,
) -> *const c_char {
    let mut name = std::ptr::null();
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            let found = c.names.get(kind as usize).and_then(|list| list.get(index));
            name = found.map_or(std::ptr::null(), |n| n.as_ptr());
            Ok(())
        })
    };
    name
}

/// The sampling period in seconds; NaN for a null pointer.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_period(controller: *mut BracketryController) -> f64 {
    let mut period = f64::NAN;
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            period = c.live.period();
            Ok(())
        })
    };
    period
}

/// Number of intervals N of the prediction; 0 for a null pointer.
///
/// # Safety
/// The handle is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bracketry_controller_horizon(controller: *mut BracketryController) -> usize {
    let mut steps = 0;
    // SAFETY: as said above.
    unsafe {
        with(controller, |c| {
            steps = c.live.prediction().steps();
            Ok(())
        })
    };
    steps
}
