//! Logs with hidden effects: each effect against the mechanics it stands for, without noise; noise against its size.

use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::driven::Course;
use bracketry_plate::experiment::{AmplitudeStep, Coordinate, Experiment};
use bracketry_plate::recording::{
    PlateMismatch, RecordingError, RecordingSettings, SyntheticLog, multisine, synthetic_log,
};
use bracketry_plate::{AreaObject, DrivenObject, Friction, Object, PlateLog};

const START: [f64; 6] = [0.3, -0.03, 0.0, 0.0, 0.0, 0.0];

fn silent() -> RecordingSettings {
    RecordingSettings { position_noise: 0.0, angle_noise: 0.0, derivatives: true, ..RecordingSettings::default() }
}

fn shaken(displacement: &str, tilt: &str) -> Experiment {
    Experiment {
        name: "shaken".into(),
        coordinate: Coordinate::X,
        start: 0.3,
        target: 0.3,
        period: 10.0,
        displacement: displacement.into(),
        tilt: tilt.into(),
        law: None,
        step: AmplitudeStep::Smooth,
    }
}

const X: &str = "0.03*sin(14*t)*(1 - exp(-8*t^2))";
const TILT: &str = "0.2*sin(11*t + 1)*(1 - exp(-8*t^2))";

fn log(experiment: &Experiment, effect: &PlateMismatch) -> PlateLog {
    synthetic_log(experiment, START, 2.0, effect, &silent(), 0).unwrap().log
}

/// Greatest difference between two columns.
fn apart(a: &PlateLog, b: &PlateLog, name: &str) -> f64 {
    let (a, b) = (a.column(name).unwrap(), b.column(name).unwrap());
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
}

#[test]
fn without_effect_and_noise_the_log_is_the_experiment_on_the_area_contact() {
    let experiment = Experiment::translation_y();
    let contact = AreaContact::new(&Object::REFERENCE, &Friction::Coulomb { mu: 0.3 }, &AreaSettings::default());
    let mut plant = AreaObject::new(contact.unwrap()).unwrap();
    plant.set_state(0.0, START).unwrap();
    let run = experiment.run_on(&mut plant, 2.0).unwrap();
    let log = log(&experiment, &PlateMismatch::None);
    for (row, t) in log.t.iter().enumerate() {
        let state = run.trajectory.state_at(*t);
        for (name, value) in ["x", "y", "phi"].iter().zip(state) {
            assert!((log.column(name).unwrap()[row] - value).abs() < 1e-12, "{name} at {t}");
        }
    }
}

#[test]
fn columns_of_derivatives_are_those_of_the_command() {
    let log = log(&Experiment::orientation(), &PlateMismatch::ActuatorLag(0.02));
    let (x, xdd) = (log.column("X").unwrap(), log.column("der(X,2)").unwrap());
    let (theta, rate) = (log.column("theta").unwrap(), log.column("der(theta,1)").unwrap());
    let h = 0.005;
    for i in 1..log.t.len() - 1 {
        // Differences over h err by h²/12 times the fourth, h²/6 times the third derivative: ω = 4π, X ≤ 25 mm, θ ≤ 15°.
        assert!((xdd[i] - (x[i + 1] - 2.0 * x[i] + x[i - 1]) / (h * h)).abs() < 2e-3 * 3.95);
        assert!((rate[i] - (theta[i + 1] - theta[i - 1]) / (2.0 * h)).abs() < 2e-3 * 3.3);
    }
}

#[test]
fn a_tilted_plate_is_one_whose_command_has_the_tilt_in_it() {
    let angle = 0.5f64.to_radians();
    let hidden = log(&shaken(X, TILT), &PlateMismatch::TiltAboutX(angle));
    let known = log(&shaken(X, &format!("{angle} + {TILT}")), &PlateMismatch::None);
    for name in ["x", "y", "phi"] {
        assert!(apart(&hidden, &known, name) < 1e-9, "{name}");
    }
    assert!(apart(&hidden, &log(&shaken(X, TILT), &PlateMismatch::None), "y") > 2e-3);
}

#[test]
fn an_inclined_axis_pulls_along_it() {
    let angle = 0.5f64.to_radians();
    let hidden = log(&shaken(X, "0"), &PlateMismatch::TiltAboutY(angle));
    // A plate that is accelerated by −g sin a; friction loses 1 − cos a = 4e-5 of itself.
    let pull = 0.5 * 9.81 * angle.sin();
    let known = log(&shaken(&format!("{X} - {pull}*t^2"), "0"), &PlateMismatch::None);
    assert!(apart(&hidden, &known, "x") < 1e-3);
    assert!(apart(&hidden, &log(&shaken(X, "0"), &PlateMismatch::None), "x") > 2e-3);
}

#[test]
fn a_camera_that_is_late_shows_what_was() {
    let now = log(&shaken(X, TILT), &PlateMismatch::None);
    let late = log(&shaken(X, TILT), &PlateMismatch::SensorDelay(0.015));
    for name in ["x", "y", "phi"] {
        let (now, late) = (now.column(name).unwrap(), late.column(name).unwrap());
        assert!((3..late.len()).all(|i| (late[i] - now[i - 3]).abs() < 1e-12));
    }
    assert_eq!(now.column("X"), late.column("X"));
}

