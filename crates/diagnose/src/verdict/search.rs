//! Exact fits of sets of candidates, and which to make.

use bracketry_numerics::statistics::extremes;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::alarm::Alarm;
use super::explanation::{Explanation, Promise};
use super::score::{Group, Scores, Sums};
use crate::settings::VerdictSettings;
use crate::{Cause, Change, Column, DiagnoseError, Effect, Estimate, Fit, Linearization, Normal, Path, Role, Study};

/// What a pair of groups gains, the groups' places, and the step.
type PairGain = (f64, usize, usize, DVector<f64>);

/// Fits sets of candidates and keeps what was fitted.
pub(crate) struct Search<'a> {
    pub(crate) study: &'a Study,
    pub(crate) candidates: Vec<Effect>,
    pub(crate) windows: Vec<usize>,
    pub(super) settings: &'a VerdictSettings,
    /// Places of changes at an instant, with those of the same changes slowly.
    pub(super) changes: Vec<[usize; 2]>,
    /// Instants at which changes were put against the data, beside the candidates.
    pub(super) scanned: f64,
    /// Initial values per window.
    initial: usize,
    known: HashMap<Vec<usize>, Option<Explanation>>,
    /// From where sets were fitted: another fit from there would be the same.
    started: HashSet<Start>,
    linearized: HashMap<Vec<usize>, Arc<Linearized>>,
}

/// A set, and the values from which it was fitted, by their bits.
type Start = (Vec<usize>, Vec<u64>);

/// A set of candidates to be fitted, and the values from which those that are new start.
pub(crate) struct Wanted {
    pub(crate) members: Vec<usize>,
    pub(crate) start: Vec<(String, f64)>,
}

/// The linearized problem around an explanation.
pub(crate) struct Linearized {
    /// The problem.
    linearization: Linearization,
    /// Its candidates' share.
    pub(crate) scores: Scores,
    /// Candidates in it, by place in the list of all.
    others: Vec<usize>,
}

impl<'a> Search<'a> {
    /// Fits will be made over `windows` of the study.
    pub(crate) fn new(
        study: &'a Study,
        candidates: Vec<Effect>,
        windows: Vec<usize>,
        settings: &'a VerdictSettings,
    ) -> Self {
        let initial = study.system().states.len();
        Self {
            study,
            candidates,
            windows,
            settings,
            changes: Vec::new(),
            scanned: 0.0,
            initial,
            known: HashMap::new(),
            started: HashSet::new(),
            linearized: HashMap::new(),
        }
    }

    /// Adds candidates; returns their places.
    pub(crate) fn extend(&mut self, more: Vec<Effect>) -> Vec<usize> {
        let from = self.candidates.len();
        self.candidates.extend(more);
        (from..self.candidates.len()).collect()
    }

    /// The model with nothing added, from its fit.
    pub(crate) fn nothing(&mut self, fit: Fit) -> Explanation {
        let explanation = self.judge(Vec::new(), fit);
        self.known.insert(Vec::new(), Some(explanation.clone()));
        explanation
    }

    /// All sets fitted so far.
    pub(crate) fn fitted(&self) -> impl Iterator<Item = &Explanation> {
        self.known.values().flatten()
    }

    /// The exact fit of `members`, started from `near` and the given values; `None` where it cannot be made.
    pub(crate) fn explain(&mut self, members: &[usize], near: &Fit, start: &[(String, f64)]) -> Option<Explanation> {
        let start = start.to_vec();
        self.explain_all(near, &[Wanted { members: members.to_vec(), start }]).pop().flatten()
    }

    /// Whether the time of the search is over: no more fits are made.
    pub(crate) fn is_over(&self) -> bool {
        self.study.counter().is_over()
    }

    /// As [`Self::explain`] of several sets from one fit, side by side.
    pub(crate) fn explain_all(&mut self, near: &Fit, attempts: &[Wanted]) -> Vec<Option<Explanation>> {
        let mut new: Vec<(Vec<usize>, &Wanted)> = Vec::new();
        for attempt in attempts {
            let key = sorted(&attempt.members);
            if !self.known.contains_key(&key) && new.iter().all(|(other, _)| *other != key) {
                new.push((key, attempt));
            }
        }
        if self.is_over() {
            self.study.counter().leave_out(new.len());
            new.clear();
        }
        let this = &*self;
        let found: Vec<Option<Explanation>> =
            new.par_iter().map(|(_, attempt)| this.exact_fit(&attempt.members, near, &attempt.start)).collect();
        for ((key, wanted), found) in new.into_iter().zip(found) {
            if wanted.start.is_empty() {
                self.started.insert((key.clone(), bits(near)));
            }
            self.known.insert(key, found);
        }
        attempts.iter().map(|attempt| self.known.get(&sorted(&attempt.members)).cloned().flatten()).collect()
    }

