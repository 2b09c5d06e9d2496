//! Inputs that identify parameters best: the determinant of the Fisher information is greatest (D-optimal; Atkinson and Fedorov 1975, Mehra
//! 1974).

use crate::composed::Composed;
use crate::design::Design;
use crate::exact::{Exact, Free};
use crate::noise::noise;
use crate::options::{ExperimentError, ExperimentOptions};
use crate::plan::{Pieces, Plan, deadline};
use crate::refit::Fitted;
use crate::search::{Candidate, Searcher};
use crate::setup::{Setup, unknown};
use crate::signals::Signals;
use crate::smooth::Smooth;
use bracketry_system::System;
use nalgebra::{DMatrix, SymmetricEigen};
use serde::Serialize;

/// Standard deviation of a parameter, relative to its value, above which it is not identified: its 95 % interval contains zero.
pub const IDENTIFIED: f64 = 0.5;
/// Relative information below which a combination of parameters counts as not measured at all.
const SINGULAR: f64 = 1e-10;

/// How well one parameter is known after an experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExpectedParameter {
    /// Its name.
    pub name: String,
    /// Its value in the model.
    pub value: f64,
    /// Its unit, where the model states it.
    pub unit: Option<String>,
    /// Expected standard deviation after the best of the simple inputs; none where that does not tell it.
    pub std_before: Option<f64>,
    /// Expected standard deviation after the experiment found; none where that does not tell it.
    pub std_after: Option<f64>,
    /// Whether the experiment tells it: its standard deviation is at most half of its value.
    pub identified: bool,
}

/// An experiment that identifies parameters.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The model.
    pub model: System,
    /// The inputs, their limits, and the noise.
    pub design: Design,
    /// Expected output, one row per sample.
    pub outputs: Vec<Vec<f64>>,
    /// The best of the simple inputs.
    pub reference: Signals,
    /// The parameters.
    pub parameters: Vec<ExpectedParameter>,
    /// Correlation of the estimates after the experiment.
    pub correlation: Vec<Vec<f64>>,
    /// Gain of the determinant of the Fisher information over that of the best of the simple inputs, as the factor by which it shortens the
    /// mean standard deviation; none where a determinant is zero.
    pub shorter: Option<f64>,
    /// Parameters that were taken as known.
    pub fixed: Vec<String>,
}

impl Identification {
    /// Whether all parameters are identified.
    pub fn is_identified(&self) -> bool {
        self.parameters.iter().all(|p| p.identified)
    }
}

