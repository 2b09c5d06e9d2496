//! Scenario trees: what they are by an independent solution, and that they keep bounds which a controller of one model does not.

use crate::common::reports::read;
use bracketry_mpc::control;
use bracketry_mpc::live::Change;
use bracketry_mpc::problem::ProblemError;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2xX, Vector2};
use proptest::prelude::*;

/// A mass on a spring whose stiffness is not known.
const SPRING: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    parameters = { k = 1, m = 1 }
    dynamics = { x = "v", v = "(u - k*x)/m" }
"#;

/// A regulation problem with a method and more lines.
fn spring(method: &str, lines: &str) -> String {
    format!(
        r#"
        model = "model.toml"
        horizon = {{ steps = 15, dt = 0.1, substeps = 1 }}
        cost = {{ stage = "x^2 + 0.1*v^2 + 0.01*u^2", terminal = "x^2 + v^2" }}
        constraints = {{ u = {{ min = -2, max = 2 }} }}
        solve = {{ method = "{method}", qp_tolerance = 1e-12 }}
        run = {{ x0 = {{ x = 1 }}, steps = 10 }}
        {lines}
        "#
    )
}

#[test]
fn branches_that_are_all_the_same_give_the_solution_of_the_model() {
    // A plan without its margin and its proximal term, which adds up over the branches.
    let plan = "plan\", tolerance = 1e-10, margin = 0, proximal = 0, backend = \"automatic";
    for (method, tolerance) in [("rti", 1e-8), ("sqp", 1e-8), (plan, 1e-8)] {
        let alone = control(&read(SPRING, &spring(method, "")).unwrap()).unwrap().run;
        for lines in [
            "uncertainty = { parameters = { k = [1, 1, 1] } }",
            "uncertainty = { parameters = { k = [1, 1] }, robust_horizon = 2 }",
        ] {
            let tree = control(&read(SPRING, &spring(method, lines)).unwrap()).unwrap().run;
            assert!(tree.report.succeeded, "{:?}", tree.report.notes);
            for (a, b) in alone.closed_loop.u.iter().zip(&tree.closed_loop.u) {
                assert!((a[0] - b[0]).abs() < tolerance, "{method}: {} and {}", a[0], b[0]);
            }
            let costs = [alone.report.open_loop_cost, tree.report.open_loop_cost];
            assert!((costs[0] - costs[1]).abs() < 1e-8 * costs[0], "{method}: {costs:?}");
        }
    }
}

/// The discrete flow of one Runge–Kutta step of order 4 for x' = A x + B u: the Taylor polynomial.
fn discrete(a: Matrix2<f64>, b: Vector2<f64>, h: f64) -> (Matrix2<f64>, Vector2<f64>) {
    let (mut power, mut flow, mut integral) = (Matrix2::identity(), Matrix2::zeros(), Matrix2::zeros());
    let mut factor = 1.0;
    for j in 0..=4 {
        flow += power * factor;
        if j < 4 {
            integral += power * (factor * h / (j + 1) as f64);
        }
        power *= a;
        factor *= h / (j + 1) as f64;
    }
    (flow, integral * b)
}

