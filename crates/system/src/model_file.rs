//! Model files: reading with located errors.

use std::path::Path;

use bracketry_symbolic::{Expr, Pool, Rational, Symbol, Tape, closest_name};
use rustc_hash::{FxHashMap, FxHashSet};

use bracketry_files::{Document, FileError, Table, Value};

use crate::constants::Constants;
use crate::discrete_time::discrete_period;
use crate::implicit::{
    Equation, MassMatrix, algebraic_equations, algebraic_names, eliminate_algebraic, smooth_beside_algebraic,
};
use crate::input_delay::read_input_delays;
use crate::rules::{Declared, check_parameter, check_range};
use crate::scope::{Derivatives, Scope};
use crate::stated_units::read_quantities;
use crate::static_level::read_static_levels;
use crate::system::{InputRange, Parameter, Point, System};

const KEYS: [&str; 18] = [
    "name",
    "time",
    "time_unit",
    "period",
    "states",
    "inputs",
    "ranges",
    "delays",
    "parameters",
    "definitions",
    "dynamics",
    "mass",
    "algebraic",
    "outputs",
    "static",
    "point",
    "units",
    "labels",
];
const PARAMETER_KEYS: [&str; 6] = ["value", "unit", "min", "max", "fixed", "about"];

type Located<'a, 'i> = &'a toml::Spanned<Value<'i>>;

/// What a reader of model files can treat beyond x' = f(x, u). What it cannot is refused with its place in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Accepted {
    /// Models that are discrete in time.
    pub discrete: bool,
    /// Algebraic variables that cannot be eliminated.
    pub algebraic: bool,
}

impl System {
    /// Reads a model file that states x' = f(x, u), perhaps after elimination.
    ///
    /// # Errors
    /// One [`FileError`] with file, line, column, the offending text and the remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<System, FileError> {
        Self::read_accepting(path, Accepted::default())
    }

    /// As [`System::read`], with what the caller can treat beyond that.
    ///
    /// # Errors
    /// As [`System::read`].
    pub fn read_accepting(path: impl AsRef<Path>, accepted: Accepted) -> Result<System, FileError> {
        let doc = Document::read(path.as_ref())?;
        let stem = path.as_ref().file_stem().map_or_else(|| "model".into(), |s| s.to_string_lossy().into_owned());
        Reader::new(&doc, accepted).system(&stem)
    }

    /// Reads a model from text; `file` is how errors call it.
    ///
    /// # Errors
    /// As [`System::read`].
    pub fn parse(file: &str, text: &str) -> Result<System, FileError> {
        Self::parse_accepting(file, text, Accepted::default())
    }

    /// As [`System::parse`], with what the caller can treat beyond x' = f(x, u).
    ///
    /// # Errors
    /// As [`System::read`].
    pub fn parse_accepting(file: &str, text: &str, accepted: Accepted) -> Result<System, FileError> {
        Reader::new(&Document::new(file, text), accepted).system(file)
    }
}

struct Reader<'d> {
    doc: &'d Document,
    pool: Pool,
    states: Vec<Symbol>,
    /// Where each state is declared.
    state_spans: Vec<std::ops::Range<usize>>,
    inputs: Vec<Symbol>,
    parameters: Vec<Parameter>,
    /// Parameters with an irrational value, which are names of constants.
    constants: Vec<(String, Expr)>,
    declared: Declared,
    accepted: Accepted,
}

impl<'d> Reader<'d> {
    fn new(doc: &'d Document, accepted: Accepted) -> Self {
        Reader {
            doc,
            pool: Pool::new(),
            states: Vec::new(),
            state_spans: Vec::new(),
            inputs: Vec::new(),
            parameters: Vec::new(),
            constants: Vec::new(),
            declared: Declared::default(),
            accepted,
        }
    }

