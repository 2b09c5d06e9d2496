//! Bounds that hold with a probability: their margins are those of the linear system, and the loop violates them about as often.

use crate::common::{dense, noise::Noise, reports::read};
use bracketry_mpc::problem::MarginFeedback;
use bracketry_mpc::riccati::dare;
use bracketry_mpc::{ControlProblem, control};

const LAG: &str = r#"
    states = ["x"]
    inputs = ["u"]
    parameters = { k = 1 }
    dynamics = { x = "u - k*x" }
"#;
const MASS: &str = r#"
    states = ["x", "v"]
    inputs = ["u"]
    dynamics = { x = "v", v = "u" }
"#;
/// Quantile of the standard normal distribution for 0.95.
const QUANTILE: f64 = 1.644_853_626_951_472_2;

/// The lag, wanted beyond its bound 0.5.
fn lag(stage: &str, bounds: &str, lines: &str) -> String {
    format!(
        r#"
        model = "model.toml"
        horizon = {{ steps = 12, dt = 0.1, substeps = 1 }}
        cost = {{ stage = "{stage}" }}
        constraints = {{ {bounds} }}
        solve = {{ method = "rti" }}
        run = {{ }}
        {lines}
        "#
    )
}

const NOISE: &str = "uncertainty = { noise = { x = 0.2 }, confidence = 0.95 }";

#[test]
fn margins_are_those_of_the_linear_system() {
    let (h, steps): (f64, i32) = (0.1, 12);
    // One step of the Runge–Kutta method.
    let a = 1.0 - h + h * h / 2.0 - h.powi(3) / 6.0 + h.powi(4) / 24.0;
    let b = h - h * h / 2.0 + h.powi(3) / 6.0 - h.powi(4) / 24.0;
    let margin = |factor: f64, k: i32| {
        let variance: f64 = (0..k).map(|j| 0.04 * h * factor.powi(2 * j)).sum();
        QUANTILE * variance.sqrt()
    };
    let gain =
        dare(&dense([[a]]), &dense([[b]]), &dense([[h]]), &dense([[0.3 * h]]), &dense([[0.0]])).unwrap().gain[(0, 0)];
    for (stage, feedback, factor) in [
        // Without a cost of the input, there is no infinite horizon.
        ("(x - 1)^2", MarginFeedback::OpenLoop, a),
        ("(x - 1)^2 + 0.3*u^2", MarginFeedback::Riccati, a - b * gain),
    ] {
        let problem =
            read(LAG, &lag(stage, "x = { max = 0.5 }, twice = { expression = \"3 - 2*x\", min = 0 }", NOISE)).unwrap();
        let chance = problem.chance.unwrap();
        assert_eq!(chance.feedback, feedback);
        assert_eq!(chance.margins.len(), 2);
        for (found, scale) in chance.margins.iter().zip([1.0, 2.0]) {
            assert!((found.first - scale * margin(factor, 1)).abs() < 1e-9, "{stage}: {found:?}");
            assert!((found.last - scale * margin(factor, steps)).abs() < 1e-8, "{stage}: {found:?}");
        }
    }
}

/// Share of the samples of a loop after the first ones at which g exceeds its bound; `next` is the plant.
fn violations(
    problem: &ControlProblem,
    samples: usize,
    next: impl Fn(&[f64], f64, &mut Noise) -> Vec<f64>,
    g: impl Fn(&[f64]) -> f64,
) -> f64 {
    let mut controller = problem.controller().unwrap();
    let mut noise = Noise::new(7);
    let (mut x, mut count) = (problem.x0.clone(), 0);
    for k in 0..samples + 50 {
        let u = controller.step(&x).unwrap().step.u[0];
        x = next(&x, u, &mut noise);
        count += usize::from(k >= 50 && g(&x) > 0.0);
    }
    count as f64 / samples as f64
}

#[test]
fn a_bound_is_violated_as_often_as_it_may_be() {
    let samples = 500;
    for (p, bound) in
        [(0.8, "x = { max = 0.5 }"), (0.95, "x = { max = 0.5 }"), (0.9, "g = { expression = \"3*x\", max = 1.5 }")]
    {
        let lines = NOISE.replace("0.95", &p.to_string());
        let problem =
            read(LAG, &lag("(x - 1)^2 + 1e-4*u^2", bound, &lines).replace("steps = 12", "steps = 4")).unwrap();
        let (h, decay) = (0.1_f64, (-0.1_f64).exp());
        let next = |x: &[f64], u: f64, noise: &mut Noise| {
            vec![decay * x[0] + (1.0 - decay) * u + 0.2 * h.sqrt() * noise.normal()]
        };
        let share = violations(&problem, samples, next, |x| x[0] - 0.5);
        // Next to nothing holds the input: every sample has its own noise.
        let error = 4.0 * (p * (1.0 - p) / samples as f64).sqrt();
        assert!(share <= 1.0 - p + error, "{p}: {share}");
        assert!(share >= 0.6 * (1.0 - p), "{p}: {share} is too careful");
    }
    // Without a margin, every second sample is beyond the bound.
    let problem =
        read(LAG, &lag("(x - 1)^2 + 1e-4*u^2", "x = { max = 0.5 }", "").replace("steps = 12", "steps = 4")).unwrap();
    let next = |x: &[f64], u: f64, noise: &mut Noise| vec![0.904_837 * x[0] + 0.095_163 * u + 0.0632 * noise.normal()];
    assert!(violations(&problem, 300, next, |x| x[0] - 0.5) > 0.4);
}

