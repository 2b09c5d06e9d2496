//! Order, stability and sensitivities of the methods.
#![allow(clippy::unwrap_used)]

use super::Integrator::{self, GaussLegendre, Map, RadauIIA, Rk4};
use super::Interval;
use crate::dynamics::{Dynamics, FieldDynamics, SymbolicDynamics};
use crate::transcription::Shooter;
use approx::assert_relative_eq;
use bracketry_system::System;

const IMPLICIT: [Integrator; 8] = [
    GaussLegendre { stages: 1 },
    GaussLegendre { stages: 2 },
    GaussLegendre { stages: 3 },
    GaussLegendre { stages: 4 },
    RadauIIA { stages: 1 },
    RadauIIA { stages: 2 },
    RadauIIA { stages: 3 },
    RadauIIA { stages: 4 },
];

fn symbolic(text: &str) -> SymbolicDynamics {
    SymbolicDynamics::new(&System::parse("model.toml", text).unwrap()).unwrap()
}

/// State at `end` after `steps` steps from time 0.
fn flow(d: &mut dyn Dynamics, integrator: Integrator, x: &[f64], u: &[f64], end: f64, steps: usize) -> Vec<f64> {
    let mut x = x.to_vec();
    Shooter::new(d, integrator).advance(d, Interval { t: 0.0, dt: end, substeps: steps, u }, &mut x);
    x
}

#[test]
fn every_method_converges_with_its_order() {
    // x = (e^{sin t}, arctan(t)/…): x' = x cos t, y' = 1/(1 + t²) − y + arctan t.
    let mut d = FieldDynamics::new(2, 0, |t, x, _u, dx, jac| {
        dx.copy_from_slice(&[x[0] * t.cos(), 1.0 / (1.0 + t * t) - x[1] + t.atan()]);
        jac.copy_from_slice(&[t.cos(), 0.0, 0.0, -1.0]);
    });
    for method in IMPLICIT.into_iter().chain([Rk4]) {
        let mut error = |steps| {
            let x = flow(&mut d, method, &[1.0, 0.0], &[], 2.0, steps);
            (x[0] - 2f64.sin().exp()).hypot(x[1] - 2f64.atan())
        };
        let steps = if method.order() >= 6 { 3 } else { 40 };
        let order = (error(steps) / error(2 * steps)).log2();
        assert!((order - method.order() as f64).abs() < 0.5, "{method:?}: {order}");
    }
}

