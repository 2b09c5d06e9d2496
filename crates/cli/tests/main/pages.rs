//! The pages that commands write with `--out`: made alike, with links to the files beside them. `tests/browser` tries them in a browser.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::pages::{assert_all_linked, assert_page, is_page};
use crate::common::robots::{log, measurements};
use crate::common::{bracketry, code, file, model, root, scratch, text};

/// Runs a command with `--out`, and gives the page that it says it has written.
fn page(name: &str, arguments: &[&str]) -> (String, PathBuf) {
    let out = scratch(name).join("out");
    let o = bracketry(&[arguments, &["--out", out.to_str().unwrap()]].concat());
    assert!(code(&o) < 2, "{}", text(&o.stderr));
    let pages: Vec<PathBuf> = fs::read_dir(&out).unwrap().map(|e| e.unwrap().path()).filter(|p| is_page(p)).collect();
    assert_eq!(pages.len(), 1, "{pages:?}");
    let page = fs::read_to_string(&pages[0]).unwrap();
    assert_page(&page, Some(&out));
    (page, out)
}

fn guide(name: &str) -> String {
    root().join("docs/getting_started").join(name).to_str().unwrap().to_owned()
}

#[test]
fn a_simulation_has_a_page() {
    let (ball, scenario) = (guide("ball.toml"), guide("ball_scenario.toml"));
    let (page, out) = page("page_simulate", &["simulate", &ball, "--scenario", &scenario, "--noise", "position=0.001"]);
    assert_all_linked(&page, &out);
    for part in ["12 s simulated", "data-title=\"v", "<h2 id=\"s-mode-changes\">", "measured.csv"] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_closed_loop_has_a_page() {
    let (page, out) = page("page_control", &["control", &guide("ball_problem.toml")]);
    assert_all_linked(&page, &out);
    for part in ["step time", "final r", "<svg role=\"img\"", "predictions.csv"] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn an_analysis_has_a_page() {
    let (page, out) = page("page_analyze", &["analyze", &model("unicycle.toml")]);
    assert_all_linked(&page, &out);
    for part in
        ["the inputs reach a set of full dimension 3 of 3.", "strongly accessible", "affine.toml", "<math>", "<title>"]
    {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_run_on_the_plate_has_a_page_with_its_animation() {
    let (page, out) = page("page_plate", &["plate", "1", "--seconds", "0.5", "--gif"]);
    assert_all_linked(&page, &out);
    for part in ["data:image/gif;base64,", "data:image/png;base64,", "aria-pressed", "Assumptions", "Target: phi"] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn stiffness_commands_have_pages() {
    let dir = scratch("page_stiffness");
    let (robot, data) = (model("kr125.toml"), file(&dir, "data.csv", &measurements(12, [1.0; 3])));
    let run = file(&dir, "log.csv", &log(|_, _, v| v));
    for (name, arguments, part) in [
        ("page_identify", ["stiffness", "identify", &data, &robot], "Joint springs"),
        ("page_poses", ["stiffness", "poses", &data, &robot], "most informative"),
        ("page_compensate", ["stiffness", "compensate", &run, &robot], "predicted displacement"),
    ] {
        let (page, out) = page(name, &arguments);
        assert_all_linked(&page, &out);
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn a_page_is_opened_only_with_a_folder_for_it() {
    let ball = guide("ball.toml");
    let o = bracketry(&["analyze", &ball, "--open"]);
    assert!(code(&o) == 2 && text(&o.stderr).contains("--out DIR"), "{}", text(&o.stderr));
}

#[test]
fn all_kinds_of_analysis_have_a_page() {
    let (unicycle, table) = (model("unicycle.toml"), model("shaken_table.toml"));
    let pendulum = model("cart_pole.toml");
    let bounds = "der(X,2)=-4..4";
    for (name, arguments) in [
        ("identifiability", vec!["analyze", &unicycle, "--identifiability"]),
        ("parameters", vec!["analyze", &pendulum, "--parameters", "l"]),
        ("parameter_map", vec!["analyze", &pendulum, "--map", "l=0.1..1,m=0.05..1", "--cells", "4"]),
        ("from_rest", vec!["analyze", &table, "--from-rest", "--bounds", bounds]),
    ] {
        let (page, out) = page(&format!("page_{name}"), &arguments);
        assert!(out.join(format!("{name}.html")).is_file());
        assert_all_linked(&page, &out);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_page_goes_to_the_browser_and_a_missing_one_is_said() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;

    let dir = scratch("page_browser");
    let out = dir.join("out");
    let run = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bracketry"));
        let arguments = ["analyze", &model("unicycle.toml"), "--open", "--out", out.to_str().unwrap()];
        command.args(arguments).env("PATH", &dir).output().unwrap()
    };
    let o = run();
    let said = text(&o.stderr);
    assert!(code(&o) == 0 && said.contains("cannot open") && said.contains("analysis.html"), "{said}");
    let browser = file(&dir, "xdg-open", "#!/bin/sh\necho \"$1\" > \"${1%.html}.opened\"\n");
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let o = run();
    assert!(code(&o) == 0 && o.stderr.is_empty(), "{}", text(&o.stderr));
    let opened = fs::read_to_string(out.join("analysis.opened")).unwrap();
    assert_eq!(Path::new(opened.trim()), out.join("analysis.html"));
}
