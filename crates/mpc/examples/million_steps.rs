//! Memory and counts of long closed loops: `cargo run --release -p bracketry-mpc --example million_steps --features measure [STEPS]`.
//!
//! A mass pushed at random for STEPS (a million) samples without faults; then the cart-pole and the mass with dry friction on
//! its exact plant for a fiftieth of them each, with every kind of fault at random. The resident memory is noted twenty times
//! per run, and the program fails when it grows after the first fifth.
#![allow(clippy::print_stdout)]

use bracketry_mpc::closed_loop::{Counts, Fault, LoopSettings, RungeKuttaPlant, SampledLoop};
use bracketry_mpc::controller::{Brake, FailurePolicy};
use bracketry_mpc::{ControlProblem, Controller, PlannedTrajectory, Plant, Rti, RtiSettings, SymbolicDynamics};
use bracketry_sim::{ExactPlant, SimulationSettings};
use bracketry_system::System;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::error::Error;
use std::time::Instant;

/// Memory that an allocator may take or keep without anything having grown, bytes.
const NOISE: f64 = 256.0 * 1024.0;
const NOTES: usize = 20;

const MASS: &str = r#"
states = ["p", "v"]
inputs = ["u"]
dynamics = { p = "v", v = "u" }
"#;
const MASS_PROBLEM: &str = r#"
model = "mass.toml"
horizon = { steps = 5, dt = 0.1 }
cost = { stage = "p^2 + 0.1*v^2 + 0.1*u^2", terminal = "p^2 + v^2" }
constraints = { u = { min = -1, max = 1 } }
solve = { method = "rti" }
run = { x0 = { p = 1 }, steps = 1 }
"#;

/// Resident memory of this process in bytes; none where the system does not tell.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|k| k * 1024.0)
}

/// Faults of one sample: each kind in about one of fifty, a blow of up to a hundred times `push` among them.
fn faults(random: &mut StdRng, push: &[f64]) -> Vec<Fault> {
    let mut uniform = |low: f64, high: f64| low + (high - low) * random.random_range(0.0..1.0);
    let mut blow = |factor: f64| Fault::Disturbance(push.iter().map(|p| factor * uniform(-p, *p)).collect());
    let mut faults = vec![blow(1.0)];
    let hundredfold = blow(100.0);
    let mut add = |fault: Fault| {
        if random.random_range(0..50) == 0 {
            faults.push(fault);
        }
    };
    add(hundredfold);
    add(Fault::LostSample);
    add(Fault::NotANumber { outputs: vec![0] });
    add(Fault::SolverLimit(2));
    add(Fault::TimeLimit(1e-5));
    faults
}

