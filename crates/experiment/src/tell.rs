//! Inputs that tell two explanations apart (T-optimal; Hunter and Reiner 1965, Atkinson and Fedorov 1975).
//!
//! What counts is the difference that remains after a refit of one explanation to the output of the other. The criterion of a plan has
//! it to first order: what combinations of the sensitivities cannot explain. Then the explanation is refitted exactly, and the inputs are
//! planned anew about its new parameters.

use crate::composed::Composed;
use crate::design::Design;
use crate::exact::{Exact, Free, Run};
use crate::noise::noise;
use crate::options::{ExperimentError, ExperimentOptions};
use crate::plan::{Pieces, Plan, deadline};
use crate::refit::{Fitted, Refit};
use crate::search::{Candidate, Search, Searcher};
use crate::setup::Setup;
use crate::smooth::Smooth;
use bracketry_system::System;
use serde::Serialize;

/// Standard deviations above which an experiment resolves two explanations: noise alone prefers the wrong one in 0.6 % of the cases.
pub const RESOLVED: f64 = 5.0;
/// Standard deviations from which on a diagnosis tells the explanations apart, too: it fits the start of every window, not only that of the run. By
/// the random draws of `benches/diagnosis/experiments.py`.
pub const CLEAR: f64 = 50.0;
/// Rounds of planning and refitting.
const ROUNDS: usize = 3;
/// Gain of a round, relative, below which there is no other.
const SETTLED: f64 = 0.02;
/// Standard deviations beyond which no other round follows: no noise confuses the explanations.
const ENOUGH: f64 = 100.0;
/// Factors of each parameter from which the refits of the best inputs start too, so that no other valley is overlooked.
const FAR: [f64; 3] = [0.05, 0.3, 5.0];
/// Most states of a plan, which has the sensitivities of as many parameters and starts as fit in.
const MOST_STATES: usize = 60;

/// The difference that a refit of one explanation to the exact output of the other leaves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Separation {
    /// The explanation whose output it is.
    pub truth: String,
    /// The explanation that is refitted.
    pub refitted: String,
    /// Sum of squares of the differences in units of the noise without a refit.
    pub as_given: f64,
    /// The same after the refit: the expected excess of chi-square.
    pub chi_square: f64,
    /// Its square root: the distance in standard deviations.
    pub deviations: f64,
    /// Values after the refit of the parameters that it may change.
    pub parameters: Vec<(String, f64)>,
    /// States at the start after the refit, such as `x(0)`.
    pub start: Vec<(String, f64)>,
}

/// An experiment that tells two explanations apart.
#[derive(Clone, Debug)]
pub struct Discrimination {
    /// The explanations.
    pub models: [System; 2],
    /// What they are called.
    pub names: [String; 2],
    /// The inputs, their limits, and the noise.
    pub design: Design,
    /// Expected outputs of both, one row per sample.
    pub outputs: [Vec<Vec<f64>>; 2],
    /// Output of the refitted one of the smaller separation, one row per sample.
    pub refitted: Vec<Vec<f64>>,
    /// The separation where the second explanation is true, and where the first one is.
    pub separations: [Separation; 2],
    /// The smaller separation of the best of the simple inputs of the same limits, in standard deviations.
    pub before: f64,
    /// Rounds of planning and refitting.
    pub rounds: usize,
    /// Parameters that were taken as known.
    pub fixed: Vec<String>,
}

impl Discrimination {
    /// The smaller separation.
    pub fn weaker(&self) -> &Separation {
        let [a, b] = &self.separations;
        if a.chi_square <= b.chi_square { a } else { b }
    }

    /// Whether a diagnosis of its data can be expected to tell the explanations apart, too.
    pub fn is_clear(&self) -> bool {
        self.weaker().deviations >= CLEAR
    }

    /// Whether the experiment tells the explanations apart, whichever is true.
    pub fn resolves(&self) -> bool {
        self.weaker().deviations >= RESOLVED
    }
}

