//! Names of other languages and of textbooks, and what they are called here.

/// There are no conditional expressions.
const CASES: &str = "there is no `if`: write cases with `sign`, `abs`, `min`, and `max`, such as `(1 + sign(x))/2`";

/// What to write instead of a function that other languages have.
pub(crate) fn instead_of_function(name: &str) -> Option<&'static str> {
    Some(match name {
        "sgn" | "signum" => "write `sign(…)`",
        "ln" => "write `log(…)`, which is the natural logarithm",
        "log10" | "lg" => "write `log(…)/log(10)`",
        "log2" | "ld" => "write `log(…)/log(2)`",
        "cot" | "ctg" => "write `1/tan(…)`",
        "sec" => "write `1/cos(…)`",
        "csc" | "cosec" => "write `1/sin(…)`",
        "coth" => "write `1/tanh(…)`",
        "tg" => "write `tan(…)`",
        "arcsin" => "write `asin(…)`",
        "arccos" => "write `acos(…)`",
        "arctan" | "arctg" => "write `atan(…)`",
        "arctan2" => "write `atan2(…, …)`",
        "asinh" | "arsinh" | "arcsinh" => "write `log(x + sqrt(x^2 + 1))`",
        "acosh" | "arcosh" | "arccosh" => "write `log(x + sqrt(x^2 - 1))`",
        "atanh" | "artanh" | "arctanh" => "write `log((1 + x)/(1 - x))/2`",
        "fabs" => "write `abs(…)`",
        "pow" | "power" => "write `x^k`",
        "cbrt" => "write `x^(1/3)`",
        "hypot" => "write `sqrt(x^2 + y^2)`",
        "heaviside" | "Heaviside" | "step" => "write `(1 + sign(…))/2`",
        "relu" | "ReLU" => "write `max(…, 0)`",
        "sat" | "saturate" | "clip" | "clamp" => "write `min(max(x, lower), upper)`",
        "if" | "ifelse" | "where" | "piecewise" | "Piecewise" => CASES,
        "diff" | "ddt" => "the derivative of an input is `der(u)`; that of a state is its equation",
        _ => return None,
    })
}

/// What to write instead of a name that other languages have.
pub(crate) fn instead_of_name(name: &str) -> Option<&'static str> {
    Some(match name {
        "e" | "E" => "Euler's number is `exp(1)`",
        "Pi" | "PI" | "π" => "write `pi`",
        "t" | "time" => {
            "equations do not depend on time: add an input for a given function of time, or a state with the rate 1"
        }
        "inf" | "Inf" | "infinity" | "nan" | "NaN" => "write a finite number",
        "if" | "then" | "else" | "and" | "or" | "not" => CASES,
        _ => return None,
    })
}
