//! Local identifiability of larger models, and of models with symmetries by construction.

use std::fmt::Write as _;

use crate::common::{elementary, ratio, system};
use bracketry_lie::observability::ObservabilityReport;
use bracketry_lie::{AnalysisOptions, Answer, Evidence, Named, observe};
use proptest::prelude::*;

/// A model as text.
#[derive(Clone, Default)]
struct Model {
    states: Vec<String>,
    inputs: Vec<String>,
    parameters: Vec<String>,
    rates: Vec<String>,
    outputs: Vec<String>,
}

impl Model {
    fn report(&self) -> ObservabilityReport {
        fn borrowed(list: &[String]) -> Vec<&str> {
            list.iter().map(String::as_str).collect()
        }
        let values: Vec<_> =
            self.parameters.iter().zip(0..).map(|(n, i)| (n.as_str(), ratio(13 + 10 * i, 7 + 4 * i))).collect();
        let s = system(
            &borrowed(&self.states),
            &borrowed(&self.inputs),
            &values,
            &borrowed(&self.rates),
            &borrowed(&self.outputs),
            None,
        );
        observe(&s, &AnalysisOptions::default(), &mut Evidence::default()).unwrap().unwrap()
    }

    /// The parameter as a product of itself and a new one, which hides a scaling.
    fn split(&mut self, name: &str) {
        let new = format!("{name}_2");
        for rate in &mut self.rates {
            *rate = replaced(rate, name, &format!("({name}*{new})"));
        }
        self.parameters.push(new);
    }
}

/// The text with a name replaced as a whole word.
fn replaced(text: &str, name: &str, by: &str) -> String {
    let mut out = String::new();
    let mut word = String::new();
    for c in text.chars().chain([' ']) {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        out.push_str(if word == name { by } else { &word });
        word.clear();
        out.push(c);
    }
    out
}

fn names(list: Option<&Named<bool>>, value: bool) -> Vec<String> {
    list.unwrap().0.iter().filter(|v| v.1 == value).map(|v| v.0.clone()).collect()
}

/// Compartments in a row with Michaelis–Menten kinetics between them, fed at the first; the last one is measured.
fn saturated_chain(n: usize) -> Model {
    let mut m = Model { inputs: vec!["u".into()], ..Model::default() };
    for i in 1..=n {
        m.states.push(format!("x{i}"));
        let mut rate = if i == 1 { "u".to_owned() } else { format!("V{0}*x{0}/(K{0} + x{0})", i - 1) };
        if i < n {
            write!(rate, " - V{i}*x{i}/(K{i} + x{i})").unwrap();
            m.parameters.extend([format!("V{i}"), format!("K{i}")]);
        } else {
            write!(rate, " - k*x{i}").unwrap();
        }
        m.rates.push(rate);
    }
    m.parameters.push("k".into());
    m.outputs.push(format!("x{n}"));
    m
}

/// Mass-action kinetics: each reaction has a rate constant of its own.
fn reactions(list: &[(Vec<String>, Vec<String>)], outputs: &[&str]) -> Model {
    let mut m = Model::default();
    for (number, (from, to)) in list.iter().enumerate() {
        let k = format!("k{}", number + 1);
        let flow = format!("{k}*{}", from.join("*"));
        m.parameters.push(k);
        for (species, sign) in from.iter().map(|s| (s, '-')).chain(to.iter().map(|s| (s, '+'))) {
            let at = m.states.iter().position(|s| s == species).unwrap_or_else(|| {
                m.states.push(species.clone());
                m.rates.push(String::new());
                m.states.len() - 1
            });
            write!(m.rates[at], " {sign} {flow}").unwrap();
        }
    }
    m.outputs = outputs.iter().map(|&o| o.to_owned()).collect();
    m
}

/// E + S ⇌ C → E + P
fn catalysis(list: &mut Vec<(Vec<String>, Vec<String>)>, enzyme: &str, substrate: &str, product: &str) {
    let complex = vec![format!("{enzyme}_{substrate}")];
    let pair = |s: &str| vec![enzyme.to_owned(), s.to_owned()];
    list.push((pair(substrate), complex.clone()));
    list.push((complex.clone(), pair(substrate)));
    list.push((complex, pair(product)));
}

/// The cascade of mitogen-activated protein kinases (Huang and Ferrell 1996): 22 species, 30 rate constants.
fn cascade(outputs: &[&str]) -> Model {
    let mut list = Vec::new();
    for (enzyme, substrate, product) in [
        ("E1", "KKK", "KKKp"),
        ("E2", "KKKp", "KKK"),
        ("KKKp", "KK", "KKp"),
        ("P2", "KKp", "KK"),
        ("KKKp", "KKp", "KKpp"),
        ("P2", "KKpp", "KKp"),
        ("KKpp", "K", "Kp"),
        ("P1", "Kp", "K"),
        ("KKpp", "Kp", "Kpp"),
        ("P1", "Kpp", "Kp"),
    ] {
        catalysis(&mut list, enzyme, substrate, product);
    }
    reactions(&list, outputs)
}

