//! Dry friction on a plane, coupled over its directions: stops, turns, breaks loose as mechanics says.
#![allow(clippy::unwrap_used)]

use bracketry_sim::{Inputs, Mode, Model, Settings, Simulation, simulate};
use bracketry_system::System;

const G: f64 = 9.81;

fn simulate_text(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64) -> Simulation {
    let system = System::parse("test.toml", text).unwrap();
    let model = Model::new(&system, inputs).unwrap();
    let run = simulate(model, 0.0, x0, t_end, &Settings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

/// A point on a plane under the acceleration `(ax, ay)` and the friction μ g.
fn plane(ax: &str, ay: &str) -> String {
    format!(
        r#"
        states = ["x", "y", "vx", "vy"]
        inputs = ["a", "b"]
        parameters = {{ mu = 0.3, g = 9.81 }}
        definitions = {{ rho = "sqrt(vx^2 + vy^2)" }}
        [dynamics]
        x = "vx"
        y = "vy"
        vx = "{ax} - mu*g*vx/rho"
        vy = "{ay} - mu*g*unit(vy, vx)"
        "#
    )
}

#[test]
fn a_straight_slide_stops_at_v_over_mu_g_at_the_right_place() {
    for (vx, vy) in [(0.3f64, 0.4f64), (-1.0, 0.001), (0.0, -2.0), (5.0, -7.0)] {
        let run = simulate_text(&plane("0", "0"), &Inputs::new(), &[0.1, -0.2, vx, vy], 5.0);
        let v = vx.hypot(vy);
        let stop = v / (0.3 * G);
        let events = run.trajectory.transitions();
        assert_eq!(events.len(), 1, "{events:?}");
        assert_eq!((events[0].from, events[0].to), (Mode::Sliding, Mode::Sticking));
        assert!((events[0].t - stop).abs() < 1e-10, "{:e}", events[0].t - stop);
        let end = run.trajectory.final_state();
        assert!((end[0] - 0.1 - 0.5 * vx * stop).abs() < 1e-9 && (end[1] + 0.2 - 0.5 * vy * stop).abs() < 1e-9);
        assert_eq!(&end[2..], &[0.0, 0.0]);
    }
}

/// A slide on a tilted plane with friction above the tilt, from `(0, v)` across the fall line: in polar coordinates of the
/// velocity, `d ln|v|/dα = −(f + b cos α)/(b sin α)`… with α the angle from the fall line.
#[test]
fn a_slide_across_a_tilted_plane_turns_into_the_fall_line_and_stops() {
    let (b, f) = (1.5f64, 0.3 * G);
    let run = simulate_text(&plane("1.5", "0"), &Inputs::new(), &[0.0, 0.0, 0.0, 1.0], 3.0);
    // With u = |v|: u' = b cos α − f, u α' = −b sin α. From α = π/2: u = tan(α/2)^(f/b) / sin α, up to u(π/2) = 1.
    // u (f + b cos α) + … : d/dt [u (cos α + f/b)] = (b² − f²)/b, which is the time.
    let stop = (f / b) / ((f * f - b * b) / b);
    let events = run.trajectory.transitions();
    assert_eq!(events.len(), 1, "{events:?}");
    assert!((events[0].t - stop).abs() < 1e-9, "{:e}", events[0].t - stop);
    // On the way: speed and angle belong together.
    for i in 1..40 {
        let t = stop * f64::from(i) / 40.0;
        let x = run.trajectory.sample(t);
        let (u, alpha) = (x[2].hypot(x[3]), x[3].atan2(x[2]));
        let expected = (0.5 * alpha).tan().powf(f / b) / alpha.sin();
        assert!((u - expected).abs() < 1e-8, "{t} {u} {expected}");
    }
}

#[test]
fn a_plane_that_shakes_breaks_the_object_loose_where_the_size_of_its_acceleration_reaches_mu_g() {
    // Elliptical shaking a = A (cos ωt, e sin ωt)·ramp: breaks loose at |a| = μ g.
    let inputs = Inputs::new().expression("a", "6*t*cos(5*t)").expression("b", "3*t*sin(5*t)");
    let run = simulate_text(&plane("a", "b"), &inputs, &[0.0; 4], 1.5);
    let size = |t: f64| (6.0 * t * (5.0 * t).cos()).hypot(3.0 * t * (5.0 * t).sin()) - 0.3 * G;
    let (mut low, mut high) = (0.5, 1.2);
    assert!(size(low) * size(high) < 0.0, "{} {}", size(low), size(high));
    for _ in 0..100 {
        let m = 0.5 * (low + high);
        if size(low) * size(m) <= 0.0 { high = m } else { low = m }
    }
    let events = run.trajectory.transitions();
    let first = events.iter().find(|e| e.from == Mode::Sticking).unwrap();
    assert!((first.t - low).abs() < 1e-10, "{:e}", first.t - low);
}

/// The reduced model of a disk on a shaken, tilted plate: friction of the centre coupled over the plane, yaw friction
/// over the plane and the spin.
const REDUCED: &str = r#"
    states = ["x", "y", "phi", "vx", "vy", "w"]
    inputs = ["X", "theta"]
    parameters = { mu = 0.3, g = 9.81, S = 0.0036, I = 0.0072 }
    [definitions]
    N = "g*cos(theta) + y*der(theta, 2)"
    [dynamics]
    x = "vx"
    y = "vy"
    phi = "w"
    vx = "-der(X, 2) - mu*N*unit(vx, vy)"
    vy = "-g*sin(theta) + y*der(theta)^2 - mu*N*unit(vy, vx)"
    w = "(mu*der(theta, 2)*S*unit(vx, vy) - mu*g*cos(theta)*S*w/sqrt(vx^2 + vy^2 + I*w^2/4))/I"
"#;

#[test]
fn a_disk_spins_on_where_its_centre_has_stopped() {
    // Without plate motion: the centre stops at v/(μ g); then w' = −μ g S/(I √(I/4)) sgn w.
    let run = simulate_text(REDUCED, &Inputs::new(), &[0.3, 0.0, 0.0, 0.3, 0.1, 9.0], 3.0);
    let events = run.trajectory.transitions();
    let stop = 0.3f64.hypot(0.1) / (0.3 * G);
    assert_eq!(events.len(), 2);
    assert!((events[0].t - stop).abs() < 1e-10);
    let w = run.trajectory.sample(events[0].t)[5];
    let rate = 0.3 * G * 0.5 / (0.0072f64 / 4.0).sqrt();
    assert!((events[1].t - stop - w / rate).abs() < 1e-9);
    assert_eq!(run.trajectory.final_state()[5], 0.0);
}

#[test]
fn the_reduced_model_runs_the_first_experiment() {
    let inputs = Inputs::new()
        .expression("X", "0.025*sin(4*pi*t)*(1 - exp(-t))")
        .expression("theta", "-pi/12*sin(4*pi*t)*(1 - exp(-t))");
    let run = simulate_text(REDUCED, &inputs, &[0.3, 0.0, 0.0, 0.0, 0.0, 0.0], 15.0);
    let end = run.trajectory.final_state();
    // Area contact turns the disk by 118°; this model stays near it.
    assert!((end[2].to_degrees() - 118.0).abs() < 6.0, "{end:?}");
}
