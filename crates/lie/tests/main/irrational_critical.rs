//! Equilibria that the linearization does not decide, with irrational coefficients, at irrational points: families with known answers.

use crate::common::system;
use crate::tier::cases;
use bracketry_lie::controllability::PointReport;
use bracketry_lie::{AnalysisOptions, analyze_affine};
use proptest::prelude::*;

/// Positive constants without other relations than those of products, and points.
const CONSTANTS: [&str; 8] = ["sqrt(2)", "1/3", "exp(1/3)", "pi/4", "sin(1)", "sqrt(3)/2", "2", "sqrt(5)/2"];
const POINTS: [&str; 4] = ["0", "sqrt(2)", "1/3", "(-sqrt(3)/2)"];

/// A system in the coordinates Z_i = k_i (s_i + m_i s_(i−1)) + p_i, or with m_i = 0, in other units of time.
struct Moved {
    states: Vec<String>,
    rates: Vec<String>,
    point: Vec<(String, String)>,
}

/// s_i' = `dynamics`, with the constants numbered by `choice`.
fn moved(dynamics: &[String], mixed: bool, choice: &[usize]) -> Moved {
    let pick = |list: &'static [&'static str], i: usize| list[choice[i % choice.len()] % list.len()];
    let mut old: Vec<String> = Vec::new();
    let (mut rates, mut point): (Vec<String>, Vec<(String, String)>) = Default::default();
    for i in 0..dynamics.len() {
        let (k, p) = (pick(&CONSTANTS, 3 * i), pick(&POINTS, 3 * i + 1));
        let m = if mixed { pick(&CONSTANTS, 3 * i + 2) } else { "0" };
        let before = if i > 0 { format!(" - {m}*{}", old[i - 1]) } else { String::new() };
        old.push(format!("((Z{i} - {p})/({k}){before})"));
        let before = if i > 0 { format!(" + {m}*({})", dynamics[i - 1]) } else { String::new() };
        rates.push(format!("{}*{k}*({}{before})", pick(&CONSTANTS, 1), dynamics[i]));
        point.push((format!("Z{i}"), p.to_owned()));
    }
    for rate in &mut rates {
        *rate = old.iter().enumerate().fold(rate.clone(), |rate, (i, z)| rate.replace(&format!("s{i}"), z));
    }
    Moved { states: (0..dynamics.len()).map(|i| format!("Z{i}")).collect(), rates, point }
}

impl Moved {
    fn point(&self) -> Vec<(&str, &str)> {
        self.point.iter().map(|(n, v)| (n.as_str(), v.as_str())).collect()
    }

    fn report(&self, inputs: &[&str]) -> PointReport {
        let states: Vec<&str> = self.states.iter().map(String::as_str).collect();
        let rates: Vec<&str> = self.rates.iter().map(String::as_str).collect();
        let system = system(&states, inputs, &[], &rates, &[], Some(&self.point()));
        analyze_affine(&system, &AnalysisOptions::default()).unwrap().at_point.unwrap().known().unwrap().clone()
    }

    /// Whether feedback makes the equilibrium asymptotically stable.
    fn stabilizable(&self, inputs: &[&str]) -> Option<bool> {
        self.report(inputs).stabilizable.unwrap().known().copied()
    }

    /// Whether the motion is minimum phase as the zero dynamics of y' = u, Z' = … + y.
    fn minimum_phase(&self) -> Option<bool> {
        let states: Vec<&str> = std::iter::once("y").chain(self.states.iter().map(String::as_str)).collect();
        let rates: Vec<String> = self.rates.iter().map(|r| format!("{r} + y")).collect();
        let rates: Vec<&str> = std::iter::once("u").chain(rates.iter().map(String::as_str)).collect();
        let system = system(&states, &["u"], &[], &rates, &["y"], Some(&self.point()));
        let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap().control.input_output.unwrap();
        report.zero_dynamics.unwrap().known().unwrap().minimum_phase.known().copied()
    }
}

/// Dynamics in s0, s1, … with constants for a, b, d.
fn family(list: &[&str], choice: &[usize]) -> Vec<String> {
    let at = |i: usize| format!("({})", CONSTANTS[choice[i] % CONSTANTS.len()]);
    list.iter().map(|f| f.replace('A', &at(0)).replace('B', &at(1)).replace('D', &at(2))).collect()
}

