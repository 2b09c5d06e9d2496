//! Keys of problem files beyond the simplest ones: what they do in the loop, and what is said about mistakes in them.

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::controller::FailurePolicy;
use bracketry_mpc::ocp::{Softness, Substeps};
use bracketry_mpc::problem::ClosedLoopReport;
use bracketry_mpc::{ControlProblem, Integrator, SymbolicDynamics};
use bracketry_system::System;

const CART: &str = r#"
states = ["x", "y", "vx", "vy"]
inputs = ["ux", "uy"]
ranges = { ux = { min = -3, max = 3 }, uy = { min = -3 } }
parameters = { m = 1, c = 0.1 }
definitions = { speed2 = "vx^2 + vy^2" }
dynamics = { x = "vx", y = "vy", vx = "(ux - c*vx)/m", vy = "(uy - c*vy)/m" }
"#;

const PROBLEM: &str = r#"
model = "cart.toml"
[horizon]
steps = 20
dt = 0.1
[cost]
stage = "(x - 1)^2 + (y - 1)^2 + 0.1*speed2 + 0.01*(ux^2 + uy^2)"
terminal = "10*((x - 1)^2 + (y - 1)^2) + vx^2 + vy^2"
[constraints]
uy = { max = 3 }
[solve]
method = "sqp"
[run]
x0 = { x = 0 }
steps = 60
"#;

fn read(text: &str) -> Result<ControlProblem, String> {
    ControlProblem::parse("p.toml", text, |file| System::parse(file, CART).map_err(Box::new)).map_err(|e| e.to_string())
}

fn with(line: &str, before: &str) -> String {
    PROBLEM.replace(before, &format!("{line}\n{before}"))
}

fn run(text: &str) -> (ClosedLoopReport, Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let problem = read(text).unwrap();
    let dynamics = SymbolicDynamics::new(&problem.plant).unwrap();
    let mut plant = RungeKuttaPlant::new(Box::new(dynamics), problem.plant_substeps);
    let run = problem.run(&mut plant).unwrap();
    (run.report, run.closed_loop.x, run.closed_loop.u)
}

#[test]
fn ranges_of_the_model_bound_the_inputs() {
    assert_eq!(read(PROBLEM).unwrap().ocp.input_bounds, [(-3.0, 3.0), (-3.0, 3.0)]);
}

#[test]
fn the_length_of_the_input_is_limited_by_a_cone() {
    let (report, _, u) = run(&with("force = { norm = [\"ux\", \"uy\"], max = 2 }", "[solve]"));
    let longest = u.iter().map(|u| u[0].hypot(u[1])).fold(0.0, f64::max);
    assert!((longest - 2.0).abs() < 1e-5, "{longest}");
    assert!(report.succeeded && (report.x_final.get("x").unwrap() - 1.0).abs() < 1e-3);
}

#[test]
fn an_expression_is_kept_within_its_bounds() {
    // The straight way leads through the circle of radius 0.3 about (0.55, 0.5).
    let text = with("hole = { expression = \"(x - 0.55)^2 + (y - 0.5)^2\", min = 0.09 }", "[solve]");
    let distance = |x: &Vec<f64>| (x[0] - 0.55).hypot(x[1] - 0.5);
    let nearest = |x: &[Vec<f64>]| x.iter().map(distance).fold(f64::INFINITY, f64::min);
    assert!(nearest(&run(PROBLEM).1) < 0.1);
    let (report, x, _) = run(&text);
    assert!(nearest(&x) > 0.2999, "{}", nearest(&x));
    assert!((report.x_final.get("y").unwrap() - 1.0).abs() < 1e-2);
}

#[test]
fn a_bound_may_move() {
    let (_, x, _) = run(&with("x = { max = \"0.1 + 0.2*t\" }", "[solve]"));
    for (k, x) in x.iter().enumerate().skip(1) {
        assert!(x[0] < 0.1 + 0.02 * k as f64 + 1e-4, "sample {k}: {}", x[0]);
    }
}