/// The tree of a linear system as one dense program of its free inputs, by projected gradient steps: first input and cost.
///
/// An input is free for every interval and past: the first `min(k, r)` choices of combinations.
fn dense(
    systems: &[(Matrix2<f64>, Vector2<f64>)],
    weights: &[f64],
    r: u32,
    x0: Vector2<f64>,
    steps: usize,
    h: f64,
) -> (f64, f64) {
    let c = systems.len();
    let branches = c.pow(r);
    let digit = |s: usize, k: usize| s / c.pow(r - 1 - (k as u32).min(r - 1)) % c;
    let past = |s: usize, k: usize| -> Vec<usize> { (0..k.min(r as usize)).map(|i| digit(s, i)).collect() };
    let mut free: Vec<(usize, Vec<usize>)> = Vec::new();
    for s in 0..branches {
        for k in 0..steps {
            if !free.contains(&(k, past(s, k))) {
                free.push((k, past(s, k)));
            }
        }
    }
    let n = free.len();
    let (mut hessian, mut gradient, mut constant) = (DMatrix::zeros(n, n), DVector::zeros(n), 0.0);
    let mut add = |row: &DVector<f64>, offset: f64, weight: f64| {
        hessian.ger(2.0 * weight, row, row, 1.0);
        gradient.axpy(2.0 * weight * offset, row, 1.0);
        constant += weight * offset * offset;
    };
    for s in 0..branches {
        let weight: f64 = (0..r as usize).map(|i| weights[digit(s, i)]).product();
        // x = M z + o.
        let (mut map, mut offset) = (Matrix2xX::zeros(n), x0);
        for k in 0..=steps {
            let factor = if k < steps { h } else { 1.0 };
            for (i, q) in [(0, 1.0), (1, if k < steps { 0.1 } else { 1.0 })] {
                add(&map.row(i).transpose(), offset[i], weight * factor * q);
            }
            if k == steps {
                break;
            }
            let place = free.iter().position(|f| *f == (k, past(s, k))).unwrap();
            let mut unit = DVector::zeros(n);
            unit[place] = 1.0;
            add(&unit, 0.0, weight * h * 0.01);
            let (a, b) = systems[digit(s, k)];
            map = a * map + b * unit.transpose();
            offset = a * offset;
        }
    }
    // Accelerated projected gradients (Nesterov), with restarts.
    let largest = hessian.symmetric_eigenvalues().max();
    let mut z = DVector::<f64>::zeros(n);
    let (mut y, mut t) = (z.clone(), 1.0_f64);
    for _ in 0..40_000 {
        let step = (&y - (&hessian * &y + &gradient) / largest).map(|v| v.clamp(-2.0, 2.0));
        let next = f64::midpoint(1.0, (1.0 + 4.0 * t * t).sqrt());
        let momentum = if (&y - &step).dot(&(&step - &z)) > 0.0 { 0.0 } else { (t - 1.0) / next };
        y = &step + (&step - &z) * momentum;
        t = if momentum == 0.0 { 1.0 } else { next };
        let moved = (&step - &z).amax();
        z = step;
        if moved < 1e-14 {
            break;
        }
    }
    (z[0], 0.5 * z.dot(&(&hessian * &z)) + gradient.dot(&z) + constant)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn a_tree_of_linear_systems_is_its_dense_program(
        k in prop::collection::vec(-2.0..4.0_f64, 2..4),
        weights in prop::collection::vec(0.1..1.0_f64, 3),
        start in prop::array::uniform2(-1.5..1.5_f64),
        r in 1..3_u32,
    ) {
        let (steps, h) = (8, 0.15);
        let weights = &weights[..k.len()];
        let total: f64 = weights.iter().sum();
        let text = format!(
            r#"
            model = "model.toml"
            horizon = {{ steps = {steps}, dt = {h}, substeps = 1 }}
            cost = {{ stage = "x^2 + 0.1*v^2 + 0.01*u^2", terminal = "x^2 + v^2" }}
            constraints = {{ u = {{ min = -2, max = 2 }} }}
            solve = {{ method = "sqp", qp_tolerance = 1e-11 }}
            uncertainty = {{ parameters = {{ k = {k:?} }}, weights = {{ k = {weights:?} }}, robust_horizon = {r} }}
            run = {{ x0 = {{ x = {}, v = {} }}, steps = 1 }}
            "#,
            start[0], start[1]
        );
        let run = control(&read(SPRING, &text).unwrap()).unwrap().run;
        let systems: Vec<_> =
            k.iter().map(|k| discrete(Matrix2::new(0.0, 1.0, -k, 0.0), Vector2::new(0.0, 1.0), h)).collect();
        let shares: Vec<f64> = weights.iter().map(|w| w / total).collect();
        let (u, cost) = dense(&systems, &shares, r, Vector2::new(start[0], start[1]), steps, h);
        // The program is solved to a gap of 1e-11 (1 + cost), and away from its minimum the cost grows by at least 0.01 h (u − u*)².
        let near = (1e-11 * (1.0 + cost) / (0.01 * h)).sqrt();
        prop_assert!((run.closed_loop.u[0][0] - u).abs() < near, "{} and {u}", run.closed_loop.u[0][0]);
        prop_assert!((run.report.open_loop_cost - cost).abs() < 1e-6 * (1.0 + cost), "{} and {cost}", run.report.open_loop_cost);
        prop_assert_eq!(run.report.scenarios.unwrap().branches, k.len().pow(r));
    }
}

/// A level that follows an inflow whose gain is not known.
const LEVEL: &str = r#"
    states = ["x"]
    inputs = ["u"]
    parameters = { k = 1 }
    dynamics = { x = "k*u - x" }
"#;

/// As close to the bound as possible, on a plant with its own gain.
fn level(method: &str, k: f64, lines: &str) -> String {
    format!(
        r#"
        model = "model.toml"
        horizon = {{ steps = 10, dt = 0.2 }}
        cost = {{ stage = "(x - 1.5)^2 + 0.001*u^2" }}
        constraints = {{ u = {{ min = 0, max = 4 }}, x = {{ max = 1, hard = true }} }}
        solve = {{ method = "{method}" }}
        run = {{ steps = 20, parameters = {{ k = {k} }} }}
        {lines}
        "#
    )
}

