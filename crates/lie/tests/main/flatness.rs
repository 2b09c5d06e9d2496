//! Dynamic extension and flatness of systems whose answer is known.

use crate::common::{fields, ratio, shown, system};
use bracketry_lie::feedback::{ExtensionLimits, FlatnessReport, FlatnessVerdict};
use bracketry_lie::{AnalysisOptions, Evidence, Function, VectorFields, analyze_affine};
use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};
use bracketry_system::System;

fn flatness(s: &System) -> FlatnessReport {
    analyze_affine(s, &AnalysisOptions::default()).unwrap().control.flatness.unwrap()
}

fn verdict(s: &System) -> FlatnessVerdict {
    flatness(s).verdict
}

/// Whether the relative degrees of the flat outputs add up to the extended dimension.
fn adds_up(s: &System, f: &FlatnessReport) -> bool {
    let integrators: usize = f.dynamic_extension.as_ref().unwrap().0.iter().map(|e| e.1).sum();
    f.relative_degree.iter().sum::<usize>() == s.states.len() + integrators
}

fn driftless(states: &[&str], inputs: &[&str], rhs: &[&str]) -> System {
    system(states, inputs, &[], rhs, &[], None)
}

/// The rates of a compensator as equations.
fn equations(rates: &[(String, Function)]) -> Vec<String> {
    rates.iter().map(|(state, rate)| format!("{state}' = {rate}")).collect()
}

#[test]
fn without_the_search_for_flat_outputs_the_dimensions_are_the_same() {
    let unicycle = driftless(&["x", "y", "th"], &["v", "w"], &["v*cos(th)", "v*sin(th)", "w"]);
    let whole = analyze_affine(&unicycle, &AnalysisOptions::default()).unwrap();
    let dimensions =
        analyze_affine(&unicycle, &AnalysisOptions { flatness: false, ..AnalysisOptions::default() }).unwrap();
    assert!(whole.control.flatness.is_some() && dimensions.control.flatness.is_none());
    assert_eq!(dimensions.modes, whole.modes);
}

#[test]
fn unicycle() {
    let s = system(&["x", "y", "th"], &["v", "w"], &[], &["v*cos(th)", "v*sin(th)", "w"], &["x", "y"], None);
    let report = analyze_affine(&s, &AnalysisOptions::default()).unwrap().control;
    let e = report.dynamic_extension.unwrap();
    assert_eq!(e.integrators.0, [("v".to_owned(), 1)]);
    assert_eq!((e.relative_degree, e.dimension, e.linearizes), (vec![2, 2], 4, true));
    assert_eq!(
        (equations(&e.compensator), e.inputs),
        (vec!["v' = vd".to_owned()], vec!["vd".to_owned(), "w".to_owned()])
    );
    let f = report.flatness.unwrap();
    assert_eq!((f.verdict, shown(&f.flat_outputs).join(", ")), (FlatnessVerdict::Yes, "x, y".to_owned()));
    assert_eq!(f.singular_set.as_ref().unwrap().to_string(), "v = 0");
}

/// Rouchon, Fliess, Lévine & Martin 1993.
#[test]
fn tractor_with_trailers_is_flat_by_the_last_axle() {
    let s = driftless(
        &["x", "y", "t0", "t1", "t2"],
        &["v", "w"],
        &[
            "v*cos(t0 - t1)*cos(t1 - t2)*cos(t2)",
            "v*cos(t0 - t1)*cos(t1 - t2)*sin(t2)",
            "w",
            "v*sin(t0 - t1)",
            "v*cos(t0 - t1)*sin(t1 - t2)",
        ],
    );
    let f = flatness(&s);
    assert_eq!(f.flat_outputs, ["x", "y"]);
    assert_eq!(f.dynamic_extension.as_ref().unwrap().0, [("v".to_owned(), 3)]);
    assert_eq!(f.relative_degree, [4, 4]);
    // The new state is the speed of the last axle.
    assert_eq!(f.singular_set.as_ref().unwrap().to_string(), "z1 = 0");
}

