//! The stiffness of robots as JSON: keys and values that other programs rely on.

use bracketry_stiffness::{
    ChosenPoses, CompensatedLog, Expectation, Identification, Identified, LoopGain, SpringResidual, Weighing,
};
use serde::Serialize;

use super::text;

type Entries = [[f64; 6]; 6];
type Intervals = [[[f64; 2]; 6]; 6];

#[derive(Serialize)]
struct Method {
    method: String,
    held_out: Option<f64>,
    condition: Option<f64>,
    chi_square: Option<f64>,
    failed: Option<String>,
}

#[derive(Serialize)]
struct Parameter {
    joint: usize,
    name: &'static str,
    value: Option<[f64; 3]>,
    why: Option<String>,
}

#[derive(Serialize)]
struct LostMotion {
    joint: usize,
    gap: f64,
    engaged: f64,
    share: f64,
}

#[derive(Serialize)]
struct Unexplained {
    moved_rms_m: f64,
    left_rms_m: f64,
    noise_rms_m: f64,
    share: f64,
    worst_line: u64,
    linear: bool,
    lost_motion: Vec<LostMotion>,
    with_lost_motion_rms_m: Option<f64>,
}

impl From<&SpringResidual> for Unexplained {
    fn from(found: &SpringResidual) -> Self {
        let lost = found.lost_motion.iter();
        Self {
            moved_rms_m: found.measured_rms,
            left_rms_m: found.residual_rms,
            noise_rms_m: found.noise_rms,
            share: found.share,
            worst_line: found.worst_line,
            linear: found.linear,
            lost_motion: lost
                .map(|l| LostMotion { joint: l.joint, gap: l.gap, engaged: l.engaged, share: l.share })
                .collect(),
            with_lost_motion_rms_m: found.with_lost_motion_rms,
        }
    }
}

#[derive(Serialize)]
struct IdentificationObject<'a> {
    robot: &'a str,
    measurements: usize,
    outliers: &'a [u64],
    outliers_kept: Option<String>,
    trusted: String,
    reasons: Vec<String>,
    methods: Vec<Method>,
    parameters: Vec<Parameter>,
    unexplained: Option<Unexplained>,
    compliance: Option<Entries>,
    compliance_interval: Option<Intervals>,
    stiffness: Option<Entries>,
    stiffness_interval: Option<Intervals>,
    withheld: Option<String>,
}

/// Six rows of six entries.
fn rows<T>(entry: impl Fn(usize, usize) -> T) -> [[T; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// An identification.
pub fn identification(found: &Identification) -> impl Serialize + '_ {
    let methods = found.methods.iter().map(|(method, figures)| {
        let figures = figures.as_ref();
        Method {
            method: method.to_string(),
            held_out: figures.ok().map(|f| f.held_out),
            condition: figures.ok().map(|f| f.condition),
            chi_square: figures.ok().map(|f| f.chi_square),
            failed: figures.err().map(ToString::to_string),
        }
    });
    let parameters = found.parameters.iter().map(|p| {
        let value = match p.identified {
            Identified::Yes { value, low, high } => Some([value, low, high]),
            Identified::No { .. } => None,
        };
        Parameter { joint: p.joint, name: p.name, value, why: p.identified.why() }
    });
    let pose = found.cartesian.as_ref();
    IdentificationObject {
        robot: &found.robot,
        measurements: found.measurements,
        outliers: &found.outliers,
        outliers_kept: found.outliers_kept.as_ref().map(ToString::to_string),
        trusted: found.trusted.to_string(),
        reasons: found.advice.iter().map(text::advice).collect(),
        methods: methods.collect(),
        parameters: parameters.collect(),
        unexplained: found.residual.as_ref().map(Unexplained::from),
        compliance: pose.map(|pose| rows(|i, j| pose.compliance[(i, j)])),
        compliance_interval: pose.map(|pose| rows(|i, j| pose.compliance_interval(i, j).into())),
        stiffness: pose.map(|pose| rows(|i, j| pose.stiffness[(i, j)])),
        stiffness_interval: pose.map(|pose| rows(|i, j| pose.stiffness_interval(i, j).into())),
        withheld: found.withheld.as_ref().map(text::withheld),
    }
}

#[derive(Serialize)]
struct ExpectationObject<'a> {
    errors: &'a [Option<f64>],
    condition: Option<f64>,
}

