//! What most programs need: `use bracketry::prelude::*;`.
//!
//! ```
//! use bracketry::prelude::*;
//!
//! let block = System::parse(
//!     "block.toml",
//!     "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - sign(v)' }",
//! )
//! .unwrap();
//! let analysis = analyze(&block, &AnalysisOptions::default()).unwrap();
//! assert_eq!(analysis.report.modes.len(), 2); // sliding to either side
//! ```

pub use crate::{System, analyze};
pub use bracketry_lie::{Analysis, AnalysisOptions, Answer};
pub use bracketry_symbolic::{Expr, Pool};

#[cfg(feature = "report")]
pub use crate::report;
#[cfg(feature = "diagnose")]
pub use bracketry_diagnose::{
    DiagnoseError, DiagnosisSettings, Record, RecordSettings, Report as DiagnosisReport, diagnose,
};
#[cfg(feature = "control")]
pub use bracketry_mpc::{ControlError, ControlProblem, Controlled, Plant, control};
#[cfg(feature = "simulate")]
pub use bracketry_sim::{Hold, Inputs, Model, Scenario, Simulation, SimulationSettings, simulate};
