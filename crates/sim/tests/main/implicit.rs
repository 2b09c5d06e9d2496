//! Models with algebraic variables of index 1: against closed forms, and where the equations have no solution.

use bracketry_sim::{
    AlgebraicRoot, Breakdown, Closures, NoRootReason, Outcome, Scenario, ScenarioRun, SimulationSettings, simulate,
};
use bracketry_system::{Accepted, System};
use proptest::prelude::*;

fn model(text: &str) -> System {
    System::parse_accepting("model.toml", text, Accepted { algebraic: true, ..Accepted::default() }).unwrap()
}

fn run(model: &System, scenario: &str) -> ScenarioRun {
    Scenario::parse("scenario.toml", scenario, model).unwrap().run(model, &SimulationSettings::default()).unwrap()
}

/// The principal branch of w exp(w) = y for y ≥ 0, by Newton's method for w + ln w = ln y.
fn lambert_w(ln_y: f64) -> f64 {
    let mut w = if ln_y > 1.0 { ln_y - ln_y.ln() } else { ln_y.exp().min(1.0) };
    for _ in 0..60 {
        w *= (1.0 + ln_y - w.ln()) / (1.0 + w);
    }
    w
}

#[test]
fn a_diode_with_a_resistor_has_the_current_of_lambert_w() {
    // Banwell and Jayakumar 2000: i = (Vt/R) W((Is R/Vt) exp((e − v + R Is)/Vt)) − Is.
    let (is, vt, r, c) = (1e-12_f64, 0.025_85, 1000.0, 1e-6);
    let text = "states = ['v']\ninputs = ['e']\nparameters = { Is = 1e-12, Vt = 0.02585, R = 1000, C = 1e-6 }\n\
                dynamics = { v = 'Is*(exp(d/Vt) - 1)/C - v/(5*R*C)' }\noutputs = { i = 'Is*(exp(d/Vt) - 1)', d = 'd' }\n\
                [algebraic]\nd = { equation = 'e - v - d - R*Is*(exp(d/Vt) - 1)', guess = 0.5 }";
    let run = run(&model(text), "duration = 0.02\nsample = 1e-4\ninputs = { e = '3*sin(2*pi*100*t)' }");
    let current = |t: f64, v: f64| {
        let e = 3.0 * (2.0 * std::f64::consts::PI * 100.0 * t).sin();
        vt / r * lambert_w((is * r / vt).ln() + (e - v + r * is) / vt) - is
    };
    let mut v = 0.0;
    let mut t = 0.0;
    let rate = |t: f64, v: f64| current(t, v) / c - v / (5.0 * r * c);
    for (row, time) in run.times.iter().enumerate() {
        assert!((run.states[row][0] - v).abs() < 1e-5, "{time}: {} {v}", run.states[row][0]);
        let i = current(*time, run.states[row][0]);
        assert!((run.outputs[row][0] - i).abs() < 1e-8 * (1e-3 + i.abs()), "{time}: {} {i}", run.outputs[row][0]);
        // The classical Runge–Kutta method with short steps.
        let h = 1e-4 / 200.0;
        for _ in 0..200 {
            let k1 = rate(t, v);
            let k2 = rate(t + h / 2.0, v + h / 2.0 * k1);
            let k3 = rate(t + h / 2.0, v + h / 2.0 * k2);
            let k4 = rate(t + h, v + h * k3);
            v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            t += h;
        }
    }
    assert!(run.states.iter().any(|x| x[0] > 1.0));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// z_i + z_i³ + Σ b_ij z_j = x_i has one solution for a small b. With z as states, z' = −g_z⁻¹ g_x x', the same motion is an
    /// ordinary differential equation, which x = z + z³ + bz then solves.
    #[test]
    fn the_motion_is_that_of_the_reduced_equations(
        b in prop::collection::vec(-0.3f64..0.3, 4),
        a in prop::collection::vec(-1.0f64..1.0, 4),
        x0 in prop::collection::vec(-3.0f64..3.0, 2),
    ) {
        let text = format!(
            "states = ['x', 'y']\nparameters = {{ b0 = {:?}, b1 = {:?}, b2 = {:?}, b3 = {:?} }}\n\
             dynamics = {{ x = '({:?})*z + ({:?})*w - z', y = '({:?})*z + ({:?})*w - w' }}\noutputs = {{ z = 'z', w = 'w' }}\n\
             [algebraic]\nz = 'z + z^3 + b0*z + b1*w - x'\nw = 'w + w^3 + b2*z + b3*w - y'",
            b[0], b[1], b[2], b[3], a[0], a[1], a[2], a[3]
        );
        let run = run(&model(&text), &format!("duration = 2\nsample = 0.1\nx0 = {{ x = {:?}, y = {:?} }}", x0[0], x0[1]));
        let (z0, w0) = (run.outputs[0][0], run.outputs[0][1]);
        let of = |z: f64, w: f64| [z + z.powi(3) + b[0] * z + b[1] * w, w + w.powi(3) + b[2] * z + b[3] * w];
        prop_assert!((of(z0, w0)[0] - x0[0]).abs() < 1e-10 && (of(z0, w0)[1] - x0[1]).abs() < 1e-10);
        let reduced = Closures {
            dim: 2,
            switches: 0,
            rhs: |_t, z: &[f64], _s: &[f64], dz: &mut [f64]| {
                let f = [a[0] * z[0] + a[1] * z[1] - z[0], a[2] * z[0] + a[3] * z[1] - z[1]];
                let (p, q) = (1.0 + 3.0 * z[0] * z[0] + b[0], 1.0 + 3.0 * z[1] * z[1] + b[3]);
                let d = p * q - b[1] * b[2];
                dz[0] = (q * f[0] - b[1] * f[1]) / d;
                dz[1] = (p * f[1] - b[2] * f[0]) / d;
            },
            switching: |_t, _x: &[f64], _sigma: &mut [f64]| {},
            gradient: |_t, _x: &[f64], _g: &mut [f64], _dt: &mut [f64]| {},
        };
        let reference = simulate(reduced, 0.0, &[z0, w0], 2.0, &SimulationSettings::default()).unwrap().trajectory;
        for (k, t) in run.times.iter().enumerate() {
            let z = reference.sample(*t);
            prop_assert!((run.outputs[k][0] - z[0]).abs() < 1e-6 && (run.outputs[k][1] - z[1]).abs() < 1e-6);
            let x = of(z[0], z[1]);
            prop_assert!((run.states[k][0] - x[0]).abs() < 1e-6 && (run.states[k][1] - x[1]).abs() < 1e-6);
        }
    }
}

