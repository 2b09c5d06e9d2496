//! What switching reaches, and what holds where switching functions vanish.

use crate::common::{ratio, shown, system};
use bracketry_lie::analysis::mode_fields;
use bracketry_lie::controllability::{InputValues, PointReport, SwitchingTheorem, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, Evidence, Report, VectorFields, analyze_affine};
use bracketry_symbolic::Rational;
use bracketry_system::System;

const PARAMETERS: [&str; 3] = ["k1", "k2", "mu"];

fn model(states: &str, inputs: &str, dynamics: &[&str]) -> System {
    let states: Vec<&str> = states.split_whitespace().collect();
    let inputs: Vec<&str> = inputs.split_whitespace().collect();
    let values = [ratio(2, 1), ratio(5, 1), ratio(1, 2)];
    let parameters: Vec<(&str, Rational)> = PARAMETERS.into_iter().zip(values).collect();
    system(&states, &inputs, &parameters, dynamics, &[], Some(&[]))
}

fn report(states: &str, inputs: &str, dynamics: &[&str]) -> Report {
    analyze_affine(&model(states, inputs, dynamics), &AnalysisOptions::default()).unwrap()
}

/// Accessible and strongly accessible dimension over all modes, where both are known.
fn over_all_modes(r: &Report) -> Option<(usize, usize)> {
    let d = &r.switched.as_ref().unwrap().dimensions;
    Some((*d.accessible_dimension.known()?, *d.strongly_accessible_dimension.known()?))
}

fn at_point(r: &Report) -> &PointReport {
    r.at_point.as_ref().unwrap().known().unwrap()
}

fn verdict(states: &str, inputs: &str, dynamics: &[&str]) -> Verdict {
    at_point(&report(states, inputs, dynamics)).stlc.verdict
}

/// Small integers from −3 to 3 and choices (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % n
    }

    fn small(&mut self) -> i64 {
        self.below(7) as i64 - 3
    }

    fn positive(&mut self) -> i64 {
        self.below(3) as i64 + 1
    }

    /// A polynomial of degree two in these.
    fn polynomial(&mut self, of: &[&str]) -> String {
        let mut terms = vec![self.small().to_string()];
        for (k, a) in of.iter().enumerate() {
            terms.push(format!("{}*{a}", self.small()));
            for b in &of[..=k] {
                if self.below(3) == 0 {
                    terms.push(format!("{}*{a}*{b}", self.small()));
                }
            }
        }
        terms.join(" + ").replace("+ -", "- ")
    }
}

#[test]
fn a_spring_that_switches_keeps_its_energy_balance() {
    let r = report("x v E", "u", &["v", "u - k1*max(x,0) - k2*min(x,0)", "u*v"]);
    assert_eq!(over_all_modes(&r), Some((2, 2)));
    let s = r.switched.as_ref().unwrap();
    assert_eq!(s.strongly_accessible_by, SwitchingTheorem::NoGain);
    assert_eq!((s.autonomous_not_found, s.autonomous.known().unwrap().len()), (None, 1));
    // v² + k1 max(x, 0)² + k2 min(x, 0)² − 2E
    let mut p = bracketry_symbolic::Pool::new();
    let found = p.parse(&s.autonomous.known().unwrap()[0].to_string()).unwrap();
    for (x, energy) in [("3", "(v^2 + 9*k1)/2"), ("-2", "(v^2 + 4*k2)/2"), ("0", "v^2/2")] {
        let (x, energy) = (p.parse(x).unwrap(), p.parse(energy).unwrap());
        let at = [(p.var("x"), x), (p.var("E"), energy)].into_iter().collect();
        let value = p.substitute(found, &at);
        let value = p.expand(value);
        assert!(p.is_zero(value), "{}", p.text(value));
    }
    assert_eq!(s.only_by_switching, Answer::Known(Vec::new()));
    assert_eq!(shown(&s.dimensions.strong_basis), ["g1", "[f(1),g1]"]);
    assert_eq!(at_point(&r).stlc.verdict, Verdict::No);
    assert!(at_point(&r).stlc.reason.to_string().ends_with("is constant in every mode at the point"));
    // A dead zone has two surfaces.
    let r = report("x v E", "u", &["v", "u - k1*(max(x-1,0) + min(x+1,0))", "u*v"]);
    assert_eq!(over_all_modes(&r), Some((2, 2)));
    assert_eq!(r.switched.unwrap().autonomous.known().unwrap().len(), 1);
}

