//! What holds for every robot: tried on random ones with turning and sliding joints.

use bracketry_stiffness::{
    Deformation, Joint, JointKind, JointSpring, Kinematics, Robot, Springs, Twist, Wrench, displaced,
    displacement_between, loaded_compliance, twist_adjoint, wrench_adjoint,
};
use nalgebra::{Isometry3, Matrix6, Translation3, Unit, UnitQuaternion, Vector3, Vector6};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

const ROBOTS: u64 = 60;

fn vector(rng: &mut StdRng, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| size * rng.random_range(-1.0..1.0))
}

fn six(rng: &mut StdRng, first: f64, last: f64) -> Vector6<f64> {
    Vector6::from_fn(|i, _| if i < 3 { first } else { last } * rng.random_range(-1.0..1.0))
}

fn isometry(rng: &mut StdRng) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(vector(rng, 1.0)), UnitQuaternion::new(vector(rng, 2.5)))
}

/// One to nine joints, a third of them sliding, with any axes and offsets.
fn robot(rng: &mut StdRng) -> (Robot, Vec<f64>) {
    let count = rng.random_range(1..10);
    let joints = (0..count).map(|i| Joint {
        name: format!("joint_{i}"),
        kind: if rng.random_range(0..3) == 0 { JointKind::Prismatic } else { JointKind::Revolute },
        placement: isometry(rng),
        axis: Unit::new_normalize(vector(rng, 1.0) + Vector3::new(0.0, 0.0, 1.5)),
        offset: rng.random_range(-1.0..1.0),
    });
    let robot = Robot { name: "random".to_owned(), joints: joints.collect(), tool: isometry(rng) };
    let q = (0..count).map(|_| rng.random_range(-2.0..2.0)).collect();
    (robot, q)
}

fn stiffnesses(rng: &mut StdRng, robot: &Robot) -> Vec<f64> {
    robot.joints.iter().map(|_| 10f64.powf(rng.random_range(5.0..7.0))).collect()
}

/// A random symmetric positive definite compliance of a link.
fn link(rng: &mut StdRng) -> Matrix6<f64> {
    let factor = Matrix6::from_fn(|_, _| rng.random_range(-1.0..1.0));
    1e-7 * (factor * factor.transpose())
}

fn close(a: &Vector6<f64>, b: &Vector6<f64>, tolerance: f64) -> bool {
    (a - b).norm() <= tolerance * (1.0 + a.norm().max(b.norm()))
}

#[test]
fn adjoints_of_twists_and_wrenches_are_dual() {
    let mut rng = StdRng::seed_from_u64(1);
    for _ in 0..200 {
        let (pose, next) = (isometry(&mut rng), isometry(&mut rng));
        let product = twist_adjoint(&pose).transpose() * wrench_adjoint(&pose);
        assert!((product - Matrix6::identity()).norm() < 1e-13);
        // The work of a wrench on a twist does not depend on the frame they are given in.
        let (twist, wrench) = (six(&mut rng, 1.0, 1.0), six(&mut rng, 1.0, 1.0));
        let there = (wrench_adjoint(&pose) * wrench).dot(&(twist_adjoint(&pose) * twist));
        assert!((there - wrench.dot(&twist)).abs() < 1e-12);
        // They are representations: of products, and of inverses.
        assert!((twist_adjoint(&(pose * next)) - twist_adjoint(&pose) * twist_adjoint(&next)).norm() < 1e-12);
        assert!((wrench_adjoint(&(pose * next)) - wrench_adjoint(&pose) * wrench_adjoint(&next)).norm() < 1e-12);
        assert!((twist_adjoint(&pose.inverse()) * twist_adjoint(&pose) - Matrix6::identity()).norm() < 1e-12);
    }
}

