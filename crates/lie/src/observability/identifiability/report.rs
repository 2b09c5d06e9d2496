//! The report on identifiability.

use std::time::{Duration, Instant};

use bracketry_symbolic::{Bindings, Expr, Function, Pool, Rational, Residue, Symbol, closest_name};
use bracketry_system::System;
use serde::Serialize;

use crate::algebra::field::VectorFields;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::modes::mode_fields;
use crate::observability::identifiability::combinations::combinations;
use crate::observability::identifiability::global::GlobalReason;
use crate::observability::identifiability::local_identifiability::{Question, SEED};
use crate::observability::report::with_inputs_as_states;
use crate::observability::series::{SeriesProgram, UnknownInputs};
use crate::options::TIME_LIMIT;
use crate::reason::Reason;
use crate::undecided::Undecided;

/// What is asked of [`identifiability`].
#[derive(Clone, Debug)]
pub struct IdentifiabilityOptions {
    /// States whose initial value is known: `x` for a known value, `x=0` for a number.
    pub known_initial: Vec<String>,
    /// Inputs that are unknown functions of time.
    pub unknown_inputs: Vec<String>,
    /// Whether the number of values is asked for, too.
    pub global: bool,
    /// Wall-clock time after which what is undecided is unknown.
    pub time_limit: Option<Duration>,
}

impl Default for IdentifiabilityOptions {
    fn default() -> Self {
        IdentifiabilityOptions {
            known_initial: Vec::new(),
            unknown_inputs: Vec::new(),
            global: true,
            time_limit: Some(TIME_LIMIT),
        }
    }
}

/// The verdict on a parameter or an initial state, for generic values of all of them and generic known inputs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identifiability {
    /// Its name.
    pub name: String,
    /// Whether finitely many values at most give the same outputs; none where that is not known.
    pub local: Option<bool>,
    /// Whether one value only does, of all complex ones; none where that is not known.
    pub global: Option<bool>,
    /// How many complex values give the same outputs, where there are finitely many and their number is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<usize>,
}

/// Identifiability of parameters and initial states.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IdentifiabilityReport {
    /// Name of the model.
    pub model: String,
    /// States whose initial value is known, with the number if it is one.
    pub known_initial: Vec<(String, Option<String>)>,
    /// Inputs that are unknown functions of time.
    pub unknown_inputs: Vec<String>,
    /// By parameter.
    pub parameters: Vec<Identifiability>,
    /// By state, of its initial value; those that are known are left out.
    pub states: Vec<Identifiability>,
    /// Independent functions of the parameters that are identifiable locally, of parameters that are not.
    pub combinations: Vec<Function>,
    /// How many more there may be; none where that is not known.
    pub combinations_missing: Option<usize>,
    /// Where two sets of values in all give the same outputs: what the second has in place of each name that changes.
    pub other_solution: Vec<(String, Function)>,
    /// Why local identifiability is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Reason>,
    /// Why the number of values is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub global_reason: Option<GlobalReason>,
    /// What the local answers rest on.
    pub certificate: Evidence,
    /// Seconds that it took.
    #[serde(skip)]
    pub seconds: f64,
}

impl IdentifiabilityReport {
    /// Whether local and, where asked for, global identifiability of all parameters is known.
    pub fn decided(&self, global: bool) -> bool {
        self.parameters.iter().all(|p| p.local.is_some() && (!global || p.global.is_some()))
    }
}