#[test]
fn car_seen_from_its_front_axle() {
    let s = driftless(&["x", "y", "th", "ph"], &["v", "w"], &["v*cos(th + ph)", "v*sin(th + ph)", "v*sin(ph)", "w"]);
    let f = flatness(&s);
    assert_eq!(f.verdict, FlatnessVerdict::Yes);
    assert_eq!(f.flat_outputs.len(), 2, "{f:?}");
    assert!(adds_up(&s, &f));
}

#[test]
fn without_drift_two_inputs_are_flat_just_when_the_derived_flag_grows_by_one() {
    let chained = driftless(&["a", "b", "c", "d", "e"], &["u", "v"], &["u", "v", "b*u", "c*u", "d*u"]);
    let f = flatness(&chained);
    assert_eq!((f.verdict, shown(&f.flat_outputs).join(", ")), (FlatnessVerdict::Yes, "a, e".to_owned()));
    assert!(adds_up(&chained, &f));
    // Growth 2, 3, 5 (Cartan 1910): no pair of functions of state and inputs is flat.
    let cartan = driftless(&["a", "b", "c", "d", "e"], &["u", "v"], &["u", "v", "b*u", "c*u", "c*v"]);
    let f = flatness(&cartan);
    assert_eq!(f.verdict, FlatnessVerdict::No);
    assert!(f.reason.to_string().contains("2, 3, 5"), "{}", f.reason);
}

#[test]
fn ball_rolling_on_a_plate_is_not_flat() {
    // Rolling without slipping or spinning, spherical coordinates (Montana 1988): growth 2, 3, 5.
    let s = driftless(
        &["x", "y", "u", "v", "ps"],
        &["a", "b"],
        &["a", "b", "(a*cos(ps) - b*sin(ps))", "(-a*sin(ps) - b*cos(ps))/cos(u)", "tan(u)*(a*sin(ps) + b*cos(ps))"],
    );
    assert_eq!(verdict(&s), FlatnessVerdict::No);
}

/// Hauser, Sastry & Meyer 1992; the flat outputs are Huygens' center of oscillation (Martin, Devasia & Paden 1996).
fn vtol(outputs: &[&str]) -> System {
    system(
        &["x", "y", "th", "vx", "vy", "w"],
        &["u1", "u2"],
        &[("gr", ratio(981, 100)), ("ep", ratio(1, 2))],
        &["vx", "vy", "w", "-sin(th)*u1 + ep*cos(th)*u2", "cos(th)*u1 + ep*sin(th)*u2 - gr", "u2"],
        outputs,
        None,
    )
}

#[test]
fn huygens_center_of_oscillation_is_found_and_verified() {
    for outputs in [&["x - ep*sin(th)", "y + ep*cos(th)"][..], &["x", "y"], &[]] {
        let s = vtol(outputs);
        let f = flatness(&s);
        assert_eq!(f.flat_outputs[0], "x - ep*sin(th)");
        assert!(["y + ep*cos(th)", "ep*cos(th) + y"].contains(&f.flat_outputs[1].to_string().as_str()));
        assert_eq!(f.dynamic_extension.as_ref().unwrap().0, [("u1".to_owned(), 2)]);
        assert_eq!(f.relative_degree, [4, 4]);
        // u1 = z + ep w², as in the literature, up to the name of the second integrator.
        assert_eq!(equations(&f.compensator), ["u1' = 2*ep*u2*w + z1", "z1' = z1d"]);
    }
}

