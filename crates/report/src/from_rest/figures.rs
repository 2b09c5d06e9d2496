//! Figures of motion from rest to rest: the cone of displacements.

use bracketry_plot::{Color, Dash, Drawing, Panel, PlotError, Series, XyChart};
use bracketry_steer::from_rest::FromRest;
use bracketry_system::Quantities;

use super::text::{short, stroke_name};

/// Points of a circle.
const POINTS: usize = 120;

/// The directions of displacement with the ball of the margin, for each pair of coordinates that move; for a single one, the
/// displacements over the length of the loops. Named by the coordinates.
pub fn from_rest_cones(quantities: &Quantities, found: &FromRest) -> Vec<(String, Result<Drawing, PlotError>)> {
    if found.strokes.is_empty() {
        return Vec::new();
    }
    let name = |k: usize| found.coordinates[found.moving[k]].name.clone();
    if found.moving.len() == 1 {
        return vec![(name(0), line(quantities, found))];
    }
    let pairs = (0..found.moving.len()).flat_map(|i| (i + 1..found.moving.len()).map(move |j| (i, j)));
    pairs.map(|(i, j)| (format!("{}_{}", name(i), name(j)), pair(quantities, found, i, j))).collect()
}

/// Displacements over the durations of the loops.
fn line(quantities: &Quantities, found: &FromRest) -> Result<Drawing, PlotError> {
    let c = found.moving[0];
    let mut panel = Panel::new(format!("displacement of {}", quantities.title(&found.coordinates[c].name)));
    for s in &found.strokes {
        let mut points: Vec<(f64, f64)> = s.displacements.iter().map(|d| (d.scale * s.duration, d.change[c])).collect();
        points.push((0.0, 0.0));
        points.reverse();
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        panel = panel.series(Series::new(stroke_name(s), x, y).markers());
    }
    XyChart::new(quantities.time_title("duration of the loop"), panel)
        .title(format!("{}: from rest to rest", found.model))
        .draw()
}

/// Directions of displacement in two coordinates.
fn pair(quantities: &Quantities, found: &FromRest, i: usize, j: usize) -> Result<Drawing, PlotError> {
    let label = |k: usize| {
        let c = found.moving[k];
        let name = &found.coordinates[c].name;
        let unit = quantities.unit(name).map_or_else(String::new, |unit| format!(" {unit}"));
        format!("displacement of {name} / {}{unit}", short(found.sizes[c]))
    };
    let mut panel = Panel::new(label(j));
    let circle = |r: f64| -> (Vec<f64>, Vec<f64>) {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / POINTS as f64;
        ((0..=POINTS).map(|k| r * angle(k).cos()).collect(), (0..=POINTS).map(|k| r * angle(k).sin()).collect())
    };
    let (x, y) = circle(found.margin);
    panel = panel.series(Series::new(format!("margin {}", short(found.margin)), x, y).color(Color::VERMILLION));
    let points: Vec<[f64; 2]> = found.directions.iter().map(|d| [d[i], d[j]]).collect();
    let outline = hull(&points);
    let (x, y): (Vec<f64>, Vec<f64>) = outline.iter().chain(outline.first()).map(|p| (p[0], p[1])).unzip();
    panel = panel.series(Series::new("hull of the directions", x, y).color(Color::BLUE).dash(Dash::Dashed));
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p[0], p[1])).unzip();
    panel = panel.series(Series::new("directions of displacement", x, y).color(Color::BLUE).points());
    XyChart::new(label(i), panel).title(format!("{}: displacements from rest to rest", found.model)).draw()
}

/// The corners of the convex hull of points in the plane, counterclockwise (Andrew 1979).
fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let chain = |list: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for p in list {
            while let [.., a, b] = out[..]
                && turn(a, b, p) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut all = chain(&mut sorted.iter().copied());
    all.extend(chain(&mut sorted.iter().rev().copied()));
    all
}
