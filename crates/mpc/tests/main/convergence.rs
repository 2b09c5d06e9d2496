//! Problems on which whole steps, Hessians or sizes decide whether and where the solver converges.
//!
//! Reference costs are those of CasADi and IPOPT for the same discretized problem from the same guess.

use bracketry_mpc::ocp::Substeps;
use bracketry_mpc::problem::{Convergence, Method};
use bracketry_mpc::sqp::{Hessian, Solution};
use bracketry_mpc::{
    ControlProblem, CostFunction, CostKind, Ocp, PlannedTrajectory, SolveStatus, Sqp, SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::TAU;
use std::fmt::Write;

fn problem(model: &str, text: &str) -> ControlProblem {
    let text = format!("model = \"model.toml\"\n{text}");
    ControlProblem::parse("problem.toml", &text, |file| System::parse(file, model).map_err(Box::new)).unwrap()
}

/// The solution without margin, to full accuracy.
fn plan(mut problem: ControlProblem, hessian: Hessian) -> Solution {
    problem.method = Method::Plan {
        convergence: Convergence { hessian, ..Convergence::default() },
        margin: 0.0,
        feedback: bracketry_mpc::problem::Feedback::default(),
    };
    problem.plan().unwrap()
}

const QUADROTOR: &str = r#"
    states = ["x", "z", "th", "vx", "vz", "w"]
    inputs = ["f1", "f2"]
    parameters = { m = 0.5, l = 0.15, J = 0.004, g = 9.81 }
    [dynamics]
    x = "vx"
    z = "vz"
    th = "w"
    vx = "-(f1 + f2)*sin(th)/m"
    vz = "(f1 + f2)*cos(th)/m - g"
    w = "l*(f1 - f2)/J"
"#;

#[test]
fn a_quadrotor_flips_upright_from_every_tilt() {
    for (tilt, reference) in [(0.3, 0.74575), (0.6, 2.57966), (0.95, 5.63394), (1.0, 6.11740)] {
        let text = format!(
            r#"
            horizon = {{ steps = 40, dt = 0.05, substeps = 1 }}
            [cost]
            stage = "x^2 + z^2 + th^2 + 0.1*(vx^2 + vz^2 + w^2) + 0.1*((f1 - m*g/2)^2 + (f2 - m*g/2)^2)"
            terminal = "10*(x^2 + z^2 + th^2) + vx^2 + vz^2 + w^2"
            [constraints]
            f1 = {{ min = 0, max = "1.5*m*g" }}
            f2 = {{ min = 0, max = "1.5*m*g" }}
            [guess]
            f1 = "m*g/2"
            f2 = "m*g/2"
            [run]
            x0 = {{ th = "{tilt}*pi" }}
            "#
        );
        let s = plan(problem(QUADROTOR, &text), Hessian::Automatic);
        assert_eq!(s.status, SolveStatus::Converged, "{tilt}");
        assert!((s.cost / reference - 1.0).abs() < 1e-3, "{tilt}: {} in place of {reference}", s.cost);
        assert!(s.interior_point_steps > 0, "{tilt}");
    }
}

#[test]
fn an_economic_cost_on_a_race_track_takes_few_programs_because_the_exact_hessian_is_chosen() {
    let car = r#"
        states = ["s", "n", "al", "v", "de"]
        inputs = ["acc", "dde"]
        parameters = { L = 0.3 }
        definitions = { kap = "0.6*sin(0.8*s)", beta = "0.5*de", ds = "v*cos(al + beta)/(1 - n*kap)" }
        dynamics = { s = "ds", n = "v*sin(al + beta)", al = "v*de/L - kap*ds", v = "acc - 0.1*v^2", de = "dde" }
    "#;
    let lap = r#"
        horizon = { steps = 50, dt = 0.05 }
        cost = { stage = "0.001*acc^2 + 0.005*dde^2", terminal = "-s" }
        [constraints]
        acc = { min = -2, max = 2 }
        dde = { min = -3, max = 3 }
        n = { min = -0.25, max = 0.25, soft = [1e3, 1e3] }
        de = { min = -0.4, max = 0.4, soft = [1e3, 1e3] }
        grip = { expression = "v^2*de/L", min = -4, max = 4, hard = true }
        [run]
        x0 = { v = 1 }
    "#;
    let s = plan(problem(car, lap), Hessian::Automatic);
    assert_eq!((s.status, s.hessian), (SolveStatus::Converged, Hessian::Exact));
    assert!((s.cost / -7.34806 - 1.0).abs() < 1e-5, "{}", s.cost);
    assert!(s.iterations.len() <= 25, "{}", s.iterations.len());
    let slow = plan(problem(car, lap), Hessian::GaussNewton);
    assert!(slow.iterations.len() > 2 * s.iterations.len(), "{}", slow.iterations.len());
}

#[test]
fn least_fuel_is_full_thrust_coasting_and_full_braking() {
    let mass = r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = { x = "v", v = "u" }
    "#;
    for distance in [0.5_f64, 1.0, 2.5] {
        let text = format!(
            r#"
            horizon = {{ steps = 40, dt = 0.1 }}
            cost = {{ stage = "abs(u)" }}
            constraints = {{ u = {{ min = -1, max = 1 }} }}
            target = {{ x = {{ value = {distance}, tolerance = 1e-3 }}, v = {{ value = 0, tolerance = 1e-3 }} }}
            run = {{ steps = 40 }}
            "#
        );
        let s = plan(problem(mass, &text), Hessian::Automatic);
        assert_eq!(s.status, SolveStatus::Converged);
        assert!(s.miss.iter().all(|e| e.abs() < 1e-6), "{:?}", s.miss);
        // With switching times that are free, T - sqrt(T^2 - 4 d); those of the grid cost a little more.
        let least = 4.0 - (16.0 - 4.0 * distance).sqrt();
        assert!(s.cost >= least - 1e-6 && s.cost < 1.01 * least, "{distance}: {} at least {least}", s.cost);
        let partial = (0..40).filter(|&k| (0.01..0.99).contains(&s.trajectory.u(k)[0].abs())).count();
        assert!(partial <= 4, "{partial}");
    }
}

const PENDULUM: &str = r#"
    states = ["th", "w"]
    inputs = ["u"]
    dynamics = { th = "w", w = "9.81*sin(th) - 0.1*w + u" }
"#;

fn swing_up(cost: &str) -> ControlProblem {
    let rest = "
        horizon = { steps = 50, dt = 0.04 }
        constraints = { u = { min = -10, max = 10 } }
        run = { x0 = { th = 2.5 } }
    ";
    problem(PENDULUM, &format!("{rest}\n[cost]\n{cost}"))
}

#[test]
fn residuals_are_the_same_as_their_weighted_squares() {
    let squares = r#"
        stage = "10*sin(th/2)^2 + 10*(1 - cos(th))^2 + 0.1*w^2 + 0.01*u^2"
        terminal = "w^2 + 3*sin(th/2)^2"
    "#;
    let residuals = r#"
        stage = "0.01*u^2"
        residuals = ["sin(th/2)", "1 - cos(th)", "w"]
        weights = [10, "5 + 5", 0.1]
        terminal_residuals = ["w", "sin(th/2)"]
        terminal_weights = [1, 3]
    "#;
    let [a, b] = [squares, residuals].map(|c| plan(swing_up(c), Hessian::GaussNewton));
    assert_eq!([a.status, b.status], [SolveStatus::Converged; 2]);
    assert!((a.cost / b.cost - 1.0).abs() < 1e-9, "{} {}", a.cost, b.cost);
}

#[test]
fn residuals_that_make_no_cost_are_refused() {
    for (cost, message) in [
        ("residuals = [\"th\"]\nweights = [1, 2]", "2 weights for 1 residuals"),
        ("residuals = [\"th\"]\nweights = [-1]", "must not be negative"),
        ("residuals = \"th\"", "must be a list"),
        ("weights = [1]", "1 weights for 0 residuals"),
        ("stage = \"u^2\"\nterminal = \"riccati\"\nterminal_residuals = [\"th\"]", "takes no residuals"),
    ] {
        let text = format!(
            "model = \"model.toml\"\nhorizon = {{ steps = 5, dt = 0.1 }}\nrun = {{ steps = 1 }}\n[cost]\n{cost}"
        );
        let read = ControlProblem::parse("problem.toml", &text, |f| System::parse(f, PENDULUM).map_err(Box::new));
        let error = read.err().unwrap().to_string();
        assert!(error.contains(message), "{cost}: {error}");
    }
}

#[test]
fn sizes_of_stiff_kinetics_come_from_trial_runs_with_the_implicit_method() {
    // Robertson 1966: b stays near 3.6e-5 while a and c are of order 1.
    let kinetics = r#"
        states = ["a", "b", "c"]
        inputs = ["u"]
        [dynamics]
        a = "-0.04*a + 1e4*b*c + u"
        b = "0.04*a - 1e4*b*c - 3e7*b^2"
        c = "3e7*b^2 - u"
    "#;
    let text = r#"
        horizon = { steps = 40, dt = 1, integrator = "radau", stages = 2 }
        cost = { stage = "100*(a - 0.9)^2 + 100*u^2" }
        constraints = { u = { min = -0.1, max = 0.1 } }
        run = { x0 = { a = 1 } }
    "#;
    let p = problem(kinetics, text);
    assert!((1e-5..1e-3).contains(&p.ocp.state_scale[1]), "{:?}", p.ocp.state_scale);
    let s = plan(p, Hessian::Automatic);
    assert_eq!(s.status, SolveStatus::Converged);
    let end = s.trajectory.x(40);
    assert!((end.iter().sum::<f64>() - 1.0).abs() < 1e-6 && end[1] > 0.0, "{end:?}");
}

/// A chain of joints with random couplings: th_i'' = g_i sin(th_i) + k_i sin(th_{i+1} - th_i) - d_i w_i + b_i u_i.
fn random_chain(random: &mut StdRng, joints: usize) -> System {
    let list = |name: &str, count: usize| (0..count).map(|i| format!("\"{name}{i}\"")).collect::<Vec<_>>().join(", ");
    let mut text = format!(
        "states = [{}, {}]\ninputs = [{}]\n[dynamics]\n",
        list("th", joints),
        list("w", joints),
        list("u", joints)
    );
    for i in 0..joints {
        let [g, k] = [random.random_range(-6.0..6.0), random.random_range(-4.0..4.0)];
        let [d, b] = [random.random_range(0.0..0.5), random.random_range(0.5..2.0)];
        let next = (i + 1) % joints;
        let _ = writeln!(
            text,
            "th{i} = \"w{i}\"\nw{i} = \"({g})*sin(th{i}) + ({k})*sin(th{next} - th{i}) - ({d})*w{i} + ({b})*u{i}\""
        );
    }
    System::parse("chain.toml", &text).unwrap()
}

#[test]
fn a_trajectory_that_can_be_followed_is_followed_from_a_guess_at_rest() {
    let mut random = StdRng::seed_from_u64(7);
    for trial in 0..25 {
        let joints = 1 + trial % 3;
        let (n, steps, dt) = (2 * joints, 40, 0.05);
        let system = random_chain(&mut random, joints);
        let x0: Vec<f64> = (0..n).map(|_| random.random_range(-1.0..1.0)).collect();
        let waves: Vec<[f64; 3]> = (0..joints)
            .map(|_| [random.random_range(-4.0..4.0), random.random_range(0.3..1.5), random.random_range(0.0..TAU)])
            .collect();
        let input = |k: usize| waves.iter().map(|w| w[0] * (w[1] * k as f64 * dt + w[2]).sin()).collect();
        let inputs: Vec<Vec<f64>> = (0..steps).map(input).collect();
        let mut ocp = Ocp::new(n, joints, steps, dt);
        ocp.substeps = Substeps::Fixed(1);
        let solver = |ocp: &Ocp| {
            let dynamics = SymbolicDynamics::new(&system).unwrap();
            Sqp::new(Box::new(dynamics), ocp.clone(), SqpSettings::default()).unwrap()
        };
        let path = solver(&ocp).guess(&x0, &inputs).unwrap();
        let mut names: Vec<String> = system.state_names().iter().map(|s| format!("{s}_r")).collect();
        names.extend(system.input_names().iter().map(|s| format!("{s}_r")));
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let square = |s: &String| format!("({s} - {s}_r)^2");
        let of_states = system.state_names().iter().map(square).collect::<Vec<_>>().join(" + ");
        let of_inputs = system.input_names().iter().map(square).collect::<Vec<_>>().join(" + ");
        let stage = format!("{of_states} + 0.1*({of_inputs})");
        ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &names, &stage).unwrap());
        ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &names, &of_states).unwrap());
        ocp.references = (0..=steps).map(|k| [path.x(k), path.u(k.min(steps - 1))].concat()).collect();
        // Bounds that the path keeps.
        ocp.input_bounds = waves.iter().map(|w| (-w[0].abs() - 0.5, w[0].abs() + 0.5)).collect();
        let s = solver(&ocp).solve(&x0, &PlannedTrajectory::constant(steps, &x0, &vec![0.0; joints])).unwrap();
        assert_eq!(s.status, SolveStatus::Converged, "{trial}");
        assert!(s.cost < 1e-6, "{trial}: {} where 0 is possible", s.cost);
        // The interior-point method leads, whatever the number of inputs.
        assert!(s.interior_point_steps > 0, "{trial}");
    }
}

#[test]
fn a_bead_on_a_wire_goes_as_far_as_on_a_cycloid() {
    // The problem of Johann Bernoulli (1696): x = g T²/π; straight pieces cost a little.
    let bead = r#"
        states = ["x", "y", "v"]
        inputs = ["th"]
        dynamics = { x = "v*cos(th)", y = "v*sin(th)", v = "9.81*sin(th)" }
    "#;
    for (time, guess) in [(0.5, 0.2), (1.0, 0.5), (2.0, 1.2), (3.0, -0.3)] {
        let text = format!(
            "horizon = {{ steps = 40, dt = {} }}\ncost = {{ terminal = \"-x\" }}\nguess = {{ th = {guess} }}\n\
             constraints = {{ th = {{ min = -1.5708, max = 1.5708 }} }}\nrun = {{ steps = 1 }}",
            time / 40.0
        );
        let s = plan(problem(bead, &text), Hessian::Automatic);
        let farthest = 9.81 * time * time / std::f64::consts::PI;
        assert_eq!(s.status, SolveStatus::Converged, "{time}");
        assert!((-s.cost / farthest - 1.0).abs() < 1e-3, "{time}: {} of {farthest}", -s.cost);
    }
}
