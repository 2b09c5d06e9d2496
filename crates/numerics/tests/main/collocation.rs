//! Rules and methods against published coefficients and their order.

use approx::assert_relative_eq;
use bracketry_numerics::collocation::{GAUSS_5, RADAU_3, RADAU_3_NODES, RADAU_3_TRANSFORMED, Tableau};

#[test]
fn published_coefficients_come_out() {
    // Hairer and Wanner II, tables IV.5.1, IV.5.5.
    let gauss = Tableau::gauss_legendre(2);
    let r = 3f64.sqrt() / 6.0;
    let expected = [0.25, 0.25 - r, 0.25 + r, 0.25];
    for (a, e) in gauss.a.iter().zip(expected) {
        assert_relative_eq!(*a, e, epsilon = 1e-14);
    }
    let radau = Tableau::radau_iia(2);
    for (a, e) in radau.a.iter().zip([5.0 / 12.0, -1.0 / 12.0, 0.75, 0.25]) {
        assert_relative_eq!(*a, e, epsilon = 1e-14);
    }
    let radau = Tableau::radau_iia(3);
    assert_relative_eq!(radau.c[0], (4.0 - 6f64.sqrt()) / 10.0, epsilon = 1e-14);
    assert_relative_eq!(radau.b[2], 1.0 / 9.0, epsilon = 1e-14);
}

/// `T⁻¹ A T` times the blocks of the eigenvalues is the identity.
#[test]
fn the_basis_of_eigenvectors_splits_the_radau_method() {
    let basis = RADAU_3_TRANSFORMED;
    let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|l| a[i][l] * b[l][j]).sum()))
    };
    let blocks = [[basis.real, 0.0, 0.0], [0.0, basis.alpha, basis.beta], [0.0, -basis.beta, basis.alpha]];
    let both =
        [product(basis.inverse, basis.matrix), product(product(basis.inverse, product(RADAU_3, basis.matrix)), blocks)];
    for identity in both {
        for (i, row) in identity.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert_relative_eq!(*entry, f64::from(u8::from(i == j)), epsilon = 1e-13);
            }
        }
    }
}

#[test]
fn quadrature_is_exact_up_to_the_order() {
    for stages in 1..=4 {
        for (t, order) in [(Tableau::gauss_legendre(stages), 2 * stages), (Tableau::radau_iia(stages), 2 * stages - 1)]
        {
            assert_eq!(t.stages(), stages);
            let moment = |k: i32| t.b.iter().zip(&t.c).map(|(b, c)| b * c.powi(k)).sum::<f64>();
            for k in 0..order as i32 {
                assert_relative_eq!(moment(k), 1.0 / f64::from(k + 1), epsilon = 1e-13);
            }
            let k = order as i32;
            assert!((moment(k) - 1.0 / f64::from(k + 1)).abs() > 1e-7, "no higher order");
        }
    }
}

#[test]
fn constants_are_those_of_the_nodes() {
    let radau = Tableau::radau_iia(3);
    for (i, row) in RADAU_3.iter().enumerate() {
        assert_relative_eq!(radau.c[i], RADAU_3_NODES[i], epsilon = 1e-14);
        for (j, a) in row.iter().enumerate() {
            assert_relative_eq!(radau.a[3 * i + j], *a, epsilon = 1e-14);
        }
    }
    for k in 0..10 {
        let moment: f64 = GAUSS_5.iter().map(|(node, weight)| weight * node.powi(k)).sum();
        assert_relative_eq!(moment, 1.0 / f64::from(k + 1), epsilon = 1e-14);
    }
}
