//! Affine forms: what is affine is recognized, what is not is made so with the least change, and the result is the same system.

use approx::assert_relative_eq;
use bracketry_system::{AffineForm, Method, System};

fn model(states: &str, inputs: &str, equations: &[(&str, &str)]) -> System {
    let list = |s: &str| s.split_whitespace().map(|n| format!("\"{n}\"")).collect::<Vec<_>>().join(",");
    let lines: String = equations.iter().map(|(s, e)| s.to_string() + " = \"" + e + "\"\n").collect();
    let text = format!("states=[{}]\ninputs=[{}]\n[dynamics]\n{lines}", list(states), list(inputs));
    System::parse("test", &text).unwrap()
}

fn plate() -> System {
    System::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/plate_published.toml")).unwrap()
}

#[test]
fn affine_models_are_left_alone() {
    for s in [
        model("x y th", "u1 u2", &[("x", "u1*cos(th)"), ("y", "u1*sin(th)"), ("th", "u2")]),
        model("x", "u", &[("x", "(x+u)^2 - u^2")]),
        model("x", "u", &[("x", "u*sin(u)^2 + u*cos(u)^2 - sign(x)")]),
        model("x", "", &[("x", "-x^3")]),
    ] {
        let a = s.affinize().unwrap();
        assert_eq!(a.method, Method::None, "{s:?}");
        assert_eq!(a.system.states, s.states);
    }
}

#[test]
fn drift_and_fields_rebuild_the_right_hand_side() {
    let s = model("x y", "u w", &[("x", "(x+u)^2 - u^2 + y*w"), ("y", "sin(x)*w - 2*u")]);
    let AffineForm { mut pool, drift, fields } = s.affine_form().unwrap().unwrap();
    let (u, w) = (pool.var("u"), pool.var("w"));
    for k in 0..2 {
        let (a, b) = (pool.mul(fields[0][k], u), pool.mul(fields[1][k], w));
        let sum = pool.sum([drift[k], a, b]);
        let difference = pool.sub(sum, s.dynamics[k]);
        assert!(pool.zero_test(difference, &bracketry_system::symbolic::Bindings::default()).is_zero());
    }
}

#[test]
fn the_plate_needs_four_integrators_and_becomes_a_model_file() {
    let original = plate();
    let a = original.affinize().unwrap();
    assert_eq!(a.method, Method::InputAugmentation);
    let integrators: Vec<(&str, u32)> = a.integrators.iter().map(|(n, k)| (n.as_str(), *k)).collect();
    assert_eq!(integrators, [("X", 2), ("theta", 2)]);
    assert_eq!(a.system.state_names(), ["x", "y", "phi", "vx", "vy", "w", "X", "Xd", "theta", "thetad"]);
    assert_eq!(a.system.input_names(), ["Xdd", "thetadd"]);

    // Written and read back, it is affine in every mode and equals the original right-hand side.
    let affine = System::parse("affine", &a.system.to_toml().unwrap()).unwrap();
    for mode in affine.modes().unwrap() {
        assert!(mode.system.affine_form().unwrap().is_some());
    }
    let compiled = |s: &System| s.compile(&s.arguments(), &s.dynamics).unwrap();
    let (f, g) = (compiled(&original), compiled(&affine));
    let body = [0.5, -0.02, 0.8, 0.3, -0.2, 1.1];
    let (x, th, xdd, thdd, xd, thd) = (0.04, 0.2, 7.0, -30.0, 0.6, -1.5);
    let mut left = [0.0; 6];
    let at: Vec<f64> = body.iter().copied().chain([x, th, xdd, thdd]).collect();
    f.eval(&at, &mut Vec::new(), &mut left);
    let mut right = [0.0; 10];
    let at: Vec<f64> = body.iter().copied().chain([x, xd, th, thd, xdd, thdd]).collect();
    g.eval(&at, &mut Vec::new(), &mut right);
    for k in 0..6 {
        assert_relative_eq!(left[k], right[k], max_relative = 1e-14);
    }
    assert_eq!(right[6..], [xd, xdd, thd, thdd]);
}

#[test]
fn a_function_of_the_input_becomes_the_input() {
    let s = model("x", "u", &[("x", "-x + x*u^2")]);
    let a = s.affinize().unwrap();
    assert_eq!(a.method, Method::InputChange);
    assert_eq!(a.system.pool.text(a.input_change[0].function), "u^2");
    assert_eq!(a.system.state_names(), ["x"]);
    assert_eq!(a.input_change[0].range().as_deref(), Some("v1 ≥ 0"));
    // Polar to Cartesian: two functions of two inputs.
    let s = model("x y", "v th", &[("x", "v*cos(th)"), ("y", "2*v*sin(th) - x")]);
    let a = s.affinize().unwrap();
    assert_eq!((a.method, a.input_change.len()), (Method::InputChange, 2));
    // One input enters as it is and keeps its name.
    let s = model("x y", "u w", &[("x", "u"), ("y", "x*exp(w)")]);
    let a = s.affinize().unwrap();
    assert_eq!(a.method, Method::InputChange);
    assert!(a.system.input_names().contains(&"u".to_owned()));
}