#[test]
fn kinks_and_jumps_of_one_input_are_not_two_inputs() {
    let r = report("x y", "u", &["u", "u*abs(x)"]);
    assert_eq!(over_all_modes(&r), Some((1, 1)));
    assert_eq!(r.switched.as_ref().unwrap().autonomous.known().unwrap()[0], "2*y - x*abs(x)");
    let r = report("x y", "u", &["u", "u*sign(x)"]);
    assert_eq!(over_all_modes(&r), Some((1, 1)));
    assert_eq!(r.switched.as_ref().unwrap().autonomous.known().unwrap()[0], "y - abs(x)");
    assert_eq!(at_point(&r).stlc.verdict, Verdict::No);
    // Never promised without a theorem: here the surface is solved for no state.
    let r = report("x y", "u", &["u", "u*sign(x^2 - 1)"]);
    assert_ne!(over_all_modes(&r), Some((2, 2)));
}

#[test]
fn switching_gains_where_the_modes_are_met_again_and_again() {
    // The share of time on either side of x = 0 is free.
    let r = report("x v y", "u", &["v", "u", "sign(x)"]);
    assert_eq!(over_all_modes(&r), Some((3, 3)));
    assert_eq!(r.switched.unwrap().strongly_accessible_by, SwitchingTheorem::SurfaceClosure);
    // Friction of the velocity: the input crosses v = 0 at will.
    let r = report("x v E", "u", &["v", "u - mu*sign(v)", "u*v"]);
    assert_eq!(over_all_modes(&r), Some((3, 3)));
    assert_eq!(r.switched.unwrap().strongly_accessible_by, SwitchingTheorem::CommonField);
    // A clock that switches what the state itself decides: nothing is chosen.
    let r = report("x y z", "u", &["1", "u", "sign(x)"]);
    assert_eq!(over_all_modes(&r), Some((2, 1)));
}

#[test]
fn without_inputs_switching_chooses_nothing() {
    let r = report("p q", "", &["-mu*sign(p - q)", "mu*sign(p - q)"]);
    assert_eq!(over_all_modes(&r), Some((1, 0)));
    let s = r.switched.unwrap();
    assert_eq!(s.only_by_switching, Answer::Known(Vec::new()));
    assert!(s.autonomous.known().unwrap().iter().any(|f| *f == "p + q"));
}

/// y = w + p + |s| q with a smooth system for s and z and with w' = 0: y − p − |s| q never changes, whatever the system, and the
/// rest is reached as without y.
#[test]
fn hidden_functions_that_are_glued_from_two_pieces_are_kept() {
    let mut random = Random(0x5eed_0001);
    for round in 0..16 {
        let speed = if round % 2 == 0 { "z".to_owned() } else { format!("z + {}*s", random.small()) };
        let force = format!("u*({}) + {}", random.positive(), random.polynomial(&["s", "z"]));
        let (p, q) = (random.polynomial(&["s", "z"]), random.polynomial(&["z"]));
        let mut pool = bracketry_symbolic::Pool::new();
        let states = ["s", "z"].map(|n| pool.symbol(n));
        let rates = [pool.parse(&speed).unwrap(), pool.parse(&force).unwrap()];
        let mut along = |text: &str| {
            let e = pool.parse(text).unwrap();
            let e = pool.lie_derivative(e, &states, &rates);
            pool.text(e)
        };
        let (smooth, kink) = (along(&p), along(&format!("s*({q})")));
        let glued = format!("{smooth} + sign(s)*({kink})");
        // In other coordinates: s = a + c b², z = b.
        let c = random.small();
        let changed = |text: &str| {
            let mut pool = bracketry_symbolic::Pool::new();
            let e = pool.parse(text).unwrap();
            let (s, z) = (pool.parse(&format!("a + {c}*b^2")).unwrap(), pool.var("b"));
            let at = [(pool.var("s"), s), (pool.var("z"), z)].into_iter().collect();
            let e = pool.substitute(e, &at);
            pool.text(e)
        };
        let dynamics = [changed(&format!("{speed} - 2*{c}*z*({force})")), changed(&force), changed(&glued)];
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let base = report("s z", "u", &[&speed, &force]);
        let d = &base.modes[0].dimensions;
        let wanted = (*d.accessible_dimension.known().unwrap(), *d.strongly_accessible_dimension.known().unwrap());
        let r = report("a b y", "u", &dynamics);
        if r.switched.is_none() {
            continue; // q vanished
        }
        assert_eq!(over_all_modes(&r), Some(wanted), "{dynamics:?}");
        assert_ne!(at_point(&r).stlc.verdict, Verdict::Yes, "{dynamics:?}");
        let s = r.switched.unwrap();
        let known = s.autonomous.known().unwrap().len() + s.autonomous_not_found.unwrap_or(0);
        assert_eq!(known, 3 - wanted.1, "{dynamics:?}");
    }
}

