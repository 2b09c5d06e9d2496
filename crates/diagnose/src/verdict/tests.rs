//! The statistics on problems whose answer is known.
#![allow(clippy::unwrap_used)]

use bracketry_symbolic::Named;
use nalgebra::{DMatrix, DVector};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

use super::alarm::Alarm;
use super::noise::Scatter;
use super::refused::may_be_nothing;
use super::score::Scores;
use super::write::{physical_name, withhold_guesses, withhold_uncertain};
use crate::report::NamedCause;
use crate::settings::{AlarmSettings, NamingSettings};
use crate::{Cause, Change, Coefficient, Column, Effect, Estimate, Linearization, Normal, Role, WindowFit};

/// The alarm of windows without fitted numbers.
fn alarm_of(windows: &[WindowFit]) -> Alarm {
    Alarm::of(windows, 0, 0, &AlarmSettings::default())
}

fn normal(rng: &mut StdRng) -> f64 {
    StandardNormal.sample(rng)
}

fn windows(rng: &mut StdRng, size: f64, extra: impl Fn(usize) -> f64) -> Vec<WindowFit> {
    (0..20)
        .map(|window| {
            let residuals: Vec<f64> = (0..150).map(|i| size * normal(rng) + extra(150 * window + i)).collect();
            let square = residuals.iter().map(|r| r * r).sum();
            WindowFit { window, x0: vec![], square, count: 150, residuals: vec![residuals], failure: None }
        })
        .collect()
}

#[test]
fn white_noise_of_any_size_rings_as_rarely_as_promised() {
    let mut rng = StdRng::seed_from_u64(5);
    for size in [0.2, 1.0, 4.0] {
        let false_alarms = (0..200).filter(|_| alarm_of(&windows(&mut rng, size, |_| 0.0)).p_value < 0.05).count();
        // 10 expected at most (the correction for several scales is conservative); 20 is three standard deviations more.
        assert!(false_alarms <= 20, "{false_alarms} of 200 at size {size}");
    }
}

#[test]
fn a_slow_residual_below_the_noise_rings() {
    let mut rng = StdRng::seed_from_u64(6);
    let quiet = alarm_of(&windows(&mut rng, 1.0, |_| 0.0));
    let loud = alarm_of(&windows(&mut rng, 1.0, |i| 0.4 * (i as f64 / 40.0).sin()));
    assert!(quiet.p_value > 0.01 && loud.p_value < 1e-10, "{quiet:?} {loud:?}");
    // Excess: 3000 samples with mean square 0.08.
    assert!((loud.excess() - 240.0).abs() < 120.0, "{}", loud.excess());
}

#[test]
fn what_a_simulation_is_inexact_by_does_not_ring() {
    let mut rng = StdRng::seed_from_u64(7);
    let rings =
        |level: f64, rng: &mut StdRng| alarm_of(&windows(rng, 0.0, |i| level * (i as f64 / 40.0).sin())).p_value < 0.01;
    assert!(!rings(0.0, &mut rng) && !rings(0.02, &mut rng));
    assert!(rings(0.3, &mut rng));
}

/// A linear problem: two parameters, three candidates of one column each.
fn problem(rng: &mut StdRng, truth: &DVector<f64>, size: f64) -> (Linearization, DMatrix<f64>, DVector<f64>) {
    let (count, rows, columns) = (25, 12, 5);
    let jacobian = DMatrix::from_fn(count * rows, columns, |_, _| normal(rng));
    let noise = DVector::from_fn(count * rows, |_, _| size * normal(rng));
    let residual = &jacobian * truth + noise;
    // The parameters are already at their best.
    let base = jacobian.columns(0, 2).into_owned();
    let best = (base.tr_mul(&base)).try_inverse().unwrap() * base.tr_mul(&residual);
    let residual = residual - base * best;
    let windows = (0..count)
        .map(|window| {
            let j = jacobian.rows(window * rows, rows);
            let r = residual.rows(window * rows, rows);
            Normal { window, gram: j.tr_mul(&j), gradient: j.tr_mul(&r), square: r.norm_squared(), count: rows }
        })
        .collect();
    let candidate = |candidate| Column::Candidate { candidate, coefficient: 0, trial: 0 };
    let linearization = Linearization {
        columns: vec![Column::Parameter(0), Column::Parameter(1), candidate(0), candidate(1), candidate(2)],
        scales: vec![1.0; columns],
        prior: vec![0.0; columns],
        pull: vec![0.0; columns],
        trials: vec![vec![vec![0.0]]; 3],
        windows,
        failures: Vec::new(),
    };
    (linearization, jacobian, residual)
}

