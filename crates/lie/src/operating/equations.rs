//! The equations of an operating point as functions of its free variables.

use bracketry_symbolic::{CompileError, Expr, Symbol, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

/// f(z) = 0 for the states that shall rest, with the Jacobian and the limits of z.
pub(crate) struct Equations {
    f: Tape,
    jacobian: Tape,
    scratch: Vec<f64>,
    /// Number of equations.
    pub(crate) rows: usize,
    /// Least and greatest value of each free variable.
    pub(crate) limits: Vec<[f64; 2]>,
}

impl Equations {
    /// `equations` must hold no names but those of the free variables and parameters.
    pub(crate) fn new(
        system: &System,
        equations: &[Expr],
        free: &[Symbol],
        limits: Vec<[f64; 2]>,
    ) -> Result<Self, CompileError> {
        let mut pool = system.pool.clone();
        let jacobian: Vec<Expr> = equations.iter().flat_map(|&e| pool.gradient(e, free)).collect();
        let with_derivatives = System { pool, ..system.clone() };
        let f = system.compile(free, equations)?;
        let jacobian = with_derivatives.compile(free, &jacobian)?;
        Ok(Equations { f, jacobian, scratch: Vec::new(), rows: equations.len(), limits })
    }

    pub(crate) fn value(&mut self, z: &DVector<f64>) -> DVector<f64> {
        let mut out = DVector::zeros(self.rows);
        self.f.eval(z.as_slice(), &mut self.scratch, out.as_mut_slice());
        out
    }

    pub(crate) fn jacobian(&mut self, z: &DVector<f64>) -> DMatrix<f64> {
        let mut out = vec![0.0; self.rows * z.len()];
        self.jacobian.eval(z.as_slice(), &mut self.scratch, &mut out);
        DMatrix::from_row_slice(self.rows, z.len(), &out)
    }
}
