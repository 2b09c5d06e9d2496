//! The estimators of a Cartesian compliance, in scaled coordinates.

use super::minimum::minimize;
use super::scaled::Row;
use bracketry_numerics::eigen::{pseudo_inverse, svd};
use nalgebra::{DMatrix, DVector, Matrix6, SMatrix, SVector, Vector6};

/// Covariance of the 36 entries, column by column.
pub(super) type EntryCovariance = SMatrix<f64, 36, 36>;

/// Refits with weights renewed from the last compliance.
const REWEIGHTED: usize = 20;
/// Smallest eigenvalue of a positive definite compliance, relative to the mean one of the start.
const FLOOR: f64 = 1e-6;

/// Sums over rows: `Σ W Wᵀ`, `Σ X Wᵀ`, `Σ X Xᵀ`.
struct Sums {
    ww: Matrix6<f64>,
    xw: Matrix6<f64>,
    xx: Matrix6<f64>,
}

impl Sums {
    fn of(rows: &[Row]) -> Self {
        let mut sums = Self { ww: Matrix6::zeros(), xw: Matrix6::zeros(), xx: Matrix6::zeros() };
        for row in rows {
            sums.ww += row.wrench * row.wrench.transpose();
            sums.xw += row.displacement * row.wrench.transpose();
            sums.xx += row.displacement * row.displacement.transpose();
        }
        sums
    }
}

/// `Σ` of the noises over the rows: of wrenches and of displacements.
pub(super) fn noise_sums(rows: &[Row]) -> (Matrix6<f64>, Matrix6<f64>) {
    rows.iter()
        .fold((Matrix6::zeros(), Matrix6::zeros()), |(w, x), row| (w + row.wrench_noise, x + row.displacement_noise))
}

/// `K = Σ W ΔXᵀ (Σ ΔX ΔXᵀ)⁻¹` with the covariance of its entries, and the condition of the displacements.
pub(super) fn wrench_on_displacement(rows: &[Row]) -> Option<(Matrix6<f64>, EntryCovariance, f64)> {
    let sums = Sums::of(rows);
    let gram = sums.xx.try_inverse()?;
    let stiffness = sums.xw.transpose() * gram;
    let (wrench, displacement) = noise_sums(rows);
    let noise = (wrench + stiffness * displacement * stiffness.transpose()) / rows.len() as f64;
    let eigenvalues = sums.xx.symmetric_eigenvalues();
    Some((stiffness, gram.kronecker(&noise), (eigenvalues.max() / eigenvalues.min()).sqrt()))
}

/// `C = Σ ΔX Wᵀ (Σ W Wᵀ)⁻¹`.
pub(super) fn displacement_on_wrench(rows: &[Row]) -> Option<(Matrix6<f64>, EntryCovariance)> {
    let sums = Sums::of(rows);
    let gram = sums.ww.try_inverse()?;
    let compliance = sums.xw * gram;
    let covariance = rows.iter().fold(Matrix6::zeros(), |sum, row| sum + row.covariance(&compliance));
    Some((compliance, gram.kronecker(&(covariance / rows.len() as f64))))
}

/// Minimizes `Σ rᵀ (Σ_X + C Σ_W Cᵀ)⁻¹ r`, `r = ΔX − C W`, with the covariances renewed from the last C.
pub(super) fn weighted(rows: &[Row]) -> Option<(Matrix6<f64>, EntryCovariance)> {
    let (mut compliance, _) = displacement_on_wrench(rows)?;
    let mut covariance = EntryCovariance::zeros();
    for _ in 0..REWEIGHTED {
        let mut normal = EntryCovariance::zeros();
        let mut right = Matrix6::zeros();
        for row in rows {
            let weight = row.covariance(&compliance).try_inverse()?;
            normal += (row.wrench * row.wrench.transpose()).kronecker(&weight);
            right += weight * row.displacement * row.wrench.transpose();
        }
        covariance = normal.cholesky()?.inverse();
        let entries = covariance * SVector::<f64, 36>::from_column_slice(right.as_slice());
        let next = Matrix6::from_column_slice(entries.as_slice());
        let change = (next - compliance).norm();
        compliance = next;
        if change <= 1e-10 * compliance.norm() {
            break;
        }
    }
    Some((compliance, covariance))
}

