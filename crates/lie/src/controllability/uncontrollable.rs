//! Modes of the linearization that no input reaches.

use bracketry_symbolic::{Expr, Function, Pool, Rational};
use serde::Serialize;

use crate::answer::Answer;
use crate::controllability::linearization::{Linearization, uncontrollable_block};
use crate::controllability::local::Frame;
use crate::residues::{Echelon, Fp};

/// An eigenvalue of the linearization x' = A x + B u that no input reaches: rank [A − λ, B] < n
/// (Popov–Belevitch–Hautus).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// How often it occurs among the uncontrollable eigenvalues.
    pub multiplicity: usize,
    /// Combinations w·x of the states (deviations from the point) with (w·x)' = λ w·x to first
    /// order whatever the inputs; known, and the eigenvalue exact, where λ and w are rational.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub combinations: Vec<Function>,
}

/// Largest denominator of an eigenvalue that is tried as a rational number.
const MAX_DENOMINATOR: i64 = 10_000;
/// Largest numerator and denominator in a combination.
const BOUND: u64 = 1 << 24;

/// The uncontrollable eigenvalues. `rank` is the exact dimension of the controllable subspace and
/// their number is n − `rank`; the eigenvalues are found in floating point, and those nearer than
/// its accuracy (relative 1e-15 to the power 1/(n − `rank`)) are counted as one, at their mean. A
/// rational eigenvalue with small denominator is confirmed exactly.
pub(crate) fn uncontrollable_modes(
    pool: &mut Pool,
    frame: &Frame,
    linearization: &Linearization,
    rank: usize,
) -> Answer<Vec<Mode>> {
    let n = frame.fields.states.len();
    if rank == n {
        return Answer::Known(Vec::new());
    }
    let (block, tolerance) = match uncontrollable_block(pool, frame, rank) {
        Ok(found) => found,
        Err(why) => return Answer::Unknown(why),
    };
    let eigenvalues: Vec<(f64, f64)> = block.complex_eigenvalues().iter().map(|z| (z.re, z.im)).collect();
    let mut clusters: Vec<Vec<(f64, f64)>> = Vec::new();
    for z in eigenvalues {
        let near = |c: &&mut Vec<(f64, f64)>| c.iter().any(|w| (w.0 - z.0).hypot(w.1 - z.1) <= tolerance);
        match clusters.iter_mut().find(near) {
            Some(c) => c.push(z),
            None => clusters.push(vec![z]),
        }
    }
    let mut modes: Vec<Mode> = Vec::new();
    for cluster in clusters {
        let k = cluster.len() as f64;
        let re = cluster.iter().map(|z| z.0).sum::<f64>() / k;
        let im = cluster.iter().map(|z| z.1).sum::<f64>() / k;
        let mut mode = Mode {
            re: tidy(re, tolerance),
            im: tidy(im, tolerance),
            multiplicity: cluster.len(),
            combinations: Vec::new(),
        };
        if mode.im == 0.0
            && let Some((p, q)) = rational_near(re, tolerance)
        {
            let combinations = left_eigenvectors(pool, frame, linearization, (p, q));
            if !combinations.is_empty() {
                mode.re = p as f64 / q as f64;
                mode.combinations = combinations;
            }
        }
        modes.push(mode);
    }
    modes.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    Answer::Known(modes)
}

fn tidy(x: f64, tolerance: f64) -> f64 {
    if x.abs() <= tolerance { 0.0 } else { x }
}

/// The rational number with the smallest denominator within `tolerance`, by continued fractions.
fn rational_near(x: f64, tolerance: f64) -> Option<(i64, i64)> {
    let (mut p0, mut q0, mut p1, mut q1) = (0i64, 1i64, 1i64, 0i64);
    let mut rest = x;
    for _ in 0..20 {
        let whole = rest.floor();
        if whole.abs() > 1e9 {
            return None;
        }
        let a = whole as i64;
        let (p, q) = (a.checked_mul(p1)?.checked_add(p0)?, a.checked_mul(q1)?.checked_add(q0)?);
        if q > MAX_DENOMINATOR {
            return None;
        }
        if (p as f64 / q as f64 - x).abs() <= tolerance {
            return Some((p, q));
        }
        (p0, q0, p1, q1) = (p1, q1, p, q);
        rest = 1.0 / (rest - whole);
    }
    None
}

/// A basis of {w : wᵀA = λ wᵀ, wᵀB = 0}; empty if it is trivial or not of small rationals.
fn left_eigenvectors(
    pool: &mut Pool,
    frame: &Frame,
    linearization: &Linearization,
    value: (i64, i64),
) -> Vec<Function> {
    let n = frame.fields.states.len();
    let Some(inverse) = Fp::from_i64(value.1).inv() else { return Vec::new() };
    let lambda = Fp::from_i64(value.0) * inverse;
    let mut rows: Vec<Vec<Fp>> = (0..n)
        .map(|j| (0..n).map(|i| linearization.a[i][j] - if i == j { lambda } else { Fp::ZERO }).collect())
        .collect();
    rows.extend(linearization.b.iter().cloned());
    let null_space = Echelon::new(&rows, n).nullspace();
    let rational: Option<Vec<Vec<Rational>>> =
        null_space.iter().map(|w| w.iter().map(|x| x.to_rational(BOUND)).collect()).collect();
    let states = frame.fields.states.clone();
    rational
        .unwrap_or_default()
        .into_iter()
        .map(|w| {
            let terms: Vec<Expr> = states
                .iter()
                .zip(w)
                .map(|(&s, c)| {
                    let s = pool.sym(s);
                    let c = pool.rational(c);
                    pool.mul(c, s)
                })
                .collect();
            let sum = pool.sum(terms);
            let sum = pool.simplify(sum);
            Function::new(pool, sum)
        })
        .collect()
}
