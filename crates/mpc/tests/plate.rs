//! The plate moves an object without grasping it: position and orientation together, on exact stick–slip friction.
#![allow(clippy::unwrap_used)]

mod common;

use bracketry_mpc::{
    Bounds, ClosedLoop, CostFunction, CostKind, Horizon, Ocp, Rti, RtiSettings, Softness, Solution, SolveStatus, Sqp,
    SqpSettings, SymbolicDynamics, TerminalTarget, run_closed_loop,
};
use bracketry_system::System;
use std::f64::consts::{PI, TAU};

const DEG: f64 = PI / 180.0;
const DT: f64 = 0.02;
const STEPS: usize = 120;

fn problem(steps: usize, system: &System, target: [f64; 3]) -> Ocp {
    let mut ocp = Ocp::new(10, 2, steps, DT);
    ocp.stage = Some(CostFunction::parse(system, CostKind::Stage, &[], "0.05*(ax/15)^2 + 0.05*(ath/60)^2").unwrap());
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
    let system = common::plate(mu);
    let ocp = problem(steps, &system, to).tightened(0.05);
    let settings = SqpSettings {
        smoothing: vec![0.1, 0.03, 0.01, 0.003],
        tolerance: 1e-2,
        defect_tolerance: 1e-3,
        max_iterations: 60,
        ..SqpSettings::default()
    };
    let mut sqp = Sqp::new(Box::new(SymbolicDynamics::new(&system).unwrap()), ocp, settings).unwrap();
    let guess = sqp.guess(&start(from), &oscillation(steps)).unwrap();
    sqp.solve(&start(from), &guess).unwrap()
}

fn closed_loop(from: [f64; 3], to: [f64; 3], mu: f64, plant_mu: f64) -> ClosedLoop {
    let plan = plan(from, to, mu, STEPS);
    assert_eq!(plan.status, SolveStatus::Converged);
    let system = common::plate(mu);
    let settings = RtiSettings {
        horizon: Horizon::Shrinking { min_steps: 6 },
        smoothing: Some(0.003),
        proximal: 0.5,
        guarded: true,
        ..RtiSettings::default()
    };
    let dynamics = Box::new(SymbolicDynamics::new(&system).unwrap());
    let mut rti = Rti::new(dynamics, problem(STEPS, &system, to), plan.trajectory, settings).unwrap();
    let mut plant = common::ExactPlant::new(&common::plate(plant_mu), &start(from));
    run_closed_loop(&mut rti, &mut plant, &start(from), STEPS, |_, _| {}).unwrap()
}

/// Object within 2 mm, 2° and 2 °/s of its target, plate at rest, bounds kept.
fn assert_arrived(run: &ClosedLoop, to: [f64; 3]) {
    assert_eq!(run.counts.fallback, 0);
    let end = run.x.last().unwrap();
    let error =
        [(end[0] - to[0]) / 2e-3, (end[1] - to[1]) / 2e-3, (end[2] - to[2]) / (2.0 * DEG), end[5] / (2.0 * DEG)];
    assert!(error.iter().all(|e| e.abs() < 1.0), "relative to the tolerances: {error:?}");
    assert!(end[3] == 0.0 && end[4] == 0.0, "the object sticks");
    assert!(end[6..].iter().all(|v| v.abs() < 2e-3), "plate {:?}", &end[6..]);
    assert!(run.constraint_violation_max < 1e-9, "{}", run.constraint_violation_max);
}

const MAIN: ([f64; 3], [f64; 3]) = ([0.48, -0.03, 0.0], [0.54, 0.0, 90.0 * DEG]);

#[test]
fn position_and_orientation_arrive_together() {
    let run = closed_loop(MAIN.0, MAIN.1, 0.3, 0.3);
    assert_arrived(&run, MAIN.1);
}

#[test]
fn a_quarter_turn_back_over_a_long_way() {
    let to = [0.2, 0.13, -90.0 * DEG];
    assert_arrived(&closed_loop([0.3, 0.0, 0.0], to, 0.3, 0.3), to);
}

#[test]
fn half_a_turn_on_a_slippery_plate() {
    let to = [0.36, 0.03, PI];
    assert_arrived(&closed_loop([0.3, 0.0, 0.0], to, 0.25, 0.25), to);
}

#[test]
fn feedback_makes_up_for_five_percent_more_friction_than_modelled() {
    let run = closed_loop(MAIN.0, MAIN.1, 0.3, 0.315);
    assert_arrived(&run, MAIN.1);
}

#[test]
fn a_target_beyond_the_tilt_is_reported_as_missed() {
    // tan 20° < 0.4: the object hardly slides along y, least of all near y = 0.
    let plan = plan(MAIN.0, MAIN.1, 0.4, STEPS);
    assert!(plan.miss[1].abs() > 5e-3, "{:?}", plan.miss);
}
