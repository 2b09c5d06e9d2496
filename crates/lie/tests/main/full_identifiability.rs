//! Global identifiability, identifiable combinations, known initial values, and unknown inputs, on published models.

use bracketry_lie::identifiability;
use bracketry_lie::observability::{IdentifiabilityError, IdentifiabilityOptions, IdentifiabilityReport};
use bracketry_system::System;

fn asked(model: &str, known: &[&str], unknown: &[&str]) -> IdentifiabilityReport {
    let system = System::parse("test", model).unwrap();
    let strings = |list: &[&str]| list.iter().map(|s| (*s).to_owned()).collect();
    let options = IdentifiabilityOptions {
        known_initial: strings(known),
        unknown_inputs: strings(unknown),
        ..IdentifiabilityOptions::default()
    };
    identifiability(&system, &options).unwrap()
}

/// `g` for global, a number of values for local, `-` for not identifiable, `l` for local with an unknown number, `?`.
fn verdicts(r: &IdentifiabilityReport) -> Vec<String> {
    let mut list: Vec<String> = r
        .parameters
        .iter()
        .map(|p| {
            let text = match (p.local, p.global, p.values) {
                (Some(true), Some(true), _) => "g".to_owned(),
                (Some(true), Some(false), Some(n)) => n.to_string(),
                (Some(true), ..) => "l".to_owned(),
                (Some(false), ..) => "-".to_owned(),
                (None, ..) => "?".to_owned(),
            };
            format!("{} {text}", p.name)
        })
        .collect();
    list.sort();
    list
}

fn combinations(r: &IdentifiabilityReport) -> Vec<String> {
    let mut list: Vec<String> = r.combinations.iter().map(bracketry_lie::Function::text).collect();
    list.sort();
    list
}

/// Vajda and Rabitz 1988: slow and fast reaction cannot be told apart.
#[test]
fn slow_and_fast_rates_may_be_exchanged() {
    let model = "states = ['a', 'b']\nparameters = { k1 = 1, k2 = 2 }\n\
                 dynamics = { a = '-k1*a', b = 'k1*a - k2*b' }\noutputs = { y = 'b' }";
    let r = asked(model, &[], &[]);
    assert_eq!(verdicts(&r), ["k1 2", "k2 2"]);
    let other: Vec<String> = r.other_solution.iter().map(|(n, f)| format!("{n} = {f}")).collect();
    assert_eq!(&other[..2], ["k1 = k2", "k2 = k1"]);
    // A known amount at the start breaks the symmetry.
    assert_eq!(verdicts(&asked(model, &["a", "b"], &[])), ["k1 g", "k2 g"]);
}

/// Two compartments, input and output in the first (DiStefano 2015): the four rates appear in three coefficients. Without
/// elimination from the second compartment all are globally identifiable.
#[test]
fn two_compartments() {
    let model = |leak: &str| {
        format!(
            "states = ['x', 'y']\ninputs = ['u']\nparameters = {{ k01 = 1, k12 = 2, k21 = 3{} }}\n\
             dynamics = {{ x = '-(k01 + k21)*x + k12*y + u', y = 'k21*x - k12*y{}' }}\noutputs = {{ h = 'x' }}",
            if leak.is_empty() { "" } else { ", k02 = 4" },
            leak
        )
    };
    assert_eq!(verdicts(&asked(&model(""), &[], &[])), ["k01 g", "k12 g", "k21 g"]);
    let r = asked(&model(" - k02*y"), &[], &[]);
    assert_eq!(verdicts(&r), ["k01 -", "k02 -", "k12 -", "k21 -"]);
    assert_eq!(combinations(&r), ["k01 + k21", "k02 + k12", "k12*k21"]);
    assert_eq!(r.combinations_missing, Some(0));
}

/// Output in the second compartment with elimination from both: the sums are exchanged with each other.
#[test]
fn exchanged_eliminations_are_counted() {
    let model = "states = ['x', 'y']\ninputs = ['u']\nparameters = { p = 1, q = 2, k = 3 }\n\
                 dynamics = { x = '-p*x + u', y = 'k*x - q*y' }\noutputs = { h = 'y' }";
    let r = asked(model, &["x=0", "y=0"], &[]);
    // p and q may be exchanged: of special initial values, that is not proven by finitely many derivatives here.
    assert_eq!(verdicts(&r), ["k g", "p l", "q l"]);
    let generic = asked(model, &[], &[]);
    assert_eq!(verdicts(&generic), ["k g", "p 2", "q 2"]);
}

