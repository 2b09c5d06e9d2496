//! `bracketry analyze --from-rest`: which rest states bounded inputs reach.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use bracketry::report::Figure;
use bracketry::report::from_rest::{
    from_rest_cones, from_rest_json, from_rest_map_figure, from_rest_map_json, from_rest_map_text, from_rest_text,
};
use bracketry::steer::from_rest::{Answer, Bound, FromRestOptions, from_rest, from_rest_map};
use bracketry::system::System;

use super::output::{PageArgs, TextReport, json, print};
use super::progress::spinner;
use super::{CommonArgs, Outcome};

/// What is asked.
pub(crate) struct Request<'a> {
    /// The model file.
    pub(crate) model: &'a Path,
    /// Bounds.
    pub(crate) bounds: Option<&'a str>,
    /// Two bounds that vary.
    pub(crate) map: Option<&'a str>,
    /// Cells along each axis.
    pub(crate) cells: usize,
    /// When to stop.
    pub(crate) time_limit: Duration,
    /// What becomes of the page.
    pub(crate) page: PageArgs,
}

/// Prints the answer, and draws the cone of displacements.
pub(crate) fn run(system: &System, args: &Request<'_>, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let bounds = args.bounds.map_or(Ok(Vec::new()), Bound::list).context("--bounds")?;
    let stop = system.pool.stop_flag().clone();
    let options = FromRestOptions { bounds, time_limit: Some(args.time_limit), stop };
    if let Some(map) = args.map {
        return cells(system, map, &options, args, output);
    }
    let progress = spinner("friction cones and loops");
    let found = from_rest(system, &options).with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let (text, value) = (from_rest_text(&system.quantities, &found), json(&from_rest_json(&found))?);
    if let Some(dir) = &output.out {
        let cone = |(name, drawing): (String, _)| {
            Figure::new(format!("displacements_{name}"), format!("Displacements from rest, {name}"), drawing)
        };
        let figures = from_rest_cones(&system.quantities, &found).into_iter().map(cone).collect();
        let title = format!("From rest to rest: {}", system.name);
        let (text, json) = (&*text, &*value);
        TextReport { name: "from_rest", title, text, json, figures, system }.save(dir, args.page)?;
    }
    print(if output.json { &value } else { &text })?;
    Ok(if found.answer == Answer::Unknown { Outcome::Negative } else { Outcome::Done })
}

/// Prints where answers change over two bounds, and draws the map.
fn cells(
    system: &System,
    map: &str,
    options: &FromRestOptions,
    args: &Request<'_>,
    output: &CommonArgs,
) -> anyhow::Result<Outcome> {
    let axes: [Bound; 2] = Bound::list(map).context("--map")?.try_into().map_err(|list: Vec<Bound>| {
        anyhow::anyhow!("--map has {} axes: give two, such as \"der(X,2)=1..6,theta=0.1..0.5\"", list.len())
    })?;
    let progress = spinner("cells of the map");
    let found = from_rest_map(system, &axes, args.cells, options).with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let (text, value) = (from_rest_map_text(&found), json(&from_rest_map_json(&found))?);
    if let Some(dir) = &output.out {
        let drawing = from_rest_map_figure(&system.quantities, &found);
        let figures = vec![Figure::new("from_rest_map", "What changes from rest to rest, over two bounds", drawing)];
        let title = format!("From rest to rest, over two bounds: {}", system.name);
        let (text, json) = (&*text, &*value);
        TextReport { name: "from_rest_map", title, text, json, figures, system }.save(dir, args.page)?;
    }
    print(if output.json { &value } else { &text })?;
    Ok(if found.is_complete() { Outcome::Done } else { Outcome::Negative })
}