#[test]
fn inputs_are_held_over_blocks() {
    let mut problem = read(&with("blocks = [1, 1, 2, 4]", "[cost]")).unwrap();
    assert_eq!(problem.ocp.move_blocks, [1, 1, 2, 16]);
    problem.samples = 1;
    let plan = problem.plan().unwrap().trajectory;
    assert_eq!(plan.u(2), plan.u(3));
    assert_eq!(plan.u(4), plan.u(19));
    assert_ne!(plan.u(3), plan.u(4));
}

#[test]
fn integrators_have_names_and_stages() {
    let integrator = |line: &str| read(&with(line, "[cost]")).unwrap().ocp.integrator;
    assert_eq!(integrator("integrator = \"radau\""), Integrator::RadauIIA { stages: 2 });
    assert_eq!(integrator("integrator = \"gauss-legendre\"\nstages = 3"), Integrator::GaussLegendre { stages: 3 });
}

#[test]
fn stiff_models_get_enough_steps() {
    let stiff = |c: f64| {
        let model = CART.replace("c = 0.1", &format!("c = {c}"));
        let read = ControlProblem::parse("p.toml", PROBLEM, |f| System::parse(f, &model).map_err(Box::new)).unwrap();
        (read.ocp.substeps, read.plant_substeps)
    };
    assert_eq!(stiff(0.1), (Substeps::AtLeast(1), 1));
    // Rate 100 /s over 0.1 s: the method of order 4 is stable up to 2.78.
    assert_eq!(stiff(100.0), (Substeps::AtLeast(4), 4));
}

#[test]
fn parameters_may_differ_between_controller_plant_and_time() {
    let text = with("[parameters]\nm = \"2/3\"\nc = \"0.1 + 0.01*t\"", "[horizon]") + "parameters = { c = 0.3 }\n";
    let problem = read(&text).unwrap();
    let value = |s: &System, i: usize| s.parameters[i].value.to_f64().value();
    assert_eq!((value(&problem.system, 0), value(&problem.plant, 0)), (2.0 / 3.0, 2.0 / 3.0));
    assert_eq!(value(&problem.plant, 1), 0.3);
    assert_eq!(problem.live, ["c"]);
    assert!((problem.ocp.parameters[50][0] - 0.15).abs() < 1e-12);
    assert!(run(&text).0.succeeded);
}

#[test]
fn the_default_penalty_of_a_bound_grows_with_the_cost() {
    let linear = |factor: f64| {
        let text = with("x = { max = 0.5 }", "[solve]").replace("stage = \"", &format!("stage = \"{factor}*("));
        let text = text.replace("uy^2)\"", "uy^2))\"");
        match read(&text).unwrap().ocp.state_bounds[0].softness {
            Softness::Soft { linear, .. } => linear,
            Softness::Hard => 0.0,
        }
    };
    assert!(linear(1e6) > 1e3 * linear(1.0));
    let (_, x, _) = run(&with("x = { max = 0.5 }", "[solve]")
        .replace("stage = \"", "stage = \"1e6*(")
        .replace("uy^2)\"", "uy^2))\""));
    assert!(x.iter().all(|x| x[0] < 0.5 + 1e-5));
}

#[test]
fn an_estimator_finds_velocities_and_a_constant_disturbance() {
    let estimation = |disturbances: &str| {
        PROBLEM.replace("steps = 60", "steps = 200\nnoise = { x = 1e-4, y = 1e-4 }\nparameters = { c = 0.3 }")
            + &format!("[estimation]\nkind = \"ekf\"\noutputs = {{ x = 1e-4, y = 1e-4 }}\n{disturbances}")
    };
    let (report, _, _) = run(&estimation("disturbances = { ux = { std = 0.1, walk = 0.1 } }\n"));
    assert!((report.x_final.get("x").unwrap() - 1.0).abs() < 5e-3, "{:?}", report.x_final);
    assert_eq!(report.status.fallback, 0);
}

