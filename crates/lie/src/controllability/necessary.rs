//! Necessary conditions for small-time local controllability; each holds for every bound on the inputs.

use bracketry_symbolic::{Expr, Function, Pool};
use nalgebra::{DMatrix, DVector};

use crate::algebra::combination::{combination, symbols};
use crate::algebra::constant_span::Words;
use crate::algebra::field::{Field, bracket};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::span::independent;
use crate::algebra::span::vanishes;
use crate::budget::check_growth;
use crate::controllability::holding::supporting;
use crate::controllability::input_values::Side;
use crate::controllability::linearization::complement;
use crate::controllability::local_accessibility::Frame;
use crate::controllability::region::Extent;
use crate::controllability::sign::{NearOrigin, Sign, definite};
use crate::evidence::Evidence;
use crate::options::Limits;
use crate::reason::{Monotone, StlcReason};
use crate::residues::times;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;
use bracketry_numerics::eigen::symmetric_eigen;

/// The even k for which Stefani's necessary condition (1986; k = 2: Sussmann 1983) fails: STLC of
/// x' = f + u g at an equilibrium needs ad_g^k f(x0) in the span of all brackets with fewer than
/// k factors g there, for every even k. `None` if it was not seen to fail.
///
/// Those brackets are infinitely many. For k = 2 they are the ad_f^i g, and Kalman's matrix has
/// their span; above, the condition is used only where they are found to span a
/// finite-dimensional space of functions.
pub(crate) fn stefani(
    pool: &mut Pool,
    frame: &Frame,
    g: &Field,
    controllable: &Echelon,
    limits: &Limits,
    evidence: &mut Evidence,
) -> Result<Option<usize>, Undecided> {
    let (states, drift) = (&frame.fields.states, &frame.fields.drift);
    let first_node = pool.len();
    let mut power = bracket(pool, states, g, drift);
    power = bracket(pool, states, g, &power);
    let value = frame.evaluate(pool, std::slice::from_ref(&power), evidence)?;
    if !controllable.contains(&value[0]) {
        return Ok(Some(2));
    }
    let mut words = Words::default();
    let mut candidates = vec![g.clone()];
    for degree in 1..limits.length {
        // From all brackets with fewer than `degree` factors g to those with at most as many.
        let fewer = words.kept.len();
        let mut rounds = 0;
        loop {
            words.extend(pool, &frame.fields.bindings, candidates, evidence)?;
            if words.fresh.is_empty() {
                break;
            }
            rounds += 1;
            if rounds > limits.length {
                return Ok(None);
            }
            candidates = Vec::new();
            for y in &words.kept[words.fresh.clone()] {
                if pool.len() - first_node > limits.nodes {
                    return Ok(None);
                }
                candidates.push(bracket(pool, states, drift, y));
            }
        }
        if words.kept.len() == fewer {
            return Ok(None);
        }
        if degree >= 3 {
            power = bracket(pool, states, g, &power);
            if degree % 2 == 1 {
                let next = bracket(pool, states, g, &power);
                let value = frame.evaluate(pool, &[next], evidence)?;
                let span = Echelon::new(&frame.evaluate(pool, &words.kept, evidence)?, states.len());
                if !span.contains(&value[0]) {
                    return Ok(Some(degree + 1));
                }
            }
        }
        candidates = words.kept[fewer..].iter().map(|y| bracket(pool, states, g, y)).collect();
    }
    Ok(None)
}

