//! The entries on the publication: all are there, what they name exists, and the page of the documentation shows them.

use crate::common::{fits, has_entries, source, test_exists};
use bracketry_report::publication::{Kind, Verdict, entries, entry_text, found, list_text, page};

#[test]
fn every_equation_and_figure_has_an_entry_with_a_verdict() {
    let numbers = |kind: Kind| -> Vec<&str> { entries().filter(|e| e.kind == kind).map(|e| e.number).collect() };
    let expected = |last: u32| -> Vec<String> { (1..=last).map(|k| format!("3.{k}")).collect() };
    assert_eq!(numbers(Kind::Equation), expected(23));
    assert_eq!(numbers(Kind::Figure), expected(6));
    for entry in entries() {
        let label = entry.label();
        assert!(!entry.statement.is_empty() && !entry.remark.is_empty() && !entry.places.is_empty(), "{label}");
        assert!(!entry.tests.is_empty(), "{label}");
        assert_eq!(entry.kind == Kind::Question, entry.verdict == Verdict::Answered, "{label}");
        assert!(found(&label) == [entry] && found(entry.number).contains(&entry), "{label}");
    }
}

#[test]
fn every_test_exists_in_its_file_and_module() {
    for entry in entries() {
        entry.tests.iter().for_each(|test| test_exists(&entry.label(), test));
    }
}

#[test]
fn every_function_and_type_is_public_in_its_file() {
    for entry in entries() {
        for place in entry.places {
            let text = source(place.file);
            let Some((path, name)) = place.name.rsplit_once("::") else {
                assert!(place.file.starts_with("models/"), "{}", place.name);
                continue;
            };
            // The folder of the crate, and the declaration; a variant stands in its enum.
            let package = path.split("::").next().unwrap().strip_prefix("bracketry_").unwrap();
            assert!(place.file.starts_with(&format!("crates/{package}/src/")), "{} in {}", place.name, place.file);
            let owner = path.rsplit("::").next().unwrap();
            let declared = ["fn", "struct", "enum"].iter().any(|word| {
                let start = format!("pub {word} {name}");
                text.match_indices(&start)
                    .any(|(at, _)| !text[at + start.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_'))
            });
            let variant = text.contains(&format!("pub enum {owner} {{")) && text.contains(&format!("\n    {name},"));
            assert!(declared || variant, "{} in {}", place.name, place.file);
        }
    }
}

#[test]
fn texts_fit_narrow_and_wide_lines() {
    for width in [45, 80, 200] {
        entries().for_each(|e| fits(&entry_text(e, width), width));
        fits(&list_text(entries(), width), width);
    }
}

#[test]
fn the_page_has_the_entries_of_the_command() {
    has_entries("publication.md", &page());
}
