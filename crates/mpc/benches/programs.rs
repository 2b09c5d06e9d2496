//! What a sample of the real-time iteration costs, and where: `cargo bench -p bracketry-mpc --bench programs`.
//!
//! Every row is one closed loop under one setting of the quadratic programs. Times are medians over its samples, the smallest
//! of several runs of the loop.

mod common;

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::controller::Step;
use bracketry_mpc::qp::{ProgramForm, QpSettings};
use bracketry_mpc::{ControlProblem, Dynamics, PlannedTrajectory, Plant, Rti, RtiSettings, SymbolicDynamics};
use bracketry_system::System;
use common::median;

/// Hold an object on the plate against errors of its pose, from a running oscillation.
const PLATE: &str = include_str!("../../../models/plate_hold.toml");

/// Programs before the first sample.
const INITIAL_ITERATIONS: usize = 10;
/// Runs of every loop, of which the least disturbed counts.
const RUNS: usize = 7;

fn dynamics(problem: &ControlProblem) -> Box<SymbolicDynamics> {
    let mut dynamics = SymbolicDynamics::new(&problem.system).expect("dynamics that compile");
    if let Some(&width) = problem.widths().last() {
        dynamics.set_smoothing(width);
    }
    Box::new(dynamics)
}

/// The guess of the problem, rolled out from its initial state.
fn start(problem: &ControlProblem) -> PlannedTrajectory {
    let mut z = PlannedTrajectory::constant(problem.ocp.steps, &problem.x0, &vec![0.0; problem.ocp.inputs()]);
    let mut plant = RungeKuttaPlant::new(dynamics(problem), 2);
    let mut x = problem.x0.clone();
    for (k, u) in problem.guess.iter().enumerate().filter(|(_, u)| u.iter().any(|v| *v != 0.0)) {
        plant.step(k as f64 * problem.ocp.dt, &mut x, u, problem.ocp.dt).expect("a smooth plant");
        z.u_mut(k).copy_from_slice(u);
        z.x_mut(k + 1).copy_from_slice(&x);
    }
    z
}

/// One closed loop: its samples and its cost.
fn closed_loop(problem: &ControlProblem, qp: QpSettings) -> (Vec<Step>, f64) {
    let settings = RtiSettings { smoothing: problem.widths().last().copied(), qp, ..RtiSettings::default() };
    let mut rti = Rti::new(dynamics(problem), problem.ocp.clone(), start(problem), settings).expect("a controller");
    let mut plant = RungeKuttaPlant::new(dynamics(problem), 2);
    for _ in 0..INITIAL_ITERATIONS {
        rti.feedback(&problem.x0).expect("a state of the right length");
    }
    common::closed_loop(problem, &mut rti, &mut plant)
}

#[allow(clippy::print_stdout)]
fn row(problem: &ControlProblem, name: &str, qp: QpSettings) {
    let runs: Vec<(Vec<Step>, f64)> = (0..RUNS).map(|_| closed_loop(problem, qp)).collect();
    let effort = runs[0].1;
    let micro =
        |of: fn(&Step) -> f64| runs.iter().map(|(steps, _)| 1e6 * median(steps, of)).fold(f64::INFINITY, f64::min);
    println!(
        "| {name:32} | {:8.1} | {:8.1} | {:6.1} | {effort:.6} |",
        micro(|s| s.timings.linearize),
        micro(|s| s.timings.qp),
        micro(|s| s.timings.rest),
    );
}

#[allow(clippy::print_stdout)]
fn table(name: &str, problem: &ControlProblem) {
    println!("\n| {name:32} | prepare, µs | program, µs | rest, µs | Σ u² of the loop |");
    println!("|---|---|---|---|---|");
    let form = |form| QpSettings { form, ..QpSettings::default() };
    row(problem, "default", QpSettings::default());
    row(problem, "sparse", form(ProgramForm::Sparse));
    for block in [2, 3, 5, 10, 20, problem.ocp.steps] {
        row(problem, &format!("Clarabel, blocks of {block}"), form(ProgramForm::Condensed { block }));
        row(problem, &format!("stagewise, blocks of {block}"), form(ProgramForm::Stagewise { block }));
    }
    row(problem, "sizes from numbers", QpSettings { equilibrate: true, ..QpSettings::default() });
    row(problem, "refined", QpSettings { refine: true, ..QpSettings::default() });
    row(problem, "tolerance 1e-6", QpSettings { tolerance: 1e-6, ..QpSettings::default() });
    let slow = QpSettings { equilibrate: true, refine: true, ..form(ProgramForm::Sparse) };
    row(problem, "sparse, refined, from numbers", slow);
}

fn main() {
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models");
    let pendulum = ControlProblem::read(format!("{models}/cart_pole_swing_up.toml")).expect("a problem file");
    table("pendulum, N = 40", &pendulum);
    let mut plate = ControlProblem::parse("plate", PLATE, |name| Ok(System::read(format!("{models}/{name}"))?))
        .expect("a problem without mistakes");
    table("plate, N = 40", &plate);
    // The same over 2.4 s.
    plate.ocp.steps = 120;
    let omega = 6.0 * std::f64::consts::PI;
    let swing = |k: usize| omega.powi(2) * (omega * 0.02 * k as f64).sin();
    plate.guess = (0..120).map(|k| vec![-0.03 * swing(k), -0.1 * swing(k)]).collect();
    plate.samples = 20;
    table("plate, N = 120", &plate);
}
