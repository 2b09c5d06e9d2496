//! Linear systems with known eigenvalues that no input reaches, in coordinates that hide them.

use crate::common::system;
use bracketry_lie::controllability::{PointReport, UncontrollableMode};
use bracketry_lie::{AnalysisOptions, Answer, analyze_affine};
use proptest::prelude::*;

fn report(states: &[String], dynamics: &[String]) -> PointReport {
    let states: Vec<&str> = states.iter().map(String::as_str).collect();
    let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
    let s = system(&states, &["u"], &[], &dynamics, &[], Some(&[]));
    analyze_affine(&s, &AnalysisOptions::default()).unwrap().at_point.unwrap().known().unwrap().clone()
}

fn names(n: usize) -> Vec<String> {
    (1..=n).map(|i| format!("x{i}")).collect()
}

/// x' = A x + b u as text.
fn linear(a: &[Vec<i64>], b: &[i64]) -> Vec<String> {
    let row = |(row, b): (&Vec<i64>, &i64)| {
        let terms = row.iter().enumerate().map(|(j, c)| format!("({c})*x{}", j + 1));
        terms.chain([format!("({b})*u")]).collect::<Vec<_>>().join(" + ")
    };
    a.iter().zip(b).map(row).collect()
}

fn modes(report: &PointReport) -> Vec<UncontrollableMode> {
    report.uncontrollable_modes.clone().unwrap().known().unwrap().clone()
}

