//! Random closed loops with random faults: every sample has an input within its bounds, and the counts add up.

use bracketry_mpc::closed_loop::{DelayCompensated, Fault, LoopSettings, RungeKuttaPlant};
use bracketry_mpc::controller::{Brake, FailurePolicy};
use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::rti::Preparation;
use bracketry_mpc::sqp::SqpController;
use bracketry_mpc::{
    Controller, CostFunction, CostKind, Ocp, PlannedTrajectory, Rti, RtiSettings, Sqp, SqpSettings, SymbolicDynamics,
    TerminalTarget, run_closed_loop,
};
use bracketry_system::System;
use proptest::prelude::*;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::fmt::Write;

const SAMPLES: usize = 25;

struct Random(StdRng);

impl Random {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random_range(0.0..1.0)
    }
    fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }
    fn chance(&mut self, p: f64) -> bool {
        self.uniform(0.0, 1.0) < p
    }
}

/// Linear dynamics, stable or not, with nonlinear terms that may grow without bound, blow up or rub.
fn system(random: &mut Random, n: usize, m: usize) -> System {
    let list = |prefix: &str, k: usize| (0..k).map(|i| format!("\"{prefix}{i}\"")).collect::<Vec<_>>().join(", ");
    let mut text = format!("name = \"random\"\nstates = [{}]\ninputs = [{}]\n[dynamics]\n", list("x", n), list("u", m));
    for i in 0..n {
        let mut rate = format!("{:.3}*u{}", random.uniform(-2.0, 2.0), random.below(m));
        for j in 0..n {
            let _ = write!(rate, " + {:.3}*x{j}", random.uniform(-2.0, 2.0));
        }
        let j = random.below(n);
        let term = match random.below(8) {
            0 => format!(" + sin(x{j})"),
            1 => format!(" + 0.3*x{j}^3"),
            2 => format!(" - 0.5*sign(x{j})"),
            3 => format!(" + exp(x{j})"),
            4 => format!(" + log(2 + x{j})"),
            5 => format!(" + x{j}*u0"),
            _ => String::new(),
        };
        let _ = writeln!(text, "x{i} = \"{rate}{term}\"");
    }
    System::parse("random.toml", &text).unwrap()
}

fn problem(random: &mut Random, system: &System, n: usize, m: usize) -> Ocp {
    let mut ocp = Ocp::new(n, m, 2 + random.below(8), random.uniform(0.01, 0.3));
    ocp.substeps = Substeps::Fixed(1 + random.below(2));
    let mut cost = String::new();
    for i in 0..n {
        let _ = write!(cost, "{:.3}*x{i}^2 + ", random.uniform(0.0, 5.0));
    }
    if random.chance(0.3) {
        cost += "sin(x0) + x0*u0 + ";
    }
    for j in 0..m {
        let _ = write!(cost, "0.1*u{j}^2{}", if j + 1 < m { " + " } else { "" });
    }
    ocp.stage = random.chance(0.9).then(|| CostFunction::parse(system, CostKind::Stage, &[], &cost).unwrap());
    for b in &mut ocp.input_bounds {
        let middle = random.uniform(-2.0, 2.0);
        *b = (middle - random.uniform(0.0, 3.0), middle + random.uniform(0.0, 3.0));
    }
    for b in &mut ocp.state_bounds {
        if random.chance(0.4) {
            let hard = random.chance(0.5);
            let softness = if hard { Softness::Hard } else { Softness::Soft { linear: 10.0, quadratic: 1.0 } };
            let min = random.uniform(-2.0, 1.0);
            let max = if random.chance(0.3) { f64::INFINITY } else { min + random.uniform(0.0, 2.0) };
            *b = Bounds { min, max, softness };
        }
    }
    if random.chance(0.4) {
        let value = random.uniform(-3.0, 3.0);
        ocp.targets = vec![TerminalTarget { state: random.below(n), value, linear: 10.0, quadratic: 1.0 }];
    }
    ocp
}

