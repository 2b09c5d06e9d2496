//! Models written as source code: text and JSON.

use std::fmt::Write;

use bracketry_export::{Export, ExportedFunction, ExportedResult, Quantity};
use serde_json::{Map, Value, json};

/// What was written, in lines: files, functions with their arrays, arguments, notes.
pub fn export_text(export: &Export) -> String {
    let files: Vec<&str> = export.files.iter().map(|f| f.name.as_str()).collect();
    let arguments = if export.parameters.is_empty() { "t, x, u" } else { "t, x, u, p" };
    let mut out = format!("{} in {}: {}\n", export.model, export.target.title(), files.join(", "));
    for f in &export.functions {
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {}({arguments}) = {}: {}; {} operations", f.name, arrays(f), f.about(), f.operations);
    }
    let mut list = |array: &str, names: Vec<&str>| {
        if !names.is_empty() {
            let _ = writeln!(out, "  {array} = {}", names.join(", "));
        }
    };
    let names = |list: &'_ [Quantity]| list.iter().map(|q| q.name.clone()).collect::<Vec<_>>();
    for (array, quantities) in [("x", &export.states), ("u", &export.inputs), ("y", &export.outputs)] {
        list(array, names(quantities).iter().map(String::as_str).collect());
    }
    list("p", export.parameters.iter().map(|p| p.name.as_str()).collect());
    if !export.constants.is_empty() {
        let constants: Vec<String> = export.constants.iter().map(|p| format!("{} = {:?}", p.name, p.value)).collect();
        let _ = writeln!(out, "  constants: {}", constants.join(", "));
    }
    for note in &export.notes {
        let _ = writeln!(out, "note: {note}");
    }
    out
}

fn arrays(f: &ExportedFunction) -> String {
    let array = |r: &ExportedResult| match r.columns {
        None => format!("{} ({})", r.name, r.rows),
        Some(m) => format!("{} ({} × {m})", r.name, r.rows),
    };
    f.results.iter().map(array).collect::<Vec<_>>().join(", ")
}

/// The export as JSON: quantities, functions, notes with their `text`, files with their `text`.
pub fn export_json(export: &Export) -> Value {
    let mut value = json!(export);
    let notes = export.notes.iter().map(|n| {
        let mut entry = json!(n).as_object().cloned().unwrap_or_else(Map::new);
        entry.insert("text".to_owned(), Value::String(n.to_string()));
        Value::Object(entry)
    });
    if let Some(entries) = value.as_object_mut() {
        entries.insert("notes".to_owned(), notes.collect());
    }
    value
}
