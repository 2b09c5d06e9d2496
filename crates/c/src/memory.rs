//! Texts and arrays behind pointers from C.

use std::ffi::{CStr, c_char};

use crate::codes::BracketryCode;
use crate::error::Failure;

/// The text behind a pointer; `what` names it in messages.
///
/// # Safety
/// The pointer is null or points to bytes that end with a zero and do not change while the text is used.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, Failure> {
    if pointer.is_null() {
        return Err(Failure::new(BracketryCode::Null, format!("{what} is a null pointer")));
    }
    // SAFETY: the pointer is not null; the caller answers for the rest.
    let bytes = unsafe { CStr::from_ptr(pointer) };
    bytes.to_str().map_err(|_| Failure::new(BracketryCode::Text, format!("{what} is not UTF-8")))
}

/// The numbers behind a pointer.
///
/// # Safety
/// The pointer is null or points to `length` numbers that nobody writes while they are used.
pub(crate) unsafe fn numbers<'a>(pointer: *const f64, length: usize, what: &str) -> Result<&'a [f64], Failure> {
    check(pointer, length, what)?;
    if length == 0 {
        return Ok(&[]);
    }
    // SAFETY: neither null nor misaligned nor too long; the caller answers for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// The texts behind a list of pointers.
///
/// # Safety
/// The pointer is null or points to `length` pointers, each as [`text`] wants it.
pub(crate) unsafe fn texts<'a>(
    pointer: *const *const c_char,
    length: usize,
    what: &str,
) -> Result<Vec<&'a str>, Failure> {
    check(pointer, length, what)?;
    // SAFETY: neither null nor misaligned nor too long; the caller answers for the rest.
    (0..length).map(|i| unsafe { text(pointer.add(i).read(), what) }).collect()
}

/// Refuses a list that cannot be one.
pub(crate) fn check<T>(pointer: *const T, length: usize, what: &str) -> Result<(), Failure> {
    if length > isize::MAX as usize / size_of::<T>() {
        return Err(Failure::new(BracketryCode::Length, format!("{what}: {length} is not a valid array length")));
    }
    if length > 0 && (pointer.is_null() || !pointer.is_aligned()) {
        return Err(Failure::new(BracketryCode::Null, format!("{what} is a null pointer, or not aligned")));
    }
    Ok(())
}

/// Refuses a place for numbers that is not for `expected` of them.
pub(crate) fn check_place(pointer: *const f64, length: usize, expected: usize, what: &str) -> Result<(), Failure> {
    if length != expected {
        let message = format!("{what} has the length {length}; it has to be {expected}");
        return Err(Failure::new(BracketryCode::Length, message));
    }
    check(pointer, length, what)
}

/// Writes numbers to a place that [`check_place`] has found good.
///
/// # Safety
/// The pointer points to a place for that many numbers, which may be where other arguments are.
pub(crate) unsafe fn write(pointer: *mut f64, values: &[f64]) {
    if !values.is_empty() {
        // SAFETY: the caller answers for the place; `values` are the library's own.
        unsafe { std::ptr::copy(values.as_ptr(), pointer, values.len()) };
    }
}
