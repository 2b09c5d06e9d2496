//! A folder that a command has to itself: it writes over what it wrote before, and over nothing else.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};

use super::output::{folder, write};

/// The list of what was written, with a checksum of each file.
const LIST: &str = ".written-by-bracketry";

/// The folder.
pub(crate) struct OwnFolder {
    path: PathBuf,
}

impl OwnFolder {
    /// Makes the folder, or empties one that holds only what was written before.
    ///
    /// # Errors
    /// For a folder with anything else in it, or with a file that has been changed since.
    pub(crate) fn open(path: &Path) -> anyhow::Result<Self> {
        folder(path)?;
        let known = fs::read_to_string(path.join(LIST)).unwrap_or_default();
        let known: BTreeMap<&str, &str> =
            known.lines().filter_map(|l| l.split_once(' ')).map(|(c, n)| (n, c)).collect();
        let present = contents(path)?;
        let remedy = "move it, or name another folder with --out";
        for name in &present {
            let file = path.join(name);
            let listed = known.get(name.as_str());
            ensure!(
                listed.is_some() && file.is_file(),
                "{}: was not written by this command, whose folder must hold nothing else\n   = {remedy}",
                file.display()
            );
            ensure!(
                listed == Some(&checksum(&file)?.as_str()),
                "{}: was changed after this command wrote it\n   = {remedy}",
                file.display()
            );
        }
        for name in &present {
            let file = path.join(name);
            fs::remove_file(&file).with_context(|| format!("cannot remove {}", file.display()))?;
        }
        Ok(Self { path: path.to_owned() })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files that are in the folder now.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub(crate) fn names(&self) -> anyhow::Result<Vec<String>> {
        contents(&self.path)
    }

    /// Notes everything that is in the folder now as written by the command.
    ///
    /// # Errors
    /// If the folder cannot be read or the list not be written.
    pub(crate) fn record(&self) -> anyhow::Result<()> {
        let mut list = String::new();
        for name in contents(&self.path)? {
            let _ = writeln!(list, "{} {name}", checksum(&self.path.join(&name))?);
        }
        write(&self.path.join(LIST), &list)
    }
}

/// Names of what is in a folder, but for the list.
fn contents(path: &Path) -> anyhow::Result<Vec<String>> {
    let read = || format!("cannot read the folder {}", path.display());
    let mut names = Vec::new();
    for entry in fs::read_dir(path).with_context(read)? {
        let name = entry.with_context(read)?.file_name().to_string_lossy().into_owned();
        if name != LIST {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

/// FNV-1a of a file.
fn checksum(path: &Path) -> anyhow::Result<String> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    Ok(format!("{hash:016x}"))
}