/// v' = u + …, with all jumps at v = 0: the union of the modes' fields is right.
#[test]
fn friction_of_the_velocity_reaches_what_all_modes_together_do() {
    let mut random = Random(0x5eed_0002);
    for _ in 0..12 {
        let jump = |r: &mut Random| format!("{}*sign(v)", r.small());
        let dynamics = [
            "v".to_owned(),
            format!("u + {} + {}", random.polynomial(&["x", "v"]), jump(&mut random)),
            format!("{} + {}", random.polynomial(&["x", "v"]), jump(&mut random)),
            format!("({})*({})", random.polynomial(&["x", "y"]), jump(&mut random)),
        ];
        let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
        let mut original = model("x v y z", "u", &dynamics);
        let family: Vec<VectorFields> = mode_fields(&mut original).unwrap().into_iter().map(|m| m.fields).collect();
        if family.len() == 1 {
            continue;
        }
        let all = VectorFields::switched(&mut original.pool, &family).unwrap();
        let mut evidence = Evidence::default();
        let wanted = (
            all.accessibility(&mut original.pool, &mut evidence).unwrap().dimension(),
            all.strong_accessibility(&mut original.pool, &mut evidence).unwrap().dimension(),
        );
        let r = report("x v y z", "u", &dynamics);
        assert_eq!(over_all_modes(&r), Some(wanted), "{dynamics:?}");
    }
}

#[test]
fn what_no_mode_lowers_is_not_lowered() {
    for kinks in
        ["max(x,0)", "x + abs(x)", "abs(x) - x", "max(x,0) + max(z,0)", "max(x,0)^2 + abs(z)^3", "abs(x)*(1 + z^2)"]
    {
        let r = report("x z y", "u w", &["u", "w", kinks]);
        let p = at_point(&r);
        assert_eq!((p.stlc.verdict, p.equilibrium.known()), (Verdict::No, Some(&true)), "{kinks}");
        assert_eq!(p.stabilizable, Some(Answer::Known(false)), "{kinks}");
        assert_eq!(p.brockett_condition, Some(Answer::Known(false)), "{kinks}");
    }
    // Falls on one side.
    for kinks in ["x - max(x,0)/2", "max(x,0) + z", "abs(x) - 2*abs(z)"] {
        let p = report("x z y", "u w", &["u", "w", kinks]);
        assert_ne!(at_point(&p).stlc.verdict, Verdict::No, "{kinks}");
        assert_ne!(at_point(&p).stabilizable, Some(Answer::Known(false)), "{kinks}");
    }
    // A striker that only pushes, and with a damper: y falls, but not below 0.
    assert_eq!(verdict("x v p", "u", &["v", "u", "k1*max(x,0)"]), Verdict::No);
    let p = report("x y", "u", &["u", "max(x,0) - y"]);
    assert_eq!(at_point(&p).stlc.verdict, Verdict::No);
    assert_ne!(at_point(&p).stabilizable, Some(Answer::Known(false)));
}

