//! Changes during the run that are worth a search: where the refitted model falls short before and after some instant.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::explanation::Explanation;
use super::search::{Search, started};
use crate::library::{Jump, jumps};
use crate::settings::{DiagnosisSettings, JumpSettings};
use crate::{Coefficient, Column, DiagnoseError, Effect, Estimate, Fit, Linearization, Study};

/// Share of a column's response that must be left after the refitted parameters have taken what they can.
const LEAST_ANGLE: f64 = 1e-7;

/// Candidates for changes during the run.
#[derive(Default)]
pub(super) struct Changes {
    /// Each at instants to be tried, and the same change slowly.
    pub(super) effects: Vec<[Effect; 2]>,
    /// Instants at which changes were put against the data.
    pub(super) scanned: f64,
}

/// Changes that promise much beside a fit without effects.
///
/// The scan takes no simulation beside one linearization: what a change does at the start of a window is the response to the change from
/// the first sample on, in that window and in all later ones (Andrews 1993).
pub(super) fn promising(
    search: &Search<'_>,
    base: &Explanation,
    settings: &DiagnosisSettings,
) -> Result<Changes, DiagnoseError> {
    let limits = &settings.verdict.jumps;
    let (study, windows) = (search.study, &search.windows);
    let starts = starts(study, windows);
    let all = jumps(study.system(), study.parameters(), study.records(), &settings.library)?;
    let (Some(&first), true) = (starts.first(), starts.len() >= limits.fewest_windows) else {
        return Ok(Changes::default());
    };
    let from_the_start: Vec<Effect> = all.iter().map(|jump| at_times(&jump.sudden, vec![first - 1.0])).collect();
    let linearization = study.linearize(&base.fit, &from_the_start, windows)?;
    let mut best = scan(study, &linearization, &starts);
    let scanned = best.len() as f64 * (starts.len() - 1) as f64;
    best.retain(|found| found.gained >= limits.least_share * base.alarm.excess());
    best.sort_by(|a, b| b.gained.total_cmp(&a.gained));
    best.truncate(limits.most);
    let mut effects = Vec::new();
    for found in best {
        let Jump { sudden, slow } = &all[found.candidate];
        effects.push([at_times(sudden, found.times(&starts, limits)), slow.clone()]);
    }
    Ok(Changes { effects, scanned })
}

/// Times at which windows start, each once.
fn starts(study: &Study, windows: &[usize]) -> Vec<f64> {
    let mut starts: Vec<f64> = windows.iter().map(|&w| start(study, w)).collect();
    starts.sort_by(f64::total_cmp);
    starts.dedup();
    starts
}

fn start(study: &Study, window: usize) -> f64 {
    let window = study.windows()[window];
    study.records()[window.record].times[window.from]
}

/// The effect, to be tried at these times.
fn at_times(effect: &Effect, times: Vec<f64>) -> Effect {
    let mut effect = effect.clone();
    if let Some(time) = effect.coefficients.get_mut(1) {
        time.nominal = times[times.len() / 2];
        time.trials = times;
    }
    effect
}

/// The best instant of a candidate.
struct Found {
    candidate: usize,
    /// Place among the starts of windows.
    start: usize,
    /// Decrease of the sum of squares.
    gained: f64,
}

impl Found {
    /// Times in the window before the instant and in that after it.
    fn times(&self, starts: &[f64], limits: &JumpSettings) -> Vec<f64> {
        let middle = starts[self.start];
        let before = middle - starts[self.start - 1];
        let after = starts.get(self.start + 1).map_or(before, |next| next - middle);
        let n = limits.trials_per_window;
        let in_window = |from: f64, length: f64| (0..n).map(move |k| from + length * (k as f64 + 0.5) / n as f64);
        in_window(middle - before, before).chain(in_window(middle, after)).collect()
    }
}

