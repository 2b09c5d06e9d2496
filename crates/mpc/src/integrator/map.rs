//! Dynamics that are discrete in time: what they give is the next state, x⁺ = f(t, x, u), and a step applies them once.

use super::interval::Interval;
use super::one_step::{Differentiated, OneStepMethod, set_identity};
use super::stages::Stages;
use crate::dynamics::Dynamics;

/// The iteration with its working memory.
#[derive(Clone, Debug)]
pub(crate) struct MapIteration {
    n: usize,
    m: usize,
    pattern: Vec<(usize, usize)>,
    next: Vec<f64>,
    jacobian: Vec<f64>,
    /// Derivative of the state with respect to (x, u) at the start of the interval, n rows of n + m.
    s: Vec<f64>,
    s_next: Vec<f64>,
}

impl MapIteration {
    pub(crate) fn new(n: usize, m: usize, pattern: &[(usize, usize)]) -> Self {
        let block = vec![0.0; n * (n + m)];
        Self {
            n,
            m,
            pattern: pattern.to_vec(),
            next: vec![0.0; n],
            jacobian: vec![0.0; pattern.len()],
            s: block.clone(),
            s_next: block,
        }
    }
}

impl OneStepMethod for MapIteration {
    fn advance(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, x: &mut [f64]) -> bool {
        for time in interval.times() {
            dynamics.field(time, x, interval.u, &mut self.next);
            x.copy_from_slice(&self.next);
        }
        true
    }

    /// S⁺ = A S + \[0 B\].
    fn differentiate(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, to: Differentiated<'_>) -> bool {
        let Differentiated { x, jacobian, mut stages } = to;
        let (n, w) = (self.n, self.n + self.m);
        set_identity(&mut self.s, w);
        for time in interval.times() {
            dynamics.field_and_jacobian(time, x, interval.u, &mut self.next, &mut self.jacobian);
            if let Some(stages) = &mut stages {
                stages.push(time, x, &self.jacobian, self.s.iter().copied());
            }
            self.s_next.fill(0.0);
            for (&(i, j), &a) in self.pattern.iter().zip(&self.jacobian) {
                if j >= n {
                    self.s_next[i * w + j] += a;
                } else {
                    for c in 0..w {
                        self.s_next[i * w + c] += a * self.s[j * w + c];
                    }
                }
            }
            std::mem::swap(&mut self.s, &mut self.s_next);
            x.copy_from_slice(&self.next);
        }
        jacobian.copy_from_slice(&self.s);
        true
    }

    /// μ_q is the multiplier after step q, and λ = Aᵀμ_q that before it.
    fn adjoints(&mut self, _h: f64, stages: &mut Stages, lambda: &mut [f64]) {
        let n = self.n;
        stages.weights.resize(stages.times.len() * n, 0.0);
        for step in (0..stages.times.len()).rev() {
            stages.weights[step * n..(step + 1) * n].copy_from_slice(lambda);
            lambda.fill(0.0);
            stages.add_transposed(&self.pattern, step, lambda);
        }
    }
}
