//! Inputs within their ranges that hold the state at a point, by linear programming.

use bracketry_symbolic::{Expr, Pool, Rational};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::controllability::balance::balance;
use crate::controllability::input_set::InputSet;
use crate::controllability::input_values::{InputValues, Side};
use crate::controllability::local_accessibility::Frame;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::linear::program::{Optimum, Program};
use crate::residues::{Echelon, Fp};
use crate::undecided::Undecided;

/// Most inputs of a linear program.
const MAX_INPUTS: usize = 32;
/// Smallest distance from the ends of ranges, relative to their widths, that counts as inside, and smallest rate, relative to
/// its terms, that counts as positive: where all values are rational, and where they are rounded. The ends of ranges are the
/// shortest fractions that their floating-point numbers stand for.
const CLEAR: [f64; 2] = [1e-9, 1e-6];
/// Denominators of inputs that are chosen where values are rounded.
const GRID: f64 = 1e6;

/// Whether inputs within their ranges hold the state at a point: 0 = f + Σ u_i g_i there.
pub(crate) enum Holding {
    /// These do; each is strictly inside its range unless all inputs that hold the state have it at that end.
    With(Vec<Expr>),
    /// None do: the rate of this linear function is at least a positive number for all inputs in their ranges.
    Never(Vec<Rational>),
    /// Not decided.
    Open,
}

/// The vectors g_1 … g_m, f at a point.
struct Velocities {
    /// A row for each state.
    rows: Vec<Vec<Rational>>,
    exact: bool,
}

/// Decides whether inputs within their ranges hold the state, and finds some that are as far inside as they can be.
pub(crate) fn holding(
    pool: &mut Pool,
    system: &VectorFields,
    set: &InputSet<'_>,
    states: &[Expr],
    evidence: &mut Evidence,
) -> Result<Holding, Error> {
    let Some(bounds) = bounds(set) else { return Ok(Holding::Open) };
    let Some(velocities) = Velocities::at(pool, system, states, evidence)? else { return Ok(Holding::Open) };
    let clear = CLEAR[usize::from(!velocities.exact)];
    match velocities.farthest_inside(&bounds) {
        Some(Inside::Strictly(u, margin)) if margin.to_f64().value() > clear => {
            if velocities.exact {
                return Ok(Holding::With(u.into_iter().map(|u| pool.rational(u)).collect()));
            }
            let rounded = |u: Rational| Rational::simplest_from_f64((u.to_f64().value() * GRID).round() / GRID);
            let Some(chosen) = u.into_iter().map(rounded).collect::<Option<Vec<_>>>() else { return Ok(Holding::Open) };
            let chosen: Vec<Expr> = chosen.into_iter().map(|u| pool.rational(u)).collect();
            let Some(inputs) = balance(pool, system, states, &chosen, evidence)? else { return Ok(Holding::Open) };
            let inside = is_inside(pool, system, states, &inputs, &bounds)?;
            Ok(if inside { Holding::With(inputs) } else { Holding::Open })
        }
        Some(Inside::AtEnds(u)) if velocities.exact => {
            Ok(Holding::With(u.into_iter().map(|u| pool.rational(u)).collect()))
        }
        Some(Inside::Never(covector)) => {
            let far = bounds.iter().any(|(l, h)| l.is_none() || h.is_none());
            // A rounded field may have a small part along the covector, which an input without a bound makes large.
            let trusted = velocities.exact || !far;
            Ok(match velocities.least_rate(&covector, &bounds) {
                Some((least, size)) if trusted && least > clear * size => Holding::Never(covector),
                _ => Holding::Open,
            })
        }
        _ => Ok(Holding::Open),
    }
}

