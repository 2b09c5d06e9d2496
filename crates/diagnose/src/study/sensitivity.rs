//! Sensitivities of a window from one simulation: small changes of the initial state and of the equations, propagated along its
//! trajectory.

use super::compiled::Target;
use super::runner::{Failure, Runner};
use crate::signal::Quantity;

impl Runner<'_> {
    /// Makes the linear maps along the trajectory from `x0`; false where the model does not have them.
    pub(super) fn map(&mut self, theta: &[f64], x0: &[f64]) -> Result<bool, Failure> {
        let states_alone = self.record.measured.iter().all(|m| matches!(m.quantity, Quantity::State(_)));
        if !states_alone || !self.compiled.differentiable {
            return Ok(false);
        }
        if !self.trajectory.is_of(theta, x0) {
            let mut simulated = vec![0.0; self.target.len()];
            self.simulate(theta, x0, &mut simulated)?;
        }
        if !self.trajectory.mapped {
            self.trajectory.mapped =
                self.stepper.system_mut().tangent(&self.trajectory.path, &mut self.trajectory.tangent);
        }
        Ok(self.trajectory.mapped)
    }

    /// Changes of the simulated columns over their noise, by columns: by the initial state, in natural units, where `initial`, then
    /// for each of `changes` of the field. They are by piece `n` numbers each. The maps must have been made.
    fn propagate<'b>(&self, initial: bool, count: usize, changes: impl Fn(usize) -> &'b [f64], out: &mut [Vec<f64>]) {
        let n = self.stepper.state().len();
        let own = if initial { n } else { 0 };
        let mut x = vec![0.0; n * (own + count)];
        (0..own).for_each(|i| x[i * n + i] = 1.0);
        let mut scratch = Vec::new();
        let mut piece = 0;
        let samples = self.samples();
        let tracked = self.tracked();
        for (number, (reading, &mark)) in self.schedule.iter().zip(&self.trajectory.marks).enumerate() {
            while piece < mark {
                let (by_state, by_field) = x.split_at_mut(own * n);
                self.trajectory.tangent.propagate(piece, by_state, &[], &mut scratch);
                self.trajectory.tangent.propagate(piece, by_field, changes(piece), &mut scratch);
                piece += 1;
            }
            let Quantity::State(state) = self.record.measured[reading.column].quantity else { continue };
            let at = reading.column * samples + reading.sample;
            let rotation = tracked
                .and_then(|(point, d)| Some((point, point.shift(state, *self.trajectory.turns.get(number)?, d))));
            for (column, values) in out.iter_mut().enumerate() {
                let moved = &x[column * n..(column + 1) * n];
                let with_it = rotation.map_or(0.0, |(point, shift)| {
                    shift.by_angle * moved[point.angle] + shift.by_spin * moved[point.spin]
                });
                values[at] = (moved[state] + with_it) * self.weights[reading.column];
            }
        }
        let columns = self.columns();
        for values in out {
            self.through_filters(&columns, values);
        }
    }

    /// Changes of the simulated columns by the initial state and, with `numbers`, by the unknowns of the equations, in order.
    pub(super) fn by_state_and_equations(&self, numbers: bool) -> Vec<Vec<f64>> {
        let count = if numbers { self.compiled.targets.iter().filter(|t| **t == Target::Equations).count() } else { 0 };
        let mut out = vec![vec![0.0; self.target.len()]; self.stepper.state().len() + count];
        self.propagate(true, count, |piece| self.trajectory.tangent.by_number(piece), &mut out);
        out
    }

    /// Changes of the simulated columns by amplitudes of a candidate, whose model another runner has, at values of all its unknowns.
    /// None where its field does not have derivatives by them.
    pub(super) fn by_amplitudes(
        &self,
        candidate: &mut Runner<'_>,
        values: &[f64],
        count: usize,
    ) -> Result<Option<Vec<Vec<f64>>>, Failure> {
        candidate.set(values)?;
        let mut changes = Vec::new();
        if !candidate.stepper.system_mut().along(self.stepper.system(), &self.trajectory.path, &mut changes) {
            return Ok(None);
        }
        let size = self.stepper.state().len() * count;
        let mut out = vec![vec![0.0; self.target.len()]; count];
        self.propagate(false, count, |piece| &changes[piece * size..(piece + 1) * size], &mut out);
        Ok(Some(out))
    }

    /// Change of the simulated columns when a candidate, whose model another runner has, changes the samples of inputs, to first order
    /// in their change. None where the models differ otherwise.
    pub(super) fn by_samples(&self, candidate: &mut Runner<'_>, values: &[f64]) -> Result<Option<Vec<f64>>, Failure> {
        candidate.set(values)?;
        let mut changes = Vec::new();
        if !candidate.stepper.system_mut().by_samples(self.stepper.system(), &self.trajectory.path, &mut changes) {
            return Ok(None);
        }
        let n = self.stepper.state().len();
        let mut out = vec![vec![0.0; self.target.len()]];
        self.propagate(false, 1, |piece| &changes[piece * n..(piece + 1) * n], &mut out);
        Ok(out.pop())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::record::Record;
    use crate::signal::{Measured, Quantity, Signal};
    use crate::study::normal::{sensitivities, simulate};
    use crate::{Study, StudySettings};
    use bracketry_sim::Hold;
    use bracketry_system::System;

    /// Sensitivities of one window of 0.4 s by initial states and parameters: propagated, and by finite differences. All
    /// states are measured with unit noise; inputs are two sines.
    fn both(text: &str, start: &[f64], hold: Hold) -> (nalgebra::DMatrix<f64>, nalgebra::DMatrix<f64>) {
        let system = System::parse("model.toml", text).unwrap();
        let times: Vec<f64> = (0..400).map(|k| k as f64 * 1e-3).collect();
        let wave = |i: usize| Signal {
            values: times.iter().map(|t| 2.5 * (17.0 * t + i as f64).sin() + (41.0 * t).cos()).collect(),
            hold,
        };
        let measured = (0..system.states.len())
            .map(|i| Measured {
                name: system.state_names()[i].clone(),
                quantity: Quantity::State(i),
                values: vec![0.0; times.len()],
                noise: 1.0,
            })
            .collect();
        let inputs = (0..system.inputs.len()).map(wave).collect();
        let record = Record {
            name: "run".into(),
            times: times.clone(),
            gaps: vec![],
            inputs,
            input_derivatives: vec![],
            measured,
            audit: None,
        };
        let settings = StudySettings { window: Some(0.4), ..StudySettings::default() };
        let study = Study::new(&system, &[record], &settings).unwrap();
        let mut compiled = study.compiled(&[]).unwrap();
        let theta: Vec<f64> = compiled.unknowns.iter().map(|u| u.nominal).collect();
        let scales = vec![1.0; start.len()];
        let mut of = |differentiable: bool| {
            compiled.differentiable = differentiable;
            let mut slots = study.slots(&compiled, &[0], None).unwrap();
            let runner = &mut slots[0].runner;
            let point = simulate(runner, &theta, start).unwrap();
            sensitivities(runner, &compiled, &theta, &point, &scales, true).unwrap()
        };
        (of(true), of(false))
    }

    fn assert_alike(text: &str, start: &[f64], hold: Hold) {
        let (propagated, differences) = both(text, start, hold);
        for (j, (a, b)) in propagated.column_iter().zip(differences.column_iter()).enumerate() {
            let size = b.amax();
            assert!((a - b).amax() < 0.01 * size, "column {j}: off by {} of {size}", (a - b).amax());
        }
    }

    #[test]
    fn a_slider_that_sticks_and_slips_has_the_sensitivities_of_finite_differences() {
        let text = "states = ['x', 'v']\ninputs = ['u']\nparameters = { m = 1.0, c = 1.5, d = 0.3, k = 20.0 }\n\
                    [dynamics]\nx = 'v'\nv = '(u - c*sign(v) - d*v - k*x)/m'";
        for hold in [Hold::Previous, Hold::Linear] {
            assert_alike(text, &[0.01, 0.05], hold);
        }
    }

    #[test]
    fn friction_on_a_plane_has_the_sensitivities_of_finite_differences() {
        let text = "states = ['x', 'y', 'vx', 'vy']\ninputs = ['u', 'w']\nparameters = { c = 2.0, a = 1.3, k = 3.0 }\n\
                    [definitions]\ns = 'sqrt(vx^2 + a^2*vy^2)'\n\
                    [dynamics]\nx = 'vx'\ny = 'vy'\nvx = 'u - k*x - c*vx/s'\nvy = 'w - c*a*vy/s'";
        assert_alike(text, &[0.0, 0.02, 0.5, -0.3], Hold::Previous);
        assert_alike(text, &[0.0, 0.02, 0.05, -0.03], Hold::Previous);
    }

    #[test]
    fn two_joints_with_friction_have_the_sensitivities_of_finite_differences() {
        let text = "states = ['p', 'q', 'v', 'w']\ninputs = ['u', 'z']\n\
                    parameters = { m = 1.0, j = 0.3, c = 0.8, b = 1.1, e = 0.4 }\n\
                    [dynamics]\np = 'v'\nq = 'w'\n\
                    v = '(u - c*sign(v) - e*sin(p - q))/m'\nw = '(z - b*sign(w) + e*sin(p - q) - 0.2*abs(w)*w)/j'";
        assert_alike(text, &[0.0, 0.02, 0.3, -0.3], Hold::Previous);
    }
}
