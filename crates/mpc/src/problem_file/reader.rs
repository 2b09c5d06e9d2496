//! Values of a problem file: numbers, names, expressions.

use super::free::Free;
use super::tree::Tree;
use super::units::without_unit;
use crate::ocp::Remembered;
use bracketry_symbolic::{Expr, Names, Pool, Tape};
use bracketry_system::{Document, FileError, System, Table, Value};
use std::ops::Range;
use std::path::Path;

pub(super) type Located<'a, 'i> = &'a toml::Spanned<Value<'i>>;
pub(super) type Key<'i> = toml::Spanned<std::borrow::Cow<'i, str>>;
pub(super) type Parsed<T> = Result<T, Box<FileError>>;

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
        let mut known = self.system.parameter_names();
        known.extend(self.time.then(|| "t".to_owned()));
        known
    }
}

/// Largest count where nothing else limits it.
const MOST: usize = 1_000_000;

/// What a name in a table stands for.
#[derive(Clone, Copy)]
pub(super) enum Variable {
    State(usize),
    Input(usize),
}

#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) doc: &'a Document,
    pub(super) system: &'a System,
    /// Where the tables that the file names are looked for.
    pub(super) folder: &'a Path,
    /// The inputs that costs and constraints remember.
    pub(super) remembered: &'a Remembered,
    /// What is free, in the problem that is solved for it.
    pub(super) free: Option<&'a Free>,
    /// The branches, in the problem of all of them.
    pub(super) tree: Option<&'a Tree>,
    /// The branch whose constraints are read.
    pub(super) branch: usize,
}

