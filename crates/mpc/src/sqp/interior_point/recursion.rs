//! The linear systems of the interior-point method, stage by stage.

/// Solves
///
/// ```text
/// min  Σ ½ w_kᵀ H_k w_k + q_kᵀ w_k        w_k = (dx_k, du_k), dx_0 = 0
/// s.t. dx_{k+1} = A_k dx_k + B_k du_k + c_k
/// ```
///
/// by the Riccati recursion. The Hessian on the directions that obey the dynamics is positive definite if and only if every pivot
/// B_kᵀ P_{k+1} B_k + H_k^uu is (J. C. Dunn, D. P. Bertsekas, J. Optim. Theory Appl. 63, 1989).
pub(super) struct Recursion {
    n: usize,
    m: usize,
    steps: usize,
    /// P_k, k = 1 … N, n rows of n.
    cost: Vec<f64>,
    /// Cholesky factors L of the pivots, N blocks of m rows of m.
    factor: Vec<f64>,
    /// L⁻¹ (B_kᵀ P_{k+1} A_k + H_k^ux), N blocks of m rows of n.
    gain: Vec<f64>,
    /// p_k, k = 1 … N; L⁻¹ (B_kᵀ (P_{k+1} c_k + p_{k+1}) + q_k^u), N rows of m.
    slope: Vec<f64>,
    offset: Vec<f64>,
    product: Vec<f64>,
    block: Vec<f64>,
}

/// Smallest pivot relative to the diagonal entry that it is left of.
const SMALLEST_PIVOT: f64 = 1e-13;

impl Recursion {
    pub(super) fn new(n: usize, m: usize, steps: usize) -> Self {
        let w = n + m;
        Self {
            n,
            m,
            steps,
            cost: vec![0.0; steps * n * n],
            factor: vec![0.0; steps * m * m],
            gain: vec![0.0; steps * m * n],
            slope: vec![0.0; steps * n],
            offset: vec![0.0; steps * m],
            product: vec![0.0; n * w],
            block: vec![0.0; w * w],
        }
    }

    /// Factorizes for the blocks H_k (n + m rows of n + m, the last n rows of n) and the flow (A_k, B_k); false where the Hessian is not
    /// positive definite on the directions that obey the dynamics.
    pub(super) fn factorize(&mut self, hessian: &[f64], flow: &[f64]) -> bool {
        let (n, m, steps) = (self.n, self.m, self.steps);
        let w = n + m;
        self.cost[(steps - 1) * n * n..].copy_from_slice(&hessian[steps * w * w..]);
        for k in (0..steps).rev() {
            let flow = &flow[k * n * w..(k + 1) * n * w];
            // P [A B], of which at the start only the part of the inputs counts.
            let first = if k == 0 { n } else { 0 };
            let p = &self.cost[k * n * n..(k + 1) * n * n];
            self.product.fill(0.0);
            for (row, product) in p.chunks_exact(n).zip(self.product.chunks_exact_mut(w)) {
                for (&p, flow) in row.iter().zip(flow.chunks_exact(w)).filter(|(p, _)| **p != 0.0) {
                    product[first..].iter_mut().zip(&flow[first..]).for_each(|(to, f)| *to += p * f);
                }
            }
            let block = &mut self.block;
            block.copy_from_slice(&hessian[k * w * w..(k + 1) * w * w]);
            for (flow, product) in flow.chunks_exact(w).zip(self.product.chunks_exact(w)) {
                for i in first..w {
                    let f = flow[i];
                    if f != 0.0 {
                        block[i * w + first..(i + 1) * w]
                            .iter_mut()
                            .zip(&product[first..])
                            .for_each(|(to, p)| *to += f * p);
                    }
                }
            }
            let factor = &mut self.factor[k * m * m..(k + 1) * m * m];
            for i in 0..m {
                factor[i * m..(i + 1) * m].copy_from_slice(&block[(n + i) * w + n..(n + i + 1) * w]);
            }
            if !cholesky(factor, m) {
                return false;
            }
            if k == 0 {
                return true;
            }
            let gain = &mut self.gain[k * m * n..(k + 1) * m * n];
            for i in 0..m {
                for c in 0..n {
                    let known: f64 = (0..i).map(|l| factor[i * m + l] * gain[l * n + c]).sum();
                    gain[i * n + c] = (block[(n + i) * w + c] - known) / factor[i * m + i];
                }
            }
            let p = &mut self.cost[(k - 1) * n * n..k * n * n];
            for i in 0..n {
                for j in 0..=i {
                    let stays: f64 = (0..m).map(|l| gain[l * n + i] * gain[l * n + j]).sum();
                    let v = f64::midpoint(block[i * w + j], block[j * w + i]) - stays;
                    p[i * n + j] = v;
                    p[j * n + i] = v;
                }
            }
        }
        true
    }

