//! The first-principles models in the published experiments: reference results, symmetries, an independent engine's log.
//!
//! The log is read from the directory that `BRACKETRY_SHARED` names, by default `../shared` seen from the workspace root;
//! where there is none, its test passes as ignored and says so.
#![allow(clippy::print_stderr)]

use bracketry_plate::experiment::{Experiment, Run};
use bracketry_plate::model::energy;
use bracketry_plate::model::{Energy, Terms};
use bracketry_plate::{Friction, Object, PlateError, Shape};
use bracketry_plate::{first_principles, published, reduced};
use bracketry_sim::{Balance, SimulationSettings};
use bracketry_system::System;
use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

const MIDDLE: [f64; 6] = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
const START: [f64; 6] = [0.48, -0.03, 0.0, 0.0, 0.0, 0.0];

fn flat(shape: Shape) -> Object {
    Object { shape, height: 0.0, ..Object::REFERENCE }
}

fn run(system: &System, experiment: &Experiment, start: &[f64; 6], duration: f64) -> Run {
    let run = experiment.run(system, start, duration, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

fn orientation(object: &Object, mu: f64) -> Run {
    run(&reduced(object, mu, Terms::default()).unwrap(), &Experiment::orientation(), &MIDDLE, 15.0)
}

fn final_yaw(run: &Run) -> f64 {
    run.trajectory.final_state()[2].to_degrees()
}

/// First time at which the yaw is 90°, to a millisecond.
fn quarter(run: &Run) -> f64 {
    (0..15000).map(|i| 1e-3 * f64::from(i)).find(|&t| run.trajectory.sample(t)[2] >= FRAC_PI_2).unwrap()
}

fn within_3_percent(value: f64, reference: f64) -> bool {
    (value / reference - 1.0).abs() < 0.03
}

#[test]
fn experiment_1_turns_as_the_area_contact_does() {
    let disk = orientation(&flat(Shape::REFERENCE_DISK), 0.3);
    assert!(within_3_percent(final_yaw(&disk), 117.8), "{}", final_yaw(&disk));
    assert!(within_3_percent(quarter(&disk), 12.0), "{}", quarter(&disk));
    let slippery = orientation(&flat(Shape::REFERENCE_DISK), 0.2);
    assert!(within_3_percent(final_yaw(&slippery), 151.0), "{}", final_yaw(&slippery));
    assert!(within_3_percent(quarter(&slippery), 9.5), "{}", quarter(&slippery));
    let ellipse = orientation(&flat(Shape::REFERENCE_ELLIPSE), 0.3);
    assert!(within_3_percent(final_yaw(&ellipse), 88.0), "{}", final_yaw(&ellipse));
}

#[test]
fn thickness_speeds_experiment_1_up_as_in_the_reference() {
    let thick = orientation(&Object::REFERENCE, 0.3);
    assert!(within_3_percent(final_yaw(&thick), 121.1) && within_3_percent(quarter(&thick), 11.7));
    assert!(final_yaw(&thick) > final_yaw(&orientation(&flat(Shape::REFERENCE_DISK), 0.3)) + 2.0);
}

#[test]
fn experiment_1_sticks_where_friction_holds_both_accelerations() {
    // |(X'', g sin θ)| ≤ |(3.95, 2.54)| = 4.70 against 0.5 g cos 15° = 4.74.
    let stuck = orientation(&flat(Shape::REFERENCE_DISK), 0.5);
    for (end, start) in stuck.trajectory.final_state().iter().zip(MIDDLE) {
        assert!((end - start).abs() < 1e-9);
    }
}

#[test]
fn experiment_2_needs_no_more_than_a_point() {
    // Without tilt the pressure is even and gives no torque: the reduced model is a point contact.
    for (omega, reference) in [(3, 2.4), (4, 1.5)] {
        let experiment = Experiment::translation_x(omega);
        let body = reduced(&Object::REFERENCE, 0.3, Terms::default()).unwrap();
        let point = first_principles(&Object::REFERENCE, &Friction::Coulomb { mu: 0.3 }, Terms::default()).unwrap();
        let (body, point) = (run(&body, &experiment, &START, 6.0), run(&point, &experiment, &START, 6.0));
        assert!(within_3_percent(body.reached.unwrap(), reference), "{:?}", body.reached);
        assert!((body.reached.unwrap() - point.reached.unwrap()).abs() < 1e-6);
        for (a, b) in body.trajectory.final_state().iter().zip(point.trajectory.final_state()) {
            assert!((a - b).abs() < 1e-8);
        }
    }
}

#[test]
fn experiment_3_reaches_the_target_or_stalls_as_in_the_reference() {
    let experiment = Experiment::translation_y();
    let reached =
        run(&reduced(&flat(Shape::REFERENCE_DISK), 0.3, Terms::default()).unwrap(), &experiment, &START, 15.0);
    // The tenth period, to 3.33 s, ends with 97.9 % of the way.
    let covered = 1.0 + reached.trajectory.sample(3.3)[1] / 0.03;
    assert!((covered - 0.98).abs() < 0.002, "{covered}");
    let (low, high) = reached.range(14.0);
    assert!(within_3_percent(1e3 * (high - low), 3.2), "{}", high - low);
    let stalled =
        run(&reduced(&flat(Shape::REFERENCE_DISK), 0.4, Terms::default()).unwrap(), &experiment, &START, 15.0);
    assert!(stalled.reached.is_none() && within_3_percent(1e3 * stalled.final_error(), -6.3));
}

#[test]
fn experiment_3_is_that_of_an_independent_engine() {
    let shared = std::env::var("BRACKETRY_SHARED")
        .map_or_else(|_| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")), PathBuf::from);
    let Ok(log) = std::fs::read_to_string(shared.join("data/plate/exp3_disk_mu0.3.csv")) else {
        eprintln!("ignored: no logs in {}", shared.display());
        return;
    };
    let mut lines = log.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| columns.iter().position(|c| *c == name).unwrap();
    let (t, y) = (column("t"), column("y_plate"));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    let system = reduced(&Object::REFERENCE, 0.3, Terms::default()).unwrap();
    let run = run(&system, &Experiment::translation_y(), &START, 10.0);
    let squares = rows.iter().filter(|r| r[t] <= 10.0).map(|r| (run.trajectory.sample(r[t])[1] - r[y]).powi(2));
    let rms = (squares.sum::<f64>() / rows.len() as f64).sqrt();
    assert!(rms < 0.5e-3, "{rms}");
}

#[test]
fn the_mirror_image_of_a_motion_is_a_motion() {
    // y → −y with θ → −θ turns φ round.
    let system =
        reduced(&Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE }, 0.25, Terms::default()).unwrap();
    let start = [0.3, 0.02, 0.3, 0.0, 0.0, 0.0];
    let image = [0.3, -0.02, -0.3, 0.0, 0.0, 0.0];
    let one = run(&system, &Experiment::orientation(), &start, 6.0);
    let other = run(&system, &Experiment::orientation().with_reversed_tilt(), &image, 6.0);
    let signs = [1.0, -1.0, -1.0, 1.0, -1.0, -1.0];
    let (one, other) = (one.trajectory.final_state().to_vec(), other.trajectory.final_state().to_vec());
    for i in 0..6 {
        assert!((one[i] - signs[i] * other[i]).abs() < 1e-9, "{i}: {} {}", one[i], other[i]);
    }
    assert!(one[2] - 0.3 > 0.1);
}

#[test]
fn the_place_along_the_axis_of_the_plate_does_not_matter() {
    let system = reduced(&Object::REFERENCE, 0.25, Terms::default()).unwrap();
    let here = run(&system, &Experiment::orientation(), &MIDDLE, 6.0);
    let there = run(&system, &Experiment::orientation(), &[-1.7, 0.0, 0.0, 0.0, 0.0, 0.0], 6.0);
    for i in 0..6 {
        let shift = if i == 0 { 2.0 } else { 0.0 };
        let difference = here.trajectory.final_state()[i] - there.trajectory.final_state()[i] - shift;
        assert!(difference.abs() < 1e-9, "{i}: {difference:e}");
    }
}

#[test]
fn an_elongated_body_turns_slowly_along_the_plate_and_fast_across_it() {
    // The torque is Syy θ'' against the inertia Sxx + Syy; friction against the spin goes with Sxx, slip being mostly along x.
    let long = flat(Shape::Rectangle { a: 0.2, b: 0.04 });
    let disk = orientation(&flat(Shape::REFERENCE_DISK), 0.3).trajectory.sample(5.0)[2];
    let system = reduced(&long, 0.3, Terms::default()).unwrap();
    let turned = |yaw: f64| {
        let run = run(&system, &Experiment::orientation(), &[0.3, 0.0, yaw, 0.0, 0.0, 0.0], 5.0);
        run.trajectory.final_state()[2] - yaw
    };
    let (along, across) = (turned(0.0), turned(FRAC_PI_2));
    assert!(0.0 < along && along < 0.2 * disk, "{along} {disk}");
    assert!(across > 2.0 * disk, "{across} {disk}");
}

#[test]
fn each_of_the_neglected_terms_shows() {
    // Without friction against the spin the object turns many times.
    let turned = |terms: Terms| {
        let system = reduced(&flat(Shape::REFERENCE_DISK), 0.3, terms).unwrap();
        final_yaw(&run(&system, &Experiment::orientation(), &MIDDLE, 15.0))
    };
    assert!(turned(Terms { yaw_friction: false, ..Terms::default() }) > 720.0);
    // The centrifugal term carries a slippery object off the plate.
    let end = |terms: Terms| {
        let system = reduced(&flat(Shape::REFERENCE_DISK), 0.1, terms).unwrap();
        run(&system, &Experiment::orientation(), &MIDDLE, 15.0).trajectory.final_state()[1].abs()
    };
    let (with, without) = (end(Terms::default()), end(Terms { centrifugal: false, ..Terms::default() }));
    assert!(with > 0.5 && without < 0.1, "{with} {without}");
}

#[test]
fn stuck_objects_stay_whatever_the_law() {
    let laws = [
        Friction::Coulomb { mu: 0.3 },
        Friction::Stribeck { mu: 0.2, mu_static: 0.3, velocity: 0.05 },
        Friction::Viscous { mu: 0.3, coefficient: 0.5 },
        Friction::Anisotropic { mu_along: 0.1, mu_across: 0.3 },
    ];
    let mut still = Experiment::translation_y();
    (still.tilt, still.law) = ("10*pi/180".into(), None);
    for law in laws {
        let system = first_principles(&Object::REFERENCE, &law, Terms::default()).unwrap();
        let run = run(&system, &still, &START, 60.0);
        for (end, start) in run.trajectory.final_state().iter().zip(START) {
            assert!((end - start).abs() < 1e-9, "{law:?}");
        }
    }
    // Along y a groove with little friction lets it go.
    let groove = Friction::Anisotropic { mu_along: 0.3, mu_across: 0.1 };
    let system = first_principles(&Object::REFERENCE, &groove, Terms::default()).unwrap();
    let slid = run(&system, &still, &START, 1.0).trajectory.final_state()[1] - START[1];
    let (s, c) = 10f64.to_radians().sin_cos();
    assert!((slid + 0.5 * 9.81 * (s - 0.1 * c)).abs() < 1e-9, "{slid}");
}

#[test]
fn a_static_level_holds_beyond_the_sliding_one_and_then_lets_go() {
    let law = Friction::StaticLevel { mu: 0.3, mu_static: 0.4 };
    for terms in [Terms::default(), Terms { coupled: false, ..Terms::default() }] {
        let system = first_principles(&Object::REFERENCE, &law, terms).unwrap();
        // Between the levels, tan 20° = 0.364, and beyond both, tan 22° = 0.404.
        let slid = |tilt: f64| {
            let mut still = Experiment::translation_y();
            (still.tilt, still.law) = (format!("{tilt}"), None);
            run(&system, &still, &START, 1.0).trajectory.final_state()[1] - START[1]
        };
        assert!(slid(20f64.to_radians()).abs() < 1e-9);
        let (s, c) = 22f64.to_radians().sin_cos();
        assert!((slid(22f64.to_radians()) + 0.5 * 9.81 * (s - 0.3 * c)).abs() < 1e-9);
    }
}

/// Error of the energy balance over experiment 1, relative to the energy exchanged.
fn imbalance(system: &System, account: &Energy) -> f64 {
    let experiment = Experiment::orientation();
    let run = run(system, &experiment, &[0.3, 0.01, 0.4, 0.0, 0.0, 0.0], 15.0);
    let mut balance = Balance::new(system, &experiment.inputs(0.0), &account.stored, &account.power, &[]).unwrap();
    let account = balance.of(&run.trajectory);
    assert!(account.turnover > 1.0);
    account.relative_error()
}

#[test]
fn the_energy_balance_of_experiment_1_closes() {
    let thick = Object { shape: Shape::REFERENCE_ELLIPSE, height: 0.02, ..Object::REFERENCE };
    let system = reduced(&thick, 0.25, Terms::default()).unwrap();
    let account = energy(&system).unwrap();
    assert!(imbalance(&system, &account) < 1e-6, "{:e}", imbalance(&system, &account));
    // It would not without one of the terms.
    for terms in [
        Terms { centrifugal: false, ..Terms::default() },
        Terms { gyroscopic: false, ..Terms::default() },
        Terms { thickness: false, ..Terms::default() },
    ] {
        let system = reduced(&thick, 0.25, terms).unwrap();
        assert!(imbalance(&system, &account) > 1e-5, "{terms:?} {:e}", imbalance(&system, &account));
    }
}

#[test]
fn the_energy_balance_closes_under_every_law_of_friction() {
    for law in [
        Friction::Coulomb { mu: 0.25 },
        Friction::StaticLevel { mu: 0.25, mu_static: 0.3 },
        Friction::Stribeck { mu: 0.2, mu_static: 0.3, velocity: 0.05 },
        Friction::Anisotropic { mu_along: 0.2, mu_across: 0.3 },
        Friction::Viscous { mu: 0.25, coefficient: 0.2 },
    ] {
        let system = first_principles(&Object::REFERENCE, &law, Terms::default()).unwrap();
        let account = energy(&system).unwrap();
        assert!(imbalance(&system, &account) < 1e-6, "{law:?} {:e}", imbalance(&system, &account));
    }
}

#[test]
fn models_without_contact_forces_have_no_account() {
    let system = published(&Shape::REFERENCE_DISK, 0.3).unwrap();
    assert_eq!(energy(&system), Err(PlateError::NoDefinition { name: "fx" }));
}
