//! The controller of a problem file for C, and for every language that calls C.
//!
//! The header `include/bracketry.h` is made from these files; the guide is `docs/c.md`. What holds for every function:
//!
//! - A [`BracketryCode`] says whether it worked; [`bracketry_last_error`] says in words what did not.
//! - No panic leaves the library: it ends as [`BracketryCode::Panic`], after which the controller can only be freed.
//! - Null pointers, wrong lengths, texts that are not UTF-8, and numbers that make no sense are refused before anything is changed.
//!
//! Pointers from C have to be dereferenced, which is `unsafe`; this happens in `memory.rs` and `controller.rs` alone.

mod changes;
mod codes;
mod controller;
mod error;
mod memory;
mod names;

pub use changes::{
    bracketry_controller_set_bounds, bracketry_controller_set_parameters, bracketry_controller_set_reference,
    bracketry_controller_set_reference_ahead, bracketry_controller_set_target,
};
pub use codes::{
    BracketryCode, BracketryKind, BracketryOutcome, BracketryReason, BracketrySource, BracketryStatus,
    bracketry_outcome_name, bracketry_reason_name, bracketry_source_name,
};
pub use controller::{
    BracketryController, bracketry_controller_feedback, bracketry_controller_free, bracketry_controller_from_text,
    bracketry_controller_lost, bracketry_controller_new, bracketry_controller_predict, bracketry_controller_prepare,
    bracketry_controller_reset, bracketry_controller_reset_to, bracketry_controller_step,
};
pub use error::{bracketry_last_error, bracketry_version};
pub use names::{
    bracketry_controller_count, bracketry_controller_horizon, bracketry_controller_name, bracketry_controller_period,
};
