//! From a model to what its inputs reach: affine form and Lie-algebraic report in one result.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::time::Instant;

use bracketry_lie::{Answer, Dimensions, InputValues, Options, Report, Side, Stlc, Verdict};
use bracketry_symbolic::Rational;
use bracketry_system::{
    AffineError, Affinization, AtPoint, InputRange, Method, NewInput, Range, System, ZeroDenominator,
};
use serde::Serialize;

use crate::affinization::AffinizationReport;

/// An analysis that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// No affine form was found.
    #[error(transparent)]
    Affine(#[from] AffineError),
    /// The brackets could not be formed.
    #[error(transparent)]
    Lie(#[from] bracketry_lie::Error),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
    /// It is asked what the outputs determine of a model without outputs.
    #[error("there are no outputs that could determine `{function}`: add a table [outputs]")]
    NoOutputs {
        /// The function that was asked for.
        function: String,
    },
}

/// What the inputs of a model reach.
#[derive(Clone, Debug, Serialize)]
pub struct Analysis {
    /// Name of the model.
    pub model: String,
    /// Number of states of the affine model.
    pub states: usize,
    /// Number of inputs of the affine model.
    pub inputs: usize,
    /// Whether the model was affine as it stood.
    pub affine: bool,
    /// Delays of the model's inputs in seconds, where there are any; the rest is about the inputs as they arrive.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub input_delays: BTreeMap<String, f64>,
    /// How it became affine.
    pub affinization: AffinizationReport,
    /// Ranks, growth vectors and verdicts of the affine model.
    #[serde(flatten)]
    pub report: Report,
    /// What the ranks mean, in plain language.
    pub summary: String,
    /// The model as it was given.
    #[serde(skip)]
    pub original: System,
}

/// Makes a model affine in its inputs and analyses it.
///
/// ```
/// use bracketry::system::System;
/// let model = "states = ['x', 'y', 'th']\ninputs = ['u1', 'u2']\n\
///              dynamics = { x = 'u1*cos(th)', y = 'u1*sin(th)', th = 'u2' }";
/// let unicycle = System::parse("unicycle", model).unwrap();
/// let analysis = bracketry::analyze(&unicycle, &Default::default()).unwrap();
/// assert_eq!(analysis.report.modes[0].dimensions.growth, [2, 3]);
/// ```
///
/// # Errors
/// [`AnalysisError`] if no affine form is found or there are too many modes; what an exact test
/// cannot decide becomes an unknown of the report instead.
pub fn analyze(system: &System, options: &Options) -> Result<Analysis, AnalysisError> {
    let begin = Instant::now();
    if let (Some(function), true) = (options.determined.first(), system.outputs.is_empty()) {
        return Err(AnalysisError::NoOutputs { function: function.clone() });
    }
    system.check_denominators()?;
    let affinization = system.affinize()?;
    let mut options = options.clone();
    if affinization.method == Method::None {
        options.ranges.extend(declared(system));
        options.one_sided.extend(at_an_end(system));
    } else {
        options.one_sided.extend(one_sided(&affinization));
        options.ranges.extend(ranges(&affinization, system));
    }
    let options = &options;
    let mut report = bracketry_lie::analyse(&affinization.system, options)?;
    if affinization.method != Method::None {
        // Old inputs are known, though integrators make them states and new inputs may hold parameters.
        report.observability = bracketry_lie::observe(system, options, &mut report.certificate)?;
    }
    withhold_local_verdicts(&mut report, &affinization, system);
    let affine = &affinization.system;
    let mut analysis = Analysis {
        model: system.name.clone(),
        states: affine.states.len(),
        inputs: affine.inputs.len(),
        affine: affinization.method == Method::None,
        input_delays: delays(system),
        affinization: (&affinization).into(),
        summary: String::new(),
        original: system.clone(),
        report,
    };
    if !analysis.affine {
        let family = bracketry_lie::family_dimensions(system, affine, &analysis.report)?;
        analysis.affinization.family = Some(family);
    }
    analysis.report.seconds = begin.elapsed().as_secs_f64();
    analysis.summary = analysis.plain_language();
    if let Some(delays) = analysis.about_delays() {
        let _ = write!(analysis.summary, " {delays}");
    }
    Ok(analysis)
}

/// The inputs that act later than they are commanded, with their delays in seconds.
fn delays(system: &System) -> BTreeMap<String, f64> {
    let values = system.delay_values();
    let named = system.input_names().into_iter().zip(values);
    named.filter_map(|(name, delay)| Some((name, delay.filter(|d| *d > 0.0)?))).collect()
}

/// New inputs that can move from their value at the point to one side only, as u² can at u = 0.
fn one_sided(affinization: &Affinization) -> Vec<(String, Side)> {
    let side = |v: &NewInput| match v.at_point {
        AtPoint::AtLower => Some(Side::Above),
        AtPoint::AtUpper => Some(Side::Below),
        AtPoint::Interior | AtPoint::Unknown => None,
    };
    affinization.input_change.iter().filter_map(|v| Some((v.name.clone(), side(v)?))).collect()
}

/// The ranges of a model's inputs.
fn declared(system: &System) -> Vec<(String, InputValues)> {
    let end = |e: &Option<Rational>, open: f64| e.as_ref().map_or(open, |e| e.to_f64().value());
    let ranges = system.input_ranges.iter();
    let values = |r: &InputRange| InputValues::Between(end(&r.min, f64::NEG_INFINITY), end(&r.max, f64::INFINITY));
    ranges.map(|r| (system.symbol_name(r.input).to_owned(), values(r))).collect()
}

/// Inputs whose value at the point is an end of their range.
fn at_an_end(system: &System) -> Vec<(String, Side)> {
    let Some((_, inputs)) = system.point_values() else { return Vec::new() };
    let side = |r: &InputRange| {
        let value = *inputs.get(system.inputs.iter().position(|u| *u == r.input)?)?;
        let is = |e: &Option<Rational>| e.as_ref().is_some_and(|e| e.to_f64().value() == value);
        match (is(&r.min), is(&r.max)) {
            (true, _) => Some(Side::Above),
            (_, true) => Some(Side::Below),
            _ => None,
        }
    };
    let ranges = system.input_ranges.iter();
    ranges.filter_map(|r| Some((system.symbol_name(r.input).to_owned(), side(r)?))).collect()
}

/// The values of new inputs that do not take all real numbers.
fn ranges(affinization: &Affinization, original: &System) -> Vec<(String, InputValues)> {
    if !original.input_ranges.is_empty() {
        return affinization.input_change.iter().map(|v| (v.name.clone(), InputValues::Unknown)).collect();
    }
    let values = |v: &NewInput| match &v.values {
        Range::Onto => None,
        Range::Interval { lower, upper } => {
            let lower = lower.as_ref().map_or(f64::NEG_INFINITY, |b| b.value);
            Some(InputValues::Between(lower, upper.as_ref().map_or(f64::INFINITY, |b| b.value)))
        }
        Range::Unknown { .. } => Some(InputValues::Unknown),
    };
    affinization.input_change.iter().filter_map(|v| Some((v.name.clone(), values(v)?))).collect()
}

/// Whether a positive verdict on the affine system, in which each new input takes the values of its range by itself,
/// holds for the original: the values that the new inputs take together must contain what it was concluded from.
struct CarriesOver {
    /// From small feedback of the new inputs: together they take all values near those at the point.
    feedback: bool,
    /// From new inputs in their ranges.
    in_ranges: bool,
}

impl CarriesOver {
    fn of(affinization: &Affinization, equilibrium: bool) -> CarriesOver {
        let new = &affinization.input_change;
        // Where the point is no equilibrium, other values than that at the point hold it.
        let free = new.is_empty() || affinization.interior_at_point == Some(true) && equilibrium;
        let chosen = affinization.candidates.iter().find(|c| c.chosen);
        let independent = new.len() == 1 || chosen.and_then(|c| c.independent_ranges) == Some(true);
        // At one end of a range the other end is taken to be far away.
        let seen = |v: &NewInput| match (v.at_point, &v.values) {
            (AtPoint::Interior, _) => true,
            (AtPoint::AtLower, Range::Interval { upper, .. }) => upper.is_none(),
            (AtPoint::AtUpper, Range::Interval { lower, .. }) => lower.is_none(),
            _ => false,
        };
        // Small feedback needs the values themselves, not mixtures of them over short times.
        let feedback = new.is_empty() || affinization.covers_at_point == Some(true) && equilibrium;
        CarriesOver { feedback, in_ranges: free || independent && new.iter().all(seen) }
    }
}

/// Where the new inputs do not cover what a positive conclusion was drawn from, as u² at u = 0, it is open; what is
/// negative even with more inputs stays.
fn withhold_local_verdicts(report: &mut Report, affinization: &Affinization, original: &System) {
    let Some(Answer::Known(point)) = &mut report.at_point else { return };
    let holds = CarriesOver::of(affinization, point.equilibrium == Answer::Known(true));
    let names: Vec<String> = affinization
        .input_change
        .iter()
        .map(|v| format!("{} = {}", v.name, affinization.system.pool.text(v.function)))
        .collect();
    let why = format!("at the point the old inputs do not move {} freely to all sides", names.join(", "));
    let ends = at_an_end(original);
    let (why, in_ranges, feedback) = match ends.first() {
        // One-sided inputs are known to the verdict on the model itself, not to one on an affine form of it.
        Some((name, _)) => {
            let why = format!("{name} is at an end of its range at the point");
            (why, affinization.method == Method::None, false)
        }
        None => (why, holds.in_ranges, holds.feedback),
    };
    if point.stlc.verdict == Verdict::Yes && !in_ranges {
        point.stlc = Stlc::inconclusive(why.clone());
    }
    if feedback {
        return;
    }
    if let Some(stabilizable @ Answer::Known(true)) = &mut point.stabilizable {
        *stabilizable = Answer::Unknown(why.clone());
        point.stabilizable_reason = None;
    }
    if let Some(brockett @ Answer::Known(true)) = &mut point.brockett_condition {
        *brockett = Answer::Unknown(why);
    }
}

impl Analysis {
    /// What delays of inputs change of all this.
    fn about_delays(&self) -> Option<String> {
        if self.input_delays.is_empty() {
            return None;
        }
        let list: Vec<String> = self.input_delays.iter().map(|(name, d)| format!("{name} by {d} s")).collect();
        Some(format!(
            "Inputs act later than they are commanded ({}). All this is about the inputs as they arrive: what they reach from the \
             state at which the first command arrives is reached that much later, ranks and dimensions are the same. A \
             feedback of the state, as for linearisation or stabilisation, would have to know the state that much ahead.",
            list.join(", ")
        ))
    }

    /// What the ranks mean, in one paragraph.
    fn plain_language(&self) -> String {
        let n = self.states;
        if self.inputs == 0 {
            return "There are no inputs: nothing can be steered, and what there is to ask is what the outputs tell."
                .to_owned();
        }
        let Some(worst) =
            self.report.modes.iter().min_by_key(|m| m.dimensions.strongly_accessible_dimension.known().copied())
        else {
            return String::new();
        };
        let Some(&inside) = worst.dimensions.strongly_accessible_dimension.known() else {
            return "What the inputs reach is undecided; the report above gives the reason.".to_owned();
        };
        let functions = worst.autonomous.known().cloned().unwrap_or_default();
        let full = |d: &Dimensions| d.strongly_accessible_dimension.known().copied();
        if worst.signs.0.is_empty() {
            return if inside == n {
                format!(
                    "From almost every state, and at every later time, the inputs reach an open set of the {n}-dimensional \
                     state space."
                )
            } else {
                format!(
                    "At each time the inputs reach only a set of dimension {inside} of {n}. {}",
                    fixed_functions(&functions, "")
                )
            };
        }
        let signs: Vec<String> =
            worst.signs.0.iter().map(|(s, v)| format!("{s} {} 0", if *v > 0 { ">" } else { "<" })).collect();
        let signs = signs.join(", ");
        let mut text = if inside == n {
            format!("Even while no switching function changes its sign, the inputs reach a set of full dimension {n}.")
        } else {
            format!(
                "While no switching function changes its sign (here: {signs}), the inputs reach at each time only a set of \
                 dimension {inside} of {n}. {}",
                fixed_functions(&functions, " there")
            )
        };
        if let Some(all) = self.report.switched.as_ref().and_then(|s| full(&s.dimensions)).filter(|all| *all > inside) {
            let _ = write!(
                text,
                " Where the motion changes from one mode to another the drift changes, and the difference of two drifts acts \
                 like one more input: with all modes together the dimension is {all} of {n}. So directions that one mode \
                 leaves out can be gained by switching, which for dry friction means sliding to and fro, as far as the inputs \
                 overcome the friction."
            );
        }
        if let Some(s) = &self.report.smoothed
            && let Some(all) = full(&s.dimensions).filter(|all| *all > inside)
        {
            let _ = write!(
                text,
                " The smoothed model, in which sign(σ) is tanh(σ/{}), has dimension {all} in one piece, because the smooth \
                 sign depends on the state and so couples the directions. That rank speaks of the smoothed model alone: exact \
                 dry friction holds whatever the inputs do not overcome.",
                s.epsilon
            );
        }
        if worst.signs.0.len() > 1 {
            text += " Modes are combinations of signs; whether each of them occurs is not checked.";
        }
        text
    }
}

fn fixed_functions(functions: &[String], place: &str) -> String {
    match functions.len() {
        0 => String::new(),
        1 => format!("The function {} evolves{place} as if there were no input.", functions[0]),
        _ => format!("The functions {} evolve{place} as if there were no input.", functions.join(" and ")),
    }
}

impl fmt::Display for Analysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.model)?;
        let a = &self.affinization;
        writeln!(f, "affine form: {}", a.why)?;
        let model = &a.model;
        writeln!(
            f,
            "  {} state{}: {}",
            self.states,
            if self.states == 1 { "" } else { "s" },
            model.state_names().join(", ")
        )?;
        let plural = |k: usize| if k == 1 { "" } else { "s" };
        if self.inputs == 0 {
            writeln!(f, "  no inputs")?;
        } else {
            writeln!(f, "  {} input{}: {}", self.inputs, plural(self.inputs), model.input_names().join(", "))?;
        }
        if let Some(family) = &a.family {
            writeln!(f, "  {family}")?;
        }
        for change in a.changes() {
            writeln!(f, "  {change}")?;
        }
        for (s, e) in model.states.iter().zip(&model.dynamics) {
            writeln!(f, "  {}' = {}", model.pool.name(*s), model.pool.text(*e))?;
        }
        write!(f, "{}", self.report)?;
        writeln!(f)?;
        for line in wrapped(&self.summary, 110) {
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}

/// Lines of at most `width` characters, broken at spaces.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
