//! The method that a problem needs is chosen without being asked.

use crate::common::reports::{PENDULUM, SPRING_MASS, TO_TARGET, problem, run};
use bracketry_mpc::ocp::Substeps;
use bracketry_mpc::problem::{Method, MethodReason, Note};
use bracketry_mpc::{ControlProblem, control};

const DC_MOTOR: &str = r#"
    states = ["phi", "w", "i"]
    inputs = ["U"]
    parameters = { J = 0.01, K = 0.1, R = 1, L = 0.002, Tc = 0.05, b = 0.002 }
    dynamics = { phi = "w", w = "(K*i - b*w - Tc*sign(w))/J", i = "(U - R*i - K*w)/L" }
"#;

const TURN: &str = r#"
    horizon = { steps = 30, dt = 0.01 }
    cost = { stage = "100*(phi - 1)^2 + 0.01*w^2 + 0.001*U^2" }
    constraints = { U = { min = -12, max = 12 } }
"#;

/// The method that a controller of the problem starts with, and why.
fn chosen(problem: &ControlProblem) -> (Method, MethodReason) {
    let controller = problem.controller().unwrap();
    (controller.problem().method, controller.problem().method_reason.clone())
}

fn least(problem: &ControlProblem) -> usize {
    let (Substeps::Fixed(s) | Substeps::AtLeast(s)) = problem.ocp.substeps;
    s
}

#[test]
fn friction_in_reach_is_treated_exactly_without_being_asked() {
    let report = run(SPRING_MASS, &format!("{TO_TARGET}\nrun = {{ x0 = {{ x = 0 }}, steps = 40 }}"));
    assert_eq!(report.method, "stick-slip");
    assert_eq!(report.method_reason, MethodReason::Friction { names: vec!["v".into()] });
    assert!(report.succeeded && (report.x_final.get("x").unwrap() - 2.0).abs() < 0.02, "{report:?}");
}

#[test]
fn an_explicit_method_gets_steps_for_the_fastest_mode() {
    // R/L is 500/s: one step of 10 ms would be unstable.
    for method in ["", "solve = { method = \"stick-slip\" }", "solve = { method = \"sqp\" }"] {
        let p = problem(DC_MOTOR, &format!("{TURN}\n{method}\nrun = {{}}"));
        assert!(least(&p) >= 2, "{method}");
        let report = control(&p).unwrap().run.report;
        assert!(
            (report.open_loop_cost - 8.02).abs() < 0.05 || method.contains("sqp"),
            "{method}: {}",
            report.open_loop_cost
        );
        assert!(report.closed_loop_cost < 9.0 && report.succeeded, "{method}: {report:?}");
    }
    let smooth = DC_MOTOR.replace("Tc = 0.05", "Tc = 0").replace(" - Tc*sign(w)", "");
    assert!(least(&problem(&smooth, &format!("{TURN}\nrun = {{}}"))) >= 2);
    // What is asked for is taken.
    let fixed = TURN.replace("dt = 0.01", "dt = 0.01, substeps = 1");
    assert_eq!(least(&problem(DC_MOTOR, &format!("{fixed}\nrun = {{}}"))), 1);
}

#[test]
fn one_program_where_it_settles_and_converged_ones_where_it_does_not() {
    let cost = "cost = { stage = \"10*th^2 + 0.1*w^2 + 0.01*u^2\" }\nconstraints = { u = { min = -10, max = 10 } }";
    let near =
        problem(PENDULUM, &format!("horizon = {{ steps = 30, dt = 0.04 }}\n{cost}\nrun = {{ x0 = {{ th = 0.1 }} }}"));
    assert!(matches!(near.method, Method::Automatic { .. }), "a file is read, not solved");
    assert!(matches!(chosen(&near), (Method::Rti { .. }, MethodReason::Settled { .. })));
    let text =
        format!("horizon = {{ steps = 50, dt = 0.04 }}\n{cost}\nrun = {{ x0 = {{ th = \"pi\" }}, steps = 100 }}");
    let report = run(PENDULUM, &text);
    assert_eq!(report.method, "sqp");
    assert!(matches!(report.method_reason, MethodReason::NotSettled { .. }));
    assert!(report.succeeded && report.x_final.get("th").unwrap().abs() < 1e-3, "{report:?}");
    assert_eq!(report.status.solved, 100);
    // A setting of one method alone asks for it.
    let asked = problem(PENDULUM, &format!("{text}\nsolve = {{ initial_iterations = 30 }}"));
    assert!(matches!(asked.method, Method::Rti { .. }));
    assert_eq!(asked.method_reason, MethodReason::Setting { key: "initial_iterations".into() });
    let given = problem(PENDULUM, &format!("{text}\nsolve = {{ method = \"rti\" }}"));
    assert_eq!(given.method_reason, MethodReason::Given);
}

