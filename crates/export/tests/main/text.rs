//! What stands in exported files, and what is refused.

use bracketry_export::{ExportNote, ExportOptions, KeptParameters, Target, export};
use bracketry_symbolic::Tape;
use bracketry_system::System;

const BLOCK: &str = "name = 'Block on a belt'\nstates = ['q', 'v', 'w']\ninputs = ['u']\n\
    parameters = { Td = 0.05, m = { value = 2, unit = 'kg', about = 'mass */ of it' }, c = 0.4 }\n\
    ranges = { u = { min = -3, max = 4 } }\ndelays = { u = 'Td + 0.1' }\nstatic = { 'v - 1' = 1.2 }\n\
    dynamics = { q = 'v', v = '(u + der(u) - c*sign(v - 1) - abs(q))/m', w = '-unit(w, v)' }\n";

fn block() -> System {
    System::parse("block.toml", BLOCK).unwrap()
}

#[test]
fn nothing_that_a_function_cannot_say_is_left_unsaid() {
    let made = export(&block(), &ExportOptions::new(Target::C)).unwrap();
    let kinds: Vec<&str> = made
        .notes
        .iter()
        .map(|n| match n {
            ExportNote::SetValued { .. } => "set-valued",
            ExportNote::Kinks => "kinks",
            ExportNote::InputDelay { .. } => "delay",
            ExportNote::InputDerivatives { .. } => "derivatives",
            ExportNote::StaticLevel { .. } => "static",
            ExportNote::NoOutputs => "no outputs",
        })
        .collect();
    assert_eq!(kinds, ["set-valued", "static", "kinks", "delay", "derivatives", "no outputs"]);
    assert_eq!(made.notes[0], ExportNote::SetValued { terms: vec!["sign(v - 1)".to_owned(), "unit(w, v)".to_owned()] });
    assert!(made.notes[3].to_string().contains("acts Td + 0.1 = 0.15 s after its command"), "{}", made.notes[3]);
    assert!(made.notes[3].to_string().contains("u(t - (Td + 0.1))"), "{}", made.notes[3]);
    assert_eq!(made.inputs.iter().map(|q| q.name.as_str()).collect::<Vec<_>>(), ["u", "der(u)"]);
    // The same sentences stand in the file of every language, with the quantities.
    for target in Target::ALL {
        let made = export(
            &block(),
            &ExportOptions { parameters: KeptParameters::Named(vec!["c".to_owned()]), ..ExportOptions::new(target) },
        );
        let made = made.unwrap();
        let text = &made.files[0].text;
        for note in &made.notes {
            assert!(text.contains(&format!("  {note}.\n")), "{target}: {note}\n{text}");
        }
        let (u, d) = if target == Target::Julia { ("u[1]", "u[2]") } else { ("u[0]", "u[1]") };
        for line in [
            &format!("  {u} = u, from -3 to 4\n"),
            &format!("  {d} = der(u)\n"),
            "  m = 2.0 kg, mass * / of it\n",
            "= c = 0.4\n",
            "Model Block on a belt: dx/dt = f(t, x, u, p)",
        ] {
            assert!(text.contains(line), "{target}: {line}\n{text}");
        }
        assert_eq!((made.parameters.len(), made.constants.len(), made.functions.len()), (1, 2, 2));
        assert!(made.files[0].name.to_lowercase().starts_with("block"), "{}", made.files[0].name);
        // The same model and options give the same text.
        let again =
            ExportOptions { parameters: KeptParameters::Named(vec!["c".to_owned()]), ..ExportOptions::new(target) };
        assert_eq!(export(&block(), &again).unwrap(), made);
    }
}

