//! The entries on the publication: all are there, what they name exists, and the page of the documentation shows them.

use bracketry_report::publication::{Kind, Verdict, entries, entry_text, found, list_text, page};
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn source(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

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
        for test in entry.tests {
            let (file, name) = test.split_once("::").unwrap();
            let text = source(file);
            assert!(text.contains(&format!("#[test]\nfn {name}()")), "{}: {test}", entry.label());
            let program = source(&format!("{}/main.rs", file.rsplit_once('/').unwrap().0));
            let module = Path::new(file).file_stem().unwrap().to_str().unwrap();
            assert!(program.contains(&format!("mod {module};")), "{test}");
        }
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
    for width in [50, 80, 200] {
        let texts: Vec<String> = entries().map(|e| entry_text(e, width)).chain([list_text(entries(), width)]).collect();
        for line in texts.iter().flat_map(|text| text.lines()) {
            // A single word may be longer, after the word of its section.
            let fits = line.chars().count() <= width || line.split_whitespace().count() <= 2;
            assert!(fits, "{width}: {line}");
            assert_eq!(line.trim_end(), line);
        }
    }
}

/// Between these lines of `docs/publication.md` stand the entries.
const MARKS: [&str; 2] = ["<!-- entries: begin -->\n", "<!-- entries: end -->\n"];

#[test]
fn the_page_has_the_entries_of_the_command() {
    let path = root().join("docs/publication.md");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(MARKS[0]).unwrap();
    let (_, after) = rest.split_once(MARKS[1]).unwrap();
    let fresh = [before, MARKS[0], &page(), MARKS[1], after].concat();
    if std::env::var_os("BRACKETRY_WRITE_DOCS").is_some() {
        fs::write(&path, &fresh).unwrap();
    }
    let now = fs::read_to_string(&path).unwrap();
    assert!(
        now == fresh,
        "docs/publication.md is stale; BRACKETRY_WRITE_DOCS=1 cargo test -p bracketry-report --test main publication:: writes it"
    );
}