#[test]
fn the_infinite_horizon_is_a_terminal_cost() {
    // A linear model with a quadratic cost about its point: whatever its length, the horizon is the infinite one.
    let text = |steps: usize| {
        PROBLEM
            .replace("(x - 1)^2 + (y - 1)^2", "x^2 + y^2")
            .replace("terminal = \"10*(x^2 + y^2) + vx^2 + vy^2\"", "terminal = \"riccati\"")
            .replace("steps = 20", &format!("steps = {steps}"))
            .replace("x = 0", "x = 0.5, y = -0.2")
    };
    let (short, long) = (run(&text(2)).0.closed_loop_cost, run(&text(30)).0.closed_loop_cost);
    assert!((short / long - 1.0).abs() < 1e-6, "{short} {long}");
    let bounded = text(2).replace("terminal = ", "terminal_set = true\nterminal = ");
    assert!(read(&bounded).unwrap().ocp.terminal_set.is_some_and(|s| s.level > 0.0));
    assert!(read(&PROBLEM.replace("stage", "terminal_set = true\nstage")).err().unwrap().contains("p.toml:7:16"));
}

#[test]
fn the_exact_hessian_gives_the_same_loop() {
    // Springs that harden: the dynamics are curved.
    let cost = |line: &str| {
        let model = CART.replace("c*vx)", "c*vx - x^3)").replace("c*vy)", "c*vy - y*x)");
        let text = with(line, "[run]");
        let p = ControlProblem::parse("p.toml", &text, |f| System::parse(f, &model).map_err(Box::new)).unwrap();
        let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&p.plant).unwrap()), p.plant_substeps);
        p.run(&mut plant).unwrap().report.closed_loop_cost
    };
    let (one, other) = (cost("hessian = \"exact\""), cost("hessian = \"gauss-newton\""));
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
    let error = read(&with("hessian = \"exact\"", "[run]").replace("\"sqp\"", "\"rti\"")).err().unwrap();
    assert!(error.contains("p.toml:13:11") && error.contains("does not use the exact Hessian"), "{error}");
}

#[test]
fn backends_give_the_same_loop() {
    let cost = |line: &str| run(&with(line, "[run]")).0.closed_loop_cost;
    let condensed = cost("backend = \"condensed\"");
    assert!((cost("backend = \"sparse\"") / condensed - 1.0).abs() < 1e-6);
    assert!((cost("backend = \"condensed\"\nblock = 5") / condensed - 1.0).abs() < 1e-6);
}

#[test]
fn policies_have_names() {
    let policy = |line: &str| read(&with(line, "[run]")).map(|p| p.policy);
    assert_eq!(policy("policy = \"rest\"").unwrap(), FailurePolicy::RestInput);
    let brake =
        policy("policy = \"brake\"\nbrake = { ux = { velocity = \"vx\", rate = 5 } }\nbrake_after = 2").unwrap();
    assert!(matches!(brake, FailurePolicy::BrakeToRest { after: 2, brakes } if brakes[0].velocity == 2));
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (line, before, message, place) in [
        ("integrator = \"rk4\"\nstages = 3", "[cost]", "always has 4 stages", "p.toml:7:10"),
        ("stages = 7\nintegrator = \"radau\"", "[cost]", "must be 1, 2, 3, or 4", "p.toml:6:10"),
        ("blocks = [1, 0]", "[cost]", "a block must be a whole number", "p.toml:6:14"),
        ("blocks = [30]", "[cost]", "the blocks hold 30 intervals, the horizon 20", "p.toml:6:10"),
        ("g = { expression = \"x + q\", max = 1 }", "[solve]", "`q`", "p.toml:11:25"),
        ("g = { expression = \"x + y\" }", "[solve]", "`g` has no bounds", "p.toml:11:1"),
        ("g = { norm = [\"ux\"] }", "[solve]", "`g` has no `max`", "p.toml:11:1"),
        ("g = { norm = \"ux\", max = 1 }", "[solve]", "must be a list", "p.toml:11:14"),
        ("hessian = \"newton\"", "[run]", "there is no Hessian `newton`", "p.toml:13:11"),
        ("policy = \"hope\"", "[run]", "there is no policy `hope`", "p.toml:13:10"),
        ("policy = \"brake\"", "[run]", "the table `brake` is missing", "p.toml:13:10"),
        ("rest = { ux = 9 }", "[run]", "outside its bounds", "p.toml:13:15"),
        ("[parameters]\nmass = 2", "[horizon]", "`mass` is not a parameter", "p.toml:4:1"),
        ("[estimation]\noutputs = { z = 0.1 }", "[run]", "`z`", "p.toml:14:13"),
        ("[estimation]\nkind = \"ukf\"", "[run]", "there is no estimator `ukf`", "p.toml:14:8"),
        ("[estimation]\nkind = \"ekf\"", "[run]", "the estimator has no measurements", "p.toml"),
    ] {
        let error = read(&with(line, before)).err().unwrap();
        assert!(error.contains(message) && error.contains(place), "{line}: {error}");
    }
    for (line, message, place) in [
        ("noise = { z = 1 }", "`z` is not measured", "p.toml:16:11"),
        ("faults = [{ lost = true }]", "the fault has no `at`", "p.toml:16:11"),
        ("faults = [{ at = 5, until = 2, lost = true }]", "ends at 2, before it starts at 5", "p.toml:16:11"),
        ("faults = [{ at = 3 }]", "this fault has no effect", "p.toml:16:11"),
        ("delay = -1", "whole number", "p.toml:16:9"),
    ] {
        let error = read(&format!("{PROBLEM}{line}\n")).err().unwrap();
        assert!(error.contains(message) && error.contains(place), "{line}: {error}");
    }
}

