//! Bounds and targets of a problem file.

use super::reader::{Key, Located, Parsed, Reader, Variable};
use super::tree::renamed;
use crate::ocp::{
    Bounds, CostKind, CostNames, NormConstraint, Ocp, PathConstraint, Softness, TerminalTarget, VectorFunction,
};
use crate::problem::ProblemError;
use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use bracketry_system::{FileError, Table, Value};

/// Stands for the default penalty until the level of the cost is known, see [`Reader::default_penalties`].
const DEFAULT_SOFT: Softness = Softness::Soft { linear: f64::INFINITY, quadratic: f64::INFINITY };

/// Least width of a smooth norm: rounds it where the vector and its limit vanish together.
const LEAST_WIDTH: f64 = 1e-16;

/// Expressions in their pool.
#[derive(Clone)]
pub(super) struct Vector {
    pub(super) pool: Pool,
    pub(super) components: Vec<Expr>,
    pub(super) uses_states: bool,
    pub(super) uses_inputs: bool,
}

impl Reader<'_> {
    /// Bounds of the inputs that the model declares.
    pub(super) fn ranges(&self, ocp: &mut Ocp) {
        for (j, bounds) in ocp.input_bounds.iter_mut().enumerate() {
            if let Some(range) = self.system.range_of_input(j) {
                *bounds = range;
            }
        }
    }

    /// Bounds on states and inputs, on expressions and on norms. `names` are the references.
    pub(super) fn constraints(&self, table: &Table<'_>, names: &[String], ocp: &mut Ocp) -> Result<(), ProblemError> {
        let Some(t) = self.doc.sub_table(table, "constraints")? else { return Ok(()) };
        for (key, v) in t {
            self.constraint(key, v, names, ocp)?;
        }
        Ok(())
    }

    /// One entry of the constraints.
    pub(super) fn constraint(
        &self,
        key: &Key<'_>,
        v: Located<'_, '_>,
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        let name: &str = key.get_ref();
        let Value::Table(b) = v.get_ref() else {
            let remedy = format!("write {name} = {{ min = …, max = … }}");
            return Err(self.doc.error(v.span(), format!("the bounds of `{name}` must be a table"), remedy).into());
        };
        self.doc.only_keys(
            b,
            &["min", "max", "rate", "soft", "hard", "expression", "norm", "at", "values", "probability"],
            "a constraint",
        )?;
        if let Some(at) = b.get("at").filter(|_| !b.contains_key("expression")) {
            let remedy = format!("write {name} = {{ expression = \"…\", at = \"end\", … }}");
            return Err(self.doc.error(at.span(), "`at` applies to an expression", remedy).into());
        }
        if b.contains_key("values") {
            self.finite_input(key, b, ocp)?;
            return Ok(());
        }
        self.rate_bounds(key, b, names, ocp)?;
        if let Some(e) = b.get("expression") {
            let g = self.vector(&[(e, "expression")], names)?;
            self.between(&g, key, b, names, ocp)?;
        } else if let Some(e) = b.get("norm") {
            self.norm(e, key, b, names, ocp)?;
        } else {
            self.bounds(key, v, b, names, ocp)?;
        }
        Ok(())
    }

    /// Bounds of a state or an input.
    fn bounds(
        &self,
        key: &Key<'_>,
        v: Located<'_, '_>,
        b: &Table<'_>,
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        let name: &str = key.get_ref();
        let variable = self.variable(name, key.span())?;
        if [b.get("min"), b.get("max")].into_iter().flatten().any(|end| self.varies(end, names)) {
            let span = key.span();
            let own = toml::Spanned::new(span, Value::String(name.to_owned().into()));
            let g = self.vector(&[(&own, name)], names)?;
            return self.between(&g, key, b, names, ocp);
        }
        if !["min", "max", "rate"].iter().any(|key| b.contains_key(*key)) {
            let message = format!("`{name}` has neither `min` nor `max`: nothing is bounded");
            return Err(self.doc.error(v.span(), message, "add min or max, or remove the entry").into());
        }
        // An end that is not named here stays that of the model's range.
        let (low, high) = match variable {
            Variable::State(_) => (f64::NEG_INFINITY, f64::INFINITY),
            Variable::Input(j) => ocp.input_bounds[j],
        };
        let min = self.number(b, "min", Some(low))?.0;
        let max = self.number(b, "max", Some(high))?.0;
        let given = (b.contains_key("min"), b.contains_key("max"));
        if min > max && given != (true, true) || min > high || max < low {
            let message =
                format!("the bounds {min} to {max} of `{name}` contradict its range {low} to {high} in the model");
            return Err(self.doc.error(v.span(), message, "change the bounds, or the model's [ranges]").into());
        }
        if min > max {
            let message = format!("`{name}` cannot be both above {min} and below {max}");
            return Err(self.doc.error(v.span(), message, "swap min and max").into());
        }
        match variable {
            Variable::State(i) => {
                let softness = self.softness(name, b, false)?;
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
        Ok(())
    }

    /// Whether an end of a constraint is an expression of more than parameters.
    fn varies(&self, end: Located<'_, '_>, names: &[String]) -> bool {
        self.constant(end, "bound").is_err() && self.vector(&[(end, "bound")], names).is_ok()
    }

    /// min ≤ g ≤ max, where an end may be an expression too.
    fn between(
        &self,
        g: &Vector,
        key: &Key<'_>,
        b: &Table<'_>,
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        let ends = [b.get("min"), b.get("max")].into_iter().flatten();
        if !g.uses_states && !g.uses_inputs && !ends.into_iter().any(|end| self.varies(end, names)) {
            return Err(self.constant_constraint(key).into());
        }
        let softness = self.softness(key.get_ref(), b, !g.uses_states)?;
        let at_end = self.choice(b, "at", "place", &[("path", false), ("end", true)])?;
        if let Some(at) =
            b.get("at").filter(|_| at_end && self.compiled(g.clone(), names).is_ok_and(|f| f.uses_inputs()))
        {
            let remedy = "use only states, time, and references: the last state has no input";
            return Err(self.doc.error(at.span(), "a constraint at the end uses an input", remedy).into());
        }
        let mut whole = Bounds { softness, ..Bounds::FREE };
        for (side, sign) in [("min", -1.0), ("max", 1.0)] {
            let Some(end) = b.get(side) else { continue };
            if self.varies(end, names) {
                let mut g = g.clone();
                let (context, _) = CostNames::new(self.system, CostKind::Stage, names);
                let mut context = context.with_remembered(self.remembered);
                let e = self.doc.expression(end, side, &mut g.pool, &mut context)?;
                let difference = g.pool.sub(g.components[0], e);
                g.components = vec![difference];
                let (min, max) = if sign > 0.0 { (f64::NEG_INFINITY, 0.0) } else { (0.0, f64::INFINITY) };
                let function = self.compiled(g, names)?;
                ocp.path_constraints.push(PathConstraint {
                    // What is bounded is the distance from the end.
                    name: format!("{} - {side}", key.get_ref()),
                    function,
                    bounds: Bounds { min, max, softness },
                    at_end,
                });
            } else {
                let value = self.constant(end, side)?;
                *(if sign > 0.0 { &mut whole.max } else { &mut whole.min }) = value;
            }
        }
        if whole.min > whole.max {
            let message = format!("`{}` cannot be above {} and below {}", key.get_ref(), whole.min, whole.max);
            return Err(self.doc.error(key.span(), message, "swap min and max").into());
        }
        if !whole.is_free() {
            ocp.path_constraints.push(PathConstraint {
                name: key.get_ref().to_string(),
                function: self.compiled(g.clone(), names)?,
                bounds: whole,
                at_end,
            });
        } else if !b.contains_key("min") && !b.contains_key("max") {
            let message = format!("`{}` has no bounds", key.get_ref());
            return Err(self.doc.error(key.span(), message, "add min or max").into());
        }
        Ok(())
    }

    /// ‖(…)‖ ≤ max.
    fn norm(
        &self,
        e: Located<'_, '_>,
        key: &Key<'_>,
        b: &Table<'_>,
        names: &[String],
        ocp: &mut Ocp,
    ) -> Result<(), ProblemError> {
        let remedy = "write norm = [\"u1\", \"u2\"], max = 5";
        let Value::Array(list) = e.get_ref() else {
            return Err(self.doc.error(e.span(), "`norm` must be a list of expressions", remedy).into());
        };
        let parts: Vec<(Located<'_, '_>, &str)> = list.iter().map(|c| (c, "norm")).collect();
        if parts.is_empty() {
            return Err(self.doc.error(e.span(), "`norm` is empty", remedy).into());
        }
        if let Some(min) = b.get("min") {
            let remedy = "a norm can only be bounded from above: remove `min`";
            return Err(self.doc.error(min.span(), "a norm has no lower bound here", remedy).into());
        }
        let Some(max) = b.get("max") else {
            return Err(self.doc.error(key.span(), format!("`{}` has no `max`", key.get_ref()), remedy).into());
        };
        if self.constant(max, "max").is_ok_and(|max| max < 0.0) {
            let remedy = "give a number from 0: no norm is negative";
            return Err(self.doc.error(max.span(), format!("nothing satisfies `{}`", key.get_ref()), remedy).into());
        }
        let (vector, limit) = (self.vector(&parts, names)?, self.vector(&[(max, "max")], names)?);
        if ![&vector, &limit].iter().any(|v| v.uses_states || v.uses_inputs) {
            return Err(self.constant_constraint(key).into());
        }
        let softness = self.softness(key.get_ref(), b, !vector.uses_states && !limit.uses_states)?;
        // A norm that has to vanish leaves nothing to move in.
        if self.tree.is_none() && !self.constant(max, "max").is_ok_and(|max| max == 0.0) {
            let row = smooth_norm(self.vector(&[&parts[..], &[(max, "max")]].concat(), names)?);
            ocp.norm_rows.push(self.compiled(row, names)?);
        }
        let (mut vector, mut limit) = (vector, limit);
        // Both or none: what is a function of the state alone has other grid points.
        let remembered = self.remembered;
        let states =
            [&mut vector, &mut limit].map(|g| remembered.at_grid_points(self.system, &mut g.pool, &g.components));
        if let [Some(of_vector), Some(of_limit)] = states {
            (vector.components, limit.components) = (of_vector, of_limit);
        }
        ocp.norm_constraints.push(NormConstraint {
            name: key.get_ref().to_string(),
            vector: self.compiled_as_written(vector, names)?,
            limit: self.compiled_as_written(limit, names)?,
            softness,
        });
        Ok(())
    }

    fn constant_constraint(&self, key: &Key<'_>) -> Box<FileError> {
        let message = format!("the constraint `{}` contains no state or input: no input can satisfy it", key.get_ref());
        self.doc.error(key.span(), message, "write an expression of states or inputs, or remove it").into()
    }

    /// Expressions of states, inputs, time and references.
    pub(super) fn vector(&self, parts: &[(Located<'_, '_>, &str)], names: &[String]) -> Parsed<Vector> {
        let (context, mut pool) = CostNames::new(self.system, CostKind::Stage, names);
        let mut context = context.with_remembered(self.remembered);
        let mut components = Vec::new();
        for (v, key) in parts {
            self.without_derivatives(v)?;
            components.push(self.doc.expression(v, key, &mut pool, &mut context)?);
        }
        let uses = |list: &[Symbol]| list.iter().any(|&s| components.iter().any(|&e| pool.depends_on(e, s)));
        let (uses_states, uses_inputs) = (uses(&self.system.states), uses(&self.system.inputs));
        Ok(Vector { pool, components, uses_states, uses_inputs })
    }

    pub(super) fn compiled(&self, mut g: Vector, names: &[String]) -> Result<VectorFunction, ProblemError> {
        if let Some(functions) = self.remembered.at_grid_points(self.system, &mut g.pool, &g.components) {
            g.components = functions;
        }
        self.compiled_as_written(g, names)
    }

    fn compiled_as_written(&self, mut g: Vector, names: &[String]) -> Result<VectorFunction, ProblemError> {
        let time = g.pool.symbol("t");
        let references: Vec<Symbol> = names.iter().map(|r| g.pool.symbol(r)).collect();
        let Some(tree) = self.tree else {
            let states = self.remembered.states(self.system, &mut g.pool);
            return Ok(VectorFunction::compile(
                &mut g.pool,
                time,
                &states,
                &self.system.inputs,
                &references,
                &g.components,
            )?);
        };
        let own = renamed(self.system, self.branch, &mut g.pool, &g.components);
        let states = tree.remembered(self.remembered).states(&tree.product, &mut g.pool);
        Ok(VectorFunction::compile(&mut g.pool, time, &states, &tree.product.inputs, &references, &own)?)
    }

    /// `soft`, `hard` or the default: constraints on inputs alone are hard, others soft.
    fn softness(&self, name: &str, b: &Table<'_>, inputs_only: bool) -> Parsed<Softness> {
        if self.boolean(b, "hard", inputs_only && !b.contains_key("soft"))? {
            if let Some(soft) = b.get("soft") {
                let message = format!("the bounds of `{name}` cannot be hard and soft");
                return Err(self.doc.error(soft.span(), message, "remove `soft` or `hard`").into());
            }
            return Ok(Softness::Hard);
        }
        Ok(self.soft(b)?.map_or(DEFAULT_SOFT, |(linear, quadratic)| Softness::Soft { linear, quadratic }))
    }

    /// Weights of soft constraints for which the file gives none: a violation by the size of the constrained quantity at one
    /// grid point costs what `level` says of the whole horizon, and as much again for its square. That keeps a bound that can
    /// be kept.
    pub(super) fn default_penalties(level: f64, ocp: &mut Ocp) {
        let penalty = |softness: &mut Softness, size: f64| {
            if *softness == DEFAULT_SOFT {
                *softness = Softness::Soft { linear: level / size, quadratic: level / size / size };
            }
        };
        for (b, &size) in ocp.state_bounds.iter_mut().zip(&ocp.state_scale) {
            penalty(&mut b.softness, size);
        }
        for c in &mut ocp.path_constraints {
            let ends = [c.bounds.min.abs(), c.bounds.max.abs()];
            let size = ends.into_iter().filter(|e| e.is_finite()).fold(0.0, f64::max);
            penalty(&mut c.bounds.softness, if size > 0.0 { size } else { 1.0 });
        }
        for c in &mut ocp.norm_constraints {
            penalty(&mut c.softness, 1.0);
        }
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
                && linear + quadratic > 0.0
            {
                return Ok(Some((linear, quadratic)));
            }
        }
        let remedy = "write soft = [linear weight, quadratic weight], neither negative, at least one positive";
        Err(self.doc.error(v.span(), "`soft` must be two weights", remedy).into())
    }

    pub(super) fn targets(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(t) = self.doc.sub_table(table, "target")? else { return Ok(()) };
        // Targets change the scales, not what the states pass through on the way.
        ocp.state_size.clone_from(&ocp.state_scale);
        for (key, v) in t {
            let name: &str = key.get_ref();
            let state = self.state(name, key.span())?;
            let target = if let Value::Table(entry) = v.get_ref() {
                self.doc.only_keys(entry, &["value", "tolerance", "soft"], "a target")?;
                if !entry.contains_key("value") {
                    let message = format!("the target of `{name}` has no value");
                    return Err(self.doc.error(v.span(), message, "add `value = …`").into());
                }
                let value = self.number(entry, "value", None)?.0;
                let tolerance = self.positive(entry, "tolerance", Some(1e-2))?;
                let weights = self.soft(entry)?.unwrap_or((1.0 / tolerance, 0.5 / tolerance / tolerance));
                ocp.state_scale[state] = tolerance;
                TerminalTarget { state, value, linear: weights.0, quadratic: weights.1 }
            } else {
                ocp.state_scale[state] = 1e-2;
                TerminalTarget { state, value: self.constant(v, name)?, linear: 1e2, quadratic: 5e3 }
            };
            let Bounds { min, max, .. } = ocp.state_bounds[state];
            if target.value < min || target.value > max {
                let message = format!("the target {} of `{name}` is outside its bounds {min} to {max}", target.value);
                return Err(self.doc.error(v.span(), message, "change the target or the bounds").into());
            }
            ocp.targets.push(target);
        }
        Ok(())
    }
}

/// √1.01 h − √(‖g‖² + h²/100) for the components g and h: not negative where ‖g‖ ≤ h, smooth also where g vanishes, and h − ‖g‖ within
/// half a percent near the bound.
fn smooth_norm(mut g: Vector) -> Vector {
    let pool = &mut g.pool;
    if let Some(h) = g.components.pop() {
        let share = pool.ratio(1, 100);
        let square = pool.powi(h, 2);
        let width = pool.mul(share, square);
        // Without it, there is no derivative where g and h vanish together.
        let least = pool.rational(Rational::simplest_from_f64(LEAST_WIDTH).unwrap_or_default());
        let mut sum = pool.add(width, least);
        for &g in &g.components {
            let square = pool.powi(g, 2);
            sum = pool.add(sum, square);
        }
        let length = pool.sqrt(sum);
        let share = pool.ratio(101, 100);
        let share = pool.sqrt(share);
        let whole = pool.mul(share, h);
        g.components = vec![pool.sub(whole, length)];
    }
    g
}
