//! The JSON of every command on every model of the repository, beside what is stored in `stored/`: the same keys and
//! values, whatever moves inside. Times are not compared; numbers may differ in their last digits from machine to machine.
//!
//! ```text
//! BRACKETRY_WRITE_STORED=1 cargo test --release -p bracketry-cli --test main stored_output::      # writes them anew
//! BRACKETRY_COMMAND=PATH …                                                                  # with another command
//! BRACKETRY_FULL_TESTS=1 …                                                                  # also what is slow
//! ```

use std::env;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{
    file,
    robots::{log, measurements, unknown},
    root, scratch,
    tier::is_full,
};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::{Map, Value, json};

/// Values that are times of this machine.
const TIMES: [&str; 5] = ["seconds", "wall_seconds", "solve_ms", "times_real_time", "late"];
/// Largest relative difference of two numbers.
const SAME: f64 = 1e-6;
/// How much more than stored anything under the key `effort` may be, where it is not so little that a single step makes the difference.
const BUDGET: f64 = 1.1;
const FEW: f64 = 3.0;
/// The models whose analysis takes most of the time of all; the full tier has them too.
const SLOW_MODELS: [&str; 6] = [
    "chain_of_five_masses.toml",
    "chain_of_masses.toml",
    "plate_point_anisotropic.toml",
    "plate_point_static_level.toml",
    "plate_reduced.toml",
    "race_car.toml",
];
/// The same of the problems.
const SLOW_PROBLEMS: [&str; 4] = [
    "chain_of_five_masses_rest.toml",
    "double_pendulum_cart_do_mpc.toml",
    "polymerization_do_mpc.toml",
    "race_car_lap.toml",
];

/// What a command gives: its exit code, with its JSON, or with its message where it refuses.
fn given(arguments: &[&str], within: &Path) -> Value {
    let command = env::var("BRACKETRY_COMMAND").unwrap_or_else(|_| env!("CARGO_BIN_EXE_bracketry").to_owned());
    let output = Command::new(command).args(arguments).arg("--json").current_dir(within).output().unwrap();
    let code = output.status.code().unwrap();
    if output.stdout.is_empty() {
        return json!({ "code": code, "message": String::from_utf8(output.stderr).unwrap() });
    }
    let mut result: Value = serde_json::from_slice(&output.stdout).unwrap();
    without_times(&mut result);
    json!({ "code": code, "result": result })
}

fn without_times(value: &mut Value) {
    match value {
        Value::Object(entries) => {
            for (key, entry) in entries {
                if TIMES.contains(&key.as_str()) {
                    *entry = Value::Null;
                } else {
                    without_times(entry);
                }
            }
        }
        Value::Array(entries) => entries.iter_mut().for_each(without_times),
        _ => {}
    }
}

/// The places at which two values differ.
fn differences(place: &str, stored: &Value, given: &Value, out: &mut Vec<String>) {
    match (stored, given) {
        (Value::Object(a), Value::Object(b)) => {
            if !a.keys().eq(b.keys().filter(|k| a.contains_key(*k))) {
                out.push(format!("{place}: keys {:?}, now {:?}", keys(a), keys(b)));
            }
            for (key, entry) in a {
                let Some(now) = b.get(key) else { continue };
                if key == "effort" {
                    over_budget(&format!("{place}.{key}"), entry, now, out);
                } else {
                    differences(&format!("{place}.{key}"), entry, now, out);
                }
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (k, (entry, now)) in a.iter().zip(b).enumerate() {
                differences(&format!("{place}[{k}]"), entry, now, out);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            if (a - b).abs() > SAME * a.abs().max(b.abs()).max(1e-6) {
                out.push(format!("{place}: {a}, now {b}"));
            }
        }
        _ if stored != given => out.push(format!("{place}: {stored}, now {given}")),
        _ => {}
    }
}

/// What costs more than a tenth more than is stored. Less is no difference: it is for the next writing.
fn over_budget(place: &str, stored: &Value, now: &Value, out: &mut Vec<String>) {
    let (Some(stored), Some(now)) = (stored.as_object(), now.as_object()) else {
        return out.push(format!("{place}: {stored}, now {now}"));
    };
    for (key, now) in now {
        let budget = BUDGET * stored.get(key).and_then(Value::as_f64).unwrap_or(0.0) + FEW;
        if now.as_f64().is_none_or(|now| now > budget) {
            out.push(format!("{place}.{key}: {now}, budget {budget:.0}"));
        }
    }
}

fn keys(map: &Map<String, Value>) -> Vec<&String> {
    map.keys().collect()
}

/// The files under `models/` for which `kind` holds of their text.
fn files(kind: impl Fn(&str) -> bool) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(root().join("models"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| kind(&fs::read_to_string(path).unwrap()))
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    names
}

fn models() -> Vec<String> {
    files(|text| text.contains("\n[dynamics]"))
}

/// The names without the slow ones, but in the full tier and where results are stored.
fn usual(mut names: Vec<String>, slow: &[&str]) -> Vec<String> {
    let all = is_full() || env::var_os("BRACKETRY_WRITE_STORED").is_some();
    names.retain(|name| all || !slow.contains(&name.as_str()));
    names
}

/// Runs something for each name, on all cores.
fn each(names: Vec<String>, run: impl Fn(&str) -> Value + Sync) -> Map<String, Value> {
    let results: Vec<(String, Value)> = names.into_par_iter().map(|name| (name.clone(), run(&name))).collect();
    results.into_iter().collect()
}

/// Compares named results with the stored ones, or stores them.
fn compare(name: &str, results: Map<String, Value>) {
    compare_but(name, results, &[]);
}

/// [`compare`] where some names may be missing.
fn compare_but(name: &str, results: Map<String, Value>, missing: &[&str]) {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/stored")).join(format!("{name}.json"));
    if env::var_os("BRACKETRY_WRITE_STORED").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, serde_json::to_string_pretty(&results).unwrap() + "\n").unwrap();
        return;
    }
    let mut stored: Map<String, Value> = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    stored.retain(|name, _| results.contains_key(name) || !missing.contains(&name.as_str()));
    assert_eq!(keys(&stored), keys(&results), "what is stored for {name}");
    let stored = Value::Object(stored);
    let mut different = Vec::new();
    differences(name, &stored, &Value::Object(results), &mut different);
    assert!(different.is_empty(), "{}", different.join("\n"));
}