/// The message about a mistake, which must name its line.
fn refused(text: &str, wrong: &str) -> String {
    let message = read(text).err().unwrap();
    let line = text.lines().position(|l| l.contains(wrong)).unwrap() + 1;
    assert!(message.contains(&format!("p.toml:{line}:")), "{message}");
    message
}

#[test]
fn a_mistake_about_the_estimator_is_found_in_its_line() {
    let with = |line: &str| format!("{PROBLEM}[estimation]\noutputs = {{ x = 0.01, y = 0.01 }}\n{line}\n");
    for (line, said) in [
        ("process_noise = { vx = -1 }", "must not be negative"),
        ("initial_std = { vx = -0.1 }", "must not be negative"),
        ("initial_std = { vx = nan }", "not a finite number"),
        ("parameters = { m = { std = -1 } }", "must not be negative"),
        ("parameters = { m = { std = 1, min = 2, max = 1 } }", "contradict"),
        ("smoothing = 0", "must be positive"),
        ("outliers = -3", "must be positive"),
    ] {
        let message = refused(&with(line), line);
        assert!(message.contains(said), "{line}: {message}");
    }
}

#[test]
fn an_estimator_looks_back_no_further_than_the_run() {
    let text = format!("{PROBLEM}[estimation]\nhorizon = 100000\noutputs = {{ x = 0.01, y = 0.01 }}\n");
    assert_eq!(read(&text).unwrap().estimation.unwrap().settings.horizon, 60);
    let long = text.replace("steps = 60", "steps = 100000");
    assert!(refused(&long, "horizon = 100000").contains("estimation horizon exceeds"));
}

#[test]
fn a_horizon_too_long_to_be_solved_is_refused() {
    let message = refused(&PROBLEM.replace("steps = 20", "steps = 100000"), "steps = 100000");
    assert!(message.contains("too large"), "{message}");
}

#[test]
fn smoothing_widths_decrease() {
    for widths in ["[0.01, 0.1]", "[0.1, 0.1]"] {
        let line = format!("smoothing = {widths}");
        assert!(refused(&with(&line, "[run]"), &line).contains("does not decrease"));
    }
    assert_eq!(read(&with("smoothing = [0.1, 0.01]", "[run]")).unwrap().smoothing, [0.1, 0.01]);
}

