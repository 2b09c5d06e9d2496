//! Norms in costs, which have no derivative at the goal that they lead to.

use crate::common::noise::Noise;
use crate::common::reports::run;
use bracketry_mpc::problem::{MethodReason, Note};

const POINT: &str = "states = [\"x\", \"y\"]\ninputs = [\"vx\", \"vy\"]\ndynamics = { x = \"vx\", y = \"vy\" }";
const DRIFTING: &str = "states = [\"x\", \"y\"]\ninputs = [\"vx\", \"vy\"]\n\
                        dynamics = { x = \"vx + 0.3*sin(y)\", y = \"vy - 0.2*sin(x)\" }";

/// With a number under the root, norms are smooth. Without one, the loop does as well, and arrives.
#[test]
fn a_norm_costs_what_its_smooth_neighbor_costs() {
    let mut noise = Noise::new(3);
    for model in [POINT, DRIFTING] {
        for method in ["", "solve = { method = \"rti\", initial_iterations = 10 }\n"] {
            let (a, b) = (0.4 + 0.6 * noise.uniform(), -0.4 - 0.3 * noise.uniform());
            let (weight, ratio) = (0.5 + 3.0 * noise.uniform(), 0.5 + noise.uniform());
            let of = |added: &str| {
                let distance = format!("sqrt((x - {a:?})^2 + {ratio:?}*(y - {b:?})^2{added})");
                run(
                    model,
                    &format!(
                        "horizon = {{ steps = 20, dt = 0.1 }}\n\
                         cost = {{ stage = \"{weight:?}*{distance} + 0.02*(vx^2 + vy^2) + 0.03*sqrt(vx^2 + vy^2{added})\", terminal = \"{distance}\" }}\n\
                         constraints = {{ vx = {{ min = -1, max = 1 }}, vy = {{ min = -1, max = 1 }} }}\n{method}run = {{ steps = 40 }}"
                    ),
                )
            };
            let report = of("");
            let end = ["x", "y"].map(|n| report.x_final.get(n).copied().unwrap());
            assert!(report.succeeded && (end[0] - a).abs().max((end[1] - b).abs()) < 1e-3, "{report:?}");
            if method.is_empty() {
                let smooth = of(" + 1e-8");
                assert!(report.closed_loop_cost < 1.002 * smooth.closed_loop_cost, "{report:?} {smooth:?}");
            }
        }
    }
}

/// One component, several norms in one, and a goal that moves.
#[test]
fn norms_of_any_kind_lead_to_their_goal() {
    for (goal, stage) in [
        ([0.6, 0.0], "sqrt((x - 0.6)^2) + sqrt(y^2)"),
        ([0.0, 0.0], "2*sqrt(4*x^2 + 2*(x + y)^2) + sqrt(x^2 + y^2)"),
        ([0.8, -0.4], "sqrt((x - 0.2*t)^2 + (y + 0.1*t)^2)"),
    ] {
        let text = format!(
            "horizon = {{ steps = 15, dt = 0.1 }}\ncost = {{ stage = \"{stage} + 0.01*(vx^2 + vy^2)\" }}\n\
             constraints = {{ vx = {{ min = -1, max = 1 }}, vy = {{ min = -1, max = 1 }} }}\n\
             run = {{ x0 = {{ x = -0.3, y = 0.5 }}, steps = 40 }}"
        );
        let report = run(POINT, &text);
        let end = ["x", "y"].map(|n| report.x_final.get(n).copied().unwrap());
        let off = (end[0] - goal[0]).abs().max((end[1] - goal[1]).abs());
        assert!(report.succeeded && off < 1e-2, "{stage}: {end:?} {:?}", report.notes);
    }
}

/// At the goal, a norm costs nothing.
#[test]
fn reported_costs_have_exact_norms() {
    for method in ["rti", "sqp", "plan"] {
        let text = format!(
            "horizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = \"sqrt(x^2 + 2*y^2) + 0.01*(vx^2 + vy^2)\" }}\n\
             solve = {{ method = \"{method}\" }}\nrun = {{ steps = 10 }}"
        );
        let report = run(POINT, &text);
        assert!(report.succeeded && report.closed_loop_cost < 1e-12 && report.open_loop_cost < 1e-12, "{report:?}");
    }
}

