//! Answers over two bounds: where a "no" becomes a "yes".

use bracketry_symbolic::Limit;
use bracketry_system::System;
use serde::Serialize;

use super::bounds::{Bound, derivative_name};
use super::decide::{Depth, decided};
use super::displacement::Plant;
use super::error::FromRestError;
use super::held::Motion;
use super::model::RestModel;
use super::reason::FromRestReason;
use super::result::{Answer, FromRestOptions};

/// Bisections of a threshold.
const BISECTIONS: usize = 24;

/// The answers for the coordinates at the middle of a cell.
pub type CellAnswers = Vec<Answer>;

/// Where the answer for a coordinate changes along one bound, while the other is at the end of its interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Threshold {
    /// The coordinate.
    pub coordinate: String,
    /// The bound that changes.
    pub bound: String,
    /// The greatest value for which the answer is "no, it never changes".
    pub no_up_to: f64,
    /// The least value for which it is "yes"; `None` if there is none in the interval.
    pub yes_from: Option<f64>,
}

/// The answers over two bounds.
#[derive(Clone, Debug)]
pub struct FromRestMap {
    /// The model.
    pub model: String,
    /// Coordinates, in the order of the answers.
    pub coordinates: Vec<String>,
    /// What is bounded: values from minus to plus the number on the axis, about the value at rest.
    pub names: [String; 2],
    /// Middles of the cells.
    pub x: Vec<f64>,
    /// Middles of the cells.
    pub y: Vec<f64>,
    /// `cells[j][i]` at `(x[i], y[j])`; `None` where the time limit came first.
    pub cells: Vec<Vec<Option<CellAnswers>>>,
    /// Where answers change along the axes.
    pub thresholds: Vec<Threshold>,
    /// Why there are no answers at all.
    pub reason: Option<FromRestReason>,
}

impl FromRestMap {
    /// Whether every cell was computed.
    pub fn is_complete(&self) -> bool {
        self.reason.is_none() && self.cells.iter().flatten().all(Option::is_some)
    }

    /// The answer for a coordinate that follows from other cells: what is reached within smaller bounds is reached within larger ones, and
    /// what stays at rest within larger bounds stays at rest within smaller ones.
    fn inferred(&self, coordinate: usize, [row, column]: [usize; 2]) -> Option<Answer> {
        let known = |j: usize, i: usize| self.cells[j][i].as_ref().map(|answers| answers[coordinate]);
        let within = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>| {
            rows.flat_map(move |j| columns.clone().map(move |i| (j, i))).filter_map(|(j, i)| known(j, i))
        };
        let yes = within(0..row + 1, 0..column + 1).find(|a| matches!(a, Answer::Yes { .. }));
        yes.or_else(|| within(row..self.y.len(), column..self.x.len()).find(|a| *a == Answer::No))
    }
}

/// A model whose bounds change.
struct Varied {
    model: RestModel,
    plant: Plant,
    /// Channel and order of the two bounds.
    places: [(usize, usize); 2],
    limit: Limit,
}

impl Varied {
    fn answers(&mut self, sizes: [f64; 2]) -> Option<(Vec<Motion>, CellAnswers)> {
        if self.limit.is_reached() {
            return None;
        }
        for (&(channel, order), size) in self.places.iter().zip(sizes) {
            self.model.bound(channel, order, size);
        }
        let found = decided("", &mut self.model, &mut self.plant, Depth::Answers, &self.limit);
        // Exact tests that run out of time answer less than they could.
        if found.reason == Some(FromRestReason::Stopped) || self.limit.is_reached() {
            return None;
        }
        Some((
            found.coordinates.iter().map(|c| c.motion).collect(),
            found.coordinates.iter().map(|c| c.answer).collect(),
        ))
    }

    /// The value between `no` and `yes` where a property that holds at `yes` starts to hold, from both sides.
    fn bisected(
        &mut self,
        axis: usize,
        [mut no, mut yes]: [f64; 2],
        other: f64,
        holds: impl Fn(&[Motion], &[Answer]) -> bool,
    ) -> Option<[f64; 2]> {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (no + yes);
            let sizes = if axis == 0 { [middle, other] } else { [other, middle] };
            let (motions, answers) = self.answers(sizes)?;
            if holds(&motions, &answers) { yes = middle } else { no = middle }
        }
        Some([no, yes])
    }

    /// Thresholds of every coordinate along an axis, with the other bound at its greatest value.
    fn thresholds(
        &mut self,
        axis: usize,
        range: [f64; 2],
        other: f64,
        names: &[String],
    ) -> Option<Vec<(String, f64, Option<f64>)>> {
        let at = |size: f64| if axis == 0 { [size, other] } else { [other, size] };
        let (low, _) = self.answers(at(range[0]))?;
        let (high, high_answers) = self.answers(at(range[1]))?;
        let mut list = Vec::new();
        for c in 0..low.len() {
            if low[c] != Motion::Never || high[c] == Motion::Never {
                continue;
            }
            let [no, _] = self.bisected(axis, range, other, |motions, _| motions[c] != Motion::Never)?;
            let is_yes = |a: &[Answer]| matches!(a[c], Answer::Yes { .. });
            let yes = if is_yes(&high_answers) {
                Some(self.bisected(axis, [no, range[1]], other, |_, answers| is_yes(answers))?[1])
            } else {
                None
            };
            list.push((names[c].clone(), no, yes));
        }
        Some(list)
    }
}

