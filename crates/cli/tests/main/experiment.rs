//! `experiment` at the command line: report, files that `simulate` and `diagnose` read, exit codes.

use crate::common::{bracketry, code, file, json, scratch, text};

const CART: &str = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1.2, c = 0.5 }\n\
     dynamics = { x = 'v', v = '(u - c*v)/m' }\n";

#[test]
fn the_inputs_can_be_simulated_and_give_the_expected_outputs() {
    let dir = scratch("experiment");
    let viscous = file(&dir, "viscous.toml", CART);
    let quadratic = file(&dir, "quadratic.toml", &CART.replace("c*v)", "c*v*abs(v))"));
    let out = dir.join("out");
    let limits = ["--limits", "u=-2..2,x=-1..1", "--duration", "6", "--starts", "1"];
    let given = [&["experiment", &viscous, "--tell", &quadratic][..], &limits].concat();
    let o = bracketry(&[&given[..], &["--noise", "x=0.002,v=0.01", "--out", out.to_str().unwrap()]].concat());
    assert_eq!(code(&o), 0, "{}{}", text(&o.stdout), text(&o.stderr));
    assert!(text(&o.stdout).contains("\nresolved: "), "{}", text(&o.stdout));
    for name in ["experiment.txt", "experiment.json", "inputs.csv", "expected.csv", "experiment.png", "experiment.svg"]
    {
        assert!(out.join(name).exists(), "{name}");
    }
    let inputs = out.join("inputs.csv");
    let v = json(&["simulate", &quadratic, "--inputs", inputs.to_str().unwrap(), "--json"]);
    let written: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("experiment.json")).unwrap()).unwrap();
    let expected = written["columns"]["x[quadratic]"].as_array().unwrap();
    let (simulated, expected) = (v["x_final"]["x"].as_f64().unwrap(), expected.last().unwrap().as_f64().unwrap());
    assert!((simulated - expected).abs() < 1e-6, "{simulated} {expected}");
    assert_eq!(written["resolved"], true);
}

#[test]
fn the_exit_code_tells_what_is_resolved_from_what_is_not_and_from_bad_input() {
    let dir = scratch("experiment_codes");
    let model = file(&dir, "cart.toml", CART);
    let twice = file(
        &dir,
        "twice.toml",
        "states = ['x', 'v']\ninputs = ['u']\nparameters = { b = 1, d = 2 }\n\
         dynamics = { x = 'v', v = 'b*u - d*v' }\n",
    );
    let limits = ["--limits", "u=-1..1", "--duration", "4", "--starts", "0"];
    let with = |more: &[&str]| bracketry(&[&["experiment"], more, &limits].concat());
    let o = with(&[&model, "--tell", &twice]);
    assert_eq!(code(&o), 1, "{}{}", text(&o.stdout), text(&o.stderr));
    assert!(text(&o.stdout).contains("not resolved") && text(&o.stdout).contains("would help"), "{}", text(&o.stdout));
    let gain = file(
        &dir,
        "gain.toml",
        "states = ['v']\ninputs = ['u']\nparameters = { k = 1, m = 2 }\n\
         dynamics = { v = 'k*u/m' }\n",
    );
    let o = with(&[&gain, "--parameters", "k,m"]);
    assert_eq!(code(&o), 1, "{}{}", text(&o.stdout), text(&o.stderr));
    assert!(text(&o.stdout).contains("not identified: k, m"), "{}", text(&o.stdout));
    let o = with(&[&gain, "--parameters", "k"]);
    assert_eq!(code(&o), 0, "{}{}", text(&o.stdout), text(&o.stderr));
    let timed =
        file(&dir, "timed.toml", "states = ['t']\ninputs = ['u']\nparameters = { m = 1 }\ndynamics = { t = 'u/m' }\n");
    for (more, says) in [
        (&[&model[..], "--parameters", "q"][..], "`q`"),
        (&[&model, "--tell", "q=1"], "`q` is not a parameter"),
        (&[&model, "--tell", "c=1", "--noise", "z=1"], "`z`"),
        (&[&model, "--tell", "c=1", "--fix", "z"], "`z`"),
        (&[&model, "--tell", "c=1", "--sample", "-1"], "positive"),
        (&[&model], "--tell"),
        (&[&timed, "--parameters", "m"], "which is time here"),
        (&[&model, "--tell", "c=1,c=2,c=3"], "3 explanations"),
        (&[&model, "--tell", "c=1", "--measure", "y"], "`y`"),
        (&[&model, "--tell", "c=1", "--noise", "x=1e-300"], "the noise of `x`"),
    ] {
        let o = with(more);
        assert!(code(&o) == 2 && text(&o.stderr).contains(says), "{more:?}: {}", text(&o.stderr));
    }
    let o = bracketry(&["experiment", &model, "--parameters", "m", "--duration", "4"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("--limits u=LOW..HIGH"), "{}", text(&o.stderr));
}

/// The cart has quadratic drag. At one speed, nothing tells it from viscous friction; the experiment that the diagnosis names does.
#[test]
fn the_diagnosis_ends_with_an_experiment_that_tells_its_causes_apart() {
    let dir = scratch("experiment_after_diagnosis");
    let cart = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1 }\ndynamics = { x = 'v', v = 'u/m' }\n";
    let model = file(&dir, "cart.toml", cart);
    let truth = file(&dir, "truth.toml", &cart.replace("u/m", "(u - 0.7*v*abs(v))/m"));
    let rows: Vec<String> =
        (0..=500).map(|k| 0.02 * f64::from(k)).map(|t| format!("{t},{}\n", 0.35 + 0.02 * (0.9 * t).cos())).collect();
    let slow = file(&dir, "slow.csv", &format!("t,u\n{}", rows.concat()));
    let (run, out) = (dir.join("run"), dir.join("out"));
    let noise = ["--noise", "x=0.04,v=0.04", "--seed", "1", "--out", run.to_str().unwrap()];
    json(&[&["simulate", &truth, "--inputs", &slow, "--json"][..], &noise].concat());
    let measured = run.join("measured.csv");
    let found = json(&["diagnose", &model, measured.to_str().unwrap(), "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(found["causes"][0]["name"], "quadratic_drag", "{}", found["causes"]);
    let next = found["next_experiments"].as_array().unwrap();
    let viscous = next.iter().find(|n| n["rival"] == "viscous_friction").unwrap();
    let command: Vec<&str> = viscous["command"].as_str().unwrap().split(' ').skip(1).collect();
    let told = json(&[&command[..], &["--starts", "0", "--json"]].concat());
    assert_eq!(told["resolved"], true, "{}", told["separations"]);
    assert_eq!(told["noise"][0]["source"], "given");
    assert!(std::fs::read_to_string(out.join("diagnosis.txt")).unwrap().contains("Next experiment, to distinguish"));
}
