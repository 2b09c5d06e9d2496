//! References and costs of a problem file.

use super::free_keys::is_free;
use super::reader::{Located, Parsed, Reader};
use super::tree::{Tree, renamed};
use crate::dynamics::SymbolicDynamics;
use crate::ocp::{CostFunction, CostKind, CostNames, Ocp, Softness, TerminalSet};
use crate::problem::Scheduled;
use bracketry_symbolic::{Expr, Pool, Rational};
use bracketry_system::{System, Table, Value};

/// What costs depend on.
#[derive(Clone, Copy, Default)]
pub(super) struct DependsOn {
    states: bool,
    inputs: bool,
}

/// The keys of one cost.
struct CostKeys {
    kind: CostKind,
    expression: &'static str,
    residuals: &'static str,
    weights: &'static str,
}

const STAGE: CostKeys =
    CostKeys { kind: CostKind::Stage, expression: "stage", residuals: "residuals", weights: "weights" };
const TERMINAL: CostKeys = CostKeys {
    kind: CostKind::Terminal,
    expression: "terminal",
    residuals: "terminal_residuals",
    weights: "terminal_weights",
};
const KEYS: [&str; 7] =
    ["stage", "residuals", "weights", "terminal", "terminal_residuals", "terminal_weights", "terminal_set"];

