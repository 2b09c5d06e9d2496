//! Dry friction with known answers: times of stopping and breaking loose, sticking forces, no creep.

use bracketry_sim::{Closures, FrictionMode, Simulation, SimulationSettings, Switched, simulate};

const G: f64 = 9.81;

/// A block `x' = v`, `v' = a(t) − μ g sgn(v)`.
fn block(mu: f64, a: impl Fn(f64) -> f64) -> impl Switched {
    Closures {
        dim: 2,
        switches: 1,
        rhs: move |t, x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = x[1];
            dx[1] = a(t) - mu * G * s[0];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[1],
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[1] = 1.0,
    }
}

fn run(system: impl Switched, x0: &[f64], t_end: f64) -> Simulation {
    let run = simulate(system, 0.0, x0, t_end, &SimulationSettings::default()).unwrap();
    assert!(run.outcome.is_finished(), "{:?}", run.outcome);
    run
}

/// Zero of `f` between `a` and `b` by bisection, independent of the crate.
fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    assert!(f(a) * f(b) < 0.0);
    for _ in 0..200 {
        let m = 0.5 * (a + b);
        if f(a) * f(m) <= 0.0 {
            b = m;
        } else {
            a = m;
        }
    }
    0.5 * (a + b)
}

#[test]
fn a_slide_stops_at_v_over_mu_g_and_stays() {
    for (mu, v0) in [(0.3, 1.0), (0.05, 3.7), (0.8, -0.2)] {
        let run = run(block(mu, |_| 0.0), &[0.2, v0], 20.0);
        let events = run.trajectory.mode_changes();
        assert_eq!(events.len(), 1);
        assert_eq!(events[0].to, FrictionMode::Sticking);
        assert!((events[0].t - v0.abs() / (mu * G)).abs() < 1e-10);
        let way = 0.2 + v0 * v0.abs() / (2.0 * mu * G);
        assert!((run.trajectory.final_state()[0] - way).abs() < 1e-9);
        assert_eq!(run.trajectory.final_state()[1], 0.0);
        assert_eq!(run.trajectory.sample(10.0)[1], 0.0);
        assert_eq!(run.trajectory.sample(10.0)[0], run.trajectory.final_state()[0]);
    }
}

#[test]
fn an_incline_holds_below_the_friction_angle_and_slides_above() {
    let mu = 0.3f64;
    let critical = mu.atan();
    for (angle, slides) in [(critical - 1e-6, false), (critical + 1e-6, true), (0.1, false), (0.6, true)] {
        let (sin, cos) = angle.sin_cos();
        let system = block(mu * cos, move |_| -G * sin);
        let run = run(system, &[0.0, 0.0], 3.0);
        let a = if slides { -G * sin + mu * G * cos } else { 0.0 };
        assert!((run.trajectory.final_state()[1] - a * 3.0).abs() < 1e-9);
        assert!((run.trajectory.final_state()[0] - a * 4.5).abs() < 1e-9);
        assert_eq!(
            run.trajectory.mode(0, 1.0),
            Some(if slides { FrictionMode::Negative } else { FrictionMode::Sticking })
        );
    }
}

#[test]
fn an_incline_stops_an_uphill_slide_and_lets_a_steep_one_return() {
    let (mu, v0) = (0.3, 2.0);
    for (angle, returns) in [(0.2f64, false), (0.5, true)] {
        let (sin, cos) = angle.sin_cos();
        let run = run(block(mu * cos, move |_| -G * sin), &[0.0, v0], 2.0);
        let stop = v0 / (G * (sin + mu * cos));
        let event = run.trajectory.mode_changes()[0];
        assert!((event.t - stop).abs() < 1e-10);
        assert_eq!(event.to, if returns { FrictionMode::Negative } else { FrictionMode::Sticking });
        let v = if returns { -G * (sin - mu * cos) * (2.0 - stop) } else { 0.0 };
        assert!((run.trajectory.final_state()[1] - v).abs() < 1e-9);
    }
}

