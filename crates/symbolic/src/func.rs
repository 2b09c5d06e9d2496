//! The elementary functions that expressions know, with their names and values.

/// Elementary functions of one argument.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Func {
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Tangent.
    Tan,
    /// Inverse sine.
    Asin,
    /// Inverse cosine.
    Acos,
    /// Inverse tangent.
    Atan,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Exponential.
    Exp,
    /// Natural logarithm.
    Log,
    /// Absolute value.
    Abs,
    /// Sign; set-valued at zero (Filippov), evaluates to 0 there.
    Sign,
}

impl Func {
    /// Every function with the name by which it is parsed and printed.
    pub const ALL: [(Func, &'static str); 13] = [
        (Func::Sin, "sin"),
        (Func::Cos, "cos"),
        (Func::Tan, "tan"),
        (Func::Asin, "asin"),
        (Func::Acos, "acos"),
        (Func::Atan, "atan"),
        (Func::Sinh, "sinh"),
        (Func::Cosh, "cosh"),
        (Func::Tanh, "tanh"),
        (Func::Exp, "exp"),
        (Func::Log, "log"),
        (Func::Abs, "abs"),
        (Func::Sign, "sign"),
    ];

    /// The name by which the function is parsed and printed.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(f, _)| *f == self).map_or("?", |(_, n)| n)
    }

    /// Value at `x`.
    pub fn eval(self, x: f64) -> f64 {
        match self {
            Func::Sin => x.sin(),
            Func::Cos => x.cos(),
            Func::Tan => x.tan(),
            Func::Asin => x.asin(),
            Func::Acos => x.acos(),
            Func::Atan => x.atan(),
            Func::Sinh => x.sinh(),
            Func::Cosh => x.cosh(),
            Func::Tanh => x.tanh(),
            Func::Exp => x.exp(),
            Func::Log => x.ln(),
            Func::Abs => x.abs(),
            Func::Sign => sign(x),
        }
    }
}

/// `sign` as a number: −1, 0 or 1, and NaN for NaN.
pub(crate) fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x * 0.0
    }
}

/// Functions of two arguments.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Func2 {
    /// `atan2(y, x)`, the angle of the point (x, y).
    Atan2,
    /// The smaller argument.
    Min,
    /// The larger argument.
    Max,
}

impl Func2 {
    /// Every function with the name by which it is parsed and printed.
    pub const ALL: [(Func2, &'static str); 3] = [(Func2::Atan2, "atan2"), (Func2::Min, "min"), (Func2::Max, "max")];

    /// The name by which the function is parsed and printed.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(f, _)| *f == self).map_or("?", |(_, n)| n)
    }

    /// Value at `(a, b)`; NaN if either is NaN.
    pub fn eval(self, a: f64, b: f64) -> f64 {
        match self {
            Func2::Atan2 => a.atan2(b),
            // Written as comparisons so that NaN goes through and machine code can do the same.
            Func2::Min => {
                if a < b || a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Func2::Max => {
                if a > b || a.is_nan() {
                    a
                } else {
                    b
                }
            }
        }
    }
}
