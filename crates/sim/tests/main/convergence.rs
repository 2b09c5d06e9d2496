//! Orders of convergence, also across events.

use bracketry_sim::{Inputs, Model, SimulationSettings, simulate};
use bracketry_system::System;

/// Final states with steps of `h` at most, the relative tolerance being no limit.
fn end(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64, h: f64) -> Vec<f64> {
    let system = System::parse("test.toml", text).unwrap();
    let settings = SimulationSettings::default().with_tolerance(1.0, 1e-6).with_max_step(h);
    let run = simulate(Model::new(&system, inputs).unwrap(), 0.0, x0, t_end, &settings).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run.trajectory.final_state().to_vec()
}

/// The observed orders from a sequence of halved steps, against the state with steps an eighth of the last.
fn orders(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64, first: f64, halvings: i32) -> Vec<f64> {
    let exact = end(text, inputs, x0, t_end, first * 0.5f64.powi(halvings + 3));
    let errors: Vec<f64> = (0..=halvings)
        .map(|k| {
            let x = end(text, inputs, x0, t_end, first * 0.5f64.powi(k));
            x.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        })
        .collect();
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn smooth_motion_converges_with_order_five() {
    let text = "states = [\"x\", \"v\"]\ndynamics = { x = \"v\", v = \"-sin(x)\" }";
    let found = orders(text, &Inputs::new(), &[2.0, 0.0], 6.0, 0.2, 3);
    assert!(found.iter().all(|p| (p - 5.0).abs() < 0.5), "{found:?}");
}

#[test]
fn the_order_holds_across_stops_and_breakaways() {
    // A pendulum with dry friction on a shaken base: stops, breaks loose, reverses.
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a - sin(x) - 0.6*sign(v)" }
    "#;
    let inputs = Inputs::new().expression("a", "1.2*sin(2*t)");
    let found = orders(text, &inputs, &[0.5, 0.0], 6.0, 0.2, 2);
    assert!(found.iter().all(|p| *p > 4.4), "{found:?}");
}

/// A point with dry friction on a plane.
const ON_A_PLANE: &str = r#"
    states = ["x", "y", "vx", "vy"]
    inputs = ["a", "b"]
    [dynamics]
    x = "vx"
    y = "vy"
    vx = "a - 2*unit(vx, vy)"
    vy = "b - 2*unit(vy, vx)"
"#;

#[test]
fn coupled_friction_that_slips_converges_with_order_five() {
    let inputs = Inputs::new().expression("a", "4*cos(3*t)").expression("b", "3*sin(3*t)");
    let found = orders(ON_A_PLANE, &inputs, &[0.0, 0.0, 1.0, 0.5], 3.0, 0.08, 2);
    assert!(found.iter().all(|p| (p - 5.0).abs() < 0.7), "{found:?}");
}

/// From rest the direction is stiff. Where the steps become explicit again, at a fixed ratio of their length to |σ|, the
/// low order of the explicit stages rules: third order, as for every explicit Runge–Kutta method at its limit of stability.
#[test]
fn coupled_friction_that_breaks_loose_converges_with_order_three() {
    let inputs = Inputs::new().expression("a", "4*sin(t)").expression("b", "2*t^2");
    let found = orders(ON_A_PLANE, &inputs, &[0.0; 4], 1.5, 0.08, 3);
    assert!(found.iter().all(|p| *p > 2.8), "{found:?}");
}
