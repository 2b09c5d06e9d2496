//! Normal forms and decompositions: the system in new coordinates, with the change, its inverse, and the feedback.
//!
//! Every form is confirmed by transforming back in exact arithmetic before it is returned.

pub(crate) mod accessible;
pub(crate) mod brunovsky;
pub(crate) mod byrnes_isidori;
pub(crate) mod chained;
pub(crate) mod chained_change;
pub(crate) mod change;
pub(crate) mod completion;
pub(crate) mod flat;
pub(crate) mod frame;
pub(crate) mod inverse;
pub(crate) mod inversion;
pub(crate) mod kalman;
pub(crate) mod normal_form;
pub(crate) mod observable;
pub(crate) mod observer;
pub(crate) mod obstacle;
pub(crate) mod parts;
pub(crate) mod root;
pub(crate) mod transform;

pub use chained::{ChainedForm, ChainedForms, NoChainedForm};
pub use normal_form::{
    Block, BlockKind, Form, FormNote, FormOutcome, NormalForm, Part, PartKind, TransformError, Transformation,
    UnknownForm,
};
pub use obstacle::Obstacle;
pub use transform::{TransformOptions, transform};