/// SIR with unknown scaling of the prevalence: β and the scale only by their quotient (Evans and others 2005).
#[test]
fn an_epidemic_observed_up_to_scale() {
    let model = "states = ['S', 'I']\nparameters = { beta = 1, gamma = 2, k = 3 }\n\
                 dynamics = { S = '-beta*S*I', I = 'beta*S*I - gamma*I' }\noutputs = { y = 'k*I' }";
    let r = asked(model, &[], &[]);
    assert_eq!(verdicts(&r), ["beta -", "gamma g", "k -"]);
    assert_eq!(combinations(&r), ["beta/k"]);
    assert_eq!(verdicts(&asked(model, &["S"], &[])), ["beta g", "gamma g", "k g"]);
}

/// SEIR with the infectious observed: incubation and recovery may be exchanged (Dankwa and others 2022; Massonis and others 2021).
#[test]
fn incubation_and_recovery_may_be_exchanged() {
    let model = "states = ['S', 'E', 'I']\nparameters = { beta = 1, eps = 2, gamma = 3 }\n\
                 dynamics = { S = '-beta*S*I', E = 'beta*S*I - eps*E', I = 'eps*E - gamma*I' }\noutputs = { y = 'I' }";
    let r = asked(model, &[], &[]);
    assert_eq!(verdicts(&r), ["beta g", "eps 2", "gamma 2"]);
}

/// Michaelis–Menten elimination with unknown volume (Godfrey 1983): all globally identifiable from a known dose.
#[test]
fn michaelis_menten_elimination() {
    let model = "states = ['x']\ninputs = ['u']\nparameters = { Vm = 1, Km = 2, c = 3 }\n\
                 dynamics = { x = '-Vm*x/(Km + x) + u' }\noutputs = { y = 'c*x' }";
    assert_eq!(verdicts(&asked(model, &[], &[])), ["Km g", "Vm g", "c g"]);
    let no_dose = "states = ['x']\nparameters = { Vm = 1, Km = 2, c = 3 }\n\
                   dynamics = { x = '-Vm*x/(Km + x)' }\noutputs = { y = 'c*x' }";
    let r = asked(no_dose, &[], &[]);
    assert_eq!(verdicts(&r), ["Km -", "Vm -", "c -"]);
    assert_eq!(r.combinations.len(), 2);
    assert_eq!(r.combinations_missing, Some(0));
}

/// HIV dynamics with the virus observed (Wu and others 2008; Miao and others 2011): production rates only in products.
#[test]
fn hiv_with_the_virus_observed() {
    let model = "states = ['T', 'I', 'V']\nparameters = { s = 1, d = 2, b = 3, delta = 4, p = 5, c = 6 }\n\
                 dynamics = { T = 's - d*T - b*T*V', I = 'b*T*V - delta*I', V = 'p*I - c*V' }\noutputs = { y = 'V' }";
    let r = asked(model, &[], &[]);
    let found = verdicts(&r);
    assert_eq!(&found[..2], ["b g", "c 2"], "{found:?} {:?}", r.global_reason);
    assert!(found.contains(&"d g".to_owned()) && found.contains(&"delta 2".to_owned()), "{found:?}");
    assert!(found.contains(&"p -".to_owned()) && found.contains(&"s -".to_owned()));
    assert_eq!(combinations(&r), ["p*s"]);
}

/// The oscillator of Goodwin (1965) with the first substance observed: locally, three rates and two combinations of the others.
#[test]
fn goodwin_oscillator() {
    let model = "states = ['x', 'y', 'z']\nparameters = { a = 1, A = 2, b = 3, al = 4, be = 5, ga = 6, de = 7 }\n\
                 dynamics = { x = 'a/(A + z) - b*x', y = 'al*x - be*y', z = 'ga*y - de*z' }\noutputs = { h = 'x' }";
    let system = System::parse("test", model).unwrap();
    let options = IdentifiabilityOptions { global: false, ..IdentifiabilityOptions::default() };
    let r = identifiability(&system, &options).unwrap();
    assert_eq!(verdicts(&r), ["A -", "a -", "al -", "b l", "be l", "de l", "ga -"]);
    assert_eq!((r.combinations.len(), r.combinations_missing), (2, Some(0)));
    assert!(r.decided(false) && !r.decided(true));
}

