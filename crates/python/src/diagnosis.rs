//! What a model gets wrong in measured data.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use bracketry::Diagnosis;
use bracketry::diagnose::{
    DiagnosisSettings, GainSettings, Record, RecordSettings, StudySettings, diagnose as run, read_record,
    reference_candidates,
};
use bracketry::lie::analysis::RankChange;
use bracketry::system::System;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::{seconds, watched};
use crate::model::Model;
use crate::tables::{Answer, columns, hold};

/// A run: a file, or columns by name under a name for messages.
#[derive(FromPyObject)]
pub(crate) enum Run<'py> {
    /// A table (CSV or NPZ).
    File(PathBuf),
    /// Columns, `t` among them.
    Columns(String, HashMap<String, PyReadonlyArray1<'py, f64>>),
}

/// The same without the interpreter.
enum Source {
    File(PathBuf),
    Columns(String, std::collections::BTreeMap<String, Vec<f64>>),
}

impl From<Run<'_>> for Source {
    fn from(run: Run<'_>) -> Self {
        match run {
            Run::File(path) => Source::File(path),
            Run::Columns(name, arrays) => Source::Columns(name, columns(arrays)),
        }
    }
}

fn read(sources: Vec<Source>, system: &System, settings: &RecordSettings) -> Result<Vec<Record>, Failure> {
    let read = |source| match source {
        Source::File(path) => Ok(read_record(&path, system, settings)?),
        Source::Columns(name, mut columns) => {
            let Some(times) = columns.remove("t") else {
                let message = format!("{name}: there is no column `t`; add one with the time in seconds");
                return Err(Failure::new(message));
            };
            Ok(Record::from_columns(&name, times, columns, system, settings)?)
        }
    };
    sources.into_iter().map(read).collect()
}

/// Diagnoses runs, and measures the gain on further ones.
#[pyfunction]
#[pyo3(signature = (model, data, validate, *, hold_inputs, rename, fix, reference, max_causes, seed, window, horizon, time_limit, threads))]
#[allow(clippy::too_many_arguments, reason = "keywords, all of them given by the Python function")]
pub(crate) fn diagnose<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: Vec<Run<'py>>,
    validate: Vec<Run<'py>>,
    hold_inputs: Option<&str>,
    rename: Vec<(String, String)>,
    fix: Vec<String>,
    reference: Option<&Bound<'py, Model>>,
    max_causes: Option<usize>,
    seed: Option<u64>,
    window: Option<f64>,
    horizon: Vec<f64>,
    time_limit: f64,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let reading = RecordSettings { hold: hold_inputs.map(hold).transpose()?, rename, ..Default::default() };
    let time_limit = Some(seconds(time_limit)?);
    let data: Vec<Source> = data.into_iter().map(Source::from).collect();
    let validate: Vec<Source> = validate.into_iter().map(Source::from).collect();
    let mut system = model.get().system.clone();
    let reference = reference.map(|m| m.get().system.clone());
    let (answer, page, extended) = watched(py, move |stop| {
        system.pool.set_stop_flag(stop.clone());
        // Threads of its own: those of a process that was forked do not exist in the new one.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| -> Result<_, Failure> {
            let (records, validate) = (read(data, &system, &reading)?, read(validate, &system, &reading)?);
            let defaults = DiagnosisSettings::default();
            let candidates = match &reference {
                Some(other) => reference_candidates(&system, other).map_err(|e| Failure::from(e).about("reference"))?,
                None => Vec::new(),
            };
            let settings = DiagnosisSettings {
                study: StudySettings { window, fixed: fix, ..StudySettings::default() },
                max_causes: max_causes.unwrap_or(defaults.max_causes),
                seed: seed.unwrap_or(defaults.seed),
                candidates,
                gain: GainSettings::with_horizons(&horizon),
                time_limit,
                ..defaults
            };
            let report = run(&system, &records, &validate, &settings, &mut |_| {})?;
            let model = report.evidence.model.as_ref();
            let ranks = model.and_then(|m| RankChange::of_systems(&system, &m.system));
            let extended = model.map(|m| -> Result<_, Failure> { Ok((m.system.clone(), m.to_toml()?)) }).transpose()?;
            let diagnosis = Arc::new(Diagnosis { report, ranks, extended_model: None, next_experiments: Vec::new() });
            let mut figures = Figures::default();
            for (k, figure) in diagnosis.figures().into_iter().enumerate() {
                let drawn = Arc::clone(&diagnosis);
                figures = figures.with(figure.name, move || drawn.figures().swap_remove(k).drawing);
            }
            let drawn = Arc::clone(&diagnosis);
            let page = Page(Box::new(move || drawn.page(&drawn.figures(), &[])));
            Ok((Answer::of(diagnosis.as_ref(), figures)?, page, extended))
        })
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("page", Py::new(py, page)?)?;
    let extended = extended.map(|(system, text)| {
        let file = format!("{}.toml", system.name);
        Py::new(py, Model::new(system, file, text))
    });
    dict.set_item("extended_model", extended.transpose()?)?;
    Ok(dict)
}

/// The report as a page, made when it is asked for.
#[pyclass(frozen, module = "bracketry._native")]
pub(crate) struct Page(Box<dyn Fn() -> String + Send + Sync>);

#[pymethods]
impl Page {
    fn html(&self, py: Python<'_>) -> String {
        py.detach(|| (self.0)())
    }
}
