//! Model files: writing.

use bracketry_symbolic::{Expr, Rational};
use serde::Serialize;

use crate::system::System;
use crate::time_unit::TimeUnit;

/// A system that cannot be written as a model file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// An equation whose text would repeat its shared parts too often.
    #[error("the equation of `{name}` has {nodes:.0e} nodes with expanded definitions, too many to be written")]
    TooLong {
        /// State or output.
        name: String,
        /// Nodes without sharing.
        nodes: f64,
    },
    /// The TOML writer refused.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
}

/// A model file as plain data, for writing as TOML or JSON.
#[derive(Serialize)]
struct Plain {
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_unit: Option<&'static str>,
    states: Vec<String>,
    inputs: Vec<String>,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    ranges: toml::Table,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    delays: toml::Table,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    parameters: toml::Table,
    dynamics: toml::Table,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    algebraic: toml::Table,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    outputs: toml::Table,
    #[serde(rename = "static", skip_serializing_if = "toml::Table::is_empty")]
    static_levels: toml::Table,
    #[serde(skip_serializing_if = "Option::is_none")]
    point: Option<toml::Table>,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    units: toml::Table,
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    labels: toml::Table,
}

impl System {
    /// The system as the text of a model file; definitions stay expanded.
    ///
    /// # Errors
    /// [`WriteError`] for an equation that is too long to be written out.
    pub fn to_toml(&self) -> Result<String, WriteError> {
        let outputs = self.outputs.iter().map(|(n, e)| (n.clone(), *e));
        for (name, e) in self.state_names().into_iter().zip(self.dynamics.iter().copied()).chain(outputs) {
            if !self.pool.is_printable(e) {
                return Err(WriteError::TooLong { name, nodes: self.pool.tree_size(e) });
            }
        }
        Ok(toml::to_string_pretty(&self.plain())?)
    }

    fn plain(&self) -> Plain {
        if !self.pool.has_directed() {
            return self.plain_as_it_is();
        }
        // What was written with `unit` has to be read as such again.
        let mut written = self.clone();
        let rows = written.rows();
        let mut rows = written.with_units_as_written(&rows).into_iter();
        written.dynamics.iter_mut().zip(&mut rows).for_each(|(e, new)| *e = new);
        written.outputs.iter_mut().zip(&mut rows).for_each(|(e, new)| e.1 = new);
        written.plain_as_it_is()
    }

    fn plain_as_it_is(&self) -> Plain {
        let text = |e: Expr| toml::Value::String(self.pool.text(e));
        let number = |r: &Rational| toml::Value::Float(r.to_f64().value());
        // A fraction such as 1/3 has no decimal form.
        let value = |r: &Rational| if is_decimal(r) { number(r) } else { toml::Value::String(r.to_string()) };
        let mut parameters = toml::Table::new();
        for p in &self.parameters {
            let mut t = toml::Table::new();
            t.insert("value".into(), value(&p.value));
            if p.is_fixed() {
                t.insert("fixed".into(), toml::Value::Boolean(true));
            } else {
                for (k, v) in [("min", &p.min), ("max", &p.max)] {
                    if let Some(v) = v {
                        t.insert(k.into(), number(v));
                    }
                }
            }
            for (k, v) in [("unit", &p.unit), ("about", &p.about)] {
                if let Some(v) = v {
                    t.insert(k.into(), toml::Value::String(v.clone()));
                }
            }
            let value = if t.len() == 1 { value(&p.value) } else { toml::Value::Table(t) };
            parameters.insert(self.pool.name(p.symbol).to_owned(), value);
        }
        let mut ranges = toml::Table::new();
        for r in &self.input_ranges {
            let ends = [("min", &r.min), ("max", &r.max)];
            let ends = ends.into_iter().filter_map(|(k, v)| Some((k.to_owned(), number(v.as_ref()?)))).collect();
            ranges.insert(self.pool.name(r.input).to_owned(), toml::Value::Table(ends));
        }
        let delays = self.input_delays.iter().map(|d| {
            let value = self.pool.number(d.delay).map_or_else(|| text(d.delay), number);
            (self.pool.name(d.input).to_owned(), value)
        });
        let static_levels = self.static_levels.iter().map(|level| {
            let components: Vec<String> = level.components.iter().map(|&c| self.pool.text(c)).collect();
            (components.join(", "), text(level.ratio))
        });
        let point = self.point.as_ref().filter(|_| self.point_is_finite()).map(|p| {
            let states = self.states.iter().zip(&p.states);
            let inputs = self.inputs.iter().zip(&p.inputs);
            let nonzero = states.chain(inputs).filter(|(_, v)| !self.pool.is_zero(**v));
            nonzero.map(|(s, v)| (self.pool.name(*s).to_owned(), text(*v))).collect()
        });
        let algebraic = self.algebraic.iter().map(|z| {
            let entries = [("equation", z.residual), ("guess", z.guess)];
            let entries: toml::Table = entries.into_iter().map(|(k, e)| (k.to_owned(), text(e))).collect();
            (self.pool.name(z.symbol).to_owned(), toml::Value::Table(entries))
        });
        let quantities = &self.quantities;
        let stated = |what: &dyn Fn(&str) -> Option<String>| -> toml::Table {
            self.quantity_names()
                .into_iter()
                .filter_map(|n| Some((n.clone(), toml::Value::String(what(&n)?))))
                .collect()
        };
        Plain {
            name: self.name.clone(),
            time: self.period.map(|_| "discrete"),
            period: self.period,
            time_unit: (quantities.time_unit != TimeUnit::Second).then(|| quantities.time_unit.symbol()),
            algebraic: algebraic.collect(),
            states: self.state_names(),
            inputs: self.input_names(),
            ranges,
            delays: delays.collect(),
            parameters,
            dynamics: self.state_names().into_iter().zip(self.dynamics.iter().map(|&e| text(e))).collect(),
            outputs: self.outputs.iter().map(|(n, e)| (n.clone(), text(*e))).collect(),
            static_levels: static_levels.collect(),
            point,
            units: stated(&|n| quantities.unit(n).map(str::to_owned)),
            labels: stated(&|n| quantities.label(n).map(str::to_owned)),
        }
    }
}

/// True for a number with finitely many decimals, and for one with too large a denominator to be told.
fn is_decimal(r: &Rational) -> bool {
    let Ok(mut denominator) = u64::try_from(r.denominator()) else { return true };
    for q in [2, 5] {
        while denominator.is_multiple_of(q) {
            denominator /= q;
        }
    }
    denominator == 1
}

impl Serialize for System {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.plain().serialize(serializer)
    }
}
