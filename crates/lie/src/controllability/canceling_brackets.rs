//! Inputs in which the bad brackets of second order cancel.

use bracketry_symbolic::{Expr, Pool, Rational};
use nalgebra::{DMatrix, DVector};

use crate::algebra::field::{Field, bracket};
use crate::budget::check_growth;
use crate::controllability::linearization::Linearization;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::sign::definite;
use crate::controllability::sussmann::Inputs;
use crate::evidence::Evidence;
use crate::reason::InputCombination;
use crate::residues::{Echelon, Fp};
use crate::undecided::Undecided;
use bracketry_numerics::eigen::{svd, symmetric_eigen};

/// Largest numerator and denominator of the numbers that are used.
const BOUND: u64 = 1 << 24;
/// Denominators of the coefficients that are chosen.
const GRID: f64 = 64.0;
/// Rounds of alternating projections.
const ROUNDS: usize = 500;
/// Most inputs.
const MAX_INPUTS: usize = 6;

/// Inputs v, u = L·diag(√s)·v, for which Σ_i [ad_f^k h_i, [f, ad_f^k h_i]](x0), k ≤ `depth`, lie in the span of the values of
/// ad_f^j g_i and [g_i, g_j], with their fields in the given ones; `None` if none are found, or nothing is to be canceled at
/// this depth.
///
/// STLC is not changed by linear changes of the inputs, but which brackets are bad is. With
/// S = L diag(s) Lᵀ the sum is, for k = 0, Σ S_ij [g_i, [f, g_j]]; a positive definite S for which it lies in
/// the span exists just when no combination of those brackets across the span is semidefinite
/// (compare the second-order conditions of Bianchini and Stefani 1993, Basto-Gonçalves 1998, and Hirschorn and Lewis 2002). S
/// is found by alternating projections, rounded, and the conditions are then tested exactly.
pub(crate) fn canceling(
    pool: &mut Pool,
    frame: &Frame,
    depth: usize,
    evidence: &mut Evidence,
) -> Result<Option<(Inputs, Vec<InputCombination>)>, Undecided> {
    let (states, drift, g) = (&frame.fields.states, &frame.fields.drift, &frame.fields.controls);
    let (n, m) = (states.len(), g.len());
    if m > MAX_INPUTS {
        return Ok(None);
    }
    let mut span = Linearization::at(pool, frame, evidence)?.controllable();
    let pairs: Vec<(usize, usize)> = (0..m).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let commutators: Vec<Field> = pairs.iter().map(|&(i, j)| bracket(pool, states, &g[i], &g[j])).collect();
    for c in frame.evaluate(pool, &commutators, evidence)? {
        span.insert(c);
    }
    let first_node = pool.len();
    let mut ends = g.clone();
    let mut conditions = Echelon::empty(pairs.len());
    for k in 0..=depth {
        let mut derived: Vec<Field> = Vec::new();
        for end in &ends {
            check_growth(pool, first_node, [drift, end], 1)?;
            derived.push(bracket(pool, states, drift, end));
        }
        let mut forms: Vec<Field> = Vec::new();
        for &(i, j) in &pairs {
            check_growth(pool, first_node, [&ends[j], &derived[i]], 1)?;
            forms.push(bracket(pool, states, &ends[j], &derived[i]));
        }
        // Up to the span, the form is symmetric only where [f, [ad_f^k g_i, ad_f^k g_j]] is in it.
        let values = frame.evaluate(pool, &forms, evidence)?;
        let reduced: Vec<Vec<Fp>> = values.into_iter().map(|v| span.reduce(v)).collect();
        let before = conditions.rank();
        for c in 0..n {
            let twice = |&(i, j): &(usize, usize)| if i == j { Fp::ONE } else { Fp::new(2) };
            conditions.insert(pairs.iter().zip(&reduced).map(|(p, v)| twice(p) * v[c]).collect());
        }
        if k == depth && conditions.rank() == before {
            return Ok(None);
        }
        ends = derived;
    }
    let Some(free) = rational_rows(&conditions.null_space()) else { return Ok(None) };
    if free.is_empty() {
        return Ok(None);
    }
    let matrix = |c: &DVector<f64>| {
        let mut s = DMatrix::zeros(m, m);
        for (row, &weight) in free.iter().zip(c.iter()) {
            for (&(i, j), x) in pairs.iter().zip(row) {
                let x = weight * x.to_f64().value();
                s[(i, j)] += x;
                if i != j {
                    s[(j, i)] += x;
                }
            }
        }
        s
    };
    let columns: Vec<DVector<f64>> = (0..free.len())
        .map(|k| {
            let mut unit = DVector::zeros(free.len());
            unit[k] = 1.0;
            DVector::from_column_slice(matrix(&unit).as_slice())
        })
        .collect();
    let Some(solver) = svd(&DMatrix::from_columns(&columns)) else { return Ok(None) };
    let mut target = DMatrix::identity(m, m);
    let mut found = None;
    for _ in 0..ROUNDS {
        let Ok(c) = solver.solve(&DVector::from_column_slice(target.as_slice()), 1e-12) else { return Ok(None) };
        let c = c.map(|x: f64| (x * GRID).round() / GRID);
        let s = matrix(&c);
        if definite(&s) == Some(true) {
            found = Some(c);
            break;
        }
        let Some(mut eigen) = symmetric_eigen(s) else { return Ok(None) };
        eigen.eigenvalues.apply(|l| *l = l.max(0.2));
        target = eigen.recompose();
    }
    let Some(c) = found else { return Ok(None) };
    let Some((l, s)) = factor(&pairs, &free, &c, m) else { return Ok(None) };
    let mut scales = Vec::new();
    for x in &s {
        let Some(x) = Fp::from_rational(x) else { return Ok(None) };
        scales.push(x);
    }
    let mut fields = Vec::new();
    let mut combinations = Vec::new();
    for j in 0..m {
        let coefficients: Vec<Expr> = (0..m).map(|i| pool.rational(l[i][j].clone())).collect();
        let field: Field = (0..n)
            .map(|k| {
                let terms: Vec<Expr> = coefficients.iter().zip(g).map(|(&c, g)| pool.mul(c, g[k])).collect();
                pool.sum(terms)
            })
            .collect();
        fields.push(field);
        let coefficients = (0..m).map(|i| l[i][j].clone()).collect();
        combinations.push(InputCombination { scale: s[j].clone(), coefficients });
    }
    Ok(Some((Inputs { fields, scales }, combinations)))
}

