//! From a numerical solution to an exact one.

use bracketry_lie::linear::MultivariatePolynomial;
use bracketry_symbolic::{Limit, Rational};
use nalgebra::DMatrix;

use crate::gram::Gram;
use crate::monomials::product;
use crate::sum_of_squares::decimals::rounded;
use crate::sum_of_squares::face::on_face;
use crate::sum_of_squares::numeric::{Numeric, rows};
use crate::sum_of_squares::program::{Constraint, Program, Unsolved};

/// A solution in exact arithmetic.
#[derive(Clone, Debug)]
pub(crate) struct Exact {
    /// The unknowns of the original program.
    pub(crate) unknowns: Vec<Rational>,
    /// One for each constraint.
    pub(crate) grams: Vec<Gram>,
}

/// Decimal digits that are tried: few give short certificates.
const DIGITS: [i32; 6] = [2, 3, 4, 6, 9, 13];

/// The Gram matrix next to a numerical one that gives the polynomial exactly: each entry is rounded, and what then is missing
/// of a coefficient is distributed evenly over the entries that belong to it, which is the orthogonal projection (Peyrl and
/// Parrilo 2008). `None` where it is not positive semidefinite.
fn projected(p: &MultivariatePolynomial, c: &Constraint, q: &DMatrix<f64>, digits: i32) -> Option<Gram> {
    let n = c.basis.len();
    let entries = rounded(q.as_slice(), digits);
    let rows = rows(c);
    let mut missing: Vec<Rational> = rows.keys().map(|m| p.coefficient(m)).collect();
    let mut count = vec![0u32; rows.len()];
    let row_of = |i: usize, j: usize| rows[&product(&c.basis[i], &c.basis[j])];
    for i in 0..n {
        for j in 0..n {
            let row = row_of(i, j);
            missing[row] -= &entries[j.max(i) * n + j.min(i)];
            count[row] += 1;
        }
    }
    let share: Vec<Rational> = missing.into_iter().zip(count).map(|(m, k)| m / Rational::from(k.max(1))).collect();
    let matrix =
        (0..n).map(|i| (0..n).map(|j| &entries[j.max(i) * n + j.min(i)] + &share[row_of(i, j)]).collect()).collect();
    let gram = Gram { monomials: c.basis.clone(), matrix };
    (gram.is_semidefinite() && gram.polynomial() == *p).then_some(gram)
}

impl Program {
    /// Solves the program: exact reduction, interior-point method, rounding, exact check of all constraints; in coordinates
    /// x_i = 2^k_i ξ_i, which only the numerical part notices.
    pub(crate) fn certified(self, powers: &[i32], limit: &Limit) -> Result<Exact, Unsolved> {
        let reduced = self.scaled(powers).reduced()?;
        let numeric = reduced.program.solve(limit)?;
        // Without a margin, rounding mostly fails; it succeeds where the solution itself has few digits.
        if numeric.margin < -1e-4 {
            return Err(Unsolved::NotFeasible);
        }
        for digits in DIGITS {
            if limit.is_reached() {
                return Err(Unsolved::OutOfTime);
            }
            let y = rounded(&numeric.unknowns, digits);
            for finer in [0, 3] {
                if let Some(grams) = reduced.program.grams(&numeric, &y, digits + finer) {
                    let grams = grams.into_iter().map(|g| g.unscaled(powers)).collect();
                    return Ok(Exact { unknowns: reduced.original(&y), grams });
                }
            }
        }
        if let Some((y, grams)) = on_face(&reduced.program, &numeric, limit) {
            let grams = grams.into_iter().map(|g| g.unscaled(powers)).collect();
            return Ok(Exact { unknowns: reduced.original(&y), grams });
        }
        Err(if numeric.margin < 1e-7 { Unsolved::NotFeasible } else { Unsolved::NotRounded })
    }

    fn grams(&self, numeric: &Numeric, y: &[Rational], digits: i32) -> Option<Vec<Gram>> {
        self.constraints
            .iter()
            .zip(&numeric.matrices)
            .map(|(c, q)| projected(&c.polynomial.at(y), c, q, digits))
            .collect()
    }
}
