//! Bounds that hold with a probability: `noise` and `confidence` in `[uncertainty]`, `probability` of a constraint.

use super::reader::{Located, Parsed, Reader};
use crate::deviations::Deviations;
use crate::dynamics::SymbolicDynamics;
use crate::ocp::{Bounds, Ocp, Softness};
use crate::problem::{ChanceMargin, ChanceReport, MarginFeedback, ProblemError};
use bracketry_system::{Table, Value};
use statrs::distribution::{ContinuousCDF, Normal};
use std::ops::Range;

/// A constraint of the file with a probability.
struct Chance<'t, 'i> {
    name: String,
    place: Located<'t, 'i>,
    probability: f64,
    /// The state that it bounds.
    state: Option<usize>,
    /// The path constraints that it became.
    path: Range<usize>,
}

impl Reader<'_> {
    /// Puts the margins of bounds that hold with a probability into the problem; `live` are the live parameters of the model,
    /// `names` the references, `start` state and input where it is linearized if the model has no point.
    pub(super) fn chance(
        &self,
        table: &Table<'_>,
        names: &[String],
        live: &[String],
        start: (&[f64], &[f64]),
        ocp: &mut Ocp,
    ) -> Result<Option<ChanceReport>, ProblemError> {
        let uncertainty = self.doc.sub_table(table, "uncertainty")?;
        let noise = uncertainty.and_then(|t| t.get("noise"));
        let chances = self.chances(table, uncertainty, names, ocp)?;
        let Some(noise) = noise else {
            let Some(first) = chances.first() else { return Ok(None) };
            let message = format!("`{}` has a probability, but nothing is random", first.name);
            let remedy = "add noise to [uncertainty]: noise = { v = 0.1 }, per square root of a second";
            return Err(self.doc.error(first.place.span(), message, remedy).into());
        };
        if chances.is_empty() {
            let message = "no soft bound of a state has a probability: the noise changes nothing";
            let remedy = "add confidence = 0.95 to [uncertainty], or probability = 0.95 to a soft bound";
            return Err(self.doc.error(noise.span(), message, remedy).into());
        }
        self.same_lengths(self.required(table, "horizon", "[horizon]")?, ocp, true, "noise on the states")?;
        let deviations = self.state_noise(noise)?;
        let live: Vec<&str> = live.iter().map(String::as_str).collect();
        let mut dynamics = SymbolicDynamics::with_live_parameters(self.system, &live)?;
        let (mut x, u) = self.system.point_values().unwrap_or_else(|| (start.0.to_vec(), start.1.to_vec()));
        ocp.append_previous(&mut x, &u);
        let deviations = ocp.deviations(&mut dynamics, (&x, &u), &deviations);
        let deviations = deviations.map_err(|e| {
            self.doc.error(noise.span(), e.to_string(), "give the model a [point], or remove the noise")
        })?;
        let mut margins = Vec::new();
        for chance in &chances {
            margins.push(self.margin(chance, &deviations, (&x, &u), ocp)?);
        }
        let feedback = if deviations.feedback { MarginFeedback::Riccati } else { MarginFeedback::OpenLoop };
        Ok(Some(ChanceReport { feedback, margins }))
    }

    /// Standard deviation of the noise on every state.
    fn state_noise(&self, v: Located<'_, '_>) -> Parsed<Vec<f64>> {
        let Value::Table(t) = v.get_ref() else {
            let remedy = "write noise = { v = 0.1 }, per square root of a second";
            return Err(self.doc.error(v.span(), "`noise` must be a table", remedy).into());
        };
        let mut noise = vec![0.0; self.system.states.len()];
        for key in t.keys() {
            let i = self.state(key.get_ref(), key.span())?;
            noise[i] = self.not_negative(t, key.get_ref(), 0.0)?;
        }
        if noise.iter().all(|s| *s == 0.0) {
            let remedy = "give a state a positive standard deviation, or remove it";
            return Err(self.doc.error(v.span(), "there is no noise", remedy).into());
        }
        Ok(noise)
    }

    /// The soft constraints on states that have a probability.
    fn chances<'t, 'i>(
        &self,
        table: &'t Table<'i>,
        uncertainty: Option<&'t Table<'i>>,
        names: &[String],
        ocp: &Ocp,
    ) -> Result<Vec<Chance<'t, 'i>>, ProblemError> {
        let all = uncertainty.and_then(|t| t.get("confidence"));
        let all = all.map(|v| self.probability(v, "confidence")).transpose()?;
        let mut chances = Vec::new();
        let mut counted = ocp.clone();
        counted.path_constraints.clear();
        for (key, place) in self.doc.sub_table(table, "constraints")?.into_iter().flatten() {
            let Value::Table(b) = place.get_ref() else { continue };
            let first = counted.path_constraints.len();
            self.constraint(key, place, names, &mut counted)?;
            let path = first..counted.path_constraints.len();
            let own = b.get("probability").map(|v| self.probability(v, "probability")).transpose()?;
            let name: &str = key.get_ref();
            let bounded = |i: &usize| path.is_empty() && !ocp.state_bounds[*i].is_free();
            let state = self.system.state_index(name).filter(bounded);
            let soft = |b: &Bounds| b.softness != Softness::Hard;
            let random = state.is_some_and(|i| soft(&ocp.state_bounds[i]))
                || !path.is_empty() && path.clone().all(|c| soft(&ocp.path_constraints[c].bounds));
            if let Some(v) = b.get("probability").filter(|_| !random) {
                let message = format!("`{name}` is not a soft bound of a state: it cannot have a probability");
                let remedy = "remove `probability`, or remove `hard`: a bound that noise may exceed is soft";
                return Err(self.doc.error(v.span(), message, remedy).into());
            }
            if let Some(probability) = own.or(all).filter(|_| random) {
                chances.push(Chance { name: name.to_owned(), place, probability, state, path });
            }
        }
        Ok(chances)
    }

    fn probability(&self, v: Located<'_, '_>, key: &str) -> Parsed<f64> {
        let p = self.constant(v, key)?;
        if (0.5..1.0).contains(&p) {
            return Ok(p);
        }
        let message = format!("`{key}` must be at least 0.5 and below 1");
        Err(self.doc.error(v.span(), message, "write 0.95 for one violation in twenty").into())
    }

    /// Puts the margin of one constraint into the problem.
    fn margin(
        &self,
        chance: &Chance<'_, '_>,
        deviations: &Deviations,
        (x, u): (&[f64], &[f64]),
        ocp: &mut Ocp,
    ) -> Result<ChanceMargin, ProblemError> {
        let (n, m, steps) = (ocp.states(), ocp.inputs(), ocp.steps);
        // The quantile of the standard normal distribution.
        let quantile = Normal::standard().inverse_cdf(chance.probability);
        let mut largest = vec![0.0_f64; steps + 1];
        let mut add = |slope: &[f64], bounds: Bounds| -> Parsed<Vec<f64>> {
            let row: Vec<f64> = (0..=steps).map(|k| quantile * deviations.of(slope, k)).collect();
            for (l, v) in largest.iter_mut().zip(&row) {
                *l = l.max(*v);
            }
            let widest = row.iter().fold(0.0_f64, |w, v| w.max(*v));
            if !widest.is_finite() || bounds.min + widest > bounds.max - widest {
                let message = format!(
                    "no admissible value remains between the bounds of `{}`: the margin for the noise grows to \
                     {widest}",
                    chance.name
                );
                let remedy = "widen the bounds, lower the probability, or shorten the horizon";
                return Err(self.doc.error(chance.place.span(), message, remedy).into());
            }
            Ok(row)
        };
        if let Some(i) = chance.state {
            let slope: Vec<f64> = (0..n + m).map(|j| f64::from(u8::from(i == j))).collect();
            let row = add(&slope, ocp.state_bounds[i])?;
            ocp.margins.states.resize(steps + 1, vec![0.0; n]);
            for (states, v) in ocp.margins.states.iter_mut().zip(&row) {
                states[i] = *v;
            }
        }
        ocp.margins.path.resize(ocp.path_constraints.len(), Vec::new());
        let r = ocp.reference(0).to_vec();
        for c in chance.path.clone() {
            let constraint = &mut ocp.path_constraints[c];
            let pattern = constraint.function.jacobian_pattern().to_vec();
            let (_, jacobian) = constraint.function.values_and_jacobian(x, u, 0.0, &r);
            let mut slope = vec![0.0; n + m];
            for (&(_, j), v) in pattern.iter().zip(jacobian) {
                slope[j] = *v;
            }
            let bounds = constraint.bounds;
            ocp.margins.path[c] = add(&slope, bounds)?;
        }
        Ok(ChanceMargin {
            name: chance.name.clone(),
            probability: chance.probability,
            first: largest[1.min(steps)],
            last: largest[steps],
        })
    }
}
