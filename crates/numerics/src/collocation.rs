//! Rules of quadrature on [0, 1], and the Runge–Kutta methods of collocation at their nodes. Their coefficients follow from the nodes
//! alone: a_ij = ∫₀^{c_i} ℓ_j, b_j = ∫₀¹ ℓ_j with the Lagrange polynomials ℓ_j (Hairer and Wanner 1996, section IV.5).

use nalgebra::DMatrix;

/// Nodes and weights of the Gauss–Legendre rule of five points, of order 10.
pub const GAUSS_5: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

const ROOT_6: f64 = 2.449_489_742_783_178;

/// Nodes of the Radau IIA method of three stages, of order 5.
pub const RADAU_3_NODES: [f64; 3] = [(4.0 - ROOT_6) / 10.0, (4.0 + ROOT_6) / 10.0, 1.0];

/// Its matrix A, by rows.
pub const RADAU_3: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * ROOT_6) / 360.0, (296.0 - 169.0 * ROOT_6) / 1800.0, (-2.0 + 3.0 * ROOT_6) / 225.0],
    [(296.0 + 169.0 * ROOT_6) / 1800.0, (88.0 + 7.0 * ROOT_6) / 360.0, (-2.0 - 3.0 * ROOT_6) / 225.0],
    [(16.0 - ROOT_6) / 36.0, (16.0 + ROOT_6) / 36.0, 1.0 / 9.0],
];

/// The inverse of A in the basis of its eigenvectors: `A⁻¹ = T diag(real, alpha ∓ i beta) T⁻¹`, the complex pair by real and imaginary
/// parts, as [`RADAU_3_TRANSFORMED`] gives it.
#[derive(Clone, Copy, Debug)]
pub struct Transformed {
    /// The real eigenvalue.
    pub real: f64,
    /// Real part of the complex ones.
    pub alpha: f64,
    /// Their imaginary part.
    pub beta: f64,
    /// T, by rows.
    pub matrix: [[f64; 3]; 3],
    /// T⁻¹, by rows.
    pub inverse: [[f64; 3]; 3],
}

/// The eigenvalues of the inverse of [`RADAU_3`] (Hairer and Wanner 1996, section IV.8).
pub const RADAU_3_TRANSFORMED: Transformed = Transformed {
    real: 3.637_834_252_744_496,
    alpha: 2.681_082_873_627_752_3,
    beta: 3.050_430_199_247_410_5,
    matrix: [
        [0.094_438_762_488_975_24, -0.141_255_295_020_954_2, 0.030_029_194_105_147_42],
        [0.250_213_122_965_333_3, 0.204_129_352_293_799_94, -0.382_942_112_757_261_9],
        [1.0, 1.0, 0.0],
    ],
    inverse: [
        [4.178_718_591_551_904, 0.327_682_820_761_062_37, 0.523_376_445_499_449_5],
        [-4.178_718_591_551_904, -0.327_682_820_761_062_37, 0.476_623_554_500_550_5],
        [0.502_872_634_945_786_8, -2.571_926_949_855_605, 0.596_039_204_828_224_9],
    ],
};

/// Coefficients of a Runge–Kutta method: X_i = x + h Σ_j a_ij f(t + c_j h, X_j), x₁ = x + h Σ_j b_j f(t + c_j h, X_j).
///
/// ```
/// use bracketry_numerics::collocation::Tableau;
/// let midpoint = Tableau::gauss_legendre(1);
/// assert!((midpoint.c[0] - 0.5).abs() < 1e-15 && (midpoint.a[0] - 0.5).abs() < 1e-15 && (midpoint.b[0] - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Debug)]
pub struct Tableau {
    /// Nodes.
    pub c: Vec<f64>,
    /// The matrix A, row by row.
    pub a: Vec<f64>,
    /// Weights.
    pub b: Vec<f64>,
}

impl Tableau {
    /// The Gauss–Legendre method, of order `2 · stages`; one to four stages.
    pub fn gauss_legendre(stages: usize) -> Self {
        Self::collocation(&roots(|x| legendre(stages, x), stages))
    }

    /// The Radau IIA method, of order `2 · stages − 1`; one to four stages.
    pub fn radau_iia(stages: usize) -> Self {
        Self::collocation(&roots(|x| legendre(stages, x) - legendre(stages - 1, x), stages))
    }

    /// Number of stages.
    pub fn stages(&self) -> usize {
        self.c.len()
    }

    /// From a node's monomials to integrals: Σ_j a_ij c_j^k = c_i^{k+1}/(k + 1) and Σ_j b_j c_j^k = 1/(k + 1).
    fn collocation(c: &[f64]) -> Self {
        let s = c.len();
        let power = DMatrix::from_fn(s, s, |k, j| c[j].powi(k as i32));
        let integral = |to: f64| DMatrix::from_fn(s, 1, |k, _| to.powi(k as i32 + 1) / (k + 1) as f64);
        let factors = power.lu();
        // The nodes are distinct, so the Vandermonde matrix is regular.
        let row = |to: f64| factors.solve(&integral(to)).map_or_else(|| vec![f64::NAN; s], |r| r.as_slice().to_vec());
        Self { a: c.iter().flat_map(|&ci| row(ci)).collect(), b: row(1.0), c: c.to_vec() }
    }
}

/// Legendre polynomial of this degree, shifted to \[0, 1\].
fn legendre(degree: usize, x: f64) -> f64 {
    let z = 2.0 * x - 1.0;
    let (mut before, mut now) = (0.0, 1.0);
    for k in 0..degree {
        let next = ((2 * k + 1) as f64 * z * now - k as f64 * before) / (k + 1) as f64;
        (before, now) = (now, next);
    }
    now
}

/// The `count` roots of `p` in (0, 1], which are simple and farther apart than 1/64 for the degrees in use.
fn roots(p: impl Fn(f64) -> f64, count: usize) -> Vec<f64> {
    const CELLS: usize = 64;
    let mut found = Vec::with_capacity(count);
    for cell in 0..CELLS {
        // Offset, so that no root but the one at 1 falls on a border.
        let border = |k: usize| if k == CELLS { 1.0 } else { (k as f64 - 0.25).max(0.0) / CELLS as f64 };
        let (mut low, mut high) = (border(cell), border(cell + 1));
        if high == 1.0 && p(1.0).abs() < 1e-14 {
            found.push(1.0);
            continue;
        }
        if p(low) * p(high) >= 0.0 {
            continue;
        }
        let rising = p(high) > 0.0;
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if (p(middle) > 0.0) == rising {
                high = middle;
            } else {
                low = middle;
            }
        }
        found.push(f64::midpoint(low, high));
    }
    found
}
