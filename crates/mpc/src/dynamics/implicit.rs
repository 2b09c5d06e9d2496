//! Dynamics with algebraic variables of index 1: x' = f(x, z, u), 0 = g(x, z, u).
//!
//! Wherever the field is evaluated, Newton's method solves for z(x, u). The derivatives follow from the implicit function theorem:
//!
//! ```text
//! dz/d(x, u) = −g_z⁻¹ g_(x, u),    df/d(x, u) = f_(x, u) + f_z dz/d(x, u)
//! ∇²(wᵀf)(x, u) = Dᵀ ∇²(wᵀf + μᵀg) D,    D = [I; dz/d(x, u)],    μ = −g_z⁻ᵀ f_zᵀ w
//! ```

use super::field::Dynamics;
use crate::error::MpcError;
use bracketry_numerics::dense::Lu;
use bracketry_sim::{AlgebraicRoot, NoRoot};

/// The dynamics with their working memory.
#[derive(Clone)]
pub(super) struct ImplicitDynamics<D> {
    /// (f, g) as the field of the states (x, z).
    whole: D,
    n: usize,
    q: usize,
    m: usize,
    root: AlgebraicRoot,
    pattern: Vec<(usize, usize)>,
    /// Places of the second derivatives of (f, g).
    curved: Vec<(usize, usize)>,
    xz: Vec<f64>,
    rates: Vec<f64>,
    entries: Vec<f64>,
    factors: Lu,
    /// dz/d(x, u), q rows of n + m.
    dz: Vec<f64>,
    failure: Option<(f64, NoRoot)>,
}

impl<D: Dynamics> ImplicitDynamics<D> {
    /// From the field (f, g) of the states (x, z), and where the search for z starts.
    pub(super) fn new(whole: D, guess: Vec<f64>) -> Self {
        let (w, q, m) = (whole.states(), guess.len(), whole.inputs());
        let n = w - q;
        let entries = whole.jacobian_pattern();
        let column = |j: usize| if j < n { Some(j) } else { j.checked_sub(q).filter(|_| j >= w) };
        let through: Vec<usize> =
            (0..n + m).filter(|c| entries.iter().any(|&(i, j)| i >= n && column(j) == Some(*c))).collect();
        let mut pattern = Vec::new();
        for i in 0..n {
            let uses = entries.iter().any(|&(row, j)| row == i && (n..w).contains(&j));
            let direct = |c: usize| entries.iter().any(|&(row, j)| row == i && column(j) == Some(c));
            pattern.extend((0..n + m).filter(|&c| direct(c) || (uses && through.contains(&c))).map(|c| (i, c)));
        }
        Self {
            n,
            q,
            m,
            root: AlgebraicRoot::new(guess),
            pattern,
            curved: Vec::new(),
            xz: vec![0.0; w],
            rates: vec![0.0; w],
            entries: vec![0.0; entries.len()],
            factors: Lu::default(),
            dz: vec![0.0; q * (n + m)],
            whole,
            failure: None,
        }
    }

    pub(super) fn pattern(&self) -> &[(usize, usize)] {
        &self.pattern
    }

    pub(super) fn whole(&mut self) -> &mut D {
        &mut self.whole
    }

    /// Time and cause of the last failure since this was last asked.
    pub(super) fn take_failure(&mut self) -> Option<(f64, NoRoot)> {
        self.failure.take()
    }

    /// Solves for z; (x, z), the rates, and the entries of the Jacobian are those there.
    fn solve(&mut self, t: f64, x: &[f64], u: &[f64]) -> bool {
        let Self { whole, n, q, root, xz, rates, entries, failure, .. } = self;
        let (n, q) = (*n, *q);
        xz[..n].copy_from_slice(x);
        let found = root.solve(|z, g, jacobian| {
            xz[n..].copy_from_slice(z);
            whole.field_and_jacobian(t, xz, u, rates, entries);
            g.copy_from_slice(&rates[n..]);
            jacobian.fill(0.0);
            for (&(i, j), &v) in whole.jacobian_pattern().iter().zip(&*entries) {
                if i >= n && (n..n + q).contains(&j) {
                    jacobian[(i - n) * q + j - n] = v;
                }
            }
        });
        match found {
            Ok(z) => {
                xz[n..].copy_from_slice(&z);
                whole.field_and_jacobian(t, xz, u, rates, entries);
                true
            }
            Err(why) => {
                *failure = Some((t, why));
                false
            }
        }
    }

