//! `analyze --from-rest` and `steer --method loops` at the command line: reports, files, exit codes.

use crate::common::{bracketry, code, file, json, root, scratch, text};

fn model(name: &str) -> String {
    root().join("models").join(name).to_str().unwrap().to_owned()
}

#[test]
fn the_answer_comes_with_its_cone_and_its_loops() {
    let out = scratch("from_rest").join("out");
    let table = model("shaken_table.toml");
    let with = |bounds: &str| json(&["analyze", &table, "--from-rest", "--bounds", bounds, "--json"]);
    let no = with("der(X,2)=-2.943..2.943");
    assert_eq!((&no["answer"], &no["coordinates"][0]["motion"]), (&"no".into(), &"never".into()), "{no}");
    assert_eq!(no["friction"][0]["text"], "|-der(X,2)| <= mu*g");
    assert_eq!(no["loops"].as_array().unwrap().len(), 0);
    let yes = with("der(X,2)=-4..4");
    assert_eq!(
        (&yes["answer"], &yes["proof"], &yes["margin"]),
        (&"yes".into(), &"proven".into(), &1.0.into()),
        "{yes}"
    );
    let o =
        bracketry(&["analyze", &table, "--from-rest", "--bounds", "der(X,2)=-4..4", "--out", out.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    assert!(text(&o.stdout).contains("x = 0: yes (proven)"), "{}", text(&o.stdout));
    for name in ["from_rest.txt", "from_rest.json", "displacements_x.svg", "displacements_x.png"] {
        assert!(out.join(name).exists(), "{name}");
    }
}

#[test]
fn a_map_tells_where_a_no_becomes_a_yes() {
    let out = scratch("from_rest_map").join("out");
    let o = bracketry(&[
        "analyze",
        &model("cart_on_tilting_beam.toml"),
        "--from-rest",
        "--map",
        "theta=0.05..0.4,der(theta,2)=1..5",
        "--cells",
        "5",
        "--json",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let map: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
    assert_eq!(map["complete"], true);
    assert_eq!(map["cells"].as_array().unwrap().len(), 5);
    assert!(out.join("from_rest_map.png").exists());
    let threshold = &map["thresholds"][0];
    let (no, yes) = (threshold["no_up_to"].as_f64().unwrap(), threshold["yes_from"].as_f64().unwrap());
    // g sin Θ = μ (g cos Θ − s α) at s = 0.1 m, α = 5 rad/s².
    let excess = |tilt: f64| 9.81 * tilt.sin() - 0.2 * (9.81 * tilt.cos() - 0.5);
    assert!(excess(no).abs() < 1e-5, "{no}");
    assert!(no < yes && yes < 1.01 * no, "{no} {yes}");
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let dir = scratch("from_rest_errors");
    let table = model("shaken_table.toml");
    let free = file(&dir, "free.toml", "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = 'u'\n");
    for (arguments, says) in [
        (&["analyze", &table, "--from-rest"][..], "`der(X,2)` is not bounded: give its bounds"),
        (&["analyze", &table, "--from-rest", "--bounds", "der(X,2)"], "write NAME=LOW..HIGH"),
        (&["analyze", &table, "--bounds", "der(X,2)=-1..1"], "--from-rest"),
        (&["analyze", &table, "--from-rest", "--map", "der(X,2)=1..2"], "give two"),
        (&["analyze", &table, "--from-rest", "--bounds", "der(X,2)=-1..1", "--map", "x=1..2,X=0..1"], "the axis `x`"),
    ] {
        let o = bracketry(arguments);
        assert_eq!(code(&o), 2, "{arguments:?}: {}", text(&o.stderr));
        assert!(text(&o.stderr).contains(says), "{arguments:?}: {}", text(&o.stderr));
    }
    let o = bracketry(&["analyze", &free, "--from-rest", "--bounds", "u=-1..1"]);
    assert_eq!(code(&o), 1);
    assert!(text(&o.stdout).contains("no dry friction acts on a velocity"));
}

#[test]
fn loops_steer_and_replay_from_rest_to_rest() {
    let out = scratch("loops").join("out");
    let table = model("shaken_table.toml");
    let given = ["steer", &table, "--to", "x=0.02", "--method", "loops"];
    let o = bracketry(&[&given[..], &["--bounds", "der(X,2)=-5..5", "--out", out.to_str().unwrap()]].concat());
    assert_eq!(code(&o), 0, "{} {}", text(&o.stdout), text(&o.stderr));
    let (extended, scenario) = (out.join("model.toml"), out.join("scenario.toml"));
    let end = json(&["simulate", extended.to_str().unwrap(), "--scenario", scenario.to_str().unwrap(), "--json"]);
    assert!((end["x_final"]["x"].as_f64().unwrap() - 0.02).abs() < 1e-6, "{end}");
    let o = bracketry(&[&given[..], &["--bounds", "der(X,2)=-2..2"]].concat());
    assert_eq!(code(&o), 1);
    assert!(
        text(&o.stdout).contains("friction holds x for all inputs within their bounds (proven)"),
        "{}",
        text(&o.stdout)
    );
}

/// At rest under dry friction, no small input moves anything: the derivative of the end by the inputs vanishes, and a controller on the
/// exact flow that is to return the table stays where it is. From loops, the mass reaches its target.
#[test]
fn a_controller_at_rest_starts_from_loops() {
    let out = scratch("loops_as_guess").join("out");
    let table = model("shaken_table.toml");
    let folder = out.to_str().unwrap();
    let bounds = ["--bounds", "der(X,2)=-5..5", "--duration", "4", "--out", folder];
    let o = bracketry(&[&["steer", &table, "--to", "x=0.02", "--method", "loops"][..], &bounds].concat());
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    let problem = |guess: &str| {
        format!(
            "model = 'model.toml'\nhorizon = {{ steps = 80, dt = 0.05 }}\ncost = {{ stage = '1e-4*Xdd^2' }}\n{guess}\
             constraints = {{ Xdd = {{ min = -5, max = 5 }} }}\ntarget = {{ x = 0.02, v = 0, X = 0, Xd = 0 }}\n\
             solve = {{ method = 'stick-slip' }}\nrun = {{ steps = 80 }}\n"
        )
    };
    let end = |name: &str, guess: &str| {
        let path = file(&out, name, &problem(guess));
        let o = bracketry(&["control", &path, "--json"]);
        let result: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
        result["x_final"]["x"].as_f64().unwrap()
    };
    assert_eq!(end("plain.toml", ""), 0.0);
    let guided = end("guided.toml", "initial_guess = { file = 'inputs.csv', hold = 'previous' }\n");
    assert!((guided - 0.02).abs() < 1e-6, "{guided}");
}
