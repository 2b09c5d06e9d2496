//! The exact dimensions agree with floating-point ranks of brackets by finite differences.

use crate::common::{disk, ellipse, fields};
use bracketry_lie::analysis::mode_fields;
use bracketry_lie::{Evidence, VectorFields};
use bracketry_symbolic::{Expr, Pool, Tape};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};
use rustc_hash::FxHashMap;

type NumericField = Box<dyn Fn(&DVector<f64>) -> DVector<f64>>;

/// A field as a function of numbers, without any symbolic derivative.
fn numeric(pool: &mut Pool, v: &VectorFields, field: &[Expr]) -> NumericField {
    let mut at = FxHashMap::default();
    for s in pool.symbols_of(field) {
        if let Some(value) = v.bindings.get(s).cloned() {
            let (x, c) = (pool.sym(s), pool.rational(value));
            at.insert(x, c);
        }
    }
    let field = pool.substitute_all(field, &at);
    let tape = Tape::compile(pool, &v.states, &field).unwrap();
    Box::new(move |x| {
        let mut out = DVector::zeros(x.len());
        tape.eval(x.as_slice(), &mut Vec::new(), out.as_mut_slice());
        out
    })
}

/// Derivative of `b` along the vector `a` at x: central differences with one Richardson step.
fn along(b: &dyn Fn(&DVector<f64>) -> DVector<f64>, x: &DVector<f64>, a: &DVector<f64>, h: f64) -> DVector<f64> {
    let d = |h: f64| (b(&(x + a * h)) - b(&(x - a * h))) / (2.0 * h);
    (d(h / 2.0) * 4.0 - d(h)) / 3.0
}

/// Value at x of the right-normed bracket of the letters.
fn value(letters: &[NumericField], word: &[usize], x: &DVector<f64>, h: f64) -> DVector<f64> {
    let a = &letters[word[0]];
    if word.len() == 1 {
        return a(x);
    }
    let rest = |x: &DVector<f64>| value(letters, &word[1..], x, h);
    along(&rest, x, &a(x), h) - along(&**a, x, &rest(x), h)
}

/// Rank by singular values, with the gap that makes it trustworthy asserted.
fn rank(columns: &[DVector<f64>]) -> usize {
    let columns: Vec<DVector<f64>> = columns.iter().filter(|c| c.norm() > 1e-5).map(|c| c / c.norm()).collect();
    if columns.is_empty() {
        return 0;
    }
    let m = DMatrix::from_columns(&columns);
    let mut s: Vec<f64> = m.svd(false, false).singular_values.iter().copied().collect();
    s.sort_by(|a, b| b.total_cmp(a));
    let r = s.iter().filter(|v| **v > 1e-4).count();
    let gap = s.get(r).map_or(0.0, |next| next / s[r - 1]);
    assert!(gap < 0.05, "no clear rank: {s:?}");
    r
}

/// Growth over all right-normed words up to `length`.
fn growth(pool: &mut Pool, v: &VectorFields, x: &[f64], length: usize) -> Vec<usize> {
    growth_of(pool, v, x, length, |_| true)
}

/// The same over the words that contain an input field.
fn strong_growth(pool: &mut Pool, v: &VectorFields, x: &[f64], length: usize) -> Vec<usize> {
    growth_of(pool, v, x, length, |word| word.iter().any(|&letter| letter > 0))
}

fn growth_of(
    pool: &mut Pool,
    v: &VectorFields,
    x: &[f64],
    length: usize,
    counts: impl Fn(&[usize]) -> bool,
) -> Vec<usize> {
    let mut letters = vec![numeric(pool, v, &v.drift)];
    letters.extend(v.controls.iter().map(|g| numeric(pool, v, g)));
    let x = DVector::from_column_slice(x);
    let mut words: Vec<Vec<usize>> = (0..letters.len()).map(|i| vec![i]).collect();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    let mut list = Vec::new();
    for k in 1..=length {
        columns.extend(words.iter().filter(|w| counts(w)).map(|w| value(&letters, w, &x, 0.02)));
        list.push(rank(&columns));
        if k < length {
            words = (0..letters.len())
                .flat_map(|i| {
                    words.iter().filter(move |w| w.len() > 1 || w[0] > i).map(move |w| {
                        let mut longer = vec![i];
                        longer.extend(w);
                        longer
                    })
                })
                .collect();
        }
    }
    list
}

/// States of ordinary size: x, y, phi, vx, vy, w, X, Xd, theta, thetad.
const POINTS: [[f64; 10]; 2] =
    [[0.3, -0.2, 0.7, 0.4, -0.3, 0.9, 0.1, 0.5, 0.35, -0.8], [-0.1, 0.25, -1.1, -0.6, 0.2, -0.4, 0.3, -0.2, -0.5, 1.1]];

/// Compares growth and strong growth at all points; returns the exact ones.
fn compare(system: &mut System, v: &VectorFields, what: &str) -> [Vec<usize>; 2] {
    let all = v.accessibility(&mut system.pool, &mut Evidence::default()).unwrap().growth;
    let strong = v.strong_accessibility(&mut system.pool, &mut Evidence::default()).unwrap().growth;
    for x in &POINTS {
        assert_eq!(growth(&mut system.pool, v, x, all.len()), all, "{what}");
        assert_eq!(strong_growth(&mut system.pool, v, x, strong.len()), strong, "{what}: strong");
    }
    [all, strong]
}

#[test]
fn in_every_mode_of_the_plate() {
    for (mut plate, wanted) in [(disk(None), [2, 4, 6, 6].to_vec()), (ellipse(None), [2, 4, 6, 8, 8].to_vec())] {
        for mode in mode_fields(&mut plate).unwrap() {
            let [_, strong] = compare(&mut plate, &mode.fields, &format!("{:?}", mode.signs));
            assert_eq!(strong, wanted);
        }
    }
}

#[test]
fn for_the_plate_with_switching() {
    for mut plate in [disk(None), ellipse(None)] {
        let family: Vec<VectorFields> = mode_fields(&mut plate).unwrap().into_iter().map(|m| m.fields).collect();
        let all = VectorFields::switched(&mut plate.pool, &family).unwrap();
        let [growth, strong] = compare(&mut plate, &all, "switched");
        assert_eq!(growth, [6, 10]);
        assert_eq!(strong.last(), Some(&10));
    }
}

#[test]
fn for_the_smoothed_plate() {
    for mut plate in [disk(None), ellipse(None)] {
        // Wide enough for finite differences; the dimension does not depend on the width.
        let width = plate.pool.ratio(1, 2);
        let mut smooth = plate.smoothed(width);
        let v = fields(&mut smooth);
        let [_, strong] = compare(&mut smooth, &v, "smoothed");
        assert_eq!(strong.last(), Some(&10));
    }
}

#[test]
fn at_rest_for_the_smoothed_plate() {
    for mut plate in [disk(None), ellipse(None)] {
        let width = plate.pool.ratio(1, 2);
        let mut smooth = plate.smoothed(width);
        let v = fields(&mut smooth);
        let mut rest = [0.0; 10];
        rest[..2].copy_from_slice(&[0.48, -0.03]);
        assert_eq!(growth(&mut smooth.pool, &v, &rest, 4), [2, 5, 8, 10]);
        assert_eq!(strong_growth(&mut smooth.pool, &v, &rest, 4), [2, 5, 8, 10]);
    }
}
