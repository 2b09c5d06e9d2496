//! Models of the repository and folders for files.
#![allow(dead_code)]

pub(crate) mod sessions;

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) fn model(name: &str) -> String {
    format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A folder of its own for each test.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&dir);
    fs::create_dir_all(&dir).unwrap();
    dir
}