impl<'a> From<&'a Expectation> for ExpectationObject<'a> {
    fn from(expected: &'a Expectation) -> Self {
        Self { errors: &expected.errors, condition: expected.condition }
    }
}

#[derive(Serialize)]
struct ChosenPosesObject<'a> {
    robot: &'a str,
    candidates: usize,
    lines: &'a [u64],
    chosen: ExpectationObject<'a>,
    all: ExpectationObject<'a>,
    springs_known: bool,
    parameters: Vec<String>,
}

/// A choice of measurements.
pub fn chosen_poses(found: &ChosenPoses) -> impl Serialize + '_ {
    ChosenPosesObject {
        robot: &found.robot,
        candidates: found.candidates,
        lines: &found.lines,
        chosen: (&found.chosen).into(),
        all: (&found.all).into(),
        springs_known: found.springs_known,
        parameters: found.parameters.iter().map(|(joint, name)| format!("joint {joint} {name}")).collect(),
    }
}

#[derive(Serialize)]
struct WeighingObject<'a> {
    robot: &'a str,
    readings: usize,
    mass: [f64; 2],
    centre: [f64; 3],
    centre_deviation: [f64; 3],
    bias: [f64; 6],
    bias_deviation: [f64; 6],
    residual: [f64; 2],
    worst_line: u64,
}

/// What a force sensor carries.
pub fn weighing(found: &Weighing) -> impl Serialize + '_ {
    let (estimate, payload) = (&found.estimate, &found.estimate.payload);
    WeighingObject {
        robot: &found.robot,
        readings: found.readings,
        mass: [payload.mass, estimate.mass_deviation],
        centre: payload.centre.into(),
        centre_deviation: estimate.centre_deviation.into(),
        bias: payload.bias.into(),
        bias_deviation: estimate.bias_deviation.into(),
        residual: estimate.residual,
        worst_line: found.worst_line,
    }
}

#[derive(Serialize)]
struct FaultCount {
    fault: String,
    samples: usize,
}

#[derive(Serialize)]
struct LoopGainObject {
    process_stiffness: [f64; 3],
    process: f64,
    compensation: f64,
    process_holds: bool,
}

impl From<&LoopGain> for LoopGainObject {
    fn from(found: &LoopGain) -> Self {
        let bracketry_stiffness::Stability { process, compensation, process_holds } = found.gains;
        Self { process_stiffness: found.process_stiffness, process, compensation, process_holds }
    }
}

#[derive(Serialize)]
struct CompensatedLogObject<'a> {
    robot: &'a str,
    samples: usize,
    period_s: f64,
    displacement_rms_m: f64,
    displacement_max_m: f64,
    force_max_n: f64,
    correction_max: &'a [f64],
    limited: usize,
    faults: Vec<FaultCount>,
    loop_gain: Option<LoopGainObject>,
}

/// A compensation along a log.
pub fn compensated_log(run: &CompensatedLog) -> impl Serialize + '_ {
    let faults = run.faults.iter();
    CompensatedLogObject {
        robot: &run.robot,
        samples: run.samples,
        period_s: run.period,
        displacement_rms_m: run.displacement_rms,
        displacement_max_m: run.displacement_max,
        force_max_n: run.force_max,
        correction_max: &run.correction_max,
        limited: run.limited,
        faults: faults.map(|f| FaultCount { fault: text::fault(f.fault), samples: f.samples }).collect(),
        loop_gain: run.loop_gain.as_ref().map(LoopGainObject::from),
    }
}
