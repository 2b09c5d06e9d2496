//! The pipeline.

use std::time::Instant;

use bracketry_system::{Parameter, System};

use super::attempt::Attempt;
use super::columns::wrong_columns;
use super::curves::{curved, curved_where_better};
use super::explanation::Explanation;
use super::fewer::fewer;
use super::findings::{Ending, Findings, Rivals};
use super::held_out::UnseenWindows;
use super::hold::{half_a_sample, other_hold};
use super::motion::{driven, still, uninformative};
use super::noise::Scatter;
use super::places::{Places, places};
use super::proven::drop_unproven;
use super::refused::{drop_refused, over_all_windows};
use super::repeats::{Distinct, distinct};
use super::rivals::rivals;
use super::scale::{factors, rescaled};
use super::search::Search;
use super::select::{Selection, backwards};
use super::stage::Stage;
use super::unnamed::unnamed;
use super::validation::mispredicted;
use super::{scale, write};
use crate::effort::Counter;
use crate::library::{candidates, dictionary};
use crate::read::Warning;
use crate::report::{Caveat, Fits, Note};
use crate::settings::{DiagnosisSettings, StudySettings};
use crate::study::{Windows, shorter_windows};
use crate::{Cause, DiagnoseError, Record, Report, Study, Verdict};

/// Finds what `system` gets wrong about `records`; `validate` are records on which nothing but the gain is
/// measured.
///
/// Long windows first: where the right causes are among the candidates, the residual is noise, and long windows
/// average it best. Where structure remains, the windows that make the unknowns most certain take their place
/// ([`Study::with_best_windows`]), and the search restarts.
///
/// # Errors
/// Records that do not fit the model, a model that cannot be simulated: [`DiagnoseError`].
/// [`DiagnoseError::Stopped`] soon after the flag of the model's pool is raised.
pub fn diagnose(
    system: &System,
    records: &[Record],
    validate: &[Record],
    settings: &DiagnosisSettings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    let started = Instant::now();
    if settings.max_causes == 0 {
        let name = "the number of causes that are named together (--max-causes)";
        return Err(DiagnoseError::Setting { name, value: 0.0, requirement: "at least 1" });
    }
    if let Some(&value) = settings.gain.predictions.horizons.iter().find(|h| !(**h > 0.0 && h.is_finite())) {
        let name = "the horizon of predictions (--horizon)";
        return Err(DiagnoseError::Setting { name, value, requirement: "positive" });
    }
    let share = settings.verdict.search.share_of_time;
    let deadline = settings.time_limit.and_then(|limit| started.checked_add(limit.mul_f64(share)));
    let counter = Counter::until(deadline, settings.end_search.clone());
    let data = distinct(records, validate);
    let mut report = examined(system, data.clone(), true, settings, &counter, progress)?;
    if report.verdict == Verdict::Unexplained && settings.study.window.is_none() {
        report = in_shorter_windows(system, &data, report, settings, &counter, progress)?;
    }
    if counter.is_over() && counter.left_out() > 0 {
        let left_out = counter.left_out();
        report.notes.push(match settings.time_limit {
            Some(limit) if !settings.end_search.is_raised() => {
                Note::TimeLimit { seconds: limit.as_secs_f64(), left_out }
            }
            _ => Note::Interrupted { left_out },
        });
    }
    report.notes.extend(fixed(system, &settings.study));
    report.notes.extend(records.iter().chain(validate).flat_map(outliers));
    report.effort = counter.effort();
    report.data = records.iter().chain(validate).filter_map(|r| r.audit.clone()).collect();
    report.seconds = started.elapsed().as_secs_f64();
    Ok(report)
}

/// The parameters that keep their values because the model file or the settings say so.
fn fixed(system: &System, settings: &StudySettings) -> Option<Note> {
    let known =
        |p: &&Parameter| p.is_fixed() || settings.fixed.iter().any(|name| *name == system.symbol_name(p.symbol));
    let names: Vec<String> =
        system.parameters.iter().filter(known).map(|p| system.symbol_name(p.symbol).to_owned()).collect();
    (!names.is_empty()).then_some(Note::Fixed(names))
}

/// What is to be said of samples of a record that stand alone.
fn outliers(record: &Record) -> impl Iterator<Item = Note> {
    let warnings = record.audit.iter().flat_map(|audit| &audit.warnings);
    let of = |warning: &&Warning| matches!(warning, Warning::Outliers { .. });
    warnings.filter(of).map(|warning| Note::Outliers { record: record.name.clone(), warning: warning.clone() })
}

