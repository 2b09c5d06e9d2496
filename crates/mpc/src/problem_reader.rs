//! The tables of a problem file, one by one.

use crate::cost::{CostFunction, CostKind, CostNames};
use crate::ocp::{Bounds, Ocp, Softness, Substeps, TerminalTarget};
use crate::problem::{ControlProblem, Method, ProblemError};
use bracketry_symbolic::{Expr, Names, Pool, Tape};
use bracketry_system::{Document, FileError, System, Table, Value};
use std::ops::Range;

pub(crate) const KEYS: [&str; 14] = [
    "name",
    "model",
    "plant",
    "horizon",
    "cost",
    "references",
    "constraints",
    "target",
    "scale",
    "trust",
    "guess",
    "solve",
    "run",
    "about",
];
const HORIZON_KEYS: [&str; 4] = ["steps", "dt", "integrator", "substeps"];
const SOLVE_KEYS: [&str; 9] = [
    "method",
    "initial_iterations",
    "max_iterations",
    "tolerance",
    "qp_tolerance",
    "smoothing",
    "margin",
    "proximal",
    "guarded",
];
const RUN_KEYS: [&str; 3] = ["x0", "steps", "plant_substeps"];

/// Default penalty of a violated state bound: linear and quadratic weight.
const DEFAULT_SOFT: (f64, f64) = (1e3, 1e3);

type Located<'a, 'i> = &'a toml::Spanned<Value<'i>>;
type Parsed<T> = Result<T, Box<FileError>>;

/// Numbers and `pi`, with the names of parameters and perhaps the time.
struct Constants<'a> {
    system: &'a System,
    time: bool,
}

impl Names for Constants<'_> {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        if self.time && name == "t" {
            return Some(pool.var("t"));
        }
        let p = self.system.parameters.iter().find(|p| self.system.symbol_name(p.symbol) == name)?;
        Some(pool.rational(p.value.clone()))
    }
    fn known(&self) -> Vec<String> {
        let mut known: Vec<String> =
            self.system.parameters.iter().map(|p| self.system.symbol_name(p.symbol).to_owned()).collect();
        known.extend(self.time.then(|| "t".to_owned()));
        known
    }
}

/// What a name in a table stands for.
#[derive(Clone, Copy)]
enum Variable {
    State(usize),
    Input(usize),
}

pub(crate) struct Reader<'a> {
    pub(crate) doc: &'a Document,
    pub(crate) system: &'a System,
}