/// A half-space that no trajectory leaves, or a linear function that never turns back, with the reason.
///
/// If on the hyperplane λ·(x − x0) = 0 near x0 every f + Σ u_i g_i points to one side or along
/// it, the half-space on that side is invariant (Nagumo 1942) and x0 is no interior point of what
/// is reached. Tried are the coordinates, the constant λ that annihilate every input field, and one that is not negative on
/// those of one-sided inputs at x0.
/// `sides` says for each input whether it deviates to one side only; `extent`, where the field must point there: on the
/// hyperplane, off it too, or on one side of it, and whether far from x0, so that trajectories that leave the neighborhood of x0
/// are bounded by it.
pub(crate) fn half_space(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    extent: Extent,
    evidence: &mut Evidence,
) -> Result<Option<StlcReason>, Undecided> {
    let states = symbols(pool, &frame.fields.states);
    let (variables, offsets) = frame.deviations(pool);
    let deviations = symbols(pool, &variables);
    let near = NearOrigin { frame, variables: variables.clone(), everywhere: extent.everywhere };
    for covector in covectors(pool, frame, sides, evidence)? {
        let deviation = combination(pool, &deviations, &covector);
        let Some(in_region) = extent.region.coordinates(pool, deviation, &variables) else { continue };
        let along = |pool: &mut Pool, field: &Field| {
            let sum = combination(pool, field, &covector);
            let sum = pool.substitute(sum, &offsets);
            pool.substitute(sum, &in_region)
        };
        let sign = |pool: &mut Pool, e: Expr| {
            if vanishes(pool, e, &frame.fields.bindings) {
                return Sign::Zero;
            }
            near.sign(pool, e)
        };
        let mut signs = Vec::new();
        for (g, side) in frame.fields.controls.iter().zip(sides) {
            let e = along(pool, g);
            let sign = sign(pool, e);
            signs.push(match side {
                Some(Side::Above) => sign,
                Some(Side::Below) => sign.opposite(),
                None if sign == Sign::Zero => sign,
                None => Sign::Unknown,
            });
            if signs.contains(&Sign::Unknown) {
                break;
            }
        }
        if signs.contains(&Sign::Unknown) {
            continue;
        }
        let drift = along(pool, &frame.fields.drift);
        signs.push(sign(pool, drift));
        let up = signs.iter().all(|s| s.at_least_zero());
        let down = signs.iter().all(|s| s.opposite().at_least_zero());
        if extent.region.bars(up, down) {
            let function = combination(pool, &states, &covector);
            let function = pool.simplify(function);
            let change = match (up, down) {
                (true, true) => Monotone::Constant,
                (true, false) => Monotone::Rises,
                _ => Monotone::Falls,
            };
            let function = Function::new(pool, function);
            let one_sided = sides.iter().any(Option::is_some);
            return Ok(Some(StlcReason::HalfSpace { function, change, one_sided }));
        }
    }
    Ok(None)
}

/// Seed of the points at which constant covectors are sought; largest numerator and denominator in them.
const COVECTOR_SEED: u64 = 0x6272_6163_6b65_7406;
const BOUND: u64 = 1 << 16;