fn controller(random: &mut Random, system: &System, ocp: &Ocp) -> Box<dyn Controller> {
    let (n, m) = (ocp.states(), ocp.inputs());
    let start: Vec<f64> = (0..n).map(|_| random.uniform(-1.0, 1.0)).collect();
    // The first plan may break the bounds.
    let guess = PlannedTrajectory::constant(ocp.steps, &start, &vec![random.uniform(-4.0, 4.0); m]);
    let dynamics = Box::new(SymbolicDynamics::new(system).unwrap());
    if random.chance(0.2) {
        let settings = SqpSettings { filter_iterations: 3, max_iterations: 4, ..SqpSettings::default() };
        return Box::new(SqpController::new(Sqp::new(dynamics, ocp.clone(), settings).unwrap(), guess));
    }
    let policy = match random.below(3) {
        0 => FailurePolicy::ShiftedInput,
        1 => FailurePolicy::RestInput,
        _ => FailurePolicy::BrakeToRest {
            after: random.below(4),
            brakes: vec![Brake { input: random.below(m), velocity: random.below(n), rate: random.uniform(0.0, 1e3) }],
        },
    };
    let settings = RtiSettings {
        policy,
        guarded: random.chance(0.3),
        proximal: if random.chance(0.3) { 0.1 } else { 0.0 },
        iterations: 1 + random.below(3),
        preparation: match random.below(4) {
            0 => Preparation::AdvancedStep { programs: 2 },
            1 => Preparation::AdvancedStepTangential { programs: 1 },
            _ => Preparation::Linearize,
        },
        time_limit: if random.chance(0.2) { 1e-4 } else { f64::INFINITY },
        ..RtiSettings::default()
    };
    Box::new(Rti::new(dynamics, ocp.clone(), guess, settings).unwrap())
}

fn faults(random: &mut Random, n: usize) -> Vec<Fault> {
    let mut faults = Vec::new();
    if random.chance(0.1) {
        faults.push(Fault::LostSample);
    }
    if random.chance(0.1) {
        faults.push(Fault::NotANumber { outputs: vec![random.below(n + 1)] });
    }
    if random.chance(0.1) {
        let size = 10f64.powf(random.uniform(-2.0, 6.0));
        faults.push(Fault::Disturbance((0..n).map(|_| random.uniform(-size, size)).collect()));
    }
    if random.chance(0.1) {
        faults.push(Fault::SolverLimit(random.below(4) as u32));
    }
    if random.chance(0.05) {
        faults.push(Fault::TimeLimit(random.uniform(0.0, 1e-4)));
    }
    if random.chance(0.02) {
        faults.push(Fault::Disturbance(vec![f64::INFINITY; n]));
    }
    faults
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_sample_has_an_input_within_its_bounds(seed: u64) {
        let mut random = Random(StdRng::seed_from_u64(seed));
        let (n, m) = (1 + random.below(4), 1 + random.below(2));
        let system = system(&mut random, n, m);
        let ocp = problem(&mut random, &system, n, m);
        let mut controller = controller(&mut random, &system, &ocp);
        let model = || Box::new(SymbolicDynamics::new(&system).unwrap());
        let delay = random.below(3);
        if delay > 0 && random.chance(0.7) {
            controller = Box::new(DelayCompensated::new(controller, model(), delay, &vec![0.0; m]).unwrap());
        }
        let x0: Vec<f64> = (0..n).map(|_| random.uniform(-2.0, 2.0)).collect();
        let settings = LoopSettings {
            delay,
            faults: Some(Box::new(|_| faults(&mut random, n))),
            ..LoopSettings::default()
        };
        let mut plant = RungeKuttaPlant::new(model(), 2);
        let run = run_closed_loop(controller.as_mut(), &mut plant, &x0, SAMPLES, settings).unwrap();
        for step in &run.steps {
            for (u, b) in step.u.iter().zip(&ocp.input_bounds) {
                prop_assert!(b.0 <= *u && *u <= b.1, "{u} outside of {b:?}: {:?}", step.status);
            }
        }
        prop_assert_eq!(run.counts.samples(), SAMPLES);
        prop_assert_eq!(run.counts.reasons.total(), run.counts.fallback);
        prop_assert_eq!(run.counts.sources.total(), SAMPLES);
        prop_assert_eq!(run.counts.sources.program + run.counts.sources.tangent, run.counts.solved + run.counts.inaccurate + run.counts.infeasible);
    }
}
