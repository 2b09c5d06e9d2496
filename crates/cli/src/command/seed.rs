//! The seed of random numbers, as the commands that draw some take it.

/// Reads a seed; the error says what one is.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}
