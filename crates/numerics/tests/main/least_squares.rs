//! Problems of least squares whose minima are known by construction.

use bracketry_numerics::least_squares::{
    Damping, Factored, Minimum, Problem, Settings, Status, Trial, central_differences, minimize,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A matrix of full rank almost surely.
fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0f64, rows * columns).prop_map(move |v| DMatrix::from_vec(rows, columns, v))
}

fn vector(length: usize) -> impl Strategy<Value = DVector<f64>> {
    matrix(length, 1).prop_map(|m| m.column(0).into_owned())
}

/// J x = b with the exact derivative, within limits.
struct Linear {
    j: DMatrix<f64>,
    b: DVector<f64>,
    limits: Vec<[f64; 2]>,
}

impl Problem for Linear {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        Some(&self.j * at - &self.b)
    }

    fn jacobian(&mut self, _: &DVector<f64>, _: &DVector<f64>) -> Option<DMatrix<f64>> {
        Some(self.j.clone())
    }

    fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }
}

/// Newton's method first.
fn undamped(rank: f64) -> Settings {
    Settings { damping: Damping { undamped: 1e-3, trials: 30, ..Damping::default() }, rank, ..Settings::default() }
}

fn rosenbrock() -> impl Problem {
    |z: &DVector<f64>| Some(DVector::from_vec(vec![10.0 * (z[1] - z[0] * z[0]), 1.0 - z[0]]))
}

fn found(problem: &mut impl Problem, start: &[f64], settings: &Settings) -> Minimum {
    minimize(problem, &DVector::from_column_slice(start), settings).unwrap()
}