#[test]
fn a_twist_adjoint_is_the_derivative_of_conjugation() {
    let mut rng = StdRng::seed_from_u64(2);
    for _ in 0..50 {
        let (pose, twist) = (isometry(&mut rng), six(&mut rng, 1.0, 1.0));
        let h = 1e-6;
        let moved = |sign: f64| pose * displaced(&Isometry3::identity(), &(sign * h * twist)) * pose.inverse();
        let slope = (displacement_between(&Isometry3::identity(), &moved(1.0))
            - displacement_between(&Isometry3::identity(), &moved(-1.0)))
            / (2.0 * h);
        assert!(close(&slope, &(twist_adjoint(&pose) * twist), 1e-8), "{slope} {twist}");
    }
}

#[test]
fn displacements_lead_from_pose_to_pose() {
    let mut rng = StdRng::seed_from_u64(3);
    for _ in 0..200 {
        let (pose, by) = (isometry(&mut rng), six(&mut rng, 1.0, 1.7));
        // The rotation vector is in the axes that the poses are given in, and its sign is that of the turn from the first to the second.
        let there = displaced(&pose, &by);
        assert!(close(&displacement_between(&pose, &there), &by, 1e-12));
        let back = displacement_between(&there, &pose);
        assert!(close(&back, &-by, 1e-12));
        let turn: Vector3<f64> = by.fixed_rows::<3>(3).into();
        let expected = UnitQuaternion::new(turn) * pose.rotation * Vector3::x();
        assert!((there.rotation * Vector3::x() - expected).norm() < 1e-12);
        assert!((there.translation.vector - pose.translation.vector - by.fixed_rows::<3>(0)).norm() < 1e-12);
    }
    // A quarter turn about z takes x to y.
    let turned = displaced(&Isometry3::identity(), &Twist::new(0.0, 0.0, 0.0, 0.0, 0.0, std::f64::consts::FRAC_PI_2));
    assert!((turned.rotation * Vector3::x() - Vector3::y()).norm() < 1e-15);
}

#[test]
fn the_jacobian_is_the_derivative_of_forward_kinematics() {
    for seed in 0..ROBOTS {
        let (robot, q) = robot(&mut StdRng::seed_from_u64(100 + seed));
        let kinematics = Kinematics::new(&robot, &q).unwrap();
        let h = 1e-5;
        for j in 0..q.len() {
            let at = |sign: f64| {
                let mut moved = q.clone();
                moved[j] += sign * h;
                robot.tool_pose(&moved).unwrap()
            };
            let slope = displacement_between(&at(-1.0), &at(1.0)) / (2.0 * h);
            assert!(close(&slope, &kinematics.jacobian().column(j).into_owned(), 1e-8), "robot {seed}, joint {j}");
            for i in 0..q.len() {
                let column = |sign: f64| {
                    let mut moved = q.clone();
                    moved[j] += sign * h;
                    Kinematics::new(&robot, &moved).unwrap().jacobian().column(i).into_owned()
                };
                let slope = (column(1.0) - column(-1.0)) / (2.0 * h);
                let derivative = kinematics.jacobian_derivative(&robot, i, j);
                assert!(close(&slope, &derivative, 1e-7), "robot {seed}, ∂J{i}/∂q{j}");
            }
        }
    }
}

#[test]
fn a_torque_is_the_load_s_power_per_rate_and_the_wrench_along_the_axis() {
    for seed in 0..ROBOTS {
        let mut rng = StdRng::seed_from_u64(200 + seed);
        let (robot, q) = robot(&mut rng);
        let kinematics = Kinematics::new(&robot, &q).unwrap();
        let wrench = six(&mut rng, 500.0, 100.0);
        for (i, joint) in robot.joints.iter().enumerate() {
            let here = kinematics.wrench_at(i, &wrench);
            let rows = if joint.kind == JointKind::Revolute { 3 } else { 0 };
            let along = here.fixed_rows::<3>(rows).dot(&joint.axis);
            assert!((kinematics.torque(i, &wrench) - along).abs() < 1e-10 * wrench.norm(), "robot {seed}, joint {i}");
            // Transported by the adjoint of the frame's pose, it is the wrench at the base again.
            let tool = Isometry3::from(kinematics.tool().translation);
            let base = wrench_adjoint(&kinematics.frames()[i]) * here;
            assert!(close(&base, &(wrench_adjoint(&tool) * wrench), 1e-12));
        }
    }
}

