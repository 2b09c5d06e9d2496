//! Newton's direction, with curvature added until it is one of descent.

use super::iterate::{Evaluator, Iterate, Values};
use crate::qp::{Recursion, Shape};

/// Curvature that is added to every variable in units of its size where there is too little: the first one tried, the largest, and the
/// factors from try to try and from step to step.
const FIRST_SHIFT: f64 = 1e-4;
const SMALLEST_SHIFT: f64 = 1e-20;
const LARGEST_SHIFT: f64 = 1e20;
const FIRST_GROWTH: f64 = 100.0;
const GROWTH: f64 = 8.0;
const SHRINKAGE: f64 = 3.0;

/// What the Hessian is made of.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Model {
    /// That of the Lagrangian.
    Lagrangian,
    /// Distance alone, with this weight: the shortest step to where the linearized constraints hold.
    Distance(f64),
}

/// A direction; `y` are multipliers, not their change.
#[derive(Clone, Default)]
pub(super) struct Direction {
    pub(super) dx: Vec<f64>,
    pub(super) du: Vec<f64>,
    pub(super) ds: Vec<f64>,
    pub(super) dt: Vec<f64>,
    pub(super) dv: Vec<f64>,
    pub(super) y: Vec<f64>,
}

/// The linear system at an iterate.
pub(super) struct System {
    recursion: Recursion,
    hessian: Vec<f64>,
    /// Derivative of every interval's end by (du, dx), with its defect in the last column.
    flow: Vec<Vec<f64>>,
    /// Slope of the cost.
    pub(super) slope: Vec<f64>,
    slack_slope: Vec<f64>,
    /// Curvature of every slack.
    slack_curvature: Vec<f64>,
    /// v/t of every row.
    stiffness: Vec<f64>,
    model: Model,
    /// Curvature added last.
    shift: f64,
}

impl System {
    pub(super) fn new(n: usize, m: usize, steps: usize) -> Self {
        let shape = |k| Shape { inputs: if k < steps { m } else { 0 }, states: if k == 0 { 0 } else { n } };
        let shapes: Vec<Shape> = (0..=steps).map(shape).collect();
        Self {
            flow: shapes[..steps].iter().map(|s| vec![0.0; n * s.stride()]).collect(),
            recursion: Recursion::new(n, shapes),
            hessian: vec![0.0; steps * (n + m) * (n + m) + n * n],
            slope: Vec::new(),
            slack_slope: Vec::new(),
            slack_curvature: Vec::new(),
            stiffness: Vec::new(),
            model: Model::Lagrangian,
            shift: 0.0,
        }
    }

    /// Factorizes at a point that has been differentiated, with at least `least` of added curvature; what was added, `None` where even the largest is
    /// not enough.
    pub(super) fn factorize(&mut self, of: &Evaluator<'_>, point: &Iterate, model: Model, least: f64) -> Option<f64> {
        self.model = model;
        self.stiffness = point.v.iter().zip(&point.t).map(|(v, t)| v / t).collect();
        let (cost, factor) = match model {
            Model::Lagrangian => (of.gradient(), of.factor),
            Model::Distance(_) => (vec![0.0; of.width() * point.z.steps() + of.states()], 0.0),
        };
        self.slope = cost;
        let slacks = of.program.slacks.iter();
        self.slack_slope =
            slacks.clone().zip(&point.s).map(|(p, s)| factor * (p.linear + 2.0 * p.quadratic * s)).collect();
        let (n, w) = (of.states(), of.width());
        for (k, (flow, jacobian)) in self.flow.iter_mut().zip(of.lin.jacobian.chunks_exact(n * w)).enumerate() {
            let stride = flow.len() / n;
            for (to, from) in flow.chunks_exact_mut(stride).zip(jacobian.chunks_exact(w)) {
                to[..w - n].copy_from_slice(&from[n..]);
                to[w - n..stride - 1].copy_from_slice(&from[..stride - 1 - (w - n)]);
                (n..w).filter(|v| of.program.is_fixed(k, *v)).for_each(|v| to[v - n] = 0.0);
            }
        }
        let mut shift = least;
        let mut tried = false;
        loop {
            self.assemble(of, shift);
            let (flow, hessian) = (&self.flow, &self.hessian);
            let fill = |k: usize, to: &mut [f64]| {
                let inputs = if k < flow.len() { w - n } else { 0 };
                upper_triangle(&hessian[k * w * w..], (inputs, n), if k == 0 { inputs } else { inputs + n }, to);
            };
            if self.recursion.factorize(|k| &flow[k], fill) {
                if tried || shift > 0.0 {
                    self.shift = shift;
                }
                return Some(shift);
            }
            shift = if !tried && least == 0.0 {
                if self.shift == 0.0 { FIRST_SHIFT } else { (self.shift / SHRINKAGE).max(SMALLEST_SHIFT) }
            } else {
                shift * if self.shift == 0.0 { FIRST_GROWTH } else { GROWTH }
            };
            tried = true;
            if shift > LARGEST_SHIFT || shift.is_nan() {
                return None;
            }
        }
    }

