//! Operating points: found, confirmed exactly where they are simple constants, and honest where there are none.

use crate::tier;
use bracketry_lie::operating::{LinearModel, Rest, Trim, TrimNote, TrimOptions, TrimStatus};
use bracketry_lie::trim;
use bracketry_system::{System, point};
use std::fmt::Write as _;

fn searched(text: &str, fixed: &[(&str, &str)], free: &[&str], moving: &[&str]) -> Trim {
    let mut system = System::parse("m", text).unwrap();
    let mut options = TrimOptions { starts: 24, seed: 1, ..TrimOptions::default() };
    for (name, value) in fixed {
        let k = system.state_index(name);
        let at = point(&mut system, &format!("{name}={value}")).unwrap();
        let value = k.map_or_else(|| at.inputs[system.input_index(name).unwrap()], |k| at.states[k]);
        options.fixed.push(((*name).to_owned(), value));
    }
    options.free = free.iter().map(|s| (*s).to_owned()).collect();
    options.moving = moving.iter().map(|s| (*s).to_owned()).collect();
    trim(&system, &options).unwrap()
}

fn exact(t: &Trim, name: &str) -> String {
    let all = t.states.iter().chain(&t.inputs);
    all.filter(|v| v.name == name).find_map(|v| v.exact.as_ref().map(bracketry_lie::Function::text)).unwrap()
}

const PENDULUM: &str = "states = ['th', 'w']\ninputs = ['u']\nparameters = { g = 9.81 }\n\
    dynamics = { th = 'w', w = 'u - g*sin(th)' }\n";

#[test]
fn equilibria_are_confirmed_exactly() {
    let t = searched(PENDULUM, &[("th", "1")], &["u"], &[]);
    assert_eq!((t.status, t.exact), (TrimStatus::Found, true), "{t:?}");
    assert_eq!((exact(&t, "u").as_str(), exact(&t, "w").as_str()), ("9.81*sin(1)", "0"));
    assert!((t.inputs[0].value - 9.81 * 1f64.sin()).abs() < 1e-14 && t.residual < 1e-12);
    // Multiples of π, square roots, and fractions.
    let t = searched(&format!("{PENDULUM}[point]\nth = 3\n"), &[], &[], &[]);
    assert_eq!((exact(&t, "th").as_str(), t.exact), ("pi", true), "{t:?}");
    let t =
        searched("states = ['x', 'y']\ndynamics = { x = 'x^2 - 2', y = '3*y - 1' }\n[point]\nx = -1\n", &[], &[], &[]);
    assert_eq!((exact(&t, "x").as_str(), exact(&t, "y").as_str()), ("-sqrt(2)", "1/3"), "{t:?}");
    assert_eq!(t.others.len(), 1);
}

#[test]
fn a_point_within_rounding_is_taken_for_the_equilibrium() {
    let t = searched(&format!("{PENDULUM}[point]\nth = 3.1415927\n"), &[], &[], &[]);
    assert!(t.notes.iter().any(|n| matches!(n, TrimNote::WithinRounding { .. })), "{t:?}");
    let mut system = System::parse("m", &format!("{PENDULUM}[point]\nth = 3.14159265358979\n")).unwrap();
    assert!(matches!(LinearModel::new(&system).unwrap().rest, Rest::WithinRounding { .. }));
    system.point = Some(point(&mut system, "th=pi").unwrap());
    assert_eq!(LinearModel::new(&system).unwrap().rest, Rest::Equilibrium);
    system.point = Some(point(&mut system, "th=1").unwrap());
    assert!(matches!(LinearModel::new(&system).unwrap().rest, Rest::Moving { .. }));
}

#[test]
fn of_a_set_of_solutions_the_nearest_is_given() {
    // x² + y² = 25 with the point (6, 8): (3, 4).
    let text = "states = ['x', 'y']\ndynamics = { x = 'x^2 + y^2 - 25', y = '0' }\n[point]\nx = 6\ny = 8\n";
    let t = searched(text, &[], &[], &[]);
    assert!(t.notes.contains(&TrimNote::Underdetermined { dimensions: 1 }), "{t:?}");
    assert!((t.states[0].value - 3.0).abs() < 1e-6 && (t.states[1].value - 4.0).abs() < 1e-6, "{t:?}");
}