#[test]
fn chains_of_saturated_compartments_are_identifiable_from_the_last() {
    for n in [2, 6, 12] {
        let r = saturated_chain(n).report();
        assert_eq!(r.rank, Answer::Known(n));
        assert_eq!(names(r.identifiable.as_ref(), false), Vec::<String>::new(), "{n}");
        assert_eq!(r.rank_with_parameters, Some(3 * n - 1));
    }
}

#[test]
fn a_kinase_cascade_is_identifiable_from_its_last_layer_and_two_kinases() {
    let r = cascade(&["Kpp", "KKpp", "KKKp"]).report();
    assert_eq!(r.reason, None);
    assert_eq!(r.rank, Answer::Known(22));
    assert_eq!(names(r.identifiable.as_ref(), false), Vec::<String>::new());
    assert_eq!(names(r.identifiable_states.as_ref(), false), Vec::<String>::new());
}

/// Amounts in unknown units: measured is the amount of the product times an unknown factor.
#[test]
fn an_unknown_gain_of_the_sensor_leaves_a_scaling_of_the_whole_cascade() {
    let mut m = cascade(&["gain*Kpp", "gain*KKpp", "gain*KKKp"]);
    m.parameters.push("gain".into());
    let r = m.report();
    assert_eq!(r.rank_with_parameters, Some(22 + 31 - 1));
    // Only the constants of first order are without a unit of amount.
    let second_order: Vec<String> = (0..10).map(|i| format!("k{}", 3 * i + 1)).chain(["gain".into()]).collect();
    assert_eq!(names(r.identifiable.as_ref(), false), second_order);
    assert_eq!(names(r.identifiable_states.as_ref(), true), Vec::<String>::new());
    assert_eq!(r.unidentifiable_directions.len(), 1);
    let symmetry = r.unidentifiable_directions[0].symmetry.as_ref().unwrap().to_string();
    assert!(symmetry.starts_with("scaling of KKK by s") || symmetry.starts_with("scaling of E1 by s"), "{symmetry}");
    assert_eq!(r.fix_to_identify.unwrap(), ["k1"]);
}

#[test]
fn functions_with_series_of_their_own_are_covered() {
    let names_of = |list: &[&str]| list.iter().map(|&s| s.to_owned()).collect::<Vec<_>>();
    // A large chain in front makes the Lie derivatives too long.
    let mut m = saturated_chain(10);
    m.states.extend(names_of(&["y", "z"]));
    m.parameters.extend(names_of(&["a", "n", "c", "d", "w"]));
    m.rates.push("a*x10^n/(1 + x10^n) - y*sqrt(1 + y)".to_owned());
    m.rates.push("c*exp(-d*y) - sin(w*z)*atan(z)".to_owned());
    m.outputs = names_of(&["y", "z"]);
    let r = m.report();
    assert_eq!(r.reason, None);
    assert_eq!(names(r.identifiable.as_ref(), false), Vec::<String>::new());
    // exp(−d y + e) hides that c and e are one.
    m.parameters.push("e".into());
    m.rates.pop();
    m.rates.push("c*exp(-d*y + e) - sin(w*z)*atan(z)".to_owned());
    let r = m.report();
    assert_eq!(r.reason, None);
    assert_eq!(names(r.identifiable.as_ref(), false), ["c", "e"]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(12) })]

    /// Products of parameters and a unimodular change of the states hide which are determined.
    #[test]
    fn hidden_scalings_are_found(
        n in 3usize..8,
        split in prop::collection::btree_set(0usize..5, 0..4),
        mixing in prop::collection::vec((0usize..8, 0usize..8, prop::sample::select(vec![-1i64, 1])), 4),
    ) {
        let mut m = saturated_chain(n);
        let chosen: Vec<String> = split.iter().map(|&i| m.parameters[i].clone()).collect();
        for name in &chosen {
            m.split(name);
        }
        // x = T z with T a product of elementary matrices, z' = T⁻¹ f(T z).
        let (to, back) = elementary(n, &mixing);
        let sum = |row: &[i64], of: &[String]| {
            let terms = row.iter().zip(of).filter(|t| *t.0 != 0).map(|(c, e)| format!("({c})*({e})"));
            terms.collect::<Vec<_>>().join(" + ")
        };
        let z: Vec<String> = (1..=n).map(|i| format!("z{i}")).collect();
        let old: Vec<String> = to.iter().map(|row| format!("({})", sum(row, &z))).collect();
        let in_new = |text: &String| m.states.iter().zip(&old).fold(text.clone(), |t, (x, e)| replaced(&t, x, e));
        let rates: Vec<String> = m.rates.iter().map(in_new).collect();
        let outputs: Vec<String> = m.outputs.iter().map(in_new).collect();
        let changed = Model {
            states: z,
            rates: back.iter().map(|row| sum(row, &rates)).collect(),
            outputs,
            ..m.clone()
        };
        let r = changed.report();
        prop_assert_eq!(&r.rank, &Answer::Known(n));
        let mut open = names(r.identifiable.as_ref(), false);
        open.sort();
        let mut expected: Vec<String> = chosen.iter().flat_map(|c| [c.clone(), format!("{c}_2")]).collect();
        expected.sort();
        prop_assert_eq!(open, expected);
        prop_assert_eq!(r.rank_with_parameters, Some(3 * n - 1));
        prop_assert_eq!(r.unidentifiable_directions.len(), chosen.len());
    }
}
