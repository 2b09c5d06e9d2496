//! Numbers in the text of an option, and what is wrong with it.

/// A message and what to do.
pub(super) type Problem = (String, String);

pub(super) fn problem(message: impl Into<String>, remedy: impl Into<String>) -> Problem {
    (message.into(), remedy.into())
}

/// Numbers separated by commas; none for an empty text.
pub(super) fn numbers(text: &str) -> Result<Vec<f64>, Problem> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(number).collect()
}

/// A finite number; with `deg` in degrees.
pub(super) fn number(text: &str) -> Result<f64, Problem> {
    let text = text.trim();
    let (digits, factor) = match text.strip_suffix("deg").or(text.strip_suffix('°')) {
        Some(degrees) => (degrees.trim(), std::f64::consts::PI / 180.0),
        None => (text, 1.0),
    };
    match digits.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v * factor),
        _ => Err(problem(format!("`{text}` is not a finite number"), "write a decimal number such as 0.12")),
    }
}
