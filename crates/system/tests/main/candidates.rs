//! Every candidate for an affine form is the original system in other variables, and the one that is taken adds the fewest states.

use std::collections::BTreeMap;

use bracketry_system::symbolic::{Expr, Pool, Tape};
use bracketry_system::{Affinization, Candidate, Method, System};
use proptest::prelude::*;

/// Model text from states, inputs and equations.
fn text(states: &str, inputs: &str, equations: &[String]) -> String {
    let list = |s: &str| s.split_whitespace().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(",");
    let lines: Vec<String> = states.split_whitespace().zip(equations).map(|(s, e)| format!("{s} = '{e}'")).collect();
    format!("states = [{}]\ninputs = [{}]\n[dynamics]\n{}\n", list(states), list(inputs), lines.join("\n"))
}

fn model(states: &str, inputs: &str, equations: &[&str]) -> System {
    let equations: Vec<String> = equations.iter().map(|e| (*e).to_owned()).collect();
    System::parse("test", &text(states, inputs, &equations)).unwrap()
}

type Values = BTreeMap<String, f64>;

/// The value of an expression where every name has one.
fn value(pool: &Pool, e: Expr, at: &Values) -> f64 {
    let symbols = pool.symbols_of(&[e]);
    let arguments: Vec<f64> = symbols.iter().map(|s| at[pool.name(*s)]).collect();
    let tape = Tape::compile(pool, &symbols, &[e]).unwrap();
    let mut out = [f64::NAN];
    tape.eval(&arguments, &mut Vec::new(), &mut out);
    out[0]
}

/// A motion: states and input derivatives of every order at one time, and their rates.
fn motion(original: &System, seed: f64) -> (Values, Values) {
    let number = |k: usize| (1.7 * seed + 2.3 * k as f64).sin() * 1.3;
    let (mut at, mut rates) = (Values::new(), Values::new());
    for (k, s) in original.state_names().into_iter().enumerate() {
        at.insert(s, number(k));
    }
    for p in &original.parameters {
        at.insert(original.pool.name(p.symbol).to_owned(), p.value.to_f64().value());
    }
    for (i, u) in original.input_names().into_iter().enumerate() {
        for order in 0..5 {
            let v = number(20 + 7 * i + order);
            // The names that a model file and the chain of integrators use.
            let der = match order {
                0 => u.clone(),
                1 => format!("der({u})"),
                _ => format!("der({u}, {order})"),
            };
            let chain = format!("{u}{}", "d".repeat(order));
            let next = number(20 + 7 * i + order + 1);
            for name in [der, chain] {
                at.insert(name.clone(), v);
                rates.insert(name, next);
            }
        }
    }
    for (s, &e) in original.state_names().into_iter().zip(&original.dynamics) {
        rates.insert(s, value(&original.pool, e, &at));
    }
    (at, rates)
}

/// The values of new states and inputs on a motion.
fn extended(candidate: &Candidate, at: &Values) -> Values {
    let system = candidate.system.as_ref().unwrap();
    let mut all = at.clone();
    for z in &candidate.coordinate_change {
        all.insert(z.name.clone(), value(z.function.pool(), z.function.expr(), at));
    }
    for v in &candidate.input_change {
        all.insert(v.name.clone(), value(&system.pool, v.function, at));
    }
    all
}

