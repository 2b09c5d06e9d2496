//! Mass matrices and algebraic equations: what they are solved for is the ordinary system, and what cannot be solved is told.

use approx::assert_relative_eq;
use bracketry_system::{Accepted, Eliminated, System};
use proptest::prelude::*;

fn values(system: &System, at: &[f64]) -> Vec<f64> {
    let tape = system.compile(&system.arguments(), &system.dynamics).unwrap();
    let mut out = vec![0.0; system.dynamics.len()];
    tape.eval(at, &mut Vec::new(), &mut out);
    out
}

const CART: &str = r#"
states = ["x", "th", "v", "w"]
inputs = ["F"]
parameters = { M = 1.3, m = 0.4, l = 0.7, g = 9.81 }
[mass]
states = ["v", "w"]
matrix = [["M + m", "m*l*cos(th)"], ["m*l*cos(th)", "m*l^2"]]
[dynamics]
x = "v"
th = "w"
v = "F + m*l*w^2*sin(th)"
w = "m*g*l*sin(th)"
"#;

#[test]
fn a_pendulum_on_a_cart_by_its_mass_matrix_has_the_explicit_equations() {
    // (M + m) v' + m l cos(th) w' = F + m l w² sin(th), m l cos(th) v' + m l² w' = m g l sin(th), solved by hand.
    let cart = System::parse("cart", CART).unwrap();
    let (big, m, l, g) = (1.3, 0.4, 0.7, 9.81);
    for (th, w, force) in [(0.3f64, -1.2f64, 2.0f64), (std::f64::consts::FRAC_PI_2, 0.5, -1.0), (2.8, 3.0, 0.0)] {
        let f = values(&cart, &[0.1, th, 0.4, w, force]);
        let v = (force + m * l * w * w * th.sin() - m * g * th.sin() * th.cos()) / (big + m * th.sin().powi(2));
        assert_relative_eq!(f[2], v, max_relative = 1e-12);
        assert_relative_eq!(f[3], (g * th.sin() - th.cos() * v) / l, max_relative = 1e-12);
        assert_eq!(f[..2], [0.4, w]);
    }
    assert_eq!(cart.eliminated, [Eliminated::MassMatrix { states: vec!["v".into(), "w".into()] }]);
}

/// An n × n matrix of numbers and the same as rows of text.
fn matrix(entries: &[f64], n: usize) -> String {
    let row = |i: usize| {
        let row: Vec<String> = entries[i * n..(i + 1) * n].iter().map(|v| format!("\"{v:?}*p\"")).collect();
        format!("[{}]", row.join(", "))
    };
    format!("[{}]", (0..n).map(row).collect::<Vec<_>>().join(", "))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_solved_rates_satisfy_the_equations_with_the_mass_matrix(
        n in 1usize..6,
        entries in prop::collection::vec(-1.0f64..1.0, 25),
        x in prop::collection::vec(-2.0f64..2.0, 5),
    ) {
        let mut mass = entries[..n * n].to_vec();
        // Diagonally dominant, so that it is far from singular.
        (0..n).for_each(|i| mass[i * n + i] += 6.0);
        let names: Vec<String> = (0..n).map(|i| format!("x{i}")).collect();
        let right = |i: usize| format!("x{i} = \"sin(x{}) + p*u*x{i}\"", (i + 1) % n);
        let text = format!(
            "states = {names:?}\ninputs = ['u']\nparameters = {{ p = 1.5 }}\nmass = {}\n[dynamics]\n{}",
            matrix(&mass, n),
            (0..n).map(right).collect::<Vec<_>>().join("\n")
        );
        let system = System::parse("random", &text).unwrap();
        let mut at = x[..n].to_vec();
        at.push(0.7);
        let rates = values(&system, &at);
        for i in 0..n {
            let left: f64 = (0..n).map(|j| 1.5 * mass[i * n + j] * rates[j]).sum();
            prop_assert!((left - (x[(i + 1) % n].sin() + 1.5 * 0.7 * x[i])).abs() < 1e-10);
        }
    }

    #[test]
    fn eliminated_variables_satisfy_their_equations(
        k in 1usize..5,
        a in prop::collection::vec(-1.0f64..1.0, 16),
        x in prop::collection::vec(-2.0f64..2.0, 3),
    ) {
        // (A + 5 + x²) z = b(x, u), then y1 − z0² = x, which is linear in y1 alone.
        let residual = |i: usize| {
            let sum: Vec<String> = (0..k).map(|j| format!("({:?}{})*z{j}", a[i * k + j], if i == j { " + 5 + x^2" } else { "" })).collect();
            format!("z{i} = \"{} - sin(x) - {i}*u\"", sum.join(" + "))
        };
        let algebraic: Vec<String> = (0..k).map(residual).collect();
        let out: Vec<String> = (0..k).map(|i| format!("o{i} = \"z{i}\"")).collect();
        let text = format!(
            "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'y1 + z0'\n[algebraic]\ny1 = 'y1 - z0^2 - x'\n{}\n[outputs]\n{}",
            algebraic.join("\n"), out.join("\n")
        );
        let system = System::parse("random", &text).unwrap();
        prop_assert_eq!(system.eliminated.len(), k + 1);
        let outputs: Vec<_> = system.outputs.iter().map(|o| o.1).chain(system.dynamics.clone()).collect();
        let tape = system.compile(&system.arguments(), &outputs).unwrap();
        let mut z = vec![0.0; k + 1];
        tape.eval(&[x[0], x[1]], &mut Vec::new(), &mut z);
        for i in 0..k {
            let diagonal = 5.0 + x[0] * x[0];
            let left: f64 = (0..k).map(|j| (a[i * k + j] + if i == j { diagonal } else { 0.0 }) * z[j]).sum();
            prop_assert!((left - x[0].sin() - i as f64 * x[1]).abs() < 1e-10);
        }
        prop_assert!((z[k] - (z[0] * z[0] + x[0] + z[0])).abs() < 1e-10);
    }
}

