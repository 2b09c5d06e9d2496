//! Linear systems around a point: exact matrices, poles, zeros, ranks, Gramians, and gains.

use bracketry_lie::operating::{
    LinearAnalysis, LinearModel, LinearizeError, LinearizeOptions, NoGain, NotLinearizable,
};
use bracketry_lie::{AnalysisOptions, analyze_affine, linearize};
use bracketry_system::System;
use nalgebra::DMatrix;
use std::fmt::Write as _;

fn analyzed(text: &str) -> LinearAnalysis {
    linearize(&System::parse("m", text).unwrap(), &LinearizeOptions::default()).unwrap()
}

#[test]
fn entries_are_formulas_of_the_parameters() {
    let text = "states = ['th', 'w']\ninputs = ['u']\nparameters = { g = 9.81, l = 0.5 }\n\
        dynamics = { th = 'w', w = 'u/l^2 - g/l*sin(th)' }\noutputs = { y = 'th' }\npoint = { th = 'pi' }";
    let r = analyzed(text);
    assert_eq!(r.system.a.formulas[1][0].text(), "g/l");
    assert!((r.system.a.values[(1, 0)] - 19.62).abs() < 1e-12 && (r.system.b.values[(1, 0)] - 4.0).abs() < 1e-12);
    assert!(r.exact && r.half_planes == Some([1, 0, 1]));
    assert_eq!((r.controllability.rank, r.observability.rank, r.controllability.exact), (2, 2, true));
    assert!(r.gramians.as_ref().unwrap().horizon.is_some());
    assert!(r.regulator.as_ref().unwrap().residual < 1e-12 && r.estimator.as_ref().unwrap().residual < 1e-12);
}

#[test]
fn a_stable_system_has_gramians_for_all_time() {
    // 1/(s + a): W = 1/(2a).
    let r = analyzed("states = ['x']\ninputs = ['u']\ndynamics = { x = 'u - 4*x' }\noutputs = { y = 'x' }");
    let g = r.gramians.unwrap();
    assert!(g.horizon.is_none() && (g.controllability[(0, 0)] - 0.125).abs() < 1e-15);
    assert_eq!(r.zeros, Some(vec![]));
}

#[test]
fn unreachable_modes_are_seen_and_have_distance_zero() {
    let r = analyzed("states = ['x', 'y']\ninputs = ['u']\ndynamics = { x = 'u - x', y = 'y' }");
    assert_eq!(r.controllability.rank, 1);
    assert!(r.distance_to_uncontrollable.unwrap().upper < 1e-9);
    assert_eq!(r.regulator, Err(NoGain::NoStabilizingSolution));
    assert!(r.system.states_are_outputs && r.system.outputs == ["x", "y"]);
}

#[test]
fn where_the_equations_are_not_smooth_there_is_none() {
    let at = |f: &str, x: &str| {
        let text = format!("states = ['x']\ninputs = ['u']\ndynamics = {{ x = '{f}' }}\npoint = {{ x = {x} }}");
        linearize(&System::parse("m", &text).unwrap(), &LinearizeOptions::default())
    };
    for f in ["u - sign(x)", "u + abs(x)", "u + max(x, 0)"] {
        let error = at(f, "0").unwrap_err();
        assert!(matches!(error, LinearizeError::NotLinearizable(NotLinearizable::NotSmooth { .. })), "{f}: {error}");
        assert!(at(f, "-1").is_ok(), "{f}");
    }
    // x |x| has the derivative 2 |x|.
    assert_eq!(at("u - x*abs(x)", "0").unwrap().system.a.values[(0, 0)], 0.0);
    assert!((at("u - x*abs(x)", "-3").unwrap().system.a.values[(0, 0)] + 6.0).abs() < 1e-15);
    assert!(matches!(
        at("u + sqrt(x)", "0").unwrap_err(),
        LinearizeError::NotLinearizable(NotLinearizable::NotFinite { .. })
    ));
}