#[test]
fn a_block_on_a_vibrating_base_switches_at_the_analytic_times() {
    // v' = A sin(ωt) − μ g sgn(v), from rest: breaks loose at asin(μg/A)/ω, slides until v = 0, then holds or passes.
    let (mu, a, omega) = (0.3, 4.5, 7.0);
    let f = mu * G;
    let t1 = (f / a).asin() / omega;
    let v = move |t: f64| a / omega * ((omega * t1).cos() - (omega * t).cos()) - f * (t - t1);
    let t2 = bisect(v, t1 + 0.1, t1 + 0.8);
    // Here the base's acceleration is too small to slide on: it sticks until A sin(ωt) = −μ g.
    assert!((a * (omega * t2).sin()).abs() < f);
    let t3 = (std::f64::consts::PI + (f / a).asin()) / omega;
    assert!(t3 > t2);
    let run = run(block(mu, move |t| a * (omega * t).sin()), &[0.0, 0.0], 0.95);
    let events = run.trajectory.mode_changes();
    let expected = [
        (t1, FrictionMode::Positive),
        (t2, FrictionMode::Sticking),
        (t3, FrictionMode::Negative),
        (t3 + t2 - t1, FrictionMode::Sticking),
    ];
    assert_eq!(events.len(), expected.len(), "{events:?}");
    for (event, (t, to)) in events.iter().zip(expected) {
        assert!((event.t - t).abs() < 1e-10, "{} {t}", event.t);
        assert_eq!(event.to, to);
    }
    let way = |t: f64| {
        a / omega * ((omega * t1).cos() * (t - t1) - ((omega * t).sin() - (omega * t1).sin()) / omega)
            - f * (t - t1) * (t - t1) / 2.0
    };
    assert!((run.trajectory.sample(0.5 * (t2 + t3))[0] - way(t2)).abs() < 1e-9);
    // The second slide undoes the first.
    assert!(run.trajectory.final_state()[0].abs() < 1e-9);
}

#[test]
fn strong_vibration_passes_through_zero_without_sticking() {
    let (mu, a, omega) = (0.1, 20.0, 80.0);
    let run = run(block(mu, move |t| a * (omega * t).sin()), &[0.0, 0.0], 80.0);
    let late: Vec<_> = run.trajectory.mode_changes().iter().filter(|e| e.t > 70.0).collect();
    assert!(late.len() > 20);
    assert!(late.iter().all(|e| e.to != FrictionMode::Sticking));
    // Steady state: reversals half a period apart.
    for pair in late.windows(2) {
        assert!((pair[1].t - pair[0].t - std::f64::consts::PI / omega).abs() < 1e-6);
    }
}

#[test]
fn the_shortest_excursion_of_the_sticking_force_is_found() {
    // The driving force exceeds the friction by one part in a hundred thousand, once per period of 1 ms.
    let omega = 2000.0 * std::f64::consts::PI;
    let f = 0.3 * G;
    let run = run(block(0.3, move |t| f * 1.00001 * (omega * t).sin()), &[0.0, 0.0], 1.0);
    let first = run.trajectory.mode_changes()[0];
    assert!((first.t - (1.0f64 / 1.00001).asin() / omega).abs() < 1e-10);
    let breaks = run.trajectory.mode_changes().iter().filter(|e| e.from == FrictionMode::Sticking).count();
    assert_eq!(breaks, 2000);
}

#[test]
fn nothing_creeps_on_a_tilted_plate_for_a_minute() {
    let (mu, tilt) = (0.3, 10.0f64.to_radians());
    // The object slides into its place first, and the plate trembles below the limit.
    let system = block(mu * tilt.cos(), move |t| -G * tilt.sin() + 0.5 * (50.0 * t).sin());
    let run = run(system, &[0.03, 0.1], 60.0);
    let stop = run.trajectory.mode_changes()[0].t;
    assert_eq!(run.trajectory.mode_changes().len(), 1);
    let place = run.trajectory.sample(stop)[0];
    assert!((run.trajectory.final_state()[0] - place).abs() <= 1e-12);
}

#[test]
fn two_blocks_that_stop_together_both_stick() {
    let mu = 0.25;
    let system = Closures {
        dim: 4,
        switches: 2,
        rhs: |_t, x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = x[2];
            dx[1] = x[3];
            dx[2] = -0.25 * G * s[0];
            dx[3] = -0.5 * G * s[1];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma.copy_from_slice(&x[2..]),
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            g[2] = 1.0;
            g[7] = 1.0;
        },
    };
    let run = run(system, &[0.0, 0.0, 1.0, -2.0], 2.0);
    let stop = 1.0 / (mu * G);
    let events = run.trajectory.mode_changes();
    assert_eq!(events.len(), 2);
    assert!(events.iter().all(|e| e.to == FrictionMode::Sticking && (e.t - stop).abs() < 1e-10));
    let x = run.trajectory.final_state();
    assert!((x[0] - stop / 2.0).abs() < 1e-9 && (x[1] + stop).abs() < 1e-9);
}