    fn system(mut self, default_name: &str) -> Result<System, FileError> {
        let doc = self.doc;
        let table = doc.table()?;
        doc.only_keys(&table, &KEYS, "a model file")?;
        let name = doc.string(&table, "name")?.unwrap_or_else(|| default_name.to_owned());
        let period = discrete_period(doc, &table, self.accepted.discrete)?;
        self.states = self.names(&table, "states", "state")?;
        if self.states.is_empty() {
            return Err(doc.missing("the model has no states", "add `states = [\"x\", …]` at the top"));
        }
        self.inputs = self.names(&table, "inputs", "input")?;
        let algebraic = algebraic_names(doc, &table, &mut self.pool, &mut self.declared)?;
        self.read_parameters(&table)?;

        let mut plain: FxHashMap<String, Expr> = FxHashMap::default();
        let symbols: Vec<Symbol> =
            self.states.iter().chain(&self.inputs).copied().chain(self.parameters.iter().map(|p| p.symbol)).collect();
        for s in symbols.into_iter().chain(algebraic.iter().copied()) {
            let e = self.pool.sym(s);
            plain.insert(self.pool.name(s).to_owned(), e);
        }
        plain.extend(self.constants.iter().cloned());
        let input_names: Vec<String> = self.inputs.iter().map(|&s| self.pool.name(s).to_owned()).collect();
        let mut derivatives = Derivatives::default();
        let mut met = FxHashSet::default();
        let mut definitions = self.constants.clone();
        definitions.extend(self.read_definitions(&table, &mut plain, &input_names, &mut derivatives, &mut met)?);

        let mut scope = Scope { plain: &plain, inputs: &input_names, derivatives: &mut derivatives, met: &mut met };
        let dynamics = self.read_dynamics(&table, &mut scope)?;
        let mass = MassMatrix::read(doc, &table, &self.states, &mut self.pool, &mut scope)?;
        let equations = algebraic_equations(doc, &table, algebraic, &mut self.pool, &mut scope)?;
        let mut outputs = Vec::new();
        if let Some(t) = doc.sub_table(&table, "outputs")? {
            for (key, value) in t {
                outputs.push((
                    key.get_ref().to_string(),
                    doc.expression(value, key.get_ref(), &mut self.pool, &mut scope)?,
                ));
            }
        }
        let point = self.read_point(&table)?;
        let input_ranges = self.read_ranges(&table)?;
        let mut system = System {
            name,
            pool: self.pool,
            states: self.states,
            inputs: self.inputs,
            input_ranges,
            input_derivatives: derivatives.list(),
            parameters: self.parameters,
            definitions,
            dynamics,
            outputs,
            point,
            period,
            ..System::default()
        };
        let implicit = equations.iter().map(Equation::residual).chain(mass.iter().flat_map(MassMatrix::entries));
        system.find_canceled(implicit, &met);
        if let Some(mass) = mass {
            mass.solve(doc, &mut system)?;
        }
        eliminate_algebraic(doc, &equations, self.accepted.algebraic, &mut plain, &mut system)?;
        read_quantities(doc, &table, &mut system)?;
        if !system.algebraic.is_empty() {
            smooth_beside_algebraic(doc, &table, &system)?;
        }
        if period.is_some() {
            if let Some(d) = system.input_derivatives.first() {
                let name = system.pool.name(d.symbol);
                let message = format!("the model is discrete in time, so `{name}` does not exist");
                return Err(doc.missing(message, "make the input of the previous step a state of the model"));
            }
            return Ok(system);
        }
        system.mark_dry_friction();
        read_static_levels(doc, &table, &plain, &mut system)?;
        read_input_delays(doc, &table, &mut system)?;
        Ok(system)
    }

