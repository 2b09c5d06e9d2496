//! Path constraints, cones, blocks of inputs and the terminal set, where the solution is known.

use approx::assert_relative_eq;
use bracketry_mpc::ocp::{Bounds, NormConstraint, PathConstraint, Softness, TerminalSet, VectorFunction};
use bracketry_mpc::qp::{ProgramForm, QpSettings};
use bracketry_mpc::sqp::Solution;
use bracketry_mpc::{
    CostFunction, CostKind, MpcError, Ocp, PlannedTrajectory, SolveStatus, Sqp, SqpSettings, SymbolicDynamics,
};
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

const FORMS: [ProgramForm; 3] =
    [ProgramForm::Sparse, ProgramForm::Condensed { block: 2 }, ProgramForm::Condensed { block: 100 }];

/// A point in the plane that moves with the velocity (u, v).
fn point() -> System {
    let text = r#"
        states = ["p", "q"]
        inputs = ["u", "v"]
        dynamics = { p = "u", q = "v" }
    "#;
    System::parse("point.toml", text).unwrap()
}

fn function(system: &System, texts: &[&str]) -> VectorFunction {
    VectorFunction::parse(system, &["a", "b"], texts).unwrap()
}

/// Cost dt·stage with the references a, b.
fn problem(system: &System, steps: usize, stage: &str) -> Ocp {
    let mut ocp = Ocp::new(2, system.inputs.len(), steps, 0.5);
    ocp.stage = Some(CostFunction::parse(system, CostKind::Stage, &["a", "b"], stage).unwrap());
    ocp.references = vec![vec![0.0, 0.0]];
    ocp
}

fn solve(system: &System, ocp: &Ocp, form: ProgramForm, x0: [f64; 2]) -> Solution {
    let qp = QpSettings { form, tolerance: 1e-10, ..QpSettings::default() };
    let dynamics = Box::new(SymbolicDynamics::new(system).unwrap());
    let mut sqp = Sqp::new(dynamics, ocp.clone(), SqpSettings { qp, ..SqpSettings::default() }).unwrap();
    let guess = PlannedTrajectory::constant(ocp.steps, &x0, &vec![0.0; ocp.inputs()]);
    sqp.solve(&x0, &guess).unwrap()
}

#[test]
fn a_limited_input_vector_is_the_projection_of_the_free_one_onto_the_disk() {
    let system = point();
    let mut ocp = problem(&system, 4, "(u - a)^2 + (v - b)^2");
    ocp.references = vec![vec![3.0, 4.0], vec![0.3, -0.2], vec![-5.0, 12.0], vec![2.5, 0.0]];
    let (vector, limit) = (function(&system, &["u", "v"]), function(&system, &["2"]));
    ocp.norm_constraints = vec![NormConstraint { name: String::new(), vector, limit, softness: Softness::Hard }];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [0.0, 0.0]);
        assert_eq!(s.status, SolveStatus::Converged);
        for (k, free) in ocp.references.iter().enumerate() {
            let shrink = (2.0 / free[0].hypot(free[1])).min(1.0);
            assert_relative_eq!(s.trajectory.u(k)[0], shrink * free[0], epsilon = 1e-6);
            assert_relative_eq!(s.trajectory.u(k)[1], shrink * free[1], epsilon = 1e-6);
        }
    }
}

#[test]
fn a_limit_that_depends_on_the_input_is_a_friction_cone() {
    // The closest point of the cone |u| ≤ 0.5 v to (1, 1): on its edge (0.5, 1)/√1.25, at the foot of the perpendicular.
    let system = point();
    let mut ocp = problem(&system, 3, "(u - 1)^2 + (v - 1)^2");
    let (vector, limit) = (function(&system, &["u"]), function(&system, &["v/2"]));
    ocp.norm_constraints = vec![NormConstraint { name: String::new(), vector, limit, softness: Softness::Hard }];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [0.0, 0.0]);
        let along = (0.5 + 1.0) / 1.25;
        assert_relative_eq!(s.trajectory.u(1)[0], 0.5 * along, epsilon = 1e-6);
        assert_relative_eq!(s.trajectory.u(1)[1], along, epsilon = 1e-6);
    }
}