/// Why there is no answer at all.
#[derive(Debug, thiserror::Error)]
pub enum IdentifiabilityError {
    /// No outputs.
    #[error("the model has no outputs that could identify anything: add a table [outputs]")]
    NoOutputs,
    /// No parameters and no states.
    #[error("the model has no {kind} `{name}`{remedy}")]
    Unknown {
        /// The name.
        name: String,
        /// State or input.
        kind: &'static str,
        /// What may have been meant.
        remedy: String,
    },
    /// A value that is no number.
    #[error("`{text}`: write a state, or a state with a number, such as x or x=0")]
    Initial {
        /// The text.
        text: String,
    },
    /// Equations that switch.
    #[error("the equations switch where {name} = 0: identifiability by power series needs smooth equations")]
    Switches {
        /// A switching function.
        name: String,
    },
    /// No states.
    #[error(transparent)]
    Lie(#[from] Error),
}

/// Whether parameters and initial states are identifiable locally and globally from the outputs, the structure of the
/// model being right and data perfect, and which combinations of parameters are.
///
/// ```
/// use bracketry_lie::identifiability;
/// use bracketry_lie::observability::IdentifiabilityOptions;
/// use bracketry_system::System;
/// // Slow and fast reaction: the rates may be exchanged (Vajda and Rabitz 1988).
/// let model = "states = ['a', 'b']\nparameters = { k1 = 1, k2 = 2 }\n\
///              dynamics = { a = '-k1*a', b = 'k1*a - k2*b' }\noutputs = { y = 'b' }";
/// let report = identifiability(&System::parse("chain", model).unwrap(), &IdentifiabilityOptions::default()).unwrap();
/// assert_eq!((report.parameters[0].local, report.parameters[0].values), (Some(true), Some(2)));
/// assert_eq!(report.other_solution[0].1.text(), "k2");
/// ```
///
/// # Errors
/// [`IdentifiabilityError`] for unknown names and models without outputs. What is not decided is said in the report.
pub fn identifiability(
    system: &System,
    options: &IdentifiabilityOptions,
) -> Result<IdentifiabilityReport, IdentifiabilityError> {
    let start = Instant::now();
    let mut system = system.clone();
    if system.outputs.is_empty() {
        return Err(IdentifiabilityError::NoOutputs);
    }
    if let Some(s) = system.switched_form().switches.first() {
        return Err(IdentifiabilityError::Switches { name: s.name.clone() });
    }
    let known = known_values(&system, &options.known_initial)?;
    for name in &options.unknown_inputs {
        find(&system, &system.inputs, name, "input")?;
    }
    let own = options.time_limit.and_then(|limit| start.checked_add(limit));
    system.pool.set_deadline(own.into_iter().chain(system.pool.deadline()).min());
    let mut report = IdentifiabilityReport {
        model: system.name.clone(),
        known_initial: known
            .iter()
            .map(|(s, v)| (system.symbol_name(*s).to_owned(), v.as_ref().map(ToString::to_string)))
            .collect(),
        unknown_inputs: options.unknown_inputs.clone(),
        parameters: Vec::new(),
        states: Vec::new(),
        combinations: Vec::new(),
        combinations_missing: None,
        other_solution: Vec::new(),
        reason: None,
        global_reason: None,
        certificate: Evidence::default(),
        seconds: 0.0,
    };
    let (fields, driven) = fields_of(&mut system, &options.unknown_inputs)?;
    let asked = Asked { fields: &fields, driven: &driven, known: &known, options };
    match asked.question(&mut system, &[]) {
        Ok(question) => asked.answer(&mut system, &question, &mut report),
        Err(why) => report.unknown(&system, why),
    }
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

fn find(system: &System, list: &[Symbol], name: &str, kind: &'static str) -> Result<Symbol, IdentifiabilityError> {
    list.iter().copied().find(|&s| system.symbol_name(s) == name).ok_or_else(|| {
        let closest = closest_name(name, list.iter().map(|&s| system.symbol_name(s)));
        let remedy = closest.map(|c| format!("; did you mean `{c}`?")).unwrap_or_default();
        IdentifiabilityError::Unknown { name: name.to_owned(), kind, remedy }
    })
}

/// States with the initial values that are numbers.
type Known = Vec<(Symbol, Option<Rational>)>;

fn known_values(system: &System, texts: &[String]) -> Result<Known, IdentifiabilityError> {
    let mut list = Known::new();
    for text in texts {
        let (name, value) = match text.split_once('=') {
            None => (text.trim(), None),
            Some((name, value)) => {
                let mut pool = Pool::new();
                let number = pool.parse(value.trim()).ok().and_then(|e| {
                    let e = pool.simplify(e);
                    pool.number(e).cloned()
                });
                let number = number.ok_or_else(|| IdentifiabilityError::Initial { text: text.clone() })?;
                (name.trim(), Some(number))
            }
        };
        list.push((find(system, &system.states, name, "state")?, value));
    }
    Ok(list)
}

/// The states that known inputs add, and the controls that unknown ones multiply.
struct Driven {
    known: Vec<Symbol>,
    unknown: Vec<usize>,
}

/// Fields for a model that may not be affine: then inputs are states, of which unknown ones are not known.
fn fields_of(system: &mut System, unknown: &[String]) -> Result<(VectorFields, Driven), IdentifiabilityError> {
    let numbers: Vec<usize> = unknown.iter().filter_map(|name| system.input_index(name)).collect();
    match mode_fields(system) {
        Ok(mut modes) => Ok((modes.remove(0).fields, Driven { known: Vec::new(), unknown: numbers })),
        Err(Error::NotAffine { .. }) => {
            let symbols: Vec<Symbol> = numbers.iter().map(|&i| system.inputs[i]).collect();
            let (fields, mut known) = with_inputs_as_states(system)?;
            // Derivatives of an unknown input are unknown as well.
            let derivatives = system.input_derivatives.iter().filter(|d| numbers.contains(&d.input)).map(|d| d.symbol);
            let hidden: Vec<Symbol> = symbols.into_iter().chain(derivatives).collect();
            known.retain(|s| !hidden.contains(s));
            Ok((fields, Driven { known, unknown: numbers }))
        }
        Err(other) => Err(other.into()),
    }
}

struct Asked<'a> {
    fields: &'a VectorFields,
    driven: &'a Driven,
    known: &'a Known,
    options: &'a IdentifiabilityOptions,
}

impl Asked<'_> {
    /// The question, compiled, with further functions of the parameters.
    fn question(&self, system: &mut System, functions: &[Expr]) -> Result<Question, Undecided> {
        let states: Vec<Symbol> =
            self.fields.states.iter().copied().filter(|s| !self.driven.known.contains(s)).collect();
        let parameters = system.parameters.iter().map(|p| p.symbol);
        let variables: Vec<Symbol> = states.iter().copied().chain(parameters).collect();
        let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
        let unknown = UnknownInputs { controls: self.driven.unknown.clone(), orders: variables.len() + 4 };
        let pool = &mut system.pool;
        let program =
            SeriesProgram::compile_with_unknown(pool, self.fields, &outputs, functions, &variables, &unknown)?;
        let mut special = Bindings::new();
        for (s, value) in self.known {
            if let Some(value) = value {
                special.bind(*s, value.clone());
            }
        }
        Ok(Question {
            program,
            known: self.known.iter().filter_map(|(s, _)| states.iter().position(|t| t == s)).collect(),
            states: states.len(),
            variables,
            special,
            is_special: self.known.iter().any(|k| k.1.is_some()),
            unknown_inputs: !self.driven.unknown.is_empty(),
        })
    }

