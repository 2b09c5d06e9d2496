//! The parts of the report on dynamic extension and flatness.

use bracketry_symbolic::{Expr, Function, Named, Pool, Symbol};
use bracketry_system::System;
use serde::{Serialize, Serializer};

use crate::algebra::field::{VectorFields, is_plain_zero};
use crate::algebra::rational::readable::tidy;
use crate::budget::check_analysis;
use crate::condition::Condition;
use crate::evidence::Evidence;
use crate::feedback::extension::{DynamicExtension, ExtensionLimits};
use crate::feedback::flatness::{Flatness, Known, MAX_INTEGRATORS};
use crate::feedback::outputs::{fed_through, named_functions};
use crate::feedback::static_linearization::LinearizationFlag;
use crate::reason::FlatnessReason;
use crate::undecided::Undecided;

/// A dynamic feedback after which the outputs of the model have a vector relative degree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExtensionReport {
    /// Integrators in front of each input that got any.
    pub integrators: Named<usize>,
    /// Relative degrees of the outputs after that.
    pub relative_degree: Vec<usize>,
    /// Number of states after that.
    pub dimension: usize,
    /// The integrators: states with their time derivatives.
    #[serde(serialize_with = "rates")]
    pub compensator: Vec<(String, Function)>,
    /// The inputs after that.
    pub inputs: Vec<String>,
    /// Whether the relative degrees add up to the dimension: the outputs are flat.
    pub linearizes: bool,
}

/// Verdict on flatness near a generic point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FlatnessVerdict {
    /// Proven.
    Yes,
    /// Excluded.
    No,
    /// Neither.
    Unknown,
}

/// Whether all states and inputs are functions of some outputs and their derivatives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlatnessReport {
    /// The verdict.
    pub verdict: FlatnessVerdict,
    /// Flat outputs, if they were found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flat_outputs: Vec<Function>,
    /// Integrators in front of each input with which these outputs linearize the system; empty if
    /// none are needed, absent if that was not found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dynamic_extension: Option<Named<usize>>,
    /// Relative degrees of the flat outputs after that.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relative_degree: Vec<usize>,
    /// The integrators: states with their time derivatives.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "rates")]
    pub compensator: Vec<(String, Function)>,
    /// Where that is singular.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular_set: Option<Condition>,
    /// What the verdict rests on.
    pub reason: FlatnessReason,
}

impl FlatnessReport {
    pub(crate) fn without_outputs(verdict: FlatnessVerdict, reason: FlatnessReason) -> Self {
        FlatnessReport {
            verdict,
            flat_outputs: Vec::new(),
            dynamic_extension: None,
            relative_degree: Vec::new(),
            compensator: Vec::new(),
            singular_set: None,
            reason,
        }
    }
}

/// Most new nodes of the pool in the dynamic extension for the outputs of the model.
const MAX_NODES: usize = 30_000;

fn integrators(system: &System, inputs: &[Symbol], extension: &DynamicExtension) -> Named<usize> {
    let counts = inputs.iter().zip(&extension.integrators).filter(|x| *x.1 > 0);
    Named(counts.map(|(&u, &k)| (system.pool.name(u).to_owned(), k)).collect())
}

fn compensator(pool: &Pool, extension: &DynamicExtension) -> Vec<(String, Function)> {
    extension.added.iter().map(|&(s, e)| (pool.name(s).to_owned(), Function::new(pool, e))).collect()
}

fn degrees(extension: &DynamicExtension) -> Vec<usize> {
    extension.degrees.degrees.iter().flatten().copied().collect()
}

/// The dynamic extension algorithm for the outputs of the model, if they are as many as its
/// inputs and have no vector relative degree.
pub(crate) fn extension_of_outputs(
    system: &mut System,
    fields: &VectorFields,
    first: usize,
    evidence: &mut Evidence,
) -> Option<DynamicExtension> {
    check_analysis(&system.pool, first).ok()?;
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let inputs = system.inputs.clone();
    // Without drift two inputs need an integrator for every state but two, if these are flat outputs.
    let chain = fields.controls.len() == 2 && is_plain_zero(&system.pool, &fields.drift);
    if chain && fields.states.len() > MAX_INTEGRATORS + 2 {
        return None;
    }
    let limits = ExtensionLimits { integrators: MAX_INTEGRATORS.min(fields.states.len()), nodes: MAX_NODES };
    fields.dynamic_extension(&mut system.pool, &outputs, &inputs, limits, evidence).ok().flatten()
}

