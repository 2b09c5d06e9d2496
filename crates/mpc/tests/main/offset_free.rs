//! Steady-state targets, and control without offset and without hunting on exact stick and slip.

use crate::common::{exact_plant, noise::Noise};
use bracketry_mpc::closed_loop::{ClosedLoop, DelayCompensated, LoopSettings};
use bracketry_mpc::estimation::{
    Disturbance, DisturbanceChannel, EstimationProblem, Estimator, ExtendedKalman, MeasuredOutput, MovingHorizon,
    MovingHorizonSettings, OffsetFree, OutputFeedback, TargetCalculator, TargetStatus,
};
use bracketry_mpc::{
    CostFunction, CostKind, Ocp, PlannedTrajectory, Plant, PlantFailure, Rti, RtiSettings, run_closed_loop,
};
use bracketry_sim::ExactPlant;
use bracketry_system::System;

const DT: f64 = 0.15;
const SAMPLES: usize = 600;
const GOAL: f64 = 1.0;

/// A mass on a spring with a damper, pulled by u, whose friction at rest is larger than in motion; F in hundredths.
fn mass(friction: u8, at_rest: f64) -> System {
    let text = format!(
        r#"
        states = ["x", "v"]
        inputs = ["u"]
        parameters = {{ F = {} }}
        dynamics = {{ x = "v", v = "-0.8*x - 0.5*v + u - F*sign(v)" }}
        static = {{ v = {at_rest} }}
        "#,
        f64::from(friction) / 100.0
    );
    System::parse("mass.toml", &text).unwrap()
}

/// The position is measured with 1 mm; an unknown constant force acts.
fn problem(model: &System) -> EstimationProblem {
    let mut problem = EstimationProblem::new(model, DT, &[0.0, 0.0]);
    problem.outputs = vec![MeasuredOutput::new("x", 1e-3)];
    problem.process_noise[1] = 0.01;
    problem.disturbances = vec![Disturbance::new(DisturbanceChannel::Input("u".into()), 0.2, 0.1)];
    problem
}

#[test]
fn the_target_balances_spring_and_disturbance() {
    let mut targets = TargetCalculator::new(&problem(&mass(20, 1.0)), &[0], &[(-2.0, 2.0)]).unwrap();
    let target = targets.target(&[2.0], &[0.15]).unwrap();
    assert_eq!(target.status, TargetStatus::Reached);
    for (value, expected) in [(target.x[0], 2.0), (target.x[1], 0.0), (target.u[0], 0.8 * 2.0 - 0.15)] {
        assert!((value - expected).abs() < 1e-6, "{value} {expected}");
    }
    // Beyond the force: as far as it goes, 0.8 x = 2 + 0.15.
    let target = targets.target(&[4.0], &[0.15]).unwrap();
    let reach = 2.15 / 0.8;
    assert!((target.x[0] - reach).abs() < 1e-5 && (target.u[0] - 2.0).abs() < 1e-5, "{target:?}");
    let TargetStatus::Nearest { miss } = target.status else { panic!("{:?}", target.status) };
    assert!((miss - (4.0 - reach)).abs() < 1e-5, "{miss}");
    // And back.
    assert_eq!(targets.target(&[1.0], &[0.0]).unwrap().status, TargetStatus::Reached);
}

#[test]
fn two_disturbances_of_one_output_are_told_apart_by_none() {
    let mut problem = problem(&mass(20, 1.0));
    assert!(problem.check_observability(&[1.0, 0.5], &[0.0]).is_ok());
    problem.disturbances.push(Disturbance::new(DisturbanceChannel::Output(0), 0.1, 0.0));
    let message = problem.check_observability(&[1.0, 0.5], &[0.0]).unwrap_err().to_string();
    assert!(message.contains("the disturbance of u, the disturbance of `x`"), "{message}");
}

fn controller(problem: &EstimationProblem) -> Rti {
    let mut ocp = Ocp::new(2, 1, 20, DT);
    let cost = "(x - xs)^2 + v^2 + 0.1*(u - us)^2";
    let names = ["xs", "vs", "us"];
    ocp.stage = Some(CostFunction::parse(&problem.system, CostKind::Stage, &names, cost).unwrap());
    ocp.terminal = Some(CostFunction::parse(&problem.system, CostKind::Terminal, &names, "(x - xs)^2 + v^2").unwrap());
    ocp.input_bounds = vec![(-2.0, 2.0)];
    ocp.references = vec![vec![0.0; 3]];
    let rest = PlannedTrajectory::constant(20, &[0.0, 0.0], &[0.0]);
    let settings = RtiSettings { smoothing: Some(0.003), ..RtiSettings::default() };
    Rti::new(Box::new(problem.controller_dynamics().unwrap()), ocp, rest, settings).unwrap()
}

