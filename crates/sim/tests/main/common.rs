//! What the random tests share.

use proptest::test_runner::{Config as ProptestConfig, RngSeed};

/// That many cases, the same ones in every run; in the full tier (`BRACKETRY_FULL_TESTS`) ten times as many, new ones in every run.
pub(crate) fn random_cases(n: u32) -> ProptestConfig {
    let full = std::env::var_os("BRACKETRY_FULL_TESTS").is_some();
    let (cases, rng_seed) = if full { (10 * n, RngSeed::Random) } else { (n, RngSeed::Fixed(20_260)) };
    ProptestConfig { rng_seed, failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}
