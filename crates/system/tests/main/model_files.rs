//! Model files: what they say is what is computed, and what is wrong is named with its place.

use approx::assert_relative_eq;
use bracketry_symbolic::Bindings;
use bracketry_system::{SwitchKind, System};

const UNICYCLE: &str = r#"
name = "unicycle"
states = ["x", "y", "th"]
inputs = ["u1", "u2"]
[parameters]
L = 0.3
mu = { value = 0.3, min = 0.0, max = 1.0, unit = "1", about = "friction coefficient" }
[definitions]
c = "k*cos(th)"
k = "2*L"
[dynamics]
x = "u1*c"
y = "u1*sin(th)"
th = "u2 - mu*sign(th)"
[outputs]
range2 = "(x^2 + y^2)/2"
[point]
x = 0.1
th = "pi/2"
"#;

fn values(system: &mut System, at: &[f64]) -> Vec<f64> {
    let arguments = system.arguments();
    let f = system.dynamics.clone();
    let tape = system.compile(&arguments, &f).unwrap();
    let mut out = vec![0.0; f.len()];
    tape.eval(at, &mut Vec::new(), &mut out);
    out
}

#[test]
fn definitions_and_parameters_are_expanded() {
    let mut s = System::parse("m", UNICYCLE).unwrap();
    let v = values(&mut s, &[0.0, 0.0, 0.7, 2.0, 0.5]);
    assert_relative_eq!(v[0], 2.0 * 0.6 * 0.7f64.cos(), max_relative = 1e-15);
    assert_relative_eq!(v[2], 0.5 - 0.3, max_relative = 1e-15);
}

#[test]
fn writing_and_reading_back_keeps_the_right_hand_side() {
    let mut a = System::parse("m", UNICYCLE).unwrap();
    let mut b = System::parse("again", &a.to_toml().unwrap()).unwrap();
    assert_eq!((a.state_names(), a.input_names()), (b.state_names(), b.input_names()));
    let at = [0.3, -1.2, 0.7, 2.0, 0.5];
    assert_eq!(values(&mut a, &at), values(&mut b, &at));
    assert_eq!(b.parameters[1].about.as_deref(), Some("friction coefficient"));
}

#[test]
fn switches_are_found_once_each_with_their_kind() {
    let mut s = System::parse(
        "m",
        r#"states=["v","z"]
           inputs=["u"]
           [dynamics]
           v = "u - sign(v)*(1 + exp(-abs(v)))"
           z = "max(z, v) - sign(-v)""#,
    )
    .unwrap();
    let form = s.switched_form();
    let found: Vec<(&str, SwitchKind)> = form.switches.iter().map(|s| (s.name.as_str(), s.kind)).collect();
    assert_eq!(found.len(), 2);
    assert!(found.contains(&("v", SwitchKind::Jump)));
    assert_eq!(found[1].1, SwitchKind::Kink);
}

#[test]
fn each_mode_equals_the_original_where_the_signs_hold() {
    let text = r#"states=["v","z"]
        inputs=["u"]
        [dynamics]
        v = "u - sign(v)*(1 + exp(-abs(v)))"
        z = "max(z, v)*min(v, 2*z) - sign(z)*abs(v-z)""#;
    let mut original = System::parse("m", text).unwrap();
    let points = [[0.3, 0.9, 0.1], [-0.3, 0.9, 0.1], [0.3, -0.9, 0.1], [-1.3, -0.9, 0.1], [2.0, 0.5, 1.0]];
    let modes = original.modes().unwrap();
    for at in points {
        let expected = values(&mut original, &at);
        let mut hits = 0;
        for m in &modes {
            let agrees = m.signs.iter().all(|(name, sign)| {
                let mut p = bracketry_system::symbolic::Pool::new();
                let e = p.parse(name).unwrap();
                let args = [p.symbol("v"), p.symbol("z")];
                let tape = bracketry_system::symbolic::Tape::compile(&p, &args, &[e]).unwrap();
                let mut out = [0.0];
                tape.eval(&at[..2], &mut Vec::new(), &mut out);
                out[0].signum() == f64::from(*sign)
            });
            if agrees {
                hits += 1;
                let mut system = m.system.clone();
                let got = values(&mut system, &at);
                for (g, e) in got.iter().zip(&expected) {
                    assert_relative_eq!(g, e, max_relative = 1e-14);
                }
            }
        }
        assert_eq!(hits, 1, "exactly one mode holds at {at:?}");
    }
}

