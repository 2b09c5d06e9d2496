//! The report on what the outputs tell: observability, identifiability, and the symmetries that prevent them.

use bracketry_symbolic::{Expr, Function, Named, Pool, Symbol, closest_name};
use bracketry_system::System;
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::algebra::field::{Field, VectorFields};
use crate::answer::Answer;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::modes::{mode_fields, parameter_bindings};
use crate::observability::codistribution::Observability;
use crate::observability::sensitivity::Asked;
use crate::observability::symmetry::{Operator, Symmetry};
use crate::options::AnalysisOptions;
use crate::reason::Reason;
use crate::undecided::Undecided;

/// A vector field along which no output changes, whatever the inputs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Direction {
    /// The field.
    pub field: Operator,
    /// What its flow does, if that has a name: a translation, a scaling or a rotation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub symmetry: Option<Symmetry>,
}

/// What the outputs determine.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ObservabilityReport {
    /// Generic rank of the observability codistribution, parameters known.
    pub rank: Answer<usize>,
    /// States whose value the outputs do not determine, parameters known.
    pub unobservable: Vec<String>,
    /// Independent fields on the states along which no output changes, parameters known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unobservable_directions: Vec<Direction>,
    /// For each parameter, whether the outputs determine it locally (up to finitely many values) while no other parameter
    /// and no state is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiable: Option<Named<bool>>,
    /// For each state, whether the outputs determine it locally while no parameter is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiable_states: Option<Named<bool>>,
    /// `identifiable` while all inputs are held at zero; absent without inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identifiable_without_inputs: Option<Named<bool>>,
    /// Rank for states and parameters together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank_with_parameters: Option<usize>,
    /// Independent fields on states and parameters along which no output changes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unidentifiable_directions: Vec<Direction>,
    /// A smallest set of parameters that, once known, makes all others identifiable; absent if all are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fix_to_identify: Option<Vec<String>>,
    /// Functions asked for, and whether the outputs determine them locally while no parameter is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub determined: Option<Named<bool>>,
    /// The functions asked for, in the order of `determined`.
    #[serde(skip)]
    pub determined_functions: Vec<Function>,
    /// Parameters of which it is not known whether the outputs determine them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undecided_parameters: Option<Undetermined>,
    /// Why `identifiable_without_inputs` is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undecided_without_inputs: Option<Reason>,
    /// Why fields along which no output changes are missing from `unobservable_directions` or `unidentifiable_directions`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undecided_directions: Option<Reason>,
    /// Why something is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Reason>,
}

impl ObservabilityReport {
    /// Whether it is known which states and parameters the outputs determine.
    pub fn decided(&self) -> bool {
        self.rank.known().is_some() && self.undecided_parameters.is_none()
    }
}

/// Parameters whose identifiability is unknown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// Their names.
    pub names: Vec<String>,
    /// Why.
    pub reason: Reason,
}

/// What the outputs of a system tell about its states and parameters, while the inputs are known
/// and vary freely. The system need not be affine in its inputs. `sign` is smoothed.
///
/// A system that is not affine is taken together with its inputs and their derivatives as known
/// functions of time: x' = f(x, u), u' = v with a free v.
///
/// `None` if there are no outputs.
///
/// # Errors
/// [`Error::Function`] for a function asked for that cannot be read; [`Error::NoStates`]. What
/// an exact test cannot decide becomes an unknown of the report instead.
pub fn observe(
    system: &System,
    options: &AnalysisOptions,
    evidence: &mut Evidence,
) -> Result<Option<ObservabilityReport>, Error> {
    let mut system = system.clone();
    let asked = read_functions(&mut system, &options.determined)?;
    if system.outputs.is_empty() {
        return Ok(None);
    }
    if !system.switched_form().switches.is_empty() {
        let width = system.pool.rational(options.epsilon.clone());
        system = system.smoothed(width);
    }
    let (fields, known) = match mode_fields(&mut system) {
        Ok(mut modes) if modes.len() == 1 => (modes.remove(0).fields, Vec::new()),
        Ok(_) | Err(Error::NotAffine { .. }) => with_inputs_as_states(&mut system)?,
        Err(other) => return Err(other),
    };
    Ok(Some(report(&mut system, &fields, &known, &asked, evidence)))
}

