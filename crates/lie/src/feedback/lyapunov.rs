//! Lyapunov functions and center manifolds of polynomial systems at an equilibrium that the linearization does not decide.

use bracketry_symbolic::{FieldElement, OrderedField, Real, UnivariatePolynomial};

use crate::linear::matrix::{Matrix, semidefinite};
use crate::linear::polynomial::RealPolynomial;

/// x' = F(x) with an equilibrium at the origin.
pub(crate) struct PolynomialField<'a>(pub(crate) &'a [RealPolynomial]);

/// What a function of the state shows of the equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shown {
    /// V is positive definite and does not rise, and V' = 0 holds along no other motion: asymptotically stable
    /// (Barbashin–Krasovskii, LaSalle).
    Attracts(RealPolynomial),
    /// V is positive definite and constant along all motions: stable, not asymptotically.
    Conserved(RealPolynomial),
    /// The same as the first with time reversed: unstable.
    Repels(RealPolynomial),
}

/// Most combinations of functions that are tried.
const MAX_FREE: usize = 5;
/// Most variables.
const MAX_VARIABLES: usize = 8;

impl PolynomialField<'_> {
    /// Tries V among quadratic forms, then with fourth powers of the variables as well, whose derivative has no terms but even
    /// powers, either at all or up to degree 4.
    pub(crate) fn shown(&self) -> Option<Shown> {
        let n = self.0.len();
        if n > MAX_VARIABLES {
            return None;
        }
        let mut functions = Vec::new();
        for i in 0..n {
            for j in i..n {
                functions.push(monomial(n, &[i, j]));
            }
        }
        for quartic in [false, true] {
            if quartic {
                functions.extend((0..n).map(|i| monomial(n, &[i, i, i, i])));
            }
            let rates: Vec<RealPolynomial> = functions.iter().map(|v| self.rate(v)).collect::<Option<_>>()?;
            for degree in [u32::MAX, 4] {
                let found = self.among(&functions, &rates, degree);
                if found.is_some() {
                    return found;
                }
            }
        }
        None
    }

    /// V' = ∇V · F.
    fn rate(&self, v: &RealPolynomial) -> Option<RealPolynomial> {
        self.0
            .iter()
            .enumerate()
            .try_fold(RealPolynomial::default(), |sum, (i, f)| Some(sum.plus(&v.derivative(i).times(f)?, &Real::ONE)))
    }

    /// Combinations of functions of whose rate all terms up to this degree are even powers.
    fn among(&self, functions: &[RealPolynomial], rates: &[RealPolynomial], degree: u32) -> Option<Shown> {
        let mut odd: Vec<Vec<u32>> = Vec::new();
        for (m, _) in rates.iter().flat_map(RealPolynomial::terms) {
            if !even(m) && m.iter().sum::<u32>() <= degree && !odd.contains(m) {
                odd.push(m.clone());
            }
        }
        let rows = odd.iter().map(|m| rates.iter().map(|r| r.coefficient(m)).collect()).collect();
        let free = Matrix::new(rows, functions.len()).null_space();
        if free.is_empty() || free.len() > MAX_FREE {
            return None;
        }
        let combined = |list: &[RealPolynomial], c: &[Real]| {
            list.iter().zip(c).fold(RealPolynomial::default(), |sum, (p, c)| sum.plus(p, c))
        };
        let mut conserved = None;
        for code in 1..3usize.pow(free.len() as u32) {
            // Digits 0, 1, 2 for the factors 0, 1, −1.
            let mut c = vec![Real::ZERO; functions.len()];
            for (k, vector) in free.iter().enumerate() {
                let factor = [0, 1, -1][code / 3usize.pow(k as u32) % 3];
                for (sum, x) in c.iter_mut().zip(vector) {
                    *sum += Real::from(factor) * x;
                }
            }
            let v = combined(functions, &c);
            if !positive_definite(&v, self.0.len()) {
                continue;
            }
            let rate = combined(rates, &c);
            if rate.is_zero() {
                conserved.get_or_insert(Shown::Conserved(v));
                continue;
            }
            let opposite = rate.negative();
            if self.falls_to_rest(&rate) {
                return Some(Shown::Attracts(v));
            }
            if self.falls_to_rest(&opposite) {
                return Some(Shown::Repels(v));
            }
        }
        conserved
    }

    /// Whether a rate is nowhere positive near the origin and vanishes along no motion but rest: its terms are even powers
    /// with negative factors, and multiples of these by functions that vanish at the origin; the variables that are zero where
    /// these powers are stay zero only where all are.
    fn falls_to_rest(&self, rate: &RealPolynomial) -> bool {
        let falling: Vec<&Vec<u32>> =
            rate.terms().filter(|(m, c)| even(m) && c.is_negative()).map(|(m, _)| m).collect();
        let dominated = |m: &Vec<u32>| falling.iter().any(|f| *f == m || f.iter().zip(m).all(|(a, b)| a <= b));
        if !rate.terms().all(|(m, _)| dominated(m)) {
            return false;
        }
        let n = self.0.len();
        let alone = |m: &[u32]| {
            let mut used = (0..n).filter(|&i| m[i] > 0);
            used.next().filter(|_| used.next().is_none())
        };
        let mut zero: Vec<usize> = falling.iter().filter_map(|m| alone(m)).collect();
        for _ in 0..n {
            let mut more = Vec::new();
            for &i in &zero {
                let f = self.0[i].without(&zero);
                // F_i = z_j^k (c + …) vanishes near the origin only where z_j does.
                let factor = (0..n).find(|&j| {
                    let least = f.terms().map(|(m, _)| m[j]).min().unwrap_or(0);
                    least > 0 && f.terms().any(|(m, _)| m[j] == least && alone(m) == Some(j))
                });
                more.extend(factor);
            }
            zero.extend(more);
            zero.sort_unstable();
            zero.dedup();
        }
        zero.len() == n
    }

    /// The first power s^k, k ≤ `order`, of the motion s' = c s^k + … on the center manifold, with c, where the linearization
    /// has the simple eigenvalue 0 and the others in the left half-plane (Carr 1981, thm. 2): asymptotically stable for odd k and
    /// c < 0, unstable otherwise. The components need to be exact up to that order.
    pub(crate) fn on_center_manifold(&self, order: usize) -> Option<(usize, Real)> {
        let n = self.0.len();
        let entry = |i: usize, j: usize| self.0[i].coefficient(&exponents(n, &[j]));
        let a: Vec<Vec<Real>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        let matrix = Matrix::new(a.clone(), n);
        let ([v], [w]) = (&matrix.null_space()[..], &matrix.transposed().null_space()[..]) else { return None };
        let dot = |x: &[Real]| w.iter().zip(x).fold(Real::ZERO, |s, (a, b)| s + a * b);
        let scale = dot(v);
        if scale == Real::ZERO {
            return None;
        }
        // x = v s + h_2 s² + …, of which the coefficients follow one after the other.
        let mut path: Vec<Vec<Real>> = v.iter().map(|x| vec![Real::ZERO, x.clone()]).collect();
        for k in 2..=order {
            let series: Vec<UnivariatePolynomial<Real>> = path.iter().cloned().map(UnivariatePolynomial::new).collect();
            let n_k: Vec<Real> = self.0.iter().map(|f| power_of(f, &series, k)).collect();
            let c = dot(&n_k) / &scale;
            if c != Real::ZERO {
                return Some((k, c));
            }
            // A h = −N with w h = 0.
            let mut rows: Vec<Vec<Real>> =
                a.iter().zip(&n_k).map(|(row, x)| row.iter().chain([x]).cloned().collect()).collect();
            rows.push(w.iter().cloned().chain([Real::ZERO]).collect());
            let solutions = Matrix::new(rows, n + 1).null_space();
            let h = solutions.iter().find(|h| h[n] != Real::ZERO)?;
            for (list, x) in path.iter_mut().zip(h) {
                list.push(x / &h[n]);
            }
        }
        None
    }
}

