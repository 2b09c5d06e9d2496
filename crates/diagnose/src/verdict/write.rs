//! The findings as a report.

use bracketry_sim::Hold;
use bracketry_system::System;

use super::base_parameters::combination_error;
use super::explanation::Explanation;
use super::findings::{Ending, Findings, Rivals};
use super::jumps::Jumped;
use super::moved_parameters::parameter_errors;
use super::proven::worth;
use super::ranking::ranking;
use super::search::Search;
use crate::report::{
    Closeness, Evidence, Excess, Flag, NamedCause, Note, Outcome, RefittedParameter, Report, Rival, RivalModel, Value,
    Verdict, VerdictReason,
};
use crate::settings::DiagnosisSettings;
use crate::{Cause, Change, Effect, Effort, Estimate, ExtendedModel, Path, Role, separating_experiment};

pub(super) fn report(
    system: &System,
    search: &mut Search<'_>,
    findings: &Findings,
    settings: &DiagnosisSettings,
) -> Report {
    let Explanation { fit, coefficients, .. } = &findings.chosen;
    let own = &fit.values[..fit.values.len() - coefficients];
    let parameters = refitted(system, own, findings.scatter.width());
    let mut causes = Vec::new();
    let named = !matches!(findings.ending, Ending::Unexplained(_) | Ending::Refuted(_));
    if named {
        for (&member, rivals) in findings.chosen.members.iter().zip(&findings.rivals) {
            causes.push(cause(system, search, findings, member, rivals));
        }
        if matches!(findings.ending, Ending::Partly(_)) {
            withhold_uncertain(&mut causes, settings.verdict.naming.uncertain_share);
        }
        let room = settings.max_causes.saturating_sub(causes.len());
        // Beside structure that is not explained or has no name, a moved parameter says nothing: it takes what it can of
        // that. Beside named causes, several that moved together did so for the same reason.
        let clear = matches!(findings.ending, Ending::Quiet | Ending::Explained | Ending::Correlated)
            && causes.iter().all(|c: &NamedCause| c.name != Cause::UnknownTerm);
        let mut errors = if clear { parameter_errors(system, findings, &parameters, settings) } else { Vec::new() };
        if clear && causes.is_empty() && errors.is_empty() {
            errors.extend(combination_error(system, search, findings, &parameters, settings));
        }
        if causes.is_empty() || (errors.len() == 1 && room > 0) {
            causes.extend(errors.into_iter().take(room));
        }
        let gained: Vec<Option<f64>> = (findings.chosen.members.iter())
            .map(|&m| Some(search.without(&findings.chosen, m)?.square() - findings.chosen.square()))
            .collect();
        let least = settings.verdict.naming.least_of_several_kinds * findings.base.alarm.excess();
        withhold_guesses(&mut causes, &gained, least);
    }
    let verdict = match findings.ending {
        Ending::Unexplained(_) | Ending::Refuted(_) => Verdict::Unexplained,
        _ if causes.is_empty() => Verdict::NothingFound,
        _ if causes.iter().all(|c| c.name == Cause::UnknownTerm) => Verdict::UnknownTerm,
        _ => Verdict::CauseFound,
    };
    let extended = verdict.extends_the_model().then_some(&findings.chosen);
    Report {
        model: system.name.clone(),
        quantities: system.quantities.clone(),
        verdict,
        reason: reason(findings, &causes),
        places: Vec::new(),
        regimes: Vec::new(),
        residual_acceleration: Vec::new(),
        gain: None,
        parameters,
        excess: Some(Excess {
            refitted: findings.base.alarm.size,
            extended: extended.filter(|e| !e.members.is_empty()).map(|e| e.alarm.size),
            p_value: findings.alarm,
        }),
        candidates: ranking(search, findings, settings),
        windows: Some(search.study.windows_used()),
        notes: limit(findings, settings).into_iter().collect(),
        effort: Effort::default(),
        seconds: 0.0,
        data: Vec::new(),
        evidence: Evidence { rivals: rival_models(system, search, findings, &causes), ..Evidence::default() },
        causes,
    }
}

/// The models with rivals in the place of each named cause: the best one of every other name.
fn rival_models(system: &System, search: &Search<'_>, findings: &Findings, causes: &[NamedCause]) -> Vec<RivalModel> {
    let mut models: Vec<RivalModel> = Vec::new();
    let pairs = causes.iter().zip(&findings.rivals).filter(|(cause, _)| cause.name != Cause::UnknownTerm);
    for (cause, (candidate, explanation)) in pairs.flat_map(|(cause, rivals)| rivals.iter().map(move |r| (cause, r))) {
        let rival = search.candidates[*candidate].cause;
        let known = models.iter().any(|m| m.cause == cause.name && m.rival == rival);
        if known || rival == cause.name || rival == Cause::UnknownTerm {
            continue;
        }
        // One that no equation can say has no model.
        if let Ok(model) = ExtendedModel::new(system, &explanation.fit, findings.scatter.width()) {
            models.push(RivalModel { cause: cause.name, rival, model });
        }
    }
    models
}

