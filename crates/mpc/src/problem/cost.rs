//! References and costs of a problem file.

use super::ProblemError;
use super::reader::{Located, Parsed, Reader};
use crate::cost::{CostFunction, CostKind, CostNames};
use crate::ocp::Ocp;
use bracketry_system::Table;

impl Reader<'_> {
    /// Parameters of the controller's model that change over the run, their values at the grid points 0 … `points` into the
    /// problem; their names. Those that do not change have been set in the model before.
    pub(super) fn parameters(&self, table: &Table<'_>, points: usize, ocp: &mut Ocp) -> Parsed<Vec<String>> {
        let (mut names, mut rows) = (Vec::new(), vec![Vec::new(); points + 1]);
        for (key, v) in self.doc.sub_table(table, "parameters")?.into_iter().flatten() {
            if self.constant(v, key.get_ref()).is_err() {
                self.over_run(v, key.get_ref(), ocp.dt, &mut rows)?;
                names.push(key.get_ref().to_string());
            }
        }
        if !names.is_empty() {
            ocp.parameters = rows;
        }
        Ok(names)
    }

    /// Adds the values of an expression of time to the rows of the grid points.
    fn over_run(&self, v: Located<'_, '_>, name: &str, dt: f64, rows: &mut [Vec<f64>]) -> Parsed<()> {
        let value = self.over_time(v, name, true)?;
        for (k, row) in rows.iter_mut().enumerate() {
            let (at, now) = (k as f64 * dt, value(k as f64 * dt));
            if !now.is_finite() {
                let message = format!("`{name}` is not finite at t = {at}");
                return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
            }
            row.push(now);
        }
        Ok(())
    }

    /// Reads the references, their values at the grid points 0 … `points` into the problem; their names. Live parameters come
    /// first: a cost sees them change.
    pub(super) fn references(
        &self,
        table: &Table<'_>,
        points: usize,
        live: &[String],
        ocp: &mut Ocp,
    ) -> Parsed<Vec<String>> {
        let mut names = live.to_vec();
        let mut rows = if live.is_empty() { vec![Vec::new(); points + 1] } else { ocp.parameters.clone() };
        let given = self.doc.sub_table(table, "references")?;
        if given.is_none() && live.is_empty() {
            return Ok(names);
        }
        for (key, v) in given.into_iter().flatten() {
            let name = key.get_ref().to_string();
            let taken = self.system.state_index(&name).is_some() || self.system.input_index(&name).is_some();
            let parameter = self.system.parameters.iter().any(|p| self.system.symbol_name(p.symbol) == name);
            if taken || parameter || name == "t" {
                let message = format!("`{name}` already has a meaning in the model");
                return Err(self.doc.error(key.span(), message, "give the reference another name").into());
            }
            self.over_run(v, &name, ocp.dt, &mut rows)?;
            names.push(name);
        }
        ocp.references = rows;
        Ok(names)
    }

    pub(super) fn costs(&self, table: &Table<'_>, references: &[String], ocp: &mut Ocp) -> Result<(), ProblemError> {
        let Some(cost) = self.doc.sub_table(table, "cost")? else { return Ok(()) };
        self.doc.only_keys(cost, &["stage", "terminal"], "[cost]")?;
        ocp.stage = self.cost(cost, "stage", CostKind::Stage, references)?;
        ocp.terminal = self.cost(cost, "terminal", CostKind::Terminal, references)?;
        Ok(())
    }

    fn cost(
        &self,
        table: &Table<'_>,
        key: &str,
        kind: CostKind,
        references: &[String],
    ) -> Result<Option<CostFunction>, ProblemError> {
        let Some(v) = table.get(key) else { return Ok(None) };
        let (mut names, mut pool) = CostNames::new(self.system, kind, references);
        let e = self.doc.expression(v, key, &mut pool, &mut names)?;
        Ok(Some(CostFunction::of_system(self.system, kind, references, &mut pool, e)?))
    }
}