/// Σ c_i max(a_i·x, 0) with c_i > 0, in random linear coordinates.
#[test]
fn sums_of_kinks_push_to_one_side_in_all_coordinates() {
    let mut random = Random(0x5eed_0003);
    for _ in 0..12 {
        let (a, b, c, d) = (random.small(), random.small(), random.positive(), random.positive());
        let kinks = format!("{c}*max({a}*x + {b}*z,0) + {d}*max({b}*x - z,0)");
        let direct = report("x z y", "u w", &["u", "w", &kinks]);
        assert_eq!(at_point(&direct).stlc.verdict, Verdict::No, "{kinks}");
        // Y = y + k x: the half-space is λ = (−k, 0, 1).
        let k = random.small();
        let moved = report("x z y", "u w", &["u", "w", &format!("{k}*u + {kinks}")]);
        assert_eq!(at_point(&moved).stlc.verdict, Verdict::No, "{k} {kinks}");
        assert_eq!(at_point(&moved).stabilizable, Some(Answer::Known(false)), "{k} {kinks}");
    }
}

/// A chain of integrators with everything that switches beside the input.
#[test]
fn what_the_inputs_cancel_does_not_matter() {
    let mut random = Random(0x5eed_0004);
    for _ in 0..8 {
        let smooth = random.polynomial(&["v", "x"]).split_once(' ').unwrap().1.to_owned();
        let kinks =
            format!("{}*max(x,0) + {}*abs(v) + {}*abs(x - v)", random.small(), random.small(), random.positive());
        let force = format!("u + 0 {smooth} + {kinks}");
        let r = report("x v", "u", &["v", &force]);
        let p = at_point(&r);
        assert_eq!(p.stlc.verdict, Verdict::Yes, "{force}: {}", p.stlc.reason);
        assert_eq!(p.stabilizable, Some(Answer::Known(true)), "{force}");
        assert_eq!(p.brockett_condition, Some(Answer::Known(true)), "{force}");
        let r = report("x v", "u", &["v", &format!("{force} - {}*sign(v)", random.positive())]);
        assert_eq!(at_point(&r).stlc.verdict, Verdict::Yes, "{force}");
        // What is left may fail.
        let r = report("v y", "u", &[&format!("u + {}*abs(v)", random.positive()), "v^2"]);
        assert_eq!(at_point(&r).stlc.verdict, Verdict::No);
    }
    // Not canceled, and not decided.
    assert_eq!(verdict("x v y", "u", &["v", "u", "sign(x)"]), Verdict::Inconclusive);
}

#[test]
fn friction_holds_what_bounded_forces_do_not_overcome() {
    let judge = |dynamics: [&str; 2], range: f64| {
        let ranges = vec![("F".to_owned(), InputValues::Between(-range, range))];
        let options = AnalysisOptions { ranges, ..AnalysisOptions::default() };
        let r = analyze_affine(&model("x v", "F", &dynamics), &options).unwrap();
        let p = at_point(&r).clone();
        assert_eq!(p.equilibrium, Answer::Known(true));
        p
    };
    let mut random = Random(0x5eed_0005);
    for _ in 0..6 {
        let (mu, k) = (random.positive(), random.small());
        let force = format!("F - {mu}*sign(v) + {k}*x");
        let held = judge(["v", &force], mu as f64 - 0.5);
        assert_eq!(held.stlc.verdict, Verdict::No, "{force}");
        assert!(held.stlc.reason.to_string().contains("the motion stays on v = 0"), "{}", held.stlc.reason);
        assert_eq!(judge(["v", &force], mu as f64 + 0.5).stlc.verdict, Verdict::Yes, "{force}");
        assert_eq!(verdict("x v", "F", &["v", &force]), Verdict::Yes);
    }
    // A constant force below the friction: v = 0 is held, above it is not.
    let p = report("v y", "u", &["1/3 - mu*sign(v)", "u"]);
    assert_eq!((at_point(&p).stlc.verdict, &at_point(&p).equilibrium), (Verdict::No, &Answer::Known(true)));
    let p = report("v y", "u", &["2 - mu*sign(v)", "u"]);
    assert_eq!(at_point(&p).equilibrium, Answer::Known(false));
}

