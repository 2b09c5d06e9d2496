//! What the outputs tell about states and parameters.

pub(crate) mod codistribution;
pub(crate) mod report;
pub(crate) mod symmetry;