#[test]
fn the_bound_that_one_model_violates_is_kept_by_the_tree() {
    let tree = "uncertainty = { parameters = { k = [0.7, 1.0, 1.3] } }";
    for method in ["sqp", "rti"] {
        let alone = control(&read(LEVEL, &level(method, 1.3, "")).unwrap()).unwrap().run.report;
        assert!(alone.constraint_violation_max > 0.01, "{method}: {}", alone.constraint_violation_max);
        for k in [0.7, 1.0, 1.3] {
            let run = control(&read(LEVEL, &level(method, k, tree)).unwrap()).unwrap().run;
            let report = &run.report;
            assert!(report.constraint_violation_max < 1e-6, "{method} {k}: {}", report.constraint_violation_max);
            let predicted = report.scenarios.as_ref().unwrap().predicted_violation.unwrap();
            assert!(predicted < 1e-5, "{method} {k}: {predicted}");
            assert!(report.status.infeasible + report.status.fallback == 0, "{:?}", report.status);
            assert!(run.closed_loop.x.last().unwrap()[0] > 0.85, "{method} {k}: the bound is approached");
        }
    }
}

#[test]
fn constraints_and_costs_have_the_values_of_their_branch() {
    // At most k times u: the branch with the largest k decides on the shared input.
    let text = |lines: &str| {
        spring("sqp", lines)
            .replace("u = { min = -2, max = 2 }", "u = { min = -2, max = 2 }, f = { expression = \"k*u\", min = -1 }")
    };
    let tree = "uncertainty = { scenarios = [{ k = 1, m = 1 }, { k = 4, m = 2 }], weights = [3, 1] }";
    let run = control(&read(SPRING, &text(tree)).unwrap()).unwrap().run;
    assert!((run.closed_loop.u[0][0] + 0.25).abs() < 1e-6, "{}", run.closed_loop.u[0][0]);
    let scenarios = run.report.scenarios.unwrap();
    assert_eq!(scenarios.scenarios[1].get("m"), Some(&2.0));
    // The mean of a cost that is k: (3·1 + 1·4)/4 per second.
    let constant = text(tree)
        .replace("0.01*u^2", "k + 1e-9*u^2")
        .replace("x^2 + 0.1*v^2 + ", "0*x^2 + ")
        .replace("terminal = \"x^2 + v^2\"", "");
    let constant = constant.replace("stage = \"0*x^2 + ", "stage = \"1e-9*x^2 + ");
    let run = control(&read(SPRING, &constant).unwrap()).unwrap().run;
    assert!((run.report.open_loop_cost - 1.5 * 7.0 / 4.0).abs() < 1e-6, "{}", run.report.open_loop_cost);
}

#[test]
fn a_live_controller_does_what_the_run_does_and_changes_all_branches() {
    let tree = "uncertainty = { parameters = { k = [0.5, 1, 2] } }";
    let problem = read(SPRING, &spring("rti", tree)).unwrap();
    let run = control(&problem).unwrap().run;
    let mut live = problem.controller().unwrap();
    for (x, u) in run.closed_loop.x.iter().zip(&run.closed_loop.u) {
        assert_eq!(live.step(x).unwrap().step.u, *u);
    }
    assert_eq!((live.prediction().states(), live.prediction().inputs()), (2, 1));
    live.change(&[Change::Bounds { name: "u", min: -0.1, max: 0.1 }]).unwrap();
    live.reset().unwrap();
    for x in [0.5, 1.0, -1.0] {
        assert!(live.step(&[x, 0.0]).unwrap().step.u[0].abs() < 0.1 + 1e-9);
    }
}

#[test]
fn live_parameters_go_with_branches_that_part_twice() {
    let text = |m: f64, lines: &str| {
        let tree = "uncertainty = { parameters = { k = [0.5, 2] }, robust_horizon = 2 }";
        spring("sqp", &format!("{tree}\nparameters = {{ m = {m} }}\n{lines}"))
    };
    let mut live = read(SPRING, &text(1.0, "live_parameters = [\"m\"]")).unwrap().controller().unwrap();
    live.set_parameters(&[("m", 3.0)]).unwrap();
    let mut given = read(SPRING, &text(3.0, "")).unwrap().controller().unwrap();
    let (a, b) = (live.step(&[0.02, 0.0]).unwrap().step.u[0], given.step(&[0.02, 0.0]).unwrap().step.u[0]);
    assert!((a - b).abs() < 1e-7 && a.abs() < 1.9, "{a} and {b}");
}