/// Deviations of the inputs at an equilibrium, to the sides that are allowed, that leave the state at rest; each is zero
/// only if it is for all of them. `None` where the fields at the point are not rational.
pub(crate) fn deviations(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<Option<Vec<Expr>>, Undecided> {
    if sides.len() > MAX_INPUTS {
        return Ok(None);
    }
    let Some(velocities) = Velocities::at(pool, &frame.fields, frame.point(), evidence)?.filter(|v| v.exact) else {
        return Ok(None);
    };
    let end = |inside: bool| Some(if inside { Rational::ONE } else { Rational::ZERO });
    let bound = |s: &Option<Side>| (end(*s != Some(Side::Above)).map(|e| -e), end(*s != Some(Side::Below)));
    let bounds: Vec<Bound> = sides.iter().map(bound).collect();
    let Some(Inside::Strictly(found, _) | Inside::AtEnds(found)) = velocities.farthest_inside(&bounds) else {
        return Ok(None);
    };
    Ok(Some(found.into_iter().map(|u| pool.rational(u)).collect()))
}

/// Whether some λ is positive on the fields of all inputs at an equilibrium, taken to the sides to which they move, but those
/// that vanish there; false where it is not known.
pub(crate) fn points_to_one_side(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<bool, Undecided> {
    let values = frame.evaluate(pool, &frame.fields.controls, evidence)?;
    let acting: Vec<usize> = (0..sides.len()).filter(|&i| values[i].iter().any(|x| *x != Fp::ZERO)).collect();
    let Some(signs) = acting.iter().map(|&i| sides[i].map(Side::sign)).collect::<Option<Vec<_>>>() else {
        return Ok(false);
    };
    if acting.len() > MAX_INPUTS {
        return Ok(false);
    }
    let Some(velocities) = Velocities::at(pool, &frame.fields, frame.point(), evidence)? else { return Ok(false) };
    // Gordan: some λ is positive on all vectors just where no weights ≥ 0 of sum 1 bring them to zero.
    let mut equations: Vec<(Vec<Rational>, Rational)> = Vec::new();
    for row in &velocities.rows {
        let entry = |(&i, &s): (&usize, &i64)| &row[i] * Rational::from(s);
        equations.push((acting.iter().zip(&signs).map(entry).collect(), Rational::ZERO));
    }
    equations.push((vec![Rational::ONE; acting.len()], Rational::ONE));
    let program = Program { equations: equations.clone(), bounds: vec![(Some(Rational::ZERO), None); acting.len()] };
    let Some(Optimum::Infeasible(mut covector)) = program.maximize(&vec![Rational::ZERO; acting.len()]) else {
        return Ok(false);
    };
    covector.pop();
    Ok(velocities.exact
        || (0..acting.len()).all(|k| {
            let terms = covector.iter().zip(&equations).map(|(l, e)| (l * &e.0[k]).to_f64().value());
            let (sum, size) = terms.fold((0.0, 0.0), |(sum, size), t| (sum + t, size + t.abs()));
            sum > CLEAR[1] * size
        }))
}

/// λ that is zero on the fields of inputs that move to both sides and nonnegative on those of the others, taken to their sides,
/// with as many clear of zero as can be; `None` if it is zero on all, or the fields at the point are not rational.
pub(crate) fn supporting(
    pool: &mut Pool,
    frame: &Frame,
    sides: &[Option<Side>],
    evidence: &mut Evidence,
) -> Result<Option<Vec<Rational>>, Undecided> {
    let one_sided = sides.iter().flatten().count();
    if one_sided == 0 || sides.len() > MAX_INPUTS {
        return Ok(None);
    }
    let Some(velocities) = Velocities::at(pool, &frame.fields, frame.point(), evidence)?.filter(|v| v.exact) else {
        return Ok(None);
    };
    // Unknowns: λ, and for each one-sided input p in [0, 1] and q ≥ 0 with ±λ·g = p + q.
    let n = velocities.rows.len();
    let mut bounds: Vec<Bound> = vec![(None, None); n];
    let mut equations = Vec::new();
    for (i, side) in sides.iter().enumerate() {
        let sign = Rational::from(side.map_or(1, Side::sign));
        let mut row: Vec<Rational> = velocities.rows.iter().map(|r| &sign * &r[i]).collect();
        row.resize(n + 2 * one_sided, Rational::ZERO);
        if side.is_some() {
            row[bounds.len()] = -Rational::ONE;
            row[bounds.len() + 1] = -Rational::ONE;
            bounds.push((Some(Rational::ZERO), Some(Rational::ONE)));
            bounds.push((Some(Rational::ZERO), None));
        }
        equations.push((row, Rational::ZERO));
    }
    let wanted: Vec<Rational> =
        (0..bounds.len()).map(|k| if k >= n && (k - n) % 2 == 0 { Rational::ONE } else { Rational::ZERO }).collect();
    let Some(Optimum::Found(mut x)) = (Program { equations, bounds }).maximize(&wanted) else { return Ok(None) };
    let positive = x[n..].iter().any(|p| *p > Rational::ZERO);
    x.truncate(n);
    Ok(positive.then_some(x))
}

type Bound = (Option<Rational>, Option<Rational>);

/// The ends of the ranges; `None` where they are not known.
fn bounds(set: &InputSet<'_>) -> Option<Vec<Bound>> {
    let mut all = Vec::new();
    for (values, said) in set.values.iter().zip(&set.one_sided) {
        all.push(match *values {
            Some(InputValues::Between(lower, upper)) if lower < upper => {
                let end = |e: f64| {
                    let exact = Rational::simplest_from_f64(e);
                    if e.is_finite() { exact.map(Some) } else { Some(None) }
                };
                (end(lower)?, end(upper)?)
            }
            None if said.is_none() => (None, None),
            // What is said of an input at the point says nothing of it at other values.
            _ => return None,
        });
    }
    (all.len() <= MAX_INPUTS).then_some(all)
}

/// The length to which distances from the ends are compared: the width of the range, where it is finite.
fn width((lower, upper): &Bound) -> Rational {
    match (lower, upper) {
        (Some(l), Some(h)) => h - l,
        _ => Rational::ONE,
    }
}

fn is_inside(
    pool: &mut Pool,
    system: &VectorFields,
    states: &[Expr],
    inputs: &[Expr],
    bounds: &[Bound],
) -> Result<bool, Error> {
    let zeros = vec![pool.int(0); inputs.len()];
    let frame = Frame::new(pool, system, states, &zeros)?;
    let Some(numbers) = frame.numbers(pool, inputs) else { return Ok(false) };
    Ok(numbers.iter().zip(bounds).all(|(u, b)| {
        let margin = CLEAR[1] * width(b).to_f64().value();
        let above = b.0.as_ref().is_none_or(|l| u - l.to_f64().value() > margin);
        above && b.1.as_ref().is_none_or(|h| h.to_f64().value() - u > margin)
    }))
}

enum Inside {
    /// With the distance from all ends, relative to the widths.
    Strictly(Vec<Rational>, Rational),
    AtEnds(Vec<Rational>),
    Never(Vec<Rational>),
}

impl Velocities {
    /// Where values are irrational, only of states whose rows are independent; `None` if a value has no number.
    fn at(
        pool: &mut Pool,
        system: &VectorFields,
        states: &[Expr],
        evidence: &mut Evidence,
    ) -> Result<Option<Velocities>, Undecided> {
        let (n, m) = (system.states.len(), system.controls.len());
        let at: FxHashMap<Expr, Expr> = system.states.iter().zip(states).map(|(&s, &v)| (pool.sym(s), v)).collect();
        let zeros = vec![pool.int(0); m];
        let Ok(frame) = Frame::new(pool, system, states, &zeros) else { return Ok(None) };
        let mut columns = system.controls.clone();
        columns.push(system.drift.clone());
        let here = pool.substitute_all(&columns.concat(), &at);
        let row = |values: &[Rational], c: usize| (0..=m).map(|i| values[i * n + c].clone()).collect::<Vec<_>>();
        if let Some(values) = frame.rationals(pool, &here) {
            return Ok(Some(Velocities { rows: (0..n).map(|c| row(&values, c)).collect(), exact: true }));
        }
        let Some(numbers) = frame.numbers(pool, &here) else { return Ok(None) };
        let Some(values) = numbers.into_iter().map(Rational::simplest_from_f64).collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let residues = frame.evaluate(pool, &columns, evidence)?;
        let mut echelon = Echelon::empty(m + 1);
        let independent: Vec<usize> =
            (0..n).filter(|&c| echelon.insert(residues.iter().map(|v| v[c]).collect::<Vec<Fp>>())).collect();
        let zero = vec![Rational::ZERO; m + 1];
        let rows = (0..n).map(|c| if independent.contains(&c) { row(&values, c) } else { zero.clone() }).collect();
        Ok(Some(Velocities { rows, exact: false }))
    }

    /// Σ u_i g_i = −f, among further unknowns that do not occur.
    fn equations(&self, further: usize) -> Vec<(Vec<Rational>, Rational)> {
        let one = |row: &Vec<Rational>| {
            let (f, g) = (&row[row.len() - 1], &row[..row.len() - 1]);
            let mut left = g.to_vec();
            left.extend(std::iter::repeat_n(Rational::ZERO, further));
            (left, -f.clone())
        };
        self.rows.iter().map(one).collect()
    }

    /// Inputs that hold the state with the largest distance from the ends of their ranges, relative to their widths. Where
    /// that is zero, the mean of inputs that are each as far as can be from one end: at an end only if all are.
    fn farthest_inside(&self, bounds: &[Bound]) -> Option<Inside> {
        let m = bounds.len();
        let ends = || {
            let of = |(i, (l, h)): (usize, &Bound)| [(i, l.clone(), Rational::ONE), (i, h.clone(), -Rational::ONE)];
            bounds.iter().enumerate().flat_map(of).filter_map(|(i, end, sign)| Some((i, end?, sign)))
        };
        // Unknowns: the inputs, the distance t, and a slack for each end: sign·(u − end) − width·t = slack.
        let count = ends().count();
        let mut equations = self.equations(1 + count);
        let mut all = bounds.to_vec();
        all.push((Some(Rational::ZERO), Some(Rational::ONE)));
        for (k, (i, end, sign)) in ends().enumerate() {
            let mut row = vec![Rational::ZERO; m + 1 + count];
            row[i].clone_from(&sign);
            row[m] = -width(&bounds[i]);
            row[m + 1 + k] = -Rational::ONE;
            equations.push((row, sign * end));
            all.push((Some(Rational::ZERO), None));
        }
        let mut wanted = vec![Rational::ZERO; m + 1 + count];
        wanted[m] = Rational::ONE;
        match (Program { equations, bounds: all }).maximize(&wanted)? {
            Optimum::Found(mut x) if x[m] > Rational::ZERO => {
                x.truncate(m + 1);
                let margin = x.pop()?;
                Some(Inside::Strictly(x, margin))
            }
            Optimum::Found(_) => self.among_ends(bounds, ends()),
            Optimum::Infeasible(_) => {
                let plain = Program { equations: self.equations(0), bounds: bounds.to_vec() };
                match plain.maximize(&vec![Rational::ZERO; m])? {
                    Optimum::Infeasible(covector) => Some(Inside::Never(covector)),
                    _ => None,
                }
            }
            Optimum::Unbounded => None,
        }
    }

    /// The mean of inputs that hold the state, one for each end, as far from it as can be and at most a width.
    fn among_ends(&self, bounds: &[Bound], ends: impl Iterator<Item = (usize, Rational, Rational)>) -> Option<Inside> {
        let m = bounds.len();
        let (mut sum, mut count) = (vec![Rational::ZERO; m], 0);
        for (i, end, sign) in ends {
            // Unknowns: the inputs, the distance, and what is left to the end: sign·(u − end) − distance = slack.
            let mut equations = self.equations(2);
            let mut row = vec![Rational::ZERO; m + 2];
            row[i].clone_from(&sign);
            row[m] = -Rational::ONE;
            row[m + 1] = -Rational::ONE;
            equations.push((row, sign * end));
            let mut all = bounds.to_vec();
            all.push((Some(Rational::ZERO), Some(width(&bounds[i]))));
            all.push((Some(Rational::ZERO), None));
            let mut wanted = vec![Rational::ZERO; m + 2];
            wanted[m] = Rational::ONE;
            let Optimum::Found(x) = (Program { equations, bounds: all }).maximize(&wanted)? else { return None };
            sum.iter_mut().zip(x).for_each(|(s, x)| *s += x);
            count += 1;
        }
        let mean: Vec<Rational> = sum.into_iter().map(|s| s / Rational::from(count)).collect();
        // A distance that is not zero but within rounding of the ends is left open.
        let clear = mean.iter().zip(bounds).all(|(u, b)| {
            let near = |e: &Option<Rational>| {
                let distance = e.as_ref().map_or(Rational::ONE, |e| u - e).to_f64().value().abs();
                distance != 0.0 && distance <= CLEAR[0] * (1.0 + u.to_f64().value().abs())
            };
            !near(&b.0) && !near(&b.1)
        });
        (count > 0 && clear).then_some(Inside::AtEnds(mean))
    }

    /// The least rate of λ·x for inputs in their ranges, with the sum of the sizes of its terms; `None` if there is none.
    fn least_rate(&self, covector: &[Rational], bounds: &[Bound]) -> Option<(f64, f64)> {
        let m = bounds.len();
        let along = |i: usize| covector.iter().zip(&self.rows).fold(Rational::ZERO, |s, (l, row)| s + l * &row[i]);
        let mut rate = along(m);
        let mut size = rate.to_f64().value().abs();
        for (i, (lower, upper)) in bounds.iter().enumerate() {
            let slope = along(i);
            if slope == Rational::ZERO {
                continue;
            }
            let end = if slope > Rational::ZERO { lower.as_ref()? } else { upper.as_ref()? };
            let term = slope * end;
            size += term.to_f64().value().abs();
            rate += term;
        }
        (rate > Rational::ZERO).then(|| (rate.to_f64().value(), size))
    }
}
