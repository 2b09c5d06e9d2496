//! The command `bracketry`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(bracketry_cli::run(std::env::args_os()))
}
