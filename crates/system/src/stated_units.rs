//! `time_unit` and the tables `[units]` and `[labels]` of model files.

use bracketry_files::{Document, FileError, Table, Value};
use bracketry_symbolic::closest_name;

use crate::quantities::Quantities;
use crate::rules::ModelError;
use crate::system::System;
use crate::time_unit::TimeUnit;

impl System {
    /// Everything that has a unit and a label: states, inputs, outputs, algebraic variables.
    pub fn quantity_names(&self) -> Vec<String> {
        let algebraic = self.algebraic.iter().map(|z| self.symbol_name(z.symbol).to_owned());
        let outputs = self.outputs.iter().map(|o| o.0.clone());
        let own = self.state_names().into_iter().chain(self.input_names());
        // An output with the name of a state is that state.
        let mut names: Vec<String> = Vec::new();
        for name in own.chain(outputs).chain(algebraic) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// The units and labels of everything, also of parameters.
    pub fn all_quantities(&self) -> Quantities {
        let mut all = self.quantities.clone();
        for p in &self.parameters {
            if let Some(unit) = p.unit.as_ref().filter(|unit| *unit != "1") {
                all.set_unit(self.symbol_name(p.symbol), unit.clone());
            }
        }
        all
    }

    /// Whether units and labels can be stated of this name.
    ///
    /// # Errors
    /// [`ModelError`] with the names that there are.
    pub(crate) fn check_quantity(&self, name: &str) -> Result<(), ModelError> {
        let known = self.quantity_names();
        // What was eliminated is a definition now.
        if self.definitions.iter().any(|d| d.0 == name) || known.iter().any(|k| k == name) {
            return Ok(());
        }
        if self.parameter_names().iter().any(|p| p == name) {
            let message = format!("the unit of the parameter `{name}` belongs in [parameters]");
            let remedy = format!("write {name} = {{ value = 1.0, unit = \"…\", about = \"…\" }} in [parameters]");
            return Err(ModelError::new(message, remedy));
        }
        let remedy = match closest_name(name, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the model has {}", known.join(", ")),
        };
        Err(ModelError::new(format!("`{name}` is not a state, input, or output"), remedy))
    }
}

/// Reads `time_unit`, `[units]`, and `[labels]`.
pub(crate) fn read_quantities(doc: &Document, table: &Table<'_>, system: &mut System) -> Result<(), FileError> {
    if let (Some(text), Some(value)) = (doc.string(table, "time_unit")?, table.get("time_unit")) {
        system.quantities.time_unit = TimeUnit::parse(&text).ok_or_else(|| {
            let known = TimeUnit::ALL.map(|unit| format!("\"{}\"", unit.symbol())).join(", ");
            doc.error(value.span(), format!("`{text}` is not a unit of time"), format!("write one of {known}"))
        })?;
    }
    for (key, set) in [
        ("units", Quantities::set_unit as fn(&mut Quantities, &str, String)),
        ("labels", Quantities::set_label as fn(&mut Quantities, &str, String)),
    ] {
        for (name, value) in doc.sub_table(table, key)?.into_iter().flatten() {
            system.check_quantity(name.get_ref()).map_err(|e| e.at(doc, name.span()))?;
            let Value::String(text) = value.get_ref() else {
                let message = format!("the entry of `{}` in [{key}] is not text", name.get_ref());
                return Err(doc.error(value.span(), message, format!("write {} = \"…\" in quotes", name.get_ref())));
            };
            set(&mut system.quantities, name.get_ref(), text.to_string());
        }
    }
    Ok(())
}
