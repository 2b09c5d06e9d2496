//! The command `diagnose` as users call it, and what becomes of the extended model.

use std::fs;

use crate::common::pages::{assert_all_linked, assert_page};
use crate::common::{bracketry, code, file, json, scratch};
use bracketry_trials::{Slider, SliderEffect, SliderSensors};
use rand::SeedableRng;
use rand::rngs::StdRng;
use serde_json::Value;

fn slider() -> Slider {
    let random = &mut StdRng::seed_from_u64(4);
    Slider { rate: 200.0, duration: 6.0, size: 0.15, ..Slider::basic(SliderSensors::PositionAndVelocity, random) }
}

#[test]
fn a_hidden_slope_is_found_and_the_extended_model_goes_into_the_controller() {
    let dir = scratch("diagnose_to_control");
    let log = slider().run(&[SliderEffect::Tilt], 11).unwrap();
    let (model, data) = (file(&dir, "given.toml", &log.model), file(&dir, "run.csv", &log.csv()));
    let out = dir.join("out");
    let found = json(&["diagnose", &model, &data, "--json", "--out", out.to_str().unwrap()]);
    assert_eq!((found["verdict"].as_str(), found["causes"][0]["name"].as_str()), (Some("cause_found"), Some("tilt")));
    let gain = &found["gain"];
    let last = gain["horizons_s"].as_array().unwrap().len() - 1;
    assert!(gain["after"][last].as_f64().unwrap() < 0.5 * gain["before"][last].as_f64().unwrap(), "{gain}");
    assert_eq!(found["ranks"]["before"]["states"], 2);
    for name in ["diagnosis.html", "diagnosis.txt", "prediction.svg", "gain.png", "candidates.png", "force_v.svg"] {
        assert!(fs::metadata(out.join(name)).unwrap().len() > 0, "{name}");
    }
    let page = fs::read_to_string(out.join("diagnosis.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("<math>") && page.contains("href=\"extended.toml\""));
    assert_page(&page, Some(&out));
    assert_all_linked(&page, &out);

    // The loop on the plant as it really is, the extended model in the controller.
    let truth = &log.truth;
    let plant = format!(
        "states = ['x', 'v']\ninputs = ['u']\n[dynamics]\nx = 'v'\nv = '(u + {} - {}*sign(v))/{}'\n",
        truth.hidden[0].strength, truth.friction, truth.mass
    );
    file(&dir, "plant.toml", &plant);
    let problem = "model = 'out/extended.toml'\nplant = 'plant.toml'\nhorizon = { steps = 20, dt = 0.05 }\n\
                   cost = { stage = '10*(x - 0.3)^2 + 0.1*v^2 + 1e-3*u^2', terminal = '10*(x - 0.3)^2 + v^2' }\n\
                   [run]\nsteps = 60\n";
    let answer = bracketry(&["control", &file(&dir, "loop.toml", problem), "--json"]);
    let v: Value = serde_json::from_slice(&answer.stdout).unwrap();
    // Standing still for the 3 s costs 10·0.3²·3.
    assert!(v["closed_loop_cost"].as_f64().unwrap() < 0.1 * 2.7, "{v}");
}

#[test]
fn without_an_effect_nothing_is_found_and_the_model_is_left_alone() {
    let dir = scratch("diagnose_nothing");
    let log = slider().run(&[], 5).unwrap();
    let (model, data) = (file(&dir, "given.toml", &log.model), file(&dir, "run.csv", &log.csv()));
    let out = dir.join("out");
    let found = json(&["diagnose", &model, &data, "--json", "--out", out.to_str().unwrap()]);
    assert_eq!((found["verdict"].as_str(), &found["causes"]), (Some("nothing_found"), &serde_json::json!([])));
    assert!(!out.join("extended.toml").exists());
}

#[test]
fn what_cannot_be_used_is_refused_with_place_and_remedy() {
    let dir = scratch("diagnose_refused");
    let model = file(&dir, "m.toml", "states = ['v']\ninputs = ['u']\n[dynamics]\nv = 'u'\n");
    let data = file(&dir, "run.csv", "t,u,w\n0,1,2\n0.1,1,2\n");
    for arguments in [
        vec!["diagnose", &model, &data],
        vec!["diagnose", &model, "missing.csv"],
        vec!["diagnose", &model, &data, "--rename", "q"],
        vec!["diagnose", &model],
    ] {
        let o = bracketry(&arguments);
        assert_eq!(code(&o), 2, "{arguments:?}");
        assert!(!o.stderr.is_empty() && o.stdout.is_empty());
    }
}

#[test]
fn settings_that_the_data_cannot_follow_are_refused_by_their_option() {
    let dir = scratch("diagnose_settings");
    let model = file(&dir, "m.toml", "states = ['v']\ninputs = ['u']\n[dynamics]\nv = 'u'\n");
    let rows =
        |n: usize| (0..n).fold("t,u,v\n".to_owned(), |text, k| format!("{text}{},1,{}\n", 0.01 * k as f64, k % 3));
    let data = file(&dir, "run.csv", &rows(200));
    let short = file(&dir, "short.csv", &rows(10));
    for (arguments, part) in [
        (vec!["diagnose", &model, &data, "--window=1000"], "--window"),
        (vec!["diagnose", &model, &data, "--window=1e-9"], "--window"),
        (vec!["diagnose", &model, &data, "--window=0"], "--window"),
        (vec!["diagnose", &model, &data, "--window=-1"], "--window"),
        (vec!["diagnose", &model, &data, "--max-causes=0"], "--max-causes"),
        (vec!["diagnose", &model, &data, "--rename", "v=bar"], "bar"),
        (vec!["diagnose", &model, &short], "short.csv"),
    ] {
        let o = bracketry(&arguments);
        let said = String::from_utf8(o.stderr.clone()).unwrap();
        assert!(code(&o) == 2 && said.contains(part), "{arguments:?}: {said}");
    }
}

/// Ctrl-C while causes are sought: the report so far, with exit code 1.
#[cfg(unix)]
#[test]
fn an_interrupted_search_is_reported() {
    use std::process::{Command, Stdio};
    let dir = scratch("diagnose_interrupted");
    let effects = [SliderEffect::Tilt, SliderEffect::InputDelay];
    let long = Slider { duration: 20.0, rate: 500.0, ..slider() };
    let log = long.run(&effects, 11).unwrap();
    let (model, data) = (file(&dir, "given.toml", &log.model), file(&dir, "run.csv", &log.csv()));
    // A signal that comes before the command listens ends it; one that comes after the search is too late.
    for wait in [300, 600, 1200, 2400, 4800] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bracketry"));
        let child = command.args(["diagnose", &model, &data]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let child = child.unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait));
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        if ended.status.code().is_some() {
            let (report, errors) = (String::from_utf8_lossy(&ended.stdout), String::from_utf8_lossy(&ended.stderr));
            assert_eq!(ended.status.code(), Some(1), "{report}{errors}");
            assert!(report.contains("interrupted: at least"), "{report}");
            assert!(errors.contains("Ctrl-C again quits at once"), "{errors}");
            return;
        }
    }
    panic!("no signal met the search");
}