fn on_all_models(command: &str, slow: &[&str]) {
    let models_folder = root().join("models");
    let models = usual(models(), slow);
    compare_but(command, each(models, |model| given(&[command, model], &models_folder)), slow);
}

#[test]
fn analyze_on_every_model() {
    on_all_models("analyze", &SLOW_MODELS);
}

#[test]
fn affinize_on_every_model() {
    on_all_models("affinize", &["plate_disk.toml"]);
}

/// One second with slow sines at all inputs.
#[test]
fn simulate_on_every_model() {
    let dir = scratch("stored_simulate");
    let run = |model: &str| {
        let text = fs::read_to_string(root().join("models").join(model)).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let inputs = table.get("inputs").and_then(toml::Value::as_array).cloned().unwrap_or_default();
        let mut scenario = "duration = 1.0\nsample = 0.25\n[inputs]\n".to_owned();
        for (k, input) in inputs.iter().enumerate() {
            writeln!(scenario, "{} = \"0.1*sin({}*t)\"", input.as_str().unwrap(), k + 2).unwrap();
        }
        let scenario = file(&dir, &format!("of_{model}"), &scenario);
        given(&["simulate", model, "--scenario", &scenario], &root().join("models"))
    };
    compare("simulate", each(models(), run));
}

#[test]
fn control_on_every_problem() {
    let problems = usual(files(|text| text.contains("\n[horizon]")), &SLOW_PROBLEMS);
    let results = each(problems, |problem| given(&["control", problem], &root().join("models")));
    compare_but("control", results, &SLOW_PROBLEMS);
}

/// Two seconds of the published experiments on every model of the contact.
#[test]
fn plate_on_every_model_of_the_contact() {
    let models = ["published", "point", "reduced", "area", "body"];
    let runs = models.iter().flat_map(|model| ["1", "2", "3"].map(|experiment| format!("{model} {experiment}")));
    let run = |name: &str| {
        let (model, experiment) = name.split_once(' ').unwrap();
        given(&["plate", experiment, "--model", model, "--seconds", "2", "--sample", "0.02"], root())
    };
    compare("plate", each(runs.collect(), run));
}

/// A slider with viscous friction in the data and none in the model, and a correct model, from data of a simulation.
#[test]
fn diagnose_finds_the_same() {
    let dir = scratch("stored_diagnose");
    let equations = |force: &str| {
        format!(
            "name = 'slider'\nstates = ['x', 'v']\ninputs = ['u']\n[parameters]\nm = {{ value = 1.2, min = 0.1, max = 10 }}\n\
             c = {{ value = 0.4, min = 0, max = 5 }}\n[dynamics]\nx = 'v'\nv = '(u - {force})/m'\n"
        )
    };
    file(&dir, "truth.toml", &equations("c*sign(v) - 0.5*v"));
    file(&dir, "coulomb.toml", &equations("c*sign(v)"));
    file(&dir, "viscous.toml", &equations("c*v"));
    file(&dir, "s.toml", "duration = 4.0\nsample = 0.01\n[inputs]\nu = \"2*sin(3*t) + sin(7.1*t)\"\n");
    let truth = [
        "simulate",
        "truth.toml",
        "--scenario",
        "s.toml",
        "--noise",
        "x=0.0005,v=0.002",
        "--seed",
        "3",
        "--out",
        "run",
    ];
    assert_eq!(given(&truth, &dir)["code"], 0);
    let diagnosed = |model: &str| {
        let arguments = ["diagnose", model, "run/trajectory.csv", "--hold", "linear"];
        (model.to_owned(), given(&arguments, &dir))
    };
    compare("diagnose", ["coulomb.toml", "viscous.toml"].map(diagnosed).into_iter().collect());
}

#[test]
fn stiffness_finds_the_same() {
    let dir = scratch("stored_stiffness");
    file(&dir, "data.csv", &measurements(12, [1.0; 3]));
    file(&dir, "unknown.toml", &unknown());
    file(&dir, "circle.csv", &log(|_, _, entry| entry));
    let robot = crate::common::model("kr125.toml");
    let mut results = Map::new();
    results.insert("identify".to_owned(), given(&["stiffness", "identify", "data.csv", "unknown.toml"], &dir));
    results.insert("poses".to_owned(), given(&["stiffness", "poses", "data.csv", &robot, "--count", "12"], &dir));
    results.insert("compensate".to_owned(), given(&["stiffness", "compensate", "circle.csv", &robot], &dir));
    results.insert("weigh".to_owned(), given(&["stiffness", "weigh", "data.csv", &robot], &dir));
    compare("stiffness", results);
}
