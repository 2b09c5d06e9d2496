//! The command `bracketry`, as a library: for its program, for the Python package, which includes it, and for tests.

mod command;
pub mod demo;

use std::ffi::OsString;

use command::{Outcome, style};

/// Runs the command with arguments as a shell passes them, the first of which is its name, and gives the exit code: 0 done, 1 ran
/// but the answer is negative or undecided, or the target was not reached, 2 bad input. It writes to the standard streams, and leaves nothing in their buffers.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match command::parse(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // As `exit` of clap does: help that nobody reads is no failure.
            let _ = error.print();
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    match command::run(cli) {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Negative) => 1,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => 0,
        Err(error) => {
            style::error(&format!("{error:#}"));
            2
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