#[test]
fn the_terminal_set_is_entered_at_its_nearest_point() {
    // Least effort to a disk of radius 0.5 about (1, −1): straight toward its center, with constant velocity.
    let system = point();
    let mut ocp = problem(&system, 5, "u^2 + v^2");
    let matrix = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
    ocp.terminal_set = Some(TerminalSet { matrix, center: vec![1.0, -1.0], level: 0.25, softness: Softness::Hard });
    for form in FORMS {
        let s = solve(&system, &ocp, form, [4.0, 3.0]);
        assert_eq!(s.status, SolveStatus::Converged);
        assert_relative_eq!(s.trajectory.x(5)[0], 1.0 + 0.5 * 3.0 / 5.0, epsilon = 1e-6);
        assert_relative_eq!(s.trajectory.x(5)[1], -1.0 + 0.5 * 4.0 / 5.0, epsilon = 1e-6);
    }
}

#[test]
fn a_terminal_set_without_weight_in_a_direction_leaves_it_free() {
    // |2 (p − 1)| ≤ 1, q free: q stays where it is.
    let system = point();
    let mut ocp = problem(&system, 5, "u^2 + v^2");
    let matrix = vec![vec![4.0, 0.0], vec![0.0, 0.0]];
    ocp.terminal_set = Some(TerminalSet { matrix, center: vec![1.0, 9.0], level: 1.0, softness: Softness::Hard });
    let s = solve(&system, &ocp, ProgramForm::Sparse, [4.0, 3.0]);
    assert_relative_eq!(s.trajectory.x(5)[0], 1.5, epsilon = 1e-6);
    assert_relative_eq!(s.trajectory.x(5)[1], 3.0, epsilon = 1e-6);
}

#[test]
fn nonlinear_path_constraints_are_kept_and_touched() {
    // The shortest way around the unit disk: every grid point outside of it, some on its rim.
    let system = point();
    let mut ocp = problem(&system, 12, "u^2 + v^2 + 10*(p - 2)^2 + 10*q^2");
    let outside = Bounds { min: 1.0, max: f64::INFINITY, softness: Softness::Hard };
    ocp.path_constraints = vec![PathConstraint {
        name: String::new(),
        function: function(&system, &["p^2 + q^2"]),
        bounds: outside,
        at_end: false,
    }];
    ocp.input_bounds = vec![(-0.8, 0.8); 2];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [-2.0, 0.3]);
        assert_eq!(s.status, SolveStatus::Converged);
        let radius = (1..=12).map(|k| s.trajectory.x(k)[0].hypot(s.trajectory.x(k)[1]));
        let closest = radius.fold(f64::INFINITY, f64::min);
        assert_relative_eq!(closest, 1.0, epsilon = 1e-5);
        assert!(s.trajectory.x(12)[0] > 1.5, "{:?}", s.trajectory.x(12));
    }
}

/// The least effort to the rim of a disk: straight to its nearest point, at a constant speed, through its inside.
#[test]
fn a_constraint_at_the_end_holds_there_alone() {
    let system = point();
    let mut ocp = problem(&system, 10, "u^2 + v^2");
    let rim = Bounds { min: 4.0, max: 4.0, softness: Softness::Hard };
    ocp.path_constraints = vec![PathConstraint {
        name: String::new(),
        function: function(&system, &["p^2 + q^2"]),
        bounds: rim,
        at_end: true,
    }];
    for form in FORMS {
        for direction in [0.3f64, 2.0, -1.2] {
            let start = [0.5 * direction.cos(), 0.5 * direction.sin()];
            let s = solve(&system, &ocp, form, start);
            assert_eq!(s.status, SolveStatus::Converged);
            let speed = 1.5 / (10.0 * ocp.dt);
            for k in 0..10 {
                assert_relative_eq!(s.trajectory.u(k)[0], speed * direction.cos(), epsilon = 1e-5);
                assert_relative_eq!(s.trajectory.u(k)[1], speed * direction.sin(), epsilon = 1e-5);
            }
        }
    }
}

