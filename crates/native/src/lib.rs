//! Machine code for expression tapes, through Cranelift.
//!
//! A [`Function`] evaluates a [`Tape`](bracketry_symbolic::Tape) by the faster
//! of two means: the tape's own interpreter, or machine code compiled for the
//! host (feature `cranelift`, on by default). Both give the same bits (only the payload of a NaN may differ): no operations are
//! fused or reassociated, and transcendental functions are those of `std`.
//!
//! ```
//! use bracketry_native::{Backend, Function, Workspace};
//! use bracketry_symbolic::{Pool, Tape};
//! let mut p = Pool::new();
//! let e = p.parse("x^2*sin(y) + 1").unwrap();
//! let arguments = [p.symbol("x"), p.symbol("y")];
//! let tape = Tape::compile(&p, &arguments, &[e]).unwrap();
//! let f = Function::new(tape);
//! // A handful of operations is not worth compiling.
//! assert_eq!(f.backend(), Backend::Tape);
//! let (mut work, mut out) = (Workspace::default(), [0.0]);
//! f.call(&[3.0, 0.0], &mut work, &mut out);
//! assert_eq!(out, [1.0]);
//! ```

// Owning and entering machine code cannot be expressed in safe Rust; nothing else in the crate needs `unsafe`.
#[cfg(feature = "cranelift")]
#[allow(unsafe_code)]
mod code;
#[cfg(not(feature = "cranelift"))]
#[path = "no_code.rs"]
mod code;
mod error;
mod function;
#[cfg(feature = "cranelift")]
mod lower;
#[cfg(feature = "cranelift")]
mod math;

pub use error::NativeError;
pub use function::{Backend, Function, Workspace};
