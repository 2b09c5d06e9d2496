//! Checks of entries that name tests, and of the pages that are written from them.

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub(crate) fn source(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// A test `file::name` stands in its file, and the file belongs to the program of its folder.
pub(crate) fn test_exists(label: &str, test: &str) {
    let (file, name) = test.split_once("::").unwrap();
    assert!(source(file).contains(&format!("#[test]\nfn {name}()")), "{label}: {test}");
    let program = source(&format!("{}/main.rs", file.rsplit_once('/').unwrap().0));
    let module = Path::new(file).file_stem().unwrap().to_str().unwrap();
    assert!(program.contains(&format!("mod {module};")), "{test}");
}

/// Lines have at most `width` characters, and none ends with a space.
pub(crate) fn fits(text: &str, width: usize) {
    for line in text.lines() {
        // A single word may be longer, after the word of its section.
        let fits = line.chars().count() <= width || line.split_whitespace().count() <= 2;
        assert!(fits, "{width}: {line}");
        assert_eq!(line.trim_end(), line);
    }
}

/// Between these lines of a document stand its entries.
const MARKS: [&str; 2] = ["<!-- entries: begin -->\n", "<!-- entries: end -->\n"];

/// A document of `docs` has the entries that `page` gives; with `BRACKETRY_WRITE_DOCS` they are written first.
pub(crate) fn has_entries(document: &str, page: &str) {
    let path = root().join("docs").join(document);
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(MARKS[0]).unwrap();
    let (_, after) = rest.split_once(MARKS[1]).unwrap();
    let fresh = [before, MARKS[0], page, MARKS[1], after].concat();
    if std::env::var_os("BRACKETRY_WRITE_DOCS").is_some() {
        fs::write(&path, &fresh).unwrap();
    }
    let now = fs::read_to_string(&path).unwrap();
    let module = document.trim_end_matches(".md");
    assert!(
        now == fresh,
        "docs/{document} is stale; BRACKETRY_WRITE_DOCS=1 cargo test -p bracketry-report --test main {module}:: writes it"
    );
}