fn least_squares(jacobian: &DMatrix<f64>, residual: &DVector<f64>, columns: &[usize]) -> (DVector<f64>, f64) {
    let j = jacobian.select_columns(columns);
    let x = j.tr_mul(&j).try_inverse().unwrap() * j.tr_mul(residual);
    let left = (residual - j * &x).norm_squared();
    (x, left)
}

#[test]
fn gains_are_those_of_least_squares_with_the_parameters_refitted() {
    let mut rng = StdRng::seed_from_u64(7);
    let (linearization, jacobian, residual) =
        problem(&mut rng, &DVector::from_vec(vec![0.3, -0.2, 0.5, 0.0, -0.1]), 0.3);
    let scores = Scores::new(&linearization);
    for set in [vec![0], vec![1], vec![2], vec![0, 2], vec![0, 1, 2]] {
        let columns: Vec<usize> = [0, 1].into_iter().chain(set.iter().map(|c| c + 2)).collect();
        let (x, left) = least_squares(&jacobian, &residual, &columns);
        let gained = scores.gain(&set);
        assert!((gained.square - (residual.norm_squared() - left)).abs() < 1e-9);
        assert!((gained.step - x.rows(2, set.len())).norm() < 1e-9);
    }
}

#[test]
fn a_step_of_the_wrong_sign_is_not_made() {
    let mut rng = StdRng::seed_from_u64(8);
    let (linearization, ..) = problem(&mut rng, &DVector::from_vec(vec![0.0, 0.0, 0.5, 0.0, -0.4]), 0.1);
    let scores = Scores::new(&linearization);
    assert_eq!(scores.gain_with_signs(&[0, 2], &[1, 1]), {
        let mut alone = scores.gain(&[0]);
        alone.step = DVector::from_vec(vec![alone.step[0], 0.0]);
        alone
    });
    assert_eq!(scores.gain_with_signs(&[0, 2], &[1, -1]), scores.gain(&[0, 2]));
}

#[test]
fn p_values_of_useless_candidates_are_uniform() {
    let mut rng = StdRng::seed_from_u64(10);
    let mut below = 0;
    for _ in 0..400 {
        let (linearization, _, residual) = problem(&mut rng, &DVector::zeros(5), 2.0);
        let scores = Scores::new(&linearization);
        let variance = residual.norm_squared() / (residual.len() as f64 - 2.0);
        let (inflation, independent) = scores.inflation(variance);
        assert!((0.5..2.0).contains(&inflation) && (2.5..=3.0).contains(&independent), "{inflation} {independent}");
        let scatter = Scatter { variance, inflation: 1.0, freedom: 298.0, samples: 298.0 };
        below += usize::from(scatter.p_value(scores.gain(&[rng.random_range(0..3)]).square, 1) < 0.1);
    }
    // 40 expected, standard deviation 6.
    assert!((22..=58).contains(&below), "{below}");
}

#[test]
fn what_stays_the_same_within_windows_is_seen_as_inflation() {
    let mut rng = StdRng::seed_from_u64(11);
    let (mut linearization, ..) = problem(&mut rng, &DVector::zeros(5), 1.0);
    // The candidates' gradients of each window scatter four times as much as white noise would let them.
    for normal in &mut linearization.windows {
        normal.gradient *= 2.0;
    }
    let (inflation, _) = Scores::new(&linearization).inflation(1.0);
    assert!((2.5..6.5).contains(&inflation), "{inflation}");
}

/// An effect with amplitudes of these names, each of a dissipation that vanishes at zero.
fn dissipation(cause: Cause, names: &[&str]) -> Effect {
    let coefficient = |name: &&str| Coefficient {
        name: (*name).to_owned(),
        role: Role::Amplitude,
        nominal: 0.0,
        scale: 0.1,
        min: -1.0,
        max: f64::INFINITY,
        trials: Vec::new(),
        physical_sign: 1,
        sign_flipped: None,
        period_of: None,
        unit: "N".to_owned(),
        about: String::new(),
    };
    Effect {
        cause,
        equation: "v".to_owned(),
        term: "-k*exp(-abs(v))*sign(v)".into(),
        coefficients: names.iter().map(coefficient).collect(),
        change: Change::Terms(Vec::new()),
    }
}