#[test]
fn a_position_is_kept_from_its_bound_by_noise_on_the_velocity() {
    let text = r#"
        model = "model.toml"
        horizon = { steps = 20, dt = 0.1, substeps = 1 }
        cost = { stage = "(x - 2)^2 + 0.3*v^2 + 0.01*u^2" }
        constraints = { x = { max = 1, probability = 0.9 } }
        uncertainty = { noise = { v = 0.3 } }
        solve = { method = "rti" }
        run = { }
    "#;
    let problem = read(MASS, text).unwrap();
    let next = |x: &[f64], u: f64, noise: &mut Noise| {
        let h = 0.1_f64;
        vec![x[0] + h * x[1] + h * h / 2.0 * u, x[1] + h * u + 0.3 * h.sqrt() * noise.normal()]
    };
    let share = violations(&problem, 400, next, |x| x[0] - 1.0);
    // The plan keeps the margins of all grid points, of which only the next one matters in the end: it is careful.
    assert!(share <= 0.1, "{share}");
}

#[test]
fn the_report_has_the_margins_and_trees_take_them_over() {
    let tree = NOISE.replace("noise =", "parameters = { k = [0.5, 1, 1.5] }, noise =");
    for lines in [NOISE, &tree] {
        let text = lag("(x - 1)^2 + 0.1*u^2", "x = { max = 0.5 }", lines).replace("run = { }", "run = { steps = 60 }");
        let run = control(&read(LAG, &text).unwrap()).unwrap().run;
        let margin = &run.report.chance.unwrap().margins[0];
        assert_eq!((margin.name.as_str(), margin.probability), ("x", 0.95));
        assert!(margin.last > margin.first && margin.first > 0.0);
        // Nothing disturbs the plant: it stays at its margin for the next sample.
        let x = run.closed_loop.x.last().unwrap()[0];
        assert!(x < 0.5 - margin.first + 1e-6, "{x}");
        assert_eq!(run.report.constraint_violation_max, 0.0);
    }
}

#[test]
fn mistakes_are_said_with_their_place_and_remedy() {
    let stage = "(x - 1)^2 + 0.1*u^2";
    let mistakes = [
        ("x = { max = 0.5 }", "uncertainty = { confidence = 0.95 }", "nothing is random"),
        ("x = { max = 0.5, probability = 0.9 }", "", "nothing is random"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { x = 0.1 } }", "has a probability: the noise changes nothing"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { x = 0.1 }, confidence = 1 }", "below 1"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { x = 0.1 }, confidence = 0.3 }", "at least 0.5"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { u = 0.1 }, confidence = 0.9 }", "not a state"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { x = -0.1 }, confidence = 0.9 }", "must not be negative"),
        ("x = { max = 0.5 }", "uncertainty = { noise = { x = 0 }, confidence = 0.9 }", "there is no noise"),
        ("x = { max = 0.5 }", "uncertainty = { noise = 1, confidence = 0.9 }", "must be a table"),
        (
            "x = { max = 0.5 }",
            "uncertainty = { noise = { x = 1 }, confidence = 0.9, weights = [1] }",
            "needs uncertain parameters",
        ),
        (
            "x = { min = 0.4, max = 0.5 }",
            "uncertainty = { noise = { x = 1 }, confidence = 0.9 }",
            "no admissible value remains",
        ),
        (
            "x = { max = 0.5, hard = true, probability = 0.9 }",
            "uncertainty = { noise = { x = 1 } }",
            "not a soft bound of a state",
        ),
        ("u = { max = 0.5, probability = 0.9 }", "uncertainty = { noise = { x = 1 } }", "not a soft bound of a state"),
    ];
    for (bounds, lines, said) in mistakes {
        let error =
            read(LAG, &lag(stage, bounds, lines)).err().unwrap_or_else(|| panic!("{bounds} {lines}")).to_string();
        assert!(error.contains(said) && error.contains("problem.toml:"), "{bounds} {lines}: {error}");
    }
}

#[test]
fn the_tank_of_the_guide_has_its_margin() {
    let guide = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/mpc_uncertainty.md")).unwrap();
    let blocks: Vec<&str> = guide.split("```toml\n").skip(1).map(|b| b.split("```").next().unwrap()).collect();
    let run = control(&read(blocks[0], blocks[2]).unwrap()).unwrap().run;
    let margin = &run.report.chance.as_ref().unwrap().margins[0];
    assert!((margin.first - QUANTILE * 0.05 * 0.2_f64.sqrt()).abs() < 1e-9, "{margin:?}");
    assert!(run.report.succeeded, "{:?}", run.report.notes);
}
