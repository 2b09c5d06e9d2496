//! The pipeline.

use std::time::Instant;

use bracketry_system::System;

use super::noise::Scatter;
use super::rivals::{Rivals, rivals};
use super::search::{Explanation, Search};
use super::select::{Selection, select};
use super::{Settings, Stage, length, write};
use crate::library::candidates;
use crate::{DiagnoseError, Record, Report};

/// Share of the excess over noise that named causes must explain where structure remains; with less the verdict is that the
/// data are unexplained.
const LEAST_EXPLAINED: f64 = 0.5;
/// A residual without any reproducible cause counts as unexplained if its root mean square exceeds that of the noise by
/// this factor; below it is coloured noise.
const COLOURED: f64 = 1.5;

/// What was found, before it is written down.
pub(crate) struct Findings {
    /// The model with parameters refitted.
    pub(crate) base: Explanation,
    /// The explanation, empty if there is none.
    pub(crate) chosen: Explanation,
    /// Rivals of each of its members.
    pub(crate) rivals: Vec<Rivals>,
    /// The scatter around it.
    pub(crate) scatter: Scatter,
    /// Candidates at their trials that were put against the data.
    pub(crate) tests: f64,
    /// Smallest of the p-values by which the alarm was raised.
    pub(crate) alarm: f64,
    /// How it ended.
    pub(crate) ending: Ending,
}

/// How the search for causes ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ending {
    /// The residual is noise.
    Quiet,
    /// The residual is correlated, but no candidate explains it, and it is hardly larger than the noise.
    Coloured,
    /// The named causes explain the residual.
    Explained,
    /// The named causes explain the given share of the excess.
    Partly(f64),
    /// They explain too little; the share of the best attempt.
    Unexplained(f64),
}

/// Finds what `system` gets wrong about `records`.
///
/// # Errors
/// Records that do not fit the model, a model that cannot be simulated: [`DiagnoseError`].
pub fn diagnose(
    system: &System,
    records: &[Record],
    validate: &[Record],
    settings: &Settings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    let begin = Instant::now();
    progress(Stage::Refit);
    let (study, fit) = length::study(system, records, settings)?;
    let mut library = candidates(system, records)?;
    library.extend(settings.candidates.iter().cloned());
    let named: Vec<usize> = (0..library.len()).collect();
    let mut search = Search::new(&study, library, system.states.len());
    let base = search.nothing(fit);
    progress(Stage::Screen { candidates: named.len() });
    let selection = select(&mut search, &base, &named, settings, progress)?;
    let Selection { mut chosen, scatter, tests, screened, .. } = selection;
    let alarm = base.alarm.p_value.min(screened);
    if alarm >= settings.significance {
        let findings = Findings { base, chosen, rivals: Vec::new(), scatter, tests, alarm, ending: Ending::Quiet };
        return written(system, &mut search, &findings, validate, settings, begin, progress);
    }
    let mut found = Vec::new();
    if !chosen.members.is_empty() {
        progress(Stage::Rivals);
        found = rivals(&mut search, &mut chosen, &scatter, &named)?;
    }
    let ending = ending(&base, &chosen, settings);
    let findings = Findings { base, chosen, rivals: found, scatter, tests, alarm, ending };
    written(system, &mut search, &findings, validate, settings, begin, progress)
}

/// The report, with intervals, extended model and gain.
fn written(
    system: &System,
    search: &mut Search<'_>,
    findings: &Findings,
    validate: &[Record],
    settings: &Settings,
    begin: Instant,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    let mut report = write::report(system, search, findings, settings, begin);
    progress(Stage::Gain);
    let (refitted, extended) = (&findings.base.fit, &findings.chosen.fit);
    report.complete(search.study, refitted, extended, validate, &settings.study, settings.seed)?;
    report.seconds = begin.elapsed().as_secs_f64();
    Ok(report)
}

/// How well an explanation does after an alarm.
fn ending(base: &Explanation, chosen: &Explanation, settings: &Settings) -> Ending {
    let share = 1.0 - chosen.alarm.excess() / base.alarm.excess().max(f64::MIN_POSITIVE);
    if chosen.members.is_empty() {
        if base.alarm.size < COLOURED { Ending::Coloured } else { Ending::Unexplained(0.0) }
    } else if chosen.alarm.p_value >= settings.significance {
        Ending::Explained
    } else if share >= LEAST_EXPLAINED {
        Ending::Partly(share)
    } else {
        Ending::Unexplained(share)
    }
}