#[test]
fn a_vehicle_at_constant_speed_is_an_operating_point() {
    let text = "states = ['p', 'v']\ninputs = ['u']\n[dynamics]\np = 'v'\nv = 'u - v^2/2'\n";
    let t = searched(text, &[("v", "3")], &["u"], &["p"]);
    assert_eq!((t.status, exact(&t, "u").as_str()), (TrimStatus::Found, "4.5"));
    assert!((t.derivatives[0].1 - 3.0).abs() < 1e-12);
    // At rest alone it cannot move.
    let t = searched(text, &[("v", "3")], &["u"], &[]);
    assert_eq!(t.status, TrimStatus::NotFound);
    assert!((t.residual - 3.0).abs() < 1e-9);
}

#[test]
fn ranges_are_respected_or_said_to_be_violated() {
    let text = "states = ['x']\ninputs = ['u']\n[ranges]\nu = { min = 0, max = 2 }\n[dynamics]\nx = 'u^2 - x'\n";
    let t = searched(text, &[("x", "4")], &["u"], &[]);
    assert_eq!((t.status, exact(&t, "u").as_str()), (TrimStatus::Found, "2"), "{t:?}");
    let t = searched(text, &[("x", "9")], &["u"], &[]);
    assert_eq!(t.status, TrimStatus::OutOfRange);
    assert!(t.notes.iter().any(|n| matches!(n, TrimNote::OutOfRange { .. })));
}

#[test]
fn without_a_solution_the_best_residual_is_given() {
    let t = searched("states = ['x']\ndynamics = { x = 'x^2 + 1' }\n", &[], &[], &[]);
    assert_eq!((t.status, t.exact), (TrimStatus::NotFound, false));
    assert!((t.residual - 1.0).abs() < 1e-6, "{t:?}");
}

/// Random triangular systems with a known equilibrium, hidden by a change of the equations.
#[test]
fn known_equilibria_are_found() {
    let mut state = 7u64;
    let mut random = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    for case in 0..40 {
        let n = 2 + random(4) as usize;
        let root: Vec<i64> = (0..n).map(|_| random(7) as i64 - 3).collect();
        let mut equations = Vec::new();
        for i in 0..n {
            let mut e = format!("(x{i} - ({})) + (x{i} - ({}))^3", root[i], root[i]);
            for (j, r) in root.iter().enumerate().take(i) {
                let _ = write!(e, " + {}*(x{j}^2 - {})", random(3), r * r);
            }
            equations.push(format!("x{i} = '{e}'"));
        }
        let names: Vec<String> = (0..n).map(|i| format!("'x{i}'")).collect();
        let t =
            searched(&format!("states = [{}]\n[dynamics]\n{}\n", names.join(","), equations.join("\n")), &[], &[], &[]);
        assert_eq!((t.status, t.exact), (TrimStatus::Found, true), "{case}: {equations:?} {t:?}");
        for (v, r) in t.states.iter().zip(&root) {
            assert!((v.value - *r as f64).abs() < 1e-9, "{case}: {t:?}");
        }
    }
}

/// Where the derivatives only tend to zero there is no equilibrium; where they vanish slowly or steeply there is one.
#[test]
fn points_at_infinity_are_no_equilibria() {
    for factor in ["1", "1/1000", "2000"] {
        for rate in
            ["exp(-x)", "exp(x)", "1/x", "1/(1 + x^2)", "tanh(x) - 1", "atan(x) - pi/2", "exp(-x^2)*(2 + sin(x))"]
        {
            let model = format!("states = ['x']\ndynamics = {{ x = '({factor})*({rate})' }}\n[point]\nx = 1\n");
            let t = searched(&model, &[], &[], &[]);
            assert_eq!(t.status, TrimStatus::NotFound, "({factor})*({rate}): {t:?}");
        }
        for (rate, root) in [
            ("(x - 3)^3", 3.0),
            ("x^2 - 6*x + 9", 3.0),
            ("max(x - 3, 0)", f64::NAN),
            ("exp(-x) - 1/1000", 1000f64.ln()),
            ("tanh(x) - 9/10", 0.9f64.atanh()),
            ("x/(1 + x^4)", 0.0),
        ] {
            let model = format!("states = ['x']\ndynamics = {{ x = '({factor})*({rate})' }}\n[point]\nx = 1\n");
            let t = searched(&model, &[], &[], &[]);
            assert_eq!(t.status, TrimStatus::Found, "({factor})*({rate}): {t:?}");
            let (x, others) = (t.states[0].value, t.others.iter().map(|o| o[0]));
            let near = |x: f64| root.is_nan() || (x - root).abs() < 1e-4;
            assert!(near(x) || others.into_iter().any(near), "({factor})*({rate}): {t:?}");
        }
    }
    let scaled = "states = ['x', 'y']\ndynamics = { x = '1e8*(x - 3)', y = '1e-8*(y - 7)' }\n";
    let t = searched(scaled, &[], &[], &[]);
    assert_eq!((t.status, t.exact), (TrimStatus::Found, true), "{t:?}");
    assert_eq!((exact(&t, "x").as_str(), exact(&t, "y").as_str()), ("3", "7"));
}

