//! Runs that fail without a failing sample are told so, with the reason; healthy ones are not accused.

use crate::common::reports::{PENDULUM, SPRING_MASS, TO_TARGET, run};
use bracketry_mpc::ControlProblem;
use bracketry_mpc::problem::{ClosedLoopReport, Note};
use bracketry_system::System;

#[test]
fn a_plan_with_smoothed_friction_arrives_or_says_that_it_does_not() {
    let report =
        run(SPRING_MASS, &format!("{TO_TARGET}\nsolve = {{ method = \"plan\" }}\nrun = {{ x0 = {{ x = 0 }} }}"));
    let arrived = (report.x_final.get("x").unwrap() - 2.0).abs() < 0.3;
    assert!(arrived || !report.succeeded && report.notes.iter().any(Note::is_failure), "{report:?}");
}

/// The message of a problem that cannot be read.
fn refused(model: &str, text: &str) -> String {
    let text = format!("model = \"model.toml\"\n{text}");
    match ControlProblem::parse("problem.toml", &text, |file| System::parse(file, model).map_err(Box::new)) {
        Ok(_) => panic!("accepted: {text}"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    let model = "states = [\"x\"]\ninputs = [\"u\"]\nranges = { u = { min = -1, max = 1 } }\ndynamics = { x = \"u\" }";
    let horizon = "horizon = { steps = 10, dt = 0.1 }\nrun = { x0 = { x = 1 } }\n";
    let none = refused(model, horizon);
    assert!(none.contains("neither a cost nor a target"), "{none}");
    let rate = refused(model, &format!("{horizon}cost = {{ stage = \"x^2 + der( u )^2\" }}"));
    assert!(
        rate.contains("problem.toml:4:") && rate.contains("`der(u)` cannot be used") && rate.contains("u_rate"),
        "{rate}"
    );
    let cost = "cost = { stage = \"x^2 + u^2\" }\n";
    for bounds in ["min = 2, max = 3", "min = 2", "max = -2"] {
        let apart = refused(model, &format!("{horizon}{cost}constraints = {{ u = {{ {bounds} }} }}"));
        assert!(apart.contains("contradict its range -1 to 1"), "{apart}");
    }
    // Bounds beyond the range are kept, and said.
    let wide = run(model, &format!("{horizon}{cost}constraints = {{ u = {{ min = -5 }} }}"));
    assert!(wide.succeeded && matches!(&wide.notes[..], [Note::BeyondRange { .. }]), "{:?}", wide.notes);
    let narrow = run(model, &format!("{horizon}{cost}constraints = {{ u = {{ min = -0.5 }} }}"));
    assert!(narrow.succeeded && narrow.notes.is_empty(), "{:?}", narrow.notes);
}

#[test]
fn a_plan_that_rest_does_not_hold_is_told() {
    let plan = |rest: &str, steps: usize| {
        run(
            SPRING_MASS,
            &format!(
                "{TO_TARGET}\nsolve = {{ method = \"plan\"{rest} }}\nrun = {{ x0 = {{ x = 0 }}, steps = {steps} }}"
            ),
        )
    };
    let lost = plan("", 40);
    assert!(!lost.succeeded && matches!(&lost.notes[..], [Note::NotHeld { count: 20, .. }]), "{lost:?}");
    assert!(plan(", rest = { u = 1.6 }", 40).succeeded && plan("", 20).succeeded);
}

#[test]
fn costs_without_a_lower_bound_and_unstable_loops_are_told() {
    let model = "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = { x = \"v\", v = \"u\" }";
    let horizon = "horizon = { steps = 20, dt = 0.1 }\nrun = { x0 = { x = 1 }, steps = 40 }\n";
    for cost in ["stage = \"x^2 - u^2\"", "stage = \"-x^2 - u^2\"", "stage = \"u^2\", terminal = \"-x^2\""] {
        for method in ["", "solve = { method = \"plan\" }\n"] {
            let report = run(model, &format!("{horizon}{method}cost = {{ {cost} }}"));
            let told = report.notes.iter().any(|n| matches!(n, Note::Diverges { in_plan: true, .. } | Note::NoPlan));
            assert!(!report.succeeded && told, "{cost} {method} {:?}", report.notes);
        }
    }
    // A pole that the controller does not know of, under whatever conditions.
    let spring = model.replace("v = \"u\"", "v = \"u - k*x\"").replace("dynamics", "parameters = { k = 1 }\ndynamics");
    for conditions in ["", ", noise = { x = 1e-6 }", ", delay = 1"] {
        let text = "horizon = { steps = 20, dt = 0.1 }\ncost = { stage = \"x^2 + v^2 + u^2\" }\n\
                    constraints = { u = { min = -1, max = 1 } }\n";
        let run_of = |plant: &str| format!("{text}run = {{ x0 = {{ x = 1 }}, steps = 100{conditions}{plant} }}");
        let report = run(&spring, &run_of(", parameters = { k = -50 }"));
        let told = report.notes.iter().any(|n| matches!(n, Note::Diverges { in_plan: false, .. }));
        assert!(!report.succeeded && told, "{conditions} {:?}", report.notes);
        assert!(run(&spring, &run_of("")).notes.iter().all(|n| !matches!(n, Note::Diverges { .. })));
    }
}

#[test]
fn inputs_that_stay_at_a_guess_that_is_no_minimum_are_told() {
    // Hanging, the cost does not tell one side from the other: the guess 0 is stationary, and a maximum.
    let hanging = PENDULUM.replace("9.81*sin(th)", "-9.81*sin(th)");
    let text = |guess: &str, method: &str| {
        format!(
            "horizon = {{ steps = 40, dt = 0.05 }}\ncost = {{ stage = \"10*(1 + cos(th))^2 + 0.01*u^2\" }}\n\
             constraints = {{ u = {{ min = -12, max = 12 }} }}\n{guess}\nsolve = {{ method = \"{method}\" }}\n\
             run = {{ steps = 60 }}"
        )
    };
    let idle = run(&hanging, &text("", "rti"));
    assert!(!idle.succeeded, "{idle:?}");
    assert!(idle.notes.iter().any(|n| matches!(n, Note::Outdone { stays: true, .. })), "{:?}", idle.notes);
    // A converged plan is solved again, from what does better.
    let again = run(&hanging, &text("", "sqp"));
    assert!(again.succeeded && again.x_final.get("th").unwrap().cos() < -0.9, "{again:?}");
    let moved = run(&hanging, &text("guess = { u = \"5*sin(4*t)\" }", "sqp"));
    assert!(moved.succeeded, "{:?}", moved.notes);
}

#[test]
fn a_plan_that_something_simple_outdoes_is_not_kept_in_silence() {
    // Two wells, the start in the shallower one: of random depth, width, and height in between.
    let mut found = 0;
    for seed in 1..25_i32 {
        let s = f64::from(seed);
        let (tilt, height, speed) =
            (0.2 + 0.3 * s.sin().abs(), 0.2 + 0.6 * (2.0 * s).cos().abs(), 2.0 + (3.0 * s).sin());
        let stage = |x: f64, u: f64| height * (x * x - 1.0).powi(2) + tilt * x + 0.001 * u * u;
        let text = format!(
            "horizon = {{ steps = 40, dt = 0.1 }}\n\
             cost = {{ stage = \"{height}*(x^2 - 1)^2 + {tilt}*x + 0.001*u^2\" }}\n\
             constraints = {{ u = {{ min = -{speed}, max = {speed} }} }}\nsolve = {{ method = \"sqp\" }}\nrun = {{ x0 = {{ x = 1 }} }}"
        );
        let report = run("states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }", &text);
        // One speed for a while, and then rest.
        let mut held = f64::INFINITY;
        for level in [1.0, 0.5, 0.25, -0.25, -0.5, -1.0] {
            for steps in [10, 20, 40] {
                let (mut x, mut cost) = (1.0, 0.0);
                for k in 0..40 {
                    let u = if k < steps { level * speed } else { 0.0 };
                    cost += 0.1 * stage(x, u);
                    x += 0.1 * u;
                }
                held = held.min(cost);
            }
        }
        // What does not count: 1 %, and 1 % of being off by the scale of the state.
        let most =
            held + 0.01 * report.open_loop_cost.abs().max(held.abs()) + 0.04 * (stage(2.0, 0.0) - stage(1.0, 0.0));
        let right = report.open_loop_cost <= most;
        let told = report.notes.iter().any(|n| matches!(n, Note::Outdone { .. }));
        assert!(right || told && !report.succeeded, "{seed}: {} {held} {:?}", report.open_loop_cost, report.notes);
        found += usize::from(right && held < 0.4 * stage(1.0, 0.0) * 10.0 - 0.1);
    }
    assert!(found > 5, "{found} other wells found");
}

#[test]
fn healthy_runs_are_not_accused() {
    // Regulators of random linear systems from random states; one starts at rest, where nothing is to be done.
    for seed in 1..7_i32 {
        let s = f64::from(seed);
        let (a, b, d) = (s.sin(), (2.0 * s).cos(), 0.5 + (3.0 * s).sin().abs());
        let model = format!(
            "states = [\"x\", \"y\"]\ninputs = [\"u\"]\ndynamics = {{ x = \"{a}*x + y\", y = \"{b}*x - 0.5*y + {d}*u\" }}"
        );
        let x0 = if seed == 1 { 0.0 } else { b };
        for extra in ["", ", noise = { x = 0.01, y = 0.01 }", ", parameters = {}"] {
            let text = format!(
                "horizon = {{ steps = 30, dt = 0.1 }}\ncost = {{ stage = \"x^2 + y^2 + 0.1*u^2\", terminal = \"10*(x^2 + y^2)\" }}\n\
                 run = {{ x0 = {{ x = {x0}, y = {a} }}, steps = 50{extra} }}"
            );
            let text = if seed == 1 { text.replace(&format!("y = {a}"), "y = 0") } else { text };
            let report = run(&model, &text);
            assert!(report.succeeded && report.notes.is_empty(), "{seed}{extra}: {:?}", report.notes);
            assert_eq!(report.method, "rti");
        }
    }
    // A harvest: its cost is negative, and its end is used up.
    let stock = "states = [\"s\"]\ninputs = [\"h\"]\ndynamics = { s = \"s*(1 - s) - h\" }";
    let harvest = "horizon = { steps = 30, dt = 0.1 }\ncost = { stage = \"-h + 0.1*h^2\" }\n\
                   constraints = { h = { min = 0, max = 0.4 }, s = { min = 0.1 } }\nrun = { x0 = { s = 0.8 }, steps = 60 }";
    let report = run(stock, harvest);
    assert!(report.succeeded, "{:?}", report.notes);
    // A push that is not worth its effort: friction holds, and nothing moves.
    let held = run(
        "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = { x = \"v\", v = \"u - 2*sign(v)\" }",
        "horizon = { steps = 20, dt = 0.05 }\ncost = { stage = \"x^2 + u^2\" }\nrun = { x0 = { x = 0.05 }, steps = 30 }",
    );
    assert!(held.succeeded && held.method == "stick-slip", "{held:?}");
    // A target that a bound keeps out of reach is not missed for want of a better plan.
    let bounded = run(
        "states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"u\" }",
        "horizon = { steps = 20, dt = 0.1 }\ncost = { stage = \"(x - 2)^2 + 0.1*u^2\" }\n\
         constraints = { u = { min = -1, max = 1 }, x = { max = 1 } }\nrun = { steps = 40 }",
    );
    assert!(bounded.succeeded, "{:?}", bounded.notes);
}

#[test]
fn a_plant_that_bends_between_samples_is_not_accused() {
    // A stiff lag along a hard bound: the plant, integrated more finely than the plan, is beyond it by some thousandths.
    for rate in [20.0, 50.0, 120.0] {
        let model = format!(
            "states = [\"y\", \"z\"]\ninputs = [\"u\"]\ndynamics = {{ y = \"{rate}*(u - y)\", z = \"y - z\" }}"
        );
        let text = "horizon = { steps = 30, dt = 0.04, integrator = \"radau\", stages = 2, substeps = 1 }\n\
                    cost = { stage = \"(z - 1)^2 + 0.01*(u - 1)^2\" }\n\
                    constraints = { u = { min = 0, max = 3 }, y = { max = 1.5, hard = true } }\nrun = { steps = 30, plant_substeps = 40 }";
        let report = run(&model, text);
        let far = report.notes.iter().find(|n| matches!(n, Note::UnlikePlan { .. } | Note::Outdone { .. }));
        assert!(far.is_none() && report.constraint_violation_max < 0.01, "{rate}: {report:?}");
    }
}

#[test]
fn springs_are_planned_as_they_are_written() {
    // A mass on a spring of 5 mm, in the plane: the force of the controller's model is exact.
    let model = "states = [\"x\", \"y\", \"vx\", \"vy\"]\ninputs = [\"u\"]\nparameters = { k = 10, L = 0.005 }\n\
                 definitions = { l = \"sqrt(x^2 + y^2)\" }\n[dynamics]\nx = \"vx\"\ny = \"vy\"\n\
                 vx = \"-k*(l - L)*x/l - 0.5*vx + u\"\nvy = \"-k*(l - L)*y/l - 0.5*vy\"\n";
    let problem = "horizon = { steps = 20, dt = 0.05 }\ncost = { stage = \"100*(x - 0.02)^2 + vx^2 + 1e-3*u^2\" }\n\
                   run = { x0 = { x = 0.004, y = 0.003 }, steps = 20 }";
    let report = run(model, problem);
    assert!(report.succeeded && report.notes.is_empty(), "{:?}", report.notes);
    assert_ne!(report.method, "stick-slip");
    // Through its end the spring turns at once: this is said.
    let through = run(model, &problem.replace("y = 0.003", "y = 1e-6").replace("x - 0.02", "x + 0.02"));
    assert!(through.notes.iter().any(|n| matches!(n, Note::Singular { .. })), "{:?}", through.notes);
}

/// Friction above what the input can do: nothing moves, whatever the cost or target asks.
#[test]
fn friction_that_no_input_overcomes_is_told() {
    for (friction, most) in [(2.0, 1.5), (0.3, 0.1), (25.0, 24.0)] {
        let model = format!("states = ['x', 'v']\ninputs = ['F']\n[dynamics]\nx = 'v'\nv = 'F - {friction}*sign(v)'\n");
        let text = |bound: f64, asked: &str| {
            format!(
                "horizon = {{ steps = 20, dt = 0.05 }}\nconstraints = {{ F = {{ min = -{bound}, max = {bound} }} }}\n{asked}\n\
                 run = {{ x0 = {{ x = 1 }}, steps = 20 }}"
            )
        };
        for asked in ["cost = { stage = \"10*x^2 + 0.1*v^2 + 0.01*F^2\" }", "target = { x = 0 }"] {
            let stuck = run(&model, &text(most, asked));
            assert!(!stuck.succeeded && matches!(&stuck.notes[..], [Note::Held { .. }]), "{:?}", stuck.notes);
            let free = run(&model, &text(4.0 * friction, asked));
            assert!(!free.notes.iter().any(|n| matches!(n, Note::Held { .. })), "{:?}", free.notes);
        }
        // At rest where it is wanted, nothing has to move.
        let wanted = run(&model, &text(most, "cost = { stage = \"10*(x - 1)^2 + 0.1*v^2 + 0.01*F^2\" }"));
        assert!(wanted.succeeded, "{:?}", wanted.notes);
    }
}

/// A maximum of a symmetric cost: one program per sample comes back to it, a converged plan leaves it.
#[test]
fn a_guess_at_a_maximum_is_left() {
    for (torque, gravity) in [(4.0, 9.81), (3.0, 5.0), (12.0, 9.81)] {
        let model =
            format!("states = ['th', 'w']\ninputs = ['u']\n[dynamics]\nth = 'w'\nw = 'u + {gravity}*sin(th)'\n");
        let report = run(
            &model,
            &format!(
                "horizon = {{ steps = 50, dt = 0.04 }}\nconstraints = {{ u = {{ min = -{torque}, max = {torque} }} }}\n\
                 cost = {{ stage = \"10*(1-cos(th)) + 0.1*w^2 + 0.01*u^2\" }}\nrun = {{ x0 = {{ th = \"pi\" }}, steps = 20 }}"
            ),
        );
        assert_eq!(report.method, "sqp", "{report:?}");
        assert!((report.x_final.get("th").unwrap() - std::f64::consts::PI).abs() > 0.3, "{report:?}");
    }
}

/// The nonholonomic integrator: no state comes home without a detour, which a cost at the end alone pays for.
const BROCKETT: &str = r#"
    states = ["x", "y", "z"]
    inputs = ["u", "v"]
    dynamics = { x = "u", y = "v", z = "x*v - y*u" }
"#;

fn brockett(weight: f64, rest: &str) -> ClosedLoopReport {
    let text = format!(
        r#"
        horizon = {{ steps = 20, dt = 0.05 }}
        cost = {{ stage = "u^2 + v^2", terminal = "{weight}*(x^2 + y^2 + z^2)" }}
        guess = {{ u = "cos(6*t)", v = "sin(6*t)" }}
        {rest}
        "#
    );
    run(BROCKETT, &text)
}

/// A plan that is tracked to its end costs what was predicted, part by part.
#[test]
fn the_parts_of_the_predicted_cost_compare_with_those_of_the_loop() {
    for weight in [10.0, 1000.0] {
        let report = brockett(weight, "solve = { method = \"plan\" }\nrun = { x0 = { z = 1 } }");
        assert!(report.succeeded, "{:?}", report.notes);
        let parts = report.open_loop_stage_cost + report.open_loop_terminal_cost;
        assert!((parts - report.open_loop_cost).abs() < 1e-12 * parts);
        let x = |name: &str| report.x_final.get(name).unwrap();
        let end = weight * (x("x").powi(2) + x("y").powi(2) + x("z").powi(2));
        let at_end = report.closed_loop_terminal_cost.unwrap();
        assert!((at_end - end).abs() < 1e-9 * end.max(1e-9), "{at_end} {end}");
        let (realized, planned) = (report.closed_loop_cost + at_end, report.open_loop_cost);
        assert!((realized - planned).abs() < 0.05 * planned, "{realized} {planned}");
    }
}

/// A horizon that moves on puts off what costs most at its end. Where it gets there in the end, nothing is wrong; where it does not,
/// what is said is the terminal cost, and not that the loop costs more than its plan.
#[test]
fn a_terminal_cost_is_not_held_against_a_horizon_that_moves_on() {
    for (steps, arrives) in [(20, false), (400, true)] {
        let report =
            brockett(1000.0, &format!("solve = {{ method = \"sqp\" }}\nrun = {{ x0 = {{ z = 1 }}, steps = {steps} }}"));
        let unlike = report.notes.iter().any(|n| matches!(n, Note::UnlikePlan { .. }));
        let stays = report.notes.iter().find(|n| matches!(n, Note::EndCostStays { .. }));
        assert!(!unlike && report.closed_loop_terminal_cost.is_none(), "{:?}", report.notes);
        assert_eq!(stays.is_none() && report.succeeded, arrives, "{steps}: {report:?}");
        assert!(stays.is_none_or(|n| n.to_string().contains("method = \"plan\"")));
    }
}

/// A delay that the controller does not know is told; where it ruins the loop, the run fails, with the delay as the reason.
#[test]
fn a_delay_without_compensation_is_told_and_fails_where_it_ruins_the_loop() {
    let upright = |delay: usize, compensate: bool| {
        let text = format!(
            r#"
            horizon = {{ steps = 30, dt = 0.05 }}
            cost = {{ stage = "10*th^2 + 0.1*w^2 + 0.01*u^2" }}
            constraints = {{ u = {{ min = -15, max = 15 }} }}
            solve = {{ method = "rti" }}
            run = {{ x0 = {{ th = 0.3 }}, steps = 100, delay = {delay}, compensate_delay = {compensate} }}
            "#
        );
        run(PENDULUM, &text)
    };
    for delay in [1, 2, 5] {
        let known = upright(delay, true);
        assert!(known.succeeded && known.notes.is_empty(), "{delay}: {:?}", known.notes);
        assert!(known.x_final.get("th").unwrap().abs() < 1e-2);
        let unknown = upright(delay, false);
        let told = unknown.notes.iter().any(|n| matches!(n, Note::Delays { compensated: 0, .. }));
        let end = unknown.x_final.get("th").unwrap().abs();
        assert!(told && (end > 1e-2 || unknown.succeeded), "{delay}: {unknown:?}");
        // Farther from the goal than at the start.
        let ruined = end > 0.3;
        let reason = unknown.notes.iter().any(|n| n.is_failure() && n.to_string().contains("compensate_delay = true"));
        assert!(!ruined || reason && !unknown.succeeded, "{delay}: {:?}", unknown.notes);
    }
    assert!(!upright(5, false).succeeded && upright(0, false).notes.is_empty());
}

/// An estimator that is sure of a wrong model does not see that its estimate leaves the state; a simulated plant knows.
#[test]
fn an_estimate_that_leaves_the_state_is_told() {
    let loop_with = |process_noise: &str, plant: &str| {
        let text = format!(
            r#"
            horizon = {{ steps = 20, dt = 0.1 }}
            cost = {{ stage = "x^2 + 0.1*v^2 + 0.1*u^2" }}
            constraints = {{ u = {{ min = -5, max = 5 }} }}
            solve = {{ method = "rti" }}
            run = {{ x0 = {{ x = 1 }}, steps = 100, noise = {{ x = 0.001 }}, parameters = {{ c = {plant} }} }}
            [estimation]
            kind = "ekf"
            outputs = {{ x = 0.001 }}
            {process_noise}
            "#
        );
        run(
            "states = [\"x\", \"v\"]\ninputs = [\"u\"]\nparameters = { c = 0 }\ndynamics = { x = \"v\", v = \"u + c\" }\n",
            &text,
        )
    };
    let sure = "process_noise = { x = 1e-9, v = 1e-9 }";
    let off = |report: &ClosedLoopReport| report.notes.iter().any(|n| matches!(n, Note::EstimateOff { .. }));
    let wrong = loop_with(sure, "3");
    assert!(off(&wrong) && !wrong.succeeded, "{:?}", wrong.notes);
    for (process_noise, plant) in [(sure, "0"), ("", "0"), ("process_noise = { v = 3 }", "3")] {
        let right = loop_with(process_noise, plant);
        assert!(!off(&right) && right.succeeded, "{process_noise} {plant}: {:?}", right.notes);
    }
}
