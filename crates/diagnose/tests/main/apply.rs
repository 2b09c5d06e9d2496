//! Effects change a model as they say, and leave it as it is while their amplitudes vanish.

use bracketry_diagnose::{Cause, Change, Coefficient, DiagnoseError, Effect, Role, TIME_INPUT};
use bracketry_system::System;
use bracketry_system::symbolic::Rational;

const PLATE: &str = r#"
states = ["y", "vy"]
inputs = ["theta"]
[parameters]
mu = 0.3
g = 9.81
[definitions]
N = "g*cos(theta)"
[dynamics]
y = "vy"
vy = "-g*sin(theta) - mu*N*sign(vy)"
[static]
vy = 1.2
"#;

fn coefficient(name: &str) -> Coefficient {
    Coefficient {
        name: name.to_owned(),
        role: Role::Amplitude,
        nominal: 0.0,
        scale: 1.0,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        trials: Vec::new(),
        physical_sign: 0,
        sign_flipped: None,
        period_of: None,
        unit: "1/m".to_owned(),
        about: String::new(),
    }
}

fn effect(change: Change) -> Effect {
    Effect {
        cause: Cause::UnknownTerm,
        equation: "vy".to_owned(),
        term: "".into(),
        coefficients: vec![coefficient("c")],
        change,
    }
}

fn term(text: &str) -> Effect {
    effect(Change::Terms(vec![("vy".to_owned(), text.to_owned())]))
}

/// Right-hand sides at named values; the rest is 0.
fn at(system: &System, values: &[(&str, f64)]) -> Vec<f64> {
    let arguments = system.arguments();
    let tape = system.compile(&arguments, &system.dynamics).unwrap();
    let x: Vec<f64> = arguments
        .iter()
        .map(|s| values.iter().find(|(n, _)| *n == system.symbol_name(*s)).map_or(0.0, |v| v.1))
        .collect();
    let mut out = vec![0.0; system.dynamics.len()];
    tape.eval(&x, &mut Vec::new(), &mut out);
    out
}

#[test]
fn a_term_is_added_and_its_coefficient_becomes_a_parameter() {
    let mut system = System::parse("plate", PLATE).unwrap();
    let before = at(&system, &[("y", 0.2), ("vy", 0.5), ("theta", 0.1)]);
    term("c*y*der(theta)^2 + c*N").apply(&mut system).unwrap();
    let point = [("y", 0.2), ("vy", 0.5), ("theta", 0.1), ("der(theta)", 3.0)];
    assert_eq!(at(&system, &point), before);
    assert!(system.set_parameter("c", Rational::from(2)));
    let expected = before[1] + 2.0 * (0.2 * 9.0 + 9.81 * 0.1f64.cos());
    assert!((at(&system, &point)[1] - expected).abs() < 1e-12);
    assert_eq!(system.parameters.last().unwrap().unit.as_deref(), Some("1/m"));
}

#[test]
fn derivatives_of_inputs_are_registered_behind_those_of_the_model() {
    let text = PLATE.replace("-g*sin(theta)", "-g*sin(theta) + y*der(theta, 2)");
    let mut system = System::parse("plate", &text).unwrap();
    term("c*y*der(theta)^2").apply(&mut system).unwrap();
    let orders: Vec<u32> = system.input_derivatives.iter().map(|d| d.order).collect();
    assert_eq!(orders, [2, 1]);
}

#[test]
fn time_comes_as_an_input() {
    let mut system = System::parse("plate", PLATE).unwrap();
    term("c*sin(3*time)").apply(&mut system).unwrap();
    assert_eq!(system.input_names(), ["theta", TIME_INPUT]);
    system.set_parameter("c", Rational::ONE);
    assert!((at(&system, &[("time", 0.4)])[1] - 1.2f64.sin()).abs() < 1e-12);
}

#[test]
fn an_expression_is_replaced_wherever_it_stands() {
    let mut system = System::parse("plate", PLATE).unwrap();
    let tilt = Change::Substitution { states: Vec::new(), pairs: vec![("theta".to_owned(), "theta + c".to_owned())] };
    effect(tilt).apply(&mut system).unwrap();
    system.set_parameter("c", Rational::ONE);
    let value = at(&system, &[("vy", 1.0), ("theta", 0.2)])[1];
    assert!((value + 9.81 * (1.2f64.sin() + 0.3 * 1.2f64.cos())).abs() < 1e-12);
    assert_eq!(system.static_levels.len(), 1);
}

#[test]
fn a_sign_that_is_replaced_loses_its_static_level() {
    let mut system = System::parse("plate", PLATE).unwrap();
    let pairs = vec![("sign(vy)".to_owned(), "sign(vy - c)".to_owned())];
    effect(Change::Substitution { states: vec!["vy".to_owned()], pairs }).apply(&mut system).unwrap();
    system.set_parameter("c", Rational::ONE);
    assert!(system.static_levels.is_empty());
    assert!(System::parse("again", &system.to_toml().unwrap()).is_ok());
}

#[test]
fn what_cannot_be_applied_leaves_the_model_as_it_was() {
    let original = System::parse("plate", PLATE).unwrap().to_toml().unwrap();
    let nothing = Change::Substitution { states: Vec::new(), pairs: vec![("tan(y)".to_owned(), "c".to_owned())] };
    let mut taken = term("mu*y");
    taken.coefficients = vec![coefficient("mu")];
    let elsewhere = effect(Change::Terms(vec![("z".to_owned(), "c".to_owned())]));
    for (effect, says) in [
        (term("c*speed"), "speed"),
        (term("c*der(y)"), "not an input"),
        (effect(nothing), "tan(y)"),
        (taken, "already has a `mu`"),
        (elsewhere, "no state `z`"),
    ] {
        let mut system = System::parse("plate", PLATE).unwrap();
        let error: DiagnoseError = effect.apply(&mut system).unwrap_err();
        assert!(error.to_string().contains(says), "{error}");
        assert_eq!(system.to_toml().unwrap(), original);
    }
}