    /// The best exact fit of `members` from the given values, and from parameters back at their nominal values.
    fn exact_fit(&self, members: &[usize], near: &Fit, start: &[(String, f64)]) -> Option<Explanation> {
        let effects: Vec<Effect> = members.iter().map(|&m| self.candidates[m].clone()).collect();
        let initial = started(near.clone(), start);
        let parameters = self.study.parameters().len();
        let refitted = returned(&initial, parameters, &effects, self.settings.search.far_parameter)
            .and_then(|b| self.study.fit(&effects, &self.windows, Some(&b)).ok());
        self.fit_from(&effects, initial, near, start)
            .into_iter()
            .chain(refitted)
            .map(|fit| self.judge(members.to_vec(), fit))
            .filter(|e| self.admissible(e))
            .min_by(|a, b| a.square().total_cmp(&b.square()))
    }

    /// Fits the explanation without each of its members in turn, side by side, for [`Self::without`].
    pub(crate) fn without_each(&mut self, explanation: &Explanation) {
        let rest = |&member: &usize| Wanted {
            members: explanation.members.iter().copied().filter(|&m| m != member).collect(),
            start: Vec::new(),
        };
        let attempts: Vec<Wanted> = explanation.members.iter().map(rest).collect();
        self.explain_all(&explanation.fit, &attempts);
    }

    /// The explanation without one of its members. Where that costs far more than the member's amplitude can, the fit without it
    /// came from elsewhere and has stopped short: it is refitted from here.
    pub(crate) fn without(&mut self, explanation: &Explanation, member: usize) -> Option<Explanation> {
        let rest: Vec<usize> = explanation.members.iter().copied().filter(|&m| m != member).collect();
        let found = self.explain(&rest, &explanation.fit, &[])?;
        let gained = found.square() - explanation.square();
        let unit = explanation.alarm.square / explanation.alarm.freedom;
        let expected = explanation.expected_cost(&self.candidates[member]);
        let gained = gained / unit.max(1.0);
        let VerdictSettings { search, rivals, .. } = self.settings;
        if gained < rivals.margin || expected > search.uncertain || gained < search.stopped_short * expected {
            return Some(found);
        }
        self.refit(rest, &explanation.fit)
    }

    /// The exact fit of `members` started from `initial`, or what is known of them already if that is better.
    pub(crate) fn refit(&mut self, mut members: Vec<usize>, initial: &Fit) -> Option<Explanation> {
        let key = sorted(&members);
        if !self.started.insert((key.clone(), bits(initial))) {
            return self.known.get(&key).cloned().flatten();
        }
        if self.is_over() {
            self.study.counter().leave_out(1);
            return self.known.get(&key).cloned().flatten();
        }
        let effects: Vec<Effect> = members.iter().map(|&m| self.candidates[m].clone()).collect();
        let fit = self.study.fit(&effects, &self.windows, Some(initial)).ok();
        let found = fit.map(|fit| self.judge(members.clone(), fit)).filter(|e| self.admissible(e));
        members.sort_unstable();
        let known = self.known.get(&members).cloned().flatten();
        match (found, known) {
            (Some(found), known) if known.as_ref().is_none_or(|k| found.square() < k.square()) => {
                self.linearized.remove(&members);
                self.known.insert(members, Some(found.clone()));
                Some(found)
            }
            (_, known) => known,
        }
    }

    /// The model with nothing added, from the best fit of it so far.
    pub(crate) fn base(&self) -> Option<&Explanation> {
        self.known.get(&Vec::new())?.as_ref()
    }

