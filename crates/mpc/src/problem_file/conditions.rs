//! The run of a problem file: start, length, noise, delay, faults, and what is different in the plant.

use super::free_keys::is_free;
use super::horizon::MOST_PLANT_SUBSTEPS;
use super::reader::{Located, Parsed, Reader};
use crate::closed_loop::Fault;
use crate::ocp::Ocp;
use crate::problem::RunConditions;
use bracketry_symbolic::Rational;
use bracketry_system::{System, Table, Value};
use std::ops::Range;

const KEYS: [&str; 10] =
    ["x0", "u0", "steps", "plant_substeps", "parameters", "noise", "seed", "delay", "compensate_delay", "faults"];
const FAULT_KEYS: [&str; 7] = ["at", "until", "lost", "nan", "disturbance", "solver_limit", "time_limit"];

/// Start and length of a run.
pub(super) struct Start {
    pub(super) x0: Vec<f64>,
    pub(super) samples: usize,
    pub(super) plant_substeps: Option<usize>,
    /// Whether the file has them.
    pub(super) given: bool,
}

impl Reader<'_> {
    /// The table `[run]`, or `none` where there is no such table.
    pub(super) fn run<'t, 'i>(
        &self,
        table: &'t Table<'i>,
        none: &'t Table<'i>,
        steps: usize,
    ) -> Parsed<(&'t Table<'i>, Start)> {
        let given = self.doc.sub_table(table, "run")?;
        let run = given.unwrap_or(none);
        self.doc.only_keys(run, &KEYS, "[run]")?;
        let samples = self.count(run, "steps", Some(steps))?;
        let mut x0 = vec![0.0; self.system.states.len()];
        for (name, value) in self.doc.sub_table(run, "x0")?.into_iter().flatten() {
            let i = self.state(name.get_ref(), name.span())?;
            if !is_free(value) {
                x0[i] = self.constant(value, name.get_ref())?;
            }
        }
        let given = given.is_some();
        let plant_substeps = run
            .contains_key("plant_substeps")
            .then(|| self.substeps(run, "plant_substeps", MOST_PLANT_SUBSTEPS))
            .transpose()?;
        Ok((run, Start { x0, samples, plant_substeps, given }))
    }

    /// The inputs applied before the first sample; empty where the file has none.
    pub(super) fn input_before(&self, run: &Table<'_>, ocp: &Ocp) -> Parsed<Vec<f64>> {
        let Some(values) = self.doc.sub_table(run, "u0")? else { return Ok(Vec::new()) };
        let mut u0 = ocp.inputs_at_rest();
        for (name, value) in values {
            let j = self.input(name.get_ref(), name.span())?;
            u0[j] = self.constant(value, name.get_ref())?;
            self.is_a_value(value.span(), j, u0[j], &ocp.input_values)?;
        }
        Ok(u0)
    }

    /// Numbers by state, 0 where there is none.
    fn by_state(&self, table: &Table<'_>, key: &str) -> Parsed<Option<Vec<f64>>> {
        let Some(values) = self.doc.sub_table(table, key)? else { return Ok(None) };
        let mut numbers = vec![0.0; self.system.states.len()];
        for (name, value) in values {
            let i = self.state(name.get_ref(), name.span())?;
            numbers[i] = self.constant(value, name.get_ref())?;
        }
        Ok(Some(numbers))
    }

    /// Values of `[run] parameters`, for the plant alone.
    pub(super) fn plant_parameters(&self, run: &Table<'_>, plant: &mut System) -> Parsed<()> {
        for (key, v) in self.doc.sub_table(run, "parameters")?.into_iter().flatten() {
            let value = self.exact(v, key.get_ref())?;
            self.set(key.get_ref(), key.span(), value, plant)?;
        }
        Ok(())
    }

    /// Values of `[parameters]` that do not change over the run.
    pub(super) fn fixed_parameters(&self, table: &Table<'_>, system: &mut System) -> Parsed<()> {
        for (key, v) in self.doc.sub_table(table, "parameters")?.into_iter().flatten() {
            if is_free(v) {
                continue;
            }
            let value = match self.constant(v, key.get_ref()) {
                Ok(_) => self.exact(v, key.get_ref())?,
                // Not a constant: the value at the start, until the run begins.
                Err(_) => Rational::simplest_from_f64(self.at_start(v, key.get_ref())?).unwrap_or_default(),
            };
            self.set(key.get_ref(), key.span(), value, system)?;
        }
        Ok(())
    }

    fn set(&self, name: &str, span: Range<usize>, value: Rational, system: &mut System) -> Parsed<()> {
        if system.set_parameter(name, value) {
            return Ok(());
        }
        Err(self.unknown(name, span, "parameter", &system.parameter_names()))
    }

    /// A constant as a rational number; what is none (π) is rounded.
    pub(super) fn exact(&self, v: Located<'_, '_>, key: &str) -> Parsed<Rational> {
        let value = self.constant(v, key)?;
        let exact = match v.get_ref() {
            Value::Integer(_) | Value::Float(_) => Some(self.doc.exact_number(v, key)?),
            _ => Rational::simplest_from_f64(value),
        };
        exact.ok_or_else(|| self.doc.error(v.span(), format!("`{key}` is not finite"), "write a number").into())
    }

    /// Noise, delay and faults. `measured` are the names of what is measured.
    pub(super) fn conditions(&self, run: &Table<'_>, samples: usize, measured: &[String]) -> Parsed<RunConditions> {
        let mut noise = vec![0.0; measured.len()];
        if let Some(t) = self.doc.sub_table(run, "noise")? {
            for key in t.keys() {
                let i = self.measured(key.get_ref(), key.span(), measured)?;
                noise[i] = self.not_negative(t, key.get_ref(), 0.0)?;
            }
        }
        let delay = self.whole(run, "delay", 0)?;
        if let Some(v) = run.get("delay").filter(|_| delay >= samples) {
            let message = format!("with a delay of {delay} samples, no input acts within the run of {samples}");
            return Err(self.doc.error(v.span(), message, "give [run] more steps, or a shorter delay").into());
        }
        let mut faults = Vec::new();
        if let Some(v) = run.get("faults") {
            let remedy = "write [[run.faults]] with `at`, or faults = [{ at = 10, lost = true }]";
            let Value::Array(list) = v.get_ref() else {
                return Err(self.doc.error(v.span(), "`faults` must be a list of tables", remedy).into());
            };
            for entry in list {
                let Value::Table(fault) = entry.get_ref() else {
                    return Err(self.doc.error(entry.span(), "a fault must be a table", remedy).into());
                };
                self.fault(entry, fault, samples, measured, &mut faults)?;
            }
        }
        Ok(RunConditions {
            noise,
            seed: self.whole(run, "seed", 0)? as u64,
            delay,
            compensate_delay: self.boolean(run, "compensate_delay", true)?,
            keep_predictions: false,
            faults,
        })
    }

    fn measured(&self, name: &str, span: Range<usize>, measured: &[String]) -> Parsed<usize> {
        let found = measured.iter().position(|m| m == name);
        found.ok_or_else(|| {
            let remedy = format!("measured: {}", measured.join(", "));
            self.doc.error(span, format!("`{name}` is not measured"), remedy).into()
        })
    }

    fn fault(
        &self,
        entry: Located<'_, '_>,
        fault: &Table<'_>,
        samples: usize,
        measured: &[String],
        faults: &mut Vec<(Range<usize>, Fault)>,
    ) -> Parsed<()> {
        self.doc.only_keys(fault, &FAULT_KEYS, "a fault")?;
        if !fault.contains_key("at") {
            return Err(self
                .doc
                .error(entry.span(), "the fault has no `at`", "add the sample, from 0: at = 10")
                .into());
        }
        let at = self.whole(fault, "at", 0)?;
        if let Some(v) = fault.get("at").filter(|_| at >= samples) {
            let message =
                format!("the fault at sample {at} comes after the run, whose samples are 0 to {}", samples - 1);
            return Err(self.doc.error(v.span(), message, "give [run] more steps, or an earlier sample").into());
        }
        let until = self.whole(fault, "until", at)?;
        if until < at {
            let remedy = format!("`until` is the last sample of the fault: {at} or more");
            return Err(self
                .doc
                .error(entry.span(), format!("the fault ends at {until}, before it starts at {at}"), remedy)
                .into());
        }
        let range = at..until + 1;
        let before = faults.len();
        if self.boolean(fault, "lost", false)? {
            faults.push((range.clone(), Fault::LostSample));
        }
        if let Some(v) = fault.get("nan") {
            let remedy = "write nan = [\"x\", \"y\"]";
            let Value::Array(list) = v.get_ref() else {
                return Err(self.doc.error(v.span(), "`nan` must be a list of names", remedy).into());
            };
            let mut outputs = Vec::new();
            for name in list {
                let Value::String(text) = name.get_ref() else {
                    return Err(self.doc.error(name.span(), "a name must be in quotes", remedy).into());
                };
                outputs.push(self.measured(text, name.span(), measured)?);
            }
            faults.push((range.clone(), Fault::NotANumber { outputs }));
        }
        if let Some(d) = self.by_state(fault, "disturbance")? {
            faults.push((range.clone(), Fault::Disturbance(d)));
        }
        if fault.contains_key("solver_limit") {
            faults.push((range.clone(), Fault::SolverLimit(self.whole(fault, "solver_limit", 0)? as u32)));
        }
        if fault.contains_key("time_limit") {
            faults.push((range, Fault::TimeLimit(self.not_negative(fault, "time_limit", 0.0)?)));
        }
        if faults.len() == before {
            let remedy = "add lost = true, nan = […], disturbance = { … }, solver_limit, or time_limit";
            return Err(self.doc.error(entry.span(), "this fault has no effect", remedy).into());
        }
        Ok(())
    }
}