#[test]
fn targets_at_the_end_of_the_run_are_planned_for_once() {
    let model = "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = { x = \"v\", v = \"u\" }";
    let text = "horizon = { steps = 20, dt = 0.1 }\ncost = { stage = \"u^2\" }\n\
                target = { x = { value = 1, tolerance = 1e-3 }, v = { value = 0, tolerance = 1e-3 } }\n";
    let report = run(model, &format!("{text}run = {{}}"));
    assert_eq!((report.method, &report.method_reason), ("plan", &MethodReason::Targets));
    // The double integrator from rest to rest in 2 s: 12/T³, and what holding the inputs adds.
    assert!(report.succeeded && (report.open_loop_cost / 1.5 - 1.0).abs() < 0.01, "{report:?}");
    // A horizon that moves on never arrives.
    let moving = run(model, &format!("{text}solve = {{ method = \"sqp\" }}\nrun = {{}}"));
    assert!(!moving.succeeded && moving.notes.iter().all(|n| matches!(n, Note::MissedTarget { .. })), "{moving:?}");
    assert!(moving.notes[0].to_string().contains("method = \"plan\""));
    assert_eq!(run(model, &format!("{text}run = {{ steps = 60 }}")).method, "rti");
    // A run that ends before the horizon is judged by its plan.
    for method in ["", "solve = { method = \"plan\" }\n", "solve = { method = \"sqp\" }\n"] {
        for steps in [1, 5, 19] {
            let early = run(model, &format!("{text}{method}run = {{ steps = {steps} }}"));
            assert!(early.succeeded, "{:?}", early.notes);
            let [Note::TargetsLater { run: length, horizon, .. }] = early.notes[..] else {
                panic!("{:?}", early.notes)
            };
            assert!((length - 0.1 * steps as f64).abs() < 1e-12 && (horizon - 2.0).abs() < 1e-12, "{length} {horizon}");
            let bounded = format!(
                "{text}{method}constraints = {{ u = {{ min = -0.1, max = 0.1 }} }}\nrun = {{ steps = {steps} }}"
            );
            let out_of_reach = run(model, &bounded);
            let told = out_of_reach.notes.iter().any(|n| matches!(n, Note::PlanMisses { state, .. } if state == "x"));
            assert!(!out_of_reach.succeeded && told, "{:?}", out_of_reach.notes);
        }
    }
}

/// What is to hold at the end of the run is a target, too: docking by constraints of the end.
#[test]
fn constraints_of_the_end_of_the_run_are_planned_for_once() {
    let model = "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = { x = \"v\", v = \"u - 0.1*v*abs2\" }\n\
                 definitions = { abs2 = \"1 + v^2\" }";
    for (goal, speed) in [(1.0, 0.0), (-0.5, 0.2), (2.0, -0.1)] {
        let text = format!(
            "horizon = {{ steps = 25, dt = 0.1 }}\ncost = {{ stage = \"u^2\" }}\n\
             constraints = {{ at = {{ expression = \"x\", min = {goal}, max = {goal}, hard = true, at = \"end\" }}, \
             touch = {{ expression = \"v\", min = {speed}, max = {speed}, hard = true, at = \"end\" }} }}\n"
        );
        let report = run(model, &format!("{text}run = {{}}"));
        assert_eq!((report.method, &report.method_reason), ("plan", &MethodReason::Targets));
        let end = ["x", "v"].map(|n| report.x_final.get(n).copied().unwrap());
        assert!(report.succeeded && (end[0] - goal).abs().max((end[1] - speed).abs()) < 1e-3, "{report:?}");
        assert!((report.closed_loop_cost / report.open_loop_cost - 1.0).abs() < 1e-2, "{report:?}");
        assert_ne!(run(model, &format!("{text}run = {{ steps = 60 }}")).method, "plan");
    }
}

