//! Interned symbolic expressions: parse, print, differentiate, simplify, decide zero and rank exactly, compile.
//!
//! Everything starts with a [`Pool`], the arena that owns the expressions.
//!
//! ```
//! use bracketry_symbolic::Pool;
//! let mut p = Pool::new();
//! let e = p.parse("x^2*sin(x)").unwrap();
//! let x = p.symbol("x");
//! let d = p.diff(e, x);
//! assert_eq!(p.text(d), "2*x*sin(x) + x^2*cos(x)");
//! ```

mod canonical;
mod closest_name;
mod collect;
mod diff;
mod exact;
mod foreign_name;
mod func;
mod function;
mod lexer;
mod matrix;
mod named;
mod node;
mod normal;
mod notation;
mod operations;
mod parse;
mod parse_error;
mod point;
mod pool;
mod random;
mod source;
mod stop_flag;
mod table;
mod tape;
mod text;
mod text_size;
mod univariate;

pub use closest_name::closest_name;
pub use dashu_ratio::RBig as Rational;
pub use exact::{
    Bindings, Certificate, Echelon, Evaluation, FieldElement, Fp, Irregular, OrderedField, Rank, Real, Residue,
    SECOND_OFFSET, Samples, THIRD_OFFSET, Undecided, ZeroTest,
};
pub use func::{Func, Func2};
pub use function::Function;
pub use named::Named;
pub use node::{Directed, Expr, Node, Symbol};
pub use notation::{Fence, Joint, Notation, Relation};
pub use parse::Names;
pub use parse_error::ParseError;
pub use point::EvaluationError;
pub use pool::Pool;
pub use random::SplitMix64;
pub use source::{Language, SourceNames, Statements};
pub use stop_flag::{Limit, Reached, StopFlag};
pub use table::{Entry, ExprTable, TableError};
pub use tape::{CompileError, Instruction, Op, Tape};
pub use text_size::TextSize;
pub use univariate::{Coefficient, RealRoot, UnivariatePolynomial};
