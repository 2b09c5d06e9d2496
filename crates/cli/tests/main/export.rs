//! `export` at the command line: files, what is printed, errors.

use std::fs;

use crate::common::{bracketry, code, file, scratch, text};
use serde_json::Value;

const BLOCK: &str = "name = 'block'\nstates = ['v']\ninputs = ['u']\nparameters = { m = 2, c = 0.4 }\n\
    dynamics = { v = '(u - c*sign(v))/m' }\noutputs = { speed = 'v' }\n";

#[test]
fn a_folder_gets_the_files_and_the_report_says_what_they_hold() {
    let dir = scratch("export");
    let model = file(&dir, "block.toml", BLOCK);
    let out = dir.join("out");
    let o = bracketry(&["export", &model, "--language", "c", "--out", out.to_str().unwrap()]);
    let printed = text(&o.stdout);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(printed.starts_with("block in C: block.h, block.c\n"), "{printed}");
    assert!(printed.contains("f_jacobian(t, x, u) = f_x (1 × 1), f_u (1 × 1)"), "{printed}");
    assert!(printed.contains("note: set-valued in the model, here 0") && printed.contains("sign(v)"), "{printed}");
    let header = fs::read_to_string(out.join("block.h")).unwrap();
    assert!(header.contains("void block_f(double t, const double *x, const double *u, double *dx);"), "{header}");
    assert!(fs::read_to_string(out.join("block.c")).unwrap().starts_with("/* See block.h. */\n#include \"block.h\"\n"));
    // Without a folder the source is printed, the notes in it.
    let o = bracketry(&["export", &model, "--language", "c"]);
    let printed = text(&o.stdout);
    assert!(printed.contains("void block_f(") && !printed.contains("#include \"block.h\""), "{printed}");
    assert!(printed.contains("set-valued in the model"), "{printed}");
}

#[test]
fn json_holds_functions_notes_and_files() {
    let dir = scratch("export_json");
    let model = file(&dir, "block.toml", BLOCK);
    for (language, name) in
        [("c", "arm.h"), ("rust", "arm.rs"), ("python", "arm.py"), ("casadi", "arm_casadi.py"), ("julia", "Arm.jl")]
    {
        let run = || {
            let arguments = ["export", &model, "--language", language, "--parameters", "c", "--name", "arm", "--json"];
            let o = bracketry(&arguments);
            assert_eq!(code(&o), 0, "{}", text(&o.stderr));
            serde_json::from_slice::<Value>(&o.stdout).unwrap()
        };
        let value = run();
        assert_eq!((value["language"].as_str(), value["files"][0]["name"].as_str()), (Some(language), Some(name)));
        assert_eq!(
            (value["parameters"][0]["name"].as_str(), value["constants"][0]["value"].as_f64()),
            (Some("c"), Some(2.0))
        );
        assert_eq!(value["functions"][2]["results"][1]["name"], "f_u");
        assert_eq!(value["notes"][0]["kind"], "set_valued");
        assert!(value["notes"][0]["text"].as_str().unwrap().contains("sign(v)"), "{value}");
        assert_eq!(value, run(), "the same text each time");
    }
}

#[test]
fn bad_input_has_the_exit_code_2_and_a_remedy() {
    let dir = scratch("export_bad");
    let model = file(&dir, "block.toml", BLOCK);
    for (arguments, answer) in [
        (&["--language", "cpp"][..], "write one of c, rust, python, casadi, julia"),
        (&[], "--language <LANGUAGE>"),
        (&["--language", "c", "--parameters", "M"], "did you mean `m`?"),
        (&["--language", "c", "--name", "my arm"], "start with a letter"),
    ] {
        let o = bracketry(&[&["export", &model], arguments].concat());
        assert!(code(&o) == 2 && text(&o.stderr).contains(answer), "{arguments:?}: {}", text(&o.stderr));
    }
    let o = bracketry(&["export", "../../models/cart_pole_swing_up.toml", "--language", "c"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("problem"), "{}", text(&o.stderr));
}