#[test]
fn a_cost_at_the_end_of_the_run_alone_is_planned_for_once() {
    // Two reactions in a row, x -> y -> nothing: the most of y at the end, by the temperature u.
    let model = "states = [\"x\", \"y\"]\ninputs = [\"u\"]\ndynamics = { x = \"-u*x\", y = \"u*x - 0.5*u^2*y\" }";
    let text = "horizon = { steps = 20, dt = 0.1 }\ncost = { terminal = \"-y\" }\n\
                constraints = { u = { min = 0.1, max = 3 } }\n";
    let of = |more: &str| run(model, &format!("{text}{more}"));
    let report = of("run = { x0 = { x = 1 } }");
    assert_eq!((report.method, &report.method_reason), ("plan", &MethodReason::TerminalCost));
    let reached = report.closed_loop_terminal_cost.unwrap();
    assert!(report.succeeded && (reached / report.open_loop_cost - 1.0).abs() < 1e-3, "{report:?}");
    let moving = of("solve = { method = \"sqp\" }\nrun = { x0 = { x = 1 } }");
    assert!(-moving.x_final.get("y").unwrap() > reached, "{moving:?}");
    // A run that goes on has no end that the cost counts at.
    assert_ne!(of("run = { x0 = { x = 1 }, steps = 40 }").method, "plan");
}

#[test]
fn a_method_is_not_chosen_at_a_guess_that_is_stationary() {
    // Hanging pendulums on a cart of random lengths and masses: at rest, the cost has no slope, and is no minimum.
    for seed in 1..7_i32 {
        let s = f64::from(seed);
        let (length, mass) = (0.3 + 0.5 * s.sin().abs(), 0.1 + 0.5 * (2.0 * s).cos().abs());
        let model = format!(
            "states = [\"x\", \"th\", \"v\", \"w\"]\ninputs = [\"u\"]\nparameters = {{ m = {mass}, l = {length}, g = 9.81 }}\n\
             definitions = {{ a = \"(u + m*sin(th)*(l*w^2 - g*cos(th)))/(1 + m*sin(th)^2)\" }}\n\
             dynamics = {{ x = \"v\", th = \"w\", v = \"a\", w = \"(g*sin(th) - a*cos(th))/l\" }}"
        );
        let text = "horizon = { steps = 60, dt = 0.03 }\n\
                    cost = { stage = \"x^2 + 10*(1 - cos(th)) + 0.01*(v^2 + w^2) + 0.001*u^2\", terminal = \"50*(1 - cos(th)) + w^2\" }\n\
                    constraints = { u = { min = -30, max = 30 } }\nrun = { x0 = { th = \"pi\" }, steps = 100 }";
        let report = run(&model, text);
        assert!(
            matches!(report.method_reason, MethodReason::NotSettled { .. } | MethodReason::NotConverging),
            "{report:?}"
        );
        let upright = report.x_final.get("th").unwrap().cos() > 0.99;
        assert!(upright || !report.succeeded, "{seed}: {report:?}");
    }
}

/// Targets at the end of the run, with dry friction on the way: a plan whose inputs arrive on the exact flow is taken without being
/// asked for, and arrives; where a horizon that moves on is asked for, the note names the plan.
#[test]
fn targets_beyond_dry_friction_are_planned_for_where_the_plan_arrives() {
    for friction in [0.2, 0.5] {
        let model = SPRING_MASS.replace("F = 0.2", &format!("F = {friction}"));
        let text = r#"
            horizon = { steps = 20, dt = 0.15 }
            cost = { stage = "0.1*v^2 + 0.1*u^2" }
            constraints = { u = { min = -2, max = 2 } }
            target = { x = { value = 1, tolerance = 0.01 }, v = { value = 0, tolerance = 0.01 } }
        "#;
        let chosen = run(&model, &format!("{text}run = {{}}"));
        assert_eq!((chosen.method, &chosen.method_reason), ("plan", &MethodReason::Targets));
        assert!(chosen.succeeded && chosen.miss.iter().all(|(_, miss)| miss.abs() <= 0.01), "{chosen:?}");
        let moving = run(&model, &format!("{text}solve = {{ method = \"stick-slip\" }}\nrun = {{}}"));
        let missed = moving.notes.iter().find(|n| matches!(n, Note::MissedTarget { .. })).unwrap();
        assert!(!moving.succeeded && missed.to_string().contains("method = \"plan\""), "{missed}");
    }
}
