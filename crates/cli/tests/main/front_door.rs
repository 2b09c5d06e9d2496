//! What a newcomer meets at the command line: help, completion, manual pages, templates, and answers to mistakes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{bracketry, code, file, json, scratch, text, within};

const COMMANDS: [&str; 20] = [
    "demo",
    "new",
    "analyze",
    "affinize",
    "trim",
    "linearize",
    "certify",
    "transform",
    "export",
    "steer",
    "simulate",
    "control",
    "diagnose",
    "experiment",
    "plate",
    "publication",
    "reproduce",
    "stiffness",
    "completions",
    "man",
];

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

/// A long example is broken before options, only where it must be, and reads as one command: no terminal of 80 columns wraps it.
#[test]
fn examples_are_broken_before_options_where_they_are_long() {
    let mut broken = Vec::new();
    let stiffness = ["identify", "poses", "weigh", "compensate"].map(|name| vec!["stiffness", name]);
    for name in COMMANDS.map(|name| vec![name]).into_iter().chain(stiffness) {
        let help = text(&bracketry(&[name.as_slice(), &["--help"]].concat()).stdout);
        let mut lines = help.lines();
        let mut count = 0;
        while let Some(first) = lines.next() {
            if !first.starts_with("    bracketry ") {
                continue;
            }
            count += 1;
            let mut command = vec![first.trim()];
            while let Some(part) = command[command.len() - 1].strip_suffix(" \\") {
                *command.last_mut().unwrap() = part;
                let next = lines.next().unwrap();
                assert!(next.starts_with("      --"), "{first}: {next}");
                command.push(next.trim());
            }
            // What has no option in it has no place for a break.
            assert!(command.iter().all(|part| part.len() <= 74 || !part.contains(" --")), "{command:?}");
            for pair in command.windows(2) {
                let option = pair[1].split(" --").next().unwrap();
                assert!(pair[0].len() + 1 + option.len() + 2 > 74, "{pair:?} would fit");
            }
            if command.len() > 1 {
                broken.push(command.join(" "));
            }
        }
        assert!(count > 0, "{name:?}: {help}");
    }
    let long = "bracketry simulate models/plate_published.toml --scenario models/plate_experiment_2.toml --out out";
    assert!(broken.iter().any(|command| command == long), "{broken:?}");
}

#[test]
fn marks_and_remedies_are_colored_and_nothing_else() {
    let dir = scratch("colored");
    let model = file(&dir, "m.toml", "states = ['v']\ninputs = ['u']\n[dynamics]\nv = 'u + w'\n");
    let run = |variable: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bracketry"));
        command.args(["analyze", &model]).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env(variable, "1");
        text(&command.output().unwrap().stderr)
    };
    let (plain, shown) = (run("NO_COLOR"), run("CLICOLOR_FORCE"));
    // Without what switches colors, ESC [ … m, the text is the same.
    let stripped: String =
        shown.split('\u{1b}').enumerate().map(|(k, s)| if k == 0 { s } else { s.split_once('m').unwrap().1 }).collect();
    assert_eq!(stripped, plain);
    assert!(plain.lines().any(|l| l.contains('^')) && plain.lines().any(|l| l.starts_with("   = ")), "{plain}");
    for (shown, plain) in shown.lines().zip(plain.lines()) {
        // The word "error:" has a color of its own.
        let shown = if plain.starts_with("error:") { shown.split_once(' ').unwrap().1 } else { shown };
        let mark = plain.strip_prefix("   | ").is_some_and(|l| l.chars().all(|c| c == ' ' || c == '^'));
        assert_eq!(shown.contains('\u{1b}'), mark || plain.starts_with("   = "), "{shown:?}");
    }
}

#[test]
fn nothing_is_colored_but_where_it_is_asked_for() {
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
    // Bash itself reads the script, where there is one; what Windows calls bash may be another system.
    if cfg!(windows) {
        return;
    }
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
    assert!(
        code(&o) == 2 && text(&o.stderr).contains("the commands are demo, new, analyze, affinize"),
        "{}",
        text(&o.stderr)
    );
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
    assert!(code(&o) == 2 && text(&o.stderr).contains("was not changed"), "{}", text(&o.stderr));
    assert_eq!(fs::read_to_string(problem).unwrap(), "mine");
    assert!(!Path::new(model).exists());
    for name in ["../up", "a b", "", ".toml", "x/y", "-x"] {
        let o = within(&dir, &["new", "--", name]);
        assert!(code(&o) == 2 && text(&o.stderr).contains("letters, digits"), "{name}: {}", text(&o.stderr));
    }
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
    assert!(refused("y=-1").contains("is not a standard deviation"));
    assert!(refused("y=nan").contains("is not a standard deviation"));
    assert!(refused("y=1,y=2").contains("measured twice"));
    assert!(refused("y").contains("x=0.001"));
    let alone = bracketry(&["simulate", &model, "--scenario", &scenario, "--noise", "y=0.1"]);
    assert!(code(&alone) == 2 && text(&alone.stderr).contains("--out"), "{}", text(&alone.stderr));
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
    assert!(help.contains("0  decided: every generic dimension, the requests of --at"), "{help}");
}