#[test]
fn smoothing_converges_to_the_signs() {
    let mut s = System::parse("m", UNICYCLE).unwrap();
    let exact = values(&mut s, &[0.0, 0.0, 0.7, 2.0, 0.5]);
    let width = s.pool.ratio(1, 1000);
    let mut smooth = s.smoothed(width);
    let v = values(&mut smooth, &[0.0, 0.0, 0.7, 2.0, 0.5]);
    assert_relative_eq!(v[2], exact[2], max_relative = 1e-12);
    let v = values(&mut smooth, &[0.0, 0.0, 1e-4, 2.0, 0.5]);
    assert_relative_eq!(v[2], 0.5 - 0.3 * 0.1f64.tanh(), max_relative = 1e-12);
}

/// (what, text, line, offending text, part of the message)
const BAD: &[(&str, &str, usize, &str, &str)] = &[
    ("not TOML", "states = [\"x\"\n[dynamics]\nx=\"0\"", 2, "", ""),
    ("unknown key", "states=[\"x\"]\n[dynamic]\nx=\"0\"", 2, "dynamic", "unknown key"),
    ("no states", "[dynamics]\nx=\"0\"", 0, "", "no states"),
    ("states not a list", "states=\"x\"\n[dynamics]\nx=\"0\"", 1, "\"x\"", "must be a list"),
    ("a state that is a number", "states=[1]\n[dynamics]\nx=\"0\"", 1, "1", "names in quotes"),
    ("duplicate state", "states=[\"x\",\"x\"]\n[dynamics]\nx=\"0\"", 1, "\"x\"", "already declared"),
    (
        "input called like a state",
        "states=[\"x\"]\ninputs=[\"x\"]\n[dynamics]\nx=\"0\"",
        2,
        "\"x\"",
        "already declared as a state",
    ),
    ("malformed name", "states=[\"2x\"]\n[dynamics]\nx=\"0\"", 1, "\"2x\"", "not a name"),
    ("reserved name", "states=[\"sin\"]\n[dynamics]\nsin=\"0\"", 1, "\"sin\"", "reserved"),
    ("no equations", "states=[\"x\"]", 0, "", "no equations"),
    ("missing equation", "states=[\"x\",\"y\"]\n[dynamics]\nx=\"0\"", 1, "\"y\"", "missing equation: state `y`"),
    ("surplus equation", "states=[\"x\"]\n[dynamics]\nx=\"0\"\ny=\"1\"", 4, "y", "surplus equation"),
    ("unknown name", "states=[\"vx\"]\n[dynamics]\nvx=\"-2*vy\"", 3, "vy", "unknown name `vy`"),
    ("unknown function", "states=[\"x\"]\n[dynamics]\nx=\"sen(x)\"", 3, "sen", "unknown function"),
    ("syntax error", "states=[\"x\"]\n[dynamics]\nx=\"x + * 2\"", 3, "*", "operand is missing"),
    ("open parenthesis", "states=[\"x\"]\n[dynamics]\nx=\"(x + 2\"", 3, "", "expected `)`"),
    ("implicit product", "states=[\"x\"]\n[dynamics]\nx=\"2x\"", 3, "2x", "number is directly followed by a name"),
    ("wrong number of arguments", "states=[\"x\"]\n[dynamics]\nx=\"atan2(x)\"", 3, "atan2", "takes 2 arguments"),
    ("division by zero", "states=[\"x\"]\n[dynamics]\nx=\"1/(2-2)\"", 3, "(", "division by zero"),
    (
        "cyclic definition",
        "states=[\"x\"]\n[definitions]\na=\"b\"\nb=\"a+1\"\n[dynamics]\nx=\"a\"",
        3,
        "a",
        "cyclic definition: a → b → a",
    ),
    ("definition of itself", "states=[\"x\"]\n[definitions]\na=\"a+1\"\n[dynamics]\nx=\"a\"", 3, "a", "cyclic"),
    (
        "parameter that is text",
        "states=[\"x\"]\n[parameters]\nm=\"one\"\n[dynamics]\nx=\"m\"",
        3,
        "\"one\"",
        "must be a number",
    ),
    ("NaN parameter", "states=[\"x\"]\n[parameters]\nm=nan\n[dynamics]\nx=\"m\"", 3, "nan", "not a finite number"),
    ("infinite parameter", "states=[\"x\"]\n[parameters]\nm=inf\n[dynamics]\nx=\"m\"", 3, "inf", "not a finite number"),
    (
        "parameter without value",
        "states=[\"x\"]\n[parameters]\nm={unit=\"kg\"}\n[dynamics]\nx=\"m\"",
        3,
        "m",
        "has no value",
    ),
    (
        "parameter outside its bounds",
        "states=[\"x\"]\n[parameters]\nm={value=3,max=2}\n[dynamics]\nx=\"m\"",
        3,
        "m",
        "outside its own",
    ),
    (
        "bounds exchanged",
        "states=[\"x\"]\n[parameters]\nm={value=3,min=4,max=2}\n[dynamics]\nx=\"m\"",
        3,
        "m",
        "min above max",
    ),
    (
        "unknown key of a parameter",
        "states=[\"x\"]\n[parameters]\nm={valu=3}\n[dynamics]\nx=\"m\"",
        3,
        "valu",
        "unknown key",
    ),
    ("derivative of a state", "states=[\"x\"]\n[dynamics]\nx=\"der(x)\"", 3, "x", "is not an input"),
    (
        "order of a derivative",
        "states=[\"x\"]\ninputs=[\"u\"]\n[dynamics]\nx=\"der(u, 0)\"",
        4,
        "0",
        "order of a derivative",
    ),
    (
        "point with an unknown name",
        "states=[\"x\"]\n[dynamics]\nx=\"0\"\n[point]\nz=1",
        5,
        "z",
        "neither a state nor an input",
    ),
    (
        "point that is not a number",
        "states=[\"x\"]\n[dynamics]\nx=\"0\"\n[point]\nx=true",
        5,
        "true",
        "must be an expression",
    ),
    ("equation that is a list", "states=[\"x\"]\n[dynamics]\nx=[1]", 3, "[1]", "must be an expression"),
    (
        "output with an unknown name",
        "states=[\"x\"]\n[dynamics]\nx=\"0\"\n[outputs]\ny=\"2*q\"",
        5,
        "q",
        "unknown name",
    ),
    ("dynamics that is text", "states=[\"x\"]\ndynamics=\"x\"", 2, "\"x\"", "must be a table"),
    ("empty expression", "states=[\"x\"]\n[dynamics]\nx=\"\"", 3, "", "empty"),
    ("foreign character", "states=[\"x\"]\n[dynamics]\nx=\"x # 2\"", 3, "#", "not part of an expression"),
    ("number out of range", "states=[\"x\"]\n[dynamics]\nx=\"1e999\"", 3, "1e999", "out of range"),
];

