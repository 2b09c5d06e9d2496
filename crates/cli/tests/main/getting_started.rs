//! The guide for a system of one's own: what it shows is what is printed, in order, in one folder.
#![allow(clippy::print_stderr)]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{
    ROOT, scratch,
    sessions::{blocks, first_difference, sessions},
};

fn guide() -> String {
    fs::read_to_string(format!("{ROOT}/docs/getting_started.md")).unwrap()
}

/// Writes the files that the guide shows into a folder. Their first line begins with the name.
fn write_files(dir: &Path) -> usize {
    let files = blocks(&guide(), "toml");
    for text in &files {
        let name = text.strip_prefix("# ").and_then(|t| t.split_once(':')).unwrap().0;
        assert_eq!(*text, fs::read_to_string(format!("{ROOT}/docs/getting_started/{name}")).unwrap(), "{name}");
        fs::write(dir.join(name), text).unwrap();
    }
    files.len()
}

/// Runs every session in a folder.
fn run_sessions(dir: &Path) -> usize {
    let sessions = sessions(&guide());
    for (arguments, shown) in &sessions {
        let o = Command::new(env!("CARGO_BIN_EXE_bracketry")).args(arguments).current_dir(dir).output().unwrap();
        let printed = String::from_utf8(o.stdout).unwrap();
        assert!(o.status.success(), "{arguments:?}: {printed}{}", String::from_utf8_lossy(&o.stderr));
        assert_eq!(first_difference(shown, &printed), None, "{arguments:?} prints\n{printed}");
    }
    sessions.len()
}

#[test]
fn every_command_of_the_guide_prints_what_is_shown() {
    let dir = scratch("getting_started");
    assert_eq!(write_files(&dir), 5);
    assert_eq!(run_sessions(&dir), 6);
    python(&dir);
}

/// The program in Python, where `BRACKETRY_PYTHON` names an interpreter that has the package.
fn python(dir: &Path) {
    let Some(interpreter) = std::env::var_os("BRACKETRY_PYTHON").filter(|v| !v.is_empty()) else {
        eprintln!("BRACKETRY_PYTHON names no interpreter with the package bracketry: its program is not run");
        return;
    };
    let program = blocks(&guide(), "python").concat();
    fs::write(dir.join("guide.py"), program).unwrap();
    let o = Command::new(interpreter).arg("guide.py").current_dir(dir).output().unwrap();
    assert!(o.status.success(), "{}", String::from_utf8_lossy(&o.stderr));
    assert_eq!(blocks(&guide(), "text").last().unwrap(), &String::from_utf8(o.stdout).unwrap());
}

#[test]
fn all_three_front_ends_show_the_same_numbers() {
    let guide = guide();
    let python = blocks(&guide, "text").pop().unwrap();
    let lines: Vec<&str> = python.lines().collect();
    let [growth, position, cost, cause] = lines.as_slice() else { panic!("{python}") };
    let rust = blocks(&guide, "rust").concat();
    let console = blocks(&guide, "console").concat();
    let growth = growth.trim_matches(['[', ']']);
    assert!(rust.contains(&format!("growth, [{growth}]")) && console.contains(&format!("(growth {growth})")));
    assert!(rust.contains(&format!("\"{position}\"")) && console.contains(&format!(" r = {position}")));
    assert!(rust.contains(&format!("\"{cost}\"")) && console.contains(cost.trim_end_matches('0')));
    let (name, value) = cause.split_once(' ').unwrap();
    assert!(rust.contains(name) && rust.contains(value) && console.contains(&format!("viscous_v = {value} ")));
}