/// Other equations beside one that only tends to zero, with any coefficients, do not make an equilibrium; beside one that has a
/// zero, they do.
#[test]
fn equations_that_hold_elsewhere_do_not_help_one_that_never_holds() {
    for (rate, possible) in [("exp(y)", false), ("1 - tanh(y)", false), ("1/cosh(y)", false), ("exp(y) - 1/2", true)] {
        for factor in ["1", "1000", "1/1000", "sqrt(7)"] {
            for other in ["tanh(x) - tanh(2)", "x^3 - 2", "(x - 1)*(2 + sin(x))"] {
                let model = format!(
                    "states = ['x', 'y']\ndynamics = {{ x = '{other}', y = '{factor}*({rate} + log(28)*({other}))' }}\n"
                );
                let t = searched(&model, &[], &[], &[]);
                let expected = if possible { TrimStatus::Found } else { TrimStatus::NotFound };
                assert_eq!(t.status, expected, "{factor}*({rate}), {other}: {t:?}");
            }
        }
    }
    // A double solution that no exact value confirms, and what only comes near zero, are not told apart.
    for rate in ["x^2 - 2*exp(1/5)*x + exp(2/5)", "exp(-x)"] {
        let t = searched(&format!("states = ['x']\ndynamics = {{ x = '{rate}' }}\n"), &[], &[], &[]);
        assert!(t.status == TrimStatus::NotFound && t.notes.contains(&TrimNote::NotConfirmed), "{rate}: {t:?}");
    }
    // A multiple solution that is no simple constant.
    let t = searched("states = ['x']\ndynamics = { x = '(x^3 - exp(1/5))^3' }\n", &[], &[], &[]);
    assert_eq!(t.status, TrimStatus::Found, "{t:?}");
}

/// Beside what another equation makes zero, times any factor, only the rest counts: whether it has a zero, whether it only tends to one far
/// out, has a kink just above zero, or ends there.
#[test]
fn factors_of_other_equations_do_not_hide_what_is_left() {
    for other in ["z - 3*x", "z - x/3", "1e6*(z - x)"] {
        for factor in ["sqrt(3)", "1/3", "-pi", "5"] {
            for (rest, possible) in [
                ("exp(-x^2)", false),
                ("1 - tanh(x)", false),
                ("abs(x - 1/3) + 1e-6", false),
                ("abs(x - 1/3) + 1e-12", false),
                ("sqrt(x) + 1e-6", false),
                ("x^2 + 1e-8", false),
                ("abs(x - 1/3) - 1e-6", true),
                ("exp(-x) - 1/1000", true),
                ("(x - 1/7)^2", true),
                ("x^3 - 2", true),
            ] {
                // The search itself ends early where slopes differ by a factor of a million.
                if possible && other.starts_with("1e6") {
                    continue;
                }
                let text = format!(
                    "states = ['x', 'z']\ndynamics = {{ x = '{rest} + ({factor})*({other})', z = '{other}' }}\n[point]\nx = 1\n"
                );
                let t = searched(&text, &[], &[], &[]);
                assert_eq!(t.status == TrimStatus::Found, possible, "{text}: {t:?}");
            }
        }
    }
    // A kink is beside the solution.
    for gap in ["1e-9", "1e-11", "1/3"] {
        let t = searched(&format!("states = ['x']\ndynamics = {{ x = 'abs(x) - {gap}' }}\n"), &[], &[], &[]);
        assert_eq!(t.status, TrimStatus::Found, "{gap}: {t:?}");
    }
}

/// Where an equation jumps from one sign to the other, it does not vanish.
#[test]
fn a_jump_is_no_equilibrium() {
    for rate in ["atan2(y, x)", "atan2(y - 1, x + 2)", "atan2(x, 3*y)"] {
        let t = searched(&format!("states = ['x', 'y']\ndynamics = {{ x = '0', y = '{rate}' }}\n"), &[], &[], &[]);
        assert!(t.status == TrimStatus::NotFound || t.residual < 1e-9, "{rate}: {t:?}");
    }
}

