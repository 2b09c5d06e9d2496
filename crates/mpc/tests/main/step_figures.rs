//! What a step and its controller tell of the plan: residual and slacks.

use crate::common::reports::problem;
use bracketry_system::System;

/// Input and soft bounds on one integrator: from x0 > 0, the first step leads to x0 − 0.1 at best.
#[test]
fn slacks_are_the_largest_violations_of_soft_bounds_by_name() {
    for method in ["rti", "sqp"] {
        for x0 in [0.4, 0.65, 1.0, 2.0] {
            let text = format!(
                r#"
                horizon = {{ steps = 30, dt = 0.1 }}
                cost = {{ stage = "x^2 + 1e-3*u^2" }}
                solve = {{ method = "{method}" }}
                [constraints]
                u = {{ min = -1, max = 1 }}
                x = {{ max = 0.5, soft = [10, 10] }}
                top = {{ expression = "2*x", max = 1.5, soft = [10, 10] }}
                kept = {{ expression = "x", min = -9, hard = true }}
                [run]
                x0 = {{ x = {x0} }}
                "#
            );
            let model = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'u' }";
            let mut controller = problem(model, &text).controller().unwrap();
            controller.feedback(&[x0]).unwrap();
            let slacks = controller.slacks();
            let names: Vec<&str> = slacks.iter().map(|s| s.0.as_str()).collect();
            assert_eq!(names, ["x", "top"]);
            assert!((slacks[0].1 - (x0 - 0.6).max(0.0)).abs() < 1e-5, "{method} {x0}: {slacks:?}");
            assert!((slacks[1].1 - (2.0 * x0 - 1.7).max(0.0)).abs() < 1e-5, "{method} {x0}: {slacks:?}");
        }
    }
}

/// A sample at rest has no residual, nor have converged ones but for the square root of the tolerance: the step that ends them promises less than 1e-8
/// of the merit. One program for a state that is not the predicted one has.
#[test]
fn the_residual_tells_how_far_a_step_is_from_optimality() {
    let model = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - sin(x)' }";
    for method in ["rti", "sqp"] {
        let text = format!(
            "horizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = '10*x^2 + v^2 + 0.1*u^2' }}\n\
             solve = {{ method = '{method}' }}\nconstraints = {{ u = {{ min = -5, max = 5 }} }}\nrun = {{ x0 = {{ x = 0.8 }} }}"
        );
        let mut controller = problem(model, &text).controller().unwrap();
        assert_eq!(controller.step(&[f64::NAN, 0.0]).unwrap().step.residual, None);
        let mut plant = crate::common::exact_plant(&System::parse("m", model).unwrap(), &[0.8, 0.0]);
        let mut residuals = Vec::new();
        for _ in 0..150 {
            let step = controller.step(plant.state()).unwrap().step.clone();
            residuals.push(step.residual.unwrap());
            assert!(plant.hold(&step.u, 0.1).unwrap().is_finished());
        }
        assert!(residuals[149] < 1e-6, "{method}: {residuals:?}");
        assert!(residuals.iter().all(|r| r.is_finite() && (method == "rti" || *r < 1e-3)), "{method}: {residuals:?}");
        let pushed = controller.step(&[0.0, 0.1]).unwrap().step.residual.unwrap();
        assert!((pushed > 1e-2) == (method == "rti"), "{method}: {pushed}");
    }
}
