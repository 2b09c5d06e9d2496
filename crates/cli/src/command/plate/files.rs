//! Files of a run on the plate: table, plots, animation.

use std::path::Path;

use anyhow::Context;
use bracketry::plate::PlateExperiment;
use bracketry::report::plate;

use super::super::output::{csv, figure, json, write};

/// Writes everything; gives the names of the files.
pub(super) fn write_all(dir: &Path, ran: &PlateExperiment, gif: bool) -> anyhow::Result<Vec<&'static str>> {
    let mut names = vec!["plate.json", "trajectory.csv", "motion.svg", "motion.png", "plan_view.svg", "plan_view.png"];
    write(&dir.join("plate.json"), &json(&plate::json(ran))?)?;
    let rows = plate::csv_rows(&ran.run.rows);
    csv(&dir.join("trajectory.csv"), &plate::csv_columns(&ran.run.rows), rows.iter().map(Vec::as_slice))?;
    figure(plate::motion_figure(ran), &dir.join("motion"));
    figure(plate::plan_view_figure(ran), &dir.join("plan_view"));
    if let Some(drawing) = plate::comparison_figure(ran) {
        figure(drawing, &dir.join("comparison"));
        names.extend(["comparison.svg", "comparison.png"]);
    }
    if gif {
        plate::animation(ran).save(dir.join("plate.gif")).context("no animation")?;
        names.push("plate.gif");
    }
    Ok(names)
}
