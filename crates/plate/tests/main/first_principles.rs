//! Models from first principles: against the derivation, against each other, and against the reference results.

use bracketry_plate::model::{FlatContact, Terms, flat_contact};
use bracketry_plate::{Friction, Object, Shape, first_principles, published, reduced};
use bracketry_system::System;
use bracketry_system::symbolic::{Bindings, Expr};

const COULOMB: Friction = Friction::Coulomb { mu: 0.3 };

fn ellipse() -> Object {
    Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE }
}

/// An expression of a model in the symbols of the derivation.
fn in_symbols_of(flat: &mut FlatContact, system: &System, e: Expr) -> Expr {
    let names = [("der(X, 2)", "Xdd"), ("der(X)", "Xd"), ("der(theta, 2)", "thetadd"), ("der(theta)", "thetad")];
    let mut text = system.pool.text(e);
    for (name, symbol) in names {
        text = text.replace(name, symbol);
    }
    flat.pool.parse(&text).unwrap()
}

fn zero(flat: &mut FlatContact, e: Expr) -> bool {
    flat.pool.zero_test(e, &Bindings::new()).is_zero()
}

/// The accelerations of the derivation under friction `fx, fy, n` given as texts in the names of the model's definitions.
fn derived(flat: &mut FlatContact, system: &System, friction: [&str; 3]) -> [Expr; 3] {
    let defined: Vec<(Expr, Expr)> = system
        .definitions
        .iter()
        .map(|(name, e)| (name.clone(), *e))
        .map(|(name, e)| (flat.pool.var(&name), in_symbols_of(flat, system, e)))
        .collect();
    let defined = defined.into_iter().collect();
    let mut forces = Vec::new();
    for (name, text) in ["fx", "fy", "n"].iter().zip(friction) {
        let force = flat.pool.parse(text).unwrap();
        let force = flat.pool.substitute(force, &defined);
        forces.push((flat.pool.var(name), force));
    }
    let forces = forces.into_iter().collect();
    flat.accelerations.map(|e| flat.pool.substitute(e, &forces))
}

/// Puts the factors of the terms at their values; everything else stays a symbol.
fn with_factors(mut system: System) -> System {
    system.parameters.retain(|p| !["mu", "g", "h", "Sa", "Sb"].contains(&system.pool.name(p.symbol)));
    let mut all = system.dynamics.clone();
    all.extend(system.definitions.iter().map(|(_, e)| *e));
    let all = system.with_values(&all);
    let (dynamics, definitions) = all.split_at(system.dynamics.len());
    system.dynamics = dynamics.to_vec();
    for ((_, e), new) in system.definitions.iter_mut().zip(definitions) {
        *e = *new;
    }
    system
}

/// Whether the coded accelerations are the derived ones.
fn agrees(system: System, friction: [&str; 3]) -> bool {
    let mut flat = flat_contact();
    let system = with_factors(system);
    let derived = derived(&mut flat, &system, friction);
    system.dynamics[3..].iter().zip(derived).all(|(&coded, derived)| {
        let coded = in_symbols_of(&mut flat, &system, coded);
        let difference = flat.pool.sub(coded, derived);
        zero(&mut flat, difference)
    })
}

#[test]
fn point_contact_is_what_lagrange_gives_under_coulomb_friction() {
    let system = first_principles(&ellipse(), &COULOMB, Terms::default()).unwrap();
    assert!(agrees(system, ["-mu*load*ex", "-mu*load*ey", "0"]));
    let system = first_principles(&ellipse(), &COULOMB, Terms { centrifugal: false, ..Terms::default() }).unwrap();
    assert!(!agrees(system, ["-mu*load*ex", "-mu*load*ey", "0"]));
}

#[test]
fn the_reduced_model_is_what_lagrange_gives_under_the_reduced_torque() {
    let system = reduced(&ellipse(), 0.3, Terms::default()).unwrap();
    let slip = "-mu*der2*(Sxy*ey - Syy*ex)".replace("der2", "thetadd");
    let along = "(Sxx*vx^2 + 2*Sxy*vx*vy + Syy*vy^2)/(vx^2 + vy^2)";
    let spin = format!("-mu*g*cos(theta)*{along}*w/sqrt(vx^2 + vy^2 + I*w^2/4)");
    assert!(agrees(system, ["-mu*load*ex", "-mu*load*ey", &(slip + &spin)]));
}

