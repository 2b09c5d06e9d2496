//! Quotients over a root of squares: springs and drag are smooth, exactly what is written; friction is set-valued.

use bracketry_system::System;
use bracketry_system::symbolic::Symbol;
use proptest::prelude::*;

fn parse(text: &str) -> System {
    System::parse("test.toml", text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The right-hand side of the set-valued form, which has no switches.
fn smooth_rates(system: &System, x: &[f64]) -> Vec<f64> {
    let mut system = system.clone();
    let form = system.set_valued_form();
    assert!(form.switches.is_empty(), "{system:?}");
    let arguments: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
    let tape = system.compile(&arguments, &form.dynamics).unwrap();
    let mut out = vec![0.0; tape.n_outputs()];
    tape.eval(x, &mut Vec::new(), &mut out);
    out
}

/// Chains of masses in the plane or in space, hung from the origin, with springs of random stiffness and length at rest, in
/// any of four ways of writing them.
fn chain(names: &str, axes: usize, k: &[f64], rest: &[f64], way: usize) -> String {
    let masses = k.len();
    let p = |i: usize, a: usize| format!("{names}{i}{}", ["a", "b", "c"][a]);
    let gap = |i: usize, a: usize| if i == 0 { p(0, a) } else { format!("({} - {})", p(i, a), p(i - 1, a)) };
    let (mut states, mut dynamics, mut definitions) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..masses {
        let squares: Vec<String> = (0..axes).map(|a| format!("{}^2", gap(i, a))).collect();
        definitions.push(format!("l{i} = \"sqrt({})\"", squares.join(" + ")));
    }
    // What spring i pulls mass i back with.
    let pull = |i: usize, a: usize| {
        let (d, k, rest) = (gap(i, a), k[i], rest[i]);
        match way {
            0 => format!("{k}*(l{i} - {rest})*{d}/l{i}"),
            1 => format!("{k}*(1 - {rest}/l{i})*{d}"),
            2 => format!("({k}*{d} - {k}*{rest}*{d}/l{i})"),
            _ => format!("{k}*{d}*(l{i} - {rest})*(l{i}^2)^(-1/2)"),
        }
    };
    for i in 0..masses {
        for a in 0..axes {
            states.extend([format!("\"{}\"", p(i, a)), format!("\"v{}\"", p(i, a))]);
            let next = if i + 1 < masses { format!(" + {}", pull(i + 1, a)) } else { String::new() };
            dynamics.push(format!("{} = \"v{}\"\nv{} = \"-{}{next}\"", p(i, a), p(i, a), p(i, a), pull(i, a)));
        }
    }
    format!(
        "states = [{}]\ndefinitions = {{ {} }}\n[dynamics]\n{}\n",
        states.join(", "),
        definitions.join(", "),
        dynamics.join("\n")
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn springs_are_smooth_and_exact(
        name in "[e-k]", axes in 2..4usize, way in 0..4usize, masses in 1..4usize,
        k in prop::collection::vec(0.5..50.0f64, 3), rest in prop::collection::vec(1e-3..0.5f64, 3),
        x in prop::collection::vec(-0.2..0.2f64, 18),
    ) {
        let system = parse(&chain(&name, axes, &k[..masses], &rest[..masses], way));
        let n = 2 * axes * masses;
        let rates = smooth_rates(&system, &x[..n]);
        let at = |i: usize, a: usize| x[2 * (i * axes + a)];
        let gap = |i: usize, a: usize| if i == 0 { at(0, a) } else { at(i, a) - at(i - 1, a) };
        let length = |i: usize| (0..axes).map(|a| gap(i, a).powi(2)).sum::<f64>().sqrt();
        let pull = |i: usize, a: usize| k[i] * (length(i) - rest[i]) * gap(i, a) / length(i);
        for i in 0..masses {
            for a in 0..axes {
                let expected = if i + 1 < masses { pull(i + 1, a) } else { 0.0 } - pull(i, a);
                let got = rates[2 * (i * axes + a) + 1];
                prop_assert!((got - expected).abs() <= 1e-11 * (1.0 + expected.abs()), "{got} {expected}");
            }
        }
        let form = system.clone().set_valued_form();
        prop_assert_eq!(form.singular.len(), masses);
    }

    #[test]
    fn drag_is_smooth_also_at_rest(c in 0.01..5.0f64, c1 in 0.01..5.0f64, way in 0..4usize, v in prop::collection::vec(-3.0..3.0f64, 3)) {
        let rho = "sqrt(p^2 + q^2 + r^2)";
        let law = |d: &str| match way {
            0 => format!("-{c}*(p^2 + q^2 + r^2)*{d}/{rho}"),
            1 => format!("-({c}*rho^2 + {c1}*rho)*{d}/rho"),
            2 => format!("-{c}*rho*{d}"),
            _ => format!("-{c}*tanh(rho/0.05)*{d}/rho"),
        };
        let system = parse(&format!(
            "states = [\"p\", \"q\", \"r\"]\ndefinitions = {{ rho = \"{rho}\" }}\n[dynamics]\np = \"{}\"\nq = \"{}\"\nr = \"{}\"\n",
            law("p"), law("q"), law("r")
        ));
        let value = |v: &[f64], i: usize| {
            let rho = v.iter().map(|v| v * v).sum::<f64>().sqrt();
            match way {
                0 | 2 => -c * rho * v[i],
                1 => -(c * rho + c1) * v[i],
                _ => -c * (rho / 0.05).tanh() * v[i] / rho,
            }
        };
        let rates = smooth_rates(&system, &v);
        for (i, rate) in rates.iter().enumerate() {
            prop_assert!((rate - value(&v, i)).abs() < 1e-12 * (1.0 + rate.abs()));
        }
        prop_assert_eq!(smooth_rates(&system, &[0.0; 3]), [0.0; 3]);
        // The derivative at rest is the limit of difference quotients, not 0/0.
        let mut system = system;
        let form = system.set_valued_form();
        let slope = system.pool.diff(form.dynamics[0], system.states[0]);
        let tape = system.compile(&system.states, &[slope]).unwrap();
        let mut out = [f64::NAN];
        tape.eval(&[0.0; 3], &mut Vec::new(), &mut out);
        let expected = value(&[1e-7, 0.0, 0.0], 0) / 1e-7;
        prop_assert!((out[0] - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{} {expected}", out[0]);
        prop_assert!(form.singular.is_empty());
    }

    #[test]
    fn friction_in_a_plane_is_set_valued_however_it_is_written(
        mu in 0.01..2.0f64, drag in 0.0..2.0f64, way in 0..6usize, a in "[e-k]", b in "[n-s]", positions: bool,
    ) {
        let s = format!("sqrt({a}^2 + {b}^2)");
        let law = |d: &str, other: &str| match way {
            0 => format!("-{mu}*{d}/{s}"),
            1 => format!("-({mu} + {drag}*rho)*{d}/rho"),
            2 => format!("-{mu}*unit({d}, {other})"),
            3 => format!("-({mu} + 0.1*exp(-rho))*{d}*rho^(-1) - {drag}*{d}"),
            4 => format!("u - {mu}*{d}/(m*rho)"),
            // A weight that other forces change.
            _ => format!("-{mu}*(9.81 - 0.5*u)*{d}/rho"),
        };
        let (more, rates) = if positions { (", \"x\", \"y\"", format!("x = \"{a}\"\ny = \"{b}\"\n")) } else { ("", String::new()) };
        let mut system = parse(&format!(
            "states = [\"{a}\", \"{b}\"{more}]\ninputs = [\"u\"]\nparameters = {{ m = 2 }}\ndefinitions = {{ rho = \"{s}\" }}\n\
             [dynamics]\n{rates}{a} = \"{}\"\n{b} = \"{}\"\n", law(&a, &b), law(&b, &a)
        ));
        let form = system.set_valued_form();
        prop_assert_eq!(form.unit_vectors.len(), 1);
        prop_assert_eq!(form.unit_vectors[0].name.clone(), format!("{a}, {b}"));
        prop_assert!(form.singular.is_empty() && !system.is_smooth());
    }
}

#[test]
fn friction_at_a_contact_acts_through_the_inertia() {
    // A bar on a rough floor that touches it at a distance from its center: the force acts on the center and the spin.
    let text = r#"
        states = ["phi", "vx", "vy", "w"]
        parameters = { f = 2, m = { value = 1.5, min = 0.1 }, J = { value = 0.2, min = 0.01 }, r = 0.4 }
        [definitions]
        sx = "vx - r*w*sin(phi)"
        sy = "vy + r*w*cos(phi)"
        s  = "sqrt(sx^2 + sy^2)"
        [dynamics]
        phi = "w"
        vx = "-f*sx/s/m"
        vy = "-f*sy/s/m"
        w = "-f*r*(cos(phi)*sy - sin(phi)*sx)/s/J"
    "#;
    assert_eq!(parse(text).set_valued_form().unit_vectors.len(), 1);
    // The same force the other way is a motor, if f cannot be negative.
    let motor = text.replace("-f*", "f*");
    assert!(!parse(&motor).is_smooth());
    assert!(parse(&motor.replace("f = 2", "f = { value = 2, min = 0 }")).is_smooth());
    assert!(parse(&text.replace("f = 2", "f = { value = -2, max = 0 }")).is_smooth());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// A fit, a sweep, or an edit changes values; it must not change what an equation means.
    #[test]
    fn what_a_quotient_is_does_not_depend_on_the_values_of_parameters(
        values in prop::collection::vec(prop_oneof![Just(0.0), -3.0..3.0f64], 4), way in 0..7usize, drag: bool,
    ) {
        let s = "sqrt(a^2 + b^2)";
        let law = |d: &str, other: &str| match way {
            0 => format!("-c*{d}/{s}"),
            1 => format!("c*{d}/{s}"),
            2 => format!("-m*((1 - c)*sign({d}) + c*{d}/{s})"),
            3 => format!("-(c - k)*{d}/{s}"),
            4 => format!("-m*(9.81 - k*u)*c*{d}/{s}"),
            5 => format!("-c*{d}/{s} - c*k*m*{d}"),
            _ => format!("-c*unit({d}, {other})"),
        };
        let more = if drag { " - 0.2*a" } else { "" };
        let text = |v: &[f64]| format!(
            "states = [\"a\", \"b\"]\ninputs = [\"u\"]\nparameters = {{ c = {:?}, m = {:?}, k = {:?}, j = {:?} }}\n\
             [dynamics]\na = \"u{more} + {}\"\nb = \"j + {}\"\n", v[0], v[1], v[2], v[3], law("a", "b"), law("b", "a")
        );
        let form = parse(&text(&values)).set_valued_form();
        prop_assert_eq!(form.unit_vectors.len(), 1, "{}", text(&values));
        prop_assert!(form.singular.is_empty());
    }

    /// The direction of a spring acts on velocities, whatever stiffness and length are.
    #[test]
    fn no_values_of_parameters_make_a_spring_friction(values in prop::collection::vec(prop_oneof![Just(0.0), -3.0..3.0f64], 3)) {
        let text = format!(
            "states = [\"x\", \"y\", \"vx\", \"vy\"]\nparameters = {{ k = {:?}, l = {:?}, c = {:?} }}\n\
             definitions = {{ r = \"sqrt(x^2 + y^2)\" }}\n[dynamics]\nx = \"vx\"\ny = \"vy\"\n\
             vx = \"-k*(r - l)*x/r - c*vx\"\nvy = \"-k*(r - l)*y/r - c*vy\"\n", values[0], values[1], values[2]
        );
        prop_assert!(parse(&text).is_smooth());
    }
}

#[test]
fn a_range_decides_which_signs_are_looked_at() {
    let of = |c: &str| {
        let text = format!(
            "states = [\"vx\", \"vy\"]\nparameters = {{ c = {c} }}\n[dynamics]\n\
             vx = \"c*vx/sqrt(vx^2 + vy^2)\"\nvy = \"c*vy/sqrt(vx^2 + vy^2)\"\n"
        );
        !parse(&text).is_smooth()
    };
    assert!(of("1") && of("0") && of("{ value = 1, min = -1 }") && of("{ value = 0, min = -0.1, max = 5 }"));
    assert!(!of("{ value = 1, min = 0 }") && !of("{ value = 0, min = 0, max = 2 }"));
}

#[test]
fn a_force_that_is_never_negative_by_its_range_is_friction() {
    let text = |min: &str| {
        format!(
            "states = [\"vx\", \"vy\"]\ninputs = [\"b\"]\nranges = {{ b = {{ min = {min}, max = 5 }} }}\n[dynamics]\n\
             vx = \"-b*vx/sqrt(vx^2 + vy^2)\"\nvy = \"-b*vy/sqrt(vx^2 + vy^2)\"\n"
        )
    };
    assert!(!parse(&text("0")).is_smooth());
    assert!(parse(&text("-5")).is_smooth());
}

#[test]
fn what_is_written_unit_stays_set_valued_when_it_is_written_again() {
    let text = r#"
        states = ["x", "y", "vx", "vy"]
        parameters = { k = 3 }
        [dynamics]
        x = "vx"
        y = "vy"
        vx = "-k*unit(x, 2*y)"
        vy = "-k*unit(2*y, x)"
    "#;
    let written = parse(text);
    assert_eq!(written.clone().set_valued_form().unit_vectors.len(), 1);
    let again = parse(&written.to_toml().unwrap());
    assert_eq!(again.clone().set_valued_form().unit_vectors.len(), 1, "{}", written.to_toml().unwrap());
    // A part of the model keeps it, and so does a parameter at its value.
    let mut system = written;
    system.dynamics = system.with_values(&system.dynamics.clone());
    assert_eq!(system.set_valued_form().unit_vectors.len(), 1);
    assert!(
        parse(&text.replace("unit(x, 2*y)", "x/sqrt(x^2 + 4*y^2)").replace("unit(2*y, x)", "y/sqrt(x^2 + 4*y^2)"))
            .is_smooth()
    );
}

#[test]
fn friction_stays_friction_when_its_coefficient_becomes_a_state() {
    let text = r#"
        states = ["vx", "vy"]
        parameters = { f = 3 }
        dynamics = { vx = "-f*vx/sqrt(vx^2 + vy^2)", vy = "-f*vy/sqrt(vx^2 + vy^2)" }
    "#;
    let mut system = parse(text);
    let f = system.parameters.remove(0).symbol;
    system.states.push(f);
    let zero = system.pool.int(0);
    system.dynamics.push(zero);
    assert_eq!(system.set_valued_form().unit_vectors.len(), 1);
}

#[test]
fn equations_that_were_exchanged_keep_their_friction_when_a_coefficient_becomes_a_state() {
    let text = "states = ['vx', 'vy']\nparameters = { f = 3 }\ndynamics = { vx = '-f*vx', vy = '-f*vy' }\npoint = { vx = 0.1 }\n";
    let vectors = |marked: bool| {
        let mut system = parse(text);
        let [f, x, y] = ["f", "vx", "vy"].map(|name| system.pool.var(name));
        let squares = [system.pool.powi(x, 2), system.pool.powi(y, 2)];
        let square = system.pool.sum(squares.to_vec());
        let size = system.pool.sqrt(square);
        system.dynamics = [x, y]
            .map(|v| {
                let force = system.pool.mul(f, v);
                let force = system.pool.neg(force);
                system.pool.div(force, size)
            })
            .to_vec();
        if marked {
            system.mark_dry_friction();
        }
        let f = system.parameters.remove(0).symbol;
        system.states.push(f);
        let zero = system.pool.int(0);
        system.dynamics.push(zero);
        system.set_valued_form().unit_vectors.len()
    };
    assert_eq!(vectors(true), 1);
    // Unmarked, a state of any sign is no friction; its point has fewer entries than the system has states.
    assert_eq!(vectors(false), 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// A spinning point on a plate, and another on top of it that rubs anisotropically.
    #[test]
    fn all_contacts_of_a_stack_are_friction(
        f in 0.01f64..4.0, r in 0.3f64..3.0, k in 0.01f64..5.0, c in 0.01f64..2.0, j in 0.01f64..2.0,
    ) {
        let mut system = parse(&format!(r#"
            states = ["vx", "vy", "w", "ux", "uy"]
            inputs = ["a", "b"]
            parameters = {{ f = {f:.6}, r = {r:.6}, k = {k:.6}, c = {c:.6}, j = {j:.6} }}
            [definitions]
            size = "sqrt(r^2*(vx - ux)^2 + (vy - uy)^2)"
            jx = "j*r^2*(vx - ux)/size"
            jy = "j*(vy - uy)/size"
            [dynamics]
            vx = "a - f*vx/sqrt(vx^2 + vy^2) - jx"
            vy = "b - f*unit(vy, vx) - jy"
            w = "0.3*a - k*w/sqrt(vx^2 + vy^2 + c*w^2)"
            ux = "a + jx"
            uy = "b + jy"
        "#));
        let form = system.set_valued_form();
        prop_assert_eq!(form.unit_vectors.len(), 3);
        prop_assert!(form.singular.is_empty());
    }
}

#[test]
fn passing_close_to_where_a_direction_has_no_value_is_found() {
    let text = r#"
        states = ["x", "y", "vx", "vy"]
        inputs = ["u"]
        definitions = { l = "sqrt(x^2 + y^2)" }
        dynamics = { x = "vx", y = "vy", vx = "u - 3*(l - 1)*x/l", vy = "-3*(l - 1)*y/l" }
    "#;
    let system = parse(text);
    let near = |y: f64| {
        // Along a line at the distance y, with no row near the closest point.
        let rows: Vec<[f64; 4]> = (0..10).map(|k| [f64::from(k) - 4.5, y, 1.0, 0.0]).collect();
        system.closest_approaches(rows.iter().map(|x| (&x[..], &[0.0][..])))
    };
    let found = near(1e-3);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].name.as_str(), found[0].row), ("x, y", 4));
    assert!((found[0].length - 1e-3).abs() < 1e-12);
    assert!(near(0.5).is_empty());
    // Friction and drag are not singular.
    let friction = parse(
        &text
            .replace("u - 3*(l - 1)*x/l", "u - vx/sqrt(vx^2 + vy^2)")
            .replace("-3*(l - 1)*y/l", "-vy/sqrt(vx^2 + vy^2)"),
    );
    let rows = [[0.0; 4]; 2];
    assert!(friction.closest_approaches(rows.iter().map(|x| (&x[..], &[0.0][..]))).is_empty());
}
