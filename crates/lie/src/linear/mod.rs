//! Linear algebra for linearizations: exact over the rational numbers and for small matrices of other constants, else in floating point with bounded iterations.

mod characteristic;
pub(crate) mod clusters;
pub(crate) mod distance;
pub(crate) mod dominance;
pub(crate) mod form;
pub(crate) mod matrix;
pub(crate) mod pencil;
pub(crate) mod polynomial;
pub(crate) mod program;
pub(crate) mod spectrum;
pub(crate) mod taylor;
pub(crate) mod zeros;

pub use distance::Distance;
pub use matrix::{Matrix, RationalMatrix};
pub use polynomial::MultivariatePolynomial;
pub use spectrum::half_planes;
