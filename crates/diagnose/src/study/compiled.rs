//! A model with effects, compiled once for all values of its unknowns.

use super::tracked::TrackedPoint;
use super::unknown::Unknown;
use crate::effect::{Change, Effect, HiddenState, Path};
use crate::effort::Counter;
use crate::error::DiagnoseError;
use crate::library::{TIME_INPUT, apply_all, input_index, unknown};
use crate::record::Record;
use crate::settings::StudySettings;
use crate::signal::Signal;
use bracketry_sim::{Hold, Inputs, Model, Samples};
use bracketry_symbolic::StopFlag;
use bracketry_system::System;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// What an unknown acts on.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Target {
    /// The equations, as a live number of the model.
    Equations,
    /// Signal paths of inputs, by index.
    Input(Path, Vec<usize>),
    /// Signal paths of measured columns, by name.
    Column(Path, Vec<String>),
    /// A tracked point off the center of mass: the coordinate with this number.
    Tracked(TrackedPoint, usize),
}

/// A model with effects whose unknowns are live numbers.
pub(super) struct Compiled {
    /// One per record; they differ in how inputs are held.
    pub(super) models: Vec<Model>,
    pub(super) unknowns: Vec<Unknown>,
    pub(super) targets: Vec<Target>,
    /// Inputs and derivatives of inputs that samples drive: name, order, index of the input, place in the record.
    pub(super) driven: Vec<Driven>,
    /// States that effects add to those of the model.
    pub(super) hidden: Vec<HiddenState>,
    /// Whether the models have derivatives by states and by the unknowns of the equations.
    pub(super) differentiable: bool,
    /// That of the model's pool.
    pub(super) stop: StopFlag,
    /// That of the study.
    pub(super) counter: Counter,
    /// Those of the study.
    pub(super) settings: StudySettings,
}

/// An input, or a derivative of one, that a record's samples drive.
pub(super) struct Driven {
    pub(super) name: String,
    pub(super) order: u32,
    pub(super) input: usize,
    /// Place in [`Record::inputs`] (order 0) or in [`Record::input_derivatives`].
    place: usize,
    /// Where the records lack it: one signal per record.
    derived: Option<Signals>,
}

impl Driven {
    /// Its samples in a record.
    pub(super) fn signal<'a>(&'a self, record: usize, records: &'a [Record]) -> &'a Signal {
        match &self.derived {
            Some(signals) => &signals[record],
            None if self.order == 0 => &records[record].inputs[self.place],
            None => &records[record].input_derivatives[self.place],
        }
    }
}

/// One signal per record.
type Signals = Arc<Vec<Signal>>;

/// Records, with derivatives of inputs that an effect may ask for beyond those that the model uses: made once, when asked for.
pub(super) struct Sources {
    pub(super) records: Vec<Record>,
    /// Counts what is done with them.
    pub(super) counter: Counter,
    /// By input and order; none for an order that cannot be had.
    derived: Mutex<BTreeMap<(usize, u32), Option<Signals>>>,
}

impl Sources {
    pub(super) fn new(records: &[Record], counter: &Counter) -> Self {
        Self { records: records.to_vec(), counter: counter.clone(), derived: Mutex::default() }
    }

    /// A derivative of an input, for all records.
    fn derivative(&self, input: usize, order: u32) -> Option<Signals> {
        let mut derived = self.derived.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let entry = derived.entry((input, order)).or_insert_with(|| {
            let all: Option<Vec<Signal>> = self.records.iter().map(|r| r.differentiated_input(input, order)).collect();
            all.map(Arc::new)
        });
        entry.clone()
    }
}

impl Compiled {
    /// Compiles `system` with `effects`; `parameters` (indices) become unknowns, then the coefficients of the effects.
    pub(super) fn new(
        system: &System,
        sources: &Sources,
        parameters: &[usize],
        effects: &[Effect],
        settings: &StudySettings,
    ) -> Result<Self, DiagnoseError> {
        Self::with_derivatives(system, sources, parameters, effects, None, settings)
    }