fn rational_rows(rows: &[Vec<Fp>]) -> Option<Vec<Vec<Rational>>> {
    rows.iter().map(|r| r.iter().map(|x| x.to_rational(BOUND)).collect()).collect()
}

/// L with unit diagonal and s > 0 with S = L diag(s) Lᵀ, for S = Σ c_k S_k.
fn factor(
    pairs: &[(usize, usize)],
    free: &[Vec<Rational>],
    c: &DVector<f64>,
    m: usize,
) -> Option<(Vec<Vec<Rational>>, Vec<Rational>)> {
    let zero = Rational::ZERO;
    let mut matrix = vec![vec![zero.clone(); m]; m];
    for (row, &weight) in free.iter().zip(c.iter()) {
        let weight = Rational::from((weight * GRID).round() as i64) / Rational::from(GRID as i64);
        for (&(i, j), x) in pairs.iter().zip(row) {
            let x = &weight * x;
            matrix[i][j] += &x;
            if i != j {
                matrix[j][i] += x;
            }
        }
    }
    let mut l = vec![vec![zero.clone(); m]; m];
    let mut s: Vec<Rational> = Vec::new();
    for j in 0..m {
        let mut pivot = matrix[j][j].clone();
        for k in 0..j {
            pivot -= &l[j][k] * &l[j][k] * &s[k];
        }
        if pivot <= zero {
            return None;
        }
        l[j][j] = Rational::ONE;
        for i in j + 1..m {
            let mut x = matrix[i][j].clone();
            for k in 0..j {
                x -= &l[i][k] * &l[j][k] * &s[k];
            }
            l[i][j] = x / &pivot;
        }
        s.push(pivot);
    }
    Some((l, s))
}
