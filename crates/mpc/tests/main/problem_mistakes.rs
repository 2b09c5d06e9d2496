//! Mistakes in problem files are said, with their place and a remedy, before anything is solved.

use bracketry_mpc::problem::{ClosedLoopReport, Note};
use bracketry_mpc::{ControlProblem, control};
use bracketry_system::System;
use std::path::{Path, PathBuf};

const MODEL: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { k = 1 }
    ranges = { u = { min = -2, max = 2 } }
    dynamics = { x = "v", v = "-k*x + u" }
"#;
const PARTS: [(&str, &str); 4] = [
    ("model", "model = \"model.toml\""),
    ("horizon", "horizon = { steps = 10, dt = 0.1 }"),
    ("cost", "cost = { stage = \"x^2 + v^2 + 0.1*u^2\" }"),
    ("run", "run = { x0 = { x = 1 } }"),
];

/// A problem without mistakes, with lines in place of those of the same key, or after them.
fn with(lines: &str) -> String {
    let key = |line: &str| line.split([' ', '=']).next().unwrap().to_owned();
    let replaced: Vec<String> = lines.lines().map(key).collect();
    let kept = PARTS.iter().filter(|(name, _)| !replaced.iter().any(|r| r == name)).map(|(_, text)| *text);
    kept.chain(lines.lines()).collect::<Vec<_>>().join("\n")
}

fn read(text: &str, folder: &Path) -> Result<ControlProblem, String> {
    let file = folder.join("problem.toml");
    ControlProblem::parse(&file.to_string_lossy(), text, |f| System::parse(f, MODEL).map_err(Box::new))
        .map_err(|e| e.to_string())
}

fn folder() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("bracketry-mistakes-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn run(lines: &str) -> ClosedLoopReport {
    control(&read(&with(lines), &folder()).unwrap_or_else(|e| panic!("{lines}: {e}"))).unwrap().run.report
}

#[test]
fn the_problem_without_mistakes_is_accepted() {
    let report = run("");
    assert!(report.succeeded && report.notes.is_empty(), "{:?}", report.notes);
}

#[test]
fn mistakes_are_said_with_their_place_and_remedy() {
    // The line, and what is said.
    let mistakes = [
        ("horizon = { dt = 0.1 }", "[horizon] has no `steps`"),
        ("horizon = { steps = 10 }", "[horizon] has no `dt`"),
        ("horizon = { steps = 0, dt = 0.1 }", "`steps` must be a whole number from 1 to 20000"),
        ("horizon = { steps = 10, dt = \"50 ms\" }", "give seconds: 0.05"),
        ("horizon = { steps = 10, dt = \"20Hz\" }", "give seconds: 0.05"),
        ("references = { x = 1 }", "stage = \"(x - x_ref)^2"),
        ("solve = { method = \"rti\", hessian = \"exact\" }", "`hessian` applies to the methods"),
        ("solve = { iterations = 2, hessian = \"exact\" }", "`iterations` chooses \"rti\""),
        ("horizon = { steps = 10, dt = 0.1, substeps = 1000000 }", "take too long"),
        ("horizon = { steps = 10, dt = 0.1, blocks = [1e300] }", "a whole number from 1 to"),
        ("cost = { stage = 5 }", "the cost contains no state or input"),
        ("cost = { stage = \"0*x^2\" }", "the cost contains no state or input"),
        ("cost = { residuals = [\"x\"], weights = [0] }", "the cost contains no state or input"),
        ("cost = { stage = \"u^2\" }", "neither cost nor target contains a state"),
        ("cost = {}", "neither a cost nor a target"),
        ("constraints = { x = {} }", "neither `min` nor `max`"),
        ("constraints = { u = { hard = true } }", "neither `min` nor `max`"),
        ("constraints = { x = { max = 0.5, soft = [0, 0] } }", "at least one positive"),
        ("constraints = { c = { expression = \"k\", max = 0.5 } }", "`c` contains no state or input"),
        ("constraints = { c = { expression = \"t\", max = 5 } }", "`c` contains no state or input"),
        ("constraints = { c = { norm = [\"k\"], max = 5 } }", "`c` contains no state or input"),
        ("constraints = { c = { norm = [\"x\", \"u\"], max = -1 } }", "nothing satisfies `c`"),
        ("target = { x = 3 }\nconstraints = { x = { max = 2 } }", "the target 3 of `x` is outside its bounds"),
        ("target = { x = { tolerance = 0.1 } }", "the target of `x` has no value"),
        ("solve = { method = \"plan\", margin = 1 }", "`margin` must be below 1"),
        ("solve = { method = \"sqp\", tolerance = 10 }", "`tolerance` must be below 1"),
        ("run = { x0 = { x = 1 }, delay = 100 }", "no input acts within the run of 10"),
        ("run = { faults = [{ at = 10, lost = true }] }", "comes after the run, whose samples are 0 to 9"),
        ("run = { plant_substeps = 1000000 }", "take too long"),
    ];
    for (lines, message) in mistakes {
        let text = with(lines);
        let said = read(&text, &folder()).err().unwrap_or_else(|| panic!("accepted: {lines}"));
        assert!(said.contains(message), "{lines}: {said}");
        assert!(said.contains("\n   = "), "{lines} has no remedy: {said}");
        assert!(
            said.contains("problem.toml:2:") || said.contains("problem.toml:4:") || said.contains("problem.toml:5:"),
            "{lines}: {said}"
        );
    }
}

