//! Steady-state targets, and control without offset and without hunting on exact stick and slip.
#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/noise.rs"]
mod noise;

use bracketry_mpc::{
    ClosedLoop, CostFunction, CostKind, Disturbance, DisturbanceChannel, EstimationProblem, Estimator, ExtendedKalman,
    LoopSettings, MeasuredOutput, MovingHorizon, MovingHorizonSettings, Ocp, OffsetFree, QpSettings, Rti, RtiSettings,
    TargetCalculator, TargetStatus, Trajectory, run_closed_loop,
};
use bracketry_symbolic::Rational;
use bracketry_system::System;
use common::ExactPlant;
use noise::Noise;

const DT: f64 = 0.15;
const SAMPLES: usize = 600;

/// A mass on a spring with a damper, pulled by u; friction in hundredths.
fn mass(friction: u8) -> System {
    let mut system = System::read(common::model_path("spring_mass_friction.toml")).unwrap();
    assert!(system.set_parameter("F", Rational::from_parts(friction.into(), 100u8.into())));
    system
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
    let mut targets = TargetCalculator::new(&problem(&mass(20)), &[0], &[(-2.0, 2.0)]).unwrap();
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
    let mut problem = problem(&mass(20));
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
    let rest = Trajectory::constant(20, &[0.0, 0.0], &[0.0]);
    let settings = RtiSettings { smoothing: Some(0.01), qp: QpSettings::default(), ..RtiSettings::default() };
    Rti::new(Box::new(problem.controller_dynamics().unwrap()), ocp, rest, settings).unwrap()
}

/// The loop on exact friction, with a force of `disturbance` that nobody knows of.
fn run(problem: &EstimationProblem, friction: u8, disturbance: f64, dead_band: f64, horizon: bool) -> ClosedLoop {
    let mut controller = OffsetFree::new(controller(problem), problem, &[0], &[2.0], &[dead_band]).unwrap();
    let mut filter: Box<dyn Estimator> = if horizon {
        Box::new(MovingHorizon::new(problem, MovingHorizonSettings::default()).unwrap())
    } else {
        Box::new(ExtendedKalman::new(problem).unwrap())
    };
    struct Pushed(ExactPlant, f64);
    impl bracketry_mpc::Plant for Pushed {
        fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), bracketry_mpc::PlantError> {
            self.0.step(t, x, &[u[0] + self.1], dt)
        }
    }
    let mut plant = Pushed(ExactPlant::new(&mass(friction), &[0.0, 0.0]), disturbance);
    let mut noise = Noise::new(u64::from(friction));
    let settings = LoopSettings {
        estimator: Some(filter.as_mut()),
        hand_over: true,
        measurement: Some(Box::new(|_, x| vec![x[0]])),
        noise: Some(Box::new(move |_, y| y[0] += 1e-3 * noise.normal())),
        ..LoopSettings::default()
    };
    run_closed_loop(&mut controller, &mut plant, &[0.0, 0.0], SAMPLES, settings).unwrap()
}

/// Way that the mass makes in the second half of the run, and its error at the end.
fn way_and_error(run: &ClosedLoop) -> (f64, f64) {
    let late = &run.x[SAMPLES / 2..];
    let way = late.windows(2).map(|w| (w[1][0] - w[0][0]).abs()).sum();
    (way, (late[late.len() - 1][0] - 2.0).abs())
}

#[test]
fn probe() {
    for (friction, disturbance) in [(16, 0.15), (24, 0.15), (20, -0.1), (24, -0.2), (16, -0.2), (20, 0.0)] {
        let knows = problem(&mass(20));
        let naive = problem(&mass(0));
        for (name, run) in [
            ("ours", run(&knows, friction, disturbance, 0.02, false)),
            ("mhe", run(&knows, friction, disturbance, 0.02, true)),
            ("no band", run(&knows, friction, disturbance, 0.0, false)),
            ("naive", run(&naive, friction, disturbance, 0.0, false)),
        ] {
            let (way, error) = way_and_error(&run);
            println!("F {friction} d {disturbance} {name:8} way {way:.4} error {error:.5} {:?}", run.counts);
            if std::env::var("LONG").is_ok() {
                for k in (0..120).step_by(2) {
                    println!(
                        "   {k} x {:.4} v {:.4} u {:.4} est {:?}",
                        run.x[k][0], run.x[k][1], run.u[k][0], run.estimates[k]
                    );
                }
            }
        }
    }
}
