//! How much a test does. `BRACKETRY_FULL_TESTS=1 cargo test --workspace` does all of it.

// A program of tests may use one of these only.
#![allow(dead_code)]

/// The usual number of cases (or a list of them), or all of them in the full tier.
pub(crate) fn cases<T>(usual: T, all: T) -> T {
    if is_full() { all } else { usual }
}

/// Whether the full tier is asked for.
pub(crate) fn is_full() -> bool {
    std::env::var_os("BRACKETRY_FULL_TESTS").is_some()
}