/// The coordinates, combinations that annihilate every input field everywhere, and one that supports the one-sided inputs.
fn covectors(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<Vec<Vec<Expr>>, Undecided> {
    let n = frame.fields.states.len();
    let zero = pool.int(0);
    let one = pool.int(1);
    let mut all: Vec<Vec<Expr>> = (0..n)
        .map(|i| {
            let mut c = vec![zero; n];
            c[i] = one;
            c
        })
        .collect();
    if frame.fields.controls.is_empty() {
        return Ok(all);
    }
    let samples =
        pool.sample_in::<OFFSET>(&frame.fields.controls.concat(), &frame.fields.bindings, n + 1, COVECTOR_SEED)?;
    let rows: Vec<Vec<Fp>> = samples.values.iter().flat_map(|v| v.chunks(n).map(<[Fp]>::to_vec)).collect();
    evidence.add_rank(&samples, n)?;
    for covector in Echelon::new(&rows, n).null_space() {
        let rational: Option<Vec<_>> = covector.iter().map(|c| c.to_rational(BOUND)).collect();
        let Some(rational) = rational else { continue };
        let covector: Vec<Expr> = rational.into_iter().map(|c| pool.rational(c)).collect();
        if !all.contains(&covector) {
            all.push(covector);
        }
    }
    if let Some(covector) = supporting(pool, frame, sides, evidence)? {
        all.push(covector.into_iter().map(|c| pool.rational(c)).collect());
    }
    Ok(all)
}

/// The second-order obstruction: a definite quadratic form transversal to everything linear.
///
/// Let D be involutive with D ∋ g_i and K ⊂ D involutive with [f, K] ⊂ D, both of constant rank
/// near the equilibrium x0 of f, A = Df(x0) and λ a covector that annihilates all A^j D(x0). If
/// (d, e) ↦ λ·[d, [f, e]](x0) is definite on D/K, the system is not STLC, for any bound of the
/// inputs. For one input, D = span g and K = 0 this is Sussmann's condition (1983, proposition 6.3).
///
/// Proof. Trajectories of x' = f + Σ u_i g_i are trajectories of x' ∈ f + D, which passes to the
/// quotient by the leaves of K; so let K = 0. In coordinates x = (y, z) where D is spanned by the
/// ∂_y a trajectory is y' = v with bounded v, z' = b(y, z). Then |z| ≤ c∫|y|, and for p' = −Aᵀp,
/// p(T) = λ, the function λ·x(T) is the integral of ½ p·D²f(x, x) + O(|x|³), that is of
/// −½ Q(y, y) + O(T)|y|² with the definite Q: it has one sign for all inputs once T is small.
///
/// Tried as D are the involutive closures of {ad_f^j g_i, j ≤ k_i} for depths k_i, and as K those of
/// the fields among these that f leaves in D. The form is evaluated in floating point and counts
/// as definite only clear of rounding.
pub(crate) fn definite_form(
    pool: &mut Pool,
    frame: &Frame,
    evidence: &mut Evidence,
) -> Result<Option<usize>, Undecided> {
    let n = frame.fields.states.len();
    let (states, drift) = (frame.fields.states.clone(), frame.fields.drift.clone());
    let bindings = &frame.fields.bindings;
    let first_node = pool.len();
    let jacobian: Vec<Field> = pool.jacobian(&drift, &states);
    let a_exact = frame.evaluate(pool, &jacobian, evidence)?;
    let Some(a) = frame.numbers(pool, &jacobian.concat()) else { return Ok(None) };
    let a = DMatrix::from_row_slice(n, n, &a);
    let m_inputs = frame.fields.controls.len();
    let mut chains: Vec<Vec<Field>> = frame.fields.controls.iter().map(|g| vec![g.clone()]).collect();
    for depths in depths(m_inputs, n) {
        for (chain, &depth) in chains.iter_mut().zip(&depths) {
            while chain.len() <= depth + 1 {
                let last = &chain[chain.len() - 1];
                check_growth(pool, first_node, [&drift, last], 1)?;
                let next = bracket(pool, &states, &drift, last);
                chain.push(next);
            }
        }
        if pool.len() - first_node > MAX_NODES {
            return Ok(None);
        }
        let inner = chains.iter().zip(&depths).flat_map(|(c, &k)| c[..k].to_vec());
        let ends = chains.iter().zip(&depths).map(|(c, &k)| (&c[k], &c[k + 1]));
        let mut all: Vec<Field> = inner.clone().collect();
        all.extend(ends.clone().map(|e| e.0.clone()));
        let whole = involutive_closure(pool, &states, &all, bindings, evidence)?.basis;
        if whole.len() >= n || frame.rank(pool, &whole, evidence)? < whole.len() {
            continue;
        }
        // K: all but the ends of chains, and those ends whose bracket with f is in D.
        let mut reduced: Vec<Field> = inner.collect();
        for (end, next) in ends {
            let mut longer = whole.clone();
            longer.push(next.clone());
            if independent(pool, &longer, bindings, evidence)?.len() == whole.len() {
                reduced.push(end.clone());
            }
        }
        let reduced = involutive_closure(pool, &states, &reduced, bindings, evidence)?.basis;
        let old = reduced.len();
        if old >= whole.len() || frame.rank(pool, &reduced, evidence)? < old {
            continue;
        }
        let mut d = reduced;
        d.extend(whole);
        let d = independent(pool, &d, bindings, evidence)?;
        if frame.rank(pool, &d, evidence)? < d.len() {
            continue;
        }
        let hull = Echelon::invariant(&frame.evaluate(pool, &d, evidence)?, n, |v| times(&a_exact, v));
        let q = n - hull.rank();
        if q == 0 {
            continue;
        }
        let mut derived = Vec::new();
        for y in &d {
            check_growth(pool, first_node, [&drift, y], 1)?;
            derived.push(bracket(pool, &states, &drift, y));
        }
        // K is spanned by the first `old` fields.
        let fresh = old..d.len();
        let mut forms: Vec<Field> = Vec::new();
        for i in fresh.clone() {
            for j in fresh.clone() {
                check_growth(pool, first_node, [&d[i], &derived[j]], 1)?;
                forms.push(bracket(pool, &states, &d[i], &derived[j]));
            }
        }
        let m = fresh.len();
        let (Some(at), Some(forms)) = (frame.numbers(pool, &d.concat()), frame.numbers(pool, &forms.concat())) else {
            return Ok(None);
        };
        let b = DMatrix::from_column_slice(n, d.len(), &at);
        let Some(across) = complement(&a, &b, hull.rank()) else { return Ok(None) };
        let forms: Vec<DVector<f64>> =
            forms.chunks(n).map(|v| across.transpose() * DVector::from_column_slice(v)).collect();
        let matrices: Vec<DMatrix<f64>> = (0..q).map(|c| DMatrix::from_fn(m, m, |i, j| forms[i * m + j][c])).collect();
        if definite_combination(&matrices) {
            return Ok(Some(depths.iter().copied().max().unwrap_or(0)));
        }
    }
    Ok(None)
}

/// Most choices of depths, and new nodes, in the search for a definite form.
const MAX_DEPTHS: usize = 40;
const MAX_NODES: usize = 50_000;

/// Depths of the chains of all inputs, shallow ones first.
fn depths(inputs: usize, states: usize) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    for total in 0..states {
        let mut lists = vec![(Vec::new(), total)];
        for i in 0..inputs {
            let last = i + 1 == inputs;
            lists = lists
                .into_iter()
                .flat_map(|(list, rest): (Vec<usize>, usize)| {
                    (if last { rest } else { 0 }..=rest).map(move |k| {
                        let mut list = list.clone();
                        list.push(k);
                        (list, rest - k)
                    })
                })
                .take(MAX_DEPTHS)
                .collect();
        }
        all.extend(lists.into_iter().map(|l| l.0));
        if all.len() >= MAX_DEPTHS {
            break;
        }
    }
    all
}