/// The functions of states and parameters with these texts; definitions and outputs may be used by name.
pub(crate) fn read_functions(system: &mut System, texts: &[String]) -> Result<Vec<(String, Expr)>, Error> {
    let mut named: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (name, e) in system.definitions.iter().chain(&system.outputs) {
        if !(system.states.iter().any(|&s| system.pool.name(s) == name)) {
            let symbol = system.pool.var(name);
            named.insert(symbol, *e);
        }
    }
    let mut list = Vec::with_capacity(texts.len());
    for text in texts {
        let fault = |problem: String| Error::Function { text: text.clone(), problem };
        let read = system.pool.parse(text).map_err(|e| fault(e.to_string()))?;
        let e = system.pool.substitute(read, &named);
        for s in system.pool.symbols_of(&[e]) {
            if system.states.contains(&s) || system.parameters.iter().any(|p| p.symbol == s) {
                continue;
            }
            let name = system.pool.name(s);
            let names = system.states.iter().copied().chain(system.parameters.iter().map(|p| p.symbol));
            let closest = closest_name(name, names.map(|s| system.pool.name(s)));
            let remedy = closest.map(|c| format!("; did you mean `{c}`?")).unwrap_or_default();
            return Err(fault(format!("`{name}` is neither a state nor a parameter{remedy}")));
        }
        list.push((text.trim().to_owned(), e));
    }
    Ok(list)
}

/// The system extended by its inputs and their derivatives as states, the highest of which vary freely.
pub(crate) fn with_inputs_as_states(system: &mut System) -> Result<(VectorFields, Vec<Symbol>), Error> {
    let mut states = system.states.clone();
    let mut drift = system.dynamics.clone();
    let mut known = Vec::new();
    let mut free = Vec::new();
    for (i, &u) in system.inputs.iter().enumerate() {
        let mut jet = vec![u];
        let orders = system.input_derivatives.iter().filter(|d| d.input == i);
        for order in 1..=orders.clone().map(|d| d.order).max().unwrap_or(0) {
            let present = orders.clone().find(|d| d.order == order).map(|d| d.symbol);
            let name = format!("der({}, {order})", system.pool.name(u));
            jet.push(present.unwrap_or_else(|| system.pool.symbol(&name)));
        }
        for next in &jet[1..] {
            drift.push(system.pool.sym(*next));
        }
        drift.push(system.pool.int(0));
        known.extend(&jet);
        states.extend(jet);
        free.push(states.len() - 1);
    }
    let (zero, one) = (system.pool.int(0), system.pool.int(1));
    let controls: Vec<Field> =
        free.iter().map(|&k| (0..states.len()).map(|j| if j == k { one } else { zero }).collect()).collect();
    let bindings = parameter_bindings(system);
    Ok((VectorFields::new(states, drift, controls, bindings)?, known))
}

