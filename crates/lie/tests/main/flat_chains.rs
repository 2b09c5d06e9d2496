//! Flatness of systems that are linearizable by static feedback by construction.

use crate::common::{shown, system};
use crate::tier;
use bracketry_lie::feedback::FlatnessVerdict;
use bracketry_lie::{AnalysisOptions, analyze_affine};
use bracketry_system::System;

/// Deterministic numbers 0, …, n − 1 (linear congruences).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

/// A chain of integrators after triangular changes of coordinates and feedback: x_i' = a_i x_(i+1) + φ_i(x_1, …, x_i).
fn triangular(n: usize, numbers: &mut Numbers) -> System {
    let names: Vec<String> = (1..=n).map(|i| format!("x{i}")).collect();
    let next = |i: usize| if i == n { "u".to_owned() } else { format!("x{}", i + 1) };
    let rhs: Vec<String> = (1..=n)
        .map(|i| {
            let (j, k) = (1 + numbers.below(i), 1 + numbers.below(i));
            let drift = match numbers.below(4) {
                0 => format!("x{j}*x{k}"),
                1 => format!("sin(x{j})"),
                2 => format!("x{j}^2 - x{k}"),
                _ => format!("x{k}*cos(x{j})"),
            };
            match numbers.below(3) {
                0 => format!("{} + {drift}", next(i)),
                1 => format!("2*{} - {drift}", next(i)),
                _ => format!("(1 + x{j}^2)*{} + {drift}", next(i)),
            }
        })
        .collect();
    let states: Vec<&str> = names.iter().map(String::as_str).collect();
    let rhs: Vec<&str> = rhs.iter().map(String::as_str).collect();
    system(&states, &["u"], &[], &rhs, &[], None)
}

#[test]
fn long_chains_are_flat_by_their_first_state() {
    let mut numbers = Numbers(1);
    for n in tier::first(2, [5, 12, 22]) {
        let s = triangular(n, &mut numbers);
        let report = analyze_affine(&s, &AnalysisOptions::default()).unwrap();
        let flatness = report.control.flatness.unwrap();
        assert_eq!(flatness.verdict, FlatnessVerdict::Yes, "{n}: {}", flatness.reason);
        assert_eq!(shown(&flatness.flat_outputs), ["x1"], "{n}");
        assert_eq!(shown(&report.control.feedback_linearization.unwrap().linearizing_outputs), ["x1"], "{n}");
    }
}

/// Linear mechanics in joint angles, with definitions of functions of the angles: the angles themselves are the linearizing outputs.
#[test]
fn states_linearize_before_functions_of_them() {
    let text = "states = ['p', 'q', 'v', 'w']\ninputs = ['a', 'b']\ndefinitions = { m = 'cos(p - q)/2', d = '1 - m^2', s = 'sin(p)' }\n\
                dynamics = { p = 'v', q = 'w', v = '(a - m*b)/d - s', w = '(b - m*a)/d' }";
    let system = System::parse("arm", text).unwrap();
    let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
    let outputs: Vec<String> =
        report.control.feedback_linearization.unwrap().linearizing_outputs.iter().map(ToString::to_string).collect();
    assert_eq!(outputs, ["p", "q"]);
}
