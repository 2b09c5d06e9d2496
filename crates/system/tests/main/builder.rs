//! Systems built by calls are those of model files, and so is what is refused.

use bracketry_system::{Builder, ModelError, System};

/// Everything that an analysis looks at, and the text.
fn same(built: &System, text: &str) {
    let read = System::parse(&built.name, text).unwrap();
    assert_eq!(built.to_toml().unwrap(), read.to_toml().unwrap());
    assert_eq!(format!("{built:?}"), format!("{read:?}"));
    assert_eq!((&built.states, &built.inputs, &built.parameters), (&read.states, &read.inputs, &read.parameters));
    assert_eq!((&built.input_ranges, &built.input_derivatives), (&read.input_ranges, &read.input_derivatives));
    let printed = |s: &System| -> Vec<(String, String)> {
        s.definitions.iter().map(|(name, e)| (name.clone(), s.pool.text(*e))).collect()
    };
    assert_eq!(printed(built), printed(&read));
    assert_eq!((built.point_values(), built.delay_values()), (read.point_values(), read.delay_values()));
    let (mut a, mut b) = (built.clone(), read.clone());
    let (a, b) = (a.set_valued_form(), b.set_valued_form());
    assert_eq!(a.set_valued_names(), b.set_valued_names());
    let at: Vec<f64> = (1..=built.arguments().len()).map(|k| 0.3 * k as f64).collect();
    let value = |s: &System| {
        let mut out = vec![0.0; s.dynamics.len()];
        s.compile(&s.arguments(), &s.dynamics).unwrap().eval(&at, &mut Vec::new(), &mut out);
        out
    };
    assert_eq!(value(built), value(&read));
}

#[test]
fn a_unicycle() {
    let b = System::builder("unicycle");
    let [x, y, th] = b.states(["x", "y", "th"]);
    let [u1, u2] = b.inputs(["u1", "u2"]);
    let (length, mu) = (b.parameter("L", 0.3), b.parameter("mu", 0.3));
    b.range(mu, 0.0..=1.0);
    b.describe(mu, "1", "friction coefficient");
    let k = b.define("k", 2 * length);
    b.dynamics(x, u1 * k * th.cos());
    b.dynamics(y, u1 * th.sin());
    b.dynamics(th, u2 - mu * th.sign());
    b.output("range2", (x.pow(2) + y.pow(2)) / 2);
    b.range(u1, -1.5..);
    b.point(x, 0.1);
    b.point(th, b.pi() / 2);
    same(
        &b.build().unwrap(),
        r#"
        states = ["x", "y", "th"]
        inputs = ["u1", "u2"]
        ranges = { u1 = { min = -1.5 } }
        definitions = { k = "2*L" }
        [parameters]
        L = 0.3
        mu = { value = 0.3, min = 0.0, max = 1.0, unit = "1", about = "friction coefficient" }
        [dynamics]
        x = "u1*k*cos(th)"
        y = "u1*sin(th)"
        th = "u2 - mu*sign(th)"
        [outputs]
        range2 = "(x^2 + y^2)/2"
        [point]
        x = 0.1
        th = "pi/2"
        "#,
    );
}

#[test]
fn a_block_with_dry_friction() {
    let b = System::builder("block");
    let [p, q, v, w] = b.states(["p", "q", "v", "w"]);
    let u = b.input("u");
    let (f, late) = (b.parameter("f", 3), b.parameter("late", 0.02));
    let [ex, ey] = b.unit([v, w]);
    b.dynamics(p, v);
    b.dynamics(q, w);
    b.dynamics(v, -f * ex + b.derivative(u, 2));
    b.dynamics(w, u - f * ey - v.abs().sqrt() * w.min(0.5));
    b.delay(u, 2 * late);
    b.static_level([v, w], 1.2);
    same(
        &b.build().unwrap(),
        r#"
        states = ["p", "q", "v", "w"]
        inputs = ["u"]
        parameters = { f = 3, late = 0.02 }
        delays = { u = "2*late" }
        static = { "v, w" = 1.2 }
        [dynamics]
        p = "v"
        q = "w"
        v = "-f*unit(v, w) + der(u, 2)"
        w = "u - f*unit(w, v) - sqrt(abs(v))*min(w, 0.5)"
        "#,
    );
}

