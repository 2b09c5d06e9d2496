//! Sweeps: order, independence of the number of threads, errors as values, cancellation; the maps made of them.

use bracketry_plate::experiment::{Experiment, Limits, Map, Summary, linspace, summarize, sweep};
use bracketry_plate::{ModelObject, PlateError, Shape, published};
use bracketry_sim::SimulationSettings;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

fn run(mu: f64, frequency: f64) -> Result<Summary, PlateError> {
    let system = published(&Shape::REFERENCE_ELLIPSE, mu)?;
    let mut plant = ModelObject::new(&system, [0.48, -0.03, 0.0, 0.0, 0.0, 0.0], &SimulationSettings::default())?;
    let experiment = Experiment::translation_y().with_frequency(frequency);
    summarize(&experiment, &mut plant, 3.0, Limits::default())
}

#[test]
fn the_number_of_threads_changes_no_digit() {
    let map = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Map::compute(&[0.2, 0.3], &[2.5, 3.0], run, |_| ControlFlow::Continue(())))
    };
    let (one, three) = (map(1), map(3));
    assert_eq!(one, three);
    let end = one.get(1, 0).unwrap().as_ref().unwrap().end;
    assert_eq!(end, run(0.3, 2.5).unwrap().end);
    assert!(one.get(2, 0).is_none() && one.get(0, 2).is_none());
}

#[test]
fn a_bad_case_is_a_value_among_the_others() {
    let results = sweep(&[0.3, -1.0], |&mu| run(mu, 3.0).map(|s| s.reached.is_some()), |_| ControlFlow::Continue(()));
    assert_eq!(results[1], Some(Err(PlateError::BadNumber { name: "mu", value: -1.0 })));
    assert!(results[0].as_ref().unwrap().is_ok());
    assert!(matches!(run(0.3, 0.0), Err(PlateError::BadNumber { name: "period", .. })));
}

#[test]
fn progress_counts_every_run_and_can_cancel_the_rest() {
    let cases: Vec<usize> = (0..1000).collect();
    let told = AtomicUsize::new(0);
    let all = sweep(
        &cases,
        |&i| i,
        |_| {
            told.fetch_add(1, Ordering::Relaxed);
            ControlFlow::Continue(())
        },
    );
    assert_eq!(all, cases.iter().map(|&i| Some(i)).collect::<Vec<_>>());
    assert_eq!(told.load(Ordering::Relaxed), 1000);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let some = pool.install(|| {
        sweep(&cases, |&i| i, |done| if done >= 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    let done = some.iter().flatten().count();
    assert!((10..=12).contains(&done), "{done}");
    assert!(some.iter().zip(&cases).all(|(result, case)| result.is_none_or(|r| r == *case)));
}

#[test]
fn an_object_that_slides_without_end_is_stopped_at_the_limit() {
    let system = published(&Shape::REFERENCE_ELLIPSE, 0.1).unwrap();
    let mut plant = ModelObject::new(&system, [0.0; 6], &SimulationSettings::default()).unwrap();
    // Steeper than the friction angle: y falls by ½ g (sin θ − μ cos θ) t².
    let slope = Experiment { tilt: "0.3".into(), law: None, start: 0.0, target: -0.2, ..Experiment::translation_y() };
    let summary = summarize(&slope, &mut plant, 10.0, Limits { travel: 0.25 }).unwrap();
    let fall = 0.5 * 9.81 * (0.3f64.sin() - 0.1 * 0.3f64.cos());
    let passes = (0.25 / fall).sqrt();
    let run_off = summary.run_off.unwrap();
    assert!(run_off >= passes && run_off < passes + slope.period && summary.duration == run_off);
    assert!((summary.reached.unwrap() - (0.98 * 0.2 / fall).sqrt()).abs() < 1e-8);
    assert!((summary.drift() - fall * run_off).abs() < 1e-6);
}

#[test]
fn the_least_load_tells_that_an_object_far_from_the_axis_would_lift_off() {
    // It rests at y = −0.1 m while θ = a sin ωt tilts: the load g cos θ − 0.1 θ'' is least near a quarter of the period later.
    let least = |a: f64| {
        let system = published(&Shape::REFERENCE_ELLIPSE, 5.0).unwrap();
        let mut plant =
            ModelObject::new(&system, [0.0, -0.1, 0.0, 0.0, 0.0, 0.0], &SimulationSettings::default()).unwrap();
        let tilt = format!("-{a}*sin(20*t)");
        let shake = Experiment { tilt, law: None, period: 0.1, ..Experiment::translation_y() };
        summarize(&shake, &mut plant, 0.4, Limits::default()).unwrap().least_load
    };
    let exact = |a: f64| {
        (0..=40_000).map(|i| 1e-5 * f64::from(i)).map(move |t| {
            let s = (20.0 * t).sin();
            9.81 * (a * s).cos() - 0.1 * a * 400.0 * s
        })
    };
    let smallest = |a| exact(a).fold(f64::INFINITY, f64::min);
    assert!((least(0.1) - smallest(0.1)).abs() < 1e-3 && least(0.1) > 5.0);
    assert!(smallest(0.3) < 0.0 && least(0.3) < 0.0);
}

#[test]
fn evenly_spaced_values_include_both_ends() {
    assert_eq!(linspace(2.0, 4.0, 5), [2.0, 2.5, 3.0, 3.5, 4.0]);
    assert_eq!((linspace(1.0, 2.0, 1), linspace(1.0, 2.0, 0)), (vec![1.0], vec![]));
}
