//! `certify` at the command line: reports, files, exit codes.

use std::fs;
use std::process::Output;

use crate::common::{bracketry, code, file, scratch, text};
use serde_json::Value;

fn json(o: &Output) -> Value {
    serde_json::from_slice(&o.stdout).unwrap()
}

const VAN_DER_POL: &str = "states = ['x', 'y']\ndynamics = { x = '-y', y = 'x + (x^2 - 1)*y' }\n";

#[test]
fn a_region_is_proved_drawn_and_checked_from_its_file() {
    let dir = scratch("certify");
    let model = file(&dir, "vdp.toml", VAN_DER_POL);
    let out = dir.join("out");
    let o = bracketry(&["certify", &model, "--find", "region", "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("region of attraction: proved"), "{}", text(&o.stdout));
    assert!(out.join("region.png").exists() && out.join("certify.json").exists());
    let certificate = out.join("certificate_region.json");
    let check = |model: &str| bracketry(&["certify", model, "--check", certificate.to_str().unwrap(), "--json"]);
    let o = check(&model);
    assert_eq!((code(&o), json(&o)["conclusion"].as_str()), (0, Some("region_of_attraction")));
    // The same certificate shows nothing of other equations, and nothing where a number is changed.
    let other = file(&dir, "other.toml", &VAN_DER_POL.replace("x^2 - 1", "x^2 - 2"));
    assert_eq!(code(&check(&other)), 1);
    let changed = fs::read_to_string(&certificate).unwrap().replacen("\"level\": \"", "\"level\": \"1", 1);
    fs::write(&certificate, changed).unwrap();
    let o = check(&model);
    assert!(code(&o) == 1 && json(&o)["valid"] == false, "{}", text(&o.stdout));
}

#[test]
fn a_closed_loop_is_certified_at_its_own_equilibrium() {
    let dir = scratch("certify_loop");
    let model = file(
        &dir,
        "spring.toml",
        "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u + x^3' }\noutputs = { y = 'v' }\n",
    );
    let o = bracketry(&["certify", &model, "--with", "u=-2*x-2*v-2*x^3", "--find", "lyapunov,conserved", "--json"]);
    assert_eq!(code(&o), 0, "{}", text(&o.stdout));
    assert_eq!(json(&o)["lyapunov"]["conclusion"], "globally_asymptotically_stable");
    assert_eq!(json(&o)["conserved"]["complete_to_degree"], 4);
    let o = bracketry(&["certify", &model, "--find", "lyapunov", "--json"]);
    assert_eq!((code(&o), json(&o)["lyapunov"]["proved"].as_bool()), (1, Some(false)));
}

#[test]
fn mistakes_are_named() {
    let dir = scratch("certify_mistakes");
    let model = file(&dir, "m.toml", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u - x' }\n");
    for (arguments, named) in [
        (&["--with", "v=-x"][..], "the model has no input `v`"),
        (&["--with", "u"], "no expression"),
        (&["--with", "u=-z"], "unknown name"),
        (&["--with", "u=1", "--with", "u=2"], "set twice"),
        (&["--degree", "3"], "use 2 or 4"),
        (&["--time-limit", "nan"], "positive number"),
        (&["--at", "z=1"], "neither a state nor an input"),
        (&["--axes", "x,z"], "not a state"),
        (&["--check", "missing.json"], "cannot read"),
    ] {
        let o = bracketry(&[&["certify", &model], arguments].concat());
        assert!(code(&o) == 2 && text(&o.stderr).contains(named), "{arguments:?}: {}", text(&o.stderr));
    }
    let o = bracketry(&["certify", &model, "--at", "x=1"]);
    assert!(code(&o) == 1 && text(&o.stdout).contains("not an equilibrium"), "{}", text(&o.stdout));
}
