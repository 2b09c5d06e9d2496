//! Smooth stiff models: against closed forms and reference values, in few steps, with events and motion between the steps.

use bracketry_sim::{Inputs, Model, Simulation, SimulationSettings, simulate};
use bracketry_system::System;

fn run(text: &str, x0: &[f64], t_end: f64) -> Simulation {
    let system = System::parse("stiff.toml", text).unwrap();
    let model = Model::new(&system, &Inputs::new()).unwrap();
    let run = simulate(model, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

/// Hairer and Wanner 1996, section IV.10; the values are those of the test set for initial value problem solvers of the University
/// of Bari (Mazzia and Magherini 2008).
#[test]
fn the_reaction_of_robertson_ends_where_it_should_and_loses_nothing() {
    let text = "states = ['a', 'b', 'c']\n[dynamics]\na = '-0.04*a + 1e4*b*c'\nb = '0.04*a - 1e4*b*c - 3e7*b^2'\nc = '3e7*b^2'";
    let known = [
        (40.0, [0.715_827_068_719_413_5, 9.185_534_764_557_338e-6, 0.284_163_745_745_829_1]),
        (1e11, [2.083_340_149_701_255e-8, 8.333_360_770_334_713e-14, 0.999_999_979_166_505]),
    ];
    for (t_end, known) in known {
        let run = run(text, &[1.0, 0.0, 0.0], t_end);
        let x = run.trajectory.final_state();
        for (x, known) in x.iter().zip(known) {
            assert!((x - known).abs() < 1e-8 * known + 1e-10, "{t_end}: {x} {known}");
        }
        for part in 0..=1000 {
            let sum: f64 = run.trajectory.sample(t_end * f64::from(part) / 1000.0).iter().sum();
            assert!((sum - 1.0).abs() < 1e-11, "{sum}");
        }
        assert!(run.statistics.steps < 1000, "{:?}", run.statistics);
    }
}

#[test]
fn relaxation_oscillations_take_some_thousand_steps() {
    // The value from the same test set.
    let text = "states = ['x', 'v']\ndynamics = { x = 'v', v = '1000*(1 - x^2)*v - x' }";
    let run = run(text, &[2.0, 0.0], 2000.0);
    let x = run.trajectory.final_state();
    assert!((x[0] - 1.706_167_732_170_483).abs() < 1e-7 && (x[1] + 8.928_097_010_247_975e-4).abs() < 1e-9, "{x:?}");
    assert!(run.statistics.steps < 5000, "{:?}", run.statistics);
}

/// The heat equation on a grid: each sine decays by itself.
#[test]
fn diffusion_decays_mode_by_mode() {
    for n in [20, 30] {
        let scale = f64::from((n + 1) * (n + 1));
        let at = |i: i32| if (1..=n).contains(&i) { format!("u{i}") } else { "0".into() };
        let names: Vec<String> = (1..=n).map(|i| format!("'u{i}'")).collect();
        let rows: Vec<String> =
            (1..=n).map(|i| format!("u{i} = '{scale:?}*({} - 2*u{i} + {})'", at(i - 1), at(i + 1))).collect();
        let text = format!("states = [{}]\n[dynamics]\n{}", names.join(", "), rows.join("\n"));
        let mode = |k: i32, i: i32| (std::f64::consts::PI * f64::from(k * i) / f64::from(n + 1)).sin();
        let x0: Vec<f64> = (1..=n).map(|i| mode(1, i) + 0.5 * mode(n, i)).collect();
        let run = run(&text, &x0, 20.0);
        let rate = |k: i32| 4.0 * scale * (std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(n + 1)).sin().powi(2);
        for t in [1e-4, 0.01, 0.1, 0.37, 1.0, 20.0] {
            for (i, x) in (1..=n).zip(run.trajectory.sample(t)) {
                let exact = (-rate(1) * t).exp() * mode(1, i) + 0.5 * (-rate(n) * t).exp() * mode(n, i);
                assert!((x - exact).abs() < 1e-8, "{n} {t} {i}: {x} {exact}");
            }
        }
        // Explicit steps are at most 3.3/rate long.
        assert!((run.statistics.steps as f64) < 0.1 * (20.0 * rate(n) / 3.3), "{n}: {:?}", run.statistics);
    }
}

/// The equation of Prothero and Robinson (1974): a fast variable follows a slow motion, also between the steps.
#[test]
fn what_is_fast_follows_what_is_slow_between_the_steps_too() {
    for rate in [1e5, 1e6, 1e7] {
        let text = format!("states = ['y', 's']\ndynamics = {{ y = '-{rate:?}*(y - cos(s)) - sin(s)', s = '1' }}");
        let run = run(&text, &[2.0, 0.0], 10.0);
        for part in 0..=5000 {
            let t = 10.0 * (f64::from(part) / 5000.0).powi(3);
            let exact = t.cos() + (-rate * t).exp();
            let y = run.trajectory.sample(t)[0];
            assert!((y - exact).abs() < 2e-8, "{rate} {t}: {y} {exact}");
        }
        assert!(run.statistics.steps < 2000, "{rate}: {:?}", run.statistics);
    }
}

/// A fast variable that stays on its slow motion switches another one, and loads a block that sticks.
#[test]
fn events_in_stiff_motion_are_exact() {
    for rate in [1e5, 1e7] {
        let text = format!(
            "states = ['y', 's', 'z']\ndynamics = {{ y = '-{rate:?}*(y - cos(s)) - sin(s)', s = '1', z = 'abs(y)' }}"
        );
        let crossed = run(&text, &[1.0, 0.0, 0.0], 4.0);
        assert!((crossed.trajectory.final_state()[2] - (2.0 - 4f64.sin())).abs() < 1e-8);
        let text = format!(
            "states = ['F', 's', 'v']\ndynamics = {{ F = '-{rate:?}*(F - s) + 1', s = '1', v = 'F - 2*sign(v)' }}"
        );
        let loaded = run(&text, &[0.0, 0.0, 0.0], 4.0);
        let change = loaded.trajectory.mode_changes();
        assert_eq!(change.len(), 1);
        assert!((change[0].t - 2.0).abs() < 1e-8, "{change:?}");
        assert!((loaded.trajectory.final_state()[2] - 2.0).abs() < 1e-8);
        for run in [crossed, loaded] {
            assert!(run.statistics.steps < 500, "{:?}", run.statistics);
        }
    }
}

/// Explicit steps take six evaluations each, and one at the start.
#[test]
fn models_that_are_not_stiff_keep_their_explicit_steps() {
    let models = [
        ("x = 'v', v = '-sin(x)'", [2.0, 0.0]),
        ("x = 'v', v = '-100*x'", [1.0, 0.0]),
        ("x = 'v', v = '3*(1 - x^2)*v - x'", [1.0, 0.0]),
        ("x = 'x*(1 - v)', v = 'v*(x - 1)'", [2.0, 1.0]),
        ("x = '-x', v = '-10*v + x'", [1.0, 1.0]),
    ];
    for (dynamics, x0) in models {
        let run = run(&format!("states = ['x', 'v']\ndynamics = {{ {dynamics} }}"), &x0, 20.0);
        let attempts = run.statistics.steps + run.statistics.rejected;
        assert_eq!(run.statistics.rhs, 6 * attempts + 1, "{dynamics}");
    }
}