#[test]
fn a_pivot_that_vanishes_somewhere_adds_no_singularity() {
    // det = −1 everywhere, while both entries that could serve as first pivot vanish at x = 0.
    let text = "states = ['x', 'y']\nmass = [['x', 1], [1, 'x']]\ndynamics = { x = 'y', y = 2 }";
    let f = values(&System::parse("m", text).unwrap(), &[0.0, 3.0]);
    assert_eq!(f, [2.0, 3.0]);
    let text =
        "states = ['x']\nalgebraic = { a = 'sin(x)*a + b - 1', b = 'a + sin(x)*b - 2' }\ndynamics = { x = 'a + 10*b' }";
    assert_eq!(values(&System::parse("m", text).unwrap(), &[0.0]), [12.0]);
}

fn refusal(text: &str) -> String {
    System::parse("m.toml", text).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_solved_is_refused_with_its_place() {
    let index = refusal("states = ['x']\ninputs = ['u']\ndynamics = { x = 'z' }\n[algebraic]\nz = 'x - u'");
    assert!(
        index.contains("index above 1") && index.contains("m.toml:5:5") && index.contains("differentiate"),
        "{index}"
    );
    // Dependent only by an identity.
    let identity = "states = ['x']\ndynamics = { x = 'a + b' }\n[algebraic]\na = 'a + b - x'\nb = '(sin(x)^2 + cos(x)^2)*a + b - 1'";
    assert!(refusal(identity).contains("m.toml:5:5"), "{}", refusal(identity));
    let curved = refusal("states = ['x']\ndynamics = { x = '-z' }\n[algebraic]\nz = 'z + z^3 - x'");
    assert!(curved.contains("not linear") && curved.contains("m.toml:4:5"), "{curved}");
    // The derivative of a sign is 0, but it is not constant.
    assert!(
        refusal("states = ['x']\ndynamics = { x = '-z' }\n[algebraic]\nz = 'z + sign(z) - x'").contains("not linear")
    );
    let mass = refusal("states = ['x', 'y']\nmass = [[1, 0], [0, 0]]\ndynamics = { x = 'y', y = 'x - y' }");
    assert!(mass.contains("singular") && mass.contains("m.toml:2:17") && mass.contains("[algebraic]"), "{mass}");
    let short = refusal("states = ['x', 'y']\nmass = [[1, 0]]\ndynamics = { x = 'y', y = 'x - y' }");
    assert!(short.contains("must be a list of 2 rows"), "{short}");
    let unknown =
        refusal("states = ['x', 'y']\nmass = { states = ['z'], matrix = [[1]] }\ndynamics = { x = 'y', y = 'x' }");
    assert!(unknown.contains("`z` is not a state"), "{unknown}");
    let twice = refusal("states = ['x']\ndynamics = { x = 'x' }\nalgebraic = { x = 'x - 1' }");
    assert!(twice.contains("already declared"), "{twice}");
}

#[test]
fn what_is_accepted_beyond_that_is_kept_and_written() {
    let text = "states = ['x']\ndynamics = { x = '-z - y' }\n[algebraic]\ny = 'y - z^2'\nz = { equation = 'z + z^3 - x', guess = 0.5 }";
    let accepted = Accepted { algebraic: true, ..Accepted::default() };
    let system = System::parse_accepting("m", text, accepted).unwrap();
    assert_eq!(system.algebraic.len(), 1);
    assert_eq!(system.eliminated, [Eliminated::Variable { name: "y".into() }]);
    let again = System::parse_accepting("m", &system.to_toml().unwrap(), accepted).unwrap();
    assert_eq!(again.pool.text(again.algebraic[0].residual), system.pool.text(system.algebraic[0].residual));
    let discrete = "time = 'discrete'\nperiod = 0.25\nstates = ['x']\ndynamics = { x = '0.5*x' }";
    assert!(refusal(discrete).contains("m.toml:1:8"));
    let accepted = Accepted { discrete: true, ..Accepted::default() };
    let system = System::parse_accepting("m", discrete, accepted).unwrap();
    let again = System::parse_accepting("m", &system.to_toml().unwrap(), accepted).unwrap();
    assert_eq!((system.period, again.period), (Some(0.25), Some(0.25)));
    for (wrong, said) in [
        ("time = 'discrete'\nstates = ['x']\ndynamics = { x = 'x' }", "needs its `period`"),
        ("time = 'discrete'\nperiod = 0\nstates = ['x']\ndynamics = { x = 'x' }", "must be positive"),
        ("period = 0.1\nstates = ['x']\ndynamics = { x = 'x' }", "no `period`"),
        (
            "time = 'discrete'\nperiod = 1\nstates = ['x']\ninputs = ['u']\ndynamics = { x = 'der(u)' }",
            "does not exist",
        ),
        (
            "time = 'discrete'\nperiod = 1\nstates = ['x']\ninputs = ['u']\ndelays = { u = 1 }\ndynamics = { x = 'u' }",
            "`delays`",
        ),
    ] {
        let error = System::parse_accepting("m", wrong, accepted).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
