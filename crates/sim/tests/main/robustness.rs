//! Order, agreement with an independent integrator, and honest ends where a solution ends.

use bracketry_sim::{
    Closures, FrictionMode, Outcome, SimError, SimulationSettings, Stepper, StopReason, Switched, simulate,
};
use proptest::prelude::*;

fn smooth<F: FnMut(f64, &[f64], &[f64], &mut [f64])>(dim: usize, rhs: F) -> impl Switched {
    Closures {
        dim,
        switches: 0,
        rhs,
        switching: |_t, _x: &[f64], _s: &mut [f64]| {},
        gradient: |_t, _x: &[f64], _g: &mut [f64], _dt: &mut [f64]| {},
    }
}

#[test]
fn the_error_falls_with_the_fifth_power_of_the_step() {
    let error = |h: f64| {
        let pendulum = smooth(2, |_t, x: &[f64], _s: &[f64], dx: &mut [f64]| {
            dx[0] = x[1];
            dx[1] = -x[0];
        });
        let settings = SimulationSettings::default().with_tolerance(1.0, 1.0).with_max_step(h);
        let run = simulate(pendulum, 0.0, &[1.0, 0.0], 8.0, &settings).unwrap();
        let x = run.trajectory.final_state();
        (x[0] - 8.0f64.cos()).hypot(x[1] + 8.0f64.sin())
    };
    let order = (error(0.2) / error(0.1)).log2();
    assert!((order - 5.0).abs() < 0.35, "{order}");
}

#[test]
fn dense_output_agrees_with_the_solution_between_steps() {
    let run = simulate(
        smooth(2, |_t, x: &[f64], _s: &[f64], dx: &mut [f64]| {
            dx[0] = x[1];
            dx[1] = -x[0];
        }),
        0.0,
        &[1.0, 0.0],
        20.0,
        &SimulationSettings::default().with_tolerance(1e-10, 1e-12),
    )
    .unwrap();
    for i in 0..=2000 {
        let t = 0.01 * f64::from(i);
        assert!((run.trajectory.sample(t)[0] - t.cos()).abs() < 1e-8);
    }
    let times: Vec<f64> = run.trajectory.times().collect();
    assert_eq!((times[0], *times.last().unwrap()), (0.0, 20.0));
    assert!(times.windows(2).all(|w| w[0] < w[1]));
}

#[test]
fn events_keep_the_tolerance() {
    // Tolerances a thousand times tighter move the end by less than the looser tolerance.
    let end = |rtol: f64| {
        let system = Closures {
            dim: 2,
            switches: 1,
            rhs: |t: f64, x: &[f64], s: &[f64], dx: &mut [f64]| {
                dx[0] = x[1];
                dx[1] = 3.0 * (4.0 * t).sin() - x[0] - s[0];
            },
            switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[1],
            gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[1] = 1.0,
        };
        let settings = SimulationSettings::default().with_tolerance(rtol, rtol * 0.1);
        simulate(system, 0.0, &[0.0, 0.0], 30.0, &settings).unwrap().trajectory.final_state().to_vec()
    };
    let (reference, coarse, fine) = (end(1e-12), end(1e-6), end(1e-9));
    assert!((coarse[0] - reference[0]).abs() < 1e-5);
    assert!((fine[0] - reference[0]).abs() < 1e-8);
}

#[test]
fn blow_up_ends_with_time_and_state() {
    let system = smooth(1, |_t, x: &[f64], _s: &[f64], dx: &mut [f64]| {
        dx[0] = x[0] * x[0];
    });
    let run = simulate(system, 0.0, &[1.0], 2.0, &SimulationSettings::default()).unwrap();
    let Outcome::Stopped { reason, t, state } = run.outcome else { panic!("x' = x² ends at t = 1") };
    assert!(matches!(reason, StopReason::StepTooSmall | StopReason::NonFinite));
    assert!((t - 1.0).abs() < 1e-6 && state[0] > 1e6 && state[0].is_finite());
    assert_eq!(run.trajectory.end(), t);
}

