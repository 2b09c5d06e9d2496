//! One recorded run: times, inputs, measured quantities.

use bracketry_sim::Hold;

use crate::read::Audit;

/// What a measured column stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A state, by index.
    State(usize),
    /// An output of the model, by index.
    Output(usize),
}

/// A measured column.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Name of the column.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// One value per time; NaN where it was lost.
    pub values: Vec<f64>,
    /// Standard deviation of the noise, in the column's unit, estimated from the column itself.
    pub noise: f64,
}

/// The samples of one input or of one derivative of an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// One finite value per time.
    pub values: Vec<f64>,
    /// How it continues between samples.
    pub hold: Hold,
}

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
