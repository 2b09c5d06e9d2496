//! `transform` at the command line: model files that other commands read, exit codes, errors.

use std::fs;

use crate::common::{bracketry, code, file, scratch, text};
use serde_json::Value;

const JOINT: &str = "states = ['q', 'w', 'p', 'v']\ninputs = ['u']\nparameters = { k = 100, g = 9.8 }\n\
    dynamics = { q = 'w', w = '-g*sin(q) - k*(q - p)', p = 'v', v = 'u + k*(q - p)' }\noutputs = { y = 'q' }\npoint = {}\n";

#[test]
fn a_form_is_a_model_file_that_other_commands_read() {
    let dir = scratch("transform");
    let model = file(&dir, "joint.toml", JOINT);
    let o = bracketry(&["transform", &model, "--to", "brunovsky"]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let printed = text(&o.stdout);
    assert!(printed.contains("# confirmed by transforming back") && printed.contains("#   z1 = q\n"), "{printed}");
    let chain = file(&dir, "chain.toml", &printed);
    let o = bracketry(&["linearize", &chain, "--json"]);
    let linear: Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!(linear["controllability"]["rank"], 4, "{linear}");
    let direct = dir.join("direct.toml");
    assert_eq!(code(&bracketry(&["transform", &model, "--to", "brunovsky", "--out", direct.to_str().unwrap()])), 0);
    assert_eq!(fs::read_to_string(direct).unwrap(), printed);
}

#[test]
fn a_folder_gets_the_model_its_parts_and_the_report() {
    let dir = scratch("transform_parts");
    let model = file(&dir, "joint.toml", &JOINT.replace("y = 'q'", "y = 'p'"));
    let out = dir.join("out");
    let o = bracketry(&["transform", &model, "--to", "byrnes-isidori", "--out", out.to_str().unwrap(), "--json"]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let value: Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!(
        (value["outcome"].as_str(), value["blocks"][1]["free_of_inputs"].as_bool()),
        (Some("found"), Some(true))
    );
    assert_eq!(value, serde_json::from_str::<Value>(&fs::read_to_string(out.join("transform.json")).unwrap()).unwrap());
    assert!(value["parts"]["zero_dynamics"]["dynamics"].is_object(), "{value}");
    for name in ["transformed.toml", "zero_dynamics.toml"] {
        assert_eq!(code(&bracketry(&["trim", out.join(name).to_str().unwrap()])), 0, "{name}");
    }
}

#[test]
fn what_does_not_exist_has_the_exit_code_1_and_says_why() {
    let dir = scratch("transform_negative");
    let text_of = |o: &std::process::Output| text(&o.stdout) + &text(&o.stderr);
    let beam = "../../models/ball_and_beam.toml";
    let o = bracketry(&["transform", beam, "--to", "brunovsky"]);
    assert!(
        code(&o) == 1 && text_of(&o).contains("is not involutive") && text_of(&o).contains("next:"),
        "{}",
        text_of(&o)
    );
    let model = file(&dir, "joint.toml", JOINT);
    let o = bracketry(&["transform", &model, "--to", "bruno"]);
    assert!(code(&o) == 2 && text_of(&o).contains("brunovsky"), "{}", text_of(&o));
    let o = bracketry(&["transform", &model, "--to", "byrnes-isidori", "--output", "z"]);
    assert!(code(&o) == 2 && text_of(&o).contains("no output `z`"), "{}", text_of(&o));
    let o = bracketry(&["transform", &model, "--to", "kalman", "--at", "x=1"]);
    assert!(code(&o) == 2 && text_of(&o).contains("neither a state nor an input"), "{}", text_of(&o));
}
