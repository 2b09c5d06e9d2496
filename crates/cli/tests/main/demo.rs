//! The main job as a command: what it writes over, and what an interrupted run leaves.

use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::{bracketry, code, scratch, text, within};

#[test]
fn the_bare_command_prints_help_and_writes_nothing() {
    let dir = scratch("bare");
    let o = within(&dir, &[]);
    let printed = text(&o.stdout);
    assert!(code(&o) == 0 && printed.contains("Usage") && printed.contains("bracketry demo"), "{printed}");
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
}

#[test]
fn a_folder_with_other_files_is_refused_before_anything_is_computed() {
    let dir = scratch("demo_refused");
    fs::write(dir.join("main.json"), "mine").unwrap();
    let o = bracketry(&["demo", "--out", dir.to_str().unwrap()]);
    let message = text(&o.stderr);
    assert_eq!(code(&o), 2, "{message}");
    assert!(message.contains("main.json") && message.contains("--out"), "{message}");
    assert_eq!(fs::read_to_string(dir.join("main.json")).unwrap(), "mine");
    assert_eq!(fs::read_dir(&dir).unwrap().count(), 1);
}

#[test]
fn an_interrupted_run_leaves_its_chapters_and_says_what_is_missing() {
    let dir = scratch("demo_interrupted");
    let out = dir.join("demo");
    let arguments = ["demo", "--out", out.to_str().unwrap()];
    let mut child = Command::new(env!("CARGO_BIN_EXE_bracketry"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Until the first chapter is there: it takes a second, and more on a busy machine.
    let report = out.join("report.txt");
    for _ in 0..600 {
        if out.join("affine.toml").exists() && fs::read_to_string(&report).is_ok_and(|r| r.contains("\n2. ")) {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let report = fs::read_to_string(&report).unwrap();
    assert!(report.contains("1. From the published equations"), "{report}");
    assert!(report.contains("This run has not ended. Missing:") && report.contains("main.json"), "{report}");
    assert!(!out.join("main.json").exists());
}
