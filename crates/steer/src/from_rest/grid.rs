//! How far the margin carries: directions of displacement at the points of a grid, with their derivatives.

use serde::Serialize;

use super::displacement::Plant;
use super::margin::margin;
use super::model::RestModel;
use super::span::{direction, fewest};
use super::strokes::Loop;

/// Points of the grid along each coordinate with bounds.
const POINTS: usize = 3;
/// Most points of the grid.
const MAX_POINTS: usize = 27;
/// Lengths of shorter loops that are enough to compare.
const ENOUGH: usize = 3;
/// Bisections of the length from which on a loop moves something, and lengths above it, as parts of what is left.
const BISECTIONS: usize = 10;
const BETWEEN: [f64; 4] = [0.05, 0.2, 0.5, 0.8];
/// Change of a coordinate in a difference quotient.
const DIFFERENCE: f64 = 1e-4;
/// A displacement below this, in units of its size, has no direction.
const SHORTEST: f64 = 1e-4;

/// The margin at a place, and how far it carries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridPoint {
    /// The coordinates.
    pub at: Vec<f64>,
    /// Radius of the ball about 0 in the hull of the directions.
    pub margin: f64,
    /// By how much a direction changes for shorter loops.
    pub variation: f64,
    /// By how much a direction changes per distance, where coordinates are in units of their sizes.
    pub slope: f64,
    /// The distance in these units up to which the margin stays positive if directions change no faster than here.
    pub reach: f64,
}

/// The points of a grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grid {
    /// Places of the loops that are used, among those of the result.
    pub loops: Vec<usize>,
    /// The points.
    pub points: Vec<GridPoint>,
    /// Half the diagonal of a cell in units of the sizes; 0 for a single point.
    pub half_cell: f64,
}

impl Grid {
    /// Whether every place between the points is within the reach of one.
    pub fn is_covered(&self) -> bool {
        self.points.iter().all(|p| p.reach > self.half_cell)
    }
}

/// What a grid is made of.
pub(crate) struct Family<'a> {
    pub(crate) model: &'a RestModel,
    pub(crate) loops: &'a [Loop],
    /// Displacements at the point of the model.
    pub(crate) changes: &'a [Vec<f64>],
    pub(crate) sizes: &'a [f64],
    /// The coordinates that the loops span.
    pub(crate) moving: &'a [usize],
    /// Durations of shorter loops, relative to the full ones.
    pub(crate) shorter: &'a [f64],
}

/// The margins over the bounds of the coordinates, or at the point; `None` where a loop cannot be followed, or time is over.
pub(crate) fn grid(of: &Family<'_>, plant: &mut Plant, is_over: impl Fn() -> bool) -> Option<Grid> {
    let changes: Vec<&[f64]> = of.changes.iter().map(Vec::as_slice).collect();
    let used = fewest(&changes, of.sizes, of.moving);
    let center: Vec<f64> = of.model.at.iter().map(|e| e.value).collect();
    let mut places = vec![center.clone()];
    let mut half_diagonal = 0.0f64;
    for &c in of.moving {
        let Some(span) = &of.model.region[c] else { continue };
        if span.width() <= 0.0 || places.len() * POINTS > MAX_POINTS {
            continue;
        }
        let step = span.width() / (POINTS - 1) as f64;
        half_diagonal += (0.5 * step / of.sizes[c]).powi(2);
        places = places
            .into_iter()
            .flat_map(|place| {
                (0..POINTS).map(move |k| {
                    let mut moved = place.clone();
                    moved[c] = span.ends[0] + step * k as f64;
                    moved
                })
            })
            .collect();
    }
    let mut points = Vec::new();
    for place in places {
        if is_over() {
            return None;
        }
        points.push(at(of, plant, &used, place)?);
    }
    Some(Grid { loops: used, points, half_cell: half_diagonal.sqrt() })
}

/// Margin, variation, and slope at a place.
fn at(of: &Family<'_>, plant: &mut Plant, used: &[usize], place: Vec<f64>) -> Option<GridPoint> {
    let (mut directions, mut variation, mut slope) = (Vec::new(), 0.0f64, 0.0f64);
    for &k in used {
        let stroke = &of.loops[k];
        let whole = plant.displaced(of.model, &place, stroke, 1.0)?;
        let d = direction(&whole.change, of.sizes, of.moving);
        for change in shorter_ones(of, plant, stroke, &place) {
            variation = variation.max(distance(&d, &direction(&change, of.sizes, of.moving)));
        }
        // A change of the place changes the displacement by its derivative, and its direction by the part across it.
        let derivative = match stroke.closing {
            None => plant.sensitivity(of.model, &place, &whole.signals)?,
            // What closes the loop depends on the place, too.
            Some(_) => differences(of, plant, stroke, &place)?,
        };
        let length: f64 = of.moving.iter().map(|&c| (whole.change[c] / of.sizes[c]).powi(2)).sum::<f64>().sqrt();
        let mut squares = 0.0;
        for &from in of.moving {
            let change: Vec<f64> =
                of.moving.iter().map(|&to| derivative[from][to] * of.sizes[from] / of.sizes[to] / length).collect();
            let along: f64 = change.iter().zip(&d).map(|(a, b)| a * b).sum();
            squares += change.iter().zip(&d).map(|(a, b)| (a - along * b).powi(2)).sum::<f64>();
        }
        slope = slope.max(squares.sqrt());
        directions.push(d);
    }
    let margin = margin(&directions);
    let left = (margin - variation).max(0.0);
    let reach = if slope > 0.0 { left / slope } else { f64::INFINITY };
    Some(GridPoint { at: place, margin, variation, slope, reach })
}

/// Displacements of shorter loops, as far as they move anything: where few of the given lengths do, of lengths above the one from
/// which on they do.
fn shorter_ones(of: &Family<'_>, plant: &mut Plant, stroke: &Loop, place: &[f64]) -> Vec<Vec<f64>> {
    let mut moved = |scale: f64| {
        let change = plant.displaced(of.model, place, stroke, scale)?.change;
        let length = change.iter().zip(of.sizes).map(|(d, s)| if *s > 0.0 { d / s } else { 0.0 });
        (length.map(|x| x * x).sum::<f64>().sqrt() > SHORTEST).then_some(change)
    };
    let mut list: Vec<Vec<f64>> = of.shorter.iter().filter_map(|&scale| moved(scale)).collect();
    if list.len() < ENOUGH {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if moved(middle).is_some() { high = middle } else { low = middle }
        }
        list.extend(BETWEEN.iter().filter_map(|part| moved(high + part * (1.0 - high))));
    }
    list
}

/// The derivative of a displacement by difference quotients, `[from][to]`.
fn differences(of: &Family<'_>, plant: &mut Plant, stroke: &Loop, place: &[f64]) -> Option<Vec<Vec<f64>>> {
    let mut derivative = Vec::new();
    for c in 0..place.len() {
        let mut beside = |sign: f64| {
            let mut moved = place.to_vec();
            moved[c] += sign * DIFFERENCE;
            Some(plant.displaced(of.model, &moved, stroke, 1.0)?.change)
        };
        let (above, below) = (beside(1.0)?, beside(-1.0)?);
        derivative.push(above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * DIFFERENCE)).collect());
    }
    Some(derivative)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