#[test]
fn load_of_a_crane_with_a_winch() {
    let s = system(
        &["x", "r", "th", "vx", "vr", "w"],
        &["F", "T"],
        &[("M", ratio(2, 1)), ("m", ratio(1, 1)), ("g", ratio(981, 100))],
        &[
            "vx",
            "vr",
            "w",
            "(F - T*sin(th))/M",
            "r*w^2 + g*cos(th) - T/m - sin(th)*(F - T*sin(th))/M",
            "(-2*vr*w - g*sin(th) - cos(th)*(F - T*sin(th))/M)/r",
        ],
        &[],
        None,
    );
    let f = flatness(&s);
    assert_eq!(f.verdict, FlatnessVerdict::Yes);
    assert!(f.flat_outputs.iter().any(|h| *h == "r*cos(th)"), "{f:?}");
    assert!(adds_up(&s, &f));
}

#[test]
fn quadrotor_in_space_by_position_and_yaw() {
    let s = system(
        &["x", "y", "z", "a", "b", "c", "ph", "th", "ps", "p", "q", "r"],
        &["T", "L", "M", "N"],
        &[("m", ratio(3, 2)), ("g", ratio(981, 100))],
        &[
            "a",
            "b",
            "c",
            "T/m*(cos(ph)*sin(th)*cos(ps) + sin(ph)*sin(ps))",
            "T/m*(cos(ph)*sin(th)*sin(ps) - sin(ph)*cos(ps))",
            "T/m*cos(ph)*cos(th) - g",
            "p + sin(ph)*tan(th)*q + cos(ph)*tan(th)*r",
            "cos(ph)*q - sin(ph)*r",
            "(sin(ph)*q + cos(ph)*r)/cos(th)",
            "q*r + L",
            "-p*r + M",
            "p*q/2 + N",
        ],
        &["x", "y", "z", "ps"],
        None,
    );
    let f = flatness(&s);
    assert_eq!(f.flat_outputs, ["x", "y", "z", "ps"]);
    assert_eq!(f.dynamic_extension.as_ref().unwrap().0, [("T".to_owned(), 2)]);
    assert_eq!(f.relative_degree, [4, 4, 4, 2]);
    assert_eq!(f.singular_set.as_ref().unwrap().to_string(), "T = 0 or cos(ph) = 0");
}

#[test]
fn with_one_input_flat_means_linearizable() {
    // Jakubczyk & Respondek 1980: the cart-pole is not.
    let cart_pole = system(
        &["x", "th", "v", "w"],
        &["u"],
        &[],
        &[
            "v",
            "w",
            "(u + w^2*sin(th) - sin(th)*cos(th))/(1 + sin(th)^2)",
            "(2*sin(th) - w^2*sin(th)*cos(th) - u*cos(th))/(1 + sin(th)^2)",
        ],
        &[],
        None,
    );
    assert_eq!(verdict(&cart_pole), FlatnessVerdict::No);
    // Spong: the pendulum with an inertia wheel is.
    let wheel = system(&["th", "w", "q"], &["u"], &[], &["w", "9*sin(th) - 2*u", "3*u - 9*sin(th)"], &[], None);
    let f = flatness(&wheel);
    assert_eq!((f.verdict, f.dynamic_extension.unwrap().0.len()), (FlatnessVerdict::Yes, 0));
    assert_eq!(f.relative_degree, [3]);
}

#[test]
fn what_inputs_do_not_influence_is_not_flat() {
    let s = system(&["x", "y", "z"], &["u", "v"], &[], &["u", "v", "-z"], &[], None);
    assert_eq!(verdict(&s), FlatnessVerdict::No);
}

#[test]
fn dependent_inputs_count_once() {
    let s = system(&["x", "v"], &["a", "b"], &[], &["v", "a + 2*b"], &[], None);
    let f = flatness(&s);
    assert_eq!((f.verdict, shown(&f.flat_outputs).join(", ")), (FlatnessVerdict::Yes, "x".to_owned()));
}

/// Charlet, Lévine & Marino 1989: accessible with one input fewer than states.
#[test]
fn one_input_less_than_states() {
    let s = system(&["a", "b", "c"], &["u", "v"], &[], &["u", "v + b", "a*v + c*exp(b)"], &[], None);
    assert_eq!(verdict(&s), FlatnessVerdict::Yes);
}