impl Reader<'_> {
    /// Names of the parameters that vary over time.
    pub(super) fn varying_parameters(&self, table: &Table<'_>) -> Parsed<Vec<String>> {
        Ok(self.parameters_over_time(table)?.into_iter().map(|(name, _)| name.to_owned()).collect())
    }

    /// The entries of `[parameters]` with an expression of time or a table.
    fn parameters_over_time<'t, 'i>(&self, table: &'t Table<'i>) -> Parsed<Vec<(&'t str, Located<'t, 'i>)>> {
        let entries = self.doc.sub_table(table, "parameters")?.into_iter().flatten();
        let entries = entries.map(|(key, v)| (key.get_ref().as_ref(), v));
        Ok(entries.filter(|(name, v)| !is_free(v) && self.constant(v, name).is_err()).collect())
    }

    /// Parameters of the controller's model that change over the run: those with an expression of time, checked at the grid
    /// points 0 … `points`, and those that are to be changed from outside. The others have been set in the model before.
    pub(super) fn parameters(&self, table: &Table<'_>, points: usize, dt: f64) -> Parsed<Vec<Scheduled>> {
        let mut live = Vec::new();
        for (name, v) in self.parameters_over_time(table)? {
            live.push(self.over_run(v, name, points, dt)?);
        }
        let Some(list) = table.get("live_parameters") else { return Ok(live) };
        let remedy = "write live_parameters = [\"m\"]: names of parameters of the model";
        let Value::Array(names) = list.get_ref() else {
            return Err(self.doc.error(list.span(), "`live_parameters` must be a list", remedy).into());
        };
        for entry in names {
            let Value::String(name) = entry.get_ref() else {
                return Err(self.doc.error(entry.span(), "a name must be in quotes", remedy).into());
            };
            let parameters = &self.system.parameters;
            let Some(p) = parameters.iter().find(|p| self.system.symbol_name(p.symbol) == name) else {
                return Err(self.unknown(name, entry.span(), "parameter", &self.system.parameter_names()));
            };
            if live.iter().any(|s| s.name == **name) {
                let message = format!("`{name}` occurs twice, or is already an expression of t");
                return Err(self.doc.error(entry.span(), message, "remove it from the list").into());
            }
            live.push(Scheduled::constant(name.to_string(), p.value.to_f64().value()));
        }
        Ok(live)
    }

    /// Reads the references, and after them those of their derivatives that are used, finite at the grid points 0 … `points`.
    pub(super) fn references(&self, table: &Table<'_>, points: usize, dt: f64) -> Parsed<Vec<Scheduled>> {
        let mut references = Vec::new();
        for (key, v) in self.doc.sub_table(table, "references")?.into_iter().flatten() {
            let name = key.get_ref().to_string();
            let taken = self.system.state_index(&name).is_some() || self.system.input_index(&name).is_some();
            if taken || self.system.parameter_names().contains(&name) || name == "t" {
                let message = format!("`{name}` already has a meaning in the model");
                let remedy = if self.system.state_index(&name).is_some() {
                    format!(
                        "a reference needs a name of its own, and the cost defines what follows it: references = {{ {name}_ref = … }}, \
                         cost = {{ stage = \"({name} - {name}_ref)^2 + …\" }}"
                    )
                } else {
                    "give the reference another name".to_owned()
                };
                return Err(self.doc.error(key.span(), message, remedy).into());
            }
            references.push(self.over_run(v, &name, points, dt)?);
        }
        for (name, order) in self.derivatives_used(table, &references)? {
            let place = self.doc.sub_table(table, "references")?.and_then(|t| t.get(name.as_str()));
            if let Some(v) = place {
                references.push(self.derivative_over_run(v, &name, order, points, dt)?);
            }
        }
        Ok(references)
    }

    /// Stage and terminal cost; what they depend on.
    pub(super) fn costs(&self, table: &Table<'_>, references: &[String], ocp: &mut Ocp) -> Parsed<DependsOn> {
        let mut depends_on = DependsOn::default();
        let Some(cost) = self.doc.sub_table(table, "cost")? else { return Ok(depends_on) };
        self.doc.only_keys(cost, &KEYS, "[cost]")?;
        ocp.stage = self.cost(cost, &STAGE, references, &mut depends_on)?;
        if self.infinite_horizon(cost)? {
            depends_on.states = true;
            if let Some(v) = cost.get(TERMINAL.residuals) {
                let message = "the terminal cost of the infinite horizon takes no residuals";
                return Err(self.doc.error(v.span(), message, "write terminal = an expression, or remove them").into());
            }
        } else {
            ocp.terminal = self.cost(cost, &TERMINAL, references, &mut depends_on)?;
        }
        Ok(depends_on)
    }

    /// Refuses a problem that asks nothing of the states: no input would answer what is measured. `costs` is what the costs depend
    /// on.
    pub(super) fn check_what_is_asked(
        &self,
        table: &Table<'_>,
        costs: DependsOn,
        ocp: &Ocp,
        planned: bool,
    ) -> Parsed<()> {
        let bounded = ocp.state_bounds.iter().any(|b| (b.min, b.max) != (f64::NEG_INFINITY, f64::INFINITY))
            || !ocp.path_constraints.is_empty()
            || !ocp.norm_constraints.is_empty();
        let remedy = "add the objective to [cost], such as stage = \"(x - 1)^2 + 0.1*u^2\", or a [target]";
        // What is free may be all that the cost is for.
        let decides = planned && (ocp.stage.is_some() || ocp.terminal.is_some());
        let message = if decides || costs.states || !ocp.targets.is_empty() || costs.inputs && bounded {
            return Ok(());
        } else if costs.inputs {
            "neither cost nor target contains a state: the inputs would not depend on the measurements"
        } else if table.contains_key("cost") && (ocp.stage.is_some() || ocp.terminal.is_some()) {
            "the cost contains no state or input: any input would be optimal"
        } else {
            "the problem has neither a cost nor a target: any input would be optimal"
        };
        Err(match table.get("cost") {
            Some(cost) => self.doc.error(cost.span(), message, remedy),
            None => self.doc.missing(message, remedy),
        }
        .into())
    }

    /// Whether the terminal cost is to be that of the infinite horizon.
    fn infinite_horizon(&self, cost: &Table<'_>) -> Parsed<bool> {
        let text = |v: &toml::Spanned<Value<'_>>| matches!(v.get_ref(), Value::String(s) if s == "riccati");
        let riccati = cost.get("terminal").is_some_and(text);
        if let Some(v) = cost.get("terminal_set").filter(|_| !riccati) {
            let remedy = "write terminal = \"riccati\", or remove `terminal_set`";
            return Err(self.doc.error(v.span(), "the terminal set needs the Riccati solution", remedy).into());
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
        if self.free.is_some() {
            let message = "the infinite horizon needs a fixed end and fixed parameters";
            return Err(self.doc.error(v.span(), message, "write an expression, or fix the free values").into());
        }
        let (n, m) = (ocp.model_states(), ocp.inputs());
        let branches = self.tree.map_or(1, Tree::branches);
        let point = self.system.point_values().map(|(x, u)| (x.repeat(branches), u.repeat(branches)));
        let (mut x, u) = point.unwrap_or_else(|| (vec![0.0; n], vec![0.0; m]));
        ocp.append_previous(&mut x, &u);
        let live: Vec<&str> = live.iter().map(String::as_str).collect();
        let solved = SymbolicDynamics::with_live_parameters(self.tree.map_or(self.system, |t| &t.product), &live)
            .and_then(|mut dynamics| ocp.clone().with_terminal_cost_at(&mut dynamics, &x, &u));
        let (whole, beyond) = solved.map_err(|e| {
            let remedy =
                "the model's [point] must be a steady state at which every undamped motion has a cost; otherwise, write a cost";
            let e = e.with_names(&self.system.state_names(), &self.system.input_names());
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

    /// The expression of a cost plus the weighted squares of its residuals.
    fn cost(
        &self,
        table: &Table<'_>,
        keys: &CostKeys,
        references: &[String],
        depends_on: &mut DependsOn,
    ) -> Parsed<Option<CostFunction>> {
        let residuals = self.residuals(table, keys)?;
        let first = residuals.first().map(|(v, _)| *v);
        let Some(place) = table.get(keys.expression).or(first) else { return Ok(None) };
        let remedy = "write states, inputs, parameters, references, and t, without derivatives of inputs";
        let made = if let Some(tree) = self.tree {
            let (mut pool, sum) = self.mean_cost(tree, table, keys, references)?;
            let remembered = tree.remembered(self.remembered);
            CostFunction::of_system(&tree.product, keys.kind, references, &remembered, &mut pool, sum)
        } else {
            let (mut pool, sum) = self.sum_of_costs(table, keys, references, depends_on)?;
            CostFunction::of_system(self.system, keys.kind, references, self.remembered, &mut pool, sum)
        };
        Ok(Some(made.map_err(|e| self.doc.error(place.span(), e.to_string(), remedy))?))
    }

    /// The weighted mean of the costs of all branches, in its pool.
    fn mean_cost(
        &self,
        tree: &Tree,
        table: &Table<'_>,
        keys: &CostKeys,
        references: &[String],
    ) -> Parsed<(Pool, Expr)> {
        let mut pool = tree.product.pool.clone();
        let mut mean = pool.int(0);
        for s in 0..tree.branches() {
            // What has been read stays what it is in a pool that grows.
            let system = System { pool, ..tree.systems[tree.last(s)].clone() };
            let reader = Reader { system: &system, tree: None, ..*self };
            let (own_pool, sum) = reader.sum_of_costs(table, keys, references, &mut DependsOn::default())?;
            pool = own_pool;
            let own = renamed(&system, s, &mut pool, &[sum])[0];
            let weight = pool.rational(Rational::simplest_from_f64(tree.weight(s)).unwrap_or_default());
            let term = pool.mul(weight, own);
            mean = pool.add(mean, term);
        }
        Ok((pool, mean))
    }

    /// The expression of a cost and the weighted squares of its residuals, in their pool.
    fn sum_of_costs(
        &self,
        table: &Table<'_>,
        keys: &CostKeys,
        references: &[String],
        depends_on: &mut DependsOn,
    ) -> Parsed<(Pool, Expr)> {
        let residuals = self.residuals(table, keys)?;
        let (names, mut pool) = CostNames::new(self.system, keys.kind, references);
        let mut names = names.with_remembered(self.remembered);
        let mut sum = pool.int(0);
        if let Some(v) = table.get(keys.expression) {
            self.without_derivatives(v)?;
            sum = self.doc.expression(v, keys.expression, &mut pool, &mut names)?;
        }
        for (v, weight) in residuals {
            self.without_derivatives(v)?;
            let residual = self.doc.expression(v, keys.residuals, &mut pool, &mut names)?;
            let square = pool.powi(residual, 2);
            let weight = pool.rational(weight);
            let term = pool.mul(weight, square);
            sum = pool.add(sum, term);
        }
        depends_on.states |= self.system.states.iter().any(|&x| pool.depends_on(sum, x));
        depends_on.inputs |= self.system.inputs.iter().any(|&u| pool.depends_on(sum, u));
        if keys.kind == CostKind::Stage {
            sum = self.over_scaled_time(&mut pool, sum);
        }
        Ok((pool, sum))
    }

    /// The residuals of a cost with their weights.
    fn residuals<'t, 'i>(&self, table: &'t Table<'i>, keys: &CostKeys) -> Parsed<Vec<(Located<'t, 'i>, Rational)>> {
        // What is reached at the end has no input.
        let (example, weights) =
            if keys.kind == CostKind::Stage { ("\"x - 1\", \"u\"", "10, 0.1") } else { ("\"x - 1\", \"v\"", "10, 1") };
        let remedy = format!("write {} = [{example}] and {} = [{weights}]", keys.residuals, keys.weights);
        let list = |key: &str| -> Parsed<Option<Vec<Located<'t, 'i>>>> {
            match table.get(key).map(|v| (v, v.get_ref())) {
                None => Ok(None),
                Some((_, Value::Array(list))) => Ok(Some(list.iter().collect())),
                Some((v, _)) => Err(self.doc.error(v.span(), format!("`{key}` must be a list"), remedy.clone()).into()),
            }
        };
        let residuals = list(keys.residuals)?.unwrap_or_default();
        let weights = list(keys.weights)?;
        if let (Some(weights), Some(v)) = (&weights, table.get(keys.weights))
            && weights.len() != residuals.len()
        {
            let message = format!("{} weights for {} residuals", weights.len(), residuals.len());
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let weight = |i: usize| -> Parsed<Rational> {
            let Some(v) = weights.as_ref().and_then(|w| w.get(i).copied()) else { return Ok(Rational::ONE) };
            let value = self.constant(v, keys.weights)?;
            Rational::simplest_from_f64(value).filter(|_| value >= 0.0).ok_or_else(|| {
                self.doc.error(v.span(), "a weight must not be negative", "write a number that is not negative").into()
            })
        };
        residuals.into_iter().enumerate().map(|(i, v)| Ok((v, weight(i)?))).collect()
    }
}