    /// The fit of `effects` from `initial`. What has more coefficients than `near` can leave no larger residual: where it does, the
    /// values that were added (`start`) mislead, and the fit restarts with smaller amplitudes.
    fn fit_from(&self, effects: &[Effect], mut initial: Fit, near: &Fit, start: &[(String, f64)]) -> Option<Fit> {
        // Above the residual of `near` there is nothing to be found.
        let reach =
            if start.is_empty() || near.windows.len() < self.windows.len() { f64::INFINITY } else { near.square() };
        let fit = |initial: &Fit| self.study.fit_toward(effects, &self.windows, initial, reach).ok();
        let mut best = fit(&initial);
        for _ in 0..self.settings.search.most_returns {
            let astray = best.as_ref().is_none_or(|fit| fit.square() > near.square());
            if start.is_empty() || !astray {
                break;
            }
            let amplitudes = effects.iter().flat_map(|e| &e.coefficients).filter(|c| c.role == Role::Amplitude);
            for c in amplitudes.filter(|c| start.iter().any(|(name, _)| *name == c.name)) {
                for e in initial.values.iter_mut().filter(|e| e.name == c.name) {
                    e.value = c.nominal + self.settings.search.nearer * (e.value - c.nominal);
                }
            }
            let refitted = fit(&initial);
            if refitted.as_ref().is_some_and(|a| best.as_ref().is_none_or(|b| a.square() < b.square())) {
                best = refitted;
            }
        }
        best
    }

    fn admissible(&self, explanation: &Explanation) -> bool {
        self.comparable(explanation) && self.biases_within_range(explanation) && self.hidden_within_limits(explanation)
    }

    /// Whether no hidden mass stops at a limit of its inertia or its frequency: a mass that is too large to move, or whose oscillation is
    /// longer than a window, is a spring to the ground.
    fn hidden_within_limits(&self, explanation: &Explanation) -> bool {
        let hidden = explanation.members.iter().map(|&m| &self.candidates[m]).filter(|e| !e.hidden().is_empty());
        hidden.flat_map(|e| &e.coefficients).filter(|c| !c.trials.is_empty()).all(|c| {
            let value = explanation.fit.estimate(&c.name).map_or(c.nominal, |e| e.value);
            c.min < value && value < c.max
        })
    }

    /// Whether the fit covers the windows that the model without effects covers.
    fn comparable(&self, explanation: &Explanation) -> bool {
        let Some(Some(base)) = self.known.get(&Vec::new()) else { return true };
        explanation.square().is_finite()
            && base.fit.windows.iter().zip(&explanation.fit.windows).all(|(b, e)| b.count == 0 || e.count == b.count)
    }

    /// Whether no sensor is said to be off by more than the range of what it shows.
    fn biases_within_range(&self, explanation: &Explanation) -> bool {
        explanation.members.iter().map(|&m| &self.candidates[m]).all(|effect| {
            let Change::Path { path: Path::SensorBias, signals } = &effect.change else { return true };
            let range = signals.iter().map(|s| self.range(s)).fold(0.0, f64::max);
            effect.coefficients.iter().all(|c| explanation.fit.estimate(&c.name).is_none_or(|e| e.value.abs() <= range))
        })
    }

    /// Largest minus smallest value of a measured column over all records.
    fn range(&self, column: &str) -> f64 {
        let columns = self.study.records().iter().flat_map(|r| &r.measured).filter(|m| m.name == column);
        let values = columns.flat_map(|m| &m.values).copied().filter(|v| v.is_finite());
        let (low, high) = extremes(values);
        high - low
    }

    /// Judges a fit by its residuals, which are not kept: nothing reads them again.
    fn judge(&self, members: Vec<usize>, mut fit: Fit) -> Explanation {
        let alarm = Alarm::of(&fit.windows, self.initial + fit.hidden_states(), fit.values.len(), &self.settings.alarm);
        fit.windows.iter_mut().for_each(|window| window.residuals = Vec::new());
        let coefficients = members.iter().map(|&m| self.candidates[m].coefficients.len()).sum();
        let physical = members.iter().all(|&m| {
            self.candidates[m].coefficients.iter().all(|c| {
                let value = fit.estimate(&c.name).map_or(c.nominal, |e| e.value);
                f64::from(c.physical_sign) * (value - c.nominal) >= 0.0
            })
        });
        Explanation { members, fit, alarm, coefficients, physical }
    }

