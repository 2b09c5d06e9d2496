//! States that inputs hold at rest but for critical modes.

use bracketry_symbolic::{Echelon, FieldElement, Real};

use crate::feedback::lyapunov::{PolynomialField, Shown};
use crate::linear::matrix::Matrix;
use crate::linear::polynomial::{RealPolynomial, unit};
use crate::linear::spectrum::Spectrum;

/// Degree up to which the rates of several modes are looked at.
pub(crate) const SLOW_DEGREE: u32 = 3;

/// s' = β(s, v) at the states X(s, v) with inputs U(s, v) where F(X, U) = Σ β_j e_j with constant vectors e_j: critical modes
/// s_j = w_j·x that the linearization of x' = F(x, u) at the origin leaves at rest, and free parameters v, one for each input.
pub(crate) struct SlowEquilibria {
    /// w_j, with w_j·e_i = 1 for i = j and 0 else.
    pub(crate) modes: Vec<Vec<Real>>,
    /// β_j up to a degree; the variables are all s and v.
    pub(crate) rates: Vec<RealPolynomial>,
}

impl SlowEquilibria {
    /// Of F in `states` states and the inputs, known up to a degree, with as many modes as combinations of the components have no
    /// linear terms; `None` without any, and where such a mode is no coordinate beside those that inputs move. X and U follow degree
    /// by degree from n of the equations [A B] (X, U) = Σ β_j e_j − …, w_j·X = s_j (implicit function theorem).
    pub(crate) fn of(field: &[RealPolynomial], inputs: usize, degree: u32) -> Option<Self> {
        let n = field.len();
        let linear: Vec<Vec<Real>> =
            field.iter().map(|f| (0..n + inputs).map(|k| f.coefficient(&unit(n + inputs, k))).collect()).collect();
        let linear = Matrix::new(linear, n + inputs);
        let Echelon { rows: modes, pivots: left_out, .. } = Echelon::new(&linear.transposed().null_space(), n);
        if modes.is_empty() {
            return None;
        }
        // The equations that the others imply are replaced by w_j·X = s_j.
        let mut rows: Vec<Vec<Real>> = linear.rows().to_vec();
        for (mode, &i) in modes.iter().zip(&left_out) {
            rows[i] = mode.iter().cloned().chain(vec![Real::ZERO; inputs]).collect();
        }
        let equations = Matrix::new(rows, n + inputs);
        let pivots = Echelon::new(equations.rows(), n + inputs).pivots;
        if pivots.len() < n {
            return None;
        }
        let square = equations.rows().iter().map(|r| pivots.iter().map(|&p| r[p].clone()).collect()).collect();
        let inverse = Matrix::new(square, n).inverse()?;
        let k = modes.len();
        let variables = k + inputs;
        let mut motion = vec![RealPolynomial::default(); n + inputs];
        for (&p, row) in pivots.iter().zip(inverse.rows()) {
            for (j, &i) in left_out.iter().enumerate() {
                motion[p].add_term(unit(variables, j), row[i].clone());
            }
        }
        for (l, v) in equations.null_space().into_iter().enumerate() {
            for (x, c) in motion.iter_mut().zip(v) {
                x.add_term(unit(variables, k + l), c);
            }
        }
        let mut rates = vec![RealPolynomial::default(); k];
        for order in 2..=degree {
            let rest: Vec<RealPolynomial> =
                field.iter().map(|f| f.composed(&motion, variables, order).of_degree(order)).collect();
            for (rate, mode) in rates.iter_mut().zip(&modes) {
                for (c, r) in mode.iter().zip(&rest) {
                    *rate = rate.plus(r, c);
                }
            }
            for (&p, row) in pivots.iter().zip(inverse.rows()) {
                for (i, r) in rest.iter().enumerate().filter(|(i, _)| !left_out.contains(i)) {
                    motion[p] = motion[p].plus(r, &-row[i].clone());
                }
            }
        }
        Some(SlowEquilibria { modes, rates })
    }

    /// Whether some Lipschitz continuous v = φ(s) makes s' = β(s, φ(s)), expanded to degree [`SLOW_DEGREE`], asymptotically stable for
    /// all terms of higher degree.
    ///
    /// - Terms of degree 2: v = κ ‖s‖ c with a large κ, where v enters them by Σ v_i B_i s alone and Σ c_i B_i is Hurwitz. In the norm
    ///   in which its flow contracts, ‖s‖' ≤ −(κ − const) ‖s‖².
    /// - Terms of degree 3: v = L s + κ |s|² c, where L cancels the terms of degree 2 and a polynomial Lyapunov function is found for
    ///   the terms of degree 3. A homogeneous system that is asymptotically stable remains so for any terms of higher degree
    ///   (Massera 1956).
    ///
    /// The feedback u = U(s, φ(s)) + K (x − X(s, φ(s))) then stabilizes, as for one mode: the deviation from X is of the order of β.
    pub(crate) fn attract(&self, inputs: usize) -> bool {
        self.by_linear_terms(inputs) || self.by_cubic_terms(inputs)
    }

