//! The keys `time` and `period` of models that are discrete in time: x(t + period) = f(x(t), u(t)).

use bracketry_files::{Document, FileError, Table};

/// The period in seconds of a model that is discrete in time; none in continuous time.
pub(crate) fn discrete_period(doc: &Document, table: &Table<'_>, accepted: bool) -> Result<Option<f64>, FileError> {
    let place = |key: &str| table.get(key).map_or(0..0, toml::Spanned::span);
    match doc.string(table, "time")?.as_deref() {
        None | Some("continuous") => {
            if table.contains_key("period") {
                let remedy = "add time = \"discrete\", or remove `period`";
                return Err(doc.error(place("period"), "a model in continuous time has no `period`", remedy));
            }
            return Ok(None);
        }
        Some("discrete") => {}
        Some(other) => {
            let remedy = "write time = \"continuous\" or \"discrete\"";
            return Err(doc.error(place("time"), format!("`time` cannot be `{other}`"), remedy));
        }
    }
    if !accepted {
        let message = "the model is discrete in time, which only `simulate` and `control` support";
        let remedy = "write the model in continuous time, x' = f(x, u), for everything else";
        return Err(doc.error(place("time"), message, remedy));
    }
    let remedy = "write period = 0.1: the time of one step in seconds";
    let Some(period) = doc.number(table, "period")? else {
        return Err(doc.error(place("time"), "a model that is discrete in time needs its `period`", remedy));
    };
    if !(period > 0.0 && period.is_finite()) {
        return Err(doc.error(place("period"), "the period must be positive", remedy));
    }
    let refused = [
        ("mass", "a mass matrix needs derivatives", "solve the equations for the next states"),
        ("delays", "delays of inputs need continuous time", "make the inputs of previous steps states of the model"),
        (
            "static",
            "dry friction with sticking needs continuous time",
            "remove the table, or write the model in continuous time",
        ),
    ];
    for (key, why, remedy) in refused {
        if table.contains_key(key) {
            return Err(doc.error(place(key), format!("`{key}` in a model that is discrete in time: {why}"), remedy));
        }
    }
    Ok(Some(period))
}