#[test]
fn a_soft_path_constraint_gives_way_where_its_price_is_exceeded() {
    // min dt·((u − 3)² + w₁ s + w₂ s²), s = u − 1 ≥ 0: 2 (u − 3) + w₁ + 2 w₂ (u − 1) = 0.
    let system = point();
    let mut ocp = problem(&system, 2, "(u - 3)^2 + v^2");
    let softness = Softness::Soft { linear: 1.0, quadratic: 0.5 };
    let bounds = Bounds { min: f64::NEG_INFINITY, max: 1.0, softness };
    ocp.path_constraints =
        vec![PathConstraint { name: String::new(), function: function(&system, &["u"]), bounds, at_end: false }];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [0.0, 0.0]);
        assert_eq!(s.status, SolveStatus::Converged);
        assert_relative_eq!(s.trajectory.u(0)[0], 2.0, epsilon = 1e-6);
    }
}

#[test]
fn contradictions_are_solved_with_the_smallest_violation_and_reported() {
    let system = point();
    let mut ocp = problem(&system, 3, "u^2 + v^2");
    ocp.input_bounds[0] = (-1.0, 1.0);
    let bounds = Bounds { min: 1.75, max: f64::INFINITY, softness: Softness::Hard };
    ocp.path_constraints =
        vec![PathConstraint { name: String::new(), function: function(&system, &["u"]), bounds, at_end: false }];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [0.0, 0.0]);
        let SolveStatus::Infeasible { violation } = s.status else { panic!("{:?}", s.status) };
        assert_relative_eq!(violation, 0.75, epsilon = 1e-6);
        assert_relative_eq!(s.trajectory.u(1)[0], 1.0, epsilon = 1e-6);
    }
    // No vector is shorter than −0.5.
    let mut ocp = problem(&system, 3, "(u - 1)^2 + v^2");
    let (vector, limit) = (function(&system, &["u", "v"]), function(&system, &["-0.5"]));
    ocp.norm_constraints = vec![NormConstraint { name: String::new(), vector, limit, softness: Softness::Hard }];
    for form in FORMS {
        let s = solve(&system, &ocp, form, [0.0, 0.0]);
        let SolveStatus::Infeasible { violation } = s.status else { panic!("{:?}", s.status) };
        assert_relative_eq!(violation, 0.5, epsilon = 1e-5);
    }
}

#[test]
fn inputs_held_over_blocks_are_the_least_squares_of_the_blocks() {
    // min dt Σ (p_k² + u_k²/2) + 3 p_N² over inputs that are constant within blocks: a least-squares problem in three numbers.
    let system = System::parse(
        "integrator.toml",
        r#"
        states = ["p", "w"]
        inputs = ["u"]
        dynamics = { p = "w", w = "u" }
    "#,
    )
    .unwrap();
    let (steps, dt) = (6, 0.5);
    let mut ocp = problem(&system, steps, "p^2 + u^2/2");
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &[], "3*p^2").unwrap());
    ocp.move_blocks = vec![1, 2, 3];
    let block = [0, 1, 1, 2, 2, 2];
    // States (p, w) as affine functions of the three inputs.
    let x0 = [1.0, -0.3];
    let (mut p, mut w) = (DVector::from_vec(vec![0.0, 0.0, 0.0, x0[0]]), DVector::from_vec(vec![0.0, 0.0, 0.0, x0[1]]));
    let mut rows: Vec<(f64, DVector<f64>)> = Vec::new();
    for b in block {
        let mut u = DVector::zeros(4);
        u[b] = 1.0;
        rows.push((dt, p.clone()));
        rows.push((dt / 2.0, u.clone()));
        p += dt * &w + dt * dt / 2.0 * &u;
        w += dt * &u;
    }
    rows.push((3.0, p));
    let mut normal = DMatrix::zeros(3, 3);
    let mut right = DVector::zeros(3);
    for (weight, row) in &rows {
        let a = row.rows(0, 3);
        normal += *weight * a * a.transpose();
        right -= *weight * row[3] * a;
    }
    let expected = normal.lu().solve(&right).unwrap();
    for form in FORMS {
        let s = solve(&system, &ocp, form, x0);
        assert_eq!(s.status, SolveStatus::Converged);
        for (k, b) in block.into_iter().enumerate() {
            assert_relative_eq!(s.trajectory.u(k)[0], expected[b], epsilon = 1e-6);
        }
        assert_eq!(s.trajectory.u(3), s.trajectory.u(5));
    }
}

