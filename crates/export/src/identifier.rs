//! Names of modules and files.

use crate::error::ExportError;

/// The name of a model, which may be any text or the path of its file, as an identifier in lower case with `_`.
pub(crate) fn identifier(model: &str) -> String {
    let stem = model.strip_suffix(".toml").map_or(model, |path| path.rsplit(['/', '\\']).next().unwrap_or(path));
    let mut name = String::new();
    for c in stem.chars() {
        if c.is_ascii_alphanumeric() {
            name.push(c.to_ascii_lowercase());
        } else if !name.is_empty() && !name.ends_with('_') {
            name.push('_');
        }
    }
    let name = name.trim_end_matches('_');
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name.to_owned()
    } else {
        format!("model_{name}").trim_end_matches('_').to_owned()
    }
}

/// A name that was asked for.
pub(crate) fn checked(name: &str) -> Result<String, ExportError> {
    let good = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if good { Ok(name.to_owned()) } else { Err(ExportError::Name { name: name.to_owned() }) }
}

/// `cart_pole` as `CartPole`.
pub(crate) fn camel_case(name: &str) -> String {
    let word = |w: &str| {
        let mut letters = w.chars();
        letters.next().map_or_else(String::new, |first| format!("{}{}", first.to_ascii_uppercase(), letters.as_str()))
    };
    let camel: String = name.split('_').map(word).collect();
    // The modules that every Julia module sees.
    if matches!(camel.as_str(), "Base" | "Core" | "Main") { format!("{camel}Model") } else { camel }
}
