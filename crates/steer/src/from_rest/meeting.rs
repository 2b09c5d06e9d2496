//! Loops with durations such that the motion ends at a given place.

use bracketry_numerics::least_squares::{Damping, Problem, Settings, central_differences, minimize};
use nalgebra::DVector;
use serde::Serialize;

use super::displacement::{Displaced, Plant};
use super::model::RestModel;
use super::span::is_displaced;
use super::strokes::Loop;
use crate::signals::Signals;

/// The last loops are this part of the full ones, or more: shorter ones of some families move nothing.
const SHORTEST: f64 = 0.2;
const SHORTEST_SCALE: f64 = 0.01;
/// Durations of the full loops, relative to the first ones: shorter where a loop cannot be closed, or cannot be simulated.
const LONGEST: [f64; 8] = [1.0, 0.99, 0.95, 0.9, 0.7, 0.5, 0.35, 0.25];
/// Bisections of the duration of a loop with a given displacement.
const BISECTIONS: usize = 30;
/// Change of a duration in a difference quotient, relative to that of the full loop.
const DIFFERENCE: f64 = 1e-5;
/// A motion that ends this far from where it started, in units of the sizes, has returned.
const RETURNED: f64 = 1e-8;

/// Loops one after the other that lead back to the start, and how their durations move the end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Return {
    /// Places of the loops among those of the result.
    pub loops: Vec<usize>,
    /// Durations relative to the full loops.
    pub scales: Vec<f64>,
    /// Distance of the end from the start, coordinates in units of their sizes.
    pub error: f64,
    /// The smallest singular value of the derivative of the end by the scales, coordinates in units of their sizes.
    pub singular: f64,
    /// That times the least change of a scale that meets its limits: to first order, the radius of the ball of ends.
    pub reach: f64,
}

/// Loops, and the plant that they act on.
pub(crate) struct Meeting<'a> {
    pub(crate) model: &'a RestModel,
    pub(crate) plant: &'a mut Plant,
    pub(crate) loops: &'a [Loop],
    /// Sizes of displacements by coordinate.
    pub(crate) sizes: &'a [f64],
    pub(crate) is_over: &'a dyn Fn() -> bool,
}

/// The longest loops that end at rest from a place.
pub(crate) struct Longest {
    pub(crate) scales: Vec<f64>,
    pub(crate) runs: Vec<Displaced>,
}

impl Longest {
    fn changes(&self) -> Vec<Vec<f64>> {
        self.runs.iter().map(|run| run.change.clone()).collect()
    }
}

/// Loops that meet the end.
pub(crate) struct Met {
    pub(crate) scales: DVector<f64>,
    pub(crate) end: Vec<f64>,
    pub(crate) signals: Vec<Signals>,
}

