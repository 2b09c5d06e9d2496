//! The rates of inputs in a problem file: `rate(u)` in costs and constraints, and `rate = { min, max }` of an input.

use super::reader::{Key, Located, Parsed, Reader};
use crate::ocp::{Bounds, Ocp, PathConstraint, Remembered, Softness};
use crate::problem::ProblemError;
use bracketry_symbolic::Rational;
use bracketry_system::{Table, Value};

impl Reader<'_> {
    /// The inputs whose rates costs and constraints use, for a period `dt`.
    pub(super) fn input_rates(&self, table: &Table<'_>, dt: f64) -> Parsed<Remembered> {
        let mut used = vec![false; self.system.inputs.len()];
        for name in ["cost", "constraints"] {
            for (key, v) in self.doc.sub_table(table, name)?.into_iter().flatten() {
                if let (Value::Table(b), Some(j)) = (v.get_ref(), self.system.input_index(key.get_ref())) {
                    used[j] |= b.contains_key("rate");
                }
                let at_end = name == "cost" && key.get_ref().starts_with("terminal");
                self.note_rates(v, at_end, &mut used)?;
            }
        }
        let inputs = (0..used.len()).filter(|&j| used[j]).collect();
        let period = Rational::simplest_from_f64(dt).unwrap_or_default();
        Ok(Remembered { inputs, period, ..Remembered::default() })
    }

    /// Notes the inputs whose rates a value uses.
    fn note_rates(&self, v: Located<'_, '_>, at_end: bool, used: &mut [bool]) -> Parsed<()> {
        match v.get_ref() {
            Value::Array(list) => list.iter().try_for_each(|v| self.note_rates(v, at_end, used)),
            Value::Table(t) => t.values().try_for_each(|v| self.note_rates(v, at_end, used)),
            Value::String(text) => rate_arguments(text).try_for_each(|name| {
                let Some(j) = self.system.input_index(name) else {
                    let remedy = format!(
                        "name an input: {}. The rate of a state is the right side of its equation",
                        self.system.input_names().join(", ")
                    );
                    return Err(self
                        .doc
                        .error(v.span(), format!("`{name}` in `rate({name})` is not an input of the model"), remedy)
                        .into());
                };
                if at_end {
                    let message = format!("`rate({name})` in a terminal cost: the end of the horizon has no input");
                    return Err(self.doc.error(v.span(), message, "write it in `stage` or `residuals`").into());
                }
                used[j] = true;
                Ok(())
            }),
            _ => Ok(()),
        }
    }

    /// The bounds `rate` of an input: hard, and those of the inputs of a failure policy too.
    pub(super) fn rate_bounds(
        &self,
        key: &Key<'_>,
        b: &Table<'_>,
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        let Some(v) = b.get("rate") else { return Ok(()) };
        let name: &str = key.get_ref();
        let remedy = format!("write {name} = {{ rate = {{ min = -1, max = 1 }} }}: change per second");
        let of_input = !b.contains_key("expression") && !b.contains_key("norm");
        let Some(j) = self.system.input_index(name).filter(|_| of_input) else {
            let remedy = "write it with the bounds of an input, or use rate(…) in the expression";
            return Err(self.doc.error(v.span(), "`rate` applies to an input", remedy).into());
        };
        let Value::Table(ends) = v.get_ref() else {
            return Err(self.doc.error(v.span(), format!("the rate of `{name}` must be a table"), remedy).into());
        };
        self.doc.only_keys(ends, &["min", "max"], "a rate")?;
        if ends.is_empty() {
            return Err(self.doc.error(v.span(), format!("the rate of `{name}` has no bounds"), remedy).into());
        }
        let min = self.number(ends, "min", Some(f64::NEG_INFINITY))?.0;
        let max = self.number(ends, "max", Some(f64::INFINITY))?.0;
        if !(min..=max).contains(&0.0) {
            let message = format!("a rate of `{name}` between {min} and {max} forbids holding it");
            return Err(self.doc.error(v.span(), message, "choose min ≤ 0 ≤ max").into());
        }
        let own = toml::Spanned::new(v.span(), Value::String(format!("rate({name})").into()));
        let function = self.compiled(self.vector(&[(&own, "rate")], names)?, names)?;
        let bounds = Bounds { min, max, softness: Softness::Hard };
        ocp.path_constraints.push(PathConstraint { name: format!("rate({name})"), function, bounds, at_end: false });
        for p in ocp.previous_inputs.iter_mut().filter(|p| p.input == j) {
            p.rate = (min, max);
        }
        Ok(())
    }
}

/// What stands between the parentheses of every `rate(…)` in an expression.
fn rate_arguments(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices("rate").filter_map(|(at, word)| {
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        let argument = text[at + word.len()..].trim_start().strip_prefix('(')?;
        (!text[..at].ends_with(is_name)).then(|| argument.split(')').next().unwrap_or_default().trim())
    })
}

#[cfg(test)]
mod tests {
    use super::rate_arguments;

    #[test]
    fn rates_are_found_wherever_they_stand() {
        let found = |text| rate_arguments(text).collect::<Vec<_>>();
        assert_eq!(found("x^2 + rate(u)^2 + 3*rate ( v )"), ["u", "v"]);
        assert_eq!(found("growth_rate*u + sigrate(u) + rate*2"), Vec::<&str>::new());
    }
}