#[test]
fn real_time_iteration_predicts_the_cost_of_its_first_plan() {
    // A linear-quadratic problem: one program solves it, and the guess (at rest) costs 2 s times 2.
    let quadratic = PROBLEM.replace(" + 0.1*speed2", "");
    let converged = run(&quadratic).0.open_loop_cost;
    let (once, _, _) = run(&quadratic.replace("\"sqp\"", "\"rti\""));
    assert!((once.open_loop_cost - converged).abs() < 1e-6 * converged, "{} {converged}", once.open_loop_cost);
    assert!(converged < 20.0, "the guess costs 4 along the horizon and 20 at its end: {converged}");
}

/// The notes, one to a line.
fn told(report: &ClosedLoopReport) -> String {
    report.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_cost_that_is_not_a_number_solves_nothing() {
    for method in ["rti", "sqp"] {
        let text = PROBLEM.replace("(x - 1)^2 + (y", "log(x - 5) + (y").replace("\"sqp\"", &format!("\"{method}\""));
        let (report, _, _) = run(&text);
        assert_eq!((report.status.solved, report.status.fallback), (0, 60), "{method}");
        assert_eq!(report.status.reasons.total(), 60);
        assert!(!report.succeeded);
        let said = told(&report);
        assert!(said.contains("the stage cost is not finite at sample 0 (t = 0)"), "{said}");
        assert!(said.contains("60 × fallback, first at sample 0"), "{said}");
    }
}

#[test]
fn the_report_says_why_samples_were_not_solved() {
    let (report, _, _) = run(&format!("{PROBLEM}faults = [{{ at = 3, until = 5, lost = true }}]\n"));
    let said = told(&report);
    assert!(said.contains("3 × fallback, first at sample 3 (t = 0.3): the measurement is missing"), "{said}");
    let (report, _, _) = run(&with("x = { max = -1, hard = true }", "[solve]"));
    let said = told(&report);
    assert!(said.contains("infeasible: a hard bound cannot be kept"), "{said}");
}

#[test]
fn violations_of_named_constraints_count_too() {
    // Two constraints that cannot both be kept: one of them is missed by at least 1.
    let both = "over = { expression = \"vx\", min = 1 }\nunder = { expression = \"vx\", max = -1 }";
    let (report, x, _) = run(&with(both, "[solve]"));
    let worst = x[1..].iter().map(|x| (1.0 - x[2]).max(x[2] + 1.0)).fold(0.0, f64::max);
    assert!(worst >= 1.0 && (report.constraint_violation_max - worst).abs() < 1e-12, "{report:?} {worst}");
    // A length below 1/2 with a component above 1.
    let length = "over = { expression = \"vx\", min = 1 }\nspeed = { norm = [\"vx\", \"vy\"], max = 0.5 }";
    let (report, x, _) = run(&with(length, "[solve]"));
    let worst = x[1..].iter().map(|x| (1.0 - x[2]).max(x[2].hypot(x[3]) - 0.5)).fold(0.0, f64::max);
    assert!(worst >= 0.25 && (report.constraint_violation_max - worst).abs() < 1e-12, "{report:?} {worst}");
}

#[test]
fn keys_that_would_do_nothing_are_refused() {
    let estimation =
        format!("{PROBLEM}[estimation]\nkind = \"ekf\"\nhorizon = 5\noutputs = {{ x = 0.01, y = 0.01 }}\n");
    assert!(refused(&estimation, "horizon = 5").contains("no `horizon`"));
    assert!(refused(&with("time_limit = 1", "[run]"), "time_limit = 1").contains("applies to the methods"));
}

#[test]
fn what_an_estimator_cannot_tell_is_noted() {
    let estimation = |disturbances: &str| {
        let text =
            format!("{PROBLEM}[estimation]\noutputs = {{ x = 0.01, y = 0.01 }}\ndisturbances = {disturbances}\n");
        told(&run(&text).0)
    };
    let both = estimation("{ ux = { std = 1 }, vx = { std = 1 } }");
    assert!(both.contains("do not determine the disturbance of ux, the disturbance of vx"), "{both}");
    assert_eq!(estimation("{ ux = { std = 1 } }"), "");
}
