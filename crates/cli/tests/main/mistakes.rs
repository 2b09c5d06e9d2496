//! Answers to mistakes: files of the wrong kind, errors in files, equations without a value, data that cannot tell.

use std::fs;
use std::path::Path;

use crate::common::{code, file, scratch, text, within};

const SLIDER: &str = "states = ['x', 'velocity']\ninputs = ['a']\n[parameters]\nmu = 0.3\n\
                      [dynamics]\nx = 'velocity'\nvelocity = 'a - mu*9.81*sign(velocity)'\n";

/// What is said to `arguments` in a folder with a model, a scenario, a problem, a table and a robot.
fn said(dir: &Path, arguments: &[&str]) -> String {
    let o = within(dir, arguments);
    assert_eq!(code(&o), 2, "{arguments:?}: {}", text(&o.stdout));
    assert!(o.stdout.is_empty(), "{arguments:?}: {}", text(&o.stdout));
    text(&o.stderr)
}

#[test]
fn a_file_of_another_kind_is_answered_with_the_right_command() {
    let dir = scratch("kinds");
    assert_eq!(code(&within(&dir, &["new", "ball"])), 0);
    file(&dir, "run.csv", "t,u,x\n0,1,2\n1,1,2\n");
    file(&dir, "robot.toml", &fs::read_to_string(crate::common::model("kr125.toml")).unwrap());
    file(&dir, "lost.toml", "model = 'bll.toml'\n[horizon]\nsteps = 3\ndt = 0.1\n");
    fs::create_dir(dir.join("empty")).unwrap();
    let robot_columns = "q1,q2,Fx,Fy,Fz,Mx,My,Mz";
    file(&dir, "loads.csv", &format!("{robot_columns}\n1,1,1,1,1,1,1,1\n"));
    file(&dir, "log.csv", &format!("t,{robot_columns}\n0,1,1,1,1,1,1,1,1\n"));
    file(&dir, "displaced.csv", &format!("{robot_columns},dx,dy,dz,rx,ry,rz\n1,1,1,1,1,1,1,1,0,0,0,0,0,0\n"));
    let cases: [(&[&str], &[&str]); 22] = [
        (
            &["analyze", "ball_problem.toml"],
            &["this is a problem file, not a model file", "`bracketry control ball_problem.toml`"],
        ),
        (&["affinize", "robot.toml"], &["this is a robot file", "bracketry stiffness"]),
        (
            &["control", "ball.toml"],
            &["this is a model file, not a problem file", "`bracketry analyze ball.toml`", "[horizon]"],
        ),
        (&["control", "ball_scenario.toml"], &["this is a scenario file", "--scenario ball_scenario.toml"]),
        (&["simulate", "ball.toml", "--scenario", "ball_problem.toml"], &["not a scenario file", "duration"]),
        (&["simulate", "ball.toml", "--scenario", "run.csv"], &["this is a table of samples", "--inputs run.csv"]),
        (&["simulate", "ball.toml", "--inputs", "ball_scenario.toml"], &["--scenario ball_scenario.toml"]),
        (&["diagnose", "ball.toml", "ball_scenario.toml"], &["not a table of samples", "column t"]),
        (&["diagnose", "run.csv", "ball.toml"], &["run.csv: this is a table of samples, not a model file"]),
        (&["stiffness", "identify", "displaced.csv", "ball.toml"], &["not a robot file", "kr125"]),
        (
            &["stiffness", "identify", "run.csv", "robot.toml"],
            &[
                "this is a table of samples, not a table of a robot's displacements",
                "`bracketry diagnose MODEL.toml run.csv`",
            ],
        ),
        (
            &["stiffness", "identify", "log.csv", "robot.toml"],
            &["this is a log of a robot", "`bracketry stiffness compensate log.csv ROBOT.toml`"],
        ),
        (&["stiffness", "compensate", "displaced.csv", "robot.toml"], &["`bracketry stiffness identify displaced.csv"]),
        (&["stiffness", "identify", "loads.csv", "robot.toml"], &["poses loads.csv", "weigh loads.csv", "dx, dy, dz"]),
        (&["diagnose", "ball.toml", "displaced.csv"], &["`bracketry stiffness identify displaced.csv ROBOT.toml`"]),
        (&["stiffness", "identify", "ball.toml", "robot.toml"], &["both ball.toml and robot.toml end in .toml"]),
        (&["plate", "ball.toml"], &["not a scenario of the plate", "experiment = 1"]),
        (&["analyze", "bal.toml"], &["there is no such file", "did you mean `ball.toml`?"]),
        (&["analyze", "ball"], &["did you mean `ball.toml`?"]),
        (
            &["control", "lost.toml"],
            &["bll.toml (named in lost.toml): cannot be read: there is no such file", "did you mean `ball.toml`?"],
        ),
        (&["analyze", "."], &["is a directory", "ball.toml"]),
        (&["analyze", "empty"], &["is a directory", "bracketry new"]),
    ];
    for (arguments, parts) in cases {
        let message = said(&dir, arguments);
        for part in parts {
            assert!(message.contains(part), "{arguments:?}: `{part}` in: {message}");
        }
    }
    assert!(said(&dir, &["ball.toml"]).contains("`bracketry analyze ball.toml`"));
    assert!(said(&dir, &["analyse", "ball.toml"]).contains("'analyze'"));
    assert!(said(&dir, &["analyze", "ball.toml", "--jsn"]).contains("'--json'"));
    let nothing = said(&dir, &["simulate", "ball.toml"]);
    assert!(nothing.contains("--scenario ball_scenario.toml") && nothing.contains("--inputs FILE.csv"), "{nothing}");
}

