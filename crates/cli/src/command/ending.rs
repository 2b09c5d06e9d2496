//! The end of a command that reached a limit, while another thread may be writing.

use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

use super::style::error;

static HAS_PRINTED: AtomicBool = AtomicBool::new(false);

/// Notes that a part of the result is written to standard output, which is locked.
pub(crate) fn has_printed() {
    HAS_PRINTED.store(true, Ordering::Relaxed);
}

/// Ends the process with exit code 1 and a message, between two writings to standard output. The message has `nothing` where nothing was
/// written.
pub(crate) fn give_up(why: &str, nothing: &str, remedy: &str) -> ! {
    let _between = std::io::stdout().lock();
    let nothing = if HAS_PRINTED.load(Ordering::Relaxed) { "" } else { nothing };
    error(&format!("{why}{nothing}\n   = {remedy}"));
    exit(1);
}
