//! Unit vectors σ/|σ| in equations: found however they are written, left alone where they are none, rounded when smoothed.

use bracketry_system::System;
use bracketry_system::symbolic::Symbol;

fn system(definitions: &str, vx: &str) -> System {
    let text = format!(
        "states = [\"vx\", \"vy\", \"w\", \"phi\"]\ninputs = [\"u\"]\n\
         parameters = {{ mu = 0.3, g = 9.81, c = 4, p = 2, q = 3 }}\n\
         definitions = {{ {definitions} }}\n\
         [dynamics]\nvx = \"{vx}\"\nvy = \"u\"\nw = \"0\"\nphi = \"w\""
    );
    System::parse("test.toml", &text).unwrap()
}

const AT: [f64; 5] = [0.3, -0.4, 0.7, 0.2, 0.1];

/// The unit vectors of a model; its set-valued form has the value of the equations where they are smooth.
fn vectors(definitions: &str, vx: &str) -> Vec<String> {
    let mut s = system(definitions, vx);
    let form = s.set_valued_form();
    let arguments: Vec<Symbol> = s.states.iter().chain(&s.inputs).copied().collect();
    let evaluate = |s: &mut System, arguments: &[Symbol], x: &[f64], e| {
        let mut out = [0.0];
        s.compile(arguments, &[e]).unwrap().eval(x, &mut Vec::new(), &mut out);
        out[0]
    };
    let (first, last) = (form.unit_vectors.first().map_or(0, |v| v.switches.start), form.switches.len());
    let mut with_directions = arguments.clone();
    let mut x = AT.to_vec();
    for vector in &form.unit_vectors {
        let components = &form.switches[vector.switches.clone()];
        let values: Vec<f64> = components.iter().map(|c| evaluate(&mut s, &arguments, &AT, c.surface)).collect();
        let size = values.iter().map(|v| v * v).sum::<f64>().sqrt();
        x.extend(values.iter().map(|v| v / size));
        with_directions.extend(components.iter().map(|c| c.sign));
    }
    assert_eq!(first + x.len() - AT.len(), last);
    let dynamics = s.dynamics.clone();
    for (&written, &switched) in dynamics.iter().zip(&form.dynamics) {
        let (a, b) = (evaluate(&mut s, &arguments, &AT, written), evaluate(&mut s, &with_directions, &x, switched));
        assert!((a - b).abs() <= 1e-14 * a.abs().max(1.0), "{vx}: {a} {b}");
        // Nothing of the quotient is left: the form has a value where the vector vanishes.
        let at_rest: Vec<f64> = x.iter().enumerate().map(|(i, v)| if i < 3 { 0.0 } else { *v }).collect();
        assert!(evaluate(&mut s, &with_directions, &at_rest, switched).is_finite() || form.unit_vectors.is_empty());
    }
    form.unit_vectors.into_iter().map(|v| v.name).collect()
}

#[test]
fn coupled_friction_is_found_however_it_is_written() {
    for (definitions, vx) in [
        ("", "u - mu*g*vx/sqrt(vx^2 + vy^2)"),
        ("", "-mu*g*unit(vx, vy)"),
        ("", "-vx*(vx^2 + vy^2)^(-1/2)"),
        ("rho = \"sqrt(vx^2 + vy^2)\"", "-mu*g/rho*vx"),
        ("rho = \"sqrt(vx^2 + vy^2)\"", "-(mu*g/rho + c)*vx"),
        ("rho = \"sqrt(vx^2 + vy^2)\"", "-(mu + p*exp(-rho/q))*(g + u*vy)*vx/(c*rho)"),
        ("rho = \"sqrt(4*vx^2 + 4*vy^2)\"", "-(vx*(2 + cos(phi)))/rho"),
        (
            "e = \"vx/sqrt(vx^2 + vy^2)\", f = \"vy/sqrt(vx^2 + vy^2)\"",
            "-e*g + e*e^2*p - e*f^2*q - 2*e*vx*vy/(vx^2 + vy^2)",
        ),
        ("", "u - p*vx/sqrt(p*(vx^2 + vy^2))"),
    ] {
        assert_eq!(vectors(definitions, vx), ["vx, vy"], "{vx}");
    }
}

