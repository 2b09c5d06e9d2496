//! For which values of parameters verdicts change.

use std::fmt::Write;

use bracketry_lie::parameters::{
    Aspect, AspectCases, AspectValue, Incomplete, ParameterError, ParameterOptions, ParameterRange, ParameterReport,
};
use bracketry_lie::{parameter_cases, parameter_map};
use bracketry_system::System;

fn report(text: &str, conditions: usize) -> ParameterReport {
    let system = System::parse("test", text).unwrap();
    parameter_cases(&system, &ParameterOptions { conditions, ..ParameterOptions::default() }).unwrap()
}

fn aspect(r: &ParameterReport, aspect: Aspect) -> &AspectCases {
    r.aspects.iter().find(|a| a.aspect == aspect).unwrap()
}

/// `conditions -> value`, sorted.
fn cases(r: &ParameterReport, a: Aspect) -> Vec<String> {
    let mut list: Vec<String> = aspect(r, a)
        .cases
        .iter()
        .map(|c| {
            let conditions: Vec<String> = c.conditions.iter().map(bracketry_lie::Function::text).collect();
            format!("{} -> {}", conditions.join(", "), c.value)
        })
        .collect();
    list.sort();
    list
}

/// Linear systems x_i' = −p_i x_i + u with output Σ x_i.
fn tanks(names: &[&str]) -> String {
    let states: Vec<String> = names.iter().map(|p| format!("'x{p}'")).collect();
    let values: Vec<String> = names.iter().zip(1..).map(|(p, k)| format!("{p} = {k}")).collect();
    let mut text = format!(
        "states = [{}]\ninputs = ['u']\nparameters = {{ {} }}\npoint = {{ }}\n[dynamics]\n",
        states.join(", "),
        values.join(", ")
    );
    for p in names {
        writeln!(text, "x{p} = 'u - {p}*x{p}'").unwrap();
    }
    let sum: Vec<String> = names.iter().map(|p| format!("x{p}")).collect();
    writeln!(text, "[outputs]\ny = '{}'", sum.join(" + ")).unwrap();
    text
}

#[test]
fn parallel_lags_are_uncontrollable_just_where_two_rates_are_equal() {
    let r = report(&tanks(&["a", "b", "c"]), 3);
    let expected = ["a - b -> 2", "a - c -> 2", "a - c, b - c -> 1", "b - c -> 2"];
    for a in
        [Aspect::StrongAccessibility, Aspect::LinearControllability, Aspect::LinearObservability, Aspect::Observability]
    {
        assert_eq!(cases(&r, a), expected, "{a:?}");
        assert!(aspect(&r, a).complete, "{:?}", aspect(&r, a).open);
        assert!(aspect(&r, a).cases.iter().all(|c| !c.confirmed_at.is_none()));
    }
    // With the drift one direction more is reached, but where all rates are equal or two vanish.
    let expected = ["a - c, b - c -> 2", "a, b -> 2", "a, b, c -> 1", "a, c -> 2", "b, c -> 2"];
    assert_eq!(cases(&r, Aspect::Accessibility), expected);
    assert!(aspect(&r, Aspect::Accessibility).complete);
}

/// Euler's equations about the principal axes, with torques about some of them.
fn rigid_body(torques: &[usize]) -> String {
    let inputs: Vec<String> = torques.iter().map(|k| format!("'u{k}'")).collect();
    let mut text = format!(
        "states = ['w1', 'w2', 'w3']\ninputs = [{}]\nparameters = {{ J1 = 1, J2 = 2, J3 = 3 }}\n[dynamics]\n",
        inputs.join(", ")
    );
    for (i, (j, k)) in [(1, (2, 3)), (2, (3, 1)), (3, (1, 2))] {
        let torque = if torques.contains(&i) { format!(" + u{i}") } else { String::new() };
        writeln!(text, "w{i} = '((J{j} - J{k})*w{j}*w{k}{torque})/J{i}'").unwrap();
    }
    text
}

