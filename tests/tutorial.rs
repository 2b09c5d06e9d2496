//! What the tutorial shows as printed is what the command prints.
#![allow(clippy::unwrap_used)]

mod common;

use std::process::Command;

use common::code;

/// Commands and the lines shown below them; the blocks are fenced as `console`.
fn sessions(tutorial: &str) -> Vec<(Vec<String>, Vec<String>)> {
    let mut out = Vec::new();
    for block in tutorial.split("```console\n").skip(1) {
        let block = block.split("```").next().unwrap();
        let mut lines = block.lines();
        let command = lines.next().unwrap().strip_prefix("$ bracketry ").unwrap();
        out.push((command.split(' ').map(str::to_owned).collect(), lines.map(str::to_owned).collect()));
    }
    out
}

/// The first line shown that does not follow in what was printed; `…` stands for any lines, also none.
fn first_difference(shown: &[String], printed: &str) -> Option<String> {
    let mut rest = printed.lines();
    let mut gap = false;
    for line in shown {
        if line == "…" {
            gap = true;
        } else {
            let found = if gap { rest.any(|l| l == line) } else { rest.next() == Some(line.as_str()) };
            if !found {
                return Some(line.clone());
            }
            gap = false;
        }
    }
    (!gap && rest.next().is_some()).then(|| "more lines".to_owned())
}

#[test]
fn every_session_of_the_tutorial_prints_what_is_shown() {
    let root = env!("CARGO_MANIFEST_DIR");
    let tutorial = std::fs::read_to_string(format!("{root}/docs/tutorial.md")).unwrap();
    let sessions = sessions(&tutorial);
    assert!(sessions.len() >= 4);
    for (arguments, shown) in sessions {
        let o = Command::new(env!("CARGO_BIN_EXE_bracketry")).args(&arguments).current_dir(root).output().unwrap();
        assert_eq!(code(&o), 0, "{arguments:?}");
        let printed = String::from_utf8(o.stdout).unwrap();
        let difference = first_difference(&shown, &printed);
        assert_eq!(difference, None, "{arguments:?} prints\n{printed}");
    }
}

#[test]
fn a_line_that_is_not_printed_is_seen() {
    let lines = |t: &str| t.lines().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(first_difference(&lines("a\n…\nc"), "a\nb\nc\n"), None);
    assert_eq!(first_difference(&lines("a\n…"), "a\n"), None);
    assert_eq!(first_difference(&lines("a\nc"), "a\nb\nc\n"), Some("c".to_owned()));
    assert_eq!(first_difference(&lines("…\nb\n…\na"), "a\nb\n"), Some("a".to_owned()));
    assert_eq!(first_difference(&lines("a"), "a\nb\n"), Some("more lines".to_owned()));
}
