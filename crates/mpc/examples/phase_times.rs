//! Times of the phases of a control step: `cargo run --release -p bracketry-mpc --example phase_times --features measure`.
//!
//! The swing-up of the pendulum with every kind of preparation, then the move of the plate along its plan.
#![allow(clippy::print_stdout)]

use bracketry_mpc::closed_loop::{LoopSettings, PhaseTimes, RungeKuttaPlant, SolveTimes};
use bracketry_mpc::rti::Preparation;
use bracketry_mpc::{ControlProblem, PlannedTrajectory, Rti, RtiSettings, SymbolicDynamics, run_closed_loop};
use bracketry_sim::{ExactPlant, SimulationSettings};
use std::error::Error;

fn print(name: &str, times: &PhaseTimes) {
    let cell = |t: &SolveTimes| format!("{:.3} / {:.3}", t.median, t.p99);
    let cells = [&times.prepare, &times.qp, &times.rest, &times.feedback].map(cell);
    println!("| {name} | {} |", cells.join(" | "));
}

fn main() -> Result<(), Box<dyn Error>> {
    let models = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/");
    println!(
        "| step, ms (median / 99 %) | prepare | program | rest of the feedback | feedback |\n|---|---|---|---|---|"
    );
    let pendulum = ControlProblem::read(format!("{models}cart_pole_swing_up.toml"))?;
    let kinds = [
        ("pendulum", Preparation::Linearize),
        ("pendulum, one program ahead", Preparation::AdvancedStep { programs: 1 }),
        ("pendulum, one program ahead and tangent", Preparation::AdvancedStepTangential { programs: 1 }),
    ];
    for (name, preparation) in kinds {
        let settings = RtiSettings { preparation, ..RtiSettings::default() };
        let start = PlannedTrajectory::constant(pendulum.ocp.steps, &pendulum.x0, &[0.0]);
        let model = || SymbolicDynamics::new(&pendulum.system).map(Box::new);
        let mut rti = Rti::new(model()?, pendulum.ocp.clone(), start, settings)?;
        for _ in 1..30 {
            rti.feedback(&pendulum.x0)?;
        }
        let mut plant = RungeKuttaPlant::new(model()?, 2);
        let run = run_closed_loop(&mut rti, &mut plant, &pendulum.x0, 1000, LoopSettings::default())?;
        print(name, &run.phases);
    }
    let plate = ControlProblem::read(format!("{models}plate_move.toml"))?;
    let run = plate.run(&mut ExactPlant::new(&plate.plant, &plate.x0, &SimulationSettings::default())?)?;
    print("plate along its plan", &run.closed_loop.phases);
    Ok(())
}
