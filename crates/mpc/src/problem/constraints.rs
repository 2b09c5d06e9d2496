//! Bounds and targets of a problem file.

use super::reader::{Parsed, Reader, Variable};
use crate::ocp::{Bounds, Ocp, Softness, TerminalTarget};
use bracketry_symbolic::Rational;
use bracketry_system::{Table, Value};

/// Default penalty of a violated state bound: linear and quadratic weight.
const DEFAULT_SOFT: (f64, f64) = (1e3, 1e3);

impl Reader<'_> {
    /// Bounds of the inputs that the model declares.
    pub(super) fn ranges(&self, ocp: &mut Ocp) {
        for range in &self.system.input_ranges {
            if let Some(j) = self.system.inputs.iter().position(|&u| u == range.input) {
                let end = |r: &Option<Rational>, free: f64| r.as_ref().map_or(free, |r| r.to_f64().value());
                ocp.input_bounds[j] = (end(&range.min, f64::NEG_INFINITY), end(&range.max, f64::INFINITY));
            }
        }
    }

    pub(super) fn constraints(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(t) = self.doc.sub_table(table, "constraints")? else { return Ok(()) };
        for (key, v) in t {
            let name: &str = key.get_ref();
            let variable = self.variable(name, key.span())?;
            let Value::Table(b) = v.get_ref() else {
                let remedy = format!("write {name} = {{ min = …, max = … }}");
                return Err(self.doc.error(v.span(), format!("the bounds of `{name}` must be a table"), remedy).into());
            };
            self.doc.only_keys(b, &["min", "max", "soft", "hard"], "a constraint")?;
            // An end that is not named here stays that of the model's range.
            let (low, high) = match variable {
                Variable::State(_) => (f64::NEG_INFINITY, f64::INFINITY),
                Variable::Input(j) => ocp.input_bounds[j],
            };
            let min = self.number(b, "min", Some(low))?.0;
            let max = self.number(b, "max", Some(high))?.0;
            if min > max {
                let message = format!("`{name}` cannot be above {min} and below {max}");
                return Err(self.doc.error(v.span(), message, "exchange min and max").into());
            }
            match variable {
                Variable::State(i) => {
                    let softness = if self.boolean(b, "hard", false)? {
                        if let Some(soft) = b.get("soft") {
                            let message = format!("the bounds of `{name}` cannot be hard and soft");
                            return Err(self.doc.error(soft.span(), message, "remove `soft` or `hard`").into());
                        }
                        Softness::Hard
                    } else {
                        let (linear, quadratic) = self.soft(b)?.unwrap_or(DEFAULT_SOFT);
                        Softness::Soft { linear, quadratic }
                    };
                    ocp.state_bounds[i] = Bounds { min, max, softness };
                }
                Variable::Input(j) => {
                    if let Some(s) = b.get("soft") {
                        let remedy = "inputs can always be kept within their bounds: remove `soft`";
                        return Err(self.doc.error(s.span(), "bounds on inputs are hard", remedy).into());
                    }
                    ocp.input_bounds[j] = (min, max);
                }
            }
        }
        Ok(())
    }

    fn soft(&self, table: &Table<'_>) -> Parsed<Option<(f64, f64)>> {
        let Some(v) = table.get("soft") else { return Ok(None) };
        if let Value::Array(list) = v.get_ref() {
            let mut weights = Vec::new();
            for w in list {
                weights.push(self.constant(w, "soft")?);
            }
            if let [linear, quadratic] = weights[..]
                && linear >= 0.0
                && quadratic >= 0.0
            {
                return Ok(Some((linear, quadratic)));
            }
        }
        let remedy = "write soft = [linear weight, quadratic weight], neither negative";
        Err(self.doc.error(v.span(), "`soft` must be two weights", remedy).into())
    }

    pub(super) fn targets(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(t) = self.doc.sub_table(table, "target")? else { return Ok(()) };
        for (key, v) in t {
            let name: &str = key.get_ref();
            let state = self.state(name, key.span())?;
            let target = if let Value::Table(entry) = v.get_ref() {
                self.doc.only_keys(entry, &["value", "tolerance", "soft"], "a target")?;
                let value = self.number(entry, "value", None)?.0;
                let tolerance = self.positive(entry, "tolerance", Some(1e-2))?;
                let weights = self.soft(entry)?.unwrap_or((1.0 / tolerance, 0.5 / tolerance / tolerance));
                ocp.state_scale[state] = tolerance;
                TerminalTarget { state, value, linear: weights.0, quadratic: weights.1 }
            } else {
                ocp.state_scale[state] = 1e-2;
                TerminalTarget { state, value: self.constant(v, name)?, linear: 1e2, quadratic: 5e3 }
            };
            ocp.targets.push(target);
        }
        Ok(())
    }
}