#[test]
fn the_load_of_the_models_is_the_derived_one() {
    for system in [
        first_principles(&ellipse(), &COULOMB, Terms::default()).unwrap(),
        reduced(&ellipse(), 0.3, Terms::default()).unwrap(),
    ] {
        let mut flat = flat_contact();
        let system = with_factors(system);
        let load = system.definitions.iter().find(|(n, _)| n == "load").unwrap().1;
        let coded = in_symbols_of(&mut flat, &system, load);
        let difference = flat.pool.sub(coded, flat.load);
        assert!(zero(&mut flat, difference));
    }
}

#[test]
fn with_the_published_terms_the_reduced_model_is_the_published_one_with_the_torque_turned_round() {
    let mut flat = flat_contact();
    let ours = with_factors(reduced(&ellipse(), 0.3, Terms::PUBLISHED).unwrap());
    let theirs = published(&Shape::REFERENCE_ELLIPSE, 0.3).unwrap();
    let axes = [("Sa", "a^2/4"), ("Sb", "b^2/4")];
    let axes = axes.map(|(s, text)| (flat.pool.var(s), flat.pool.parse(text).unwrap())).into_iter().collect();
    for i in 0..6 {
        let ours = in_symbols_of(&mut flat, &ours, ours.dynamics[i]);
        let ours = flat.pool.substitute(ours, &axes);
        let theirs = in_symbols_of(&mut flat, &theirs, theirs.dynamics[i]);
        let rest = if i == 5 { flat.pool.add(ours, theirs) } else { flat.pool.sub(ours, theirs) };
        assert!(zero(&mut flat, rest), "{i}: {}", flat.pool.text(rest));
    }
}

/// The accelerations `x'', y'', phi''` of a model at a state and at rates of the plate `(X'', theta, theta', theta'')`.
fn accelerations(system: &mut System, state: [f64; 6], plate: [f64; 4]) -> [f64; 3] {
    let arguments = system.arguments();
    let names: Vec<String> = arguments.iter().map(|&s| system.pool.name(s).to_owned()).collect();
    let states = ["x", "y", "phi", "vx", "vy", "w"].into_iter().zip(state);
    let rates = ["der(X, 2)", "theta", "der(theta)", "der(theta, 2)"].into_iter().zip(plate);
    let known: Vec<(&str, f64)> = states.chain(rates).collect();
    let values: Vec<f64> = names.iter().map(|n| known.iter().find(|(k, _)| k == n).map_or(0.0, |(_, v)| *v)).collect();
    let dynamics = system.dynamics[3..].to_vec();
    let tape = system.compile(&arguments, &dynamics).unwrap();
    let mut out = [0.0; 3];
    tape.eval(&values, &mut Vec::new(), &mut out);
    out
}

#[test]
fn every_law_of_friction_acts_in_the_model_as_it_does_by_itself() {
    let laws = [
        COULOMB,
        Friction::StaticLevel { mu: 0.3, mu_static: 0.4 },
        Friction::Stribeck { mu: 0.3, mu_static: 0.4, velocity: 0.05 },
        Friction::Anisotropic { mu_along: 0.2, mu_across: 0.4 },
        Friction::Anisotropic { mu_along: 0.0, mu_across: 0.4 },
        Friction::Viscous { mu: 0.3, coefficient: 0.5 },
    ];
    let (state, plate) = ([0.1, -0.2, 0.4, 0.03, -0.05, 0.7], [1.5, 0.2, -1.1, 6.0]);
    let frictionless = Friction::Coulomb { mu: 0.0 };
    let mut free = first_principles(&ellipse(), &frictionless, Terms::default()).unwrap();
    let free = accelerations(&mut free, state, plate);
    let (y, vy, h) = (state[1], state[4], ellipse().height);
    let load = 9.81 * plate[1].cos() + y * plate[3] + 2.0 * vy * plate[2] - h * plate[2] * plate[2];
    for law in laws {
        let mut system = first_principles(&ellipse(), &law, Terms::default()).unwrap();
        let with = accelerations(&mut system, state, plate);
        let force = law.force([state[3], state[4]]);
        for i in 0..2 {
            assert!((with[i] - free[i] - load * force[i]).abs() < 1e-12, "{law:?} {i}");
        }
        assert_eq!(with[2], free[2]);
    }
}

