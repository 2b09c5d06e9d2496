//! The command `reproduce`, and the figures of its rows.

use crate::common::{bracketry, code, json, root, text, within};
use bracketry::report::reproduced::{Ours, rows};

#[test]
fn results_are_listed_and_shown_by_name_author_and_year() {
    let list = text(&bracketry(&["reproduce"]).stdout);
    assert!(rows().all(|row| list.lines().any(|line| line.starts_with(&format!("{} ", row.name)))), "{list}");
    let one = text(&bracketry(&["reproduce", "brockett-integrator"]).stdout);
    for part in ["Brockett 1983", "bracketry analyze models/brockett_integrator.toml", "verdict   same"] {
        assert!(one.contains(part), "{part}: {one}");
    }
    let several = text(&bracketry(&["reproduce", "Kawski", "1990"]).stdout);
    assert_eq!(several.matches("reference Kawski").count(), 3, "{several}");
    let o = bracketry(&["reproduce", "nobody"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("there is no result nobody"), "{}", text(&o.stderr));
    let o = bracketry(&["reproduce", "all", "--out", "out"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("--out"));
}

#[test]
fn the_data_have_the_command_and_the_figure() {
    let all = json(&["reproduce", "--json"]);
    assert_eq!(all["results"].as_array().unwrap().len(), rows().count());
    let one = &json(&["reproduce", "goddard-rocket", "--json"])["results"][0];
    assert_eq!((one["field"].as_str(), one["verdict"].as_str()), (Some("optimal_control"), Some("same")));
    assert_eq!(one["command"], one["ours"]["printed"]["command"]);
    let asserted = &json(&["reproduce", "rocking-block", "--json"])["results"][0];
    assert!(asserted["command"].as_str().unwrap().starts_with("cargo test -p bracketry-plate"));
}

/// Whether a text with single spaces has a part, in which "…" stands for further digits.
fn has(printed: &str, part: &str) -> bool {
    let Some((head, tail)) = part.split_once('…') else { return printed.contains(part) };
    printed
        .match_indices(head)
        .any(|(at, _)| printed[at + head.len()..].trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(tail))
}

#[test]
fn commands_print_what_the_rows_say() {
    let mut shown = 0;
    for row in rows() {
        let Ours::Printed { command, lines } = row.ours else { continue };
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        let o = within(root(), &words);
        assert_eq!(code(&o), 0, "{command}: {}", text(&o.stderr));
        let printed = text(&o.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
        for line in lines {
            assert!(has(&printed, line), "{}: {line}: {printed}", row.name);
        }
        shown += 1;
    }
    assert!(shown >= 25, "{shown}");
}