#[test]
fn every_command_that_draws_at_random_says_what_a_seed_is() {
    let dir = scratch("seeds");
    for command in [
        &["demo"][..],
        &["control", "p"],
        &["diagnose", "m", "d"],
        &["simulate", "m"],
        &["steer", "m", "--to", "x=1"],
        &["trim", "m"],
    ] {
        for seed in ["abc", "-1", "1.5", "18446744073709551616"] {
            let message = said(&dir, &[command, &["--seed", seed]].concat());
            assert!(
                message.contains(seed) && message.contains("a whole number from 0 to 18446744073709551615"),
                "{message}"
            );
        }
    }
}

/// The place, the mark below the text, and the remedy.
#[test]
fn errors_in_files_show_the_line_and_mark_the_text() {
    let dir = scratch("marks");
    file(&dir, "slider.toml", SLIDER);
    let model = |change: (&str, &str)| SLIDER.replace(change.0, change.1);
    let scenario = |inputs: &str| format!("duration = 1\n{inputs}");
    let files: Vec<(&str, String, [&str; 3])> = vec![
        (
            "key.toml",
            model(("[dynamics]", "[dynamic]")),
            ["key.toml:5:2: unknown key `dynamic`", "   |  ^^^^^^^", "did you mean `dynamics`?"],
        ),
        (
            "name.toml",
            model(("sign(velocity)", "sign(velocty)")),
            ["name.toml:7:", "^^^^^^^", "did you mean `velocity`?"],
        ),
        (
            "type.toml",
            model(("0.3", "'rough'")),
            ["type.toml:4:6: `mu` must be a number, not text", "      ^^^^^^^", "without quotes"],
        ),
        ("nan.toml", model(("0.3", "nan")), ["nan.toml:4:6: `mu` is not a finite number", "^^^", "finite number"]),
        ("bare.toml", model(("'velocity'\n", "velocity\n")), ["bare.toml:6:5:", "^", "in quotes"]),
        (
            "open.toml",
            model(("= 'velocity'\n", "= 'velocity\n")),
            ["open.toml:6:", "^", "close the quotes on the same line"],
        ),
        ("list.toml", model(("'velocity']", "'velocity'")), ["list.toml:2:1:", "^", "`]` at its end"]),
        (
            "twice.toml",
            model(("mu = 0.3", "mu = 0.3\nmu = 0.4")),
            ["twice.toml:5:1: duplicate key", "^^", "remove or rename"],
        ),
        ("product.toml", model(("mu*9.81", "2mu*9.81")), ["product.toml:7:17:", "                 ^^", "`*`"]),
        ("empty.toml", String::new(), ["empty.toml: the model has no states", "", "states = ["]),
        ("zero.toml", "\0\u{1}\0".into(), ["zero.toml:", "", ""]),
        (
            "x0.toml",
            scenario("[x0]\nvelocty = 1\n"),
            ["x0.toml:3:1: unknown key `velocty`", "^^^^^^^", "did you mean `velocity`?"],
        ),
        ("x0_text.toml", scenario("[x0]\nx = 'far'\n"), ["x0_text.toml:3:6: unknown name `far`", "     ^^^", ""]),
        (
            "input.toml",
            scenario("[inputs]\na = '3*sin(tt)'\n"),
            ["input.toml:3:12: unknown name `tt`", "           ^^", "expressions in t and the model's parameters: mu"],
        ),
        ("closed.toml", scenario("[inputs]\na = 'sin(t'\n"), ["closed.toml:3:", "^", "add `)`"]),
        (
            "text.csv",
            "t,a\n0,1\n1,fast\n".into(),
            ["text.csv:3:3: line 3, column `a`: `fast` is not a finite number", "  ^^^^", "correct or remove the row"],
        ),
        (
            "order.csv",
            "t,a\n0,1\n2,1\n1,2\n".into(),
            ["order.csv:4:1: line 4: the time does not increase", "^", "sort the rows"],
        ),
        (
            "ragged.csv",
            "t,a\n0,1\n1\n".into(),
            ["ragged.csv:3:1: line 3 has 1 entry, the header 2 entries", "^", "as many entries as the header"],
        ),
        (
            "column.csv",
            "t,b\n0,1\n1,1\n".into(),
            ["column.csv: no column has the name of an input", "", "name the columns after the inputs: a"],
        ),
        ("time.csv", "s,a\n0,1\n1,1\n".into(), ["there is no column `t`; the columns are s, a", "", "add a column t"]),
        ("semicolon.csv", "t;a\n0,5;1\n1;1\n".into(), ["separated by semicolons", "", "decimal points"]),
        ("tabs.csv", "t\ta\n0\t1\n1\t1\n".into(), ["separated by tabs", "", "by commas"]),
        ("blanks.csv", "  t    a\n0.0  1.0\n1.0  1.0\n".into(), ["separated by blanks", "", "by commas"]),
        ("decimal.csv", "t,a\n0,0,1,5\n1,0,1,5\n".into(), ["has 4 entries, the header 2", "^", "0.5, not 0,5"]),
        (
            "comma.csv",
            "t,a,\n0,1,\n1,1,\n".into(),
            ["column 3 (without a name): the entry is empty", "", "remove the comma"],
        ),
        ("quote.csv", "t,\"a\n0,1\n".into(), ["quotation mark in the header is not closed", "", "t,u,x"]),
        ("none.csv", String::new(), ["none.csv: the table is empty", "", "start with a header such as t,u,x"]),
        ("blank_lines.csv", "\n \n# t,a\n".into(), ["blank_lines.csv: the table is empty", "", "a row of numbers"]),
        (
            "headless.csv",
            "0,1\n1,1\n".into(),
            ["headless.csv:1:1: the first line contains numbers", "   | ^^^", "start with a header"],
        ),
        ("dot.toml", model(("0.3", ".3")), ["dot.toml:4:6: invalid mantissa", "^", "0.01"]),
        ("bracket.toml", model(("[parameters]", "[para meters]")), ["bracket.toml:3:", "^", "letters, digits"]),
        ("rows.csv", "t,a\n".into(), ["rows.csv: the table has no rows", "", "two samples"]),
    ];
    for (name, content, parts) in files {
        file(&dir, name, &content);
        let arguments: Vec<&str> = match name {
            n if n.strip_suffix(".csv").is_some() => vec!["simulate", "slider.toml", "--inputs", n],
            n @ ("x0.toml" | "x0_text.toml" | "input.toml" | "closed.toml") => {
                vec!["simulate", "slider.toml", "--scenario", n]
            }
            n => vec!["analyze", n],
        };
        let message = said(&dir, &arguments);
        for part in parts {
            assert!(message.contains(part), "{name}: `{part}` in: {message}");
        }
    }
    // The mark stands below the text that it means.
    let message = said(&dir, &["simulate", "slider.toml", "--inputs", "text.csv"]);
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!((lines[1], lines[2]), ("   | 1,fast", "   |   ^^^^"));
    let table = "t,a,x,velocity\n0,1,2,0\n0.1,1,3,zero\n";
    file(&dir, "run.csv", table);
    let message = said(&dir, &["diagnose", "slider.toml", "run.csv"]);
    assert!(
        message.contains("run.csv:3:9: line 3, column `velocity`") && message.contains("   |         ^^^^"),
        "{message}"
    );
}

