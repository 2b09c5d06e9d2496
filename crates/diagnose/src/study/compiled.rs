//! A model with effects, compiled once for all values of its unknowns.

use super::unknown::Unknown;
use crate::effect::{Change, Effect, Path};
use crate::error::DiagnoseError;
use crate::library::TIME_INPUT;
use crate::record::Record;
use bracketry_sim::{Hold, Inputs, Model, Samples};
use bracketry_system::System;

/// What an unknown acts on.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Target {
    /// The equations, as a live number of the model.
    Equations,
    /// The way of inputs, by index.
    Input(Path, Vec<usize>),
    /// The way of measured columns, by name.
    Column(Path, Vec<String>),
}

/// A model with effects whose unknowns are live numbers.
pub(super) struct Compiled {
    /// One per record; they differ in how inputs are held.
    pub(super) models: Vec<Model>,
    pub(super) unknowns: Vec<Unknown>,
    pub(super) targets: Vec<Target>,
    /// Inputs and derivatives of inputs that samples drive: name, order, index of the input, place in the record.
    pub(super) driven: Vec<Driven>,
}

/// An input, or a derivative of one, that a record's samples drive.
pub(super) struct Driven {
    pub(super) name: String,
    pub(super) order: u32,
    pub(super) input: usize,
    /// Place in [`Record::inputs`] (order 0) or in [`Record::input_derivatives`].
    pub(super) place: usize,
}

impl Compiled {
    /// Compiles `system` with `effects`; `parameters` (indices) become unknowns, then the coefficients of the effects.
    pub(super) fn new(
        system: &System,
        records: &[Record],
        parameters: &[usize],
        effects: &[Effect],
    ) -> Result<Self, DiagnoseError> {
        let mut changed = system.clone();
        let mut unknowns: Vec<Unknown> =
            parameters.iter().map(|&i| Unknown::parameter(system, &system.parameters[i])).collect();
        let mut targets = vec![Target::Equations; unknowns.len()];
        for effect in effects {
            effect.apply(&mut changed)?;
            for c in &effect.coefficients {
                unknowns.push(Unknown::coefficient(c));
                targets.push(target(system, records, effect)?);
            }
        }
        let driven = driven(system, &changed, records)?;
        let mut models: Vec<Model> = Vec::with_capacity(records.len());
        for (index, record) in records.iter().enumerate() {
            let same = (0..index).find(|&i| same_holds(&records[i], record));
            let model = match same {
                Some(i) => models[i].clone(),
                None => compile(&changed, record, &unknowns, &targets, &driven)?,
            };
            models.push(model);
        }
        Ok(Self { models, unknowns, targets, driven })
    }
}

fn same_holds(a: &Record, b: &Record) -> bool {
    let holds = |r: &Record| -> Vec<Hold> { r.inputs.iter().chain(&r.input_derivatives).map(|s| s.hold).collect() };
    holds(a) == holds(b)
}

fn target(system: &System, records: &[Record], effect: &Effect) -> Result<Target, DiagnoseError> {
    let Change::Path { path, signals } = &effect.change else {
        return Ok(Target::Equations);
    };
    match path {
        Path::InputDelay | Path::ActuatorLag => {
            let index = |name: &String| {
                system.input_index(name).ok_or_else(|| DiagnoseError::UnknownName {
                    what: "input",
                    name: name.clone(),
                    known: system.input_names().join(", "),
                })
            };
            Ok(Target::Input(*path, signals.iter().map(index).collect::<Result<_, _>>()?))
        }
        Path::SensorDelay | Path::SensorBias => {
            let known: Vec<&str> = records.iter().flat_map(|r| &r.measured).map(|m| m.name.as_str()).collect();
            match signals.iter().find(|s| !known.contains(&s.as_str())) {
                Some(name) => Err(DiagnoseError::UnknownName {
                    what: "measured column",
                    name: name.clone(),
                    known: known.join(", "),
                }),
                None => Ok(Target::Column(*path, signals.clone())),
            }
        }
    }
}

fn driven(system: &System, changed: &System, records: &[Record]) -> Result<Vec<Driven>, DiagnoseError> {
    let names = system.input_names();
    let mut driven: Vec<Driven> =
        names.iter().enumerate().map(|(i, name)| Driven { name: name.clone(), order: 0, input: i, place: i }).collect();
    for (place, d) in changed.input_derivatives.iter().enumerate() {
        let name = changed.pool.name(changed.inputs[d.input]).to_owned();
        if records.iter().any(|r| place >= r.input_derivatives.len()) {
            return Err(bracketry_sim::InputError::MissingDerivative { input: name, order: d.order }.into());
        }
        driven.push(Driven { name, order: d.order, input: d.input, place });
    }
    Ok(driven)
}

fn compile(
    changed: &System,
    record: &Record,
    unknowns: &[Unknown],
    targets: &[Target],
    driven: &[Driven],
) -> Result<Model, DiagnoseError> {
    let mut inputs = Inputs::new();
    for d in driven {
        let signal = if d.order == 0 { &record.inputs[d.place] } else { &record.input_derivatives[d.place] };
        let placeholder = Samples::new(vec![0.0], vec![0.0], signal.hold)?;
        inputs = if d.order == 0 {
            inputs.samples(&d.name, placeholder)
        } else {
            inputs.derivative(&d.name, d.order, placeholder)
        };
    }
    if changed.inputs.len() > record.inputs.len() {
        inputs = inputs.expression(TIME_INPUT, "t");
    }
    for (unknown, target) in unknowns.iter().zip(targets) {
        if *target == Target::Equations {
            inputs = inputs.live(&unknown.name, unknown.start);
        }
    }
    Ok(Model::new(changed, &inputs)?)
}

impl Compiled {
    /// A step for finite differences in an unknown. Times (delays and lags) move by a fraction of the sampling time: what a held
    /// input does is linear in its delay within an interval.
    pub(super) fn step(&self, unknown: usize, sampling: f64) -> f64 {
        match &self.targets[unknown] {
            Target::Input(..) | Target::Column(Path::SensorDelay, _) => 0.05 * sampling,
            _ => 1e-4 * self.unknowns[unknown].scale,
        }
    }
}
