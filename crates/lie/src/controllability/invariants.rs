//! Functions that no mode changes, put together from those of the single modes.

use bracketry_symbolic::{Bindings, Expr, Func, Pool};

use crate::algebra::span::{independent_rows, vanishes};
use crate::controllability::occurrence::{Edge, Occurrence};
use crate::controllability::surface::Surface;
use crate::evidence::Evidence;
use crate::modes::ModeFields;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// A continuous function of the state with one piece in each mode.
#[derive(Clone, Debug)]
pub(crate) struct Glued {
    /// One piece per mode; 0 in impossible ones.
    pub(crate) pieces: Vec<Expr>,
    /// The whole, with signs of the switching functions.
    pub(crate) whole: Expr,
    /// Whether it never changes; else it grows at a constant rate.
    pub(crate) constant: bool,
}

/// Most modes whose functions are put together, and unknown coefficients.
const MAX_MODES: usize = 8;
const MAX_UNKNOWNS: usize = 60;
/// Seed of the points, and how many more than unknowns.
const SEED: u64 = 0x6272_6163_6b65_7412;
const SPARE: usize = 4;
/// Largest numerator and denominator of a coefficient.
const BOUND: u64 = 1 << 20;

/// Combinations with constant coefficients of the functions `lists`, which no input influences in their mode, that agree on
/// the surfaces between the modes and change at the same constant rate in all of them.
pub(crate) fn glued(
    pool: &mut Pool,
    modes: &[ModeFields],
    occurrence: &Occurrence,
    lists: &[Vec<Expr>],
    evidence: &mut Evidence,
) -> Result<Vec<Glued>, Undecided> {
    let Some(first) = modes.first() else { return Ok(Vec::new()) };
    let (states, bindings) = (first.fields.states.clone(), first.fields.bindings.clone());
    let possible: Vec<usize> = (0..modes.len()).filter(|&k| !occurrence.impossible[k]).collect();
    if possible.len() > MAX_MODES || possible.iter().any(|&k| lists[k].is_empty()) {
        return Ok(Vec::new());
    }
    let Some(Conditions { start, unknowns, rows, surfaces }) =
        Conditions::of(pool, modes, occurrence, lists, &possible, evidence)?
    else {
        return Ok(Vec::new());
    };
    let mut found: Vec<Glued> = Vec::new();
    for vector in Echelon::new(&rows, unknowns).null_space() {
        let Some(c) = vector.iter().map(|c| c.to_rational(BOUND)).collect::<Option<Vec<_>>>() else { continue };
        let mut pieces = vec![pool.int(0); modes.len()];
        for &k in &possible {
            let mut terms = Vec::new();
            for (i, &phi) in lists[k].iter().enumerate() {
                let factor = pool.rational(c[start[k] + i].clone());
                terms.push(pool.mul(factor, phi));
            }
            terms.push(pool.rational(c[start[k] + lists[k].len()].clone()));
            let sum = pool.sum(terms);
            pieces[k] = pool.simplify(sum);
        }
        let mut continuous = true;
        for (edge, surface) in &surfaces {
            let gap = pool.sub(pieces[edge.modes[0]], pieces[edge.modes[1]]);
            let gap = surface.restrict(pool, &[gap])[0];
            continuous &= vanishes(pool, gap, &bindings);
        }
        let Some(constant) = rate(pool, modes, &possible, &pieces, &bindings).filter(|_| continuous) else { continue };
        // Independent of the others in some mode.
        let mut independent = false;
        for &k in &possible {
            let mut all: Vec<Vec<Expr>> = found.iter().map(|g| pool.gradient(g.pieces[k], &states)).collect();
            all.push(pool.gradient(pieces[k], &states));
            independent |= independent_rows(pool, &all, &bindings, evidence)?.len() == all.len();
        }
        if !independent {
            continue;
        }
        let whole = whole(pool, modes, &possible, &pieces);
        found.push(Glued { pieces, whole, constant });
    }
    Ok(found)
}

/// Linear conditions for the coefficients.
struct Conditions<'a> {
    /// The first unknown of each mode: a coefficient for each of its functions and a constant. The common rate comes last.
    start: Vec<usize>,
    unknowns: usize,
    rows: Vec<Vec<Fp>>,
    surfaces: Vec<(&'a Edge, Surface)>,
}