    /// dz/d(x, u) from the entries of the Jacobian.
    fn differentiate(&mut self) -> bool {
        let (n, q, w) = (self.n, self.q, self.n + self.m);
        let matrix = self.factors.matrix(q);
        matrix.fill(0.0);
        self.dz.fill(0.0);
        for (&(i, j), &v) in self.whole.jacobian_pattern().iter().zip(&self.entries) {
            if i < n {
                continue;
            }
            if (n..n + q).contains(&j) {
                matrix[(i - n) * q + j - n] = v;
            } else {
                self.dz[(i - n) * w + if j < n { j } else { j - q }] = -v;
            }
        }
        let regular = self.factors.factorize();
        if regular {
            self.factors.solve(&mut self.dz, w);
        }
        regular
    }

    pub(super) fn field(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) {
        if self.solve(t, x, u) {
            dx.copy_from_slice(&self.rates[..self.n]);
        } else {
            dx.fill(f64::NAN);
        }
    }

    pub(super) fn field_and_jacobian(&mut self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64], jacobian: &mut [f64]) {
        if !(self.solve(t, x, u) && self.differentiate()) {
            dx.fill(f64::NAN);
            jacobian.fill(f64::NAN);
            return;
        }
        let (n, q, w) = (self.n, self.q, self.n + self.m);
        dx.copy_from_slice(&self.rates[..n]);
        jacobian.fill(0.0);
        let entries = self.whole.jacobian_pattern().iter().zip(&self.entries);
        for (&(i, j), &v) in entries.filter(|((i, _), _)| *i < n) {
            let row = self.pattern.iter().zip(jacobian.iter_mut()).filter(|((row, _), _)| *row == i);
            if (n..n + q).contains(&j) {
                row.for_each(|((_, c), out)| *out += v * self.dz[(j - n) * w + c]);
            } else {
                let column = if j < n { j } else { j - q };
                row.filter(|((_, c), _)| *c == column).for_each(|(_, out)| *out += v);
            }
        }
    }

    /// All places i ≤ j: D couples everything.
    pub(super) fn second_derivatives(&mut self) -> Result<Vec<(usize, usize)>, MpcError> {
        self.curved = self.whole.second_derivatives()?;
        let w = self.n + self.m;
        Ok((0..w).flat_map(|i| (i..w).map(move |j| (i, j))).collect())
    }

    pub(super) fn weighted_hessian(&mut self, t: f64, x: &[f64], u: &[f64], weights: &[f64], hessian: &mut [f64]) {
        if !(self.solve(t, x, u) && self.differentiate()) {
            hessian.fill(f64::NAN);
            return;
        }
        let (n, q, w) = (self.n, self.q, self.n + self.m);
        let mut multipliers = weights.to_vec();
        let mut slope = vec![0.0; q];
        for (&(i, j), &v) in self.whole.jacobian_pattern().iter().zip(&self.entries) {
            if i < n && (n..n + q).contains(&j) {
                slope[j - n] -= v * weights[i];
            }
        }
        self.factors.solve_transposed(&mut slope);
        multipliers.extend(slope);
        let mut values = vec![0.0; self.curved.len()];
        self.whole.weighted_hessian(t, &self.xz, u, &multipliers, &mut values);
        // Row of D for a variable of (x, z, u).
        let dz = &self.dz;
        let row = |i: usize, c: usize| match i {
            i if i < n => f64::from(u8::from(i == c)),
            i if i < n + q => dz[(i - n) * w + c],
            i => f64::from(u8::from(i - q == c)),
        };
        let mut place = 0;
        for a in 0..w {
            for b in a..w {
                let term = |(&(i, j), &v): (&(usize, usize), &f64)| {
                    let other = if i == j { 0.0 } else { row(j, a) * row(i, b) };
                    v * (row(i, a) * row(j, b) + other)
                };
                hessian[place] = self.curved.iter().zip(&values).map(term).sum();
                place += 1;
            }
        }
    }
}
