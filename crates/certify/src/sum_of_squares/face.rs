//! Exact solutions with singular Gram matrices.
//!
//! Where every solution has a singular Gram matrix, rounding leaves the set of semidefinite matrices. Its null space is then
//! recognized from the numerical solution, in rational numbers; on the orthogonal complement the matrices are regular again.

use bracketry_lie::linear::RationalMatrix;
use bracketry_symbolic::{Limit, Rational};
use nalgebra::{DMatrix, SymmetricEigen};

use crate::gram::Gram;
use crate::monomials::product;
use crate::sum_of_squares::decimals::rounded;
use crate::sum_of_squares::numeric::{Numeric, rows};
use crate::sum_of_squares::program::{Constraint, Program};

/// Eigenvalues below this, relative to the largest, are taken for zero: the first that gives an exact solution.
const ZERO: [f64; 3] = [1e-5, 1e-4, 1e-3];
/// Distance of an entry of the null space from the rational number that it is taken for.
const NEAR: f64 = 2e-3;
/// Most equations of the exact solution.
const MAX_EQUATIONS: usize = 120;
/// Decimal digits that are tried.
const DIGITS: [i32; 3] = [3, 6, 9];

/// Unknowns and Gram matrices that satisfy all constraints exactly.
pub(super) fn on_face(program: &Program, numeric: &Numeric, limit: &Limit) -> Option<(Vec<Rational>, Vec<Gram>)> {
    for zero in ZERO {
        let bases: Vec<Vec<Vec<Rational>>> =
            numeric.matrices.iter().map(|q| range(q, zero)).collect::<Option<Vec<_>>>()?;
        for digits in DIGITS {
            if limit.is_reached() {
                return None;
            }
            if let Some(found) = solved(program, numeric, &bases, digits) {
                return Some(found);
            }
        }
    }
    None
}

/// A rational basis of the range of a numerical matrix, whose eigenvalues below `zero` count as zero.
fn range(q: &DMatrix<f64>, zero: f64) -> Option<Vec<Vec<Rational>>> {
    let n = q.nrows();
    if n == 0 {
        return Some(Vec::new());
    }
    let eigen = SymmetricEigen::try_new(q.clone(), 1e-14, 1000)?;
    let largest = eigen.eigenvalues.amax();
    let null: Vec<usize> = (0..n).filter(|&k| eigen.eigenvalues[k] <= zero * largest).collect();
    let mut rows: Vec<Vec<f64>> =
        null.iter().map(|&k| eigen.eigenvectors.column(k).iter().copied().collect()).collect();
    reduce(&mut rows);
    let exact = rows.iter().map(|row| row.iter().map(|&x| simple(x)).collect()).collect();
    Some(RationalMatrix::new(exact, n).null_space())
}

/// Reduced row echelon form, with the largest pivots first.
fn reduce(rows: &mut [Vec<f64>]) {
    let columns = rows.first().map_or(0, Vec::len);
    for k in 0..rows.len() {
        let best = (k..rows.len()).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let Some((i, j)) = best.max_by(|a, b| rows[a.0][a.1].abs().total_cmp(&rows[b.0][b.1].abs())) else { return };
        rows.swap(k, i);
        let pivot = rows[k][j];
        if pivot == 0.0 {
            return;
        }
        rows[k].iter_mut().for_each(|x| *x /= pivot);
        let row = rows[k].clone();
        for other in (0..rows.len()).filter(|i| *i != k) {
            let factor = rows[other][j];
            rows[other].iter_mut().zip(&row).for_each(|(x, r)| *x -= factor * r);
        }
    }
}

/// The simplest rational number next to a number.
fn simple(x: f64) -> Rational {
    let width = NEAR * x.abs().max(0.05);
    let (Ok(low), Ok(high)) = (Rational::try_from(x - width), Rational::try_from(x + width)) else {
        return Rational::ZERO;
    };
    if low <= Rational::ZERO && high >= Rational::ZERO { Rational::ZERO } else { Rational::simplest_in(low, high) }
}

/// R of Q = Bᵀ R B in the sense of least squares, by its entries on and above the diagonal.
fn coordinates(q: &DMatrix<f64>, basis: &[Vec<Rational>]) -> Option<Vec<f64>> {
    let r = basis.len();
    if r == 0 {
        return Some(Vec::new());
    }
    let b = DMatrix::from_fn(r, q.nrows(), |i, j| basis[i][j].to_f64().value());
    let inverse = (&b * b.transpose()).try_inverse()?;
    let m = &inverse * &b * q * b.transpose() * &inverse;
    Some((0..r).flat_map(|i| (i..r).map(move |j| (i, j))).map(|(i, j)| m[(i, j)]).collect())
}

