//! The languages.

/// A language in which [`Pool::source`](crate::Pool::source) and [`Tape::statements`](crate::Tape::statements) write.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Language {
    /// `pub fn name(x: f64, …) -> [f64; n]`, which needs only the standard library.
    Rust,
    /// `void name(double x, …, double out[n])`, C99 with `math.h`.
    C,
    /// `def name(x, …)`, which returns a tuple and needs the module `math`.
    ///
    /// Python raises `ZeroDivisionError`, `ValueError` or `OverflowError` where the other languages give an infinity
    /// or NaN.
    Python,
    /// The same with NumPy as `np`, for numbers of NumPy.
    NumPy,
    /// The same with CasADi as `ca`, for symbols of CasADi.
    Casadi,
    /// `function name(x, …)`, which returns a tuple, for any type of number.
    ///
    /// Julia throws `DomainError` where a root, a logarithm or a power of a negative number is none.
    Julia,
}

impl Language {
    /// Every language.
    pub const ALL: [Language; 6] =
        [Language::Rust, Language::C, Language::Python, Language::NumPy, Language::Casadi, Language::Julia];

    pub(super) fn is_python(self) -> bool {
        matches!(self, Language::Python | Language::NumPy | Language::Casadi)
    }
}
