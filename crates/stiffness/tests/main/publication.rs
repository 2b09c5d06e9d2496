//! The published equations 3.1 to 3.15 by their mathematics, and by how much the wrong ones fail for the KR 125.

use crate::common::{
    STIFFNESS, kr125,
    measured::{NOISE, compliance, linear_measurements, relative},
    pose, rng,
};
use bracketry_stiffness::{
    Deformation, Kinematics, Springs, Twist, Wrench, loaded_compliance, twist_adjoint, wrench_adjoint,
};
use nalgebra::{Isometry3, Matrix3, Matrix6, Matrix6xX, Translation3, UnitQuaternion, Vector3, Vector6};
use rand::RngExt;
use rand::rngs::StdRng;

/// 300, −200, −500 N and 10, −20, 5 N·m.
fn load() -> Wrench {
    Wrench::new(300.0, -200.0, -500.0, 10.0, -20.0, 5.0)
}

fn deformed() -> Deformation {
    Deformation::linear(&kr125(), &Springs::linear(&STIFFNESS), &pose(), &load()).unwrap()
}

fn random(rng: &mut StdRng) -> Vector6<f64> {
    Vector6::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

fn blocks(first: &Matrix3<f64>, last: &Matrix3<f64>) -> Matrix6<f64> {
    let mut m = Matrix6::zeros();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(first);
    m.fixed_view_mut::<3, 3>(3, 3).copy_from(last);
    m
}

/// The published matrix for displacements: two rotations, no lever.
fn without_lever(pose: &Isometry3<f64>) -> Matrix6<f64> {
    let turn = *pose.rotation.to_rotation_matrix().matrix();
    blocks(&turn, &turn)
}

fn asymmetry(m: &Matrix6<f64>) -> f64 {
    (m - m.transpose()).norm() / m.norm()
}

/// Equation 3.15.
fn least_squares(data: &[(Wrench, Twist)]) -> Matrix6<f64> {
    let (mut xx, mut xw) = (Matrix6::zeros(), Matrix6::zeros());
    for (wrench, twist) in data {
        xx += twist * twist.transpose();
        xw += twist * wrench.transpose();
    }
    (xx.try_inverse().unwrap() * xw).transpose()
}

#[test]
fn three_angles_are_a_rotation_vector_to_first_order() {
    let rotation: Vector3<f64> = deformed().tool.fixed_rows::<3>(3).into();
    let (roll, pitch, yaw) = UnitQuaternion::new(rotation).euler_angles();
    let apart = (Vector3::new(roll, pitch, yaw) - rotation).norm() / rotation.norm();
    assert!((1e3 * rotation.norm() - 1.494).abs() < 1e-3, "{rotation}");
    assert!((apart - 3.24e-4).abs() < 1e-6, "{apart}");
}

#[test]
fn a_stiffness_belongs_to_its_pose() {
    let mut turned = pose();
    turned[2] += 10f64.to_radians();
    let kinematics = Kinematics::new(&kr125(), &turned).unwrap();
    let there = loaded_compliance(&kr125(), &Springs::linear(&STIFFNESS), &kinematics, &Wrench::zeros()).unwrap();
    let changed = relative(&there.try_inverse().unwrap(), &compliance().try_inverse().unwrap());
    assert!((changed - 0.194).abs() < 1e-3, "{changed}");
}

#[test]
fn a_stiffness_keeps_its_energy_only_with_the_lever_of_displacements() {
    let mut rng = rng(31);
    let energy = |stiffness: &Matrix6<f64>, twist: &Twist| 0.5 * twist.dot(&(stiffness * twist));
    let mut changed = 0;
    for _ in 0..200 {
        let factor = Matrix6::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let (stiffness, twist) = (factor * factor.transpose(), random(&mut rng));
        let (arm, turn) = (random(&mut rng), random(&mut rng));
        let pose = Isometry3::from_parts(
            Translation3::new(arm[0], arm[1], arm[2]),
            UnitQuaternion::new(2.0 * Vector3::new(turn[0], turn[1], turn[2])),
        );
        let carried = |a: Matrix6<f64>| (wrench_adjoint(&pose) * stiffness * a.try_inverse().unwrap(), a * twist);
        let before = energy(&stiffness, &twist);
        let (complete, there) = carried(twist_adjoint(&pose));
        assert!((energy(&complete, &there) - before).abs() < 1e-10 * complete.norm() * there.norm_squared());
        assert!(asymmetry(&complete) < 1e-12);
        let (published, there) = carried(without_lever(&pose));
        changed += usize::from((energy(&published, &there) / before - 1.0).abs() > 0.01);
        assert!(asymmetry(&published) > 0.01, "{}", asymmetry(&published));
    }
    assert!(changed > 180, "{changed}");
}

#[test]
fn without_the_lever_a_quarter_of_the_displacement_is_missing() {
    let springs = Springs::linear(&STIFFNESS);
    let at = |tool: f64| {
        let robot = kr125().with_tool(Isometry3::translation(0.0, 0.0, tool));
        let kinematics = Kinematics::new(&robot, &pose()).unwrap();
        let compliance = loaded_compliance(&robot, &springs, &kinematics, &Wrench::zeros()).unwrap();
        (kinematics.tool().translation.vector, compliance)
    };
    let ((flange, of_flange), (point, of_point)) = (at(0.0), at(0.3));
    // The flange seen from the tool point, base axes: the rotation is 1, and so is the published matrix for displacements.
    let seen = Isometry3::from_parts((flange - point).into(), UnitQuaternion::identity());
    assert_eq!(without_lever(&seen), Matrix6::identity());
    let at_flange = of_flange * wrench_adjoint(&seen.inverse()) * load();
    let at_point = of_point * load();
    assert!((twist_adjoint(&seen) * at_flange - at_point).norm() < 1e-15);
    let micrometers = |twist: Twist| 1e6 * twist.fixed_rows::<3>(0).norm();
    assert_eq!([micrometers(at_point), micrometers(at_point - at_flange)].map(f64::round), [1726.0, 465.0]);
    let stiffness = of_point.try_inverse().unwrap();
    let published = wrench_adjoint(&seen) * of_flange.try_inverse().unwrap();
    let complete = published * wrench_adjoint(&seen).transpose();
    assert!(relative(&complete, &stiffness) < 1e-9);
    let found = [relative(&published, &stiffness), asymmetry(&published)];
    assert_eq!(found.map(|share| (100.0 * share).round()), [20.0, 25.0], "{found:?}");
}

#[test]
fn the_wrench_of_a_component_is_the_transported_one() {
    let halves = |w: &Wrench| -> [Vector3<f64>; 2] { [w.fixed_rows::<3>(0).into(), w.fixed_rows::<3>(3).into()] };
    // Frame j in frame i.
    let component = |j_in_i: &Isometry3<f64>, wrench: &Wrench| {
        let ([force, moment], turn) = (halves(wrench), j_in_i.rotation.inverse());
        let moment = turn * (force.cross(&j_in_i.translation.vector) + moment);
        let force = turn * force;
        Wrench::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    };
    let kinematics = Kinematics::new(&kr125(), &pose()).unwrap();
    // The load in the axes of the base, at the tool point.
    let tool = Isometry3::from(kinematics.tool().translation);
    for (joint, frame) in kinematics.frames().iter().enumerate() {
        let seen = tool.inverse() * frame;
        let expected = component(&seen, &load());
        assert!((kinematics.wrench_at(joint, &load()) - expected).norm() < 1e-9, "{joint}");
        assert!((wrench_adjoint(&seen.inverse()) * load() - expected).norm() < 1e-9, "{joint}");
    }
}

#[test]
fn opposite_senses_of_position_and_rotation_make_an_indefinite_stiffness() {
    let mut rng = rng(36);
    let (compliance, one) = (compliance(), Matrix3::identity());
    let truth = compliance.try_inverse().unwrap();
    let turn = Kinematics::new(&kr125(), &pose()).unwrap().tool().rotation.to_rotation_matrix();
    let loads: Vec<Wrench> = (0..30).map(|_| random(&mut rng).component_mul(&load())).collect();
    let fitted = |measured: Matrix6<f64>| {
        least_squares(&loads.iter().map(|w| (*w, measured * compliance * w)).collect::<Vec<_>>())
    };
    assert!(relative(&fitted(Matrix6::identity()), &truth) < 1e-6);
    for (measured, percent) in [(blocks(&-one, &one), 163.0), (blocks(&-one, &turn.matrix().transpose()), 175.0)] {
        let stiffness = fitted(measured);
        let error = relative(&stiffness, &truth);
        assert_eq!((100.0 * error).round(), percent, "{error}");
        let eigenvalues = (0.5 * (stiffness + stiffness.transpose())).symmetric_eigenvalues();
        assert!(eigenvalues.min() < -1e5 && eigenvalues.max() > 1e5, "{eigenvalues}");
    }
}

#[test]
fn a_frame_moves_with_all_joints_before_it() {
    let bent = deformed();
    let turned = 1e3 * bent.frames[5].fixed_rows::<3>(3).norm();
    let own = 1e3 * bent.deflections[5].abs();
    assert!((turned - 1.494).abs() < 1e-3 && (own - 0.0273).abs() < 1e-4, "{turned} {own}");
}

#[test]
fn the_fitting_error_has_the_transpose_of_the_stiffness() {
    for seed in 0..10 {
        let measurements = linear_measurements(&mut rng(seed), &compliance(), 200);
        let data: Vec<_> = measurements.iter().map(|m| (m.wrench, m.displacement)).collect();
        let stiffness = least_squares(&data);
        let (mut residual, mut squares, mut ww, mut xw) = (Matrix6::zeros(), 0.0, Matrix6::zeros(), Matrix6::zeros());
        for (wrench, twist) in &data {
            let error = wrench - stiffness * twist;
            residual += error * error.transpose();
            squares += error.norm_squared();
            ww += wrench * wrench.transpose();
            xw += twist * wrench.transpose();
        }
        let published = |k: Matrix6<f64>| ww - xw.transpose() * k;
        assert!((published(stiffness.transpose()) - residual).norm() < 1e-8 * ww.norm());
        assert!((residual.trace() / squares - 1.0).abs() < 1e-12);
        let factor = published(stiffness).trace() / squares;
        assert!((10.0..25.0).contains(&factor), "{factor}");
    }
}

#[test]
fn the_gradient_of_the_sum_of_squares_is_the_published_one() {
    let mut rng = rng(313);
    let mut matrix = |columns| Matrix6xX::from_fn(columns, |_, _| rng.random_range(-1.0..1.0));
    let (w, x, k) = (matrix(8), matrix(8), matrix(6));
    let k = Matrix6::from_iterator(k.iter().copied());
    let sum = |k: &Matrix6<f64>| (w.transpose() - x.transpose() * k.transpose()).norm_squared();
    let expanded = &w * w.transpose() - &w * x.transpose() * k.transpose() - k * &x * w.transpose()
        + k * &x * x.transpose() * k.transpose();
    assert!((expanded.trace() / sum(&k) - 1.0).abs() < 1e-12);
    let gradient = -2.0 * &x * w.transpose() + 2.0 * &x * x.transpose() * k.transpose();
    for i in 0..6 {
        for j in 0..6 {
            let at = |sign: f64| {
                let mut k = k;
                k[(i, j)] += sign;
                sum(&k)
            };
            // S is of second order in K: central differences are exact.
            assert!(((at(1.0) - at(-1.0)) / 2.0 - gradient[(j, i)]).abs() < 1e-10, "{i} {j}");
        }
    }
}

#[test]
fn one_displacement_has_no_inverse() {
    let twist = deformed().tool;
    let squares = (twist * twist.transpose()).symmetric_eigenvalues();
    let mut squares: Vec<f64> = squares.iter().map(|v| v.abs()).collect();
    squares.sort_by(f64::total_cmp);
    assert!(squares[4] < 1e-14 * squares[5], "{squares:?}");
}

#[test]
fn the_noise_of_displacements_makes_the_published_stiffness_too_small() {
    let (compliance, noise) =
        (compliance(), blocks(&(NOISE[0] * Matrix3::identity()), &(NOISE[1] * Matrix3::identity())));
    let truth = compliance.try_inverse().unwrap();
    // Second moments of the displacements under loads that are uniform between their limits, per measurement.
    let moments = |moment: f64| {
        let loads = Vector6::from_fn(|i, _| [1000.0, moment][i / 3].powi(2) / 3.0);
        compliance * Matrix6::from_diagonal(&loads) * compliance.transpose()
    };
    let limit = |moment: f64| truth * moments(moment) * (moments(moment) + noise * noise).try_inverse().unwrap();
    let error = relative(&limit(60.0), &truth);
    assert!((error - 0.727).abs() < 1e-3, "{error}");
    // In units of the noise, every direction of displacements shrinks by its own factor.
    let whitened = noise.try_inverse().unwrap();
    let visible = (whitened * moments(60.0) * whitened.transpose()).symmetric_eigenvalues();
    let smallest = visible.min() / (1.0 + visible.min());
    assert!((smallest - 0.105).abs() < 1e-3, "{smallest}");
    // Displacements under forces are large against their noise and stay right; those under moments are not.
    let [forces, moments_alone] = [0, 3].map(|first| {
        let wrench = Wrench::from_fn(|i, _| if i / 3 * 3 == first { load()[i] } else { 0.0 });
        let (exact, predicted) = (compliance * wrench, limit(60.0).try_inverse().unwrap() * wrench);
        [0, 3].map(|i| (predicted - exact).fixed_rows::<3>(i).norm() / exact.fixed_rows::<3>(i).norm())
    });
    assert!(forces[0] < 0.002 && forces[1] < 0.005, "{forces:?}");
    assert_eq!(moments_alone.map(|share| (100.0 * share).round()), [13.0, 43.0], "{moments_alone:?}");
    // Small moments: little is left of the stiffnesses about x and z.
    let small = limit(20.0);
    for i in [3, 5] {
        let missing = 1.0 - small[(i, i)] / truth[(i, i)];
        assert_eq!((100.0 * missing).round(), 94.0, "{i}: {missing}");
    }
}
