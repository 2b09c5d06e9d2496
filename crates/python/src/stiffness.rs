//! Stiffness of robots: identified and compensated, what to measure, what the sensor carries.

use std::path::Path;
use std::sync::Arc;

use bracketry::report::stiffness::{figures as drawn, json, text};
use bracketry::stiffness::{
    ChosenPoses, CompensatedLog, CompensatedRow, Identification, Outliers, RobotFile, RobotLog, Weighing, with_springs,
};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::tables::{Answer, Text, matrix};

pub(crate) fn robot_file(given: &Text) -> Result<RobotFile, Failure> {
    match given {
        Text::File(path) => Ok(RobotFile::read(path)?),
        Text::Given(name, text) => Ok(RobotFile::parse(name, text, Path::new(""))?),
    }
}

/// Springs of the joints and stiffness at the tool point from measurements.
#[pyfunction]
pub(crate) fn identify(py: Python<'_>, data: Text, robot: Text, keep_outliers: bool) -> PyResult<Bound<'_, PyDict>> {
    let (answer, identified) = watched(py, move |_| {
        let file = robot_file(&robot)?;
        let table = data.table("name a CSV file: a table with the columns q1 …, Fx … Mz, dx … rz")?;
        let outliers = if keep_outliers { Outliers::Keep } else { Outliers::Reject };
        let found = Arc::new(Identification::from_table(&file, &table, outliers)?);
        // The springs are in the report, whether they go into the file or not.
        let identified = match &found.springs {
            Some(springs) => {
                let (name, text) = robot.contents()?;
                with_springs(&name, &text, springs).ok()
            }
            None => None,
        };
        let mut figures = Figures::default();
        if let Some(Ok(drawing)) = drawn::stiffness(&found) {
            figures = figures.with("stiffness", move || Ok(drawing.clone()));
        }
        if let Some(Ok(drawing)) = drawn::residuals(&found) {
            figures = figures.with("residuals", move || Ok(drawing.clone()));
        }
        Ok((Answer::new(&json::identification(&found), text::identification(&found), figures)?, identified))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("identified_robot", identified)?;
    Ok(dict)
}

/// What the compensation does along a log.
#[pyfunction]
pub(crate) fn compensate(
    py: Python<'_>,
    log: Text,
    robot: Text,
    process_stiffness: Option<[f64; 3]>,
) -> PyResult<Bound<'_, PyDict>> {
    let (answer, run) = watched(py, move |_| {
        let file = robot_file(&robot)?;
        let table = log.table("name a CSV file: a table with the columns t, q1 …, Fx, Fy, Fz, Mx, My, Mz")?;
        let log = RobotLog::from_table(&table, &file.robot)?;
        let run = Arc::new(CompensatedLog::new(&file, &log, process_stiffness)?);
        let shown = Arc::clone(&run);
        let figures = Figures::default().with("compensation", move || drawn::compensated_log(&shown));
        Ok((Answer::new(&json::compensated_log(&run), text::compensated_log(&run), figures)?, run))
    })?;
    let joints = run.correction_max.len();
    let rows = |of: &dyn Fn(&CompensatedRow) -> Vec<f64>| -> Vec<Vec<f64>> { run.rows.iter().map(of).collect() };
    let dict = answer.into_dict(py)?;
    dict.set_item("t", run.rows.iter().map(|r| r.t).collect::<Vec<f64>>().into_pyarray(py))?;
    dict.set_item("corrected", matrix(py, &rows(&|r| r.corrected.clone()), joints)?)?;
    dict.set_item("correction", matrix(py, &rows(&|r| r.correction.clone()), joints)?)?;
    dict.set_item("wrench", matrix(py, &rows(&|r| r.wrench.as_slice().to_vec()), 6)?)?;
    dict.set_item("displacement", matrix(py, &rows(&|r| r.displacement.as_slice().to_vec()), 6)?)?;
    dict.set_item("held", run.rows.iter().map(|r| r.held).collect::<Vec<bool>>().into_pyarray(py))?;
    dict.set_item("limited", run.rows.iter().map(|r| r.limited).collect::<Vec<bool>>().into_pyarray(py))?;
    Ok(dict)
}

/// Which measurements tell the most about the springs.
#[pyfunction]
pub(crate) fn choose_poses(py: Python<'_>, candidates: Text, robot: Text, count: usize) -> PyResult<Bound<'_, PyDict>> {
    let (answer, chosen, joints) = watched(py, move |_| {
        let file = robot_file(&robot)?;
        let table = candidates.table("name a CSV file: a table of candidates with the columns q1 …, Fx … Mz")?;
        let chosen = ChosenPoses::from_table(&file, &table, count)?;
        let answer = Answer::new(&json::chosen_poses(&chosen), text::chosen_poses(&chosen), Figures::default())?;
        Ok((answer, chosen, file.robot.joints.len()))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("rows", matrix(py, &chosen.rows, joints + 6)?)?;
    dict.set_item("identifies_all", chosen.identifies_all())?;
    Ok(dict)
}

/// What the force sensor carries, and its bias.
#[pyfunction]
pub(crate) fn weigh(py: Python<'_>, readings: Text, robot: Text) -> PyResult<Bound<'_, PyDict>> {
    let (answer, toml) = watched(py, move |_| {
        let file = robot_file(&robot)?;
        let table = readings.table("name a CSV file: a table with the columns q1 …, Fx … Mz")?;
        let found = Weighing::from_table(&file, &table)?;
        let answer = Answer::new(&json::weighing(&found), text::weighing(&found), Figures::default())?;
        Ok((answer, text::payload_table(&found.estimate.payload)))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("toml", toml)?;
    Ok(dict)
}
