//! Numerical methods that the other crates share, each idea once.
//!
//! Sizes are those of control problems: matrices of up to some dozen rows, tables of up to a million samples. Whatever iterates has a
//! bound, and says where it did not get to its end.
//!
//! ```
//! use bracketry_numerics::statistics::{median, rms};
//! assert_eq!(median(vec![0.3, -0.1, 0.2]), Some(0.2));
//! assert_eq!(rms([3.0, -4.0, f64::NAN].into_iter()), 12.5f64.sqrt());
//! ```

pub mod collocation;
#[cfg(feature = "dense")]
pub mod dense;
pub mod eigen;
pub mod least_squares;
pub mod linear_equations;
pub mod matrix_equations;
#[cfg(feature = "dense")]
pub mod rows;
mod singular_values;
pub mod spline;
pub mod statistics;