/// Finds inputs within limits that identify the named parameters best, all others being known.
///
/// ```
/// use bracketry_experiment::{ExperimentOptions, Limit, identify};
/// use bracketry_system::System;
/// let lag = System::parse("lag.toml", "states = ['y']\ninputs = ['u']\nparameters = { a = 2, b = 3 }\ndynamics = { y = '-a*y + b*u' }");
/// let options = ExperimentOptions {
///     limits: vec![Limit::new("u", -1.0, 1.0)],
///     noise: vec![("y".into(), 0.01)],
///     starts: 1,
///     ..ExperimentOptions::lasting(4.0)
/// };
/// let found = identify(&lag.unwrap(), &["a".into(), "b".into()], &options).unwrap();
/// assert!(found.is_identified());
/// ```
///
/// # Errors
/// [`ExperimentError`] for what cannot be designed: unknown names, inputs without limits, a model that cannot be simulated.
pub fn identify(
    model: &System,
    parameters: &[String],
    options: &ExperimentOptions,
) -> Result<Identification, ExperimentError> {
    let setup = Setup::new(&[model], options)?;
    let exact = Exact::new(model, &setup, &options.stop);
    let free = chosen(&exact, parameters)?;
    let searcher = Searcher { setup: &setup, exacts: &[&exact], options, deadline: deadline(options) };
    let simple = searcher.simple()?;
    let runs: Vec<_> = simple.iter().flat_map(|c| c.runs.clone()).collect();
    let noise = noise(&setup, options, &runs)?;
    let stds: Vec<f64> = noise.iter().map(|n| n.std).collect();
    let smooth = Smooth::new(model, &setup.rest(), &simple[0].runs[0].states);
    let mut build = |margins: &[f64], starts: &[Pieces]| {
        let mut composed = Composed::new(&setup);
        let shown = composed.add(&smooth, "", &setup, &[], &free, &stds)?;
        let information = composed.add_products(&shown.sensitivities, setup.sample)?;
        let criterion = composed.determinant(&information);
        let cost = composed.cost(criterion)?;
        Plan::new(&composed, cost, &setup, margins, starts, options)
    };
    let search = searcher.search(&simple, &[], &mut build)?;
    let of = |candidate: &Candidate| -> Result<Information, ExperimentError> {
        let jacobian = Fitted::new(&exact, &candidate.signals, &free, &stds, None).sensitivities()?;
        Ok(Information::new(jacobian, free.len()))
    };
    let best = |candidates: Vec<Candidate>| -> Result<Option<(Candidate, Information)>, ExperimentError> {
        let mut best: Option<(Candidate, Information)> = None;
        for candidate in candidates {
            let own = of(&candidate)?;
            if best.as_ref().is_none_or(|b| own.log_determinant > b.1.log_determinant) {
                best = Some((candidate, own));
            }
        }
        Ok(best)
    };
    let stopped = || ExperimentError::Simulation { model: model.name.clone() };
    let (reference, before) = best(simple)?.ok_or_else(stopped)?;
    let (found, after) = match best(search.candidates)? {
        Some((found, after)) if after.log_determinant >= before.log_determinant => (found, after),
        _ => (reference.copy(), before.clone()),
    };
    let expected = free.iter().enumerate().map(|(j, p)| {
        let std = |i: &Information| i.std(j).map(|s| s * p.scale);
        let std_after = std(&after);
        ExpectedParameter {
            name: p.name.clone(),
            value: p.value,
            unit: model.parameters.iter().find(|q| model.symbol_name(q.symbol) == p.name).and_then(|q| q.unit.clone()),
            std_before: std(&before),
            std_after,
            identified: std_after.is_some_and(|s| p.value == 0.0 || s <= IDENTIFIED * p.value.abs()),
        }
    });
    let gain = after.log_determinant - before.log_determinant;
    Ok(Identification {
        model: model.clone(),
        outputs: found.runs[0].outputs.clone(),
        design: Design::new(&setup, found.signals, noise, search.starts, searcher.is_late()),
        reference: reference.signals,
        parameters: expected.collect(),
        correlation: after.correlation(),
        shorter: gain.is_finite().then(|| (gain / (2.0 * free.len() as f64)).exp()),
        fixed: exact.free(&[]).into_iter().map(|p| p.name).filter(|n| !parameters.contains(n)).collect(),
    })
}

/// The parameters asked for.
fn chosen(exact: &Exact<'_>, names: &[String]) -> Result<Vec<Free>, ExperimentError> {
    let all = exact.free(&[]);
    let known: Vec<String> = all.iter().map(|p| p.name.clone()).collect();
    let of = |name: &String| {
        let found = all.iter().find(|p| p.name == *name).cloned();
        found.ok_or_else(|| unknown("--parameters", name, "a parameter of the model that is free", &known))
    };
    // A name given twice is one parameter.
    let first = |(k, name): &(usize, &String)| !names[..*k].contains(name);
    names.iter().enumerate().filter(first).map(|(_, name)| of(name)).collect()
}

/// The Fisher information of relative changes of parameters.
#[derive(Clone)]
struct Information {
    /// Minus infinity where a combination of parameters is not measured.
    log_determinant: f64,
    covariance: Option<DMatrix<f64>>,
}

impl Information {
    fn new(jacobian: Option<DMatrix<f64>>, count: usize) -> Self {
        let nothing = Self { log_determinant: f64::NEG_INFINITY, covariance: None };
        let Some(jacobian) = jacobian else { return nothing };
        let information = jacobian.transpose() * &jacobian;
        let eigen = SymmetricEigen::new(information);
        let largest = eigen.eigenvalues.amax();
        if count == 0 || eigen.eigenvalues.iter().any(|v| *v <= SINGULAR * largest) {
            return nothing;
        }
        let inverse = DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| 1.0 / v));
        Self {
            log_determinant: eigen.eigenvalues.iter().map(|v| v.ln()).sum(),
            covariance: Some(&eigen.eigenvectors * inverse * eigen.eigenvectors.transpose()),
        }
    }

    fn std(&self, j: usize) -> Option<f64> {
        self.covariance.as_ref().map(|c| c[(j, j)].sqrt())
    }

    fn correlation(&self) -> Vec<Vec<f64>> {
        let Some(c) = &self.covariance else { return Vec::new() };
        let entry = |i: usize, j: usize| c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt();
        (0..c.nrows()).map(|i| (0..c.nrows()).map(|j| entry(i, j)).collect()).collect()
    }
}
