//! What a newcomer meets at the command line: help, completion, manual pages, templates, and answers to mistakes.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use common::{bracketry, code, file, json, scratch};

const COMMANDS: [&str; 10] =
    ["new", "analyze", "affinize", "simulate", "control", "diagnose", "plate", "stiffness", "completions", "man"];

const SLIDER: &str = "states = ['x', 'velocity']\ninputs = ['a']\n[parameters]\nmu = 0.3\n\
                      [dynamics]\nx = 'velocity'\nvelocity = 'a - mu*9.81*sign(velocity)'\n";

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn within(dir: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bracketry")).args(arguments).current_dir(dir).output().unwrap()
}

#[test]
fn every_command_has_help_with_examples() {
    let all = text(&bracketry(&["--help"]).stdout);
    assert!(all.contains("Exit codes:") && all.contains("Units:"), "{all}");
    // In the order in which they are used.
    let places =
        COMMANDS.map(|command| all.find(&format!("\n  {command} ")).unwrap_or_else(|| panic!("{command} in {all}")));
    assert!(places.is_sorted(), "{all}");
    for command in COMMANDS {
        let help = text(&bracketry(&[command, "--help"]).stdout);
        assert!(help.contains("Examples:") && help.contains(&format!("bracketry {command} ")), "{help}");
    }
    for command in ["identify", "poses", "weigh", "compensate"] {
        let help = text(&bracketry(&["stiffness", command, "--help"]).stdout);
        assert!(help.contains(&format!("bracketry stiffness {command} ")) && help.contains("Exit codes:"), "{help}");
    }
    for command in ["analyze", "simulate", "control", "diagnose"] {
        let help = text(&bracketry(&[command, "--help"]).stdout);
        assert!(help.contains("Exit codes:\n  0  "), "{help}");
    }
}

#[test]
fn nothing_is_coloured_but_where_it_is_asked_for() {
    let run = |variable: Option<&str>, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bracketry"));
        command.args(arguments).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        if let Some(variable) = variable {
            command.env(variable, "1");
        }
        let o = command.output().unwrap();
        text(&o.stdout) + &text(&o.stderr)
    };
    for arguments in [&["--help"][..], &["analyze", "missing.toml"], &["analyse"]] {
        let plain = run(None, arguments);
        assert!(!plain.is_empty() && !plain.contains('\u{1b}'), "{plain}");
        assert!(!run(Some("NO_COLOR"), arguments).contains('\u{1b}'));
        assert!(run(Some("CLICOLOR_FORCE"), arguments).contains('\u{1b}'));
    }
}

#[test]
fn shells_complete_every_command() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = text(&bracketry(&["completions", shell]).stdout);
        assert!(COMMANDS.iter().all(|c| script.contains(c)) && script.contains("markdown"), "{shell}");
    }
    assert_eq!(code(&bracketry(&["completions", "bash", "--json"])), 2);
    // Bash itself reads the script, where there is one.
    let dir = scratch("completions");
    let script = file(&dir, "bracketry.bash", &text(&bracketry(&["completions", "bash"]).stdout));
    let ask = "source \"$0\"; COMP_WORDS=(bracketry ana); COMP_CWORD=1; _bracketry bracketry ana bracketry; echo \"${COMPREPLY[@]}\"";
    if let Ok(o) = Command::new("bash").args(["-c", ask, &script]).output() {
        assert_eq!(text(&o.stdout).trim(), "analyze", "{}", text(&o.stderr));
    }
}

#[test]
fn manual_pages_exist_for_every_command() {
    let dir = scratch("man");
    let o = bracketry(&["man", "--out", dir.to_str().unwrap()]);
    assert_eq!(code(&o), 0, "{}", text(&o.stderr));
    for name in COMMANDS
        .iter()
        .map(|c| format!("bracketry-{c}"))
        .chain(["bracketry".into(), "bracketry-stiffness-identify".into()])
    {
        let page = fs::read_to_string(dir.join(format!("{name}.1"))).unwrap();
        let title = name.replace('-', "\\-");
        assert!(page.contains(&format!(".TH {name} 1")) && page.contains(&format!("{title} \\- ")), "{name}");
        assert!(!page.contains('\u{1b}'), "{name}");
    }
    let page = fs::read_to_string(dir.join("bracketry-stiffness-identify.1")).unwrap();
    assert_eq!(text(&bracketry(&["man", "stiffness", "identify"]).stdout), page);
    let o = bracketry(&["man", "analyse"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("there are new, analyze, affinize"), "{}", text(&o.stderr));
}

/// The same numbers whenever the test runs: sums of twelve uniform ones, of a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (*state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
    }
}