#[test]
fn the_work_of_a_slowly_applied_load_is_the_energy_of_the_springs() {
    for seed in 0..ROBOTS {
        let mut rng = StdRng::seed_from_u64(300 + seed);
        let (robot, q) = robot(&mut rng);
        let stiffness = stiffnesses(&mut rng, &robot);
        let links: Vec<Matrix6<f64>> = robot.joints.iter().map(|_| link(&mut rng)).collect();
        let springs = Springs::linear(&stiffness).with_links(links.clone());
        let wrench = six(&mut rng, 500.0, 100.0);
        let kinematics = Kinematics::new(&robot, &q).unwrap();
        let compliance = loaded_compliance(&robot, &springs, &kinematics, &Wrench::zeros()).unwrap();
        let work = 0.5 * wrench.dot(&(compliance * wrench));
        let bent = Deformation::linear(&robot, &springs, &q, &wrench).unwrap();
        let joints: f64 = bent.deflections.iter().zip(&stiffness).map(|(d, k)| 0.5 * k * d * d).sum();
        let of_links = links.iter().enumerate().map(|(i, link)| {
            let here = kinematics.wrench_at(i, &wrench);
            0.5 * here.dot(&(link * here))
        });
        let energy = joints + of_links.sum::<f64>();
        assert!((work - energy).abs() < 1e-11 * work, "robot {seed}: {work} {energy}");
        assert!((work - 0.5 * wrench.dot(&bent.tool)).abs() < 1e-11 * work);
    }
}

#[test]
fn the_work_along_the_loaded_path_is_the_energy_of_nonlinear_springs() {
    // A force keeps its direction: ∫ F·dp over the equilibria, against ∫ τ dδ in every joint.
    for seed in 0..10 {
        let mut rng = StdRng::seed_from_u64(400 + seed);
        let (robot, q) = robot(&mut rng);
        let joints = stiffnesses(&mut rng, &robot);
        let springs = Springs::of_joints(
            joints.iter().map(|k| JointSpring::Stiffening { stiffness: *k, cubic: k * 1e6 }).collect(),
        );
        let force = Wrench::from_fn(|i, _| if i < 3 { 2000.0 * rng.random_range(-1.0..1.0) } else { 0.0 });
        let steps = 400;
        let (mut work, mut last) = (0.0, Wrench::zeros());
        for n in 1..=steps {
            let load = force * (f64::from(n) / f64::from(steps));
            let tool = Deformation::equilibrium(&robot, &springs, &q, &load).unwrap().tool;
            let before = force * (f64::from(n - 1) / f64::from(steps));
            work += 0.5 * (load + before).dot(&(tool - last));
            last = tool;
        }
        let bent = Deformation::equilibrium(&robot, &springs, &q, &force).unwrap();
        let energy = bent.deflections.iter().zip(&joints).map(|(d, k)| 0.5 * k * d * d + 0.25 * k * 1e6 * d.powi(4));
        let energy: f64 = energy.sum();
        assert!((work - energy).abs() < 1e-4 * energy, "robot {seed}: {work} {energy}");
    }
}