    /// The list of names under `key`.
    fn names(&mut self, table: &Table<'_>, key: &str, kind: &'static str) -> Result<Vec<Symbol>, FileError> {
        let Some(value) = table.get(key) else { return Ok(Vec::new()) };
        let remedy = format!("write {key} = [\"a\", \"b\"]");
        let Value::Array(list) = value.get_ref() else {
            return Err(self.doc.error(value.span(), format!("`{key}` must be a list of names"), remedy));
        };
        let mut out = Vec::new();
        for item in list {
            let Value::String(name) = item.get_ref() else {
                return Err(self.doc.error(item.span(), format!("`{key}` must hold names in quotes"), remedy));
            };
            self.declared.add(name, kind).map_err(|e| e.at(self.doc, item.span()))?;
            out.push(self.pool.symbol(name));
            if kind == "state" {
                self.state_spans.push(item.span());
            }
        }
        Ok(out)
    }

    fn read_parameters(&mut self, table: &Table<'_>) -> Result<(), FileError> {
        let doc = self.doc;
        let Some(t) = doc.sub_table(table, "parameters")? else { return Ok(()) };
        for (key, value) in t {
            let name: &str = key.get_ref();
            self.declared.add(name, "parameter").map_err(|e| e.at(doc, key.span()))?;
            let symbol = self.pool.symbol(name);
            let Value::Table(entries) = value.get_ref() else {
                let Some(value) = self.parameter_value(value, name)? else { continue };
                self.parameters.push(Parameter { symbol, value, min: None, max: None, unit: None, about: None });
                continue;
            };
            doc.only_keys(entries, &PARAMETER_KEYS, "a parameter")?;
            let bound = |k: &str| entries.get(k).map(|v| doc.exact_number(v, k)).transpose();
            let Some(value) = entries.get("value") else {
                return Err(doc.error(
                    key.span(),
                    format!("parameter `{name}` has no value"),
                    format!("write {name} = {{ value = 1.0 }}"),
                ));
            };
            let Some(number) = self.parameter_value(value, name)? else {
                if let Some((key, _)) = entries.iter().find(|(k, _)| k.get_ref() != "value") {
                    return Err(doc.error(
                        key.span(),
                        format!("parameter `{name}` is irrational and has no further entries"),
                        format!("write {name} = \"…\", or its value as a decimal number"),
                    ));
                }
                continue;
            };
            let (mut min, mut max) = (bound("min")?, bound("max")?);
            if let Some(entry) = entries.get("fixed") {
                let wrong = match entry.get_ref() {
                    Value::Boolean(false) => None,
                    Value::Boolean(true) if min.is_some() || max.is_some() => {
                        Some((format!("parameter `{name}` is fixed and has bounds"), "remove fixed, or min and max"))
                    }
                    Value::Boolean(true) => {
                        (min, max) = (Some(number.clone()), Some(number.clone()));
                        None
                    }
                    _ => {
                        let message = format!("`fixed` of parameter `{name}` must be true or false");
                        Some((message, "write fixed = true for a parameter that is known"))
                    }
                };
                if let Some((message, remedy)) = wrong {
                    return Err(doc.error(entry.span(), message, remedy));
                }
            }
            check_parameter(name, &number, min.as_ref(), max.as_ref()).map_err(|e| e.at(doc, key.span()))?;
            let (unit, about) = (doc.string(entries, "unit")?, doc.string(entries, "about")?);
            self.parameters.push(Parameter { symbol, value: number, min, max, unit, about });
        }
        Ok(())
    }

    /// The exact value: a number, or a constant such as "1/3" in quotes. `None` for an irrational one such as "sqrt(2)",
    /// which becomes a definition of that name.
    fn parameter_value(&mut self, value: Located<'_, '_>, name: &str) -> Result<Option<Rational>, FileError> {
        if !matches!(value.get_ref(), Value::String(_)) {
            return self.doc.exact_number(value, name).map(Some);
        }
        let Ok(written) = self.doc.expression(value, name, &mut self.pool, &mut Constants) else {
            return self.doc.exact_number(value, name).map(Some);
        };
        let constant = self.pool.simplify(written);
        if let Some(number) = self.pool.number(constant) {
            return Ok(Some(number.clone()));
        }
        let mut out = [f64::NAN];
        if let Ok(tape) = Tape::compile(&self.pool, &[], &[constant]) {
            tape.eval(&[], &mut Vec::new(), &mut out);
        }
        if !out[0].is_finite() {
            let remedy = "write a number, or a constant such as \"1/3\" or \"sqrt(2)\"";
            return Err(self.doc.error(value.span(), format!("`{name}` is not a finite real number"), remedy));
        }
        self.constants.push((name.to_owned(), constant));
        Ok(None)
    }

