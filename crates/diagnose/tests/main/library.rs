//! The library finds places for its causes in the structure of models.

use std::collections::HashSet;

use bracketry_diagnose::{
    Cause, Effect, LibrarySettings, candidates, dictionary, reference_candidates, separating_experiment,
};
use bracketry_system::System;

fn model(name: &str) -> System {
    System::read(format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn of(effects: &[Effect], cause: Cause) -> Vec<&Effect> {
    effects.iter().filter(|e| e.cause == cause).collect()
}

fn has(effects: &[Effect], cause: Cause) -> bool {
    effects.iter().any(|e| e.cause == cause)
}

const PENDULUM: &str = r#"
states = ["th", "w"]
parameters = { g = 9.81, l = 0.5 }
dynamics = { th = "w", w = "-g/l*sin(th)" }
"#;

const WRIST: &str = r#"
states = ["q1", "q2", "v1", "v2"]
inputs = ["tau1", "tau2"]
[parameters]
J1 = { value = 0.02, unit = "kg m^2" }
J2 = { value = 0.03, unit = "kg m^2" }
F1 = { value = 0.1, unit = "N m" }
[dynamics]
q1 = "v1"
q2 = "v2"
v1 = "(tau1 - F1*sign(v1))/J1"
v2 = "tau2/J2"
"#;

#[test]
fn the_published_plate_lacks_friction_of_the_spin_coupling_and_inertial_forces() {
    let effects = candidates(&model("plate_published"), &[], &LibrarySettings::default()).unwrap();
    let against_spin = of(&effects, Cause::YawFriction);
    assert_eq!(against_spin.len(), 3);
    // A body has one load: friction of the footprint against the spin follows it where the model says how it changes.
    let footprint = against_spin.iter().find(|e| e.coefficients.len() == 2).unwrap();
    assert!(footprint.term.text().ends_with("*mu*(der(theta, 2)*y + g*cos(theta))"), "{}", footprint.term);
    assert_eq!(of(&effects, Cause::FrictionCoupling).len(), 1);
    let centrifugal =
        of(&effects, Cause::InertialCoupling).into_iter().find(|e| e.term.text().ends_with("*y*der(theta)^2"));
    assert_eq!(centrifugal.unwrap().equation, "vy");
    let tilts: Vec<&str> = of(&effects, Cause::Tilt).iter().map(|e| e.equation.as_str()).collect();
    assert_eq!(tilts, ["vy", "vx"]);
    // The model has dry friction along both axes, and a rotation that slides has friction of the spin instead.
    assert!(!has(&effects, Cause::CoulombFriction));
    assert!(of(&effects, Cause::ViscousFriction).iter().all(|e| e.equation != "w"));
}

#[test]
fn a_pendulum_gets_friction_and_a_torque_but_no_tilt() {
    let effects = candidates(&System::parse("pendulum", PENDULUM).unwrap(), &[], &LibrarySettings::default()).unwrap();
    for cause in [Cause::ViscousFriction, Cause::CoulombFriction, Cause::ConstantBias, Cause::QuadraticDrag] {
        assert_eq!(of(&effects, cause).len(), 1, "{cause:?}");
    }
    assert!(!has(&effects, Cause::Tilt));
    assert!(!has(&effects, Cause::JointCoupling));
}

#[test]
fn joints_of_a_wrist_are_coupled_in_both_directions() {
    let effects = candidates(&System::parse("wrist", WRIST).unwrap(), &[], &LibrarySettings::default()).unwrap();
    let couplings = of(&effects, Cause::JointCoupling);
    for on in ["v1", "v2"] {
        assert!(couplings.iter().any(|e| e.equation == on && e.term.text().contains("sign(")));
    }
    let shared = couplings[0];
    assert!(shared.term.text().ends_with("s = v1 + joint_ratio_v1_v2*v2"));
    assert_eq!(shared.coefficients[2].unit, "kg m^2");
    let coulomb: Vec<&str> = of(&effects, Cause::CoulombFriction).iter().map(|e| e.equation.as_str()).collect();
    assert_eq!(coulomb, ["v2"]);
    assert!(!has(&effects, Cause::Tilt));
}

#[test]
fn what_the_model_has_is_not_proposed() {
    let effects = candidates(&model("spring_mass_friction"), &[], &LibrarySettings::default()).unwrap();
    for cause in [Cause::ViscousFriction, Cause::CoulombFriction, Cause::LinearStiffness] {
        assert!(!has(&effects, cause), "{cause:?}");
    }
    let drag = of(&effects, Cause::QuadraticDrag)[0];
    assert_eq!((drag.term.text(), drag.coefficients[0].unit.as_str()), ("-drag_v*abs(v)*v/m", "N s^2/m^2"));
}

#[test]
fn coefficients_have_names_of_their_own() {
    for name in ["plate_published", "cart_pole_friction", "spring_mass_friction", "quadrotor", "cstr"] {
        let system = model(name);
        let mut names: HashSet<String> = system.state_names().into_iter().chain(system.input_names()).collect();
        names.extend(system.parameters.iter().map(|p| system.symbol_name(p.symbol).to_owned()));
        let mut all = candidates(&system, &[], &LibrarySettings::default()).unwrap();
        all.extend(dictionary(&system, &[], &LibrarySettings::default()).unwrap());
        for c in all.iter().flat_map(|e| &e.coefficients) {
            assert!(names.insert(c.name.clone()), "{} twice in {name}", c.name);
            // What is there altogether or not at all has one value, which is not that of the model without it.
            let all_or_nothing = c.min == c.max && c.min != c.nominal && c.trials == [c.min];
            assert!(c.scale > 0.0 && c.scale.is_finite(), "{c:?}");
            assert!(all_or_nothing || c.min <= c.nominal && c.nominal <= c.max, "{c:?}");
        }
    }
}

#[test]
fn the_dictionary_has_terms_for_each_equation() {
    let system = System::parse("wrist", WRIST).unwrap();
    let terms = dictionary(&system, &[], &LibrarySettings::default()).unwrap();
    for wanted in ["q1*v1/J1", "v2^2/J1", "tau1*q1/J1", "sin(", "tanh("] {
        assert!(terms.iter().any(|e| e.equation == "v1" && e.term.text().contains(wanted)), "{wanted}");
    }
    assert!(terms.iter().all(|e| e.cause == Cause::UnknownTerm));
}

#[test]
fn each_pair_of_causes_has_an_experiment_that_separates_it() {
    for name in ["plate_published", "cart_pole_friction"] {
        let system = model(name);
        let effects = candidates(&system, &[], &LibrarySettings::default()).unwrap();
        for a in &effects {
            for b in &effects {
                let sentence = separating_experiment(a, b, &system);
                assert!(sentence.len() > 40, "{:?} {:?}: {sentence}", a.cause, b.cause);
                assert_eq!(sentence.contains("180 degrees about the vertical"), {
                    let pair = [a.cause, b.cause];
                    pair.contains(&Cause::Tilt) && pair.contains(&Cause::ConstantBias)
                });
            }
        }
    }
}

#[test]
fn the_experiment_for_delays_and_lags_names_the_frequency() {
    let system = model("spring_mass_friction");
    let effects = candidates(&system, &[], &LibrarySettings::default()).unwrap();
    let mut delay = of(&effects, Cause::InputDelay)[0].clone();
    delay.coefficients[0].nominal = 0.008;
    let sentence = separating_experiment(of(&effects, Cause::ActuatorLag)[0], &delay, &system);
    // 1/(2π · 8 ms) = 19.9 Hz
    assert!(sentence.contains("= 19.9 Hz"), "{sentence}");
}

#[test]
fn a_more_complete_model_names_what_the_published_one_lacks() {
    let (published, reduced) = (model("plate_published"), model("plate_reduced"));
    let effects = reference_candidates(&published, &reduced).unwrap();
    assert_eq!(of(&effects, Cause::FrictionCoupling).len(), 1);
    assert_eq!(of(&effects, Cause::YawFriction).len(), 1);
    assert_eq!(of(&effects, Cause::YawFriction)[0].equation, "w");
    let inertial = of(&effects, Cause::InertialCoupling);
    let in_vy: Vec<&str> = inertial.iter().filter(|e| e.equation == "vy").map(|e| e.term.text()).collect();
    let centrifugal = |t: &&str| t.contains("y*der(theta)^2") || t.contains("der(theta)^2*y");
    assert_eq!(in_vy.iter().copied().filter(|t| centrifugal(t) && !t.contains("sqrt")).count(), 1, "{in_vy:?}");
    assert!(!has(&effects, Cause::UnknownTerm));
    // The moment of inertia of an ellipse depends on its yaw; the torque of tilting is one term all the same.
    let torques = inertial
        .iter()
        .filter(|e| e.equation == "w" && e.term.text().contains("der(theta, 2)") && e.term.text().contains("vx"));
    assert!(torques.count() <= 2, "{:?}", inertial.iter().map(|e| &e.term).collect::<Vec<_>>());
    assert!(reference_candidates(&published, &published).unwrap().is_empty());
    assert!(reference_candidates(&published, &model("cstr")).is_err());
}

#[test]
fn laws_of_a_reference_have_their_names() {
    let text = |law: &str| format!("states = [\"x\", \"v\"]\ninputs = [\"u\"]\n[dynamics]\nx = \"v\"\nv = \"{law}\"\n");
    let system = System::parse("simple", &text("u")).unwrap();
    for (law, cause) in [
        ("u - 0.3*v", Cause::ViscousFriction),
        ("u - 0.3*sign(v)", Cause::CoulombFriction),
        ("u - 0.3*exp(-(v/0.1)^2)*sign(v)", Cause::StribeckFriction),
        ("u - 0.3*abs(v)*v", Cause::QuadraticDrag),
        ("u - 0.3*x", Cause::LinearStiffness),
        ("u + 0.3", Cause::ConstantBias),
        ("u + 0.3*sin(x)*cosh(u)", Cause::UnknownTerm),
    ] {
        let reference = System::parse("reference", &text(law)).unwrap();
        let causes: Vec<Cause> = reference_candidates(&system, &reference).unwrap().iter().map(|e| e.cause).collect();
        assert_eq!(causes, [cause], "{law}");
    }
}

#[test]
fn a_term_of_the_reference_in_place_of_one_with_its_parameter_comes_as_one_effect_too() {
    let tank = |outflow: &str| {
        let text = format!(
            "states = ['h']\ninputs = ['q']\nparameters = {{ A = 0.5, k = 0.4 }}\ndynamics = {{ h = '(q - {outflow})/A' }}\n"
        );
        System::parse("tank", &text).unwrap()
    };
    let effects = reference_candidates(&tank("k*h"), &tank("k*sqrt(h)")).unwrap();
    let whole = effects.iter().filter(|e| e.term.text().contains("sqrt") && e.term.text().contains("h*k"));
    assert_eq!((whole.count(), effects.len()), (1, 2), "{effects:?}");
    // What comes on top of a term takes the place of none.
    assert_eq!(reference_candidates(&tank("k*h"), &tank("(k*h + k*sqrt(h))")).unwrap().len(), 1);
}

#[test]
fn friction_that_fades_with_speed_brings_that_of_sliding_where_the_model_has_none() {
    for (system, coefficients) in [(System::parse("pendulum", PENDULUM).unwrap(), 3), (model("emps"), 2)] {
        let effects = candidates(&system, &[], &LibrarySettings::default()).unwrap();
        let laws = of(&effects, Cause::StribeckFriction);
        assert!(!laws.is_empty() && laws.iter().all(|e| e.coefficients.len() == coefficients), "{laws:?}");
    }
}

#[test]
fn the_settings_say_which_values_are_tried() {
    let system = model("spring_mass_friction");
    let settings = LibrarySettings { stribeck_trials: 3, ..LibrarySettings::default() };
    let effects = candidates(&system, &[], &settings).unwrap();
    let stribeck = effects.iter().filter(|e| e.cause == Cause::StribeckFriction);
    let trials: Vec<usize> =
        stribeck.flat_map(|e| &e.coefficients).map(|c| c.trials.len()).filter(|n| *n > 0).collect();
    assert!(!trials.is_empty() && trials.iter().all(|n| *n == 3), "{trials:?}");
}
