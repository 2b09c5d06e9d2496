//! Effects of the library leave the dynamics as they are while their amplitudes vanish, and change them as they say.
#![allow(clippy::format_push_string)]

use bracketry_diagnose::{
    Cause, Change, Effect, Fit, LibrarySettings, Record, RecordSettings, Role, Study, StudySettings, candidates,
    dictionary,
};
use bracketry_system::System;
use bracketry_system::symbolic::{Bindings, Expr, Rational};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

fn model(name: &str) -> System {
    System::read(format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// A chain of masses or of rotors with springs, dampers and dry friction drawn at random.
fn random_model(seed: u64) -> System {
    let mut random = SmallRng::seed_from_u64(seed);
    let n = random.random_range(1..=3);
    let angles = random.random_bool(0.5);
    let mut text = String::new();
    let list = |name: &str| (0..n).map(|i| format!("\"{name}{i}\"")).collect::<Vec<_>>().join(", ");
    let (q, v) = if angles { ("th", "w") } else { ("x", "v") };
    text += &format!("states = [{}, {}]\ninputs = [{}]\n", list(q), list(v), list("u"));
    text += "parameters = { m = 0.7, c = 0.2, k = 3, F = 0.4, g = 9.81 }\n[dynamics]\n";
    for i in 0..n {
        text += &format!("{q}{i} = \"{v}{i}\"\n");
        let mut force = format!("u{i}");
        for (part, often) in [
            (format!(" - c*{v}{i}"), 0.5),
            (format!(" - F*sign({v}{i})"), 0.5),
            (format!(" - k*{q}{i}"), 0.5),
            (format!(" - k*({q}{i} - {q}{})", (i + 1) % n), if n > 1 { 0.5 } else { 0.0 }),
            (format!(" - m*g*sin({q}{i})"), if angles { 0.5 } else { 0.0 }),
        ] {
            if random.random_bool(often) {
                force += &part;
            }
        }
        text += &format!("{v}{i} = \"({force})/m\"\n");
    }
    System::parse("random", &text).unwrap()
}

fn models() -> Vec<System> {
    let names = [
        "plate_published",
        "plate_reduced",
        "plate_disk",
        "plate_point_anisotropic",
        "cart_pole_friction",
        "spring_mass_friction",
    ];
    names.into_iter().map(model).chain((0..6).map(random_model)).collect()
}

fn library(system: &System) -> Vec<Effect> {
    let mut effects = candidates(system, &[], &LibrarySettings::default()).unwrap();
    effects.extend(dictionary(system, &[], &LibrarySettings::default()).unwrap());
    effects
}

/// The dynamics with some coefficients at other values than the nominal ones, at a point drawn from a seed.
fn values(system: &System, coefficients: &[(&str, f64)], seed: u64) -> Vec<f64> {
    let mut system = system.clone();
    for (name, value) in coefficients {
        assert!(system.set_parameter(name, Rational::try_from(*value).unwrap()));
    }
    let (arguments, dynamics) = (system.arguments(), system.dynamics.clone());
    let tape = system.compile(&arguments, &dynamics).unwrap();
    // By name, so that an extended model is asked at the same point.
    let x: Vec<f64> = arguments
        .iter()
        .map(|s| {
            let bytes = system.symbol_name(*s).bytes().fold(seed, |h, b| h.wrapping_mul(31).wrapping_add(u64::from(b)));
            SmallRng::seed_from_u64(bytes).random_range(-2.0..2.0)
        })
        .collect();
    let mut out = vec![0.0; dynamics.len()];
    tape.eval(&x, &mut Vec::new(), &mut out);
    out
}

#[test]
fn effects_vanish_with_their_amplitudes() {
    for system in models() {
        for effect in library(&system) {
            let mut extended = system.clone();
            effect.apply(&mut extended).unwrap();
            let zero = extended.pool.int(0);
            let map = effect
                .coefficients
                .iter()
                .filter(|c| c.role == Role::Amplitude)
                .map(|c| {
                    assert_eq!(c.nominal, 0.0);
                    (extended.pool.var(&c.name), zero)
                })
                .collect();
            let rows = extended.dynamics.clone();
            let at_zero = extended.pool.substitute_all(&rows, &map);
            for (new, old) in at_zero.into_iter().zip(&system.dynamics) {
                let difference = extended.pool.sub(new, *old);
                let difference = extended.pool.simplify(difference);
                let exactly = extended.pool.is_zero(difference)
                    || extended.pool.zero_test(difference, &Bindings::new()).is_zero();
                assert!(exactly, "{:?} {}: {}", effect.cause, effect.term, extended.pool.text(difference));
            }
        }
    }
}

#[test]
fn the_term_is_what_the_equation_gains() {
    for system in models() {
        for effect in library(&system) {
            let Change::Terms(terms) = &effect.change else { continue };
            // The reader's term is that of the equation which the effect names, if it is written in full.
            let mut extended = system.clone();
            effect.apply(&mut extended).unwrap();
            let Some(row) = extended.state_index(&effect.equation) else { continue };
            assert!(terms.iter().any(|t| t.0 == effect.equation), "{}", effect.term);
            let mut alone = extended.clone();
            let zero = alone.pool.int(0);
            for d in &mut alone.dynamics {
                *d = zero;
            }
            let written = Effect {
                coefficients: Vec::new(),
                change: Change::Terms(vec![(effect.equation.clone(), effect.term.text().to_owned())]),
                ..effect.clone()
            };
            if effect.cause == Cause::JointCoupling && effect.coefficients.len() > 1 {
                continue;
            }
            written.apply(&mut alone).unwrap();
            let at: Vec<(&str, f64)> =
                effect.coefficients.iter().map(|c| (c.name.as_str(), c.nominal + 0.25 * c.scale.min(1.0))).collect();
            for seed in 0..3 {
                let gain = values(&extended, &at, seed)[row] - values(&system, &[], seed)[row];
                let term = values(&alone, &at, seed)[row];
                assert!((gain - term).abs() <= 1e-9 * (1.0 + term.abs()), "{}: {gain} {term}", effect.term);
            }
        }
    }
}

#[test]
fn replaced_friction_stays_set_valued() {
    let unit_vectors = |system: &System, effect: &Effect, value: f64| {
        let mut extended = system.clone();
        effect.apply(&mut extended).unwrap();
        let k = extended.pool.var(&effect.coefficients[0].name);
        let value = extended.pool.rational(Rational::try_from(value).unwrap());
        let rows: Vec<Expr> = extended.dynamics.clone();
        extended.dynamics = extended.pool.substitute_all(&rows, &std::iter::once((k, value)).collect());
        let form = extended.set_valued_form();
        let mut sizes: Vec<usize> = form.unit_vectors.iter().map(|u| u.switches.len()).collect();
        sizes.sort_unstable();
        sizes
    };
    let published = model("plate_published");
    let effects = candidates(&published, &[], &LibrarySettings::default()).unwrap();
    let coupling = effects.iter().find(|e| e.cause == Cause::FrictionCoupling).unwrap();
    assert_eq!(unit_vectors(&published, coupling, 1.0), [2]);
    for name in ["plate_reduced", "plate_point_stribeck", "plate_disk"] {
        let system = model(name);
        let before: Vec<usize> =
            system.clone().set_valued_form().unit_vectors.iter().map(|u| u.switches.len()).collect();
        let effects = candidates(&system, &[], &LibrarySettings::default()).unwrap();
        let ellipse = effects.iter().find(|e| e.cause == Cause::AnisotropicFriction).unwrap();
        assert_eq!(unit_vectors(&system, ellipse, 0.25), before, "{name}");
    }
}

#[test]
fn a_tracked_point_off_the_center_of_mass_is_found_where_the_body_turns() {
    // The center of mass of a free body moves straight on; a point at d on the body circles about it.
    let text = r#"
states = ["x", "y", "phi", "vx", "vy", "w"]
dynamics = { x = "vx", y = "vy", phi = "w", vx = "0", vy = "0", w = "0" }
"#;
    let system = System::parse("free", text).unwrap();
    let d = [0.03, -0.02];
    let times: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
    // Rounded as a sensor would, a tenth of a millimeter.
    let column = |f: &dyn Fn(f64) -> f64| times.iter().map(|t| (f(*t) * 1e4).round() * 1e-4).collect::<Vec<f64>>();
    let phi = |t: f64| 0.3 + 2.0 * t;
    let columns = [
        ("x".to_owned(), column(&|t| 0.1 * t + d[0] * phi(t).cos() - d[1] * phi(t).sin())),
        ("y".to_owned(), column(&|t| 0.2 * t + d[0] * phi(t).sin() + d[1] * phi(t).cos())),
        ("phi".to_owned(), column(&phi)),
    ];
    let record =
        Record::from_columns("free", times.clone(), columns.into(), &system, &RecordSettings::default()).unwrap();
    let effects = candidates(&system, std::slice::from_ref(&record), &LibrarySettings::default()).unwrap();
    let com = effects.into_iter().find(|e| e.cause == Cause::ComOffset).unwrap();
    let study = Study::new(&system, &[record], &StudySettings::default()).unwrap();
    let every: Vec<usize> = (0..study.windows().len()).collect();
    let square = |effects: &[Effect]| study.fit(effects, &every, None).unwrap();
    let (without, with) = (square(&[]), square(&[com]));
    let over_noise = |fit: &Fit| {
        let count: usize = fit.windows.iter().map(|w| w.count).sum();
        fit.windows.iter().map(|w| w.square).sum::<f64>() / count as f64
    };
    assert!(over_noise(&with) < 1.2 && over_noise(&without) > 10.0, "{} {}", over_noise(&with), over_noise(&without));
    for (estimate, d) in with.values.iter().zip(d) {
        assert!((estimate.value - d).abs() < 5.0 * estimate.std && estimate.std < 1e-3, "{estimate:?}");
    }
}

/// The disk with friction `(1 + k)^2` times as great along y at the same speed of slip, and `(1 + q)^2` times against the spin, written by
/// hand; `factor` stands, as a parameter of value 1, in the sum under the root.
fn disk_by_hand(k: &str, q: &str, factor: &str) -> System {
    let path = format!("{}/../../models/plate_disk.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let changed = text
        .replace("[definitions]", "one = 1\n[definitions]")
        .replace("sqrt(vx^2 + vy^2 + S*w^2)", &format!("sqrt(vx^2 + ({k}*vy)^2 + ({q})^2*S{factor}*w^2)"))
        .replace("\"vy/s\"", &format!("\"({k})^2*vy/s\""))
        .replace("\"w/s\"", &format!("\"({q})^2*w/s\""));
    assert_eq!(changed.matches("vy/s").count() + changed.matches("w/s").count(), 2);
    System::parse("by hand", &changed).unwrap()
}

#[test]
fn pressure_at_another_radius_is_the_limit_surface_written_by_hand() {
    for factor in ["", "*one"] {
        let given = disk_by_hand("1", "1", factor);
        let effects = candidates(&given, &[], &LibrarySettings::default()).unwrap();
        let effect = effects.iter().find(|c| c.cause == Cause::PressureRadius).unwrap();
        let [q] = effect.coefficients.as_slice() else { panic!("{effect:?}") };
        assert_eq!((q.name.as_str(), effect.equation.as_str()), ("pressure_radius_w", "w"));
        let mut extended = given.clone();
        effect.apply(&mut extended).unwrap();
        for radius in ["1.4", "0.5"] {
            let by_hand = disk_by_hand("1", radius, factor);
            let relative = radius.parse::<f64>().unwrap() - 1.0;
            for seed in 0..20 {
                let new = values(&extended, &[(&q.name, relative)], seed);
                for (new, expected) in new.iter().zip(values(&by_hand, &[], seed)) {
                    assert!((new - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{factor}: {new} {expected}");
                }
            }
        }
    }
    // A model without friction against the spin has no pressure at a radius.
    let published = candidates(&model("plate_published"), &[], &LibrarySettings::default()).unwrap();
    assert!(published.iter().all(|c| c.cause != Cause::PressureRadius));
}

#[test]
fn anisotropic_friction_of_a_footprint_is_the_limit_surface_written_by_hand() {
    for factor in ["", "*one"] {
        let given = disk_by_hand("1", "1", factor);
        let effect = candidates(&given, &[], &LibrarySettings::default())
            .unwrap()
            .into_iter()
            .find(|c| c.cause == Cause::AnisotropicFriction)
            .unwrap();
        let names: Vec<&str> = effect.coefficients.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["anisotropy_vy", "anisotropy_spin_w"]);
        let mut extended = given.clone();
        effect.apply(&mut extended).unwrap();
        let by_hand = disk_by_hand("1.2", "0.75", factor);
        for seed in 0..20 {
            let new = values(&extended, &[(names[0], 0.2), (names[1], -0.25)], seed);
            for (new, expected) in new.iter().zip(values(&by_hand, &[], seed)) {
                assert!((new - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{factor}: {new} {expected}");
            }
        }
    }
}

#[test]
fn a_change_of_the_load_changes_the_friction_along_every_axis() {
    let system = model("plate_published_disk");
    let effects = candidates(&system, &[], &LibrarySettings::default()).unwrap();
    let on_load = |e: &&Effect| e.coefficients[0].name.starts_with("inertia_load_");
    let found: Vec<&Effect> = effects.iter().filter(on_load).collect();
    assert!(!found.is_empty());
    for effect in found {
        let mut extended = system.clone();
        effect.apply(&mut extended).unwrap();
        for seed in 0..20 {
            let k = (effect.coefficients[0].name.as_str(), 0.25);
            let [new, old] = [values(&extended, &[k], seed), values(&system, &[], seed)];
            // Friction against x and y has the same size per load: its directions are signs.
            let gained = |row: usize| (new[row] - old[row]).abs();
            assert!(gained(3) > 1e-6 && (gained(3) - gained(4)).abs() < 1e-12, "{}", effect.term);
        }
    }
}