#[test]
fn two_functions_of_one_input_need_an_integrator() {
    let s = model("x y", "u", &[("x", "cos(u)"), ("y", "sin(u)")]);
    let a = s.affinize().unwrap();
    assert_eq!(a.method, Method::InputAugmentation);
    assert_eq!(a.system.state_names(), ["x", "y", "u"]);
    assert_eq!(a.system.input_names(), ["ud"]);
}

#[test]
fn only_the_inputs_that_need_it_get_integrators() {
    // u·w is bilinear: one integrator, in front of either, suffices.
    let s = model("x y z", "u w", &[("x", "u"), ("y", "w"), ("z", "u*w")]);
    let a = s.affinize().unwrap();
    assert_eq!(a.integrators.values().sum::<u32>(), 1);
    // The middle of a star of products is the cheapest.
    let star = [("x", "a*b"), ("y", "c*b"), ("z", "a"), ("p", "c"), ("q", "sin(b)")];
    let s = model("x y z p q", "a b c", &star);
    let a = s.affinize().unwrap();
    assert_eq!(a.integrators.keys().collect::<Vec<_>>(), ["b"]);
    // An input inside a switching function jumps the right-hand side: not affine.
    let s = model("x", "u", &[("x", "sign(u - x)")]);
    assert_eq!(s.affinize().unwrap().system.input_names(), ["ud"]);
}

#[test]
fn names_already_taken_are_avoided() {
    let s = model("x ud", "u", &[("x", "cos(u)"), ("ud", "sin(u)")]);
    assert_eq!(s.affinize().unwrap().system.input_names(), ["ud_"]);
}

#[test]
fn inputs_that_act_together_are_one_input() {
    let s = model("x y", "u w", &[("x", "(u + w)^2"), ("y", "x")]);
    let a = s.affinize().unwrap();
    assert_ne!(a.method, Method::None);
    assert!(a.system.affine_form().unwrap().is_some());
}

#[test]
fn functions_are_counted_over_the_constants_not_by_the_term() {
    // One function of one input, in two terms.
    let s = model("x", "u", &[("x", "2*u^3 + 2*sin(u) - x")]);
    let a = s.affinize().unwrap();
    assert_eq!((a.method, a.input_change.len()), (Method::InputChange, 1));
    assert_eq!(a.system.pool.text(a.system.dynamics[0]), "-x + 2*v1");
    // Two functions of two inputs, the second a sum.
    let s = model("x y", "u v", &[("x", "u*v"), ("y", "u + v")]);
    assert_eq!(s.affinize().unwrap().method, Method::InputChange);
    // Proportional combinations with different state factors are one function.
    let s = model("x y", "u", &[("x", "x*(u^2 + u)"), ("y", "y^2*(3*u + 3*u^2)")]);
    let a = s.affinize().unwrap();
    assert_eq!((a.method, a.input_change.len()), (Method::InputChange, 1));
    // Independent ones are two, and one input is not enough for them.
    let s = model("x y", "u", &[("x", "x*(u^2 + u)"), ("y", "y^2*(3*u + u^2)")]);
    assert_eq!(s.affinize().unwrap().method, Method::InputAugmentation);
}

#[test]
fn whether_the_new_inputs_are_free_at_the_point_is_told() {
    let at = |e: &str, u: &str| {
        let text = format!("states=['x']\ninputs=['u']\n[dynamics]\nx='{e}'\n[point]\nu='{u}'");
        System::parse("m", &text).unwrap().affinize().unwrap().regular_at_point
    };
    assert_eq!(at("u^2", "0"), Some(false));
    assert_eq!(at("u^2", "1"), Some(true));
    assert_eq!(at("exp(u)", "0"), Some(true));
    assert_eq!(at("sin(u)", "pi/2"), Some(false));
}

#[test]
fn jumps_of_an_input_are_left_to_integrators() {
    for e in ["sign(u)", "sign(u - x)", "u + sign(u)", "abs(u - x)"] {
        let a = model("x", "u", &[("x", e)]).affinize().unwrap();
        assert_eq!((a.method, a.system.input_names()), (Method::InputAugmentation, vec!["ud".to_owned()]), "{e}");
    }
}

#[test]
fn many_inputs_are_no_obstacle_where_few_multiply_each_other() {
    let names: Vec<String> = (0..30).map(|i| format!("u{i}")).collect();
    let states: Vec<String> = (0..30).map(|i| format!("x{i}")).collect();
    let mut equations: Vec<(&str, &str)> = states.iter().zip(&names).map(|(x, u)| (x.as_str(), u.as_str())).collect();
    equations.push(("y", "u3*u7 + sin(u5)"));
    let a = model(&(states.join(" ") + " y"), &names.join(" "), &equations).affinize().unwrap();
    assert_eq!(a.integrators.values().sum::<u32>(), 2);
}

#[test]
fn a_point_at_which_a_new_input_has_no_value_is_not_written() {
    for (e, u, finite) in [("1/u", "0", false), ("log(u)", "0", false), ("1/(u - 1)", "1", false), ("1/u", "2", true)] {
        let text = format!("states=['x']\ninputs=['u']\n[dynamics]\nx='{e}'\n[point]\nu='{u}'");
        let affine = System::parse("m", &text).unwrap().affinize().unwrap().system;
        assert_eq!(affine.point_is_finite(), finite, "{e} at {u}");
        let written = affine.to_toml().unwrap();
        assert_eq!(written.contains("[point]"), finite, "{written}");
        System::parse("written", &written).unwrap();
    }
}
