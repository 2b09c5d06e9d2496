//! The classical Runge–Kutta method of order 4.
//!
//! It is differentiated as it stands, so the sensitivities are those of the numbers it returns:
//! S_{i+1} = S_i + h/6 (D_1 + 2 D_2 + 2 D_3 + D_4), D_j = A_j T_j + [0 B_j].

use super::interval::Interval;
use super::one_step::{Differentiated, OneStepMethod, set_identity};
use super::stages::Stages;
use crate::dynamics::Dynamics;

/// The method with its working memory.
#[derive(Clone, Debug)]
pub(crate) struct ExplicitRungeKutta {
    n: usize,
    m: usize,
    pattern: Vec<(usize, usize)>,
    /// Columns of the possible entries of each row of the flow's derivative.
    columns: Vec<Vec<usize>>,
    /// Positions of all possible entries.
    entries: Vec<usize>,
    stage: Vec<f64>,
    k: [Vec<f64>; 4],
    d: [Vec<f64>; 4],
    s: Vec<f64>,
    t: Vec<f64>,
    jac: Vec<f64>,
}

const FRACTION: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
const WEIGHT: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];

impl ExplicitRungeKutta {
    /// `closure` marks the possible entries of the flow's derivative, n rows of n + m.
    pub(crate) fn new(n: usize, m: usize, pattern: &[(usize, usize)], closure: &[bool]) -> Self {
        let w = n + m;
        let columns = (0..n).map(|i| (0..w).filter(|j| closure[i * w + j]).collect()).collect();
        let entries = (0..n * w).filter(|&e| closure[e]).collect();
        let row = || vec![0.0; n];
        let block = || vec![0.0; n * w];
        Self {
            n,
            m,
            columns,
            entries,
            stage: row(),
            k: [row(), row(), row(), row()],
            d: [block(), block(), block(), block()],
            s: block(),
            t: block(),
            jac: vec![0.0; pattern.len()],
            pattern: pattern.to_vec(),
        }
    }
}

impl OneStepMethod for ExplicitRungeKutta {
    fn advance(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, x: &mut [f64]) -> bool {
        let (h, u) = (interval.step(), interval.u);
        for time in interval.times() {
            for q in 0..4 {
                let c = FRACTION[q] * h;
                for i in 0..self.n {
                    self.stage[i] = if q == 0 { x[i] } else { x[i] + c * self.k[q - 1][i] };
                }
                dynamics.field(time + c, &self.stage, u, &mut self.k[q]);
            }
            for i in 0..self.n {
                x[i] += h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
            }
        }
        true
    }

    fn differentiate(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, to: Differentiated<'_>) -> bool {
        let Differentiated { x, jacobian, mut stages } = to;
        let (n, w) = (self.n, self.n + self.m);
        let (h, u) = (interval.step(), interval.u);
        set_identity(&mut self.s, w);
        for time in interval.times() {
            for q in 0..4 {
                let c = FRACTION[q] * h;
                if q == 0 {
                    self.stage.copy_from_slice(x);
                    self.t.copy_from_slice(&self.s);
                } else {
                    for i in 0..n {
                        self.stage[i] = x[i] + c * self.k[q - 1][i];
                    }
                    for &e in &self.entries {
                        self.t[e] = self.s[e] + c * self.d[q - 1][e];
                    }
                }
                dynamics.field_and_jacobian(time + c, &self.stage, u, &mut self.k[q], &mut self.jac);
                if let Some(stages) = &mut stages {
                    stages.push(time + c, &self.stage, &self.jac, self.t.iter().copied());
                }
                let d = &mut self.d[q];
                for &e in &self.entries {
                    d[e] = 0.0;
                }
                for (&(i, j), &a) in self.pattern.iter().zip(&self.jac) {
                    if j >= n {
                        d[i * w + j] += a;
                    } else {
                        for &c in &self.columns[j] {
                            d[i * w + c] += a * self.t[j * w + c];
                        }
                    }
                }
            }
            for i in 0..n {
                x[i] += h * (0..4).map(|q| WEIGHT[q] * self.k[q][i]).sum::<f64>();
            }
            for &e in &self.entries {
                self.s[e] += h * (0..4).map(|q| WEIGHT[q] * self.d[q][e]).sum::<f64>();
            }
        }
        jacobian.copy_from_slice(&self.s);
        true
    }

    fn adjoints(&mut self, h: f64, stages: &mut Stages, lambda: &mut [f64]) {
        let n = self.n;
        stages.weights.resize(stages.times.len() * n, 0.0);
        for step in (0..stages.times.len() / 4).rev() {
            // The adjoint of the stage after this one, through its increment, then that of this one.
            let next = &mut self.stage;
            self.s[..n].copy_from_slice(lambda);
            for q in (0..4).rev() {
                let at = step * 4 + q;
                for i in 0..n {
                    let through = if q < 3 { FRACTION[q + 1] * h * next[i] } else { 0.0 };
                    stages.weights[at * n + i] = h * WEIGHT[q] * self.s[i] + through;
                }
                next.fill(0.0);
                stages.add_transposed(&self.pattern, at, next);
                lambda.iter_mut().zip(&*next).for_each(|(l, v)| *l += v);
            }
        }
    }
}