proptest! {
    /// The gradient of ‖J x − b‖² + μ ‖x‖² vanishes.
    #[test]
    fn a_damped_solution_is_stationary(j in matrix(5, 3), b in vector(5), wide in any::<bool>(), damping in 1e-6..10.0f64) {
        let (j, b) = if wide { (j.transpose(), b.rows(0, 3).into_owned()) } else { (j, b) };
        let x = Factored::new(&j, 0.0).unwrap().solve(&b, damping);
        let gradient = j.tr_mul(&(&j * &x - &b)) + damping * &x;
        prop_assert!(gradient.amax() <= 1e-12 * (1.0 + x.amax()), "{gradient}");
    }

    /// The product of two random factors has their rank: the solution is stationary and lies in the range of Jᵀ, so that it is the
    /// shortest, and what is added in the null space changes nothing.
    #[test]
    fn without_damping_it_is_the_shortest(left in matrix(5, 2), right in matrix(2, 4), b in vector(5), other in vector(4)) {
        let j = &left * &right;
        let factored = Factored::new(&j, 1e-9).unwrap();
        prop_assume!(Factored::new(&j, 1e-3).unwrap().rank() == 2);
        prop_assert_eq!(factored.rank(), 2);
        let x = factored.solve(&b, 0.0);
        let size = factored.largest();
        prop_assert!(j.tr_mul(&(&j * &x - &b)).amax() <= 1e-10 * size.max(1.0));
        prop_assert!(factored.onto_null_space(x.clone()).amax() <= 1e-10 * (1.0 + x.amax()));
        let free = factored.onto_null_space(other.clone());
        prop_assert!((&j * &free).amax() <= 1e-12 && (factored.onto_null_space(free.clone()) - &free).amax() <= 1e-12);
        prop_assert!((&other - &free).dot(&free).abs() <= 1e-12);
    }

    /// Newton's step is the minimum.
    #[test]
    fn a_linear_problem_takes_one_step(j in matrix(6, 3), b in vector(6), start in vector(3)) {
        prop_assume!(Factored::new(&j, 1e-2).unwrap().rank() == 3);
        let mut problem = Linear { j, b, limits: Vec::new() };
        let one = minimize(&mut problem, &start, &Settings { iterations: 1, ..undamped(0.0) }).unwrap();
        prop_assert!(problem.j.tr_mul(&one.residual).amax() <= 1e-11);
        let end = minimize(&mut problem, &start, &undamped(0.0)).unwrap();
        prop_assert!(end.status != Status::IterationLimit && (end.at - one.at).amax() <= 1e-11);
    }

    /// With columns scaled, units of the variables change nothing but the units of the result.
    #[test]
    fn scaled_steps_do_not_depend_on_units(j in matrix(6, 3), b in vector(6), units in prop::collection::vec(-2..3i32, 3)) {
        let units = DVector::from_iterator(3, units.iter().map(|k| 2f64.powi(*k)));
        let settings = Settings { iterations: 1, scaled: true, ..Settings::default() };
        let start = DVector::zeros(3);
        let mut problem = Linear { j: j.clone(), b: b.clone(), limits: Vec::new() };
        let plain = minimize(&mut problem, &start, &settings).unwrap();
        let mut problem = Linear { j: j * DMatrix::from_diagonal(&units), b, limits: Vec::new() };
        let other = minimize(&mut problem, &start, &settings).unwrap();
        prop_assert!((other.at.component_mul(&units) - plain.at).amax() <= 1e-11);
    }

    /// Solutions of u(x) = u(s) for an increasing u of each combination of variables.
    #[test]
    fn a_nonlinear_solution_is_found(j in matrix(3, 3), solution in vector(3), scaled in any::<bool>()) {
        let j = j + DMatrix::identity(3, 3) * 4.0;
        let value = |z: &DVector<f64>| (&j * z).map(|v| v + 0.1 * v.powi(3));
        let target = value(&solution);
        let mut problem = |z: &DVector<f64>| Some(value(z) - &target);
        let end = found(&mut problem, &[0.0; 3], &Settings { scaled, ..Settings::default() });
        prop_assert!((end.at - solution).amax() <= 1e-9);
    }

    /// The distance to a point, from inside a box: the nearest point of the box. Variables do not depend on each other.
    #[test]
    fn variables_stop_at_their_limits(target in vector(3), start in vector(3)) {
        let limits = vec![[-0.3, 0.4]; 3];
        let nearest = target.map(|v| v.clamp(-0.3, 0.4));
        let mut problem = Linear { j: DMatrix::identity(3, 3), b: target, limits };
        let end = minimize(&mut problem, &start, &undamped(1e-9)).unwrap();
        prop_assert!((end.at - nearest).amax() <= 1e-12);
    }

    /// The conditions of Karush, Kuhn and Tucker hold with one variable held that others depend on.
    #[test]
    fn the_others_move_on_where_one_is_held(b in vector(2), coupling in -0.8..0.8f64) {
        let j = DMatrix::from_row_slice(2, 2, &[1.0, coupling, coupling, 1.0]);
        let mut problem = Linear { j, b, limits: vec![[-0.1, 0.1], [-9.0, 9.0]] };
        let end = minimize(&mut problem, &DVector::zeros(2), &undamped(1e-9)).unwrap();
        let slope = problem.j.tr_mul(&end.residual);
        prop_assert!(slope[1].abs() <= 1e-6, "{slope}");
        prop_assert!(slope[0].abs() <= 1e-6 || (slope[0] < 0.0) == (end.at[0] == 0.1) && end.at[0].abs() == 0.1);
    }
}

#[test]
fn the_valley_of_rosenbrock_ends_at_one() {
    for scaled in [false, true] {
        for start in [[-1.2, 1.0], [3.0, -7.0], [0.0, 0.0]] {
            let end = found(&mut rosenbrock(), &start, &Settings { scaled, ..Settings::default() });
            assert!((end.at - DVector::from_element(2, 1.0)).amax() < 1e-9, "{start:?}");
            assert_ne!(end.status, Status::IterationLimit);
        }
    }
}

/// Steps into x ≤ 0, where the logarithm has no value, are too long.
#[test]
fn residuals_without_a_value_shorten_a_step() {
    let mut logarithm = |z: &DVector<f64>| (z[0] > 0.0).then(|| DVector::from_element(1, z[0].ln() + 2.0));
    let end = found(&mut logarithm, &[5.0], &undamped(0.0));
    assert!((end.at[0] - (-2.0f64).exp()).abs() < 1e-10, "{end:?}");
    assert_eq!(minimize(&mut logarithm, &DVector::from_element(1, -1.0), &undamped(0.0)), None);
}

