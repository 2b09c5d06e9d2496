//! Inputs of finite sets.

use super::reader::{Key, Parsed, Reader};
use crate::ocp::Ocp;
use bracketry_system::{Table, Value};
use std::ops::Range;

impl Reader<'_> {
    /// The key `values` of an input, whose bounds become the smallest and the largest of them.
    pub(super) fn finite_input(&self, key: &Key<'_>, b: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(v) = b.get("values") else { return Ok(()) };
        let name: &str = key.get_ref();
        let remedy = format!("write {name} = {{ values = [0, 1] }}: the values that the input may take");
        if let Some((other, _)) = b.iter().find(|(other, _)| *other.get_ref() != "values") {
            let message = format!("`values` defines all of `{name}`: it cannot be combined with `{}`", other.get_ref());
            return Err(self.doc.error(other.span(), message, "remove one of them").into());
        }
        let Some(j) = self.system.input_index(name) else {
            let remedy = "write it for an input: states cannot be chosen";
            return Err(self.doc.error(v.span(), "`values` applies to an input", remedy).into());
        };
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "`values` must be a list", remedy).into());
        };
        let mut values = Vec::new();
        let (min, max) = ocp.input_bounds[j];
        for entry in list {
            let value = self.constant(entry, "values")?;
            if !(min..=max).contains(&value) {
                let message = format!("the value {value} of `{name}` is outside its range {min} to {max} in the model");
                return Err(self.doc.error(entry.span(), message, "change it, or the model's [ranges]").into());
            }
            if values.contains(&value) {
                let message = format!("the value {value} of `{name}` occurs twice");
                return Err(self.doc.error(entry.span(), message, "remove one of them").into());
            }
            values.push(value);
        }
        if values.len() < 2 {
            let remedy = format!("give two or more, or fix the input: {name} = {{ min = 1, max = 1 }}");
            return Err(self.doc.error(v.span(), format!("`{name}` has fewer than two values"), remedy).into());
        }
        values.sort_by(f64::total_cmp);
        ocp.input_bounds[j] = (values[0], values[values.len() - 1]);
        ocp.input_values.resize(ocp.input_bounds.len(), Vec::new());
        ocp.input_values[j] = values;
        Ok(())
    }

    /// Inputs at rest of finite sets: those that the table `[solve]` gives are of the set, the other ones become so.
    pub(super) fn finite_rest(&self, solve: &Table<'_>, ocp: &Ocp, rest: &mut [f64]) -> Parsed<()> {
        let given = self.doc.sub_table(solve, "rest")?;
        for (j, (rest, closest)) in rest.iter_mut().zip(ocp.inputs_at_rest()).enumerate() {
            let name = self.system.symbol_name(self.system.inputs[j]);
            if let Some(v) = given.and_then(|t| t.get(name)) {
                self.is_a_value(v.span(), j, *rest, &ocp.input_values)?;
            } else if ocp.input_values.get(j).is_some_and(|values| !values.is_empty()) {
                *rest = closest;
            }
        }
        Ok(())
    }

    /// Refuses a number that an input of a finite set does not take.
    pub(super) fn is_a_value(&self, span: Range<usize>, j: usize, value: f64, values: &[Vec<f64>]) -> Parsed<()> {
        match values.get(j).filter(|values| !values.is_empty() && !values.contains(&value)) {
            None => Ok(()),
            Some(values) => {
                let known: Vec<String> = values.iter().map(f64::to_string).collect();
                let message = format!("`{}` does not take the value {value}", self.system.input_names()[j]);
                Err(self.doc.error(span, message, format!("choose one of {}", known.join(", "))).into())
            }
        }
    }
}