/// y' = −a y + w with w unknown: nothing; with a second output of the state that w does not reach, its rate.
#[test]
fn unknown_inputs_hide_what_they_drive() {
    let model = "states = ['x', 'z']\ninputs = ['w']\nparameters = { a = 1, b = 2, c = 3 }\n\
                 dynamics = { x = '-a*x + w', z = 'c*x - b*z' }\noutputs = { y = 'x', h = 'z' }";
    assert_eq!(verdicts(&asked(model, &[], &[])), ["a g", "b g", "c g"]);
    assert_eq!(verdicts(&asked(model, &[], &["w"])), ["a -", "b g", "c g"]);
    // Not affine in the unknown input.
    let model = "states = ['x', 'z']\ninputs = ['w']\nparameters = { a = 1, b = 2, c = 3 }\n\
                 dynamics = { x = '-a*x + w^2', z = 'c*x - b*z' }\noutputs = { y = 'x', h = 'z' }";
    assert_eq!(verdicts(&asked(model, &[], &["w"])), ["a -", "b g", "c g"]);
}

/// x' = −a x: c is scaled with x(0); known x(0) tells it, but for x(0) = 0 nothing is seen.
#[test]
fn known_initial_values() {
    let model = "states = ['x']\nparameters = { a = 1, c = 2 }\ndynamics = { x = '-a*x' }\noutputs = { y = 'c*x' }";
    assert_eq!(verdicts(&asked(model, &[], &[])), ["a g", "c -"]);
    assert_eq!(verdicts(&asked(model, &["x"], &[])), ["a g", "c g"]);
    assert_eq!(verdicts(&asked(model, &["x=2"], &[])), ["a g", "c g"]);
    // At rest the outputs are zero: whether derivatives of any order tell more is not decided by rank.
    assert_eq!(verdicts(&asked(model, &["x=0"], &[])), ["a ?", "c ?"]);
}

/// Squares, and roots of the parameters: numbers of values by construction.
#[test]
fn numbers_of_values_by_construction() {
    for (rate, values) in [("a", "g"), ("a^2", "2"), ("a^3", "3"), ("a^3 + a", "3"), ("a^4", "4"), ("1/a", "g")] {
        let model = format!(
            "states = ['x']\nparameters = {{ a = 2 }}\ndynamics = {{ x = '-({rate})*x' }}\noutputs = {{ y = 'x' }}"
        );
        assert_eq!(verdicts(&asked(&model, &[], &[])), [format!("a {values}")], "{rate}");
    }
    // Three equal compartments in a row: the rates are the roots of a polynomial.
    let model = "states = ['x', 'y', 'z']\nparameters = { a = 1, b = 2, c = 3 }\n\
                 dynamics = { x = '-a*x', y = 'a*x - b*y', z = 'b*y - c*z' }\noutputs = { h = 'z' }";
    assert_eq!(verdicts(&asked(model, &[], &[])), ["a 3", "b 3", "c 3"]);
}

/// Functions that are no quotients of polynomials leave the number of values open, which is said.
#[test]
fn transcendental_functions_are_local_only() {
    let model = "states = ['x']\nparameters = { a = 1 }\ndynamics = { x = '-a*sin(x)' }\noutputs = { y = 'x' }";
    let r = asked(model, &[], &[]);
    assert_eq!(verdicts(&r), ["a l"]);
    assert!(r.global_reason.is_some() && !r.decided(true) && r.decided(false));
}

#[test]
fn bad_input_is_refused() {
    let system = System::parse(
        "test",
        "states = ['mass']\nparameters = { a = 1 }\ndynamics = { mass = '-a*mass' }\noutputs = { y = 'mass' }",
    )
    .unwrap();
    let with = |known: &str| {
        let options =
            IdentifiabilityOptions { known_initial: vec![known.to_owned()], ..IdentifiabilityOptions::default() };
        identifiability(&system, &options).unwrap_err()
    };
    assert_eq!(with("mas").to_string(), "the model has no state `mas`; did you mean `mass`?");
    assert!(matches!(with("mass=q"), IdentifiabilityError::Initial { .. }));
    let options = IdentifiabilityOptions { unknown_inputs: vec!["u".to_owned()], ..IdentifiabilityOptions::default() };
    assert!(matches!(identifiability(&system, &options), Err(IdentifiabilityError::Unknown { kind: "input", .. })));
}
