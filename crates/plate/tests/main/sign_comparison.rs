//! Runs beside logs where the sign of an amplitude hangs on next to nothing: logs of objects with random shape and friction, started so
//! that an error passes zero at the start of a period.

use std::ops::ControlFlow;
use std::sync::LazyLock;

use bracketry_plate::log::PlateColumns;
use bracketry_plate::run::{
    ExperimentKind, FrictionLaw, PlateOptions, PlateRun, PlateSetup, SignComparison, SignSource, SignStatus,
};
use bracketry_plate::{PlateExperiment, PlateLog, Shape};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// A random object with random friction in an experiment.
fn setup(experiment: ExperimentKind, rng: &mut StdRng) -> PlateSetup {
    let [a, b] = [(); 2].map(|()| rng.random_range(0.05..0.15));
    let shape = match rng.random_range(0..3) {
        0 => Shape::Disk { radius: a },
        1 => Shape::Ellipse { a, b },
        _ => Shape::Rectangle { a, b },
    };
    let start = match experiment {
        ExperimentKind::TranslationX => [0.53, rng.random_range(-0.02..0.02), rng.random_range(-1.5..1.5)],
        _ => [0.3, -0.01, rng.random_range(-1.5..1.5)],
    };
    let options = PlateOptions {
        experiment: Some(experiment),
        omega: Some(3),
        shape: Some(shape),
        mu: Some(rng.random_range(0.15..0.3)),
        friction: Some(FrictionLaw::Coulomb),
        start: Some(start),
        seconds: Some(2.0),
        points: Some(12),
        dt: Some(4e-3),
        sample: Some(4e-3),
        ..PlateOptions::default()
    };
    options.setup(None).unwrap()
}

fn run(setup: &PlateSetup) -> PlateRun {
    setup.run(None, |_| ControlFlow::Continue(())).unwrap()
}

fn started_at(setup: &PlateSetup, value: f64) -> PlateSetup {
    let mut other = setup.clone();
    other.start[setup.coordinate()] = value;
    other
}

/// Two starts less than a micrometer apart, so that the error of one run is just below zero at the start of a period and that of the
/// other just above, with the same signs before; and which start of a period that is.
fn on_either_side(setup: &PlateSetup) -> Option<([PlateSetup; 2], usize)> {
    let signs =
        |value: f64| -> Vec<bool> { run(&started_at(setup, value)).starts.iter().map(|s| s.error > 0.0).collect() };
    let first = |p: &[bool], q: &[bool]| p.iter().zip(q).position(|(p, q)| p != q);
    let start = setup.start[setup.coordinate()];
    let values: Vec<f64> = (-6..=6).map(|k| start + 5e-4 * f64::from(k)).collect();
    let all: Vec<Vec<bool>> = values.iter().map(|value| signs(*value)).collect();
    // The pair whose signs differ first; the error changes steadily between them as far as the signs before agree.
    let (at, k) = (1..all.len()).filter_map(|k| Some((first(&all[k - 1], &all[k])?, k))).min()?;
    let mut pair = [values[k - 1], values[k]];
    while pair[1] - pair[0] > 1e-6 {
        let middle = 0.5 * (pair[0] + pair[1]);
        let found = signs(middle);
        if found[..at] != all[k][..at] {
            return None;
        }
        if found[at] == all[k][at] { pair[1] = middle } else { pair[0] = middle }
    }
    Some((pair.map(|value| started_at(setup, value)), at))
}