    fn answer(&self, system: &mut System, question: &Question, report: &mut IdentifiabilityReport) {
        let local = match question.local(&mut system.pool, &mut report.certificate) {
            Ok(local) => local,
            Err(why) => return report.unknown(system, why),
        };
        let mut verdicts: Vec<Identifiability> = question
            .variables
            .iter()
            .zip(&local.determined)
            .map(|(&s, &yes)| {
                let local = if yes || local.closed { Some(yes) } else { None };
                let global = local.filter(|yes| !yes);
                Identifiability { name: system.symbol_name(s).to_owned(), local, global, values: None }
            })
            .collect();
        if self.options.global {
            count(system, question, &local.determined, &mut verdicts, report);
        }
        report.parameters = verdicts.split_off(question.states);
        let shown = |i: usize| !question.known.contains(&i) && system.states.contains(&question.variables[i]);
        report.states = verdicts.into_iter().enumerate().filter(|(i, _)| shown(*i)).map(|x| x.1).collect();
        if local.closed {
            self.combine(system, question, &local.determined[question.states..], report);
        }
    }

    fn combine(
        &self,
        system: &mut System,
        question: &Question,
        determined: &[bool],
        report: &mut IdentifiabilityReport,
    ) {
        let Ok(found) = combinations(&mut system.pool, question, determined) else { return };
        // Each is decided as a function that is asked for.
        let Ok(again) = self.question(system, &found.found) else { return };
        let Ok(local) = again.local(&mut system.pool, &mut report.certificate) else { return };
        let kept: Vec<Expr> = found.found.iter().zip(&local.functions).filter(|x| *x.1).map(|x| *x.0).collect();
        report.combinations_missing = Some(found.missing + found.found.len() - kept.len());
        report.combinations = Function::list(&system.pool, &kept);
    }
}

