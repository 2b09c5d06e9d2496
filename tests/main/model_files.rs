//! The reference of model and scenario files: every file it shows is read, and it knows every key.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::common::{scratch, sessions::blocks};
use bracketry::Scenario;
use bracketry::mpc::ControlProblem;
use bracketry::sim::Outcome;
use bracketry::system::{Accepted, System};

const REFERENCE: &str = include_str!("../../docs/model_files.md");

/// Writes the files that the reference shows, whose first line begins with their name, into a folder.
fn write_files(dir: &Path) -> Vec<String> {
    let write = |text: String| {
        let name = text.strip_prefix("# ").and_then(|t| t.split_once(':')).unwrap().0.to_owned();
        fs::write(dir.join(&name), text).unwrap();
        name
    };
    blocks(REFERENCE, "toml").into_iter().map(write).collect()
}

#[test]
fn every_file_is_read_and_every_scenario_runs_to_its_end() {
    let dir = scratch("model_files");
    let mut read = BTreeSet::new();
    for name in write_files(&dir) {
        let path = dir.join(&name);
        if name.ends_with("_problem.toml") {
            ControlProblem::read(&path).unwrap();
        } else if let Some(model) = name.strip_suffix("_scenario.toml") {
            let system = System::read(dir.join(format!("{model}.toml"))).unwrap();
            let run = Scenario::read(&path, &system)
                .unwrap()
                .run(&system, &bracketry::sim::SimulationSettings::default())
                .unwrap();
            assert!(matches!(run.simulation.outcome, Outcome::Finished), "{name}: {:?}", run.simulation.outcome);
        } else {
            System::read_accepting(&path, Accepted { discrete: true, algebraic: true }).unwrap();
        }
        read.insert(name);
    }
    assert_eq!(read.len(), 10, "{read:?}");
}

/// The keys that the reader lists where it meets one that it does not know.
fn known_keys(error: &str) -> Vec<&str> {
    let (_, list) = error.split_once("accepts: ").unwrap();
    list.lines().next().unwrap().split(", ").collect()
}

#[test]
fn every_key_and_every_function_is_described() {
    let described = |name: &str| REFERENCE.contains(&format!("`{name}`")) || REFERENCE.contains(&format!("`[{name}]`"));
    let parameter = "states = ['x']\nparameters = { p = { qqqqqqqqqqqq = 1 } }\ndynamics = { x = 'x' }\n";
    let system = System::parse("model", "states = ['x']\ndynamics = { x = 'x' }\n").unwrap();
    let errors = [
        System::parse("model", "qqqqqqqqqqqq = 1\n").unwrap_err(),
        System::parse("model", parameter).unwrap_err(),
        Scenario::parse("scenario", "qqqqqqqqqqqq = 1\n", &system).unwrap_err(),
    ];
    let mut keys = 0;
    for error in errors.map(|e| e.to_string()) {
        for key in known_keys(&error) {
            assert!(described(key) || REFERENCE.contains(&format!("{key} = ")), "{key}");
            keys += 1;
        }
    }
    assert_eq!(keys, 18 + 6 + 6);
    let functions = REFERENCE.lines().filter(|l| l.starts_with("| functions") || l.starts_with("| dry friction"));
    let functions = functions.collect::<Vec<_>>().concat();
    for name in bracketry::system::RESERVED.iter().filter(|name| !["pi", "der"].contains(name)) {
        assert!(functions.split(|c: char| !c.is_alphanumeric()).any(|word| word == *name), "{name}");
    }
}