#[test]
fn not_a_number_is_reported_where_it_arises() {
    let root = || {
        smooth(1, |t: f64, _x: &[f64], _s: &[f64], dx: &mut [f64]| {
            dx[0] = (1.0 - t).sqrt();
        })
    };
    let run = simulate(root(), 0.0, &[0.0], 2.0, &SimulationSettings::default()).unwrap();
    let Outcome::Stopped { reason, t, state } = run.outcome else { panic!("√(1−t) ends at 1") };
    assert_eq!(reason, StopReason::NonFinite);
    assert!((t - 1.0).abs() < 1e-6 && (state[0] - 2.0 / 3.0).abs() < 1e-6);
    let run = simulate(root(), 0.0, &[f64::NAN], 0.5, &SimulationSettings::default()).unwrap();
    assert!(matches!(run.outcome, Outcome::Stopped { reason: StopReason::NonFinite, t: 0.0, .. }));
}

/// Filippov's spiral: `x' = −sgn x + 2 sgn y`, `y' = −2 sgn x − sgn y` reaches the origin after infinitely many switchings.
fn spiral() -> impl Switched {
    Closures {
        dim: 2,
        switches: 2,
        rhs: |_t, _x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = -s[0] + 2.0 * s[1];
            dx[1] = -2.0 * s[0] - s[1];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(x),
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            g.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
        },
    }
}

#[test]
fn infinitely_many_switchings_are_passed_or_stopped_by_the_guard() {
    // The axes are met at distances 1, 1/3, 1/9, …: the origin at t = 1/3 + 1/9 + … = 1/2.
    let run = simulate(spiral(), 0.0, &[1.0, 0.0], 3.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    assert!(run.trajectory.final_state().iter().all(|x| x.abs() < 1e-10));
    assert_eq!(run.trajectory.mode(0, 3.0), Some(FrictionMode::Sticking));
    assert_eq!(run.trajectory.mode(1, 3.0), Some(FrictionMode::Sticking));
    let last = run.trajectory.mode_changes().last().unwrap();
    assert!((last.t - 0.5).abs() < 1e-9);
    let guarded = SimulationSettings::default().with_event_limit(12, 0.1);
    let run = simulate(spiral(), 0.0, &[1.0, 0.0], 3.0, &guarded).unwrap();
    let Outcome::Stopped { reason, t, .. } = run.outcome else { panic!("the guard must stop it") };
    assert_eq!(reason, StopReason::TooManyEvents { limit: 12, window: 0.1 });
    assert!(t < 0.5);
}

#[test]
fn a_switch_that_nothing_can_hold_passes_through() {
    // |x| written as s·x: no force depends on the sign at zero.
    let system = Closures {
        dim: 2,
        switches: 1,
        rhs: |_t, x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = x[1];
            dx[1] = -s[0] * x[0] * x[0];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
    };
    let run = simulate(system, 0.0, &[0.5, 0.0], 40.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished());
    let energy = |x: &[f64]| 0.5 * x[1] * x[1] + x[0].abs().powi(3) / 3.0;
    assert!((energy(run.trajectory.final_state()) - energy(&[0.5, 0.0])).abs() < 1e-9);
    assert!(run.trajectory.mode_changes().len() > 5);
    assert!(run.trajectory.mode_changes().iter().all(|e| e.to != FrictionMode::Sticking));
}

#[test]
fn a_grazing_contact_with_zero_is_no_event_and_a_crossing_by_a_hair_is_two() {
    // σ = x with x = (t − 1)² + gap: the sign never matters to the motion.
    let transitions = |gap: f64| {
        let system = Closures {
            dim: 2,
            switches: 1,
            rhs: |_t, x: &[f64], s: &[f64], dx: &mut [f64]| {
                dx[0] = x[1];
                dx[1] = 2.0 + 0.0 * s[0];
            },
            switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
            gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
        };
        let run = simulate(system, 0.0, &[1.0 + gap, -2.0], 5.0, &SimulationSettings::default()).unwrap();
        assert!(run.outcome.is_finished());
        assert!((run.trajectory.final_state()[0] - 16.0 - gap).abs() < 1e-9);
        run.trajectory.mode_changes().iter().map(|e| e.t).collect::<Vec<_>>()
    };
    assert!(transitions(1e-9).is_empty());
    let crossings = transitions(-1e-8);
    assert_eq!(crossings.len(), 2);
    assert!((crossings[0] - (1.0 - 1e-4)).abs() < 1e-9 && (crossings[1] - (1.0 + 1e-4)).abs() < 1e-9);
}

#[test]
fn many_blocks_that_stop_together_are_settled_without_enumeration() {
    let n = 20;
    let system = Closures {
        dim: n,
        switches: n,
        rhs: |_t, _x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx.iter_mut().zip(s).for_each(|(d, s)| *d = -s);
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(x),
        gradient: move |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            (0..n).for_each(|i| g[i * n + i] = 1.0);
        },
    };
    let run = simulate(system, 0.0, &vec![1.0; n], 2.0, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    assert!(run.trajectory.final_state().iter().all(|&v| v == 0.0));
}

#[test]
fn misuse_is_an_error() {
    let system = || smooth(2, |_t, _x: &[f64], _s: &[f64], dx: &mut [f64]| dx.fill(0.0));
    let settings = SimulationSettings::default();
    assert_eq!(
        simulate(system(), 0.0, &[1.0], 1.0, &settings).unwrap_err(),
        SimError::WrongLength { what: "the state", expected: 2, found: 1 }
    );
    assert!(matches!(simulate(system(), 1.0, &[0.0; 2], 0.0, &settings), Err(SimError::BadTimeSpan { .. })));
    let bad = SimulationSettings::default().with_tolerance(0.0, 1e-9);
    assert!(matches!(simulate(system(), 0.0, &[0.0; 2], 1.0, &bad), Err(SimError::BadSetting { name: "rtol", .. })));
}

/// Two coupled oscillators with friction between each other and the ground.
fn pair(mu: [f64; 2], drive: [f64; 2], omega: f64) -> impl Switched {
    Closures {
        dim: 4,
        switches: 2,
        rhs: move |t: f64, x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = x[2];
            dx[1] = x[3];
            dx[2] = drive[0] * (omega * t).sin() - 5.0 * (x[0] - x[1]) - mu[0] * s[0];
            dx[3] = drive[1] * (omega * t).cos() + 5.0 * (x[0] - x[1]) - mu[1] * s[1];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(&x[2..]),
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            g[2] = 1.0;
            g[7] = 1.0;
        },
    }
}