#[test]
fn each_term_switched_off_takes_just_itself_away() {
    let (state, plate) = ([0.1, -0.2, 0.4, 0.03, -0.05, 0.7], [1.5, 0.2, -1.1, 6.0]);
    let object = Object { height: 0.05, ..ellipse() };
    let complete = accelerations(&mut reduced(&object, 0.3, Terms::default()).unwrap(), state, plate);
    let [y, vx, vy, w] = [state[1], state[3], state[4], state[5]];
    let [_, theta, rate, acceleration] = plate;
    let speed = vx.hypot(vy);
    let (ex, ey) = (vx / speed, vy / speed);
    let (sxx, syy, sxy) = object.shape.second_moments_at(state[2]);
    let inertia = sxx + syy;
    let load = 9.81 * theta.cos() + y * acceleration + 2.0 * vy * rate - 0.05 * rate * rate;
    let along = sxx * ex * ex + 2.0 * sxy * ex * ey + syy * ey * ey;
    let spin = -0.3 * 9.81 * theta.cos() * along * w / (speed * speed + inertia * w * w / 4.0).sqrt();
    let through_load = |part: f64| [-0.3 * part * ex, -0.3 * part * ey, 0.0];
    let all = Terms::default();
    let cases = [
        (Terms { centrifugal: false, ..all }, [0.0, y * rate * rate, 0.0]),
        (Terms { euler: false, ..all }, through_load(y * acceleration)),
        (Terms { coriolis: false, ..all }, through_load(2.0 * vy * rate)),
        (Terms { thickness: false, ..all }, {
            let [x, y, _] = through_load(-0.05 * rate * rate);
            [x, y + 0.05 * acceleration, 0.0]
        }),
        (Terms { load_along_x: false, ..all }, [-0.3 * (load - 9.81) * ex, 0.0, 0.0]),
        (Terms { gyroscopic: false, ..all }, [0.0, 0.0, sxy * rate * rate / inertia]),
        (Terms { torque_across: false, ..all }, [0.0, 0.0, -0.3 * acceleration * sxy * ey / inertia]),
        (Terms { yaw_friction: false, ..all }, [0.0, 0.0, spin / inertia]),
    ];
    for (terms, share) in cases {
        let without = accelerations(&mut reduced(&object, 0.3, terms).unwrap(), state, plate);
        for i in 0..3 {
            assert!((complete[i] - without[i] - share[i]).abs() < 1e-12, "{terms:?} {i}");
        }
    }
    let per_axis = accelerations(&mut reduced(&object, 0.3, Terms { coupled: false, ..all }).unwrap(), state, plate);
    assert!((complete[0] - per_axis[0] + 0.3 * load * (ex - 1.0)).abs() < 1e-12);
    assert!((complete[1] - per_axis[1] + 0.3 * load * (ey + 1.0)).abs() < 1e-12);
}

#[test]
fn numbers_without_meaning_are_refused_with_their_name() {
    let refused = |object: Object, friction: Friction| {
        first_principles(&object, &friction, Terms::default()).unwrap_err().to_string()
    };
    assert!(refused(Object { height: -1.0, ..ellipse() }, COULOMB).contains("height = -1"));
    assert!(refused(ellipse(), Friction::Coulomb { mu: f64::NAN }).contains("mu = NaN"));
    let lamina = Object { shape: Shape::Ellipse { a: 0.1, b: 0.0 }, ..ellipse() };
    assert!(refused(lamina, COULOMB).contains("b = 0"));
    assert!(reduced(&ellipse(), -0.1, Terms::default()).unwrap_err().to_string().contains("mu = -0.1"));
}
