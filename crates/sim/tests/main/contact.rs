//! Steps of dry contact: mechanics that is known, and certificates. Clarabel as an independent solver is asked where it is compiled, in
//! `crates/mpc/tests/main/contact_reference.rs`.

use bracketry_sim::{ContactError, ContactStep, FrictionPoints, FrictionSolver, Slip};

const INERTIA: f64 = 0.0072;
const MASS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, INERTIA]];

/// Deterministic numbers in (−1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Rows of a point of a flat body at `(x, y)` from its center of mass.
fn rows(x: f64, y: f64) -> [[f64; 3]; 2] {
    [[1.0, 0.0, -y], [0.0, 1.0, x]]
}

fn flat(points: &[([f64; 2], f64)]) -> FrictionPoints<3> {
    let mut all = FrictionPoints::new();
    for ([x, y], bound) in points {
        all.push(rows(*x, *y), *bound);
    }
    all
}

fn step(points: &FrictionPoints<3>, free: [f64; 3]) -> ContactStep<3> {
    FrictionSolver::new().step(&MASS, &free, points, &[0.0; 3]).unwrap()
}

/// The impulses are admissible, balance the change of momentum and do the most work: the definition of the solution.
fn assert_optimal<const N: usize>(
    mass: &[[f64; N]; N],
    free: &[f64; N],
    points: &FrictionPoints<N>,
    solver: &FrictionSolver<N>,
    step: &ContactStep<N>,
) {
    let size: f64 = free.iter().map(|v| v.abs()).sum();
    for i in 0..N {
        let mut balance: f64 = (0..N).map(|j| mass[i][j] * (step.velocity[j] - free[j])).sum();
        assert!((step.impulse[i] - balance).abs() <= 1e-11 * size);
        for (index, multiplier) in solver.multipliers().iter().enumerate() {
            let rows = points.rows(index);
            balance += rows[0][i] * multiplier[0] + rows[1][i] * multiplier[1];
        }
        assert!(balance.abs() <= 1e-11 * size, "balance {balance} in {i}, {step:?}");
    }
    for (index, multiplier) in solver.multipliers().iter().enumerate() {
        let (bound, slip) = (points.bound(index), points.slip(index, &step.velocity));
        assert!(multiplier[0].hypot(multiplier[1]) <= bound * (1.0 + 1e-12));
        let lost = bound * slip[0].hypot(slip[1]) - multiplier[0] * slip[0] - multiplier[1] * slip[1];
        assert!(lost <= 1e-11 * size * size, "{lost} of {bound} at {slip:?}, {step:?}");
    }
    assert!(step.gap <= 1e-20 * size * size + 1e-11 * size * step.residual, "{step:?}");
}

fn random_points(random: &mut Random, count: usize, strength: f64) -> FrictionPoints<3> {
    let mut points = FrictionPoints::new();
    for _ in 0..count {
        points.push(rows(0.12 * random.next(), 0.12 * random.next()), strength / count as f64 * (1.0 + random.next()));
    }
    points
}

#[test]
fn random_steps_certify_themselves() {
    let mut random = Random(7);
    let mut kinds = [0; 3];
    for case in 0..150 {
        let count = [1, 2, 3, 5, 8, 13][case % 6];
        let strength = [0.01, 0.3, 1.0, 3.0][case % 4];
        let points = random_points(&mut random, count, strength);
        let free = [random.next(), random.next(), 10.0 * random.next()];
        let mut solver = FrictionSolver::new();
        let step = solver.step(&MASS, &free, &points, &[0.0; 3]).unwrap();
        assert_optimal(&MASS, &free, &points, &solver, &step);
        match step.slip {
            Slip::Held => kinds[0] += 1,
            Slip::Pivoting { .. } => kinds[1] += 1,
            Slip::Sliding => kinds[2] += 1,
        }
    }
    assert!(kinds.iter().all(|&k| k > 5), "{kinds:?}");
}