/// The answers where two bounds vary: each axis gives the largest difference of an input, or of a derivative, from its value at
/// rest, in `cells` steps from the low to the high end of its interval.
///
/// # Errors
/// As [`super::from_rest`], and [`FromRestError::Axis`] for an axis that is no input or derivative, or whose interval has values
/// below zero.
pub fn from_rest_map(
    system: &System,
    axes: &[Bound; 2],
    cells: usize,
    options: &FromRestOptions,
) -> Result<FromRestMap, FromRestError> {
    let limit = Limit::new(options.time_limit, &options.stop);
    let mut bounds: Vec<Bound> =
        options.bounds.iter().filter(|b| axes.iter().all(|a| a.name != b.name)).cloned().collect();
    for axis in axes {
        if axis.low < 0.0 || axis.low >= axis.high || cells == 0 {
            return Err(FromRestError::Axis { name: axis.name.clone() });
        }
        bounds.push(Bound::new(&axis.name, -axis.high, axis.high));
    }
    let middles = |axis: &Bound| -> Vec<f64> {
        let width = (axis.high - axis.low) / cells as f64;
        (0..cells).map(|k| axis.low + width * (k as f64 + 0.5)).collect()
    };
    let mut map = FromRestMap {
        model: system.name.clone(),
        coordinates: Vec::new(),
        names: axes.clone().map(|a| a.name),
        x: middles(&axes[0]),
        y: middles(&axes[1]),
        cells: vec![vec![None; cells]; cells],
        thresholds: Vec::new(),
        reason: None,
    };
    let mut model = match RestModel::new(system, &bounds)? {
        Ok(model) => model,
        Err(reason) => return Ok(FromRestMap { reason: Some(reason), ..map }),
    };
    model.system.pool.set_limit(limit.clone());
    let place = |axis: &Bound| {
        let orders = model.channels.iter().enumerate().flat_map(|(j, c)| (0..=c.order()).map(move |o| (j, o)));
        let mut found = orders.filter(|&(j, o)| derivative_name(&model.channels[j].name, o) == axis.name);
        found.next().ok_or_else(|| FromRestError::Axis { name: axis.name.clone() })
    };
    let places = [place(&axes[0])?, place(&axes[1])?];
    map.coordinates = model.coordinate_names();
    let plant = Plant::new(&model, &options.stop)?;
    let mut varied = Varied { model, plant, places, limit };
    for axis in 0..2 {
        let other = &axes[1 - axis];
        let range = [axes[axis].low, axes[axis].high];
        for (coordinate, no_up_to, yes_from) in
            varied.thresholds(axis, range, other.high, &map.coordinates).unwrap_or_default()
        {
            map.thresholds.push(Threshold { coordinate, bound: axes[axis].name.clone(), no_up_to, yes_from });
        }
    }
    let mut open = vec![[0, cells, 0, cells]];
    while let Some([bottom, top, left, right]) = open.pop() {
        for (j, i) in [(bottom, left), (top - 1, right - 1)] {
            map.cells[j][i] = map.cells[j][i].clone().or_else(|| {
                let mut answers = varied.answers([map.x[i], map.y[j]])?.1;
                for (c, answer) in answers.iter_mut().enumerate().filter(|(_, a)| **a == Answer::Unknown) {
                    *answer = map.inferred(c, [j, i]).unwrap_or(Answer::Unknown);
                }
                Some(answers)
            });
        }
        let mut is_whole = true;
        for (j, i) in (bottom..top).flat_map(|j| (left..right).map(move |i| (j, i))) {
            if map.cells[j][i].is_none() {
                map.cells[j][i] = (0..map.coordinates.len()).map(|c| map.inferred(c, [j, i])).collect();
                is_whole &= map.cells[j][i].is_some();
            }
        }
        if !is_whole && !varied.limit.is_reached() {
            let (j, i) = (usize::midpoint(bottom, top), usize::midpoint(left, right));
            let parts = [[bottom, j, left, i], [bottom, j, i, right], [j, top, left, i], [j, top, i, right]];
            open.extend(parts.into_iter().filter(|p| p[0] < p[1] && p[2] < p[3]));
        }
    }
    // Smaller bounds that say yes, or larger ones that say no, may have come later.
    for (j, i) in (0..cells).flat_map(|j| (0..cells).map(move |i| (j, i))) {
        let Some(mut answers) = map.cells[j][i].clone() else { continue };
        for (c, answer) in answers.iter_mut().enumerate().filter(|(_, a)| **a == Answer::Unknown) {
            *answer = map.inferred(c, [j, i]).unwrap_or(Answer::Unknown);
        }
        map.cells[j][i] = Some(answers);
    }
    Ok(map)
}