/// What a report left unexplained, in windows of a quarter and of a sixteenth of the length: what falls out of step over long windows, as with
/// a long lag, may be clear in short ones. The first report with a cause, or the one that was.
fn in_shorter_windows(
    system: &System,
    data: &Distinct,
    report: Report,
    settings: &DiagnosisSettings,
    counter: &Counter,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    let Some(Windows { seconds: used, .. }) = report.windows else { return Ok(report) };
    let parts = &settings.verdict.search.shorter;
    for seconds in shorter_windows(&data.records, system.states.len(), parts, &settings.study.windows) {
        if seconds > settings.verdict.search.shorter_than * used {
            continue;
        }
        if counter.is_over() {
            counter.leave_out(1);
            break;
        }
        let study = StudySettings { window: Some(seconds), ..settings.study.clone() };
        let settings = DiagnosisSettings { study, ..settings.clone() };
        let mut found = examined(system, data.clone(), true, &settings, counter, progress)?;
        if found.verdict.extends_the_model() && found.verdict.is_conclusive() {
            found.notes.push(Note::ShorterWindows { seconds, used });
            return Ok(found);
        }
    }
    Ok(report)
}

/// The diagnosis of records of which each is there once. Where inputs go on along straight `lines` between their samples and curves
/// leave much less, it restarts with these.
fn examined(
    system: &System,
    data: Distinct,
    lines: bool,
    settings: &DiagnosisSettings,
    counter: &Counter,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    progress(Stage::Refit);
    counter.set_ended(false);
    let Distinct { mut records, mut validate, mut notes } = data;
    let mut library = candidates(system, &records, &settings.library)?;
    // What another model suggests may be in the library already.
    let more = settings.candidates.iter().filter(|c| library.iter().all(|known| known.change != c.change));
    library.extend(more.cloned().collect::<Vec<_>>());
    let first = Study::counted(system, &records, &settings.study, counter)?;
    first.check_window()?;
    first.check_time_scale()?;
    if still(&records, settings.verdict.alarm.motion_spread).1 {
        return Ok(Report { notes, ..uninformative(system, &records) });
    }
    if let Some(report) = wrong_columns(system, &first, settings, counter)? {
        return Ok(Report { notes, ..report });
    }
    let (shorter, weighed);
    let mut study = &first;
    let mut attempt = Attempt::new(study, None, &library, settings, progress)?;
    if let Some(factors) = factors(&attempt.selection.chosen.alarm, records.iter().chain(&validate), settings) {
        progress(Stage::Refit);
        notes.extend(scale::notes(&records, &factors, settings.verdict.alarm.noise_off));
        (records, validate) = (rescaled(&records, &factors), rescaled(&validate, &factors));
        weighed = Study::counted(system, &records, &settings.study, counter)?;
        study = &weighed;
        attempt = Attempt::new(study, None, &library, settings, progress)?;
    }
    let structured = !counter.is_over()
        && attempt.selection.chosen.alarm.p_value < settings.significance
        && !attempt.selection.chosen.spans(&attempt.base, &settings.verdict.search);
    if structured && settings.study.window.is_none() {
        progress(Stage::Refit);
        let near = attempt.selection.chosen.fit.clone();
        shorter = study.with_best_windows(&near.effects, Some(&near))?.0;
        if shorter.windows().len() != study.windows().len() {
            attempt = Attempt::new(&shorter, Some(&near), &library, settings, progress)?;
        }
    }
    let Attempt { mut search, mut base, selection } = attempt;
    if lines
        && !counter.is_over()
        && let Some((better, note)) = curved_where_better(system, search.study, &selection.chosen, settings)?
    {
        notes.push(note);
        let data = Distinct { records: better, validate: curved(system, &validate, &settings.verdict.signals), notes };
        return examined(system, data, false, settings, counter, progress);
    }
    let validate = validate.as_slice();
    let Selection { chosen, scatter, tests, screened } = selection;
    let mut alarm = base.alarm.p_value.min(screened);
    let chosen = Chosen { explanation: chosen, scatter, tests, rivals: Vec::new(), refuted: None, refused: None };
    let Chosen { explanation: mut chosen, scatter, tests, rivals, refuted, refused } = if alarm < settings.significance
    {
        weigh(system, &mut search, &base, chosen, settings, progress)?
    } else {
        chosen
    };
    if let Some(better) = search.base().filter(|b| b.square() < base.square()) {
        base = better.clone();
        alarm = base.alarm.p_value;
    }
    if search.windows.len() < search.study.windows().len() {
        let every: Vec<usize> = (0..search.study.windows().len()).collect();
        base.fit = search.study.fit(&[], &every, Some(&base.fit))?;
        chosen.fit = over_all_windows(&search, &chosen)?;
    }
    let ending = if alarm < settings.significance {
        ending(&base, &chosen, (refuted, refused), settings)
    } else {
        Ending::Quiet
    };
    counter.set_ended(true);
    let findings = Findings { base, chosen, rivals, scatter, tests, alarm, ending };
    let mut report = written(system, &mut search, &findings, validate, settings, progress)?;
    report.notes.extend(notes);
    // What failed since was not the model's fault.
    if system.pool.stop_flag().is_raised() {
        return Err(DiagnoseError::Stopped);
    }
    Ok(report)
}

