//! Model-predictive control, timed; see `control.py` for the others. Wall-clock seconds, medians over the samples.

use bracketry::mpc::closed_loop::{ClosedLoop, RungeKuttaPlant};
use bracketry::mpc::controller::Step;
use bracketry::mpc::problem::{Convergence, Feedback, Method};
use bracketry::mpc::{ControlProblem, PlannedTrajectory, Plant, Rti, RtiSettings, SymbolicDynamics};
use bracketry::system::System;
use serde_json::{Value, json};

const PENDULUM: &str = include_str!("../../models/cart_pole_swing_up.toml");
/// Samples whose programs are handed to the others.
const EVERY: usize = 8;

/// Programs before the first sample.
const INITIAL_ITERATIONS: usize = 10;

/// The plate on its reduced model.
const PLATE: &str = include_str!("../../models/plate_hold.toml");

/// Median over the samples but the first, which may have to build what later ones only update.
fn median(steps: &[Step], of: impl Fn(&Step) -> f64) -> f64 {
    let mut seconds: Vec<f64> = steps.iter().skip(1).map(of).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

fn times(steps: &[Step]) -> Value {
    json!({
        "linearise": median(steps, |s| s.timings.linearize),
        "program": median(steps, |s| s.timings.qp),
        "rest": median(steps, |s| s.timings.rest),
        "total": median(steps, |s| s.timings.total()),
        "mean": steps.iter().skip(1).map(|s| s.timings.total()).sum::<f64>() / (steps.len() - 1) as f64,
    })
}

fn problem(text: &str, model: &System) -> ControlProblem {
    ControlProblem::parse("problem", text, |_| Ok(model.clone())).expect("a problem without mistakes")
}

fn dynamics(problem: &ControlProblem) -> Box<SymbolicDynamics> {
    Box::new(SymbolicDynamics::new(&problem.system).expect("dynamics that compile"))
}

/// Real-time iteration from `start`, with every eighth program in full.
fn real_time_iteration(problem: &ControlProblem, start: PlannedTrajectory, goal: &[f64]) -> (Vec<Step>, Vec<Value>) {
    let settings = RtiSettings { smoothing: problem.smoothing.last().copied(), ..RtiSettings::default() };
    let mut rti = Rti::new(dynamics(problem), problem.ocp.clone(), start, settings).expect("a controller");
    let mut model = dynamics(problem);
    if let Some(&width) = problem.smoothing.last() {
        bracketry::mpc::Dynamics::set_smoothing(model.as_mut(), width);
    }
    let mut plant = RungeKuttaPlant::new(model, 2);
    for _ in 0..INITIAL_ITERATIONS {
        rti.feedback(&problem.x0).expect("a state of the right length");
    }
    let rows = |t: &PlannedTrajectory| -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let steps = t.steps();
        ((0..=steps).map(|k| t.x(k).to_vec()).collect(), (0..steps).map(|k| t.u(k).to_vec()).collect())
    };
    let (mut x, mut steps, mut programs) = (problem.x0.clone(), Vec::new(), Vec::new());
    for k in 0..problem.samples {
        rti.prepare().expect("settings in their ranges");
        let (states, inputs) = rows(rti.trajectory());
        let step = rti.feedback(&x).expect("a state of the right length").clone();
        if k % EVERY == EVERY - 1 {
            programs.push(json!({"x": states, "u": inputs, "start": x, "u0": step.u, "goal": goal}));
        }
        rti.shift();
        plant.step(k as f64 * problem.ocp.dt, &mut x, &step.u, problem.ocp.dt).expect("a smooth plant");
        steps.push(step);
    }
    (steps, programs)
}

fn pendulum() -> Value {
    let model = System::parse("cart_pole.toml", include_str!("../../models/cart_pole.toml")).expect("a model");
    let mut problem = problem(PENDULUM, &model);
    let start = PlannedTrajectory::constant(problem.ocp.steps, &problem.x0, &[0.0]);
    let (rti, programs) = real_time_iteration(&problem, start, &[0.0; 4]);
    problem.method = Method::Sqp { convergence: Convergence::default(), first: Feedback::default() };
    let mut plant = RungeKuttaPlant::new(dynamics(&problem), problem.plant_substeps);
    let run = problem.run(&mut plant).expect("a loop that runs");
    let ClosedLoop { x, u, steps, cost, .. } = run.closed_loop;
    let inputs: Vec<f64> = u.iter().map(|u| u[0]).collect();
    json!({
        "rti": times(&rti), "sqp": times(&steps), "cost": cost,
        "states": x[..u.len()], "inputs": inputs, "programs": programs,
    })
}

fn plate() -> Value {
    let model = System::parse("plate_reduced.toml", include_str!("../../models/plate_reduced.toml")).expect("a model");
    let problem = problem(PLATE, &model);
    // The oscillation, rolled out: a trajectory that obeys the dynamics.
    let mut at = dynamics(&problem);
    bracketry::mpc::Dynamics::set_smoothing(at.as_mut(), problem.smoothing[0]);
    let mut roll = RungeKuttaPlant::new(at, 2);
    let mut start = PlannedTrajectory::constant(problem.ocp.steps, &problem.x0, &[0.0, 0.0]);
    let mut x = problem.x0.clone();
    for (k, u) in problem.guess.iter().enumerate() {
        roll.step(k as f64 * problem.ocp.dt, &mut x, u, problem.ocp.dt).expect("a smooth model");
        start.u_mut(k).copy_from_slice(u);
        start.x_mut(k + 1).copy_from_slice(&x);
    }
    let goal = [0.02, 0.01, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (steps, programs) = real_time_iteration(&problem, start, &goal);
    let q = [10.0, 10.0, 1.0, 0.1, 0.1, 0.01, 10.0, 0.1, 1.0, 0.01];
    json!({
        "rti": times(&steps), "programs": programs, "steps": 40, "dt": 0.02, "substeps": 2, "width": 0.02,
        "Q": q, "R": [5e-4, 5e-5], "P": q, "bounds": [15.0, 40.0],
        "soft": [[6, 0.1, 50.0, 1e3], [8, 0.35, 50.0, 1e3]],
    })
}

pub(crate) fn report() -> Value {
    json!({"pendulum": pendulum(), "plate": plate()})
}
