//! One recorded run: times, inputs, measured quantities.

use crate::read::Audit;
use crate::signal::{Measured, Signal};

/// One recorded run.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name, for messages: the file it was read from.
    pub name: String,
    /// Times in seconds, increasing.
    pub times: Vec<f64>,
    /// Index of the first sample after each gap in time; the run starts at 0, which is not listed.
    pub gaps: Vec<usize>,
    /// One signal per input of the model, in order.
    pub inputs: Vec<Signal>,
    /// One signal per input derivative that the model uses, in the order of `System::input_derivatives`.
    pub input_derivatives: Vec<Signal>,
    /// What was measured.
    pub measured: Vec<Measured>,
    /// What was noticed when it was read; none for a record made by other means.
    pub audit: Option<Audit>,
}