/// The columns of a trajectory that a plant would have given: `t`, the inputs, and the measured ones with noise of a thousandth
/// of their standard deviation.
fn measured(trajectory: &Path, inputs: &[&str], outputs: &[&str]) -> String {
    let table = fs::read_to_string(trajectory).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect();
    let column = |name: &str| {
        let k = header.iter().position(|h| *h == name).unwrap();
        rows.iter().map(|r| r[k]).collect::<Vec<f64>>()
    };
    let mut noise = Noise(1);
    let mut columns = vec![column("t")];
    columns.extend(inputs.iter().map(|name| column(name)));
    for name in outputs {
        let mut values = column(name);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        for v in &mut values {
            *v += 1e-3 * std * noise.next();
        }
        columns.push(values);
    }
    let names: Vec<&str> = ["t"].into_iter().chain(inputs.iter().copied()).chain(outputs.iter().copied()).collect();
    let lines = (0..rows.len()).map(|i| columns.iter().map(|c| c[i].to_string()).collect::<Vec<_>>().join(","));
    [names.join(",")].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_template_runs_through_analyze_simulate_control_and_diagnose() {
    let templates: [(&str, &[&str], &[&str]); 5] = [
        ("spring", &["u"], &["x"]),
        ("friction", &["u"], &["x"]),
        ("pendulum", &["tau"], &["th"]),
        ("vehicle", &["s", "r"], &["x", "y"]),
        ("tanks", &["q"], &["h2"]),
    ];
    let help = text(&bracketry(&["new", "--help"]).stdout);
    for (template, inputs, outputs) in templates {
        assert!(help.contains(&format!("- {template}:")), "{template} in {help}");
        let dir = scratch(&format!("template_{template}"));
        let written = within(&dir, &["new", "mine", "--template", template]);
        assert_eq!(code(&written), 0, "{}", text(&written.stderr));
        // The commands that it names are those to type next.
        let shown = text(&written.stdout);
        let next: Vec<&str> = shown.lines().filter_map(|l| l.strip_prefix("  bracketry ")).collect();
        assert_eq!(next.len(), 4, "{shown}");
        assert!(next[3].starts_with("diagnose ") && next[3].contains("--hold linear"), "{shown}");
        for command in next {
            let o = within(&dir, &command.split(' ').collect::<Vec<_>>());
            assert_eq!(code(&o), 0, "{template}: {command}\n{}{}", text(&o.stdout), text(&o.stderr));
        }
        file(&dir, "run.csv", &measured(&dir.join("out/trajectory.csv"), inputs, outputs));
        let o = within(&dir, &["diagnose", "mine.toml", "run.csv", "--hold", "linear", "--json"]);
        assert_eq!(code(&o), 0, "{template}: {}", text(&o.stderr));
        let verdict: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
        assert_eq!(verdict["verdict"], "nothing_found", "{template}: {}", verdict["reason"]);
    }
}

#[test]
fn a_new_model_overwrites_nothing() {
    let dir = scratch("new");
    let v = json(&["new", "ball.toml", "--out", dir.join("a/b").to_str().unwrap(), "--json"]);
    let model = v["model"].as_str().unwrap();
    assert!(model.ends_with("ball.toml") && fs::read_to_string(model).unwrap().contains("name   = \"ball\""));
    fs::remove_file(model).unwrap();
    let problem = v["problem"].as_str().unwrap();
    fs::write(problem, "mine").unwrap();
    let o = bracketry(&["new", "ball", "--out", dir.join("a/b").to_str().unwrap()]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("is left as it is"), "{}", text(&o.stderr));
    assert_eq!(fs::read_to_string(problem).unwrap(), "mine");
    assert!(!Path::new(model).exists());
    for name in ["../up", "a b", "", ".toml", "x/y", "-x"] {
        let o = within(&dir, &["new", "--", name]);
        assert!(code(&o) == 2 && text(&o.stderr).contains("letters, digits"), "{name}: {}", text(&o.stderr));
    }
}

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
    file(&dir, "robot.toml", &fs::read_to_string(common::model("kr125.toml")).unwrap());
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
        (&["stiffness", "identify", "ball.toml", "robot.toml"], &["each of ball.toml and robot.toml ends in .toml"]),
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
            ["column.csv: no column is called like an input", "", "name the columns after the inputs: a"],
        ),
        ("time.csv", "s,a\n0,1\n1,1\n".into(), ["there is no column `t`; the columns are s, a", "", "add a column t"]),
        ("semicolon.csv", "t;a\n0,5;1\n1;1\n".into(), ["separated by semicolons", "", "decimal points"]),
        ("tabs.csv", "t\ta\n0\t1\n1\t1\n".into(), ["separated by tabs", "", "by commas"]),
        ("blanks.csv", "  t    a\n0.0  1.0\n1.0  1.0\n".into(), ["separated by blanks", "", "by commas"]),
        ("decimal.csv", "t,a\n0,0,1,5\n1,0,1,5\n".into(), ["has 4 entries, the header 2", "^", "0.5, not 0,5"]),
        ("comma.csv", "t,a,\n0,1,\n1,1,\n".into(), ["column 3 (without a name): the entry is empty", "", "take away"]),
        ("quote.csv", "t,\"a\n0,1\n".into(), ["quotation mark in the header is not closed", "", "t,u,x"]),
        ("none.csv", String::new(), ["none.csv: the table is empty", "", "begin with a header such as t,u,x"]),
        ("blank_lines.csv", "\n \n# t,a\n".into(), ["blank_lines.csv: the table is empty", "", "a row of numbers"]),
        (
            "headless.csv",
            "0,1\n1,1\n".into(),
            ["headless.csv:1:1: the first line holds numbers", "   | ^^^", "begin with a header"],
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

#[test]
fn states_of_scenarios_may_be_constants() {
    let dir = scratch("constants");
    let model = file(&dir, "m.toml", "states = ['th']\ninputs = ['u']\n[dynamics]\nth = 'u'\n");
    let scenario = file(&dir, "s.toml", "duration = 1\n[x0]\nth = 'pi/2'\n");
    let v = json(&["simulate", &model, "--scenario", &scenario, "--json"]);
    assert_eq!(v["x_final"]["th"].as_f64(), Some(std::f64::consts::FRAC_PI_2));
}

#[test]
fn a_recorded_run_gives_the_same_run_in_spite_of_a_delay() {
    let dir = scratch("recorded_delay");
    let model = file(&dir, "m.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u - x'\n[delays]\nu = 0.25\n");
    let scenario = file(&dir, "s.toml", "duration = 2\nsample = 0.001\n[inputs]\nu = 'sin(3*max(t - 0.5, 0))'\n");
    let out = dir.join("out");
    let first = json(&["simulate", &model, "--scenario", &scenario, "--json", "--out", out.to_str().unwrap()]);
    let table = out.join("trajectory.csv");
    let again = json(&["simulate", &model, "--inputs", table.to_str().unwrap(), "--hold", "linear", "--json"]);
    let x = |v: &serde_json::Value| v["x_final"]["x"].as_f64().unwrap();
    assert!((x(&first) - x(&again)).abs() < 1e-6, "{first} {again}");
    // x' + x = u(t − 0.25), by the formula for sin 3t from 0.75 on.
    let t: f64 = 1.25;
    let exact = (3.0 * (-t).exp() + (3.0 * t).sin() - 3.0 * (3.0 * t).cos()) / 10.0;
    assert!((x(&first) - exact).abs() < 1e-6, "{} {exact}", x(&first));
}

#[test]
fn measurements_have_the_noise_that_is_asked_for() {
    let dir = scratch("noise");
    let model = file(&dir, "m.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u'\n[outputs]\ny = '2*x'\n");
    let scenario = file(&dir, "s.toml", "duration = 100\nsample = 0.01\n[inputs]\nu = 'cos(t)'\n");
    let measured = |seed: &str, folder: &str| {
        let out = dir.join(folder);
        let arguments = ["simulate", &model, "--scenario", &scenario, "--noise", "y=0.1,x=0"];
        let o = bracketry(&[&arguments[..], &["--seed", seed, "--out", out.to_str().unwrap()]].concat());
        assert_eq!(code(&o), 0, "{}", text(&o.stderr));
        fs::read_to_string(out.join("measured.csv")).unwrap()
    };
    let table = measured("1", "a");
    assert_eq!(table.lines().next(), Some("t,u,y,x"));
    let errors: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|f| f.parse::<f64>().unwrap()).collect::<Vec<_>>())
        .inspect(|r| assert!((r[1] - r[0].cos()).abs() < 1e-12 && (r[3] - r[0].sin()).abs() < 1e-7, "{r:?}"))
        .map(|r| r[2] - 2.0 * r[3])
        .collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let std = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
    // Four standard errors of 10001 samples.
    assert!(mean.abs() < 4.0 * 0.1 / n.sqrt() && (std / 0.1 - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{mean} {std}");
    assert_eq!(measured("1", "b"), table);
    assert_ne!(measured("2", "c"), table);
    let out = dir.join("d");
    let refused = |noise: &str| {
        let o =
            bracketry(&["simulate", &model, "--scenario", &scenario, "--noise", noise, "--out", out.to_str().unwrap()]);
        assert_eq!(code(&o), 2, "{noise}");
        text(&o.stderr)
    };
    assert!(refused("z=0.1").contains("`z` is neither an output nor a state of the model: it has y, x"));
    assert!(refused("y=-1").contains("is no standard deviation"));
    assert!(refused("y=nan").contains("is no standard deviation"));
    assert!(refused("y=1,y=2").contains("measured twice"));
    assert!(refused("y").contains("x=0.001"));
    let alone = bracketry(&["simulate", &model, "--scenario", &scenario, "--noise", "y=0.1"]);
    assert!(code(&alone) == 2 && text(&alone.stderr).contains("--out"), "{}", text(&alone.stderr));
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
            ["in the equation of `v`, `log(x)` has no value where `x` is 0 or below", "holds beyond"],
        ),
        ("-1 + asin(x)", "0.5", ["`asin(x)` has no value where `x` is beyond -1 to 1", "holds beyond"]),
        ("u/x", "0", ["in the equation of `v`, `x` stands in a denominator and is 0", "begin elsewhere"]),
        ("-1 - c/x", "0.5", ["`v` runs away there", "or divides by what comes near 0"]),
        ("exp(x)^2", "0.5", ["in the equation of `v`", "`exp(x)^2` grows beyond all numbers"]),
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
fn times_far_from_zero_are_simulated() {
    let dir = scratch("far_times");
    file(&dir, "m.toml", "states = ['x']\ninputs = ['u']\n[dynamics]\nx = 'u'\n");
    // Milliseconds and nanoseconds since 1970, taken for seconds.
    for t in [1.7e12, 1.7e18] {
        file(&dir, "run.csv", &format!("t,u\n{t},2\n{},2\n{},2\n", t + 1e6, t + 2e6));
        let v = json_of(&within(&dir, &["simulate", "m.toml", "--inputs", "run.csv", "--json"]));
        assert!((v["x_final"]["x"].as_f64().unwrap() / 4e6 - 1.0).abs() < 1e-3, "{v}");
    }
}

fn json_of(o: &Output) -> serde_json::Value {
    assert_eq!(code(o), 0, "{}", text(&o.stderr));
    serde_json::from_slice(&o.stdout).unwrap()
}

/// Every dimension counts that was asked for, not just some: here the generic ones are decided and those at the point are not.
#[test]
fn analyze_ends_with_1_where_a_dimension_is_undecided() {
    let dir = scratch("undecided");
    file(&dir, "m.toml", "states = ['x', 'y']\ninputs = ['u']\n[dynamics]\nx = 'u'\ny = 'x/y'\n");
    assert_eq!(code(&within(&dir, &["analyze", "m.toml"])), 0);
    let at = |point: &str| within(&dir, &["analyze", "m.toml", "--at", point]);
    assert_eq!(code(&at("y=1")), 0);
    let o = at("y=0");
    assert!(code(&o) == 1 && text(&o.stdout).contains("unknown"), "{}", text(&o.stdout));
    let help = text(&bracketry(&["analyze", "--help"]).stdout);
    assert!(help.contains("0  every generic dimension is decided, and what --at"), "{help}");
}

#[test]
fn data_that_cannot_tell_end_with_1_and_a_remedy() {
    let dir = scratch("dead_data");
    assert_eq!(code(&within(&dir, &["new", "ball"])), 0);
    let rows = |u: fn(f64) -> f64, x: fn(f64) -> f64| {
        let line = |k: u32| (f64::from(k) * 0.01, u(f64::from(k) * 0.01), x(f64::from(k) * 0.01));
        let lines = (0..400).map(line).map(|(t, u, x)| format!("{t},{u},{x}"));
        ["t,u,position".to_owned()].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
    };
    let still: fn(f64) -> f64 = |_| 0.0;
    let cases: [(fn(f64) -> f64, fn(f64) -> f64, &str); 3] = [
        (still, still, "no input moves: drive the device"),
        (|_| 1.0, |_| 0.3, "no input moves: drive the device"),
        (|t| (3.0 * t).sin(), |_| 0.2, "a sensor is dead"),
    ];
    for (u, x, remedy) in cases {
        file(&dir, "run.csv", &rows(u, x));
        let o = within(&dir, &["diagnose", "ball.toml", "run.csv"]);
        let report = text(&o.stdout);
        assert!(code(&o) == 1 && report.contains("ball: the data cannot tell") && report.contains(remedy), "{report}");
        assert!(!report.contains('±') && !report.contains("95 %"), "{report}");
        let o = within(&dir, &["diagnose", "ball.toml", "run.csv", "--json", "--out", "out"]);
        let found: serde_json::Value = serde_json::from_slice(&o.stdout).unwrap();
        assert_eq!((found["verdict"].as_str(), &found["parameters"]), (Some("uninformative"), &serde_json::json!({})));
        assert!(fs::read_to_string(dir.join("out/diagnosis.html")).unwrap().contains("the data cannot tell"));
    }
}