#[test]
fn what_is_set_valued_is_zero_with_derivatives_zero_where_it_is_so() {
    let text = "states = ['a', 'b']\nparameters = { k = 3 }\n\
        dynamics = { a = '-unit(a, b) - sign(b)', b = '-k*b/sqrt(k*a^2 + b^2)' }\noutputs = { y = 'unit(b, a)' }\n";
    let mut system = System::parse("block.toml", text).unwrap();
    let states = system.states.clone();
    let rows = system.single_valued();
    let rows = [rows.dynamics, rows.outputs].concat();
    let slopes = system.pool.jacobian(&rows, &states).concat();
    let tape = system.compile(&states, &[rows, slopes].concat()).unwrap();
    let value = |tape: &Tape, x: &[f64]| {
        let mut out = vec![f64::NAN; tape.n_outputs()];
        tape.eval(x, &mut Vec::new(), &mut out);
        out
    };
    assert_eq!(value(&tape, &[0.0, 0.0]), [0.0; 9]);
    // Elsewhere they are what is written.
    let mut plain = system.dynamics.clone();
    plain.extend(system.outputs.iter().map(|(_, e)| *e));
    plain.extend(system.pool.jacobian(&plain.clone(), &states).concat());
    let written = system.compile(&states, &plain).unwrap();
    for x in [[0.3, -0.4], [1e-12, 2e-11], [0.0, 5.0], [-7.0, 0.0]] {
        // The terms of a derivative, which may cancel, are of the size of 1/|x|.
        let size = 3.0 / f64::hypot(x[0], x[1]).min(1.0);
        for (got, expected) in value(&tape, &x).iter().zip(value(&written, &x)) {
            assert!((got - expected).abs() <= 1e-15 * size, "{x:?}: {got}, not {expected}");
        }
    }
}

#[test]
fn bad_requests_have_a_remedy() {
    let error = |options: &ExportOptions| export(&block(), options).unwrap_err().to_string();
    let named = |list: &[&str]| ExportOptions {
        parameters: KeptParameters::Named(list.iter().map(ToString::to_string).collect()),
        ..ExportOptions::new(Target::C)
    };
    assert_eq!(error(&named(&["M"])), "the model has no parameter `M`\n   = did you mean `m`?");
    assert!(error(&named(&["friction"])).contains("its parameters are Td, m, c"), "{}", error(&named(&["friction"])));
    assert!(error(&named(&["m", "m"])).contains("named twice"));
    assert!(error(&ExportOptions { name: Some("2".to_owned()), ..ExportOptions::new(Target::C) }).contains("letter"));
    assert!(
        "matlab".parse::<Target>().unwrap_err().to_string().contains("write one of c, rust, python, casadi, julia")
    );
    assert!("juli".parse::<Target>().unwrap_err().to_string().contains("did you mean `julia`?"));
    assert_eq!("CasADi".parse(), Ok(Target::Casadi));
}

#[test]
fn a_zero_denominator_is_refused_unless_its_parameter_is_an_argument() {
    let text = "states = ['x']\ninputs = ['u']\nparameters = { L = 0, k = 1 }\ndynamics = { x = 'k*u/L' }\n";
    let system = System::parse("coil.toml", text).unwrap();
    let made = |parameters| export(&system, &ExportOptions { parameters, ..ExportOptions::new(Target::C) });
    for kept in [KeptParameters::None, KeptParameters::Named(vec!["k".to_owned()])] {
        let error = made(kept).unwrap_err().to_string();
        assert!(error.contains("the denominator `L` in the equation of `x` is 0 with L = 0"), "{error}");
    }
    let text = made(KeptParameters::Named(vec!["L".to_owned()])).unwrap().single;
    assert!(text.contains("dx[0] = u_ / L;"), "{text}");
}

