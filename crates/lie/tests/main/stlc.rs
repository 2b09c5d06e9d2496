//! Local controllability of systems whose answers are known.

use crate::common::{shown, system};
use bracketry_lie::controllability::{GeneralCondition, InputValues, PointReport, Side, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};

/// A system at its equilibrium 0 (if not said otherwise).
struct Case {
    name: &'static str,
    states: &'static str,
    inputs: &'static str,
    dynamics: &'static [&'static str],
    at: &'static [(&'static str, &'static str)],
    /// What is true.
    truth: Verdict,
    /// Whether a condition that is implemented decides it; else the answer is inconclusive.
    decided: bool,
}

use Verdict::{No, Yes};

const fn case(
    name: &'static str,
    states: &'static str,
    inputs: &'static str,
    dynamics: &'static [&'static str],
    truth: Verdict,
) -> Case {
    Case { name, states, inputs, dynamics, at: &[], truth, decided: true }
}

impl Case {
    const fn at(mut self, at: &'static [(&'static str, &'static str)]) -> Case {
        self.at = at;
        self
    }

    /// The truth is known by other means than the conditions that are implemented.
    const fn open(mut self) -> Case {
        self.decided = false;
        self
    }

    fn report(&self) -> Report {
        self.report_with(&AnalysisOptions::default())
    }

    fn report_with(&self, options: &AnalysisOptions) -> Report {
        let states: Vec<&str> = self.states.split(' ').collect();
        let inputs: Vec<&str> = self.inputs.split(' ').collect();
        let s = system(&states, &inputs, &[], self.dynamics, &[], Some(self.at));
        analyze_affine(&s, options).unwrap()
    }
}

fn point(report: &Report) -> &PointReport {
    report.at_point.as_ref().unwrap().known().unwrap()
}