#[test]
fn rates_delays_and_move_blocks_go_with_a_tree() {
    let tree = "uncertainty = { parameters = { k = [0.5, 1, 2] } }";
    let text = spring("sqp", tree)
        .replace("u = { min = -2, max = 2 }", "u = { min = -2, max = 2, rate = { min = -3, max = 3 } }")
        .replace("substeps = 1", "substeps = 1, blocks = [1, 2, 4]")
        .replace("steps = 10", "steps = 30, delay = 1");
    let run = control(&read(SPRING, &text).unwrap()).unwrap().run;
    let mut last = 0.0;
    for u in &run.closed_loop.u {
        assert!((u[0] - last).abs() <= 0.3 + 1e-6);
        last = u[0];
    }
    assert!(run.report.x_final.get("x").unwrap().abs() < 0.2);
}

#[test]
fn mistakes_are_said_with_their_place_and_remedy() {
    let mistakes = [
        ("uncertainty = { }", "names no parameters"),
        ("uncertainty = { parameters = { q = [1, 2] } }", "`q` is not a parameter of the model"),
        ("uncertainty = { parameters = { k = 1 } }", "must be a list"),
        ("uncertainty = { parameters = { k = [] } }", "has no values"),
        ("uncertainty = { parameters = { } }", "is empty"),
        ("uncertainty = { parameters = { k = [1, 2] }, weights = { k = [1] } }", "1 weights for 2 values"),
        ("uncertainty = { parameters = { k = [1, 2] }, weights = { k = [1, -1] } }", "must not be negative"),
        ("uncertainty = { parameters = { k = [1, 2] }, weights = { k = [0, 0] } }", "all weights are zero"),
        ("uncertainty = { parameters = { k = [1, 2] }, weights = [1, 1] }", "must be a table"),
        ("uncertainty = { parameters = { k = [1, 2] }, weights = { m = [1, 2] } }", "has weights but no values"),
        ("uncertainty = { parameters = { k = [1, 2] }, scenarios = [{ k = 1 }] }", "both define the scenarios"),
        ("uncertainty = { scenarios = [{ k = 1 }, { m = 1 }] }", "to the same parameters"),
        ("uncertainty = { scenarios = [] }", "is empty"),
        ("uncertainty = { parameters = { k = [1, 2] }, robust_horizon = 0 }", "whole number from 1"),
        ("uncertainty = { parameters = { k = [1, 2] }, robust_horizon = 9 }", "512 branches"),
        (
            "uncertainty = { parameters = { k = [1, 2, 3, 4, 5, 6, 7, 8, 9], m = [1, 2, 3, 4, 5, 6, 7, 8] } }",
            "more than 64",
        ),
        ("uncertainty = { parameters = { k = [1] }, robust_horizon = 16 }", "longer than the 15 intervals"),
        ("uncertainty = { parameters = { k = [1, 2] }, robust_horizn = 1 }", "did you mean `robust_horizon`"),
        ("uncertainty = { parameters = { k = [1, 2] } }\nlive_parameters = [\"k\"]", "also live"),
        ("uncertainty = { parameters = { m = [1, 0] } }", ""),
    ];
    for (lines, said) in mistakes {
        match read(SPRING, &spring("sqp", lines)) {
            Err(ProblemError::File(e)) if !said.is_empty() => {
                let text = e.to_string();
                assert!(text.contains(said), "{lines}: {text}");
                assert!(text.contains("problem.toml:"), "{lines}: {text}");
            }
            Err(e) => assert!(said.is_empty(), "{lines}: {e}"),
            Ok(_) => assert!(said.is_empty(), "{lines}"),
        }
    }
    let text = spring("stick-slip", "uncertainty = { parameters = { k = [1, 2] } }");
    assert!(read(SPRING, &text).err().unwrap().to_string().contains("no scenario tree"));
    let text =
        spring("sqp", "uncertainty = { parameters = { k = [1, 2] }, robust_horizon = 2 }").replace("x^2 +", "k*x^2 +");
    assert!(read(SPRING, &text).err().unwrap().to_string().contains("in the dynamics only"));
}

#[test]
fn the_tank_of_the_guide_keeps_its_bound_with_the_tree_alone() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/mpc_uncertainty.md")).unwrap();
    let blocks: Vec<&str> = guide.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
    let with = control(&read(blocks[0], blocks[1]).unwrap()).unwrap().run.report;
    assert!(with.succeeded && with.constraint_violation_max < 1e-6, "{with:?}");
    let without: Vec<&str> = blocks[1].lines().filter(|l| !l.starts_with("uncertainty")).collect();
    let without = control(&read(blocks[0], &without.join("\n")).unwrap()).unwrap().run.report;
    assert!((without.constraint_violation_max - 0.07).abs() < 0.005, "{}", without.constraint_violation_max);
}
