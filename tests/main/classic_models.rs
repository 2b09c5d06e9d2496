//! The classic systems in `models/`: the verdicts of `analyze` against the literature, and the table in `docs/models.md`.

use std::fmt::Write as _;
use std::sync::OnceLock;

use crate::common::read;
use bracketry::lie::AnalysisOptions;
use serde_json::Value;

/// What the literature says of a system; `None` where it says nothing that `analyze` answers.
struct Known {
    file: &'static str,
    system: &'static str,
    growth: &'static [u64],
    /// Small-time locally controllable at the point of the model.
    stlc: Option<&'static str>,
    /// Rank of the linearization at the point of the model.
    linear_rank: Option<u64>,
    /// Linearizable by static feedback near a generic point.
    static_feedback: bool,
    flat: Option<&'static str>,
    source: &'static str,
}

static SYSTEMS: [Known; 25] = [
    Known {
        file: "acrobot",
        system: "two links, motor at the elbow",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: Some("no"),
        source: "not linearizable by static feedback (Murray and Hauser 1991; Spong 1995)",
    },
    Known {
        file: "ball_and_beam",
        system: "ball on a beam that a torque turns",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: Some("no"),
        source: "relative degree of r not defined where r w = 0 (Hauser, Sastry, and Kokotović 1992)",
    },
    Known {
        file: "brockett_integrator",
        system: "nonholonomic integrator",
        growth: &[2, 3],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: false,
        flat: Some("yes"),
        source: "controllable, no continuous stabilizing feedback (Brockett 1983)",
    },
    Known {
        file: "car_with_trailers",
        system: "tractor with two trailers",
        growth: &[2, 3, 4, 5],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: false,
        flat: Some("yes"),
        source: "controllable (Laumond 1993), flat with the last axle (Rouchon and others 1993)",
    },
    Known {
        file: "cart_pole",
        system: "inverted pendulum on a cart",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: Some("no"),
        source: "fails the conditions of Jakubczyk and Respondek (1980)",
    },
    Known {
        file: "double_integrator",
        system: "mass and force",
        growth: &[2],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: true,
        flat: Some("yes"),
        source: "linear and controllable",
    },
    Known {
        file: "duffing",
        system: "beam between magnets",
        growth: &[2],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: true,
        flat: Some("yes"),
        source: "in normal form",
    },
    Known {
        file: "flexible_joint",
        system: "link on an elastic joint",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: true,
        flat: Some("yes"),
        source: "linearizable by static feedback (Spong 1987)",
    },
    Known {
        file: "furuta_pendulum",
        system: "rotary inverted pendulum",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: Some("no"),
        source: "fails the conditions of Jakubczyk and Respondek (1980)",
    },
    Known {
        file: "heading",
        system: "point of constant speed that steers",
        growth: &[2, 3],
        stlc: Some("no"),
        linear_rank: None,
        static_feedback: false,
        flat: Some("no"),
        source: "accessible, never at rest (Dubins 1957)",
    },
    Known {
        file: "induction_motor",
        system: "induction motor",
        growth: &[3, 5],
        stlc: None,
        linear_rank: None,
        static_feedback: false,
        flat: Some("yes"),
        source: "not static, but dynamic feedback linearizable (Marino and others 1993; Chiasson 1993)",
    },
    Known {
        file: "kinematic_car",
        system: "car (bicycle model)",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: false,
        flat: Some("yes"),
        source: "flat with the rear axle (Fliess and others 1995)",
    },
    Known {
        file: "lorenz",
        system: "Lorenz equations with an input",
        growth: &[2, 3],
        stlc: Some("no"),
        linear_rank: Some(2),
        static_feedback: true,
        flat: Some("yes"),
        source: "the set z ≥ x²/(2s), which contains the origin, cannot be left: (z − x²/2s)' = (1 − b/2s) x² − b (z − x²/2s)",
    },
    Known {
        file: "magnetic_levitation",
        system: "ball below a magnet",
        growth: &[2, 3],
        stlc: Some("yes"),
        linear_rank: Some(3),
        static_feedback: true,
        flat: Some("yes"),
        source: "linearizable by static feedback (Barie and Chiasson 1996)",
    },
    Known {
        file: "pendubot",
        system: "two links, motor at the shoulder",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: Some("no"),
        source: "not linearizable by static feedback (Spong and Block 1995)",
    },
    Known {
        file: "pvtol",
        system: "aircraft that takes off vertically",
        growth: &[3, 5, 6],
        stlc: Some("yes"),
        linear_rank: Some(6),
        static_feedback: false,
        flat: Some("yes"),
        source: "not minimum phase (Hauser and others 1992), flat (Martin and others 1996)",
    },
    Known {
        file: "quadruple_tank",
        system: "four tanks, two pumps",
        growth: &[3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: true,
        flat: Some("yes"),
        source: "zeros −0.060 and −0.018 1/s (Johansson 2000)",
    },
    Known {
        file: "quadrotor",
        system: "quadrotor, four thrusts",
        growth: &[5, 9, 12],
        stlc: None,
        linear_rank: None,
        static_feedback: false,
        flat: None,
        source: "flat with x, y, z, and yaw (Mellinger and Kumar 2011), which the search does not find",
    },
    Known {
        file: "reaction_wheel_pendulum",
        system: "pendulum with a wheel",
        growth: &[2, 3],
        stlc: Some("yes"),
        linear_rank: Some(3),
        static_feedback: true,
        flat: Some("yes"),
        source: "linearizable by static feedback (Spong and others 2001)",
    },
    Known {
        file: "rolling_disk",
        system: "disk that rolls upright",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: false,
        flat: Some("yes"),
        source: "controllable (Bloch 2003)",
    },
    Known {
        file: "spacecraft",
        system: "rigid body, torques about two axes",
        growth: &[3, 5, 6],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: false,
        flat: None,
        source: "small-time controllable (Crouch 1984), no smooth stabilizing feedback (Byrnes and Isidori 1991)",
    },
    Known {
        file: "tora",
        system: "cart on a spring with a rotor",
        growth: &[2, 3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: true,
        flat: Some("yes"),
        source: "a cascade linearizable where cos θ ≠ 0 (Jankovic and others 1996)",
    },
    Known {
        file: "two_link_arm",
        system: "robot arm, a motor at each joint",
        growth: &[3, 4],
        stlc: Some("yes"),
        linear_rank: Some(4),
        static_feedback: true,
        flat: Some("yes"),
        source: "computed torque (Spong and others 2006)",
    },
    Known {
        file: "unicycle",
        system: "wheel that rolls and turns",
        growth: &[2, 3],
        stlc: Some("yes"),
        linear_rank: Some(2),
        static_feedback: false,
        flat: Some("yes"),
        source: "controllable, no continuous stabilizing feedback (Brockett 1983); flat (d'Andréa-Novel and others 1992)",
    },
    Known {
        file: "van_der_pol",
        system: "Van der Pol's oscillator with a force",
        growth: &[2],
        stlc: None,
        linear_rank: None,
        static_feedback: true,
        flat: Some("yes"),
        source: "in normal form",
    },
];

/// What `analyze` says of each system, worked out once.
fn analyses() -> &'static [Value] {
    static ALL: OnceLock<Vec<Value>> = OnceLock::new();
    ALL.get_or_init(|| {
        let analyzed = |k: &Known| {
            let analysis = bracketry::analyze(&read(k.file), &AnalysisOptions::default()).unwrap();
            serde_json::to_value(bracketry::report::analysis::json(&analysis)).unwrap()
        };
        let half = SYSTEMS.len() / 2;
        std::thread::scope(|scope| {
            let first = scope.spawn(|| SYSTEMS[..half].iter().map(analyzed).collect::<Vec<_>>());
            let second: Vec<Value> = SYSTEMS[half..].iter().map(analyzed).collect();
            first.join().unwrap().into_iter().chain(second).collect()
        })
    })
}

fn analysis(file: &str) -> &'static Value {
    &analyses()[SYSTEMS.iter().position(|k| k.file == file).unwrap()]
}

