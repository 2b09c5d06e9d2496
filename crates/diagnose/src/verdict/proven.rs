//! What a cause must be worth to be named.

use super::explanation::Explanation;
use super::noise::Scatter;
use super::search::Search;
use crate::report::{Caveat, Doubt, Excess, Note, Outcome, Report, SmallGain, Verdict};
use crate::settings::{DiagnosisSettings, NamingSettings};
use crate::{Cause, Effect, Role};

/// Improvement by a member of an explanation: decrease of the sum of squares and its p-value, corrected for the number of
/// `tests`; `None` where the explanation without it cannot be fitted.
pub(super) fn worth(
    search: &mut Search<'_>,
    chosen: &Explanation,
    member: usize,
    scatter: &Scatter,
    tests: f64,
) -> Option<(f64, f64, Explanation)> {
    let rest = search.without(chosen, member)?;
    let gained = rest.square() - chosen.square();
    let p_value = scatter.p_value(gained, search.numbers(member)) * tests;
    Some((gained, p_value.min(1.0), rest))
}

/// Takes out, one after the other, causes that are not significant or none of whose amplitudes exceeds its standard
/// deviation, twice that where structure remains, first the one that gains least; says whether there were any.
pub(super) fn drop_unproven(
    search: &mut Search<'_>,
    chosen: &mut Explanation,
    scatter: &Scatter,
    tests: f64,
    settings: &DiagnosisSettings,
) -> bool {
    let mut dropped = false;
    loop {
        let mut least: Option<(f64, Explanation)> = None;
        search.without_each(chosen);
        for member in chosen.members.clone() {
            let Some((gained, p_value, rest)) = worth(search, chosen, member, scatter, tests) else { continue };
            let times = if chosen.alarm.p_value < settings.significance { settings.verdict.naming.sure } else { 1.0 };
            let sizeable = sizeable(&search.candidates[member], chosen, times, scatter);
            let proven = p_value < settings.significance && sizeable;
            if !proven && least.as_ref().is_none_or(|l| gained < l.0) {
                least = Some((gained, rest));
            }
        }
        let Some((_, rest)) = least else { return dropped };
        *chosen = rest;
        dropped = true;
    }
}

/// Whether some amplitude of an effect exceeds its standard deviation so many `times`.
fn sizeable(effect: &Effect, explanation: &Explanation, times: f64, scatter: &Scatter) -> bool {
    let width = times * scatter.width();
    effect.coefficients.iter().filter(|c| c.role == Role::Amplitude).any(|c| {
        let estimate = explanation.fit.estimate(&c.name);
        estimate.is_some_and(|e| (e.value - c.nominal).abs() > width * e.std)
    })
}

impl Report {
    /// Takes the causes back if with them data that played no part in the fit are predicted no better at the longest horizon, or no better
    /// than by a constant; takes their names where structure remains and the improvement is small, or there is another reason to doubt them.
    pub(super) fn weigh_gain(&mut self, limits: &NamingSettings) {
        if !self.verdict.extends_the_model() {
            return;
        }
        let small = self.gain.as_ref().filter(|gain| gain.held_out).and_then(|gain| {
            let [refitted, given, after] = [&gain.before, &gain.as_given, &gain.after].map(|list| list.last().copied());
            Some(SmallGain { horizon: *gain.horizons_s.last()?, before: refitted?.min(given?), after: after? })
        });
        if let Some(small @ SmallGain { before, after, .. }) = small
            && !(after < (1.0 - limits.least_gain) * before && after < 1.0)
        {
            let causes = self.causes.iter().map(|c| c.name).collect();
            self.reason.outcome = Outcome::NoGain { causes, gain: small };
            self.withdraw();
            self.verdict = Verdict::NoGain;
            return;
        }
        if !matches!(self.reason.outcome, Outcome::PartlyExplained { .. }) {
            return;
        }
        let little = small.filter(|gain| gain.after > (1.0 - limits.clear_gain) * gain.before);
        let Some(caveat) = little.map(Caveat::SmallGain).or_else(|| self.doubt(limits).map(Caveat::Doubtful)) else {
            return;
        };
        for cause in self.causes.iter_mut().filter(|c| c.name != Cause::UnknownTerm) {
            cause.confusable_with.insert(0, cause.name);
            cause.name = Cause::UnknownTerm;
        }
        self.reason.caveats.push(caveat);
        self.verdict = Verdict::PartlyExplained;
    }

    /// A reason to doubt causes that leave structure.
    fn doubt(&self, limits: &NamingSettings) -> Option<Doubt> {
        if let Outcome::PartlyExplained { share, .. } = self.reason.outcome
            && share < limits.clear_share
        {
            return Some(Doubt::Share(share));
        }
        if let Some(Excess { refitted: before, extended: Some(after), .. }) = self.excess
            && after >= before
        {
            return Some(Doubt::Noise { before, after });
        }
        if let Some(gain) = &self.gain
            && let (Some(before), Some(after)) = (gain.equation_error_before, gain.equation_error_after)
            && after > limits.most_force_error * before
        {
            return Some(Doubt::ForceError { before, after });
        }
        let of_a_cause = |name: &str| self.causes.iter().any(|c| c.parameters.0.iter().any(|(n, _)| n == name));
        self.notes.iter().find_map(|note| match note {
            Note::AtLimit { name, without_causes: false, .. } if of_a_cause(name) => Some(Doubt::AtLimit(name.clone())),
            _ => None,
        })
    }

    /// Takes the causes back, and what was made with them.
    pub(super) fn withdraw(&mut self) {
        self.causes.clear();
        self.verdict = Verdict::Unexplained;
        self.gain = None;
        self.candidates.iter_mut().for_each(|c| c.chosen = false);
        if let Some(excess) = &mut self.excess {
            excess.extended = None;
        }
        self.notes.retain(|note| !matches!(note, Note::ExtendedModel(_)));
        self.evidence.extended = None;
        self.evidence.model = None;
        self.evidence.rivals.clear();
        self.evidence.held_out = None;
    }
}
