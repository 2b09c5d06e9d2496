//! The parametrization of states and inputs by flat outputs and their derivatives.

use bracketry_symbolic::{Expr, Symbol};
use bracketry_system::{Point, System};

use crate::algebra::field::VectorFields;
use crate::algebra::matrix::generic_rank;
use crate::feedback::extension::DynamicExtension;
use crate::feedback::flatness::Known;
use crate::feedback::flatness_report::extension_of_outputs;
use crate::feedback::outputs::{fed_through, named_functions};
use crate::feedback::relative_degree::RelativeDegree;
use crate::forms::change::Plan;
use crate::forms::frame::Frame;
use crate::forms::normal_form::{BlockKind, FormNote, NormalForm, Part, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};

/// Flat outputs with the system, extended by integrators where needed, that they linearize.
struct FlatOutputs {
    degrees: RelativeDegree,
    extension: Option<DynamicExtension>,
}

impl Frame {
    /// `x = A(y, y', …)`, `u = B(y, y', …)` (Fliess, Lévine, Martin, and Rouchon 1995): a system of chains of integrators whose
    /// states are the flat outputs with their derivatives and whose outputs are the old states and inputs.
    pub(crate) fn flat(&mut self) -> Result<NormalForm, Stop> {
        self.without_delays()?;
        let m = self.fields.controls.len();
        if m == 0 {
            return Err(Stop::No(Obstacle::NoInputs));
        }
        let pool = &mut self.system.pool;
        let rank = generic_rank(pool, &self.fields.controls, &self.fields.bindings, &mut self.evidence)?;
        if rank < m {
            return Err(Stop::Unknown(Obstacle::DependentInputs { inputs: m, rank }));
        }
        let found = self.flat_outputs()?;
        let mut extended = self.extended(&found);
        let form = extended.parametrized(&found.degrees);
        self.evidence = extended.evidence;
        let mut form = form?;
        if found.extension.is_some() {
            form.parts.push(Part { kind: PartKind::Extended, system: extended.system });
            form.notes.push(FormNote::Extended);
        }
        Ok(form)
    }

    fn flat_outputs(&mut self) -> Result<FlatOutputs, Stop> {
        let fields = self.fields.clone();
        let (pool, evidence) = (&mut self.system.pool, &mut self.evidence);
        let flag = fields.linearization_flag(pool, evidence)?;
        let strong = fields.strong_accessibility(pool, evidence)?.dimension();
        let mut functions = self.output_functions();
        let chosen = if fed_through(&self.system) { 0 } else { functions.len() };
        functions.truncate(chosen);
        for h in named_functions(&self.system) {
            if !functions.contains(&h) {
                functions.push(h);
            }
        }
        let first = self.system.pool.made();
        let all = self.outputs.len() == self.system.outputs.len();
        let square = all && chosen == fields.controls.len();
        let extension = if square && !flag.linearizable() {
            extension_of_outputs(&mut self.system, &fields, first, &mut self.evidence)
        } else {
            None
        };
        let inputs = self.system.inputs.clone();
        let known = Known {
            inputs: &inputs,
            functions: &functions,
            outputs: chosen,
            strong_dimension: Some(strong),
            flag: &flag,
            extension: extension.as_ref(),
        };
        let pool = &mut self.system.pool;
        let found = fields.flatness(pool, &known, &mut self.evidence)?;
        match found.flat {
            Some(false) => return Err(Stop::No(Obstacle::NotFlat { reason: found.reason })),
            None => return Err(Stop::Unknown(Obstacle::FlatnessOpen { reason: found.reason })),
            Some(true) if found.outputs.is_empty() => {
                return Err(Stop::Unknown(Obstacle::NoFlatOutputs { reason: found.reason }));
            }
            Some(true) => {}
        }
        if let Some(extension) = found.extension {
            return Ok(FlatOutputs { degrees: extension.degrees.clone(), extension: Some(extension) });
        }
        let degrees = fields.relative_degree(pool, &found.outputs, &mut self.evidence)?;
        if !degrees.is_vector() || degrees.total() != Some(fields.states.len()) {
            return Err(Stop::Unknown(Obstacle::NoFlatOutputs { reason: found.reason }));
        }
        Ok(FlatOutputs { degrees, extension: None })
    }