    fn assemble(&mut self, of: &Evaluator<'_>, shift: f64) {
        let (n, w) = (of.states(), of.width());
        let sizes: Vec<f64> = (0..w).map(|v| of.program.size(v)).collect();
        self.hessian.fill(0.0);
        let (factor, added) = match self.model {
            Model::Lagrangian => (of.factor, shift),
            Model::Distance(weight) => (0.0, weight + shift),
        };
        for (k, block) in self.hessian.chunks_mut(w * w).enumerate() {
            if factor != 0.0 {
                of.program.add_block(k, factor, block);
            }
            let width = if block.len() == w * w { w } else { n };
            (0..width).for_each(|i| block[i * width + i] += added / sizes[i].powi(2));
        }
        let slacks = of.program.slacks.iter();
        self.slack_curvature =
            slacks.map(|p| factor * 2.0 * p.quadratic + added / p.scale.powi(2) + self.of_bound(p)).collect();
        for (i, row) in of.program.rows.iter().enumerate().filter(|(_, row)| row.slack.is_none()) {
            add_square(&mut self.hessian, (row.k, n, w), self.stiffness[i], &of.program.row(i));
        }
        // With a slack of curvature r, rows of stiffness a and b that it softens act as r (a cc + b dd)/(r + a + b) and a b (c − d)(c − d)/(r + a + b).
        for (p, &own) in of.program.slacks.iter().zip(&self.slack_curvature) {
            let whole = own + p.softens.iter().map(|&i| self.stiffness[i]).sum::<f64>();
            for &i in &p.softens {
                add_square(&mut self.hessian, (p.k, n, w), self.stiffness[i] * own / whole, &of.program.row(i));
            }
            if let &[i, j] = p.softens.as_slice() {
                let both = self.stiffness[i] * self.stiffness[j] / whole;
                // Both sides of one function: their gradients are opposite.
                add_square(&mut self.hessian, (p.k, n, w), 4.0 * both, &of.program.row(i));
            }
        }
    }

    fn of_bound(&self, p: &crate::qp::NonlinearSlack) -> f64 {
        p.bound.map_or(0.0, |row| self.stiffness[row])
    }

