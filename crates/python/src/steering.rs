//! Motions from one state to another.

use bracketry::report::steering::{
    steering_figure, steering_json, steering_path, steering_scenario, steering_text, steering_trajectory,
};
use bracketry::steer::from_rest::Bound as Interval;
use bracketry::steer::{SteerMethod, SteerOptions, own_inputs};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::{seconds, watched};
use crate::model::Model;
use crate::tables::Answer;

/// Initial state, state at the end, and bounds, by name.
type Asked = (Option<String>, String, String);

fn method_of(name: &str) -> Result<Option<SteerMethod>, Failure> {
    match name {
        "auto" => Ok(None),
        "chained" => Ok(Some(SteerMethod::Chained)),
        "nilpotent" => Ok(Some(SteerMethod::Nilpotent)),
        "flat" => Ok(Some(SteerMethod::Flat)),
        "loops" => Ok(Some(SteerMethod::Loops)),
        "shooting" => Ok(Some(SteerMethod::Shooting)),
        other => Err(Failure::new(format!(
            "method is \"{other}\"; it can be \"auto\", \"chained\", \"nilpotent\", \"flat\", \"loops\" or \"shooting\""
        ))),
    }
}

/// Inputs that move a model from one state to another, and the motion.
#[pyfunction]
#[pyo3(signature = (model, asked, duration, method, time_limit, seed))]
pub(crate) fn steer<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    asked: Asked,
    duration: Option<f64>,
    method: &str,
    time_limit: f64,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let given = model.get().system.clone();
    let (start, goal, bounds) = asked;
    let method = method_of(method)?;
    let time_limit = Some(seconds(time_limit)?);
    let (answer, table, scenario, steered) = watched(py, move |stop| {
        let mut system = own_inputs(&given)?;
        let options = SteerOptions {
            bounds: if bounds.is_empty() { Vec::new() } else { Interval::list(&bounds)? },
            duration,
            method,
            time_limit,
            seed,
            stop: stop.clone(),
            ..SteerOptions::named(&mut system, start.as_deref(), &goal)?
        };
        let found = bracketry::steer::steer(&given, &options)?;
        let mut figures = Figures::default();
        if let (Some(_), Some(_)) = (&found.motion, &found.signals) {
            let drawn = found.clone();
            // There is a motion.
            figures = figures.with("steering", move || {
                steering_figure(&drawn).unwrap_or_else(|| bracketry::plot::TimeSeries::new().draw())
            });
            if steering_path(&found).is_some() {
                let drawn = found.clone();
                figures = figures.with("path", move || {
                    steering_path(&drawn).unwrap_or_else(|| bracketry::plot::TimeSeries::new().draw())
                });
            }
        }
        let answer = Answer::new(&steering_json(&found), steering_text(&found), figures)?;
        let table = steering_trajectory(&found);
        let scenario = steering_scenario(&found, "inputs.csv");
        Ok((answer, table, scenario, Model::made(found.system)?))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("trajectory", table)?;
    dict.set_item("scenario", scenario)?;
    dict.set_item("model", Py::new(py, steered)?)?;
    Ok(dict)
}
