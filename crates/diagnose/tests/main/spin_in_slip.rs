//! Friction against the spin of a contact that slides: what spins takes part in the slip, on one limit surface.

use bracketry_diagnose::{
    Cause, Effect, Estimate, ExtendedModel, LibrarySettings, Record, RecordSettings, Study, StudySettings, candidates,
};
use bracketry_system::System;
use bracketry_system::symbolic::Rational;
use proptest::prelude::*;

/// A body on a plate whose contact has no spin in its friction; `ex`, `ey` are the directions, `spin` is added to the equation of w.
fn body(ex: &str, ey: &str, spin: &str) -> System {
    let text = format!(
        r#"
        states = ["x", "y", "phi", "vx", "vy", "w"]
        inputs = ["X", "theta"]
        [parameters]
        mu = {{ value = 0.3, min = 0 }}
        g = 9.81
        l = {{ value = 0.1, min = 0 }}
        rho = {{ value = 0.1, min = 0 }}
        k = {{ value = 0, min = -0.9 }}
        [definitions]
        N = "g*cos(theta) + y*der(theta, 2)"
        [dynamics]
        x = "vx"
        y = "vy"
        phi = "w"
        vx = "-der(X, 2) - mu*N*({ex})"
        vy = "-g*sin(theta) - mu*N*({ey})"
        w = "-0.5*mu*({ex})*der(theta, 2){spin}"
        "#
    );
    System::parse("body", &text).unwrap()
}

/// The ways in which a model may write friction against the direction of the slip.
fn without_spin() -> [System; 3] {
    let root = "sqrt(vx^2 + vy^2)";
    [
        body("unit(vx, vy)", "unit(vy, vx)", ""),
        body(&format!("vx/{root}"), &format!("vy/{root}"), ""),
        body("sign(vx)", "sign(vy)", ""),
    ]
}

/// What [`without_spin`] is with the spin on the limit surface, friction `1 + k` times as far along y.
fn by_hand() -> System {
    let root = "sqrt(vx^2 + ((1 + k)*vy)^2 + (l*w)^2)";
    body(&format!("vx/{root}"), &format!("(1 + k)^2*vy/{root}"), &format!(" - mu*N*l^2*w/(rho^2*{root})"))
}

fn effects(system: &System) -> Vec<Effect> {
    candidates(system, &[], &LibrarySettings::default()).unwrap()
}

fn spin_in_slip(system: &System) -> Effect {
    let wanted = |e: &Effect| e.cause == Cause::YawFriction && e.coefficients[0].name == "spin_ratio_w";
    effects(system).into_iter().find(wanted).unwrap()
}

fn of(system: &System, cause: Cause) -> Option<Effect> {
    effects(system).into_iter().find(|e| e.cause == cause)
}

/// The equations with effects of given values, as a file that is read back.
fn extended(system: &System, effects: &[Effect], value: impl Fn(&str) -> f64) -> System {
    let times: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
    let columns = system
        .states
        .iter()
        .chain(&system.inputs)
        .map(|&s| (system.symbol_name(s).to_owned(), times.iter().map(|t| 0.1 * (7.0 * t).sin()).collect()))
        .collect();
    let record = Record::from_columns("run", times, columns, system, &RecordSettings::default()).unwrap();
    let mut fit = Study::new(system, &[record], &StudySettings::default()).unwrap().nominal();
    fit.effects = effects.to_vec();
    for c in effects.iter().flat_map(|e| &e.coefficients) {
        let (name, value) = (c.name.clone(), value(&c.name));
        fit.values.push(Estimate { name, nominal: c.nominal, value, std: 1e-9 });
    }
    let text = ExtendedModel::new(system, &fit, 1.0).unwrap().to_toml().unwrap();
    System::parse("extended", &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The rates where states, inputs, and their derivatives have these values by name, the others 0.
fn rates(system: &System, at: &[(&str, f64)]) -> Vec<f64> {
    let arguments = system.arguments();
    assert!(at.iter().all(|(n, _)| arguments.iter().any(|s| system.symbol_name(*s) == *n)));
    let value = |name: &str| at.iter().find(|(n, _)| *n == name).map_or(0.0, |a| a.1);
    let x: Vec<f64> = arguments.iter().map(|s| value(system.symbol_name(*s))).collect();
    let mut out = vec![0.0; system.dynamics.len()];
    system.compile(&arguments, &system.dynamics).unwrap().eval(&x, &mut Vec::new(), &mut out);
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn the_extended_equations_are_those_written_by_hand(
        l in 0.01..0.2f64,
        rho in 0.02..0.2f64,
        k in -0.4..0.4f64,
        at in proptest::collection::vec(-1.0..1.0f64, 7),
    ) {
        let names = ["y", "vx", "vy", "w", "theta", "der(X, 2)", "der(theta, 2)"];
        let at: Vec<(&str, f64)> = names.into_iter().zip(at).collect();
        for system in without_spin() {
            let mut changes = vec![spin_in_slip(&system)];
            changes.extend(of(&system, Cause::FrictionCoupling));
            let anisotropy = of(&system, Cause::AnisotropicFriction).filter(|_| changes.len() == 1);
            let k = if anisotropy.is_some() { k } else { 0.0 };
            changes.extend(anisotropy);
            let extended = extended(&system, &changes, |name| match name {
                "spin_ratio_w" => l / rho,
                "spin_gyration_w" => rho,
                "anisotropy_vy" => k,
                _ => 1.0,
            });
            let mut expected = by_hand();
            for (name, value) in [("l", l), ("rho", rho), ("k", k)] {
                prop_assert!(expected.set_parameter(name, Rational::try_from(value).unwrap()));
            }
            for (new, old) in rates(&extended, &at).into_iter().zip(rates(&expected, &at)) {
                prop_assert!((new - old).abs() < 1e-6 * (1.0 + old.abs()), "{new} {old}");
            }
        }
    }
}

#[test]
fn slip_and_spin_are_one_direction_of_friction_wherever_a_fit_begins() {
    for system in &without_spin()[..2] {
        let mut changed = system.clone();
        let effect = spin_in_slip(system);
        effect.apply(&mut changed).unwrap();
        let length = &effect.coefficients[0];
        for value in [length.nominal, length.trials[0], 0.3] {
            assert!(changed.set_parameter(&length.name, Rational::try_from(value).unwrap()));
            let form = changed.clone().set_valued_form();
            let components: Vec<usize> = form.unit_vectors.iter().map(|u| u.components.len()).collect();
            assert_eq!((form.signs().len(), components), (0, vec![3]), "{value}");
        }
    }
}

#[test]
fn a_body_that_spins_slides_more_easily() {
    let system = &without_spin()[0];
    let extended =
        extended(system, &[spin_in_slip(system)], |name| if name == "spin_ratio_w" { 0.06 / 0.085 } else { 0.085 });
    let rate_of_vx = |w: f64| rates(&extended, &[("vx", 0.1), ("w", w)])[3];
    assert!((rate_of_vx(0.0) + 0.3 * 9.81).abs() < 1e-6);
    // (0.1, 0.06 · 10): the slip's share of the friction is 0.1/√(0.01 + 0.36).
    assert!((rate_of_vx(10.0) + 0.3 * 9.81 * 0.1 / 0.37f64.sqrt()).abs() < 1e-6);
}
