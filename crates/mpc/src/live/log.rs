//! What a live controller measured and decided, for later.

use crate::controller::Step;
use crate::problem::ControlProblem;
use std::collections::VecDeque;

/// The last samples of a live controller as a table: time, measured outputs, applied inputs. In this form
/// `bracketry diagnose` reads it.
#[derive(Clone, Debug)]
pub struct LoopLog {
    names: Vec<String>,
    dt: f64,
    capacity: usize,
    /// Decided inputs of the last samples, for those that act later.
    pending: VecDeque<Vec<f64>>,
    first: Vec<f64>,
    delay: usize,
    rows: VecDeque<Vec<f64>>,
}

impl LoopLog {
    pub(super) fn new(problem: &ControlProblem, capacity: usize, first: &[f64]) -> Self {
        let mut names = vec!["t".to_owned()];
        names.extend(problem.measured());
        names.extend(problem.system.input_names());
        let delay = problem.conditions.delay;
        Self {
            names,
            dt: problem.ocp.dt,
            capacity: capacity.max(1),
            pending: vec![first.to_vec(); delay].into(),
            first: first.to_vec(),
            delay,
            rows: VecDeque::new(),
        }
    }

    /// The same without samples.
    pub(super) fn cleared(mut self) -> Self {
        self.rows.clear();
        self.pending = vec![self.first.clone(); self.delay].into();
        self
    }

    /// Adds a sample; the oldest one makes room for it.
    pub(super) fn add(&mut self, sample: usize, y: &[f64], step: &Step) {
        let mut decided = self.pending.pop_front().unwrap_or_default();
        let mut row = if self.rows.len() == self.capacity { self.rows.pop_front() } else { None }.unwrap_or_default();
        row.clear();
        row.push(sample as f64 * self.dt);
        row.extend_from_slice(y);
        if self.delay == 0 {
            row.extend_from_slice(&step.u);
        } else {
            row.extend_from_slice(&decided);
            decided.clone_from(&step.u);
            self.pending.push_back(decided);
        }
        self.rows.push_back(row);
    }

    /// Names of the columns: `t` (s), measured outputs, inputs.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The samples, oldest first.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.rows.iter().map(Vec::as_slice)
    }
}
