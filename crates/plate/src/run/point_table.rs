//! Points in tables that options name.

use std::path::Path;

use super::option_text::{Problem, number, problem};

/// The rows of a table with the columns `names` in this order, or as many columns without names. Empty lines and lines that
/// start with `#` are no rows.
pub(super) fn rows<const N: usize>(path: &Path, names: [&str; N], remedy: &str) -> Result<Vec<[f64; N]>, Problem> {
    let place = path.display();
    let text = std::fs::read_to_string(path).map_err(|e| problem(format!("{place} cannot be read: {e}"), remedy))?;
    let mut rows = Vec::new();
    let mut named = false;
    for (k, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        if rows.is_empty() && !named && fields == names {
            named = true;
            continue;
        }
        let at = |what: String| problem(format!("{place}, line {}: {what}", k + 1), remedy);
        if fields.len() != N {
            return Err(at(format!("`{line}` has {} entries, not {N}", fields.len())));
        }
        let mut row = [0.0; N];
        for (value, field) in row.iter_mut().zip(fields) {
            *value = number(field).map_err(|p| at(p.0))?;
        }
        rows.push(row);
    }
    Ok(rows)
}
