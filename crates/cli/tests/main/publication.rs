//! The command `publication`, and where other commands refer to it.

use crate::common::{bracketry, code, json, text};

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
