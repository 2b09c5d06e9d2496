//! `trim` and `linearize` at the command line: reports, files, exit codes.

use std::fs;
use std::process::Output;

use crate::common::{bracketry, code, file, scratch, text};
use serde_json::Value;

fn json(o: &Output) -> Value {
    serde_json::from_slice(&o.stdout).unwrap()
}

const PENDULUM: &str = "states = ['th', 'w']\ninputs = ['u']\nparameters = { g = 9.81 }\nranges = { u = { min = -9, max = 9 } }\n\
    dynamics = { th = 'w', w = 'u - g*sin(th)' }\noutputs = { y = 'th' }\n";

#[test]
fn an_operating_point_is_found_and_written_as_a_model() {
    let dir = scratch("trim");
    let model = file(&dir, "pendulum.toml", PENDULUM);
    let out = dir.join("out");
    let o = bracketry(&["trim", &model, "--fix", "th=1", "--free", "u", "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("confirmed exactly") && text(&o.stdout).contains("9.81*sin(1)"));
    let again = bracketry(&["linearize", out.join("trimmed.toml").to_str().unwrap(), "--json"]);
    let value = json(&again);
    assert_eq!(value["rest"]["kind"], "equilibrium", "{value}");
    assert!((value["a"]["values"][1][0].as_f64().unwrap() + 9.81 * 1f64.cos()).abs() < 1e-12);
    assert!(value["regulator"]["residual"].as_f64().unwrap() < 1e-12);
    assert_eq!(value["controllability"]["rank"], 2);
}

#[test]
fn what_is_not_found_has_the_exit_code_1() {
    let dir = scratch("trim_negative");
    let model = file(&dir, "pendulum.toml", PENDULUM);
    let o = bracketry(&["trim", &model, "--fix", "th=1", "--json"]);
    assert_eq!((code(&o), json(&o)["status"].as_str()), (1, Some("not_found")));
    // It takes a moment of 9.81, beyond the range.
    let o = bracketry(&["trim", &model, "--fix", "th=pi/2", "--free", "u", "--json"]);
    assert_eq!((code(&o), json(&o)["status"].as_str()), (1, Some("out_of_range")));
    let o = bracketry(&["trim", &model, "--free", "q"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("no state or input"), "{}", text(&o.stderr));
    let kink = file(&dir, "kink.toml", "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u + abs(x)' }\n");
    let o = bracketry(&["linearize", &kink]);
    assert!(code(&o) == 1 && text(&o.stdout).contains("kink"), "{}", text(&o.stdout));
    assert_eq!(code(&bracketry(&["linearize", &model, "--state-weights", "1,2,3"])), 2);
}

#[test]
fn other_programs_get_files() {
    let dir = scratch("linearize_files");
    let model = file(&dir, "pendulum.toml", PENDULUM);
    let o = bracketry(&["linearize", &model, "--out", dir.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let read = |name: &str| fs::read_to_string(dir.join(name)).unwrap();
    assert!(
        read("linear.py").contains("A = np.array([[0.0, 1.0],\n     [-9.81, 0.0]]).reshape(2, 2)"),
        "{}",
        read("linear.py")
    );
    assert!(read("linear.m").contains("A = [0.0, 1.0; -9.81, 0.0];"));
    assert!(read("linear.jl").contains("sys = ss(A, B, C, D)"));
    assert!(read("linear.txt").contains("poles of A - B K"));
}