#[test]
fn a_pushed_stack_moves_together_until_the_push_exceeds_the_joint() {
    // Upper block (mass 1) on lower block (mass 2), floor friction; the lower one is pushed by p(t) = 4 t.
    let (mu_floor, mu_joint) = (0.1, 0.3);
    let system = Closures {
        dim: 2,
        switches: 2,
        rhs: move |t, _x: &[f64], s: &[f64], dx: &mut [f64]| {
            let (floor, joint) = (mu_floor * 3.0 * G * s[0], mu_joint * G * s[1]);
            dx[0] = (4.0 * t - floor - joint) / 2.0;
            dx[1] = joint;
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| {
            sigma[0] = x[0];
            sigma[1] = x[0] - x[1];
        },
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| {
            g.copy_from_slice(&[1.0, 0.0, 1.0, -1.0]);
        },
    };
    let run = run(system, &[0.0, 0.0], 4.0);
    let events = run.trajectory.mode_changes();
    let first = mu_floor * 3.0 * G / 4.0;
    // Together: 3 v' = p − floor; the joint carries v' ≤ μ_joint g.
    let second = (3.0 * mu_joint * G + mu_floor * 3.0 * G) / 4.0;
    assert_eq!(events.len(), 2, "{events:?}");
    assert!((events[0].t - first).abs() < 1e-10 && events[0].switch == 0);
    assert!((events[1].t - second).abs() < 1e-10 && events[1].switch == 1);
    let joint_speed = (4.0 * (second * second - first * first) / 2.0 - mu_floor * 3.0 * G * (second - first)) / 3.0;
    assert!((run.trajectory.sample(second)[1] - joint_speed).abs() < 1e-9);
    let upper = joint_speed + mu_joint * G * (4.0 - second);
    assert!((run.trajectory.final_state()[1] - upper).abs() < 1e-9);
}

#[test]
fn one_sign_that_acts_in_two_equations_has_one_value() {
    // As on the plate: the friction force along x also turns the object, w' = −c s_x(t).
    let (mu, a, omega, c) = (0.3, 2.0, 3.0, 0.7);
    let system = Closures {
        dim: 2,
        switches: 1,
        rhs: move |t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]| {
            dx[0] = a * (omega * t).sin() - mu * G * s[0];
            dx[1] = -c * s[0];
        },
        switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
        gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
    };
    let run = run(system, &[0.0, 0.0], 5.0);
    assert!(run.trajectory.mode_changes().iter().all(|e| e.t == 0.0));
    // Stuck throughout: s = A sin(ωt)/(μ g).
    let w = -c * a / (mu * G) * (1.0 - (omega * 5.0).cos()) / omega;
    assert!((run.trajectory.final_state()[1] - w).abs() < 1e-9);
}

#[test]
fn a_belt_that_changes_speed_at_once_sets_the_block_sliding() {
    // σ = v − u(t) with a belt speed that jumps at t = 1; the segment's formula is used to its end.
    #[derive(Clone)]
    struct Belt {
        speed: f64,
    }
    impl Switched for Belt {
        fn dim(&self) -> usize {
            1
        }
        fn switches(&self) -> usize {
            1
        }
        fn rhs(&mut self, _t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]) {
            dx[0] = -0.3 * G * s[0];
        }
        fn switching(&mut self, _t: f64, x: &[f64], sigma: &mut [f64]) {
            sigma[0] = x[0] - self.speed;
        }
        fn switching_gradient(&mut self, _t: f64, _x: &[f64], gradient: &mut [f64], partial_t: &mut [f64]) {
            gradient[0] = 1.0;
            partial_t[0] = 0.0;
        }
        fn enter_segment(&mut self, t: f64) -> f64 {
            self.speed = if t < 1.0 { 0.5 } else { 2.0 };
            if t < 1.0 { 1.0 } else { f64::INFINITY }
        }
    }
    let run = run(Belt { speed: 0.0 }, &[0.0], 3.0);
    let events = run.trajectory.mode_changes();
    let times = [0.5 / (0.3 * G), 1.0, 1.0 + 1.5 / (0.3 * G)];
    assert_eq!(events.len(), 3, "{events:?}");
    for (event, t) in events.iter().zip(times) {
        assert!((event.t - t).abs() < 1e-10);
    }
    assert_eq!(run.trajectory.final_state()[0], 2.0);
    assert_eq!(run.trajectory.mode_intervals(0).len(), 4);
}
