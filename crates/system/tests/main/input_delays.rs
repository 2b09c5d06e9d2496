//! Delays of inputs in model files, and what becomes of them when a model is made affine.

use bracketry_system::System;

fn parse(rest: &str) -> Result<System, String> {
    let text = format!("states = [\"x\", \"v\"]\ninputs = [\"F\", \"X\"]\nparameters = {{ d = 0.01, m = 2 }}\n{rest}");
    System::parse("model.toml", &text).map_err(|e| e.to_string())
}

#[test]
fn delays_are_read_and_written() {
    let dynamics = "[dynamics]\nx = \"v\"\nv = \"F/m + X\"\n";
    let system = parse(&format!("{dynamics}[delays]\nF = 0.0007\nX = \"2*d\"")).unwrap();
    assert_eq!(system.delay_values(), [Some(0.0007), Some(0.02)]);
    let written = system.to_toml().unwrap();
    assert!(written.contains("F = 0.0007") && written.contains("X = \"2*d\""), "{written}");
    let mut again = System::parse("again.toml", &written).unwrap();
    assert_eq!(again.delay_values(), system.delay_values());
    assert!(again.set_parameter("d", bracketry_symbolic::Rational::from(3i64)));
    assert_eq!(again.delay_values(), [Some(0.0007), Some(6.0)]);
    let without = parse(dynamics).unwrap();
    assert_eq!(without.delay_values(), [Some(0.0), Some(0.0)]);
    assert!(!without.to_toml().unwrap().contains("delays"));
}

#[test]
fn delays_without_meaning_are_refused_with_place_and_remedy() {
    for (delay, parts) in [
        ("G = 0.1", ["model.toml:8:1", "`G` is not an input", "F, X"]),
        ("F = -0.1", ["model.toml:8:5", "not a valid time", "at least 0"]),
        ("F = \"x\"", ["model.toml:8:6", "x", "="]),
        ("F = true", ["model.toml:8:5", "`F`", "quotes"]),
    ] {
        let message = parse(&format!("[dynamics]\nx = \"v\"\nv = \"F + X\"\n[delays]\n{delay}")).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "no `{part}` in: {message}");
        }
    }
}

#[test]
fn integrators_and_functions_of_inputs_keep_the_delay() {
    let delays = "[delays]\nF = 0.5\nX = 0.25";
    let delays_of = |dynamics: &str| {
        let system = parse(&format!("[dynamics]\n{dynamics}\n{delays}")).unwrap();
        let affine = system.affinize().unwrap();
        let names = affine.system.input_names();
        let values = affine.system.delay_values();
        let named: Vec<(String, Option<f64>)> = names.into_iter().zip(values).collect();
        (named, affine.why.to_string())
    };
    // As it stands.
    let (named, _) = delays_of("x = \"v\"\nv = \"F + X\"");
    assert_eq!(named, [("F".into(), Some(0.5)), ("X".into(), Some(0.25))]);
    // Two integrators in front of X.
    let (named, _) = delays_of("x = \"v + X\"\nv = \"F + der(X, 2)\"");
    assert_eq!(named.iter().find(|(name, _)| name == "Xdd").unwrap().1, Some(0.25), "{named:?}");
    // A new input in the place of F².
    let (named, why) = delays_of("x = \"X\"\nv = \"F^3\"");
    assert!(named.iter().any(|(_, delay)| *delay == Some(0.5)), "{named:?} {why}");
    // A function of both inputs has no one delay, and that is said.
    let (named, why) = delays_of("x = \"v\"\nv = \"exp(F*X)\"");
    assert!(
        named.iter().all(|(_, delay)| *delay == Some(0.0)) && why.contains("after their delays"),
        "{named:?} {why}"
    );
}
