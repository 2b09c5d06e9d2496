//! Random programs of every shape that the method takes, against Clarabel on the same program as it stands.
#![allow(clippy::unwrap_used)]

use super::super::backend::{QpBackend, QpSettings, QpStatus, StageSolution};
use super::super::clarabel::Clarabel;
use super::super::program::{Side, StageProgram};
use super::Stagewise;
use rand::{RngExt, SeedableRng, rngs::StdRng};

/// A function to be bounded: grid point, entries among (x, u), whether both sides, and what a slack costs (slope, curvature).
struct Bounded {
    k: usize,
    entries: Vec<(usize, f64)>,
    both: bool,
    slack: Option<(f64, f64)>,
}

fn random_functions(random: &mut StdRng, (n, m, steps): (usize, usize, usize)) -> Vec<Bounded> {
    let mut all = Vec::new();
    for k in 0..=steps {
        for _ in 0..random.random_range(0..4) {
            let range = if k == 0 { n..n + m } else { 0..if k < steps { n + m } else { n } };
            let share = if random.random_bool(0.5) { 0.0 } else { 0.5 };
            let one = random.random_range(range.clone());
            let mut entry = |v| (v == one || random.random_bool(share)).then(|| (v, random.random_range(-1.0..1.0)));
            let mut entries: Vec<(usize, f64)> = range.filter_map(&mut entry).collect();
            let slack = random.random_bool(0.6).then(|| (random.random_range(0.0..3.0), random.random_range(0.0..2.0)));
            // A constraint on the first state bounds nothing that can move.
            if slack.is_some() && random.random_bool(0.1) {
                entries.clear();
            }
            all.push(Bounded { k, entries, both: random.random_bool(0.5), slack });
        }
    }
    all
}

/// A program that a point fulfills, with its flow.
fn random_program(random: &mut StdRng, (n, m, steps): (usize, usize, usize)) -> (StageProgram, Vec<f64>) {
    let w = n + m;
    let functions = random_functions(random, (n, m, steps));
    let mut p =
        StageProgram { states: n, inputs: m, steps, flow_pattern: vec![true; n * w], ..StageProgram::default() };
    p.slacks = vec![0; steps + 1];
    functions.iter().filter(|f| f.slack.is_some()).for_each(|f| p.slacks[f.k] += 1);
    p.first = vec![0; steps + 1];
    for k in 1..=steps {
        p.first[k] = p.first[k - 1] + p.slacks[k - 1] + m + if k > 1 { n } else { 0 };
    }
    let variables = p.first[steps] + p.slacks[steps] + n;
    let mut number = |_| random.random_range(-1.0..1.0);
    p.gradient = (0..variables).map(&mut number).collect();
    p.defect = (0..steps * n).map(&mut number).collect();
    let flow: Vec<f64> = (0..steps * n * w).map(|i| 0.9 * number(i)).collect();
    p.block_start = (0..steps * m).map(|i| i / m).collect();
    p.shared_with = (0..steps * m).map(|i| i % m).collect();
    p.offset = vec![0.0; steps * m];
    p.hessian_places = (0..variables).map(|v| (v, v)).collect();
    p.hessian = vec![0.0; variables];
    p.objective_scale = 1.0;
    for k in 0..=steps {
        let places: Vec<usize> = (0..if k < steps { w } else { n }).filter_map(|v| p.variable(k, v)).collect();
        for &v in &places {
            p.hessian[v] += 0.2;
        }
        let squares: Vec<Vec<f64>> = (0..random.random_range(0..3))
            .map(|_| places.iter().map(|_| random.random_range(-1.0..1.0)).collect())
            .collect();
        for a in 0..places.len() {
            for b in (a..places.len()).filter(|_| !squares.is_empty()) {
                let sum: f64 = squares.iter().map(|square: &Vec<f64>| square[a] * square[b]).sum();
                if a == b {
                    p.hessian[places[a]] += sum;
                } else {
                    p.hessian_places.push((places[a].min(places[b]), places[a].max(places[b])));
                    p.hessian.push(sum);
                }
            }
        }
    }
    // A point that obeys the dynamics; every function without a slack is fulfilled there.
    let mut z = vec![0.0; variables];
    let mut x = vec![0.0; n];
    for k in 0..steps {
        let u: Vec<f64> = (0..m).map(|_| random.random_range(-1.0..1.0)).collect();
        let xu: Vec<f64> = x.iter().chain(&u).copied().collect();
        x = (0..n)
            .map(|i| p.defect[k * n + i] + (0..w).map(|v| flow[(k * n + i) * w + v] * xu[v]).sum::<f64>())
            .collect();
        z[p.input(k, 0)..][..m].copy_from_slice(&u);
        z[p.state(k + 1, 0)..][..n].copy_from_slice(&x);
    }
    let mut slacks = vec![0; steps + 1];
    for f in &functions {
        let value: f64 = f.entries.iter().map(|&(v, a)| a * z[p.variable(f.k, v).unwrap()]).sum();
        let slack = f.slack.map(|_| {
            slacks[f.k] += 1;
            p.slack(f.k, slacks[f.k] - 1)
        });
        let mut first = None;
        for sign in if f.both { &[1.0, -1.0][..] } else { &[1.0] } {
            let row = p.right.len();
            let room = if slack.is_some() { random.random_range(-0.5..0.5) } else { random.random_range(0.0..0.5) };
            p.right.push(sign * value + room);
            p.row_stage.push(f.k);
            p.sides.push(first.map_or(Side::First, Side::OppositeOf));
            first = first.or(Some(row));
            for &(v, a) in &f.entries {
                p.row_places.push((row, p.variable(f.k, v).unwrap()));
                p.rows.push(sign * a);
            }
            if let Some(s) = slack {
                p.row_places.push((row, s));
                p.rows.push(-1.0);
            }
        }
        if let (Some(s), Some((linear, quadratic))) = (slack, f.slack) {
            p.gradient[s] = linear;
            p.hessian[s] = quadratic + SLACK_CURVATURE;
            p.row_places.push((p.right.len(), s));
            p.rows.push(-1.0);
            p.right.push(0.0);
            p.row_stage.push(f.k);
            p.sides.push(Side::SlackBound);
        }
    }
    p.nonnegative = p.right.len();
    p.scale = vec![1.0; variables];
    p.row_scale = vec![1.0; p.right.len()];
    (p, flow)
}

