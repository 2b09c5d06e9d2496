//! Operating points, and the linear system around one.

pub(crate) mod confirm;
pub(crate) mod equations;
pub(crate) mod gains;
pub(crate) mod linear_model;
pub(crate) mod linearize;
pub(crate) mod solver;
pub(crate) mod trim;