#[test]
fn analyze_says_what_the_literature_says() {
    for (known, found) in SYSTEMS.iter().zip(analyses()) {
        let file = known.file;
        assert_eq!(found["modes"][0]["growth"], serde_json::json!(known.growth), "{file}");
        assert_eq!(found["modes"][0]["accessible_dimension"], found["states"], "{file}");
        assert_eq!(found["static_feedback_linearizable"], known.static_feedback, "{file}");
        if let Some(flat) = known.flat {
            assert_eq!(found["flatness"]["verdict"], flat, "{file}: {}", found["flatness"]["reason"]);
        }
        if let Some(stlc) = known.stlc {
            // The literature takes bounded inputs.
            let found = &found["at_point"]["stlc"];
            let bounded = found.get("bounded").unwrap_or(found);
            assert_eq!(bounded["verdict"], stlc, "{file}");
        }
        if let Some(rank) = known.linear_rank {
            assert_eq!(found["at_point"]["linear_controllability_rank"], rank, "{file}");
        }
    }
}

#[test]
fn what_continuous_feedback_cannot_stabilize_is_what_brockett_says() {
    for (known, found) in SYSTEMS.iter().zip(analyses()) {
        let driftless = ["brockett_integrator", "car_with_trailers", "kinematic_car", "rolling_disk", "unicycle"];
        let fails = driftless.contains(&known.file) || known.file == "spacecraft";
        if known.linear_rank.is_some() {
            assert_eq!(found["at_point"]["brockett_condition"], !fails, "{}", known.file);
        }
    }
}

