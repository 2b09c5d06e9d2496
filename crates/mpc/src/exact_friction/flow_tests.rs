//! The exact flow against the simulator and against finite differences of itself.
#![allow(clippy::unwrap_used)]

use super::flow::StickSlipFlow;
use super::switched_field::SwitchedField;
use crate::integrator::Interval;
use approx::assert_relative_eq;
use bracketry_sim::{ExactPlant, FrictionMode, SimulationSettings};
use bracketry_system::System;

/// Two masses on springs, each rubbing on the ground, with a slider on the first that rubs on it.
fn masses() -> System {
    let text = r#"
        states = ["p", "v", "q", "w", "r"]
        inputs = ["a", "b"]
        dynamics = { p = "v", v = "-3*p + 2*(q - p) - 0.4*sign(v) - 0.3*sign(v - r) + a", q = "w", w = "2*(p - q) - q^3 - (0.3 + 0.1*q^2)*sign(w) + b", r = "0.5*sign(v - r) + 0.2*b" }
    "#;
    System::parse("masses.toml", text).unwrap()
}

fn flow(system: &System) -> StickSlipFlow {
    StickSlipFlow::new(SwitchedField::new(system, &[], 1e-3).unwrap())
}

/// Reproducible numbers in [−1, 1] (a linear congruential generator).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A start with some velocities zero and some relative ones, so that modes of all kinds occur.
fn start(numbers: &mut Numbers) -> ([f64; 5], [f64; 2]) {
    let mut x = [(); 5].map(|()| numbers.next());
    if numbers.next() > 0.0 {
        x[1] = 0.0;
    }
    if numbers.next() > 0.0 {
        x[3] = 0.0;
    }
    if numbers.next() > 0.0 {
        x[4] = x[1];
    }
    (x, [2.0 * numbers.next(), 2.0 * numbers.next()])
}

#[test]
fn end_states_and_modes_are_those_of_the_simulator() {
    let system = masses();
    let mut flow = flow(&system);
    let mut numbers = Numbers(1);
    let mut changes = 0;
    for _ in 0..80 {
        let (x0, u) = start(&mut numbers);
        let mut x = x0;
        assert!(flow.advance(Interval { t: 0.0, dt: 0.6, substeps: 40, u: &u }, &mut x, None, &[]));
        let mut plant = ExactPlant::new(&system, &x0, &SimulationSettings::default()).unwrap();
        plant.hold(&u, 0.6).unwrap();
        for (a, b) in x.iter().zip(plant.state()) {
            assert_relative_eq!(a, b, epsilon = 1e-7);
        }
        changes += flow.changes.len();
    }
    assert!(changes > 60, "{changes} changes of mode are too few to have tested anything");
}

#[test]
fn the_derivative_is_that_of_the_flow_across_events() {
    let system = masses();
    let mut flow = flow(&system);
    let mut numbers = Numbers(7);
    let (mut compared, mut with_events) = (0, 0);
    for _ in 0..80 {
        let (x0, u) = start(&mut numbers);
        let mut x = x0;
        let mut jacobian = vec![0.0; 35];
        assert!(flow.advance(Interval { t: 0.0, dt: 0.6, substeps: 40, u: &u }, &mut x, Some(&mut jacobian), &[]));
        let sequence: Vec<(usize, FrictionMode)> = flow.changes.iter().map(|c| (c.switch, c.to)).collect();
        let h = 1e-5;
        for j in 0..7 {
            let mut end = |by: f64| {
                let (mut x, mut u) = (x0, u);
                if j < 5 {
                    x[j] += by;
                } else {
                    u[j - 5] += by;
                }
                assert!(flow.advance(Interval { t: 0.0, dt: 0.6, substeps: 40, u: &u }, &mut x, None, &[]));
                x
            };
            let (a, b, c, d) = (end(h), end(-h), end(h / 2.0), end(-h / 2.0));
            for i in 0..5 {
                let (whole, half) = ((a[i] - b[i]) / (2.0 * h), (c[i] - d[i]) / h);
                // Where the sequence of modes differs on the two sides there is no derivative: quotients then disagree, or the
                // one-sided ones do.
                let (right, left) = ((c[i] - x[i]) * 2.0 / h, (x[i] - d[i]) * 2.0 / h);
                if (whole - half).abs() > 1e-6 || (right - left).abs() > 1e-4 {
                    continue;
                }
                assert_relative_eq!(jacobian[i * 7 + j], half, epsilon = 2e-5, max_relative = 2e-5);
                compared += 1;
                with_events += usize::from(!sequence.is_empty());
            }
        }
    }
    assert!(compared > 1900 && with_events > 600, "{compared} entries compared, {with_events} across events");
}

#[test]
fn what_sticks_feels_neither_input_nor_speed() {
    // A block under less force than friction holds: x stays, whatever small speed it is given.
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a - sign(v)" }
    "#;
    let mut flow = flow(&System::parse("block.toml", text).unwrap());
    let mut x = [0.3, 0.0];
    let mut jacobian = [0.0; 6];
    assert!(flow.advance(Interval { t: 0.0, dt: 0.5, substeps: 1, u: &[0.7] }, &mut x, Some(&mut jacobian), &[]));
    assert_eq!(x, [0.3, 0.0]);
    assert_eq!(jacobian, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(flow.start_modes, [FrictionMode::Sticking]);
    // s = a holds it, so ∂s/∂a = 1.
    assert_relative_eq!(flow.start_signs[0], 0.7, epsilon = 1e-15);
    assert_eq!(flow.start_rows, [0.0, 0.0, 1.0]);
}

#[test]
fn a_block_stops_where_it_should_and_the_derivative_knows() {
    // v' = −1 − 0.5 until v = 0 at t = v0/1.5, at x = v0²/3; it then sticks.
    let text = r#"
        states = ["x", "v"]
        inputs = ["a"]
        dynamics = { x = "v", v = "a - sign(v)" }
    "#;
    let mut flow = flow(&System::parse("block.toml", text).unwrap());
    let (v0, a) = (0.6, -0.5);
    let mut x = [0.0, v0];
    let mut jacobian = [0.0; 6];
    assert!(flow.advance(Interval { t: 0.0, dt: 1.0, substeps: 1, u: &[a] }, &mut x, Some(&mut jacobian), &[]));
    assert_relative_eq!(x[0], v0 * v0 / 3.0, epsilon = 1e-12);
    assert_eq!(x[1], 0.0);
    assert_relative_eq!(flow.changes[0].t, v0 / 1.5, epsilon = 1e-12);
    // x = v0²/(2(1 − a)): ∂x/∂v0 = v0/(1 − a), ∂x/∂a = v0²/(2(1 − a)²).
    let expected = [1.0, v0 / 1.5, v0 * v0 / (2.0 * 1.5 * 1.5), 0.0, 0.0, 0.0];
    for (a, b) in jacobian.iter().zip(expected) {
        assert_relative_eq!(*a, b, epsilon = 1e-12);
    }
}
