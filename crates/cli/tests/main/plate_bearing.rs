//! Where an object presses and where its mass is, as options of `plate`.

use crate::common::{bracketry, code, file, scratch};
use serde_json::Value;

/// Experiment 1 for two seconds on the area model.
fn turned(options: &[&str]) -> Value {
    let base = ["plate", "1", "--seconds", "2", "--dt", "0.002", "--sample", "0.02", "--json"];
    let o = bracketry(&[&base[..], options].concat());
    serde_json::from_slice(&o.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&o.stderr)))
}

fn yaw(v: &Value) -> f64 {
    v.pointer("/final/phi").and_then(Value::as_f64).unwrap()
}

fn final_pose(v: &Value) -> [f64; 3] {
    ["x", "y", "phi"].map(|name| v["final"][name].as_f64().unwrap())
}

#[test]
fn friction_against_the_spin_grows_with_the_radius_of_the_bearing() {
    let [inner, whole, rim] = ["scaled:0.5", "footprint", "ring:1"].map(|b| turned(&["--bearing", b]));
    assert!(yaw(&inner) > 1.2 * yaw(&whole) && yaw(&whole) > 1.2 * yaw(&rim), "{inner} {whole} {rim}");
    assert_eq!(inner["bearing"], serde_json::json!({"kind": "scaled", "scale": 0.5}));
    assert_eq!(whole["bearing"], serde_json::json!({"kind": "footprint"}));
    assert_eq!(rim["bearing"], serde_json::json!({"kind": "ring", "scale": 1.0}));
    let scaled = turned(&["--bearing", "scaled:1"]);
    for (a, b) in final_pose(&whole).into_iter().zip(final_pose(&scaled)) {
        assert!((a - b).abs() < 1e-9, "{whole} {scaled}");
    }
}

#[test]
fn feet_are_a_map_with_equal_weights_on_the_command_line_and_in_a_scenario_file() {
    let dir = scratch("plate_feet");
    let feet = turned(&["--bearing", "feet:0.1,0;-0.05,0.08;-0.05,-0.08"]);
    assert_eq!(feet["bearing"]["points"].as_array().unwrap().len(), 3);
    let map = file(&dir, "map.csv", "x,y,weight\n0.1,0,2\n-0.05,0.08,2\n-0.05,-0.08,2\n");
    let mapped = turned(&["--bearing", &format!("map:{map}")]);
    let scenario = file(&dir, "s.toml", "experiment = 1\nbearing = 'map:map.csv'\ncenter_of_mass = '0.01,-0.005'\n");
    let base = ["plate", &scenario, "--seconds", "2", "--dt", "0.002", "--sample", "0.02"];
    let from_file: Value = serde_json::from_slice(&bracketry(&[&base[..], &["--json"]].concat()).stdout).unwrap();
    let options = ["--bearing", &format!("map:{map}"), "--center-of-mass", "0.01,-0.005"];
    let off = turned(&options);
    for ((a, b), (c, d)) in final_pose(&feet)
        .into_iter()
        .zip(final_pose(&mapped))
        .zip(final_pose(&from_file).into_iter().zip(final_pose(&off)))
    {
        assert!((a - b).abs() < 1e-9 && (c - d).abs() < 1e-12);
    }
    assert!((yaw(&off) - yaw(&feet)).abs() > 1e-3, "{off} {feet}");
    assert_eq!(off["center_of_mass"], serde_json::json!([0.01, -0.005]));
    let report = bracketry(&base);
    let text = String::from_utf8_lossy(&report.stdout);
    assert!(text.contains("bearing     a map of 3 points; center of mass at 0.01, -0.005 m"), "{text}");
}

#[test]
fn bearings_without_meaning_are_refused_with_place_and_remedy() {
    let dir = scratch("plate_bearing_bad");
    let empty = format!("map:{}", file(&dir, "empty.csv", "x,y,weight\n"));
    let weightless = format!("map:{}", file(&dir, "weightless.csv", "0,0,1\n0.1,0,0\n0,0.1,1\n"));
    let narrow = format!("map:{}", file(&dir, "narrow.csv", "0,0\n"));
    let cases: [(&[&str], &str); 15] = [
        (&["--bearing", "rim"], "--bearing: `rim` is not a bearing; give footprint, scaled:0.5"),
        (&["--bearing", "footprint:2"], "`footprint:2` is not a bearing"),
        (&["--bearing", "scaled:0"], "--bearing: the scale 0 is not positive; give a number greater than zero"),
        (&["--bearing", "ring:"], "--bearing: `` is not a finite number"),
        (&["--bearing", "feet:0,0;0.1"], "--bearing: `0.1` has 1 numbers, not 2; give a point as x,y in meters"),
        (
            &["--bearing", "feet:0,0;0.1,0"],
            "--bearing: the bearing cannot carry the object: a polygon needs at least 3",
        ),
        (&["--bearing", "feet:0,0;0.05,0;0.1,0"], "give at least three points that do not lie on one line"),
        (&["--bearing", "feet:100,0;-50,80;-50,-80"], "--bearing: the point 100,0 lies beyond the outline"),
        (&["--bearing", "map:/nowhere.csv"], "/nowhere.csv cannot be read"),
        (&["--bearing", &empty], "--bearing: the bearing cannot carry the object"),
        (&["--bearing", &weightless], "weightless.csv: the weight 0 at 0.1,0 is not positive; give a table"),
        (&["--bearing", &narrow], "narrow.csv, line 1: `0,0` has 2 entries, not 3"),
        (&["--center-of-mass", "0.1"], "--center-of-mass: `0.1` has 1 numbers, not 2"),
        (
            &["--center-of-mass", "-5,0"],
            "--center-of-mass: the center of mass -5,0 lies beyond the outline of the object",
        ),
        (&["--bearing", "ring:1", "--model", "reduced"], "use --model area"),
    ];
    for (options, part) in cases {
        let o = bracketry(&[&["plate", "1"], options].concat());
        let message = String::from_utf8_lossy(&o.stderr);
        assert!(code(&o) == 2 && message.contains(part), "`{part}` in {message}");
    }
    let scenario = file(&dir, "s.toml", "experiment = 1\nbearing = 'rim'\n");
    let o = bracketry(&["plate", &scenario]);
    let message = String::from_utf8_lossy(&o.stderr);
    assert!(code(&o) == 2 && message.contains("s.toml:2:11: `rim` is not a bearing"), "{message}");
}
