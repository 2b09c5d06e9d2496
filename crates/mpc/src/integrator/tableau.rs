//! Coefficients of Runge–Kutta methods. Those of collocation follow from the nodes alone: a_ij = ∫₀^{c_i} ℓ_j, b_j = ∫₀¹ ℓ_j with the
//! Lagrange polynomials ℓ_j (Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.5).

use super::method::Integrator;
use nalgebra::DMatrix;

/// X_i = x + h Σ_j a_ij f(t + c_j h, X_j), x₁ = x + h Σ_j b_j f(t + c_j h, X_j).
#[derive(Clone, Debug)]
pub(crate) struct Tableau {
    pub(crate) c: Vec<f64>,
    /// Row by row.
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
}

impl Tableau {
    pub(crate) fn new(integrator: Integrator) -> Self {
        match integrator {
            Integrator::Rk4 => {
                let mut a = vec![0.0; 16];
                (a[4], a[9], a[14]) = (0.5, 0.5, 1.0);
                let (sixth, third) = (1.0 / 6.0, 1.0 / 3.0);
                Self { c: vec![0.0, 0.5, 0.5, 1.0], a, b: vec![sixth, third, third, sixth] }
            }
            // It has no stages.
            Integrator::Map => Self { c: Vec::new(), a: Vec::new(), b: Vec::new() },
            Integrator::GaussLegendre { stages } => Self::collocation(&roots(|x| legendre(stages, x), stages)),
            Integrator::RadauIIA { stages } => {
                Self::collocation(&roots(|x| legendre(stages, x) - legendre(stages - 1, x), stages))
            }
        }
    }

    pub(crate) fn stages(&self) -> usize {
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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn published_coefficients_come_out() {
        // Hairer and Wanner II, tables IV.5.1, IV.5.5.
        let gauss = Tableau::new(Integrator::GaussLegendre { stages: 2 });
        let r = 3f64.sqrt() / 6.0;
        let expected = [0.25, 0.25 - r, 0.25 + r, 0.25];
        for (a, e) in gauss.a.iter().zip(expected) {
            assert_relative_eq!(*a, e, epsilon = 1e-14);
        }
        let radau = Tableau::new(Integrator::RadauIIA { stages: 2 });
        for (a, e) in radau.a.iter().zip([5.0 / 12.0, -1.0 / 12.0, 0.75, 0.25]) {
            assert_relative_eq!(*a, e, epsilon = 1e-14);
        }
        let radau = Tableau::new(Integrator::RadauIIA { stages: 3 });
        assert_relative_eq!(radau.c[0], (4.0 - 6f64.sqrt()) / 10.0, epsilon = 1e-14);
        assert_relative_eq!(radau.b[2], 1.0 / 9.0, epsilon = 1e-14);
    }

    #[test]
    fn quadrature_is_exact_up_to_the_order() {
        for stages in 1..=4 {
            for integrator in [Integrator::GaussLegendre { stages }, Integrator::RadauIIA { stages }] {
                let t = Tableau::new(integrator);
                assert_eq!(t.stages(), stages);
                let moment = |k: i32| t.b.iter().zip(&t.c).map(|(b, c)| b * c.powi(k)).sum::<f64>();
                for k in 0..integrator.order() as i32 {
                    assert_relative_eq!(moment(k), 1.0 / f64::from(k + 1), epsilon = 1e-13);
                }
                let k = integrator.order() as i32;
                assert!((moment(k) - 1.0 / f64::from(k + 1)).abs() > 1e-7, "no higher order");
            }
        }
    }
}
