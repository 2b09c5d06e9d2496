//! Columns of NumPy archives.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use bracketry_system::{Document, FileError};
use zip::ZipArchive;
use zip::result::ZipError;

use super::npy;

/// Files, and arrays in them, larger than this are refused.
const MOST_BYTES: u64 = 512 << 20;

/// Columns by name, and the names that were not read.
type Columns = (BTreeMap<String, Vec<f64>>, Vec<String>);

/// Reads the arrays of an archive that `wanted` asks for: of numbers, one-dimensional (or with a second dimension of 1), all of
/// one length.
///
/// # Errors
/// [`FileError`] with file, array and remedy.
pub(super) fn read(path: &Path, wanted: impl Fn(&str) -> bool) -> Result<Columns, FileError> {
    let doc = Document::new(path.display().to_string(), "");
    let cannot = |e: std::io::Error| doc.missing(format!("cannot be read: {e}"), "check the path and the permissions");
    let meta = std::fs::metadata(path).map_err(cannot)?;
    if !meta.is_file() {
        return Err(doc.missing("is not a file", "name an archive made by numpy.savez"));
    }
    if meta.len() > MOST_BYTES {
        let message = format!("is larger than {} MiB", MOST_BYTES >> 20);
        return Err(doc.missing(message, "give fewer samples, or use the run in parts"));
    }
    let bytes = std::fs::read(path).map_err(cannot)?;
    let no_archive =
        |e: ZipError| doc.missing(format!("is not a NumPy archive: {e}"), "write it by numpy.savez(file, t=…, x=…)");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(no_archive)?;
    let names: Vec<String> = archive.file_names().filter_map(|f| f.strip_suffix(".npy")).map(str::to_owned).collect();
    let mut columns = BTreeMap::new();
    let mut ignored = Vec::new();
    for name in names {
        if !wanted(&name) {
            ignored.push(name);
            continue;
        }
        let refuse = |problem: String| {
            doc.missing(
                format!("array `{name}`: {problem}"),
                "store one-dimensional arrays of real numbers: numpy.savez",
            )
        };
        let mut bytes = Vec::new();
        let entry = archive.by_name(&format!("{name}.npy")).map_err(|e| refuse(e.to_string()))?;
        entry.take(MOST_BYTES).read_to_end(&mut bytes).map_err(|e| refuse(e.to_string()))?;
        let values = npy::numbers(&bytes).map_err(refuse)?;
        columns.insert(name, values);
    }
    let lengths: Vec<String> = columns.iter().map(|(name, v)| format!("{name}: {}", v.len())).collect();
    if columns.values().any(|v| columns.values().any(|other| other.len() != v.len())) {
        let message = format!("the arrays differ in length ({})", lengths.join(", "));
        return Err(doc.missing(message, "give one entry per time"));
    }
    Ok((columns, ignored))
}
