//! Delays of inputs, from the model file to the analysis and to the closed loop.

use bracketry::mpc::ControlProblem;
use bracketry::system::System;
use bracketry::{analyze, control};

use bracketry::report::analysis as report;

const MASS: &str = "states = ['x', 'v']\ninputs = ['F']\n[dynamics]\nx = 'v'\nv = 'F'\n";

#[test]
fn an_analysis_says_that_it_is_about_the_inputs_as_they_arrive() {
    let delayed = System::parse("mass.toml", &format!("{MASS}[delays]\nF = 0.25")).unwrap();
    let (with, without) = [delayed, System::parse("mass.toml", MASS).unwrap()]
        .map(|s| analyze(&s, &bracketry::lie::AnalysisOptions::default()).unwrap())
        .into();
    assert_eq!(with.input_delays["F"], 0.25);
    let (said, silent) = (report::summary(&with), report::summary(&without));
    assert!(said.contains("F by 0.25 s") && said.contains("as they arrive"), "{said}");
    assert!(without.input_delays.is_empty() && !silent.contains("arrive"));
    assert_eq!(with.report.modes[0].dimensions.growth, without.report.modes[0].dimensions.growth);
    assert!(serde_json::to_string(&report::json(&with)).unwrap().contains("\"input_delays\":{\"F\":0.25}"));
}

/// Brings a mass to rest at the origin; the delay is in the model file.
fn problem(delay: &str, run: &str) -> ControlProblem {
    let text = format!(
        "model = 'mass.toml'\n[horizon]\nsteps = 40\ndt = 0.05\n[cost]\nstage = '10*x^2 + v^2 + 0.1*F^2'\n\
         terminal = '100*x^2 + 10*v^2'\n[run]\nx0 = {{ x = 1 }}\nsteps = 120\n{run}"
    );
    let model = System::parse("mass.toml", &format!("{MASS}{delay}")).unwrap();
    ControlProblem::parse("problem.toml", &text, |_| Ok(model.clone())).unwrap()
}

#[test]
fn a_loop_applies_the_delay_and_the_controller_knows_it() {
    let rest = |problem: &ControlProblem| {
        let run = control(problem).unwrap().run;
        let end = run.closed_loop.x.last().unwrap().clone();
        let notes: Vec<String> = run.report.notes.iter().map(ToString::to_string).collect();
        (end[0].hypot(end[1]), run.report.closed_loop_cost, notes.join("\n"))
    };
    let (_, cost, notes) = rest(&problem("", ""));
    assert!(!notes.contains("later than commanded"), "{notes}");
    // Three samples.
    let (left, delayed, notes) = rest(&problem("[delays]\nF = 0.15", ""));
    assert!(left < 1e-3 && delayed > cost, "{left} {delayed} {cost}");
    assert!(
        notes.contains("3.00 samples (a time of 0.15)") && notes.contains("predicts over a delay of 3 samples"),
        "{notes}"
    );
    // The same as a loop that delays the inputs itself.
    let (_, same, _) = rest(&problem("", "delay = 3\n"));
    assert!((delayed / same - 1.0).abs() < 1e-3, "{delayed} {same}");
    // A controller that is not told does worse.
    let (_, untold, notes) = rest(&problem("[delays]\nF = 0.15", "compensate_delay = false\n"));
    assert!(
        untold > 1.02 * delayed && notes.contains("predicts over a delay of 0 samples"),
        "{untold} {delayed} {notes}"
    );
}
