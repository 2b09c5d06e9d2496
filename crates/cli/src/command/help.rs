//! Texts and colors of the help, alike for all commands.

use clap::builder::StyledStr;
use clap::builder::styling::{AnsiColor, Style, Styles};
use std::fmt::Write as _;

/// Colors of help and errors; they are written on terminals alone.
pub(crate) const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default())
    .error(AnsiColor::Red.on_default().bold())
    .valid(AnsiColor::Green.on_default())
    .invalid(AnsiColor::Yellow.on_default());

/// Examples: what each does, and the command.
pub(crate) fn examples(list: &[(&str, &str)]) -> StyledStr {
    let mut text = heading("Examples");
    for (k, (what, command)) in list.iter().enumerate() {
        let gap = if k == 0 { "" } else { "\n" };
        let literal = STYLES.get_literal();
        let _ = write!(text, "{gap}\n  {what}:\n    {literal}{}{literal:#}", on_lines(command));
    }
    text.into()
}

/// Columns of a command that a terminal of 80 columns shows without wrapping it.
const EXAMPLE_COLUMNS: usize = 76;

/// A command in lines that no terminal wraps, broken before options with a backslash, as a shell reads it.
fn on_lines(command: &str) -> String {
    let mut lines = vec![String::new()];
    for (k, part) in command.split(" --").enumerate() {
        let part = if k == 0 { part.to_owned() } else { format!(" --{part}") };
        let last = lines.len() - 1;
        // Two columns for the backslash.
        if k > 0 && lines[last].len() + part.len() + 2 > EXAMPLE_COLUMNS {
            lines.push(format!(" {part}"));
        } else {
            lines[last] += &part;
        }
    }
    lines.join(" \\\n    ")
}

/// [`examples`], then sections of a heading and lines.
pub(crate) fn guide(list: &[(&str, &str)], sections: &[(&str, &str)]) -> StyledStr {
    let mut text = examples(list).ansi().to_string();
    for (name, lines) in sections {
        let _ = write!(text, "\n\n{}\n  {}", heading(name), lines.replace('\n', "\n  "));
    }
    text.into()
}

fn heading(name: &str) -> String {
    let header: &Style = STYLES.get_header();
    format!("{header}{name}:{header:#}")
}

/// What exit codes mean, where nothing more is to be said.
pub(crate) const EXIT_CODES: (&str, &str) = (
    "Exit codes",
    "0  done\n1  ran, but did not find, decide, prove, or reach what was asked for\n2  bad input; the message gives the location and the remedy",
);

/// The same for commands that write files and decide nothing.
pub(crate) const WRITTEN: (&str, &str) =
    ("Exit codes", "0  written\n2  bad input; the message gives the location and the remedy");

/// What numbers are measured in.
pub(crate) const UNITS: (&str, &str) = (
    "Units",
    "All quantities are in the units of the model file. Time is in seconds, unless the model file states another time_unit, such as \"h\". Limits of computing time are always in seconds.",
);
