//! The command `bracketry`.
// Errors and warnings go to standard error.
#![allow(clippy::print_stderr)]

mod command;

use std::process::ExitCode;

use clap::Parser;

use command::{Cli, Outcome};

fn main() -> ExitCode {
    let cli = Cli::parse();
    match command::run(cli) {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Negative) => ExitCode::from(1),
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
