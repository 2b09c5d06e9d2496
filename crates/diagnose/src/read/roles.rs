//! Which column is what.

use std::collections::{BTreeMap, BTreeSet};

use bracketry_system::symbolic::{Node, Symbol};
use bracketry_system::{Columns, FileError, System};

use super::origin::Origin;
use crate::Quantity;

/// What a column means to a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Time in seconds.
    Time,
    /// An input, by index.
    Input(usize),
    /// A derivative that the equations use: index of the input, order.
    Derivative(usize, u32),
    /// Something measured.
    Measured(Quantity),
}

/// The role of a column of that name, if it has one. An output that is nothing but a state is that state.
pub(super) fn role(name: &str, system: &System) -> Option<Role> {
    if name == "t" {
        return Some(Role::Time);
    }
    if let Some(input) = system.input_index(name) {
        return Some(Role::Input(input));
    }
    if let Some(output) = system.outputs.iter().position(|(output, _)| output == name) {
        let quantity = match system.pool.node(system.outputs[output].1) {
            Node::Sym(s) => system.states.iter().position(|state| *state == s).map(Quantity::State),
            _ => None,
        };
        return Some(Role::Measured(quantity.unwrap_or(Quantity::Output(output))));
    }
    if let Some(state) = system.state_index(name) {
        return Some(Role::Measured(Quantity::State(state)));
    }
    let (input, order) = Columns::derivative_name(name)?;
    let input = system.input_index(input)?;
    let used = system.input_derivatives.iter().any(|d| d.input == input && d.order == order);
    used.then_some(Role::Derivative(input, order))
}

/// The columns by what they mean.
pub(super) struct Roles {
    pub(super) times: Vec<f64>,
    /// The row of the table of each sample, or that before it where there is none.
    pub(super) rows: Vec<usize>,
    pub(super) inputs: BTreeMap<usize, Vec<f64>>,
    pub(super) derivatives: BTreeMap<(usize, u32), Vec<f64>>,
    pub(super) measured: Vec<(String, Quantity, Vec<f64>)>,
    names: Vec<String>,
}

