//! Feasibility restoration: what to do where the filter accepts no step.

use super::direction::Model;
use super::iterate::Iterate;
use super::solver::InteriorPoint;

/// Share of the infeasibility that has to go, and most steps that it may take.
const REMAINING: f64 = 0.9;
const STEPS: usize = 40;
/// Share of what a step promises that it has to remove, and the shortest one.
const REALIZED: f64 = 0.1;
const SHORTEST: f64 = 1e-3;
/// Largest multiplier of a distance after restoration, in units of its size.
const LARGEST_MULTIPLIER: f64 = 1e3;

impl InteriorPoint<'_> {
    /// Takes shortest steps toward where dynamics and constraints hold until the filter accepts one; where they lead nowhere, the
    /// inputs are simulated, once. False where nothing helps.
    pub(super) fn restore(&mut self) -> bool {
        self.filter.add(&self.merit());
        let goal = REMAINING * self.now.infeasibility;
        for _ in 0..STEPS {
            if !self.step_toward_feasibility() && !self.simulate() {
                return false;
            }
            if self.now.infeasibility <= goal && self.filter.accepts(&self.merit()) {
                for ((v, t), row) in self.at.v.iter_mut().zip(&self.at.t).zip(&self.of.program.rows) {
                    *v = (self.barrier / t).min(LARGEST_MULTIPLIER / row.scale);
                }
                self.estimate_multipliers();
                return true;
            }
        }
        false
    }

    fn step_toward_feasibility(&mut self) -> bool {
        self.of.differentiate(&self.at, false);
        let mut point = self.at.clone();
        point.v.iter_mut().zip(&point.t).for_each(|(v, t)| *v = self.barrier / t);
        let model = Model::Distance(self.barrier.sqrt());
        if self.system.factorize(&self.of, &point, model, 0.0).is_none() {
            return false;
        }
        let residuals = (self.now.defects.as_slice(), self.now.residuals.as_slice());
        let d = self.system.solve(&self.of, &point, self.barrier, residuals);
        let mut fraction = self.longest(&self.at.t, &d.dt);
        while fraction > SHORTEST {
            let trial = self.at.moved(&d, fraction);
            let values = self.of.values(&trial);
            if values.is_finite() && values.infeasibility <= (1.0 - REALIZED * fraction) * self.now.infeasibility {
                (self.at, self.now) = (trial, values);
                return true;
            }
            fraction /= 2.0;
        }
        false
    }

    /// The trajectory of the same inputs, which has no defects.
    fn simulate(&mut self) -> bool {
        if std::mem::replace(&mut self.simulated, true) {
            return false;
        }
        let mut z = self.at.z.clone();
        self.of.problem.roll_out(&mut z);
        self.of.problem.shooter.take_failure();
        if !z.is_finite() {
            return false;
        }
        let t = self.distances(&z, &self.at.s.clone());
        let point = Iterate { z, t, ..self.at.clone() };
        let values = self.of.values(&point);
        if !values.is_finite() || values.infeasibility >= self.now.infeasibility {
            return false;
        }
        (self.at, self.now) = (point, values);
        true
    }
}