#[test]
fn induction_motor_becomes_linear_by_dynamic_feedback() {
    // Chiasson 1993: not by static feedback, but with one integrator.
    let s = system(
        &["w", "pa", "pb", "ia", "ib"],
        &["ua", "ub"],
        &[("M", ratio(9, 10)), ("J", ratio(13, 10))],
        &["J*(pa*ib - pb*ia)", "-pa - w*pb + M*ia", "-pb + w*pa + M*ib", "pa + w*pb - ia + ua", "pb - w*pa - ib + ub"],
        &[],
        None,
    );
    let f = flatness(&s);
    assert_eq!(f.verdict, FlatnessVerdict::Yes);
    assert!(adds_up(&s, &f), "{f:?}");
}

/// Extends a system and checks that the compensator does what it says.
#[test]
fn the_extended_system_is_the_given_one_with_its_compensator() {
    let mut s = vtol(&["x - ep*sin(th)", "y + ep*cos(th)"]);
    let v = fields(&mut s);
    let outputs: Vec<Expr> = s.outputs.iter().map(|o| o.1).collect();
    let limits = ExtensionLimits { integrators: 6, nodes: 100_000 };
    let pool = &mut s.pool;
    let e = v.dynamic_extension(pool, &outputs, &s.inputs, limits, &mut Evidence::default()).unwrap().unwrap();
    assert!(e.linearizes());
    let new: Vec<Expr> = e.new_inputs.iter().map(|&u| pool.sym(u)).collect();
    let right = right_hand_side(pool, &e.fields, &new);
    let given = right_hand_side(pool, &v, &e.inputs);
    let added: Vec<Expr> = e.added.iter().map(|a| a.1).collect();
    for (a, b) in right.iter().zip(given.iter().chain(&added)) {
        let difference = pool.sub(*a, *b);
        assert!(pool.zero_test(difference, &Bindings::new()).is_zero(), "{} is not {}", pool.text(*a), pool.text(*b));
    }
    let names: Vec<Symbol> = e.added.iter().map(|a| a.0).collect();
    assert_eq!(e.fields.states[6..], names);
}

fn right_hand_side(pool: &mut Pool, v: &VectorFields, inputs: &[Expr]) -> Vec<Expr> {
    (0..v.states.len())
        .map(|i| {
            let mut e = v.drift[i];
            for (g, &u) in v.controls.iter().zip(inputs) {
                let term = pool.mul(g[i], u);
                e = pool.add(e, term);
            }
            e
        })
        .collect()
}

#[test]
fn outputs_that_depend_on_each_other_cannot_be_extended() {
    let mut s = vtol(&["x", "2*x + 1"]);
    let v = fields(&mut s);
    let outputs: Vec<Expr> = s.outputs.iter().map(|o| o.1).collect();
    let limits = ExtensionLimits { integrators: 6, nodes: 100_000 };
    let e = v.dynamic_extension(&mut s.pool, &outputs, &s.inputs, limits, &mut Evidence::default()).unwrap();
    assert!(e.is_none());
}

/// The planar VTOL with the thrusts of its two rotors as inputs: the center of oscillation does not depend on the choice
/// of the inputs, nor on arms of different length.
#[test]
fn rotor_thrusts_and_other_combinations_of_the_inputs() {
    for [thrust, roll] in [["f1 + f2", "f1 - f2"], ["f1 + f2", "2*f1 - 3*f2"], ["2*f1 + f2", "f2 - f1"]] {
        let rhs = [
            "vx".to_owned(),
            "vy".to_owned(),
            "w".to_owned(),
            format!("-sin(th)*({thrust}) + ep*cos(th)*({roll})"),
            format!("cos(th)*({thrust}) + ep*sin(th)*({roll}) - gr"),
            roll.to_owned(),
        ];
        let rhs: Vec<&str> = rhs.iter().map(String::as_str).collect();
        let parameters = [("gr", ratio(981, 100)), ("ep", ratio(1, 2))];
        let s = system(&["x", "y", "th", "vx", "vy", "w"], &["f1", "f2"], &parameters, &rhs, &[], None);
        let f = flatness(&s);
        assert_eq!(f.verdict, FlatnessVerdict::Yes, "{thrust}, {roll}: {}", f.reason);
        assert_eq!(f.flat_outputs[0], "x - ep*sin(th)");
        assert!(adds_up(&s, &f), "{f:?}");
    }
}