impl<'a> Conditions<'a> {
    /// None if there are too many unknowns, or a surface is solved for no state.
    fn of(
        pool: &mut Pool,
        modes: &[ModeFields],
        occurrence: &'a Occurrence,
        lists: &[Vec<Expr>],
        possible: &[usize],
        evidence: &mut Evidence,
    ) -> Result<Option<Self>, Undecided> {
        let Some(fields) = modes.first().map(|m| &m.fields) else { return Ok(None) };
        let (states, bindings) = (fields.states.clone(), fields.bindings.clone());
        // Unknowns: a coefficient for each function of each mode, and a constant for each mode, 0 in the first.
        let mut start = vec![0; modes.len()];
        let mut unknowns = 0;
        for &k in possible {
            start[k] = unknowns;
            unknowns += lists[k].len() + 1;
        }
        // The common rate.
        unknowns += 1;
        if unknowns > MAX_UNKNOWNS {
            return Ok(None);
        }
        let mut rows: Vec<Vec<Fp>> = vec![vec![Fp::ZERO; unknowns]];
        rows[0][start[possible[0]] + lists[possible[0]].len()] = Fp::ONE;
        for &k in possible {
            let drift = &modes[k].fields.drift;
            let rates: Vec<Expr> = lists[k].iter().map(|&phi| pool.lie_derivative(phi, &states, drift)).collect();
            let samples = pool.sample_in::<OFFSET>(&rates, &bindings, unknowns + SPARE, SEED)?;
            evidence.add_rank(&samples, unknowns)?;
            for values in &samples.values {
                let mut row = vec![Fp::ZERO; unknowns];
                row[start[k]..start[k] + values.len()].copy_from_slice(values);
                row[unknowns - 1] = -Fp::ONE;
                rows.push(row);
            }
        }
        let mut surfaces = Vec::new();
        for edge in &occurrence.edges {
            let s = modes[edge.modes[0]].surfaces[edge.switch];
            let Some(surface) = Surface::solve(pool, &states, s, &bindings) else { return Ok(None) };
            let [a, b] = edge.modes;
            let both = [lists[a].clone(), lists[b].clone()].concat();
            let on_surface = surface.restrict(pool, &both);
            let samples = pool.sample_in::<OFFSET>(&on_surface, &bindings, unknowns + SPARE, SEED)?;
            evidence.add_rank(&samples, unknowns)?;
            for values in &samples.values {
                let mut row = vec![Fp::ZERO; unknowns];
                for (i, &v) in values.iter().enumerate() {
                    match i.checked_sub(lists[a].len()) {
                        None => row[start[a] + i] = v,
                        Some(j) => row[start[b] + j] = -v,
                    }
                }
                row[start[a] + lists[a].len()] = Fp::ONE;
                row[start[b] + lists[b].len()] = -Fp::ONE;
                rows.push(row);
            }
            surfaces.push((edge, surface));
        }
        Ok(Some(Conditions { start, unknowns, rows, surfaces }))
    }
}

/// Whether the rate of change is 0 in all modes (true) or another constant, the same in all (false); none otherwise.
fn rate(
    pool: &mut Pool,
    modes: &[ModeFields],
    possible: &[usize],
    pieces: &[Expr],
    bindings: &Bindings,
) -> Option<bool> {
    let mut rate = None;
    for &k in possible {
        let fields = &modes[k].fields;
        for g in &fields.controls {
            let along = pool.lie_derivative(pieces[k], &fields.states, g);
            if !vanishes(pool, along, bindings) {
                return None;
            }
        }
        let along = pool.lie_derivative(pieces[k], &fields.states, &fields.drift);
        let along = if vanishes(pool, along, bindings) { pool.int(0) } else { pool.simplify(along) };
        if fields.states.iter().any(|&s| pool.depends_on(along, s)) {
            return None;
        }
        let first = *rate.get_or_insert(along);
        let gap = pool.sub(along, first);
        if !vanishes(pool, gap, bindings) {
            return None;
        }
    }
    rate.map(|r| pool.is_zero(r))
}

/// The pieces as one expression: of two, (φ₊ + φ₋)/2 + sign(s) (φ₊ − φ₋)/2, where |s| absorbs a factor s.
fn whole(pool: &mut Pool, modes: &[ModeFields], possible: &[usize], pieces: &[Expr]) -> Expr {
    let half = pool.ratio(1, 2);
    if let [a, b] = *possible
        && let [s] = modes[a].surfaces[..]
    {
        let (p, m) = if modes[a].sign_list()[0] > 0 { (pieces[a], pieces[b]) } else { (pieces[b], pieces[a]) };
        let (sum, gap) = (pool.add(p, m), pool.sub(p, m));
        let gap = pool.simplify(gap);
        if pool.is_zero(gap) {
            return p;
        }
        let quotient = pool.div(gap, s);
        let quotient = pool.simplify(quotient);
        let smooth = pool.reachable(&[quotient]).into_iter().all(|e| !negative_power(pool, e));
        let kink = if smooth {
            let size = pool.call(Func::Abs, s);
            pool.mul(size, quotient)
        } else {
            let sign = pool.call(Func::Sign, s);
            pool.mul(sign, gap)
        };
        let total = pool.add(sum, kink);
        let mean = pool.mul(half, total);
        return pool.expand(mean);
    }
    let mut terms = Vec::new();
    for &k in possible {
        let mut term = pieces[k];
        for (&s, sign) in modes[k].surfaces.iter().zip(modes[k].sign_list()) {
            let of_s = pool.call(Func::Sign, s);
            let signed = if sign > 0 { of_s } else { pool.neg(of_s) };
            let one = pool.int(1);
            let twice = pool.add(one, signed);
            let indicator = pool.mul(half, twice);
            term = pool.mul(indicator, term);
        }
        terms.push(term);
    }
    pool.sum(terms)
}

fn negative_power(pool: &Pool, e: Expr) -> bool {
    let bracketry_symbolic::Node::Pow(_, k) = pool.node(e) else { return false };
    pool.number(k).is_none_or(|k| *k < bracketry_symbolic::Rational::ZERO)
}
