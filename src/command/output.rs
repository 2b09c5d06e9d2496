//! Files and printing shared by the subcommands.

use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::Serialize;

/// Makes a folder with its parents.
pub(crate) fn folder(path: &Path) -> anyhow::Result<()> {
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