#[test]
fn bodies_of_other_dimensions_and_full_mass_matrices_are_solved_too() {
    let mut random = Random(11);
    for case in 0..60 {
        let mut root = [[0.0; 6]; 6];
        root.iter_mut().flatten().for_each(|entry| *entry = random.next());
        let mass: [[f64; 6]; 6] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..6).map(|k| root[i][k] * root[j][k]).sum::<f64>() + f64::from(u8::from(i == j)))
        });
        let mut points = FrictionPoints::new();
        for _ in 0..=case % 5 {
            let rows = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
            points.push(rows, [0.1, 0.5, 2.0][case % 3]);
        }
        let free = std::array::from_fn(|_| random.next());
        let mut solver = FrictionSolver::new();
        let step = solver.step(&mass, &free, &points, &[0.0; 6]).unwrap();
        assert_optimal(&mass, &free, &points, &solver, &step);
    }
}

#[test]
fn a_guess_changes_the_work_but_not_the_result() {
    let mut random = Random(3);
    for _ in 0..100 {
        let points = random_points(&mut random, 48, 0.3);
        let free = [random.next(), random.next(), 10.0 * random.next()];
        let mut solver = FrictionSolver::new();
        let cold = solver.step(&MASS, &free, &points, &[0.0; 3]).unwrap();
        for guess in [cold.velocity, [random.next(), 0.0, 1e6], [f64::NAN, f64::INFINITY, 0.0]] {
            let warm = solver.step(&MASS, &free, &points, &guess).unwrap();
            assert_optimal(&MASS, &free, &points, &solver, &warm);
            for (a, b) in cold.velocity.iter().zip(warm.velocity) {
                assert!((a - b).abs() < 1e-11);
            }
        }
    }
}

#[test]
fn friction_holds_up_to_its_bound_exactly() {
    // A block on four points at its corners: held below the sum of the bounds, sliding by the excess above.
    let corners = [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]].map(|p| (p, 0.25));
    let points = flat(&corners);
    for share in [0.0, 0.3, 0.999_999_999] {
        let held = step(&points, [0.6 * share, -0.8 * share, 0.0]);
        assert_eq!((held.velocity, held.slip), ([0.0; 3], Slip::Held));
    }
    for excess in [1e-9, 1e-6, 0.1, 10.0] {
        let sliding = step(&points, [0.6 * (1.0 + excess), -0.8 * (1.0 + excess), 0.0]);
        assert_eq!(sliding.slip, Slip::Sliding);
        assert!((sliding.velocity[0] - 0.6 * excess).abs() < 1e-14 * (1.0 + excess));
        assert!((sliding.velocity[1] + 0.8 * excess).abs() < 1e-14 * (1.0 + excess));
    }
    // The torque that four corners hold: Σ b r.
    let most = 4.0 * 0.25 * 0.1 * 2f64.sqrt() / INERTIA;
    assert_eq!(step(&points, [0.0, 0.0, most * (1.0 - 1e-9)]).slip, Slip::Held);
    assert!((step(&points, [0.0, 0.0, most + 1e-3]).velocity[2] - 1e-3).abs() < 1e-12);
}

#[test]
fn a_body_pushed_aside_of_its_only_support_pivots_about_it() {
    let points = flat(&[([0.1, 0.0], 10.0)]);
    let pivoting = step(&points, [0.0, 1.0, 0.0]);
    assert_eq!(pivoting.slip, Slip::Pivoting { points: 1 });
    // About the support: (I + r²) w = −r v*, and the support stays where it is, to rounding.
    let w = -0.1 / (INERTIA + 0.01);
    assert!((pivoting.velocity[2] - w).abs() < 1e-13);
    assert!((pivoting.velocity[1] + 0.1 * pivoting.velocity[2]).abs() < 1e-16);
    // The same with the support made of several points at one place.
    let many = flat(&[([0.1, 0.0], 4.0), ([0.1, 0.0], 3.0), ([0.1, 0.0], 3.0)]);
    let other = step(&many, [0.0, 1.0, 0.0]);
    assert_eq!(other.slip, Slip::Pivoting { points: 3 });
    assert!((other.velocity[2] - w).abs() < 1e-13);
}

