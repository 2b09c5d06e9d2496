//! The parts of the report that are about control: outputs, linearization, flatness.

use bracketry_symbolic::{Expr, Function, Named};
use bracketry_system::System;
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::condition::Condition;
use crate::evidence::Evidence;
use crate::feedback::flatness_report::{
    ExtensionReport, FlatnessReport, extension_of_outputs, extension_report, flatness_report,
};
use crate::feedback::input_output::{InputOutputReport, input_output};
use crate::feedback::outputs::{fed_through, fresh_symbols, named_functions};
use crate::feedback::relative_degree::RelativeDegree;
use crate::feedback::static_linearization::LinearizationFlag;
use crate::reason::Reason;
use crate::undecided::Undecided;

/// What feedback can do with the system; every part is absent where it does not apply.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ControlReport {
    /// Relative degrees and zero dynamics; absent without inputs or outputs, or if an output depends on an input directly.
    #[serde(flatten)]
    pub input_output: Option<InputOutputReport>,
    /// Linearization by static feedback.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedback_linearization: Option<LinearizationReport>,
    /// Integrators that give the outputs of the model a vector relative degree; absent where they
    /// have one already or never get one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic_extension: Option<ExtensionReport>,
    /// Differential flatness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flatness: Option<FlatnessReport>,
}

/// The distributions `D_i = span{ad_f^k g_j, k ≤ i}` and, for a linearizable system, its linear form.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LinearizationReport {
    /// dim D_0, dim D_1, … until the dimension is full or repeats.
    pub dims: Vec<usize>,
    /// Whether D_i is involutive; the list may end after the first that is not.
    pub involutive: Vec<bool>,
    /// Lengths of the chains of integrators, for a linearizable system.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub controllability_indices: Vec<usize>,
    /// Functions whose relative degrees are the controllability indices, if they were found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub linearizing_outputs: Vec<Function>,
    /// The linearizing coordinates: each output with its derivatives.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coordinates: Vec<Vec<Function>>,
    /// The feedback that makes the last derivatives equal to the new inputs v1, v2, …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feedback: Option<Named<Function>>,
    /// Where this feedback is not defined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular_set: Option<Condition>,
    /// Why something is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Reason>,
}

/// Relative degrees, linearization and flatness of a smooth system with the given fields.
pub(crate) fn control_report(
    system: &mut System,
    fields: &VectorFields,
    flag: &Result<LinearizationFlag, Undecided>,
    strong_dimension: Option<usize>,
    (first, examine_flatness): (usize, bool),
    evidence: &mut Evidence,
) -> (ControlReport, Option<RelativeDegree>) {
    if fields.controls.is_empty() {
        return (ControlReport::default(), None);
    }
    let references = fresh_symbols(&mut system.pool, "v", fields.controls.len());
    let (input_output, degree) = if system.outputs.is_empty() || fed_through(system) {
        (None, None)
    } else {
        let (report, degree) = input_output(system, fields, &references, first, evidence);
        (Some(report), degree)
    };
    let feedback_linearization =
        flag.as_ref().ok().map(|flag| linearization(system, fields, flag, &references, evidence));
    let extension = match &degree {
        Some(d) if !d.is_vector() && d.degrees.len() == fields.controls.len() => {
            extension_of_outputs(system, fields, first, evidence)
        }
        _ => None,
    };
    let dynamic_extension = extension.as_ref().map(|e| extension_report(system, e));
    let flatness = examine_flatness
        .then(|| flatness_report(system, fields, flag, strong_dimension, extension.as_ref(), first, evidence));
    (ControlReport { input_output, feedback_linearization, dynamic_extension, flatness }, degree)
}

fn linearization(
    system: &mut System,
    fields: &VectorFields,
    flag: &LinearizationFlag,
    references: &[Expr],
    evidence: &mut Evidence,
) -> LinearizationReport {
    let (dims, involutive) = (flag.dims.clone(), flag.involutive.clone());
    let mut report = LinearizationReport { dims, involutive, ..LinearizationReport::default() };
    if !flag.linearizable() {
        return report;
    }
    report.controllability_indices = flag.controllability_indices();
    let preferred = named_functions(system);
    let pool = &mut system.pool;
    let functions = match fields.linearizing_functions(pool, flag, &preferred, evidence) {
        Ok(Some(functions)) => functions,
        Ok(None) => {
            report.reason = Some(Reason::NoLinearizingOutputs);
            return report;
        }
        Err(why) => {
            report.reason = Some(why.into());
            return report;
        }
    };
    report.linearizing_outputs = Function::list(pool, &functions);
    // Coordinates and feedback are left out where the derivatives grow too large.
    match fields.relative_degree(pool, &functions, evidence) {
        Ok(degrees) => {
            report.coordinates = degrees.derivatives.iter().map(|list| Function::list(pool, list)).collect();
            report.feedback = degrees.named_feedback(pool, &system.inputs, references);
            report.singular_set = degrees.singular_set(pool, fields);
        }
        Err(why) => report.reason = Some(why.into()),
    }
    report
}
