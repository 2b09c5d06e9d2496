//! References and parameters from tables.
#![allow(clippy::unwrap_used)]

use bracketry_mpc::{ControlProblem, ProblemError};
use bracketry_system::System;
use std::fs;
use std::path::{Path, PathBuf};

const MODEL: &str =
    "states = ['x', 'v']\ninputs = ['a']\nparameters = { d = 0 }\ndynamics = { x = 'v', v = 'a + d' }\n";

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn problem(folder: &Path, tables: &str) -> Result<ControlProblem, ProblemError> {
    let text = format!(
        "model = 'mass.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = '(x - r)^2 + 0.1*v^2 + 0.01*(a + d)^2' }}\n\
         solve = {{ method = 'rti' }}\nrun = {{ steps = 50 }}\n{tables}"
    );
    let file = folder.join("problem.toml");
    ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, MODEL).map_err(Box::new))
}

/// A table of a function at the samples is as good as the function.
#[test]
fn a_table_is_the_function_that_it_was_made_of() {
    let folder = folder("mpc_tables");
    let rows = |f: fn(f64) -> f64| -> String {
        let row = |k: u32| format!("{},{}\n", f64::from(k) * 0.1, f(f64::from(k) * 0.1));
        format!("t,value\n{}", (0..=70).map(row).collect::<String>())
    };
    fs::write(folder.join("r.csv"), rows(|t| (2.0 * t).sin())).unwrap();
    fs::write(folder.join("d.csv"), rows(|t| 0.2 * t)).unwrap();
    for hold in ["previous", "linear"] {
        let table = |file: &str| format!("{{ file = '{file}', column = 'value', hold = '{hold}' }}");
        let tables = format!("references = {{ r = {} }}\nparameters = {{ d = {} }}\n", table("r.csv"), table("d.csv"));
        let from_tables = problem(&folder, &tables).unwrap();
        let functions = "references = { r = 'sin(2*t)' }\nparameters = { d = '0.2*t' }\n";
        let from_functions = problem(&folder, functions).unwrap();
        let inputs = |problem: &ControlProblem| {
            let mut controller = problem.controller().unwrap();
            (0..50).map(|k| controller.step(&[0.01 * f64::from(k), 0.0]).unwrap().step.u[0]).collect::<Vec<f64>>()
        };
        for (a, b) in inputs(&from_tables).iter().zip(inputs(&from_functions)) {
            assert!((a - b).abs() < 1e-7, "{hold}: {a} {b}");
        }
    }
}

#[test]
fn tables_that_cannot_be_used_are_refused_with_the_place() {
    let folder = folder("mpc_bad_tables");
    fs::write(folder.join("good.csv"), "t,r\n0,1\n1,2\n").unwrap();
    fs::write(folder.join("no_time.csv"), "s,r\n0,1\n").unwrap();
    fs::write(folder.join("unordered.csv"), "t,r\n1,1\n0,2\n").unwrap();
    fs::write(folder.join("nan.csv"), "t,r\n0,nan\n").unwrap();
    assert!(problem(&folder, "references = { r = { file = 'good.csv' } }\n").is_ok());
    for (table, says) in [
        ("{ file = 'missing.csv' }", "missing.csv"),
        ("{ file = 'no_time.csv' }", "`t`"),
        ("{ file = 'good.csv', column = 'q' }", "`q`"),
        ("{ file = 'unordered.csv' }", "time"),
        ("{ file = 'nan.csv' }", "nan.csv"),
        ("{ column = 'r' }", "names no table"),
        ("{ file = 'good.csv', hold = 'cubic' }", "cubic"),
        ("{ file = 'good.csv', scale = 2 }", "scale"),
    ] {
        let error = problem(&folder, &format!("references = {{ r = {table} }}\n")).err().unwrap().to_string();
        assert!(error.contains(says), "{table}: {error}");
    }
}

#[test]
fn a_constraint_at_the_end_is_read_and_what_it_cannot_be_is_refused() {
    let folder = folder("mpc_at_end");
    let with =
        |constraint: &str| problem(&folder, &format!("references = {{ r = 0 }}\nconstraints = {{ {constraint} }}\n"));
    let read = with("arrive = { expression = 'x + v', at = 'end', min = 1, hard = true }").unwrap();
    assert_eq!(read.ocp.path_constraints[0].grid_points(20), 20..21);
    for (constraint, says) in [
        ("arrive = { expression = 'x + a', at = 'end', min = 1 }", "uses an input"),
        ("arrive = { expression = 'x', at = 'start', min = 1 }", "start"),
        ("x = { at = 'end', min = 1 }", "expression"),
    ] {
        let error = with(constraint).err().unwrap().to_string();
        assert!(error.contains(says), "{constraint}: {error}");
    }
}