/// What `simulate` says of an equation that loses its value on the way.
fn stopped(dir: &Path, v: &str, x0: &str, input: &str) -> (i32, String) {
    file(
        dir,
        "m.toml",
        &format!(
            "states = ['x', 'v']\ninputs = ['u']\nparameters = {{ c = 0.1 }}\n[dynamics]\nx = 'v'\nv = '{v}'\n[point]\nx = '{x0}'\n"
        ),
    );
    file(dir, "s.toml", &format!("duration = 5\n[inputs]\nu = '{input}'\n"));
    let o = within(dir, &["simulate", "m.toml", "--scenario", "s.toml"]);
    (code(&o), text(&o.stdout))
}

#[test]
fn an_equation_without_a_value_is_named_with_the_part_that_has_none() {
    let dir = scratch("no_value");
    for (v, x0, parts) in [
        ("-1 - sqrt(x)", "0.5", ["in the equation of `v`, `sqrt(x)` has no value where `x` is below 0", "max(x, 0)"]),
        ("u*sqrt(x - 1)", "0.5", ["`sqrt(x - 1)` has no value where `x - 1` is below 0", "max(x - 1, 0)"]),
        (
            "-1 + c*log(x)",
            "0.5",
            ["in the equation of `v`, `log(x)` has no value where `x` is 0 or below", "defined beyond it"],
        ),
        ("-1 + asin(x)", "0.5", ["`asin(x)` has no value where `x` is outside -1 to 1", "defined beyond it"]),
        ("u/x", "0", ["in the equation of `v`, the denominator `x` is 0", "start elsewhere"]),
        ("-1 - c/x", "0.5", ["`v` diverges there", "divides by a value near 0"]),
        ("exp(x)^2", "0.5", ["in the equation of `v`", "`exp(x)^2` overflows"]),
    ] {
        let (exit, report) = stopped(&dir, v, x0, "1");
        assert!(exit == 1 && report.contains("stopped at t = "), "{v}: {report}");
        for part in parts {
            assert!(report.contains(part), "{v}: `{part}` in {report}");
        }
    }
    let (exit, report) = stopped(&dir, "u", "0", "sqrt(1 - t)");
    assert!(exit == 1 && report.contains("the input `u` has no finite value"), "{report}");
    assert!(report.contains("stopped at t = 1 s"), "{report}");
}

