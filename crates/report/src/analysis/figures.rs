//! Pictures of an analysis: how brackets open directions, and what comes under the influence of the inputs when.

use bracketry_lie::Analysis;
use bracketry_lie::algebra::{Bracket, Generator};
use bracketry_lie::analysis::{Dimensions, Influence, ModeReport, ReachTable};
use bracketry_plot::{Color, TileChart, TileGrid};

/// Inputs that get a color each.
const OWN_COLORS: usize = 3;
/// Grids with more rows are left out: nobody reads them.
const MOST_ROWS: usize = 60;

const DRIFT: &str = "the drift f";
const SWITCHING: &str = "a difference of drifts: switching";
const SEVERAL: &str = "fields of several inputs";
const UNNAMED: &str = "direction at the point (bracket not listed)";
const NEVER: &str = "in no bracket";

/// A staircase: each column has the brackets of one length, on top of those that were there before.
pub fn growth_figure(a: &Analysis) -> TileChart {
    let inputs = a.affinization.system.input_names();
    let mut chart =
        TileChart::new().title(format!("Directions opened by brackets, {}", a.model)).category(DRIFT, Color::band(2));
    // With many inputs they are one category.
    let own = if inputs.len() > OWN_COLORS { 1 } else { inputs.len() };
    for (i, u) in inputs.iter().enumerate().take(own) {
        let color = [Color::band(0), Color::band(1), Color::band(3)][i];
        chart = chart.category(field_of(&inputs, i, u), color);
    }
    chart = chart
        .category(SEVERAL, Color::band(5))
        .category(SWITCHING, Color::band(4))
        .category(UNNAMED, Color::band(0).mix(Color::GRAY, 0.15))
        .category(NEVER, Color::VERMILLION.mix(Color(255, 255, 255), 0.45));
    if a.states > MOST_ROWS {
        return chart;
    }
    let report = &a.report;
    let n = a.states;
    if let Some(first) = report.modes.first() {
        chart = chart.grid(staircase(&mode_title(first, &report.modes), &first.dimensions, n, &inputs));
    }
    // Without common brackets there are no steps.
    if let Some(s) = report.switched.as_ref().filter(|s| !s.dimensions.growth.is_empty()) {
        chart = chart.grid(staircase("all modes together; f(k), g(k): fields in mode k", &s.dimensions, n, &inputs));
    }
    if let Some(s) = &report.smoothed {
        chart = chart.grid(staircase(&format!("smoothed, width {}", s.epsilon), &s.dimensions, n, &inputs));
    }
    // Where the point is like any other its picture says nothing new.
    let generic = report.smoothed.as_ref().map(|s| &s.dimensions).or(report.modes.first().map(|m| &m.dimensions));
    if let Some(p) = report.at_point.as_ref().and_then(|p| p.known())
        && generic.is_none_or(|d| d.growth != p.dimensions.growth)
    {
        chart = chart.grid(staircase("at the point of the model", &p.dimensions, n, &inputs));
    }
    chart
}

/// States and functions against rounds of brackets; none where the analysis could not tell.
pub fn reach_figure(a: &Analysis) -> Option<TileChart> {
    let tables = &a.report.reach;
    if tables.is_empty() {
        return None;
    }
    let chart = TileChart::new()
        .title(format!("What the inputs influence, {}", a.model))
        .category(FREE, Color::BLUE.mix(Color(255, 255, 255), 0.25))
        .category(MOVES, Color::BLUE.mix(Color(255, 255, 255), 0.75))
        .category(NOT_YET, Color::band(2))
        .category(NO_INPUT, Color::VERMILLION.mix(Color(255, 255, 255), 0.45));
    Some(tables.iter().fold(chart, |chart, t| chart.grid(table(t, a.states))))
}

fn mode_title(first: &ModeReport, modes: &[ModeReport]) -> String {
    if first.signs.0.is_empty() {
        return "at a generic point".to_owned();
    }
    let alike = modes.iter().filter(|m| m.dimensions.growth == first.dimensions.growth).count();
    format!("one mode: {}{}", first.signs.condition(), others("growth", alike))
}

