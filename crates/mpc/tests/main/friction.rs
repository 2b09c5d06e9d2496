//! Control on dry friction, judged on the exact stick–slip plant alone.

use bracketry_mpc::closed_loop::{ClosedLoop, Fault, LoopSettings};
use bracketry_mpc::exact_friction::StickSlipSettings;
use bracketry_mpc::problem::Method;
use bracketry_mpc::{
    ControlProblem, CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, StickSlipController, run_closed_loop,
};
use bracketry_system::System;

/// A mass on a spring with Coulomb friction of the given level.
fn spring_mass(friction: f64) -> System {
    let text = format!(
        r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = {{ x = "v", v = "-0.8*x - 0.5*v + u - {friction}*sign(v)" }}
    "#
    );
    System::parse("spring_mass.toml", &text).unwrap()
}

fn benchmark(system: &System) -> Ocp {
    let mut ocp = Ocp::new(2, 1, 20, 0.15);
    let stage = "(x - 2)^2 + v^2 + 0.1*(u - 1.8)^2";
    ocp.stage = Some(CostFunction::parse(system, CostKind::Stage, &[], stage).unwrap());
    ocp.input_bounds = vec![(-2.0, 2.0)];
    ocp
}

fn controller(model: &System, ocp: Ocp, x0: &[f64]) -> StickSlipController {
    let guess = PlannedTrajectory::constant(ocp.steps, x0, &vec![0.0; ocp.inputs()]);
    StickSlipController::new(model, ocp, guess, StickSlipSettings::default()).unwrap()
}

fn run_with_faults(
    model: &System,
    plant: &System,
    ocp: Ocp,
    x0: &[f64],
    samples: usize,
    faults: impl FnMut(usize) -> Vec<Fault>,
) -> ClosedLoop {
    let mut controller = controller(model, ocp, x0);
    let mut plant = crate::common::exact_plant(plant, x0);
    let settings = LoopSettings { faults: Some(Box::new(faults)), ..LoopSettings::default() };
    run_closed_loop(&mut controller, &mut plant, x0, samples, settings).unwrap()
}

fn run(model: &System, plant: &System, ocp: Ocp, x0: &[f64], samples: usize) -> ClosedLoop {
    run_with_faults(model, plant, ocp, x0, samples, |_| Vec::new())
}

#[test]
fn the_spring_mass_arrives_at_the_receding_horizon_optimum() {
    // 5.791733 and 1.996371: every sample minimized to convergence on a closed-form event-driven flow (SciPy, L-BFGS-B).
    let system = spring_mass(0.2);
    let run = run(&system, &system, benchmark(&system), &[0.0, 0.0], 40);
    assert!((run.cost - 5.791733).abs() < 2e-5, "{}", run.cost);
    assert!((run.x[40][0] - 1.996371).abs() < 5e-5, "{}", run.x[40][0]);
    assert_eq!(run.counts.solved, 40);
}

#[test]
fn a_guess_of_the_wrong_length_is_refused() {
    let system = spring_mass(0.2);
    let guess = PlannedTrajectory::constant(7, &[0.0, 0.0], &[0.0]);
    let refused = StickSlipController::new(&system, benchmark(&system), guess, StickSlipSettings::default());
    assert!(matches!(refused.err(), Some(MpcError::Length { what: "the guess", found: 7, expected: 20 })));
}

#[test]
fn a_problem_file_asks_for_control_on_exact_friction() {
    let problem = ControlProblem::read(crate::common::model_path("spring_mass_friction_target.toml")).unwrap();
    assert!(matches!(problem.method, Method::StickSlip { .. }));
    let mut plant = crate::common::exact_plant(&problem.plant, &problem.x0);
    let report = problem.run(&mut plant).unwrap().report;
    assert!(report.closed_loop_cost <= 5.793, "{}", report.closed_loop_cost);
    assert!((report.x_final.get("x").unwrap() - 2.0).abs() <= 0.005, "{:?}", report.x_final);
    // The minimum over one horizon on the closed-form flow (SciPy, L-BFGS-B).
    assert!((report.open_loop_cost - 5.751804).abs() < 5e-5, "{}", report.open_loop_cost);
    assert_eq!(report.status.solved, 40);
}

#[test]
fn wrong_friction_leaves_no_more_than_it_could_hold() {
    // A force wrong by 20 % of 0.2 N moves the rest of a spring of 0.8 N/m by 0.05 m at most.
    let model = spring_mass(0.2);
    for friction in [0.16, 0.24] {
        let run = run(&model, &spring_mass(friction), benchmark(&model), &[0.0, 0.0], 60);
        assert!((run.x[60][0] - 2.0).abs() < 0.05, "{:?}", run.x[60]);
        assert!((run.x[60][0] - run.x[55][0]).abs() < 0.01, "it does not hunt");
    }
}

/// A block under Coulomb friction of 1 m/s².
fn block() -> System {
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a - sign(v)" }
    "#;
    System::parse("block.toml", text).unwrap()
}

/// Toward zero, where the end of the horizon counts `terminal` times x².
fn to_zero(terminal: f64) -> Ocp {
    let mut ocp = Ocp::new(2, 1, 20, 0.05);
    let (stage, terminal) = ("x^2 + 0.1*v^2 + 0.001*a^2", format!("{terminal}*x^2"));
    ocp.stage = Some(CostFunction::parse(&block(), CostKind::Stage, &[], stage).unwrap());
    ocp.terminal = Some(CostFunction::parse(&block(), CostKind::Terminal, &[], &terminal).unwrap());
    ocp.input_bounds = vec![(-5.0, 5.0)];
    ocp
}