/// As they are written: where a denominator or a logarithm has no value, there is no case, even if the factor would cancel.
#[test]
fn equations_without_a_value_are_no_case() {
    let written = [
        ("J2*(J2 - J3)/(J1*J2)*w2*w3 + u/J1", "(J3 - J1)*w3*w1", vec!["J1", "J2"]),
        ("u/sqrt(J1 + J3)", "log(J2)*w1", vec!["J1 + J3", "J2"]),
        ("u", "(J1^2 - J2^2)/(J1 - J2)*w1", vec!["J1 - J2"]),
        ("u + w2/(J1 + w3^2)", "J2*w1", vec![]),
    ];
    for (first, second, expected) in written {
        let text = format!(
            "states = ['w1', 'w2', 'w3']\ninputs = ['u']\nparameters = {{ J1 = 1, J2 = 2, J3 = 3 }}\n[dynamics]\n\
             w1 = '{first}'\nw2 = '{second}'\nw3 = '(J1 + J3)*w1*w2'\n"
        );
        let r = report(&text, 2);
        let mut undefined: Vec<String> = r.undefined.iter().map(bracketry_lie::Function::text).collect();
        undefined.sort();
        assert_eq!(undefined, expected, "{first}");
        let sets = r.aspects.iter().flat_map(|a| &a.cases).flat_map(|c| &c.conditions).map(ToString::to_string);
        for set in sets {
            assert!(!expected.contains(&set.as_str()), "{first}: {set}");
        }
    }
}

/// Two torques about principal axes: accessible if and only if the inertias about these differ (Baillieul 1981).
#[test]
fn a_rigid_body_with_two_torques_is_accessible_unless_their_inertias_are_equal() {
    let r = report(&rigid_body(&[1, 2]), 3);
    assert_eq!(cases(&r, Aspect::StrongAccessibility), ["J1 - J2 -> 2"]);
    let a = aspect(&r, Aspect::StrongAccessibility);
    assert!(a.complete, "{:?}", a.open);
    let undefined: Vec<String> = r.undefined.iter().map(bracketry_lie::Function::text).collect();
    assert_eq!(undefined, ["J1", "J2", "J3"]);
}

/// One torque about the third axis: (J3 − J1) J1 w1² + (J3 − J2) J2 w2² stays what it is, and both rates where all inertias
/// are equal.
#[test]
fn a_rigid_body_with_one_torque() {
    let r = report(&rigid_body(&[3]), 2);
    let a = aspect(&r, Aspect::StrongAccessibility);
    let generic = a.generic.known().unwrap();
    assert_eq!(*generic, AspectValue::Dimension(2));
    assert_eq!(cases(&r, Aspect::StrongAccessibility), ["J1 - J3, J2 - J3 -> 1"]);
    assert!(a.complete_up_to_conditions, "{:?}", a.open);
}

/// The point at distance l ahead of the wheels: its position has relative degree 1, 1 unless l = 0.
#[test]
fn a_unicycle_loses_its_relative_degree_without_offset() {
    let text = "states = ['x', 'y', 'th']\ninputs = ['v', 'w']\nparameters = { l = 0.5 }\n\
                dynamics = { x = 'v*cos(th)', y = 'v*sin(th)', th = 'w' }\n\
                outputs = { p = 'x + l*cos(th)', q = 'y + l*sin(th)' }";
    let r = report(text, 2);
    let a = aspect(&r, Aspect::RelativeDegree);
    assert_eq!(a.generic.known().unwrap(), &AspectValue::Degrees { degrees: vec![Some(1), Some(1)], rank: 2 });
    assert_eq!(cases(&r, Aspect::RelativeDegree), ["l -> 1, 1; decoupling rank 1"]);
    assert!(a.complete);
    assert!(aspect(&r, Aspect::Accessibility).cases.is_empty() && aspect(&r, Aspect::Accessibility).complete);
}

/// A crane with two loads on ropes of equal length, linearized: the loads cannot be moved apart.
#[test]
fn two_pendulums_on_a_cart_need_different_lengths() {
    let text = "states = ['s', 'v', 'a', 'p', 'b', 'q']\ninputs = ['u']\nparameters = { l1 = 1, l2 = 2 }\n\
                dynamics = { s = 'v', v = 'u', a = 'p', p = '(-9.81*sin(a) - u*cos(a))/l1', b = 'q', \
                q = '(-9.81*sin(b) - u*cos(b))/l2' }\npoint = { s = 0 }";
    let r = report(text, 2);
    assert_eq!(cases(&r, Aspect::LinearControllability), ["l1 - l2 -> 4"]);
    assert!(aspect(&r, Aspect::LinearControllability).complete);
    let undefined: Vec<String> = r.undefined.iter().map(bracketry_lie::Function::text).collect();
    assert_eq!(undefined, ["l1", "l2"]);
}

