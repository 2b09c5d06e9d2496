//! Set-valued signs beyond plain friction: sliding-mode control, loads that vanish, redundant and late switches.

use bracketry_sim::{
    Closures, FrictionMode, Inputs, Model, Outcome, Simulation, SimulationSettings, StopReason, simulate,
};
use bracketry_system::System;

fn run(text: &str, x0: &[f64], t_end: f64) -> Simulation {
    let system = System::parse("test.toml", text).unwrap();
    let model = Model::new(&system, &Inputs::new()).unwrap();
    let run = simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

#[test]
fn sliding_mode_control_follows_its_surface() {
    // x'' = −2 sgn(x + x'): from (1, 0) it meets x + v = 0 and then x = x₀ e^{−t}.
    let text = "states = [\"x\", \"v\"]\ndynamics = { x = \"v\", v = \"-2*sign(x + v)\" }";
    let run = run(text, &[1.0, 0.0], 8.0);
    // x = 1 − t², v = −2t: 1 − 2t − t² = 0.
    let meets = 2.0f64.sqrt() - 1.0;
    let events = run.trajectory.mode_changes();
    assert_eq!((events.len(), events[0].to), (1, FrictionMode::Sticking));
    assert!((events[0].t - meets).abs() < 1e-10);
    for i in 1..=70 {
        let t = meets + 0.1 * f64::from(i);
        let x = run.trajectory.sample(t);
        let exact = (1.0 - meets * meets) * (meets - t).exp();
        assert!((x[0] - exact).abs() < 1e-9 && (x[0] + x[1]).abs() < 1e-11, "{t} {x:?}");
    }
}

#[test]
fn a_surface_is_left_where_it_no_longer_attracts() {
    // The sign holds x + v = 0 against a growing force until that exceeds it.
    let text = "states = [\"x\", \"v\", \"c\"]\ndynamics = { x = \"v\", c = \"1\", v = \"c^2 - 2*sign(x + v)\" }";
    let run = run(text, &[0.0, 0.0, 0.0], 2.5);
    // While sliding, σ̇ = v + c² − 2s = 0 and v = −x = 0: s = c²/2 reaches 1 at c = √2.
    let event = run.trajectory.mode_changes().iter().find(|e| e.from == FrictionMode::Sticking && e.t > 0.0).unwrap();
    assert!((event.t - 2.0f64.sqrt()).abs() < 1e-9);
    assert_eq!(event.to, FrictionMode::Positive);
}

#[test]
fn a_load_that_vanishes_for_a_while_lets_go_and_grips_again() {
    // Friction μ max(N, 0) with N = sin: none in the second half of each turn.
    let text = r#"
        states = ["v", "c"]
        dynamics = { c = "1", v = "0.2 - 0.5*max(sin(c), 0)*sign(v)" }
    "#;
    let with_push = run(text, &[0.0, 0.0], 20.0);
    let (mut v, dt) = (0.0f64, 2e-6);
    for i in 0..10_000_000 {
        let c = (f64::from(i) + 0.5) * dt;
        let free = v + 0.2 * dt;
        v = free.signum() * (free.abs() - dt * 0.5 * c.sin().max(0.0)).max(0.0);
    }
    assert!((with_push.trajectory.final_state()[0] - v).abs() < 1e-5);
    // What is gripped breaks loose where 0.5 sin c falls to 0.2.
    let first = with_push.trajectory.mode_changes().iter().find(|e| e.t > 1e-9 && e.from == FrictionMode::Sticking);
    assert!(first.is_some_and(|e| (e.t.sin() - 0.4).abs() < 1e-9));
    // Without a push the load may vanish: nothing moves, nothing breaks.
    let still = run(&text.replace("0.2 -", "0 -"), &[0.0, 0.0], 20.0);
    assert!(still.trajectory.final_state()[0].abs() < 1e-15);
}

#[test]
fn redundant_switches_share_their_force() {
    let text = "states = [\"v\", \"c\"]\ndynamics = { c = \"1\", v = \"0.25*c - sign(v) - 0.2*sign(2*v)\" }";
    let run = run(text, &[0.5, 0.0], 10.0);
    // Stops under 1.2 − c/4, holds until c/4 = 1.2, then v' = c/4 − 1.2.
    assert!((run.trajectory.final_state()[0] - (10.0f64 - 4.8).powi(2) / 8.0).abs() < 1e-9);
    assert!(run.trajectory.sample(4.5)[0].abs() < 1e-15);
}

#[test]
fn late_clocks_keep_the_event_times() {
    // The same slide, started after eleven days: times resolve 1e-10 s there.
    let block = || Closures {
        dim: 1,
        switches: 1,
        rhs: |_t, _x: &[f64], s: &[f64], dx: &mut [f64]| dx[0] = -2.0 * s[0],
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
    };
    let run = simulate(block(), 1e6, &[3.0], 1e6 + 10.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished());
    assert!((run.trajectory.mode_changes()[0].t - 1e6 - 1.5).abs() < 1e-8);
    assert_eq!(run.trajectory.final_state()[0], 0.0);
}

#[test]
fn scales_from_nanometers_to_kilometers_stop_alike() {
    for scale in [1e-9, 1e-4, 1.0, 1e5] {
        let block = Closures {
            dim: 2,
            switches: 1,
            rhs: move |_t, x: &[f64], s: &[f64], dx: &mut [f64]| {
                dx[0] = x[1];
                dx[1] = -2.0 * scale * s[0];
            },
            switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[1],
            gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[1] = 1.0,
        };
        let run = simulate(block, 0.0, &[0.0, 3.0 * scale], 4.0, &SimulationSettings::default()).unwrap();
        assert!(run.outcome.is_finished());
        assert!((run.trajectory.mode_changes()[0].t - 1.5).abs() < 1e-10, "{scale}");
        assert!((run.trajectory.final_state()[0] / scale - 2.25).abs() < 1e-9);
    }
}

#[test]
fn an_end_that_is_no_time_stops_at_once() {
    let text = "states = [\"v\"]\ndynamics = { v = \"-sign(v)\" }";
    let system = System::parse("test.toml", text).unwrap();
    let model = || Model::new(&system, &Inputs::new()).unwrap();
    assert!(simulate(model(), 0.0, &[1.0], f64::INFINITY, &SimulationSettings::default()).is_err());
    let mut stepper = bracketry_sim::Stepper::new(model(), 0.0, &[1.0], &SimulationSettings::default()).unwrap();
    assert!(matches!(stepper.advance(f64::NAN), Outcome::Stopped { reason: StopReason::NonFinite, .. }));
    assert!(stepper.advance(0.5).is_finished());
    assert!((stepper.state()[0] - 0.5).abs() < 1e-12);
}

#[test]
fn too_many_steps_are_told() {
    let text = "states = [\"v\"]\ndynamics = { v = \"cos(1000*v) + 2\" }";
    let system = System::parse("test.toml", text).unwrap();
    let model = Model::new(&system, &Inputs::new()).unwrap();
    let settings = SimulationSettings { max_steps: 50, ..SimulationSettings::default() };
    let run = simulate(model, 0.0, &[0.0], 10.0, &settings).unwrap();
    let Outcome::Stopped { reason, t, .. } = run.outcome else { panic!("50 steps do not reach 10 s") };
    assert_eq!(reason, StopReason::TooManySteps { limit: 50 });
    assert!(t > 0.0 && t < 10.0);
}

#[test]
fn a_kink_that_hangs_on_a_sticking_velocity_does_not_chatter() {
    // v sticks from 0.5 s on; the kink of |2 v| and of max(−v, v) is then met at every instant.
    let text = r#"
        states = ["v", "w"]
        dynamics = { v = "-sign(v) + 0.5*sin(w) - abs(2*v)*v", w = "1 - max(-v, v)" }
    "#;
    let run = run(text, &[0.4, 0.0], 10.0);
    let stop = run.trajectory.mode_changes().iter().find(|e| e.to == FrictionMode::Sticking).unwrap().t;
    assert!(stop < 0.6 && run.trajectory.mode_changes().len() <= 4, "{:?}", run.trajectory.mode_changes());
    let end = run.trajectory.final_state();
    assert!(end[0].abs() < 1e-15);
    assert!((end[1] - run.trajectory.sample(stop)[1] - (10.0 - stop)).abs() < 1e-9);
}

#[test]
fn a_sign_that_cannot_hold_its_own_surface_follows_the_motion() {
    // v' = −sin 3c starts from v = 0 with v' = 0: no sign of v acts on v, and v turns negative.
    let text = r#"
        states = ["v", "w", "c"]
        dynamics = { v = "-sin(3*c)", w = "-sign(v)", c = "1" }
    "#;
    let run = run(text, &[0.0, 0.0, 0.0], 2.0);
    assert_eq!(run.trajectory.mode(0, 1.0), Some(FrictionMode::Negative));
    let end = run.trajectory.final_state();
    assert!((end[0] - (6.0f64.cos() - 1.0) / 3.0).abs() < 1e-9);
    assert!((end[1] - 2.0).abs() < 1e-6);
}
