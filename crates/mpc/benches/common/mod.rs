//! What the benchmarks of closed loops share.

use bracketry_mpc::controller::Step;
use bracketry_mpc::{ControlProblem, Controller, Plant};

/// One closed loop from the state of the problem: its samples and its sum of squared inputs.
pub(crate) fn closed_loop(
    problem: &ControlProblem,
    controller: &mut dyn Controller,
    plant: &mut dyn Plant,
) -> (Vec<Step>, f64) {
    let (mut x, mut steps, mut effort) = (problem.x0.clone(), Vec::new(), 0.0);
    for k in 0..problem.samples {
        controller.prepare().expect("settings within their ranges");
        let step = controller.feedback(&x).expect("a state of the right length").clone();
        controller.shift();
        plant.step(k as f64 * problem.ocp.dt, &mut x, &step.u, problem.ocp.dt).expect("a smooth plant");
        effort += step.u.iter().map(|u| u * u).sum::<f64>();
        steps.push(step);
    }
    (steps, effort)
}

/// Median over the samples but the first, which may have to build what later ones only update.
pub(crate) fn median(steps: &[Step], of: impl Fn(&Step) -> f64) -> f64 {
    let mut values: Vec<f64> = steps.iter().skip(1).map(of).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