/// An explanation while experiments are compared.
struct Side<'a> {
    exact: Exact<'a>,
    free: Vec<Free>,
    name: &'a str,
}

/// Values of the free parameters of both explanations from which refits start: as given, and those of the last refit.
type RefitStarts = [Vec<Vec<f64>>; 2];

/// A candidate with both refits.
struct Judged {
    candidate: Candidate,
    /// Of the first explanation to the second, and the other way round.
    refits: [Refit; 2],
}

impl Judged {
    fn value(&self) -> f64 {
        self.refits[0].square.min(self.refits[1].square)
    }

    /// Refits both explanations from far away too.
    fn refit_from_afar(
        &mut self,
        sides: &[Side<'_>; 2],
        stds: &[f64],
        searcher: &Searcher<'_>,
    ) -> Result<(), ExperimentError> {
        for (k, side) in sides.iter().enumerate() {
            let moved = |j: usize, factor: f64| {
                let value = |(i, p): (usize, &Free)| if i == j { p.value * factor } else { p.value };
                side.free.iter().enumerate().map(value).collect::<Vec<f64>>()
            };
            let starts: Vec<Vec<f64>> = (0..side.free.len()).flat_map(|j| FAR.map(|factor| moved(j, factor))).collect();
            let truth = &self.candidate.runs[1 - k];
            for start in starts {
                if searcher.is_late() {
                    return Ok(());
                }
                let fitted = Fitted::new(&side.exact, &self.candidate.signals, &side.free, stds, Some(truth));
                if let Some(found) = fitted.refit(&[start])?.filter(|f| f.square < self.refits[k].square) {
                    self.refits[k] = found;
                }
            }
        }
        Ok(())
    }

    /// The explanation whose refit leaves less.
    fn weaker(&self) -> usize {
        usize::from(self.refits[1].square < self.refits[0].square)
    }
}

/// Finds inputs within limits that tell two explanations apart, each with its name.
///
/// ```
/// use bracketry_experiment::{ExperimentOptions, Limit, tell};
/// use bracketry_system::System;
/// let model = |rate: &str| {
///     let text = format!("states = ['v']\ninputs = ['u']\nparameters = {{ c = 0.5 }}\ndynamics = {{ v = 'u - {rate}' }}");
///     System::parse("mass.toml", &text).unwrap()
/// };
/// let options = ExperimentOptions {
///     limits: vec![Limit::new("u", -2.0, 2.0)],
///     noise: vec![("v".into(), 0.02)],
///     starts: 1,
///     ..ExperimentOptions::lasting(6.0)
/// };
/// let found = tell([("viscous", &model("c*v")), ("quadratic", &model("c*v*abs(v)"))], &options).unwrap();
/// assert!(found.resolves());
/// ```
///
/// # Errors
/// [`ExperimentError`] for what cannot be designed: models of different inputs or columns, inputs without limits, a model that cannot be
/// simulated.
pub fn tell(
    explanations: [(&str, &System); 2],
    options: &ExperimentOptions,
) -> Result<Discrimination, ExperimentError> {
    let models = explanations.map(|e| e.1);
    let setup = Setup::new(&models, options)?;
    let mut sides = explanations.map(|(name, system)| {
        let exact = Exact::new(system, &setup, &options.stop);
        let free = exact.free(&options.fixed);
        Side { exact, free, name }
    });
    known(&options.fixed, &models)?;
    let exacts = models.map(|m| Exact::new(m, &setup, &options.stop));
    let exacts = [&exacts[0], &exacts[1]];
    let searcher = Searcher { setup: &setup, exacts: &exacts, options, deadline: deadline(options) };
    let simple = searcher.simple()?;
    // No log starts exactly where a model says.
    for (k, side) in sides.iter_mut().enumerate() {
        side.free.extend(exacts[k].starts(simple.iter().map(|c| &c.runs[k])));
    }
    let mut from: RefitStarts = [0, 1].map(|k| vec![sides[k].free.iter().map(|p| p.value).collect()]);
    let runs: Vec<Run> = simple.iter().flat_map(|c| c.runs.clone()).collect();
    let noise = noise(&setup, options, &runs)?;
    let stds: Vec<f64> = noise.iter().map(|n| n.std).collect();
    let smooth = [0, 1].map(|k| Smooth::new(models[k], &setup.rest(), &simple[0].runs[k].states));
    let stopped = || ExperimentError::Simulation { model: explanations.map(|e| e.0).join(", ") };
    let simple_best = best_of(&sides, &from, simple.iter().map(Candidate::copy).collect(), &stds, &searcher)?;
    let mut best = simple_best.ok_or_else(stopped)?;
    best.refit_from_afar(&sides, &stds, &searcher)?;
    let before = best.value().sqrt();
    let (mut starts, mut rounds) = (0, 0);
    while rounds < ROUNDS {
        rounds += 1;
        let weak = best.weaker();
        // The plan has the refitted explanation about its last refit.
        let refitted: Vec<Free> = about(&sides[weak].free, &best.refits[weak].values);
        let Search { candidates, starts: tried } =
            searcher.search(&simple, &[best.candidate.pieces.clone()], &mut |margins, starts| {
                plan(
                    [&smooth[1 - weak], &smooth[weak]],
                    [&refitted, &sides[weak].free],
                    &setup,
                    &stds,
                    margins,
                    starts,
                    options,
                )
            })?;
        starts += tried;
        let value = best.value();
        if let Some(found) = best_of(&sides, &from, candidates, &stds, &searcher)?.filter(|f| f.value() > value) {
            best = found;
        }
        best.refit_from_afar(&sides, &stds, &searcher)?;
        let settled = best.value() <= (1.0 + SETTLED) * value && best.weaker() == weak;
        let enough = best.value().sqrt() >= ENOUGH;
        for (from, refit) in from.iter_mut().zip(&best.refits) {
            from.truncate(1);
            from.push(refit.values.clone());
        }
        if settled || enough || searcher.is_late() {
            break;
        }
    }
    let weak = best.weaker();
    let refit: Vec<(&Free, f64)> = sides[weak].free.iter().zip(best.refits[weak].values.iter().copied()).collect();
    let refitted = sides[weak].exact.run(&best.candidate.signals, &refit)?.map(|r| r.outputs).unwrap_or_default();
    let separations = [0, 1].map(|k| separation(&sides[1 - k], &sides[k], &best, k, &stds));
    let [first, second] = &best.candidate.runs[..] else { return Err(stopped()) };
    Ok(Discrimination {
        models: models.map(Clone::clone),
        names: explanations.map(|e| e.0.to_owned()),
        outputs: [first.outputs.clone(), second.outputs.clone()],
        refitted,
        separations,
        before,
        rounds,
        fixed: options.fixed.clone(),
        design: Design::new(&setup, best.candidate.signals, noise, starts, searcher.is_late()),
    })
}

/// Names of parameters that are to be fixed have to be known to a model.
fn known(fixed: &[String], models: &[&System; 2]) -> Result<(), ExperimentError> {
    let names: Vec<String> = models.iter().flat_map(|m| m.parameter_names()).collect();
    match fixed.iter().find(|f| !names.contains(f)) {
        Some(name) => Err(crate::setup::unknown("--fix", name, "a parameter of either model", &names)),
        None => Ok(()),
    }
}

/// Parameters with other values.
fn about(free: &[Free], values: &[f64]) -> Vec<Free> {
    free.iter().zip(values).map(|(p, v)| Free { value: *v, ..p.clone() }).collect()
}

/// The plan that moves the output of the truth away from what refits of the other explanation reach.
fn plan(
    [truth, other]: [&Smooth; 2],
    [refitted, given]: [&[Free]; 2],
    setup: &Setup,
    stds: &[f64],
    margins: &[f64],
    starts: &[Pieces],
    options: &ExperimentOptions,
) -> Result<Plan, ExperimentError> {
    let mut composed = Composed::new(setup);
    let is = composed.add(truth, "@1", setup, &[], &[], stds)?;
    let values: Vec<(&Free, f64)> = refitted.iter().map(|p| (p, p.value)).collect();
    let sensitive = sensitive(refitted, given, [truth.x0.len(), other.x0.len()]);
    let seems = composed.add(other, "@2", setup, &values, &sensitive, stds)?;
    let mut lists = seems.sensitivities;
    let pool = &mut composed.system.pool;
    lists.push(is.outputs.iter().zip(&seems.outputs).map(|(a, b)| pool.sub(*a, *b)).collect());
    let products = composed.add_products(&lists, setup.sample)?;
    let criterion = composed.remainder(&products);
    let cost = composed.cost(criterion)?;
    Plan::new(&composed, cost, setup, margins, starts, options)
}

/// The parameters and starts of which a plan has the sensitivities: those that the last refit changed most, as many as fit in.
fn sensitive(refitted: &[Free], given: &[Free], states: [usize; 2]) -> Vec<Free> {
    let size = |count: usize| states[0] + states[1] * (count + 1) + (count + 1) * (count + 2) / 2;
    let count = (0..=refitted.len()).take_while(|count| size(*count) <= MOST_STATES).last().unwrap_or(0);
    let moved = |k: usize| ((refitted[k].value - given[k].value) / given[k].scale).abs();
    let mut order: Vec<usize> = (0..refitted.len()).collect();
    order.sort_by(|a, b| moved(*b).total_cmp(&moved(*a)));
    order.into_iter().take(count).map(|k| refitted[k].clone()).collect()
}

/// Refits both explanations under each of the candidates; the one with the largest smaller separation.
fn best_of(
    sides: &[Side<'_>; 2],
    from: &RefitStarts,
    candidates: Vec<Candidate>,
    stds: &[f64],
    searcher: &Searcher<'_>,
) -> Result<Option<Judged>, ExperimentError> {
    let mut best: Option<Judged> = None;
    for candidate in candidates {
        if best.is_some() && searcher.is_late() {
            break;
        }
        let refit = |k: usize| {
            let side = &sides[k];
            let truth = &candidate.runs[1 - k];
            Fitted::new(&side.exact, &candidate.signals, &side.free, stds, Some(truth)).refit(&from[k])
        };
        let (Some(first), Some(second)) = (refit(0)?, refit(1)?) else { continue };
        let judged = Judged { candidate, refits: [first, second] };
        if best.as_ref().is_none_or(|b| judged.value() > b.value()) {
            best = Some(judged);
        }
    }
    Ok(best)
}

/// The separation in which explanation `k` is refitted.
fn separation(truth: &Side<'_>, refitted: &Side<'_>, best: &Judged, k: usize, stds: &[f64]) -> Separation {
    let [a, b] = [0, 1].map(|i| best.candidate.runs[i].outputs.iter());
    let gaps = a.zip(b).flat_map(|(a, b)| a.iter().zip(b).zip(stds).map(|((a, b), std)| ((a - b) / std).powi(2)));
    let refit = &best.refits[k];
    let values = refitted.free.iter().zip(&refit.values);
    let (start, parameters): (Vec<_>, Vec<_>) = values.partition(|(p, _)| p.state.is_some());
    let [parameters, start] =
        [parameters, start].map(|list| list.into_iter().map(|(p, v)| (p.name.clone(), *v)).collect::<Vec<_>>());
    Separation {
        truth: truth.name.to_owned(),
        refitted: refitted.name.to_owned(),
        as_given: gaps.sum(),
        chi_square: refit.square,
        deviations: refit.square.sqrt(),
        parameters,
        start,
    }
}
