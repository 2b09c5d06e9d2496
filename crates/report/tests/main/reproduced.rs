//! The published results: their tests and problem files exist, names are distinct, and the page of the documentation shows them.

use crate::common::{fits, has_entries, root, source, test_exists};
use bracketry_report::reproduced::{Field, Ours, Verdict, found, list_text, page, row_text, rows};
use std::collections::BTreeSet;
use std::path::Path;

#[test]
fn every_result_has_a_reference_a_figure_and_a_verdict() {
    let names: BTreeSet<&str> = rows().map(|row| row.name).collect();
    assert_eq!(names.len(), rows().count());
    assert!(names.len() >= 30, "{}", names.len());
    let entries = source("docs/references.md");
    for row in rows() {
        let name = row.name;
        assert!(name.chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{name}");
        assert!(!row.subject.is_empty() && !row.claim.is_empty() && !row.figure().is_empty(), "{name}");
        assert!(row.verdict == Verdict::Same || !row.remark.is_empty(), "{name}");
        assert_eq!(found(name), [row]);
        // An entry has all authors and the year.
        for reference in row.reference.split("; ") {
            let words: Vec<&str> = reference.split([' ', ',']).filter(|w| !["", "and"].contains(w)).collect();
            let cited = |line: &str| line.starts_with("- ") && words.iter().all(|word| line.contains(word));
            assert!(entries.lines().any(cited), "{name}: {reference}");
        }
    }
    let fields: Vec<Field> = rows().map(|row| row.field).collect();
    assert!(fields.is_sorted_by_key(|field| Field::ALL.iter().position(|f| f == field)));
}

#[test]
fn every_test_exists_and_every_command_names_what_exists() {
    for row in rows() {
        assert!(!row.tests.is_empty(), "{}", row.name);
        row.tests.iter().for_each(|test| test_exists(row.name, test));
        let command = row.command();
        match row.ours {
            Ours::Printed { .. } => assert!(command.starts_with("bracketry "), "{command}"),
            Ours::Asserted(_) => assert!(command.starts_with("cargo test -p bracketry"), "{command}"),
        }
        for word in command.split(' ').filter(|word| Path::new(word).extension().is_some_and(|e| e == "toml")) {
            assert!(root().join(word).exists(), "{command}");
        }
    }
    let command = |name: &str| found(name)[0].command();
    assert_eq!(command("rocking-block").split(" -- ").next(), Some("cargo test -p bracketry-plate --test main"));
    let of_the_workspace = command("cubic-in-the-plane");
    assert!(of_the_workspace.starts_with("cargo test -p bracketry --test main -- verdicts::"), "{of_the_workspace}");
}

#[test]
fn results_are_found_by_author_and_year() {
    assert!(found("Hauser").len() >= 3 && found("hauser").len() == found("Hauser").len());
    assert!(found("1992").iter().all(|row| row.reference.contains("1992")));
    assert!(found("").is_empty() && found("nobody").is_empty());
}

#[test]
fn texts_fit_narrow_and_wide_lines() {
    for width in [60, 80, 200] {
        rows().for_each(|row| fits(&row_text(row, width), width));
        fits(&list_text(rows(), width), width);
    }
}

#[test]
fn the_page_has_the_rows_of_the_command() {
    has_entries("reproduced.md", &page());
}