/// Trolley and winch by their accelerations: the position of the load.
#[test]
fn crane_with_accelerated_trolley_and_rope() {
    let s = system(
        &["x", "r", "th", "vx", "vr", "w"],
        &["a", "b"],
        &[("g", ratio(981, 100))],
        &["vx", "vr", "w", "a", "b", "-(2*vr*w + g*sin(th) + a*cos(th))/r"],
        &[],
        None,
    );
    let f = flatness(&s);
    assert_eq!(f.verdict, FlatnessVerdict::Yes, "{}", f.reason);
    assert!(adds_up(&s, &f), "{f:?}");
}

/// A quadrotor by the thrusts of its rotors.
#[test]
fn quadrotor_by_rotor_thrusts() {
    let s = system(
        &["x", "y", "z", "a", "b", "c", "ph", "th", "ps", "p", "q", "r"],
        &["f1", "f2", "f3", "f4"],
        &[("g", ratio(981, 100))],
        &[
            "a",
            "b",
            "c",
            "(f1 + f2 + f3 + f4)*(cos(ph)*sin(th)*cos(ps) + sin(ph)*sin(ps))",
            "(f1 + f2 + f3 + f4)*(cos(ph)*sin(th)*sin(ps) - sin(ph)*cos(ps))",
            "(f1 + f2 + f3 + f4)*cos(ph)*cos(th) - g",
            "p + sin(ph)*tan(th)*q + cos(ph)*tan(th)*r",
            "cos(ph)*q - sin(ph)*r",
            "(sin(ph)*q + cos(ph)*r)/cos(th)",
            "q*r + f2 - f4",
            "-p*r + f3 - f1",
            "p*q/2 + (f1 - f2 + f3 - f4)/10",
        ],
        &[],
        None,
    );
    let f = flatness(&s);
    assert_eq!(f.verdict, FlatnessVerdict::Yes, "{}", f.reason);
    assert!(adds_up(&s, &f), "{f:?}");
}

/// A rigid body on a passive joint whose accelerations are the inputs, as the last link of a planar arm (De Luca and Oriolo
/// 2002), with and without gravity, of any length and turned frame: the center of oscillation is flat.
#[test]
fn a_body_on_a_passive_joint_is_flat_by_its_center_of_oscillation() {
    let turned = [("a1", "a2"), ("(3*a1 - 4*a2)/5", "(4*a1 + 3*a2)/5"), ("a1 + 2*a2", "a2")];
    for (case, (ax, ay)) in turned.into_iter().enumerate() {
        let gravity = ["0", "981/100", "0"][case];
        let spin = format!("(sin(th)*({ax}) - cos(th)*({ay} + {gravity}))/K");
        let s = system(
            &["x", "y", "th", "vx", "vy", "w"],
            &["a1", "a2"],
            &[("K", ratio(case as i64 + 1, 2))],
            &["vx", "vy", "w", ax, ay, &spin],
            &[],
            None,
        );
        let f = flatness(&s);
        assert_eq!(f.verdict, FlatnessVerdict::Yes, "{case}");
        assert!(adds_up(&s, &f), "{case}");
        let mut found = shown(&f.flat_outputs);
        found.sort_unstable();
        assert_eq!(found, ["K*cos(th) + x", "K*sin(th) + y"], "{case}");
    }
}