    /// As [`Compiled::new`], with derivatives by the named unknowns alone.
    pub(super) fn with_derivatives(
        system: &System,
        sources: &Sources,
        parameters: &[usize],
        effects: &[Effect],
        by: Option<&[String]>,
        settings: &StudySettings,
    ) -> Result<Self, DiagnoseError> {
        let stop = system.pool.stop_flag().clone();
        if stop.is_raised() {
            return Err(DiagnoseError::Stopped);
        }
        let records = &sources.records;
        let mut changed = system.clone();
        let mut unknowns: Vec<Unknown> =
            parameters.iter().map(|&i| Unknown::parameter(system, &system.parameters[i], &settings.priors)).collect();
        let mut targets = vec![Target::Equations; unknowns.len()];
        apply_all(effects, &mut changed)?;
        for effect in effects {
            for (number, c) in effect.coefficients.iter().enumerate() {
                unknowns.push(Unknown::coefficient(c, &settings.priors));
                targets.push(target(system, records, effect, number)?);
            }
        }
        let driven = driven(system, &changed, sources)?;
        let mut models: Vec<Model> = Vec::with_capacity(records.len());
        let holds = |index: usize| -> Vec<Hold> { driven.iter().map(|d| d.signal(index, records).hold).collect() };
        for index in 0..records.len() {
            let same = (0..index).find(|&i| holds(i) == holds(index));
            let model = match same {
                Some(i) => models[i].clone(),
                None => compile(&changed, &holds(index), (&unknowns, &targets), &driven, by)?,
            };
            models.push(model);
        }
        let counter = sources.counter.clone();
        let (differentiable, settings) = (by.is_none(), settings.clone());
        let hidden = effects.iter().flat_map(|e| e.hidden().iter().cloned()).collect();
        Ok(Self { models, unknowns, targets, driven, hidden, differentiable, stop, counter, settings })
    }
}

/// What the coefficient of an effect with this number acts on.
fn target(system: &System, records: &[Record], effect: &Effect, number: usize) -> Result<Target, DiagnoseError> {
    if let Some(point) = TrackedPoint::new(system, &effect.change)? {
        return Ok(Target::Tracked(point, number));
    }
    let Change::Path { path, signals } = &effect.change else {
        return Ok(Target::Equations);
    };
    match path {
        Path::InputDelay | Path::ActuatorLag => {
            let inputs = signals.iter().map(|name| input_index(system, name));
            Ok(Target::Input(*path, inputs.collect::<Result<_, _>>()?))
        }
        Path::SensorDelay | Path::SensorLag | Path::DigitalFilter | Path::SensorBias | Path::SensorDrift => {
            let known: Vec<String> = records.iter().flat_map(|r| &r.measured).map(|m| m.name.clone()).collect();
            match signals.iter().find(|s| !known.contains(s)) {
                Some(name) => Err(unknown("measured column", name, &known)),
                None => Ok(Target::Column(*path, signals.clone())),
            }
        }
    }
}

fn driven(system: &System, changed: &System, sources: &Sources) -> Result<Vec<Driven>, DiagnoseError> {
    let names = system.input_names();
    let mut driven: Vec<Driven> = names
        .iter()
        .enumerate()
        .map(|(i, name)| Driven { name: name.clone(), order: 0, input: i, place: i, derived: None })
        .collect();
    for (place, d) in changed.input_derivatives.iter().enumerate() {
        let name = changed.pool.name(changed.inputs[d.input]).to_owned();
        let derived = if place < system.input_derivatives.len() {
            None
        } else {
            let missing = || bracketry_sim::InputError::MissingDerivative { input: name.clone(), order: d.order };
            Some(sources.derivative(d.input, d.order).ok_or_else(missing)?)
        };
        driven.push(Driven { name, order: d.order, input: d.input, place, derived });
    }
    Ok(driven)
}

fn compile(
    changed: &System,
    holds: &[Hold],
    (unknowns, targets): (&[Unknown], &[Target]),
    driven: &[Driven],
    by: Option<&[String]>,
) -> Result<Model, DiagnoseError> {
    let mut inputs = Inputs::new();
    for (d, hold) in driven.iter().zip(holds) {
        let placeholder = Samples::new(vec![0.0], vec![0.0], *hold)?;
        inputs = if d.order == 0 {
            inputs.samples(&d.name, placeholder)
        } else {
            inputs.derivative(&d.name, d.order, placeholder)
        };
    }
    let given = driven.iter().filter(|d| d.order == 0).count();
    if changed.inputs.len() > given {
        inputs = inputs.expression(TIME_INPUT, "t");
    }
    let mut live = Vec::new();
    for (unknown, target) in unknowns.iter().zip(targets) {
        if *target == Target::Equations {
            inputs = inputs.live(&unknown.name, unknown.start);
            live.push(unknown.name.clone());
        }
    }
    Ok(match by {
        Some(names) => Model::with_influences(changed, &inputs, names)?,
        None => Model::differentiable(changed, &inputs, &live)?,
    })
}

impl Compiled {
    /// A step for finite differences in an unknown. Times (delays and lags) move by a fraction of the sampling time.
    pub(super) fn step(&self, unknown: usize, sampling: f64) -> f64 {
        match &self.targets[unknown] {
            Target::Input(..) | Target::Column(Path::SensorDelay | Path::SensorLag | Path::DigitalFilter, _) => {
                self.settings.solver.time_step * sampling
            }
            _ => self.settings.solver.difference_step * self.unknowns[unknown].scale,
        }
    }
}
