//! Terms of the model that may have the opposite sign.

use super::search::{Explanation, Search, begun};
use crate::{Coefficient, Fit, Role};

/// A term of which less than this part is left hides its sign: there is little for friction to resist.
const LITTLE: f64 = 0.5;

impl Search<'_> {
    /// A term of the wrong sign and friction that is missing hide each other: without friction the best that a factor can do is to
    /// take the term out, and nothing is left then for friction to act on. Where an explanation has such a factor, these are the
    /// exact fits that begin with the term turned round and friction on the same equation.
    pub(crate) fn with_turned_terms(&mut self, current: &Explanation) -> Vec<Explanation> {
        let hidden: Vec<(String, &Coefficient, f64)> = current
            .members
            .iter()
            .flat_map(|&m| self.candidates[m].coefficients.iter().map(move |c| (m, c)))
            .filter_map(|(m, c)| {
                let turned = c.turned?;
                let value = current.fit.values.iter().find(|e| e.name == c.name)?.value;
                let middle = 0.5 * (c.nominal + turned);
                ((value - middle).abs() < LITTLE * (turned - middle).abs())
                    .then(|| (self.candidates[m].equation.clone(), c, turned))
            })
            .collect();
        let begins: Vec<(usize, Vec<(String, f64)>)> = hidden
            .iter()
            .flat_map(|(equation, factor, turned)| {
                let others = (0..self.candidates.len()).filter(|m| !current.members.contains(m));
                others.filter(|&m| self.candidates[m].equation == *equation && self.resists(m)).map(|m| {
                    let mut values = vec![(factor.name.clone(), *turned)];
                    values.extend(self.candidates[m].coefficients.iter().map(|c| (c.name.clone(), first(c))));
                    (m, values)
                })
            })
            .collect();
        begins
            .into_iter()
            .filter_map(|(member, values)| {
                // Initial states were fitted to the term that is nearly gone.
                let near = Fit { windows: Vec::new(), ..current.fit.clone() };
                let members = current.members.iter().copied().chain([member]).collect();
                self.again(members, &begun(near, &values))
            })
            .collect()
    }

    /// Whether all amplitudes of a candidate are of a dissipation.
    fn resists(&self, candidate: usize) -> bool {
        let amplitudes = self.candidates[candidate].coefficients.iter().filter(|c| c.role == Role::Amplitude);
        let mut signs = amplitudes.map(|c| c.physical_sign).peekable();
        signs.peek().is_some() && signs.all(|s| s == 1)
    }
}

/// A first value of a coefficient.
fn first(c: &Coefficient) -> f64 {
    if c.role == Role::Amplitude { c.nominal + c.scale } else { c.nominal }
}