#[test]
fn what_is_no_mistake_is_accepted() {
    // Effort alone, with a bound that needs some; a number that changes over time; an end that only the inputs have.
    for lines in [
        "cost = { stage = \"u^2\" }\nconstraints = { x = { max = 0.5 } }",
        "cost = { stage = \"u^2\" }\ntarget = { x = 0 }",
        "cost = { stage = \"0.1*u^2\", terminal = \"riccati\" }",
        "constraints = { c = { expression = \"x\", max = \"1 + t\" } }",
        "constraints = { c = { expression = \"1 + t\", min = \"x\" } }",
        "constraints = { x = { max = 2 } }\ntarget = { x = 2 }",
        "run = { faults = [{ at = 9, lost = true }], delay = 9 }",
    ] {
        assert!(read(&with(lines), &folder()).is_ok(), "{lines}: {:?}", read(&with(lines), &folder()).err());
    }
}

#[test]
fn a_table_that_ends_before_the_run_is_told() {
    let folder = folder();
    let cost = "cost = { stage = \"(x - r)^2 + 0.1*u^2\" }\nreferences = { r = { file = \"r.csv\" } }";
    for (last, steps, told) in [(0.5, 30, true), (2.9, 30, false), (5.0, 30, false), (2.7, 30, true)] {
        std::fs::write(folder.join("r.csv"), format!("t,r\n0,1\n{last},0.5\n")).unwrap();
        let problem = read(&with(&format!("{cost}\nrun = {{ steps = {steps} }}")), &folder).unwrap();
        let report = control(&problem).unwrap().run.report;
        let notes = &report.notes;
        assert_eq!(notes.iter().any(|n| matches!(n, Note::TableEnds { .. })), told, "{last}: {notes:?}");
        assert!(report.succeeded, "{last}: {notes:?}");
    }
}

#[test]
fn a_table_with_one_row_is_a_constant_and_is_told() {
    let folder = folder();
    std::fs::write(folder.join("one.csv"), "t,r\n0,0.5\n").unwrap();
    let cost = "cost = { stage = \"(x - r)^2 + 0.1*u^2\" }\n";
    let costs = |r: &str| {
        let problem =
            read(&with(&format!("{cost}references = {{ r = {r} }}\nsolve = {{ method = \"rti\" }}")), &folder);
        let report = control(&problem.unwrap()).unwrap().run.report;
        (report.closed_loop_cost, report.notes)
    };
    let (from_table, told) = costs("{ file = \"one.csv\" }");
    let (from_number, quiet) = costs("0.5");
    assert_eq!(from_table, from_number);
    assert!(matches!(&told[..], [Note::OneRow { name }] if name == "r") && quiet.is_empty(), "{told:?} {quiet:?}");
}

#[test]
fn a_reference_that_nothing_uses_is_told() {
    let report = run("references = { r = 1, s = \"sin(t)\" }\ncost = { stage = \"(x - s)^2 + 0.1*u^2\" }");
    assert!(matches!(&report.notes[..], [Note::UnusedReference { name }] if name == "r"), "{:?}", report.notes);
    let at_end = run("references = { r = 1 }\nconstraints = { c = { expression = \"x - r\", max = 5, at = \"end\" } }");
    assert!(at_end.notes.is_empty(), "{:?}", at_end.notes);
}

/// The oscillator has a period of 2π: an interval of 50 s was meant to be one of 50 ms.
#[test]
fn an_interval_beyond_every_motion_of_the_model_is_told() {
    let notes = |dt: f64| {
        let text = with(&format!("horizon = {{ steps = 10, dt = {dt} }}\nsolve = {{ method = \"rti\" }}"));
        control(&read(&text, &folder()).unwrap()).unwrap().run.report.notes
    };
    let told = |notes: &[Note]| notes.iter().any(|n| matches!(n, Note::LongInterval { dt: 50.0, .. }));
    assert!(told(&notes(50.0)) && notes(0.05).is_empty());
    // One Runge–Kutta step of 1 s is off by almost a hundredth, which is another matter.
    assert!(matches!(&notes(1.0)[..], [Note::PlantRefined(refined)] if refined.substeps == 1 && refined.error < 0.01));
}

#[test]
fn a_start_outside_a_hard_bound_is_told_by_its_name() {
    let report = run("constraints = { x = { max = 0.5, hard = true } }");
    let told = report.notes.iter().any(|n| matches!(n, Note::StartsOutside { state, .. } if state == "x"));
    assert!(told && !report.succeeded, "{:?}", report.notes);
    // What the violation costs is no trouble of the method.
    assert!(!report.notes.iter().any(|n| matches!(n, Note::UnlikePlan { .. })), "{:?}", report.notes);
    let within = run("constraints = { x = { max = 1.5, hard = true } }");
    assert!(within.succeeded && within.notes.is_empty(), "{:?}", within.notes);
}

#[test]
fn a_point_that_is_not_steady_is_said_with_the_name_of_the_state_that_moves() {
    let model = "states = [\"x\", \"tank\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\", tank = \"1 - tank\" }";
    let text = "horizon = { steps = 5, dt = 0.1 }\n\
                cost = { stage = \"x^2 + u^2 + tank^2\", terminal = \"riccati\" }\nrun = {}";
    let error = crate::common::reports::read_with_model(model, text).err().unwrap().to_string();
    assert!(error.contains("problem.toml:3:") && error.contains("state `tank` moves by"), "{error}");
}
