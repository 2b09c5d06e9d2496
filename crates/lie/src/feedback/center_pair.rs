//! A pair of eigenvalues ±iω: center manifolds of dimension 2, and Lyapunov's focal values.

use std::cmp::Ordering;

use bracketry_symbolic::{Echelon, FieldElement, OrderedField, Real};

use crate::linear::matrix::{Matrix, quotient_by_reachable};
use crate::linear::polynomial::{RealPolynomial, unit};
use crate::linear::spectrum::squared_frequency;

/// Most unknowns in the equations for the terms of one degree.
const MAX_UNKNOWNS: usize = 120;

/// x' = F(x, u) at the origin, where the modes that no input reaches have a pair of eigenvalues ±iω, simple, and otherwise decay.
pub(crate) struct CenterPair<'a> {
    /// F, in the states and then the inputs.
    field: &'a [RealPolynomial],
    inputs: usize,
    /// Two rows w: the coordinates z = w x of the pair.
    modes: Vec<Vec<Real>>,
    /// z' = M z to first order.
    motion: Vec<Vec<Real>>,
}

/// A manifold x = X(z), u = U(z) to which feedback keeps the motion, with z' = G(z) on it, up to a degree.
struct Manifold {
    /// X and U.
    shape: Vec<RealPolynomial>,
    /// G.
    rate: Vec<RealPolynomial>,
}

impl<'a> CenterPair<'a> {
    /// `None` where the modes that no input reaches have no such pair, or more.
    pub(crate) fn of(field: &'a [RealPolynomial], inputs: usize) -> Option<Self> {
        let n = field.len();
        let entry = |i: usize, k: usize| field[i].coefficient(&unit(n + inputs, k));
        let a = Matrix::new((0..n).map(|i| (0..n).map(|k| entry(i, k)).collect()).collect(), n);
        let b: Vec<Vec<Real>> = (0..inputs).map(|k| (0..n).map(|i| entry(i, n + k)).collect()).collect();
        let transposed = a.transposed();
        let rest = quotient_by_reachable(&a, &Matrix::new(b.clone(), n));
        let axis = &squared_frequency(&rest.characteristic_polynomial())?;
        // w (A² + ω²) = 0, and w annihilates the space that the inputs reach.
        let mut rows = Echelon::invariant(&b, n, |v| a.times(v)).rows;
        for i in 0..n {
            let e: Vec<Real> = (0..n).map(|j| if i == j { Real::ONE } else { Real::ZERO }).collect();
            let mut row = a.times(&a.times(&e));
            row[i] += axis;
            rows.push(row);
        }
        let modes = Matrix::new(rows, n).null_space();
        let [first, second] = &modes[..] else { return None };
        // The coefficients of w A in the basis of the modes: these have entries 1 and 0 where the others have 0 and 1.
        let place = |w: &[Real], other: &[Real]| (0..n).rev().find(|&i| w[i] == Real::ONE && other[i] == Real::ZERO);
        let (p, q) = (place(first, second)?, place(second, first)?);
        let motion = modes.iter().map(|w| transposed.times(w)).map(|v| vec![v[p].clone(), v[q].clone()]).collect();
        Some(CenterPair { field, inputs, modes, motion })
    }

    /// The first focal value that does not vanish, up to a degree of F: with a positive definite quadratic form q of the pair,
    /// V = q + … has V' = l q^((k + 1)/2) + … with the odd k, by which the degree of l is told; `None` where all vanish.
    ///
    /// Asymptotically stable on the center manifold for l < 0, unstable for l > 0 (Lyapunov 1892; Carr 1981 for the whole system).
    pub(crate) fn focal_value(&self, degree: u32) -> Option<(u32, Real)> {
        let mut manifold = self.first()?;
        for k in 2..=degree {
            self.extend(&mut manifold, k)?;
        }
        self.focal_value_of(&manifold.rate, degree)
    }