/// The same as a report.
pub(crate) fn extension_report(system: &System, extension: &DynamicExtension) -> ExtensionReport {
    let names = extension.new_inputs.iter().map(|&u| system.pool.name(u).to_owned()).collect();
    ExtensionReport {
        integrators: integrators(system, &system.inputs, extension),
        relative_degree: degrees(extension),
        dimension: extension.fields.states.len(),
        compensator: compensator(&system.pool, extension),
        inputs: names,
        linearizes: extension.linearizes(),
    }
}

/// Flatness of the system with the given fields, of which the dependent ones are left out.
pub(crate) fn flatness_report(
    system: &mut System,
    fields: &VectorFields,
    flag: &Result<LinearizationFlag, Undecided>,
    strong_dimension: Option<usize>,
    model_extension: Option<&DynamicExtension>,
    first: usize,
    evidence: &mut Evidence,
) -> FlatnessReport {
    let unknown = |reason| FlatnessReport::without_outputs(FlatnessVerdict::Unknown, reason);
    let functions = named_functions(system);
    let outputs = if fed_through(system) { 0 } else { system.outputs.len() };
    let pool = &mut system.pool;
    let linearizable = flag.as_ref().is_ok_and(LinearizationFlag::linearizable);
    // Where the system is linearizable, little is left to do.
    let room = if linearizable { Ok(()) } else { check_analysis(pool, first) };
    let found = room.and_then(|()| {
        let flag = flag.as_ref().map_err(Clone::clone)?;
        let rank = pool.rank(&fields.controls, &fields.bindings)?;
        evidence.add(&rank.certificate);
        let inputs: Vec<Symbol> = rank.independent.iter().map(|&i| system.inputs[i]).collect();
        let mut independent = fields.clone();
        independent.controls = rank.independent.iter().map(|&i| fields.controls[i].clone()).collect();
        let extension = model_extension;
        let known = Known { inputs: &inputs, functions: &functions, outputs, strong_dimension, flag, extension };
        Ok((independent.flatness(pool, &known, evidence)?, independent, inputs))
    });
    let (Flatness { flat, outputs, extension, reason }, fields, inputs) = match found {
        Ok(f) => f,
        Err(_) if linearizable => {
            return FlatnessReport::without_outputs(FlatnessVerdict::Yes, FlatnessReason::StaticFeedback);
        }
        Err(why) => return unknown(why.into()),
    };
    let mut report = unknown(reason);
    report.verdict = match flat {
        Some(true) => FlatnessVerdict::Yes,
        Some(false) => FlatnessVerdict::No,
        None => FlatnessVerdict::Unknown,
    };
    let pool = &mut system.pool;
    for &h in &outputs {
        let h = tidy(pool, h);
        report.flat_outputs.push(Function::new(pool, h));
    }
    if let Some(extension) = extension {
        report.dynamic_extension = Some(integrators(system, &inputs, &extension));
        report.relative_degree = degrees(&extension);
        report.compensator = compensator(&system.pool, &extension);
        report.singular_set = extension.degrees.singular_set(&mut system.pool, &extension.fields);
    } else if !outputs.is_empty()
        && let Ok(degree) = fields.relative_degree(&mut system.pool, &outputs, evidence)
        && degree.total() == Some(fields.states.len())
    {
        report.dynamic_extension = Some(Named(Vec::new()));
        report.relative_degree = degree.degrees.iter().flatten().copied().collect();
        report.singular_set = degree.singular_set(&mut system.pool, &fields);
    }
    report
}

/// Writes rates as equations, `u1' = u1d`.
fn rates<S: Serializer>(list: &[(String, Function)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(list.iter().map(|(state, rate)| format!("{state}' = {rate}")))
}
