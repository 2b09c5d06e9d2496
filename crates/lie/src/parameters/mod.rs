//! Verdicts as functions of parameters.

pub(crate) mod aspect;
pub(crate) mod cases;
pub(crate) mod confirm;
mod decompose;
mod explore;
mod factor;
mod limits;
pub(crate) mod map;
pub(crate) mod report;
mod state_values;

pub use aspect::{Aspect, AspectValue, NotLinear};
pub use cases::parameter_cases;
pub use confirm::Confirmed;
pub use map::{MapCell, MapCurve, MapPoint, ParameterMap, ParameterRange, parameter_map};
pub use report::{AspectCases, Incomplete, ParameterCase, ParameterError, ParameterOptions, ParameterReport};
