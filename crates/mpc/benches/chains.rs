//! Chains of three to seven masses, the scalable example of acados ("chain_mass"; Wirsching, Bock and Diehl 2006), 40
//! intervals of 0.2 s: what a sample of the real-time iteration and a converged solution cost as the number of states grows:
//! `cargo bench -p bracketry-mpc --bench chains`.
//!
//! Every row is one closed loop from a chain deflected for 1 s, beside a wall with soft bounds. Times are medians over its
//! samples, the smallest of several runs of the loop.

mod common;

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::controller::Step;
use bracketry_mpc::qp::{ProgramForm, QpSettings};
use bracketry_mpc::sqp::SqpController;
use bracketry_mpc::{
    ControlProblem, Dynamics, PlannedTrajectory, Plant, Rti, RtiSettings, Sqp, SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;
use common::{closed_loop, median};
use std::fmt::Write as _;

/// Numbers of masses that move.
const MASSES: [usize; 4] = [2, 3, 4, 6];
const SAMPLES: usize = 25;
const RUNS: usize = 5;

/// Mass in kg, stiffness in N/m, length of an unloaded spring in m, gravity in m/s².
const MASS: f64 = 0.033;
const STIFFNESS: f64 = 1.0;
const LENGTH: f64 = 0.033;
const GRAVITY: f64 = 9.81;

/// The model with `masses` moving masses, of which the last one is moved with a given velocity.
fn model(masses: usize) -> String {
    let name = |p: &str, i: usize| format!("{p}{i}");
    let mut states: Vec<String> = (1..=masses).flat_map(|i| ["x", "y", "z"].map(|c| name(c, i))).collect();
    states.extend((1..masses).flat_map(|i| ["vx", "vy", "vz"].map(|c| name(c, i))));
    let (mut definitions, mut dynamics) = (String::new(), String::new());
    // Displacement over spring i.
    let over = |c: &str, i: usize| if i == 1 { format!("{c}1") } else { format!("({c}{i} - {c}{})", i - 1) };
    for i in 1..=masses {
        let [x, y, z] = ["x", "y", "z"].map(|c| over(c, i));
        let _ =
            writeln!(definitions, "l{i} = \"sqrt({x}^2 + {y}^2 + {z}^2)\"\nf{i} = \"{STIFFNESS}*(1 - {LENGTH}/l{i})\"");
    }
    for i in 1..=masses {
        for c in ["x", "y", "z"] {
            let speed = if i < masses { format!("v{c}{i}") } else { format!("u{c}") };
            let _ = writeln!(dynamics, "{c}{i} = \"{speed}\"");
        }
    }
    for i in 1..masses {
        for c in ["x", "y", "z"] {
            let weight = if c == "z" { format!(" - {GRAVITY}") } else { String::new() };
            let (next, last) = (over(c, i + 1), over(c, i));
            let _ = writeln!(dynamics, "v{c}{i} = \"(f{}*{next} - f{i}*{last})/{MASS}{weight}\"", i + 1);
        }
    }
    format!(
        "states = {states:?}\ninputs = [\"ux\", \"uy\", \"uz\"]\n[definitions]\n{definitions}[dynamics]\n{dynamics}"
    )
}

/// The chain at rest with its end held at `end`: positions, then speeds of zero.
fn rest(masses: usize, end: [f64; 3]) -> Vec<f64> {
    let mut p: Vec<[f64; 3]> = (1..=masses).map(|i| end.map(|e| e * i as f64 / masses as f64)).collect();
    // Gauss–Seidel: with the lengths of its springs held, the balance of forces at a mass is linear in its position.
    for _ in 0..20_000 {
        for i in 0..masses - 1 {
            let before = if i == 0 { [0.0; 3] } else { p[i - 1] };
            let force = |a: [f64; 3], b: [f64; 3]| {
                let length = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                STIFFNESS * (1.0 - LENGTH / length)
            };
            let (f, g) = (force(p[i], before), force(p[i + 1], p[i]));
            for c in 0..3 {
                let weight = if c == 2 { MASS * GRAVITY } else { 0.0 };
                p[i][c] += 0.5 * ((f * before[c] + g * p[i + 1][c] - weight) / (f + g) - p[i][c]);
            }
        }
    }
    let mut x: Vec<f64> = p.concat();
    x.resize(6 * masses - 3, 0.0);
    x
}

/// The problem: bring the chain to rest with its end at 6 L for every spring, the wall at y = −0.05 m.
fn problem(masses: usize, integrator: &str) -> ControlProblem {
    let goal = rest(masses, [6.0 * LENGTH * masses as f64, 0.0, 0.0]);
    let mut cost = String::new();
    for i in 0..masses {
        for (c, name) in ["x", "y", "z"].iter().enumerate() {
            let weight = if i + 1 == masses { 4.0 } else { 1.0 };
            let _ = write!(cost, "{weight}*({name}{} - ({}))^2 + ", i + 1, goal[3 * i + c]);
        }
    }
    for i in 1..masses {
        let _ = write!(cost, "vx{i}^2 + vy{i}^2 + vz{i}^2 + ");
    }
    let wall: String = (1..=masses).fold(String::new(), |mut text, i| {
        let _ = writeln!(text, "y{i} = {{ min = -0.05, soft = [1, 500] }}");
        text
    });
    let text = format!(
        "model = \"chain\"\n[horizon]\nsteps = 40\ndt = 0.2\nsubsteps = 2\n{integrator}\n\
         [cost]\nstage = \"{cost}0.01*(ux^2 + uy^2 + uz^2)\"\nterminal = \"{}\"\n[constraints]\n{wall}\
         ux = {{ min = -1, max = 1 }}\nuy = {{ min = -1, max = 1 }}\nuz = {{ min = -1, max = 1 }}\n\
         [run]\nsteps = {SAMPLES}\nx0 = {{ x1 = 0 }}\n",
        cost.trim_end_matches(" + ")
    );
    let system = System::parse("chain", &model(masses)).expect("a model without mistakes");
    let mut problem =
        ControlProblem::parse("chain", &text, |_| Ok(system.clone())).expect("a problem without mistakes");
    problem.x0 = goal;
    let mut plant = RungeKuttaPlant::new(dynamics(&problem), 20);
    for k in 0..5 {
        plant.step(0.2 * k as f64, &mut problem.x0, &[-1.0, 1.0, 1.0], 0.2).expect("a smooth plant");
    }
    problem
}

fn dynamics(problem: &ControlProblem) -> Box<dyn Dynamics> {
    Box::new(SymbolicDynamics::new(&problem.system).expect("dynamics that compile"))
}

fn start(problem: &ControlProblem) -> PlannedTrajectory {
    PlannedTrajectory::constant(problem.ocp.steps, &problem.x0, &[0.0; 3])
}

/// One closed loop of the real-time iteration: its samples and its sum of squared inputs.
fn real_time(problem: &ControlProblem, qp: QpSettings) -> (Vec<Step>, f64) {
    let settings = RtiSettings { qp, ..RtiSettings::default() };
    let mut rti = Rti::new(dynamics(problem), problem.ocp.clone(), start(problem), settings).expect("a controller");
    for _ in 0..10 {
        rti.feedback(&problem.x0).expect("a state of the right length");
    }
    let mut plant = RungeKuttaPlant::new(dynamics(problem), 10);
    closed_loop(problem, &mut rti, &mut plant)
}

/// One closed loop of converged solutions.
fn converged(problem: &ControlProblem) -> (Vec<Step>, f64) {
    let solver = Sqp::new(dynamics(problem), problem.ocp.clone(), SqpSettings::default()).expect("a solver");
    let mut sqp = SqpController::new(solver, start(problem));
    let mut plant = RungeKuttaPlant::new(dynamics(problem), 10);
    closed_loop(problem, &mut sqp, &mut plant)
}

#[allow(clippy::print_stdout)]
fn row(name: &str, states: usize, run: impl Fn() -> (Vec<Step>, f64)) {
    let runs: Vec<(Vec<Step>, f64)> = (0..RUNS).map(|_| run()).collect();
    let least = |of: fn(&Step) -> f64| runs.iter().map(|(s, _)| 1e3 * median(s, of)).fold(f64::INFINITY, f64::min);
    let iterations = median(&runs[0].0, |s| s.effort.interior_point_steps as f64);
    println!(
        "| {states} | {name} | {:.3} | {:.3} | {:.3} | {:.3} | {iterations} | {:.9} |",
        least(|s| s.timings.linearize),
        least(|s| s.timings.qp),
        least(|s| s.timings.rest),
        least(|s| s.timings.total()),
        runs[0].1,
    );
}

#[allow(clippy::print_stdout)]
fn main() {
    println!("| states | method | prepare, ms | program | rest | sample | iterations | Σ u² of the loop |");
    println!("|---|---|---|---|---|---|---|---|");
    for masses in MASSES {
        let problem_of = |integrator| problem(masses, integrator);
        let problem = problem_of("");
        let states = problem.ocp.states();
        row("real-time iteration", states, || real_time(&problem, QpSettings::default()));
        for block in std::env::args().skip(1).filter_map(|a| a.parse().ok()) {
            for form in [ProgramForm::Condensed { block }, ProgramForm::Stagewise { block }] {
                row(&format!("{form:?}"), states, || real_time(&problem, QpSettings { form, ..QpSettings::default() }));
            }
        }
        row("converged", states, || converged(&problem));
        let problem = problem_of("integrator = \"gauss-legendre\"\nstages = 2");
        row("real-time iteration, Gauss–Legendre", states, || real_time(&problem, QpSettings::default()));
        row("converged, Gauss–Legendre", states, || converged(&problem));
    }
}
