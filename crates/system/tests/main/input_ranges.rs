//! New inputs take the images of the ranges of the old ones: no more, and no less.

use bracketry_system::symbolic::Tape;
use bracketry_system::{Affinization, AtPoint, Range, RangeNote, System};
use proptest::prelude::*;

fn affinize(dynamics: &str, ranges: &str, more: &str) -> Affinization {
    let text = format!("states = ['x']\ninputs = ['u', 'w']\n[ranges]\n{ranges}\n[dynamics]\nx = '{dynamics}'\n{more}");
    System::parse("m", &text).unwrap().affinize().unwrap()
}

const RANGES: &str = "u = { min = 0, max = 2 }\nw = { min = -1, max = 3 }";

#[test]
fn images_are_those_of_calculus() {
    for (w, limits) in [
        ("u^2", "0 ≤ v1 ≤ 4"),
        ("exp(-u)", "exp(-2) ≤ v1 ≤ 1"),
        ("u^2 - u", "-0.25 ≤ v1 ≤ 2"),
        ("w^2", "0 ≤ v1 ≤ 9"),
        ("w^3", "-1 ≤ v1 ≤ 27"),
        ("sin(u)", "0 ≤ v1 ≤ 1"),
        ("cos(2*w)", "|v1| ≤ 1"),
        ("abs(w)", "0 ≤ v1 ≤ 3"),
        ("max(w, 1)", "1 ≤ v1 ≤ 3"),
        ("u*w", "-2 ≤ v1 ≤ 6"),
        ("u^2 + sin(w)^2", "0 ≤ v1 ≤ 5"),
        ("u*exp(u)", "0 ≤ v1 ≤ 2*exp(2)"),
        ("u*w + u^2", "-0.250000 ≤ v1 ≤ 10"),
        ("1/(1 + u)^2", "0.111111 ≤ v1 ≤ 1"),
        ("sqrt(u)*(1 + u)", "0 ≤ v1 ≤ 2^1.5 + sqrt(2)"),
    ] {
        let a = affinize(w, RANGES, "");
        let v = &a.input_change[0];
        let text = v.range().unwrap_or_else(|| format!("{}", v.values));
        // Fractions are compared as numbers below.
        assert!(text == limits || text.replace("1/9", "0.111111") == limits, "{w}: {text}");
    }
}

#[test]
fn the_ranges_are_written_into_the_affine_model() {
    let a = affinize("exp(-u) - 3*w", RANGES, "");
    let again = System::parse("m", &a.system.to_toml().unwrap()).unwrap();
    let names: Vec<&str> = again.input_ranges.iter().map(|r| again.symbol_name(r.input)).collect();
    assert_eq!(names.len(), again.inputs.len(), "{names:?}");
    for r in &again.input_ranges {
        assert!(r.min.is_some() && r.max.is_some(), "{r:?}");
    }
}

#[test]
fn the_inverse_is_the_branch_within_the_range() {
    for (w, min, max, inverse) in [
        ("u^2", 0, 2, "v1^0.5"),
        ("u^2", -2, 0, "-v1^0.5"),
        ("abs(u)", -2, -1, "-v1"),
        ("abs(u)", 1, 2, "v1"),
        ("exp(-u)", -2, 0, "-log(v1)"),
    ] {
        let a = affinize(w, &format!("u = {{ min = {min}, max = {max} }}"), "");
        let chosen = a.candidates.iter().find(|c| c.chosen).unwrap();
        let text = chosen.inverse[0].1.text().replace("sqrt(v1)", "v1^0.5");
        assert_eq!(text, inverse, "{w} on [{min}, {max}]");
    }
}

#[test]
fn the_place_of_the_point_respects_the_ranges() {
    let at = |w: &str, u: &str| affinize(w, RANGES, &format!("[point]\nu = {u}\n")).input_change[0].at_point;
    assert_eq!(at("u^2", "0"), AtPoint::AtLower);
    assert_eq!(at("u^2", "1"), AtPoint::Interior);
    assert_eq!(at("u^2", "2"), AtPoint::AtUpper);
    let whole = affinize("u^2", RANGES, "[point]\nu = 2\n");
    assert_eq!((whole.interior_at_point, whole.covers_at_point), (Some(false), Some(false)));
}

#[test]
fn what_the_ranges_do_not_say_is_noted() {
    let text =
        format!("states = ['x', 'y']\ninputs = ['u', 'w']\n[ranges]\n{RANGES}\n[dynamics]\nx = 'u + w'\ny = 'u*w^2'\n");
    let a = System::parse("m", &text).unwrap().affinize().unwrap();
    assert!(a.range_notes.iter().any(|n| matches!(n, RangeNote::Joint { .. } | RangeNote::State { .. })), "{a:?}");
    // No value at u = 0: the image is not given, and that is said.
    let a = affinize("1/u", RANGES, "");
    assert!(a.range_notes.iter().any(|n| matches!(n, RangeNote::Unknown { .. })), "{:?}", a.range_notes);
    // Without ranges there is nothing to say.
    let a = affinize("u^2", "", "");
    assert!(a.range_notes.is_empty());
}

/// One factor or term: a function of the variable `s`.
fn function() -> impl Strategy<Value = fn(&str, i32) -> String> {
    let all: Vec<fn(&str, i32) -> String> = vec![
        |s, k| format!("({k}*{s} + {s}^2)"),
        |s, k| format!("({s}^3 - {k}*{s})"),
        |s, k| format!("exp({k}*{s}/4)"),
        |s, k| format!("sin({k}*{s})"),
        |s, k| format!("tanh({s} - {k})"),
        |s, _| format!("sqrt(1 + {s})"),
        |s, k| format!("cos({s} + {k})"),
        |s, k| format!("({k} - {s})"),
    ];
    prop::sample::select(all)
}

