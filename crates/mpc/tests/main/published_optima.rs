//! Optimal costs that are published: first plans of problem files in `benches/peers/problems`, which state the sources.

use bracketry_mpc::{ControlProblem, control};
use bracketry_system::System;
use std::path::Path;

/// The cost of the first plan of a problem, after replacements in its file.
fn planned(name: &str, replacements: &[(&str, &str)]) -> f64 {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../benches/peers/problems/smooth");
    let mut text = std::fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap();
    for (from, to) in replacements {
        assert!(text.contains(from), "{name}: {from}");
        text = text.replace(from, to);
    }
    let read = |file: &str| System::read(folder.join(file)).map_err(Box::new);
    let mut problem = ControlProblem::parse(name, &text, read).unwrap();
    problem.samples = 1;
    control(&problem).unwrap().run.report.open_loop_cost
}

fn close(name: &str, cost: f64, published: f64, tolerance: f64) {
    assert!((cost / published - 1.0).abs() <= tolerance, "{name}: {cost} in place of {published}");
}

#[test]
fn plans_cost_what_is_published() {
    for (name, published) in [
        ("goddard_rocket", -1.01283),
        ("catalyst_mixing", -0.048_055_6),
        ("hang_glider", -12.4803),
        ("brachistochrone", -9.81 / std::f64::consts::PI),
        ("bryson_denham", 4.0),
        ("batch_reactor", -0.610_775),
    ] {
        close(name, planned(name, &[]), published, 1e-3);
    }
    // Published with three digits.
    assert!((planned("luus_cstr", &[]) - 0.133).abs() <= 5e-4);
}

#[test]
fn finer_problems_approach_what_is_published() {
    // The orbit is circular by a cost, which a larger weight turns into a constraint.
    close("orbit_transfer", planned("orbit_transfer", &[("100*", "10000*")]), -1.525, 1e-3);
    let fine = [("steps = 30, dt = 0.5, substeps = 4", "steps = 150, dt = 0.1, substeps = 1")];
    close("park_ramirez", planned("park_ramirez", &fine), -32.686, 1e-3);
    // A sum over the starts of intervals converges with order one.
    let fishing = |grid: &str| planned("lotka_volterra_fishing", &[("steps = 60, dt = 0.2, substeps = 2", grid)]);
    let (coarse, fine) =
        (fishing("steps = 240, dt = 0.05, substeps = 1"), fishing("steps = 960, dt = 0.0125, substeps = 1"));
    assert!((coarse - 1.3527).abs() < 1e-4 && (fine - 1.3462).abs() < 1e-4, "{coarse} {fine}");
    close("lotka_volterra_fishing", (4.0 * fine - coarse) / 3.0, 1.34408, 1e-3);
    // Below what is published, and more so on a finer grid.
    let crane = planned("container_crane", &[("steps = 45, dt = 0.2", "steps = 180, dt = 0.05")]);
    assert!((crane - 0.005_153).abs() < 1e-6 && crane < planned("container_crane", &[]), "{crane}");
}
