//! Every axis of every figure has a quantity with a unit, where the model states units.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::{bracketry, code, scratch};

/// A damped pendulum (sin θ ≈ θ − θ³/6) on a motor in minutes, with units everywhere.
const MODEL: &str = r#"
name = "pendulum"
time_unit = "min"
states = ["th", "w"]
inputs = ["u"]
[parameters]
k = { value = 4.0, min = 1, max = 9, unit = "1/min²" }
c = { value = 1.0, min = 0.1, max = 3, unit = "1/min" }
[dynamics]
th = "w"
w = "-k*(th - th^3/6) - c*w + u"
[ranges]
u = { min = -6, max = 6 }
[point]
[units]
th = "rad"
w = "rad/min"
u = "rad/min²"
[labels]
th = "angle of the pendulum"
"#;
const PROBLEM: &str = r#"
model = "pendulum.toml"
[run]
x0 = { th = 0.5 }
steps = 20
[horizon]
steps = 20
dt = 0.1
[cost]
stage = "th^2 + 0.1*w^2 + 0.01*u^2"
"#;
const SCENARIO: &str = "duration = 20.0\nsample = 0.02\n[inputs]\nu = \"sin(1.3*t) + 0.6*sin(3.1*t)\"\n";

/// Figures whose horizontal axis has names in place of numbers.
const OF_NAMES: [&str; 3] = ["where", "regimes", "gain"];
/// Axes that count or compare, and so have no unit.
const COUNTS: [&str; 4] = ["bracket length", "dimension", "rounds of brackets", "prediction horizon"];

/// The titles of the axes of a figure: the turned texts, whose lines stand side by side, and the lowest centered text.
fn titles(svg: &str) -> Vec<String> {
    let attribute = |tag: &str, name: &str| -> Option<f64> {
        let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
        rest.split_once('"')?.0.parse().ok()
    };
    let mut turned: BTreeMap<i64, Vec<(f64, String)>> = BTreeMap::new();
    let mut lowest: (f64, String) = (0.0, String::new());
    for part in svg.split("<text").skip(1) {
        let (tag, rest) = part.split_once('>').unwrap();
        let text = rest.split_once("</text>").unwrap().0.trim().replace("&apos;", "'").replace("&#39;", "'");
        let (x, y) = (attribute(tag, "x").unwrap(), attribute(tag, "y").unwrap());
        if tag.contains("rotate(270") {
            turned.entry(y as i64).or_default().push((x, text));
        } else if tag.contains("\"middle\"") && y > lowest.0 {
            lowest = (y, text);
        }
    }
    let joined = turned.into_values().map(|mut lines| {
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines.into_iter().map(|l| l.1).collect::<Vec<_>>().join(" ")
    });
    joined.chain([lowest.1]).collect()
}

#[test]
fn every_axis_has_a_quantity_and_a_unit() {
    let dir = scratch("axes");
    let path = |name: &str| dir.join(name).display().to_string();
    for (name, text) in [("pendulum.toml", MODEL), ("problem.toml", PROBLEM), ("scenario.toml", SCENARIO)] {
        fs::write(dir.join(name), text).unwrap();
    }
    let wrong = MODEL.replace("- c*w", "");
    fs::write(dir.join("wrong.toml"), wrong).unwrap();
    let (model, table) = (path("pendulum.toml"), crate::common::model("shaken_table.toml"));
    let (scenario, log) = (path("scenario.toml"), path("log/trajectory.csv"));
    let mut figures = 0;
    for (out, arguments) in [
        ("log", vec!["simulate", &model, "--scenario", &scenario, "--noise", "th=0.001,w=0.001"]),
        ("control", vec!["control", &path("problem.toml")]),
        ("analyze", vec!["analyze", &model]),
        ("map", vec!["analyze", &model, "--map", "k=1..9,c=0.1..3", "--cells", "5"]),
        ("certify", vec!["certify", &model, "--with", "u=0", "--find", "region", "--degree", "2"]),
        ("steer", vec!["steer", &model, "--to", "th=0.5"]),
        ("rest", vec!["analyze", &table, "--from-rest", "--bounds", "der(X,2)=-4..4"]),
        ("diagnose", vec!["diagnose", &path("wrong.toml"), &log]),
    ] {
        let folder = path(out);
        let ran = bracketry(&[arguments.as_slice(), &["--out", &folder]].concat());
        assert!(code(&ran) < 2, "{out}: {}", String::from_utf8_lossy(&ran.stderr));
        let Ok(files) = fs::read_dir(Path::new(&folder)) else { continue };
        for file in files.map(|f| f.unwrap().path()).filter(|f| f.extension().is_some_and(|e| e == "svg")) {
            figures += 1;
            let mut titles = titles(&fs::read_to_string(&file).unwrap());
            if OF_NAMES.iter().any(|name| file.file_stem().is_some_and(|stem| stem == *name)) {
                titles.pop();
            }
            for title in titles {
                let has_unit = title.ends_with(']') && title.contains('[') && !title.contains("unit of");
                assert!(has_unit || COUNTS.contains(&title.as_str()), "{}: `{title}`", file.display());
                let in_seconds = title.contains("[s]") || title.contains("/s");
                assert_eq!(in_seconds, out == "rest" && in_seconds, "{}: `{title}`", file.display());
            }
        }
    }
    assert!(figures >= 15, "{figures}");
}
