//! The documents as a reader follows them: every link leads to a file, and to a heading in it, and every command has the options it is shown with.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{ROOT, bracketry};

/// All Markdown files of the repository's documentation with their text.
fn documents() -> Vec<(PathBuf, String)> {
    let root = Path::new(ROOT);
    let listed = ["docs", "docs/records"].into_iter().flat_map(|folder| fs::read_dir(root.join(folder)).unwrap());
    let listed = listed.map(|entry| entry.unwrap().path());
    let files = listed.chain(
        ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "CODE_OF_CONDUCT.md"]
            .map(|name| root.join(name)),
    );
    let files = files.filter(|path| path.extension().is_some_and(|e| e == "md"));
    files.map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

/// The text outside of fenced blocks.
fn prose(text: &str) -> String {
    text.split("\n```").step_by(2).collect::<Vec<_>>().join("\n")
}

/// The anchors of a document: its headings in lower case, with dashes for spaces and without punctuation.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text);
    let headings =
        headings.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let anchor = |heading: &str| -> String {
        let kept = heading.to_lowercase();
        kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
    };
    headings.map(anchor).collect()
}

#[test]
fn every_document_is_listed() {
    let docs = Path::new(ROOT).join("docs");
    let index = fs::read_to_string(docs.join("README.md")).unwrap();
    for (path, _) in documents() {
        let Ok(name) = path.strip_prefix(&docs) else { continue };
        let name = name.to_str().unwrap();
        assert!(name == "README.md" || index.contains(&format!("]({name})")), "{name}");
    }
}

#[test]
fn every_link_leads_to_a_file_and_to_a_heading_in_it() {
    let mut links = 0;
    for (path, text) in documents() {
        for part in prose(&text).split("](").skip(1) {
            let target = part.split([')', ' ']).next().unwrap();
            if target.contains("://") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let to = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            assert!(to.exists(), "{}: {target}", path.display());
            if !anchor.is_empty() {
                let known = anchors(&fs::read_to_string(&to).unwrap());
                assert!(known.contains(anchor), "{}: {target}; there are {known:?}", path.display());
            }
            links += 1;
        }
    }
    assert!(links > 60, "{links}");
}

#[test]
fn a_document_that_names_the_publication_cites_it_or_a_guide_that_does() {
    let cites = |text: &str| text.contains("Momeni Kelageri");
    let guides = ["plate.md", "stiffness.md"];
    let mut naming = 0;
    for (path, text) in documents() {
        let named = ["published model", "published experiment", "published method", "published equations"];
        if path.ends_with("CHANGELOG.md") || !named.iter().any(|words| text.contains(words)) {
            continue;
        }
        let guide =
            guides.iter().any(|guide| text.contains(&format!("{guide})")) || text.contains(&format!("{guide}#")));
        let is_guide = guides.iter().any(|guide| path.ends_with(guide));
        assert!(cites(&text) || (guide && !is_guide), "{}", path.display());
        naming += 1;
    }
    assert!(naming > 8, "{naming}");
    for model in ["plate_published", "plate_published_disk"] {
        assert!(cites(&fs::read_to_string(Path::new(ROOT).join(format!("models/{model}.toml"))).unwrap()), "{model}");
    }
}

/// The short report on the first screen is a part of what the command prints.
#[test]
fn the_report_in_the_readme_is_that_of_the_command() {
    let readme = fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    let shown = readme.split("$ bracketry analyze models/unicycle.toml\n").nth(1).unwrap().split("```").next().unwrap();
    let printed = bracketry(&["analyze", &Path::new(ROOT).join("models/unicycle.toml").display().to_string()]);
    let printed = String::from_utf8(printed.stdout).unwrap();
    let shown: Vec<_> = shown.lines().filter(|line| *line != "…").collect();
    assert_eq!(shown.len(), 4);
    for line in shown {
        assert!(printed.lines().any(|l| l == line), "{line}");
    }
}

#[test]
fn every_file_that_is_named_in_code_exists() {
    let mut named = 0;
    for (path, text) in documents() {
        for code in prose(&text).split('`').skip(1).step_by(2) {
            for word in code.split_whitespace() {
                let looks_real = ["docs/", "models/", "benches/", "notebooks/", "examples/", "crates/", "tests/"]
                    .iter()
                    .any(|folder| word.starts_with(folder));
                if looks_real && !word.contains(['*', '…', '<', '{', ':']) {
                    assert!(Path::new(ROOT).join(word).exists(), "{}: {word}", path.display());
                    named += 1;
                }
            }
        }
    }
    assert!(named > 60, "{named}");
}

/// The words of every command `bracketry …` in a document's code.
fn commands(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter_map(|line| {
        let line = line.trim_start();
        line.strip_prefix("$ bracketry ").or_else(|| line.strip_prefix("bracketry ")).map(str::to_owned)
    });
    let spans = prose(text).split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let spans = spans.into_iter().filter_map(|code| code.strip_prefix("bracketry ").map(str::to_owned));
    let words = |command: String| {
        let command = command.split(" #").next().unwrap_or_default().to_owned();
        command.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    lines.chain(spans).map(words).collect()
}

#[test]
fn every_command_has_the_options_it_is_shown_with() {
    let mut helps: BTreeMap<Vec<String>, String> = BTreeMap::new();
    let mut options = 0;
    for (path, text) in documents() {
        for words in commands(&text) {
            let lower = |word: &&String| word.chars().all(|c| c.is_ascii_lowercase());
            let nested = words.first().is_some_and(|word| word == "stiffness");
            let name: Vec<String> = words.iter().take_while(lower).take(if nested { 2 } else { 1 }).cloned().collect();
            let given = words.iter().filter_map(|word| word.trim_start_matches('[').strip_prefix("--"));
            let given: Vec<String> =
                given.map(|word| word.split(['=', ']', ',', ';', '|']).next().unwrap_or_default().to_owned()).collect();
            if given.is_empty() {
                continue;
            }
            let help = helps.entry(name.clone()).or_insert_with(|| {
                let arguments: Vec<&str> = name.iter().map(String::as_str).chain(["--help"]).collect();
                String::from_utf8(bracketry(&arguments).stdout).unwrap()
            });
            for option in given {
                let known = help
                    .split(|c: char| c.is_whitespace() || ",=[".contains(c))
                    .any(|word| word == format!("--{option}"));
                assert!(known, "{}: bracketry {}: --{option}", path.display(), words.join(" "));
                options += 1;
            }
        }
    }
    assert!(options > 40, "{options}");
}
