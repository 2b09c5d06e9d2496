//! From a model to what its inputs reach and its outputs tell.

use std::collections::BTreeMap;
use std::time::Instant;

use bracketry_system::{AffineError, Affinization, Method, System, ZeroDenominator};

use crate::analysis::affine::analyze_affine;
use crate::analysis::family::{Family, family_dimensions};
use crate::analysis::report::Report;
use crate::analysis::transfer::{flatness_of_original, with_input_ranges, withhold_local_verdicts};
use crate::error::Error;
use crate::observability::report::observe;
use crate::options::AnalysisOptions;

/// An analysis that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// No affine form was found.
    #[error(transparent)]
    Affine(#[from] AffineError),
    /// The brackets could not be formed.
    #[error(transparent)]
    Lie(#[from] Error),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
    /// It is asked what the outputs determine of a model without outputs.
    #[error("the model has no outputs that could determine `{function}`: add a table [outputs]")]
    NoOutputs {
        /// The function that was asked for.
        function: String,
    },
}

/// What the inputs of a model reach and what its outputs tell.
#[derive(Clone, Debug)]
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
    pub input_delays: BTreeMap<String, f64>,
    /// How it became affine.
    pub affinization: Affinization,
    /// What the original reaches with constant inputs, which the affine form must agree with; absent for a model that is
    /// affine as it stands.
    pub family: Option<Family>,
    /// Ranks, growth vectors and verdicts of the affine model, local verdicts as far as they hold for the original.
    pub report: Report,
    /// The model as it was given.
    pub original: System,
}

/// Makes a model affine in its inputs and analyzes it.
///
/// ```
/// use bracketry_system::System;
/// let model = "states = ['x', 'y', 'th']\ninputs = ['u1', 'u2']\n\
///              dynamics = { x = 'u1*cos(th)', y = 'u1*sin(th)', th = 'u2' }";
/// let unicycle = System::parse("unicycle", model).unwrap();
/// let analysis = bracketry_lie::analyze(&unicycle, &Default::default()).unwrap();
/// assert_eq!(analysis.report.modes[0].dimensions.growth, [2, 3]);
/// ```
///
/// What is not decided within [`AnalysisOptions::time_limit`] is unknown.
///
/// # Errors
/// [`AnalysisError`] if no affine form is found or there are too many modes; what an exact test
/// cannot decide becomes an unknown of the report instead.
pub fn analyze(system: &System, options: &AnalysisOptions) -> Result<Analysis, AnalysisError> {
    let start = Instant::now();
    if let (Some(function), true) = (options.determined.first(), system.outputs.is_empty()) {
        return Err(AnalysisError::NoOutputs { function: function.clone() });
    }
    let given = system;
    let mut system = given.clone();
    system.pool.set_deadline(options.deadline(start, &system.pool));
    let system = &system;
    system.check_denominators()?;
    let mut affinization = system.affinize()?;
    let affine = affinization.method == Method::None;
    let options = with_input_ranges(options, &affinization, system);
    let mut report = analyze_affine(&affinization.system, &options)?;
    if !affine {
        flatness_of_original(&mut report, &affinization, system);
        // Old inputs are known, though integrators make them states and new inputs may hold parameters.
        report.observability = observe(system, &options, &mut report.certificate)?;
    }
    withhold_local_verdicts(&mut report, &affinization, system);
    let family = if affine { None } else { Some(family_dimensions(system, &affinization.system, &report)?) };
    report.seconds = start.elapsed().as_secs_f64();
    let others = affinization.candidates.iter_mut().filter_map(|c| c.system.as_mut());
    for system in others.chain([&mut affinization.system]) {
        system.pool.set_deadline(given.pool.deadline());
    }
    Ok(Analysis {
        model: system.name.clone(),
        states: affinization.system.states.len(),
        inputs: affinization.system.inputs.len(),
        affine,
        input_delays: system.delays_by_name(),
        affinization,
        family,
        report,
        original: given.clone(),
    })
}
