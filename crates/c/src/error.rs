//! What went wrong, and the border that no panic crosses.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use bracketry_mpc::MpcError;

use crate::codes::BracketryCode;

thread_local! {
    /// The words of the last failure of this thread.
    static LAST: RefCell<CString> = RefCell::default();
}

/// A failure with its code.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: BracketryCode,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(code: BracketryCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }
}

impl From<MpcError> for Failure {
    fn from(e: MpcError) -> Self {
        let code = match e {
            MpcError::Length { .. } => BracketryCode::Length,
            MpcError::Value { .. } | MpcError::EmptyBounds { .. } => BracketryCode::Value,
            MpcError::NoSuchName { .. } => BracketryCode::Name,
            MpcError::Time { .. } => BracketryCode::Time,
            _ => BracketryCode::Controller,
        };
        Self::new(code, e.to_string())
    }
}

/// Does something, and turns every failure, panics among them, into a code and the words of [`bracketry_last_error`].
///
/// What the work had changed when it panicked is not looked at again: see `BracketryController::broken`.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> BracketryCode {
    let failure = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return BracketryCode::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::new(BracketryCode::Panic, format!("a bug in the library: {}", words(panic.as_ref()))),
    };
    let text: Vec<u8> = failure.message.into_bytes().into_iter().filter(|&b| b != 0).collect();
    // Without zeros within, every text is a C string.
    let text = CString::new(text).unwrap_or_default();
    LAST.with(|last| last.replace(text));
    failure.code
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

/// What went wrong in the last call of this thread that failed, with a remedy; empty if none did. It holds until the next call that
/// fails; not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn bracketry_last_error() -> *const c_char {
    LAST.with(|last| last.borrow().as_ptr())
}

/// The version of the library, such as `0.1.0`. Not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn bracketry_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    CStr::from_bytes_with_nul(VERSION.as_bytes()).unwrap_or_default().as_ptr()
}

#[cfg(test)]
mod tests {
    use super::{Failure, LAST, guarded};
    use crate::codes::BracketryCode;

    fn last() -> String {
        LAST.with(|last| last.borrow().to_str().unwrap_or("?").to_owned())
    }

    #[test]
    fn a_panic_becomes_a_code_and_its_words() {
        let list: Vec<f64> = Vec::new();
        assert_eq!(guarded(|| panic!("out of {}", "order")), BracketryCode::Panic);
        assert_eq!(last(), "a bug in the library: out of order");
        assert_eq!(guarded(|| Err(Failure::new(BracketryCode::Value, list[1].to_string()))), BracketryCode::Panic);
        assert!(last().contains("index out of bounds"), "{}", last());
    }

    #[test]
    fn success_keeps_the_last_failure() {
        assert_eq!(guarded(|| Err(Failure::new(BracketryCode::Name, "no\0 such name"))), BracketryCode::Name);
        assert_eq!(guarded(|| Ok(())), BracketryCode::Ok);
        assert_eq!(last(), "no such name");
    }
}
