//! Running the command and reading what it says; known answers.

#[path = "../../../../../tests/main/common/case_file.rs"]
pub(crate) mod case_file;
#[path = "../../../../../tests/main/common/known_answers.rs"]
pub(crate) mod known_answers;
pub(crate) mod pages;
pub(crate) mod robots;
#[path = "../../../../../tests/main/common/sessions.rs"]
pub(crate) mod sessions;
#[path = "../../../../../tests/main/common/tier.rs"]
pub(crate) mod tier;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// The root of the repository.
pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The root of the repository, without dots in it.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap()
}

pub(crate) fn bracketry(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bracketry")).args(arguments).output().unwrap()
}

pub(crate) fn code(o: &Output) -> i32 {
    o.status.code().unwrap()
}

pub(crate) fn json(arguments: &[&str]) -> Value {
    let o = bracketry(arguments);
    assert_eq!(code(&o), 0, "{}", String::from_utf8_lossy(&o.stderr));
    serde_json::from_slice(&o.stdout).unwrap()
}

/// What the command prints where it succeeds.
pub(crate) fn stdout(arguments: &[&str]) -> String {
    let o = bracketry(arguments);
    assert_eq!(code(&o), 0, "{arguments:?}: {}", String::from_utf8_lossy(&o.stderr));
    String::from_utf8(o.stdout).unwrap()
}

/// A number in a document.
pub(crate) fn number(v: &Value, path: &str) -> f64 {
    v.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {v}"))
}

pub(crate) fn model(name: &str) -> String {
    format!("{}/models/{name}", root().display())
}

/// A folder of its own for each test.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&dir);
    fs::create_dir_all(&dir).unwrap();
    dir
}

pub(crate) fn file(dir: &Path, name: &str, text: &str) -> String {
    let path = dir.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The command, run in a folder.
pub(crate) fn within(dir: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bracketry")).args(arguments).current_dir(dir).output().unwrap()
}
