//! References and costs of a problem file.

use super::ProblemError;
use super::reader::{Parsed, Reader};
use crate::cost::{CostFunction, CostKind, CostNames};
use crate::ocp::Ocp;
use bracketry_system::Table;

impl Reader<'_> {
    /// Reads the references, their values at the grid points 0 … `points` into the problem; their names.
    pub(super) fn references(&self, table: &Table<'_>, points: usize, ocp: &mut Ocp) -> Parsed<Vec<String>> {
        let Some(t) = self.doc.sub_table(table, "references")? else { return Ok(Vec::new()) };
        let mut names = Vec::new();
        let mut rows = vec![Vec::new(); points + 1];
        for (key, v) in t {
            let name = key.get_ref().to_string();
            let taken = self.system.state_index(&name).is_some() || self.system.input_index(&name).is_some();
            let parameter = self.system.parameters.iter().any(|p| self.system.symbol_name(p.symbol) == name);
            if taken || parameter || name == "t" {
                let message = format!("`{name}` already has a meaning in the model");
                return Err(self.doc.error(key.span(), message, "give the reference another name").into());
            }
            let value = self.over_time(v, &name, true)?;
            for (k, row) in rows.iter_mut().enumerate() {
                let at = k as f64 * ocp.dt;
                row.push(value(at));
                if !row[row.len() - 1].is_finite() {
                    let message = format!("the reference `{name}` is not finite at t = {at}");
                    return Err(self.doc.error(v.span(), message, "write an expression that is finite").into());
                }
            }
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
