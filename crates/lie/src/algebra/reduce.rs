//! Simpler fields that span the same distribution at a generic point.

use bracketry_symbolic::{Bindings, Expr, Pool};

use crate::algebra::field::Field;
use crate::evidence::Evidence;
use crate::residues::{Echelon, Fp, OFFSET};

/// Seed and number of the points at which unit fields are looked for.
const SEED: u64 = 0x6272_6163_6b65_7405;
const POINTS: usize = 3;

/// Fields in place of others with the same span.
pub(crate) struct Reduced {
    /// Spans Δ_k.
    pub(crate) spanning: Vec<Field>,
    /// Spans Δ_k together with Δ_{k−1}, as many as there were new ones.
    pub(crate) fresh: Vec<Field>,
    /// Coordinates i with ∂/∂x_i in Δ_k; empty if the fields are the old ones.
    pub(crate) units: Vec<usize>,
}

/// Uses the coordinate fields in Δ_k: they stand for others of their own span, and the rest needs no
/// component along them.
///
/// `old` are independent fields that span Δ_{k−1} at a generic point, `old` with `new` independent fields
/// that span Δ_k. Over the field K of functions any basis of Δ_k is as good as any other for the
/// dimensions that follow, but brackets with coordinate fields are mere partial derivatives, and zeros stay
/// zeros: without this, brackets of n-trailers grow exponentially with their length, with it they do not.
///
/// ∂/∂x_i counts as in Δ_k if it is at all of a few random points.
pub(crate) fn reduce(
    pool: &mut Pool,
    old: &[Field],
    new: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Reduced {
    let all: Vec<Field> = old.iter().chain(new).cloned().collect();
    simpler(pool, &all, old.len(), bindings, evidence).unwrap_or_else(|| Reduced {
        spanning: all,
        fresh: new.to_vec(),
        units: Vec::new(),
    })
}

/// None if there is no coordinate field in the span, or none can be looked for.
fn simpler(
    pool: &mut Pool,
    all: &[Field],
    old: usize,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Option<Reduced> {
    let n = all.first()?.len();
    evidence.allow_elimination(all.len(), n).ok()?;
    let samples = pool.sample_in::<OFFSET>(&all.concat(), bindings, POINTS, SEED).ok()?;
    if samples.ambiguous_signs > 0 {
        return None;
    }
    let mut is_unit = vec![true; n];
    for values in &samples.values {
        let span = Echelon::new(&values.chunks(n).map(<[_]>::to_vec).collect::<Vec<_>>(), n);
        let units: Vec<usize> = unit_rows(&span).collect();
        is_unit.iter_mut().enumerate().for_each(|(i, all)| *all &= units.contains(&i));
    }
    let units: Vec<usize> = (0..n).filter(|&i| is_unit[i]).collect();
    if units.is_empty() {
        return None;
    }
    evidence.add_memberships(&samples, all.len(), n).ok()?;
    let (zero, one) = (pool.int(0), pool.int(1));
    let unit = |i: usize| -> Field { (0..n).map(|k| if k == i { one } else { zero }).collect() };
    let rest = |field: &Field| -> Field { zeroed(field, &units, zero) };
    // Of the lists below the first independent ones are taken, at a point where the old ones are independent.
    samples.values.iter().find_map(|values| {
        let rows: Vec<Vec<_>> = values.chunks(n).map(<[_]>::to_vec).collect();
        let value_of_rest = |j: usize| zeroed(&rows[j], &units, Fp::ZERO);
        let value_of_unit = |i: usize| (0..n).map(|k| u64::from(k == i)).map(Fp::new).collect();
        let mut fresh = Vec::new();
        let mut span = Echelon::new(&rows[..old], n);
        for &i in &units {
            if span.rank() < all.len() && span.insert(value_of_unit(i)) {
                fresh.push(unit(i));
            }
        }
        for j in old..all.len() {
            if span.rank() < all.len() && span.insert(value_of_rest(j)) {
                fresh.push(rest(&all[j]));
            }
        }
        let mut spanning: Vec<Field> = units.iter().map(|&i| unit(i)).collect();
        let mut span = Echelon::empty(n);
        for &i in &units {
            span.insert(value_of_unit(i));
        }
        for j in 0..all.len() {
            if span.insert(value_of_rest(j)) {
                spanning.push(rest(&all[j]));
            }
        }
        let complete = spanning.len() == all.len() && fresh.len() == all.len() - old;
        complete.then(|| Reduced { spanning, fresh, units: units.clone() })
    })
}

/// The columns for which the span holds the row that is 1 there and 0 elsewhere.
fn unit_rows(span: &Echelon) -> impl Iterator<Item = usize> {
    let alone = |row: &[Fp], p: usize| row.iter().enumerate().all(|(j, x)| j == p || x.is_zero());
    span.pivots.iter().zip(&span.rows).filter(move |(p, row)| alone(row, **p)).map(|(p, _)| *p)
}

/// The field without its components along some coordinates.
pub(crate) fn zeroed<T: Copy>(field: &[T], coordinates: &[usize], zero: T) -> Vec<T> {
    let mut rest = field.to_vec();
    for &i in coordinates {
        rest[i] = zero;
    }
    rest
}

impl Reduced {
    /// The field modulo the coordinate fields.
    pub(crate) fn remainder(&self, pool: &mut Pool, field: &[Expr]) -> Field {
        let zero = pool.int(0);
        zeroed(field, &self.units, zero)
    }
}
