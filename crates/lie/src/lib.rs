//! Lie brackets, distributions, accessibility and the functions that no input influences.
//!
//! The system is control-affine, `x' = f(x) + Σ u_i g_i(x)`. Which states the inputs can reach is
//! decided by the Lie algebra of f and the g_i under the bracket `[a, b] = Db·a − Da·b`. Every
//! rank is exact, modulo a large prime at random points, with the probability of error in the report.
//!
//! [`analyse`] gives the whole report on a [`System`](bracketry_system::System); [`VectorFields`]
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

mod analyse;
mod answer;
mod autonomous;
mod brockett;
mod closure;
mod control_report;
mod display;
mod error;
mod evidence;
mod extension;
mod family;
mod fields;
mod flatness;
mod flatness_report;
mod growth;
mod hall;
mod input_output;
mod inputs;
mod integrals;
mod involutive;
mod kernel;
mod linear;
mod linearization;
mod local;
mod matrix;
mod merge;
mod minimum_phase;
mod modes;
mod naming;
mod necessary;
mod nilpotent;
mod observability;
mod observe;
mod point_report;
mod ranges;
mod rational;
mod reduce;
mod relative_degree;
mod report;
mod requested;
mod residues;
mod sign;
mod stlc;
mod sussmann;
mod switching;
mod symmetry;
mod word;
mod zero_dynamics;

pub use analyse::{ModeFields, Options, analyse, mode_fields};
pub use answer::Answer;
pub use closure::Closure;
pub use control_report::{ControlReport, LinearizationReport};
pub use error::{Error, Undecided};
pub use evidence::Evidence;
pub use extension::{DynamicExtension, ExtensionLimits};
pub use family::{Family, family_dimensions};
pub use fields::{Field, VectorFields, adjoint, bracket};
pub use flatness_report::{ExtensionReport, FlatnessReport, FlatnessVerdict};
pub use hall::{HallBasis, HallElement, HallTooLarge, witt, witt_degrees};
pub use input_output::{Eigenvalue, InputOutputReport, ZeroDynamicsReport};
pub use integrals::{Integrals, integrals};
pub use involutive::{InvolutiveClosureReport, involutive_closure};
pub use linearization::{LinearizationFlag, LinearizingOutputs};
pub use local::{Limits, LocalAccessibility};
pub use minimum_phase::MinimumPhase;
pub use modes::Mode;
pub use nilpotent::LieAlgebra;
pub use observability::Observability;
pub use observe::{Direction, ObservabilityReport, observe};
pub use ranges::{InputValues, Side};
pub use relative_degree::RelativeDegree;
pub use report::{Dimensions, ModeReport, Named, PointReport, Report, SmoothedReport, Subject};
pub use stlc::{GeneralCondition, Stlc, Verdict};
pub use sussmann::Obstruction;
pub use switching::{Switchable, SwitchedReport};
pub use word::{Word, WordError, WordProblem};
pub use zero_dynamics::{NoZeroDynamics, ZeroDynamics};
