//! The map over two bounds.

use bracketry_plot::{Color, Drawing, PlotError, RegimeMap};
use bracketry_steer::from_rest::{Answer, CellAnswers, FromRestMap};
use bracketry_system::{Quantities, readable, with_unit};
use serde_json::{Value, json};

/// What changes in a cell, in words.
fn cell(map: &FromRestMap, answers: &CellAnswers) -> String {
    let of = |wanted: fn(&Answer) -> bool| -> Vec<&str> {
        map.coordinates.iter().zip(answers).filter(|(_, a)| wanted(a)).map(|(n, _)| n.as_str()).collect()
    };
    let yes = of(|a| matches!(a, Answer::Yes { .. }));
    let unknown = of(|a| *a == Answer::Unknown);
    let mut text = if yes.is_empty() { "nothing changes".to_owned() } else { format!("{} change", yes.join(", ")) };
    if yes.len() == 1 {
        text = format!("{} changes", yes[0]);
    }
    match (unknown.is_empty(), yes.is_empty()) {
        (true, _) => text,
        (false, true) => format!("{} unknown", unknown.join(", ")),
        (false, false) => format!("{text}; {} unknown", unknown.join(", ")),
    }
}

/// The thresholds, and how many cells have which answers.
pub fn from_rest_map_text(map: &FromRestMap) -> String {
    let [a, b] = &map.names;
    let mut lines = vec![format!("{}: from rest to rest, over the bounds of {a} and {b}", map.model)];
    if let Some(reason) = &map.reason {
        lines.push(format!("  {reason}"));
    }
    for t in &map.thresholds {
        let yes =
            t.yes_from.map_or_else(|| "yes nowhere on the axis".to_owned(), |v| format!("yes from {}", readable(v)));
        lines.push(format!("  {}: bound of {}: no up to {}, {yes}", t.coordinate, t.bound, readable(t.no_up_to)));
    }
    let mut counts: Vec<(String, usize)> = Vec::new();
    for c in map.cells.iter().flatten() {
        let text = c.as_ref().map_or_else(|| "not computed in time".to_owned(), |answers| cell(map, answers));
        match counts.iter_mut().find(|(t, _)| *t == text) {
            Some((_, n)) => *n += 1,
            None => counts.push((text, 1)),
        }
    }
    if map.reason.is_none() {
        let all = map.cells.iter().flatten().count();
        lines.extend(counts.into_iter().map(|(text, n)| format!("  {n} of {all} cells: {text}")));
    }
    lines.join("\n") + "\n"
}

/// The map as data.
pub fn from_rest_map_json(map: &FromRestMap) -> Value {
    json!({
        "model": map.model,
        "coordinates": map.coordinates,
        "names": map.names,
        "x": map.x,
        "y": map.y,
        "cells": map.cells,
        "thresholds": map.thresholds,
        "reason": map.reason,
        "complete": map.is_complete(),
    })
}

/// The title of the axis of `der(X,2)`: `largest |X''| [m/s²]`.
fn axis(quantities: &Quantities, name: &str) -> String {
    let parts = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')')?.rsplit_once(','));
    let derivative = parts.and_then(|(input, order)| Some((input.trim(), order.trim().parse::<u32>().ok()?)));
    let (what, unit) = match derivative {
        Some((input, order)) => {
            (format!("largest |{input}{}|", "'".repeat(order as usize)), quantities.unit_of_derivative(input, order))
        }
        None => (format!("largest deviation of {name}"), quantities.unit(name).map(str::to_owned)),
    };
    with_unit(&what, unit.as_deref())
}

/// Cells by the coordinates that change.
///
/// # Errors
/// As [`RegimeMap::draw`].
pub fn from_rest_map_figure(quantities: &Quantities, map: &FromRestMap) -> Result<Drawing, PlotError> {
    let mut names: Vec<String> = Vec::new();
    let rows: Vec<Vec<Option<usize>>> = map
        .cells
        .iter()
        .map(|row| {
            let mut category = |answers: &Option<CellAnswers>| {
                let text = cell(map, answers.as_ref()?);
                Some(names.iter().position(|n| *n == text).unwrap_or_else(|| {
                    names.push(text);
                    names.len() - 1
                }))
            };
            row.iter().map(&mut category).collect()
        })
        .collect();
    let label = |name: &String| axis(quantities, name);
    let mut figure = RegimeMap::new(label(&map.names[0]), label(&map.names[1]))
        .title(format!("{}: what changes from rest to rest", map.model))
        .cells(map.x.clone(), map.y.clone(), rows)
        .missing("not computed in time");
    for (k, n) in names.iter().enumerate() {
        let color =
            if n.contains("unknown") { Color(224, 224, 224) } else { Color::series(k).mix(Color(255, 255, 255), 0.6) };
        figure = figure.category(n.clone(), color);
    }
    figure.draw()
}
