#![allow(clippy::unwrap_used)]
use super::condensing::Condensing;
use super::*;
use crate::ocp::{
    Bounds, CostFunction, CostKind, NormConstraint, PathConstraint, Softness, TerminalSet, TerminalTarget,
    VectorFunction,
};
use ::clarabel::algebra::CscMatrix;
use approx::assert_relative_eq;
use bracketry_system::System;
use nalgebra::{DMatrix, DVector};

/// Numbers in [−1, 1] from a linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    fn vector(&mut self, length: usize, size: f64) -> Vec<f64> {
        (0..length).map(|_| size * self.next()).collect()
    }
}

fn system() -> System {
    let text = r#"
        states = ["a", "b", "c"]
        inputs = ["u", "v"]
        dynamics = { a = "b", b = "c*u", c = "v - a" }
    "#;
    System::parse("three.toml", text).unwrap()
}

const STEPS: usize = 11;
const SOFT: Softness = Softness::Soft { linear: 3.0, quadratic: 2.0 };

/// A problem with every kind of cost and constraint.
fn everything() -> Ocp {
    let system = system();
    let function = |texts: &[&str]| VectorFunction::parse(&system, &["r"], texts).unwrap();
    let mut ocp = Ocp::new(3, 2, STEPS, 0.1);
    ocp.state_scale = vec![1.0, 0.5, 2.0];
    let stage = "(a - r)^2 + 2*b^2 + c^2 + a*u + u^2 + u*v + 3*v^2 + exp(a)";
    ocp.stage = Some(CostFunction::parse(&system, CostKind::Stage, &["r"], stage).unwrap());
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &["r"], "a^2 + a*b + b^2 + c^2").unwrap());
    ocp.references = (0..20).map(|k| vec![0.1 * k as f64]).collect();
    ocp.input_bounds = vec![(-0.5, 0.7), (f64::NEG_INFINITY, 0.4)];
    ocp.state_bounds[1] = Bounds { min: -0.2, max: 0.3, softness: SOFT };
    ocp.state_bounds[2] = Bounds { min: -0.9, max: f64::INFINITY, softness: Softness::Hard };
    ocp.targets = vec![
        TerminalTarget { state: 0, value: 0.3, linear: 2.0, quadratic: 1.0 },
        TerminalTarget { state: 1, value: -0.1, linear: 0.0, quadratic: 4.0 },
    ];
    let bounds = |min, max, softness| Bounds { min, max, softness };
    ocp.path_constraints = vec![
        PathConstraint {
            name: String::new(),
            function: function(&["a*b + sin(c)"]),
            bounds: bounds(-0.4, 0.5, SOFT),
            at_end: false,
        },
        PathConstraint {
            name: String::new(),
            function: function(&["a*u + v + t"]),
            bounds: bounds(-0.6, f64::INFINITY, Softness::Hard),
            at_end: false,
        },
        PathConstraint { name: String::new(), function: function(&["a + c - r"]), bounds: Bounds::FREE, at_end: false },
    ];
    ocp.norm_constraints = vec![
        NormConstraint {
            name: String::new(),
            vector: function(&["u", "v"]),
            limit: function(&["0.6 + 0.1*a^2"]),
            softness: Softness::Hard,
        },
        NormConstraint {
            name: String::new(),
            vector: function(&["a", "b", "c"]),
            limit: function(&["0.8"]),
            softness: SOFT,
        },
    ];
    ocp.terminal_set = Some(TerminalSet {
        matrix: vec![vec![2.0, 0.5, 0.0], vec![0.5, 1.0, 0.0], vec![0.0, 0.0, 0.0]],
        center: vec![0.1, 0.0, 5.0],
        level: 0.04,
        softness: SOFT,
    });
    ocp
}

/// A point and a stable linearization at it, drawn at random within the flow's pattern.
fn random_point(seed: u64) -> (PlannedTrajectory, ShootingLinearization, Vec<bool>) {
    let mut random = Random(seed);
    let x: Vec<Vec<f64>> = (0..=STEPS).map(|_| random.vector(3, 0.8)).collect();
    let u: Vec<Vec<f64>> = (0..STEPS).map(|_| random.vector(2, 0.5)).collect();
    let mut closure = vec![true; 15];
    closure[4] = seed.is_multiple_of(2);
    let mut jacobian = random.vector(STEPS * 15, 0.6);
    for (i, v) in jacobian.iter_mut().enumerate().filter(|(i, _)| !closure[i % 15]) {
        *v = 0.0 * i as f64;
    }
    let end = random.vector(STEPS * 3, 0.8);
    (
        PlannedTrajectory::from_rows(&x, &u).unwrap(),
        ShootingLinearization { end, jacobian, ..ShootingLinearization::default() },
        closure,
    )
}

