//! Experiments on the vibrating plate.

use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use bracketry::plate::run::{GivenOption, NumberOption, PlateOptions, PlateRow, PlateSetup, TextOption};
use bracketry::plate::{PlateExperiment, PlateLog, Shape};
use bracketry::report::plate;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::tables::{Answer, Text, matrix};

/// Options by name; what is `None` has a default.
pub(crate) type Given<T> = HashMap<String, Option<T>>;

/// The options that are given, numbers before texts.
fn options(mut numbers: Given<f64>, mut texts: Given<String>) -> Result<PlateOptions, Failure> {
    let number = |&option: &NumberOption| Some(GivenOption::Number(option, numbers.remove(option.name())??));
    let text = |&option: &TextOption| Some(GivenOption::Text(option, texts.remove(option.name())??));
    let numbers = NumberOption::ALL.iter().filter_map(number);
    PlateOptions::from_values(numbers.chain(TextOption::ALL.iter().filter_map(text))).map_err(named)
}

/// The set-up of options.
pub(crate) fn setup_of(numbers: Given<f64>, texts: Given<String>) -> Result<PlateSetup, Failure> {
    options(numbers, texts)?.setup(None).map_err(named)
}

/// One experiment, with the options of a scenario file where they are not given, on a polygon where its vertices are, and beside a log.
#[pyfunction]
#[pyo3(signature = (numbers, texts, *, scenario, polygon, log, driven_by_log))]
pub(crate) fn run_plate(
    py: Python<'_>,
    numbers: Given<f64>,
    texts: Given<String>,
    scenario: Option<PathBuf>,
    polygon: Option<Vec<[f64; 2]>>,
    log: Option<Text>,
    driven_by_log: bool,
) -> PyResult<Bound<'_, PyDict>> {
    let (answer, ran) = watched(py, move |stop| {
        let scenario = scenario.map_or(Ok(PlateOptions::default()), |path| PlateOptions::read(&path)).map_err(named)?;
        let log = log.map(|log| read(&log)).transpose()?;
        let mut options = options(numbers, texts)?.or(scenario);
        if let Some(vertices) = polygon {
            options.shape = Some(Shape::polygon(&vertices).map_err(|e| Failure::from(e).about("shape"))?);
        }
        let setup = options.setup(log.as_ref()).map_err(named)?;
        let watch = |_| if stop.is_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let ran = Arc::new(PlateExperiment::new(setup, log, driven_by_log, watch).map_err(named)?);
        let (motion, plan_view) = (Arc::clone(&ran), Arc::clone(&ran));
        let mut figures = Figures::default()
            .with("motion", move || plate::motion_figure(&motion))
            .with("plan_view", move || plate::plan_view_figure(&plan_view));
        if let Some(Ok(drawing)) = plate::comparison_figure(&ran) {
            figures = figures.with("comparison", move || Ok(drawing.clone()));
        }
        Ok((Answer::of(&plate::json(&ran), figures)?, ran))
    })?;
    let column = |value: fn(&PlateRow) -> f64| ran.run.rows.iter().map(value).collect::<Vec<f64>>().into_pyarray(py);
    let states: Vec<Vec<f64>> = ran.run.rows.iter().map(|row| row.state.to_vec()).collect();
    let dict = answer.into_dict(py)?;
    dict.set_item("states", matrix(py, &states, 6)?)?;
    dict.set_item("t", column(|row| row.t))?;
    dict.set_item("plate_displacement", column(|row| row.plate.displacement))?;
    dict.set_item("plate_tilt", column(|row| row.plate.tilt))?;
    dict.set_item("amplitude", column(|row| row.amplitude))?;
    dict.set_item("normal_force", column(|row| row.normal_force))?;
    dict.set_item("stick_fraction", column(|row| row.stick_fraction))?;
    dict.set_item("gap", column(|row| row.gap))?;
    dict.set_item("lean", column(|row| row.lean))?;
    Ok(dict)
}

fn read(log: &Text) -> Result<PlateLog, Failure> {
    let table = log.table("name a CSV file: a table with the columns t, x_plate, y_plate, phi_plate")?;
    Ok(PlateLog::from_table(&table)?)
}

/// An error that speaks of options by the names that the Python function gives them.
fn named(error: impl std::error::Error) -> Failure {
    Failure::from(error).without_dashes()
}