    /// Whether smooth feedback u = U + K (x − X) makes the first focal value negative (Abed and Fu 1986): it is affine in the terms of
    /// degree 2 of X and U that are free, and has any sign unless it does not depend on them.
    pub(crate) fn attracts_by_feedback(&self) -> Option<bool> {
        let mut manifold = self.first()?;
        let free = self.solutions(2, &vec![RealPolynomial::default(); self.field.len()])?.1;
        for h in free {
            // z' gains the terms of w F that are products of X_1, U_1 and h.
            let gain: Vec<RealPolynomial> = [1, 0]
                .map(|with: i64| {
                    let shape: Vec<_> =
                        manifold.shape.iter().zip(&h).map(|(x, h)| x.plus(h, &Real::from(with))).collect();
                    self.of_modes(&shape, 3)
                })
                .into_iter()
                .reduce(|a, b| a.iter().zip(&b).map(|(a, b)| a.plus(b, &-Real::ONE)).collect())?;
            let linear: Vec<RealPolynomial> = self.linear_rate();
            let rate: Vec<_> = linear.iter().zip(&gain).map(|(m, g)| m.plus(g, &Real::ONE)).collect();
            if self.focal_value_of(&rate, 3).is_some() {
                return Some(true);
            }
        }
        for k in 2..=3 {
            self.extend(&mut manifold, k)?;
        }
        Some(self.focal_value_of(&manifold.rate, 3).is_some_and(|(_, l)| l.is_negative()))
    }

    /// M z.
    fn linear_rate(&self) -> Vec<RealPolynomial> {
        let row = |m: &Vec<Real>| {
            let mut p = RealPolynomial::default();
            p.add_term(vec![1, 0], m[0].clone());
            p.add_term(vec![0, 1], m[1].clone());
            p
        };
        self.motion.iter().map(row).collect()
    }

    /// w F(X, U) up to a degree.
    fn of_modes(&self, shape: &[RealPolynomial], degree: u32) -> Vec<RealPolynomial> {
        let all: Vec<RealPolynomial> = self.field.iter().map(|f| f.composed(shape, 2, degree)).collect();
        self.modes.iter().map(|w| combined(&all, w)).collect()
    }

    /// The linear part: w X = z, and X, U carry z' = M z.
    fn first(&self) -> Option<Manifold> {
        let n = self.field.len();
        let mut manifold =
            Manifold { shape: vec![RealPolynomial::default(); n + self.inputs], rate: self.linear_rate() };
        manifold.shape = self.solutions(1, &vec![RealPolynomial::default(); n])?.0;
        Some(manifold)
    }

    /// The terms of degree k ≥ 2.
    fn extend(&self, manifold: &mut Manifold, k: u32) -> Option<()> {
        let all: Vec<RealPolynomial> =
            self.field.iter().map(|f| f.composed(&manifold.shape, 2, k).of_degree(k)).collect();
        for (g, w) in manifold.rate.iter_mut().zip(&self.modes) {
            *g = g.plus(&combined(&all, w), &Real::ONE);
        }
        // DX_k M z − A X_k − B U_k = F_k − Σ_{j < k} DX_j G_{k − j + 1}.
        let right: Vec<RealPolynomial> = all
            .iter()
            .zip(&manifold.shape)
            .map(|(f, x)| {
                let carried = (0..2).fold(RealPolynomial::default(), |sum, i| {
                    sum.plus(&x.derivative(i).times_up_to(&manifold.rate[i], k), &Real::ONE)
                });
                f.plus(&carried.of_degree(k), &-Real::ONE)
            })
            .collect();
        let found = self.solutions(k, &right)?.0;
        for (x, h) in manifold.shape.iter_mut().zip(found) {
            *x = x.plus(&h, &Real::ONE);
        }
        Some(())
    }