#[test]
fn every_kind_of_bad_model_names_place_text_and_remedy() {
    for (what, text, line, found, message) in BAD {
        let e = System::parse("bad.toml", text).expect_err(what);
        assert_eq!(e.line, *line, "{what}: {e}");
        assert_eq!(e.found, *found, "{what}: {e}");
        assert!(e.message.contains(message), "{what}: {e}");
        assert!(!e.remedy.is_empty(), "{what}");
        let shown = e.to_string();
        assert!(shown.starts_with("bad.toml"), "{what}: {shown}");
        if *line > 0 {
            assert!(shown.contains(&format!("bad.toml:{line}:{}", e.column)), "{what}: {shown}");
        }
    }
}

#[test]
fn a_misspelt_name_is_answered_with_the_right_one() {
    let e = System::parse("m", "states=[\"theta\"]\n[dynamics]\ntheta=\"cos(thet)\"").unwrap_err();
    assert_eq!((e.line, e.column), (3, 12));
    assert!(e.remedy.contains("`theta`"));
}

#[test]
fn unreadable_files_are_named() {
    let e = System::read("no/such/model.toml").unwrap_err();
    assert!(e.to_string().contains("no/such/model.toml") && e.message.contains("cannot be read"));
}

#[test]
fn input_derivatives_are_arguments_of_the_published_plate() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/plate_published.toml");
    let mut s = System::read(path).unwrap();
    let order: Vec<(usize, u32)> = s.input_derivatives.iter().map(|d| (d.input, d.order)).collect();
    assert_eq!(order, [(0, 2), (1, 2)]);
    let (theta, tdd, xdd) = (0.2, 3.0, 1.5);
    let at = [0.0, -0.03, 0.4, 0.1, -0.2, 0.0, 0.0, theta, xdd, tdd];
    let v = values(&mut s, &at);
    assert_relative_eq!(v[3], -xdd - 0.3 * 9.81, max_relative = 1e-14);
    let vy = -9.81 * theta.sin() + 0.3 * (9.81 * theta.cos() - 0.03 * tdd);
    assert_relative_eq!(v[4], vy, max_relative = 1e-14);
    let (sa, sb) = (0.15f64.powi(2) / 4.0, 0.01 / 4.0);
    let syy = 0.4f64.sin().powi(2) * sa + 0.4f64.cos().powi(2) * sb;
    assert_relative_eq!(v[5], -0.3 * syy * tdd / (sa + sb), max_relative = 1e-14);
}