    fn read_ranges(&mut self, table: &Table<'_>) -> Result<Vec<InputRange>, FileError> {
        let doc = self.doc;
        let mut ranges = Vec::new();
        for (key, value) in doc.sub_table(table, "ranges")?.into_iter().flatten() {
            let name: &str = key.get_ref();
            let Some(&input) = self.inputs.iter().find(|&&u| self.pool.name(u) == name) else {
                let known: Vec<&str> = self.inputs.iter().map(|&u| self.pool.name(u)).collect();
                let remedy = match closest_name(name, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("the inputs are {}", known.join(", ")),
                };
                return Err(doc.error(key.span(), format!("`{name}` is not an input"), remedy));
            };
            let Value::Table(entries) = value.get_ref() else {
                let remedy = format!("write {name} = {{ min = 0 }}, with or without max");
                return Err(doc.error(value.span(), format!("the range of `{name}` is not a table"), remedy));
            };
            doc.only_keys(entries, &["min", "max"], "a range")?;
            let bound = |k: &str| entries.get(k).map(|v| doc.exact_number(v, k)).transpose();
            let (min, max) = (bound("min")?, bound("max")?);
            check_range(name, min.as_ref(), max.as_ref()).map_err(|e| e.at(doc, key.span()))?;
            ranges.push(InputRange { input, min, max });
        }
        Ok(ranges)
    }

    /// Definitions in dependency order; they may be written in any order but not in a circle.
    fn read_definitions(
        &mut self,
        table: &Table<'_>,
        plain: &mut FxHashMap<String, Expr>,
        inputs: &[String],
        derivatives: &mut Derivatives,
        met: &mut FxHashSet<Expr>,
    ) -> Result<Vec<(String, Expr)>, FileError> {
        let doc = self.doc;
        let Some(t) = doc.sub_table(table, "definitions")? else { return Ok(Vec::new()) };
        let mut entries: Vec<(String, std::ops::Range<usize>, Located<'_, '_>, Expr)> = Vec::new();
        for (key, value) in t {
            let name: &str = key.get_ref();
            self.declared.add(name, "definition").map_err(|e| e.at(doc, key.span()))?;
            let placeholder = self.pool.var(name);
            plain.insert(name.to_owned(), placeholder);
            entries.push((name.to_owned(), key.span(), value, placeholder));
        }
        let mut raw: Vec<Expr> = Vec::new();
        for (name, _, value, _) in &entries {
            let mut scope = Scope { plain, inputs, derivatives, met };
            raw.push(doc.expression(value, name, &mut self.pool, &mut scope)?);
        }
        // Expand by depth-first search; gray nodes on the path mean a circle.
        let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
        let mut order = Vec::new();
        let place = entries.iter().enumerate().map(|(j, e)| (self.pool.symbol(&e.0), j));
        let place: FxHashMap<Symbol, usize> = place.collect();
        let mut state = vec![0u8; entries.len()];
        for start in 0..entries.len() {
            let mut stack = vec![start];
            while let Some(&i) = stack.last() {
                if state[i] == 2 {
                    stack.pop();
                    continue;
                }
                state[i] = 1;
                let uses = self.pool.symbols_of(&[raw[i]]);
                let open = uses.iter().filter_map(|s| place.get(s)).copied().filter(|&j| state[j] != 2).min();
                match open {
                    Some(j) if state[j] == 1 => {
                        let names: Vec<&str> =
                            stack.iter().skip_while(|&&k| k != j).map(|&k| entries[k].0.as_str()).collect();
                        let circle = format!("{} → {}", names.join(" → "), entries[j].0);
                        return Err(doc.error(
                            entries[j].1.clone(),
                            format!("cyclic definition: {circle}"),
                            "define one of them without the others",
                        ));
                    }
                    Some(j) => stack.push(j),
                    None => {
                        let full = self.pool.substitute(raw[i], &map);
                        map.insert(entries[i].3, full);
                        plain.insert(entries[i].0.clone(), full);
                        order.push((entries[i].0.clone(), full));
                        state[i] = 2;
                        stack.pop();
                    }
                }
            }
        }
        Ok(order)
    }