fn settings(form: ProgramForm, tolerance: f64) -> QpSettings {
    QpSettings { form, tolerance, ..QpSettings::default() }
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn solved(ocp: &mut Ocp, seed: u64, form: ProgramForm) -> (QpStatus, QpSolution) {
    let (z, lin, closure) = random_point(seed);
    let mut qp = Qp::new(ocp, STEPS, &closure, settings(form, 1e-12));
    qp.assemble(ocp, 2, &z, &lin, 0.1);
    let status = qp.solve().unwrap();
    (status, qp.solution.clone())
}

/// ½ zᵀHz + gᵀz, and r − Rz.
fn objective_and_rows(program: &StageProgram, z: &[f64]) -> (f64, Vec<f64>) {
    let quadratic: f64 = program.hessian().map(|((i, j), h)| h * z[i] * z[j] * if i == j { 0.5 } else { 1.0 }).sum();
    let linear: f64 = program.gradient().iter().zip(z).map(|(g, z)| g * z).sum();
    let mut rows = program.right_hand_side().to_vec();
    program.rows().for_each(|((row, v), r)| rows[row] -= r * z[v]);
    (quadratic + linear, rows)
}

/// The same of the program as a solver sees it.
fn reduced(p: &CscMatrix<f64>, q: &[f64], a: &CscMatrix<f64>, b: &[f64], y: &[f64]) -> (f64, Vec<f64>) {
    let mut value: f64 = q.iter().zip(y).map(|(q, y)| q * y).sum();
    let mut rows = b.to_vec();
    for c in 0..p.n {
        for s in p.colptr[c]..p.colptr[c + 1] {
            let r = p.rowval[s];
            value += p.nzval[s] * y[r] * y[c] * if r == c { 0.5 } else { 1.0 };
        }
        for s in a.colptr[c]..a.colptr[c + 1] {
            rows[a.rowval[s]] -= a.nzval[s] * y[c];
        }
    }
    (value, rows)
}

#[test]
fn elimination_keeps_objective_and_constraints_of_every_step_that_obeys_the_dynamics() {
    type Rule = fn(usize, usize) -> bool;
    let rules: [Rule; 5] =
        [|_, _| false, |_, _| true, |k, _| k % 3 != 0, |_, i| i == 1, |k, i| (k * 7 + i * 5) % 4 < 2];
    for blocks in [vec![], vec![1, 2, 3, 5]] {
        let mut ocp = everything();
        ocp.move_blocks = blocks;
        for (seed, rule) in rules.iter().enumerate() {
            let (trajectory, lin, closure) = random_point(seed as u64);
            let scale = ocp.state_scale.clone();
            let mut assembly = Assembly::new(&ocp, STEPS, &closure, false);
            assembly.fill(&mut ocp, LinearizationPoint { k0: 2, trajectory: &trajectory, lin: &lin }, 0.1, 1e4, &[]);
            let program = &assembly.program;
            let (mut substitution, mut p, mut a) = Condensing::new(program, rule);
            substitution.load(program, &lin.jacobian);
            let (mut q, mut b) = (vec![0.0; p.n], vec![0.0; a.m]);
            substitution.gather(&mut p.nzval, &mut q, &mut a.nzval, &mut b);
            let mut random = Random(99);
            // Differences to one step remove the constant of the objective.
            let mut values = Vec::new();
            for _ in 0..4 {
                let y = random.vector(p.n, 1.0);
                let mut solution = StageSolution {
                    z: vec![0.0; program.variables()],
                    multipliers: vec![0.0; STEPS * 3],
                    ..StageSolution::default()
                };
                substitution.recover(&y, &vec![0.0; a.m], &mut solution, 3);
                let z = solution.z;
                let (full, expected) = objective_and_rows(program, &z);
                let (value, rows) = reduced(&p, &q, &a, &b, &y);
                values.push(full - value * program.objective_scale());
                for ((r, e), s) in rows[substitution.equalities()..].iter().zip(&expected).zip(program.row_scales()) {
                    assert_relative_eq!(*r * s, *e, epsilon = 1e-10);
                }
                // What was eliminated obeys the dynamics; the residuals of what was not are the rows of the solver.
                let mut kept = rows[..substitution.equalities()].iter();
                for k in 0..STEPS {
                    for i in 0..3 {
                        let flow = &lin.jacobian[(k * 3 + i) * 5..][..5];
                        let step = (0..5).map(|v| program.variable(k, v).map_or(0.0, |z_v| flow[v] * z[z_v]));
                        let residual = program.defects()[k * 3 + i] + step.sum::<f64>() - z[program.state(k + 1, i)];
                        let expected = if rule(k + 1, i) { 0.0 } else { scale[i] * *kept.next().unwrap() };
                        assert_relative_eq!(residual, expected, epsilon = 1e-10);
                    }
                    for j in 0..2 {
                        let (start, offset) = program.block(k, j);
                        if start < k {
                            assert_eq!(z[program.input(k, j)], z[program.input(start, j)] + offset);
                        }
                    }
                }
            }
            for v in &values[1..] {
                assert_relative_eq!(*v, values[0], epsilon = 1e-9, max_relative = 1e-12);
            }
        }
    }
}

#[test]
fn every_form_attains_the_same_objective() {
    // Objectives agree to the tolerance of the solver, steps to its root.
    for blocks in [vec![], vec![1, 2, 3, 5]] {
        let mut ocp = everything();
        ocp.move_blocks = blocks;
        for seed in 0..10 {
            let (trajectory, lin, closure) = random_point(seed);
            let mut solve = |form| {
                let mut qp = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-10));
                qp.assemble(&mut ocp, 2, &trajectory, &lin, 0.1);
                let status = qp.solve().unwrap();
                assert!(status.is_usable(), "{seed}: {status:?}");
                let (value, _) = objective_and_rows(&qp.assembly.program, &qp.stage.z);
                (value, qp.solution)
            };
            let (best, sparse) = solve(ProgramForm::Sparse);
            for block in [2, 3, 4, STEPS, 100] {
                let (value, condensed) = solve(ProgramForm::Condensed { block });
                assert_relative_eq!(value, best, max_relative = 1e-9, epsilon = 1e-9);
                let step = difference(&sparse.dx, &condensed.dx).max(difference(&sparse.du, &condensed.du));
                assert!(step < 3e-5, "{seed} {block}: {step:e}");
            }
        }
    }
}

