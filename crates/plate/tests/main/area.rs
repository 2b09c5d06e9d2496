//! Area contact: mechanics known in closed form, symmetries, balances, the reference results and the logs of an independent
//! engine.
//!
//! The logs are read from the folder that `BRACKETRY_SHARED` names (default `../shared` seen from the workspace root);
//! where it is absent, the comparison with them passes as not made and says so.
#![allow(clippy::print_stderr)]

use bracketry_plate::area::{AreaContact, AreaEvent, AreaOutcome, AreaRecord, AreaSettings, Scheme};
use bracketry_plate::driven::Course;
use bracketry_plate::experiment::Experiment;
use bracketry_plate::model::Terms;
use bracketry_plate::{AreaObject, DrivenObject, Friction, Object, PlateKinematics, PlateMotion, Shape};
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;

const G: f64 = 9.81;
const R: f64 = 0.12;

fn still(_: f64) -> PlateKinematics {
    PlateKinematics::default()
}

fn tilted(angle: f64) -> impl FnMut(f64) -> PlateKinematics {
    move |_| PlateKinematics { tilt: angle, ..PlateKinematics::default() }
}

/// A shaken and rocking plate.
fn shaken(strength: f64) -> impl FnMut(f64) -> PlateKinematics + Copy {
    move |t| {
        let (a, b, p, q) = (0.02 * strength, 0.2 * strength, 4.0 * PI, 6.0 * PI);
        PlateKinematics {
            displacement: a * (p * t).sin(),
            velocity: a * p * (p * t).cos(),
            acceleration: -a * p * p * (p * t).sin(),
            tilt: b * (q * t).sin(),
            tilt_rate: b * q * (q * t).cos(),
            tilt_acceleration: -b * q * q * (q * t).sin(),
        }
    }
}

fn flat(shape: Shape) -> Object {
    Object { shape, height: 0.0, mass: 0.2, ..Object::REFERENCE }
}

fn contact(object: &Object, mu: f64, settings: &AreaSettings, state: [f64; 6]) -> AreaContact {
    let mut contact = AreaContact::new(object, &Friction::Coulomb { mu }, settings).unwrap();
    contact.set_state(state).unwrap();
    contact
}

fn run(contact: &mut AreaContact, mut motion: impl PlateMotion, t_end: f64) -> AreaRecord {
    let (record, outcome) = contact.record(&mut motion, t_end).unwrap();
    assert_eq!(outcome, AreaOutcome::Finished);
    record
}