#[test]
fn small_inputs_do_not_overcome_a_jump() {
    let mut random = Random(0x5eed_0011);
    for _ in 0..8 {
        let (mu, gain, cubic) = (random.positive(), random.positive(), random.small());
        let judge = |range: Option<f64>| {
            let ranges = range.map(|r| ("F".to_owned(), InputValues::Between(-r, r)));
            let options = AnalysisOptions { ranges: ranges.into_iter().collect(), ..AnalysisOptions::default() };
            let equation = format!("{gain}*F - {mu}*sign(v) + {cubic}*x^3");
            at_point(&analyze_affine(&model("x v", "F", &["v", &equation]), &options).unwrap()).stlc.clone()
        };
        // The jump is canceled by inputs of its size, and the motion does not leave v = 0 with smaller ones.
        let free = judge(None);
        assert_eq!((free.verdict, free.with_bounded_inputs()), (Verdict::Yes, Verdict::No), "{free:?}");
        assert_eq!(judge(Some(2.0 * mu as f64 / gain as f64)).with_bounded_inputs(), Verdict::Yes);
        // Inputs that just hold the jump do not drive the motion away either, where no force depends on the state.
        if cubic == 0 {
            assert_eq!(judge(Some(mu as f64 / gain as f64)).verdict, Verdict::No);
        }
        // A difference of the modes that vanishes on the surface takes small inputs only.
        let r = report("x v", "F", &["v", &format!("F - {mu}*v*abs(v)")]);
        assert_eq!(at_point(&r).stlc.with_bounded_inputs(), Verdict::Yes);
    }
}

/// What no mode changes, or rest that the inputs cannot end, keeps states near the point from it.
#[test]
fn what_does_not_change_in_any_mode_excludes_stabilization() {
    for rates in [["u", "u*abs(x)"], ["u", "u*sign(x)"], ["u", "3*u*max(x, 0)"]] {
        let p = report("x y", "u", &rates);
        assert_eq!(at_point(&p).stabilizable, Some(Answer::Known(false)), "{rates:?}");
    }
    let sliding = |range: f64| {
        let system = system(&["x", "v"], &["F"], &[], &["v", "F - 2*sign(v)"], &[], Some(&[]));
        let ranges = vec![("F".to_owned(), InputValues::Between(-range, range))];
        let options = AnalysisOptions { ranges, ..AnalysisOptions::default() };
        analyze_affine(&system, &options).unwrap()
    };
    assert_eq!(at_point(&sliding(1.5)).stabilizable, Some(Answer::Known(false)));
    assert_ne!(at_point(&sliding(2.5)).stabilizable, Some(Answer::Known(false)));
}

/// A root that ends at the kink: the flow over a weir never falls.
#[test]
fn a_root_at_a_kink_has_a_sign() {
    for exponent in ["1.5", "0.5", "2.5"] {
        let p = report("h q", "u", &["u", &format!("max(h, 0)^{exponent}")]);
        assert_eq!(at_point(&p).stlc.with_bounded_inputs(), Verdict::No, "{exponent}");
        assert_eq!(at_point(&p).stabilizable, Some(Answer::Known(false)), "{exponent}");
    }
}

/// x' = u, y' = |x|, max(x, 0) or x + |x| in coordinates Y = y + a sin(x) + b x²: y never falls in any mode.
#[test]
fn one_way_functions_at_kinks_need_no_coordinates() {
    for kink in ["abs(x)", "max(x, 0)", "x + abs(x)"] {
        for (a, b) in [(2, 0), (0, 3), (-1, 2)] {
            let rate = format!("{kink} + {a}*cos(x)*u + 2*{b}*x*u");
            let p = report("x y", "u", &["u", &rate]);
            assert_eq!(at_point(&p).stlc.with_bounded_inputs(), Verdict::No, "{rate}");
            assert_eq!(at_point(&p).stabilizable, Some(Answer::Known(false)), "{rate}");
        }
    }
    // It falls where the kink has both signs.
    for rate in ["x*abs(x) + 2*cos(x)*u", "2*x + abs(x) + 2*cos(x)*u"] {
        let p = report("x y", "u", &["u", rate]);
        assert_ne!(at_point(&p).stlc.verdict, Verdict::No, "{rate}");
    }
}

