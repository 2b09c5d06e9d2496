//! What feedback can do: relative degrees, linearization, flatness, zero dynamics.

pub(crate) mod center_pair;
pub(crate) mod characteristic;
pub(crate) mod critical;
pub(crate) mod extension;
pub(crate) mod flat_pairs;
pub(crate) mod flatness;
pub(crate) mod flatness_report;
pub(crate) mod input_output;
pub(crate) mod logarithmic_integral;
pub(crate) mod lyapunov;
pub(crate) mod minimum_phase;
pub(crate) mod outputs;
pub(crate) mod relative_degree;
pub(crate) mod report;
pub(crate) mod ruled;
pub(crate) mod static_linearization;
pub(crate) mod zero_dynamics;

pub use extension::{DynamicExtension, ExtensionLimits};
pub use flatness_report::{ExtensionReport, FlatnessReport, FlatnessVerdict};
pub use input_output::{Eigenvalue, InputOutputReport, ZeroDynamicsReport};
pub use minimum_phase::MinimumPhase;
pub use relative_degree::RelativeDegree;
pub use report::{ControlReport, LinearizationReport};
pub use static_linearization::{LinearizationFlag, LinearizingOutputs};
pub use zero_dynamics::ZeroDynamics;
