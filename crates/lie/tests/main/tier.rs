//! How many random cases are drawn.

use proptest::prelude::ProptestConfig;

/// That many random cases; in the full tier (`BRACKETRY_FULL_TESTS`) twenty times as many.
pub(crate) fn cases(few: u32) -> ProptestConfig {
    let full = std::env::var_os("BRACKETRY_FULL_TESTS").is_some();
    ProptestConfig::with_cases(if full { 20 * few } else { few })
}