#[test]
fn every_form_takes_the_same_step_where_bounds_are_linear() {
    for blocks in [vec![], vec![1, 2, 3, 5]] {
        let mut ocp = everything();
        ocp.move_blocks = blocks;
        ocp.norm_constraints.clear();
        ocp.terminal_set = None;
        for seed in 0..10 {
            let (status, sparse) = solved(&mut ocp, seed, ProgramForm::Sparse);
            assert!(status.is_usable(), "{seed}: {status:?}");
            for block in [2, 3, 4, STEPS, 100] {
                let (_, condensed) = solved(&mut ocp, seed, ProgramForm::Condensed { block });
                assert!(difference(&sparse.dx, &condensed.dx) < 1e-8, "{seed} {block}");
                assert!(difference(&sparse.du, &condensed.du) < 1e-8, "{seed} {block}");
                assert!(difference(&sparse.multipliers, &condensed.multipliers) < 1e-6, "{seed} {block}");
            }
        }
    }
}

#[test]
fn without_inequalities_every_form_solves_the_optimality_conditions() {
    // H z + g + Eᵀy = 0, E z = c as one dense system, put together from the blocks.
    let mut ocp = everything();
    ocp.path_constraints.clear();
    ocp.norm_constraints.clear();
    ocp.terminal_set = None;
    ocp.targets.truncate(0);
    ocp.input_bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); 2];
    ocp.state_bounds = vec![Bounds::FREE; 3];
    for seed in 0..5 {
        let (trajectory, lin, closure) = random_point(seed);
        for form in [ProgramForm::Sparse, ProgramForm::Condensed { block: 4 }, ProgramForm::Condensed { block: STEPS }]
        {
            let mut qp = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-12));
            qp.assemble(&mut ocp, 2, &trajectory, &lin, 0.1);
            assert_eq!(qp.solve().unwrap(), QpStatus::Solved);
            let program = &qp.assembly.program;
            let (nv, ne) = (program.variables(), STEPS * 3);
            let mut matrix = DMatrix::zeros(nv + ne, nv + ne);
            let mut right = DVector::zeros(nv + ne);
            for ((i, j), h) in program.hessian() {
                matrix[(i, j)] += h;
                if i != j {
                    matrix[(j, i)] += h;
                }
            }
            for v in 0..nv {
                right[v] = -program.gradient()[v];
            }
            for k in 0..STEPS {
                for i in 0..3 {
                    let row = nv + k * 3 + i;
                    let mut set = |v: usize, a: f64| {
                        matrix[(row, v)] += a;
                        matrix[(v, row)] += a;
                    };
                    set(program.state(k + 1, i), 1.0);
                    for j in 0..5 {
                        if let Some(v) = program.variable(k, j) {
                            set(v, -lin.jacobian[(k * 3 + i) * 5 + j]);
                        }
                    }
                    right[row] = program.defects()[k * 3 + i];
                }
            }
            let expected = matrix.lu().solve(&right).unwrap();
            assert!(difference(&qp.stage.z, &expected.as_slice()[..nv]) < 1e-7);
            assert!(difference(&qp.stage.multipliers, &expected.as_slice()[nv..]) < 1e-6);
        }
    }
}