/// The greatest value of f near the best sample, by golden sections along each variable in turn.
fn polished(f: &mut dyn FnMut(&[f64]) -> f64, ends: &[[f64; 2]], mut at: Vec<f64>, step: f64) -> f64 {
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..60 {
        let before = f(&at);
        for k in 0..at.len() {
            let (mut a, mut b) = ((at[k] - step).max(ends[k][0]), (at[k] + step).min(ends[k][1]));
            let mut on = |x: f64, at: &mut Vec<f64>| {
                at[k] = x;
                f(at)
            };
            let mut best = (on(at[k], &mut at), at[k]);
            for x in [a, b] {
                let v = on(x, &mut at);
                if v > best.0 {
                    best = (v, x);
                }
            }
            for _ in 0..80 {
                let (p, q) = (b - ratio * (b - a), a + ratio * (b - a));
                let (fp, fq) = (on(p, &mut at), on(q, &mut at));
                for (v, x) in [(fp, p), (fq, q)] {
                    if v > best.0 {
                        best = (v, x);
                    }
                }
                if fp > fq { b = q } else { a = p }
            }
            at[k] = best.1;
        }
        if f(&at) - before < 1e-14 {
            break;
        }
    }
    f(&at)
}

/// A product of functions of one input each that is written as a sum has the product of their ranges, wherever the
/// intervals lie: also where no simple number is inside, and where it vanishes on a whole edge.
#[test]
fn products_written_as_sums_are_split_on_any_interval() {
    for (low, high) in [(2, 3), (5, 7), (-9, -7)] {
        let end = if low > 0 { low } else { high };
        let ranges = format!("u = {{ min = {low}, max = {high} }}\nw = {{ min = 2, max = 3 }}");
        let w = format!("u^2*exp(w/4) - ({end})*u*exp(w/4)");
        let a = affinize(&format!("x + {w}"), &ranges, "");
        let Range::Interval { lower: Some(lower), upper: Some(upper) } = &a.input_change[0].values else {
            panic!("{w}: {}", a.input_change[0].values)
        };
        let far = f64::from(if low > 0 { high } else { low });
        let greatest = (far - f64::from(end)) * far * 0.75f64.exp();
        // The new input may be the product or its negative.
        let (none, most) = if upper.value > 0.0 { (lower, upper.value) } else { (upper, -lower.value) };
        assert!(none.value.abs() < 1e-9 && (most - greatest).abs() < 1e-9, "{w}: {lower} to {upper}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(150) })]

    /// The interval holds 10⁴ samples, and its ends are taken to 1e-9.
    #[test]
    fn samples_fill_the_image(
        f in function(), g in function(), j in -3i32..4, k in 1i32..4, sum: bool, two: bool,
        low in -3i32..3, width in 1i32..5,
    ) {
        let ends = [[f64::from(low.max(-1)), f64::from(low.max(-1) + width)], [-1.0, 0.5]];
        let second = if two { "w" } else { "u" };
        let w = format!("{} {} {}", f("u", j), if sum { "+" } else { "*" }, g(second, k));
        let ranges = format!("u = {{ min = {}, max = {} }}\nw = {{ min = -1, max = 0.5 }}", ends[0][0], ends[0][1]);
        let a = affinize(&format!("x + {w}"), &ranges, "");
        prop_assume!(!a.input_change.is_empty());
        for v in &a.input_change {
            let Range::Interval { lower: Some(lower), upper: Some(upper) } = &v.values else {
                // At an end where a root vanishes its slope has no bound, and the range may stay unknown.
                let steep = w.contains("sqrt(1 + w)") || w.contains("sqrt(1 + u)") && ends[0][0] == -1.0;
                prop_assert!(steep, "{w}: {}", v.values);
                continue;
            };
            let mut pool = a.system.pool.clone();
            let symbols = [pool.symbol("u"), pool.symbol("w")];
            let tape = Tape::compile(&pool, &symbols, &[v.function]).unwrap();
            let mut scratch = Vec::new();
            let mut value = |at: &[f64]| {
                let mut out = [0.0];
                tape.eval(at, &mut scratch, &mut out);
                out[0]
            };
            let (mut least, mut greatest) = ((f64::INFINITY, vec![]), (f64::NEG_INFINITY, vec![]));
            for i in 0..=100 {
                for j in 0..=100 {
                    let part = |n: f64, [a, b]: [f64; 2]| a + (b - a) * n / 100.0;
                    // Where u alone matters, all samples are along u: a narrow dip between two zeros is seen.
                    let (i, j) = (f64::from(i), f64::from(j) / 101.0);
                    let at = vec![part(if two { i } else { (i + j).min(100.0) }, ends[0]), part(j * 101.0, ends[1])];
                    let x = value(&at);
                    if x < least.0 {
                        least = (x, at.clone());
                    }
                    if x > greatest.0 {
                        greatest = (x, at);
                    }
                }
            }
            let scale = 1e-9 * (1.0 + least.0.abs().max(greatest.0.abs()));
            prop_assert!(least.0 >= lower.value - scale && greatest.0 <= upper.value + scale, "{w}: {:?}", v.values);
            let step = 0.05 * f64::from(width);
            let high = polished(&mut value, &ends, greatest.1, step);
            let low = -polished(&mut |at: &[f64]| -value(at), &ends, least.1, step);
            prop_assert!((low - lower.value).abs() <= scale, "{w}: {low} and {:?}", v.values);
            prop_assert!((high - upper.value).abs() <= scale, "{w}: {high} and {:?}", v.values);
        }
    }
}