fn real(report: &PointReport) -> Vec<(f64, usize)> {
    modes(report).iter().filter(|m| m.im == 0.0).map(|m| (m.re, m.multiplicity)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A chain of two integrators driven by the input beside a block with eigenvalues `real` and 'a ± ib', which the chain
    /// is fed by, after a unimodular change of coordinates: eigenvalues, multiplicities, and stabilizability are found.
    #[test]
    fn hidden_eigenvalues_are_found(
        real_parts in prop::collection::vec(-9i64..4, 1..4),
        (a, b) in (-2i64..2, 1i64..5),
        fast in prop::sample::select(vec![1i64, 1_000, 1_000_000]),
        mixing in prop::collection::vec((0usize..7, 0usize..7, -2i64..3), 6),
    ) {
        let k = real_parts.len();
        let n = 2 + k + 2;
        let mut m = vec![vec![0i64; n]; n];
        m[0][1] = fast;
        m[0][2] = 1;
        m[1][n - 1] = 3;
        for (i, &r) in real_parts.iter().enumerate() {
            m[2 + i][2 + i] = r;
            // Equal eigenvalues with and without a chain between them.
            if i > 0 {
                m[1 + i][2 + i] = 1;
            }
        }
        (m[n - 2][n - 2], m[n - 2][n - 1], m[n - 1][n - 2], m[n - 1][n - 1]) = (a, -b, b, a);
        let mut input = vec![0i64; n];
        input[1] = 1;
        // x_i := x_i + c x_j: rows of A and b change with c, columns with −c.
        for &(i, j, c) in mixing.iter().filter(|t| t.0 < n && t.1 < n && t.0 != t.1) {
            for col in 0..n {
                m[i][col] += c * m[j][col];
            }
            input[i] += c * input[j];
            for row in &mut m {
                row[j] -= c * row[i];
            }
        }
        let report = report(&names(n), &linear(&m, &input));
        let found = modes(&report);
        prop_assert_eq!(found.iter().map(|m| m.multiplicity).sum::<usize>(), k + 2);
        for r in &real_parts {
            let multiplicity = real_parts.iter().filter(|s| *s == r).count();
            let here = found.iter().find(|m| m.im == 0.0 && m.re == *r as f64);
            prop_assert_eq!(here.map(|m| m.multiplicity), Some(multiplicity), "{} in {:?}", r, found);
            prop_assert!(!here.unwrap().combinations.is_empty());
        }
        let upper = found.iter().find(|m| m.im > 0.0).unwrap();
        prop_assert!((upper.re - a as f64).abs() < 1e-12 && (upper.im - b as f64).abs() < 1e-12, "{upper:?}");
        let worst = real_parts.iter().copied().chain([a]).max().unwrap();
        prop_assert_eq!(report.stabilizable.unwrap(), Answer::Known(worst < 0));
    }
}

/// A fast controllable state does not blur slow modes that are not controllable.
#[test]
fn a_fast_mode_hides_no_unstable_one() {
    let states = ["i", "a", "b", "c", "d"].map(str::to_owned);
    let report = report(&states, &["u - 1e5*i", "-a", "-5*b", "-2*c", "d/2"].map(str::to_owned));
    assert_eq!(real(&report), [(0.5, 1), (-1.0, 1), (-2.0, 1), (-5.0, 1)]);
    assert_eq!(report.stabilizable, Some(Answer::Known(false)));
}

/// x_i' = −i x_i: as many eigenvalues as states, none of them doubled.
#[test]
fn distinct_modes_stay_distinct() {
    for n in [4, 8, 16] {
        let dynamics: Vec<String> = (1..=n).map(|i| format!("-{i}*x{i}")).chain(["u".to_owned()]).collect();
        let states: Vec<String> = names(n).into_iter().chain(["y".to_owned()]).collect();
        let expected: Vec<(f64, usize)> = (1..=n).map(|i| (-(i as f64), 1)).collect();
        assert_eq!(real(&report(&states, &dynamics)), expected);
    }
}

/// Symmetric networks of integrators with one input: the modes that the symmetry hides.
#[test]
fn stars_and_complete_graphs_are_decided() {
    for n in [10usize, 12, 20] {
        // A star with its center driven: differences of leaves decay as exp(−t).
        let star: Vec<String> = (1..=n).map(|i| if i == 1 { "u".to_owned() } else { format!("x1 - x{i}") }).collect();
        assert_eq!(real(&report(&names(n), &star)), [(-1.0, n - 2)]);
        // The complete graph: each with all others, −n on all differences.
        let all = names(n).join(" + ");
        let complete: Vec<String> =
            (1..=n).map(|i| format!("{all} - {n}*x{i}{}", if i == 1 { " + u" } else { "" })).collect();
        let report = report(&names(n), &complete);
        assert_eq!(real(&report), [(-(n as f64), n - 2)]);
        assert_eq!(report.stabilizable, Some(Answer::Known(true)));
    }
}

/// Lightly damped oscillators beside an integrator: none of their eigenvalues is at zero, and all decay.
#[test]
fn light_damping_decides() {
    let states: Vec<String> =
        (1..=5).flat_map(|i| [format!("q{i}"), format!("v{i}")]).chain(["y".to_owned()]).collect();
    let dynamics: Vec<String> =
        (1..=5).flat_map(|i| [format!("v{i}"), format!("-{i}*q{i} - v{i}/1000000")]).chain(["u".to_owned()]).collect();
    let report = report(&states, &dynamics);
    let found = modes(&report);
    assert_eq!(found.len(), 10);
    for m in found {
        assert!(m.multiplicity == 1 && (m.re + 0.5e-6).abs() < 1e-15 && m.im.abs() >= 0.99, "{m:?}");
    }
    assert_eq!(report.stabilizable, Some(Answer::Known(true)));
}

/// a' = −√2 a + b/s, b' = −s a − √2 b: −√2 ± i in any units of b.
#[test]
fn units_hide_no_mode() {
    for digits in [0, 4, 8, 12] {
        let [up, down] = ["", "-"].map(|sign| format!("10^({sign}{digits})"));
        let dynamics = [format!("-sqrt(2)*a + {down}*b"), format!("-{up}*a - sqrt(2)*b"), "u".to_owned()];
        let report = report(&["a", "b", "c"].map(str::to_owned), &dynamics);
        let found = modes(&report);
        let is = |m: &UncontrollableMode, im: f64| (m.re + 2f64.sqrt()).hypot(m.im - im) < 1e-9 && m.multiplicity == 1;
        assert!(found.len() == 2 && is(&found[0], 1.0) && is(&found[1], -1.0), "{digits}: {found:?}");
        assert_eq!(report.stabilizable, Some(Answer::Known(true)), "{digits}");
    }
}