#[test]
fn a_program_whose_first_interval_was_replaced_is_the_program_assembled_anew() {
    for blocks in [vec![], vec![4, 4, 3]] {
        let mut ocp = everything();
        ocp.move_blocks = blocks;
        for form in [ProgramForm::Sparse, ProgramForm::Condensed { block: 3 }, ProgramForm::Condensed { block: STEPS }]
        {
            let (mut trajectory, mut lin, closure) = random_point(5);
            let mut updated = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-8));
            updated.assemble(&mut ocp, 2, &trajectory, &lin, 0.1);
            // A new measurement moves x_0, and with it the first block of the flow.
            let mut random = Random(77);
            trajectory.x_mut(0).copy_from_slice(&random.vector(3, 0.5));
            for (i, v) in lin.jacobian[..15].iter_mut().enumerate().filter(|(i, _)| closure[*i]) {
                *v += 0.01 * i as f64;
            }
            lin.end[..3].copy_from_slice(&random.vector(3, 0.5));
            let mut anew = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-8));
            anew.assemble(&mut ocp, 2, &trajectory, &lin, 0.1);
            for _ in 0..2 {
                updated.update_first_interval(&mut ocp, 2, &trajectory, &lin);
                assert_eq!(updated.solve().unwrap(), anew.solve().unwrap());
                assert_eq!(updated.solution.dx, anew.solution.dx);
                assert_eq!(updated.solution.du, anew.solution.du);
                assert_eq!(updated.solution.multipliers, anew.solution.multipliers);
            }
        }
    }
}

#[test]
fn new_numbers_give_the_solution_of_a_new_program() {
    let mut ocp = everything();
    for form in [ProgramForm::Sparse, ProgramForm::Condensed { block: 3 }] {
        let (_, _, closure) = random_point(0);
        let mut updated = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-8));
        for seed in [0, 2, 4] {
            let (trajectory, lin, _) = random_point(seed);
            let mut anew = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-8));
            for qp in [&mut updated, &mut anew] {
                qp.assemble(&mut ocp, 2, &trajectory, &lin, 0.1);
                assert!(qp.solve().unwrap().is_usable());
            }
            assert_eq!(updated.solution.dx, anew.solution.dx);
            assert_eq!(updated.solution.multipliers, anew.solution.multipliers);
        }
    }
}

#[test]
fn numbers_that_are_not_finite_are_reported_before_anything_is_solved() {
    let mut ocp = everything();
    let (trajectory, mut lin, closure) = random_point(0);
    lin.end[4] = f64::NAN;
    for form in [ProgramForm::Sparse, ProgramForm::Condensed { block: 100 }] {
        let mut qp = Qp::new(&ocp, STEPS, &closure, settings(form, 1e-8));
        qp.assemble(&mut ocp, 0, &trajectory, &lin, 0.0);
        assert_eq!(qp.solve().unwrap(), QpStatus::NotANumber);
    }
}
