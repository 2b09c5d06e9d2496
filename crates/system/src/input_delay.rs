//! Delays of inputs: the table `[delays]` of model files, and what becomes of them where inputs are changed.

use bracketry_symbolic::{Expr, Names, Pool, Symbol, closest_name};
use rustc_hash::FxHashMap;

use crate::candidate::{Candidate, Method};
use crate::reason::AffineReason;
use crate::system::{InputDelay, System};
use bracketry_files::{Document, FileError, Table};

/// The parameters alone.
struct Parameters(FxHashMap<String, Symbol>);

impl Names for Parameters {
    fn lookup(&mut self, pool: &mut Pool, name: &str) -> Option<Expr> {
        self.0.get(name).map(|s| pool.sym(*s))
    }

    fn known(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}

/// Reads the table `[delays]`: keys are inputs, values seconds, as numbers or expressions of parameters.
pub(crate) fn read_input_delays(doc: &Document, table: &Table<'_>, system: &mut System) -> Result<(), FileError> {
    let parameters = system.parameters.iter().map(|p| (system.symbol_name(p.symbol).to_owned(), p.symbol)).collect();
    let mut names = Parameters(parameters);
    for (key, value) in doc.sub_table(table, "delays")?.into_iter().flatten() {
        let name: &str = key.get_ref();
        let Some(input) = system.input_index(name) else {
            let known = system.input_names();
            let remedy = match closest_name(name, known.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the inputs are {}", known.join(", ")),
            };
            return Err(doc.error(key.span(), format!("`{name}` is not an input"), remedy));
        };
        let delay = doc.expression(value, name, &mut system.pool, &mut names)?;
        system.check_delay(name, delay).map_err(|e| e.at(doc, value.span()))?;
        system.input_delays.push(InputDelay { input: system.inputs[input], delay });
    }
    Ok(())
}

impl Candidate {
    /// Writes the delays of new inputs, and of inputs that stay, into the candidate's system: integrators and functions of
    /// inputs alone commute with a delay, functions of the state do not.
    pub(crate) fn transfer_delays(&mut self, original: &System) {
        let Some(system) = self.system.as_mut().filter(|_| self.method != Method::None) else { return };
        if original.input_delays.is_empty() {
            return;
        }
        let delay_of = |input: Symbol| original.input_delays.iter().find(|d| d.input == input).map(|d| d.delay);
        let mut delays = Vec::new();
        let mut inexact = Vec::new();
        for (index, &new) in system.inputs.iter().enumerate() {
            let name = system.pool.name(new).to_owned();
            let function = self.input_change.iter().find(|v| v.name == name).map(|v| v.function);
            let commanded = match function {
                None if original.inputs.contains(&new) => vec![new],
                // A derivative of the input in the same place.
                None => original.inputs.get(index).map_or_else(Vec::new, |&u| vec![u]),
                Some(function) => {
                    let Some(inputs) = inputs_in(original, &self.derivatives, system, function) else {
                        inexact.push(name);
                        continue;
                    };
                    inputs
                }
            };
            let mut found: Vec<Option<Expr>> = commanded.into_iter().map(delay_of).collect();
            found.dedup();
            match found[..] {
                [Some(delay)] => delays.push(InputDelay { input: new, delay }),
                [] | [None] => {}
                _ => inexact.push(name),
            }
        }
        system.input_delays = delays;
        if !inexact.is_empty() {
            let then = Box::new(self.why.clone());
            self.why = AffineReason::WithoutDelays { functions: inexact, then };
        }
    }
}

/// The inputs of the original, themselves or by their derivatives, that a function is made of; `None` if it depends on
/// states too.
fn inputs_in(
    original: &System,
    derivatives: &[(Symbol, usize)],
    system: &System,
    function: Expr,
) -> Option<Vec<Symbol>> {
    let mut found = Vec::new();
    for symbol in system.pool.symbols_of(&[function]) {
        if original.parameters.iter().any(|p| p.symbol == symbol) {
            continue;
        }
        let derivative = original.input_derivatives.iter().find(|d| d.symbol == symbol).map(|d| d.input);
        let input = original.inputs.iter().position(|u| *u == symbol).or(derivative);
        let input = input.or_else(|| derivatives.iter().find(|d| d.0 == symbol).map(|d| d.1))?;
        found.push(original.inputs[input]);
    }
    Some(found)
}
