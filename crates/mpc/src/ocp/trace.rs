//! Constraints along a run: their values, and where a bound is violated most.

use super::problem::Ocp;
use serde::Serialize;
use std::ops::Range;

/// The values of a path or norm constraint along a run.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintTrace {
    /// Its name; empty where it has none.
    pub name: String,
    /// The constrained quantity at every grid point; where it uses an input, that of the end is taken with the last input.
    pub values: Vec<f64>,
    /// Smallest value at every grid point; negative infinity is none.
    pub min: Vec<f64>,
    /// Largest value at every grid point; infinity is none.
    pub max: Vec<f64>,
    /// Grid points at which it has to hold.
    pub holds: Range<usize>,
}

/// Which end of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundSide {
    /// The lower one.
    Min,
    /// The upper one.
    Max,
}

/// What is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bounded {
    /// A state, by its index.
    State(usize),
    /// An input, by its index.
    Input(usize),
    /// A path constraint, or after them a norm constraint, by its index.
    Constraint(usize),
}

/// The largest violation of a bound along a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestViolation {
    /// What is bounded.
    pub of: Bounded,
    /// Which of its bounds.
    pub side: BoundSide,
    /// By how much, in its own unit; NaN where its value is no number.
    pub by: f64,
    /// At which grid point.
    pub sample: usize,
}

/// What rounding adds to a value on its bound, relative to the largest along the run.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl LargestViolation {
    /// The larger of what was found before and this one, if it is one; what is no number counts most.
    fn or(
        found: Option<Self>,
        of: Bounded,
        sample: usize,
        (v, size): (f64, f64),
        (min, max): (f64, f64),
    ) -> Option<Self> {
        let (below, above) = (min - v, v - max);
        let side = if below > above { BoundSide::Min } else { BoundSide::Max };
        let by = if below > above { below } else { above };
        let bounded = min != f64::NEG_INFINITY || max != f64::INFINITY;
        let larger = match &found {
            Some(f) => !f.by.is_nan() && (by.is_nan() || by > f.by),
            // A value that rounding put past a bound on which it lies keeps it.
            None => by.is_nan() || by > ROUNDING * size,
        };
        if bounded && larger { Some(Self { of, side, by, sample }) } else { found }
    }
}

impl Ocp {
    /// The values of the path constraints, and after them the norm constraints, along a run with states x (the previous inputs
    /// included) and inputs u (one fewer).
    pub fn constraint_traces(&mut self, x: &[Vec<f64>], u: &[Vec<f64>]) -> Vec<ConstraintTrace> {
        let (steps, dt) = (u.len(), self.dt);
        let last = u.last().map_or(&[][..], Vec::as_slice);
        let input = |k: usize| u.get(k).map_or(last, Vec::as_slice);
        let mut traces = Vec::new();
        let mut path = std::mem::take(&mut self.path_constraints);
        for c in &mut path {
            let value =
                |(k, x): (usize, &Vec<f64>)| c.function.values(x, input(k), k as f64 * dt, self.reference(k))[0];
            let values: Vec<f64> = x.iter().enumerate().map(value).collect();
            let (min, max) = (vec![c.bounds.min; values.len()], vec![c.bounds.max; values.len()]);
            traces.push(ConstraintTrace { name: c.name.clone(), values, min, max, holds: c.grid_points(steps) });
        }
        self.path_constraints = path;
        let mut norm = std::mem::take(&mut self.norm_constraints);
        for c in &mut norm {
            let (mut values, mut max) = (Vec::new(), Vec::new());
            for (k, x) in x.iter().enumerate() {
                let (t, r) = (k as f64 * dt, self.reference(k));
                values.push(c.vector.values(x, input(k), t, r).iter().map(|v| v * v).sum::<f64>().sqrt());
                max.push(c.limit.values(x, input(k), t, r)[0]);
            }
            let min = vec![f64::NEG_INFINITY; values.len()];
            traces.push(ConstraintTrace { name: c.name.clone(), values, min, max, holds: c.grid_points(steps) });
        }
        self.norm_constraints = norm;
        traces
    }

    /// The largest violation of a bound of a state (from the second grid point on) or input along a run, or of a constraint by its
    /// `traces`; none where all are kept.
    pub fn worst_violation(
        &self,
        x: &[Vec<f64>],
        u: &[Vec<f64>],
        traces: &[ConstraintTrace],
    ) -> Option<LargestViolation> {
        let mut found = None;
        let sizes = |rows: &[Vec<f64>], count: usize| -> Vec<f64> {
            (0..count).map(|i| rows.iter().map(|row| row[i].abs()).fold(0.0, f64::max)).collect()
        };
        let (of_states, of_inputs) = (sizes(x, self.state_bounds.len()), sizes(u, self.input_bounds.len()));
        for (k, x) in x.iter().enumerate().skip(1) {
            for (i, (v, b)) in x.iter().zip(&self.state_bounds).enumerate() {
                found = LargestViolation::or(found, Bounded::State(i), k, (*v, of_states[i]), (b.min, b.max));
            }
        }
        for (k, u) in u.iter().enumerate() {
            for (j, (v, b)) in u.iter().zip(&self.input_bounds).enumerate() {
                found = LargestViolation::or(found, Bounded::Input(j), k, (*v, of_inputs[j]), *b);
            }
        }
        for (c, trace) in traces.iter().enumerate() {
            let size = trace.values.iter().map(|v| v.abs()).fold(0.0, f64::max);
            for k in trace.holds.clone() {
                let bounds = (trace.min[k], trace.max[k]);
                found = LargestViolation::or(found, Bounded::Constraint(c), k, (trace.values[k], size), bounds);
            }
        }
        found
    }
}
