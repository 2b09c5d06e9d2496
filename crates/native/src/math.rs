//! The functions of `std` under a fixed calling convention, for machine code to call.

use bracketry_symbolic::{Func, Func2, Op};

/// A function that machine code calls back: its symbol, its number of arguments and its address.
#[derive(Clone, Copy)]
pub(crate) struct Callee {
    pub(crate) symbol: &'static str,
    pub(crate) arity: usize,
    pub(crate) address: fn() -> *const u8,
}

macro_rules! callees {
    ($($name:ident($($argument:ident),+) = $body:expr;)*) => {
        $(extern "C" fn $name($($argument: f64),+) -> f64 {
            $body
        })*
        /// Everything that compiled code may call.
        pub(crate) const CALLEES: &[Callee] = &[$(Callee {
            symbol: concat!("bracketry_", stringify!($name)),
            arity: [$(stringify!($argument)),+].len(),
            address: || $name as *const u8,
        }),*];
    };
}

callees! {
    sin(x) = x.sin();
    cos(x) = x.cos();
    tan(x) = x.tan();
    asin(x) = x.asin();
    acos(x) = x.acos();
    atan(x) = x.atan();
    sinh(x) = x.sinh();
    cosh(x) = x.cosh();
    tanh(x) = x.tanh();
    exp(x) = x.exp();
    log(x) = x.ln();
    atan2(y, x) = y.atan2(x);
    pow(x, y) = x.powf(y);
}

/// The position in [`CALLEES`] of the function behind `op`; `None` for what the processor does itself.
pub(crate) fn callee(op: Op) -> Option<usize> {
    let symbol = match op {
        Op::Pow => "bracketry_pow",
        Op::Call2(Func2::Atan2) => "bracketry_atan2",
        Op::Call(f) => match f {
            Func::Sin => "bracketry_sin",
            Func::Cos => "bracketry_cos",
            Func::Tan => "bracketry_tan",
            Func::Asin => "bracketry_asin",
            Func::Acos => "bracketry_acos",
            Func::Atan => "bracketry_atan",
            Func::Sinh => "bracketry_sinh",
            Func::Cosh => "bracketry_cosh",
            Func::Tanh => "bracketry_tanh",
            Func::Exp => "bracketry_exp",
            Func::Log => "bracketry_log",
            Func::Abs | Func::Sign => return None,
        },
        Op::Add | Op::Sub | Op::Mul | Op::Div | Op::Neg | Op::Sqrt | Op::Call2(Func2::Min | Func2::Max) => return None,
    };
    CALLEES.iter().position(|c| c.symbol == symbol)
}
