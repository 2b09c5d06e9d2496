//! The record of a closed loop is that of this loop: its states at the samples, its modes between them, and its disturbances.

use bracketry_mpc::{ControlProblem, Controlled, control};
use bracketry_sim::FrictionMode;
use bracketry_system::{Accepted, System};
use proptest::prelude::*;

const BLOCK: &str = "dynamics = { x = 'v', v = 'u - 2*sign(v)' }";
const OSCILLATOR: &str = "dynamics = { x = 'v', v = 'u - x - 0.2*v' }";
const LATE: &str = "dynamics = { x = 'v', v = 'u - x - sign(v)' }\n[delays]\nu = 0.07";
const MAP: &str = "time = 'discrete'\nperiod = 0.05\ndynamics = { x = 'x + 0.05*v', v = 'v + 0.05*(u - x)' }";

/// A loop of 40 samples of 0.1 s that is disturbed as said.
fn run(plant: &str, bound: f64, faults: &str) -> Controlled {
    let model = format!("states = ['x', 'v']\ninputs = ['u']\n{plant}\n");
    let problem = format!(
        "model = 'm'\nhorizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = '(x - 1)^2 + 0.1*v^2 + 0.1*u^2' }}\n\
         constraints = {{ u = {{ min = {}, max = {bound} }} }}\nsolve = {{ method = 'rti' }}\n\
         [run]\nsteps = 40\nfaults = [{faults}]\n",
        -bound
    );
    let accepted = Accepted { discrete: true, algebraic: false };
    let read = |file: &str| System::parse_accepting(file, &model, accepted).map_err(Box::new);
    control(&ControlProblem::parse("p.toml", &problem, read).unwrap()).unwrap()
}

/// The recorded state at every sample, after a jump there, is that of the loop; the end too.
fn assert_of_the_loop(controlled: &Controlled) {
    let (recorded, sampled) = (&controlled.recording.trajectory, &controlled.run.closed_loop);
    for (t, x) in sampled.t.iter().zip(&sampled.x) {
        let found = recorded.sample(t + 1e-10);
        for (a, b) in found.iter().zip(x) {
            assert!((a - b).abs() <= 1e-8 * (1.0 + b.abs()), "at {t}: {found:?}, {x:?}");
        }
    }
    for switch in 0..controlled.switches.len() {
        for interval in recorded.mode_intervals(switch) {
            let middle = recorded.sample(f64::midpoint(interval.from, interval.to))[1];
            let expected = match interval.mode {
                FrictionMode::Sticking => middle == 0.0,
                FrictionMode::Positive => middle > 0.0,
                FrictionMode::Negative => middle < 0.0,
                FrictionMode::Sliding => unreachable!("no unit vectors"),
            };
            assert!(expected || interval.to - interval.from < 1e-9, "{interval:?}: v = {middle}");
        }
    }
}

#[test]
fn a_block_that_a_disturbance_sets_moving_is_recorded_as_sliding() {
    // |u| ≤ 1/2 never overcomes the friction; the push at the tenth sample gives 2 m/s, which ends after 2/(2 ± 1/2) s.
    let controlled = run(BLOCK, 0.5, "{ at = 10, disturbance = { v = 2 } }");
    let modes = controlled.recording.trajectory.mode_intervals(0);
    let slides: Vec<_> = modes.iter().filter(|interval| interval.mode == FrictionMode::Positive).collect();
    assert_eq!(slides.len(), 1, "{modes:?}");
    assert!((slides[0].from - 1.0).abs() < 1e-9 && (1.8..2.34).contains(&slides[0].to), "{modes:?}");
    assert_of_the_loop(&controlled);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn the_record_meets_the_samples_whatever_disturbs_them(
        plant in prop::sample::select(vec![BLOCK, OSCILLATOR, LATE, MAP]),
        at in 0usize..38,
        later in 0usize..38,
        push in -3.0f64..3.0,
        shift in -1.0f64..1.0,
    ) {
        let faults = format!("{{ at = {at}, disturbance = {{ v = {push} }} }}, {{ at = {later}, disturbance = {{ x = {shift} }} }}");
        assert_of_the_loop(&run(plant, 4.0, &faults));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// x' = u − x at the equilibrium x = u0: until a delay has passed, the plant still has the input from before the start.
    #[test]
    fn late_inputs_have_been_what_they_were_before_the_start(u0 in -1.0..1.0f64, delay in 0.01..0.35f64) {
        let model = format!("states = ['x']\ninputs = ['u']\ndynamics = {{ x = 'u - x' }}\ndelays = {{ u = {delay} }}");
        let problem = format!(
            "model = 'm'\nhorizon = {{ steps = 10, dt = 0.1 }}\n\
             cost = {{ stage = '(x - {u0})^2 + (u - {u0})^2', terminal = '(x - {u0})^2' }}\n\
             constraints = {{ u = {{ min = -2, max = 2 }} }}\n[run]\nsteps = 20\nx0 = {{ x = {u0} }}\nu0 = {{ u = {u0} }}\n"
        );
        let read = |file: &str| System::parse(file, &model).map_err(Box::new);
        let run = control(&ControlProblem::parse("p.toml", &problem, read).unwrap()).unwrap().run;
        for x in &run.closed_loop.x {
            prop_assert!((x[0] - u0).abs() < 1e-6, "{x:?} for {u0}");
        }
    }
}