/// `fields` are those of `system`, of which the states `known` are known functions of time.
pub(crate) fn report(
    system: &mut System,
    fields: &VectorFields,
    known: &[Symbol],
    asked: &[(String, Expr)],
    evidence: &mut Evidence,
) -> ObservabilityReport {
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let parameters: Vec<Symbol> = system.parameters.iter().map(|p| p.symbol).collect();
    let mut report = ObservabilityReport::default();
    let pool = &mut system.pool;
    let functions: Vec<Expr> = asked.iter().map(|a| a.1).collect();
    let question = Asked { fields, outputs: &outputs, unknown: &[], known, functions: &[] };
    let found = report.states(pool, &question, evidence);
    if let Err(why) =
        found.or_else(|why| report.states_by_series(pool, &question, evidence).map_err(|last| later(why, last)))
    {
        report.rank = Answer::Unknown(why.clone().into());
        report.reason = Some(why.into());
    }
    let question = Asked { unknown: &parameters, functions: &functions, ..question };
    if !parameters.is_empty() || !asked.is_empty() {
        let found = report.parameters(pool, &question, asked, evidence).or_else(|why| {
            report.parameters_by_series(pool, &question, asked, evidence).map_err(|last| later(why, last))
        });
        if let Err(why) = found {
            let names = parameters.iter().map(|&s| pool.name(s).to_owned());
            report.undecided_parameters = Some(Undetermined { names: names.collect(), reason: why.clone().into() });
            report.reason.get_or_insert(why.into());
        }
    }
    let driven = !fields.controls.is_empty() || !known.is_empty();
    if driven && !parameters.is_empty() {
        match without_inputs(pool, &question, evidence) {
            Ok(answers) => report.identifiable_without_inputs = Some(answers),
            Err(why) => report.undecided_without_inputs = Some(why.into()),
        }
    }
    report
}

/// The reason of the second method where the first one took too much, else that of the first.
fn later(first: Undecided, second: Undecided) -> Undecided {
    match first {
        Undecided::TooLarge { .. } | Undecided::TooMany { .. } => second,
        Undecided::Exact(_) | Undecided::TooManyStates { .. } => first,
    }
}

impl ObservabilityReport {
    /// What is known of the states while the parameters are, by Lie derivatives of the outputs.
    fn states(&mut self, pool: &mut Pool, asked: &Asked<'_>, evidence: &mut Evidence) -> Result<(), Undecided> {
        let o = asked.fields.observability_given(pool, asked.outputs, &[], asked.known, evidence)?;
        let yes = o.determined_variables(pool, evidence)?;
        self.rank = Answer::Known(o.rank());
        self.unobservable =
            o.variables.iter().zip(&yes).filter(|v| !v.1).map(|(&s, _)| pool.name(s).to_owned()).collect();
        let fields = o.unobservable_directions(pool, evidence);
        self.unobservable_directions = self.directions(pool, &o.variables, fields);
        Ok(())
    }

    /// The same by power series.
    fn states_by_series(
        &mut self,
        pool: &mut Pool,
        asked: &Asked<'_>,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let found = asked.sensitivity(pool, evidence)?;
        self.rank = Answer::Known(found.rank);
        let open = found.variables.iter().zip(&found.determined).filter(|v| !v.1);
        self.unobservable = open.map(|(&s, _)| pool.name(s).to_owned()).collect();
        self.unobservable_directions = self.directions(pool, &found.variables, found.directions);
        Ok(())
    }

    /// What is known of states and parameters together, by Lie derivatives of the outputs.
    fn parameters(
        &mut self,
        pool: &mut Pool,
        question: &Asked<'_>,
        asked: &[(String, Expr)],
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let parameters = question.unknown;
        let o = question.fields.observability_given(pool, question.outputs, parameters, question.known, evidence)?;
        let mut states = named_answers(pool, &o, evidence)?;
        let identifiable = states.split_off(states.len() - parameters.len());
        let mut answers = Vec::with_capacity(asked.len());
        for (text, e) in asked {
            answers.push((text.clone(), o.determines(pool, *e, evidence)?));
        }
        self.determined = (!answers.is_empty()).then_some(Named(answers));
        self.determined_functions = asked.iter().map(|&(_, e)| Function::new(pool, e)).collect();
        if parameters.is_empty() {
            return Ok(());
        }
        self.rank_with_parameters = Some(o.rank());
        if identifiable.iter().any(|p| !p.1) {
            let fix = o.fix_to_determine(pool, parameters, evidence)?;
            self.fix_to_identify = fix.map(|list| list.iter().map(|&s| pool.name(s).to_owned()).collect());
        }
        self.identifiable = Some(Named(identifiable));
        self.identifiable_states = Some(Named(states));
        let fields = o.unobservable_directions(pool, evidence);
        self.unidentifiable_directions = self.directions(pool, &o.variables, fields);
        Ok(())
    }

