//! Programs whose constraints are sums of squares: exact reduction, numerical solution, exact rounding.

pub(crate) mod decimals;
pub(crate) mod face;
pub(crate) mod numeric;
pub(crate) mod program;
pub(crate) mod rounding;