const CASES: &[Case] = &[
    // One input. Sussmann 1983 (Lie brackets and local controllability), Kawski 1990 (High-order
    // small-time local controllability), Stefani 1986, Hermes 1982, Coron 2007 (Control and nonlinearity).
    case("ad_g^2 f", "x y", "u", &["u", "x^2"], No),
    case("ad_g^3 f", "x y", "u", &["u", "x^3"], Yes),
    case("ad_g^4 f", "x y", "u", &["u", "x^4"], No),
    case("ad_g^5 f", "x y", "u", &["u", "x^5"], Yes),
    case("cubic and quadratic", "x y", "u", &["u", "x^3 + x^2"], No),
    case("both signs", "x y", "u", &["u", "x^3 - x^4"], Yes),
    case("Sussmann 1983, x1^3 against x2^2", "x y z", "u", &["u", "x", "x^3 + y^2"], Yes),
    case("Sussmann 1983, x1^3 with x2", "x y z", "u", &["u", "x", "x^3*y^2"], Yes),
    case("position squared", "x y z", "u", &["u", "x", "y^2"], No),
    // Kawski 1990: STLC with ever more switchings, beyond Sussmann's condition.
    case("Kawski 1990, increasing switchings", "x y z w", "u", &["u", "x", "x^3/6", "y*z"], Yes).open(),
    case("position cubed", "x y z", "u", &["u", "x", "y^3"], Yes),
    case("triple integrator squared", "a b c z", "u", &["u", "a", "b", "c^2"], No),
    case("velocity and position squared", "x y z", "u", &["u", "x", "x^2 + y^2"], No),
    case("indefinite quadratic, velocity first", "x y z", "u", &["u", "x", "x^2 - y^2"], No),
    case("Coron 2007, ex. 3.17", "x y", "u", &["u", "y + x^3"], Yes),
    case("decaying square", "x y", "u", &["u", "x^2 - y"], No),
    case("square through a rotation", "x y z", "u", &["u", "z + x^2", "-y"], No),
    case("Kawski 1990, x1^3 x2: even in u and in f", "x y z", "u", &["u", "x", "x^3*y"], Yes),
    case("1 - cos", "x y", "u", &["u", "1 - cos(x)"], No),
    case("sin^3", "x y", "u", &["u", "sin(x)^3"], Yes),
    case("a field that vanishes", "x", "u", &["x*u"], No),
    case("bilinear with invariant half-line", "x y", "u", &["u", "y*u"], No),
    // Two inputs.
    case("two squares", "x y z", "u v", &["u", "v", "x^2 + y^2"], No),
    case("definite with product", "x y z", "u v", &["u", "v", "x^2 + x*y + y^2"], No),
    case("indefinite, balanced", "x y z", "u v", &["u", "v", "x^2 - y^2"], Yes),
    case("indefinite, unbalanced", "x y z", "u v", &["u", "v", "x^2 - 4*y^2"], Yes),
    case("indefinite with product", "x y z", "u v", &["u", "v", "x^2 + 3*x*y + y^2"], Yes),
    case("product", "x y z", "u v", &["u", "v", "x*y"], Yes),
    case("semidefinite form", "x y z", "u v", &["u", "v", "(x + y)^2"], No),
    case("two quadratic forms", "x y z w", "u v", &["u", "v", "x^2 - y^2", "x*y"], Yes),
    case("two quadratic forms, one definite", "x y z w", "u v", &["u", "v", "x^2 + y^2", "x*y"], No),
    case("one chain of two carries the square", "x a y b z", "u v", &["a", "u", "b", "v", "a^2 - x^2"], No),
    case("chains of different depth", "x a y z", "u v", &["a", "u", "v", "x^2 + y^2 + x*y"], No),
    case("three inputs, indefinite", "x y z w", "u v s", &["u", "v", "s", "x^2 + y^2 - z^2"], Yes),
    case("own weights", "x y z", "u v", &["u", "v", "x^2 + x*y^2 + y^3"], Yes),
    case("area against square", "x y z", "u v", &["u", "v", "x*v + x^2"], Yes),
    case("damped area", "x y z", "u v", &["u", "v", "x*v - y*u - z"], Yes),
    // Wheeled vehicles: Murray, Li, Sastry 1994; Laumond 1998.
    case("unicycle", "x y th", "u v", &["u*cos(th)", "u*sin(th)", "v"], Yes),
    case("car", "x y th p", "u v", &["u*cos(th)", "u*sin(th)", "u*tan(p)", "v"], Yes),
    case("skate", "x y th", "u v", &["u*cos(th)", "u*sin(th)", "u + v"], Yes),
    case("Brockett's integrator", "x y z", "u v", &["u", "v", "x*v - y*u"], Yes),
    case("chained form 6", "a b c d e h", "u v", &["u", "v", "b*u", "c*u", "d*u", "e*u"], Yes),
    case("Dubins at constant speed", "x y th", "u", &["cos(th)", "sin(th)", "u"], No),
    case("unicycle with speed at rest", "x y th v", "a w", &["v*cos(th)", "v*sin(th)", "w", "a"], Yes),
    case("unicycle with inertia", "x y th v w", "a b", &["v*cos(th)", "v*sin(th)", "w", "a", "b"], Yes),
    case("bicycle with speed at rest", "x y th p v", "a s", &["v*cos(th)", "v*sin(th)", "v*tan(p)", "s", "a"], Yes),
    // Bodies. Sussmann 1987, Crouch 1984, Bullo and Lewis 2004, Kerai 1995; Melody, Başar, Bullo 2003.
    case("rigid body, two torques", "a b c", "u v", &["u", "v", "a*b"], Yes),
    case("symmetric rigid body, two torques", "a b c", "u v", &["u - b*c", "v + a*c", "0"], No),
    case("rigid body, one skew torque", "a b c", "u", &["-b*c + u", "a*c + u/2", "-a*b/3 + u/3"], No),
    case("rigid body, one torque along an axis", "a b c", "u", &["b*c + u", "-2*a*c", "a*b"], No),
    case(
        "attitude with two torques",
        "r p y a b c",
        "u v",
        &["a + (b*sin(r) + c*cos(r))*tan(p)", "b*cos(r) - c*sin(r)", "(b*sin(r) + c*cos(r))/cos(p)", "u", "v", "a*b"],
        Yes,
    ),
    case(
        "attitude with two wheels, no momentum",
        "r p y",
        "u v",
        &["u + v*sin(r)*tan(p)", "v*cos(r)", "v*sin(r)/cos(p)"],
        Yes,
    ),
    case(
        "planar body, force off the center",
        "x y th a b w",
        "u v",
        &["a", "b", "w", "u*cos(th) - v*sin(th)", "u*sin(th) + v*cos(th)", "-v"],
        Yes,
    ),
    case("planar body, lateral force only", "x y th a b w", "v", &["a", "b", "w", "-v*sin(th)", "v*cos(th)", "-v"], No),
    case("hovercraft", "x y th a b w", "f t", &["a", "b", "w", "f*cos(th)", "f*sin(th)", "t"], Yes),
    case("ship with surge force and yaw torque", "a b r", "f t", &["f + b*r", "-a*r", "t"], Yes),
    case("hovering aircraft", "x y th a b w", "f t", &["a", "b", "w", "-f*sin(th)", "f*cos(th) - 1", "t"], Yes)
        .at(&[("f", "1")]),
    case(
        "hovering aircraft, thrust not given",
        "x y th a b w",
        "f t",
        &["a", "b", "w", "-f*sin(th)", "f*cos(th) - 1", "t"],
        Yes,
    ),
    case("planar body, central force only", "x y th a b w", "f", &["a", "b", "w", "f*cos(th)", "f*sin(th)", "0"], No),
    // Pendulums, balls.
    case("pendulum, upright", "q p", "u", &["p", "sin(q) + u"], Yes),
    case(
        "cart-pole",
        "x q v w",
        "u",
        &[
            "v",
            "w",
            "(u + sin(q)*(w^2 - cos(q)))/(1 + sin(q)^2)",
            "(2*sin(q) - cos(q)*(u + sin(q)*w^2))/(1 + sin(q)^2)",
        ],
        Yes,
    ),
    case("wheel pendulum", "q p r", "u", &["p", "sin(q) - u", "u"], Yes),
    case("ball and beam", "x v q w", "u", &["v", "x*w^2 - sin(q)", "w", "u"], Yes),
    case("ball on a flat beam without gravity", "x v q w", "u", &["v", "x*w^2", "w", "u"], No),
    case("ball and plate", "x a y b p r", "u v", &["a", "-sin(p)", "b", "-sin(r)", "u", "v"], Yes),
    case("TORA", "a b c d", "u", &["b", "-a + sin(c)/10", "d", "u"], Yes),
    case("no balance", "x y", "u", &["1", "u"], No),
    case("half-line", "x y", "u", &["u", "abs(x) + y^2 + x^2"], No),
];

