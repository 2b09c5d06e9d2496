//! The extended model as a file: read back, it has the right-hand sides of the fit.

use std::collections::BTreeMap;

use bracketry_diagnose::{
    Effect, ExtendedModel, LibrarySettings, Path, Record, RecordSettings, Study, StudySettings, candidates,
};
use bracketry_system::System;

const AXIS: &str = r#"
    name = "axis"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { m = { value = 1.5, unit = "kg", max = 1.6 }, Fc = 0.7 }
    dynamics = { x = "v", v = "(u - Fc*sign(v))/m" }
    point = { u = 0.3 }
"#;

/// A short run of anything: only the form of the model matters here.
fn record(system: &System) -> Record {
    let times: Vec<f64> = (0..400).map(|k| f64::from(k) * 5e-3).collect();
    let column = |f: fn(f64) -> f64| times.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    let columns = BTreeMap::from([
        ("u".to_owned(), column(|t| 4.0 * (5.0 * t).sin())),
        ("x".to_owned(), column(|t| -0.1 * (5.0 * t).sin())),
        ("v".to_owned(), column(|t| -0.5 * (5.0 * t).cos())),
    ]);
    Record::from_columns("run", times, columns, system, &RecordSettings::default()).unwrap()
}

fn right_hand_side(system: &System, at: &[f64]) -> Vec<f64> {
    let tape = system.compile(&system.arguments(), &system.dynamics).unwrap();
    let mut out = vec![0.0; system.dynamics.len()];
    tape.eval(at, &mut Vec::new(), &mut out);
    out
}

fn extended(system: &System, study: &Study, effect: &Effect) -> (ExtendedModel, Vec<(String, f64)>) {
    let mut fit = study.nominal();
    fit.effects = vec![effect.clone()];
    for (k, e) in fit.values.iter_mut().enumerate() {
        (e.value, e.std) = (e.nominal * (1.1 + 0.01 * k as f64), 1e-4);
    }
    for c in &effect.coefficients {
        let value =
            if c.nominal + 0.3 * c.scale <= c.max { c.nominal + 0.3 * c.scale } else { c.nominal - 0.3 * c.scale };
        fit.values.push(bracketry_diagnose::Estimate {
            name: c.name.clone(),
            nominal: c.nominal,
            value,
            std: 1e-6 * c.scale,
        });
    }
    let values = fit.values.iter().map(|e| (e.name.clone(), e.value)).collect();
    (ExtendedModel::new(system, &fit, 1.0).unwrap(), values)
}

#[test]
fn every_effect_of_the_library_reads_back_with_the_same_right_hand_sides() {
    let system = System::parse("axis", AXIS).unwrap();
    let record = record(&system);
    let study = Study::new(&system, std::slice::from_ref(&record), &StudySettings::default()).unwrap();
    let library = candidates(&system, &[record], &LibrarySettings::default()).unwrap();
    assert!(library.len() > 5);
    for effect in &library {
        let (model, values) = extended(&system, &study, effect);
        let text = model.to_toml().unwrap();
        let back = System::parse("extended", &text).unwrap_or_else(|e| panic!("{:?}: {e}\n{text}", effect.cause));
        // The effect applied by itself, at the same values.
        let mut direct = system.clone();
        effect.apply(&mut direct).unwrap();
        assert!(back.states.len() >= direct.states.len());
        for (name, value) in &values {
            let at = back.parameters.iter().find(|p| back.symbol_name(p.symbol) == name);
            if let Some(p) = at {
                let rounded = p.value.to_f64().value();
                assert!((rounded - value).abs() <= 1e-3 * value.abs().max(1e-9), "{name}: {rounded} {value}");
                direct.set_parameter(name, p.value.clone());
            }
        }
        if back.states.len() > direct.states.len() || back.input_names() != direct.input_names() {
            continue;
        }
        for point in [[0.02, 0.3, 1.0], [-0.1, -0.7, -2.0]] {
            let (a, b) = (right_hand_side(&back, &point), right_hand_side(&direct, &point));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}: {a:?} {b:?}", effect.cause);
        }
    }
}

#[test]
fn a_lag_becomes_a_state_that_the_equations_use() {
    let system = System::parse("axis", AXIS).unwrap();
    let record = record(&system);
    let study = Study::new(&system, std::slice::from_ref(&record), &StudySettings::default()).unwrap();
    let library = candidates(&system, &[record], &LibrarySettings::default()).unwrap();
    let is_lag = |e: &&Effect| matches!(e.change, bracketry_diagnose::Change::Path { path: Path::ActuatorLag, .. });
    let lag = library.iter().find(is_lag).unwrap();
    let (model, values) = extended(&system, &study, lag);
    let back = System::parse("extended", &model.to_toml().unwrap()).unwrap();
    assert_eq!(back.state_names(), ["x", "v", "u_lagged"]);
    let value = |name: &str| values.iter().find(|(n, _)| n == name).unwrap().1;
    let (m, fc, tau) = (value("m"), value("Fc"), value(&lag.coefficients[0].name));
    // States x, v, u_lagged, then the input.
    let rates = right_hand_side(&back, &[0.1, 0.4, 2.0, 5.0]);
    assert!((rates[1] - (2.0 - fc) / m).abs() < 1e-6);
    assert!((rates[2] - 3.0 / tau).abs() < 1e-3 * (3.0 / tau));
    // The point stays an equilibrium of the lag.
    let (states, inputs) = back.point_values().unwrap();
    assert_eq!((states[2], inputs[0]), (0.3, 0.3));
}

#[test]
fn a_fitted_value_beyond_its_limit_drops_the_limit_and_says_what_it_was() {
    let system = System::parse("axis", AXIS).unwrap();
    let record = record(&system);
    let study = Study::new(&system, &[record], &StudySettings::default()).unwrap();
    let mut fit = study.nominal();
    (fit.values[0].value, fit.values[0].std) = (1.72345678, 0.01);
    let text = ExtendedModel::new(&system, &fit, 3.0).unwrap().to_toml().unwrap();
    let back = System::parse("extended", &text).unwrap();
    let mass = &back.parameters[0];
    assert_eq!((mass.max.clone(), mass.unit.as_deref()), (None, Some("kg")));
    assert!((mass.value.to_f64().value() - 1.72345678).abs() < 1e-7);
    assert_eq!(mass.about.as_deref(), Some("fitted, std 0.030, previously 1.5"));
    assert_eq!(back.name, "axis");
}
