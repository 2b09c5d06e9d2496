//! Lyapunov and Riccati equations in continuous time, from the complex Schur form with eigenvalues in a chosen order.

use dashu_ratio::RBig;
use nalgebra::{Complex, DMatrix, Schur};

type ComplexMatrix = DMatrix<Complex<f64>>;

/// Iterations of the QR algorithm for each row.
const ITERATIONS: usize = 100;

/// U and T with M = U T Uᴴ, U unitary and T upper triangular; `None` where the QR algorithm does not converge.
fn schur(m: &DMatrix<f64>) -> Option<(ComplexMatrix, ComplexMatrix)> {
    let shift = Complex::from(m.norm());
    let n = m.nrows();
    let complex = m.map(Complex::from);
    let residual = |u: &ComplexMatrix, t: &ComplexMatrix| (u * t * u.adjoint() - &complex).norm();
    // The deflation test compares with diagonal entries, which a shift keeps away from zero.
    [Complex::from(0.0), shift].into_iter().find_map(|shift| {
        let shifted = &complex + ComplexMatrix::identity(n, n) * shift;
        let (u, mut t) = Schur::try_new(shifted, f64::EPSILON, ITERATIONS * n)?.unpack();
        for j in 0..n {
            t[(j, j)] -= shift;
            for i in j + 1..n {
                t[(i, j)] = Complex::from(0.0);
            }
        }
        (residual(&u, &t) <= 1e-10 * (1.0 + m.norm())).then_some((u, t))
    })
}

/// Exchanges the eigenvalues at k and k + 1 by a rotation.
fn exchange(u: &mut ComplexMatrix, t: &mut ComplexMatrix, k: usize) {
    let (x, y) = (t[(k, k + 1)], t[(k + 1, k + 1)] - t[(k, k)]);
    let length = (x.norm_sqr() + y.norm_sqr()).sqrt();
    if length == 0.0 {
        return;
    }
    let (c, s) = (x / length, y / length);
    // Columns (c, s) and (−s̄, c̄).
    for m in [&mut *t, u] {
        for i in 0..m.nrows() {
            let (a, b) = (m[(i, k)], m[(i, k + 1)]);
            m[(i, k)] = a * c + b * s;
            m[(i, k + 1)] = b * c.conj() - a * s.conj();
        }
    }
    for j in 0..t.ncols() {
        let (a, b) = (t[(k, j)], t[(k + 1, j)]);
        t[(k, j)] = c.conj() * a + s.conj() * b;
        t[(k + 1, j)] = c * b - s * a;
    }
    t[(k + 1, k)] = Complex::from(0.0);
}

/// X with A X + X Aᵀ + Q = 0 for symmetric Q (Bartels and Stewart 1972), refined once; `None` where two eigenvalues of A
/// add up to zero.
pub fn lyapunov(a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = a.nrows();
    let (u, t) = schur(a)?;
    let solve = |q: &DMatrix<f64>| -> Option<DMatrix<f64>> {
        let c = u.adjoint() * q.map(Complex::from) * &u;
        let mut y = ComplexMatrix::zeros(n, n);
        for j in (0..n).rev() {
            for i in (0..n).rev() {
                // Row i of T y_j + Σ_k y_k conj(t_jk) = −c_j.
                let mut right = -c[(i, j)];
                for k in i + 1..n {
                    right -= t[(i, k)] * y[(k, j)];
                }
                for k in j + 1..n {
                    right -= y[(i, k)] * t[(j, k)].conj();
                }
                let pivot = t[(i, i)] + t[(j, j)].conj();
                if pivot.norm() <= f64::EPSILON * a.norm() {
                    return None;
                }
                y[(i, j)] = right / pivot;
            }
        }
        let x = (&u * y * u.adjoint()).map(|z| z.re);
        Some((&x + x.transpose()) * 0.5)
    };
    let x = solve(q)?;
    let residual = a * &x + &x * a.transpose() + q;
    let better = solve(&residual).map(|step| &x + step)?;
    better.iter().all(|v| v.is_finite()).then_some(better)
}

/// A solution of a Riccati equation.
#[derive(Clone, Debug, PartialEq)]
pub struct Riccati {
    /// X.
    pub x: DMatrix<f64>,
    /// R⁻¹ Bᵀ X.
    pub gain: DMatrix<f64>,
    /// Norm of the equation's left side, relative to that of its terms.
    pub residual: f64,
}

/// Largest relative residual of a solution.
const RESIDUAL: f64 = 1e-6;

/// Steps of Newton's method after the Schur form.
const NEWTON_STEPS: usize = 8;

