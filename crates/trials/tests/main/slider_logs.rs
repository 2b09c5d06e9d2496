//! Synthetic logs hold what they promise: equations, sizes, noise, and a truth that the log does not tell.

use bracketry_system::System;
use bracketry_trials::{Excitation, Hidden, Slider, SliderEffect, SliderLog, SliderSensors, SyntheticError};
use rand::SeedableRng;
use rand::rngs::StdRng;

fn basic(seed: u64) -> Slider {
    Slider::basic(SliderSensors::PositionAndVelocity, &mut StdRng::seed_from_u64(seed))
}

fn noiseless(seed: u64) -> Slider {
    Slider { noise: 0.0, lead: 0.0, ..basic(seed) }
}

fn column<'a>(log: &'a SliderLog, name: &str) -> &'a [f64] {
    &log.columns.iter().find(|(n, _)| n == name).unwrap().1
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    (values.map(|v| v * v).sum::<f64>() / n).sqrt()
}

/// Force of the effect beside drive and Coulomb friction, by formulas of its own.
fn force(hidden: &Hidden, x: f64, v: f64, t: f64) -> f64 {
    let Hidden { strength: a, shape: b, .. } = *hidden;
    match hidden.effect {
        SliderEffect::Viscous => -a * v,
        SliderEffect::Stribeck => -a * (-(v / b).powi(2)).exp() * v.signum(),
        SliderEffect::Tilt => a,
        SliderEffect::QuadraticDrag => -a * v * v.abs(),
        SliderEffect::FrictionAsymmetry => -a,
        SliderEffect::LinearStiffness => -a * x,
        SliderEffect::CubicStiffness => -a * x * x * x,
        SliderEffect::PeriodicDisturbance => a * (std::f64::consts::TAU * b * t).sin(),
        SliderEffect::PositionDependentFriction => -a * (b * x).sin() * v.signum(),
        SliderEffect::Cogging => a * (b * x).sin(),
        SliderEffect::CubicDrag => -a * v.powi(3),
        SliderEffect::WarmingFriction => -a * (1.0 - (-t / b).exp()) * v.signum(),
        other => panic!("{other:?} needs more than position, speed and time"),
    }
}

/// Whether the effect's force follows from position, speed and time alone.
fn of_motion(effect: SliderEffect) -> bool {
    use SliderEffect::{ActuatorLag, BristleFriction, ElasticMass, ForceLimit, InputDelay};
    !matches!(effect, InputDelay | ActuatorLag | ElasticMass | BristleFriction | ForceLimit)
}

#[test]
fn momentum_is_what_the_forces_leave() {
    // Between samples at which the slider moves in one direction, m Δv = ∫ (u − F sign v + effect) dt (Simpson's rule for the effect).
    for (seed, effect) in SliderEffect::all().filter(|&e| of_motion(e)).enumerate() {
        let slider = noiseless(seed as u64);
        let log = slider.run(&[effect], seed as u64).unwrap();
        let (t, u, x, v) = (column(&log, "t"), column(&log, "u"), column(&log, "x"), column(&log, "v"));
        let h = 1.0 / slider.rate;
        let mut compared = 0;
        for k in 1..t.len() - 1 {
            // Two steps at once, so that the middle is a sample.
            if v[k - 1].signum() != v[k].signum()
                || v[k].signum() != v[k + 1].signum()
                || v[k - 1..=k + 1].contains(&0.0)
            {
                continue;
            }
            let f = |k: usize| force(&log.truth.hidden[0], x[k], v[k], t[k]);
            let effect = h / 3.0 * (f(k - 1) + 4.0 * f(k) + f(k + 1));
            let impulse = h * (u[k - 1] + u[k]) - 2.0 * h * v[k].signum() + effect;
            let gained = v[k + 1] - v[k - 1];
            assert!((gained - impulse).abs() < 1e-6, "{effect:?} {k}: {gained} {impulse}");
            compared += 1;
        }
        assert!(compared > 5000, "{compared}");
    }
}