    /// The direction for these defects and residuals.
    pub(super) fn solve(
        &mut self,
        of: &Evaluator<'_>,
        point: &Iterate,
        barrier: f64,
        (defects, residuals): (&[f64], &[f64]),
    ) -> Direction {
        let (n, w, steps) = (of.states(), of.width(), point.z.steps());
        let rows = &of.program.rows;
        // What every row pushes with.
        let force: Vec<f64> =
            (0..rows.len()).map(|i| barrier / point.t[i] - self.stiffness[i] * residuals[i]).collect();
        let mut q = self.slope.clone();
        for (i, row) in rows.iter().enumerate() {
            of.program.row(i).for_each(|(place, a)| q[row.k * w + place] -= a * force[i]);
        }
        let mut slack_force = self.slack_slope.clone();
        for (p, g) in of.program.slacks.iter().zip(&mut slack_force) {
            *g -= p.softens.iter().chain(&p.bound).map(|&i| force[i]).sum::<f64>();
        }
        for ((p, g), own) in of.program.slacks.iter().zip(&slack_force).zip(&self.slack_curvature) {
            let whole = own + p.softens.iter().map(|&i| self.stiffness[i]).sum::<f64>();
            for &i in &p.softens {
                let share = self.stiffness[i] * g / whole;
                of.program.row(i).for_each(|(place, a)| q[p.k * w + place] -= a * share);
            }
        }
        let m = w - n;
        for (flow, c) in self.flow.iter_mut().zip(defects.chunks_exact(n)) {
            let stride = flow.len() / n;
            flow.chunks_exact_mut(stride).zip(c).for_each(|(row, c)| row[stride - 1] = *c);
        }
        let gradients: Vec<Vec<f64>> = (0..=steps)
            .map(|k| {
                let (states, inputs) = q[k * w..(k * w + w).min(q.len())].split_at(n);
                inputs.iter().chain(states.iter().filter(|_| k > 0)).copied().collect()
            })
            .collect();
        let mut stages = gradients.clone();
        self.recursion.solve(|k| &self.flow[k], &gradients, true, &mut stages);
        let mut d = Direction {
            dx: vec![0.0; n],
            du: Vec::with_capacity(steps * m),
            ds: vec![0.0; point.s.len()],
            dt: residuals.to_vec(),
            dv: vec![0.0; rows.len()],
            y: vec![0.0; steps * n],
        };
        for (k, stage) in stages.iter().enumerate() {
            let (inputs, states) = stage.split_at(if k < steps { m } else { 0 });
            d.du.extend(inputs);
            d.dx.extend(states);
            if k > 0 {
                self.recursion.multipliers(k, stage, &mut d.y[(k - 1) * n..k * n]);
            }
        }
        // A constant moves alike over the whole horizon.
        for j in &of.problem.ocp.constant_inputs {
            (1..steps).for_each(|k| d.du[k * m + j] = d.du[*j]);
        }
        for &(state, j) in &of.problem.ocp.free_starts {
            d.dx[state] = d.du[j];
        }
        for (i, row) in rows.iter().enumerate() {
            let step = |place: usize| if place < n { d.dx[row.k * n + place] } else { d.du[row.k * m + place - n] };
            d.dt[i] += of.program.row(i).map(|(place, a)| a * step(place)).sum::<f64>();
        }
        for (((p, g), own), ds) in of.program.slacks.iter().zip(&slack_force).zip(&self.slack_curvature).zip(&mut d.ds)
        {
            let whole = own + p.softens.iter().map(|&i| self.stiffness[i]).sum::<f64>();
            let pull: f64 = p.softens.iter().map(|&i| self.stiffness[i] * (d.dt[i] - residuals[i])).sum();
            *ds = -(g + pull) / whole;
        }
        for (i, row) in rows.iter().enumerate() {
            d.dt[i] += row.slack.map_or(0.0, |s| d.ds[s]);
            d.dv[i] = barrier / point.t[i] - point.v[i] - self.stiffness[i] * d.dt[i];
        }
        d
    }

    /// How the objective with its barrier changes along a direction, to first order.
    pub(super) fn slope_along(&self, d: &Direction, point: &Iterate, barrier: f64) -> f64 {
        let (n, m) = (point.z.states(), point.z.inputs());
        let w = n + m;
        let mut sum = 0.0;
        for k in 0..=point.z.steps() {
            let q = &self.slope[k * w..(k * w + w).min(self.slope.len())];
            sum += q[..n].iter().zip(&d.dx[k * n..]).map(|(a, b)| a * b).sum::<f64>();
            sum += q[n..].iter().zip(d.du.get(k * m..).unwrap_or(&[])).map(|(a, b)| a * b).sum::<f64>();
        }
        sum += self.slack_slope.iter().zip(&d.ds).map(|(a, b)| a * b).sum::<f64>();
        sum - barrier * d.dt.iter().zip(&point.t).map(|(d, t)| d / t).sum::<f64>()
    }
}

/// The upper triangle of the first `size` variables (u, x) of a block of (x, u), row by row at the distance size + 1.
fn upper_triangle(block: &[f64], (inputs, states): (usize, usize), size: usize, to: &mut [f64]) {
    let (width, place) = (inputs + states, |i: usize| if i < inputs { states + i } else { i - inputs });
    for i in 0..size {
        for j in i..size {
            to[i * (size + 1) + j] =
                f64::midpoint(block[place(i) * width + place(j)], block[place(j) * width + place(i)]);
        }
    }
}

/// Adds weight a aᵀ to the block of grid point k.
fn add_square(
    hessian: &mut [f64],
    (k, n, w): (usize, usize, usize),
    weight: f64,
    a: &(impl Iterator<Item = (usize, f64)> + Clone),
) {
    let start = k * w * w;
    let width = if hessian.len() - start == n * n { n } else { w };
    for (i, x) in a.clone() {
        for (j, y) in a.clone() {
            hessian[start + i * width + j] += weight * x * y;
        }
    }
}

/// The values of a trial point for a correction of second order.
pub(super) fn corrected(now: &Values, trial: &Values, fraction: f64) -> (Vec<f64>, Vec<f64>) {
    let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| fraction * a + b).collect();
    (add(&now.defects, &trial.defects), add(&now.residuals, &trial.residuals))
}
