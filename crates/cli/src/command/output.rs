//! Files and printing shared by the subcommands.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::plot::{Drawing, PlotError};
use clap::Args;
use serde::Serialize;

use super::ending;
use super::limits::{self, Limits};
use super::style::warning;

/// How a command ended; bad input is an error instead.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Outcome {
    /// Exit code 0.
    Done,
    /// Ran, but the answer is negative or undecided, or the target was not reached: exit code 1.
    Negative,
}

/// What every command takes: where results go, and its memory.
#[derive(Args, Clone)]
pub(crate) struct CommonArgs {
    /// Print one JSON object instead of the human-readable report
    #[arg(long, global = true, display_order = 1001)]
    pub(crate) json: bool,
    /// Folder for files and plots
    #[arg(long, global = true, display_order = 1000, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Stop before the process takes more memory than this, such as 4GB [default: half of the memory of the machine]
    #[arg(long, global = true, display_order = 1002, value_name = "SIZE", value_parser = limits::bytes)]
    pub(crate) memory_limit: Option<u64>,
    /// The limits of the command that runs.
    #[arg(skip)]
    pub(crate) limits: Limits,
}

/// Writes to standard output at once. A reader that has gone away is an error like any other, not a panic.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    ending::has_printed();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to standard output")
}

/// [`print`] with a line break at the end.
pub(crate) fn line(text: &str) -> anyhow::Result<()> {
    print(&format!("{text}\n"))
}

/// Saves a figure as SVG and PNG; says whether there is one. One that cannot be drawn (numbers too large for an axis) is said to be
/// missing; the results beside it are worth keeping.
pub(crate) fn figure(drawing: Result<Drawing, PlotError>, stem: &Path) -> bool {
    let saved = drawing.and_then(|d| d.save(stem).map(|_| ()));
    if let Err(e) = &saved {
        warning(&format!("no figure {}: {e}", stem.display()));
    }
    saved.is_ok()
}

/// Makes a folder with its parents.
pub(crate) fn folder(path: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(!path.is_file(), "{}: is a file\n   = give a folder; it is created if necessary", path.display());
    fs::create_dir_all(path).with_context(|| format!("cannot create the folder {}", path.display()))
}

/// Writes a text file.
pub(crate) fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// A value as indented JSON.
pub(crate) fn json<T: Serialize>(value: &T) -> anyhow::Result<String> {
    Ok(serde_json::to_string_pretty(value)? + "\n")
}

/// Writes columns of equal length as CSV; numbers are printed so that they read back exactly.
pub(crate) fn csv<'a>(path: &Path, header: &[String], rows: impl Iterator<Item = &'a [f64]>) -> anyhow::Result<()> {
    let mut writer = csv::Writer::from_path(path).with_context(|| format!("cannot write {}", path.display()))?;
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row.iter().map(ToString::to_string))?;
    }
    writer.flush().with_context(|| format!("cannot write {}", path.display()))
}
