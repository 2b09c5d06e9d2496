//! What the real-time iteration allocates: nothing; with Clarabel, what its own update and solution do.
//! A program of its own, because its global allocator counts.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

#[path = "main/common/mod.rs"]
#[allow(dead_code)]
mod common;

use allocation_counter::measure;
use bracketry_mpc::controller::StepStatus;
use bracketry_mpc::ocp::{Bounds, Softness, Substeps};
use bracketry_mpc::qp::ProgramForm;
use bracketry_mpc::{
    ControlProblem, CostFunction, CostKind, Ocp, PlannedTrajectory, Rti, RtiSettings, SymbolicDynamics, TerminalTarget,
};
use bracketry_system::System;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, SupportedConeT};
use std::f64::consts::PI;

const X0: [f64; 4] = [0.0, PI, 0.0, 0.0];

/// Allocations of Clarabel alone: one update and solution of a program with two variables and two inequalities.
fn clarabel_alone() -> u64 {
    let p = CscMatrix::identity(2);
    let a = CscMatrix::identity(2);
    let cones = [SupportedConeT::NonnegativeConeT(2)];
    let settings = DefaultSettingsBuilder::default().verbose(false).presolve_enable(false).build().unwrap();
    let mut solver = DefaultSolver::new(&p, &[1.0, -3.0], &a, &[1.0, 2.0], &cones, settings).unwrap();
    solver.solve();
    let (q, b) = (vec![-1.0, -2.0], vec![1.5, 1.0]);
    measure(|| {
        solver.update_data(&p.nzval, &q, &a.nzval, &b).unwrap();
        solver.solve();
    })
    .count_total
}

/// Swing-up of a cart-pole with soft bounds, a target, references and a cost whose Hessian has to be convexified.
fn swing_up() -> (System, Ocp) {
    let system = common::cart_pole();
    let names = ["p_ref"];
    let mut ocp = Ocp::new(4, 1, 40, 0.02);
    ocp.substeps = Substeps::Fixed(1);
    ocp.stage = Some(
        CostFunction::parse(
            &system,
            CostKind::Stage,
            &names,
            "1e3*(p - p_ref)^2 + 1e3*(1 - cos(th)) + 1e-2*(v*w)^2 + 1e-2*u^2",
        )
        .unwrap(),
    );
    ocp.references = vec![vec![0.1]];
    ocp.terminal = Some(CostFunction::parse(&system, CostKind::Terminal, &names, "1e3*(p - p_ref)^2 + v^2").unwrap());
    ocp.input_bounds = vec![(-80.0, 80.0)];
    ocp.state_bounds[0] = Bounds { min: -2.0, max: 2.0, softness: Softness::Soft { linear: 1e3, quadratic: 1e2 } };
    ocp.targets = vec![TerminalTarget { state: 2, value: 0.0, linear: 1.0, quadratic: 1.0 }];
    (system, ocp)
}

/// Largest numbers of allocations in preparation, feedback and shift over some samples, the first left out.
fn largest(settings: RtiSettings, programs: u64) -> (u64, u64, u64) {
    let (system, ocp) = swing_up();
    let dynamics = Box::new(SymbolicDynamics::new(&system).unwrap());
    let mut rti = Rti::new(dynamics, ocp, PlannedTrajectory::constant(40, &X0, &[0.0]), settings).unwrap();
    let mut x = X0;
    let mut worst = (0, 0, 0);
    for k in 0..12 {
        let prepare = measure(|| rti.prepare().unwrap()).count_total;
        let mut status = None;
        // Every fourth measurement is lost: the failure policy at work.
        let y = if k % 4 == 3 { [f64::NAN; 4] } else { x };
        let feedback = measure(|| status = Some(rti.feedback(&y).unwrap().status)).count_total;
        let shift = measure(|| rti.shift()).count_total;
        assert_eq!(matches!(status.unwrap(), StepStatus::Fallback(_)), k % 4 == 3);
        if k > 0 {
            worst = (worst.0.max(prepare), worst.1.max(feedback.div_ceil(programs)), worst.2.max(shift));
        }
        x.copy_from_slice(rti.trajectory().x(0));
        x[1] += 1e-3;
    }
    worst
}

#[test]
fn a_sample_allocates_nothing() {
    assert_eq!(largest(RtiSettings::default(), 1), (0, 0, 0));
}

