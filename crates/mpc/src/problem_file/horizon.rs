//! The horizon of a problem file, and the guess of the inputs along it.

use super::reader::{Parsed, Reader};
use crate::integrator::Integrator;
use crate::ocp::{Ocp, Substeps};
use bracketry_system::{Table, Value};

pub(super) const KEYS: [&str; 9] =
    ["steps", "dt", "growth", "lengths", "end_time", "integrator", "stages", "substeps", "blocks"];

/// Most intervals of a horizon.
pub(super) const MOST_INTERVALS: usize = 20_000;

/// Most integration steps per interval.
pub(super) const MOST_SUBSTEPS: usize = 10_000;
/// The same of the plant, which is not differentiated.
pub(super) const MOST_PLANT_SUBSTEPS: usize = 100_000;

impl Reader<'_> {
    /// Integrator, substeps and move blocks.
    pub(super) fn discretization(&self, horizon: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        if horizon.contains_key("substeps") {
            ocp.substeps = Substeps::Fixed(self.substeps(horizon, "substeps", MOST_SUBSTEPS)?);
        }
        let stages = self.count(horizon, "stages", Some(2))?;
        if let Some(v) = horizon.get("stages").filter(|_| stages > 4) {
            let remedy = "2 stages are usual";
            return Err(self.doc.error(v.span(), "`stages` must be 1, 2, 3, or 4", remedy).into());
        }
        let methods = [
            ("rk4", Integrator::Rk4),
            ("gauss-legendre", Integrator::GaussLegendre { stages }),
            ("radau", Integrator::RadauIIA { stages }),
        ];
        ocp.integrator = self.choice(horizon, "integrator", "integrator", &methods)?;
        if let Some(v) = horizon.get("stages").filter(|_| ocp.integrator == Integrator::Rk4) {
            let remedy = "add integrator = \"gauss-legendre\" or \"radau\", or remove `stages`";
            return Err(self.doc.error(v.span(), "the integrator rk4 always has 4 stages", remedy).into());
        }
        self.blocks(horizon, ocp)
    }

    /// A number of integration steps per interval.
    pub(super) fn substeps(&self, table: &Table<'_>, key: &str, most: usize) -> Parsed<usize> {
        let steps = self.count(table, key, None)?;
        match table.get(key).filter(|_| steps > most) {
            None => Ok(steps),
            Some(v) => {
                let message = format!("{steps} integration steps per interval take too long");
                let remedy = format!("use at most {most}, an implicit integrator, or a shorter dt");
                Err(self.doc.error(v.span(), message, remedy).into())
            }
        }
    }

    /// Lengths of the move blocks; the last one is extended to the end of the horizon.
    pub(super) fn blocks(&self, horizon: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(v) = horizon.get("blocks") else { return Ok(()) };
        let remedy = "write blocks = [1, 1, 2, 4, 8]: numbers of intervals over which the inputs are held";
        let Value::Array(list) = v.get_ref() else {
            return Err(self.doc.error(v.span(), "`blocks` must be a list", remedy).into());
        };
        for length in list {
            let value = self.constant(length, "blocks")?;
            if !(1.0..=1e6).contains(&value) || value.fract() != 0.0 {
                return Err(self
                    .doc
                    .error(length.span(), "a block must be a whole number from 1 to 1000000", remedy)
                    .into());
            }
            ocp.move_blocks.push(value as usize);
        }
        let sum: usize = ocp.move_blocks.iter().sum();
        if sum > ocp.steps {
            let message = format!("the blocks hold {sum} intervals, the horizon {}", ocp.steps);
            return Err(self.doc.error(v.span(), message, "shorten the blocks").into());
        }
        match ocp.move_blocks.last_mut() {
            Some(last) => *last += ocp.steps - sum,
            None => return Err(self.doc.error(v.span(), "`blocks` is empty", remedy).into()),
        }
        Ok(())
    }

    /// The inputs of the guess, taken in the middle of every interval; where the file gives none, 0 or the bound closest to it.
    pub(super) fn guess(&self, table: &Table<'_>, ocp: &Ocp) -> Parsed<Vec<Vec<f64>>> {
        let rest = ocp.input_bounds.iter().map(|b| 0f64.clamp(b.0, b.1)).collect();
        let mut rows: Vec<Vec<f64>> = vec![rest; ocp.steps];
        let Some(t) = self.doc.sub_table(table, "guess")? else { return Ok(rows) };
        for (key, v) in t {
            let Some(j) = self.system.input_index(key.get_ref()) else {
                return Err(self.unknown(key.get_ref(), key.span(), "input", &self.system.input_names()));
            };
            let value = self.over_time(v, key.get_ref(), true)?;
            for (k, row) in rows.iter_mut().enumerate() {
                row[j] = value(if ocp.is_uniform() {
                    (k as f64 + 0.5) * ocp.dt
                } else {
                    ocp.offset(k) + 0.5 * ocp.length(k)
                });
                if !row[j].is_finite() {
                    let message = format!("the guess of `{}` is not finite at some time", key.get_ref());
                    return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
                }
            }
        }
        Ok(rows)
    }
}
