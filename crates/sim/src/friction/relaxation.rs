//! Directions of several unit vectors that leave zero, one after the other: each gets the direction that fits the others as they are.
//!
//! Alone, `λ s = σ̇ = g + J s` with `|s| = 1` is the problem of a trust region: with the eigenvalues `d ≤ 0` of `J`, `λ ≥ 0` solves the
//! secular equation `Σ h²/(λ − d)² = 1`, where `h` are the components of `g` (Conn, Gould, and Toint 2000, section 7.3).
//! This also finds the part of a direction that has no influence and merely follows σ̇, however slowly σ grows.

use bracketry_numerics::eigen::symmetric_eigen;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::ops::Range;

const PASSES: usize = 200;
/// Change of a direction that is rounding.
const CONVERGED: f64 = 1e-14;
/// Part of `|g|` below which `λ` is 0.
const LEAST_RATE: f64 = 1e-18;

/// Turns the directions `s`, by rows of the influence `∂σ̇/∂s`, from where they have the rates `σ̇`.
pub(super) fn relax(s: &mut DVector<f64>, mut rates: DVector<f64>, influence: &DMatrix<f64>, blocks: &[Range<usize>]) {
    let symmetric = |rows: &Range<usize>| {
        let own = influence.view((rows.start, rows.start), (rows.len(), rows.len()));
        0.5 * (own + own.transpose())
    };
    let own: Vec<_> = blocks.iter().map(symmetric).collect();
    let Some(eigen) = own.iter().cloned().map(symmetric_eigen).collect::<Option<Vec<_>>>() else { return };
    for _ in 0..PASSES {
        let mut change = 0.0f64;
        for ((rows, own), eigen) in blocks.iter().zip(&own).zip(&eigen) {
            let before = s.rows(rows.start, rows.len()).into_owned();
            let free = rates.rows(rows.start, rows.len()) - own * &before;
            let Some(next) = direction(eigen, &free) else { continue };
            let turn = next - before;
            change = change.max(turn.amax());
            rates += influence.columns(rows.start, rows.len()) * &turn;
            let mut part = s.rows_mut(rows.start, rows.len());
            part += turn;
        }
        if change <= CONVERGED {
            return;
        }
    }
}

/// The unit vector `s` with `λ s = g + J s`; none where nothing tells it.
fn direction(influence: &SymmetricEigen<f64, nalgebra::Dyn>, free: &DVector<f64>) -> Option<DVector<f64>> {
    let along = influence.eigenvectors.tr_mul(free);
    let size = along.norm();
    let at = |rate: f64| along.zip_map(&influence.eigenvalues, |h, d| h / (rate - d.min(0.0)));
    // |s| falls with λ and is at most 1 at |g|.
    let (mut low, mut high) = (LEAST_RATE * size, size);
    if at(low).norm() > 1.0 {
        for _ in 0..80 {
            let middle = (low * high).sqrt();
            if at(middle).norm() > 1.0 { low = middle } else { high = middle }
        }
    }
    let s = &influence.eigenvectors * at(low);
    let length = s.norm();
    (length > 0.0 && length.is_finite()).then(|| s / length)
}