#[test]
fn a_sample_on_clarabel_allocates_what_clarabel_does() {
    let mut settings = RtiSettings::default();
    settings.qp.form = ProgramForm::Condensed { block: 4 };
    assert_eq!(largest(settings, 1), (0, clarabel_alone(), 0));
}

#[test]
fn the_guarded_step_allocates_no_more() {
    let settings = RtiSettings { guarded: true, proximal: 0.1, ..RtiSettings::default() };
    assert_eq!(largest(settings, 1), (0, 0, 0));
}

#[test]
fn several_iterations_allocate_nothing() {
    let settings = RtiSettings { iterations: 3, ..RtiSettings::default() };
    assert_eq!(largest(settings, 3), (0, 0, 0));
}

/// A live controller adds nothing, whatever is measured, nor do the rows of a reference that never ends.
#[test]
fn a_live_controller_allocates_no_more() {
    let model = "states = ['x', 'v']\ninputs = ['a']\ndynamics = { x = 'v', v = 'a' }\n";
    let problem = "model = 'mass.toml'\nhorizon = { steps = 20, dt = 0.1 }\nreferences = { r = 0.5 }\n\
        cost = { stage = '(x - r)^2 + 0.1*v^2 + 0.01*a^2' }\nconstraints = { a = { min = -1, max = 1 } }\n\
        solve = { method = 'rti' }\nrun = { x0 = { x = 1 } }\n";
    let problem =
        ControlProblem::parse("problem.toml", problem, |f| System::parse(f, model).map_err(Box::new)).unwrap();
    let mut controller = problem.controller().unwrap();
    controller.keep_log(8);
    for k in 0..40 {
        let prepare = measure(|| controller.prepare().unwrap()).count_total;
        let y = if k % 4 == 3 { [f64::NAN; 2] } else { [1.0 - 0.01 * f64::from(k), 0.0] };
        let feedback = measure(|| controller.feedback(&y).map(|_| ()).unwrap()).count_total;
        if k > 9 {
            assert!(prepare == 0 && feedback == 0, "sample {k}: {prepare} before, {feedback} after the measurement");
        }
    }
}

/// Largest numbers of allocations before and after the measurement over some samples of a live controller of a mass under friction
/// `c*sign(v)`, the first ones left out.
fn of_live(friction: &str, rest: &str) -> (u64, u64) {
    let model = format!(
        "states = ['x', 'v']\ninputs = ['a']\ndynamics = {{ x = 'v', v = 'a - {friction}' }}\noutputs = {{ y = 'x' }}\n"
    );
    let problem = format!(
        "model = 'mass.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = 'x^2 + 0.1*v^2 + 0.01*a^2' }}\n\
         constraints = {{ a = {{ min = -1, max = 1 }} }}\nrun = {{ x0 = {{ x = 1 }} }}\n{rest}"
    );
    let problem =
        ControlProblem::parse("problem.toml", &problem, |f| System::parse(f, &model).map_err(Box::new)).unwrap();
    let mut controller = problem.controller().unwrap();
    let mut y = vec![0.0; controller.measured().len()];
    let mut worst = (0, 0);
    for k in 0..40 {
        y[0] = 1.0 - 0.01 * f64::from(k);
        let prepare = measure(|| controller.prepare().unwrap()).count_total;
        let feedback = measure(|| controller.feedback(&y).map(|_| ()).unwrap()).count_total;
        if k > 9 {
            worst = (worst.0.max(prepare), worst.1.max(feedback));
        }
    }
    worst
}

/// What the other methods and the estimators allocate at a sample, as docs/live.md states it: nothing before the measurement, and
/// after it at most so many times.
#[test]
fn the_other_methods_and_the_estimators_allocate_what_the_guide_states() {
    let smooth = "0.1*v";
    let ekf = "solve = { method = 'rti' }\nestimation = { kind = 'ekf', outputs = { y = 0.01 } }\n";
    let mhe = "solve = { method = 'rti' }\nestimation = { kind = 'mhe', outputs = { y = 0.01 }, horizon = 10 }\n";
    for (name, friction, rest, most) in [
        ("rti with ekf", smooth, ekf, 0),
        ("rti with mhe", smooth, mhe, 6),
        ("sqp", smooth, "solve = { method = 'sqp' }\n", 0),
        ("stick-slip", "0.1*sign(v)", "solve = { method = 'stick-slip' }\n", 60),
    ] {
        let (prepare, feedback) = of_live(friction, rest);
        println!("{name}: {feedback}");
        assert!(prepare == 0 && feedback <= most, "{name}: {prepare} before, {feedback} after the measurement");
    }
}
