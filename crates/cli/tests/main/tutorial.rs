//! What the tutorial shows as printed is what the command prints.

use std::process::Command;

use crate::common::{
    code,
    sessions::{first_difference, sessions},
};

#[test]
fn every_session_of_the_tutorial_prints_what_is_shown() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
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