#[test]
fn every_function_is_that_of_files() {
    let b = System::builder("all");
    let x = b.state("x");
    for (term, text) in [
        (x.sin(), "sin(x)"),
        (x.cos(), "cos(x)"),
        (x.tan(), "tan(x)"),
        (x.asin(), "asin(x)"),
        (x.acos(), "acos(x)"),
        (x.atan(), "atan(x)"),
        (x.sinh(), "sinh(x)"),
        (x.cosh(), "cosh(x)"),
        (x.tanh(), "tanh(x)"),
        (x.exp(), "exp(x)"),
        (x.ln(), "log(x)"),
        (x.abs(), "abs(x)"),
        (x.sign(), "sign(x)"),
        (x.sqrt(), "sqrt(x)"),
        (x.atan2(1), "atan2(x, 1)"),
        (x.min(2.5), "min(x, 2.5)"),
        (x.max(x + 1), "max(x, x + 1)"),
        (x.pow(-2), "1/x^2"),
        (2 / x - 0.1, "2/x - 0.1"),
        (1.5 - x, "-x + 1.5"),
        (-x * 3, "-3*x"),
        (b.formula("2*x^2"), "2*x^2"),
    ] {
        assert_eq!(term.to_string(), text);
        assert_eq!(b.formula(text).to_string(), text);
    }
}

/// What is wrong with a system of the state x and the input u.
fn refused(wrong: impl FnOnce(&Builder)) -> ModelError {
    let b = System::builder("m");
    let (x, u) = (b.state("x"), b.input("u"));
    b.dynamics(x, u);
    wrong(&b);
    b.build().unwrap_err()
}

#[test]
fn what_is_wrong_is_named_with_its_remedy() {
    let b = System::builder("m");
    let (x, _) = (b.state("x"), b.state("y"));
    b.dynamics(x, 1);
    assert!(b.build().unwrap_err().message.contains("missing equation: state `y`"));
    assert!(System::builder("m").build().unwrap_err().message.contains("no states"));

    let unknown = refused(|b| b.output("o", b.formula("u3*x")));
    assert!(unknown.message.contains("unknown name `u3`"), "{unknown}");
    let near = refused(|b| {
        b.parameter("mass", 1);
        b.output("o", b.formula("masss*x"));
    });
    assert_eq!(near.remedy, "did you mean `mass`?");
    for (error, message) in [
        (refused(|b| b.dynamics(b.formula("u"), 1)), "surplus equation: `u` is not a state"),
        (refused(|b| b.dynamics(b.formula("x"), 1)), "surplus equation: `x` has one already"),
        (refused(|b| b.dynamics(b.formula("2*x"), 1)), "surplus equation: `2*x` is not a state"),
        (
            refused(|b| {
                b.state("u");
            }),
            "state `u` is already declared as a input",
        ),
        (
            refused(|b| {
                b.parameter("pi", 3);
            }),
            "`pi` is reserved",
        ),
        (
            refused(|b| {
                b.input("2u");
            }),
            "`2u` is not a name",
        ),
        (
            refused(|b| {
                b.parameter("m", f64::NAN);
            }),
            "NaN is not a number of a model",
        ),
        (refused(|b| b.range(b.parameter("m", 3), ..=2.0)), "parameter `m` lies outside its own min…max"),
        (refused(|b| b.range(b.formula("u"), 1.0..=1.0)), "the range of `u` is empty or a single value"),
        (refused(|b| b.range(b.formula("x"), 0.0..)), "`x` is neither an input nor a parameter"),
        (refused(|b| b.point(b.formula("x"), b.formula("u"))), "the value of `x` at the point is not constant"),
        (refused(|b| b.delay(b.formula("u"), -1)), "the delay of `u` is not a valid time"),
        (refused(|b| b.static_level([b.formula("x")], 2)), "no dry friction acts on `x`"),
        (
            refused(|b| {
                b.derivative(b.formula("x"), 1);
            }),
            "`x` is not an input with a derivative of order 1",
        ),
        (refused(|b| b.output("o", b.formula("x +"))), "`x +`: the expression ends too early"),
    ] {
        assert_eq!(error.message, message);
        assert!(!error.remedy.is_empty());
    }
}

#[test]
#[should_panic(expected = "two builders")]
fn terms_of_two_builders_are_not_combined() {
    let (a, b) = (System::builder("a"), System::builder("b"));
    let _ = a.state("x") + b.state("x");
}