impl Reader<'_> {
    pub(crate) fn problem(&self, table: &Table<'_>, plant: System) -> Result<ControlProblem, ProblemError> {
        let system = self.system;
        let (n, m) = (system.states.len(), system.inputs.len());
        let horizon = self.required(table, "horizon", "[horizon] with steps and dt")?;
        self.doc.only_keys(horizon, &HORIZON_KEYS, "[horizon]")?;
        let steps = self.count(horizon, "steps", None)?;
        let dt = self.positive(horizon, "dt", None)?;
        self.integrator(horizon)?;
        let mut ocp = Ocp::new(n, m, steps, dt);
        ocp.substeps = match horizon.get("substeps") {
            Some(_) => Substeps::Fixed(self.count(horizon, "substeps", None)?),
            None => Substeps::AtLeast(1),
        };

        let run = self.required(table, "run", "[run] with x0 and steps")?;
        self.doc.only_keys(run, &RUN_KEYS, "[run]")?;
        let samples = self.count(run, "steps", Some(steps))?;
        let mut x0 = vec![0.0; n];
        if let Some(values) = self.doc.sub_table(run, "x0")? {
            for (key, value) in values {
                let i = self.state(key.get_ref(), key.span())?;
                x0[i] = self.constant(value, key.get_ref())?;
            }
        }

        let (names, rows) = self.references(table, samples + steps, dt)?;
        ocp.references = rows;
        if let Some(cost) = self.doc.sub_table(table, "cost")? {
            self.doc.only_keys(cost, &["stage", "terminal"], "[cost]")?;
            ocp.stage = self.cost(cost, "stage", CostKind::Stage, &names)?;
            ocp.terminal = self.cost(cost, "terminal", CostKind::Terminal, &names)?;
        }
        self.constraints(table, &mut ocp)?;
        self.targets(table, &mut ocp)?;
        self.scales(table, &mut ocp)?;

        let empty = Table::new();
        let solve = self.doc.sub_table(table, "solve")?.unwrap_or(&empty);
        self.doc.only_keys(solve, &SOLVE_KEYS, "[solve]")?;
        let method = self.method(solve)?;
        let planned = method == Method::Plan;
        Ok(ControlProblem {
            method,
            initial_iterations: self.count(solve, "initial_iterations", Some(1))?,
            max_iterations: self.count(solve, "max_iterations", Some(100))?,
            tolerance: self.positive(solve, "tolerance", Some(if planned { 1e-2 } else { 1e-8 }))?,
            qp_tolerance: self.positive(solve, "qp_tolerance", Some(1e-8))?,
            smoothing: self.smoothing(solve, planned)?,
            margin: self.not_negative(solve, "margin", if planned { 0.05 } else { 0.0 })?,
            proximal: self.not_negative(solve, "proximal", if planned { 0.5 } else { 0.0 })?,
            guarded: self.boolean(solve, "guarded", planned)?,
            guess: self.guess(table, steps, dt)?,
            x0,
            samples,
            plant_substeps: self.count(run, "plant_substeps", Some(1))?,
            system: system.clone(),
            plant,
            ocp,
        })
    }

    fn required<'t, 'i>(&self, table: &'t Table<'i>, key: &str, remedy: &str) -> Parsed<&'t Table<'i>> {
        let found = self.doc.sub_table(table, key)?;
        Ok(found.ok_or_else(|| self.doc.missing(format!("[{key}] is missing"), format!("add {remedy}")))?)
    }

    fn number(&self, table: &Table<'_>, key: &str, default: Option<f64>) -> Parsed<(f64, Range<usize>)> {
        match (table.get(key), default) {
            (Some(v), _) => Ok((self.constant(v, key)?, v.span())),
            (None, Some(d)) => Ok((d, 0..0)),
            (None, None) => Err(self.doc.missing(format!("`{key}` is missing"), format!("add `{key} = …`")).into()),
        }
    }

    fn positive(&self, table: &Table<'_>, key: &str, default: Option<f64>) -> Parsed<f64> {
        let (v, span) = self.number(table, key, default)?;
        if v > 0.0 {
            Ok(v)
        } else {
            Err(self.doc.error(span, format!("`{key}` must be positive"), "give a positive number").into())
        }
    }

    fn not_negative(&self, table: &Table<'_>, key: &str, default: f64) -> Parsed<f64> {
        let (v, span) = self.number(table, key, Some(default))?;
        if v >= 0.0 {
            Ok(v)
        } else {
            Err(self.doc.error(span, format!("`{key}` must not be negative"), "give 0 or more").into())
        }
    }

    fn count(&self, table: &Table<'_>, key: &str, default: Option<usize>) -> Parsed<usize> {
        let (v, span) = self.number(table, key, default.map(|d| d as f64))?;
        if (1.0..=1e6).contains(&v) && v.fract() == 0.0 {
            Ok(v as usize)
        } else {
            let message = format!("`{key}` must be a whole number from 1 to 1000000");
            Err(self.doc.error(span, message, "give a whole number").into())
        }
    }

    fn boolean(&self, table: &Table<'_>, key: &str, default: bool) -> Parsed<bool> {
        match table.get(key) {
            None => Ok(default),
            Some(v) => match v.get_ref() {
                Value::Boolean(b) => Ok(*b),
                _ => Err(self.doc.error(v.span(), format!("`{key}` must be true or false"), "write it bare").into()),
            },
        }
    }

    /// A number, or an expression of parameters in quotes.
    fn constant(&self, v: Located<'_, '_>, key: &str) -> Parsed<f64> {
        let value = self.over_time(v, key, false)?;
        Ok(value(0.0))
    }

    /// An expression of parameters and perhaps the time, as a function.
    fn over_time(&self, v: Located<'_, '_>, key: &str, time: bool) -> Parsed<impl Fn(f64) -> f64 + use<>> {
        let mut pool = Pool::new();
        let e = self.doc.expression(v, key, &mut pool, &mut Constants { system: self.system, time })?;
        let t = pool.symbol("t");
        let tape = Tape::compile(&pool, &[t], &[e])
            .map_err(|e| self.doc.error(v.span(), e.to_string(), "use numbers and parameters"))?;
        let value = move |t: f64| {
            let mut out = [0.0];
            tape.eval(&[t], &mut Vec::new(), &mut out);
            out[0]
        };
        if value(0.0).is_finite() {
            Ok(value)
        } else {
            Err(self.doc.error(v.span(), format!("`{key}` is not a finite number"), "write a finite number").into())
        }
    }

    fn variable(&self, name: &str, span: Range<usize>) -> Parsed<Variable> {
        if let Some(i) = self.system.state_index(name) {
            return Ok(Variable::State(i));
        }
        if let Some(j) = self.system.input_index(name) {
            return Ok(Variable::Input(j));
        }
        let mut known = self.system.state_names();
        known.extend(self.system.input_names());
        Err(self.unknown(name, span, "state or input", &known))
    }

    fn state(&self, name: &str, span: Range<usize>) -> Parsed<usize> {
        let found = self.system.state_index(name);
        found.ok_or_else(|| self.unknown(name, span, "state", &self.system.state_names()))
    }

    fn unknown(&self, name: &str, span: Range<usize>, what: &str, known: &[String]) -> Box<FileError> {
        let remedy = format!("the model has: {}", known.join(", "));
        self.doc.error(span, format!("`{name}` is no {what} of the model"), remedy).into()
    }

    fn integrator(&self, horizon: &Table<'_>) -> Parsed<()> {
        match (self.doc.string(horizon, "integrator")?.as_deref(), horizon.get("integrator")) {
            (None | Some("rk4"), _) | (_, None) => Ok(()),
            (Some(other), Some(v)) => {
                Err(self.doc.error(v.span(), format!("there is no integrator `{other}`"), "write \"rk4\"").into())
            }
        }
    }

    fn method(&self, solve: &Table<'_>) -> Parsed<Method> {
        match (self.doc.string(solve, "method")?.as_deref(), solve.get("method")) {
            (None | Some("rti"), _) | (_, None) => Ok(Method::Rti),
            (Some("sqp"), _) => Ok(Method::Sqp),
            (Some("plan"), _) => Ok(Method::Plan),
            (Some(other), Some(v)) => {
                let message = format!("there is no method `{other}`");
                Err(self.doc.error(v.span(), message, "write \"rti\", \"sqp\" or \"plan\"").into())
            }
        }
    }

    fn smoothing(&self, solve: &Table<'_>, planned: bool) -> Parsed<Vec<f64>> {
        let Some(v) = solve.get("smoothing") else {
            return Ok(if planned { vec![0.1, 0.03, 0.01, 0.003] } else { vec![0.01] });
        };
        let mut widths = Vec::new();
        match v.get_ref() {
            Value::Array(list) => {
                for w in list {
                    widths.push(self.constant(w, "smoothing")?);
                }
            }
            _ => widths.push(self.constant(v, "smoothing")?),
        }
        if widths.is_empty() || widths.iter().any(|w| *w <= 0.0) {
            let remedy = "give a positive width, or a list of them from wide to narrow";
            return Err(self.doc.error(v.span(), "`smoothing` must be positive", remedy).into());
        }
        Ok(widths)
    }

    fn references(&self, table: &Table<'_>, points: usize, dt: f64) -> Parsed<(Vec<String>, Vec<Vec<f64>>)> {
        let Some(t) = self.doc.sub_table(table, "references")? else { return Ok((Vec::new(), Vec::new())) };
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
                row.push(value(k as f64 * dt));
            }
            names.push(name);
        }
        Ok((names, rows))
    }

    fn cost(
        &self,
        table: &Table<'_>,
        key: &str,
        kind: CostKind,
        references: &[String],
    ) -> Result<Option<CostFunction>, ProblemError> {
        let Some(v) = table.get(key) else { return Ok(None) };
        let mut pool = self.system.pool.clone();
        let mut names = CostNames { system: self.system, kind, references };
        let e = self.doc.expression(v, key, &mut pool, &mut names)?;
        Ok(Some(CostFunction::of_system(self.system, kind, references, &mut pool, e)?))
    }

    fn constraints(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        let Some(t) = self.doc.sub_table(table, "constraints")? else { return Ok(()) };
        for (key, v) in t {
            let name: &str = key.get_ref();
            let variable = self.variable(name, key.span())?;
            let Value::Table(b) = v.get_ref() else {
                let remedy = format!("write {name} = {{ min = …, max = … }}");
                return Err(self.doc.error(v.span(), format!("the bounds of `{name}` must be a table"), remedy).into());
            };
            self.doc.only_keys(b, &["min", "max", "soft", "hard"], "a constraint")?;
            let min = self.number(b, "min", Some(f64::NEG_INFINITY))?.0;
            let max = self.number(b, "max", Some(f64::INFINITY))?.0;
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
                    let half = (max - min) / 2.0;
                    if half.is_finite() && half > 0.0 {
                        ocp.input_trust[j] = half;
                    }
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

    fn targets(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
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

    fn scales(&self, table: &Table<'_>, ocp: &mut Ocp) -> Parsed<()> {
        if let Some(t) = self.doc.sub_table(table, "scale")? {
            for key in t.keys() {
                let i = self.state(key.get_ref(), key.span())?;
                ocp.state_scale[i] = self.positive(t, key.get_ref(), None)?;
            }
        }
        if let Some(t) = self.doc.sub_table(table, "trust")? {
            for key in t.keys() {
                let value = self.positive(t, key.get_ref(), None)?;
                match self.variable(key.get_ref(), key.span())? {
                    Variable::State(i) => ocp.state_trust[i] = value,
                    Variable::Input(j) => ocp.input_trust[j] = value,
                }
            }
        }
        Ok(())
    }

    /// The inputs of the guess, taken in the middle of every interval; 0 where the file gives none.
    fn guess(&self, table: &Table<'_>, steps: usize, dt: f64) -> Parsed<Vec<Vec<f64>>> {
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