#[test]
fn a_model_may_call_something_t_and_says_so() {
    let kind = |text: &str| System::parse("m", text).unwrap().declares_time();
    assert_eq!(kind("states = ['t', 'x']\n[dynamics]\nt = '1'\nx = 't*x'"), Some("state"));
    assert_eq!(kind("states = ['x']\ninputs = ['t']\n[dynamics]\nx = 't'"), Some("input"));
    assert_eq!(kind("states = ['x']\n[parameters]\nt = 1\n[dynamics]\nx = 't'"), Some("parameter"));
    assert_eq!(kind("states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u'"), None);
}

#[test]
fn a_message_stays_short_whatever_it_speaks_of() {
    let long = "x".repeat(100_000);
    let text = format!("states = [\"{long}\", \"{long}\"]\ninputs = []\n[dynamics]\n{long} = 1\n");
    let message = System::parse("long.toml", &text).unwrap_err().to_string();
    assert!(
        message.contains("long.toml:1:") && message.chars().count() < 2500,
        "{} characters",
        message.chars().count()
    );
}

#[test]
fn parameters_are_exact_constants() {
    let text = "states = ['x']\n[parameters]\na = '1/3'\nb = 'sqrt(2)'\nc = { value = '2*0.35', max = 1 }\nd = 'atan(1)'\n\
                [dynamics]\nx = 'a*b^2 + c*cos(d)'";
    let mut s = System::parse("m.toml", text).unwrap();
    let values: Vec<String> = s.parameters.iter().map(|p| p.value.to_string()).collect();
    assert_eq!(values, ["1/3", "7/10"]);
    let names: Vec<&str> = s.definitions.iter().map(|d| d.0.as_str()).collect();
    assert_eq!(names, ["b", "d"]);
    let expected = s.pool.parse("2*a/3*3 + c*sqrt(2)/2").unwrap();
    let difference = s.pool.sub(s.dynamics[0], expected);
    assert!(s.pool.zero_test(difference, &Bindings::new()).is_zero());
    let written = s.to_toml().unwrap();
    let mut again = System::parse("m.toml", &written).unwrap();
    assert_eq!(again.parameters[0].value, s.parameters[0].value, "{written}");
    let expected = again.pool.parse("2*a/3*3 + c*sqrt(2)/2").unwrap();
    let difference = again.pool.sub(again.dynamics[0], expected);
    assert!(again.pool.zero_test(difference, &Bindings::new()).is_zero(), "{written}");
    for (text, part) in [
        ("'1/0'", "must be a number"),
        ("'sqrt(-2)'", "not a finite real number"),
        ("{ value = 'sqrt(2)', unit = 'm' }", "irrational"),
    ] {
        let text = format!("states = ['x']\n[parameters]\na = {text}\n[dynamics]\nx = 'a'");
        let error = System::parse("m.toml", &text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn names_of_other_languages_have_a_remedy() {
    for (expression, remedy) in [
        ("sgn(x)", "`sign("),
        ("ln(x)", "`log("),
        ("cot(x)", "`1/tan("),
        ("e^x", "`exp(1)`"),
        ("Pi*x", "`pi`"),
        ("t*x", "equations do not depend on time"),
        ("if(x, 1, 0)", "`min`, and `max`"),
        ("arctan(x)", "`atan("),
        ("log10(x)", "log(10)"),
    ] {
        let text = format!("states = ['x']\n[dynamics]\nx = '{expression}'");
        let error = System::parse("m.toml", &text).unwrap_err().to_string();
        assert!(error.contains(remedy), "{error}");
    }
    // A name of the model that differs in case comes first.
    let error = System::parse("m.toml", "states = ['x']\ninputs = ['T']\n[dynamics]\nx = 't'").unwrap_err().to_string();
    assert!(error.contains("did you mean `T`?"), "{error}");
}

#[test]
fn a_fixed_parameter_has_no_other_value() {
    let read =
        |entry: &str| System::parse("m", &format!("states = ['x']\n[parameters]\nk = {entry}\n[dynamics]\nx = '-k*x'"));
    let system = read("{ value = 0.3, fixed = true }").unwrap();
    let again = System::parse("m", &system.to_toml().unwrap()).unwrap();
    assert!(system.parameters[0].is_fixed() && again.parameters[0].is_fixed());
    assert!(system.to_toml().unwrap().contains("fixed = true"));
    assert!(!read("{ value = 0.3, fixed = false }").unwrap().parameters[0].is_fixed());
    assert!(!read("0.3").unwrap().parameters[0].is_fixed());
    for (entry, message) in [
        ("{ value = 0.3, fixed = true, max = 1 }", "`k` is fixed and has bounds"),
        ("{ value = 0.3, fixed = 1 }", "`fixed` of parameter `k` must be true or false"),
    ] {
        let error = read(entry).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