    /// The same by power series.
    fn parameters_by_series(
        &mut self,
        pool: &mut Pool,
        question: &Asked<'_>,
        asked: &[(String, Expr)],
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        let found = question.sensitivity(pool, evidence)?;
        let texts = asked.iter().map(|a| a.0.clone());
        let answers: Vec<(String, bool)> = texts.zip(found.functions.iter().copied()).collect();
        self.determined = (!answers.is_empty()).then_some(Named(answers));
        self.determined_functions = asked.iter().map(|&(_, e)| Function::new(pool, e)).collect();
        if question.unknown.is_empty() {
            return Ok(());
        }
        let name = |s: &Symbol| pool.name(*s).to_owned();
        let mut states: Vec<(String, bool)> =
            found.variables.iter().map(name).zip(found.determined.iter().copied()).collect();
        let identifiable = states.split_off(states.len() - question.unknown.len());
        self.rank_with_parameters = Some(found.rank);
        self.fix_to_identify = identifiable.iter().any(|p| !p.1).then(|| found.fix.iter().map(name).collect());
        self.identifiable = Some(Named(identifiable));
        self.identifiable_states = Some(Named(states));
        self.unidentifiable_directions = self.directions(pool, &found.variables, found.directions);
        Ok(())
    }

    /// The fields with what their flows do; where they are not known, why.
    fn directions(
        &mut self,
        pool: &mut Pool,
        variables: &[Symbol],
        fields: Result<Vec<Field>, Undecided>,
    ) -> Vec<Direction> {
        match fields {
            Ok(fields) => fields
                .iter()
                .map(|field| Direction {
                    field: Operator::new(pool, variables, field),
                    symmetry: Symmetry::of(pool, variables, field),
                })
                .collect(),
            Err(why) => {
                self.undecided_directions.get_or_insert(why.into());
                Vec::new()
            }
        }
    }
}

/// The identifiability of the parameters with all inputs at zero.
fn without_inputs(pool: &mut Pool, asked: &Asked<'_>, evidence: &mut Evidence) -> Result<Named<bool>, Undecided> {
    let (fields, known) = (asked.fields, asked.known);
    let zero = pool.int(0);
    let rest: FxHashMap<Expr, Expr> = known.iter().map(|&u| (pool.sym(u), zero)).collect();
    let kept: Vec<usize> = (0..fields.states.len()).filter(|&i| !known.contains(&fields.states[i])).collect();
    let drift: Field = kept.iter().map(|&i| fields.drift[i]).collect();
    let still = VectorFields {
        states: kept.iter().map(|&i| fields.states[i]).collect(),
        drift: pool.substitute_all(&drift, &rest),
        controls: Vec::new(),
        bindings: fields.bindings.clone(),
    };
    let outputs = pool.substitute_all(asked.outputs, &rest);
    let question = Asked { fields: &still, outputs: &outputs, unknown: asked.unknown, known: &[], functions: &[] };
    let by_brackets = still.observability(pool, &outputs, asked.unknown, evidence);
    let mut answers = match by_brackets.and_then(|o| named_answers(pool, &o, evidence)) {
        Ok(answers) => answers,
        Err(why) => {
            let found = question.sensitivity(pool, evidence).map_err(|last| later(why, last))?;
            let names = found.variables.iter().map(|&s| pool.name(s).to_owned());
            names.zip(found.determined).collect()
        }
    };
    Ok(Named(answers.split_off(still.states.len())))
}

fn named_answers(
    pool: &mut Pool,
    o: &Observability,
    evidence: &mut Evidence,
) -> Result<Vec<(String, bool)>, Undecided> {
    let yes = o.determined_variables(pool, evidence)?;
    Ok(o.variables.iter().map(|&s| pool.name(s).to_owned()).zip(yes).collect())
}