/// Numbers of values.
fn count(
    system: &mut System,
    question: &Question,
    determined: &[bool],
    verdicts: &mut [Identifiability],
    report: &mut IdentifiabilityReport,
) {
    if !determined.contains(&true) {
        return;
    }
    let counts = match question.counts(&mut system.pool) {
        Ok(counts) => counts,
        Err(why) => {
            report.global_reason = Some(why);
            return;
        }
    };
    let few = question.is_special || question.unknown_inputs;
    for ((v, count), _) in verdicts.iter_mut().zip(&counts).zip(determined).filter(|x| *x.1) {
        match count {
            Some(1) | None => (v.global, v.values) = (Some(true), Some(1)),
            Some(_) if few => report.global_reason = Some(GlobalReason::MoreDerivatives),
            Some(k) => (v.global, v.values) = (Some(false), Some(*k)),
        }
    }
    if !few && counts.iter().any(|c| c.is_some_and(|c| c == 2)) {
        report.other_solution = other_solution(&mut system.pool, question, determined).unwrap_or_default();
    }
}

impl IdentifiabilityReport {
    fn unknown(&mut self, system: &System, why: Undecided) {
        let open = |s: Symbol| Identifiability {
            name: system.symbol_name(s).to_owned(),
            local: None,
            global: None,
            values: None,
        };
        self.parameters = system.parameters.iter().map(|p| open(p.symbol)).collect();
        self.states = system.states.iter().map(|&s| open(s)).collect();
        self.reason = Some(why.into());
    }
}

/// What the second of two solutions has in place of each variable that changes, as a simple function of the first; it
/// holds at points modulo two primes. `None` if no such functions are found.
fn other_solution(pool: &mut Pool, question: &Question, determined: &[bool]) -> Option<Vec<(String, Function)>> {
    use bracketry_symbolic::SECOND_OFFSET;
    let a = question.solutions::<1>(pool, SEED ^ 5).ok()?.pair?;
    let b = question.solutions::<SECOND_OFFSET>(pool, SEED ^ 6).ok()?.pair?;
    let mut list = Vec::new();
    for i in (0..question.variables.len()).filter(|&i| determined[i] && a.0[i] != a.1[i]) {
        let candidate = simple_functions(question.variables.len())
            .find(|c| c.value(&a.0) == Some(a.1[i]) && c.value(&b.0) == Some(b.1[i]));
        let Some(candidate) = candidate else {
            // Initial states may change in longer ways.
            if i < question.states {
                continue;
            }
            return None;
        };
        let e = candidate.expression(pool, &question.variables);
        list.push((pool.name(question.variables[i]).to_owned(), Function::new(pool, e)));
    }
    // Parameters first.
    let states: Vec<String> = question.variables[..question.states].iter().map(|&s| pool.name(s).to_owned()).collect();
    list.sort_by_key(|(name, _)| states.contains(name));
    Some(list)
}

/// (±a ± b) or a b / c of variables by their numbers.
#[derive(Clone, Copy)]
enum Simple {
    Sum(i64, usize, i64, usize),
    Quotient(usize, usize, usize),
}

fn simple_functions(n: usize) -> impl Iterator<Item = Simple> {
    let single = (0..n).flat_map(|i| [Simple::Sum(1, i, 0, i), Simple::Sum(-1, i, 0, i)]);
    let sums = (0..n).flat_map(move |i| {
        (0..n).filter(move |&j| j != i).flat_map(move |j| [Simple::Sum(1, i, 1, j), Simple::Sum(1, i, -1, j)])
    });
    let quotients = (0..n).flat_map(move |i| {
        (i..n).flat_map(move |j| (0..n).filter(move |&k| k != i && k != j).map(move |k| Simple::Quotient(i, j, k)))
    });
    single.chain(sums).chain(quotients)
}

impl Simple {
    fn value<const C: u64>(self, v: &[Residue<C>]) -> Option<Residue<C>> {
        match self {
            Simple::Sum(s, i, t, j) => Some(Residue::from_i64(s) * v[i] + Residue::from_i64(t) * v[j]),
            Simple::Quotient(i, j, k) => Some(v[i] * v[j] * v[k].inv()?),
        }
    }

    fn expression(self, pool: &mut Pool, variables: &[Symbol]) -> Expr {
        match self {
            Simple::Sum(s, i, t, j) => {
                let (x, y) = (pool.sym(variables[i]), pool.sym(variables[j]));
                let (s, t) = (pool.int(s), pool.int(t));
                let (a, b) = (pool.mul(s, x), pool.mul(t, y));
                pool.add(a, b)
            }
            Simple::Quotient(i, j, k) => {
                let [x, y, z] = [i, j, k].map(|i| pool.sym(variables[i]));
                let top = pool.mul(x, y);
                pool.div(top, z)
            }
        }
    }
}
