//! The linear systems of the interior-point method, block by block.

use super::blocks::Blocks;
use bracketry_numerics::rows::{
    Strided, add_multiple, add_product, add_symmetric_product, add_symmetric_times, dot, eliminate,
};

/// Smallest pivot relative to the diagonal entry that it is left of.
const SMALLEST_PIVOT: f64 = 1e-14;

/// Solves
///
/// ```text
/// min  Σ ½ w_jᵀ M_j w_j + g_jᵀ w_j
/// s.t. x_{j+1} = F_j w_j (+ c_j)
/// ```
///
/// over the variables w_j = (u_j, x_j) of the blocks by the Riccati recursion: the inputs of a block are eliminated from M_j + F_jᵀ P_{j+1} F_j by
/// Cholesky's method, and P_j is what is left.
pub(super) struct Recursion {
    /// Upper triangles: rows of the Cholesky factor and of the gain, then P_j.
    factors: Vec<Vec<f64>>,
    /// L⁻¹ (slope of the inputs) and the slope of P_j.
    slopes: Vec<Vec<f64>>,
    /// P_{j+1} in full, and its product with F_j.
    cost: Vec<f64>,
    product: Vec<f64>,
    /// Slope of P_{j+1} at the end of a block, and the constant of its dynamics.
    slope: Vec<f64>,
    constant: Vec<f64>,
}

impl Recursion {
    pub(super) fn new(blocks: &Blocks) -> Self {
        let widest = blocks.all.iter().map(super::blocks::Block::stride).max().unwrap_or(1);
        let n = blocks.n;
        Self {
            factors: blocks.all.iter().map(|b| vec![0.0; b.size() * b.stride()]).collect(),
            slopes: blocks.all.iter().map(|b| vec![0.0; b.size()]).collect(),
            cost: vec![0.0; n * n],
            product: vec![0.0; n * widest],
            slope: vec![0.0; n],
            constant: vec![0.0; n],
        }
    }

    /// Factorizes; `add` adds to the upper triangle of the Hessian of a block what the inequalities ask for. False where the
    /// matrix is not positive definite on the directions that obey the dynamics.
    pub(super) fn factorize(&mut self, blocks: &Blocks, mut add: impl FnMut(usize, &mut [f64])) -> bool {
        let n = blocks.n;
        for (j, block) in blocks.all.iter().enumerate().rev() {
            let (stride, size) = (block.stride(), block.size());
            let (head, tail) = self.factors.split_at_mut(j + 1);
            let m = &mut head[j];
            m.copy_from_slice(&block.hessian);
            add(j, m);
            if let (Some(next), Some(factor)) = (blocks.all.get(j + 1), tail.first()) {
                let (first, row) = (next.inputs, next.stride());
                for a in 0..n {
                    for b in a..n {
                        let v = factor[(first + a) * row + first + b];
                        self.cost[a * n + b] = v;
                        self.cost[b * n + a] = v;
                    }
                }
                let flow = block.state(block.length, n);
                let product = &mut self.product[..n * stride];
                product.fill(0.0);
                add_product(product, stride, Strided::new(&self.cost, n), (flow, stride), (n, n), 0..size);
                add_symmetric_product(m, stride, flow, product, (size, n));
            }
            if !eliminate(m, stride, (block.inputs, size), SMALLEST_PIVOT) {
                return false;
            }
        }
        true
    }

    /// Solves for the gradients g_j after a factorization; with the constants of the dynamics if `affine`.
    pub(super) fn solve(&mut self, blocks: &Blocks, g: &[Vec<f64>], affine: bool, w: &mut [Vec<f64>]) {
        let n = blocks.n;
        for (j, block) in blocks.all.iter().enumerate().rev() {
            let (stride, size) = (block.stride(), block.size());
            let (head, tail) = self.slopes.split_at_mut(j + 1);
            let h = &mut head[j];
            h.copy_from_slice(&g[j]);
            if let (Some(next), Some(after)) = (blocks.all.get(j + 1), tail.first()) {
                let flow = block.state(block.length, n);
                self.slope.copy_from_slice(&after[next.inputs..]);
                if affine {
                    self.constant.iter_mut().enumerate().for_each(|(a, c)| *c = flow[a * stride + size]);
                    let cost = &self.factors[j + 1][next.inputs * next.stride() + next.inputs..];
                    add_symmetric_times(&mut self.slope, cost, next.stride(), &self.constant);
                }
                for (row, slope) in flow.chunks_exact(stride).zip(&self.slope) {
                    add_multiple(h, *slope, &row[..size]);
                }
            }
            let factor = &self.factors[j];
            for i in 0..block.inputs {
                let row = &factor[i * stride..i * stride + size];
                let y = h[i] / row[i];
                h[i] = y;
                add_multiple(&mut h[i + 1..], -y, &row[i + 1..]);
            }
        }
        for (j, block) in blocks.all.iter().enumerate() {
            let (stride, size) = (block.stride(), block.size());
            let (before, w) = w.split_at_mut(j);
            let w = &mut w[0];
            if let Some(last) = j.checked_sub(1) {
                let (of, w_last) = (&blocks.all[last], &before[last]);
                for (row, x) in of.state(of.length, n).chunks_exact(of.stride()).zip(&mut w[block.inputs..]) {
                    *x = dot(&row[..of.size()], w_last) + if affine { row[of.size()] } else { 0.0 };
                }
            }
            for i in (0..block.inputs).rev() {
                let row = &self.factors[j][i * stride..i * stride + size];
                w[i] = -(self.slopes[j][i] + dot(&row[i + 1..], &w[i + 1..])) / row[i];
            }
        }
    }
}