#[test]
fn what_is_not_a_number_ends_it() {
    let mut nowhere = |z: &DVector<f64>| Some(z.map(|_| f64::NAN));
    assert_eq!(minimize(&mut nowhere, &DVector::zeros(2), &Settings::default()), None);
    // Finite at the start alone.
    let mut point = |z: &DVector<f64>| Some(z.map(|v| if v == 0.0 { 1.0 } else { f64::NAN }));
    assert_eq!(found(&mut point, &[0.0], &Settings::default()).status, Status::NoDerivative);
    let mut steep = Linear { j: DMatrix::from_element(1, 1, f64::INFINITY), b: DVector::zeros(1), limits: Vec::new() };
    steep.b[0] = 1.0;
    assert_eq!(minimize(&mut steep, &DVector::zeros(1), &Settings::default()), None);
}

#[test]
fn every_end_is_told() {
    let settings = Settings::default();
    let end = found(&mut |_: &DVector<f64>| Some(DVector::from_element(1, 3.0)), &[1.0], &settings);
    assert_eq!((end.status, end.iterations), (Status::Converged, 0));
    // Uphill on both sides of a kink, with the slope of one side.
    let mut kink = Kink;
    assert_eq!(found(&mut kink, &[0.0], &settings).status, Status::Stalled);
    let end = found(&mut rosenbrock(), &[-1.2, 1.0], &Settings { iterations: 3, ..settings });
    assert_eq!((end.status, end.iterations), (Status::IterationLimit, 3));
    let end = found(&mut rosenbrock(), &[-1.2, 1.0], &Settings { enough: 0.5, ..settings });
    assert!(end.status == Status::Converged && end.residual.amax() <= 0.5 && end.residual.amax() > 1e-9);
    assert_eq!(found(&mut |_: &DVector<f64>| Some(DVector::from_element(1, 1.0)), &[], &settings).at.len(), 0);
}

/// 1 + |x|.
struct Kink;

impl Problem for Kink {
    fn residual(&mut self, at: &DVector<f64>) -> Option<DVector<f64>> {
        Some(at.map(|v| 1.0 + v.abs()))
    }

    fn jacobian(&mut self, _: &DVector<f64>, _: &DVector<f64>) -> Option<DMatrix<f64>> {
        Some(DMatrix::identity(1, 1))
    }
}

#[test]
fn no_variable_moves_farther_than_the_longest_step() {
    let mut problem = Linear {
        j: DMatrix::from_diagonal_element(2, 2, 1.0),
        b: DVector::from_vec(vec![100.0, 50.0]),
        limits: Vec::new(),
    };
    let settings = Settings { longest: 2.0, iterations: 3, ..undamped(0.0) };
    let end = minimize(&mut problem, &DVector::zeros(2), &settings).unwrap();
    assert!((end.at - DVector::from_vec(vec![6.0, 3.0])).amax() <= 1e-12);
}

#[test]
fn the_trials_of_a_step_have_a_limit() {
    let count = |mut damping: Damping, from: f64| {
        let mut tried = Vec::new();
        let found = damping.search(|d| {
            tried.push(d);
            if d >= from { Trial::Accepted(()) } else { Trial::Rejected }
        });
        (found.is_some(), tried, damping.value)
    };
    let few = Damping { trials: 3, undamped: 1e-3, ..Damping::default() };
    assert_eq!(count(few, f64::INFINITY), (false, vec![0.0, 1e-2, 1e-1], 1.0));
    assert_eq!(count(few, 0.0), (true, vec![0.0], 1e-4));
    let (found, tried, _) = count(Damping { most: 10.0, ..Damping::default() }, f64::INFINITY);
    assert!(!found && tried.len() == 4);
    assert_eq!(count(Damping { value: 1e-12, ..Damping::default() }, 0.0).2, 1e-12);
    let mut damping = Damping::default();
    assert_eq!(damping.search::<()>(|_| Trial::Last), None);
    assert_eq!(damping, Damping::default());
}

/// Exact up to rounding for polynomials of the second degree.
#[test]
fn central_differences_of_a_parabola_are_its_slope() {
    let square = |x: &DVector<f64>| Ok::<_, ()>(DVector::from_vec(vec![x[0] * x[0] - 3.0 * x[1], x[0] * x[1]]));
    let at = DVector::from_vec(vec![0.7, -1.3]);
    let slope = central_differences(square, &at, 1e-4).unwrap();
    let exact = DMatrix::from_row_slice(2, 2, &[1.4, -3.0, -1.3, 0.7]);
    assert!((slope - exact).amax() < 1e-11);
    assert_eq!(central_differences(|_| Err::<DVector<f64>, _>("none"), &at, 1e-4), Err("none"));
}
