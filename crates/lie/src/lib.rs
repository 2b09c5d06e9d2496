//! Lie brackets, distributions, accessibility and the functions that no input influences.
//!
//! The system is control-affine, `x' = f(x) + Σ u_i g_i(x)`. Which states the inputs can reach is
//! decided by the Lie algebra of f and the g_i under the bracket `[a, b] = Db·a − Da·b`. Every
//! rank is exact, modulo a large prime at random points, with the probability of error in the report.
//!
//! [`analyze`] gives the whole report on a [`System`](bracketry_system::System); [`VectorFields`]
//! has the single analyses.
//!
//! ```
//! use bracketry_lie::{Evidence, VectorFields};
//! use bracketry_symbolic::{Bindings, Pool};
//! let mut p = Pool::new();
//! let states = ["x", "y", "th"].map(|s| p.symbol(s)).to_vec();
//! let mut field = |c: [&str; 3]| c.map(|s| p.parse(s).unwrap()).to_vec();
//! let drive = field(["cos(th)", "sin(th)", "0"]);
//! let turn = field(["0", "0", "1"]);
//! let drift = field(["0", "0", "0"]);
//! let unicycle = VectorFields::new(states, drift, vec![drive, turn], Bindings::new()).unwrap();
//! let mut evidence = Evidence::default();
//! let reach = unicycle.accessibility(&mut p, &mut evidence).unwrap();
//! assert_eq!(reach.growth, [2, 3]);
//! assert!(evidence.log10_error() < -15.0);
//! ```

pub mod algebra;
pub mod analysis;
mod answer;
mod as_text;
mod budget;
mod condition;
pub mod controllability;
mod dimensions;
mod error;
mod evidence;
pub mod feedback;
pub mod forms;
pub mod linear;
mod modes;
pub mod observability;
pub mod operating;
mod options;
pub mod parameters;
pub mod reason;
mod regular;
mod residues;
mod undecided;

pub use algebra::field::{Field, VectorFields, bracket};
pub use analysis::affine::analyze_affine;
pub use analysis::analyze::{Analysis, AnalysisError, analyze};
pub use analysis::report::Report;
pub use answer::Answer;
pub use bracketry_symbolic::{Function, Named};
pub use condition::Condition;
pub use error::Error;
pub use evidence::Evidence;
pub use forms::transform::transform;
pub use observability::identifiability::report::identifiability;
pub use observability::report::observe;
pub use operating::linearize::linearize;
pub use operating::trim::trim;
pub use options::{AnalysisOptions, Limits};
pub use parameters::cases::parameter_cases;
pub use parameters::map::parameter_map;
pub use undecided::Undecided;
