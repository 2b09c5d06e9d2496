//! Files and printing shared by the subcommands.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::Context;
use bracketry::plot::{Drawing, PlotError};
use bracketry::report::Figure;
use bracketry::report::html::Page;
use bracketry::system::System;
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
pub(crate) fn figure(drawing: &Result<Drawing, PlotError>, stem: &Path) -> bool {
    let why = match drawing {
        Ok(drawing) => drawing.save(stem).err().map(|e| e.to_string()),
        Err(e) => Some(e.to_string()),
    };
    if let Some(why) = &why {
        warning(&format!("no figure {}: {why}", stem.display()));
    }
    why.is_none()
}

/// Saves figures in a folder, and gives the files with what they show.
pub(crate) fn save_figures(figures: &[Figure], dir: &Path) -> Vec<(String, String)> {
    let drawn = figures.iter().filter(|f| figure(&f.drawing, &dir.join(&f.name)));
    drawn.flat_map(|f| ["svg", "png"].map(|ending| (format!("{}.{ending}", f.name), f.caption.clone()))).collect()
}

/// Files with what is in them, for the links of a page.
pub(crate) fn listed(files: &[(&str, &str)]) -> Vec<(String, String)> {
    files.iter().map(|(name, what)| ((*name).to_owned(), (*what).to_owned())).collect()
}

/// The option of commands that write a page.
#[derive(Args, Clone, Copy)]
pub(crate) struct PageArgs {
    /// Open the page that is written to --out in the browser
    #[arg(long)]
    open: bool,
}

impl PageArgs {
    /// Before anything is computed: there is a folder for the page.
    ///
    /// # Errors
    /// Without one.
    pub(crate) fn check(self, output: &CommonArgs) -> anyhow::Result<()> {
        anyhow::ensure!(!self.open || output.out.is_some(), "--open: no folder is given for the page; add --out DIR");
        Ok(())
    }

    /// Opens a page, where that was asked for; if it cannot be opened, says so.
    pub(crate) fn open(self, page: &Path) {
        let (program, first): (&str, &[&str]) = match std::env::consts::OS {
            "macos" => ("open", &[]),
            "windows" => ("cmd", &["/C", "start", ""]),
            _ => ("xdg-open", &[]),
        };
        if !self.open {
            return;
        }
        let mut command = Command::new(program);
        command.args(first).arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let why = match command.status() {
            Ok(status) if status.success() => return,
            Ok(status) => status.to_string(),
            Err(e) => e.to_string(),
        };
        warning(&format!("cannot open {} with {program}: {why}", page.display()));
    }
}

/// A report of text and JSON, perhaps with figures, for a folder.
pub(crate) struct TextReport<'a> {
    /// Name of its files, without ending.
    pub(crate) name: &'a str,
    /// Title of its page.
    pub(crate) title: String,
    pub(crate) text: &'a str,
    pub(crate) json: &'a str,
    pub(crate) figures: Vec<Figure>,
    /// The model that it is about.
    pub(crate) system: &'a System,
}

impl TextReport<'_> {
    /// Writes it with its page, which is opened where that was asked for.
    pub(crate) fn save(&self, dir: &Path, page: PageArgs) -> anyhow::Result<()> {
        folder(dir)?;
        let file = |ending: &str| format!("{}.{ending}", self.name);
        write(&dir.join(file("txt")), self.text)?;
        write(&dir.join(file("json")), self.json)?;
        let (text, json) = (file("txt"), file("json"));
        let mut files = listed(&[(text.as_str(), "the report as text"), (json.as_str(), "all results, for programs")]);
        files.extend(save_figures(&self.figures, dir));
        let path = dir.join(file("html"));
        write(&path, &Page::of_text(&self.title, self.text, &self.figures, self.system, &files))?;
        page.open(&path);
        Ok(())
    }
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