/// Beside the end of a domain, where the slope is infinite, a value that is not small is no rounding.
#[test]
fn no_solution_at_the_end_of_a_domain() {
    for power in ["(1/3)", "(1/5)", "(1/4)", "0.1", "(1/2)"] {
        for (offset, solved) in [(" + 1", false), (" + 1/1000", false), ("", true), (" - 1/2", true)] {
            let text = format!("states = ['x']\ndynamics = {{ x = 'x^{power}{offset}' }}\n[point]\nx = 1\n");
            let t = searched(&text, &[], &[], &[]);
            assert_eq!(t.status != TrimStatus::NotFound, solved, "{text}: {t:?}");
        }
    }
}

/// Multiple solutions are found to a part of their digits only, and confirmed exactly all the same.
#[test]
fn multiple_solutions_at_simple_constants_are_confirmed() {
    for (equation, value) in [
        ("sin(x) - 1", "0.5*pi"),
        ("cos(2*x) + 1", "0.5*pi"),
        ("x^2 - 2*x*sqrt(2) + 2", "sqrt(2)"),
        ("(x - 1/3)^2", "1/3"),
        ("(x - 3)^3*(x + 5)", "3"),
    ] {
        let start = if value == "1/3" { "0.5" } else { "2" };
        let text = format!("states = ['x']\ndynamics = {{ x = '{equation}' }}\n[point]\nx = {start}\n");
        let t = searched(&text, &[], &[], &[]);
        assert_ne!(t.status, TrimStatus::NotFound, "{equation}: {t:?}");
        assert_eq!(exact(&t, "x"), value, "{equation}");
    }
}

/// Triangular equations of which one has a multiple root, of odd or even order, at an irrational point: it is found to all digits.
#[test]
fn multiple_roots_are_located() {
    for (root, order) in [("exp(1/3)", 3), ("1/3 + sqrt(2)", 3), ("-exp(1/7)", 4)] {
        for factor in ["(2 + sin(x))", "1000*exp(y)"] {
            let text = format!(
                "states = ['x', 'y', 'z']\ndynamics = {{ x = '{factor}*(x - ({root}))^{order}', y = 'y - x^2*sqrt(2) - 1', z = 'exp(z - x*pi) - 3*(1 + (x - ({root}))^{order})' }}\n"
            );
            let t = searched(&text, &[], &[], &[]);
            let value = |e: &str| {
                let mut pool = bracketry_symbolic::Pool::new();
                let e = pool.parse(e).unwrap();
                pool.constant_value(e, &bracketry_symbolic::Bindings::new()).unwrap()
            };
            if t.status == TrimStatus::NotFound {
                // Roots of even order have no change of sign that proves them.
                assert_eq!(order % 2, 0, "{text}: {t:?}");
                continue;
            }
            for (v, expected) in t.states.iter().zip([
                value(root),
                value(&format!("1 + ({root})^2*sqrt(2)")),
                value(&format!("log(3) + ({root})*pi")),
            ]) {
                assert!(
                    (v.value - expected).abs() <= 1e-11 * (1.0 + expected.abs()),
                    "{text}: {} for {expected}, {t:?}",
                    v.value
                );
            }
        }
    }
}

/// Regular linear equations with coefficients of very different size in irrational combinations have one solution, and no set of them.
#[test]
fn coefficients_of_different_size_make_no_set_of_solutions() {
    for (large, small) in tier::first(2, [("1e9", "1e-9"), ("1e7", "1e-6"), ("1e12", "1e-3")]) {
        for factor in ["sqrt(3)", "(2 + sin(x))", "-exp(1/5)"] {
            let (f, g) = (
                format!("{large}*(x - sqrt(2))"),
                format!("({small}*(y - exp(1/3)) + {factor}*{large}*(x - sqrt(2)))"),
            );
            for (x, y) in [
                (f.clone(), g.clone()),
                (format!("{f} - (1 + y^2)*{g}"), g.clone()),
                (g.clone(), format!("{f} + sqrt(7)*{g}")),
            ] {
                let text = format!("states = ['x', 'y']\ndynamics = {{ x = '{x}', y = '{y}' }}\n[point]\ny = 1\n");
                let t = searched(&text, &[], &[], &[]);
                assert!(!t.notes.iter().any(|n| matches!(n, TrimNote::Underdetermined { .. })), "{text}: {t:?}");
                if t.status == TrimStatus::Found {
                    let errors = [t.states[0].value - 2f64.sqrt(), t.states[1].value - (1f64 / 3.0).exp()];
                    assert!(errors.iter().all(|e| e.abs() < 1e-9), "{text}: {errors:?}, {t:?}");
                }
            }
        }
    }
}