#[test]
fn weights_and_compound_components_are_found() {
    assert_eq!(vectors("", "u - p^2*vx/sqrt((p*vx)^2 + (q*vy)^2)"), ["vx, vy"]);
    assert_eq!(vectors("", "-vx/sqrt(p^2*vx^2 + (1 + phi^2)*vy^2)"), ["vx, vy"]);
    assert_eq!(vectors("", "-unit(vx, vy, w*sqrt(c)/2)").len(), 1);
    assert_eq!(vectors("", "-(vx - w*phi)/sqrt((vx - w*phi)^2 + (vy + w*u)^2)").len(), 1);
    assert_eq!(vectors("", "(w*phi - vx)/sqrt((vx - w*phi)^2 + (vy + w*u)^2)").len(), 1);
    assert_eq!(vectors("", "-unit(vx, vy) - vx/sqrt(vx^2 + vy^2 + c*w^2)").len(), 2);
    let (along, across) = ("(cos(phi)*vx + sin(phi)*vy)", "(cos(phi)*vy - sin(phi)*vx)");
    let rotated = format!("-(cos(phi)*{along} - sin(phi)*{across})/sqrt({along}^2 + {across}^2)");
    assert_eq!(vectors("", &rotated).len(), 1);
}

#[test]
fn what_is_no_unit_vector_stays() {
    for vx in [
        "vx/sqrt(vx^2 + vy^2 + 0.01)",
        "vx/sqrt(vx^2 + vy^2 + p^2)",
        "1/sqrt(vx^2 + vy^2)",
        "(vx + 1)/sqrt(vx^2 + vy^2)",
        "vx*vy/(vx^2 + vy^2)",
        "vx/sqrt(2*vx^2 - vy^2)",
        "vx*sqrt(vx^2 + vy^2)",
        "vx/(vx^2 + vy^2)^(3/2)",
        // It drives, or acts now along and now against the velocity, or on another equation, or vanishes with the speed.
        "2.943*vx/sqrt(vx^2 + vy^2)",
        "-u*vx/sqrt(vx^2 + vy^2)",
        "-phi*vx/sqrt(vx^2 + vy^2)",
        "-w/sqrt(w^2 + phi^2)",
        "-c*vx*(vx^2 + vy^2)/sqrt(vx^2 + vy^2)",
    ] {
        assert!(vectors("", vx).is_empty(), "{vx}");
    }
    // What drives with these values is friction with others, which the parameters may have.
    assert_eq!(vectors("", "mu*g*vx/sqrt(vx^2 + vy^2)").len(), 1);
}

#[test]
fn smoothing_rounds_the_root_wherever_it_stands() {
    let mut s = system("rho = \"sqrt(vx^2 + vy^2)\"", "-(mu + p*exp(-rho))*vx/rho - sign(w)");
    let width = s.pool.ratio(1, 100);
    let mut smooth = s.smoothed(width);
    let arguments: Vec<Symbol> = smooth.states.iter().chain(&smooth.inputs).copied().collect();
    let f = smooth.dynamics[0];
    let slope = smooth.pool.diff(f, smooth.states[0]);
    let tape = smooth.compile(&arguments, &[f, slope]).unwrap();
    let at = |x: &[f64]| {
        let mut out = [0.0; 2];
        tape.eval(x, &mut Vec::new(), &mut out);
        out
    };
    let rho = (0.25f64 + 1e-4).sqrt();
    let expected = -(0.3 + 2.0 * (-rho).exp()) * 0.3 / rho - (0.7f64 / 0.01).tanh();
    assert!((at(&AT)[0] - expected).abs() < 1e-14);
    let rest = at(&[0.0; 5]);
    assert_eq!(rest[0], 0.0);
    assert!((rest[1] + (0.3 + 2.0 * (-0.01f64).exp()) / 0.01).abs() < 1e-9);
}
