//! Control systems: model files, parameters, switching modes, affine forms, compiled right-hand sides.
//!
//! ```
//! use bracketry_system::System;
//! let block = System::parse(
//!     "block.toml",
//!     "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 2 }\ndynamics = { x = 'v', v = 'u/m - sign(v)' }",
//! )
//! .unwrap();
//! assert_eq!(block.state_names(), ["x", "v"]);
//! // What is wrong has a place and a remedy.
//! let error = System::parse("block.toml", "states = ['x']\ndynamics = { x = 'y' }").unwrap_err();
//! assert!(error.to_string().contains("block.toml:2:"));
//! ```

mod affine;
mod augment;
mod builder;
mod candidate;
mod closest_approach;
mod constants;
mod directions;
mod discrete_time;
mod enclosure;
mod extrema;
mod feedback;
mod hull;
mod image_on_box;
mod images;
mod implicit;
mod input_change;
mod input_delay;
mod interval;
mod inverse;
mod least_value;
mod linear_solution;
mod lowering;
mod model_file;
mod model_text;
mod new_input;
mod new_state;
mod point_text;
mod quantities;
mod quotient_kind;
mod range;
mod range_note;
mod rational_function;
mod readable;
mod reason;
mod rules;
mod scope;
mod separable;
mod separation;
mod single_valued;
mod singular;
mod stated_units;
mod static_level;
mod sum_of_squares;
mod switching;
mod system;
mod term;
mod time_unit;
mod trend;
mod unit_vector;
mod unknown_range;
mod zero_denominator;

pub use affine::{AffineForm, Affinization};
pub use bracketry_files::{Columns, Document, Entries, FileError, Table, Unit, Value};
pub use bracketry_symbolic as symbolic;
pub use builder::Builder;
pub use candidate::{Candidate, Method};
pub use closest_approach::ClosestApproach;
pub use constants::Constants;
pub use inverse::solved_for;
pub use least_value::LeastValue;
pub use model_file::Accepted;
pub use model_text::WriteError;
pub use new_input::{AtPoint, NewInput};
pub use new_state::NewState;
pub use point_text::{PointError, point};
pub use quantities::{Quantities, with_unit};
pub use range::{Bound, Range};
pub use range_note::RangeNote;
pub use readable::{counted, readable};
pub use reason::{AffineError, AffineReason, Nonlinearity, Rejection};
pub use rules::{ModelError, RESERVED};
pub use single_valued::SingleValued;
pub use singular::{Level, SingularSet};
pub use switching::{
    MAX_ENUMERATED_SWITCHES, Mode, SingularQuotient, Switch, SwitchKind, SwitchedForm, TooManyModes, UnitVector,
};
pub use system::{
    Algebraic, Eliminated, InputDelay, InputDerivative, InputRange, Parameter, Point, StaticLevel, System,
};
pub use term::{Operand, Term};
pub use time_unit::TimeUnit;
pub use unknown_range::UnknownRange;
pub use zero_denominator::ZeroDenominator;
