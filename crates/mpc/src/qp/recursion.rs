//! The linear systems of the interior-point methods, stage by stage.

use bracketry_numerics::rows::{
    Strided, add_multiple, add_product, add_symmetric_product, add_symmetric_times, dot, eliminate,
};

/// Smallest pivot relative to the diagonal entry that it is left of.
const SMALLEST_PIVOT: f64 = 1e-14;

/// Number of inputs and of states among the variables w = (u, x) of a stage: no states where they are given, no inputs at the end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) inputs: usize,
    pub(crate) states: usize,
}

impl Shape {
    /// Number of variables.
    pub(crate) fn size(self) -> usize {
        self.inputs + self.states
    }

    /// Distance of the rows of its matrices: a column for every variable and one for what is constant.
    pub(crate) fn stride(self) -> usize {
        self.size() + 1
    }
}

/// Solves
///
/// ```text
/// min  Σ ½ w_jᵀ M_j w_j + g_jᵀ w_j        w_j = (u_j, x_j)
/// s.t. x_{j+1} = F_j w_j (+ c_j)
/// ```
///
/// by the Riccati recursion: the inputs of a stage are eliminated from M_j + F_jᵀ P_{j+1} F_j by Cholesky's method, and P_j is what is left.
/// The Hessian on the directions that obey the dynamics is positive definite if and only if every pivot is (Dunn and Bertsekas 1989).
///
/// Every function takes F_j with c_j in the last column, n rows at the stride of the stage.
pub(crate) struct Recursion {
    n: usize,
    shapes: Vec<Shape>,
    /// Upper triangles: rows of the Cholesky factor and of the gain, then P_j.
    factors: Vec<Vec<f64>>,
    /// L⁻¹ (slope of the inputs) and the slope of P_j.
    slopes: Vec<Vec<f64>>,
    /// P_{j+1} in full, and its product with F_j.
    cost: Vec<f64>,
    product: Vec<f64>,
    /// Slope of P_{j+1} at the end of a stage, and the constant of its dynamics.
    slope: Vec<f64>,
    constant: Vec<f64>,
}

impl Recursion {
    /// For `n` states between stages of these shapes.
    pub(crate) fn new(n: usize, shapes: Vec<Shape>) -> Self {
        let widest = shapes.iter().map(|s| s.stride()).max().unwrap_or(1);
        Self {
            n,
            factors: shapes.iter().map(|s| vec![0.0; s.size() * s.stride()]).collect(),
            slopes: shapes.iter().map(|s| vec![0.0; s.size()]).collect(),
            cost: vec![0.0; n * n],
            product: vec![0.0; n * widest],
            slope: vec![0.0; n],
            constant: vec![0.0; n],
            shapes,
        }
    }