impl Reader<'_> {
    pub(super) fn required<'t, 'i>(&self, table: &'t Table<'i>, key: &str, remedy: &str) -> Parsed<&'t Table<'i>> {
        let found = self.doc.sub_table(table, key)?;
        Ok(found.ok_or_else(|| self.doc.missing(format!("[{key}] is missing"), format!("add {remedy}")))?)
    }

    /// Refuses derivatives of inputs, which costs and constraints do not have.
    pub(super) fn without_derivatives(&self, v: Located<'_, '_>) -> Parsed<()> {
        let Value::String(text) = v.get_ref() else { return Ok(()) };
        let names = self.system.input_names();
        let compact: String = text.split_whitespace().collect();
        let Some(name) =
            names.iter().find(|name| [")", ","].iter().any(|end| compact.contains(&format!("der({name}{end}"))))
        else {
            return Ok(());
        };
        let remedy = format!(
            "write `rate({name})` for the change of `{name}` from one sample to the next over the period. For an input that \
             changes continuously, make `{name}` a state of the model, with its rate as the input: dynamics = {{ {name} = \
             \"{name}_rate\" }}"
        );
        Err(self.doc.error(v.span(), format!("`der({name})` cannot be used in a cost or constraint"), remedy).into())
    }

    pub(super) fn number(&self, table: &Table<'_>, key: &str, default: Option<f64>) -> Parsed<(f64, Range<usize>)> {
        match (table.get(key), default) {
            (Some(v), _) => Ok((self.constant(v, key)?, v.span())),
            (None, Some(d)) => Ok((d, 0..0)),
            (None, None) => Err(self.doc.missing(format!("`{key}` is missing"), format!("add `{key} = …`")).into()),
        }
    }

    pub(super) fn positive(&self, table: &Table<'_>, key: &str, default: Option<f64>) -> Parsed<f64> {
        let (v, span) = self.number(table, key, default)?;
        if v > 0.0 {
            Ok(v)
        } else {
            Err(self.doc.error(span, format!("`{key}` must be positive"), "give a positive number").into())
        }
    }

    pub(super) fn not_negative(&self, table: &Table<'_>, key: &str, default: f64) -> Parsed<f64> {
        let (v, span) = self.number(table, key, Some(default))?;
        if v >= 0.0 {
            Ok(v)
        } else {
            Err(self.doc.error(span, format!("`{key}` must not be negative"), "give 0 or more").into())
        }
    }

    pub(super) fn count(&self, table: &Table<'_>, key: &str, default: Option<usize>) -> Parsed<usize> {
        self.count_up_to(table, key, default, MOST)
    }

    /// A whole number from 1 that may be at most `most`; a larger one up to a million is left to the caller to refuse with a remedy.
    pub(super) fn count_up_to(
        &self,
        table: &Table<'_>,
        key: &str,
        default: Option<usize>,
        most: usize,
    ) -> Parsed<usize> {
        let (v, span) = self.number(table, key, default.map(|d| d as f64))?;
        if (1.0..=MOST as f64).contains(&v) && v.fract() == 0.0 {
            Ok(v as usize)
        } else {
            let message = format!("`{key}` must be a whole number from 1 to {most}");
            Err(self.doc.error(span, message, "give a whole number").into())
        }
    }

    /// A whole number from 0.
    pub(super) fn whole(&self, table: &Table<'_>, key: &str, default: usize) -> Parsed<usize> {
        let (v, span) = self.number(table, key, Some(default as f64))?;
        if (0.0..=1e9).contains(&v) && v.fract() == 0.0 {
            Ok(v as usize)
        } else {
            let message = format!("`{key}` must be a whole number from 0 to 1000000000");
            Err(self.doc.error(span, message, "give a whole number").into())
        }
    }

    pub(super) fn boolean(&self, table: &Table<'_>, key: &str, default: bool) -> Parsed<bool> {
        match table.get(key) {
            None => Ok(default),
            Some(v) => match v.get_ref() {
                Value::Boolean(b) => Ok(*b),
                _ => Err(self
                    .doc
                    .error(v.span(), format!("`{key}` must be true or false"), "write it without quotes")
                    .into()),
            },
        }
    }

    /// What the name under `key` stands for, one of the `options`; the first of them where there is none.
    pub(super) fn choice<T: Copy>(&self, table: &Table<'_>, key: &str, what: &str, options: &[(&str, T)]) -> Parsed<T> {
        let name = self.doc.string(table, key)?;
        let (Some(name), Some(v)) = (name, table.get(key)) else { return Ok(options[0].1) };
        let names: Vec<String> = options.iter().map(|o| format!("\"{}\"", o.0)).collect();
        options.iter().find(|o| o.0 == name).map(|o| o.1).ok_or_else(|| {
            let remedy = format!("write {} or {}", names[..names.len() - 1].join(", "), names[names.len() - 1]);
            self.doc.error(v.span(), format!("there is no {what} `{name}`"), remedy).into()
        })
    }

    /// A number, or an expression of parameters in quotes.
    pub(super) fn constant(&self, v: Located<'_, '_>, key: &str) -> Parsed<f64> {
        let value = self.over_time(v, key, false)?;
        Ok(value(0.0))
    }

    /// An expression of parameters and perhaps the time, as a function.
    pub(super) fn over_time(&self, v: Located<'_, '_>, key: &str, time: bool) -> Parsed<impl Fn(f64) -> f64 + use<>> {
        self.derivative_over_time(v, key, time, 0)
    }

    /// The derivative of such an expression with respect to the time, 0 for itself; finite at the start.
    pub(super) fn derivative_over_time(
        &self,
        v: Located<'_, '_>,
        key: &str,
        time: bool,
        order: u32,
    ) -> Parsed<impl Fn(f64) -> f64 + use<>> {
        let value = self.derivative_of_time(v, key, time, order)?;
        if value(0.0).is_finite() {
            Ok(value)
        } else {
            Err(self.doc.error(v.span(), format!("`{key}` is not a finite number"), "write a finite number").into())
        }
    }

    /// The same, where it exists.
    pub(super) fn derivative_of_time(
        &self,
        v: Located<'_, '_>,
        key: &str,
        time: bool,
        order: u32,
    ) -> Parsed<impl Fn(f64) -> f64 + use<>> {
        if let Value::String(text) = v.get_ref()
            && let Some(remedy) = without_unit(text)
        {
            return Err(self.doc.error(v.span(), format!("`{key}` has a unit, `{text}`"), remedy).into());
        }
        if let (Value::String(text), Some(free)) = (v.get_ref(), self.free)
            && let Some(name) = free.names().into_iter().find(|name| identifiers(text).any(|word| word == name))
        {
            let message = format!("`{key}` depends on the free parameter `{name}`, which has no value before the plan");
            let remedy = format!(
                "write a number; what the plan is to reach or keep may depend on `{name}` in [cost] and in expressions of [constraints]"
            );
            return Err(self.doc.error(v.span(), message, remedy).into());
        }
        let mut pool = Pool::new();
        let mut e = self.doc.expression(v, key, &mut pool, &mut Constants { system: self.system, time })?;
        let t = pool.symbol("t");
        for _ in 0..order {
            e = pool.diff(e, t);
        }
        let tape = Tape::compile(&pool, &[t], &[e])
            .map_err(|e| self.doc.error(v.span(), e.to_string(), "use numbers and parameters"))?;
        Ok(move |t: f64| {
            let mut out = [0.0];
            tape.eval(&[t], &mut Vec::new(), &mut out);
            out[0]
        })
    }

    pub(super) fn variable(&self, name: &str, span: Range<usize>) -> Parsed<Variable> {
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

    pub(super) fn state(&self, name: &str, span: Range<usize>) -> Parsed<usize> {
        let found = self.system.state_index(name);
        found.ok_or_else(|| self.unknown(name, span, "state", &self.system.state_names()))
    }

    pub(super) fn input(&self, name: &str, span: Range<usize>) -> Parsed<usize> {
        let found = self.system.input_index(name);
        found.ok_or_else(|| self.unknown(name, span, "input", &self.system.input_names()))
    }

    pub(super) fn unknown(&self, name: &str, span: Range<usize>, what: &str, known: &[String]) -> Box<FileError> {
        let article = if what.starts_with('i') { "an" } else { "a" };
        let remedy = match known {
            [] => "the model has none".to_owned(),
            known => format!("the model has: {}", known.join(", ")),
        };
        self.doc.error(span, format!("`{name}` is not {article} {what} of the model"), remedy).into()
    }
}

/// The names in an expression.
pub(super) fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}