    /// The system with its integrators; its outputs are the states and inputs of the given one.
    fn extended(&mut self, found: &FlatOutputs) -> Frame {
        let mut system = self.system.clone();
        let pool = &mut system.pool;
        let (states, inputs) = (self.fields.states.clone(), self.system.inputs.clone());
        let given: Vec<Expr> = match &found.extension {
            Some(extension) => extension.inputs.clone(),
            None => inputs.iter().map(|&u| pool.sym(u)).collect(),
        };
        let names = states.iter().chain(&inputs);
        let values: Vec<Expr> = states.iter().map(|&s| pool.sym(s)).chain(given).collect();
        system.outputs = names.map(|&s| pool.name(s).to_owned()).zip(values).collect();
        let fields = match &found.extension {
            None => self.fields.clone(),
            Some(extension) => {
                extend(&mut system, extension);
                extension.fields.clone()
            }
        };
        let outputs = (0..system.outputs.len()).collect();
        Frame { system, fields, outputs, evidence: std::mem::take(&mut self.evidence) }
    }

    fn parametrized(&mut self, degrees: &RelativeDegree) -> Result<NormalForm, Stop> {
        let (n, m) = (self.fields.states.len(), self.fields.controls.len());
        let new = self.derivative_symbols(degrees);
        let v = self.fresh("v", m);
        let feedback = self.decoupling_feedback(degrees, v)?;
        let known = self.chains(degrees, &new, &feedback.new);
        let singular = degrees.singular_factors(&mut self.system.pool, &self.fields);
        let mut next = 0;
        let blocks = degrees.derivatives.iter().map(|list| {
            next += list.len();
            (BlockKind::FlatOutput, (next - list.len()..next).collect())
        });
        let plan = Plan {
            blocks: blocks.collect(),
            coordinates: degrees.derivatives.concat(),
            new,
            feedback: Some(feedback),
            known: known.into_iter().map(Some).collect(),
            inverse: None,
            regular: Some(degrees.decoupling.clone()),
            singular,
            keep_names: false,
            suffix: "flat",
            notes: Vec::new(),
        };
        let form = self.change(plan)?.form;
        debug_assert_eq!(form.system.states.len(), n);
        if form.inverse.is_none() {
            let coordinates = form.coordinates.0.into_iter().map(|(_, t)| t).collect();
            return Err(Stop::Unknown(Obstacle::NoInverse { coordinates }));
        }
        Ok(form)
    }

    /// y1, y1_d1, y1_d2, …, y2, …
    fn derivative_symbols(&mut self, degrees: &RelativeDegree) -> Vec<Symbol> {
        let pool = &mut self.system.pool;
        let mut prefix = "y".to_owned();
        let taken =
            |pool: &bracketry_symbolic::Pool, prefix: &str| {
                degrees.derivatives.iter().enumerate().any(|(i, list)| {
                    (0..list.len()).any(|k| pool.find_symbol(&derivative_name(prefix, i, k)).is_some())
                })
            };
        while taken(pool, &prefix) {
            prefix.push('_');
        }
        let mut list = Vec::new();
        for (i, derivatives) in degrees.derivatives.iter().enumerate() {
            for k in 0..derivatives.len() {
                list.push(pool.symbol(&derivative_name(&prefix, i, k)));
            }
        }
        list
    }
}

fn derivative_name(prefix: &str, i: usize, k: usize) -> String {
    if k == 0 { format!("{prefix}{}", i + 1) } else { format!("{prefix}{}_d{k}", i + 1) }
}

/// Makes the integrators states of the system.
fn extend(system: &mut System, extension: &DynamicExtension) {
    let VectorFields { states, drift, controls, .. } = &extension.fields;
    let pool = &mut system.pool;
    let mut dynamics = drift.clone();
    for (g, &u) in controls.iter().zip(&extension.new_inputs) {
        let u = pool.sym(u);
        for (rate, &g) in dynamics.iter_mut().zip(g) {
            let term = pool.mul(g, u);
            *rate = pool.add(*rate, term);
        }
    }
    let zero = pool.int(0);
    // An integrator that carries the name of an input starts at its value, any other at zero.
    let start = |s: &Symbol| system.inputs.iter().position(|u| u == s);
    system.point = system.point.as_ref().map(|p| {
        let added = extension.added.iter().map(|(s, _)| start(s).map_or(zero, |k| p.inputs[k]));
        Point {
            states: p.states.iter().copied().chain(added).collect(),
            inputs: vec![zero; extension.new_inputs.len()],
        }
    });
    system.name = format!("{}_extended", system.name);
    system.states.clone_from(states);
    system.dynamics = dynamics;
    system.inputs.clone_from(&extension.new_inputs);
    system.input_ranges.clear();
}