    /// Solves for the slopes q_k (n + m entries, the last n) and c_k after a factorization. `dx` has N + 1 rows of n, `du` N rows of m, and
    /// the multipliers y_k of dx_{k+1} − A_k dx_k − B_k du_k − c_k = 0 N rows of n.
    pub(super) fn solve(
        &mut self,
        q: &[f64],
        c: &[f64],
        flow: &[f64],
        (dx, du, y): (&mut [f64], &mut [f64], &mut [f64]),
    ) {
        let (n, m, steps) = (self.n, self.m, self.steps);
        let w = n + m;
        self.slope[(steps - 1) * n..].copy_from_slice(&q[steps * w..]);
        let mut force = vec![0.0; n];
        let mut g = vec![0.0; w];
        for k in (0..steps).rev() {
            let p = &self.cost[k * n * n..(k + 1) * n * n];
            let c = &c[k * n..(k + 1) * n];
            for ((f, row), slope) in force.iter_mut().zip(p.chunks_exact(n)).zip(&self.slope[k * n..(k + 1) * n]) {
                *f = slope + dot(row, c);
            }
            g.copy_from_slice(&q[k * w..(k + 1) * w]);
            for (f, flow) in force.iter().zip(flow[k * n * w..(k + 1) * n * w].chunks_exact(w)) {
                g.iter_mut().zip(flow).for_each(|(g, a)| *g += a * f);
            }
            let factor = &self.factor[k * m * m..(k + 1) * m * m];
            let offset = &mut self.offset[k * m..(k + 1) * m];
            for i in 0..m {
                let known = dot(&factor[i * m..i * m + i], &offset[..i]);
                offset[i] = (g[n + i] - known) / factor[i * m + i];
            }
            if k > 0 {
                let gain = &self.gain[k * m * n..(k + 1) * m * n];
                let slope = &mut self.slope[(k - 1) * n..k * n];
                slope.copy_from_slice(&g[..n]);
                for (o, row) in offset.iter().zip(gain.chunks_exact(n)) {
                    slope.iter_mut().zip(row).for_each(|(s, a)| *s -= a * o);
                }
            }
        }
        dx[..n].fill(0.0);
        for k in 0..steps {
            let (before, after) = dx.split_at_mut((k + 1) * n);
            let x = &before[k * n..];
            let u = &mut du[k * m..(k + 1) * m];
            let factor = &self.factor[k * m * m..(k + 1) * m * m];
            for i in (0..m).rev() {
                let mut v = -self.offset[k * m + i];
                if k > 0 {
                    v -= dot(&self.gain[(k * m + i) * n..(k * m + i + 1) * n], x);
                }
                // Lᵀ du = v.
                u[i] = v;
            }
            for i in (0..m).rev() {
                let known: f64 = (i + 1..m).map(|l| factor[l * m + i] * u[l]).sum();
                u[i] = (u[i] - known) / factor[i * m + i];
            }
            let next = &mut after[..n];
            for ((to, row), c) in
                next.iter_mut().zip(flow[k * n * w..(k + 1) * n * w].chunks_exact(w)).zip(&c[k * n..(k + 1) * n])
            {
                *to = c + dot(&row[..n], x) + dot(&row[n..], u);
            }
            let p = &self.cost[k * n * n..(k + 1) * n * n];
            for (i, to) in y[k * n..(k + 1) * n].iter_mut().enumerate() {
                *to = -(self.slope[k * n + i] + dot(&p[i * n..(i + 1) * n], next));
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Replaces the lower triangle by the Cholesky factor; false where a pivot is not positive beyond rounding.
fn cholesky(a: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let diagonal = a[j * n + j];
        let pivot = diagonal - a[j * n..j * n + j].iter().map(|v| v * v).sum::<f64>();
        if pivot.is_nan() || pivot <= SMALLEST_PIVOT * diagonal.abs() || pivot.is_infinite() {
            return false;
        }
        let root = pivot.sqrt();
        a[j * n + j] = root;
        for i in j + 1..n {
            let known = dot(&a[i * n..i * n + j], &a[j * n..j * n + j]);
            a[i * n + j] = (a[i * n + j] - known) / root;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    const SHAPES: [(usize, usize, usize); 4] = [(1, 1, 1), (2, 1, 4), (3, 2, 5), (4, 3, 3)];

    /// Blocks and flow, and the whole problem: Hessian and constraint Jacobian over (du_0, dx_1, du_1, …, dx_N).
    fn random_problem(
        random: &mut StdRng,
        (n, m, steps): (usize, usize, usize),
        shift: f64,
    ) -> (Vec<f64>, Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
        let w = n + m;
        let mut block = |size: usize| {
            let a = DMatrix::from_fn(size, size, |_, _| random.random_range(-1.0..1.0));
            &a + a.transpose() + DMatrix::identity(size, size) * shift
        };
        let blocks: Vec<DMatrix<f64>> = (0..=steps).map(|k| block(if k < steps { w } else { n })).collect();
        let flow: Vec<f64> = (0..steps * n * w).map(|_| random.random_range(-1.0..1.0)).collect();
        let hessian = blocks.iter().flat_map(|b| b.iter().copied()).collect();
        // Place of entry v of (dx_k, du_k).
        let place =
            |k: usize, v: usize| if v >= n { Some(k * w + v - n) } else { (k > 0).then(|| (k - 1) * w + m + v) };
        let mut whole = DMatrix::zeros(steps * w, steps * w);
        let mut constraints = DMatrix::zeros(steps * n, steps * w);
        for k in 0..=steps {
            let size = if k < steps { w } else { n };
            for i in 0..size {
                for j in 0..size {
                    if let (Some(a), Some(b)) = (place(k, i), place(k, j)) {
                        whole[(a, b)] = blocks[k][(i, j)];
                    }
                }
            }
        }
        for k in 0..steps {
            for i in 0..n {
                constraints[(k * n + i, place(k + 1, i).unwrap())] = 1.0;
                for j in 0..w {
                    if let Some(b) = place(k, j) {
                        constraints[(k * n + i, b)] -= flow[(k * n + i) * w + j];
                    }
                }
            }
        }
        (hessian, flow, whole, constraints)
    }

    #[test]
    fn the_solution_is_that_of_the_whole_system() {
        let mut random = StdRng::seed_from_u64(3);
        for shape @ (n, m, steps) in SHAPES {
            let w = n + m;
            let (hessian, flow, whole, constraints) = random_problem(&mut random, shape, 8.0);
            let mut recursion = Recursion::new(n, m, steps);
            assert!(recursion.factorize(&hessian, &flow));
            let q: Vec<f64> = (0..steps * w + n).map(|_| random.random_range(-1.0..1.0)).collect();
            let c: Vec<f64> = (0..steps * n).map(|_| random.random_range(-1.0..1.0)).collect();
            let (mut dx, mut du, mut y) = (vec![0.0; (steps + 1) * n], vec![0.0; steps * m], vec![0.0; steps * n]);
            recursion.solve(&q, &c, &flow, (&mut dx, &mut du, &mut y));
            let (variables, rows) = (steps * w, steps * n);
            let mut kkt = DMatrix::zeros(variables + rows, variables + rows);
            kkt.view_mut((0, 0), (variables, variables)).copy_from(&whole);
            kkt.view_mut((variables, 0), (rows, variables)).copy_from(&constraints);
            kkt.view_mut((0, variables), (variables, rows)).copy_from(&constraints.transpose());
            // The first n slopes belong to the state that is fixed; the others stand in the order of the variables.
            let right: Vec<f64> = q[n..].iter().map(|q| -q).chain(c).collect();
            let solved = kkt.lu().solve(&DVector::from_vec(right)).unwrap();
            for k in 0..steps {
                let expected = du[k * m..(k + 1) * m].iter().chain(&dx[(k + 1) * n..(k + 2) * n]);
                expected.enumerate().for_each(|(i, v)| assert!((solved[k * w + i] - v).abs() < 1e-9));
            }
            y.iter().enumerate().for_each(|(i, y)| assert!((solved[variables + i] - y).abs() < 1e-9));
        }
    }

    #[test]
    fn it_factorizes_exactly_where_the_hessian_is_positive_on_the_dynamics() {
        let mut random = StdRng::seed_from_u64(4);
        let mut counts = [0, 0];
        for trial in 0..200 {
            let shape @ (n, m, steps) = SHAPES[trial % SHAPES.len()];
            let shift = random.random_range(-1.0..4.0);
            let (hessian, flow, whole, constraints) = random_problem(&mut random, shape, shift);
            // Eigenvalues of the Hessian on the null space of the constraints, which the first columns of (Bᵀ …) span.
            let (q, rows) = (constraints.transpose().qr().q(), steps * n);
            let projector = DMatrix::identity(rows + steps * m, rows + steps * m) - &q * q.transpose();
            let values = (&projector * whole * &projector).symmetric_eigen().eigenvalues;
            let negative = values.iter().any(|v| *v < -1e-6);
            let clear = values.iter().filter(|v| v.abs() > 1e-6).count() == steps * m;
            if clear {
                assert_eq!(Recursion::new(n, m, steps).factorize(&hessian, &flow), !negative, "{trial}");
                counts[usize::from(negative)] += 1;
            }
        }
        assert!(counts.iter().all(|c| *c > 20), "{counts:?}");
    }
}
