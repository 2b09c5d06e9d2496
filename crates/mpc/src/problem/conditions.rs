//! What stands between controller and plant of a problem.

use crate::closed_loop::Fault;
use std::ops::Range;

/// What stands between the controller and the plant of a problem.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunConditions {
    /// Standard deviation of the noise on every measured quantity, in its unit; zeros for none.
    pub noise: Vec<f64>,
    /// Seed of the noise.
    pub seed: u64,
    /// Samples between a measurement and the application of the input that answers it.
    pub delay: usize,
    /// Whether the controller predicts over the delay.
    pub compensate_delay: bool,
    /// Whether the run keeps the predicted trajectory of every sample.
    pub keep_predictions: bool,
    /// What goes wrong, with the samples at which it does.
    pub faults: Vec<(Range<usize>, Fault)>,
}

impl RunConditions {
    /// What goes wrong at sample k.
    pub fn faults_at(&self, k: usize) -> Vec<Fault> {
        self.faults.iter().filter(|(range, _)| range.contains(&k)).map(|(_, fault)| fault.clone()).collect()
    }
}
