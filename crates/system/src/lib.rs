//! Control systems: model files, parameters, switching modes, affine forms, compiled right-hand sides.

mod affine;
mod augment;
mod candidate;
mod feedback;
mod hull;
mod input_change;
mod input_delay;
mod interval;
mod inverse;
mod lowering;
mod model_file;
mod model_text;
mod polynomial;
mod range;
mod rational_function;
mod readable;
mod separation;
mod singular;
mod static_level;
mod sum_of_squares;
mod switching;
mod system;
mod trend;
mod unit_vector;
mod zero_denominator;

pub use affine::{AffineError, AffineForm, Affinization};
pub use bracketry_files::{Columns, Document, Entries, FileError, Table, Value};
pub use bracketry_symbolic as symbolic;
pub use candidate::{AtPoint, Candidate, Method, NewInput, NewState};
pub use model_file::RESERVED;
pub use model_text::WriteError;
pub use range::{Bound, Range};
pub use readable::{counted, readable};
pub use switching::{MAX_ENUMERATED_SWITCHES, Mode, Switch, SwitchKind, SwitchedForm, TooManyModes, UnitVector};
pub use system::{InputDelay, InputDerivative, InputRange, Parameter, Point, StaticLevel, System};
pub use zero_denominator::ZeroDenominator;
