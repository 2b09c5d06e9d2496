//! How the loops of the story are closed: what the camera and the plate's encoders tell, one sample late.

use bracketry::mpc::estimation::{EstimatedParameter, EstimationProblem, MeasuredOutput, MovingHorizonSettings};
use bracketry::mpc::problem::{ControlRun, Estimation, EstimatorKind};
use bracketry::mpc::{ControlProblem, MpcError};
use bracketry::plate::recording::RecordingSettings;

/// Samples between a measurement and the input that answers it.
const DELAY: usize = 1;
/// Standard deviations that the encoders of the plate are taken to have: m, m/s, rad, rad/s.
const ENCODERS: [(&str, f64); 4] = [("X", 1e-6), ("Xd", 1e-5), ("theta", 1e-6), ("thetad", 1e-5)];
/// Intensity of what the equations of vx, vy (m/s per √s) and w (rad/s per √s) leave out, and the share of it that rounded friction
/// does on a plant that has the same equations.
const UNMODELED: [f64; 3] = [0.02, 0.02, 0.3];
const ROUNDED: f64 = 0.1;
/// The same for the states that are integrals or measured exactly.
const EXACT: f64 = 1e-5;
/// Standard deviations of where the object lies at the start (m, rad), and of its rates (m/s, rad/s).
const START: [f64; 6] = [1e-3, 1e-3, 5e-3, 1e-3, 1e-3, 1e-3];
/// Share of its value by which a parameter that was fitted may be off.
const UNCERTAIN: f64 = 0.03;
/// Intervals that the estimator looks back on.
const PAST: usize = 40;

/// Lets a loop see what a laboratory does: the pose from a camera, with noise, and the motion of the plate. A moving-horizon
/// estimator finds the rates, and corrects the parameters that are named; where none is, it takes the equations for those of the
/// plant.
///
/// # Errors
/// If the model is not one of the plate.
pub(super) fn measured(
    problem: &mut ControlProblem,
    adjusted: &[String],
    settings: &RecordingSettings,
    seed: u64,
) -> Result<(), MpcError> {
    let pose = [settings.position_noise, settings.position_noise, settings.angle_noise];
    let names = problem.system.state_names();
    let mut estimation = EstimationProblem::new(&problem.system, problem.ocp.dt, &problem.x0);
    estimation.integrator = problem.ocp.integrator;
    estimation.substeps = problem.ocp.substeps;
    estimation.process_noise.fill(EXACT);
    let share = if adjusted.is_empty() { ROUNDED } else { 1.0 };
    estimation.process_noise[3..6].copy_from_slice(&UNMODELED.map(|v| share * v));
    estimation.initial_std[..6].copy_from_slice(&START);
    let camera = names.iter().zip(pose).map(|(name, std)| MeasuredOutput::new(name, std));
    estimation.outputs = camera.chain(ENCODERS.iter().map(|(name, std)| MeasuredOutput::new(*name, *std))).collect();
    for name in adjusted {
        let known = problem.system.parameters.iter().find(|p| problem.system.symbol_name(p.symbol) == name);
        let size = known.map_or(0.0, |p| p.value.to_f64().value().abs());
        if size > 0.0 {
            estimation.parameters.push(EstimatedParameter::new(name, UNCERTAIN * size));
        }
    }
    problem.conditions.noise = pose.iter().copied().chain([0.0; 4]).collect();
    problem.conditions.seed = seed;
    problem.conditions.delay = DELAY;
    problem.conditions.compensate_delay = true;
    problem.set_estimation(Estimation {
        kind: EstimatorKind::MovingHorizon,
        names: estimation.outputs.iter().map(|o| o.expression.clone()).collect(),
        problem: estimation,
        settings: MovingHorizonSettings { horizon: PAST, ..MovingHorizonSettings::default() },
    })
}

/// Quadratic programs of the plan and of the samples that had one.
pub(super) fn programs_of(run: &ControlRun) -> usize {
    let counts = &run.report.status;
    run.report.plan.as_ref().map_or(0, |p| p.programs) + counts.solved + counts.inaccurate + counts.infeasible
}
