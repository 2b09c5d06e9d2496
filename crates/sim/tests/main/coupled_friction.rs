//! Dry friction on a plane, coupled over its directions: stops, turns, breaks loose as mechanics says.

use bracketry_sim::{FrictionMode, Inputs, Model, Simulation, SimulationSettings, simulate};
use bracketry_system::System;

const G: f64 = 9.81;

fn simulate_text(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64) -> Simulation {
    let system = System::parse("test.toml", text).unwrap();
    let model = Model::new(&system, inputs).unwrap();
    let run = simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
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
        let events = run.trajectory.mode_changes();
        assert_eq!(events.len(), 1, "{events:?}");
        assert_eq!((events[0].from, events[0].to), (FrictionMode::Sliding, FrictionMode::Sticking));
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
    let events = run.trajectory.mode_changes();
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
    let events = run.trajectory.mode_changes();
    let first = events.iter().find(|e| e.from == FrictionMode::Sticking).unwrap();
    assert!((first.t - low).abs() < 1e-10, "{:e}", first.t - low);
}

/// The reduced model of a disk on a shaken, tilted plate: friction of the center coupled over the plane, yaw friction
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
fn a_disk_spins_on_where_its_center_has_stopped() {
    // Without plate motion: the center stops at v/(μ g); then w' = −μ g S/(I √(I/4)) sgn w.
    let run = simulate_text(REDUCED, &Inputs::new(), &[0.3, 0.0, 0.0, 0.3, 0.1, 9.0], 3.0);
    let events = run.trajectory.mode_changes();
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

#[test]
fn a_push_that_grows_breaks_loose_along_its_own_line() {
    // a = c t along a line: v = c (t − t₁)²/2 from t₁ = μ g/c on.
    let (c, angle) = (5.0f64, 0.7f64);
    let push = |part: f64| format!("{:.17}*t", c * part);
    let inputs = Inputs::new().expression("a", &push(angle.cos())).expression("b", &push(angle.sin()));
    let run = simulate_text(&plane("a", "b"), &inputs, &[0.0; 4], 1.5);
    let start = 0.3 * G / c;
    let events = run.trajectory.mode_changes();
    assert_eq!((events.len(), events[0].to), (1, FrictionMode::Sliding));
    assert!((events[0].t - start).abs() < 1e-10);
    for i in 1..=20 {
        let t = start + (1.5 - start) * f64::from(i) / 20.0;
        let (v, way) = (c * (t - start).powi(2) / 2.0, c * (t - start).powi(3) / 6.0);
        let x = run.trajectory.sample(t);
        for (value, exact) in x.iter().zip([way * angle.cos(), way * angle.sin(), v * angle.cos(), v * angle.sin()]) {
            assert!((value - exact).abs() < 1e-9, "{t} {:e}", value - exact);
        }
    }
}

#[test]
fn on_a_circularly_shaken_plate_the_slip_keeps_its_speed() {
    // v' = a e^{iωt} − f v/|v| has the solution |v| = √(a² − f²)/ω, turning with the plate.
    let (a, omega, f) = (6.0f64, 20.0f64, 0.3 * G);
    let speed = (a * a - f * f).sqrt() / omega;
    let lag = (omega * speed / f).atan();
    let inputs = Inputs::new().expression("a", "6*cos(20*t)").expression("b", "6*sin(20*t)");
    let start = [0.0, 0.0, speed * lag.cos(), -speed * lag.sin()];
    let run = simulate_text(&plane("a", "b"), &inputs, &start, 3.0);
    assert!(run.trajectory.mode_changes().is_empty());
    for i in 1..=300 {
        let t = 0.01 * f64::from(i);
        let x = run.trajectory.sample(t);
        assert!((x[2] - speed * (omega * t - lag).cos()).abs() < 1e-9);
        assert!((x[3] - speed * (omega * t - lag).sin()).abs() < 1e-9);
    }
}

/// Elliptical shaking that makes the object stick, break loose, slide around and stick again.
fn shaken_in_axes(angle: f64, mirrored: bool) -> Simulation {
    let (s, c) = angle.sin_cos();
    let side = if mirrored { -1.0 } else { 1.0 };
    let (first, second) = ("4*cos(9*t)*sin(t)", "2.5*sin(9*t)*sin(t)");
    let a = format!("({c:.17})*({first}) - ({s:.17})*({second})");
    let b = format!("({side:.1})*(({s:.17})*({first}) + ({c:.17})*({second}))");
    let inputs = Inputs::new().expression("a", &a).expression("b", &b);
    simulate_text(&plane("a", "b"), &inputs, &[0.0; 4], 8.0)
}

#[test]
fn results_do_not_depend_on_the_axes() {
    let straight = shaken_in_axes(0.0, false);
    let count = straight.trajectory.mode_changes().len();
    assert!(count >= 6, "{:?}", straight.trajectory.mode_changes());
    let x = straight.trajectory.final_state();
    let mirrored = shaken_in_axes(0.0, true);
    let m = mirrored.trajectory.final_state();
    assert!((x[0] - m[0]).abs() < 1e-14 && (x[1] + m[1]).abs() < 1e-14, "{x:?} {m:?}");
    for angle in [0.5f64, 2.0] {
        let turned = shaken_in_axes(angle, false);
        let (s, c) = angle.sin_cos();
        let t = turned.trajectory.final_state();
        let back = [c * t[0] + s * t[1], c * t[1] - s * t[0]];
        assert!((x[0] - back[0]).abs() < 1e-9 && (x[1] - back[1]).abs() < 1e-9, "{x:?} {back:?}");
        assert_eq!(turned.trajectory.mode_changes().len(), count);
        for (a, b) in straight.trajectory.mode_changes().iter().zip(turned.trajectory.mode_changes()) {
            assert!((a.t - b.t).abs() < 1e-8, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_disk_whose_spin_brakes_hard_ends_both_motions_together() {
    // (√c w)' = −k √c w/√(v² + c w²) with k > f: the spin dies out with the speed, which stops at v/f.
    let text = r#"
        states = ["vx", "vy", "w"]
        parameters = { f = 3, k = 4, c = 0.25 }
        [dynamics]
        vx = "-f*unit(vx, vy)"
        vy = "-f*unit(vy, vx)"
        w = "-k*w/sqrt(vx^2 + vy^2 + c*w^2)"
    "#;
    let run = simulate_text(text, &Inputs::new(), &[0.6, 0.8, 0.5], 2.0);
    let events = run.trajectory.mode_changes();
    assert_eq!(events.len(), 2, "{events:?}");
    for e in events {
        assert_eq!(e.to, FrictionMode::Sticking);
        assert!((e.t - 1.0 / 3.0).abs() < 1e-9, "{e:?}");
    }
    assert_eq!(run.trajectory.final_state(), &[0.0; 3]);
}

#[test]
fn nothing_creeps_on_a_tilted_plate_for_a_minute() {
    let tilt = 10.0f64.to_radians();
    let text =
        plane(&format!("-9.81*{:.17} + a", tilt.sin()), "b").replace("mu*g", &format!("mu*g*{:.17}", tilt.cos()));
    let inputs = Inputs::new().expression("a", "0.5*sin(50*t)").expression("b", "0.4*cos(37*t)");
    let run = simulate_text(&text, &inputs, &[0.03, 0.0, 0.1, 0.05], 60.0);
    let events = run.trajectory.mode_changes();
    assert_eq!(events.len(), 1, "{events:?}");
    let place = run.trajectory.sample(events[0].t);
    let end = run.trajectory.final_state();
    // Nothing but rounding: a nanometer would be 1e-9.
    assert!((end[0] - place[0]).abs() < 1e-15 && (end[1] - place[1]).abs() < 1e-15, "{end:?} {place:?}");
    assert_eq!(&end[2..], &[0.0, 0.0]);
}

/// A body whose spin takes part in the slip with the length `l`: the friction of the slip falls while it spins.
#[test]
fn a_spin_whose_length_in_the_slip_vanishes_leaves_friction_as_it_is_without() {
    let run = |l: f64| {
        let text = format!(
            r#"
            states = ["x", "y", "vx", "vy", "w"]
            parameters = {{ mu = 0.3, g = 9.81, l = {l:?}, rho = 0.08 }}
            [dynamics]
            x = "vx"
            y = "vy"
            vx = "0.5*sin(20*x) - mu*g*unit(vx, vy, l*w)"
            vy = "-mu*g*unit(vy, vx, l*w)"
            w = "-mu*g*l/rho^2*unit(l*w, vx, vy)"
            "#
        );
        simulate_text(&text, &Inputs::new(), &[0.0, 0.0, 0.4, -0.3, 2.0], 1.0).trajectory.final_state().to_vec()
    };
    let (none, tiny) = (run(0.0), run(1e-7));
    // Sticks, and spins on.
    assert_eq!((none[2], none[3], none[4]), (0.0, 0.0, 2.0));
    for (none, tiny) in none.iter().zip(&tiny) {
        assert!((none - tiny).abs() < 1e-3, "{none} {tiny}");
    }
    // With a length it slides farther, and the spin ends too.
    let wide = run(0.05);
    assert!(wide[0] > none[0] + 0.001 && wide[4] == 0.0, "{wide:?} {none:?}");
}
