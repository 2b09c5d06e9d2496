//! Problems whose plain start is stationary: they are solved from steered inputs, and from waves around the plain start.

use crate::common::scratch;
use std::fs;
use std::path::{Path, PathBuf};

use bracketry::mpc::{ControlProblem, SolveStatus};
use bracketry::report::steering::steering_inputs;
use bracketry::sim::Hold;
use bracketry::steer::{SteerOptions, SteerStatus, own_inputs, steer};
use bracketry::system::System;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

/// Steers the model of a problem and writes inputs.csv beside it.
fn steered(dir: &Path, model: &str, from: &str, to: &str, duration: f64) -> &'static str {
    let mut system = own_inputs(&System::read(dir.join(model)).unwrap()).unwrap();
    let options = SteerOptions::named(&mut system, Some(from), to).unwrap();
    let found = steer(&system, &SteerOptions { duration: Some(duration), ..options }).unwrap();
    assert_eq!(found.status, SteerStatus::Reached, "{:?}", found.attempts);
    assert!(found.end_error < 1e-6);
    let (header, rows) = steering_inputs(&found).unwrap();
    let line = |row: &Vec<f64>| row.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = std::iter::once(header.join(",")).chain(rows.iter().map(line)).collect();
    fs::write(dir.join("inputs.csv"), rows.join("\n") + "\n").unwrap();
    match found.signals.unwrap().hold {
        Hold::Previous => "previous",
        Hold::Linear => "linear",
    }
}

/// How the plan of a problem ended, and its largest miss of a target.
fn planned(dir: &Path, text: &str) -> (SolveStatus, f64) {
    let path = dir.join("problem.toml");
    fs::write(&path, text).unwrap();
    let problem = ControlProblem::read(&path).unwrap();
    let plan = problem.plan().unwrap();
    let end = plan.trajectory.x(plan.trajectory.steps());
    let miss = problem.ocp.targets.iter().map(|t| (end[t.state] - t.value).abs()).fold(0.0, f64::max);
    (plan.status, miss)
}

const GUESS: &str = "[initial_guess]\nfile = \"inputs.csv\"\nhold = \"linear\"\n";

/// At rest, the linearization of a car cannot move sideways: from zero inputs, a program of any kind that uses it stays there. The
/// plan is then solved again from waves.
#[test]
fn a_car_parks_sideways_past_a_post_from_steered_inputs_alone() {
    let dir = scratch("parking");
    fs::copy(models().join("kinematic_car.toml"), dir.join("kinematic_car.toml")).unwrap();
    assert_eq!(steered(&dir, "kinematic_car.toml", "x=0", "y=2", 15.0), "linear");
    let problem = "model = \"kinematic_car.toml\"\n[horizon]\nsteps = 60\ndt = 0.25\n\
        [cost]\nstage = \"0.01*(v^2 + w^2)\"\n\
        [constraints]\ndelta = { min = -1.2, max = 1.2 }\nv = { min = -1.5, max = 1.5 }\nw = { min = -1.5, max = 1.5 }\n\
        post = { expression = \"(x - 0.6)^2 + (y - 1)^2\", min = 0.25 }\n\
        [target]\nx = 0\ny = 2\nth = 0\ndelta = 0\n[solve]\nmethod = \"plan\"\n[run]\nsteps = 60\n";
    let (_, plain) = planned(&dir, problem);
    assert!(plain < 1e-3, "the plain start ends {plain} away");
    let (status, guided) = planned(&dir, &problem.replace("[solve]", &format!("{GUESS}[solve]")));
    assert!(guided < 1e-3 && status == SolveStatus::Converged, "{status:?}, {guided} away");
}

/// The vibrating plate moves its object by 60 mm and 30 mm and turns it by 90 degrees: `models/plate_move.toml` without the
/// oscillation that it gives as guess.
#[test]
fn the_plate_moves_and_turns_its_object_from_steered_inputs_alone() {
    let dir = scratch("plate");
    fs::copy(models().join("plate_published.toml"), dir.join("plate_published.toml")).unwrap();
    let text = fs::read_to_string(models().join("plate_move.toml")).unwrap();
    let (before, rest) = text.split_once("[guess]").unwrap();
    let after = &rest[rest.find("[solve]").unwrap()..];
    steered(&dir, "plate_published.toml", "x=0.48,y=-0.03", "x=0.54,phi=pi/2", 2.4);
    let (_, plain) = planned(&dir, &format!("{before}{after}"));
    assert!(plain < 0.01, "the plain start ends {plain} away");
    let (_, guided) = planned(&dir, &format!("{before}{GUESS}{after}"));
    // The tolerances of the problem: 0.01 m, 0.1 rad, 0.05 m/s, 0.3 rad/s.
    assert!(guided < 0.01, "{guided} away");
}