/// The stabilizing X of Aᵀ X + X A − X B R⁻¹ Bᵀ X + Q = 0 with diagonal R, from the stable invariant subspace of the Hamiltonian matrix
/// (Laub 1979), refined by Newton's method (Kleinman 1968). `None` where there is none, or rounding hides it.
pub fn riccati(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Option<Riccati> {
    let n = a.nrows();
    let inverse = r.clone().cholesky()?.inverse();
    let g = b * &inverse * b.transpose();
    let mut h = DMatrix::zeros(2 * n, 2 * n);
    h.view_mut((0, 0), (n, n)).copy_from(a);
    h.view_mut((0, n), (n, n)).copy_from(&-&g);
    h.view_mut((n, 0), (n, n)).copy_from(&-q);
    h.view_mut((n, n), (n, n)).copy_from(&-a.transpose());
    let (mut u, mut t) = schur(&h)?;
    // Bubble the eigenvalues of the left half-plane to the top.
    let mut top = 0;
    for k in 0..2 * n {
        if t[(k, k)].re < 0.0 {
            for j in (top..k).rev() {
                exchange(&mut u, &mut t, j);
            }
            top += 1;
        }
    }
    if top != n {
        return None;
    }
    let (u1, u2) = (u.view((0, 0), (n, n)).into_owned(), u.view((n, 0), (n, n)).into_owned());
    let x = (u2 * u1.try_inverse()?).map(|z| z.re);
    let mut x = (&x + x.transpose()) * 0.5;
    let defect = |x: &DMatrix<f64>| {
        let sum = a.transpose() * x + x * a - x * &g * x + q;
        let size = 2.0 * (a.transpose() * x).norm() + (x * &g * x).norm() + q.norm();
        sum.norm() / size.max(f64::MIN_POSITIVE)
    };
    let mut residual = defect(&x);
    for _ in 0..NEWTON_STEPS {
        let gain = &inverse * b.transpose() * &x;
        let Some(next) = lyapunov(&(a - b * &gain).transpose(), &(q + gain.transpose() * r * &gain)) else { break };
        let better = defect(&next);
        if better.is_nan() || better >= residual {
            break;
        }
        (x, residual) = (next, better);
    }
    if n <= MAX_REFINED {
        for _ in 0..NEWTON_STEPS {
            let Some(left) = exact_left_side(a, b, q, r, &x) else { break };
            let closed = a - b * (&inverse * b.transpose() * &x);
            let Some(step) = lyapunov(&closed.transpose(), &left) else { break };
            if step.norm().is_nan() || step.norm() > 1e-3 * x.norm() {
                break;
            }
            x += &step;
            if step.norm() <= 2.0 * f64::EPSILON * x.norm() {
                break;
            }
        }
        residual = residual.min(defect(&x));
    }
    let gain = &inverse * b.transpose() * &x;
    let loop_is_stable = crate::eigen::eigenvalues(&(a - b * &gain))?.iter().all(|z| z.0 < 0.0);
    (loop_is_stable && residual <= RESIDUAL).then_some(Riccati { x, gain, residual })
}

/// Systems with more states are not refined with exact left sides.
const MAX_REFINED: usize = 20;

/// Aᵀ X + X A − X B R⁻¹ Bᵀ X + Q for a diagonal R, in rational arithmetic, then rounded: where X is large, its terms cancel.
fn exact_left_side(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    x: &DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let exact = |m: &DMatrix<f64>| -> Option<Vec<Vec<RBig>>> {
        m.row_iter().map(|row| row.iter().map(|v| RBig::try_from(*v).ok()).collect()).collect()
    };
    let (a, b, q, r, x) = (exact(a)?, exact(b)?, exact(q)?, exact(r)?, exact(x)?);
    let (n, m) = (a.len(), r.len());
    let sum = |terms: &mut dyn Iterator<Item = RBig>| terms.fold(RBig::ZERO, |s, t| s + t);
    let rows = |rows: usize, entry: &dyn Fn(usize, usize) -> RBig| -> Vec<Vec<RBig>> {
        (0..rows).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    };
    let xa = rows(n, &|i, j| sum(&mut (0..n).map(|k| &x[i][k] * &a[k][j])));
    let bx = rows(m, &|i, j| sum(&mut (0..n).map(|k| &b[k][i] * &x[k][j])));
    let left = DMatrix::from_fn(n, n, |i, j| {
        let quadratic = sum(&mut (0..m).map(|k| &bx[k][i] * &bx[k][j] / &r[k][k]));
        let total = &xa[i][j] + &xa[j][i] - quadratic + &q[i][j];
        total.to_f64().value()
    });
    Some(left)
}
