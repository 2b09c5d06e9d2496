//! The library of causes: effects instantiated on a model from its structure alone.

mod actuators;
mod apply;
mod builder;
mod candidates;
mod dictionary;
mod forces;
mod friction;
mod hidden;
mod hysteresis;
mod inertia;
mod joints;
mod jumps;
mod names;
mod paths;
mod physical_terms;
mod probe;
mod reference;
mod replace;
mod separate;
mod stretch;
mod structure;
mod terms;

pub(crate) use apply::{apply_all, decimal, parameter};
pub use candidates::candidates;
pub use dictionary::dictionary;
pub(crate) use hidden::hidden_states;
pub(crate) use jumps::{Jump, jumps};
pub use names::TIME_INPUT;
pub(crate) use names::{ModelNames, derivative_name, input_index, state_index, symbols, unknown};
pub use reference::reference_candidates;
pub(crate) use separate::OF_COLUMNS;
pub use separate::separating_experiment;
pub(crate) use structure::{Kind, Structure, is_angle};