/// Total least squares: the six-dimensional space nearest to `[W, ΔX]`, each in units of its (mean) noise, is the graph of C
/// (Golub and Van Loan 1980). Maximum likelihood where both are noisy.
pub(super) fn total_least_squares(rows: &[Row]) -> Option<(Matrix6<f64>, EntryCovariance)> {
    let count = rows.len() as f64;
    let (wrench_noise, displacement_noise) = noise_sums(rows);
    let wrench_scale = (wrench_noise / count).cholesky()?.l();
    let displacement_scale = (displacement_noise / count).cholesky()?.l();
    let (whiten_w, whiten_x) = (wrench_scale.try_inverse()?, displacement_scale.try_inverse()?);
    let data = DMatrix::from_fn(rows.len().max(12), 12, |i, j| match rows.get(i) {
        Some(row) if j < 6 => (whiten_w.row(j) * row.wrench)[0],
        Some(row) => (whiten_x.row(j - 6) * row.displacement)[0],
        None => 0.0,
    });
    let right = svd(&data)?.v_t?;
    // Singular values come in descending order: the last six rows span what is orthogonal to the graph.
    let orthogonal = right.rows(6, 6);
    let w = Matrix6::from_fn(|i, j| orthogonal[(i, j)]);
    let x = Matrix6::from_fn(|i, j| orthogonal[(i, j + 6)]);
    let compliance = displacement_scale * (-x.try_inverse()? * w) * whiten_w;
    // To first order the noise of W only adds to that of ΔX; the loads without it are the regressors.
    let loads = Sums::of(rows).ww - wrench_noise;
    let noise = (displacement_noise + compliance * wrench_noise * compliance.transpose()) / count;
    Some((compliance, loads.cholesky()?.inverse().kronecker(&noise)))
}

/// The same sum of squares, `Σ rᵀ (Σ_X + C Σ_W Cᵀ)⁻¹ r` (maximum likelihood), over symmetric positive definite `C = G Gᵀ + floor`
/// with lower triangular G: nothing is lost by a full-rank factor (Burer and Monteiro 2005).
pub(super) fn positive_definite(rows: &[Row], most_iterations: usize) -> Option<(Matrix6<f64>, EntryCovariance, bool)> {
    let (free, _) = displacement_on_wrench(rows)?;
    let mut eigen = (0.5 * (free + free.transpose())).symmetric_eigen();
    let unit = eigen.eigenvalues.abs().mean();
    eigen.eigenvalues.apply(|v| *v = (*v / unit - FLOOR).max(1e-3));
    let factor = eigen.recompose().cholesky()?.l();
    let start = DVector::from_iterator(21, lower().map(|(i, j)| factor[(i, j)]));
    let factor = |g: &DVector<f64>| {
        let mut factor = Matrix6::zeros();
        lower().zip(g.iter()).for_each(|(place, v)| factor[place] = *v);
        factor
    };
    let compliance = |g: &DVector<f64>| {
        let factor = factor(g);
        unit * (factor * factor.transpose() + FLOOR * Matrix6::identity())
    };
    let rows = compressed(rows);
    let residuals = |g: &DVector<f64>| {
        let compliance = compliance(g);
        let mut stacked = DVector::zeros(6 * rows.len());
        let mut whiten = None;
        for (n, row) in rows.iter().enumerate() {
            if n == 0 || !same_noise(row, &rows[n - 1]) {
                whiten = Some(row.covariance(&compliance).cholesky()?.l());
            }
            let residual = row.displacement - compliance * row.wrench;
            let white: Vector6<f64> = whiten.as_ref()?.solve_lower_triangular(&residual)?;
            stacked.fixed_rows_mut::<6>(6 * n).copy_from(&white);
        }
        Some(stacked)
    };
    let minimum = minimize(residuals, &start, most_iterations)?;
    // Entries per parameter: d(G Gᵀ) = dG Gᵀ + G dGᵀ.
    let g = factor(&minimum.parameters);
    let mut entries = DMatrix::zeros(36, 21);
    for (k, place) in lower().enumerate() {
        let mut one = Matrix6::zeros();
        one[place] = unit;
        let moved = one * g.transpose() + g * one.transpose();
        entries.column_mut(k).copy_from_slice(moved.as_slice());
    }
    let information = minimum.jacobian.tr_mul(&minimum.jacobian);
    let tiny = 1e-12 * information.amax();
    let covariance = &entries * pseudo_inverse(&information, tiny)? * entries.transpose();
    let covariance = EntryCovariance::from_column_slice(covariance.as_slice());
    Some((compliance(&minimum.parameters), covariance, minimum.converged))
}

fn lower() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

fn same_noise(a: &Row, b: &Row) -> bool {
    a.wrench_noise == b.wrench_noise && a.displacement_noise == b.displacement_noise
}

/// Rows of the same noise as twelve with the same sums: the triangular factor of `[W, ΔX]`.
fn compressed(rows: &[Row]) -> Vec<Row> {
    if rows.len() <= 12 || rows.iter().any(|row| !same_noise(row, &rows[0])) {
        return rows.to_vec();
    }
    let data =
        DMatrix::from_fn(rows.len(), 12, |i, j| if j < 6 { rows[i].wrench[j] } else { rows[i].displacement[j - 6] });
    let r = data.qr().r();
    let of = |i: usize, from: usize| Vector6::from_fn(|j, _| r[(i, from + j)]);
    (0..12).map(|i| Row { wrench: of(i, 0), displacement: of(i, 6), ..rows[0].clone() }).collect()
}
