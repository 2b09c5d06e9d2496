//! How many cases are tried.

use proptest::prelude::ProptestConfig;

fn is_full() -> bool {
    std::env::var_os("BRACKETRY_FULL_TESTS").is_some()
}

/// That many random cases; in the full tier (`BRACKETRY_FULL_TESTS`) twenty times as many.
pub(crate) fn cases(few: u32) -> ProptestConfig {
    ProptestConfig::with_cases(if is_full() { 20 * few } else { few })
}

/// The first ones of a list of cases; in the full tier all of them.
pub(crate) fn first<T>(few: usize, all: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
    all.into_iter().take(if is_full() { usize::MAX } else { few })
}