fn pairs(r: usize) -> Vec<(usize, usize)> {
    (0..r).flat_map(|i| (i..r).map(move |j| (i, j))).collect()
}

/// One equation: factors of the entries of all R and of the unknowns, and the right-hand side.
type Equation = (Vec<Rational>, Rational);

/// The equations of one constraint; its entries of R start at `first`, the unknowns at `unknowns`, of `total` columns.
fn equations(c: &Constraint, basis: &[Vec<Rational>], first: usize, unknowns: usize, total: usize) -> Vec<Equation> {
    let rows = rows(c);
    let mut list: Vec<Equation> =
        rows.keys().map(|m| (vec![Rational::ZERO; total], c.polynomial.constant.coefficient(m))).collect();
    for (k, &(a, b)) in pairs(basis.len()).iter().enumerate() {
        for i in 0..c.basis.len() {
            for j in 0..c.basis.len() {
                let mut factor = &basis[a][i] * &basis[b][j];
                if a != b {
                    factor += &basis[b][i] * &basis[a][j];
                }
                if factor != Rational::ZERO {
                    list[rows[&product(&c.basis[i], &c.basis[j])]].0[first + k] += factor;
                }
            }
        }
    }
    for (k, p) in c.polynomial.linear.iter().enumerate() {
        for (m, row) in &rows {
            list[*row].0[unknowns + k] -= p.coefficient(m);
        }
    }
    list
}

/// The solution of the equations next to the rounded numerical one, where its matrices are semidefinite.
fn solved(
    program: &Program,
    numeric: &Numeric,
    bases: &[Vec<Vec<Rational>>],
    digits: i32,
) -> Option<(Vec<Rational>, Vec<Gram>)> {
    let sizes: Vec<usize> = bases.iter().map(|b| pairs(b.len()).len()).collect();
    let unknowns: usize = sizes.iter().sum();
    let total = unknowns + program.unknowns;
    let mut start = Vec::with_capacity(total);
    let mut system: Vec<Equation> = Vec::new();
    for ((c, q), basis) in program.constraints.iter().zip(&numeric.matrices).zip(bases) {
        let first = start.len();
        start.extend(rounded(&coordinates(q, basis)?, digits));
        system.extend(equations(c, basis, first, unknowns, total));
    }
    start.extend(rounded(&numeric.unknowns, digits));
    if system.len() > MAX_EQUATIONS {
        return None;
    }
    let solution = nearest(&system, start)?;
    let mut first = 0;
    let mut grams = Vec::new();
    for ((c, basis), size) in program.constraints.iter().zip(bases).zip(sizes) {
        let gram = assembled(c, basis, &solution[first..first + size]);
        first += size;
        if !gram.is_semidefinite() || gram.polynomial() != c.polynomial.at(&solution[unknowns..]) {
            return None;
        }
        grams.push(gram);
    }
    Some((solution[unknowns..].to_vec(), grams))
}

fn assembled(c: &Constraint, basis: &[Vec<Rational>], entries: &[Rational]) -> Gram {
    let n = c.basis.len();
    let mut matrix = vec![vec![Rational::ZERO; n]; n];
    for (&(a, b), value) in pairs(basis.len()).iter().zip(entries) {
        for i in 0..n {
            for j in 0..n {
                let mut factor = &basis[a][i] * &basis[b][j];
                if a != b {
                    factor += &basis[b][i] * &basis[a][j];
                }
                matrix[i][j] += factor * value;
            }
        }
    }
    Gram { monomials: c.basis.clone(), matrix }
}

/// The point of {x : M x = b} next to `start`: x + Mᵀ λ with M Mᵀ λ = b − M x.
fn nearest(system: &[Equation], start: Vec<Rational>) -> Option<Vec<Rational>> {
    let dot = |a: &[Rational], b: &[Rational]| {
        a.iter().zip(b).filter(|(x, _)| **x != Rational::ZERO).fold(Rational::ZERO, |s, (x, y)| s + x * y)
    };
    let rows: Vec<Vec<Rational>> = system
        .iter()
        .map(|(row, right)| {
            let missing = right - dot(row, &start);
            system.iter().map(|(other, _)| dot(row, other)).chain([-missing]).collect()
        })
        .collect();
    let last = system.len();
    let kernel = RationalMatrix::new(rows, last + 1).null_space();
    let multipliers = kernel.into_iter().find(|v| v[last] != Rational::ZERO)?;
    let mut x = start;
    for ((row, _), factor) in system.iter().zip(&multipliers) {
        if *factor != Rational::ZERO {
            for (sum, m) in x.iter_mut().zip(row) {
                *sum += factor * m;
            }
        }
    }
    Some(x)
}
