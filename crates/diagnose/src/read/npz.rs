//! Columns of NumPy archives.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use bracketry_system::{Document, FileError};
use npyz::{DType, Deserialize, NpyFile, TypeChar};
use zip::ZipArchive;
use zip::result::ZipError;

/// Files, and arrays in them, larger than this are refused.
const MOST_BYTES: u64 = 512 << 20;
/// The header of an array of numbers opens one brace and one parenthesis. The parser of headers tries every way to read what
/// is nested, which takes exponential time on deep nesting.
const MOST_PARENTHESES: usize = 6;

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
        let values = array(&bytes).map_err(refuse)?;
        columns.insert(name, values);
    }
    let lengths: Vec<String> = columns.iter().map(|(name, v)| format!("{name}: {}", v.len())).collect();
    if columns.values().any(|v| columns.values().any(|other| other.len() != v.len())) {
        let message = format!("the arrays differ in length ({})", lengths.join(", "));
        return Err(doc.missing(message, "give one entry per time"));
    }
    Ok((columns, ignored))
}

/// The numbers of an array file, or what is wrong with it.
fn array(bytes: &[u8]) -> Result<Vec<f64>, String> {
    check_header(bytes)?;
    let file = NpyFile::new(bytes).map_err(|e| e.to_string())?;
    let shape = file.shape().to_vec();
    if shape.iter().filter(|n| **n != 1).count() > 1 || shape.is_empty() {
        return Err(format!("has the shape {shape:?}"));
    }
    let DType::Plain(kind) = file.dtype() else {
        return Err("is a table of several types".into());
    };
    let size = kind.size_field();
    match (kind.type_char(), size) {
        (TypeChar::Float, 8) => numbers(file, |v: f64| v),
        (TypeChar::Float, 4) => numbers(file, |v: f32| f64::from(v)),
        (TypeChar::Int, 8) => numbers(file, |v: i64| v as f64),
        (TypeChar::Int, 4) => numbers(file, |v: i32| f64::from(v)),
        (TypeChar::Int, 2) => numbers(file, |v: i16| f64::from(v)),
        (TypeChar::Int, 1) => numbers(file, |v: i8| f64::from(v)),
        (TypeChar::Uint, 8) => numbers(file, |v: u64| v as f64),
        (TypeChar::Uint, 4) => numbers(file, |v: u32| f64::from(v)),
        (TypeChar::Uint, 2) => numbers(file, |v: u16| f64::from(v)),
        (TypeChar::Uint, 1) => numbers(file, |v: u8| f64::from(v)),
        _ => Err(format!("has the type {kind}")),
    }
}

fn numbers<T: Deserialize>(file: NpyFile<&[u8]>, convert: impl Fn(T) -> f64) -> Result<Vec<f64>, String> {
    let items = file.data::<T>().map_err(|e| e.to_string())?;
    items.map(|item| item.map(&convert).map_err(|e| e.to_string())).collect()
}

/// Refuses headers that claim more numbers than the bytes can hold, or that nest deeply.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let wide = bytes.get(6).is_some_and(|version| *version > 1);
    let text = bytes.get(if wide { 12 } else { 10 }..).unwrap_or(&[]);
    let length = match (wide, bytes) {
        (false, [_, _, _, _, _, _, _, _, a, b, ..]) => usize::from(u16::from_le_bytes([*a, *b])),
        (true, [_, _, _, _, _, _, _, _, a, b, c, d, ..]) => u32::from_le_bytes([*a, *b, *c, *d]) as usize,
        _ => return Err("is truncated".into()),
    };
    let header = text.get(..length).ok_or("is truncated")?;
    let header = std::str::from_utf8(header).map_err(|e| e.to_string())?;
    if header.matches(['(', '[', '{']).count() > MOST_PARENTHESES {
        return Err("has a header that does not describe an array of numbers".into());
    }
    let shape = header.split_once("shape").map_or("", |(_, shape)| shape);
    let shape = shape.split_once(')').map_or(shape, |(shape, _)| shape);
    let sizes = shape.split(|c: char| !c.is_ascii_digit()).filter(|digits| !digits.is_empty());
    let mut count = 1u64;
    for digits in sizes {
        let size: u64 = digits.parse().map_err(|_| format!("has {digits} entries"))?;
        count = count.checked_mul(size).filter(|n| *n <= MOST_BYTES).ok_or("has too many entries")?;
    }
    Ok(())
}
