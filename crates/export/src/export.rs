//! From a system to source code.

use bracketry_symbolic::{Expr, Rational, Symbol, closest_name};
use bracketry_system::{Parameter, SingleValued, System};
use rustc_hash::FxHashMap;

use crate::equations::compiled;
use crate::error::ExportError;
use crate::exported::{Constant, Export, Quantity};
use crate::identifier::{checked, identifier};
use crate::note::ExportNote;
use crate::options::{ExportOptions, KeptParameters};
use crate::write::write;

/// Writes f, h and their Jacobians as source code.
///
/// The text depends on the model and the options alone.
///
/// # Errors
/// [`ExportError`] for a parameter that the model does not have, a name that is none, or a denominator that is zero everywhere.
pub fn export(system: &System, options: &ExportOptions) -> Result<Export, ExportError> {
    let mut system = system.clone();
    let kept = kept(&system, &options.parameters)?;
    let name = match &options.name {
        Some(name) => checked(name)?,
        None => identifier(&system.name),
    };
    check_denominators(&system, &kept)?;
    let single_valued = system.single_valued();
    let notes = notes(&system, &single_valued);
    let states = system.states.clone();
    let inputs: Vec<Symbol> = system.arguments().split_off(states.len());
    let parameters: Vec<Symbol> = kept.iter().map(|&i| system.parameters[i].symbol).collect();
    let rows: Vec<Expr> = [single_valued.dynamics.as_slice(), &single_valued.outputs].concat();
    let mut rows = with_constants(&mut system, &rows, &kept);
    let outputs = rows.split_off(states.len());
    let functions = compiled(&mut system.pool, [&states, &inputs, &parameters], &rows, &outputs)?;
    let constant = |p: &Parameter| Constant {
        name: system.symbol_name(p.symbol).to_owned(),
        value: number(&p.value),
        unit: p.unit.clone(),
        about: p.about.clone(),
    };
    let others = (0..system.parameters.len()).filter(|i| !kept.contains(i));
    let mut made = Export {
        target: options.target,
        name,
        states: states.iter().map(|&s| quantity(&system, s)).collect(),
        inputs: inputs.iter().map(|&s| quantity(&system, s)).collect(),
        outputs: system.outputs.iter().map(|(name, _)| Quantity { name: name.clone(), min: None, max: None }).collect(),
        parameters: kept.iter().map(|&i| constant(&system.parameters[i])).collect(),
        constants: others.map(|i| constant(&system.parameters[i])).collect(),
        functions: functions.iter().map(|f| f.signature.clone()).collect(),
        notes,
        files: Vec::new(),
        single: String::new(),
        model: system.name,
    };
    write(&mut made, &functions);
    Ok(made)
}

/// Which parameters are arguments, in their order.
fn kept(system: &System, wanted: &KeptParameters) -> Result<Vec<usize>, ExportError> {
    let names = match wanted {
        KeptParameters::None => return Ok(Vec::new()),
        KeptParameters::All => return Ok((0..system.parameters.len()).collect()),
        KeptParameters::Named(names) => names,
    };
    let known: Vec<&str> = system.parameters.iter().map(|p| system.symbol_name(p.symbol)).collect();
    let mut kept = Vec::new();
    for name in names {
        let Some(at) = known.iter().position(|k| k == name) else {
            let remedy = match closest_name(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "it has none: all numbers are in the equations".to_owned(),
                None => format!("its parameters are {}", known.join(", ")),
            };
            return Err(ExportError::UnknownParameter { name: name.clone(), remedy });
        };
        if kept.contains(&at) {
            return Err(ExportError::RepeatedParameter { name: name.clone() });
        }
        kept.push(at);
    }
    Ok(kept)
}

/// Refuses constants that make a denominator zero; parameters that are arguments may have any value.
fn check_denominators(system: &System, kept: &[usize]) -> Result<(), ExportError> {
    let mut constants = system.clone();
    let mut at = 0..;
    constants.parameters.retain(|_| at.next().is_some_and(|i| !kept.contains(&i)));
    Ok(constants.check_denominators()?)
}

/// The expressions with the exact values of all parameters but those kept.
fn with_constants(system: &mut System, rows: &[Expr], kept: &[usize]) -> Vec<Expr> {
    let pool = &mut system.pool;
    let others = system.parameters.iter().enumerate().filter(|(i, _)| !kept.contains(i));
    let values: FxHashMap<Expr, Expr> =
        others.map(|(_, p)| (pool.sym(p.symbol), pool.rational(p.value.clone()))).collect();
    pool.substitute_all(rows, &values)
}

fn number(value: &Rational) -> f64 {
    value.to_f64().value()
}

fn quantity(system: &System, symbol: Symbol) -> Quantity {
    let range = system.input_ranges.iter().find(|r| r.input == symbol);
    let (min, max) = range.map_or((None, None), |r| (r.min.as_ref(), r.max.as_ref()));
    Quantity { name: system.symbol_name(symbol).to_owned(), min: min.map(number), max: max.map(number) }
}

fn notes(system: &System, single_valued: &SingleValued) -> Vec<ExportNote> {
    let pool = &system.pool;
    let list = |components: &[Expr]| components.iter().map(|&e| pool.text(e)).collect::<Vec<_>>().join(", ");
    let unit = |components: &[Expr]| format!("unit({})", list(components));
    let mut notes = Vec::new();
    let mut terms: Vec<String> = single_valued.signs.iter().map(|&a| format!("sign({})", pool.text(a))).collect();
    terms.extend(single_valued.unit_vectors.iter().map(|c| unit(c)));
    if !terms.is_empty() {
        notes.push(ExportNote::SetValued { terms });
    }
    for level in &system.static_levels {
        let term = if level.components.len() == 1 {
            format!("sign({})", list(&level.components))
        } else {
            unit(&level.components)
        };
        notes.push(ExportNote::StaticLevel { term });
    }
    if single_valued.kinks {
        notes.push(ExportNote::Kinks);
    }
    for delay in &system.input_delays {
        notes.push(ExportNote::InputDelay {
            input: system.symbol_name(delay.input).to_owned(),
            delay: pool.text(delay.delay),
            seconds: system.value(delay.delay),
        });
    }
    if !system.input_derivatives.is_empty() {
        let names = system.input_derivatives.iter().map(|d| system.symbol_name(d.symbol).to_owned()).collect();
        notes.push(ExportNote::InputDerivatives { names });
    }
    if system.outputs.is_empty() {
        notes.push(ExportNote::NoOutputs);
    }
    notes
}