    /// The forms X, U of degree k with DX·M z − A X − B U = R and w X = z for k = 1, 0 above: one solution, and a basis of the
    /// differences of solutions.
    fn solutions(&self, k: u32, right: &[RealPolynomial]) -> Option<(Forms, Vec<Forms>)> {
        let (n, m) = (self.field.len(), self.inputs);
        let monomials: Vec<Vec<u32>> = (0..=k).map(|j| vec![k - j, j]).collect();
        let size = monomials.len();
        let unknowns = (n + m) * size;
        if unknowns > MAX_UNKNOWNS {
            return None;
        }
        // Unknown (x, j) is the coefficient of monomial j in component x; the last column is the right side.
        let mut rows = vec![vec![Real::ZERO; unknowns + 1]; n * size];
        let linear = self.linear_rate();
        for (j, monomial) in monomials.iter().enumerate() {
            let carried = carried(monomial, &linear);
            for (l, target) in monomials.iter().enumerate() {
                let c = carried.coefficient(target);
                for i in 0..n {
                    rows[i * size + l][i * size + j] += &c;
                }
            }
            for i in 0..n {
                for x in 0..n + m {
                    rows[i * size + j][x * size + j] -= self.field[i].coefficient(&unit(n + m, x));
                }
                rows[i * size + j][unknowns] = right[i].coefficient(monomial);
            }
        }
        for (which, w) in self.modes.iter().enumerate() {
            for (j, monomial) in monomials.iter().enumerate() {
                let mut row = vec![Real::ZERO; unknowns + 1];
                for (i, c) in w.iter().enumerate() {
                    row[i * size + j].clone_from(c);
                }
                if k == 1 && monomial[which] == 1 {
                    row[unknowns] = Real::ONE;
                }
                rows.push(row);
            }
        }
        let forms = |v: &[Real]| -> Forms {
            v[..unknowns]
                .chunks(size)
                .map(|list| {
                    let mut p = RealPolynomial::default();
                    for (c, monomial) in list.iter().zip(&monomials) {
                        p.add_term(monomial.clone(), c.clone());
                    }
                    p
                })
                .collect()
        };
        let null = Matrix::new(rows, unknowns + 1).null_space();
        // The vector with −1 in the last column stands for a solution.
        let solution = null.iter().find(|v| v[unknowns] != Real::ZERO)?;
        let scale = -Real::ONE / &solution[unknowns];
        let solution: Vec<Real> = solution.iter().map(|c| c * &scale).collect();
        let free = null.iter().filter(|v| v[unknowns] == Real::ZERO).map(|v| forms(v)).collect();
        Some((forms(&solution), free))
    }

    /// The same for z' = G(z).
    fn focal_value_of(&self, rate: &[RealPolynomial], degree: u32) -> Option<(u32, Real)> {
        let [first, second] = &self.motion[..] else { return None };
        // M has trace 0, so that M₂₁ z₁² + (M₂₂ − M₁₁) z₁ z₂ − M₁₂ z₂² is constant along z' = M z, and definite.
        let mut q = RealPolynomial::default();
        q.add_term(vec![2, 0], second[0].clone());
        q.add_term(vec![1, 1], &second[1] - &first[0]);
        q.add_term(vec![0, 2], -first[1].clone());
        // Definite, so that it is not 0.
        let q = if second[0].sign()? == Ordering::Less { q.negative() } else { q };
        let linear = self.linear_rate();
        let mut v = q.clone();
        let mut power = q.clone();
        for k in 3..=degree + 1 {
            // DV_k M z − l q^(k/2) = −R_k, where l belongs to even k only.
            let rest = (0..2).fold(RealPolynomial::default(), |sum, i| {
                sum.plus(&v.derivative(i).times_up_to(&rate[i], k), &Real::ONE)
            });
            let rest = rest.of_degree(k);
            let monomials: Vec<Vec<u32>> = (0..=k).map(|j| vec![k - j, j]).collect();
            let size = monomials.len();
            let even = k % 2 == 0;
            if even {
                power = power.product(&q);
            }
            let mut rows = vec![vec![Real::ZERO; size + 2]; size];
            for (j, monomial) in monomials.iter().enumerate() {
                let carried = carried(monomial, &linear);
                for (l, target) in monomials.iter().enumerate() {
                    rows[l][j] = carried.coefficient(target);
                }
                rows[j][size] = if even { -power.coefficient(monomial) } else { Real::ZERO };
                rows[j][size + 1] = rest.coefficient(monomial);
            }
            let null = Matrix::new(rows, size + 2).null_space();
            let found = null.iter().find(|x| x[size + 1] != Real::ZERO)?;
            let l = &found[size] / &found[size + 1];
            if even && l != Real::ZERO {
                return Some((k - 1, l));
            }
            for (monomial, c) in monomials.iter().zip(found) {
                v.add_term(monomial.clone(), c / &found[size + 1]);
            }
        }
        None
    }
}

/// A polynomial for each state and input.
type Forms = Vec<RealPolynomial>;

fn combined(list: &[RealPolynomial], c: &[Real]) -> RealPolynomial {
    list.iter().zip(c).fold(RealPolynomial::default(), |sum, (p, c)| sum.plus(p, c))
}

/// The derivative of a monomial in two variables along a field.
fn carried(monomial: &[u32], field: &[RealPolynomial]) -> RealPolynomial {
    let p = RealPolynomial::term(Real::ONE, monomial.to_vec());
    (0..2).fold(RealPolynomial::default(), |sum, i| sum.plus(&p.derivative(i).product(&field[i]), &Real::ONE))
}
