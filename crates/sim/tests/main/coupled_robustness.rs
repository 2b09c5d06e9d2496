//! Random coupled friction: every run ends where it should, with finite numbers, and agrees with finer runs.

use bracketry_sim::{Balance, Inputs, Model, SimulationSettings, simulate};
use bracketry_system::System;
use proptest::prelude::*;

/// A spinning point on a shaken plate, and another on top of it that rubs anisotropically.
const MODEL: &str = r#"
    states = ["vx", "vy", "w", "ux", "uy"]
    inputs = ["a", "b"]
    parameters = { f = 1, r = 1, k = 1, c = 1, j = 1 }
    [definitions]
    size = "sqrt(r^2*(vx - ux)^2 + (vy - uy)^2)"
    jx = "j*r^2*(vx - ux)/size"
    jy = "j*(vy - uy)/size"
    [dynamics]
    vx = "a - f*vx/sqrt(vx^2 + vy^2) - jx"
    vy = "b - f*unit(vy, vx) - jy"
    w = "0.3*a - k*w/sqrt(vx^2 + vy^2 + c*w^2)"
    ux = "a + jx"
    uy = "b + jy"
"#;

fn system(values: &[(&str, f64)]) -> System {
    let mut text = MODEL.to_owned();
    for (name, value) in values {
        text = text.replacen(&format!("{name} = 1"), &format!("{name} = {value:.6}"), 1);
    }
    System::parse("random.toml", &text).unwrap()
}

#[test]
fn points_that_break_loose_together_slide_together() {
    // A push along y that reaches the friction of both at once.
    let text = r#"
        states = ["vx", "vy", "ux", "uy"]
        inputs = ["b"]
        parameters = { f = 2.355735 }
        [dynamics]
        vx = "-f*unit(vx, vy)"
        vy = "b - f*unit(vy, vx)"
        ux = "-f*unit(ux, uy)"
        uy = "b - f*unit(uy, ux)"
    "#;
    let system = System::parse("two.toml", text).unwrap();
    let inputs = Inputs::new().expression("b", "6.7*sin(t)*cos(10.436693*t)");
    let run =
        simulate(Model::new(&system, &inputs).unwrap(), 0.0, &[0.0; 4], 2.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?} {:?}", run.outcome, run.trajectory.mode_changes());
    let end = run.trajectory.final_state();
    assert!(end[1].abs() > 1e-3 && (end[1] - end[3]).abs() < 1e-12 && end[0].abs() < 1e-12, "{end:?}");
}

proptest! {
    #![proptest_config(crate::common::random_cases(40))]

    #[test]
    fn runs_finish_and_friction_only_dissipates(
        f in 0.0f64..4.0, r in 0.3f64..3.0, k in 0.0f64..5.0, c in 0.01f64..2.0, j in 0.0f64..2.0,
        x in prop::array::uniform5(-1.0f64..1.0), still in prop::array::uniform5(any::<bool>()),
        p in 0.0f64..8.0, q in 0.0f64..8.0, turns in 1.0f64..20.0,
    ) {
        let system = system(&[("f", f), ("r", r), ("k", k), ("c", c), ("j", j)]);
        let inputs = Inputs::new()
            .expression("a", &format!("{p:.6}*sin({turns:.6}*t)"))
            .expression("b", &format!("{q:.6}*sin(t)*cos({turns:.6}*t)"));
        let x0: Vec<f64> = x.iter().zip(still).map(|(v, rest)| if rest { 0.0 } else { *v }).collect();
        let model = Model::new(&system, &inputs).unwrap();
        let run = simulate(model, 0.0, &x0, 2.0, &SimulationSettings::default()).unwrap();
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        prop_assert!(run.trajectory.final_state().iter().all(|v| v.is_finite()));
        let stored = "(vx^2 + vy^2 + ux^2 + uy^2)/2";
        let driven = "a*(vx + ux) + b*(vy + uy)";
        let friction = "-f*(vx*vx/sqrt(vx^2 + vy^2) + vy*unit(vy, vx)) - jx*(vx - ux) - jy*(vy - uy)";
        let power = format!("{driven} + ({friction})");
        let account = Balance::new(&system, &inputs, stored, &power, &[]).unwrap().of(&run.trajectory);
        prop_assert!(account.error() < 1e-7 * (1.0 + account.turnover), "{:e} {:e}", account.error(), account.turnover);
    }
}