impl Roles {
    /// Sorts the columns, all of which have a role.
    ///
    /// # Errors
    /// [`FileError`] if time, something measured, or an input that the model needs is missing; it lists what there is and
    /// what could be.
    pub(super) fn of(
        origin: &Origin<'_>,
        columns: BTreeMap<String, Vec<f64>>,
        ignored: &[String],
        system: &System,
    ) -> Result<Self, FileError> {
        system.leaves_time_free(&bracketry_system::Document::new(origin.name, ""))?;
        let found: Vec<&str> = columns.keys().chain(ignored).map(String::as_str).collect();
        let found = found.join(", ");
        let names = system.input_names();
        let mut roles = Self {
            times: Vec::new(),
            rows: Vec::new(),
            inputs: BTreeMap::new(),
            derivatives: BTreeMap::new(),
            measured: Vec::new(),
            names: names.clone(),
        };
        for (name, values) in columns {
            match role(&name, system) {
                Some(Role::Time) => roles.times = values,
                Some(Role::Input(input)) => {
                    roles.inputs.insert(input, values);
                }
                Some(Role::Derivative(input, order)) => {
                    let before = roles.derivatives.insert((input, order), values);
                    if before.is_some() {
                        let message = format!("two columns define der({},{order})", names[input]);
                        return Err(origin.whole(message, "remove one of them"));
                    }
                }
                Some(Role::Measured(quantity)) => {
                    if let Some((other, _, known)) = roles.measured.iter().find(|(_, q, _)| *q == quantity) {
                        // A table of a simulation has a state once more as the output that it is.
                        if known.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits()) {
                            continue;
                        }
                        let message = format!(
                            "the columns `{other}` and `{name}` measure the same quantity with different numbers"
                        );
                        return Err(origin.whole(message, "remove one of them"));
                    }
                    roles.measured.push((name, quantity, values));
                }
                None => {}
            }
        }
        if roles.times.is_empty() {
            let message = format!("there is no column `t`; the columns are {found}");
            let column = ignored.iter().find(|c| c.to_lowercase().contains("time")).or(ignored.first());
            let column = column.map_or("time", String::as_str);
            return Err(origin.whole(message, format!("name the column of the time t: --rename \"{column}=t\"")));
        }
        if roles.measured.is_empty() {
            let known = measurable(system).join(", ");
            let message =
                format!("no measurement: no column has the name of a state or an output; the columns are {found}");
            let called = |column: &&String| {
                let starts = |name: &String| column.to_lowercase().starts_with(&name.to_lowercase());
                measurable(system).into_iter().find(starts).map(|name| ((*column).clone(), name))
            };
            let (column, name) =
                ignored.iter().find_map(|c| called(&c)).unwrap_or_else(|| ("q".to_owned(), "x".to_owned()));
            let remedy = format!("name a column after one of {known}: --rename \"{column}={name}\"");
            return Err(origin.whole(message, remedy));
        }
        roles.rows = (0..roles.times.len()).collect();
        let missing: Vec<String> = roles.missing(system);
        if !missing.is_empty() {
            let message = format!(
                "the model uses `{}`, for which there is no column; the columns are {found}",
                missing.join("`, `")
            );
            let remedy = format!("add a column, or name an existing one: --rename column={}", missing[0]);
            return Err(origin.whole(message, remedy));
        }
        Ok(roles)
    }

    /// Inputs and derivatives that the equations use and nothing gives.
    fn missing(&self, system: &System) -> Vec<String> {
        let measured = self.measured.iter().filter_map(|(_, quantity, _)| match quantity {
            Quantity::Output(output) => Some(system.outputs[*output].1),
            Quantity::State(_) => None,
        });
        let used: Vec<_> = system.dynamics.iter().copied().chain(measured).collect();
        let used: BTreeSet<Symbol> = system.pool.symbols_of(&used).into_iter().collect();
        let inputs = (0..system.inputs.len()).filter(|input| used.contains(&system.inputs[*input]));
        let inputs = inputs.filter(|input| !self.inputs.contains_key(input)).map(|input| self.names[input].clone());
        let derivatives = system.input_derivatives.iter().filter(|d| used.contains(&d.symbol));
        let derivatives = derivatives
            .filter(|d| !self.inputs.contains_key(&d.input) && !self.derivatives.contains_key(&(d.input, d.order)))
            .map(|d| format!("der({},{})", self.names[d.input], d.order));
        inputs.chain(derivatives).collect()
    }

    /// Columns that drive the model, by name.
    pub(super) fn driving(&self) -> impl Iterator<Item = (String, &Vec<f64>)> {
        let inputs = self.inputs.iter().map(|(input, values)| (self.names[*input].clone(), values));
        let derivatives = self.derivatives.iter();
        inputs.chain(derivatives.map(|((input, order), v)| (format!("der({},{order})", self.names[*input]), v)))
    }

    /// As [`Self::driving`], to be changed, without names.
    pub(super) fn driving_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.inputs.values_mut().chain(self.derivatives.values_mut())
    }

    /// All columns but the time.
    pub(super) fn all(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.inputs.values().chain(self.derivatives.values()).chain(self.measured.iter().map(|m| &m.2))
    }

    /// All columns but the time, by name, to be changed.
    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = (String, &mut Vec<f64>)> {
        let Self { inputs, derivatives, measured, names, .. } = self;
        let names = &*names;
        let inputs = inputs.iter_mut().map(|(input, values)| (names[*input].clone(), values));
        let derivatives =
            derivatives.iter_mut().map(|((input, order), v)| (format!("der({},{order})", names[*input]), v));
        inputs.chain(derivatives).chain(measured.iter_mut().map(|(name, _, values)| (name.clone(), values)))
    }

    /// Leaves out rows.
    pub(super) fn keep(&mut self, kept: &[bool]) {
        if kept.iter().all(|k| *k) {
            return;
        }
        retain(&mut self.times, kept);
        retain(&mut self.rows, kept);
        self.driving_mut().for_each(|values| retain(values, kept));
        self.measured.iter_mut().for_each(|(_, _, values)| retain(values, kept));
    }

    /// Puts a row after each of some, in ascending order: times and inputs in the middle, and nothing measured.
    pub(super) fn insert_after(&mut self, rows: &[usize]) {
        let insert = |values: &mut Vec<f64>, between: fn(f64, f64) -> f64| {
            let mut rows = rows.iter().peekable();
            let mut out = Vec::with_capacity(values.len() + rows.len());
            for (k, &value) in values.iter().enumerate() {
                out.push(value);
                if rows.next_if(|row| **row == k).is_some() {
                    out.push(between(value, values[k + 1]));
                }
            }
            *values = out;
        };
        let middle = |a: f64, b: f64| 0.5 * (a + b);
        for row in rows.iter().rev() {
            self.rows.insert(row + 1, self.rows[*row]);
        }
        insert(&mut self.times, middle);
        self.driving_mut().for_each(|values| insert(values, middle));
        self.measured.iter_mut().for_each(|(_, _, values)| insert(values, |_, _| f64::NAN));
    }
}

fn retain<T>(values: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    values.retain(|_| kept.next().is_none_or(|k| *k));
}

/// Names that a column may have: the time, inputs, their derivatives in use, states and outputs.
pub(super) fn known(system: &System) -> Vec<String> {
    let inputs = system.input_names();
    let derivatives = system.input_derivatives.iter().map(|d| format!("der({},{})", inputs[d.input], d.order));
    ["t".to_owned()].into_iter().chain(inputs.iter().cloned()).chain(derivatives).chain(measurable(system)).collect()
}

/// Names of states and outputs, each once.
fn measurable(system: &System) -> Vec<String> {
    let states = system.state_names();
    let outputs = system.outputs.iter().map(|(name, _)| name.clone()).filter(|name| !states.contains(name));
    states.iter().cloned().chain(outputs).collect()
}
