//! What the inputs do to the outputs: the part of the report on relative degrees and zero dynamics.

use bracketry_symbolic::{Expr, Function, Named};
use bracketry_system::System;
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::algebra::rational::readable::tidy;
use crate::answer::Answer;
use crate::budget::check_analysis;
use crate::condition::Condition;
use crate::evidence::Evidence;
use crate::feedback::minimum_phase::MinimumPhase;
use crate::feedback::relative_degree::RelativeDegree;
use crate::feedback::zero_dynamics::ZeroDynamics;
use crate::reason::{MinimumPhaseReason, NoZeroDynamics, Reason};

/// Relative degrees of the outputs, at a generic point, and what follows from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InputOutputReport {
    /// Per output the smallest r with some `L_gj L_f^(r−1) h ≠ 0`; null where no input reaches the output.
    pub relative_degree: Answer<Vec<Option<usize>>>,
    /// Why the relative degree is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_degree_reason: Option<Reason>,
    /// `L_gj L_f^(r_i−1) h_i`, one row per output.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub decoupling_matrix: Vec<Vec<Function>>,
    /// Its generic rank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decoupling_rank: Option<usize>,
    /// Its determinant; absent unless there are as many outputs as inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decoupling_determinant: Option<Function>,
    /// Whether the decoupling matrix has full row rank at a generic point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vector_relative_degree: Option<bool>,
    /// Where the determinant vanishes; absent for a determinant that is zero everywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular_set: Option<Condition>,
    /// The inputs that make the r-th derivatives of the outputs equal to v1, v2, …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decoupling_feedback: Option<Named<Function>>,
    /// The motion left while the outputs are held.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zero_dynamics: Option<Answer<ZeroDynamicsReport>>,
    /// Why there are no zero dynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zero_dynamics_reason: Option<Reason>,
    /// Names of the outputs.
    #[serde(skip)]
    pub outputs: Vec<String>,
}

/// Real and imaginary part of an eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Eigenvalue {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

/// The motion left while inputs hold the outputs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZeroDynamicsReport {
    /// Coordinates.
    pub states: Vec<String>,
    /// How many they are.
    pub dimension: usize,
    /// Time derivative of each coordinate.
    pub equations: Vec<Function>,
    /// The other states.
    pub on: Named<Function>,
    /// The inputs that hold the outputs; one that stays free is absent.
    pub inputs: Named<Function>,
    /// Outputs that are held at another value than zero: theirs at the point of the model or, without a
    /// point and where zero is no value that they can keep, any constant.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub held_at: Named<Function>,
    /// Where the equations hold, such as `cos(q2) ≠ 0`; absent if everywhere.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub valid: Option<Condition>,
    /// Eigenvalues of the linearization at the equilibrium.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub eigenvalues: Vec<Eigenvalue>,
    /// Whether the equilibrium of the zero dynamics at the point of the model (at zero if it gives none) is asymptotically stable.
    pub minimum_phase: Answer<bool>,
    /// What that rests on, or why it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub minimum_phase_reason: Option<MinimumPhaseReason>,
}

/// The report for the outputs of `system`, whose smooth fields are `fields`, with `references` as the
/// names of new inputs; `first` is the size of the pool when the analysis began. With it the relative degree for questions at a point.
pub(crate) fn input_output(
    system: &mut System,
    fields: &VectorFields,
    references: &[Expr],
    first: usize,
    evidence: &mut Evidence,
) -> (InputOutputReport, Option<RelativeDegree>) {
    let names: Vec<String> = system.outputs.iter().map(|o| o.0.clone()).collect();
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let mut report = InputOutputReport { outputs: names, ..InputOutputReport::default() };
    let found =
        check_analysis(&system.pool, first).and_then(|()| fields.relative_degree(&mut system.pool, &outputs, evidence));
    let degree = match found {
        Ok(d) => d,
        Err(why) => {
            report.relative_degree_reason = Some(why.clone().into());
            report.relative_degree = Answer::Unknown(why.into());
            return (report, None);
        }
    };
    let pool = &mut system.pool;
    report.relative_degree = Answer::Known(degree.degrees.clone());
    report.decoupling_matrix = degree.decoupling.iter().map(|row| Function::list(pool, row)).collect();
    report.decoupling_rank = Some(degree.rank);
    report.vector_relative_degree = Some(degree.is_vector());
    if outputs.len() == fields.controls.len() {
        if degree.is_vector() {
            report.decoupling_determinant = degree.determinant(pool).map(|d| Function::new(pool, d));
            report.singular_set = degree.singular_set(pool, fields);
            report.decoupling_feedback = degree.named_feedback(pool, &system.inputs, references);
        } else {
            let zero = pool.int(0);
            report.decoupling_determinant = Some(Function::new(pool, zero));
        }
    }
    match zero_dynamics(system, fields, &degree, first, evidence) {
        Ok(z) => report.zero_dynamics = Some(Answer::Known(z)),
        Err(why) => {
            report.zero_dynamics_reason = Some(why.clone().into());
            report.zero_dynamics = Some(Answer::Unknown(why.into()));
        }
    }
    (report, Some(degree))
}