/// What a camera logs of a run.
fn logged(run: &PlateRun, noise: f64, plate: bool, rng: &mut StdRng) -> PlateLog {
    // Normal numbers after Box and Muller (1958).
    let mut normal = || {
        let [radius, angle] = [(); 2].map(|()| rng.random_range(f64::MIN_POSITIVE..1.0));
        noise * (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    };
    let mut column = |i: usize| run.rows.iter().map(|r| r.state[i] + normal()).collect::<Vec<f64>>();
    let [x, y, phi] = [0, 1, 2].map(&mut column);
    let motion: Vec<_> = run.rows.iter().map(|r| r.plate).collect();
    let plate = plate.then(|| PlateColumns::new(&motion, false));
    PlateLog { name: "log.csv".into(), t: run.rows.iter().map(|r| r.t).collect(), x, y, phi, plate }
}

fn compared(setup: &PlateSetup, log: PlateLog) -> (PlateExperiment, SignComparison) {
    let ran = PlateExperiment::new(setup.clone(), Some(log), false, |_| ControlFlow::Continue(())).unwrap();
    let signs = ran.comparison.as_ref().unwrap().signs.clone().unwrap();
    (ran, signs)
}

/// Random set-ups with a start of a period that decides, two of each experiment.
static DECIDING: LazyLock<Vec<([PlateSetup; 2], usize)>> = LazyLock::new(|| {
    let mut found = Vec::new();
    for experiment in [ExperimentKind::TranslationX, ExperimentKind::TranslationY] {
        let some = (0..20).filter_map(|seed| {
            let mut rng = StdRng::seed_from_u64(seed);
            on_either_side(&setup(experiment, &mut rng))
        });
        let before = found.len();
        found.extend(some.take(2));
        assert_eq!(found.len() - before, 2, "too few seeds decide");
    }
    found
});

#[test]
fn a_sign_that_noise_decides_is_undecided_from_its_start_on_and_imposed_for_the_log() {
    let mut rng = StdRng::seed_from_u64(7);
    for (pair, at) in DECIDING.iter() {
        let [one, other] = pair;
        for (noise, plate) in [(0.0, false), (3e-4, false), (3e-4, true)] {
            let (ran, signs) = compared(one, logged(&run(other), noise, plate, &mut rng));
            let said = format!("noise {noise}, plate {plate}: {signs:#?}");
            assert_eq!(signs.status(), SignStatus::Undecided, "{said}");
            let opposite = signs.opposite.as_ref().unwrap();
            assert!((opposite.errors.t - *at as f64 * one.experiment.period).abs() < 1e-9, "{at}, {said}");
            let source = match (noise > 0.0, plate) {
                (_, true) => SignSource::LoggedPlate,
                (true, false) => SignSource::LoggedMotion,
                (false, false) => opposite.sign_of_log,
            };
            assert_eq!(opposite.sign_of_log, source, "{said}");
            assert!(ran.comparison.as_ref().unwrap().is_undecided());
            // Before, the run agrees within the noise; with the signs of the log it does so after, too.
            let k = one.coordinate();
            let of = |d: &bracketry_plate::run::PoseDeviations| 1e-3 * [d.x_mm.rms, d.y_mm.rms][k];
            let [before, after, given] =
                [&opposite.before, &opposite.after, &opposite.after_with_signs_of_log].map(|d| of(d.as_ref().unwrap()));
            assert!(before < 1.2 * noise + 1e-4 && given < 1.2 * noise + 1e-4, "{before} {given}, {said}");
            assert!(after > 3.0 * given, "{after} {given}, {said}");
            let depending = 1e-3 * [opposite.depending.x_mm.rms, opposite.depending.y_mm.rms][k];
            assert!((depending / after - 1.0).abs() < 0.3, "{depending} {after}, {said}");
        }
    }
}

#[test]
fn a_sign_within_the_noise_that_both_took_is_close_and_not_undecided() {
    let mut rng = StdRng::seed_from_u64(7);
    for (pair, at) in DECIDING.iter() {
        let one = &pair[0];
        for plate in [false, true] {
            let (ran, signs) = compared(one, logged(&run(one), 3e-4, plate, &mut rng));
            assert_eq!(signs.status(), SignStatus::Agreed, "{signs:#?}");
            let t = *at as f64 * one.experiment.period;
            assert!(signs.close.iter().any(|c| (c.t - t).abs() < 1e-9), "{t}: {signs:#?}");
            assert!(!ran.comparison.unwrap().is_undecided());
        }
    }
}

#[test]
fn errors_beyond_the_noise_decide_and_nothing_is_close() {
    for experiment in [ExperimentKind::TranslationX, ExperimentKind::TranslationY] {
        for seed in 0..4 {
            let mut rng = StdRng::seed_from_u64(seed);
            let mut one = setup(experiment, &mut rng);
            // Far from the target, as it is before the object has arrived.
            one.seconds = 1.0;
            let starts = run(&one).starts;
            let nearest = starts.iter().map(|s| s.error.abs()).fold(f64::INFINITY, f64::min);
            let (ran, signs) = compared(&one, logged(&run(&one), nearest / 20.0, false, &mut rng));
            assert_eq!(signs.status(), SignStatus::Decided, "{nearest}: {signs:#?}");
            assert!(signs.starts >= starts.len() - 1 && signs.opposite.is_none() && signs.close.is_empty());
            assert!((signs.noise / (nearest / 20.0) - 1.0).abs() < 0.2, "{}", signs.noise);
            assert!(ran.with_signs_of_log.is_none());
        }
    }
}

#[test]
fn signs_that_differ_by_more_than_the_deviation_before_contradict() {
    let mut rng = StdRng::seed_from_u64(5);
    let one = setup(ExperimentKind::TranslationY, &mut rng);
    let mut log = logged(&run(&one), 1e-5, false, &mut rng);
    // From the second period on the object of the log is on the other side.
    let first = log.t.partition_point(|t| *t < 0.9 * one.experiment.period);
    log.y[first..].iter_mut().for_each(|y| *y = -*y);
    let (ran, signs) = compared(&one, log);
    assert_eq!(signs.status(), SignStatus::Contradicted, "{signs:#?}");
    let opposite = signs.opposite.unwrap();
    assert!((opposite.errors.t - one.experiment.period).abs() < 1e-9);
    assert!(opposite.errors.run_error < -0.004 && opposite.errors.log_error > 0.004);
    assert!(!ran.comparison.unwrap().is_undecided());
}

#[test]
fn noise_that_is_given_is_used() {
    let mut rng = StdRng::seed_from_u64(2);
    let mut one = setup(ExperimentKind::TranslationY, &mut rng);
    one.seconds = 1.0;
    let log = logged(&run(&one), 0.0, false, &mut rng);
    assert_eq!(compared(&one, log.clone()).1.status(), SignStatus::Decided);
    one.noise = Some(0.05);
    let signs = compared(&one, log).1;
    assert!(signs.noise_given && signs.noise == 0.05);
    assert_eq!(signs.status(), SignStatus::Agreed);
}

#[test]
fn a_constant_amplitude_and_a_logged_motion_have_no_signs_to_compare() {
    let mut rng = StdRng::seed_from_u64(1);
    let mut one = setup(ExperimentKind::TranslationY, &mut rng);
    one.seconds = 0.5;
    let log = logged(&run(&one), 0.0, true, &mut rng);
    let driven = PlateExperiment::new(one.clone(), Some(log), true, |_| ControlFlow::Continue(())).unwrap();
    assert!(driven.comparison.unwrap().signs.is_none());
    let mut turning = setup(ExperimentKind::Orientation, &mut rng);
    turning.seconds = 0.5;
    let log = logged(&run(&turning), 0.0, true, &mut rng);
    let turned = PlateExperiment::new(turning, Some(log), false, |_| ControlFlow::Continue(())).unwrap();
    assert!(turned.comparison.unwrap().signs.is_none());
}