fn solution_of(backend: &mut dyn QpBackend, program: &StageProgram, flow: &[f64]) -> (QpStatus, StageSolution) {
    let mut solution = StageSolution {
        z: vec![0.0; program.variables()],
        multipliers: vec![0.0; program.steps * program.states],
        ..StageSolution::default()
    };
    backend.load(program, flow);
    let status = backend.solve(program, &mut solution).unwrap();
    (status, solution)
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn objective(program: &StageProgram, z: &[f64]) -> f64 {
    let quadratic = program.hessian().map(|((i, j), h)| h * z[i] * z[j] * if i == j { 0.5 } else { 1.0 });
    quadratic.sum::<f64>() + program.gradient().iter().zip(z).map(|(g, z)| g * z).sum::<f64>()
}

/// Largest violation of the dynamics, and of Hz + g + Rᵀv + Eᵀy = 0 relative to what is added there.
fn residuals(program: &StageProgram, flow: &[f64], of: &StageSolution) -> (f64, f64) {
    let (n, w) = (program.states, program.states + program.inputs);
    let z = &of.z;
    let mut slope = program.gradient.clone();
    let mut terms: Vec<f64> = slope.iter().map(|g| 1.0 + g.abs()).collect();
    let mut add = |v: usize, a: f64| {
        slope[v] += a;
        terms[v] += a.abs();
    };
    for ((i, j), h) in program.hessian() {
        add(i, h * z[j]);
        if i != j {
            add(j, h * z[i]);
        }
    }
    program.rows().for_each(|((row, v), r)| add(v, r * of.row_multipliers[row]));
    let mut worst = 0.0_f64;
    for (row, flow) in flow.chunks_exact(w).enumerate() {
        let (k, i) = (row / n, row % n);
        let mut residual = z[program.state(k + 1, i)] - program.defect[row];
        add(program.state(k + 1, i), of.multipliers[row]);
        for (v, a) in flow.iter().enumerate().filter_map(|(v, a)| Some((program.variable(k, v)?, a))) {
            residual -= a * z[v];
            add(v, -a * of.multipliers[row]);
        }
        worst = worst.max(residual.abs());
    }
    (worst, slope.iter().zip(&terms).map(|(s, t)| (s / t).abs()).fold(0.0, f64::max))
}

/// Curvature that every slack has at least.
const SLACK_CURVATURE: f64 = 1e-3;

const SETTINGS: QpSettings = QpSettings {
    form: super::super::backend::ProgramForm::Sparse,
    max_iterations: 100,
    tolerance: 1e-12,
    refine: true,
    equilibrate: false,
    time_limit: f64::INFINITY,
    hard_weight: 1e4,
};

/// Programs of the random tests; more with the full tier.
fn programs() -> u64 {
    if std::env::var_os("BRACKETRY_FULL_TESTS").is_some() { 5000 } else { 150 }
}

#[test]
fn random_programs_have_the_solution_that_clarabel_finds() {
    let (mut iterations, mut close) = (0, 0);
    for seed in 0..programs() {
        let mut random = StdRng::seed_from_u64(seed);
        let shape = (random.random_range(1..6), random.random_range(1..4), random.random_range(1..13));
        let (program, flow) = random_program(&mut random, shape);
        let (status, expected) = solution_of(&mut Clarabel::sparse(&program, SETTINGS), &program, &flow);
        assert!(status.is_usable(), "{seed}: {status:?}");
        let best = objective(&program, &expected.z);
        for length in [1, random.random_range(2..6), shape.2] {
            // The largest difference of the objectives relative to the larger of them and 1.
            for (tolerance, agreement) in [(1e-8, 3e-7), (1e-10, 1e-8)] {
                let settings = QpSettings { tolerance, ..SETTINGS };
                let mut stagewise = Stagewise::new(&program, settings, length).unwrap();
                let (status, found) = solution_of(&mut stagewise, &program, &flow);
                let context = format!("{seed} {shape:?} {length} {tolerance:e}");
                // Below its usual tolerance rounding may come first; it then says so.
                let solved = status == QpStatus::Solved;
                assert!(solved || tolerance < 1e-8, "{context}: {status:?}");
                if solved {
                    let error = (objective(&program, &found.z) - best).abs() / best.abs().max(1.0);
                    assert!(error < agreement, "{context}: {error:e}");
                    // The least curvature is that of a slack.
                    let steps = (2.0 * agreement * best.abs().max(1.0) / SLACK_CURVATURE).sqrt();
                    assert!(difference(&found.z, &expected.z) < steps, "{context}");
                    let (dynamics, slope) = residuals(&program, &flow, &found);
                    assert!(dynamics < 1e-9 && slope < 1e-6, "{context}: {dynamics:e} {slope:e}");
                    assert!(found.row_multipliers.iter().all(|v| *v >= 0.0), "{context}");
                    iterations += found.iterations;
                    close += usize::from(tolerance < 1e-8);
                }
            }
        }
    }
    let programs = 3 * programs() as usize;
    assert!(close * 100 > programs * 97, "{close} of {programs} to 1e-10");
    assert!((iterations as usize) < 12 * (programs + close), "{iterations} iterations");
}

#[test]
fn bounds_that_contradict_each_other_are_not_solved() {
    for seed in 0..40 {
        let mut random = StdRng::seed_from_u64(seed);
        let shape = (2, 2, 6);
        let (mut program, flow) = random_program(&mut random, shape);
        // An input below −1 and above 1.
        for (side, sign) in [(Side::First, 1.0), (Side::OppositeOf(program.right.len()), -1.0)] {
            program.row_places.push((program.right.len(), program.input(3, 1)));
            program.rows.push(sign);
            program.right.push(-1.0);
            program.row_stage.push(3);
            program.row_scale.push(1.0);
            program.sides.push(side);
        }
        program.nonnegative = program.right.len();
        let mut stagewise = Stagewise::new(&program, SETTINGS, 3).unwrap();
        let (status, _) = solution_of(&mut stagewise, &program, &flow);
        assert!(!status.is_usable(), "{seed}: {status:?}");
    }
}

#[test]
fn what_is_indefinite_on_the_dynamics_has_failed() {
    let mut random = StdRng::seed_from_u64(1);
    let (mut program, flow) = random_program(&mut random, (2, 1, 5));
    let u = program.input(4, 0);
    program.hessian[u] = -50.0;
    let mut stagewise = Stagewise::new(&program, SETTINGS, 2).unwrap();
    assert_eq!(solution_of(&mut stagewise, &program, &flow).0, QpStatus::Failed);
}