/// For each candidate, the start of a window at which a change gains most, with all parameters at their best.
fn scan(study: &Study, linearization: &Linearization, starts: &[f64]) -> Vec<Found> {
    let Linearization { columns, prior, pull, windows, .. } = linearization;
    let base: Vec<usize> = (0..columns.len()).filter(|&c| !matches!(columns[c], Column::Candidate { .. })).collect();
    let nb = base.len();
    let mut gram = DMatrix::from_fn(nb, nb, |i, j| if i == j { prior[base[i]] } else { 0.0 });
    let mut gradient = DVector::from_fn(nb, |i, _| prior[base[i]] * pull[base[i]]);
    for window in windows {
        gram += DMatrix::from_fn(nb, nb, |i, j| window.gram[(base[i], base[j])]);
        gradient += DVector::from_fn(nb, |i, _| window.gradient[base[i]]);
    }
    let Some(cholesky) = Cholesky::new(gram) else { return Vec::new() };
    let step = cholesky.solve(&gradient);
    let mut found = Vec::new();
    for (place, column) in columns.iter().enumerate() {
        let &Column::Candidate { candidate, coefficient: 0, .. } = column else { continue };
        let best = (1..starts.len())
            .filter_map(|s| {
                let (mut own, mut slope, mut cross) = (0.0, 0.0, DVector::zeros(nb));
                for window in windows.iter().filter(|w| start(study, w.window) >= starts[s]) {
                    own += window.gram[(place, place)];
                    slope += window.gradient[place];
                    cross += DVector::from_fn(nb, |i, _| window.gram[(base[i], place)]);
                }
                let left = own - cross.dot(&cholesky.solve(&cross));
                let gained = (slope - cross.dot(&step)).powi(2) / left;
                (left > LEAST_ANGLE * own && gained.is_finite()).then_some(Found { candidate, start: s, gained })
            })
            .max_by(|a, b| a.gained.total_cmp(&b.gained));
        found.extend(best);
    }
    found
}

/// Explanations with changes at an instant, beside them those with the same changes slowly, and the better fits of the first that start
/// from these.
///
/// The sum of squares has many minima in the instant of a sudden change: only samples within one interval of it say in which direction it
/// moves. That of a slow change has few.
pub(super) fn with_slow_changes(search: &mut Search<'_>, tried: &[Explanation], spread: f64) -> Vec<Explanation> {
    let duration = spread * search.study.windows_used().seconds;
    let mut found = Vec::new();
    for explanation in tried {
        for [sudden, slow] in search.changes.clone() {
            if !explanation.members.contains(&sudden) {
                continue;
            }
            let [from, to] = [sudden, slow].map(|m| search.candidates[m].coefficients.clone());
            let value = |fit: &Fit, c: &Coefficient| fit.estimate(&c.name).map_or(c.nominal, |e| e.value);
            let carried = |fit: &Fit, from: &[Coefficient], to: &[Coefficient]| -> Vec<(String, f64)> {
                from.iter().zip(to).take(2).map(|(from, to)| (to.name.clone(), value(fit, from))).collect()
            };
            let mut start = carried(&explanation.fit, &from, &to);
            start.extend(to.get(2).map(|c| (c.name.clone(), duration)));
            let members = explanation.members.iter().map(|&m| if m == sudden { slow } else { m }).collect();
            let Some(slower) = search.refit(members, &started(explanation.fit.clone(), &start)) else { continue };
            let start = started(slower.fit.clone(), &carried(&slower.fit, &to, &from));
            found.extend(search.refit(explanation.members.clone(), &start));
            found.push(slower);
        }
    }
    found
}

/// What has changed, from which value to which, and when: the name of a parameter of the model, or of the change itself.
pub(super) struct Jumped {
    pub(super) name: String,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) at: f64,
}

impl Jumped {
    /// Of an effect in a fit.
    pub(super) fn of(effect: &Effect, fit: &Fit) -> Option<Self> {
        let [change, time] = &effect.coefficients[..] else { return None };
        let [change, time] = [change, time].map(|c| fit.estimate(&c.name));
        let (change, at) = (change?, time?.value);
        let of_model = |e: &&Estimate| e.name != change.name && change.name == format!("jump_{}", e.name);
        let before = fit.values.iter().find(of_model);
        let from = before.map_or(0.0, |e| e.value);
        let name = before.map_or(change.name.clone(), |e| e.name.clone());
        Some(Self { name, from, to: from + change.value, at })
    }
}
