//! Semidefinite combinations of quadratic forms.

use bracketry_numerics::eigen::symmetric_eigen;
use bracketry_symbolic::{Rational, UnivariatePolynomial};
use nalgebra::{DMatrix, DVector};

use crate::linear::form::signs;
use crate::linear::matrix::RationalMatrix;

/// Most forms, and most variables.
const MAX_FORMS: usize = 6;
const MAX_VARIABLES: usize = 10;
/// Steps to a combination whose least eigenvalue is large.
const STEPS: usize = 100;
/// Most vectors on which a combination is made to vanish.
const MAX_VECTORS: usize = 40;
/// An eigenvalue smaller than this, relative to the forms, may stand for 0.
const SMALL: f64 = 0.05;
/// Most of them one after the other.
const MAX_DEPTH: usize = 2;
/// Denominators to which numbers are rounded.
const DENOMINATORS: [i64; 7] = [1, 2, 3, 4, 5, 6, 12];

/// Coefficients λ, not all zero, for which Σ λ_i Q_i is semidefinite, seen exactly. Those of two forms are all found up to irrational
/// ones; of more, floating point proposes some.
pub(crate) fn semidefinite_combinations(forms: &[RationalMatrix]) -> Vec<Vec<Rational>> {
    let Some(n) = forms.first().map(|q| q.rows().len()) else { return Vec::new() };
    if forms.len() > MAX_FORMS || n > MAX_VARIABLES {
        return Vec::new();
    }
    let mut proposed = proposed(forms, MAX_DEPTH);
    for i in 0..forms.len() {
        for j in 0..i {
            proposed.extend(of_two(&forms[i], &forms[j]).into_iter().map(|[a, b]| {
                let place = |k: usize| {
                    if k == i {
                        a.clone()
                    } else if k == j {
                        b.clone()
                    } else {
                        Rational::ZERO
                    }
                };
                (0..forms.len()).map(place).collect::<Vec<_>>()
            }));
        }
    }
    let mut found: Vec<Vec<Rational>> = Vec::new();
    for c in proposed {
        if c.iter().any(|x| *x != Rational::ZERO)
            && signs(&combined(forms, &c)) != Some((true, true))
            && !found.contains(&c)
        {
            found.push(c);
        }
    }
    found
}