impl Meeting<'_> {
    pub(crate) fn longest(&mut self, from: &[f64]) -> Option<Longest> {
        let mut longest = Longest { scales: Vec::new(), runs: Vec::new() };
        for stroke in self.loops {
            let (scale, run) = LONGEST.iter().find_map(|&s| {
                let run = self.plant.displaced(self.model, from, stroke, s)?;
                is_displaced(&run.change, from).then_some((s, run))
            })?;
            longest.scales.push(scale);
            longest.runs.push(run);
        }
        Some(longest)
    }

    /// Parts of the longest displacements, not too small ones, that add up to a gap; `None` if there are none.
    pub(crate) fn parts(&self, longest: &Longest, gap: &[f64]) -> Option<Vec<f64>> {
        self.combined(longest, gap, [SHORTEST, 1.0], 0.5 * (1.0 + SHORTEST))
    }

    /// Multiples of the longest displacements, within limits, that add up to a gap.
    pub(crate) fn combined(&self, longest: &Longest, gap: &[f64], limits: [f64; 2], start: f64) -> Option<Vec<f64>> {
        let columns: Vec<Vec<f64>> = longest.changes().iter().map(|d| scaled(d, self.sizes)).collect();
        let start = DVector::from_element(columns.len(), start);
        let limits = vec![limits; columns.len()];
        let mut parts = Parts { columns, wanted: scaled(gap, self.sizes), limits };
        let settings = Settings { iterations: 200, enough: 1e-9, ..Settings::default() };
        let found = minimize(&mut parts, &start, &settings)?;
        (found.residual.amax() <= 1e-6).then(|| found.at.iter().copied().collect())
    }

    /// Durations whose displacements add up to the gap, first one by one, then together on the plant.
    pub(crate) fn meet(&mut self, here: &[f64], end: &[f64], longest: &Longest, parts: &[f64]) -> Option<Met> {
        let mut start = DVector::zeros(parts.len());
        for (k, full) in longest.changes().iter().enumerate() {
            let toward = scaled(full, self.sizes);
            let length = |d: &[f64]| -> f64 { scaled(d, self.sizes).iter().zip(&toward).map(|(a, b)| a * b).sum() };
            let (mut low, mut high) = (0.0, longest.scales[k]);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                let reaches = self.plant.displaced(self.model, here, &self.loops[k], middle);
                let part = reaches.map_or(0.0, |d| length(&d.change) / length(full));
                if part < parts[k] { low = middle } else { high = middle }
            }
            start[k] = high;
        }
        let limits = longest.scales.iter().map(|&s| [SHORTEST_SCALE * s, s]).collect();
        let mut last = Last { meeting: self, here, end, limits };
        let settings = Settings {
            damping: Damping { least: 1e-15, trials: 8, ..Damping::default() },
            iterations: 30,
            enough: 1e-11,
            ..Settings::default()
        };
        let found = minimize(&mut last, &start, &settings)?;
        let (end, signals) = self.run(here, &found.at)?;
        Some(Met { scales: found.at, end, signals })
    }

    /// Where the loops end, with their signals.
    fn run(&mut self, from: &[f64], scales: &DVector<f64>) -> Option<(Vec<f64>, Vec<Signals>)> {
        let mut place = from.to_vec();
        let mut list = Vec::new();
        for (stroke, &scale) in self.loops.iter().zip(scales) {
            if (self.is_over)() {
                return None;
            }
            let run = self.plant.displaced(self.model, &place, stroke, scale)?;
            place.iter_mut().zip(&run.change).for_each(|(q, d)| *q += d);
            list.push(run.signals);
        }
        Some((place, list))
    }

    /// The loops, with durations such that the motion returns to its start; `None` if there are none.
    pub(crate) fn returned(&mut self, at: &[f64], moving: &[usize]) -> Option<Return> {
        let longest = self.longest(at)?;
        let parts = self.parts(&longest, &vec![0.0; at.len()])?;
        let met = self.meet(at, at, &longest, &parts)?;
        let units = self.sizes;
        let end_of = |place: &[f64]| -> DVector<f64> {
            DVector::from_iterator(moving.len(), moving.iter().map(|&c| (place[c] - at[c]) / units[c]))
        };
        let error = end_of(&met.end).norm();
        let end = |scales: &DVector<f64>| self.run(at, scales).map(|(place, _)| end_of(&place)).ok_or(());
        let jacobian = central_differences(end, &met.scales, DIFFERENCE).ok()?;
        let singular = jacobian.singular_values().iter().copied().fold(f64::INFINITY, f64::min);
        let room =
            met.scales.iter().zip(&longest.scales).map(|(s, most)| s.min(most - s)).fold(f64::INFINITY, f64::min);
        let is_return = error <= RETURNED && singular > 0.0 && room > 0.0;
        is_return.then(|| Return {
            loops: Vec::new(),
            scales: met.scales.iter().copied().collect(),
            error,
            singular,
            reach: singular * room,
        })
    }
}

fn scaled(difference: &[f64], sizes: &[f64]) -> Vec<f64> {
    difference.iter().zip(sizes).map(|(d, s)| if *s > 0.0 { d / s } else { 0.0 }).collect()
}

/// The linear problem of the parts.
struct Parts {
    columns: Vec<Vec<f64>>,
    wanted: Vec<f64>,
    limits: Vec<[f64; 2]>,
}

impl Problem for Parts {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let sum = |i: usize| self.columns.iter().zip(at.iter()).map(|(c, h)| c[i] * h).sum::<f64>();
        Some(DVector::from_fn(self.wanted.len(), |i, _| sum(i) - self.wanted[i]))
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}

/// What is left to the end as a function of the durations of the last loops.
struct Last<'m, 'a> {
    meeting: &'m mut Meeting<'a>,
    here: &'m [f64],
    end: &'m [f64],
    limits: Vec<[f64; 2]>,
}

impl Problem for Last<'_, '_> {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        let (place, _) = self.meeting.run(self.here, at)?;
        Some(DVector::from_fn(place.len(), |i, _| place[i] - self.end[i]))
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}