/// Inputs without drift that cross a kink: z' = (p x + q |x|) v + r x u, Z = z + r y², is STLC if and only if a mode has the bracket
/// p ± q ≠ 0 across x.
#[test]
fn inputs_without_drift_cross_a_kink() {
    for (p, q) in [(0, 1), (1, 1), (1, -1), (-2, 1), (3, 2)] {
        for (r, c) in [(0, 0), (1, -1), (-2, 3)] {
            let rate = format!("({p}*x + {q}*abs(x))*v + 2*{r}*y*v");
            let dynamics = [format!("u + {c}*y*v"), "v".to_owned(), rate];
            let dynamics: Vec<&str> = dynamics.iter().map(String::as_str).collect();
            assert_eq!(verdict("x y Z", "u v", &dynamics), Verdict::Yes, "{dynamics:?}");
        }
    }
    // With a drift, what rises does not come back; and |y| v alone moves Z as a function of y.
    assert_eq!(verdict("x y z", "u v", &["u", "v", "abs(x)"]), Verdict::No);
    assert_eq!(verdict("x y z", "u v", &["u", "v", "abs(y)*v"]), Verdict::No);
}

/// h = y + c x² with h' = k max(σ, 0) or k |σ|, σ = x + d h², never falls for k > 0, and never rises for k < 0.
#[test]
fn a_rate_that_is_a_multiple_of_a_curved_switching_function_has_one_sign() {
    for (c, d) in [(1, 1), (-2, 1), (1, -3), (3, 2)] {
        for kink in ["max(s, 0)", "abs(s)", "-2*max(s, 0)", "(2 + sin(x))*abs(s)"] {
            let rate = kink.replace("(s", &format!("(x + ({d})*(y + ({c})*x^2)^2"));
            let system = system(&["x", "y"], &["u"], &[], &["u", &format!("{rate} - 2*({c})*x*u")], &[], Some(&[]));
            let report = analyze_affine(&system, &AnalysisOptions::default()).unwrap();
            let point = report.at_point.unwrap().known().cloned().unwrap();
            assert_eq!(point.stlc.verdict, Verdict::No, "{c} {d} {kink}: {}", point.stlc.reason);
        }
    }
}

/// Inside a mode, inputs without bounds may lead to another one: its equations say nothing of them.
#[test]
fn one_mode_says_nothing_of_inputs_that_lead_to_another() {
    let judge = |dynamics: &[&str], range: Option<f64>| {
        let ranges = range.map(|r| ("u".to_owned(), InputValues::Between(-r, r)));
        let options = AnalysisOptions { ranges: ranges.into_iter().collect(), ..AnalysisOptions::default() };
        at_point(&analyze_affine(&model("x y", "u", dynamics), &options).unwrap()).stlc.clone()
    };
    for (rate, near) in [
        // One sign in all modes, or another one in a mode far away.
        ("x^2*max(x + 2, 0)", Verdict::No),
        ("x^2*abs(x + 1)", Verdict::No),
        ("x^2*sign(x + 2)", Verdict::No),
        ("x^2 - 100*max(-x - 2, 0)", Verdict::No),
        ("max(x - 1, 0) - 100*max(-x - 1, 0)", Verdict::No),
        ("x^3*abs(x + 1)", Verdict::Yes),
    ] {
        let free = judge(&["u", rate], None);
        assert_eq!(free.verdict == Verdict::Yes, near == Verdict::Yes, "{rate}: {free:?}");
        assert_ne!(free.verdict, Verdict::No, "{rate}: {free:?}");
        assert_eq!(free.with_bounded_inputs(), near, "{rate}: {free:?}");
        assert_eq!(judge(&["u", rate], Some(1.0)).verdict, near, "{rate}");
    }
    // No mode moves y.
    assert_eq!(judge(&["u + abs(x + 1)", "0"], None).verdict, Verdict::No);
}