#[test]
fn the_relative_degree_of_the_ball_is_lost_where_it_is_to_be_kept() {
    let found = analysis("ball_and_beam");
    assert_eq!(found["relative_degree"], serde_json::json!([3]));
    assert_eq!(found["at_point"]["relative_degree_defined"], false);
    assert_eq!(analysis("flexible_joint")["relative_degree"], serde_json::json!([4]));
    assert_eq!(analysis("flexible_joint")["at_point"]["relative_degree_defined"], true);
}

#[test]
fn the_aircraft_is_flat_with_its_center_of_oscillation_and_not_minimum_phase() {
    let found = analysis("pvtol");
    assert_eq!(found["flatness"]["flat_outputs"], serde_json::json!(["x - eps*sin(th)", "eps*cos(th) + y"]));
    assert_eq!(found["zero_dynamics"]["minimum_phase"], false);
    // th'' = sin(th)/eps
    let eigenvalue = found["zero_dynamics"]["eigenvalues"][0]["re"].as_f64().unwrap();
    assert!((eigenvalue - (1.0 / 0.3f64).sqrt()).abs() < 1e-12, "{eigenvalue}");
}

#[test]
fn the_zeros_of_the_tanks_are_those_published() {
    let zeros = &analysis("quadruple_tank")["zero_dynamics"]["eigenvalues"];
    for (k, published) in [-0.018, -0.060].into_iter().enumerate() {
        let zero = zeros[k]["re"].as_f64().unwrap();
        assert!((zero - published).abs() < 1e-3 && zeros[k]["im"] == 0.0, "{zeros}");
    }
}

/// A list of numbers or texts with commas.
fn listed(v: &Value) -> String {
    let item = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_owned);
    v.as_array().map_or(String::new(), |list| list.iter().map(item).collect::<Vec<_>>().join(", "))
}

fn yes_no(v: &Value) -> &str {
    match v {
        Value::Bool(true) => "yes",
        Value::Bool(false) => "no",
        Value::String(s) => s,
        _ => "–",
    }
}

fn table() -> String {
    let mut out = "| model | system | states, inputs | affine | growth | at its point: linear rank | STLC | continuous feedback may stabilize | static feedback linearizable | flat outputs | literature |\n\
                   |---|---|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for (known, found) in SYSTEMS.iter().zip(analyses()) {
        let point = &found["at_point"];
        let flat = match found["flatness"]["verdict"].as_str() {
            Some("yes") => format!("`{}`", listed(&found["flatness"]["flat_outputs"]).replace(", ", "`, `")),
            Some(verdict) => verdict.to_owned(),
            None => "–".to_owned(),
        };
        let rank = point["linear_controllability_rank"].as_u64().map_or("–".to_owned(), |r| r.to_string());
        let _ = writeln!(
            out,
            "| [`{}`](../models/{}.toml) | {} | {}, {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            known.file,
            known.file,
            known.system,
            found["states"],
            found["inputs"],
            if found["affine"] == true { "yes" } else { "with integrators" },
            listed(&found["modes"][0]["growth"]),
            rank,
            yes_no(&point["stlc"]["verdict"]),
            yes_no(&point["brockett_condition"]),
            yes_no(&found["static_feedback_linearizable"]),
            flat,
            known.source,
        );
    }
    out
}

/// Between these lines of `docs/models.md` stands what the program says.
const MARKS: [&str; 2] = ["<!-- table: begin -->\n", "<!-- table: end -->\n"];

#[test]
fn the_table_of_models_is_what_analyze_says() {
    let path = format!("{}/docs/models.md", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(MARKS[0]).unwrap();
    let (_, after) = rest.split_once(MARKS[1]).unwrap();
    let fresh = [before, MARKS[0], &table(), MARKS[1], after].concat();
    if std::env::var_os("BRACKETRY_WRITE_DOCS").is_some() {
        std::fs::write(&path, &fresh).unwrap();
    }
    let now = std::fs::read_to_string(&path).unwrap();
    assert!(
        now == fresh,
        "docs/models.md is stale; BRACKETRY_WRITE_DOCS=1 cargo test -p bracketry --test main classic_models:: writes it"
    );
}
