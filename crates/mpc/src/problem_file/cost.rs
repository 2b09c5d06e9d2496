//! References and costs of a problem file.

use super::reader::{Located, Parsed, Reader};
use crate::dynamics::SymbolicDynamics;
use crate::ocp::{CostFunction, CostKind, CostNames, Ocp, Softness, TerminalSet};
use bracketry_system::{Table, Value};

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

    pub(super) fn costs(&self, table: &Table<'_>, references: &[String], ocp: &mut Ocp) -> Parsed<()> {
        let Some(cost) = self.doc.sub_table(table, "cost")? else { return Ok(()) };
        self.doc.only_keys(cost, &["stage", "terminal", "terminal_set"], "[cost]")?;
        ocp.stage = self.cost(cost, "stage", CostKind::Stage, references)?;
        if !self.infinite_horizon(cost)? {
            ocp.terminal = self.cost(cost, "terminal", CostKind::Terminal, references)?;
        }
        Ok(())
    }

    /// Whether the terminal cost is to be that of the infinite horizon.
    fn infinite_horizon(&self, cost: &Table<'_>) -> Parsed<bool> {
        let text = |v: &toml::Spanned<Value<'_>>| matches!(v.get_ref(), Value::String(s) if s == "riccati");
        let riccati = cost.get("terminal").is_some_and(text);
        if let Some(v) = cost.get("terminal_set").filter(|_| !riccati) {
            let remedy = "write terminal = \"riccati\", or remove `terminal_set`";
            return Err(self.doc.error(v.span(), "the terminal set is one of the Riccati solution", remedy).into());
        }
        Ok(riccati)
    }

    /// Terminal cost of the infinite horizon at the model's point (else the origin), and the set in which its feedback keeps
    /// all bounds. `level` is that of the cost.
    pub(super) fn end_of_horizon(&self, table: &Table<'_>, live: &[String], level: f64, ocp: &mut Ocp) -> Parsed<()> {
        let Some(cost) = self.doc.sub_table(table, "cost")? else { return Ok(()) };
        let Some(v) = cost.get("terminal").filter(|_| self.infinite_horizon(cost).unwrap_or(false)) else {
            return Ok(());
        };
        let (n, m) = (ocp.states(), ocp.inputs());
        let (x, u) = self.system.point_values().unwrap_or_else(|| (vec![0.0; n], vec![0.0; m]));
        let live: Vec<&str> = live.iter().map(String::as_str).collect();
        let solved = SymbolicDynamics::with_live_parameters(self.system, &live)
            .and_then(|mut dynamics| ocp.clone().with_terminal_cost_at(&mut dynamics, &x, &u));
        let (whole, beyond) = solved.map_err(|e| {
            let remedy =
                "the model's [point] must be a steady state at which every undamped motion has a cost; otherwise, write a cost";
            self.doc.error(v.span(), e.to_string(), remedy)
        })?;
        *ocp = whole;
        if self.boolean(cost, "terminal_set", false)? {
            let alpha = ocp.largest_terminal_level(&beyond);
            if alpha <= 0.0 {
                let remedy = "move the model's [point] inside the bounds, or remove `terminal_set`";
                return Err(self.doc.error(v.span(), "the steady state is not within the bounds", remedy).into());
            }
            if alpha.is_finite() {
                let weight = ocp.dt * level / alpha.sqrt();
                ocp.terminal_set = Some(TerminalSet {
                    matrix: beyond.riccati.cost_to_go.row_iter().map(|r| r.iter().copied().collect()).collect(),
                    center: beyond.state,
                    level: alpha,
                    softness: Softness::Soft { linear: weight, quadratic: weight / alpha.sqrt() },
                });
            }
        }
        Ok(())
    }

    fn cost(
        &self,
        table: &Table<'_>,
        key: &str,
        kind: CostKind,
        references: &[String],
    ) -> Parsed<Option<CostFunction>> {
        let Some(v) = table.get(key) else { return Ok(None) };
        let (mut names, mut pool) = CostNames::new(self.system, kind, references);
        let e = self.doc.expression(v, key, &mut pool, &mut names)?;
        let made = CostFunction::of_system(self.system, kind, references, &mut pool, e);
        let remedy = "write states, inputs, parameters, references and t, without derivatives of inputs";
        Ok(Some(made.map_err(|e| self.doc.error(v.span(), e.to_string(), remedy))?))
    }
}
