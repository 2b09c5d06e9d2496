//! A diagnosis costs no more than it did, by counts that are the same on every machine.
#![allow(clippy::print_stdout)]

use bracketry_diagnose::{DiagnosisSettings, Effort};
use bracketry_trials::{Choice, SliderEffect, SliderSensors, SliderTrial};

fn effort(choice: Choice, seed: u64) -> Effort {
    let mut trial = SliderTrial::draw(choice, SliderSensors::PositionAndVelocity, 0.1, false, seed);
    trial.slider.rate = 200.0;
    trial.run(&DiagnosisSettings::default()).unwrap().0.effort
}

/// What was counted, beside what it may be: a tenth more fails.
fn assert_within(what: &str, counted: Effort, budget: Effort) {
    let rows = [
        ("fits", counted.fits, budget.fits),
        ("linearizations", counted.linearizations, budget.linearizations),
        ("simulations", counted.simulations, budget.simulations),
        ("steps", counted.steps, budget.steps),
        ("rejected", counted.rejected, budget.rejected),
        ("evaluations", counted.evaluations, budget.evaluations),
    ];
    for (name, counted, budget) in rows {
        println!("{what}: {counted} {name} of {budget}");
    }
    for (name, counted, budget) in rows {
        assert!(
            counted <= budget || 10 * counted < 11 * budget,
            "{what}: {counted} {name}, more than a tenth above {budget}"
        );
    }
}

#[test]
fn a_slider_with_one_effect_costs_no_more_than_before() {
    let budget =
        Effort { fits: 7, linearizations: 5, simulations: 2983, steps: 381_555, rejected: 0, evaluations: 2_718_452 };
    assert_within("viscous friction", effort(Choice::Only(SliderEffect::Viscous), 1), budget);
}

#[test]
fn the_effort_does_not_depend_on_how_threads_share_it() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let of = |threads| pool(threads).install(|| effort(Choice::Nothing, 2));
    assert_eq!(of(1), of(3));
}