/// The same by velocity time stepping with the set-valued force chosen in closed form at every step of 10 µs.
fn pair_fixed_step(mu: [f64; 2], drive: [f64; 2], omega: f64, t_end: f64) -> [f64; 4] {
    let dt = 1e-5;
    let mut x = [0.0f64; 4];
    for i in 0..(t_end / dt).round() as usize {
        let t = (i as f64 + 0.5) * dt;
        let spring = 5.0 * (x[0] - x[1]);
        let force = [drive[0] * (omega * t).sin() - spring, drive[1] * (omega * t).cos() + spring];
        for b in 0..2 {
            let free = x[2 + b] + dt * force[b];
            let after = free.signum() * (free.abs() - dt * mu[b]).max(0.0);
            x[b] += 0.5 * dt * (x[2 + b] + after);
            x[2 + b] = after;
        }
    }
    x
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn agrees_with_a_fixed_step_integrator(
        mu in [0.1..3.0f64, 0.1..3.0f64],
        drive in [0.5..6.0f64, 0.5..6.0f64],
        omega in 1.0..12.0f64,
    ) {
        let run = simulate(pair(mu, drive, omega), 0.0, &[0.0; 4], 2.0, &SimulationSettings::default()).unwrap();
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        let reference = pair_fixed_step(mu, drive, omega, 2.0);
        for (x, r) in run.trajectory.final_state().iter().zip(reference) {
            prop_assert!((x - r).abs() < 2e-4, "{:?} {:?}", run.trajectory.final_state(), reference);
        }
    }

    #[test]
    fn stepping_in_samples_gives_the_same_end(
        mu in [0.1..3.0f64, 0.1..3.0f64],
        drive in [0.5..6.0f64, 0.5..6.0f64],
        omega in 1.0..12.0f64,
    ) {
        let settings = SimulationSettings::default();
        let whole = simulate(pair(mu, drive, omega), 0.0, &[0.0; 4], 1.0, &settings).unwrap();
        let mut stepper = Stepper::new(pair(mu, drive, omega), 0.0, &[0.0; 4], &settings).unwrap();
        for i in 1..=100 {
            let outcome = stepper.advance(0.01 * f64::from(i));
            prop_assert!(outcome.is_finished(), "{outcome:?}");
        }
        for (x, r) in stepper.state().iter().zip(whole.trajectory.final_state()) {
            prop_assert!((x - r).abs() < 1e-8);
        }
    }
}

/// A stack of four blocks on the ground, each driven, with friction in every joint: `σ_j = v_j − v_{j−1}`.
#[derive(Debug, Clone)]
struct Stack {
    mass: [f64; 4],
    friction: [f64; 4],
    drive: [f64; 4],
    omega: [f64; 4],
}