    fn read_dynamics(&mut self, table: &Table<'_>, scope: &mut Scope<'_>) -> Result<Vec<Expr>, FileError> {
        let doc = self.doc;
        let Some(t) = doc.sub_table(table, "dynamics")? else {
            return Err(doc.missing("the model has no equations", "add a table [dynamics] with one entry per state"));
        };
        let names: Vec<String> = self.states.iter().map(|&s| self.pool.name(s).to_owned()).collect();
        let known: FxHashSet<&str> = names.iter().map(String::as_str).collect();
        for key in t.keys() {
            let name: &str = key.get_ref();
            if !known.contains(name) {
                let remedy = match closest_name(name, names.iter().map(String::as_str)) {
                    Some(near) => {
                        format!("did you mean `{near}`? Otherwise add `{name}` to states or remove the equation")
                    }
                    None => format!("add `{name}` to states or remove the equation"),
                };
                return Err(doc.error(key.span(), format!("surplus equation: `{name}` is not a state"), remedy));
            }
        }
        let mut out = Vec::new();
        for (name, span) in names.iter().zip(&self.state_spans) {
            let Some(value) = t.get(name.as_str()) else {
                let message = format!("missing equation: state `{name}` has no entry in [dynamics]");
                let remedy = format!("add {name} = \"…\" (its time derivative) to [dynamics]");
                return Err(doc.error(span.clone(), message, remedy));
            };
            out.push(doc.expression(value, name, &mut self.pool, scope)?);
        }
        Ok(out)
    }

    fn read_point(&mut self, table: &Table<'_>) -> Result<Option<Point>, FileError> {
        let doc = self.doc;
        let Some(t) = doc.sub_table(table, "point")? else { return Ok(None) };
        let zero = self.pool.int(0);
        let mut point = Point { states: vec![zero; self.states.len()], inputs: vec![zero; self.inputs.len()] };
        for (key, value) in t {
            let name: &str = key.get_ref();
            let number = doc.expression(value, name, &mut self.pool, &mut Constants)?;
            let mut found = [f64::NAN];
            if let Ok(tape) = Tape::compile(&self.pool, &[], &[number]) {
                tape.eval(&[], &mut Vec::new(), &mut found);
            }
            if !found[0].is_finite() {
                let message = format!("the value of `{name}` at the point is not a finite number");
                return Err(doc.error(
                    value.span(),
                    message,
                    "write a constant that has a value, such as 0.3, pi/2, or sqrt(2)",
                ));
            }
            let at = |list: &[Symbol]| list.iter().position(|&s| self.pool.name(s) == name);
            if let Some(i) = at(&self.states) {
                point.states[i] = number;
            } else if let Some(i) = at(&self.inputs) {
                point.inputs[i] = number;
            } else {
                let known: Vec<&str> = self.states.iter().chain(&self.inputs).map(|&s| self.pool.name(s)).collect();
                let remedy = match closest_name(name, known.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "a point gives values to states and inputs".into(),
                };
                return Err(doc.error(key.span(), format!("`{name}` is neither a state nor an input"), remedy));
            }
        }
        Ok(Some(point))
    }
}