/// The experiment with an object of 0.2 kg that starts where its coordinate does, otherwise at `x = 0.3 m`, `y = 0`.
fn experiment(
    experiment: &Experiment,
    object: &Object,
    mu: f64,
    step: f64,
    duration: f64,
) -> bracketry_plate::experiment::Run<AreaRecord> {
    // 24 points agree with 768 to 0.01 %; see the example `plate_area`.
    let settings = AreaSettings::default().with_step(step).with_points(24);
    let contact = AreaContact::new(object, &Friction::Coulomb { mu }, &settings).unwrap();
    let mut plant = AreaObject::new(contact).unwrap();
    let mut state = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let index = experiment.index();
    state[index] = experiment.start;
    plant.set_state(0.0, state).unwrap();
    let run = experiment.run_on(&mut plant, duration).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

fn yaw_at(record: &AreaRecord, t: f64) -> f64 {
    record.state_at(t)[2].to_degrees()
}

fn quarter_turn(record: &AreaRecord) -> f64 {
    record.samples.iter().find(|s| s.state[2] >= FRAC_PI_2).unwrap().t
}

fn sticks(record: &AreaRecord) -> Vec<f64> {
    record.events.iter().filter_map(|e| if let AreaEvent::Sticks { t } = e { Some(*t) } else { None }).collect()
}

#[test]
fn a_spinning_disk_stops_in_the_time_of_the_uniform_pressure() {
    // Torque 2/3 μ m g R against the inertia m R²/2.
    for scheme in [Scheme::Euler, Scheme::SecondOrder] {
        let settings = AreaSettings::default().with_scheme(scheme);
        let mut disk = contact(&flat(Shape::Disk { radius: R }), 0.3, &settings, [0.0, 0.0, 0.0, 0.0, 0.0, 10.0]);
        let record = run(&mut disk, still, 0.5);
        let time = 3.0 * R * 10.0 / (4.0 * 0.3 * G);
        assert_eq!(sticks(&record).len(), 1);
        assert!((sticks(&record)[0] - time).abs() < 1e-9, "{:?}", sticks(&record));
        assert_eq!(disk.state()[3..], [0.0; 3]);
        // It stays where it is.
        let end = disk.state();
        run(&mut disk, still, 1.5);
        assert_eq!(disk.state(), end);
    }
}

#[test]
fn a_sliding_object_stops_as_a_block_does() {
    for shape in [Shape::REFERENCE_ELLIPSE, Shape::Rectangle { a: 0.1, b: 0.05 }] {
        let mut block = contact(&flat(shape), 0.25, &AreaSettings::default(), [0.0, 0.0, 0.4, 0.6, -0.8, 0.0]);
        let record = run(&mut block, still, 0.6);
        let (time, way) = (1.0 / (0.25 * G), 1.0 / (2.0 * 0.25 * G));
        assert!((sticks(&record)[0] - time).abs() < 1e-9);
        // The second-order scheme is exact for constant deceleration; the last step is one of implicit Euler.
        let [x, y, phi, ..] = block.state();
        assert!((x - 0.6 * way).abs() < 2e-6 && (y + 0.8 * way).abs() < 2e-6);
        assert!((phi - 0.4).abs() < 1e-12);
    }
}

#[test]
fn sliding_and_spinning_end_together_at_the_known_ratio() {
    // Whatever the start, v/(w R) of a uniform disk tends to 0.653 (Farkas, Bartels, Unger and Wolf 2003).
    for (ratio, w) in [(0.653, 6.0), (0.9, 4.0), (0.4, 8.0)] {
        let settings = AreaSettings::default().with_points(192);
        let start = [0.0, 0.0, 0.0, ratio * w * R, 0.0, w];
        let mut disk = contact(&flat(Shape::Disk { radius: R }), 0.3, &settings, start);
        let record = run(&mut disk, still, 0.6);
        assert_eq!(sticks(&record).len(), 1);
        let moving = record.samples.iter().filter(|s| s.state[5] > 0.0);
        let off: Vec<f64> = moving.map(|s| s.state[3] / (s.state[5] * R) - 0.653).collect();
        // The last milliseconds, of a few steps, are left out.
        let off = &off[..off.len() - 3];
        assert!(off.windows(2).all(|pair| pair[1].abs() < pair[0].abs().max(0.01)), "{ratio}: {off:?}");
        assert!(off[off.len() - 1].abs() < 0.2 * off[0].abs().max(0.05), "{ratio}: {off:?}");
    }
}

#[test]
fn what_friction_holds_does_not_creep() {
    // 10° tilt at μ = 0.3 for a minute, also on a vibrating plate as long as friction suffices.
    for height in [0.0, 0.0025, 0.02] {
        let object = Object { height, ..Object::REFERENCE };
        let start = [0.3, -0.03, 0.2, 0.0, 0.0, 0.0];
        let mut held = contact(&object, 0.3, &AreaSettings::default().with_step(0.01), start);
        run(&mut held, tilted(10f64.to_radians()), 60.0);
        assert_eq!(held.state(), start);
        let mut held = contact(&object, 0.3, &AreaSettings::default(), start);
        let shaken = shaken(0.2);
        let record = run(&mut held, shaken, 2.0);
        assert_eq!(held.state(), start, "{:?}", record.events.first());
    }
}

#[test]
fn an_incline_lets_go_at_the_angle_of_friction() {
    let critical = 0.3f64.atan();
    for shape in [Shape::REFERENCE_DISK, Shape::Rectangle { a: 0.1, b: 0.02 }] {
        let mut held = contact(&flat(shape.clone()), 0.3, &AreaSettings::default(), [0.0; 6]);
        run(&mut held, tilted(critical - 1e-9), 1.0);
        assert_eq!(held.state(), [0.0; 6]);
        let mut slides = contact(&flat(shape), 0.3, &AreaSettings::default(), [0.0; 6]);
        let angle = critical + 0.01;
        run(&mut slides, tilted(angle), 1.0);
        let acceleration = G * (angle.sin() - 0.3 * angle.cos());
        assert!((slides.state()[4] + acceleration).abs() < 1e-12);
        assert!((slides.state()[1] + 0.5 * acceleration).abs() < 1e-3 * acceleration);
    }
}

#[test]
fn experiment_1_gives_the_reference_results() {
    let disk = |height| Object { height, ..Object::REFERENCE };
    let ellipse = Object { height: 0.0, shape: Shape::REFERENCE_ELLIPSE, mass: 0.2, ..Object::REFERENCE };
    let orientation = Experiment::orientation();
    for (object, mu, time, yaw) in [
        (disk(0.0), 0.3, 12.0, 117.8),
        (disk(0.0025), 0.3, 11.7, 121.1),
        (disk(0.0), 0.2, 9.5, 151.0),
        (ellipse, 0.3, f64::INFINITY, 88.0),
    ] {
        let run = experiment(&orientation, &object, mu, 4e-3, 15.0);
        let record = &run.trajectory;
        assert!((yaw_at(record, 15.0) / yaw - 1.0).abs() < 0.01, "{}, not {yaw}", yaw_at(record, 15.0));
        if time.is_finite() {
            assert!((quarter_turn(record) / time - 1.0).abs() < 0.02, "{}, not {time}", quarter_turn(record));
        }
        assert!(record.energy.relative_error() < 1e-12);
    }
    // At mu = 0.5 it sticks but for a moment of each period, in which the pressure is least where friction is needed.
    let stuck = experiment(&orientation, &disk(0.0), 0.5, 4e-3, 15.0);
    assert!(yaw_at(&stuck.trajectory, 15.0).abs() < 0.5);
    let longer = Object { height: 0.0, shape: Shape::REFERENCE_ELLIPSE, mass: 0.2, ..Object::REFERENCE };
    let stuck = experiment(&orientation, &longer, 0.5, 4e-3, 15.0);
    assert_eq!(stuck.trajectory.state_at(15.0), [0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn friction_of_each_axis_on_its_own_hardly_turns_the_object() {
    let settings = |coupled| {
        AreaSettings::default().with_step(4e-3).with_points(24).with_terms(Terms { coupled, ..Terms::default() })
    };
    let turned = |coupled| {
        let mut motion = Experiment::orientation().motion(0.0).unwrap();
        let mut disk = contact(&flat(Shape::REFERENCE_DISK), 0.3, &settings(coupled), [0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
        disk.advance(&mut motion, 15.0).unwrap();
        disk.state()[2].to_degrees()
    };
    let (coupled, uncoupled) = (turned(true), turned(false));
    assert!((coupled - 118.0).abs() < 1.0 && uncoupled.abs() < 7.0, "{coupled} and {uncoupled}");
}

/// Columns `t, x, y, phi` of a log, if it is there.
fn log(name: &str) -> Option<Vec<[f64; 4]>> {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shared = std::env::var("BRACKETRY_SHARED").map_or_else(|_| workspace.join("../shared"), PathBuf::from);
    let path = shared.join("data/plate").join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("not compared: {} cannot be read", path.display());
        return None;
    };
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns = ["t", "x_plate", "y_plate", "phi_plate"].map(|c| names.iter().position(|n| *n == c).unwrap());
    Some(
        lines
            .map(|line| {
                let fields: Vec<&str> = line.split(',').collect();
                columns.map(|c| fields[c].parse().unwrap())
            })
            .collect(),
    )
}

#[test]
fn the_logs_of_an_independent_engine_agree_in_orientation() {
    let Some(log) = log("exp1_disk_mu0.3.csv") else { return };
    let run = experiment(&Experiment::orientation(), &Object::REFERENCE, 0.3, 4e-3, 15.0);
    let end = log.last().unwrap();
    let yaw = run.trajectory.state_at(end[0])[2];
    assert!((yaw / end[3] - 1.0).abs() < 0.1, "{yaw}, log {}", end[3]);
    // All the way, from the first eighth of a turn on.
    for row in log.iter().filter(|row| row[3] > PI / 4.0) {
        assert!((run.trajectory.state_at(row[0])[2] / row[3] - 1.0).abs() < 0.1, "{row:?}");
    }
}

#[test]
fn the_logs_of_an_independent_engine_agree_in_position() {
    let cases = [
        ("exp2_disk_w3pi_mu0.3.csv", Experiment::translation_x(3)),
        ("exp3_disk_mu0.3.csv", Experiment::translation_y()),
    ];
    for (name, published) in cases {
        let Some(log) = log(name) else { return };
        let end = log.last().unwrap()[0];
        let run = experiment(&published, &Object::REFERENCE, 0.3, 2e-3, end);
        for (k, coordinate) in ["x", "y"].into_iter().enumerate() {
            let squares: f64 = log.iter().map(|row| (run.trajectory.state_at(row[0])[k] - row[k + 1]).powi(2)).sum();
            let rms = (squares / log.len() as f64).sqrt();
            assert!(rms < 3e-3, "{name}: {coordinate} is off by {rms} m rms");
        }
    }
}