#[test]
fn it_sticks_exactly_while_friction_holds_the_drive() {
    let slider = Slider { friction: 2.5, ..noiseless(1) };
    let log = slider.run(&[], 1).unwrap();
    let (u, v) = (column(&log, "u"), column(&log, "v"));
    let at_rest = (0..v.len()).filter(|&k| v[k] == 0.0 && k + 1 < v.len() && v[k + 1] == 0.0);
    let (mut count, mut largest) = (0, 0.0f64);
    for k in at_rest {
        count += 1;
        largest = largest.max(u[k].abs());
    }
    assert!(count > 100 && (1.0..=2.5).contains(&largest), "{count} samples at rest, up to {largest} N");
}

#[test]
fn effects_have_the_size_that_was_asked_for() {
    for (seed, effect) in SliderEffect::all().enumerate() {
        for size in [0.1, 0.03] {
            let slider = Slider { size, duration: 4.0, ..noiseless(seed as u64) };
            let log = slider.run(&[effect], seed as u64).unwrap();
            let hidden = &log.truth.hidden[0];
            let (t, u, x, v) = (column(&log, "t"), column(&log, "u"), column(&log, "x"), column(&log, "v"));
            assert!((rms(u.iter().copied()) - 3.0).abs() < 1e-9);
            if matches!(effect, SliderEffect::InputDelay | SliderEffect::BristleFriction) {
                let strength = if effect == SliderEffect::InputDelay { 0.08 } else { 2e-3 } * size;
                assert!((hidden.strength - strength).abs() < 1e-12);
                assert!((0.5..4.0).contains(&(hidden.size / size)), "{hidden:?}");
                continue;
            }
            assert!((hidden.size / size - 1.0).abs() <= 0.2, "{hidden:?}");
            if of_motion(effect) && !matches!(effect, SliderEffect::FrictionAsymmetry) {
                let at = |k: usize| {
                    if v[k] == 0.0 && force(hidden, x[k], 1.0, t[k]) != force(hidden, x[k], -1.0, t[k]) {
                        0.0
                    } else {
                        force(hidden, x[k], v[k], t[k])
                    }
                };
                let share = rms((0..t.len()).map(at)) / 3.0;
                assert!((share / hidden.size - 1.0).abs() < 1e-6, "{effect:?}: {share} {}", hidden.size);
            }
        }
    }
}

#[test]
fn a_late_force_is_the_force_at_an_earlier_time() {
    // The same slider under a force that is 5 samples late: its motion is 5 samples late, as it starts at rest.
    let slider = Slider { size: 0.0625, ..noiseless(3) };
    let (late, punctual) = (slider.run(&[SliderEffect::InputDelay], 3).unwrap(), slider.run(&[], 3).unwrap());
    assert_eq!(column(&late, "u"), column(&punctual, "u"));
    let (a, b) = (column(&late, "v"), column(&punctual, "v"));
    let difference = (5..a.len()).map(|k| (a[k] - b[k - 5]).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-6, "{difference}");
}

#[test]
fn a_limited_force_is_the_force_up_to_its_limit() {
    let slider = noiseless(4);
    let log = slider.run(&[SliderEffect::ForceLimit], 4).unwrap();
    let (u, v) = (column(&log, "u"), column(&log, "v"));
    let limit = log.truth.hidden[0].strength.powf(-0.125);
    let (mut limited, h) = (0, 1.0 / slider.rate);
    for k in 1..v.len() {
        if v[k - 1] * v[k] > 0.0 {
            let impulse = h * (u[k - 1].clamp(-limit, limit) - v[k].signum());
            assert!((v[k] - v[k - 1] - impulse).abs() < 1e-6, "{k}");
            limited += i32::from(u[k - 1].abs() > limit);
        }
    }
    assert!(limited > 50, "{limited}");
}