/// Systems with the answer whether the origin attracts.
const FAMILIES: &[(&[&str], bool)] = &[
    // A leading term.
    (&["-A*s0^3 + B*s0^4"], true),
    (&["A*s0^3 - B*s0^5"], false),
    (&["B*s0^2 - A*s0^3"], false),
    (&["A*(sin(s0) - s0)"], true),
    // A Lyapunov function.
    (&["A*s1", "-B*s0 - D*s1^3"], true),
    (&["A*s1", "-B*s0 + D*s1^3"], false),
    (&["s1", "-A*s0^3 - B*s1"], true),
    // A focal value.
    (&["A*s1", "-B*s0 - D*s0^2*s1"], true),
    (&["A*s1", "-B*s0 + D*s0^2*s1"], false),
    // b' = −ω² a + p a b + s a²: it has the sign of p s.
    (&["s1", "-A*s0 + B*s0*s1 + D*s0^2"], false),
    (&["s1", "-A*s0 - B*s0*s1 + D*s0^2"], true),
    // A center manifold.
    (&["A*s0*s1", "-B*s1 - D*s0^2"], true),
    (&["A*s0*s1", "-B*s1 + D*s0^2"], false),
    // Lorenz at r = 1.
    (&["A*(s1 - s0)", "s0 - s1 - s0*s2", "-B*s2 + s0*s1"], true),
];

/// The same where a Lyapunov function shows it only in coordinates of which its rate has even powers.
const SUMS_OF_EVEN_POWERS: &[(&[&str], bool)] = &[
    (&["A*s1", "-B*s0 - s1^3", "sqrt(5)*s3", "-sqrt(5)*s2 - D*s3^3"], true),
    (&["A*s1", "-B*s0 - D*s1^3", "-A*s2^3"], true),
    (&["s1", "-A*s0^3 - B*s1^3"], true),
    (&["-A*s0^3 + B*s0*s1", "-B*s0^2 - D*s1^3"], true),
    (&["A*s1", "-B*s0", "sqrt(5)*s3", "-sqrt(5)*s2"], false),
    (&["A*s0*s1", "-A*s0^2"], false),
];

/// Systems in which an input acts on critical modes, with the answer whether feedback stabilizes.
const WITH_INPUT: &[(&[&str], bool)] = &[
    (&["u", "A*s0*s1 + B*s1^2"], true),
    (&["u", "D*s1^3 - A*s0^2*s1"], true),
    (&["u", "A*s1^2 - B*s0^3*s1"], true),
    (&["s1", "u", "A*s0*s2 + B*s2^3"], true),
    (&["u", "s2", "-A*s1 + B*s0*s2"], true),
    (&["u", "A*s0*s1 - B*s0*s2 + D*s1^2", "B*s0*s1 + A*s0*s2"], true),
    (&["u", "A*s0^2*s1 + B*s1^3"], false),
    (&["u", "A*s1 - B*s0^2"], false),
    (&["u", "A*s1^2 + B*s0^2"], false),
];

fn choices() -> impl Strategy<Value = Vec<usize>> {
    prop::collection::vec(0usize..24, 12)
}

proptest! {
    #![proptest_config(cases(5))]

    #[test]
    fn attraction_is_decided(which in 0..FAMILIES.len(), choice in choices()) {
        let (dynamics, attracts) = FAMILIES[which];
        let mut dynamics = family(dynamics, &choice);
        let alone = moved(&dynamics, true, &choice);
        prop_assert_eq!(alone.minimum_phase(), Some(attracts), "{:?}", alone.rates);
        prop_assert_eq!(alone.stabilizable(&[]), Some(attracts), "{:?}", alone.rates);
        // An input that changes nothing of it.
        dynamics.push("u + s0^2".to_owned());
        let driven = moved(&dynamics, true, &choice);
        prop_assert_eq!(driven.stabilizable(&["u"]), Some(attracts), "{:?}", driven.rates);
    }

    #[test]
    fn attraction_is_decided_in_suitable_coordinates(which in 0..SUMS_OF_EVEN_POWERS.len(), choice in choices()) {
        let (dynamics, attracts) = SUMS_OF_EVEN_POWERS[which];
        let moved = moved(&family(dynamics, &choice), false, &choice);
        prop_assert_eq!(moved.minimum_phase(), Some(attracts), "{:?}", moved.rates);
        prop_assert_eq!(moved.stabilizable(&[]), Some(attracts), "{:?}", moved.rates);
    }

    #[test]
    fn feedback_acts_on_critical_modes(which in 0..WITH_INPUT.len(), choice in choices()) {
        let (dynamics, stabilizes) = WITH_INPUT[which];
        let moved = moved(&family(dynamics, &choice), true, &choice);
        prop_assert_eq!(moved.stabilizable(&["u"]), Some(stabilizes), "{:?}", moved.rates);
    }
}