#[test]
fn a_compliance_is_carried_to_another_frame_by_congruence() {
    for seed in 0..ROBOTS {
        let mut rng = StdRng::seed_from_u64(500 + seed);
        let (first, q) = robot(&mut rng);
        let springs = Springs::linear(&stiffnesses(&mut rng, &first))
            .with_links(first.joints.iter().map(|_| link(&mut rng)).collect());
        // The same robot with its tool point elsewhere: pose of the old point seen from the new, in base axes.
        let second = first.clone().with_tool(isometry(&mut rng));
        let at = |robot: &Robot| Kinematics::new(robot, &q).unwrap();
        let of = |robot: &Robot| loaded_compliance(robot, &springs, &at(robot), &Wrench::zeros()).unwrap();
        let arm = at(&first).tool().translation.vector - at(&second).tool().translation.vector;
        let seen = Isometry3::from_parts(arm.into(), UnitQuaternion::identity());
        let (twist, wrench) = (twist_adjoint(&seen), wrench_adjoint(&seen));
        let (here, there) = (of(&first), of(&second));
        let carried = twist * here * twist.transpose();
        assert!((there - carried).norm() < 1e-11 * there.norm(), "robot {seed}");
        // Stiffness goes the other way, with the wrenches' adjoint (of links alone here every direction yields).
        let stiffness = wrench * here.try_inverse().unwrap() * wrench.transpose();
        assert!((stiffness * there - Matrix6::identity()).norm() < 1e-6, "robot {seed}");
        assert!((there - there.transpose()).norm() < 1e-12 * there.norm());
        assert!(there.symmetric_eigenvalues().min() > 0.0);
        // Turned axes: the base turned, everything turns along.
        let turn = Isometry3::from_parts(Translation3::identity(), UnitQuaternion::new(vector(&mut rng, 2.0)));
        let mut turned = first.clone();
        turned.joints[0].placement = turn * turned.joints[0].placement;
        let adjoint = twist_adjoint(&turn);
        assert!((of(&turned) - adjoint * here * adjoint.transpose()).norm() < 1e-12 * here.norm());
    }
}

#[test]
fn displacement_and_rotation_have_the_sign_of_the_load() {
    for seed in 0..ROBOTS {
        let mut rng = StdRng::seed_from_u64(600 + seed);
        let (robot, q) = robot(&mut rng);
        let springs = Springs::linear(&stiffnesses(&mut rng, &robot))
            .with_links(robot.joints.iter().map(|_| link(&mut rng)).collect());
        for axis in 0..6 {
            let mut wrench = Wrench::zeros();
            wrench[axis] = 50.0;
            for bent in [
                Deformation::linear(&robot, &springs, &q, &wrench).unwrap(),
                Deformation::product(&robot, &springs, &q, &wrench).unwrap(),
                Deformation::equilibrium(&robot, &springs, &q, &wrench).unwrap(),
            ] {
                assert!(bent.tool[axis] > 0.0, "robot {seed}, axis {axis}: {}", bent.tool);
            }
        }
    }
}

#[test]
fn the_three_deformations_agree_to_first_order_in_the_load() {
    for seed in 0..ROBOTS {
        let mut rng = StdRng::seed_from_u64(700 + seed);
        let (robot, q) = robot(&mut rng);
        let springs = Springs::linear(&stiffnesses(&mut rng, &robot))
            .with_links(robot.joints.iter().map(|_| link(&mut rng)).collect());
        let wrench = six(&mut rng, 500.0, 100.0);
        let gap = |strength: f64| {
            let load = strength * wrench;
            let linear = Deformation::linear(&robot, &springs, &q, &load).unwrap();
            let others = [
                Deformation::product(&robot, &springs, &q, &load).unwrap(),
                Deformation::equilibrium(&robot, &springs, &q, &load).unwrap(),
            ];
            let frames = linear.frames.len() - 1;
            others.map(|other| {
                (other.tool - linear.tool).norm().max((other.frames[frames] - linear.frames[frames]).norm())
            })
        };
        // Half the load, a quarter of the difference.
        for (whole, half) in gap(0.1).iter().zip(gap(0.05)) {
            assert!((half / whole - 0.25).abs() < 0.02, "robot {seed}: {whole} {half}");
        }
    }
}