/// A plant with an input disturbance.
struct Pushed(ExactPlant, f64);

impl Plant for Pushed {
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantFailure> {
        self.0.step(t, x, &[u[0] + self.1], dt)
    }
}

/// What the loop is run with.
struct Case {
    /// Friction of the plant in hundredths, and how much larger it is at rest.
    friction: (u8, f64),
    /// The force that nobody knows of.
    disturbance: f64,
    dead_band: f64,
    delay: usize,
    /// Whether every seventh measurement is lost.
    losses: bool,
}

const PLAIN: Case = Case { friction: (20, 1.0), disturbance: 0.15, dead_band: 0.03, delay: 0, losses: false };

/// The loop on exact friction.
fn run(problem: &EstimationProblem, estimator: impl Estimator, case: &Case) -> ClosedLoop {
    let inside = OffsetFree::new(controller(problem), problem, &[0], &[GOAL], &[case.dead_band]).unwrap();
    let model = Box::new(problem.controller_dynamics().unwrap());
    let compensated = DelayCompensated::new(inside, model, case.delay, &[0.0]).unwrap();
    let mut controller = OutputFeedback::new(compensated, estimator, true, case.delay, &[0.0]).unwrap();
    let (friction, at_rest) = case.friction;
    let mut plant = Pushed(exact_plant(&mass(friction, at_rest), &[0.0, 0.0]), case.disturbance);
    let mut noise = Noise::new(u64::from(friction));
    let losses = case.losses;
    let settings = LoopSettings {
        delay: case.delay,
        measurement: Some(Box::new(|_, x| vec![x[0]])),
        noise: Some(Box::new(move |k, y| {
            y[0] += 1e-3 * noise.normal();
            if losses && k % 7 == 3 {
                y[0] = f64::NAN;
            }
        })),
        ..LoopSettings::default()
    };
    run_closed_loop(&mut controller, &mut plant, &[0.0, 0.0], SAMPLES, settings).unwrap()
}

/// How often the mass breaks loose in the second half of the run, and its largest error there.
fn starts_and_error(run: &ClosedLoop) -> (usize, f64) {
    let late = &run.x[SAMPLES / 2..];
    let starts = late.windows(2).filter(|w| w[0][1] == 0.0 && w[1][1] != 0.0).count();
    (starts, late.iter().fold(0.0, |worst: f64, x| worst.max((x[0] - GOAL).abs())))
}

#[test]
fn with_wrong_friction_and_a_constant_disturbance_the_mass_comes_to_rest_near_the_goal() {
    // Friction alone could hold it off by F/k = 0.25.
    let problem = problem(&mass(20, 1.0));
    for case in [
        Case { friction: (16, 1.0), ..PLAIN },
        Case { friction: (24, 1.0), ..PLAIN },
        Case { friction: (24, 1.5), disturbance: -0.1, ..PLAIN },
        Case { friction: (16, 1.0), delay: 1, ..PLAIN },
        Case { friction: (24, 1.0), losses: true, ..PLAIN },
    ] {
        let run = run(&problem, ExtendedKalman::new(&problem).unwrap(), &case);
        let (starts, error) = starts_and_error(&run);
        assert_eq!(starts, 0, "the mass moves again with friction {:?}", case.friction);
        assert!(error < 0.03, "{error} with friction {:?}, delay {}", case.friction, case.delay);
        let late = &run.u[SAMPLES / 2..];
        assert!(late.iter().all(|u| u == &late[0]), "within the dead band the input is held");
    }
    let horizon = MovingHorizon::new(&problem, MovingHorizonSettings::default()).unwrap();
    let (starts, error) = starts_and_error(&run(&problem, horizon, &Case { friction: (24, 1.0), ..PLAIN }));
    assert!(starts == 0 && error < 0.03, "{starts} {error}");
}

#[test]
fn an_integrator_that_knows_nothing_of_friction_never_comes_to_rest() {
    // Friction is left to the disturbance: it winds up while the mass sticks.
    let problem = problem(&mass(0, 1.0));
    for friction in [(24, 1.0), (24, 1.5)] {
        let case = Case { friction, dead_band: 0.0, ..PLAIN };
        let (starts, _) = starts_and_error(&run(&problem, ExtendedKalman::new(&problem).unwrap(), &case));
        assert!(starts > 0, "{friction:?}");
    }
}
