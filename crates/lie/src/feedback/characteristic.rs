//! Input combinations along which the second distribution stays small.

use bracketry_symbolic::{Expr, Pool};

use crate::algebra::field::{Field, VectorFields, bracket};
use crate::algebra::matrix::reduced;
use crate::algebra::rational::readable::{square_root, tidy};
use crate::algebra::span::independent;
use crate::evidence::Evidence;
use crate::undecided::Undecided;

impl VectorFields {
    /// Of two inputs, the combinations Y = α_1(x) g_1 + α_2(x) g_2 for which [Y, [f, Y]] lies in D_1 = span{g_i, [f, g_i]}, as far
    /// as the derivatives of α along the inputs do not count: functions that g_1, g_2 and [f, Y] keep constant are candidates
    /// for flat outputs, as the center of oscillation of a rigid body is (Martin, Devasia, and Paden 1996). They do not depend
    /// on the choice of the inputs: α are the zeros of a quadratic form. Empty if D_1 has not four dimensions, or a zero is
    /// not written out.
    pub(crate) fn characteristic_inputs(
        &self,
        pool: &mut Pool,
        evidence: &mut Evidence,
    ) -> Result<Vec<Field>, Undecided> {
        let n = self.states.len();
        if self.controls.len() != 2 {
            return Ok(Vec::new());
        }
        let along: Vec<Field> = self.controls.iter().map(|g| bracket(pool, &self.states, &self.drift, g)).collect();
        let spanning: Vec<Field> = self.controls.iter().chain(&along).cloned().collect();
        let basis = independent(pool, &spanning, &self.bindings, evidence)?;
        if basis.len() != 4 || n < 5 {
            return Ok(Vec::new());
        }
        let basis = reduced(pool, &basis, &self.bindings, evidence)?;
        let Some(pivots) = pivots(pool, &basis) else { return Ok(Vec::new()) };
        let mut entries: Vec<Field> = Vec::new();
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let z = bracket(pool, &self.states, &self.controls[i], &along[j]);
            entries.push(modulo(pool, z, &basis, &pivots));
        }
        for k in (0..n).filter(|k| !pivots.contains(k)) {
            let mixed = pool.add(entries[1][k], entries[2][k]);
            let mut form = Vec::new();
            for e in [entries[0][k], mixed, entries[3][k]] {
                let zero = self.vanishes(pool, e, evidence)?;
                form.push(if zero { pool.int(0) } else { tidy(pool, e) });
            }
            if form.iter().any(|&e| !pool.is_zero(e)) {
                let zeros = zeros(pool, [form[0], form[1], form[2]]);
                return Ok(zeros.into_iter().map(|alpha| self.combination(pool, &alpha)).collect());
            }
        }
        Ok(Vec::new())
    }

    /// Σ α_i g_i.
    fn combination(&self, pool: &mut Pool, alpha: &[Expr]) -> Field {
        (0..self.states.len())
            .map(|k| {
                let mut sum = pool.int(0);
                for (&a, g) in alpha.iter().zip(&self.controls) {
                    let term = pool.mul(a, g[k]);
                    sum = pool.add(sum, term);
                }
                tidy(pool, sum)
            })
            .collect()
    }
}

/// The zeros of a α_1² + b α_1 α_2 + c α_2², where they are written out.
fn zeros(pool: &mut Pool, [a, b, c]: [Expr; 3]) -> Vec<[Expr; 2]> {
    let (zero, one) = (pool.int(0), pool.int(1));
    let ratio = |pool: &mut Pool, top: Expr, bottom: Expr| {
        let e = pool.div(top, bottom);
        tidy(pool, e)
    };
    if pool.is_zero(a) {
        let mut list = vec![[one, zero]];
        if !pool.is_zero(b) {
            let minus = pool.neg(c);
            let x = ratio(pool, minus, b);
            list.push([x, one]);
        }
        return list;
    }
    let (square, four) = (pool.powi(b, 2), pool.int(4));
    let product = pool.mul(a, c);
    let product = pool.mul(four, product);
    let discriminant = pool.sub(square, product);
    let root = square_root(pool, discriminant).or_else(|| {
        let waves = pool.trig_form(discriminant);
        square_root(pool, waves)
    });
    let Some(root) = root else { return Vec::new() };
    let two = pool.int(2);
    let bottom = pool.mul(two, a);
    let minus = pool.neg(b);
    let tops = [pool.add(minus, root), pool.sub(minus, root)];
    let mut list: Vec<[Expr; 2]> = Vec::new();
    for top in tops {
        let x = ratio(pool, top, bottom);
        if !list.contains(&[x, one]) {
            list.push([x, one]);
        }
    }
    // Without the division, which hides what the distribution keeps constant.
    for top in tops {
        let factors = [tidy(pool, top), tidy(pool, bottom)];
        if factors.iter().any(|&e| !pool.is_zero(e)) {
            list.push(factors);
        }
    }
    list
}

/// Per field a component that is 1 there and plainly zero in the others; `None` if there is none.
fn pivots(pool: &Pool, basis: &[Field]) -> Option<Vec<usize>> {
    let n = basis.first()?.len();
    (0..basis.len())
        .map(|i| {
            (0..n).find(|&k| {
                pool.is_one(basis[i][k]) && basis.iter().enumerate().all(|(j, y)| j == i || pool.is_zero(y[k]))
            })
        })
        .collect()
}

/// `z` less the combination of `basis` that has its components at the pivots.
fn modulo(pool: &mut Pool, mut z: Field, basis: &[Field], pivots: &[usize]) -> Field {
    for (y, &p) in basis.iter().zip(pivots) {
        let factor = z[p];
        if pool.is_zero(factor) {
            continue;
        }
        for (a, &b) in z.iter_mut().zip(y) {
            let term = pool.mul(factor, b);
            *a = pool.sub(*a, term);
        }
    }
    z
}
