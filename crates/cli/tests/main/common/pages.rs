//! What every page of a command is made of, without a browser.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Elements that have no end.
const VOID: [&str; 4] = ["meta", "img", "source", "!DOCTYPE"];

/// A tag with its attributes as they are written.
struct Tag<'a> {
    name: &'a str,
    attributes: &'a str,
    /// Names of the elements around it.
    within: Vec<&'a str>,
    /// Text up to the next tag.
    text: &'a str,
}

impl<'a> Tag<'a> {
    fn get(&self, name: &str) -> Option<&'a str> {
        let (_, rest) = self.attributes.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"').unwrap().0)
    }
}

/// Every tag in order; each is closed where the one before it was.
fn tags(page: &str) -> Vec<Tag<'_>> {
    let (mut open, mut found, mut rest): (Vec<&str>, Vec<Tag>, &str) = (Vec::new(), Vec::new(), page);
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix("!--") {
            rest = &after[after.find("-->").unwrap() + 3..];
            continue;
        }
        let end = rest.find('>').expect("a tag ends");
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name.trim()), "closed out of turn");
            continue;
        }
        let name = tag.split_whitespace().next().unwrap().trim_end_matches('/');
        let text = &rest[..rest.find('<').unwrap_or(rest.len())];
        found.push(Tag { name, attributes: &tag[name.len()..], within: open.clone(), text });
        if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
        // What stands in these is no HTML.
        if matches!(name, "script" | "style") {
            rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
    found
}

/// The page has one title and one main part, headings in order, contents that list them, no id twice, links that lead somewhere, and loads
/// nothing. `folder` is where it lies; without one it has no links to files.
pub(crate) fn assert_page(page: &str, folder: Option<&Path>) {
    let tags = tags(page);
    let of = |name: &str| tags.iter().filter(|t| t.name == name).count();
    assert_eq!((of("main"), of("h1"), of("nav")), (1, 1, 1));
    let ids: Vec<&str> = tags.iter().filter_map(|t| t.get("id")).collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "an id stands twice: {ids:?}");
    let headings: Vec<(usize, &Tag)> = tags
        .iter()
        .filter_map(|t| Some((t.name.strip_prefix('h')?.parse().ok()?, t)))
        .inspect(|(_, t)| assert!(t.within.contains(&"main"), "a heading outside of the text"))
        .collect();
    let levels: Vec<usize> = headings.iter().map(|(level, _)| *level).collect();
    assert!(levels[0] == 1 && levels.windows(2).all(|w| w[1] <= w[0] + 1), "{levels:?}");
    // The contents are the headings of two levels, in order.
    let listed: Vec<(&str, &str)> = tags
        .iter()
        .filter(|t| t.name == "a" && t.within.contains(&"nav"))
        .map(|t| (t.get("href").unwrap().strip_prefix('#').unwrap(), t.text))
        .collect();
    let shown: Vec<(&str, &str)> = headings
        .iter()
        .filter(|(level, _)| [2, 3].contains(level))
        .map(|(_, t)| (t.get("id").unwrap(), t.text))
        .collect();
    assert_eq!(listed, shown);
    for tag in &tags {
        assert!(!["link", "iframe", "object", "embed"].contains(&tag.name), "<{}>", tag.name);
        for attribute in ["src", "srcset"] {
            assert!(tag.get(attribute).is_none_or(|s| s.starts_with("data:")), "{}", tag.attributes);
        }
        if tag.name == "a" && !tag.within.contains(&"nav") {
            let target = tag.get("href").unwrap();
            assert!(folder.is_some_and(|dir| dir.join(target).is_file()), "no file {target}");
        }
        if tag.name == "pre" {
            assert!(tag.within.contains(&"details"), "long text that is not folded");
        }
        if tag.name == "svg" {
            assert!(tag.get("role") == Some("img") && tag.get("aria-label").is_some_and(|l| !l.is_empty()));
        }
    }
    assert!(!page.contains("url(") && !page.contains("@import"));
}

/// Every file beside the page is linked.
pub(crate) fn assert_all_linked(page: &str, out: &Path) {
    for entry in fs::read_dir(out).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(is_page(&path) || page.contains(&format!("href=\"{name}\"")), "{name} has no link");
    }
}

/// Whether a file is a page.
pub(crate) fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "html")
}