#[test]
fn a_tracked_point_goes_round_the_center_of_mass() {
    let mut start = START;
    start[5] = 3.0;
    let experiment = shaken(X, TILT);
    let run = |effect| synthetic_log(&experiment, start, 1.0, &effect, &silent(), 0).unwrap().log;
    let (center, point) = (run(PlateMismatch::None), run(PlateMismatch::CenterOfMass([0.003, 0.004])));
    let of = |log: &PlateLog, name: &str, i: usize| log.column(name).unwrap()[i];
    let mut angles = Vec::new();
    for i in 0..center.t.len() {
        let (dx, dy) = (of(&point, "x", i) - of(&center, "x", i), of(&point, "y", i) - of(&center, "y", i));
        assert!((dx.hypot(dy) - 0.005).abs() < 1e-12);
        angles.push(dy.atan2(dx) - of(&center, "phi", i));
    }
    assert!(angles.iter().all(|a| (a - 0.8f64.asin()).abs() < 1e-9));
    assert!(of(&center, "phi", 100) > 0.1);
}

#[test]
fn friction_effects_are_those_of_the_friction_law() {
    // A push along each axis of a plate at rest: v²/(2 μ g).
    let still = shaken("0", "0");
    let way = |axis: usize, effect| {
        let mut start = START;
        start[3 + axis] = 0.8;
        let log = synthetic_log(&still, start, 1.0, &effect, &silent(), 0).unwrap().log;
        let values = log.column(["x", "y"][axis]).unwrap();
        values[values.len() - 1] - values[0]
    };
    let expected = |mu: f64| 0.64 / (2.0 * 9.81 * mu);
    let (along, across) = (0.3 / 1.2f64.sqrt(), 0.3 * 1.2f64.sqrt());
    // The camber of the pressure by thickness changes nothing on a way straight ahead.
    for (axis, effect, mu) in [
        (0, PlateMismatch::Friction(1.1), 0.33),
        (1, PlateMismatch::Friction(0.9), 0.27),
        (0, PlateMismatch::AnisotropicFriction(1.2), along),
        (1, PlateMismatch::AnisotropicFriction(1.2), across),
    ] {
        assert!((way(axis, effect) / expected(mu) - 1.0).abs() < 1e-3, "{effect:?} along axis {axis}");
    }
}

#[test]
fn noise_has_its_size_and_touches_the_pose_alone() {
    let settings = RecordingSettings::default();
    let experiment = Experiment::orientation();
    let noisy = synthetic_log(&experiment, START, 3.0, &PlateMismatch::None, &settings, 3).unwrap().log;
    let clean = synthetic_log(&experiment, START, 3.0, &PlateMismatch::None, &silent(), 3).unwrap().log;
    for (name, size) in [("x", 0.5e-3), ("y", 0.5e-3), ("phi", 0.3f64.to_radians())] {
        let (a, b) = (noisy.column(name).unwrap(), clean.column(name).unwrap());
        let square = a.iter().zip(b).map(|(p, q)| (p - q).powi(2)).sum::<f64>() / a.len() as f64;
        // 601 samples: the standard error of the standard deviation is 2.9 %.
        assert!((square.sqrt() / size - 1.0).abs() < 0.1, "{name}");
    }
    assert_eq!(noisy.column("theta"), clean.column("theta"));
    let again = synthetic_log(&experiment, START, 3.0, &PlateMismatch::None, &settings, 3).unwrap().log;
    assert_eq!(noisy, again);
    assert_eq!(noisy.csv().lines().count(), 1 + noisy.t.len());
}

#[test]
fn a_multisine_stays_within_its_bounds_and_keeps_the_object_sliding() {
    let settings = RecordingSettings::default();
    for seed in [1, 2] {
        let experiment = multisine(START, 4.0, &settings, seed).unwrap();
        let SyntheticLog { log, outcome } =
            synthetic_log(&experiment, START, 4.0, &PlateMismatch::None, &silent(), 0).unwrap();
        assert!(outcome.is_finished());
        let greatest = |name: &str| log.column(name).unwrap().iter().map(|v| v.abs()).fold(0.0, f64::max);
        assert!(greatest("X") <= 0.1 && greatest("theta") <= 20f64.to_radians());
        // What friction alone can hold is 0.3 g.
        let slides = log.column("der(X,2)").unwrap().iter().filter(|a| a.abs() > 0.3 * 9.81).count();
        assert!(slides > log.t.len() / 3, "{slides} of {}", log.t.len());
    }
}

#[test]
fn a_plate_that_would_jump_is_refused() {
    let error =
        synthetic_log(&Experiment::translation_x(3), START, 2.0, &PlateMismatch::None, &silent(), 0).unwrap_err();
    assert!(matches!(error, RecordingError::Jump { t } if (t - 1.0 / 3.0).abs() < 1e-9), "{error}");
}