/// What the search has chosen so far.
struct Chosen {
    explanation: Explanation,
    scatter: Scatter,
    tests: f64,
    /// Of each of its members.
    rivals: Vec<Rivals>,
    /// Share of the excess that was explained by what held-out data did not bear out, if nothing else is left.
    refuted: Option<f64>,
    /// The same of causes that were significant and must not be named.
    refused: Option<f64>,
}

/// Weighs an explanation after an alarm: terms without a name take its place where they say the same more simply, rivals the
/// place of causes where they are better, and causes that held-out data do not bear out or that are not significant leave.
fn weigh(
    system: &System,
    search: &mut Search<'_>,
    base: &Explanation,
    mut now: Chosen,
    settings: &DiagnosisSettings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Chosen, DiagnoseError> {
    // Hidden masses are fitted, not screened.
    let mut among: Vec<usize> =
        (0..search.candidates.len()).filter(|&c| search.candidates[c].hidden().is_empty()).collect();
    let chosen = &now.explanation;
    // Structure that is hardly worth a name; several causes or parameters far off that one law may say more simply.
    let structured = chosen.alarm.p_value < settings.significance && !chosen.spans(base, &settings.verdict.search);
    if search.is_over() {
        // What would take its place was not tried; the report says so.
        search.study.counter().leave_out(chosen.members.len());
        now.rivals = vec![Vec::new(); chosen.members.len()];
        return Ok(now);
    }
    if structured || chosen.members.len() > 1 || chosen.moved_parameters(settings.tolerance) > 0 {
        let terms = search.extend(dictionary(system, search.study.records(), &settings.library)?);
        let lists = (among.as_slice(), terms.as_slice());
        if let Some((better, scatter)) = unnamed(search, base, chosen, lists, settings, progress)? {
            (now.explanation, now.scatter) = (better, scatter);
            now.tests += terms.len() as f64;
            among.extend(terms);
            backwards(search, &mut now.explanation, &now.scatter, now.tests, settings);
        }
    }
    if now.explanation.members.is_empty() {
        return Ok(now);
    }
    let named: Vec<usize> =
        among.iter().copied().filter(|&c| search.candidates[c].cause != Cause::UnknownTerm).collect();
    while let Some(smaller) = fewer(search, base, &now.explanation, &named, &now.scatter, settings)? {
        now.explanation = smaller;
    }
    progress(Stage::Rivals);
    let unseen = UnseenWindows::new(search.study, &search.windows, settings.verdict.search.most_windows);
    let compare = |search: &mut Search<'_>, explanation: &mut Explanation| {
        rivals(search, explanation, &now.scatter, &among, unseen.as_ref(), (settings.significance, settings.tolerance))
    };
    now.rivals = compare(search, &mut now.explanation)?;
    let best = now.explanation.clone();
    if drop_idle(search, &mut now.explanation, unseen.as_ref())? {
        now.rivals = compare(search, &mut now.explanation)?;
    }
    now.refuted = now.explanation.members.is_empty().then(|| share(base, &best));
    // Each round leaves fewer causes.
    loop {
        let before = now.explanation.clone();
        let unproven = drop_unproven(search, &mut now.explanation, &now.scatter, now.tests, settings);
        if !unproven && !drop_refused(search, &mut now.explanation, &now.scatter, settings)? {
            break;
        }
        now.refused = (!unproven && now.explanation.members.is_empty()).then(|| share(base, &before));
        now.rivals = compare(search, &mut now.explanation)?;
    }
    Ok(now)
}

