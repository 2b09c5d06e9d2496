//! The command `publication`, and where other commands refer to it.

use crate::common::{bracketry, code, json, number, text};
use serde_json::Value;

#[test]
fn every_number_is_listed_and_shown() {
    let list = text(&bracketry(&["publication"]).stdout);
    for number in (1..=23).map(|k| format!("Equation 3.{k} ")).chain((1..=6).map(|k| format!("Figure 3.{k} "))) {
        assert!(list.contains(&number), "{number}: {list}");
    }
    let one = text(&bracketry(&["publication", "3.16"]).stdout);
    for part in ["Equation 3.16", "bracketry_plate::published", "verdict   wrong", "plate 1 --model published"] {
        assert!(one.contains(part), "{part}: {one}");
    }
    assert!(!one.contains("Equation 3.17"));
}

#[test]
fn a_number_may_mean_an_equation_and_a_figure() {
    let both = text(&bracketry(&["publication", "3.4"]).stdout);
    assert!(both.contains("Equation 3.4:") && both.contains("Figure 3.4:"), "{both}");
    for words in [&["publication", "figure", "3.4"][..], &["publication", "Figure 3.4"]] {
        let figure = text(&bracketry(words).stdout);
        assert!(!figure.contains("Equation 3.4:") && figure.contains("Figure 3.4:"), "{figure}");
    }
    let o = bracketry(&["publication", "3.24"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("there is no 3.24"), "{}", text(&o.stderr));
}

#[test]
fn the_json_has_what_the_text_says() {
    let all = json(&["publication", "--json"]);
    assert!(all["publication"].as_str().unwrap().contains("Momeni Kelageri"));
    assert_eq!(all["entries"].as_array().unwrap().len(), 34);
    let one = &json(&["publication", "3.3", "--json"])["entries"][0];
    assert_eq!((one["kind"].as_str(), one["verdict"].as_str()), (Some("equation"), Some("wrong")));
    assert_eq!(one["places"][0]["file"], "crates/stiffness/src/robot/frame.rs");
}

#[test]
fn lines_are_as_wide_as_asked_for() {
    for width in [60, 100, 140] {
        let all = text(&bracketry(&["publication", "all", "--width", &width.to_string()]).stdout);
        let longest = all.lines().map(|line| line.chars().count()).max().unwrap();
        // A path or the name of a test is not broken.
        let broken = all.lines().filter(|line| line.chars().count() > width);
        assert!(broken.clone().all(|line| line.split_whitespace().count() <= 2), "{:?}", broken.collect::<Vec<_>>());
        assert!(longest > width - 10);
    }
}

#[test]
fn a_run_of_the_published_model_refers_to_what_is_wrong_with_it() {
    let run = |model: &str| text(&bracketry(&["plate", "1", "--model", model, "--seconds", "0.5"]).stdout);
    assert!(run("published").contains("bracketry publication 3.16"));
    assert!(!run("point").contains("publication"));
}

/// What the entries say about runs of the experiments is what the commands give that they name.
#[test]
fn runs_give_the_numbers_of_the_entries() {
    let run = |words: &str| -> Value {
        let words: Vec<&str> = words.split(' ').chain(["--json"]).collect();
        serde_json::from_slice(&bracketry(&words).stdout).unwrap()
    };
    let turned = |words: &str| number(&run(words), "/final/phi").to_degrees();
    assert_eq!(turned("plate 1 --model published").trunc(), -20172.0);
    assert_eq!(turned("plate 1 --model published --mu 0.5").trunc(), -21929.0);
    let area = run("plate 1");
    assert_eq!(number(&area, "/final/phi").to_degrees().round(), 121.0);
    let reached = |v: &Value| (100.0 * number(v, "/reached")).round();
    assert_eq!(reached(&area), 1162.0);
    for (words, hundredths) in [
        ("plate 2 --model published", 237.0),
        ("plate 2", 237.0),
        ("plate 2 --omega 4 --model published", 150.0),
        ("plate 3 --model published", 321.0),
        ("plate 3", 291.0),
    ] {
        assert!((reached(&run(words)) - hundredths).abs() <= 1.0, "{words}");
    }
    let stalled = run("plate 3 --model published --mu 0.4");
    assert!(stalled["reached"].is_null() && (1e3 * number(&stalled, "/final/y") + 6.3).abs() < 0.05);
    let o = bracketry(&["publication", "3.16", "--out", "out"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("--out"));
}
