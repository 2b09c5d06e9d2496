//! References and parameters from tables.

use bracketry_mpc::problem::ProblemError;
use bracketry_mpc::{ControlProblem, control};
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

/// The stage cost of a problem with the references of its file, at the samples of a run.
fn costs(folder: &Path, rest: &str) -> Vec<f64> {
    let text = format!("model = 'mass.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\nrun = {{ steps = 50 }}\n{rest}");
    let file = folder.join("problem.toml");
    let problem = ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, MODEL).map_err(Box::new));
    let mut ocp = problem.unwrap_or_else(|e| panic!("{e}")).ocp;
    let rows = ocp.references.clone();
    let cost = ocp.stage.as_mut().unwrap();
    rows.iter().enumerate().map(|(k, r)| cost.value(&[0.0, 0.0], &[0.0], 0.1 * k as f64, r)).collect()
}

/// With x = v = 0, the cost is the reference's derivative itself: that of an expression is exact, that of a table converges.
#[test]
fn the_derivative_of_a_reference_is_that_of_calculus() {
    let folder = folder("mpc_derivatives");
    let cost = |derivative: &str| format!("cost = {{ stage = 'x^2 + v + {derivative}' }}\n");
    let exact = |order: &str, of: &str| {
        let rest = format!("{}references = {{ r = '{of}' }}\n", cost(&format!("der(r{order})")));
        costs(&folder, &rest)
    };
    for (k, (first, second)) in
        exact("", "sin(2*t)*exp(-t)").into_iter().zip(exact(", 2", "sin(2*t)*exp(-t)")).enumerate()
    {
        let t = 0.1 * k as f64;
        let (s, c, e) = ((2.0 * t).sin(), (2.0 * t).cos(), (-t).exp());
        assert!((first - e * (2.0 * c - s)).abs() < 1e-12 && (second - e * (-3.0 * s - 4.0 * c)).abs() < 1e-12);
    }
    let rows = |step: f64| -> String {
        let row = |k: u32| format!("{},{}\n", f64::from(k) * step, (f64::from(k) * step).sin());
        format!("t,r\n{}", (0..=(8.0 / step) as u32).map(row).collect::<String>())
    };
    // Away from the ends of the table: of the first order where straight lines join the rows, of the third by cubic pieces.
    for (hold, power) in [("linear", 1.0), ("cubic", 3.0)] {
        let error = |step: f64| {
            fs::write(folder.join("r.csv"), rows(step)).unwrap();
            let rest = format!("{}references = {{ r = {{ file = 'r.csv', hold = '{hold}' }} }}\n", cost("der(r)"));
            let found = costs(&folder, &rest).into_iter().enumerate().skip(20).take(30);
            found.fold(0.0, |w: f64, (k, d)| w.max((d - (0.1 * k as f64).cos()).abs()))
        };
        // The samples lie off the rows, where the error of a derivative is of its full order.
        let found = (error(0.37) / error(0.0925)).log(4.0);
        assert!(found > power - 0.5, "{hold}: {found}");
    }
}

/// A mass that has to follow position and velocity of a table does so without a lag.
#[test]
fn a_velocity_from_a_table_is_tracked() {
    let folder = folder("mpc_velocity");
    let row = |k: u32| format!("{},{}\n", f64::from(k) * 0.2, (f64::from(k) * 0.2).sin());
    fs::write(folder.join("r.csv"), format!("t,r\n{}", (0..=60).map(row).collect::<String>())).unwrap();
    let error = |hold: &str| {
        let text = format!(
            "model = 'mass.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\nsolve = {{ method = 'rti' }}\n\
             cost = {{ stage = '(v - der(r))^2' }}\nrun = {{ x0 = {{ v = 1 }}, steps = 60 }}\n\
             references = {{ r = {{ file = 'r.csv', hold = '{hold}' }} }}\n"
        );
        let file = folder.join("problem.toml");
        let problem =
            ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, MODEL).map_err(Box::new))
                .unwrap();
        assert_eq!(problem.references[1].tracked_by.as_deref(), Some("v"));
        let run = control(&problem).unwrap().run;
        assert!(run.report.succeeded, "{:?}", run.report.notes);
        let points = run.closed_loop.t.iter().zip(&run.closed_loop.x);
        points.fold(0.0, |w: f64, (t, x)| w.max((x[1] - t.cos()).abs()))
    };
    let (linear, cubic) = (error("linear"), error("cubic"));
    assert!(cubic < 0.01 && linear < 0.15 && cubic < linear, "{cubic} {linear}");
}

#[test]
fn a_derivative_that_a_table_does_not_have_is_refused() {
    let folder = folder("mpc_no_derivative");
    fs::write(folder.join("r.csv"), "t,r\n0,1\n1,2\n").unwrap();
    for (hold, order, says) in
        [("previous", "", "hold = \"linear\""), ("linear", ", 2", "\"cubic\""), ("cubic", ", 3", "two")]
    {
        let text = format!(
            "model = 'mass.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\nrun = {{ steps = 50 }}\n\
             cost = {{ stage = 'x^2 + der(r{order})*v' }}\nreferences = {{ r = {{ file = 'r.csv', hold = '{hold}' }} }}\n"
        );
        let file = folder.join("problem.toml");
        let read = ControlProblem::parse(file.to_str().unwrap(), &text, |f| System::parse(f, MODEL).map_err(Box::new));
        let error = read.err().unwrap().to_string();
        assert!(error.contains(says) && error.contains("problem.toml:5:"), "{hold}: {error}");
    }
}

#[test]
fn tables_that_cannot_be_used_are_refused_with_the_place() {
    let folder = folder("mpc_bad_tables");
    fs::write(folder.join("good.csv"), "t,r\n0,1\n1,2\n").unwrap();
    fs::write(folder.join("no_time.csv"), "s,r\n0,1\n").unwrap();
    fs::write(folder.join("unordered.csv"), "t,r\n1,1\n0,2\n").unwrap();
    fs::write(folder.join("twice.csv"), "r,t\n1,0\n2,1\n3,1\n").unwrap();
    fs::write(folder.join("nan.csv"), "t,r\n0,nan\n").unwrap();
    assert!(problem(&folder, "references = { r = { file = 'good.csv' } }\n").is_ok());
    for (table, says) in [
        ("{ file = 'missing.csv' }", "missing.csv"),
        ("{ file = 'no_time.csv' }", "`t`"),
        ("{ file = 'good.csv', column = 'q' }", "`q`"),
        ("{ file = 'unordered.csv' }", "unordered.csv:3:1"),
        ("{ file = 'twice.csv' }", "twice.csv:4:3"),
        ("{ file = 'nan.csv' }", "nan.csv"),
        ("{ column = 'r' }", "names no table"),
        ("{ file = 'good.csv', hold = 'quintic' }", "quintic"),
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
