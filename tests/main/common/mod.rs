//! Models of the repository and folders for files.

// The tests of the command use the rest of it.
#[allow(dead_code)]
pub(crate) mod sessions;

use std::fs;
use std::path::{Path, PathBuf};

use bracketry::system::System;

pub(crate) fn model(name: &str) -> String {
    format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A model of the repository.
pub(crate) fn read(name: &str) -> System {
    System::read(model(&format!("{name}.toml"))).unwrap()
}

/// A folder of its own for each test.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&dir);
    fs::create_dir_all(&dir).unwrap();
    dir
}