/// Asserts that the candidate's equations hold on motions of the original, and that its inverses lead back.
fn assert_same(original: &System, candidate: &Candidate) {
    let system = candidate.system.as_ref().unwrap();
    let smooth = system.clone().modes().unwrap().len() == 1;
    assert!(!smooth || system.affine_form().unwrap().is_some(), "{candidate:?}");
    for seed in 1..6 {
        let (at, rates) = motion(original, f64::from(seed));
        let here = extended(candidate, &at);
        let h = 1e-5;
        let moved = |sign: f64| -> Values {
            at.iter().map(|(n, v)| (n.clone(), v + sign * h * rates.get(n).copied().unwrap_or(0.0))).collect()
        };
        let (before, after) = (extended(candidate, &moved(-1.0)), extended(candidate, &moved(1.0)));
        for (s, &e) in system.state_names().iter().zip(&system.dynamics) {
            let found = value(&system.pool, e, &here);
            let expected = (after[s] - before[s]) / (2.0 * h);
            assert!(
                (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{s}' = {found}, not {expected}: {candidate:?}"
            );
        }
        for z in &candidate.coordinate_change {
            let old = value(z.inverse.pool(), z.inverse.expr(), &here);
            assert!((old - at[&z.replaces]).abs() < 1e-10, "{z:?}");
        }
        for v in &candidate.input_change {
            // One of several inverses: it need not be the old input, but it must give the new one.
            let mut inverted = here.clone();
            inverted.extend(candidate.inverse.iter().map(|(u, e)| (u.clone(), value(e.pool(), e.expr(), &here))));
            let again = value(&system.pool, v.function, &inverted);
            assert!((again - here[&v.name]).abs() < 1e-9 * (1.0 + again.abs()), "{}: {:?}", v.name, candidate.inverse);
        }
    }
}

fn affinize(original: &System) -> Affinization {
    let a = original.affinize().unwrap();
    assert_eq!(a.candidates.iter().filter(|c| c.chosen && c.is_accepted()).count(), 1);
    let ranks: Vec<(bool, usize)> = a.candidates.iter().map(|c| (!c.is_accepted(), c.added_states)).collect();
    assert!(ranks.is_sorted(), "{ranks:?}");
    assert!(a.candidates.iter().all(|c| !c.why.to_string().is_empty()));
    for c in a.candidates.iter().filter(|c| c.is_accepted()) {
        assert_same(original, c);
    }
    a
}

#[test]
fn all_candidates_are_the_original_and_the_shortest_is_taken() {
    use Method::{Feedback, InputAugmentation, InputChange};
    // (states, inputs, equations, method, added states)
    let cases: &[(&str, &str, &[&str], Method, usize)] = &[
        ("x y th", "u w", &["u*cos(th)", "u*sin(th)", "w"], Method::None, 0),
        ("x y", "u", &["cos(u)", "sin(u)"], InputAugmentation, 1),
        ("x", "u", &["-x + x*u^2"], InputChange, 0),
        ("x", "u", &["sin(u)"], InputChange, 0),
        ("x", "u", &["abs(u)*u - x"], InputChange, 0),
        ("x", "u", &["tanh(u) - x"], InputChange, 0),
        ("x", "u", &["cosh(u) + sinh(x)"], InputChange, 0),
        ("x y", "u", &["u", "u^2"], InputAugmentation, 1),
        ("x y", "u w", &["u*cos(w)", "u*sin(w)"], InputChange, 0),
        ("x y", "u w", &["u*cos(x + w)", "u*sin(x + w)"], InputChange, 0),
        ("x y", "u w", &["u^2", "cos(w)"], InputChange, 0),
        // One integrator less than without the new input u².
        ("x y z", "u w", &["u^2", "cos(w)", "sin(w)"], InputAugmentation, 1),
        (
            "z v p q r",
            "a b c d",
            &["v", "a^2+b^2+c^2+d^2-9.81", "b^2-d^2", "a^2-c^2", "a^2-b^2+c^2-d^2"],
            InputChange,
            0,
        ),
        ("x v", "i", &["v", "9.81 - i^2/(2 + x)^2"], InputChange, 0),
        ("x y th", "v d", &["v*cos(th)", "v*sin(th)", "v*tan(d)/2"], InputChange, 0),
        // The function of the input depends on the state.
        ("x", "u", &["u + x*u^2 - 3"], Feedback, 0),
        ("x y", "u", &["u + x*u^2 + y", "x*u + x^2*u^2 - y"], Feedback, 0),
        ("x", "u", &["sin(x + u)"], Feedback, 0),
        ("x y", "u w", &["exp(y*u) + w", "x*exp(y*u) - w"], Feedback, 0),
        // Two such functions of one input.
        ("x y", "u", &["u + x*u^2", "u^2 + x*u"], InputAugmentation, 1),
        ("x y z", "u w", &["u", "w", "u*w"], InputAugmentation, 1),
        ("x", "u", &["-x + u + der(u)"], InputAugmentation, 1),
        ("x", "u", &["x*der(u) - x"], InputAugmentation, 1),
        ("x v", "X", &["v", "-der(X,2) - v^3"], InputAugmentation, 2),
        ("x v", "X", &["v - x*der(X)", "-der(X,2) - v"], InputAugmentation, 2),
        ("x y", "u w", &["y*der(u) + w^3", "-x*y + w^3"], InputAugmentation, 2),
    ];
    for (states, inputs, equations, method, added) in cases {
        let original = model(states, inputs, equations);
        let a = affinize(&original);
        let found = (a.method, a.system.states.len() - original.states.len());
        assert_eq!(found, (*method, *added), "{equations:?}: {}", a.why);
    }
}

#[test]
fn derivatives_of_inputs_are_removed_by_new_states_in_further_candidates() {
    let lower = |states: &str, inputs: &str, equations: &[&str]| {
        let a = affinize(&model(states, inputs, equations));
        let c = a.candidates.into_iter().find(|c| c.method == Method::CoordinateChange && c.is_accepted());
        c.map(|c| {
            let z: Vec<String> = c.coordinate_change.iter().map(|z| format!("{} = {}", z.name, z.function)).collect();
            (z.join(", "), c.added_states)
        })
    };
    let found = |z: &str, added: usize| Some((z.to_owned(), added));
    assert_eq!(lower("x", "u", &["-x + u + der(u)"]), found("z_x = x - u", 0));
    assert_eq!(lower("x", "u", &["x*der(u) - x"]), found("z_x = x*exp(-u)", 0));
    assert_eq!(lower("x v", "X", &["v", "-der(X,2) - v"]), found("z_x = X + x, z_v = der(X) + v - X", 0));
    assert_eq!(lower("x v", "X", &["v - x*der(X)", "-der(X,2) - v"]), found("z_v = der(X) + v", 1));
    // A chain of states: x' = u' v, v' = u'.
    assert_eq!(lower("x v", "u", &["v*der(u)", "der(u) - v"]), None);
    assert_eq!(lower("x v", "u", &["v*der(u)", "der(u)"]), found("z_x = 0.5*u^2 - u*v + x, z_v = v - u", 0));
    // Squares of derivatives cannot be removed.
    assert_eq!(lower("x", "u", &["der(u)^2"]), None);
}

#[test]
fn a_derivative_that_occurs_alone_can_be_the_input() {
    let a = affinize(&model("x v", "X", &["v", "-der(X,2) - v^3"]));
    let c = a.candidates.iter().find(|c| c.method == Method::InputChange).unwrap();
    assert_eq!((c.added_states, c.chosen), (0, false));
    assert_eq!(c.system.as_ref().unwrap().input_names(), ["Xdd"]);
    // Not where the input itself enters too.
    let a = affinize(&model("x v", "X", &["v", "-der(X,2) - v^3 + X"]));
    assert!(a.candidates.iter().all(|c| c.method != Method::InputChange));
}

#[test]
fn the_plate_keeps_its_chain_and_lists_what_else_was_tried() {
    let plate = System::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/plate_published.toml")).unwrap();
    let a = affinize(&plate);
    assert_eq!((a.method, a.system.states.len()), (Method::InputAugmentation, 10));
    let others: Vec<(Method, bool, usize)> =
        a.candidates.iter().filter(|c| !c.chosen).map(|c| (c.method, c.is_accepted(), c.added_states)).collect();
    assert_eq!(others[0], (Method::InputChange, true, 2));
    assert!(others[1..].iter().all(|o| *o == (Method::CoordinateChange, false, 0)), "{others:?}");
    let why: Vec<String> = a.candidates.iter().filter(|c| !c.is_accepted()).map(|c| c.why.to_string()).collect();
    assert!(why.iter().any(|w| w.contains("z_vx = der(X) + vx") && w.contains("still need 4 integrators")), "{why:?}");
    assert!(why.iter().any(|w| w.contains("jumps with the sign")), "{why:?}");
}

#[test]
fn rejections_say_how_many_functions_there_are() {
    let a = affinize(&model("x y", "u", &["cos(u)", "sin(u)"]));
    let c = a.candidates.iter().find(|c| !c.is_accepted()).unwrap();
    assert_eq!(c.method, Method::InputChange);
    assert!(c.why.to_string().contains("through 2 independent functions, more than there are inputs (1)"), "{}", c.why);
}

#[test]
fn feedback_is_not_taken_where_it_is_singular_at_the_point() {
    let at = |u: &str| {
        let text = text("x", "u", &["x + u^2*exp(x*u)".to_owned()]) + "[point]\nu = " + u + "\n";
        System::parse("m", &text).unwrap().affinize().unwrap().method
    };
    assert_eq!(at("0"), Method::InputAugmentation);
    assert_eq!(at("1"), Method::Feedback);
}

#[test]
fn outputs_follow_the_new_inputs() {
    let output = |y: &str| {
        let text = text("x", "u", &["-x + u^3".to_owned()]) + "[outputs]\ny = '" + y + "'\n";
        let a = System::parse("m", &text).unwrap().affinize().unwrap();
        (a.method, a.system.pool.text(a.system.outputs[0].1))
    };
    assert_eq!(output("x + 2*u^3"), (Method::InputChange, "x + 2*v1".to_owned()));
    // u itself is another function of u.
    assert_eq!(output("x + u"), (Method::InputAugmentation, "x + u".to_owned()));
}

#[test]
fn coefficients_with_parameters_do_not_count_as_functions() {
    let text = "states = ['x', 'y']\ninputs = ['u']\n[parameters]\nk = 2\nc = 3\n[dynamics]\n\
                x = 'k*u + c*u^3 - x'\ny = 'x*(k*u + c*u^3)'";
    let a = affinize(&System::parse("m", text).unwrap());
    assert_eq!((a.method, a.input_change.len()), (Method::InputChange, 1));
    assert_eq!(a.system.pool.text(a.input_change[0].function), "c*u^3 + k*u");
}

#[test]
fn a_candidate_is_written_with_all_that_it_claims() {
    let text = text("x", "u", &["-x + u^2".to_owned()]) + "[point]\nu = 1\n";
    let a = System::parse("m", &text).unwrap().affinize().unwrap();
    let json = serde_json::to_value(&a.candidates[0]).unwrap();
    let expected = serde_json::json!({
        "method": "input_change", "accepted": true, "chosen": true, "added_states": 0, "integrators": {},
        "input_change": [{"name": "v1", "function": "u^2", "range": "v1 ≥ 0", "at_point": "interior",
            "values": {"kind": "interval", "upper": null, "lower": {"value": 0.0, "text": "0", "exact": true, "closed": true}}}],
        "inverse": {"u": "sqrt(v1)"}, "singular_set": "u = 0", "independent_ranges": true, "regular_at_point": true,
        "interior_at_point": true, "covers_at_point": true, "states": ["x"], "inputs": ["v1"], "certificate": "identical",
        "why": "the equations depend on the inputs through 1 independent function: v1 = u^2 (v1 ≥ 0)",
    });
    assert_eq!(json, expected);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// x' = a(x) + B(x) φ(u) with a triangular polynomial map φ, whose inverse is polynomial too: no state is added.
    #[test]
    fn random_invertible_changes_are_found(c in prop::collection::vec(-2i32..3, 12), cubic: bool) {
        let (first, odd) = if cubic { ("(u + u^3)", 3) } else { ("u", 1) };
        let phi = [
            first.to_owned(),
            format!("(w + ({})*u^2 + ({})*u^{odd})", c[0], c[1]),
        ];
        let factor = |k: usize| format!("({} + ({})*x + ({})*y*x)", c[k], c[k + 1], c[k + 2]);
        let row = |k: usize, rest: &str| format!("{}*{} + {}*{} + {rest}", factor(k), phi[0], factor(k + 3), phi[1]);
        let equations = [row(2, "y - x^2"), row(5, "sin(x)"), format!("{} + {}", phi[0], phi[1])];
        let original = System::parse("m", &text("x y z", "u w", &equations)).unwrap();
        let a = affinize(&original);
        prop_assert_eq!(a.system.states.len(), 3, "{:?}: {}", equations, a.why);
        let affine = a.system;
        prop_assert!(affine.affine_form().unwrap().is_some());
    }

    /// x' = f(x, u, …, u^(k)) with the highest derivative in a term of degree d: k integrators, one more for d > 1.
    #[test]
    fn random_chains_have_the_length_of_the_highest_derivative(k in 1u32..4, d in 1u32..3, c in 1i32..4) {
        let der = if k == 1 { "der(u)".to_owned() } else { format!("der(u, {k})") };
        let equations = [format!("y + ({c})*x*{der}^{d}"), "u*x + sin(u)".to_owned()];
        let original = System::parse("m", &text("x y", "u", &equations)).unwrap();
        let a = affinize(&original);
        prop_assert_eq!(&a.integrators, &BTreeMap::from([("u".to_owned(), k + u32::from(d > 1))]));
    }
}
