//! States that inputs hold at rest but for one critical mode.

use bracketry_symbolic::{Echelon, Rational};

use crate::linear::matrix::RationalMatrix;
use crate::linear::polynomial::{MultivariatePolynomial, unit};

/// s' = β(s, v) at the states X(s, v) with inputs U(s, v) where F(X, U) = β e with a constant vector e: a critical mode s = w·x
/// that the linearization of x' = F(x, u) at the origin leaves at rest, and free parameters v, one for each input.
pub(crate) struct SlowEquilibria {
    /// w, with w·e = 1.
    pub(crate) mode: Vec<Rational>,
    /// β up to a degree; its variables are s and v.
    pub(crate) rate: MultivariatePolynomial,
}

impl SlowEquilibria {
    /// Of F in `states` states and the inputs, known up to a degree; `None` unless exactly one combination of the components has no
    /// linear terms. X and U follow degree by degree from n of the equations [A B] (X, U) = β e − …, w·X = s (implicit function
    /// theorem).
    pub(crate) fn of(field: &[MultivariatePolynomial], inputs: usize, degree: u32) -> Option<Self> {
        let n = field.len();
        let linear: Vec<Vec<Rational>> =
            field.iter().map(|f| (0..n + inputs).map(|k| f.coefficient(&unit(n + inputs, k))).collect()).collect();
        let linear = RationalMatrix::new(linear, n + inputs);
        let [mode] = &linear.transposed().null_space()[..] else { return None };
        let left_out = mode.iter().position(|c| *c != Rational::ZERO)?;
        // The equation that the others imply is replaced by w·X = s.
        let mut rows: Vec<Vec<Rational>> = linear.rows().to_vec();
        rows[left_out] = mode.iter().cloned().chain(vec![Rational::ZERO; inputs]).collect();
        let equations = RationalMatrix::new(rows, n + inputs);
        let pivots = Echelon::new(equations.rows(), n + inputs).pivots;
        if pivots.len() < n {
            return None;
        }
        let square = equations.rows().iter().map(|r| pivots.iter().map(|&p| r[p].clone()).collect()).collect();
        let inverse = RationalMatrix::new(square, n).inverse()?;
        let variables = 1 + inputs;
        let mut motion = vec![MultivariatePolynomial::default(); n + inputs];
        for (&p, row) in pivots.iter().zip(inverse.rows()) {
            motion[p].add_term(unit(variables, 0), row[left_out].clone());
        }
        for (k, v) in equations.null_space().into_iter().enumerate() {
            for (x, c) in motion.iter_mut().zip(v) {
                x.add_term(unit(variables, 1 + k), c);
            }
        }
        let mut rate = MultivariatePolynomial::default();
        for order in 2..=degree {
            let rest: Vec<MultivariatePolynomial> =
                field.iter().map(|f| f.composed(&motion, variables, order).of_degree(order)).collect();
            for (c, r) in mode.iter().zip(&rest) {
                rate = rate.plus(r, c);
            }
            for (&p, row) in pivots.iter().zip(inverse.rows()) {
                for (i, r) in rest.iter().enumerate().filter(|(i, _)| *i != left_out) {
                    motion[p] = motion[p].plus(r, &-row[i].clone());
                }
            }
        }
        Some(SlowEquilibria { mode: mode.clone(), rate })
    }
}