#[test]
fn verdicts_agree_with_the_literature() {
    let mut wrong = Vec::new();
    for c in CASES {
        let report = c.report();
        let stlc = &point(&report).stlc;
        let expected = if c.decided { c.truth } else { Verdict::Inconclusive };
        // The literature takes bounded inputs.
        if stlc.with_bounded_inputs() != expected {
            wrong.push(format!("{}: {} ({}), expected {expected}", c.name, stlc.verdict, stlc.reason));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What changes where no bound is set: jumps of x, of the speed, and of the heading reverse the drift; a square, a system
/// without access, and a clock stay as they are.
#[test]
fn inputs_without_bounds_jump() {
    type Ranges = &'static [(&'static str, f64, f64)];
    let forward: Ranges = &[("s", 0.0, 1.0)];
    let cases: &[(Case, Ranges)] = &[
        (case("cubic and quadratic", "x y", "u", &["u", "x^3 + x^2"], Yes), &[]),
        (case("moving double integrator", "x v", "u", &["v", "u"], Yes).at(&[("v", "1")]), &[]),
        (case("forward unicycle", "x y th", "s w", &["s*cos(th)", "s*sin(th)", "w"], Yes), forward),
        (case("Dubins", "x y th", "u", &["cos(th)", "sin(th)", "u"], Yes), &[]),
        (case("against a square", "x y", "u v", &["u", "v - x^2"], Yes), &[("v", 0.0, f64::INFINITY)]),
        (case("square", "x y", "u", &["u", "x^2"], No), &[]),
        (case("square with damping", "x y", "u", &["u", "x^2 + x^4 - y"], No), &[]),
        (case("form", "x y z", "u v", &["u", "v", "2*x^2 - 2*x*y + y^2"], No), &[]),
        (case("wave", "x y", "u", &["u", "1 - cos(x)"], No), &[]),
        (case("clock", "x t", "u", &["u", "1"], No), &[]),
        // z − x²/2 falls behind itself only as fast as it is large: the equations of Lorenz (1963).
        (case("Lorenz", "x y z", "u", &["10*(y - x)", "28*x - y - x*z + u", "x*y - 8*z/3"], No), &[]),
        (case("no access", "x y", "u", &["u", "-y"], No), &[]),
    ];
    for (c, ranges) in cases {
        let named = ranges.iter().map(|(n, a, b)| ((*n).to_owned(), InputValues::Between(*a, *b))).collect();
        let stlc = point(&c.report_with(&AnalysisOptions { ranges: named, ..AnalysisOptions::default() })).stlc.clone();
        assert_eq!(stlc.verdict, c.truth, "{}: {}", c.name, stlc.reason);
    }
}

/// With a bound on every input the verdict of the literature stays, whatever the bound.
#[test]
fn bounded_inputs_stay_near() {
    for c in CASES.iter().filter(|c| c.decided && c.truth == No && !c.dynamics.concat().contains("abs")) {
        let ranges = c.inputs.split(' ').map(|u| (u.to_owned(), InputValues::Between(-50.0, 50.0))).collect();
        let report = c.report_with(&AnalysisOptions { ranges, ..AnalysisOptions::default() });
        assert_eq!(point(&report).stlc.verdict, No, "{}", c.name);
    }
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(24))]

    /// x' = u, y_i' = p_i(x): a jump reaches rates to all sides of 0 just where no combination of the p_i keeps its sign.
    /// One even power among odd ones decides by its sign; a product of all with one sign stays "no".
    #[test]
    fn polynomial_drifts_are_decided_by_their_signs(odd in 1i64..6, even in -5i64..6, quartic in 0i64..4) {
        let dynamics = ["u".to_owned(), format!("{odd}*x^3 + {even}*x^2 + {quartic}*x^4")];
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let s = system(&["x", "y"], &["u"], &[], &dynamics, &[], Some(&[]));
        let stlc = point(&analyze_affine(&s, &AnalysisOptions::default()).unwrap()).stlc.clone();
        // c(x) = x² (q x² + o x + e) has one sign just where o² ≤ 4 q e.
        let keeps_sign = odd * odd <= 4 * quartic * even;
        proptest::prop_assert!(stlc.verdict != if keeps_sign { Yes } else { No }, "{}", stlc.reason);
        if even == 0 || quartic == 0 {
            proptest::prop_assert_eq!(stlc.verdict, Yes);
        }
    }
}