fn reason(findings: &Findings, causes: &[NamedCause]) -> VerdictReason {
    let size = findings.base.alarm.size;
    let parameter_off = !causes.is_empty();
    let outcome = match findings.ending {
        Ending::Quiet => Outcome::Noise { parameter_off },
        Ending::Correlated => Outcome::Correlated { size, parameter_off },
        Ending::Explained => Outcome::Explained,
        Ending::Partly(share) => Outcome::PartlyExplained { share, size: findings.chosen.alarm.size },
        Ending::Refuted(share) => Outcome::NotBorneOut { size, share },
        Ending::Unexplained(share) => Outcome::Unexplained { size, share: (share != 0.0).then_some(share) },
    };
    VerdictReason { outcome, caveats: Vec::new() }
}

/// A note where structure remains and the most causes allowed are there.
fn limit(findings: &Findings, settings: &DiagnosisSettings) -> Option<Note> {
    let causes = findings.chosen.members.len();
    let structured = matches!(findings.ending, Ending::Partly(_) | Ending::Unexplained(_));
    (structured && causes >= settings.max_causes).then_some(Note::MostCauses { causes, allowed: settings.max_causes })
}

/// Estimate with the width that correlation within windows gives it. A number without a dimension has no unit to be shown.
fn value(estimate: &Estimate, unit: &str, width: f64) -> Value {
    let unit = if unit == "1" { "" } else { unit };
    Value { value: estimate.value, std: estimate.widened(width), interval: None, unit: unit.to_owned() }
}

/// Refitted parameters of the model, with the width that correlation within windows gives them.
pub(super) fn refitted(system: &System, estimates: &[Estimate], width: f64) -> Vec<RefittedParameter> {
    estimates
        .iter()
        .map(|e| {
            let unit = system.parameters.iter().find(|p| system.symbol_name(p.symbol) == e.name);
            let unit = unit.and_then(|p| p.unit.clone()).unwrap_or_default();
            let v = value(e, &unit, width);
            RefittedParameter {
                name: e.name.clone(),
                before: e.nominal,
                after: e.value,
                std: v.std,
                interval: None,
                unit: v.unit,
            }
        })
        .collect()
}

fn cause(system: &System, search: &mut Search<'_>, findings: &Findings, member: usize, rivals: &Rivals) -> NamedCause {
    let effect = search.candidates[member].clone();
    let limits = search.settings;
    let chosen = &findings.chosen;
    let worth = worth(search, chosen, member, &findings.scatter, findings.tests);
    let p_value = worth.as_ref().map(|w| w.1);
    let share = worth.and_then(|(gained, _, rest)| {
        let excess = rest.alarm.excess();
        (excess > 0.0).then(|| (gained / excess).clamp(0.0, 1.0))
    });
    let estimates: Vec<&Estimate> = effect.coefficients.iter().filter_map(|c| chosen.fit.estimate(&c.name)).collect();
    let parameters = effect
        .coefficients
        .iter()
        .zip(&estimates)
        .map(|(c, e)| (c.name.clone(), value(e, &c.unit, findings.scatter.width())))
        .collect();
    let (name, mut flags) =
        physical_name(&effect, &estimates, findings.scatter.width(), limits.naming.near_no_friction);
    if name == Cause::ParameterJump {
        flags.extend(Jumped::of(&effect, &chosen.fit).map(|j| Flag::Jumped {
            name: j.name,
            from: j.from,
            to: j.to,
            at: j.at,
        }));
    }
    flags.extend(hold_delays(search, &effect, &estimates));
    flags.extend(chosen.stopped(limits.search.vanished).map(|p| Flag::ParameterAtLimit(p.to_owned())));
    let others: Vec<Rival> = rivals
        .iter()
        .map(|(candidate, explanation)| {
            let rival = &search.candidates[*candidate];
            let more = (explanation.square() - chosen.square()) / findings.scatter.unit();
            let closeness = if more.abs() < 0.5 {
                Closeness::Equal
            } else if more < 0.0 {
                Closeness::Better(-more)
            } else if more <= limits.rivals.margin {
                Closeness::Worse { by: more, margin: limits.rivals.margin }
            } else {
                Closeness::LittleMore
            };
            Rival { name: rival.cause, equation: rival.equation.clone(), term: rival.term.clone(), closeness }
        })
        .collect();
    let mut confusable_with: Vec<Cause> = Vec::new();
    for rival in &others {
        if rival.name != name && !confusable_with.contains(&rival.name) {
            confusable_with.push(rival.name);
        }
    }
    let separating = separating(system, search, &effect, name, rivals);
    NamedCause {
        name,
        equation: effect.equation.clone(),
        term: effect.term.clone(),
        parameters,
        p_value,
        confusable_with,
        separating_experiment: separating,
        rivals: others,
        share,
        flags,
        combination: None,
    }
}