    /// B_i of the terms Σ v_i B_i s, by rows; `None` where products of the v_i are among the terms of degree 2.
    fn multiplied(&self, inputs: usize) -> Option<Vec<Vec<Vec<Real>>>> {
        let k = self.modes.len();
        if self
            .rates
            .iter()
            .any(|r| r.terms().any(|(m, _)| m[..k].iter().all(|e| *e == 0) && m.iter().sum::<u32>() == 2))
        {
            return None;
        }
        let entry = |r: &RealPolynomial, i: usize, l: usize| r.coefficient(&product(k + inputs, k + i, l));
        let row = |r, i| (0..k).map(|l| entry(r, i, l)).collect();
        Some((0..inputs).map(|i| self.rates.iter().map(|r| row(r, i)).collect()).collect())
    }

    fn by_linear_terms(&self, inputs: usize) -> bool {
        let k = self.modes.len();
        let Some(matrices) = self.multiplied(inputs) else { return false };
        directions(inputs, &[1]).iter().any(|c| {
            let entry = |j: usize, l: usize| {
                let terms = matrices.iter().zip(c).map(|(b, c)| &b[j][l] * Real::from(*c));
                terms.fold(Real::ZERO, |sum, x| sum + x)
            };
            let rows = (0..k).map(|j| (0..k).map(|l| entry(j, l)).collect()).collect();
            Spectrum::of_reals(&Matrix::new(rows, k)).is_some_and(|s| (s.right, s.on_axis) == (0, 0))
        })
    }

    fn by_cubic_terms(&self, inputs: usize) -> bool {
        let k = self.modes.len();
        let Some(linear) = self.canceling(inputs) else { return false };
        let mut square = RealPolynomial::default();
        for j in 0..k {
            square.add_term(product(k, j, j), Real::ONE);
        }
        let mut all = directions(inputs, &[1, 10]);
        all.push(vec![0; inputs]);
        all.iter().any(|c| {
            let of_modes = (0..k).map(|j| RealPolynomial::term(Real::ONE, unit(k, j)));
            let of_inputs = c.iter().zip(&linear).map(|(c, l)| l.plus(&square, &Real::from(*c)));
            let values: Vec<RealPolynomial> = of_modes.chain(of_inputs).collect();
            let field: Vec<RealPolynomial> = self.rates.iter().map(|r| r.composed(&values, k, SLOW_DEGREE)).collect();
            field.iter().all(|f| f.of_degree(2).is_zero())
                && matches!(PolynomialField(&field).shown(), Some(Shown::Attracts(_)))
        })
    }

    /// v = L s without terms of degree 2 in β(s, L s), one polynomial for each v; 0 where these are products of the v_i.
    fn canceling(&self, inputs: usize) -> Option<Vec<RealPolynomial>> {
        let k = self.modes.len();
        let Some(matrices) = self.multiplied(inputs) else {
            return Some(vec![RealPolynomial::default(); inputs]);
        };
        // One equation for each rate and each product of two modes, in the entries of L and then the terms without v.
        let unknowns = inputs * k;
        let mut equations = Vec::new();
        for (j, rate) in self.rates.iter().enumerate() {
            for (a, b) in (0..k).flat_map(|a| (a..k).map(move |b| (a, b))) {
                let mut row = vec![Real::ZERO; unknowns + 1];
                for (i, matrix) in matrices.iter().enumerate() {
                    row[i * k + a] += &matrix[j][b];
                    if a != b {
                        row[i * k + b] += &matrix[j][a];
                    }
                }
                row[unknowns] = rate.coefficient(&product(k + inputs, a, b));
                equations.push(row);
            }
        }
        let solved = Echelon::new(&equations, unknowns + 1);
        if solved.pivots.contains(&unknowns) {
            return None;
        }
        let mut linear = vec![RealPolynomial::default(); inputs];
        for (row, &p) in solved.rows.iter().zip(&solved.pivots) {
            linear[p / k].add_term(unit(k, p % k), -row[unknowns].clone());
        }
        Some(linear)
    }
}

/// The exponents of the product of two of n variables.
fn product(n: usize, a: usize, b: usize) -> Vec<u32> {
    unit(n, a).iter().zip(unit(n, b)).map(|(x, y)| x + y).collect()
}

/// Values of the parameters that are tried, up to a factor: all of 0, ± each size, but not all 0.
fn directions(inputs: usize, sizes: &[i64]) -> Vec<Vec<i64>> {
    let mut list = vec![Vec::new()];
    for _ in 0..inputs {
        let values = |c: &Vec<i64>| {
            let signed = sizes.iter().flat_map(|s| [*s, -s]).chain([0]);
            signed.map(|v| c.iter().copied().chain([v]).collect()).collect::<Vec<_>>()
        };
        list = list.iter().flat_map(values).collect();
    }
    list.retain(|c| c.iter().any(|v| *v != 0));
    list
}
