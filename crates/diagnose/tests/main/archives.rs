//! Runs in NumPy archives, and files that are none.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use bracketry_diagnose::{RecordSettings, read_record};
use bracketry_system::System;
use proptest::prelude::*;
use zip::write::FileOptions;
use zip::{CompressionMethod, ZipWriter};

const SLIDER: &str = r#"
name = "slider"
states = ["x", "v"]
inputs = ["F"]
dynamics = { x = "v", v = "F - 0.1*sign(v)" }
"#;

fn slider() -> System {
    System::parse("slider.toml", SLIDER).unwrap()
}

fn path(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("bracketry-archives-{}-{name}", std::process::id()))
}

/// A type of NumPy: its name in the header and its bytes, both in little-endian order.
trait Number: Copy {
    const DESCR: &str;
    fn bytes(self) -> Vec<u8>;
}

macro_rules! number {
    ($($type:ty: $descr:literal),*) => {
        $(impl Number for $type {
            const DESCR: &str = $descr;
            fn bytes(self) -> Vec<u8> {
                self.to_le_bytes().to_vec()
            }
        })*
    };
}
number!(f64: "<f8", f32: "<f4", i32: "<i4", u8: "|u1");

/// Writes an array in version 1.0 of NumPy's format.
fn store<T: Number>(npz: &mut ZipWriter<File>, name: &str, shape: &[u64], values: &[T]) {
    let options = FileOptions::default().compression_method(CompressionMethod::Deflated);
    npz.start_file(format!("{name}.npy"), options).unwrap();
    // A comma after each length, for a tuple of one has one too.
    let shape = shape.iter().fold(String::new(), |shape, n| shape + &n.to_string() + ", ");
    let header = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({shape}), }}", T::DESCR);
    // Magic string, version, length, and header fill whole blocks of 64 bytes.
    let length = (header.len() + 11).next_multiple_of(64) - 10;
    npz.write_all(b"\x93NUMPY\x01\x00").unwrap();
    npz.write_all(&u16::try_from(length).unwrap().to_le_bytes()).unwrap();
    writeln!(npz, "{header:<width$}", width = length - 1).unwrap();
    npz.write_all(&values.iter().flat_map(|v| v.bytes()).collect::<Vec<u8>>()).unwrap();
}

fn archive(name: &str, fill: impl FnOnce(&mut ZipWriter<File>)) -> PathBuf {
    let path = path(name);
    let mut npz = ZipWriter::new(File::create(&path).unwrap());
    fill(&mut npz);
    npz.finish().unwrap();
    path
}

fn refused(path: &Path, parts: &[&str]) {
    let message = read_record(path, &slider(), &RecordSettings::default()).unwrap_err().to_string();
    let name = path.display().to_string();
    for part in parts.iter().chain(&[name.as_str()]) {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

#[test]
fn arrays_of_any_number_type_are_columns() {
    let path = archive("types.npz", |npz| {
        store(npz, "t", &[3], &[0.0, 0.5, 1.0]);
        store(npz, "F", &[3, 1], &[1i32, 2, 3]);
        store(npz, "x", &[3], &[0.5f32, f32::NAN, 2.5]);
        store(npz, "other", &[2, 2], &[0u8; 4]);
    });
    let record = read_record(&path, &slider(), &RecordSettings::default()).unwrap();
    assert_eq!(record.times, [0.0, 0.5, 1.0]);
    assert_eq!(record.inputs[0].values, [1.0, 2.0, 3.0]);
    let x = &record.measured[0].values;
    assert!(x[0] == 0.5 && x[1].is_nan() && x[2] == 2.5);
    assert_eq!(record.audit.unwrap().ignored, ["other"]);
}

#[test]
fn archives_that_are_no_table_are_refused() {
    let grid = archive("grid.npz", |npz| {
        store(npz, "t", &[2, 2], &[0.0, 1.0, 2.0, 3.0]);
    });
    refused(&grid, &["array `t`", "[2, 2]", "numpy.savez"]);
    let lengths = archive("lengths.npz", |npz| {
        store(npz, "t", &[2], &[0.0, 1.0]);
        store(npz, "x", &[3], &[0.0, 1.0, 2.0]);
    });
    refused(&lengths, &["t: 2", "x: 3", "one entry per time"]);
    let order = archive("order.npz", |npz| {
        for name in ["t", "x", "F"] {
            store(npz, name, &[3], &[0.0, 2.0, 1.0]);
        }
    });
    refused(&order, &["sample 2", "column `t`", "sort"]);
    let text = path("text.npz");
    std::fs::write(&text, "t,x\n0,1\n").unwrap();
    refused(&text, &["not a NumPy archive", "numpy.savez"]);
    refused(&path("absent.npz"), &["cannot be read"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300), start in 0usize..4) {
        let mut text = ["", "t,F,x\n0,", "t,F,x\n0,1,2\n", "\u{feff}#\nt,x,F,\"der(F,2)\"\n1,2,3,"][start].as_bytes().to_vec();
        text.extend(&bytes);
        for name in ["any.csv", "any.npz"] {
            std::fs::write(path(name), &text).unwrap();
            let _ = read_record(&path(name), &slider(), &RecordSettings::default()).map_err(|e| e.to_string());
        }
    }

    #[test]
    fn any_rows_are_read_or_refused(rows in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>()), 0..40), sorted: bool) {
        let mut rows = rows;
        if sorted {
            rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let lines: Vec<String> = rows.iter().map(|(t, f, x)| format!("{t},{f},{x}")).collect();
        std::fs::write(path("rows.csv"), format!("t,F,x\n{}", lines.join("\n"))).unwrap();
        if let Ok(record) = read_record(&path("rows.csv"), &slider(), &RecordSettings::default()) {
            prop_assert!(record.measured.iter().all(|m| m.noise > 0.0 && m.noise.is_finite()));
            prop_assert!(!record.audit.unwrap().to_string().is_empty());
        }
    }

    #[test]
    fn any_header_of_an_array_is_read_or_refused(
        header in "\\{'descr': ('[<>|=][fiubcSUmM][0-9]{1,20}'|\\[\\('a', '<f8'\\)\\]), 'fortran_order': (True|False), 'shape': \\(([0-9]{1,21},){0,3}\\), \\}|[(\\[]{0,80}|.{0,60}",
        data in prop::collection::vec(any::<u8>(), 0..64),
        version in 0u8..4,
    ) {
        let mut array = b"\x93NUMPY".to_vec();
        array.extend([version, 0]);
        if version > 1 {
            array.extend((header.len() as u32).to_le_bytes());
        } else {
            array.extend((header.len() as u16).to_le_bytes());
        }
        array.extend(header.as_bytes());
        array.extend(&data);
        let path = archive("header.npz", |npz| {
            npz.start_file("t.npy", FileOptions::default()).unwrap();
            npz.write_all(&array).unwrap();
        });
        prop_assert!(read_record(&path, &slider(), &RecordSettings::default()).is_err());
    }
}