    /// Factorizes; `fill` writes the upper triangle of the Hessian of a stage. False where the matrix is not positive definite on the
    /// directions that obey the dynamics.
    pub(crate) fn factorize<'a>(
        &mut self,
        flow: impl Fn(usize) -> &'a [f64],
        mut fill: impl FnMut(usize, &mut [f64]),
    ) -> bool {
        let n = self.n;
        for (j, shape) in self.shapes.iter().enumerate().rev() {
            let (stride, size) = (shape.stride(), shape.size());
            let (head, tail) = self.factors.split_at_mut(j + 1);
            let m = &mut head[j];
            fill(j, m);
            if let (Some(next), Some(factor)) = (self.shapes.get(j + 1), tail.first()) {
                let (first, row) = (next.inputs, next.stride());
                for a in 0..n {
                    for b in a..n {
                        let v = factor[(first + a) * row + first + b];
                        self.cost[a * n + b] = v;
                        self.cost[b * n + a] = v;
                    }
                }
                let (flow, product) = (flow(j), &mut self.product[..n * stride]);
                product.fill(0.0);
                add_product(product, stride, Strided::new(&self.cost, n), (flow, stride), (n, n), 0..size);
                add_symmetric_product(m, stride, flow, product, (size, n));
            }
            if !eliminate(m, stride, (shape.inputs, size), SMALLEST_PIVOT) {
                return false;
            }
        }
        true
    }

    /// Solves for the gradients g_j after a factorization; with the constants of the dynamics if `affine`.
    pub(crate) fn solve<'a>(
        &mut self,
        flow: impl Fn(usize) -> &'a [f64],
        g: &[Vec<f64>],
        affine: bool,
        w: &mut [Vec<f64>],
    ) {
        for (j, shape) in self.shapes.iter().enumerate().rev() {
            let (stride, size) = (shape.stride(), shape.size());
            let (head, tail) = self.slopes.split_at_mut(j + 1);
            let h = &mut head[j];
            h.copy_from_slice(&g[j]);
            if let (Some(next), Some(after)) = (self.shapes.get(j + 1), tail.first()) {
                let flow = flow(j);
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
            for i in 0..shape.inputs {
                let row = &factor[i * stride..i * stride + size];
                let y = h[i] / row[i];
                h[i] = y;
                add_multiple(&mut h[i + 1..], -y, &row[i + 1..]);
            }
        }
        for (j, shape) in self.shapes.iter().enumerate() {
            let (stride, size) = (shape.stride(), shape.size());
            let (before, w) = w.split_at_mut(j);
            let w = &mut w[0];
            if let Some(last) = j.checked_sub(1) {
                let (of, w_last) = (self.shapes[last], &before[last]);
                for (row, x) in flow(last).chunks_exact(of.stride()).zip(&mut w[shape.inputs..]) {
                    *x = dot(&row[..of.size()], w_last) + if affine { row[of.size()] } else { 0.0 };
                }
            }
            for i in (0..shape.inputs).rev() {
                let row = &self.factors[j][i * stride..i * stride + size];
                w[i] = -(self.slopes[j][i] + dot(&row[i + 1..], &w[i + 1..])) / row[i];
            }
        }
    }

    /// The multipliers of x_j − F_{j−1} w_{j−1} − c_{j−1} = 0 for the solution w_j of a stage j ≥ 1.
    pub(crate) fn multipliers(&self, j: usize, w: &[f64], to: &mut [f64]) {
        let (shape, factor) = (self.shapes[j], &self.factors[j]);
        to.copy_from_slice(&self.slopes[j][shape.inputs..]);
        let cost = &factor[shape.inputs * shape.stride() + shape.inputs..];
        add_symmetric_times(to, cost, shape.stride(), &w[shape.inputs..]);
        for y in to {
            *y = -*y;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    const SHAPES: [(usize, usize, usize); 4] = [(1, 1, 1), (2, 1, 4), (3, 2, 5), (4, 3, 3)];

    /// A problem by its stages, and as a whole: Hessian and constraint Jacobian over (u_0, x_1, u_1, …, x_N).
    struct Random {
        shapes: Vec<Shape>,
        blocks: Vec<DMatrix<f64>>,
        flow: Vec<Vec<f64>>,
        whole: DMatrix<f64>,
        constraints: DMatrix<f64>,
    }

    impl Random {
        fn new(random: &mut StdRng, (n, m, steps): (usize, usize, usize), shift: f64) -> Self {
            let states = |k: usize| if k == 0 { 0 } else { n };
            let shape = |k| Shape { inputs: if k < steps { m } else { 0 }, states: states(k) };
            let shapes: Vec<Shape> = (0..=steps).map(shape).collect();
            let mut uniform = || random.random_range(-1.0..1.0);
            let blocks: Vec<DMatrix<f64>> = shapes
                .iter()
                .map(|s| {
                    let a = DMatrix::from_fn(s.size(), s.size(), |_, _| uniform());
                    &a + a.transpose() + DMatrix::identity(s.size(), s.size()) * shift
                })
                .collect();
            let flow: Vec<Vec<f64>> =
                shapes[..steps].iter().map(|s| (0..n * s.stride()).map(|_| uniform()).collect()).collect();
            let starts: Vec<usize> =
                shapes.iter().scan(0, |at, s| Some(std::mem::replace(at, *at + s.size()))).collect();
            let variables = shapes.iter().map(|s| s.size()).sum();
            let mut whole = DMatrix::zeros(variables, variables);
            let mut constraints = DMatrix::zeros(steps * n, variables);
            for ((block, &start), s) in blocks.iter().zip(&starts).zip(&shapes) {
                whole.view_mut((start, start), (s.size(), s.size())).copy_from(block);
            }
            for k in 0..steps {
                for i in 0..n {
                    constraints[(k * n + i, starts[k + 1] + shapes[k + 1].inputs + i)] = 1.0;
                    for v in 0..shapes[k].size() {
                        constraints[(k * n + i, starts[k] + v)] -= flow[k][i * shapes[k].stride() + v];
                    }
                }
            }
            Self { shapes, blocks, flow, whole, constraints }
        }

        fn factorized(&self, n: usize) -> Option<Recursion> {
            let mut recursion = Recursion::new(n, self.shapes.clone());
            let fill = |j: usize, to: &mut [f64]| {
                let stride = self.shapes[j].stride();
                for (a, b) in (0..self.shapes[j].size()).flat_map(|a| (a..self.shapes[j].size()).map(move |b| (a, b))) {
                    to[a * stride + b] = self.blocks[j][(a, b)];
                }
            };
            recursion.factorize(|j| &self.flow[j], fill).then_some(recursion)
        }
    }

    #[test]
    fn the_solution_is_that_of_the_whole_system() {
        let mut random = StdRng::seed_from_u64(3);
        for shape @ (n, _, steps) in SHAPES {
            let of = Random::new(&mut random, shape, 8.0);
            let mut recursion = of.factorized(n).unwrap();
            let g: Vec<Vec<f64>> =
                of.shapes.iter().map(|s| (0..s.size()).map(|_| random.random_range(-1.0..1.0)).collect()).collect();
            let (variables, rows) = (of.whole.nrows(), of.constraints.nrows());
            let mut kkt = DMatrix::zeros(variables + rows, variables + rows);
            kkt.view_mut((0, 0), (variables, variables)).copy_from(&of.whole);
            kkt.view_mut((variables, 0), (rows, variables)).copy_from(&of.constraints);
            kkt.view_mut((0, variables), (variables, rows)).copy_from(&of.constraints.transpose());
            let factors = kkt.lu();
            for affine in [true, false] {
                let mut w = g.clone();
                recursion.solve(|j| &of.flow[j], &g, affine, &mut w);
                let constant = |k: usize, i: usize| of.flow[k][(i + 1) * of.shapes[k].stride() - 1];
                let c = (0..rows).map(|row| if affine { constant(row / n, row % n) } else { 0.0 });
                let right: Vec<f64> = g.iter().flatten().map(|g| -g).chain(c).collect();
                let solved = factors.solve(&DVector::from_vec(right)).unwrap();
                w.iter().flatten().zip(solved.iter()).for_each(|(w, v)| assert!((w - v).abs() < 1e-9));
                for k in 1..=steps {
                    let mut y = vec![0.0; n];
                    recursion.multipliers(k, &w[k], &mut y);
                    let expected = solved.rows(variables + (k - 1) * n, n);
                    y.iter().zip(expected.iter()).for_each(|(y, v)| assert!((y - v).abs() < 1e-9));
                }
            }
        }
    }

    #[test]
    fn it_factorizes_exactly_where_the_hessian_is_positive_on_the_dynamics() {
        let mut random = StdRng::seed_from_u64(4);
        let mut counts = [0, 0];
        for trial in 0..200 {
            let shape @ (n, m, steps) = SHAPES[trial % SHAPES.len()];
            let shift = random.random_range(-1.0..4.0);
            let of = Random::new(&mut random, shape, shift);
            // Eigenvalues of the Hessian on the null space of the constraints.
            let (q, rows) = (of.constraints.transpose().qr().q(), steps * n);
            let projector = DMatrix::identity(rows + steps * m, rows + steps * m) - &q * q.transpose();
            let values = (&projector * &of.whole * &projector).symmetric_eigen().eigenvalues;
            let negative = values.iter().any(|v| *v < -1e-6);
            let clear = values.iter().filter(|v| v.abs() > 1e-6).count() == steps * m;
            if clear {
                assert_eq!(of.factorized(n).is_some(), !negative, "{trial}");
                counts[usize::from(negative)] += 1;
            }
        }
        assert!(counts.iter().all(|c| *c > 20), "{counts:?}");
    }
}