impl Stack {
    fn force(&self, i: usize, t: f64) -> f64 {
        self.drive[i] * (self.omega[i] * t).sin()
    }

    /// Time stepping with the joint impulses `|λ_j| ≤ dt F_j` by projected Gauss–Seidel iteration, independent of modes.
    fn fixed_step(&self, t_end: f64, dt: f64) -> [f64; 4] {
        let (mut v, mut impulse) = ([0.0f64; 4], [0.0f64; 4]);
        for step in 0..(t_end / dt).round() as usize {
            let t = (step as f64 + 0.5) * dt;
            for i in 0..4 {
                v[i] += dt * self.force(i, t) / self.mass[i];
                // Start from the last step's impulses.
                v[i] -= impulse[i] / self.mass[i];
                if i > 0 {
                    v[i - 1] += impulse[i] / self.mass[i - 1];
                }
            }
            for _ in 0..400 {
                let mut change = 0.0f64;
                for j in 0..4 {
                    let below = if j > 0 { v[j - 1] } else { 0.0 };
                    let inverse = 1.0 / self.mass[j] + if j > 0 { 1.0 / self.mass[j - 1] } else { 0.0 };
                    let limit = dt * self.friction[j];
                    let next = (impulse[j] + (v[j] - below) / inverse).clamp(-limit, limit);
                    let delta = next - impulse[j];
                    impulse[j] = next;
                    v[j] -= delta / self.mass[j];
                    if j > 0 {
                        v[j - 1] += delta / self.mass[j - 1];
                    }
                    change = change.max(delta.abs());
                }
                if change < 1e-13 {
                    break;
                }
            }
        }
        v
    }
}

impl Switched for Stack {
    fn dim(&self) -> usize {
        4
    }
    fn switches(&self) -> usize {
        4
    }
    fn rhs(&mut self, t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]) {
        for i in 0..4 {
            let above = if i < 3 { self.friction[i + 1] * s[i + 1] } else { 0.0 };
            dx[i] = (self.force(i, t) - self.friction[i] * s[i] + above) / self.mass[i];
        }
    }
    fn switching(&mut self, _t: f64, x: &[f64], sigma: &mut [f64]) {
        for j in 0..4 {
            sigma[j] = x[j] - if j > 0 { x[j - 1] } else { 0.0 };
        }
    }
    fn switching_gradient(&mut self, _t: f64, _x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
        gradient.fill(0.0);
        partial_t.fill(0.0);
        for j in 0..4 {
            gradient[4 * j + j] = 1.0;
            if j > 0 {
                gradient[4 * j + j - 1] = -1.0;
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_stack_of_blocks_agrees_with_impulse_time_stepping(
        mass in [0.3..3.0f64, 0.3..3.0f64, 0.3..3.0f64, 0.3..3.0f64],
        friction in [0.2..4.0f64, 0.2..4.0f64, 0.2..4.0f64, 0.2..4.0f64],
        drive in [0.0..6.0f64, 0.0..6.0f64, 0.0..6.0f64, 0.0..6.0f64],
        omega in [1.0..15.0f64, 1.0..15.0f64, 1.0..15.0f64, 1.0..15.0f64],
    ) {
        let stack = Stack { mass, friction, drive, omega };
        let run = simulate(stack.clone(), 0.0, &[0.0; 4], 2.0, &SimulationSettings::default()).unwrap();
        prop_assert!(run.outcome.is_finished(), "{:?}", run.outcome);
        let reference = stack.fixed_step(2.0, 5e-5);
        for (v, r) in run.trajectory.final_state().iter().zip(reference) {
            prop_assert!((v - r).abs() < 2e-3, "{:?} {:?}", run.trajectory.final_state(), reference);
        }
        // Modes and velocities tell the same: a sticking joint has no relative velocity, a sliding one its own sign.
        for i in 0..200 {
            let t = 0.01 * f64::from(i) + 0.005;
            let v = run.trajectory.sample(t);
            for j in 0..4 {
                let relative = v[j] - if j > 0 { v[j - 1] } else { 0.0 };
                match run.trajectory.mode(j, t).unwrap() {
                    FrictionMode::Sticking => prop_assert!(relative.abs() < 1e-12, "joint {j} at {t}: {relative}"),
                    sliding => prop_assert!(sliding.sign() * relative > -1e-12, "joint {j} at {t}: {relative}"),
                }
            }
        }
    }
}