/// The coefficient of s^k of a polynomial at power series in s.
fn power_of(f: &RealPolynomial, series: &[UnivariatePolynomial<Real>], k: usize) -> Real {
    let cut = |p: UnivariatePolynomial<Real>| {
        UnivariatePolynomial::new(p.coefficients().iter().take(k + 1).cloned().collect())
    };
    let mut sum = Real::ZERO;
    for (m, c) in f.terms().filter(|(m, _)| m.iter().sum::<u32>() as usize <= k) {
        let mut product = UnivariatePolynomial::new(vec![c.clone()]);
        for (&e, x) in m.iter().zip(series) {
            for _ in 0..e {
                product = cut(product.mul(x));
            }
        }
        sum += product.coefficients().get(k).cloned().unwrap_or(Real::ZERO);
    }
    sum
}

fn even(m: &[u32]) -> bool {
    m.iter().all(|k| k % 2 == 0)
}

fn exponents(n: usize, factors: &[usize]) -> Vec<u32> {
    let mut m = vec![0; n];
    for &i in factors {
        m[i] += 1;
    }
    m
}

fn monomial(n: usize, factors: &[usize]) -> RealPolynomial {
    RealPolynomial::term(Real::ONE, exponents(n, factors))
}

/// Whether Q + Σ b_i z_i⁴ with a quadratic form Q is positive definite near the origin: Q is in the variables that it
/// contains, and the others have b_i > 0.
fn positive_definite(v: &RealPolynomial, n: usize) -> bool {
    let half = Real::ONE / Real::from(2);
    let entry = |i: usize, j: usize| {
        let c = v.coefficient(&exponents(n, &[i, j]));
        if i == j { c } else { c * &half }
    };
    let inside: Vec<usize> = (0..n).filter(|&i| (0..n).any(|j| entry(i, j) != Real::ZERO)).collect();
    let others = (0..n).filter(|i| !inside.contains(i));
    let q: Vec<Vec<Real>> = inside.iter().map(|&i| inside.iter().map(|&j| entry(i, j)).collect()).collect();
    let regular = Matrix::new(q.clone(), inside.len()).null_space().is_empty();
    regular
        && semidefinite(q) == Some(true)
        && others.into_iter().all(|i| v.coefficient(&exponents(n, &[i, i, i, i])).is_positive())
}
