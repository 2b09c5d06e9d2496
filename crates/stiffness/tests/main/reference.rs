//! A published robot: figures that were computed elsewhere.

use crate::common::{STIFFNESS, kr125, pose};
use bracketry_stiffness::{Deformation, Kinematics, Robot, Springs, Wrench, geometric_stiffness, loaded_compliance};

fn robot_and_springs() -> (Robot, Springs) {
    (kr125(), Springs::linear(&STIFFNESS))
}

fn load() -> Wrench {
    Wrench::new(300.0, -200.0, -500.0, 10.0, -20.0, 5.0)
}

/// Equal to all digits given.
fn assert_digits(value: f64, printed: f64, digits: i32) {
    let last = 10f64.powi(-digits);
    assert!((value - printed).abs() <= 0.5 * last * (1.0 + 1e-9), "{value} is not {printed}");
}

#[test]
fn the_tool_stands_where_it_was_computed() {
    let (robot, _) = robot_and_springs();
    let tool = robot.tool_pose(&pose()).unwrap().translation.vector;
    for (value, printed) in tool.iter().zip([0.903094, 0.415235, 1.366918]) {
        assert_digits(*value, printed, 6);
    }
}

#[test]
fn the_translational_compliance_has_the_computed_entries() {
    let (robot, springs) = robot_and_springs();
    let kinematics = Kinematics::new(&robot, &pose()).unwrap();
    let compliance = loaded_compliance(&robot, &springs, &kinematics, &Wrench::zeros()).unwrap();
    let printed = [[1.33330, 0.11391, -0.27370], [0.11391, 0.77727, -0.08889], [-0.27370, -0.08889, 2.52606]];
    for (i, row) in printed.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            assert_digits(1e6 * compliance[(i, j)], *entry, 5);
        }
    }
}

#[test]
fn the_three_deformations_have_the_computed_values() {
    let (robot, springs) = robot_and_springs();
    let (q, load) = (pose(), load());
    for (deformation, printed) in [
        (Deformation::linear(&robot, &springs, &q, &load), [0.50122, -0.08114, -1.25964]),
        (Deformation::equilibrium(&robot, &springs, &q, &load), [0.50068, -0.08150, -1.25858]),
        (Deformation::product(&robot, &springs, &q, &load), [0.50017, -0.08162, -1.25969]),
    ] {
        for (value, printed) in deformation.unwrap().tool.iter().zip(printed) {
            assert_digits(1e3 * value, printed, 5);
        }
    }
}

#[test]
fn the_loaded_compliance_is_the_derivative_of_the_equilibrium() {
    let (robot, springs) = robot_and_springs();
    let q = pose();
    let load = 5.0 * load();
    let bent = Deformation::equilibrium(&robot, &springs, &q, &load).unwrap();
    let loaded: Vec<f64> = q.iter().zip(&bent.deflections).map(|(q, d)| q + d).collect();
    let kinematics = Kinematics::new(&robot, &loaded).unwrap();
    let compliance = loaded_compliance(&robot, &springs, &kinematics, &load).unwrap();
    assert!(geometric_stiffness(&robot, &kinematics, &load).unwrap().amax() > 1000.0);
    for j in 0..6 {
        let h = if j < 3 { 1.0 } else { 0.3 };
        let at = |sign: f64| {
            let mut wrench = load;
            wrench[j] += sign * h;
            Deformation::equilibrium(&robot, &springs, &q, &wrench).unwrap().tool
        };
        let slope = (at(1.0) - at(-1.0)) / (2.0 * h);
        for i in 0..3 {
            let scale = (compliance[(i, i)] * compliance[(j, j)]).sqrt();
            assert!(
                (slope[i] - compliance[(i, j)]).abs() < 1e-6 * scale,
                "{i} {j}: {} {}",
                slope[i],
                compliance[(i, j)]
            );
        }
    }
}
