//! The horizon of a problem file, and the guess of the inputs along it.

use super::reader::{Parsed, Reader};
use crate::ocp::{Ocp, Substeps};
use bracketry_system::Table;

pub(super) const KEYS: [&str; 4] = ["steps", "dt", "integrator", "substeps"];

impl Reader<'_> {
    pub(super) fn integrator(&self, horizon: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        if horizon.contains_key("substeps") {
            ocp.substeps = Substeps::Fixed(self.count(horizon, "substeps", None)?);
        }
        match (self.doc.string(horizon, "integrator")?.as_deref(), horizon.get("integrator")) {
            (None | Some("rk4"), _) | (_, None) => Ok(()),
            (Some(other), Some(v)) => {
                Err(self.doc.error(v.span(), format!("there is no integrator `{other}`"), "write \"rk4\"").into())
            }
        }
    }

    /// The inputs of the guess, taken in the middle of every interval; 0 where the file gives none.
    pub(super) fn guess(&self, table: &Table<'_>, steps: usize, dt: f64) -> Parsed<Vec<Vec<f64>>> {
        let mut rows = vec![vec![0.0; self.system.inputs.len()]; steps];
        let Some(t) = self.doc.sub_table(table, "guess")? else { return Ok(rows) };
        for (key, v) in t {
            let Some(j) = self.system.input_index(key.get_ref()) else {
                return Err(self.unknown(key.get_ref(), key.span(), "input", &self.system.input_names()));
            };
            let value = self.over_time(v, key.get_ref(), true)?;
            for (k, row) in rows.iter_mut().enumerate() {
                row[j] = value((k as f64 + 0.5) * dt);
                if !row[j].is_finite() {
                    let message = format!("the guess of `{}` is not finite at some time", key.get_ref());
                    return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
                }
            }
        }
        Ok(rows)
    }
}
