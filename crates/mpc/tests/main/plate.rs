//! The plate moves an object without grasping it: position and orientation together, on exact stick–slip friction.

use bracketry_mpc::problem::ControlRun;
use bracketry_mpc::{ControlProblem, SolveStatus};
use bracketry_symbolic::Rational;
use bracketry_system::System;
use std::f64::consts::PI;

const DEG: f64 = PI / 180.0;
/// From (0.48, −0.03) to (0.54, 0), turning by 90°.
const MAIN: ([f64; 3], [f64; 3]) = ([0.48, -0.03, 0.0], [0.54, 0.0, 90.0 * DEG]);

fn set_friction(system: &mut System, percent: i64) {
    let mu = Rational::from_parts(percent.into(), 100u8.into());
    assert!(system.set_parameter("mu", mu));
}

/// The problem file's move, between other points and with other friction (in hundredths) in model and plant.
fn problem((from, to): ([f64; 3], [f64; 3]), model_mu: i64, plant_mu: i64) -> ControlProblem {
    let mut p = ControlProblem::read(crate::common::model_path("plate_move.toml")).unwrap();
    set_friction(&mut p.system, model_mu);
    set_friction(&mut p.plant, plant_mu);
    p.x0[..3].copy_from_slice(&from);
    for (target, value) in p.ocp.targets.iter_mut().zip(to) {
        target.value = value;
    }
    p
}

fn run(p: &ControlProblem, disturb: impl FnMut(usize, &mut [f64])) -> ControlRun {
    let mut plant = crate::common::exact_plant(&p.plant, &p.x0);
    p.run_disturbed(&mut plant, disturb).unwrap()
}

/// Object at rest within 2 mm, 2° and `spin` °/s of its target, plate at rest, bounds kept, no step failed.
fn assert_arrived(run: &ControlRun, spin: f64) {
    let r = &run.report;
    assert_eq!(run.plan.as_ref().unwrap().status, SolveStatus::Converged);
    assert_eq!(r.status.fallback, 0);
    for (name, tolerance) in [("x", 2e-3), ("y", 2e-3), ("phi", 2.0 * DEG), ("w", spin * DEG)] {
        assert!(r.miss.get(name).unwrap().abs() < tolerance, "{name} misses by {}", r.miss.get(name).unwrap());
    }
    assert!(*r.x_final.get("vx").unwrap() == 0.0 && *r.x_final.get("vy").unwrap() == 0.0, "the object sticks");
    for name in ["X", "Xd", "theta", "thetad"] {
        assert!(r.miss.get(name).unwrap().abs() < 2e-3, "{name} misses by {}", r.miss.get(name).unwrap());
    }
    assert!(r.constraint_violation_max < 1e-9, "{}", r.constraint_violation_max);
}

#[test]
fn position_and_orientation_arrive_together() {
    assert_arrived(&run(&problem(MAIN, 30, 30), |_, _| {}), 2.0);
}

#[test]
fn a_quarter_turn_back_over_a_long_way() {
    let there = ([0.3, 0.0, 0.0], [0.2, 0.13, -90.0 * DEG]);
    assert_arrived(&run(&problem(there, 30, 30), |_, _| {}), 2.0);
}

#[test]
fn half_a_turn_on_a_slippery_plate() {
    let there = ([0.3, 0.0, 0.0], [0.36, 0.03, PI]);
    assert_arrived(&run(&problem(there, 20, 20), |_, _| {}), 2.0);
}

#[test]
fn feedback_makes_up_for_friction_that_the_model_has_wrong() {
    assert_arrived(&run(&problem(MAIN, 30, 28), |_, _| {}), 5.0);
}

#[test]
fn a_tenth_of_a_second_without_measurements_is_survived() {
    let p = problem(MAIN, 30, 30);
    let run = run(&p, |k, x| {
        if (50..55).contains(&k) {
            x.fill(f64::NAN);
        }
    });
    let r = &run.report;
    assert_eq!(r.status.fallback, 5);
    assert!(
        r.miss.get("x").unwrap().abs() < 2e-3
            && r.miss.get("y").unwrap().abs() < 2e-3
            && r.miss.get("phi").unwrap().abs() < 2.0 * DEG,
        "{:?}",
        r.miss
    );
}

#[test]
fn a_target_beyond_the_tilt_is_reported_as_missed() {
    // tan 20° < 0.4: the object hardly slides along y, least of all near y = 0.
    let plan = problem(MAIN, 40, 40).plan().unwrap();
    assert!(plan.miss[1].abs() > 5e-3, "{:?}", plan.miss);
}