/// In how many modes the same holds of `what`.
fn others(what: &str, alike: usize) -> String {
    match alike {
        0 | 1 => String::new(),
        2 => format!(" (the same {what} in 1 other mode)"),
        k => format!(" (the same {what} in {} other modes)", k - 1),
    }
}

fn field_of(inputs: &[String], i: usize, input: &str) -> String {
    if inputs.len() > OWN_COLORS {
        "the field of one input".to_owned()
    } else {
        format!("g{}, the field of {input}", i + 1)
    }
}

/// One tile for each dimension, in the column of the length at which it was gained.
fn staircase(title: &str, d: &Dimensions, n: usize, inputs: &[String]) -> TileGrid {
    let reached = d.growth.last().or(d.accessible_dimension.known()).copied().unwrap_or(0);
    let mut columns: Vec<String> = (1..=d.growth.len().max(1)).map(|k| k.to_string()).collect();
    if reached < n {
        columns.push("none".to_owned());
    }
    let rows = (1..=n).rev().map(|k| k.to_string());
    let mut grid = TileGrid::new(columns, rows).title(title).column_label("bracket length").row_label("dimension");
    let mut below = 0;
    for (k, &dimension) in d.growth.iter().enumerate() {
        for row in below..dimension {
            let bracket = d.basis.get(row);
            let label = match (bracket, k) {
                (Some(bracket), _) => bracket.to_string(),
                (None, 0) => "a field".to_owned(),
                (None, _) => format!("length {}", k + 1),
            };
            grid = grid.tile(k, n - 1 - row, category(bracket, inputs), label);
        }
        below = dimension.max(below);
    }
    for row in reached..n {
        grid = grid.tile(d.growth.len(), n - 1 - row, NEVER, "not reached");
    }
    grid
}

/// Which fields a bracket is made of.
fn category(bracket: Option<&Bracket>, inputs: &[String]) -> String {
    let Some(bracket) = bracket else { return UNNAMED.to_owned() };
    let letters = bracket.letters();
    if letters.iter().any(|g| matches!(g, Generator::DriftDifference { .. })) {
        return SWITCHING.to_owned();
    }
    let mut fields: Vec<usize> = letters
        .iter()
        .filter_map(|g| if let Generator::Input { input, .. } = g { Some(*input) } else { None })
        .collect();
    fields.dedup();
    match fields[..] {
        [] => DRIFT.to_owned(),
        [i] => field_of(inputs, i - 1, &inputs[i - 1]),
        _ => SEVERAL.to_owned(),
    }
}

const FREE: &str = "can be moved alone";
const MOVES: &str = "moves with others";
const NOT_YET: &str = "not yet influenced";
const NO_INPUT: &str = "influenced by no input";

fn table(t: &ReachTable, n: usize) -> TileGrid {
    let title = if t.all_modes {
        "all modes together: what switching adds".to_owned()
    } else if t.signs.0.is_empty() {
        format!("{n} states")
    } else {
        format!("one mode: {}{}", t.signs.condition(), others("influence", t.alike))
    };
    let rounds = t.rows.first().map_or(0, |r| r.influence.len());
    let columns = (0..rounds).map(|k| match k {
        0 => "input fields".to_owned(),
        1 => "1 bracket".to_owned(),
        k => format!("{k} brackets"),
    });
    let mut grid = TileGrid::new(columns, t.rows.iter().map(|r| r.function.to_string()))
        .title(title)
        .column_label("rounds of brackets");
    for (i, row) in t.rows.iter().enumerate() {
        let never = row.influence.last() == Some(&Influence::None);
        for (k, influence) in row.influence.iter().enumerate() {
            let category = match influence {
                Influence::Free => FREE,
                Influence::Moves => MOVES,
                Influence::None if never => NO_INPUT,
                Influence::None => NOT_YET,
            };
            grid = grid.tile(k, i, category, "");
        }
    }
    grid
}
