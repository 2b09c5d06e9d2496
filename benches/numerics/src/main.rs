//! Dense linear algebra at the sizes in use: ours, nalgebra's, and faer's, on one core, all in one run:
//! `cargo run --release --manifest-path benches/numerics/Cargo.toml`.
//!
//! Every figure is the median of some runs, in microseconds. What is factorized is copied first, in all three.
#![allow(clippy::print_stdout)]

use bracketry_numerics::dense::Lu;
use bracketry_numerics::eigen;
use bracketry_numerics::rows::{Strided, add_product, eliminate};
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Par, Side};
use nalgebra::{DMatrix, SVD};
use std::hint::black_box;
use std::time::Instant;

/// Time of one run, µs: the median of at least nine runs, or of as many as take a tenth of a second.
fn time<T>(mut run: impl FnMut() -> T) -> f64 {
    let (mut times, start) = (Vec::new(), Instant::now());
    while times.len() < 9 || (start.elapsed().as_secs_f64() < 0.1 && times.len() < 10_000) {
        let begin = Instant::now();
        black_box(run());
        times.push(1e6 * begin.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Numbers in (−1, 1), the same in every run.
fn random(rows: usize, columns: usize) -> DMatrix<f64> {
    let mut state = 7u64;
    DMatrix::from_fn(rows, columns, |_, _| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

fn by_rows(a: &DMatrix<f64>) -> Vec<f64> {
    a.transpose().as_slice().to_vec()
}

fn faer_of(a: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(a.as_slice(), a.nrows(), a.ncols())
}

fn row(operation: &str, size: &str, place: &str, ours: Option<f64>, nalgebra: f64, faer: f64) {
    let ours = ours.map_or("–".to_owned(), |t| format!("{t:.2}"));
    println!("| {operation} | {size} | {place} | {ours} | {nalgebra:.2} | {faer:.2} |");
}

fn lu() {
    for (n, place) in [
        (4, "implicit equations"),
        (18, "collocation, 9 states, 2 stages"),
        (42, "collocation, 21 states"),
        (66, "collocation, 33 states"),
        (132, "collocation, 66 states"),
    ] {
        let a = random(n, n) + DMatrix::identity(n, n);
        let rows = by_rows(&a);
        let mut own = Lu::default();
        let ours = time(|| {
            own.matrix(n).copy_from_slice(&rows);
            own.factorize()
        });
        let nalgebra = time(|| a.clone().lu());
        let faer = time(|| faer_of(&a).partial_piv_lu());
        row("LU factors", &n.to_string(), place, Some(ours), nalgebra, faer);
        let columns = n / 2 + 3;
        let right = random(n, columns);
        let right_rows = by_rows(&right);
        let mut x = right_rows.clone();
        let ours = time(|| {
            x.copy_from_slice(&right_rows);
            own.solve(&mut x, columns);
        });
        let factors = a.clone().lu();
        let nalgebra = time(|| factors.solve(&right));
        let factors = faer_of(&a).partial_piv_lu();
        let faer = time(|| factors.solve(faer_of(&right)));
        row("solution with them", &format!("{n}, {columns} columns"), "sensitivities", Some(ours), nalgebra, faer);
    }
}

fn cholesky() {
    for (n, place) in [
        (4, "programs, block of the pendulum"),
        (15, "programs, block of the plate"),
        (48, "programs, block of 33 states"),
        (120, "programs, condensed whole"),
        (300, "sums of squares"),
        (600, "sums of squares"),
    ] {
        let b = random(n + 3, n);
        let a = b.transpose() * &b + DMatrix::identity(n, n);
        let rows = by_rows(&a);
        let mut work = rows.clone();
        let ours = time(|| {
            work.copy_from_slice(&rows);
            eliminate(&mut work, n, (n, n), 1e-14)
        });
        let nalgebra = time(|| a.clone().cholesky());
        let faer = time(|| faer_of(&a).llt(Side::Lower));
        row("Cholesky factor", &n.to_string(), place, Some(ours), nalgebra, faer);
    }
}

fn product() {
    for (n, columns, place) in [(4, 9, "pendulum"), (10, 21, "plate"), (33, 58, "33 states"), (100, 150, "–")] {
        let (a, b) = (random(n, n), random(n, columns));
        let (a_rows, b_rows) = (by_rows(&a), by_rows(&b));
        let mut c = vec![0.0; n * columns];
        let ours = time(|| {
            c.fill(0.0);
            add_product(&mut c, columns, Strided::new(&a_rows, n), (&b_rows, columns), (n, n), 0..columns);
        });
        let mut to = DMatrix::zeros(n, columns);
        let nalgebra = time(|| to.gemm(1.0, &a, &b, 0.0));
        let mut to = Mat::<f64>::zeros(n, columns);
        let faer = time(|| {
            let beta = faer::Accum::Replace;
            faer::linalg::matmul::matmul(to.as_mut(), beta, faer_of(&a), faer_of(&b), 1.0, Par::Seq);
        });
        row("product", &format!("{n} × {n} × {columns}"), place, Some(ours), nalgebra, faer);
    }
}

fn spectra() {
    for n in [5, 20, 42, 100] {
        let a = random(n, n);
        let symmetric = &a + a.transpose();
        let nalgebra = time(|| eigen::symmetric_eigen(symmetric.clone()));
        let faer = time(|| faer_of(&symmetric).self_adjoint_eigen(Side::Lower).is_ok());
        row("symmetric eigenvectors", &n.to_string(), "friction, identification", None, nalgebra, faer);
        let nalgebra = time(|| eigen::eigenvalues(&a));
        let faer = time(|| faer_of(&a).eigenvalues().is_ok());
        row("eigenvalues", &n.to_string(), "linear analysis", None, nalgebra, faer);
        let ours = time(|| eigen::svd(&a));
        let nalgebra = time(|| SVD::try_new(a.clone(), true, true, f64::EPSILON, 100 * n));
        let faer = time(|| faer_of(&a).svd().is_ok());
        row("singular values and vectors", &n.to_string(), "linear analysis, identification", Some(ours), nalgebra, faer);
    }
}

fn main() {
    println!("| operation | size | place | ours, µs | nalgebra | faer |");
    println!("|---|---|---|---|---|---|");
    lu();
    cholesky();
    product();
    spectra();
}