/// Takes their names from causes that stand beside terms without a name, with structure remaining, and explain less than
/// the share `uncertain` of what is there without them: what the library lacks is then larger than they are, and they may be its image.
pub(super) fn withhold_uncertain(causes: &mut [NamedCause], uncertain: f64) {
    if causes.iter().all(|c| c.name != Cause::UnknownTerm) {
        return;
    }
    for cause in causes.iter_mut().filter(|c| c.name != Cause::UnknownTerm) {
        if cause.share.is_some_and(|share| share < uncertain) {
            cause.flags.push(Flag::SmallerThanUnknown(cause.name));
            cause.confusable_with.insert(0, cause.name);
            cause.name = Cause::UnknownTerm;
        }
    }
}

/// Takes their names from those of several causes that gain less than `least` and that the data do not tell from another kind.
/// Causes come in the order of what they `gained`.
pub(super) fn withhold_guesses(causes: &mut [NamedCause], gained: &[Option<f64>], least: f64) {
    if gained.len() < 2 {
        return;
    }
    for (gained, cause) in gained.iter().zip(causes) {
        let guessed = cause.name != Cause::UnknownTerm && !cause.confusable_with.is_empty();
        if guessed && gained.is_some_and(|gained| gained < least) {
            cause.flags.push(Flag::OneOfSeveralKinds(cause.name));
            cause.confusable_with.insert(0, cause.name);
            cause.name = Cause::UnknownTerm;
        }
    }
}

/// What to measure in order to tell a cause from each of its rivals of another name: one sentence for all of them, or one for each
/// group of rivals that the same experiment tells from it, with their names.
fn separating(system: &System, search: &Search<'_>, effect: &Effect, name: Cause, rivals: &Rivals) -> String {
    let mut experiments: Vec<(String, Vec<String>)> = Vec::new();
    for (c, _) in rivals {
        let rival = &search.candidates[*c];
        if rival.cause == name {
            continue;
        }
        let experiment = separating_experiment(effect, rival, system);
        let rival = rival.cause.to_string();
        match experiments.iter_mut().find(|(known, _)| *known == experiment) {
            Some((_, names)) if names.contains(&rival) => {}
            Some((_, names)) => names.push(rival),
            None => experiments.push((experiment, vec![rival])),
        }
    }
    match experiments.as_slice() {
        [(only, _)] => only.clone(),
        several => several.iter().map(|(e, names)| format!("{}: {e}", names.join(", "))).collect::<Vec<_>>().join("; "),
    }
}

/// A cause whose coefficient has the wrong sign loses its name, for a friction that drives is none; only Stribeck's effect
/// keeps it, for friction that rises from rest is found in real machines. Friction that may as well be none at rest is no dry
/// friction: something yields before it slips, or flows, which Stribeck's law does not describe. `width` is the factor by
/// which correlation widens standard deviations, `near` the number of them within which friction is none.
pub(super) fn physical_name(effect: &Effect, estimates: &[&Estimate], width: f64, near: f64) -> (Cause, Vec<Flag>) {
    let mut name = effect.cause;
    let mut flags = Vec::new();
    for (c, e) in effect.coefficients.iter().zip(estimates) {
        let moved = e.value - c.nominal;
        if effect.cause == Cause::StribeckFriction && c.role == Role::Amplitude && moved < 0.0 {
            if e.value - c.min < near * width * e.std {
                flags.push(Flag::NoFrictionAtRest(c.name.clone()));
                name = Cause::UnknownTerm;
            } else {
                flags.push(Flag::RisingFriction(c.name.clone()));
            }
        } else if f64::from(c.physical_sign) * moved < 0.0 {
            flags.push(Flag::Unphysical { name: c.name.clone(), above: c.physical_sign > 0, nominal: c.nominal });
            name = Cause::UnknownTerm;
        }
    }
    (name, flags)
}

/// What is to be added to a delay of held inputs for one who takes the logged value for the force at its instant.
fn hold_delays(search: &Search<'_>, effect: &Effect, estimates: &[&Estimate]) -> Option<Flag> {
    let Change::Path { path, .. } = &effect.change else { return None };
    let record = search.study.records().first()?;
    let delayed = matches!(path, Path::InputDelay | Path::ActuatorLag | Path::SensorDelay);
    if !delayed || !record.inputs.iter().any(|i| i.hold == Hold::Previous) {
        return None;
    }
    let half = 0.5 * (record.times.last()? - record.times.first()?) / (record.times.len() - 1) as f64;
    Some(Flag::BeyondHold { half, all: estimates.first()?.value + half })
}
