//! What inputs without bounds add: jumps along their fields.

use bracketry_symbolic::{Expr, Func, Node, Pool, Symbol, Tape};
use nalgebra::{DMatrix, DVector};

use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::InputValues;
use crate::controllability::local_accessibility::Frame;
use bracketry_numerics::eigen::{svd, symmetric_eigen};

/// Most input fields along which the state jumps, and most bounded inputs whose ends are combined.
const MAX_FREE: usize = 6;
const MAX_BOUNDED: usize = 4;
/// Lengths of the jumps that are tried, in the units of the states.
const LENGTHS: [f64; 12] = [0.05, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.5, 6.0, 10.0, 30.0, 100.0];
/// A vector shorter than this, relative to the values that were added to it, counts as zero.
const CLEAR: f64 = 1e-9;
/// Smallest singular value of vectors of length 1 that span the space, and largest of the weights that balance them.
const SPANNING: f64 = 1e-4;
const MAX_WEIGHT: f64 = 1e6;

/// Whether jumps along the constant fields of inputs without bounds make the system small-time locally controllable.
///
/// An input without bounds moves the state along its field g in no time, there and back: e^(−τ g) e^(t f) e^(τ g) is the
/// flow of the field f(· + τ g), for a constant g, so that all these fields can be followed, as can ±g and all positive
/// combinations (the strong Lie saturate, Jurdjevic 1997, ch. 3; Jurdjevic and Kupka 1981).
/// If they surround 0 at the point, a neighborhood is reached in every time T > 0. They are taken at some τ; that they
/// surround 0 is an open condition, which numbers with a margin decide. `false` says nothing.
pub(crate) fn surrounded_by_jumps(pool: &mut Pool, frame: &Frame, set: &InputSet<'_>, inputs: &[Expr]) -> bool {
    rates(pool, frame, set, inputs).is_some_and(|r| surround(&r))
}

/// The rates of the state after jumps, across the fields of the jumps, as vectors of length 1.
fn rates(pool: &mut Pool, frame: &Frame, set: &InputSet<'_>, inputs: &[Expr]) -> Option<Vec<DVector<f64>>> {
    let fields = &frame.fields;
    let states = fields.states.clone();
    let n = states.len();
    let constant = |pool: &Pool, g: &[Expr]| pool.symbols_of(g).iter().all(|s| !states.contains(s));
    let jumps: Vec<usize> =
        (0..fields.controls.len()).filter(|&i| set.unbounded(i) && constant(pool, &fields.controls[i])).collect();
    if jumps.is_empty() || jumps.len() > MAX_FREE {
        return None;
    }
    let offsets = deviations(pool, frame, inputs, set)?;
    // The columns: drift, then the fields of bounded inputs.
    let bounded: Vec<usize> = offsets.iter().map(|o| o.0).collect();
    let mut columns = vec![fields.drift.clone()];
    columns.extend(bounded.iter().map(|&i| fields.controls[i].clone()));
    if !is_entire(pool, &columns.concat(), &states) {
        return None;
    }
    let jump_values =
        frame.numbers(pool, &jumps.iter().flat_map(|&i| fields.controls[i].clone()).collect::<Vec<_>>())?;
    let directions = DMatrix::from_column_slice(n, jumps.len(), &jump_values);
    let across = orthogonal_complement(&directions)?;
    let tape = compiled(pool, frame, &columns.concat())?;
    let mut rates = Vec::new();
    let (mut work, mut values) = (Vec::new(), vec![0.0; tape.n_outputs()]);
    for step in steps(&directions) {
        tape.eval(step.as_slice(), &mut work, &mut values);
        for choice in 0..1usize << offsets.len() {
            let mut rate = DVector::from_column_slice(&values[..n]);
            let mut size = rate.norm();
            for (k, (_, ends)) in offsets.iter().enumerate() {
                let column = DVector::from_column_slice(&values[(k + 1) * n..(k + 2) * n]);
                let end = ends[choice >> k & 1];
                size += (column.norm() * end).abs();
                rate += column * end;
            }
            let rate = across.transpose() * rate;
            if rate.norm().is_finite() && rate.norm() > CLEAR * (1.0 + size) {
                rates.push(rate.normalize());
            }
        }
    }
    Some(rates)
}

/// The bounded inputs with the deviations of the ends of their ranges from their values at the point.
fn deviations(pool: &mut Pool, frame: &Frame, inputs: &[Expr], set: &InputSet<'_>) -> Option<Vec<(usize, [f64; 2])>> {
    let at_point = frame.numbers(pool, inputs)?;
    let mut all = Vec::new();
    for (i, &u) in at_point.iter().enumerate() {
        match set.values[i] {
            Some(InputValues::Between(lower, upper)) if lower <= u && u <= upper => {
                // Of an infinite end some part is taken.
                let end = |e: f64| if e.is_finite() { e - u } else { e.signum() };
                if lower.is_finite() || upper.is_finite() {
                    all.push((i, [end(lower), end(upper)]));
                }
            }
            Some(_) => return None,
            None if set.one_sided[i].is_some() => return None,
            None => {}
        }
    }
    (all.len() <= MAX_BOUNDED).then_some(all)
}

