//! Terms of the model that may have the opposite sign.

use super::explanation::Explanation;
use super::search::{Search, started};
use crate::{Coefficient, Effect, Fit, Role};

impl Search<'_> {
    /// A term of the wrong sign and friction that is missing hide each other: without friction the best that a factor can do is to
    /// take the term out, and nothing is left then for friction to act on. Where an explanation has such a factor, these are the
    /// exact fits that start with the sign flipped and friction on the same equation. Where that cannot be simulated in all
    /// windows, a cause that was taken for what the two do is in the way: each of the others is then omitted.
    pub(crate) fn with_sign_flips(&mut self, current: &Explanation) -> Vec<Explanation> {
        // Initial states were fitted to the term that is nearly gone.
        let near = current.fit.without_windows();
        let mut fits = Vec::new();
        for (factor, flipped) in self.hidden(current) {
            let equation = self.candidates[factor].equation.clone();
            for candidate in 0..self.candidates.len() {
                let effect = &self.candidates[candidate];
                if current.members.contains(&candidate) || effect.equation != equation || !resists(effect) {
                    continue;
                }
                for mut start in starts(effect) {
                    start.push(flipped.clone());
                    let members: Vec<usize> = current.members.iter().copied().chain([candidate]).collect();
                    let effects: Vec<Effect> = members.iter().map(|&m| self.candidates[m].clone()).collect();
                    let first = self.study.fit(&effects, &self.windows, Some(&started(near.clone(), &start)));
                    let Ok(first) = first else { continue };
                    let initial = with_windows_of(first, &current.fit);
                    if let Some(found) = self.refit(members.clone(), &initial) {
                        fits.push(found);
                        continue;
                    }
                    for &other in current.members.iter().filter(|&&m| m != factor) {
                        let rest = members.iter().copied().filter(|&m| m != other).collect();
                        fits.extend(self.refit(rest, &initial));
                    }
                }
            }
        }
        fits
    }

    /// Factors of an explanation that leave little of their term: the member, its name and its value with the sign flipped.
    fn hidden(&self, explanation: &Explanation) -> Vec<(usize, (String, f64))> {
        let members = explanation.members.iter();
        let factors = members.flat_map(|&m| self.candidates[m].coefficients.iter().map(move |c| (m, c)));
        factors
            .filter_map(|(member, c)| {
                let flipped = c.sign_flipped?;
                let value = explanation.fit.estimate(&c.name)?.value;
                let gone = 0.5 * (c.nominal + flipped);
                ((value - gone).abs() < self.settings.search.little_left * (flipped - gone).abs())
                    .then(|| (member, (c.name.clone(), flipped)))
            })
            .collect()
    }
}

/// The fit with the windows of another one where its own could not be simulated from the guess of their initial state.
fn with_windows_of(mut fit: Fit, other: &Fit) -> Fit {
    for window in fit.windows.iter_mut().filter(|w| w.failure.is_some()) {
        if let Some(known) = other.windows.iter().find(|w| w.window == window.window) {
            *window = known.clone();
        }
    }
    fit
}

/// Whether all amplitudes of an effect are of a dissipation.
fn resists(effect: &Effect) -> bool {
    let amplitudes = effect.coefficients.iter().filter(|c| c.role == Role::Amplitude);
    let mut signs = amplitudes.map(|c| c.physical_sign).peekable();
    signs.peek().is_some() && signs.all(|s| s == 1)
}

/// Where a fit of a dissipation may start: typical amplitudes, shapes in the middle of what is tried and, since one start may lead
/// nowhere, at its first value.
fn starts(effect: &Effect) -> Vec<Vec<(String, f64)>> {
    let with = |shape: fn(&Coefficient) -> f64| {
        let value = |c: &Coefficient| if c.role == Role::Amplitude { c.nominal + c.scale } else { shape(c) };
        effect.coefficients.iter().map(|c| (c.name.clone(), value(c))).collect::<Vec<_>>()
    };
    let mut starts = vec![with(|c| c.nominal)];
    let other = with(|c| c.trials.first().copied().unwrap_or(c.nominal));
    if other != starts[0] {
        starts.push(other);
    }
    starts
}
