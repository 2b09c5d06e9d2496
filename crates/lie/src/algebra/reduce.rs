//! Simpler fields that span the same distribution at a generic point.

use bracketry_symbolic::{Bindings, Expr, Pool, Samples};

use crate::algebra::field::Field;
use crate::algebra::peel::Peeled;
use crate::evidence::Evidence;
use crate::residues::{Echelon, Fp, OFFSET, Span, unit_row};

/// Seed and number of the points at which unit fields are looked for.
const SEED: u64 = 0x6272_6163_6b65_7405;
const POINTS: usize = 3;

/// A distribution Δ_k at a generic point.
pub(crate) struct Reduced {
    /// Whether ∂/∂x_i is known to be in Δ_k, for each coordinate.
    pub(crate) units: Vec<bool>,
    /// With those coordinate fields they span Δ_k; independent modulo them and without components along them.
    pub(crate) rest: Vec<Field>,
    /// Spans Δ_k together with Δ_{k−1}, as many as there were new ones.
    pub(crate) fresh: Vec<Field>,
}

/// Uses the coordinate fields in Δ_k: they stand for others of their own span, and the rest needs no
/// component along them.
///
/// `old` spans Δ_{k−1} at a generic point, with the independent `new` it spans Δ_k; these have no components along its
/// coordinate fields. Over the field K of functions any basis of Δ_k is as good as any other for the dimensions that
/// follow, but brackets with coordinate fields are mere partial derivatives, and zeros stay zeros: without this, brackets
/// of n-trailers grow exponentially with their length, with it they do not.
///
/// ∂/∂x_i counts as in Δ_k if it is at all of a few random points.
pub(crate) fn reduce(
    pool: &mut Pool,
    old: Reduced,
    new: Vec<Field>,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Reduced {
    match simpler(pool, &old, &new, bindings, evidence) {
        Some(reduced) => reduced,
        None => old.with(new),
    }
}

/// None if there is no coordinate field in the span that was not known, or none can be looked for.
fn simpler(
    pool: &mut Pool,
    before: &Reduced,
    new: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Option<Reduced> {
    let (zero, one) = (pool.int(0), pool.int(1));
    let old = before.rest.len();
    let all = [&before.rest, new].concat();
    let n = before.units.len();
    let peeled = Peeled::of(pool, &all);
    let samples = if peeled.rest.is_empty() { None } else { Some(sampled(pool, &all, &peeled, bindings, evidence)?) };
    let columns = &peeled.columns;
    let rows = |values: &[Fp]| values.chunks(columns.len()).map(<[_]>::to_vec).collect::<Vec<_>>();
    // Coordinates, by their number among the columns, whose fields are in the span of the rest.
    let mut found = vec![samples.is_some(); columns.len()];
    for values in samples.iter().flat_map(|s| &s.values) {
        let mut span = Span::empty(columns.len());
        for row in rows(values) {
            span.insert(row);
        }
        found.iter_mut().zip(&span.units).for_each(|(all, unit)| *all &= unit);
    }
    let of_rest: Vec<usize> = (0..columns.len()).filter(|&i| found[i]).collect();
    if let (Some(samples), false) = (&samples, of_rest.is_empty()) {
        evidence.add_memberships(samples, peeled.rest.len(), columns.len()).ok()?;
    }
    // The new coordinate fields, with the number of a plain unit row or the column of one that was found.
    let mut coordinates: Vec<(usize, Unit)> = peeled.units.iter().map(|&(i, c)| (c, Unit::Plain(i))).collect();
    coordinates.extend(of_rest.iter().map(|&i| (columns[i], Unit::Found(i))));
    coordinates.sort_unstable_by_key(|u| u.0);
    if coordinates.is_empty() {
        return None;
    }
    let mut units = before.units.clone();
    for &(c, _) in &coordinates {
        units[c] = true;
    }
    let unit = |i: usize| -> Field { (0..n).map(|k| if k == i { one } else { zero }).collect() };
    let without = |field: &Field| -> Field { zeroed(field, &units, zero) };
    // Of the lists below the first independent ones are taken, at a point where the old ones are independent.
    let points = samples.map_or_else(|| vec![Vec::new()], |s| s.values);
    points.iter().find_map(|values| {
        let rows = if columns.is_empty() { Vec::new() } else { rows(values) };
        let row_of_rest = |r: usize| zeroed(&rows[r], &found, Fp::ZERO);
        let mut fresh = Vec::new();
        let olds = peeled.rest.partition_point(|&i| i < old);
        let mut span = Echelon::new(&rows[..olds], columns.len());
        for &(c, from) in &coordinates {
            let is_new = match from {
                Unit::Plain(i) => i >= old,
                Unit::Found(i) => fresh.len() < new.len() && span.insert(unit_row(i, columns.len())),
            };
            if is_new {
                fresh.push(unit(c));
            }
        }
        for (r, &j) in peeled.rest.iter().enumerate().skip(olds) {
            if fresh.len() < new.len() && span.insert(row_of_rest(r)) {
                fresh.push(without(&all[j]));
            }
        }
        let mut rest: Vec<Field> = Vec::new();
        let mut span = Echelon::empty(columns.len());
        for (r, &j) in peeled.rest.iter().enumerate() {
            if span.insert(row_of_rest(r)) {
                rest.push(without(&all[j]));
            }
        }
        let complete = coordinates.len() + rest.len() == all.len() && fresh.len() == new.len();
        complete.then(|| Reduced { units: units.clone(), rest, fresh })
    })
}

/// Where a coordinate field comes from.
#[derive(Clone, Copy)]
enum Unit {
    /// A row of this number.
    Plain(usize),
    /// The span of the rest, in whose columns it has this number.
    Found(usize),
}

/// Values of the rest at a few points.
fn sampled(
    pool: &mut Pool,
    all: &[Field],
    peeled: &Peeled,
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Option<Samples<OFFSET>> {
    evidence.allow_elimination(peeled.rest.len(), peeled.columns.len()).ok()?;
    let samples = pool.sample_in::<OFFSET>(&peeled.rest(all).concat(), bindings, POINTS, SEED).ok()?;
    (samples.ambiguous_signs == 0).then_some(samples)
}

/// The field without its components along some coordinates.
fn zeroed<T: Copy>(field: &[T], coordinates: &[bool], zero: T) -> Vec<T> {
    field.iter().zip(coordinates).map(|(&x, &gone)| if gone { zero } else { x }).collect()
}

impl Reduced {
    /// Nothing yet, of `n` coordinates.
    pub(crate) fn empty(n: usize) -> Self {
        Reduced { units: vec![false; n], rest: Vec::new(), fresh: Vec::new() }
    }

    /// Dimension of Δ_k.
    pub(crate) fn dimension(&self) -> usize {
        self.units.iter().filter(|u| **u).count() + self.rest.len()
    }

    /// With other fields, which are independent of those that it has, as they are.
    pub(crate) fn with(mut self, new: Vec<Field>) -> Self {
        self.rest.extend(new.iter().cloned());
        Reduced { fresh: new, ..self }
    }

    /// The field modulo the coordinate fields.
    pub(crate) fn remainder(&self, zero: Expr, field: &[Expr]) -> Field {
        zeroed(field, &self.units, zero)
    }
}
