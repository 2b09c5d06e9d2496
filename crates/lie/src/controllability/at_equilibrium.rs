//! What verdicts on stabilizability rest on.

use bracketry_symbolic::Expr;

use crate::algebra::closure::Closure;
use crate::answer::Answer;
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::Side;
use crate::controllability::local_accessibility::{Frame, LocalAccessibility};
use crate::controllability::stlc::Stlc;
use crate::residues::Fp;

/// What is known of an equilibrium.
pub(crate) struct AtEquilibrium<'a> {
    pub(crate) frame: &'a Frame,
    /// Rank of Kalman's matrix.
    pub(crate) rank: usize,
    /// The input fields at the point.
    pub(crate) inputs: &'a [Vec<Fp>],
    /// Whether the modes that no input reaches decay.
    pub(crate) decays: Answer<bool>,
    /// Dimensions of the accessibility algebra and of its strong part: generic and at the point.
    pub(crate) generic: [usize; 2],
    pub(crate) local: &'a LocalAccessibility,
    /// The accessibility distribution.
    pub(crate) reach: &'a Closure,
    pub(crate) stlc: &'a Stlc,
    pub(crate) sides: &'a [Option<Side>],
    /// The inputs with their ranges, and their values at the point.
    pub(crate) set: &'a InputSet<'a>,
    pub(crate) values: &'a [Expr],
}
