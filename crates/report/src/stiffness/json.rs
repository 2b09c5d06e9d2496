//! The stiffness of robots as JSON: keys and values that other programs rely on.

use bracketry_stiffness::{
    CartesianEstimate, ChosenPoses, CompensatedLog, Expectation, FaultCount, Identification, Identified, LoopGain,
    LostMotion, SpringParameter, SpringResidual, Weighing,
};
use serde_json::{Value, json};

use super::text;

/// Interval of an entry of a compliance or a stiffness.
type Interval = fn(&CartesianEstimate, usize, usize) -> (f64, f64);

/// Six rows of six entries.
fn rows<T>(entry: impl Fn(usize, usize) -> T) -> [[T; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// An identification.
pub fn identification(found: &Identification) -> Value {
    let methods = found.methods.iter().map(|(method, figures)| {
        let known = figures.as_ref().ok();
        json!({
            "method": method.to_string(),
            "held_out": known.map(|f| f.held_out),
            "condition": known.map(|f| f.condition),
            "chi_square": known.map(|f| f.chi_square),
            "failed": figures.as_ref().err().map(ToString::to_string),
        })
    });
    let parameter = |p: &SpringParameter| {
        let value = match p.identified {
            Identified::Yes { value, low, high } => Some([value, low, high]),
            Identified::No { .. } => None,
        };
        json!({ "joint": p.joint, "name": p.name, "value": value, "why": p.identified.why() })
    };
    let pose = found.cartesian.as_ref();
    let interval = |of: Interval| pose.map(|pose| rows(|i, j| of(pose, i, j)));
    json!({
        "robot": found.robot,
        "measurements": found.measurements,
        "outliers": found.outliers,
        "outliers_kept": found.outliers_kept.as_ref().map(ToString::to_string),
        "trusted": found.trusted.to_string(),
        "reasons": found.advice.iter().map(text::advice).collect::<Vec<_>>(),
        "methods": methods.collect::<Vec<_>>(),
        "parameters": found.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "unexplained": found.residual.as_ref().map(residual),
        "compliance": pose.map(|pose| rows(|i, j| pose.compliance[(i, j)])),
        "compliance_interval": interval(CartesianEstimate::compliance_interval),
        "stiffness": pose.map(|pose| rows(|i, j| pose.stiffness[(i, j)])),
        "stiffness_interval": interval(CartesianEstimate::stiffness_interval),
        "withheld": found.withheld.as_ref().map(text::withheld),
    })
}

fn residual(found: &SpringResidual) -> Value {
    let lost = |l: &LostMotion| json!({ "joint": l.joint, "gap": l.gap, "engaged": l.engaged, "share": l.share });
    json!({
        "moved_rms_m": found.measured_rms,
        "left_rms_m": found.residual_rms,
        "noise_rms_m": found.noise_rms,
        "share": found.share,
        "worst_line": found.worst_line,
        "linear": found.linear,
        "lost_motion": found.lost_motion.iter().map(lost).collect::<Vec<_>>(),
        "with_lost_motion_rms_m": found.with_lost_motion_rms,
    })
}

/// A choice of measurements.
pub fn chosen_poses(found: &ChosenPoses) -> Value {
    let expectation = |of: &Expectation| json!({ "errors": of.errors, "condition": of.condition });
    let parameters = found.parameters.iter().map(|(joint, name)| format!("joint {joint} {name}"));
    json!({
        "robot": found.robot,
        "candidates": found.candidates,
        "lines": found.lines,
        "chosen": expectation(&found.chosen),
        "all": expectation(&found.all),
        "springs_known": found.springs_known,
        "parameters": parameters.collect::<Vec<_>>(),
    })
}

/// What a force sensor carries.
pub fn weighing(found: &Weighing) -> Value {
    let (estimate, payload) = (&found.estimate, &found.estimate.payload);
    json!({
        "robot": found.robot,
        "readings": found.readings,
        "mass": [payload.mass, estimate.mass_deviation],
        "centre": payload.center.as_slice(),
        "centre_deviation": estimate.center_deviation.as_slice(),
        "bias": payload.bias.as_slice(),
        "bias_deviation": estimate.bias_deviation.as_slice(),
        "residual": estimate.residual,
        "worst_line": found.worst_line,
    })
}

/// A compensation along a log.
pub fn compensated_log(run: &CompensatedLog) -> Value {
    let fault = |count: &FaultCount| json!({ "fault": text::fault(count.fault), "samples": count.samples });
    json!({
        "robot": run.robot,
        "samples": run.samples,
        "period_s": run.period,
        "displacement_rms_m": run.displacement_rms,
        "displacement_max_m": run.displacement_max,
        "force_max_n": run.force_max,
        "correction_max": run.correction_max,
        "limited": run.limited,
        "faults": run.faults.iter().map(fault).collect::<Vec<_>>(),
        "loop_gain": run.loop_gain.as_ref().map(loop_gain),
    })
}

fn loop_gain(found: &LoopGain) -> Value {
    json!({
        "process_stiffness": found.process_stiffness,
        "process": found.gains.process,
        "compensation": found.gains.compensation,
        "process_holds": found.gains.process_holds,
    })
}