/// Branches and blocks are not for the interior-point method: there, programs go from wide to sharp norms.
#[test]
fn norms_get_sharper_where_programs_are_alone() {
    let model = "states = [\"x\", \"y\"]\ninputs = [\"vx\", \"vy\"]\nparameters = { k = 1 }\n\
                 dynamics = { x = \"k*vx\", y = \"vy - 0.1*sin(y)\" }";
    for (more, blocks) in
        [("", ", blocks = [1, 1, 2, 3]"), ("uncertainty = { parameters = { k = [0.7, 1, 1.3] } }\n", "")]
    {
        for (a, b) in [(1.0, 0.0), (0.6, -0.4)] {
            let text = format!(
                "horizon = {{ steps = 15, dt = 0.1{blocks} }}\n{more}\
                 cost = {{ stage = \"sqrt((x - {a})^2 + (y - {b})^2) + 0.1*(vx^2 + vy^2)\" }}\n\
                 solve = {{ method = \"sqp\" }}\nrun = {{ steps = 20 }}"
            );
            let report = run(model, &text);
            let end = ["x", "y"].map(|n| report.x_final.get(n).copied().unwrap());
            assert!(report.succeeded && report.status.inaccurate <= 1, "{more}{blocks}: {report:?}");
            assert!((end[0] - a).abs().max((end[1] - b).abs()) < 1e-2, "{report:?}");
        }
    }
}

/// Costs with a cusp at a goal, for which no plan converges, with their powers and goals; `more` is added to each problem.
fn cusps(more: &str) -> Vec<(&'static str, f64, String)> {
    let goals = |power: &'static str| [0.7, 1.1].map(|goal| (power, goal));
    let problem = |(power, goal): (&'static str, f64)| {
        let text = format!(
            "horizon = {{ steps = 20, dt = 0.1 }}\n\
             cost = {{ stage = \"((x - {goal})^2 + (y - 0.5)^2)^({power}) + 0.01*(vx^2 + vy^2)\" }}\n\
             constraints = {{ vx = {{ min = -1, max = 1 }}, vy = {{ min = -1, max = 1 }} }}\n{more}"
        );
        (power, goal, text)
    };
    ["1/4", "1/3", "1/5"].into_iter().flat_map(goals).map(problem).collect()
}

/// Where no plan converges, a loop of one program per sample that does worse than a plan fails, and says why.
#[test]
fn a_method_that_is_chosen_for_want_of_a_plan_is_told() {
    let mut seen = 0;
    for (power, goal, text) in cusps("run = { steps = 40 }") {
        let report = run(POINT, &text);
        let end = ["x", "y"].map(|n| report.x_final.get(n).copied().unwrap());
        let arrived = (end[0] - goal).abs().max((end[1] - 0.5).abs()) < 0.02;
        assert!(arrived || !report.succeeded, "{power} {goal}: {report:?}");
        if matches!(report.method_reason, MethodReason::NotConverging) {
            seen += 1;
            let told = report.notes.iter().any(|n| matches!(n, Note::ChosenWithoutPlan));
            assert_eq!(told, !report.succeeded, "{:?}", report.notes);
        }
    }
    assert!(seen > 0);
}

/// A plan that does not converge may meet its targets at any cost: the run fails, unless it proves to be as good as a plan.
#[test]
fn targets_that_are_met_do_not_excuse_a_plan_that_does_not_converge() {
    let mut seen = 0;
    let target = "target = { x = { value = 0.2, tolerance = 1e-2 }, y = { value = 0.9, tolerance = 1e-2 } }\nrun = {}";
    for (power, goal, text) in cusps(target) {
        let report = run(POINT, &text);
        let converged = report.plan.as_ref().is_some_and(|p| p.status == "converged");
        seen += usize::from(!converged);
        let told = report.notes.iter().any(|n| matches!(n, Note::PlanNotConverged));
        assert!(converged || told || report.succeeded, "{power} {goal}: {report:?}");
        // Straight to the goal, a rest, and straight to the target.
        assert!(converged || told || report.closed_loop_cost < 1.05 * report.open_loop_cost, "{report:?}");
        assert!(!told || !report.succeeded);
    }
    assert!(seen > 0);
}
