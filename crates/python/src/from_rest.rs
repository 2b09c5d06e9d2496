//! Motion from rest to rest under dry friction.

use std::sync::Arc;

use bracketry::report::from_rest::{
    from_rest_json, from_rest_map_figure, from_rest_map_json, from_rest_map_text, from_rest_text,
};
use bracketry::steer::from_rest::{Bound as Interval, FromRestOptions};
use bracketry::system::System;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::{seconds, watched};
use crate::model::Model;
use crate::tables::Answer;

/// The model at the point, and the bounds.
fn asked(mut system: System, at: Option<&str>, bounds: &str) -> Result<(System, Vec<Interval>), Failure> {
    if let Some(at) = at {
        system.point = Some(bracketry::point(&mut system, at)?);
    }
    let bounds = if bounds.is_empty() { Vec::new() } else { Interval::list(bounds)? };
    Ok((system, bounds))
}

/// Which rest states bounded inputs reach.
#[pyfunction]
pub(crate) fn from_rest<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    bounds: String,
    at: Option<String>,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let system = model.get().system.clone();
    let time_limit = Some(seconds(time_limit)?);
    let answer = watched(py, move |stop| {
        let (system, bounds) = asked(system, at.as_deref(), &bounds)?;
        let options = FromRestOptions { bounds, time_limit, stop: stop.clone() };
        let found = bracketry::steer::from_rest::from_rest(&system, &options)?;
        Answer::new(&from_rest_json(&found), from_rest_text(&system.quantities, &found), Figures::default())
    })?;
    answer.into_dict(py)
}

/// The answers over two bounds.
#[pyfunction]
pub(crate) fn from_rest_map<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    axes: String,
    bounds: String,
    at: Option<String>,
    cells: usize,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let system = model.get().system.clone();
    let time_limit = Some(seconds(time_limit)?);
    let answer = watched(py, move |stop| {
        let (system, bounds) = asked(system, at.as_deref(), &bounds)?;
        let options = FromRestOptions { bounds, time_limit, stop: stop.clone() };
        let axes: [Interval; 2] = Interval::list(&axes)?
            .try_into()
            .map_err(|list: Vec<Interval>| Failure::new(format!("{} axes are given; give two", list.len())))?;
        let map = Arc::new(bracketry::steer::from_rest::from_rest_map(&system, &axes, cells, &options)?);
        let drawn = Arc::clone(&map);
        let figures = Figures::default().with("map", move || from_rest_map_figure(&system.quantities, &drawn));
        Answer::new(&from_rest_map_json(&map), from_rest_map_text(&map), figures)
    })?;
    answer.into_dict(py)
}
