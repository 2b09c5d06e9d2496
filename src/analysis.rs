//! From a model to what its inputs reach: affine form and Lie-algebraic report in one result.

use std::fmt::{self, Write as _};
use std::time::Instant;

use bracketry_lie::{Options, Report};
use bracketry_system::{AffineError, Affinization, Method, System};
use serde::Serialize;

/// An analysis that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// No affine form was found.
    #[error(transparent)]
    Affine(#[from] AffineError),
    /// The brackets could not be formed.
    #[error(transparent)]
    Lie(#[from] bracketry_lie::Error),
}

/// How the model became affine in its inputs.
#[derive(Clone, Debug, Serialize)]
pub struct AffinizationReport {
    /// What was done.
    pub method: Method,
    /// Integrators in front of each input that got any.
    pub integrators: std::collections::BTreeMap<String, u32>,
    /// For a change of inputs: each new input as a function of the old ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub input_change: Vec<(String, String)>,
    /// The affine model.
    pub model: System,
    /// The reason, in a sentence.
    pub why: String,
}

impl From<&Affinization> for AffinizationReport {
    fn from(a: &Affinization) -> Self {
        AffinizationReport {
            method: a.method,
            integrators: a.integrators.clone(),
            input_change: a.input_change.iter().map(|(v, w)| (v.clone(), a.system.pool.text(*w))).collect(),
            model: a.system.clone(),
            why: a.why.clone(),
        }
    }
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
    /// How it became affine.
    pub affinization: AffinizationReport,
    /// Ranks, growth vectors and verdicts of the affine model.
    #[serde(flatten)]
    pub report: Report,
    /// What the ranks mean, in plain language.
    pub summary: String,
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
    let affinization = system.affinize()?;
    let mut report = bracketry_lie::analyse(&affinization.system, options)?;
    report.seconds = begin.elapsed().as_secs_f64();
    let affine = &affinization.system;
    let mut analysis = Analysis {
        model: system.name.clone(),
        states: affine.states.len(),
        inputs: affine.inputs.len(),
        affine: affinization.method == Method::None,
        affinization: (&affinization).into(),
        summary: String::new(),
        report,
    };
    analysis.summary = analysis.plain_language();
    Ok(analysis)
}

impl Analysis {
    /// What the ranks mean, in one paragraph.
    fn plain_language(&self) -> String {
        let n = self.states;
        let Some(worst) =
            self.report.modes.iter().min_by_key(|m| m.dimensions.strongly_accessible_dimension.known().copied())
        else {
            return String::new();
        };
        let Some(&inside) = worst.dimensions.strongly_accessible_dimension.known() else {
            return "What the inputs reach is undecided; the report above gives the reason.".to_owned();
        };
        let functions = worst.autonomous.known().cloned().unwrap_or_default();
        if worst.signs.0.is_empty() {
            return if inside == n {
                format!(
                    "From almost every state the inputs reach an open set of the {n}-dimensional state space, at every time."
                )
            } else {
                format!(
                    "At each time the inputs reach only a set of dimension {inside} of {n}. {}",
                    fixed_functions(&functions)
                )
            };
        }
        let mut text = format!(
            "As long as no friction direction changes, the inputs reach at each time only a set of dimension {inside} of {n}. {}",
            fixed_functions(&functions)
        );
        if inside == n {
            text = format!("Even while no friction direction changes, the inputs reach a set of full dimension {n}.");
        }
        let full = |d: &bracketry_lie::Dimensions| d.strongly_accessible_dimension.known().copied();
        if let Some(all) = self.report.switched.as_ref().and_then(full).filter(|all| *all > inside) {
            let _ = write!(
                text,
                " Changing the direction of sliding changes the drift, and the difference of two drifts acts like one more \
                 input: with all modes together the dimension is {all} of {n}, so what one mode cannot reach is reached by \
                 switching, that is, by letting the object slide to and fro."
            );
        }
        if let Some(s) = &self.report.smoothed
            && let Some(all) = full(&s.dimensions).filter(|all| *all > inside)
        {
            let _ = write!(
                text,
                " The smoothed model (sign replaced by tanh(σ/{})) has dimension {all} for the same reason in one piece: its \
                 friction depends on the velocity, which couples the directions. That rank speaks of the smoothed model; \
                 exact dry friction holds the object wherever the inputs do not overcome it.",
                s.epsilon
            );
        }
        text
    }
}

fn fixed_functions(functions: &[String]) -> String {
    match functions.len() {
        0 => String::new(),
        1 => format!("The function {} evolves as if there were no input.", functions[0]),
        _ => format!("The functions {} evolve as if there were no input.", functions.join(" and ")),
    }
}

impl fmt::Display for Analysis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.model)?;
        let a = &self.affinization;
        writeln!(f, "affine form: {}", a.why)?;
        let model = &a.model;
        writeln!(f, "  {} states: {}", self.states, model.state_names().join(", "))?;
        writeln!(f, "  {} inputs: {}", self.inputs, model.input_names().join(", "))?;
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
