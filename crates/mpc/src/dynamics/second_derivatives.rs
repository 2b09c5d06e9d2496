//! Second derivatives of symbolic dynamics.

use crate::error::MpcError;
use bracketry_native::{Function, Workspace};
use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use std::sync::Arc;

/// What the second derivatives are made from, once somebody asks for them.
#[derive(Clone)]
pub(crate) struct SecondDerivatives(Arc<Source>);

struct Source {
    pool: Pool,
    /// Arguments of the field.
    arguments: Vec<Symbol>,
    /// States and inputs.
    variables: Vec<Symbol>,
    rows: usize,
    /// Entries (i, j, ∂f_i/∂v_j) of the Jacobian that are not zero.
    jacobian: Vec<(usize, usize, Expr)>,
}

impl SecondDerivatives {
    pub(crate) fn new(
        pool: &Pool,
        arguments: Vec<Symbol>,
        variables: Vec<Symbol>,
        rows: usize,
        jacobian: Vec<(usize, usize, Expr)>,
    ) -> Self {
        Self(Arc::new(Source { pool: pool.clone(), arguments, variables, rows, jacobian }))
    }

    /// Compiles ∇² Σ w_i f_i, the weights being arguments.
    pub(crate) fn compile(&self) -> Result<WeightedHessian, MpcError> {
        let Source { arguments, variables, rows, jacobian, .. } = &*self.0;
        let mut pool = self.0.pool.clone();
        let weights: Vec<Symbol> = (0..*rows).map(|i| pool.symbol(&format!("weight#{i}"))).collect();
        let mut gradient = vec![pool.int(0); variables.len()];
        for &(i, j, e) in jacobian {
            let weight = pool.sym(weights[i]);
            let term = pool.mul(weight, e);
            gradient[j] = pool.add(gradient[j], term);
        }
        let (mut pattern, mut outputs) = (Vec::new(), Vec::new());
        for (i, &g) in gradient.iter().enumerate() {
            for (j, &v) in variables.iter().enumerate().skip(i) {
                let h = pool.diff(g, v);
                if !pool.is_zero(h) {
                    pattern.push((i, j));
                    outputs.push(h);
                }
            }
        }
        let all: Vec<Symbol> = arguments.iter().chain(&weights).copied().collect();
        let function = Function::new(Tape::compile(&pool, &all, &outputs)?);
        Ok(WeightedHessian { function, pattern, arguments: vec![0.0; all.len()] })
    }
}

/// ∇² Σ w_i f_i, compiled.
#[derive(Clone)]
pub(crate) struct WeightedHessian {
    function: Function,
    pattern: Vec<(usize, usize)>,
    arguments: Vec<f64>,
}

impl WeightedHessian {
    /// Places (i ≤ j) of the entries.
    pub(crate) fn pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }

    /// The entries at these arguments of the field.
    pub(crate) fn call(&mut self, arguments: &[f64], weights: &[f64], work: &mut Workspace, out: &mut [f64]) {
        let (first, second) = self.arguments.split_at_mut(arguments.len());
        first.copy_from_slice(arguments);
        second.copy_from_slice(weights);
        self.function.call(&self.arguments, work, out);
    }
}
