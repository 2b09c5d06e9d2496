//! The main job as a command: what it writes over, and what an interrupted run leaves.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::common::{bracketry, code, scratch, text, within};

/// The list of what the command wrote into a folder.
const LIST: &str = ".written-by-bracketry";

/// A line of that list: FNV-1a of the file, and its name.
fn listed(folder: &Path, name: &str) -> String {
    let bytes = fs::read(folder.join(name)).unwrap();
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
    format!("{hash:016x} {name}\n")
}

/// A file as the command would have written it.
fn written(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).unwrap();
    let list = fs::read_to_string(folder.join(LIST)).unwrap_or_default();
    fs::write(folder.join(LIST), list + &listed(folder, name)).unwrap();
}

/// The command at work in a folder.
fn started(folder: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_bracketry"))
        .args(["demo", "--out", folder.to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits up to a minute.
fn wait_until(holds: impl Fn() -> bool) {
    for _ in 0..600 {
        if holds() {
            break;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

/// Why the folder is refused.
fn refusal(folder: &Path) -> String {
    let o = bracketry(&["demo", "--out", folder.to_str().unwrap()]);
    let message = text(&o.stderr);
    assert_eq!(code(&o), 2, "{message}");
    message
}

#[test]
fn what_the_command_wrote_is_replaced_and_everything_else_is_kept() {
    let dir = scratch("demo_replaced");
    written(&dir, "run.csv", "1");
    let mut child = started(&dir);
    wait_until(|| !dir.join("run.csv").exists());
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!dir.join("run.csv").exists());

    let dir = scratch("demo_kept");
    written(&dir, "run.csv", "1");
    fs::write(dir.join("notes.txt"), "mine").unwrap();
    let error = refusal(&dir);
    assert!(error.contains("notes.txt") && error.contains("--out"), "{error}");
    assert_eq!(fs::read_to_string(dir.join("notes.txt")).unwrap(), "mine");
    assert!(dir.join("run.csv").exists());
}

#[test]
fn a_file_that_was_edited_is_kept() {
    let dir = scratch("demo_edited");
    written(&dir, "extended.toml", "a");
    fs::write(dir.join("extended.toml"), "b").unwrap();
    let error = refusal(&dir);
    assert!(error.contains("changed"), "{error}");
    assert_eq!(fs::read_to_string(dir.join("extended.toml")).unwrap(), "b");
}

#[test]
fn a_folder_with_a_folder_in_it_is_refused_untouched() {
    let dir = scratch("demo_other");
    fs::create_dir(dir.join("sub")).unwrap();
    assert!(refusal(&dir).contains("sub"));
    assert!(dir.join("sub").is_dir());
}

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
    let mut child = started(&out);
    // Until the first chapter is there, and on the list: it takes a second, and more on a busy machine.
    let report = out.join("report.txt");
    let on_list = |name: &str| fs::read_to_string(out.join(LIST)).is_ok_and(|list| list.contains(&listed(&out, name)));
    wait_until(|| {
        out.join("affine.toml").exists()
            && fs::read_to_string(&report).is_ok_and(|r| r.contains("\n2. "))
            && on_list("report.txt")
    });
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(on_list("affine.toml") && on_list("report.txt"));
    let report = fs::read_to_string(&report).unwrap();
    assert!(report.contains("1. From the published equations"), "{report}");
    assert!(report.contains("This run has not ended. Missing:") && report.contains("main.json"), "{report}");
    assert!(!out.join("main.json").exists());
}
