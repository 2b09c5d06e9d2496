//! Steps of dry contact beside Clarabel, an independent solver.

use bracketry_sim::{FrictionPoints, FrictionSolver};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};

/// Numbers in (−1, 1), the same for ever: where the optimum is flat, Clarabel's velocities agree to fewer digits.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A body on random points: mass matrix, velocity without friction, points.
struct Case<const N: usize> {
    mass: [[f64; N]; N],
    free: [f64; N],
    points: FrictionPoints<N>,
}

/// `min ½ (v − v*)ᵀ M (v − v*) + Σ cᵢ |Jᵢ v|`.
fn objective<const N: usize>(Case { mass, free, points }: &Case<N>, v: &[f64; N]) -> f64 {
    let mut value = points.dissipation(v);
    for i in 0..N {
        for j in 0..N {
            value += 0.5 * (v[i] - free[i]) * mass[i][j] * (v[j] - free[j]);
        }
    }
    value
}

/// The same step as a second-order cone program: `min ½ vᵀMv − (Mv*)ᵀv + cᵀs`, `|J_i v| ≤ s_i`.
fn clarabel_step<const N: usize>(Case { mass, free, points }: &Case<N>) -> [f64; N] {
    let m = points.len();
    let mut p = vec![vec![0.0; N + m]; N + m];
    let mut q = vec![0.0; N + m];
    for i in 0..N {
        for j in 0..N {
            if i <= j {
                p[i][j] = mass[i][j];
            }
            q[i] -= mass[i][j] * free[j];
        }
    }
    let mut a = vec![vec![0.0; N + m]; 3 * m];
    for i in 0..m {
        q[N + i] = points.bound(i);
        a[3 * i][N + i] = -1.0;
        for (k, row) in points.rows(i).iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                a[3 * i + 1 + k][j] = -entry;
            }
        }
    }
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let cones = vec![SupportedConeT::SecondOrderConeT(3); m];
    let (p, a) = (CscMatrix::from(&p), CscMatrix::from(&a));
    let mut solver = DefaultSolver::new(&p, &q, &a, &vec![0.0; 3 * m], &cones, settings).unwrap();
    solver.solve();
    std::array::from_fn(|i| solver.solution.x[i])
}

fn assert_agrees<const N: usize>(case: &Case<N>) {
    let step = FrictionSolver::new().step(&case.mass, &case.free, &case.points, &[0.0; N]).unwrap();
    let other = clarabel_step(case);
    for (a, b) in step.velocity.iter().zip(other) {
        assert!((a - b).abs() < 1e-5, "{step:?}, Clarabel {other:?}");
    }
    let difference = objective(case, &step.velocity) - objective(case, &other);
    assert!(difference < 1e-12, "{difference}");
}

#[test]
fn steps_of_a_flat_body_on_random_points_agree_with_clarabel() {
    let mut random = Random(7);
    for case in 0..150 {
        let count = [1, 2, 3, 5, 8, 13][case % 6];
        let strength = [0.01, 0.3, 1.0, 3.0][case % 4];
        let mut points = FrictionPoints::new();
        for _ in 0..count {
            let [x, y] = [(); 2].map(|()| 0.12 * random.next());
            points.push([[1.0, 0.0, -y], [0.0, 1.0, x]], strength / f64::from(count) * (1.0 + random.next()));
        }
        let free = [1.0, 1.0, 10.0].map(|size| size * random.next());
        assert_agrees(&Case { mass: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0072]], free, points });
    }
}

#[test]
fn steps_with_full_mass_matrices_agree_with_clarabel() {
    let mut random = Random(11);
    for case in 0..60 {
        let root: [[f64; 6]; 6] = [(); 6].map(|()| [(); 6].map(|()| random.next()));
        let entry =
            |i: usize, j: usize| (0..6).map(|k| root[i][k] * root[j][k]).sum::<f64>() + f64::from(u8::from(i == j));
        let mass = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
        let mut points = FrictionPoints::new();
        for _ in 0..=case % 5 {
            points.push([(); 2].map(|()| [(); 6].map(|()| random.next())), [0.1, 0.5, 2.0][case % 3]);
        }
        assert_agrees(&Case { mass, free: [(); 6].map(|()| random.next()), points });
    }
}
