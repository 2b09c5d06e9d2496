//! The map over two parameters.

use bracketry_lie::parameters::{AspectValue, MapCell, ParameterMap};
use bracketry_plot::{Color, RegimeMap};
use bracketry_system::Quantities;

use super::text::{cell, name};

/// Cells by what the linearization does there, with the curves on which ranks change.
/// Axes have the units of `quantities`, which are those of
/// [`System::all_quantities`](bracketry_system::System::all_quantities).
pub fn parameter_figure(quantities: &Quantities, map: &ParameterMap) -> RegimeMap {
    let mut names: Vec<String> = Vec::new();
    let known = map.cells.iter().flatten().any(Option::is_some);
    // Without a linearization, the generic dimension holds everywhere off the curves.
    let dimension = map.report.aspects.first().and_then(|a| match a.generic.known() {
        Some(AspectValue::Dimension(d)) => Some(format!("{} {d} of {}", name(a.aspect), map.report.states)),
        _ => None,
    });
    let rows: Vec<Vec<Option<usize>>> = map
        .cells
        .iter()
        .map(|row| {
            let category = |c: &Option<MapCell>| {
                let text = if known { c.as_ref().map(cell) } else { dimension.clone() }?;
                Some(names.iter().position(|n| *n == text).unwrap_or_else(|| {
                    names.push(text);
                    names.len() - 1
                }))
            };
            row.iter().map(category).collect()
        })
        .collect();
    let [a, b] = &map.names;
    let mut figure = RegimeMap::new(quantities.title(a), quantities.title(b))
        .title(format!("{}: verdicts over {a} and {b}", map.report.model))
        .cells(map.x.clone(), map.y.clone(), rows)
        .missing("no rational linearization");
    for (k, n) in names.iter().enumerate() {
        figure = figure.category(n.clone(), color(n, k));
    }
    for c in &map.curves {
        let changes: Vec<String> = c.changes.iter().map(|(aspect, v)| format!("{} {v}", name(*aspect))).collect();
        let shown = changes.first().cloned().unwrap_or_default();
        let more = if changes.len() > 1 { " …" } else { "" };
        figure = figure.curve(
            format!("{} = 0: {shown}{more}", c.condition),
            map.trace_x.clone(),
            map.trace_y.clone(),
            c.values.clone(),
        );
    }
    let inside = |v: f64, list: &[f64]| list.first().is_some_and(|l| *l <= v) && list.last().is_some_and(|h| v <= *h);
    for p in &map.points {
        let at = p.at;
        if inside(at[0], &map.trace_x) && inside(at[1], &map.trace_y) {
            let shown = p.changes.first().map(|(aspect, v)| format!("{} {v}", name(*aspect))).unwrap_or_default();
            figure = figure.mark(shown, at[0], at[1]);
        }
    }
    figure
}

fn color(name: &str, index: usize) -> Color {
    let pale = |c: Color| c.mix(Color(255, 255, 255), 0.6);
    if name.starts_with("stable") {
        pale(Color::BLUE)
    } else if name.starts_with("not") {
        pale(Color::VERMILLION)
    } else {
        Color::band(index + 1)
    }
}
