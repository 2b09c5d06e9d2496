//! The nearest positive semidefinite matrix, block by block.

use nalgebra::{DMatrix, SymmetricEigen};

/// Groups the indices 0 … size−1 that are linked by an off-diagonal entry.
pub(crate) fn components(size: usize, links: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..size).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for &(i, j) in links {
            let low = label[i].min(label[j]);
            changed |= label[i] != low || label[j] != low;
            label[i] = low;
            label[j] = low;
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); size];
    for (i, &l) in label.iter().enumerate() {
        groups[l].push(i);
    }
    groups.retain(|g| !g.is_empty());
    groups
}

/// Clips the negative eigenvalues of a symmetric matrix to zero; a positive semidefinite matrix stays exactly as it is.
pub(crate) fn clip_to_psd(h: &mut DMatrix<f64>) {
    if h.nrows() == 1 {
        h[(0, 0)] = h[(0, 0)].max(0.0);
        return;
    }
    if h.iter().any(|v| !v.is_finite()) || h.clone().cholesky().is_some() {
        return;
    }
    let mut eigen = SymmetricEigen::new(h.clone());
    if eigen.eigenvalues.iter().all(|&l| l >= 0.0) {
        return;
    }
    eigen.eigenvalues.iter_mut().for_each(|l| *l = l.max(0.0));
    *h = eigen.recompose();
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_semidefinite_matrix_is_left_alone() {
        let h = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 3.0]);
        let mut c = h.clone();
        clip_to_psd(&mut c);
        assert_eq!(c, h);
    }

    #[test]
    fn the_negative_part_of_a_saddle_is_removed() {
        // xy has the eigenvalues ±1/2·2 with eigenvectors (1, ±1)/√2; the positive part is (x + y)²/4.
        let mut h = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        clip_to_psd(&mut h);
        assert_relative_eq!(h, DMatrix::from_element(2, 2, 0.5), epsilon = 1e-14);
    }

    #[test]
    fn chains_are_one_component() {
        let c = components(6, &[(4, 1), (1, 0), (3, 5)]);
        assert_eq!(c, vec![vec![0, 1, 4], vec![2], vec![3, 5]]);
    }
}