/// Rounds of the search for a definite combination.
const ROUNDS: usize = 500;

/// Whether Σ λ_c Q_c is found definite for some λ: where it is not, λ is moved to where the
/// quadratic forms are larger on the eigenvector of the least eigenvalue (a perceptron, which
/// ends if a λ exists).
fn definite_combination(matrices: &[DMatrix<f64>]) -> bool {
    let symmetric: Vec<DMatrix<f64>> = matrices.iter().map(|q| (q + q.transpose()) * 0.5).collect();
    let size = symmetric.iter().map(DMatrix::norm).fold(0.0, f64::max);
    if size < 1e-12 {
        return false;
    }
    let mut lambda: Vec<f64> = symmetric.iter().map(|q| q.trace() / size).collect();
    if lambda.iter().all(|l| l.abs() < 1e-12) {
        return false;
    }
    for _ in 0..ROUNDS {
        let m = symmetric[0].nrows();
        let sum = symmetric.iter().zip(&lambda).fold(DMatrix::zeros(m, m), |s, (q, &l)| s + q * l);
        if definite(&sum) == Some(true) {
            return true;
        }
        let Some(eigen) = symmetric_eigen(sum) else { return false };
        let least = eigen.eigenvalues.imin();
        let v = eigen.eigenvectors.column(least).into_owned();
        let step: Vec<f64> = symmetric.iter().map(|q| (v.transpose() * q * &v)[0] / size).collect();
        if step.iter().all(|s| s.abs() < 1e-12) {
            return false;
        }
        for (l, s) in lambda.iter_mut().zip(step) {
            *l += s;
        }
    }
    false
}
