//! An input that is remembered for one interval.

/// An input whose value over the interval before is a state, so that costs and constraints can use its change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviousInput {
    /// Index of the input.
    pub input: usize,
    /// Smallest and largest rate (change from one interval to the next, divided by dt) that inputs of a failure policy may
    /// have. The rate of planned inputs is limited by a [`PathConstraint`](crate::ocp::PathConstraint).
    pub rate: (f64, f64),
}
