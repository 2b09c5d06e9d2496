//! Control systems: model files, parameters, switching modes, affine forms, compiled right-hand sides.

mod affine;
mod document;
mod input_change;
mod model_file;
mod switching;
mod system;

pub use affine::{AffineError, AffineForm, Affinization, Method, NewInput};
pub use bracketry_symbolic as symbolic;
pub use document::{Document, FileError, Table, Value};
pub use model_file::{RESERVED, WriteError};
pub use switching::{MAX_ENUMERATED_SWITCHES, Mode, Switch, SwitchKind, SwitchedForm, TooManyModes};
pub use system::{InputDerivative, Parameter, Point, System};
