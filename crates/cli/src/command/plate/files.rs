//! Files of a run on the plate: page, table, plots, animation.

use std::path::Path;

use anyhow::Context;
use bracketry::plate::PlateExperiment;
use bracketry::report::{html, plate};

use super::super::output::{csv, json, listed, save_figures, write};

/// The page with everything.
pub(super) const PAGE: &str = "plate.html";

/// Writes everything; gives the names of the files.
pub(super) fn write_all(dir: &Path, ran: &PlateExperiment, gif: bool) -> anyhow::Result<Vec<String>> {
    let mut files = listed(&[("plate.json", "all results, for programs"), ("trajectory.csv", "the run over time")]);
    write(&dir.join("plate.json"), &json(&plate::json(ran))?)?;
    let rows = plate::csv_rows(&ran.run.rows);
    csv(&dir.join("trajectory.csv"), &plate::csv_columns(&ran.run.rows), rows.iter().map(Vec::as_slice))?;
    let figures = plate::figures(ran);
    files.extend(save_figures(&figures, dir));
    let mut film = None;
    if gif {
        let animation = plate::animation(ran);
        let images = animation.gif().context("no animation")?;
        let path = dir.join("plate.gif");
        std::fs::write(&path, &images).with_context(|| format!("cannot write {}", path.display()))?;
        let caption = "The object on the plate, in real time";
        film = Some(html::animation(&images, &animation.still().context("no animation")?, caption));
        files.extend(listed(&[("plate.gif", caption)]));
    }
    write(&dir.join(PAGE), &plate::page(ran, &figures, film.as_deref(), &files))?;
    Ok(std::iter::once(PAGE.to_owned()).chain(files.into_iter().map(|f| f.0)).collect())
}