#[test]
fn an_effect_may_be_nothing_if_all_its_intervals_contain_zero() {
    let mut random = StdRng::seed_from_u64(5);
    let effect = dissipation(Cause::ViscousFriction, &["k", "l"]);
    for _ in 0..200 {
        let [k, l] = std::array::from_fn(|_| {
            let (low, width) = (random.random_range(-1.0..1.0), random.random_range(0.0..1.0));
            [low, low + width]
        });
        let interval = |name: &str| Some(if name == "k" { k } else { l });
        assert_eq!(may_be_nothing(&effect, interval), [k, l].iter().all(|[a, b]| a * b <= 0.0), "{k:?} {l:?}");
        // A value without an interval is not known to be nothing.
        assert!(!may_be_nothing(&effect, |name| (name == "k").then_some(k)));
    }
}

#[test]
fn friction_that_may_vanish_at_rest_loses_its_name() {
    let effect = dissipation(Cause::StribeckFriction, &["k"]);
    let name = |value, width| {
        let estimate = Estimate { name: "k".to_owned(), nominal: 0.0, value, std: 0.1 };
        physical_name(&effect, &[&estimate], width, NamingSettings::default().near_no_friction)
    };
    // Falling friction, and friction that rises but is there at rest.
    assert_eq!(name(0.9, 1.0), (Cause::StribeckFriction, Vec::new()));
    assert_eq!(name(-0.7, 1.0).0, Cause::StribeckFriction);
    // Two standard deviations from none.
    assert_eq!(name(-0.8, 1.0).0, Cause::UnknownTerm);
    assert_eq!(name(-0.7, 1.5).0, Cause::UnknownTerm);
}

/// A cause that explains this share of what is there without it.
fn cause(name: Cause, share: f64) -> NamedCause {
    NamedCause {
        name,
        equation: String::new(),
        term: "".into(),
        parameters: Named(Vec::new()),
        p_value: Some(0.0),
        confusable_with: Vec::new(),
        separating_experiment: String::new(),
        rivals: Vec::new(),
        share: Some(share),
        flags: Vec::new(),
        combination: None,
    }
}

#[test]
fn a_small_one_of_several_causes_has_no_name_if_it_may_be_of_several_kinds() {
    let mut random = StdRng::seed_from_u64(6);
    for _ in 0..100 {
        let count = random.random_range(1..6);
        let gained: Vec<f64> = (0..count).map(|_| random.random_range(0.0..2.0)).collect();
        let confusable: Vec<bool> = (0..count).map(|_| random.random_range(0.0..1.0) < 0.5).collect();
        let mut causes: Vec<NamedCause> = confusable
            .iter()
            .map(|&c| NamedCause {
                confusable_with: vec![Cause::QuadraticDrag; usize::from(c)],
                ..cause(Cause::Tilt, 0.5)
            })
            .collect();
        withhold_guesses(&mut causes, &gained.iter().copied().map(Some).collect::<Vec<_>>(), 1.0);
        for (i, cause) in causes.iter().enumerate() {
            let withheld = count > 1 && confusable[i] && gained[i] < 1.0;
            assert_eq!(cause.name == Cause::UnknownTerm, withheld, "{i}: {gained:?} {confusable:?}");
            // Its name stays among those that it may have.
            assert_eq!(cause.confusable_with.contains(&Cause::Tilt), withheld);
        }
    }
}

#[test]
fn small_names_beside_large_unknowns_are_withheld() {
    let names = |mut causes: Vec<NamedCause>| {
        withhold_uncertain(&mut causes, NamingSettings::default().uncertain_share);
        causes.into_iter().map(|c| (c.name, c.confusable_with)).collect::<Vec<_>>()
    };
    let (tilt, drag) = (Cause::Tilt, Cause::QuadraticDrag);
    // Without a term that has no name, small causes keep theirs.
    assert_eq!(names(vec![cause(tilt, 0.9), cause(drag, 0.3)]), [(tilt, vec![]), (drag, vec![])]);
    let unknown = || cause(Cause::UnknownTerm, 0.2);
    assert_eq!(
        names(vec![cause(tilt, 0.9), cause(drag, 0.3), unknown()]),
        [(tilt, vec![]), (Cause::UnknownTerm, vec![drag]), (Cause::UnknownTerm, vec![])]
    );
}