#[test]
fn what_contradicts_the_model_is_refused() {
    let system = point();
    let other = System::parse("one.toml", "states = [\"p\"]\ninputs = []\ndynamics = { p = \"-p\" }").unwrap();
    let free = || problem(&system, 4, "u^2 + v^2");
    let refused = |change: &dyn Fn(&mut Ocp)| {
        let mut ocp = free();
        change(&mut ocp);
        ocp.check(2, 2).unwrap_err().to_string()
    };
    let path = |f: VectorFunction, min: f64, max: f64| PathConstraint {
        name: String::new(),
        function: f,
        bounds: Bounds { min, max, softness: Softness::Hard },
        at_end: false,
    };
    let norm = |vector: &[&str], limit: &[&str]| NormConstraint {
        name: String::new(),
        vector: function(&system, vector),
        limit: function(&system, limit),
        softness: Softness::Hard,
    };
    let set = |matrix: [[f64; 2]; 2], level: f64| {
        let matrix = matrix.iter().map(|r| r.to_vec()).collect();
        Some(TerminalSet { matrix, center: vec![0.0; 2], level, softness: Softness::Hard })
    };
    let cases: Vec<(String, &str)> = vec![
        (refused(&|o| o.move_blocks = vec![1, 2]), "the sum of the move blocks has length 3, expected 4"),
        (refused(&|o| o.move_blocks = vec![4, 0]), "the length of a move block is 0: give a positive number"),
        (
            refused(&|o| {
                let f = VectorFunction::parse(&other, &[], &["p"]).unwrap();
                o.path_constraints = vec![path(f, 0.0, 1.0)];
            }),
            "a path constraint's list of variables has length 1, expected 4",
        ),
        (
            refused(&|o| o.path_constraints = vec![path(function(&system, &["p", "q"]), 0.0, 1.0)]),
            "a path constraint's function has length 2, expected 1",
        ),
        (
            refused(&|o| o.path_constraints = vec![path(function(&system, &["p"]), 2.0, 1.0)]),
            "the bounds of path constraint 0 contradict each other: min 2 > max 1",
        ),
        (
            refused(&|o| o.norm_constraints = vec![norm(&["u", "v"], &["1", "2"])]),
            "a norm constraint's limit has length 2, expected 1",
        ),
        (
            refused(&|o| o.norm_constraints = vec![norm(&[], &["1"])]),
            "the number of components of a norm constraint is 0: give a positive number",
        ),
        (
            refused(&|o| o.terminal_set = set([[1.0, 0.0], [0.5, 1.0]], 1.0)),
            "the asymmetry of the terminal set's matrix at (1, 0) is 0.5: give a symmetric matrix",
        ),
        (
            refused(&|o| o.terminal_set = set([[1.0, 0.0], [0.0, -1.0]], 1.0)),
            "the smallest eigenvalue of the terminal set's matrix is -1: give a positive semidefinite matrix",
        ),
        (
            refused(&|o| o.terminal_set = set([[0.0, 0.0], [0.0, 0.0]], 1.0)),
            "the largest entry of the terminal set's matrix is 0: give a matrix that is not zero",
        ),
        (
            refused(&|o| o.terminal_set = set([[1.0, 0.0], [0.0, 1.0]], 0.0)),
            "the level of the terminal set is 0: give a positive number",
        ),
    ];
    for (message, expected) in cases {
        assert_eq!(message, expected);
    }
    assert!(matches!(VectorFunction::parse(&system, &[], &["p + unknown"]), Err(MpcError::Parse(_))));
}
