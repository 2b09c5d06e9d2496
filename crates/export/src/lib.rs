//! The equations of a [`System`](bracketry_system::System) with their Jacobians as source code.
//!
//! [`export`] writes x' = f(t, x, u), y = h(t, x, u) and the derivatives of both by x and u, for code that this project is
//! no part of: a simulator in C, an estimator in Rust, a transcription in CasADi.
//!
//! ```
//! use bracketry_export::{ExportOptions, Target, export};
//! use bracketry_system::System;
//! let text = "name = 'pendulum'\nstates = ['th', 'w']\ninputs = ['u']\nparameters = { k = 9.81 }\n\
//!     dynamics = { th = 'w', w = 'u - k*sin(th)' }\n";
//! let pendulum = System::parse("pendulum.toml", text).unwrap();
//! let made = export(&pendulum, &ExportOptions::new(Target::Julia)).unwrap();
//! assert_eq!(made.files[0].name, "Pendulum.jl");
//! assert!(made.files[0].text.contains("    return [\n        w,\n        u_ - 9.81 * sin(th),\n    ]\n"));
//! ```

mod equations;
mod error;
mod export;
mod exported;
mod identifier;
mod note;
mod options;
mod write;

pub use equations::{ExportedFunction, ExportedResult};
pub use error::ExportError;
pub use export::export;
pub use exported::{Constant, Export, Quantity, SourceFile};
pub use note::ExportNote;
pub use options::{ExportOptions, KeptParameters, Target, UnknownTarget};