/// Observability is lost where the coupling vanishes; linearizability where a chain is cut or a bracket opens.
#[test]
fn a_coupling_that_vanishes_cuts_the_chain() {
    let text = "states = ['x', 'y', 'z']\ninputs = ['u']\nparameters = { k = 1, m = 1, e = 0 }\n\
                dynamics = { x = 'k*y', y = 'm*z + e*x*y', z = 'u' }\noutputs = { h = 'x' }";
    let r = report(text, 3);
    assert_eq!(cases(&r, Aspect::Observability), ["k -> 1", "m -> 2"]);
    assert_eq!(cases(&r, Aspect::StaticLinearization), ["k -> no", "m -> no"]);
    assert!(aspect(&r, Aspect::Observability).complete && aspect(&r, Aspect::StaticLinearization).complete);
}

/// x' = u, y' = v + e x² …: not involutive unless e = 0, and then linearizable.
#[test]
fn a_verdict_may_become_better_at_special_values() {
    let text = "states = ['x', 'y', 'z']\ninputs = ['u', 'v']\nparameters = { e = 1, k = 1 }\n\
                dynamics = { x = 'u', y = 'v', z = 'k*x + e*x*v' }";
    let r = report(text, 2);
    let a = aspect(&r, Aspect::StaticLinearization);
    assert_eq!(a.generic.known().unwrap(), &AspectValue::Possible(false));
    assert_eq!(cases(&r, Aspect::StaticLinearization), ["e -> yes", "e, k -> no"]);
    assert!(a.complete);
}

/// Where both inputs' gains vanish, and nowhere else: two simultaneous conditions, by a sum of squares too.
#[test]
fn conditions_that_have_to_hold_together() {
    let text = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 1 }\n\
                dynamics = { x = 'a*u', y = 'b*x + a*u' }";
    let r = report(text, 2);
    assert_eq!(cases(&r, Aspect::StrongAccessibility), ["a -> 0", "b -> 1"]);
    assert_eq!(cases(&r, Aspect::Accessibility), ["a -> 1", "a, b -> 0", "b -> 1"]);
    let text = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 1 }\n\
                dynamics = { x = '(a^2 + b^2)*u', y = 'x + y^2' }";
    let r = report(text, 2);
    assert_eq!(cases(&r, Aspect::StrongAccessibility), ["a, b -> 0"]);
    assert!(aspect(&r, Aspect::StrongAccessibility).complete);
}

/// What is not covered is said: roots of states, and parameters in exponents.
#[test]
fn incomplete_lists_say_so() {
    let text = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\n\
                dynamics = { x = 'u - a*sqrt(x)', y = 'u - b*sqrt(y)' }";
    let r = report(text, 2);
    let a = aspect(&r, Aspect::Accessibility);
    assert!(!a.complete && a.open.iter().any(|o| matches!(o, Incomplete::Function { .. })), "{:?}", a.open);
    let text = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\n\
                dynamics = { x = 'u*exp(a*x)', y = 'u*exp(b*x)' }";
    let r = report(text, 2);
    assert!(!aspect(&r, Aspect::StrongAccessibility).complete);
}

#[test]
fn conditions_outside_of_the_limits_are_marked() {
    let text = "states = ['x', 'y']\ninputs = ['u']\n[parameters]\na = { value = 1, min = 0.5, max = 2 }\n\
                b = { value = 5, min = 4, max = 6 }\n[dynamics]\nx = 'u - a*x'\ny = 'u - b*y'";
    let r = report(text, 2);
    assert_eq!(aspect(&r, Aspect::Accessibility).cases[0].within_limits, Some(false));
}

#[test]
fn bad_input_is_refused() {
    let of = |text: &str, names: &[&str]| {
        let system = System::parse("test", text).unwrap();
        let parameters = names.iter().map(|s| (*s).to_owned()).collect();
        parameter_cases(&system, &ParameterOptions { parameters, ..ParameterOptions::default() }).unwrap_err()
    };
    let tanks = tanks(&["rate", "b"]);
    let unknown = of(&tanks, &["rat"]);
    assert_eq!(unknown.to_string(), "the model has no parameter `rat`; did you mean `rate`?");
    let none = of("states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }", &[]);
    assert!(matches!(none, ParameterError::NoParameters));
    let kink = of("states = ['x']\ninputs = ['u']\nparameters = { k = 1 }\ndynamics = { x = 'u - k*abs(x)' }", &[]);
    assert!(matches!(kink, ParameterError::Switches { .. }), "{kink}");
}