fn named(name: &str) -> &'static Case {
    CASES.iter().find(|c| c.name == name).unwrap()
}

fn degrees(report: &Report) -> Vec<(String, usize)> {
    point(report).stlc.obstruction.as_ref().unwrap().degrees.0.clone()
}

#[test]
fn the_obstructing_bracket_is_named() {
    let report = named("ad_g^2 f").report();
    let stlc = &point(&report).stlc;
    let obstruction = stlc.obstruction.as_ref().unwrap();
    assert_eq!(stlc.general_condition, Some(GeneralCondition::Obstructed));
    assert_eq!(obstruction.bracket.to_string(), "[g1,[f,g1]]");
    assert_eq!(obstruction.weights, [1, 1]);
    assert_eq!(degrees(&report), [("f".to_owned(), 1), ("g1".to_owned(), 2)]);
    let report = named("ad_g^4 f").report();
    assert_eq!(degrees(&report), [("f".to_owned(), 1), ("g1".to_owned(), 4)]);
}

/// One input must weigh more than the other.
#[test]
fn each_input_has_its_own_weight() {
    let report = named("own weights").report();
    let stlc = &point(&report).stlc;
    let weights = stlc.weights.as_ref().unwrap();
    assert_eq!(stlc.general_condition, Some(GeneralCondition::Holds));
    assert!(weights.len() == 3 && 2 * weights[1] > 3 * weights[2], "{weights:?}");
}

