//! Functions that are said not to return to their value at the point: looked at where it would show.

use crate::common::system;
use crate::tier::cases;
use bracketry_lie::reason::{Monotone, StabilizableReason};
use bracketry_lie::{AnalysisOptions, analyze_affine};
use bracketry_symbolic::{Function, Tape};
use proptest::prelude::*;

const NAMES: [&str; 3] = ["X", "Y", "Z"];

/// X' = u, Y' and Z' polynomials with these coefficients: linear, quadratic, and cubic terms in turn.
fn dynamics(coefficients: &[i64]) -> Vec<String> {
    let monomials = [
        "X", "Y", "Z", "X^2", "X*Y", "X*Z", "Y^2", "Y*Z", "Z^2", "X^3", "X^2*Y", "X*Y^2", "Y^3", "Z^3", "X^2*Z",
        "Y*Z^2",
    ];
    let rate = |c: &[i64]| {
        let terms: Vec<String> =
            c.iter().zip(monomials).filter(|(c, _)| **c != 0).map(|(c, m)| format!("({c})*{m}")).collect();
        if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }
    };
    let half = coefficients.len() / 2;
    vec!["u".to_owned(), rate(&coefficients[..half]), rate(&coefficients[half..])]
}

/// The function and its rate without the input at a point.
fn value_and_rate(function: &Function, rates: &[String], at: &[f64]) -> (f64, f64) {
    let mut pool = function.pool().clone();
    let symbols: Vec<_> = NAMES.iter().map(|n| pool.symbol(n)).collect();
    let gradient = pool.gradient(function.expr(), &symbols);
    let fields: Vec<_> = rates.iter().map(|r| pool.parse(&r.replace('u', "0")).unwrap()).collect();
    let terms: Vec<_> = gradient.iter().zip(fields).map(|(&g, f)| pool.mul(g, f)).collect();
    let rate = pool.sum(terms);
    let tape = Tape::compile(&pool, &symbols, &[function.expr(), rate]).unwrap();
    let mut out = [0.0; 2];
    tape.eval(at, &mut Vec::new(), &mut out);
    (out[0], out[1])
}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn functions_do_not_return(
        kinds in prop::collection::vec(0usize..7, 32),
        values in prop::collection::vec(-2i64..3, 32),
        directions in prop::collection::vec(prop::collection::vec((-1.0f64..1.0, 1u32..4), 3), 200),
    ) {
        // A few terms only.
        let coefficients: Vec<i64> = kinds.iter().zip(values).map(|(&k, v)| if k == 0 { v } else { 0 }).collect();
        let rates = dynamics(&coefficients);
        let texts: Vec<&str> = rates.iter().map(String::as_str).collect();
        let system = system(&NAMES, &["u"], &[], &texts, &[], Some(&[]));
        let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
        let Some(at) = report.at_point.unwrap().known().cloned() else { return Ok(()) };
        let (function, side, rises) = match at.stabilizable_reason {
            Some(StabilizableReason::NoReturn { function, above }) => (function, if above { 1.0 } else { -1.0 }, above),
            Some(StabilizableReason::OneWay { function, change: Monotone::Rises }) => (function, 0.0, true),
            Some(StabilizableReason::OneWay { function, change: Monotone::Falls }) => (function, 0.0, false),
            _ => return Ok(()),
        };
        for d in &directions {
            let point: Vec<f64> = d.iter().map(|(x, k)| x * 1e-3_f64.powi(*k as i32)).collect();
            let (value, rate) = value_and_rate(&function, &rates, &point);
            let size = point.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if value * side >= 0.0 {
                let wrong = if rises { -rate } else { rate };
                prop_assert!(wrong <= 1e-14 * size, "{rates:?}: {} at {point:?}: {rate}", function.text());
            }
        }
    }
}
