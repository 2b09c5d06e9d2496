//! The equations of an operating point as functions of its free variables.

use bracketry_symbolic::{CompileError, Expr, Symbol, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

/// Quotient of the slopes of two equations from which on they are weighed.
const WEIGHED: f64 = 1e6;

/// f(z) = 0 for the states that shall rest, with the Jacobian and the limits of z.
pub(crate) struct Equations {
    /// Behind the equations, functions that cancel in them and must have values, too.
    f: Tape,
    jacobian: Tape,
    scratch: Vec<f64>,
    /// Factors of the equations in the iterations.
    weights: Vec<f64>,
    /// Number of equations.
    pub(crate) rows: usize,
    /// Least and greatest value of each free variable.
    pub(crate) limits: Vec<[f64; 2]>,
}

impl Equations {
    /// `equations` and `canceled`, functions that cancel in them, must hold no names but those of the free variables and parameters.
    pub(crate) fn new(
        system: &System,
        equations: &[Expr],
        canceled: &[Expr],
        free: &[Symbol],
        limits: Vec<[f64; 2]>,
    ) -> Result<Self, CompileError> {
        let mut pool = system.pool.clone();
        let jacobian: Vec<Expr> = equations.iter().flat_map(|&e| pool.gradient(e, free)).collect();
        let with_derivatives = System { pool, ..system.clone() };
        let f = system.compile(free, &[equations, canceled].concat())?;
        let jacobian = with_derivatives.compile(free, &jacobian)?;
        let (rows, weights) = (equations.len(), vec![1.0; equations.len()]);
        Ok(Equations { f, jacobian, scratch: Vec::new(), weights, rows, limits })
    }

    /// Weighs equations whose slopes at `z` differ by more than the iterations can tell from rounding.
    pub(crate) fn weigh(&mut self, z: &DVector<f64>) {
        let slopes: Vec<f64> = self.jacobian(z).row_iter().map(|row| row.norm()).collect();
        let usable = |s: &f64| s.is_finite() && *s > 0.0;
        let least = slopes.iter().copied().filter(usable).fold(f64::INFINITY, f64::min);
        let most = slopes.iter().copied().filter(usable).fold(0.0, f64::max);
        let weight = |s: f64| if most > WEIGHED * least && usable(&s) { 1.0 / s } else { 1.0 };
        self.weights = slopes.into_iter().map(weight).collect();
    }

    /// f(z) with the weights.
    pub(crate) fn weighed_value(&mut self, z: &DVector<f64>) -> DVector<f64> {
        let mut f = self.value(z);
        f.iter_mut().zip(&self.weights).for_each(|(f, w)| *f *= w);
        f
    }

    /// The Jacobian with the weights.
    pub(crate) fn weighed_jacobian(&mut self, z: &DVector<f64>) -> DMatrix<f64> {
        let mut j = self.jacobian(z);
        j.row_iter_mut().zip(&self.weights).for_each(|(mut row, w)| row.scale_mut(*w));
        j
    }

    pub(crate) fn value(&mut self, z: &DVector<f64>) -> DVector<f64> {
        let mut out = vec![0.0; self.f.n_outputs()];
        self.f.eval(z.as_slice(), &mut self.scratch, &mut out);
        let canceled = out.split_off(self.rows);
        if canceled.iter().any(|v| v.is_nan()) {
            out.fill(f64::NAN);
        }
        DVector::from_vec(out)
    }

    pub(crate) fn jacobian(&mut self, z: &DVector<f64>) -> DMatrix<f64> {
        let mut out = vec![0.0; self.rows * z.len()];
        self.jacobian.eval(z.as_slice(), &mut self.scratch, &mut out);
        DMatrix::from_row_slice(self.rows, z.len(), &out)
    }
}
