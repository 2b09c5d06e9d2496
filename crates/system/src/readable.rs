//! Numbers for a reader.

/// Seven significant digits without zeros at the end, with an exponent where a plain number would be long; −0 is 0.
///
/// ```
/// use bracketry_system::readable;
/// assert_eq!([0.5, -0.0, 1.0 / 3.0, 123456789.0].map(readable), ["0.5", "0", "0.3333333", "1.234568e8"]);
/// ```
pub fn readable(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if value.is_finite() && !(1e-4..1e7).contains(&size) { format!("{rounded:e}") } else { rounded.to_string() }
}

/// A number of things, with their name in the singular or the plural.
///
/// ```
/// use bracketry_system::counted;
/// assert_eq!([1, 2].map(|n| counted(n, "step", "steps")), ["1 step", "2 steps"]);
/// ```
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
