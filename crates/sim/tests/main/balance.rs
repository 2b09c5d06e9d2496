//! Energy balance and invariants along trajectories with stick and slip.

use bracketry_sim::{Account, Balance, InputError, Inputs, Model, SimulationSettings, simulate};
use bracketry_system::System;

fn account(text: &str, inputs: &Inputs, x0: &[f64], t_end: f64, stored: &str, power: &str, kept: &[&str]) -> Account {
    let system = System::parse("test.toml", text).unwrap();
    let run = simulate(Model::new(&system, inputs).unwrap(), 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished());
    assert!(run.trajectory.mode_changes().len() > 3 || !kept.is_empty());
    Balance::new(&system, inputs, stored, power, kept).unwrap().of(&run.trajectory)
}

#[test]
fn a_spring_driven_block_turns_its_work_into_heat() {
    let text = r#"
        states = ["x", "v"]
        inputs = ["X"]
        parameters = { k = 20, f = 1.5 }
        dynamics = { x = "v", v = "k*(X - x) - f*sign(v)" }
    "#;
    let inputs = Inputs::new().expression("X", "0.3*sin(3*t)");
    let a = account(text, &inputs, &[0.0, 0.0], 10.0, "v^2/2 + k*(X - x)^2/2", "k*(X - x)*der(X) - f*sign(v)*v", &[]);
    assert!(a.relative_error() < 1e-9, "{:e}", a.relative_error());
    assert!(a.turnover > 1.0);
}

#[test]
fn coupled_friction_on_a_shaken_plate_closes_its_balance() {
    let text = r#"
        states = ["x", "y", "vx", "vy"]
        inputs = ["X", "Y"]
        parameters = { f = 2.943 }
        [dynamics]
        x = "vx"
        y = "vy"
        vx = "-der(X, 2) - f*unit(vx, vy)"
        vy = "-der(Y, 2) - f*unit(vy, vx)"
    "#;
    let inputs = Inputs::new().expression("X", "0.05*sin(9*t)*sin(t)").expression("Y", "0.03*cos(9*t)*sin(t)^2");
    // In the laboratory: kinetic energy of the object, power of the friction force, also while it sticks.
    let stored = "((vx + der(X))^2 + (vy + der(Y))^2)/2";
    let power = "-f*unit(vx, vy)*(vx + der(X)) - f*unit(vy, vx)*(vy + der(Y))";
    let a = account(text, &inputs, &[0.0; 4], 8.0, stored, power, &[]);
    assert!(a.relative_error() < 1e-9, "{:e}", a.relative_error());
    // A wrong power does not close.
    let wrong = account(text, &inputs, &[0.0; 4], 8.0, stored, "-f*unit(vx, vy)*(vx + der(X))", &[]);
    assert!(wrong.relative_error() > 1e-3);
}

#[test]
fn invariants_are_watched() {
    // Two blocks rub on each other: their momentum stays, sliding and sticking.
    let text = r#"
        states = ["v", "w"]
        parameters = { f = 1, m = 3 }
        dynamics = { v = "-f*sign(v - w)", w = "f*sign(v - w)/m" }
    "#;
    let a =
        account(text, &Inputs::new(), &[1.0, 0.0], 3.0, "v^2/2 + m*w^2/2", "-f*sign(v - w)*(v - w)", &["v + m*w", "v"]);
    assert!(a.drifts[0] < 1e-12 && (a.drifts[1] - 0.75).abs() < 1e-9, "{:?}", a.drifts);
    assert!(a.relative_error() < 1e-10);
    assert_eq!(a.invariants[0].len(), a.times.len());
}

#[test]
fn a_quantity_that_cannot_be_read_is_told() {
    let system = System::parse("test.toml", "states = [\"v\"]\ndynamics = { v = \"-sign(v)\" }").unwrap();
    let refused = Balance::new(&system, &Inputs::new(), "v^2/2", "-sign(u)*v", &[]).unwrap_err();
    assert!(matches!(refused, InputError::Quantity { .. }), "{refused}");
}