/// Takes out causes without which held-out data are predicted no worse; says whether there were any.
fn drop_idle(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    held_out: Option<&UnseenWindows>,
) -> Result<bool, DiagnoseError> {
    let Some(held_out) = held_out else { return Ok(false) };
    let mut dropped = false;
    for member in chosen.members.clone() {
        let Some(without) = search.without(chosen, member) else { continue };
        if held_out.worse(&without, chosen)? <= 0.0 {
            *chosen = without;
            dropped = true;
        }
    }
    Ok(dropped)
}

/// The report, with intervals, extended model and gain.
fn written(
    system: &System,
    search: &mut Search<'_>,
    findings: &Findings,
    validate: &[Record],
    settings: &DiagnosisSettings,
    progress: &mut dyn FnMut(Stage),
) -> Result<Report, DiagnoseError> {
    let mut report = write::report(system, search, findings, settings);
    if report.verdict != Verdict::NothingFound {
        let records = search.study.records();
        let Places { motion, regimes, over_time } = places(system, records, &findings.base.fit, settings)?;
        (report.places, report.regimes, report.residual_acceleration) = (motion, regimes, over_time);
        if report.places.is_empty() {
            report.notes.push(Note::NoPlaces);
        }
    }
    progress(Stage::Gain);
    let width = findings.scatter.width();
    let fits = Fits { refitted: &findings.base.fit, extended: &findings.chosen.fit, width };
    report.complete(search.study, fits, validate, settings)?;
    report.weigh_gain(&settings.verdict.naming);
    add_caveats(&mut report, system, search, findings, validate, settings)?;
    Ok(report)
}

/// Adds what speaks against the verdict: columns without motion, inputs that go on otherwise between samples, other units, runs for
/// validation that are not predicted.
fn add_caveats(
    report: &mut Report,
    system: &System,
    search: &Search<'_>,
    findings: &Findings,
    validate: &[Record],
    settings: &DiagnosisSettings,
) -> Result<(), DiagnoseError> {
    let records = search.study.records();
    let (still, _) = still(records, settings.verdict.alarm.motion_spread);
    if !still.is_empty() {
        report.notes.push(Note::StillColumns(still));
    }
    // Inputs that never change continue equally with either hold; another fit would only find another minimum.
    if findings.ending != Ending::Quiet
        && driven(records)
        && !search.is_over()
        && let Some(other) = other_hold(system, search, findings, settings)?
    {
        report.reason.caveats.push(Caveat::OtherHold(other));
        if other.stays.is_none() && report.verdict.extends_the_model() {
            report.withdraw();
        }
        report.notes.push(Note::OtherHold(other));
    }
    for cause in &mut report.causes {
        cause.flags.extend(half_a_sample(cause, records, settings.verdict.signals.near_half_sample));
    }
    if report.verdict != Verdict::Unexplained {
        for run in mispredicted(system, search.study, &findings.chosen, validate, settings)? {
            report.reason.caveats.push(Caveat::Mispredicted(run.clone()));
            report.notes.push(Note::Mispredicted(run));
        }
    }
    Ok(())
}

/// Share of the excess that an explanation takes away.
fn share(base: &Explanation, chosen: &Explanation) -> f64 {
    1.0 - chosen.alarm.excess() / base.alarm.excess().max(f64::MIN_POSITIVE)
}

/// How well an explanation does after an alarm; `refuted` is the share of one that held-out data did not bear out.
fn ending(
    base: &Explanation,
    chosen: &Explanation,
    (refuted, refused): (Option<f64>, Option<f64>),
    settings: &DiagnosisSettings,
) -> Ending {
    let share = share(base, chosen);
    if chosen.members.is_empty() {
        // Something is there, however small: it was significant.
        if let Some(share) = refused {
            Ending::Unexplained(share)
        } else if base.alarm.size < settings.verdict.search.near_noise {
            Ending::Correlated
        } else {
            refuted.map_or(Ending::Unexplained(0.0), Ending::Refuted)
        }
    } else if chosen.alarm.p_value >= settings.significance {
        Ending::Explained
    } else if share >= settings.verdict.naming.least_explained {
        Ending::Partly(share)
    } else {
        Ending::Unexplained(share)
    }
}