#[test]
fn a_parameter_that_makes_a_denominator_zero_is_named_by_every_command() {
    let dir = scratch("zero_denominator");
    file(
        &dir,
        "m.toml",
        "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 0, k = 1 }\n[dynamics]\nx = 'v'\nv = '(u - k*x)/m'\n",
    );
    file(&dir, "s.toml", "duration = 1\n[inputs]\nu = '1'\n");
    file(
        &dir,
        "p.toml",
        "model = 'm.toml'\nhorizon = { steps = 5, dt = 0.1 }\ncost = { stage = 'x^2 + u^2' }\nrun = { steps = 3 }\n",
    );
    file(&dir, "run.csv", "t,u,x\n0,1,2\n1,1,2\n");
    for arguments in [
        &["analyze", "m.toml"][..],
        &["simulate", "m.toml", "--scenario", "s.toml"],
        &["control", "p.toml"],
        &["diagnose", "m.toml", "run.csv"],
        &["export", "m.toml", "--language", "c", "--parameters", "k"],
    ] {
        let message = said(&dir, arguments);
        assert!(
            message.contains("the denominator `m` in the equation of `v` is 0 with m = 0"),
            "{arguments:?}: {message}"
        );
    }
    // A scenario may give the value that counts.
    file(&dir, "s.toml", "duration = 1\n[inputs]\nu = '1'\n[parameters]\nm = 2\n");
    assert_eq!(code(&within(&dir, &["simulate", "m.toml", "--scenario", "s.toml"])), 0);
}

#[test]
fn data_that_cannot_tell_end_with_1_and_a_remedy() {
    type Signal = fn(f64) -> f64;
    let dir = scratch("dead_data");
    assert_eq!(code(&within(&dir, &["new", "ball"])), 0);
    let rows = |u: Signal, x: Signal| {
        let line = |k: u32| (f64::from(k) * 0.01, u(f64::from(k) * 0.01), x(f64::from(k) * 0.01));
        let lines = (0..400).map(line).map(|(t, u, x)| format!("{t},{u},{x}"));
        ["t,u,position".to_owned()].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
    };
    let still: Signal = |_| 0.0;
    let cases: [(Signal, Signal, &str); 3] = [
        (still, still, "no input moves: drive the device"),
        (|_| 1.0, |_| 0.3, "no input moves: drive the device"),
        (|t| (3.0 * t).sin(), |_| 0.2, "a sensor is dead"),
    ];
    for (u, x, remedy) in cases {
        file(&dir, "run.csv", &rows(u, x));
        let o = within(&dir, &["diagnose", "ball.toml", "run.csv"]);
        let report = text(&o.stdout);
        assert!(code(&o) == 1 && report.contains("ball: uninformative data") && report.contains(remedy), "{report}");
        assert!(!report.contains('±') && !report.contains("95 %"), "{report}");
        let o = within(&dir, &["diagnose", "ball.toml", "run.csv", "--json", "--out", "out"]);
        let found: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
        assert_eq!((found["verdict"].as_str(), &found["parameters"]), (Some("uninformative"), &serde_json::json!({})));
        assert!(fs::read_to_string(dir.join("out/diagnosis.html")).unwrap().contains("uninformative data"));
    }
}
