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

mod algebra;
mod analysis;
mod answer;
mod as_text;
mod budget;
mod condition;
mod controllability;
mod dimensions;
mod error;
mod evidence;
mod feedback;
mod forms;
mod linear;
mod modes;
mod observability;
mod operating;
mod options;
mod parameters;
mod reason;
mod residues;
mod undecided;

pub use algebra::closure::Closure;
pub use algebra::field::{Field, VectorFields, adjoint, bracket};
pub use algebra::hall::{HallBasis, HallElement, HallTooLarge, witt, witt_degrees};
pub use algebra::integrals::search::{Integrals, integrals};
pub use algebra::involutive::involutive_closure;
pub use algebra::lie_algebra::LieAlgebra;
pub use algebra::word::{Bracket, Generator, Word, generators};
pub use analysis::affine::analyze_affine;
pub use analysis::analyze::{Analysis, AnalysisError, analyze};
pub use analysis::brackets::RequestedBracket;
pub use analysis::family::{Family, family_dimensions};
pub use analysis::influence::{Influence, ReachTable, Reached};
pub use analysis::rank_change::{RankChange, Ranks};
pub use analysis::report::{Effort, ModeReport, Report, SmoothedReport};
pub use answer::Answer;
pub use bracketry_symbolic::{Function, Named};
pub use condition::Condition;
pub use controllability::input_values::{InputValues, Side};
pub use controllability::involutive::InvolutiveClosureReport;
pub use controllability::local_accessibility::LocalAccessibility;
pub use controllability::orbit::SwitchingTheorem;
pub use controllability::point::{PointReport, Subject, Vanishing};
pub use controllability::stlc::{BoundedStlc, GeneralCondition, Stlc, Verdict};
pub use controllability::sussmann::Obstruction;
pub use controllability::switched::{Switchable, SwitchedReport};
pub use controllability::uncontrollable::UncontrollableMode;
pub use dimensions::Dimensions;
pub use error::{Error, WordError, WordProblem};
pub use evidence::Evidence;
pub use feedback::extension::{DynamicExtension, ExtensionLimits};
pub use feedback::flatness_report::{ExtensionReport, FlatnessReport, FlatnessVerdict};
pub use feedback::input_output::{Eigenvalue, InputOutputReport, ZeroDynamicsReport};
pub use feedback::minimum_phase::MinimumPhase;
pub use feedback::relative_degree::RelativeDegree;
pub use feedback::report::{ControlReport, LinearizationReport};
pub use feedback::static_linearization::{LinearizationFlag, LinearizingOutputs};
pub use feedback::zero_dynamics::ZeroDynamics;
pub use forms::chained::{ChainedForm, ChainedForms, NoChainedForm};
pub use forms::normal_form::{
    Block, BlockKind, Form, FormNote, FormOutcome, NormalForm, Part, PartKind, TransformError, Transformation,
    UnknownForm,
};
pub use forms::obstacle::Obstacle;
pub use forms::transform::{TransformOptions, transform};
pub use linear::distance::Distance;
pub use linear::matrix::RationalMatrix;
pub use linear::polynomial::MultivariatePolynomial;
pub use linear::spectrum::half_planes;
pub use modes::{ModeFields, Signs, mode_fields};
pub use observability::codistribution::Observability;
pub use observability::identifiability::global::GlobalReason;
pub use observability::identifiability::report::{
    Identifiability, IdentifiabilityError, IdentifiabilityOptions, IdentifiabilityReport, identifiability,
};
pub use observability::report::{Direction, ObservabilityReport, Undetermined, observe};
pub use observability::symmetry::{Operator, Symmetry};
pub use operating::gains::{Gain, Gramians, NoGain};
pub use operating::linear_model::{LinearMatrix, LinearModel, NotLinearizable, Rest};
pub use operating::linearize::{LinearAnalysis, LinearizeError, LinearizeOptions, Pole, Rank, linearize};
pub use operating::trim::{Trim, TrimError, TrimNote, TrimOptions, TrimRole, TrimStatus, TrimValue, trim};
pub use options::{AnalysisOptions, Limits};
pub use parameters::aspect::{Aspect, AspectValue, NotLinear};
pub use parameters::cases::parameter_cases;
pub use parameters::confirm::Confirmed;
pub use parameters::map::{MapCell, MapCurve, MapPoint, ParameterMap, ParameterRange, parameter_map};
pub use parameters::report::{
    AspectCases, Incomplete, ParameterCase, ParameterError, ParameterOptions, ParameterReport,
};
pub use reason::{
    AtSwitch, BracketLimit, FamilyReason, FlatnessReason, InputCombination, MinimumPhaseReason, Monotone,
    NoZeroDynamics, Reason, StabilizableReason, StlcReason, SwitchingReason,
};
pub use undecided::Undecided;