    /// The linearized problem around an explanation with those `among` the candidates that are not in it.
    pub(crate) fn linearized(
        &mut self,
        explanation: &Explanation,
        among: &[usize],
    ) -> Result<Arc<Linearized>, DiagnoseError> {
        let beside = |c: usize| explanation.members.iter().all(|&m| m != c && !self.same([m, c]));
        let others: Vec<usize> = among.iter().copied().filter(|&c| beside(c)).collect();
        let mut key = explanation.members.clone();
        key.sort_unstable();
        if let Some(linearized) = self.linearized.get(&key).filter(|a| a.others == others) {
            return Ok(Arc::clone(linearized));
        }
        let linearized = Arc::new(self.linearize(explanation, others, &self.windows)?);
        self.linearized.insert(key, Arc::clone(&linearized));
        Ok(linearized)
    }

    /// The problem over some windows, which are added up one after the other.
    pub(super) fn linearize(
        &self,
        explanation: &Explanation,
        others: Vec<usize>,
        windows: &[usize],
    ) -> Result<Linearized, DiagnoseError> {
        let effects: Vec<Effect> = others.iter().map(|&c| self.candidates[c].clone()).collect();
        let mut sums = Sums::default();
        let add = |columns: &[Column], normal: Normal| sums.add(columns, &normal);
        let linearization = self.study.linearize_each(&explanation.fit, &effects, windows, add)?;
        let scores = sums.scores(&linearization);
        Ok(Linearized { linearization, scores, others })
    }

    /// Those of `among` that promise most on a quarter of the windows, at most `count`.
    pub(crate) fn shortlist(
        &self,
        explanation: &Explanation,
        among: &[usize],
        count: usize,
    ) -> Result<Vec<usize>, DiagnoseError> {
        if among.len() <= count {
            return Ok(among.to_vec());
        }
        let windows: Vec<usize> = self.windows.iter().copied().step_by(4).collect();
        let linearized = self.linearize(explanation, among.to_vec(), &windows)?;
        Ok(self.singles(&linearized).iter().take(count).map(|p| p.candidates[0]).collect())
    }

    /// What each candidate alone promises at its best trial, the best first.
    pub(crate) fn singles(&self, linearized: &Linearized) -> Vec<Promise> {
        let Linearized { linearization, scores, others } = linearized;
        let mut best: Vec<Option<(f64, &Group, DVector<f64>)>> = vec![None; others.len()];
        for group in &scores.groups {
            let effect = &self.candidates[others[group.candidate]];
            let gained = scores.gain_with_signs(&group.columns, &signs(effect, group));
            let slot = &mut best[group.candidate];
            if slot.as_ref().is_none_or(|s| gained.square > s.0) {
                *slot = Some((gained.square, group, gained.step));
            }
        }
        let mut promises: Vec<Promise> = best
            .into_iter()
            .flatten()
            .map(|(square, group, step)| {
                let effect = &self.candidates[others[group.candidate]];
                Promise {
                    candidates: vec![others[group.candidate]],
                    square,
                    coefficients: effect.coefficients.len(),
                    start: start(
                        effect,
                        linearization,
                        scores,
                        (group, step.as_slice()),
                        self.settings.search.farthest,
                    ),
                }
            })
            .collect();
        promises.sort_by(|a, b| b.square.total_cmp(&a.square));
        promises
    }

    /// Numbers that are fitted for a candidate, see [`Explanation::numbers`].
    pub(super) fn numbers(&self, candidate: usize) -> usize {
        let effect = &self.candidates[candidate];
        effect.coefficients.len() + effect.hidden().len() * self.windows.len()
    }

    /// Whether both are filters of the same columns, or changes of the same parameter: one stands for the other.
    fn same(&self, pair: [usize; 2]) -> bool {
        let [a, b] = pair.map(|c| &self.candidates[c]);
        let filters = a.is_filter() && b.is_filter() && a.equation == b.equation;
        filters || self.changes.iter().any(|change| pair.iter().all(|c| change.contains(c)))
    }