fn zero_dynamics(
    system: &mut System,
    fields: &VectorFields,
    degree: &RelativeDegree,
    first: usize,
    evidence: &mut Evidence,
) -> Result<ZeroDynamicsReport, NoZeroDynamics> {
    check_analysis(&system.pool, first)?;
    let pool = &mut system.pool;
    let zero = pool.int(0);
    let point = system.point.as_ref().map_or_else(|| vec![zero; fields.states.len()], |p| p.states.clone());
    let at: FxHashMap<Expr, Expr> = fields.states.iter().zip(&point).map(|(&s, &v)| (pool.sym(s), v)).collect();
    let inputs: Vec<Expr> = system.inputs.iter().map(|&u| pool.sym(u)).collect();
    let mut held_at = Vec::new();
    // With Σ r_i = n the outputs and their derivatives are coordinates: nothing moves while they are held.
    let found = if degree.is_vector() && degree.total() == Some(fields.states.len()) {
        ZeroDynamics {
            states: Vec::new(),
            equations: Vec::new(),
            solved: Vec::new(),
            inputs: Vec::new(),
            nonzero: Vec::new(),
        }
    } else {
        let mut outputs = Vec::new();
        for (name, h) in &system.outputs {
            let mut h = *h;
            if system.point.is_some() {
                let value = pool.substitute(h, &at);
                let value = tidy(pool, value);
                if !fields.vanishes(pool, value, evidence)? {
                    held_at.push((name.clone(), Function::new(pool, value)));
                    h = pool.sub(h, value);
                }
            }
            outputs.push(h);
        }
        let found = fields.zero_dynamics(pool, &outputs, &inputs, &point, evidence);
        match found {
            Err(_) if system.point.is_none() => {
                // Zero may be a value that the outputs cannot keep: hold them at constants.
                let mut outputs = Vec::new();
                for (name, h) in &system.outputs {
                    let constant = pool.var(&format!("{name}_0"));
                    outputs.push(pool.sub(*h, constant));
                    held_at.push((name.clone(), Function::new(pool, constant)));
                }
                let constants = fields.zero_dynamics(pool, &outputs, &inputs, &point, evidence);
                if constants.is_err() {
                    held_at.clear();
                }
                constants.or(found)?
            }
            found => found?,
        }
    };
    let MinimumPhase { holds, reason, eigenvalues } = found.minimum_phase(pool, fields, &point, evidence);
    let states: Vec<String> = found.states.iter().map(|&s| pool.name(s).to_owned()).collect();
    let valid: Vec<Condition> = found.nonzero.iter().map(|&e| Condition::Differs(Function::new(pool, e))).collect();
    let held = system.inputs.iter().zip(&found.inputs);
    Ok(ZeroDynamicsReport {
        dimension: states.len(),
        equations: Function::list(pool, &found.equations),
        states,
        on: Named(found.solved.iter().map(|&(s, e)| (pool.name(s).to_owned(), Function::new(pool, e))).collect()),
        inputs: Named(held.filter_map(|(&u, e)| Some((pool.name(u).to_owned(), Function::new(pool, (*e)?)))).collect()),
        held_at: Named(held_at),
        valid: (!valid.is_empty()).then_some(Condition::All(valid)),
        eigenvalues: eigenvalues.into_iter().map(|(re, im)| Eigenvalue { re, im }).collect(),
        minimum_phase_reason: holds.reason().cloned().map(Into::into).or(reason),
        minimum_phase: holds,
    })
}
