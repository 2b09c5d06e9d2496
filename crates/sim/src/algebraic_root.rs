//! Algebraic variables z from their equations g(z) = 0, along a motion on which the equations change gradually.

use nalgebra::{DMatrix, DVector};

/// Newton iterations after which a search has failed.
const MAX_ITERATIONS: usize = 60;
/// Correction, relative to 1 + |z|, at which the equations count as solved.
const TOLERANCE: f64 = 1e-13;
/// Corrections up to this size may be rounding errors.
const ROUNDING: f64 = 1e-10;
/// Part of a correction below which the search has failed.
const SHORTEST: f64 = 1e-6;

/// Equations without a solution on the branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoRoot {
    /// The equation with the largest residual.
    pub equation: usize,
    /// This residual.
    pub residual: f64,
    /// Why there is none.
    pub why: NoRootReason,
}

/// Why equations have no solution on the branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoRootReason {
    /// Newton's method does not converge.
    NotConverging,
    /// ∂g/∂z is singular, or not finite.
    Singular,
    /// What was found lies beyond a fold: the determinant of ∂g/∂z has another sign.
    OtherBranch,
}

/// The solution of algebraic equations that belongs to a branch.
///
/// Newton's method with exact derivatives, damped by the natural monotonicity test (Deuflhard 2004, section 3.3), starts from the
/// last solution and, if that fails, from the guess. The first solution selects the branch. Where branches meet, ∂g/∂z is singular,
/// so that its determinant keeps its sign on a branch; a solution with another sign is refused.
#[derive(Clone, Debug)]
pub struct AlgebraicRoot {
    guess: Vec<f64>,
    last: Option<Vec<f64>>,
    /// Sign of the determinant on the branch.
    sign: Option<f64>,
}

impl AlgebraicRoot {
    /// The search for as many unknowns as the guess has.
    pub fn new(guess: Vec<f64>) -> Self {
        Self { guess, last: None, sign: None }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.guess.len()
    }

    /// The solution of the equations that `evaluate` gives at z: g and ∂g/∂z, row by row.
    ///
    /// ```
    /// use bracketry_sim::AlgebraicRoot;
    /// let mut root = AlgebraicRoot::new(vec![1.0]);
    /// let mut square = |x: f64| root.solve(|z, g, dg| { g[0] = z[0] * z[0] - x; dg[0] = 2.0 * z[0]; });
    /// assert_eq!(square(4.0).unwrap(), [2.0]);
    /// assert!(square(-1.0).is_err());
    /// ```
    ///
    /// # Errors
    /// [`NoRoot`]; the last solution is kept.
    pub fn solve(&mut self, mut evaluate: impl FnMut(&[f64], &mut [f64], &mut [f64])) -> Result<Vec<f64>, NoRoot> {
        let from_last = self.last.clone().map(|start| self.search(start, &mut evaluate));
        let found = match from_last {
            Some(Ok(found)) => Ok(found),
            _ => self.search(self.guess.clone(), &mut evaluate),
        };
        let (z, sign) = found?;
        self.sign = Some(sign);
        self.last = Some(z.clone());
        Ok(z)
    }

    /// The solution that Newton's method reaches, with the sign of the determinant.
    fn search(
        &self,
        mut z: Vec<f64>,
        evaluate: &mut impl FnMut(&[f64], &mut [f64], &mut [f64]),
    ) -> Result<(Vec<f64>, f64), NoRoot> {
        let q = z.len();
        let (mut g, mut jacobian) = (vec![0.0; q], vec![0.0; q * q]);
        let (mut trial, mut unused) = (vec![0.0; q], vec![0.0; q * q]);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            evaluate(&z, &mut g, &mut jacobian);
            let factors = DMatrix::from_row_slice(q, q, &jacobian).lu();
            let Some(correction) = factors.solve(&DVector::from_column_slice(&g)).filter(finite) else {
                return Err(no_root(&g, NoRootReason::Singular));
            };
            let size = 1.0 + z.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let length = correction.amax();
            // At rounding level nothing falls any more.
            if length <= TOLERANCE * size || (length <= ROUNDING * size && length > 0.5 * last) {
                z.iter_mut().zip(correction.iter()).for_each(|(z, d)| *z -= d);
                let sign = factors.determinant().signum();
                let belongs = self.sign.is_none_or(|known| known == sign);
                return if belongs { Ok((z, sign)) } else { Err(no_root(&g, NoRootReason::OtherBranch)) };
            }
            let mut alpha = 1.0;
            loop {
                for i in 0..q {
                    trial[i] = z[i] - alpha * correction[i];
                }
                if length <= ROUNDING * size {
                    break;
                }
                evaluate(&trial, &mut g, &mut unused);
                let next = factors.solve(&DVector::from_column_slice(&g)).filter(finite);
                if next.is_some_and(|next| next.amax() <= (1.0 - alpha / 4.0) * length) {
                    break;
                }
                alpha /= 2.0;
                if alpha < SHORTEST {
                    evaluate(&z, &mut g, &mut unused);
                    return Err(no_root(&g, NoRootReason::NotConverging));
                }
            }
            std::mem::swap(&mut z, &mut trial);
            last = length;
        }
        evaluate(&z, &mut g, &mut unused);
        Err(no_root(&g, NoRootReason::NotConverging))
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)]
fn finite(v: &DVector<f64>) -> bool {
    v.iter().all(|v| v.is_finite())
}

fn no_root(g: &[f64], why: NoRootReason) -> NoRoot {
    let size = |i: &usize| if g[*i].is_nan() { f64::INFINITY } else { g[*i].abs() };
    let equation = (0..g.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
    NoRoot { equation, residual: g[equation], why }
}