#[test]
fn an_elliptic_limit_surface_is_a_scaling_of_the_rows() {
    // Friction 0.2 along x and 0.4 along y: the impulse lies on the ellipse.
    let mut points = FrictionPoints::new();
    points.push([[0.2, 0.0], [0.0, 0.4]], 1.0);
    let mass = [[1.0, 0.0], [0.0, 1.0]];
    let sliding = FrictionSolver::new().step(&mass, &[0.5, 0.5], &points, &[0.5; 2]).unwrap();
    let [px, py] = sliding.impulse;
    assert!(((px / 0.2).powi(2) + (py / 0.4).powi(2) - 1.0).abs() < 1e-13);
    assert!(sliding.velocity[1] < sliding.velocity[0]);
    let held = FrictionSolver::new().step(&mass, &[0.1, 0.3], &points, &[0.0; 2]).unwrap();
    assert_eq!(held.slip, Slip::Held);
}

#[test]
fn nothing_to_solve_is_solved() {
    let free = [0.3, -0.2, 1.0];
    for points in [flat(&[]), flat(&[([0.1, 0.2], 0.0), ([0.0, 0.0], 0.0)])] {
        assert_eq!(step(&points, free).velocity, free);
    }
    let points = flat(&[([0.1, 0.2], 0.5)]);
    assert_eq!(step(&points, [0.0; 3]).slip, Slip::Held);
    // A motion that no point feels goes on.
    let center = flat(&[([0.0, 0.0], 1.0)]);
    let spinning = step(&center, [0.0, 0.0, 5.0]);
    assert_eq!(spinning.velocity, [0.0, 0.0, 5.0]);
}

#[test]
fn units_do_not_matter() {
    let mut random = Random(5);
    let points = random_points(&mut random, 12, 0.4);
    for free in [[0.3, 0.2, -4.0], [0.1, 0.0, 0.1], [0.0, 0.0, 9.0]] {
        let one = step(&points, free);
        for size in [1e-200, 1e-20, 1e20, 1e200] {
            let mut scaled = points.clone();
            for i in 0..points.len() {
                scaled.set_bound(i, points.bound(i) * size);
            }
            let other = step(&scaled, free.map(|v| v * size));
            assert_eq!(other.slip, one.slip);
            for (a, b) in one.velocity.iter().zip(other.velocity) {
                assert!((a - b / size).abs() < 1e-12);
            }
        }
    }
    // Bounds that nothing overcomes.
    let strong = flat(&[([0.1, 0.0], 1e300), ([0.0, 0.1], 1e-300), ([-0.1, 0.0], 1e300)]);
    assert_eq!(step(&strong, [1e-9, 1e9, 1.0]).slip, Slip::Held);
}

#[test]
fn steps_without_meaning_are_refused() {
    let points = flat(&[([0.1, 0.0], 1.0), ([0.0, 0.0], -1.0)]);
    let mut solver = FrictionSolver::new();
    let refused = solver.step(&MASS, &[0.0; 3], &points, &[0.0; 3]);
    assert_eq!(refused.unwrap_err(), ContactError::Point { index: 1, bound: -1.0 });
    let fine = flat(&[([0.1, 0.0], 1.0)]);
    let refused = solver.step(&MASS, &[f64::INFINITY, 0.0, 0.0], &fine, &[0.0; 3]);
    assert_eq!(refused.unwrap_err(), ContactError::Velocity { value: f64::INFINITY });
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut mass = MASS;
        mass[1][1] = bad;
        assert_eq!(solver.step(&mass, &[1.0; 3], &fine, &[0.0; 3]).unwrap_err(), ContactError::Mass);
    }
    let singular = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(solver.step(&singular, &[1.0; 3], &fine, &[0.0; 3]).unwrap_err(), ContactError::Mass);
}