#[test]
fn the_guess_selects_the_branch_which_the_motion_keeps() {
    for guess in [1.5, -1.5] {
        let text = format!(
            "states = ['x']\ndynamics = {{ x = 'z' }}\noutputs = {{ z = 'z' }}\n[algebraic]\nz = {{ equation = 'z^2 - x^2 - 1', guess = {guess} }}"
        );
        let run = run(&model(&text), "duration = 3\nx0 = { x = -2 }");
        for (x, z) in run.states.iter().zip(&run.outputs) {
            assert!((z[0] - f64::copysign((x[0] * x[0] + 1.0).sqrt(), guess)).abs() < 1e-10);
        }
    }
}

#[test]
fn a_motion_into_a_fold_stops_there_and_says_so() {
    // z² = x and x' = −1 − z: with s = √x, 2 s s' = −1 − s until s = 0, after 2 (s − ln(1 + s)).
    let text = "states = ['x']\ndynamics = { x = '-1 - z' }\n[algebraic]\nz = { equation = 'z^2 - x', guess = 1 }";
    let run = run(&model(text), "duration = 5\nx0 = { x = 4 }");
    let Outcome::Stopped { t, .. } = run.simulation.outcome else { panic!("there is no solution beyond") };
    assert!((t - 2.0 * (2.0 - 3f64.ln())).abs() < 1e-4, "{t}");
    let Some(Breakdown::NoRoot(failure)) = run.breakdown else { panic!("{:?}", run.breakdown) };
    assert_eq!(failure.equation, 0);
    // From the start.
    let run = self::run(&model(text), "duration = 5\nx0 = { x = -1 }");
    assert!(matches!(run.breakdown, Some(Breakdown::NoRoot(_))), "{:?}", run.breakdown);
}

#[test]
fn a_solution_beyond_a_fold_is_refused() {
    // z³ − 3z = x has folds at z = ±1; the branch above ends at x = −2.
    let mut root = AlgebraicRoot::new(vec![2.0]);
    let mut solve = |x: f64| {
        root.solve(|z, g, dg| {
            g[0] = z[0].powi(3) - 3.0 * z[0] - x;
            dg[0] = 3.0 * z[0] * z[0] - 3.0;
        })
    };
    for k in 0..=40 {
        let x = 2.0 - 0.099 * f64::from(k);
        assert!(solve(x).unwrap()[0] > 1.0);
    }
    let failure = solve(-2.5).unwrap_err();
    assert_ne!(failure.why, NoRootReason::Singular);
    assert!(solve(-1.0).unwrap()[0] > 1.0);
}