/// Systems by construction: diagonal poles and known uncontrollable modes behind a rational change of coordinates.
#[test]
fn ranks_and_poles_survive_changes_of_coordinates() {
    let mut state = 11u64;
    let mut random = |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % n) as i64
    };
    for case in 0..30 {
        let n = 2 + random(4) as usize;
        let poles: Vec<i64> = (0..n).map(|i| -(i as i64) - 1 + 3 * random(2)).collect();
        let reached: Vec<bool> = (0..n).map(|_| random(3) > 0).collect();
        // Lower triangular T with unit diagonal, z = T x: x' = T⁻¹ (Λ T x + b u).
        let t = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal => 1.0,
            std::cmp::Ordering::Greater => random(3) as f64 - 1.0,
            std::cmp::Ordering::Less => 0.0,
        });
        let inverse = t.clone().try_inverse().unwrap();
        let lambda = DMatrix::from_fn(n, n, |i, j| if i == j { poles[i] as f64 } else { 0.0 });
        let a = &inverse * lambda * &t;
        let b = &inverse * DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(reached[i])));
        let seen: Vec<bool> = (0..n).map(|_| random(3) > 0).collect();
        let c = DMatrix::from_fn(1, n, |_, i| f64::from(u8::from(seen[i]))) * &t;
        // States in units that are 1, or irrational.
        let written = |units: &[&str]| {
            let mut text = format!(
                "states = [{}]\ninputs = ['u']\n[dynamics]\n",
                (0..n).map(|i| format!("'x{i}'")).collect::<Vec<_>>().join(",")
            );
            let unit = |i: usize| units[i % units.len()];
            for i in 0..n {
                let terms: Vec<String> =
                    (0..n).map(|j| format!("({})*{}/{}*x{j}", a[(i, j)].round(), unit(i), unit(j))).collect();
                let _ = writeln!(text, "x{i} = '{} + ({})*{}*u'", terms.join(" + "), b[(i, 0)].round(), unit(i));
            }
            let terms: Vec<String> = (0..n).map(|j| format!("({})/{}*x{j}", c[(0, j)].round(), unit(j))).collect();
            let _ = writeln!(text, "[outputs]\ny = '{}'", terms.join(" + "));
            text
        };
        let text = written(&["1"]);
        let r = analyzed(&text);
        let irrational = analyzed(&written(&["sqrt(2)", "cos(1/5)", "exp(1/3)", "(sqrt(3)*pi)", "log(7)"]));
        assert_eq!(irrational.controllability, r.controllability, "{case}: {text}");
        assert_eq!(irrational.observability, r.observability, "{case}: {text}");
        for (rank, distance) in [
            (r.controllability, irrational.distance_to_uncontrollable.unwrap()),
            (r.observability, irrational.distance_to_unobservable.unwrap()),
        ] {
            assert!(rank.exact && (rank.rank < n) == (distance.upper == 0.0), "{case}: {rank:?} {distance:?}");
        }
        let mut visible: Vec<i64> = poles.iter().zip(&seen).filter(|(_, s)| **s).map(|(p, _)| *p).collect();
        visible.sort_unstable();
        visible.dedup();
        assert_eq!(r.observability.rank, visible.len(), "{case}: {text}");
        let mut distinct: Vec<i64> = poles.iter().zip(&reached).filter(|(_, r)| **r).map(|(p, _)| *p).collect();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(r.controllability.rank, distinct.len(), "{case}: {text}");
        let unstable = poles.iter().filter(|p| **p > 0).count();
        assert_eq!(r.half_planes.unwrap()[2], unstable, "{case}: {text}");
        let stabilizable = poles.iter().all(|p| *p < 0 || distinct.contains(p))
            && poles.iter().enumerate().all(|(i, p)| *p < 0 || poles.iter().skip(i + 1).all(|q| q != p));
        assert_eq!(r.regulator.is_ok(), stabilizable, "{case}: {text} {:?}", r.regulator);
        let d = r.distance_to_uncontrollable.unwrap();
        assert!(d.lower <= d.upper && (distinct.len() == n || d.upper < 1e-6), "{case}: {d:?}");
    }
}

/// Weights of inputs and measurement noises are positive, those of states and process noises not negative.
#[test]
fn weights_that_give_no_cost_are_refused() {
    let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u' }\noutputs = { y = 'x' }";
    let with = |change: fn(&mut LinearizeOptions)| {
        let mut options = LinearizeOptions::default();
        change(&mut options);
        linearize(&System::parse("m", text).unwrap(), &options)
    };
    assert!(matches!(with(|o| o.input_weights = vec![0.0]), Err(LinearizeError::Weight { positive: true, .. })));
    assert!(matches!(with(|o| o.input_weights = vec![f64::NAN]), Err(LinearizeError::Weight { .. })));
    assert!(matches!(with(|o| o.state_weights = vec![1.0, -1.0]), Err(LinearizeError::Weight { positive: false, .. })));
    assert!(matches!(with(|o| o.measurement_noise = vec![-1.0]), Err(LinearizeError::Weight { .. })));
    assert!(with(|o| o.state_weights = vec![1.0, 0.0]).unwrap().regulator.is_ok());
}

/// Nothing is said where the equations have no value or jump, by no command.
#[test]
fn points_without_values_are_refused() {
    for (equation, x, what) in [
        ("x^(1/3) + 1", "-1", "x^(1/3) has no value"),
        ("log(x)", "-1", "log(x) has no value"),
        ("tan(x)", "pi/2", "tan(x) has no value"),
        ("asin(x)", "3/2", "asin(x) has no value"),
        ("sqrt(x - sqrt(2))", "7/5", "has no value"),
        ("atan2(y, x) - pi", "-1", "atan2(y, x) jumps"),
        ("atan2(y, x)", "0", "atan2(y, x) has no value"),
        ("1/(x - 1)", "1", "has no value"),
    ] {
        let text = format!(
            "states = ['x', 'y']\ninputs = ['u']\ndynamics = {{ x = 'u', y = '{equation}' }}\n[point]\nx = '{x}'\n"
        );
        let system = System::parse("m", &text).unwrap();
        let refused = LinearModel::new(&system).unwrap_err().to_string();
        assert!(refused.contains(what), "{equation}: {refused}");
        let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
        let why = report.at_point.unwrap();
        assert!(why.known().is_none(), "{equation}");
        assert!(why.reason().unwrap().to_string().contains(what), "{equation}: {:?}", why.reason());
    }
}

#[test]
fn delays_of_inputs_are_told() {
    let text = "states = ['x']\ninputs = ['u', 'w']\ndynamics = { x = 'u + w - x' }\ndelays = { u = 0.2 }\n";
    let system = System::parse("lag.toml", text).unwrap();
    let found = linearize(&system, &LinearizeOptions::default()).unwrap();
    let delays: Vec<(&str, f64)> = found.system.input_delays.iter().map(|(name, d)| (name.as_str(), *d)).collect();
    assert_eq!(delays, [("u", 0.2)]);
}