#[test]
fn what_rests_near_its_target_is_pushed_when_that_pays() {
    // It breaks loose above 1 m/s²: no derivative at rest says so.
    let run = run(&block(), &block(), to_zero(50.0), &[-0.02, 0.0], 40);
    let end = &run.x[40];
    assert!(end[0].abs() <= 0.005 && end[1] == 0.0, "{end:?}");
    assert!(run.x[20..].iter().all(|x| x == end), "it stays there");
}

#[test]
fn what_rests_near_its_target_is_left_alone_when_a_push_costs_more() {
    // 1 m/s² over one sample costs 5e-5; 1 mm over the whole horizon costs 1e-6.
    let run = run(&block(), &block(), to_zero(0.0), &[-0.001, 0.0], 10);
    assert_eq!(run.x[10], [-0.001, 0.0]);
    assert!(run.u.iter().all(|u| u[0].abs() < 1e-3), "{:?}", run.u);
}

#[test]
fn blocks_joined_by_a_spring_are_brought_to_the_target_whichever_the_friction() {
    for friction in [0.3, 0.6, 0.9] {
        let text = format!(
            r#"
            states = ["p", "v", "q", "w"]
            inputs = ["u"]
            dynamics = {{ p = "v", v = "u + 20*(q - p) + (w - v) - {friction}*sign(v)", q = "w", w = "20*(p - q) + (v - w) - {friction}*sign(w)" }}
        "#
        );
        let system = System::parse("blocks.toml", &text).unwrap();
        let mut ocp = Ocp::new(4, 1, 30, 0.05);
        let stage = "10*(q - 0.5)^2 + w^2 + 0.1*v^2 + 0.01*u^2";
        ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &[], stage).unwrap());
        ocp.input_bounds = vec![(-5.0, 5.0)];
        let run = run(&system, &system, ocp, &[0.0; 4], 80);
        assert!((run.x[80][2] - 0.5).abs() < 0.02, "{friction}: {:?}", run.x[80]);
    }
}

#[test]
fn the_modes_of_a_plan_are_those_of_the_plant() {
    let mut changes = 0;
    for (i, x0) in [[0.0, 0.0], [0.0, -0.5], [2.6, 0.3], [1.9, 0.0], [2.2, 0.0], [3.0, -1.0], [3.0, 0.5], [-0.5, -1.0]]
        .iter()
        .enumerate()
    {
        let system = spring_mass(0.2 + 0.05 * i as f64);
        let mut controller = controller(&system, benchmark(&system), x0);
        let plan = controller.plan_from(x0).unwrap().clone();
        let planned = controller.mode_changes();
        changes += planned.len();
        let mut plant =
            bracketry_sim::ExactPlant::new(&system, x0, &bracketry_sim::SimulationSettings::default()).unwrap();
        for k in 0..plan.steps() {
            assert!(plant.hold(plan.u(k), 0.15).unwrap().is_finished());
            assert!((plant.state()[0] - plan.x(k + 1)[0]).abs() < 1e-4);
            let until = |c: &&bracketry_sim::ModeChange| c.t <= 0.15 * (k + 1) as f64 - 1e-6;
            if let Some(last) = planned.iter().rfind(until)
                && planned.iter().all(|c| (c.t - 0.15 * (k + 1) as f64).abs() > 1e-3)
            {
                assert_eq!(last.to, plant.modes()[0], "start {i}, interval {k}");
            }
        }
    }
    assert!(changes >= 4, "{changes} changes of mode");
}

#[test]
fn lost_and_wrong_measurements_are_survived_by_the_plan() {
    let system = spring_mass(0.2);
    let faults = |k: usize| match k {
        5 | 6 => vec![Fault::LostSample],
        9 => vec![Fault::NotANumber { outputs: vec![1] }],
        _ => vec![],
    };
    let run = run_with_faults(&system, &system, benchmark(&system), &[0.0, 0.0], 40, faults);
    assert_eq!((run.counts.fallback, run.counts.solved), (3, 37));
    assert!((run.x[40][0] - 2.0).abs() < 0.005, "{:?}", run.x[40]);
}

#[test]
fn friction_that_is_handed_over_controls_like_friction_that_was_known() {
    let text = r#"
        states = ["x", "v"]
        inputs = ["u"]
        parameters = { F = 0.5 }
        dynamics = { x = "v", v = "-0.8*x - 0.5*v + u - F*sign(v)" }
    "#;
    let (model, truth) = (System::parse("spring_mass.toml", text).unwrap(), spring_mass(0.2));
    let settings = StickSlipSettings { live_parameters: vec!["F".into()], ..StickSlipSettings::default() };
    let guess = PlannedTrajectory::constant(20, &[0.0, 0.0], &[0.0]);
    let mut told = StickSlipController::new(&model, benchmark(&model), guess, settings).unwrap();
    assert!(told.set_parameters(&[0.2, 0.3]).is_err());
    told.set_parameters(&[0.2]).unwrap();
    let mut plant = crate::common::exact_plant(&truth, &[0.0, 0.0]);
    let told = run_closed_loop(&mut told, &mut plant, &[0.0, 0.0], 40, LoopSettings::default()).unwrap();
    let knew = run(&truth, &truth, benchmark(&truth), &[0.0, 0.0], 40);
    assert!((told.cost - knew.cost).abs() < 1e-9, "{} {}", told.cost, knew.cost);
}
