//! A NumPy archive, read as a run of a model with a state and an input.

#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use bracketry_diagnose::{RecordSettings, read_record};
use bracketry_system::System;
use libfuzzer_sys::fuzz_target;

static MODEL: LazyLock<System> = LazyLock::new(|| {
    System::parse("model.toml", "states = [\"x\"]\ninputs = [\"u\"]\n[dynamics]\nx = \"u - x\"\n").expect("a model")
});

static PATH: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("bracketry-fuzz-{}.npz", std::process::id())));

fuzz_target!(|bytes: &[u8]| {
    std::fs::write(&*PATH, bytes).expect("a folder for temporary files");
    let _ = read_record(&PATH, &MODEL, &RecordSettings::default());
});