    /// What pairs of candidates promise at their best trials, the best first; `most` of them.
    pub(crate) fn pairs(&self, linearized: &Linearized, most: usize) -> Vec<Promise> {
        let Linearized { linearization, scores, others } = linearized;
        let n = others.len();
        let mut best: Vec<Option<PairGain>> = vec![None; n * n];
        for (i, a) in scores.groups.iter().enumerate() {
            for (j, b) in scores.groups.iter().enumerate() {
                if a.candidate >= b.candidate || self.same([a.candidate, b.candidate].map(|c| others[c])) {
                    continue;
                }
                let columns: Vec<usize> = a.columns.iter().chain(&b.columns).copied().collect();
                if columns.iter().any(|&c| !scores.identifiable(c)) {
                    continue;
                }
                let mut wanted = signs(&self.candidates[others[a.candidate]], a);
                wanted.extend(signs(&self.candidates[others[b.candidate]], b));
                let gained = scores.gain_with_signs(&columns, &wanted);
                let slot = &mut best[a.candidate * n + b.candidate];
                if slot.as_ref().is_none_or(|s| gained.square > s.0) {
                    *slot = Some((gained.square, i, j, gained.step));
                }
            }
        }
        let mut found: Vec<_> = best.into_iter().flatten().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(most);
        found
            .into_iter()
            .map(|(square, i, j, step)| {
                let (a, b) = (&scores.groups[i], &scores.groups[j]);
                let (first, second) = (&self.candidates[others[a.candidate]], &self.candidates[others[b.candidate]]);
                let (for_a, for_b) = step.as_slice().split_at(a.columns.len());
                let reach = self.settings.search.farthest;
                let mut initial = start(first, linearization, scores, (a, for_a), reach);
                initial.extend(start(second, linearization, scores, (b, for_b), reach));
                Promise {
                    candidates: vec![others[a.candidate], others[b.candidate]],
                    square,
                    coefficients: first.coefficients.len() + second.coefficients.len(),
                    start: initial,
                }
            })
            .collect()
    }
}

/// The values of a fit, bit by bit.
fn bits(fit: &Fit) -> Vec<u64> {
    fit.values.iter().map(|e| e.value.to_bits()).collect()
}

/// The name under which a set is known.
fn sorted(members: &[usize]) -> Vec<usize> {
    let mut key = members.to_vec();
    key.sort_unstable();
    key
}

/// The fit with other values, or more of them, to start from.
pub(crate) fn started(mut near: Fit, start: &[(String, f64)]) -> Fit {
    for (name, value) in start {
        match near.values.iter_mut().find(|e| e.name == *name) {
            Some(estimate) => estimate.value = *value,
            None => near.values.push(Estimate { name: name.clone(), nominal: *value, value: *value, std: 0.0 }),
        }
    }
    near
}

/// The fit with those of its first values, the parameters, back at their nominal values that another explanation has driven away from
/// them by more than the share `far`; `None` if there are none. From where they went (a radius that vanishes) there may be no slope
/// back.
fn returned(initial: &Fit, parameters: usize, effects: &[Effect], far: f64) -> Option<Fit> {
    let mut back = initial.clone();
    let own = |name: &str| effects.iter().flat_map(|e| &e.coefficients).all(|c| c.name != name);
    let parameters = back.values.iter_mut().take(parameters);
    let moved = parameters.filter(|e| own(&e.name) && (e.value - e.nominal).abs() > far * e.nominal.abs());
    let moved = moved.map(|e| e.value = e.nominal).count();
    (moved > 0).then_some(back)
}

/// Signs that amplitudes must have. Friction that rises from rest is found in real machines, so that the sign of Stribeck's
/// effect is flagged rather than enforced.
fn signs(effect: &Effect, group: &Group) -> Vec<i8> {
    if effect.cause == Cause::StribeckFriction {
        return vec![0; group.columns.len()];
    }
    group.coefficients.iter().map(|&c| effect.coefficients[c].physical_sign).collect()
}

/// Values of an effect's coefficients after a step from the linearized problem, at most `farthest` times the secant.
fn start(
    effect: &Effect,
    linearization: &Linearization,
    scores: &Scores,
    (group, step): (&Group, &[f64]),
    farthest: f64,
) -> Vec<(String, f64)> {
    let at = linearization.trials.get(group.candidate).and_then(|t| t.get(group.trial));
    effect
        .coefficients
        .iter()
        .enumerate()
        .map(|(i, c)| {
            let tried = at.and_then(|values| values.get(i)).copied().unwrap_or(c.nominal);
            let value = match (c.role, group.coefficients.iter().position(|&k| k == i)) {
                (Role::Amplitude, Some(place)) => {
                    let moved = step[place] * linearization.scales[scores.columns[group.columns[place]]];
                    let reach = farthest * (tried - c.nominal).abs();
                    c.nominal + if c.trials.is_empty() || reach == 0.0 { moved } else { moved.clamp(-reach, reach) }
                }
                _ => tried,
            };
            (c.name.clone(), value.clamp(c.min, c.max))
        })
        .collect()
}