/// Random linear systems T diag(p) T⁻¹ with T unimodular: controllability is lost just where two of the p are equal, or an
/// entry of T⁻¹ b vanishes, which it does not here.
#[test]
fn random_changes_of_coordinates_change_no_condition() {
    let mut state = 7_u64;
    let mut random = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    for case in 0..6 {
        // x = T z with T = product of elementary matrices; z_i' = −p_i z_i + u.
        let mut t = [[1_i64, 0, 0], [0, 1, 0], [0, 0, 1]];
        let mut inverse = t;
        for _ in 0..4 {
            let (i, j) = (random(3) as usize, random(3) as usize);
            let c = random(5) as i64 - 2;
            if i == j {
                continue;
            }
            // T ← T (1 + c e_ij), T⁻¹ ← (1 − c e_ij) T⁻¹
            for row in &mut t {
                row[j] += c * row[i];
            }
            let rows = inverse;
            for (x, y) in inverse[i].iter_mut().zip(rows[j]) {
                *x -= c * y;
            }
        }
        let names = ["a", "b", "c"];
        let mut text =
            "states = ['x', 'y', 'z']\ninputs = ['u']\nparameters = { a = 1, b = 2, c = 3 }\n[dynamics]\n".to_owned();
        for (i, state) in ["x", "y", "z"].iter().enumerate() {
            let mut terms = Vec::new();
            for (k, p) in names.iter().enumerate() {
                let inner: Vec<String> =
                    ["x", "y", "z"].iter().zip(inverse[k]).map(|(s, v)| format!("({v})*{s}")).collect();
                terms.push(format!("({})*(u - {p}*({}))", t[i][k], inner.join(" + ")));
            }
            writeln!(text, "{state} = '{}'", terms.join(" + ")).unwrap();
        }
        let r = report(&text, 2);
        let expected = ["a - b -> 2", "a - c -> 2", "a - c, b - c -> 1", "b - c -> 2"];
        assert_eq!(cases(&r, Aspect::StrongAccessibility), expected, "case {case}");
        // All three are equal on the last of these sets, where nothing is left to be sought but one free parameter.
        assert!(aspect(&r, Aspect::StrongAccessibility).complete_up_to_conditions, "case {case}");
    }
}

/// x' = a x + u, y' = b y: stabilizable just for b < 0; unstable for a > 0 or b > 0.
#[test]
fn a_map_tells_half_planes_exactly_and_draws_where_ranks_change() {
    let text = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 2, c = 1 }\n\
                dynamics = { x = 'a*x + u', y = 'b*y + (a - c)*(a - 3*c)*u' }";
    let system = System::parse("test", text).unwrap();
    let ranges = ParameterRange::two("a=-2..2, b=-1..1").unwrap();
    let map = parameter_map(&system, &ranges, 8, &ParameterOptions::default()).unwrap();
    for (j, row) in map.cells.iter().enumerate() {
        for (i, cell) in row.iter().enumerate() {
            let (a, b) = (map.x[i], map.y[j]);
            let cell = cell.unwrap();
            assert_eq!(cell.unstable, usize::from(a > 0.0) + usize::from(b > 0.0), "{a} {b}");
            assert!(cell.stabilizable, "{a} {b}");
        }
    }
    let curves: Vec<String> = map.curves.iter().map(|c| c.condition.text()).collect();
    assert!(curves.contains(&"a - b".to_owned()) && curves.contains(&"a - 1".to_owned()), "{curves:?}");
    for bad in ["a=0..1", "a=0..1,a=1..2", "a=1..0,b=0..1", "a=0,b=1", "a=x..1,b=0..1"] {
        assert!(matches!(ParameterRange::two(bad), Err(ParameterError::Map { .. })), "{bad}");
    }
    let unknown = ParameterRange::two("q=0..1,a=0..1").unwrap();
    assert!(parameter_map(&system, &unknown, 4, &ParameterOptions::default()).is_err());
}