#[test]
fn sensitivities_are_the_derivatives_of_the_implicit_flow_and_of_a_map() {
    let text = r#"
        states = ["q", "v", "z"]
        inputs = ["a", "b"]
        dynamics = { q = "v", v = "-sin(q) - 30*v*(1 + z^2) + a", z = "b*v - z + a*q" }
    "#;
    let mut d = symbolic(text);
    let z0 = [0.3, 0.2, -0.4, 0.6, 1.5];
    for method in IMPLICIT.into_iter().chain([Map]) {
        let mut jacobian = vec![0.0; 15];
        let mut x = z0[..3].to_vec();
        let interval = Interval { t: 0.0, dt: 0.3, substeps: 2, u: &z0[3..] };
        Shooter::new(&d, method).advance_with_sensitivity(&mut d, interval, &mut x, &mut jacobian);
        assert_eq!(x, flow(&mut d, method, &z0[..3], &z0[3..], 0.3, 2));
        let h = 1e-5;
        for j in 0..5 {
            let mut at = |by: f64| {
                let mut z = z0;
                z[j] += by;
                flow(&mut d, method, &z[..3], &z[3..], 0.3, 2)
            };
            let (plus, minus) = (at(h), at(-h));
            for i in 0..3 {
                let difference = (plus[i] - minus[i]) / (2.0 * h);
                // Central differences with this step are exact to about 1e-10 of a derivative.
                assert_relative_eq!(jacobian[i * 5 + j], difference, epsilon = 1e-8, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn a_stiff_oscillator_is_followed_at_steps_where_the_explicit_method_fails() {
    // Van der Pol with mu = 1000 on its slow branch, where x(1 − …): x' ≈ x/(mu (1 − x²)), ln x − x²/2 = t/mu + const.
    let text = r#"
        states = ["x", "v"]
        inputs = ["u"]
        dynamics = { x = "v", v = "1000*(1 - x^2)*v - x + u" }
    "#;
    let mut d = symbolic(text);
    let start = [2.0, -2.0 / 3000.0];
    assert!(!flow(&mut d, Rk4, &start, &[0.0], 100.0, 200)[0].is_finite());
    let fine = flow(&mut d, RadauIIA { stages: 4 }, &start, &[0.0], 100.0, 400);
    for method in [RadauIIA { stages: 2 }, RadauIIA { stages: 3 }, GaussLegendre { stages: 2 }] {
        let x = flow(&mut d, method, &start, &[0.0], 100.0, 50);
        assert_relative_eq!(x[0], fine[0], epsilon = 1e-6);
    }
    // Over the branch, to first order in 1/mu².
    let invariant = |x: f64| x.ln() - x * x / 2.0;
    assert_relative_eq!(invariant(fine[0]) - invariant(2.0), 0.1, epsilon = 1e-5);
}

#[test]
fn chemical_kinetics_reach_their_published_state() {
    // Robertson's problem at t = 40 (Hairer and Wanner 1996, section IV.10): rate constants over nine decades.
    let text = r#"
        states = ["a", "b", "c"]
        inputs = ["u"]
        dynamics = { a = "-0.04*a + 1e4*b*c", b = "0.04*a - 1e4*b*c - 3e7*b^2", c = "3e7*b^2 + 0*u" }
    "#;
    let mut d = symbolic(text);
    assert!(!flow(&mut d, Rk4, &[1.0, 0.0, 0.0], &[0.0], 40.0, 1000)[0].is_finite());
    let x = flow(&mut d, RadauIIA { stages: 3 }, &[1.0, 0.0, 0.0], &[0.0], 40.0, 60);
    assert_relative_eq!(x[0], 0.715827068, max_relative = 1e-5);
    assert_relative_eq!(x[1], 9.185534764e-6, max_relative = 1e-4);
    assert_relative_eq!(x.iter().sum::<f64>(), 1.0, epsilon = 1e-10);
}

#[test]
fn the_symplectic_method_keeps_a_quadratic_invariant() {
    let text = r#"
        states = ["q", "p"]
        inputs = ["u"]
        dynamics = { q = "p", p = "-q + u" }
    "#;
    let x = flow(&mut symbolic(text), GaussLegendre { stages: 2 }, &[1.0, 0.0], &[0.0], 500.0, 1000);
    assert_relative_eq!(x[0] * x[0] + x[1] * x[1], 1.0, epsilon = 1e-11);
}

#[test]
fn equations_without_a_solution_are_a_failure_and_no_hang() {
    // Implicit Euler: z = h (1 + (x + z)²) has no real solution for h x > 1/4 and the like.
    let mut d = symbolic("states = [\"x\"]\ninputs = [\"u\"]\ndynamics = { x = \"1 + x^2 + u\" }");
    let mut shooter = Shooter::new(&d, RadauIIA { stages: 1 });
    let mut x = [1.0];
    shooter.advance(&mut d, Interval { t: 0.0, dt: 2.0, substeps: 1, u: &[0.0] }, &mut x);
    assert!(x[0].is_nan());
    assert!(shooter.take_failure());
    assert!(!shooter.take_failure());
}

#[test]
fn curvature_is_the_derivative_of_the_sensitivities() {
    let text = r#"
        states = ["q", "v", "z"]
        inputs = ["a", "b"]
        dynamics = { q = "v", v = "-sin(q) - 3*v*(1 + z^2) + a", z = "b*v - z + a*q + z^2" }
    "#;
    let mut d = symbolic(text);
    let field = d.second_derivatives().unwrap();
    let z0 = [0.3, 0.2, -0.4, 0.6, 1.5];
    let lambda = [0.7, -1.3, 2.1];
    for method in IMPLICIT.into_iter().chain([Rk4, Map]) {
        let mut shooter = Shooter::new(&d, method);
        let mut hessian = vec![0.0; 25];
        let interval = Interval { t: 0.2, dt: 0.3, substeps: 2, u: &z0[3..] };
        shooter.curvature(&mut d, interval, &z0[..3], &mut lambda.clone(), &field, &mut hessian);
        let mut gradient = |z: [f64; 5]| {
            let (mut x, mut jacobian) = (z[..3].to_vec(), vec![0.0; 15]);
            let interval = Interval { t: 0.2, dt: 0.3, substeps: 2, u: &z[3..] };
            shooter.advance_with_sensitivity(&mut d, interval, &mut x, &mut jacobian);
            [0, 1, 2, 3, 4].map(|j| (0..3).map(|i| lambda[i] * jacobian[i * 5 + j]).sum::<f64>())
        };
        let h = 1e-5;
        for j in 0..5 {
            let (mut plus, mut minus) = (z0, z0);
            plus[j] += h;
            minus[j] -= h;
            let (plus, minus) = (gradient(plus), gradient(minus));
            for i in 0..5 {
                let v = hessian[i * 5 + j];
                let difference = (plus[i] - minus[i]) / (2.0 * h);
                assert_relative_eq!(v, difference, epsilon = 1e-8, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn second_derivatives_stand_where_variables_meet() {
    let places = |v: &str| {
        let text = format!("states = [\"x\", \"v\"]\ninputs = [\"u\"]\ndynamics = {{ x = \"v\", v = \"{v}\" }}");
        symbolic(&text).second_derivatives().unwrap()
    };
    assert_eq!(places("u - x"), []);
    assert_eq!(places("u*v - x^2"), [(0, 0), (1, 2)]);
}