/// Runs a loop, prints its memory and counts, and says by how much the memory grew after the first fifth.
fn watch(
    name: &str,
    controller: &mut dyn Controller,
    plant: &mut dyn Plant,
    x0: &[f64],
    samples: usize,
    settings: LoopSettings<'_>,
) -> Result<f64, Box<dyn Error>> {
    let bounds = controller.ocp().input_bounds.clone();
    let start = Instant::now();
    let mut sampled = SampledLoop::new(controller, plant, x0, settings)?;
    let mut notes = Vec::with_capacity(NOTES);
    let (mut kept, mut finite) = (true, true);
    for k in 1..=samples {
        let sample = sampled.sample()?;
        kept &= sample.u.iter().zip(&bounds).all(|(u, b)| b.0 <= *u && *u <= b.1);
        finite &= sample.x.iter().all(|v| v.is_finite());
        if k % (samples / NOTES) == 0 {
            notes.push(resident().ok_or("resident memory is told on Linux only")?);
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let counts: Counts = *sampled.counts();
    let largest = |v: &[f64]| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let fifth = NOTES / 5;
    let growth = largest(&notes[NOTES - fifth..]) - largest(&notes[..fifth]);
    println!("{name}: {samples} samples, {:.1} µs each", 1e6 * seconds / samples as f64);
    let kib: Vec<String> = notes.iter().map(|b| format!("{:.0}", b / 1024.0)).collect();
    println!("  resident memory, KiB: {}", kib.join(" "));
    println!("  growth from the first to the last fifth: {:.0} KiB", growth / 1024.0);
    println!("  {}", outcomes(&counts));
    println!("  inputs within their bounds: {kept}, states finite: {finite}");
    assert_eq!(counts.samples(), samples);
    assert_eq!(counts.reasons.total(), counts.fallback);
    assert!(kept && finite);
    Ok(growth)
}

fn outcomes(c: &Counts) -> String {
    let (r, s) = (&c.reasons, &c.sources);
    format!(
        "solved {}, inaccurate {}, infeasible {}; fallback {} (lost sample {}, not a number {}, linearization {}, time limit \
         {}, solver limit {}, solver failed {}); inputs from programs {}, plan {}, brake {}, rest {}",
        c.solved,
        c.inaccurate,
        c.infeasible,
        c.fallback,
        r.lost_sample,
        r.measurement,
        r.linearization,
        r.time_limit,
        r.qp_limit,
        r.qp_failed,
        s.program,
        s.plan,
        s.brake,
        s.rest
    )
}

/// Real-time iteration on a problem.
fn controller(problem: &ControlProblem, policy: FailurePolicy) -> Result<Rti, Box<dyn Error>> {
    let settings = RtiSettings { policy, smoothing: problem.widths().last().copied(), ..RtiSettings::default() };
    let rest = vec![0.0; problem.ocp.inputs()];
    let start = PlannedTrajectory::constant(problem.ocp.steps, &problem.x0, &rest);
    let dynamics = Box::new(SymbolicDynamics::new(&problem.system)?);
    Ok(Rti::new(dynamics, problem.ocp.clone(), start, settings)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let samples: usize = std::env::args().nth(1).map_or(Ok(1_000_000), |t| t.parse())?;
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/");
    let mut random = StdRng::seed_from_u64(5);
    let mut grown = Vec::new();

    let mass =
        ControlProblem::parse("mass_problem.toml", MASS_PROBLEM, |file| System::parse(file, MASS).map_err(Box::new))?;
    let mut rti = controller(&mass, FailurePolicy::ShiftedInput)?;
    let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&mass.system)?), 1);
    let push = |_| vec![Fault::Disturbance(vec![0.0, 0.2 * (2.0 * random.random_range(0.0..1.0) - 1.0)])];
    let settings = LoopSettings { faults: Some(Box::new(push)), ..LoopSettings::default() };
    grown.push(watch("mass", &mut rti, &mut plant, &mass.x0, samples, settings)?);

    let mut random = StdRng::seed_from_u64(6);
    let mut pole = ControlProblem::read(format!("{models}cart_pole_swing_up.toml"))?;
    pole.x0.fill(0.0);
    let mut rti = controller(&pole, FailurePolicy::ShiftedInput)?;
    let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&pole.plant)?), 2);
    let push = [0.0, 0.0, 0.02, 0.02];
    let settings = LoopSettings { faults: Some(Box::new(|_| faults(&mut random, &push))), ..LoopSettings::default() };
    grown.push(watch("cart-pole with faults", &mut rti, &mut plant, &pole.x0, samples / 50, settings)?);

    let mut random = StdRng::seed_from_u64(7);
    let spring = ControlProblem::read(format!("{models}spring_mass_friction_target.toml"))?;
    let brake = Brake { input: 0, velocity: 1, rate: 1.0 / spring.ocp.dt };
    let policy = FailurePolicy::BrakeToRest { after: 1, brakes: vec![brake] };
    let mut rti = controller(&spring, policy)?;
    let push = [0.0, 0.05];
    let settings = LoopSettings { faults: Some(Box::new(|_| faults(&mut random, &push))), ..LoopSettings::default() };
    let mut plant = ExactPlant::new(&spring.plant, &spring.x0, &SimulationSettings::default())?;
    grown.push(watch("mass with dry friction and faults", &mut rti, &mut plant, &spring.x0, samples / 50, settings)?);

    assert!(grown.iter().all(|g| *g < NOISE), "the memory grows: {grown:?} bytes");
    Ok(())
}