#[test]
fn noise_is_white_and_a_share_of_the_column() {
    let clean = noiseless(5);
    let noisy = Slider { noise: 0.01, ..clean.clone() };
    let (clean, noisy) =
        (clean.run(&[SliderEffect::Viscous], 5).unwrap(), noisy.run(&[SliderEffect::Viscous], 5).unwrap());
    assert_eq!(column(&clean, "u"), column(&noisy, "u"));
    for name in ["x", "v"] {
        let (a, b) = (column(&clean, name), column(&noisy, name));
        let noise: Vec<f64> = a.iter().zip(b).map(|(a, b)| b - a).collect();
        let deviation = rms(noise.iter().copied());
        let n = noise.len() as f64;
        // Five standard errors of a standard deviation and of a correlation.
        assert!((deviation / (0.01 * rms(a.iter().copied())) - 1.0).abs() < 5.0 / (2.0 * n).sqrt());
        let lag = noise.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n * deviation * deviation);
        assert!(lag.abs() < 5.0 / n.sqrt(), "{lag}");
    }
}

#[test]
fn the_model_is_off_as_stated_and_the_log_keeps_the_secret() {
    for seed in 0..8 {
        let log = basic(seed).run(&[SliderEffect::Stribeck], seed).unwrap();
        let model = System::parse("slider.toml", &log.model).unwrap();
        let off: Vec<f64> = model.parameters.iter().map(|p| (p.value.to_f64().value() - 1.0).abs()).collect();
        assert!((off[0] - 0.03).abs() < 1e-12 && (off[1] - 0.05).abs() < 1e-12, "{off:?}");
        assert_eq!(log.csv().lines().next().unwrap(), "t,u,x,v");
        assert_eq!(log.csv().lines().count(), 8002);
    }
    let log = Slider { sensors: SliderSensors::Position, ..basic(1) }.run(&[], 1).unwrap();
    assert!(log.csv().starts_with("t,u,x\n"));
    assert!(log.truth.hidden.is_empty());
}

#[test]
fn the_same_seed_gives_the_same_log_and_another_one_another() {
    let run = |seed| basic(seed).run(&[SliderEffect::Tilt], seed).unwrap();
    assert_eq!(run(7), run(7));
    assert_ne!(run(7).columns, run(8).columns);
}

#[test]
fn two_effects_have_a_size_each() {
    let log = basic(2).run(&[SliderEffect::Viscous, SliderEffect::Tilt], 2).unwrap();
    assert!(log.truth.hidden.iter().all(|hidden| (hidden.size / 0.1 - 1.0).abs() < 0.02), "{:?}", log.truth);
}

#[test]
fn random_experiments_can_be_run() {
    let mut random = StdRng::seed_from_u64(11);
    for seed in 0..6 {
        let slider = Slider::random(SliderSensors::PositionAndVelocity, &mut random);
        assert!((200.0..=2000.0).contains(&slider.rate));
        let log = slider.run(&[SliderEffect::Viscous], seed).unwrap();
        assert!(log.columns.iter().all(|(_, values)| values.iter().all(|v| v.is_finite())));
    }
}

#[test]
fn settings_without_meaning_are_refused() {
    let wrong = Slider { rate: 0.0, ..basic(1) };
    assert_eq!(wrong.run(&[], 1), Err(SyntheticError::Setting { name: "rate", value: 0.0 }));
    let wrong = Slider { noise: f64::NAN, ..basic(1) };
    assert!(matches!(wrong.run(&[], 1), Err(SyntheticError::Setting { name: "noise", .. })));
    // Too weak a drive: it never moves, and no viscous friction shows.
    let still = Slider { drive: 0.2, excitation: Excitation::Chirp { low: 1.0, high: 2.0 }, ..basic(1) };
    assert!(matches!(still.run(&[SliderEffect::Viscous], 1), Err(SyntheticError::Size { .. })));
}