/// x' = v, one-sided at 0, and systems around it.
#[test]
fn one_sided_inputs() {
    let verdict = |c: Case, ranges: &[(&str, f64, f64)]| {
        let ranges = ranges.iter().map(|(n, a, b)| ((*n).to_owned(), InputValues::Between(*a, *b))).collect();
        let report = c.report_with(&AnalysisOptions { ranges, ..AnalysisOptions::default() });
        point(&report).stlc.verdict
    };
    let above = [("v", 0.0, f64::INFINITY)];
    assert_eq!(verdict(case("integrator", "x", "v", &["v"], Yes), &[]), Yes);
    assert_eq!(verdict(case("integrator", "x", "v", &["v"], Yes), &above), No);
    assert_eq!(verdict(case("bilinear", "x", "v", &["-x + x*v"], No), &above), No);
    // In long time the oscillator is controllable (Brammer 1972), in short time it is not.
    assert_eq!(verdict(case("oscillator", "x y", "v", &["y", "v - x"], No), &above), No);
    // A square is undone by a push against it, not by one along with it.
    let bounded = [("v", 0.0, f64::INFINITY), ("u", -1.0, 1.0)];
    assert_eq!(verdict(case("against a square", "x y", "u v", &["u", "v - x^2"], Yes), &bounded), Yes);
    assert_eq!(verdict(case("with a square", "x y", "u v", &["u", "v + x^2"], No), &above), No);
    assert_eq!(verdict(case("with a square", "x y", "u v", &["u", "x^2 - v"], No), &[("v", -1.0, 0.0)]), No);
    // Thrusters in opposite directions, and one without an opponent.
    let both = [("v", 0.0, 1.0), ("w", 0.0, 1.0)];
    assert_eq!(verdict(case("opposed", "x y", "v w", &["y", "v - w"], Yes), &both), Yes);
    assert_eq!(verdict(case("aligned", "x y", "v w", &["v", "v + w"], No), &both), No);
    // The same said of the point only.
    let one_sided = vec![("v".to_owned(), Side::Above)];
    let report =
        case("", "x", "v", &["v"], No).report_with(&AnalysisOptions { one_sided, ..AnalysisOptions::default() });
    assert_eq!(point(&report).stlc.verdict, No);
    // The input that is free to both sides suffices.
    assert_eq!(verdict(case("helped", "x y", "u v", &["y", "u + v"], Yes), &above), Yes);
}

/// A rocket that hovers needs a thrust inside its range; x' = v - 1 is balanced by v = 1.
#[test]
fn inputs_that_balance_the_drift_lie_in_their_ranges() {
    let verdict = |values: Option<InputValues>| {
        let ranges = values.map(|v| ("v".to_owned(), v)).into_iter().collect();
        let report = case("", "x y", "v", &["y", "v - 1"], Yes)
            .report_with(&AnalysisOptions { ranges, ..AnalysisOptions::default() });
        point(&report).stlc.verdict
    };
    assert_eq!(verdict(None), Yes);
    assert_eq!(verdict(Some(InputValues::Between(0.0, 2.0))), Yes);
    // A thrust that cannot exceed the weight never lets the rocket rise.
    for weak in [InputValues::Between(0.0, 1.0), InputValues::Between(0.0, 0.5)] {
        assert_eq!(verdict(Some(weak)), No, "{weak:?}");
    }
    assert_eq!(verdict(Some(InputValues::Unknown)), Verdict::Inconclusive);
}

#[test]
fn a_range_of_no_input_is_an_error() {
    let s = system(&["x"], &["u"], &[], &["u"], &[], Some(&[]));
    let options =
        AnalysisOptions { ranges: vec![("w".to_owned(), InputValues::Unknown)], ..AnalysisOptions::default() };
    assert_eq!(analyze_affine(&s, &options).unwrap_err().to_string(), "there is no input w for this range");
}

