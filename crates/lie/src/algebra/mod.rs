//! The algebra of vector fields: brackets, bases, distributions and their integrals.

pub(crate) mod annihilator;
pub(crate) mod antiderivative;
pub(crate) mod closure;
pub(crate) mod combination;
pub(crate) mod constant_span;
pub(crate) mod field;
pub(crate) mod hall;
pub(crate) mod integrals;
pub(crate) mod involutive;
pub(crate) mod krylov;
pub(crate) mod lie_algebra;
pub(crate) mod linear_fields;
pub(crate) mod matrix;
pub(crate) mod merge;
pub(crate) mod naming;
pub(crate) mod peel;
pub(crate) mod rational;
pub(crate) mod reduce;
pub(crate) mod span;
pub(crate) mod subsets;
pub(crate) mod word;

pub use crate::error::{WordError, WordProblem};
pub use closure::Closure;
pub use field::{Field, VectorFields, adjoint, bracket};
pub use hall::{HallBasis, HallElement, HallTooLarge, witt, witt_degrees};
pub use integrals::search::{Integrals, integrals};
pub use involutive::involutive_closure;
pub use lie_algebra::LieAlgebra;
pub use word::{Bracket, Generator, Word, generators};