/// Sums of up to two jumps of all lengths.
fn steps(directions: &DMatrix<f64>) -> Vec<DVector<f64>> {
    let mut steps = vec![DVector::zeros(directions.nrows())];
    for i in 0..directions.ncols() {
        for j in 0..=i {
            for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let (first, second) = (directions.column(i) * a, directions.column(j) * b);
                let sum = if i == j { first } else { first + second };
                steps.extend(LENGTHS.iter().map(|&length| &sum * length));
            }
        }
    }
    steps
}

/// The expressions as functions of the deviations from the point.
fn compiled(pool: &mut Pool, frame: &Frame, list: &[Expr]) -> Option<Tape> {
    let (variables, offsets) = frame.deviations(pool);
    let moved = pool.substitute_all(list, &offsets);
    let roots: Vec<Expr> = moved.into_iter().map(|e| frame.constants_in(pool, e)).collect();
    Tape::compile(pool, &variables, &roots).ok()
}

/// Whether the functions are defined and smooth for all values of the states: no jump crosses a pole or a kink.
pub(crate) fn is_entire(pool: &Pool, list: &[Expr], states: &[Symbol]) -> bool {
    pool.reachable(list).into_iter().all(|e| match pool.node(e) {
        Node::Num(_) | Node::Pi | Node::Sym(_) | Node::Add(..) | Node::Mul(..) => true,
        Node::Pow(base, exponent) => {
            pool.integer(exponent).is_some_and(|k| k >= 0) || !states.iter().any(|&s| pool.depends_on(base, s))
        }
        Node::Call(f, a) => {
            let smooth =
                matches!(f, Func::Sin | Func::Cos | Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh | Func::Atan);
            smooth || !states.iter().any(|&s| pool.depends_on(a, s))
        }
        Node::Call2(..) => !states.iter().any(|&s| pool.depends_on(e, s)),
    })
}

/// Orthonormal columns that span what is orthogonal to the columns; `None` if these are not clear of rounding.
fn orthogonal_complement(columns: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = columns.nrows();
    let gram = columns * columns.transpose();
    let eigen = symmetric_eigen(gram)?;
    let size = eigen.eigenvalues.amax();
    let zero: Vec<usize> = (0..n).filter(|&i| eigen.eigenvalues[i] <= 1e-12 * size).collect();
    let unclear = eigen.eigenvalues.iter().any(|l| *l > 1e-12 * size && *l < 1e-6 * size);
    (size > 0.0 && !unclear).then(|| eigen.eigenvectors.select_columns(&zero))
}

/// Whether the vectors, of length 1, have 0 in the interior of their convex hull: they span the space, and weights of at
/// least 1 balance them.
fn surround(vectors: &[DVector<f64>]) -> bool {
    let Some(q) = vectors.first().map(DVector::len) else { return false };
    let matrix = DMatrix::from_columns(vectors);
    let spread = &matrix * matrix.transpose() / vectors.len() as f64;
    let spans = |e: nalgebra::SymmetricEigen<f64, nalgebra::Dyn>| e.eigenvalues.min() >= SPANNING * SPANNING;
    if q == 0 || !symmetric_eigen(spread).is_some_and(spans) {
        return false;
    }
    let target = -vectors.iter().fold(DVector::zeros(q), |s, v| s + v);
    let Some(weights) = nonnegative_least_squares(&matrix, &target) else { return false };
    let rest = &matrix * &weights - &target;
    weights.amax() <= MAX_WEIGHT && rest.norm() <= 1e-10 * vectors.len() as f64
}

/// min ‖A x − b‖ over x ≥ 0, by the active-set method of Lawson and Hanson (1974, ch. 23).
fn nonnegative_least_squares(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let columns = a.ncols();
    let mut x = DVector::zeros(columns);
    let mut passive: Vec<usize> = Vec::new();
    for _ in 0..3 * (a.nrows() + 10) {
        let gradient = a.transpose() * (b - a * &x);
        let best = (0..columns).filter(|i| !passive.contains(i)).max_by(|&i, &j| gradient[i].total_cmp(&gradient[j]));
        match best.filter(|&i| gradient[i] > 1e-12) {
            Some(i) => passive.push(i),
            None => return Some(x),
        }
        for _ in 0..=columns {
            let chosen = a.select_columns(&passive);
            let s = svd(&chosen)?.solve(b, 1e-13).ok()?;
            if s.iter().all(|v| *v > 0.0) {
                x.fill(0.0);
                for (&i, &v) in passive.iter().zip(s.iter()) {
                    x[i] = v;
                }
                break;
            }
            let blocked = passive.iter().zip(s.iter()).filter(|(_, v)| **v <= 0.0);
            let step = blocked.map(|(&i, &v)| x[i] / (x[i] - v)).fold(1.0, f64::min);
            for (&i, &v) in passive.iter().zip(s.iter()) {
                x[i] += step * (v - x[i]);
            }
            passive.retain(|&i| x[i] > 1e-14);
            if passive.is_empty() {
                break;
            }
        }
    }
    Some(x)
}
