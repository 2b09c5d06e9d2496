//! Systems whose coefficients are multiples of the primes of the exact tests, or mistaken for small numbers by them.

use crate::common::{elementary, system};
use bracketry_lie::{AnalysisOptions, Answer, Evidence, analyze_affine, observe};
use bracketry_symbolic::{Residue, SECOND_OFFSET, THIRD_OFFSET};
use proptest::prelude::*;

const PRIMES: [u64; 3] = [Residue::<1>::MODULUS, Residue::<SECOND_OFFSET>::MODULUS, Residue::<THIRD_OFFSET>::MODULUS];

fn coefficient(prime: usize, form: usize) -> String {
    let forms = ["@", "@/2", "2*@/3", "1/@", "@ + 1", "5 - @", "@^2"];
    format!("({})", forms[form % forms.len()].replace('@', &PRIMES[prime].to_string()))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(40) })]

    /// A chain of `k` states behind the input, beside states that nothing reaches, after a unimodular change of
    /// coordinates: the dimension is k, and the measured end of the chain shows the chain alone. A value modulo the
    /// prime that the coefficients belong to may stay undecided; it is never wrong.
    #[test]
    fn chains_keep_their_dimension(
        k in 1usize..4,
        rest in 0usize..3,
        prime in 0usize..3,
        forms in prop::collection::vec(0usize..7, 6),
        mixing in prop::collection::vec((0usize..6, 0usize..6, prop::sample::select(vec![-1i64, 1])), 4),
    ) {
        let n = k + rest;
        // x = T z with a product T of elementary matrices; z' = T⁻¹ f(T z).
        let (to, back) = elementary(n, &mixing);
        let sum = |row: &[i64], of: &[String]| {
            row.iter().zip(of).map(|(c, e)| format!("({c})*({e})")).collect::<Vec<_>>().join(" + ")
        };
        let z: Vec<String> = (1..=n).map(|i| format!("z{i}")).collect();
        let x: Vec<String> = to.iter().map(|row| sum(row, &z)).collect();
        let rate = |i: usize| match i {
            0 => "u".to_owned(),
            i if i < k => format!("{}*({})", coefficient(prime, forms[i]), x[i - 1]),
            i => format!("{}*({})", coefficient(prime, forms[i]), x[i]),
        };
        let rates: Vec<String> = (0..n).map(rate).collect();
        let dynamics: Vec<String> = back.iter().map(|row| sum(row, &rates)).collect();
        let names: Vec<&str> = z.iter().map(String::as_str).collect();
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let s = system(&names, &["u"], &[], &dynamics, &[&x[k - 1]], Some(&[]));
        let report = analyze_affine(&s, &AnalysisOptions::default()).unwrap();
        let right = |answer: &Answer<usize>, expected: usize| match answer {
            Answer::Known(d) => *d == expected,
            Answer::Unknown(_) => prime == 1,
        };
        prop_assert!(right(&report.modes[0].dimensions.strongly_accessible_dimension, k));
        if let Some(Answer::Known(p)) = &report.at_point {
            prop_assert!(right(&p.dimensions.strongly_accessible_dimension, k));
            prop_assert!(p.linear_controllability_rank.is_none_or(|r| r == k));
        }
        let o = observe(&s, &AnalysisOptions::default(), &mut Evidence::default()).unwrap().unwrap();
        prop_assert!(right(&o.rank, k), "{:?}", o.rank);
    }
}
