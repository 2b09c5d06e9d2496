//! An effect chosen at random is hidden in the log of a slider, and the diagnosis must name it from the CSV alone.
//!
//! Seeds are fixed here; `cargo run --release -p bracketry-trials --example hidden_effects --features measure` takes any, and many more.

use bracketry_diagnose::DiagnosisSettings;
use bracketry_trials::{Choice, Score, SliderSensors, SliderTrial};

const XV: SliderSensors = SliderSensors::PositionAndVelocity;
const X: SliderSensors = SliderSensors::Position;

/// Diagnoses one log per seed, sampled at 250 Hz to be quick, and returns what they scored with a text for messages.
fn scores(choice: Choice, sensors: SliderSensors, size: f64, seeds: std::ops::Range<u64>) -> Vec<(Score, String)> {
    let score = |seed| {
        let mut trial = SliderTrial::draw(choice, sensors, size, false, seed);
        trial.slider.rate = 250.0;
        let (report, score) = trial.run(&DiagnosisSettings::default()).unwrap();
        (score, format!("seed {seed}, {:?} hidden:\n{report:?}", trial.hidden))
    };
    seeds.map(score).collect()
}

#[test]
fn an_effect_of_a_tenth_of_the_drive_is_named() {
    for (score, text) in scores(Choice::Any, XV, 0.1, 1..3) {
        assert_eq!(score, Score::Exact, "{text}");
    }
}

#[test]
fn where_nothing_is_hidden_nothing_is_found() {
    for (score, text) in scores(Choice::Nothing, XV, 0.1, 1..3) {
        assert_eq!(score, Score::Exact, "{text}");
    }
}

#[test]
fn positions_alone_suffice_for_the_set() {
    for (score, text) in scores(Choice::Any, X, 0.1, 3..4) {
        assert!([Score::Exact, Score::InSet].contains(&score), "{text}");
    }
}
