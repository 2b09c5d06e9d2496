//! Names that a language allows.

use std::fmt::Write;

use rustc_hash::FxHashSet;

use super::language::Language;

const RUST: &str = "\
    as async await break const continue crate dyn else enum extern false fn for if impl in let loop match mod \
    move mut pub ref return self Self static struct super trait true type unsafe use where while abstract become \
    box do final gen macro override priv try typeof unsized virtual yield f64 main";

/// Keywords up to C23, functions and macros of `math.h`, and the words of C++, where the function may be compiled too.
const C: &str = "\
    alignas alignof auto bool break case char const constexpr continue default do double else enum extern false \
    float for goto if inline int long nullptr register restrict return short signed sizeof static static_assert \
    struct switch thread_local true typedef typeof typeof_unqual union unsigned void volatile while asm fortran \
    main out sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt pow fabs abs NAN INFINITY HUGE_VAL I \
    errno unix linux M_E M_PI M_PI_2 M_PI_4 M_1_PI M_2_PI M_LN2 M_LN10 M_LOG2E M_LOG10E M_SQRT2 M_SQRT1_2 \
    M_2_SQRTPI isnan isinf isfinite isnormal signbit fpclassify DOMAIN OVERFLOW UNDERFLOW SING PLOSS TLOSS \
    X_TLOSS MAXFLOAT HUGE FP_NAN FP_ZERO FP_NORMAL FP_INFINITE FP_SUBNORMAL MATH_ERRNO math_errhandling signgam \
    and and_eq bitand bitor catch class compl concept consteval constinit const_cast decltype delete \
    dynamic_cast explicit export friend mutable namespace new noexcept not not_eq operator or or_eq private \
    protected public reinterpret_cast requires static_cast template this throw try typeid typename using virtual \
    wchar_t xor xor_eq co_await co_return co_yield char8_t char16_t char32_t";

const PYTHON: &str = "\
    ca np False None True and as assert async await break class continue def del elif else except finally for from \
    global if import in is lambda nonlocal not or pass raise return try while with yield match case type math \
    __debug__ _ float tuple";

/// Keywords, and the functions and constants of `Base` that statements use or that a local had better not hide.
const JULIA: &str = "\
    abstract as baremodule begin break catch const continue do else elseif end export false finally for function \
    global if import importall in isa let local macro module mutable outer primitive public quote return struct \
    true try type typealias using var where while sin cos tan asin acos atan sinh cosh tanh exp log sqrt abs sign \
    min max pi im ans Inf NaN Float64 String Base Core Main reshape zeros include eval";

/// Names that a language allows, each given away once.
///
/// Letters beyond ASCII become their code, anything else that is no letter or digit becomes `_`, and what is reserved or
/// taken gets a `_` at its end.
///
/// ```
/// use bracketry_symbolic::{Language, SourceNames};
/// let mut names = SourceNames::new(Language::Python);
/// assert_eq!(["lambda", "der(u)", "θ", "th", "th"].map(|n| names.name(n)), ["lambda_", "der_u", "u3b8", "th", "th_"]);
/// ```
#[derive(Clone, Debug)]
pub struct SourceNames {
    reserved: FxHashSet<&'static str>,
    taken: FxHashSet<String>,
}

impl SourceNames {
    /// No name but those that the language reserves is taken.
    pub fn new(language: Language) -> Self {
        let reserved = match language {
            Language::Rust => RUST,
            Language::C => C,
            Language::Python | Language::NumPy | Language::Casadi => PYTHON,
            Language::Julia => JULIA,
        };
        Self { reserved: reserved.split_whitespace().collect(), taken: FxHashSet::default() }
    }

    /// A name like `wanted` that is allowed and new.
    pub fn name(&mut self, wanted: &str) -> String {
        let mut name = String::new();
        for c in wanted.chars() {
            if c.is_ascii_alphanumeric() || c == '_' {
                name.push(c);
            } else if c.is_alphabetic() {
                // Writing to a string does not fail.
                let _ = write!(name, "u{:x}", u32::from(c));
            } else {
                name.push('_');
            }
        }
        // der(u) becomes der_u.
        while name.len() > 1 && name.ends_with('_') && !wanted.ends_with('_') {
            name.pop();
        }
        if name.starts_with(|c: char| c.is_ascii_digit()) || name.chars().all(|c| c == '_') {
            name.insert(0, 'x');
        }
        // Two leading underscores, or one and a capital, belong to C compilers.
        if name.starts_with('_') {
            name.insert(0, 'x');
        }
        while self.reserved.contains(name.as_str()) || self.taken.contains(&name) {
            name.push('_');
        }
        self.taken.insert(name.clone());
        name
    }

    /// What no name continues with a digit: locals are this and a number.
    pub fn prefix(&self) -> String {
        let mut prefix = String::from("t");
        let clash = |p: &str| {
            self.taken.iter().any(|n| n.strip_prefix(p).is_some_and(|r| r.starts_with(|c: char| c.is_ascii_digit())))
        };
        while clash(&prefix) {
            prefix.push('_');
        }
        prefix
    }
}
