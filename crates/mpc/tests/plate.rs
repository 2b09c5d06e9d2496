//! The plate moves an object without grasping it: position and orientation together, on exact stick–slip friction.
#![allow(clippy::unwrap_used)]

mod common;

use bracketry_mpc::{
    Bounds, Horizon, Ocp, Rti, RtiSettings, Softness, Solution, Sqp, SqpSettings, TerminalTarget, run_closed_loop,
};
use std::f64::consts::{PI, TAU};

const DEG: f64 = PI / 180.0;
const DT: f64 = 0.02;

fn problem(steps: usize, model: &mut common::Model, target: [f64; 3]) -> Ocp {
    let mut ocp = Ocp::new(10, 2, steps, DT);
    ocp.stage = Some(model.stage("0.05*(ax/15)^2 + 0.05*(ath/60)^2"));
    ocp.input_bounds = vec![(-15.0, 15.0), (-60.0, 60.0)];
    let soft = Softness::Soft { linear: 5e3, quadratic: 1e3 };
    ocp.state_bounds[6] = Bounds { min: -0.1, max: 0.1, softness: soft };
    let soft = Softness::Soft { linear: 1e3, quadratic: 1e2 };
    ocp.state_bounds[8] = Bounds { min: -20.0 * DEG, max: 20.0 * DEG, softness: soft };
    ocp.state_scale = vec![0.01, 0.01, 0.1, 0.05, 0.05, 0.3, 0.02, 0.1, 0.1, 1.0];
    ocp.state_trust[3..6].copy_from_slice(&[0.1, 0.1, 1.0]);
    ocp.input_trust = vec![15.0, 60.0];
    let wanted = [target[0], target[1], target[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let tolerance = [0.01, 0.01, 0.1, 0.05, 0.05, 0.3, 0.02, 0.1, 0.1, 1.0];
    ocp.targets = (0..10)
        .map(|state| TerminalTarget {
            state,
            value: wanted[state],
            linear: 1.0 / tolerance[state],
            quadratic: 0.5 / tolerance[state] / tolerance[state],
        })
        .collect();
    ocp
}

/// A plain 3 Hz oscillation, faded in and out.
fn oscillation(steps: usize) -> Vec<Vec<f64>> {
    let (w, amplitude) = (TAU * 3.0, [0.03, 8.0 * DEG]);
    (0..steps)
        .map(|k| {
            let t = (k as f64 + 0.5) * DT;
            let fade = (t.min(steps as f64 * DT - t) / 0.2).min(1.0);
            amplitude.iter().map(|a| -a * w * w * (w * t).sin() * fade).collect()
        })
        .collect()
}

fn start(at: [f64; 3]) -> Vec<f64> {
    let mut x = vec![0.0; 10];
    x[..3].copy_from_slice(&at);
    x
}

fn plan(from: [f64; 3], to: [f64; 3], mu: f64, steps: usize) -> Solution {
    let mut model = common::plate(mu);
    let ocp = problem(steps, &mut model, to).tightened(0.05);
    let settings = SqpSettings {
        smoothing: vec![0.1, 0.03, 0.01, 0.003],
        tolerance: 1e-2,
        defect_tolerance: 1e-3,
        max_iterations: 60,
        ..SqpSettings::default()
    };
    let mut sqp = Sqp::new(Box::new(model.dynamics()), ocp, settings).unwrap();
    let guess = sqp.guess(&start(from), &oscillation(steps)).unwrap();
    sqp.solve(&start(from), &guess).unwrap()
}

fn closed_loop(from: [f64; 3], to: [f64; 3], mu: f64, plant_mu: f64, steps: usize) -> bracketry_mpc::ClosedLoop {
    let plan = plan(from, to, mu, steps);
    eprintln!(
        "plan {:?}: {} programs, {:.2} s, cost {:.4}, defect {:.1e}",
        plan.status,
        plan.iterations.len(),
        plan.seconds,
        plan.cost,
        plan.defect
    );
    let mut model = common::plate(mu);
    let ocp = problem(steps, &mut model, to);
    let settings = RtiSettings {
        horizon: Horizon::Shrinking { min_steps: 6 },
        smoothing: Some(0.003),
        proximal: 0.5,
        guarded: true,
        ..RtiSettings::default()
    };
    let mut rti = Rti::new(Box::new(model.dynamics()), ocp, plan.trajectory, settings).unwrap();
    let mut plant = common::ExactPlate { mu: plant_mu, max_step: 1e-4 };
    let run = run_closed_loop(&mut rti, &mut plant, &start(from), steps, |_, _| {}).unwrap();
    let end = run.x.last().unwrap();
    eprintln!(
        "mu {mu}/{plant_mu} error {:.2} mm {:.2} mm {:.2}° spin {:.2} °/s plate {:.1e} {:.1e} {:.1e} {:.1e} times {:?} {:?} violation {:.1e}",
        1e3 * (end[0] - to[0]),
        1e3 * (end[1] - to[1]),
        (end[2] - to[2]) / DEG,
        end[5] / DEG,
        end[6],
        end[7],
        end[8],
        end[9],
        run.times,
        run.counts,
        run.constraint_violation_max
    );
    run
}

#[test]
fn all() {
    for (from, to, mu, steps) in [
        ([0.48, -0.03, 0.0], [0.54, 0.0, 90.0 * DEG], 0.3, 120),
        ([0.3, 0.0, 0.0], [0.2, 0.13, -90.0 * DEG], 0.3, 120),
        ([0.3, 0.0, 0.0], [0.36, 0.03, PI], 0.3, 120),
        ([0.48, -0.03, 0.0], [0.54, 0.0, 90.0 * DEG], 0.2, 120),
        ([0.48, -0.03, 0.0], [0.54, 0.0, 90.0 * DEG], 0.3, 100),
        ([0.0, 0.1, 30.0 * DEG], [-0.05, -0.1, 0.0], 0.25, 120),
        ([0.0, 0.0, 0.0], [0.0, 0.0, 90.0 * DEG], 0.3, 120),
    ] {
        for f in [1.0, 0.95, 1.05] {
            closed_loop(from, to, mu, f * mu, steps);
        }
    }
}