fn combined(forms: &[RationalMatrix], c: &[Rational]) -> RationalMatrix {
    let n = forms[0].rows().len();
    let entry = |i: usize, j: usize| forms.iter().zip(c).fold(Rational::ZERO, |s, (q, c)| s + c * &q.rows()[i][j]);
    RationalMatrix::new((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect(), n)
}

/// (a, b) for a Q + b P: the set of τ for which Q + τ P is semidefinite is bounded by roots of the coefficients of its characteristic
/// polynomial, so that it has one of the rational roots or a number beside a root in it.
fn of_two(q: &RationalMatrix, p: &RationalMatrix) -> Vec<[Rational; 2]> {
    let n = q.rows().len();
    let pair = [q.clone(), p.clone()];
    let at = |x: &Rational| combined(&pair, &[Rational::ONE, x.clone()]).characteristic_polynomial();
    let nodes: Vec<Rational> = (0..=n).map(Rational::from).collect();
    let values: Vec<UnivariatePolynomial> = nodes.iter().map(at).collect();
    let mut list = vec![[Rational::ZERO, Rational::ONE], [Rational::ONE, Rational::ZERO]];
    for k in 0..n {
        let values =
            values.iter().map(|v| v.coefficients().get(k).cloned().unwrap_or(Rational::ZERO)).collect::<Vec<_>>();
        for root in interpolated(&nodes, &values).roots() {
            let beside = [&root.between[0] - Rational::ONE, &root.between[1] + Rational::ONE];
            let all = root.exact.into_iter().chain(root.between).chain(beside);
            list.extend(all.map(|x| [Rational::ONE, x]));
        }
    }
    list
}

/// The polynomial with these values (Lagrange).
fn interpolated(nodes: &[Rational], values: &[Rational]) -> UnivariatePolynomial {
    let zero = UnivariatePolynomial::new(Vec::new());
    nodes.iter().zip(values).fold(zero, |sum, (x, y)| {
        let start = UnivariatePolynomial::new(vec![y.clone()]);
        let others = nodes.iter().filter(|z| *z != x);
        let basis = others.fold(start, |p, z| {
            let factor = UnivariatePolynomial::new(vec![-z.clone(), Rational::ONE]);
            p.mul(&factor).scaled(&(Rational::ONE / (x - z)))
        });
        sum.add(&basis)
    })
}

/// Combinations near one whose least eigenvalue is as large as it gets. Where that is 0, the combination vanishes on a vector v, which
/// leaves linear equations Σ λ_i Q_i v = 0.
fn proposed(forms: &[RationalMatrix], depth: usize) -> Vec<Vec<Rational>> {
    let count = forms.len();
    let unit = |k: usize| (0..count).map(|i| Rational::from(i64::from(i == k))).collect::<Vec<_>>();
    let mut list: Vec<Vec<Rational>> = (0..count).map(unit).collect();
    if count < 2 || depth == 0 {
        return list;
    }
    let matrices: Vec<DMatrix<f64>> = forms.iter().map(number).collect();
    let size = matrices.iter().map(DMatrix::norm).fold(0.0, f64::max);
    if size == 0.0 {
        return list;
    }
    let mut vectors: Vec<Vec<Rational>> = Vec::new();
    for start in starts(&matrices, size) {
        let Some(attained) = highest(&matrices, size, &start) else { continue };
        list.extend(rounded(&attained.lambda));
        let small = (0..attained.eigenvalues.len()).filter(|&i| attained.eigenvalues[i].abs() < SMALL * size);
        for v in small.flat_map(|i| rounded(&attained.eigenvectors.column(i).into_owned())) {
            if !vectors.contains(&v) {
                vectors.push(v);
            }
        }
    }
    for v in vectors.into_iter().take(MAX_VECTORS) {
        let columns: Vec<Vec<Rational>> = forms.iter().map(|q| q.times(&v)).collect();
        let rows = (0..v.len()).map(|i| columns.iter().map(|c| c[i].clone()).collect()).collect();
        let left = RationalMatrix::new(rows, count).null_space();
        if left.is_empty() || left.len() == count {
            continue;
        }
        let reduced: Vec<RationalMatrix> = left.iter().map(|c| combined(forms, c)).collect();
        for c in proposed(&reduced, depth - 1) {
            let of = |i: usize| left.iter().zip(&c).fold(Rational::ZERO, |s, (l, c)| s + c * &l[i]);
            list.push((0..count).map(of).collect());
        }
    }
    list
}

/// Σ λ_i Q_i with |λ| = 1.
struct Attained {
    lambda: DVector<f64>,
    eigenvalues: DVector<f64>,
    eigenvectors: DMatrix<f64>,
}

/// Directions from which combinations are improved: both of each form, and that of the traces.
fn starts(matrices: &[DMatrix<f64>], size: f64) -> Vec<DVector<f64>> {
    let count = matrices.len();
    let traces = DVector::from_iterator(count, matrices.iter().map(|q| q.trace() / size));
    let mut list: Vec<DVector<f64>> = Some(traces).into_iter().filter(|t| t.norm() > SMALL).collect();
    for k in 0..count {
        list.extend([1.0, -1.0].map(|x| DVector::from_fn(count, |i, _| if i == k { x } else { 0.0 })));
    }
    list
}

/// A combination with a large least eigenvalue, by subgradient steps.
fn highest(matrices: &[DMatrix<f64>], size: f64, start: &DVector<f64>) -> Option<Attained> {
    let (count, n) = (matrices.len(), matrices.first()?.nrows());
    let mut lambda = start.normalize();
    let mut best: Option<Attained> = None;
    for step in 0..STEPS {
        let sum = matrices.iter().zip(lambda.iter()).fold(DMatrix::zeros(n, n), |s, (q, &l)| s + q * l);
        let eigen = symmetric_eigen(sum)?;
        let v = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        if best.as_ref().is_none_or(|b| eigen.eigenvalues.min() > b.eigenvalues.min()) {
            let (eigenvalues, eigenvectors) = (eigen.eigenvalues, eigen.eigenvectors);
            best = Some(Attained { lambda: lambda.clone(), eigenvalues, eigenvectors });
        }
        let slope = |q: &DMatrix<f64>| (v.transpose() * q * &v)[0] / size;
        let gradient = DVector::from_iterator(count, matrices.iter().map(slope));
        lambda += gradient * (1.0 / (1.0 + step as f64).sqrt());
        let norm = lambda.norm();
        if norm < f64::EPSILON {
            return best;
        }
        lambda /= norm;
    }
    best
}

/// The direction of a vector with small denominators.
fn rounded(v: &DVector<f64>) -> Vec<Vec<Rational>> {
    let largest = v.amax();
    let of = |d: i64| -> Option<Vec<Rational>> {
        v.iter()
            .map(|x| Some(Rational::simplest_from_f64((x / largest * d as f64).round())? / Rational::from(d)))
            .collect()
    };
    if largest > 0.0 { DENOMINATORS.into_iter().filter_map(of).collect() } else { Vec::new() }
}

fn number(q: &RationalMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(q.rows().len(), q.rows().len(), |i, j| q.rows()[i][j].to_f64().value())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn form(n: usize, entries: &[i64]) -> RationalMatrix {
        let entry = |i: usize, j: usize| Rational::from(entries[n * i.min(j) + i.max(j)]);
        RationalMatrix::new((0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect(), n)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]

        /// Two forms that a square of a linear function is a combination of, which is the only semidefinite one.
        #[test]
        fn a_square_among_two_forms(v in prop::collection::vec(-3i64..4, 3), w in prop::collection::vec(-3i64..4, 9), a in -3i64..4) {
            let square = form(3, &[v[0] * v[0], v[0] * v[1], v[0] * v[2], 0, v[1] * v[1], v[1] * v[2], 0, 0, v[2] * v[2]]);
            let other = form(3, &w);
            prop_assume!(v.iter().any(|x| *x != 0));
            let first = combined(&[square.clone(), other.clone()], &[Rational::ONE, Rational::from(a)]);
            let found = semidefinite_combinations(&[first, other]);
            prop_assert!(!found.is_empty());
        }

        /// Three forms of which a combination is semidefinite of rank 1, in three variables.
        #[test]
        fn a_square_among_three_forms(v in prop::collection::vec(-1i64..2, 3), w in prop::collection::vec(-3i64..4, 18), c in prop::collection::vec(-2i64..3, 2)) {
            let square = form(3, &[v[0] * v[0], v[0] * v[1], v[0] * v[2], 0, v[1] * v[1], v[1] * v[2], 0, 0, v[2] * v[2]]);
            prop_assume!(v.iter().any(|x| *x != 0));
            let (p, q) = (form(3, &w[..9]), form(3, &w[9..]));
            let c: Vec<Rational> = std::iter::once(1).chain(c).map(Rational::from).collect();
            let first = combined(&[square, p.clone(), q.clone()], &c);
            prop_assert!(!semidefinite_combinations(&[first, p, q]).is_empty());
        }
    }
}
