//! The main job's claim: x, y and yaw arrive together on exact set-valued friction, and an integrator that knows nothing
//! of this project's simulator agrees.

use std::sync::OnceLock;

use bracketry::mpc::ControlProblem;
use bracketry::plate::control::Arrival;
use bracketry::plate::{Shape, plate_move};
use bracketry::sim::FrictionMode;
use bracketry::{Controlled, control};

const MU: f64 = 0.3;
const G: f64 = 9.81;

/// The move with 0.6 s of rest after it, computed once for all tests.
fn reference() -> &'static (ControlProblem, Controlled) {
    static RUN: OnceLock<(ControlProblem, Controlled)> = OnceLock::new();
    RUN.get_or_init(|| {
        let mut problem = plate_move(&Shape::REFERENCE_ELLIPSE, MU).unwrap();
        problem.samples += 30;
        let controlled = control(&problem).unwrap();
        (problem, controlled)
    })
}

#[test]
fn position_and_orientation_arrive_together_and_stay() {
    let (problem, controlled) = reference();
    let a = Arrival::of(problem, &controlled.recording.trajectory);
    assert!(a.x_m.abs() <= 2e-3 && a.y_m.abs() <= 2e-3, "{a:?}");
    assert!(a.phi_deg.abs() <= 2.0 && a.spin_deg_s.abs() <= 2.0, "{a:?}");
    assert!(a.settled_s.is_some_and(|t| t <= 3.0), "{a:?}");
    let end = controlled.recording.trajectory.final_state();
    assert!(end[6..].iter().all(|v| v.abs() < 1e-3), "the plate is back at rest: {:?}", &end[6..]);
}

#[test]
fn the_plate_keeps_pressing_on_the_object() {
    let (problem, controlled) = reference();
    assert_eq!(problem.ocp.path_constraints.len(), 1);
    let (x, u) = (&controlled.run.closed_loop.x, &controlled.run.closed_loop.u);
    let load = x.iter().zip(u).map(|(x, u)| G * x[8].cos() + x[1] * u[1]).fold(f64::INFINITY, f64::min);
    assert!(load > 0.29 * G, "{load}");
}

#[test]
fn every_bound_is_kept_between_the_samples_too() {
    let (problem, controlled) = reference();
    let a = Arrival::of(problem, &controlled.recording.trajectory);
    assert_eq!((a.stroke_excess_m, a.tilt_excess_deg), (0.0, 0.0), "{a:?}");
    for u in &controlled.run.closed_loop.u {
        assert!(u[0].abs() <= 15.0 && u[1].abs() <= 60.0, "{u:?}");
    }
}

#[test]
fn no_sample_falls_back_on_an_old_plan() {
    let (_, controlled) = reference();
    let c = controlled.run.report.status;
    assert_eq!((c.inaccurate, c.fallback), (0, 0));
}

#[test]
fn the_recording_is_what_the_loop_saw() {
    let (_, controlled) = reference();
    let run = &controlled.run.closed_loop;
    for (t, x) in run.t.iter().zip(&run.x) {
        let recorded = controlled.recording.trajectory.sample(*t);
        for (a, b) in x.iter().zip(&recorded) {
            assert!((a - b).abs() < 1e-6, "at {t} s: {x:?} against {recorded:?}");
        }
    }
}

#[test]
fn the_object_comes_to_rest_by_sticking_in_both_directions() {
    let (_, controlled) = reference();
    let end = controlled.recording.trajectory.end();
    for i in 0..2 {
        assert_eq!(controlled.recording.trajectory.mode(i, end), Some(FrictionMode::Sticking));
    }
}

/// Velocity after `dt` under dry friction of size `grip` per mass, implicit in the sign, and the sign itself.
fn dry(v: f64, push: f64, grip: f64, dt: f64) -> (f64, f64) {
    let free = v + dt * push;
    let v = free.signum() * (free.abs() - dt * grip).max(0.0);
    (v, (free - v) / (dt * grip))
}

/// The published equations by Moreau's time stepping at 10 µs, written by hand: x, y and yaw after each sample.
fn replay(problem: &ControlProblem, inputs: &[Vec<f64>]) -> Vec<[f64; 3]> {
    let mut poses = Vec::new();
    let (sa, sb) = (0.15f64.powi(2) / 4.0, 0.10f64.powi(2) / 4.0);
    let h = 1e-5;
    let steps = (problem.ocp.dt / h).round() as usize;
    let [mut x, mut y, mut phi] = [problem.x0[0], problem.x0[1], problem.x0[2]];
    let (mut vx, mut vy, mut w, mut theta, mut rate) = (0.0, 0.0, 0.0, 0.0f64, 0.0);
    for u in inputs {
        for _ in 0..steps {
            let (sin, load) = (f64::sin(phi), G * theta.cos() + y * u[1]);
            let (new_vx, sign) = dry(vx, -u[0], MU * G, h);
            let (new_vy, _) = dry(vy, -G * theta.sin(), MU * load, h);
            let syy = sin * sin * sa + (1.0 - sin * sin) * sb;
            let new_w = w - h * sign * MU * syy * u[1] / (sa + sb);
            x += 0.5 * h * (vx + new_vx);
            y += 0.5 * h * (vy + new_vy);
            phi += 0.5 * h * (w + new_w);
            theta += h * rate + 0.5 * h * h * u[1];
            rate += h * u[1];
            (vx, vy, w) = (new_vx, new_vy, new_w);
        }
        poses.push([x, y, phi]);
    }
    poses
}

#[test]
fn a_fixed_step_integrator_at_ten_microseconds_agrees() {
    let (problem, controlled) = reference();
    let run = &controlled.run.closed_loop;
    for (k, again) in replay(problem, &run.u).iter().enumerate() {
        let x = &run.x[k + 1];
        assert!((again[0] - x[0]).abs() <= 0.5e-3, "x {} against {} at {} s", again[0], x[0], run.t[k + 1]);
        assert!((again[1] - x[1]).abs() <= 0.5e-3, "y {} against {} at {} s", again[1], x[1], run.t[k + 1]);
        assert!((again[2] - x[2]).to_degrees().abs() <= 0.5, "yaw {} against {} at {} s", again[2], x[2], run.t[k + 1]);
    }
}
