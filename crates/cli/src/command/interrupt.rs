//! Ctrl-C: a first one keeps what is known, a second one ends the command.

use anyhow::Context as _;
use bracketry::symbolic::StopFlag;

/// Exit code of a command that was interrupted, as shells have it.
const INTERRUPTED: i32 = 130;

/// A flag that the first Ctrl-C raises, with a message of what that does; the second one ends the command.
pub(crate) fn ended_by_user(what: &'static str) -> anyhow::Result<StopFlag> {
    let flag = StopFlag::default();
    let raised = flag.clone();
    ctrlc::set_handler(move || {
        if raised.is_raised() {
            std::process::exit(INTERRUPTED);
        }
        raised.raise();
        anstream::eprintln!("interrupted: {what}, and what was found is reported; Ctrl-C again quits at once");
    })
    .context("Ctrl-C cannot be handled")?;
    Ok(flag)
}