/// The text of a small model in full.
#[test]
fn julia_of_a_pendulum() {
    let text = "name = 'pendulum'\nstates = ['th', 'w']\ninputs = ['u']\n\
        parameters = { k = 9.81, c = { value = 0.1, unit = '1/s' } }\n\
        dynamics = { th = 'w', w = 'u - k*sin(th) - c*w' }\noutputs = { height = '1 - cos(th)' }\n";
    let system = System::parse("pendulum.toml", text).unwrap();
    let options =
        ExportOptions { parameters: KeptParameters::Named(vec!["k".to_owned()]), ..ExportOptions::new(Target::Julia) };
    let made = export(&system, &options).unwrap();
    let expected = "\
# Model pendulum: dx/dt = f(t, x, u, p), y = h(t, x, u, p), and their Jacobians.
# Written by bracketry 0.1.0. Do not edit: change the model and export again.
#
# States:
#   x[1] = th
#   x[2] = w
#
# Inputs:
#   u[1] = u
#
# Outputs:
#   y[1] = height
#
# Parameters, with their values in the model:
#   p[1] = k = 9.81
#
# Parameters of the model that are constants here:
#   c = 0.1 1/s
module Pendulum

const STATES = [\"th\", \"w\"]
const INPUTS = [\"u\"]
const OUTPUTS = [\"height\"]
const PARAMETERS = [\"k\"]
const PARAMETER_VALUES = [9.81]

# f(t, x, u, p): Time derivatives of the states.
function f(t, x, u, p = PARAMETER_VALUES)
    th = x[1]
    w = x[2]
    u_ = u[1]
    k = p[1]
    return [
        w,
        u_ - k * sin(th) - 0.1 * w,
    ]
end

# h(t, x, u, p): Outputs.
function h(t, x, u, p = PARAMETER_VALUES)
    th = x[1]
    return [
        1.0 - cos(th),
    ]
end

# f_jacobian(t, x, u, p): Derivatives of f with respect to x and u.
function f_jacobian(t, x, u, p = PARAMETER_VALUES)
    th = x[1]
    k = p[1]
    f_x = reshape([
        0.0, -(k * cos(th)),
        1.0, -0.1,
    ], 2, 2)
    f_u = reshape([
        0.0, 1.0,
    ], 2, 1)
    return f_x, f_u
end

# h_jacobian(t, x, u, p): Derivatives of h with respect to x and u.
function h_jacobian(t, x, u, p = PARAMETER_VALUES)
    th = x[1]
    h_x = reshape([
        sin(th),
        0.0,
    ], 1, 2)
    h_u = reshape([
        0.0,
    ], 1, 1)
    return h_x, h_u
end

end # module Pendulum
";
    assert_eq!(made.single, expected);
}

/// The block with another name.
fn named(name: &str) -> System {
    let mut system = block();
    name.clone_into(&mut system.name);
    system
}

#[test]
fn models_of_any_name_have_an_identifier() {
    for (name, identifier) in [
        ("cart_pole", "cart_pole"),
        ("models/Cart-pole 2.toml", "cart_pole_2"),
        ("θ", "model"),
        ("2nd", "model_2nd"),
        ("", "model"),
        ("a.b", "a_b"),
        ("System(model)", "system_model"),
    ] {
        let made = export(&named(name), &ExportOptions::new(Target::C)).unwrap();
        assert_eq!(made.name, identifier, "{name}");
        assert_eq!(made.files[0].name.split('.').next(), Some(identifier));
    }
    // The modules of Julia, none of which every other one sees.
    for (name, module) in [("cart_pole_2", "CartPole2"), ("base", "BaseModel"), ("a__b", "AB")] {
        let options = ExportOptions { name: Some(name.to_owned()), ..ExportOptions::new(Target::Julia) };
        let text = export(&block(), &options).unwrap().files[0].text.clone();
        assert!(text.contains(&format!("\nmodule {module}\n")), "{name}: {text}");
    }
}

#[test]
fn only_identifiers_are_taken() {
    let made =
        |name: &str| export(&block(), &ExportOptions { name: Some(name.to_owned()), ..ExportOptions::new(Target::C) });
    assert_eq!(made("Arm_2").unwrap().name, "Arm_2");
    for bad in ["", "2a", "_a", "a-b", "ä", "a b"] {
        let refused = made(bad).is_err_and(|e| e.to_string().contains("start with a letter"));
        assert!(refused, "{bad}");
    }
}

#[test]
fn no_text_of_a_model_leaves_its_comment_or_literal() {
    let mut system = named("m*/ f /* g\n#include \u{202e}x ");
    let about = system.parameters.iter_mut().find(|p| p.about.is_some()).unwrap();
    about.about = Some("of it \t".to_owned());
    let y = system.dynamics[0];
    system.outputs = vec![("a\"b\\\n".to_owned(), y)];
    for target in Target::ALL {
        let files = export(&system, &ExportOptions::new(target)).unwrap().files;
        let text: String = files.into_iter().map(|f| f.text).collect();
        assert!(text.contains("Model m* / f / * g #include  x : dx/dt = f(t, x, u)"), "{target}: {text}");
        assert!(text.contains("  m = 2.0 kg, of it\n"), "{target}: {text}");
        assert!(text.contains("\"a\\\"b\\\\ \""), "{target}: {text}");
    }
}
