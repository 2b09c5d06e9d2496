//! A table of samples, read as a run of a model with a state, an output and an input with a derivative.

#![no_main]

use std::sync::LazyLock;

use bracketry_diagnose::{Record, RecordSettings};
use bracketry_system::{Columns, Document, Entries, System};
use libfuzzer_sys::fuzz_target;

static MODEL: LazyLock<System> = LazyLock::new(|| {
    System::parse(
        "model.toml",
        "states = [\"x\", \"v\"]\ninputs = [\"u\", \"X\"]\n[dynamics]\nx = \"v\"\nv = \"u - v - der(X, 2)\"\n[outputs]\ny = \"x + v\"\n",
    )
    .expect("a model")
});

fuzz_target!(|text: &str| {
    let document = Document::new("run.csv", text);
    let entries = |name: &str| if name == "t" { Entries::Finite } else { Entries::MayBeLost };
    let Ok(Columns { mut columns, header, lines }) = Columns::parse(&document, entries) else { return };
    assert!(header.len() >= columns.len() && !lines.is_empty());
    assert!(columns.values().all(|column| column.len() == lines.len()));
    let Some(times) = columns.remove("t") else { return };
    let _ = Record::from_columns("run.csv", times, columns, &MODEL, &RecordSettings::default());
});