#[test]
fn uncontrollable_modes_and_what_they_act_on() {
    let modes = |dynamics: &'static [&'static str]| {
        let report = case("", "x y z", "u", dynamics, No).report();
        let modes = point(&report).uncontrollable_modes.clone().unwrap();
        modes.known().unwrap().iter().map(|m| (m.re, m.im, m.multiplicity, shown(&m.combinations))).collect::<Vec<_>>()
    };
    assert_eq!(modes(&["y", "z", "u"]), []);
    assert_eq!(modes(&["u - x", "u - y/3", "z/2"]), [(0.5, 0.0, 1, vec!["z".to_owned()])]);
    assert_eq!(modes(&["u - 3*x", "2*u - 3*y", "u"]), [(-3.0, 0.0, 1, vec!["y - 2*x".to_owned()])]);
    assert_eq!(modes(&["u", "-y", "-z"]), [(-1.0, 0.0, 2, vec!["y".to_owned(), "z".to_owned()])]);
    let rotation = modes(&["u", "z", "-4*y"]);
    assert_eq!(rotation.len(), 2);
    assert!(rotation.iter().all(|m| m.0 == 0.0 && (m.1.abs() - 2.0).abs() < 1e-9 && m.3.is_empty()));
}

/// Brockett 1983; attitude with two torques: Byrnes and Isidori 1991; x' = x + u^3: Kawski 1989.
/// Maps onto a neighborhood of 0 without being submersions: odd powers in triangular form, powers of a complex number; and
/// the same with an even power in place of an odd one, which is open or "no".
#[test]
fn brockett_condition_by_the_local_degree() {
    let condition = |states: &[&str], inputs: &[&str], rhs: &[&str]| {
        let s = crate::common::system(states, inputs, &[], rhs, &[], Some(&[]));
        let report = bracketry_lie::analyze_affine(&s, &AnalysisOptions::default()).unwrap();
        report.at_point.unwrap().known().unwrap().brockett_condition.clone().unwrap().known().copied()
    };
    for (k, holds) in [(3, true), (5, true), (2, false), (4, false)] {
        let power = format!("y^{k}");
        let mixed = format!("y^{k}*(1 + z) + z*y^{k}");
        let triangular = format!("z + x^2 + y^{k}");
        for rhs in [[power.as_str(), "u"], [&mixed, "u"]] {
            let found = condition(&["x", "y", "z"], &["u", "w"], &[rhs[0], rhs[1], "w"]);
            if holds { assert_eq!(found, Some(true), "{rhs:?}") } else { assert_ne!(found, Some(true), "{rhs:?}") }
        }
        let found = condition(&["x", "y", "z"], &["u"], &[&power, "u", &triangular]);
        if holds { assert_eq!(found, Some(true), "{k}") } else { assert_ne!(found, Some(true), "{k}") }
    }
    // (y + i z)², and a form that does not turn.
    assert_eq!(condition(&["a", "b", "y", "z"], &["u", "v"], &["y^2 - z^2", "2*y*z", "u", "v"]), Some(true));
    assert_ne!(condition(&["a", "b", "y", "z"], &["u", "v"], &["y^2 + z^2", "2*y*z", "u", "v"]), Some(true));
}

#[test]
fn brockett_condition() {
    let condition = |name: &str| point(&named(name).report()).brockett_condition.clone().unwrap();
    for fails in [
        "unicycle",
        "car",
        "Brockett's integrator",
        "skate",
        "unicycle with inertia",
        "unicycle with speed at rest",
        "attitude with two torques",
        "hovercraft",
        "ad_g^2 f",
        "two squares",
    ] {
        assert_eq!(condition(fails), Answer::Known(false), "{fails}");
    }
    for holds in ["pendulum, upright", "cart-pole", "ball and beam"] {
        assert_eq!(condition(holds), Answer::Known(true), "{holds}");
    }
    assert_eq!(condition("ad_g^3 f"), Answer::Known(true));
    // It holds for these as well, whether or not a test here sees it.
    for holds in ["rigid body, two torques", "rigid body, one torque along an axis"] {
        assert_ne!(condition(holds), Answer::Known(false), "{holds}");
    }
}

#[test]
fn lie_algebras_over_the_constants() {
    let algebra = |name: &str| named(name).report().lie_algebra.map(|a| (a.dimension, a.nilpotent_length));
    assert_eq!(algebra("Brockett's integrator"), Some((3, Some(2))));
    assert_eq!(algebra("chained form 6"), Some((6, Some(5))));
    assert_eq!(algebra("unicycle"), Some((3, None)));
    assert_eq!(algebra("ad_g^2 f"), Some((4, Some(3))));
    assert_eq!(algebra("pendulum, upright"), None);
}
