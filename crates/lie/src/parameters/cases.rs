//! For which values of the parameters a verdict differs from that for generic values.
//!
//! A verdict that rests on ranks differs only where a matrix of full rank for generic values loses rank, thus where all
//! its maximal minors vanish for all states. Minors at states of random value are polynomials in the parameters; their
//! common zeros hold all these values. The zeros are divided into sets on which one parameter is a rational function of
//! the others, the verdict is decided anew on each set, and the search goes on within it. So the list holds all cases
//! with up to the given number of simultaneous conditions, unless a step gave up, which is said.

use std::time::Instant;

use bracketry_symbolic::{Expr, Function, Pool, Rational, Symbol, closest_name};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::evidence::Evidence;
use crate::modes::mode_fields;
use crate::parameters::aspect::{Aspect, NotLinear, Subject, linear_at};
use crate::parameters::confirm::undefined_factors;
use crate::parameters::explore::Explorer;
use crate::parameters::report::{ParameterError, ParameterOptions, ParameterReport};

/// The parameters of these names, all for none.
fn selected(system: &System, names: &[String]) -> Result<Vec<Symbol>, ParameterError> {
    if system.parameters.is_empty() {
        return Err(ParameterError::NoParameters);
    }
    let known = |s: Symbol| system.pool.name(s);
    for name in names {
        if !system.parameters.iter().any(|p| known(p.symbol) == name) {
            let closest = closest_name(name, system.parameters.iter().map(|p| known(p.symbol)));
            let remedy = closest.map(|c| format!("; did you mean `{c}`?")).unwrap_or_default();
            return Err(ParameterError::Unknown { name: name.clone(), remedy });
        }
    }
    let chosen = |s: Symbol| names.is_empty() || names.iter().any(|n| n == known(s));
    Ok(system.parameters.iter().map(|p| p.symbol).filter(|&s| chosen(s)).collect())
}

/// The verdicts on accessibility, observability, relative degree, and linearization for generic values of parameters,
/// and the values for which they differ.
///
/// ```
/// use bracketry_lie::parameter_cases;
/// use bracketry_lie::parameters::ParameterOptions;
/// use bracketry_system::System;
/// let model = "states = ['x', 'y']\ninputs = ['u']\nparameters = { a = 1, b = 2 }\n\
///              dynamics = { x = 'u - a*x', y = 'u - b*y' }";
/// let tanks = System::parse("tanks", model).unwrap();
/// let report = parameter_cases(&tanks, &ParameterOptions::default()).unwrap();
/// let strong = &report.aspects[1];
/// let case = &strong.cases[0];
/// assert_eq!((case.conditions[0].text(), case.value.to_string()), ("a - b".to_owned(), "1".to_owned()));
/// assert!(strong.complete);
/// ```
///
/// # Errors
/// [`ParameterError`] for unknown names, and for equations that switch or are not affine in the inputs. What an exact test
/// cannot decide is said in the report.
pub fn parameter_cases(system: &System, options: &ParameterOptions) -> Result<ParameterReport, ParameterError> {
    let start = Instant::now();
    let symbols = selected(system, &options.parameters)?;
    let mut system = system.clone();
    if let Some(s) = system.switched_form().switches.first() {
        return Err(ParameterError::Switches { name: s.name.clone() });
    }
    let own = options.time_limit.and_then(|limit| start.checked_add(limit));
    system.pool.set_deadline(own.into_iter().chain(system.pool.deadline()).min());
    let (subject, no_linearization) = subject(&mut system, &symbols)?;
    let mut evidence = Evidence::default();
    let limits = system
        .parameters
        .iter()
        .filter(|p| symbols.contains(&p.symbol))
        .map(|p| (p.min.clone(), p.max.clone()))
        .collect();
    let mut explorer = Explorer::new(&mut system.pool, &symbols, limits, options.conditions);
    let undefined = undefined_factors(explorer.pool, &subject, &symbols);
    let mut aspects = Vec::new();
    for aspect in Aspect::ALL {
        let needed = match aspect {
            Aspect::Accessibility | Aspect::StrongAccessibility | Aspect::StaticLinearization => {
                !subject.fields.controls.is_empty()
            }
            Aspect::RelativeDegree => !subject.fields.controls.is_empty() && !subject.outputs.is_empty(),
            Aspect::Observability => !subject.outputs.is_empty(),
            Aspect::LinearControllability => subject.linear.is_some() && !subject.fields.controls.is_empty(),
            Aspect::LinearObservability => subject.linear.is_some() && !subject.outputs.is_empty(),
        };
        if needed {
            aspects.push(explorer.aspect(&subject, aspect, &mut evidence));
        }
    }
    let name = |s: Symbol| system.pool.name(s).to_owned();
    let fixed = system.parameters.iter().filter(|p| !symbols.contains(&p.symbol));
    Ok(ParameterReport {
        model: system.name.clone(),
        states: system.states.len(),
        parameters: symbols.iter().map(|&s| name(s)).collect(),
        fixed: fixed.map(|p| (name(p.symbol), p.value.to_string())).collect(),
        conditions: options.conditions,
        undefined: Function::list(&system.pool, &undefined),
        aspects,
        no_linearization,
        certificate: evidence,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// The smooth affine system with all other parameters at their values.
pub(crate) fn subject(system: &mut System, symbols: &[Symbol]) -> Result<(Subject, Option<NotLinear>), ParameterError> {
    let mut fields = mode_fields(system)?.remove(0).fields;
    let pool = &mut system.pool;
    let fixed: Vec<(Symbol, Rational)> = system
        .parameters
        .iter()
        .filter(|p| !symbols.contains(&p.symbol))
        .map(|p| (p.symbol, p.value.clone()))
        .collect();
    let values: FxHashMap<Expr, Expr> = fixed.into_iter().map(|(s, v)| (pool.sym(s), pool.rational(v))).collect();
    let put = |pool: &mut Pool, list: &[Expr]| pool.substitute_all(list, &values);
    fields.drift = put(pool, &fields.drift);
    fields.controls = fields.controls.iter().map(|g| put(pool, g)).collect();
    fields.bindings = bracketry_symbolic::Bindings::new();
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let outputs = put(pool, &outputs);
    let linear = match &system.point {
        // As `linearize` does.
        None => {
            let zero = pool.int(0);
            let (n, m) = (fields.states.len(), fields.controls.len());
            linear_at(pool, &fields, &outputs, &vec![zero; n], &vec![zero; m])
        }
        Some(point) => linear_at(pool, &fields, &outputs, &point.states, &point.inputs),
    };
    let reason = linear.as_ref().err().copied();
    Ok((Subject { fields, outputs, linear: linear.ok() }, reason))
}
