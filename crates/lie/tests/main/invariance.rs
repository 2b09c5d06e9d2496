//! Ranks and verdicts do not depend on the coordinates of the state, and those that feedback cannot change do not
//! change with it.

use crate::common::system;
use crate::tier::cases;
use bracketry_lie::controllability::{PointReport, Verdict};
use bracketry_lie::{AnalysisOptions, Answer, Report, analyze_affine};
use bracketry_symbolic::{Expr, Func, Symbol};
use bracketry_system::System;
use proptest::prelude::*;
use rustc_hash::FxHashMap;

/// Systems with an equilibrium at the origin: (states, inputs, equations).
const SYSTEMS: &[(&[&str], &[&str], &[&str])] = &[
    // Unicycle: driftless, controllable.
    (&["x", "y", "th"], &["u", "w"], &["u*cos(th)", "u*sin(th)", "w"]),
    // Angular velocities of a rigid body with two torques.
    (&["p", "q", "r"], &["u", "w"], &["q*r + u", "-2*p*r + w", "3*p*q"]),
    // Controllable linearization, not linearizable.
    (&["a", "b", "c"], &["u"], &["b + c^2", "c", "u"]),
    // Linearizable.
    (&["a", "b"], &["u"], &["sin(b)", "-a^2 + u"]),
    // Accessible, and the square of the first state moves the second one way only.
    (&["a", "b"], &["u"], &["u", "a^2"]),
    // Not accessible: p and q move together.
    (&["p", "q", "r"], &["u"], &["u", "2*u", "p - r"]),
    // Three states, one of which is a function of the others for each initial value.
    (&["p", "q", "r"], &["u", "w"], &["u", "w", "q*u + p*w"]),
];

/// Σ c x^i y^j over a few monomials without a constant term, in the given variables.
fn polynomial(s: &mut System, variables: &[Symbol], c: &[i8]) -> Expr {
    let mut terms = Vec::new();
    for (k, &c) in c.iter().enumerate() {
        let Some(&a) = variables.get(k % variables.len().max(1)) else { break };
        let b = variables[(k / 2) % variables.len()];
        let (a, b, c) = (s.pool.sym(a), s.pool.sym(b), s.pool.int(i64::from(c)));
        let monomial = if k % 3 == 0 { a } else { s.pool.mul(a, b) };
        terms.push(s.pool.mul(c, monomial));
    }
    s.pool.sum(terms)
}

/// The system in the coordinates z_i = x_i + p_i(x_1 … x_{i−1}), named like the old ones.
fn in_coordinates(original: &System, coefficients: &[Vec<i8>]) -> System {
    let mut s = original.clone();
    let states = s.states.clone();
    let (mut forward, mut back) = (Vec::new(), FxHashMap::default());
    for (i, &x) in states.iter().enumerate() {
        let p = polynomial(&mut s, &states[..i], &coefficients[i]);
        let e = s.pool.sym(x);
        forward.push(s.pool.add(e, p));
        // x_i = z_i − p_i(x_1(z) …)
        let p = s.pool.substitute(p, &back);
        let old = s.pool.sub(e, p);
        back.insert(e, old);
    }
    let f = s.dynamics.clone();
    let rates: Vec<Expr> = forward.iter().map(|&t| s.pool.lie_derivative(t, &states, &f)).collect();
    s.dynamics = s.pool.substitute_all(&rates, &back);
    s
}

/// The system with u_j = α_j(x) + v_j + Σ_{k<j} β_jk(x) v_k, where α vanishes at the origin.
fn with_feedback(original: &System, coefficients: &[Vec<i8>]) -> System {
    let mut s = original.clone();
    let states = s.states.clone();
    let mut map = FxHashMap::default();
    for (j, &u) in s.inputs.clone().iter().enumerate() {
        let mut total = polynomial(&mut s, &states, &coefficients[j]);
        let e = s.pool.sym(u);
        total = s.pool.add(total, e);
        for &v in &s.inputs.clone()[..j] {
            let beta = polynomial(&mut s, &states, &coefficients[j + 1]);
            let v = s.pool.sym(v);
            let term = s.pool.mul(beta, v);
            total = s.pool.add(total, term);
        }
        map.insert(e, total);
    }
    s.dynamics = s.pool.substitute_all(&s.dynamics.clone(), &map);
    s
}

/// Constants that are no rational numbers, each with one that rotates by it or shears.
const CONSTANTS: &[&str] = &[
    "cos(1/3)",
    "exp(1/2)",
    "exp(-1/3)",
    "sqrt(2)",
    "sqrt(2) + sqrt(3)",
    "log(2)",
    "log(3/2)",
    "tan(2/7)",
    "pi",
    "2^(1/3)",
];

/// One change of two states i ≠ j, by a rotation or a shear.
#[derive(Clone, Copy, Debug)]
struct Plane {
    states: (usize, usize),
    constant: usize,
    rotates: bool,
}

/// The system in the coordinates z = M x with products M of rotations and shears, named like the old ones.
fn in_rotated_coordinates(original: &System, planes: &[Plane]) -> System {
    let mut s = original.clone();
    let states = s.states.clone();
    let n = states.len();
    for plane in planes {
        let (i, j) = (plane.states.0 % n, (plane.states.0 + 1 + plane.states.1 % (n - 1)) % n);
        let [x, y] = [i, j].map(|k| s.pool.sym(states[k]));
        // (x, y) → (c x − s y, s x + c y), or (x + k y, y).
        let (c, d) = if plane.rotates {
            let angle = s.pool.parse(["1/5", "3/10", "1/2", "1"][plane.constant % 4]).unwrap();
            (s.pool.call(Func::Cos, angle), s.pool.call(Func::Sin, angle))
        } else {
            (s.pool.int(1), s.pool.parse(CONSTANTS[plane.constant % CONSTANTS.len()]).unwrap())
        };
        let mut combine = |a: Expr, b: Expr, sign: i64| -> [Expr; 2] {
            let sign = s.pool.int(sign);
            let d = s.pool.mul(sign, d);
            let minus = s.pool.neg(d);
            let mut sum = |p: Expr, a: Expr, q: Expr, b: Expr| {
                let (l, r) = (s.pool.mul(p, a), s.pool.mul(q, b));
                s.pool.add(l, r)
            };
            if plane.rotates { [sum(c, a, minus, b), sum(d, a, c, b)] } else { [sum(c, a, d, b), b] }
        };
        let [old_x, old_y] = combine(x, y, -1);
        let [new_x, new_y] = combine(s.dynamics[i], s.dynamics[j], 1);
        (s.dynamics[i], s.dynamics[j]) = (new_x, new_y);
        let map: FxHashMap<Expr, Expr> = [(x, old_x), (y, old_y)].into_iter().collect();
        s.dynamics = s.pool.substitute_all(&s.dynamics.clone(), &map);
    }
    s
}

fn model(k: usize) -> System {
    let (states, inputs, equations) = SYSTEMS[k];
    system(states, inputs, &[], equations, &[], Some(&[]))
}

fn report(system: &System) -> Report {
    analyze_affine(system, &AnalysisOptions::default()).unwrap()
}

fn at_point(r: &Report) -> &PointReport {
    r.at_point.as_ref().and_then(Answer::known).unwrap()
}

fn coefficients() -> impl Strategy<Value = Vec<Vec<i8>>> {
    prop::collection::vec(prop::collection::vec(-3i8..4, 3), 4)
}

fn planes() -> impl Strategy<Value = Vec<Plane>> {
    let plane = (0usize..3, 0usize..2, 0usize..20, any::<bool>());
    let plane = plane.prop_map(|(i, j, constant, rotates)| Plane { states: (i, j), constant, rotates });
    prop::collection::vec(plane, 1..4)
}

proptest! {
    #![proptest_config(cases(8))]

    #[test]
    fn coordinates_change_no_rank_and_no_verdict(k in 0..SYSTEMS.len(), c in coefficients()) {
        let original = model(k);
        let (a, b) = (report(&original), report(&in_coordinates(&original, &c)));
        prop_assert_eq!(&a.modes[0].dimensions.growth, &b.modes[0].dimensions.growth);
        prop_assert_eq!(&a.modes[0].dimensions.strong_growth, &b.modes[0].dimensions.strong_growth);
        prop_assert_eq!(&a.involutive, &b.involutive);
        prop_assert_eq!(&a.static_feedback_linearizable, &b.static_feedback_linearizable);
        let (p, q) = (at_point(&a), at_point(&b));
        prop_assert_eq!(&p.dimensions.growth, &q.dimensions.growth);
        prop_assert_eq!(&p.linear_controllability_rank, &q.linear_controllability_rank);
        let verdicts = [p.stlc.verdict, q.stlc.verdict, p.stlc.with_bounded_inputs(), q.stlc.with_bounded_inputs()];
        prop_assert_eq!(&verdicts[..1], &verdicts[1..2], "{} / {}", p.stlc.reason, q.stlc.reason);
        prop_assert_eq!(verdicts[2], verdicts[3]);
    }

    #[test]
    fn feedback_changes_no_accessibility_and_no_linearizability(k in 0..SYSTEMS.len(), c in coefficients()) {
        let original = model(k);
        let (a, b) = (report(&original), report(&with_feedback(&original, &c)));
        let (d, e) = (&a.modes[0].dimensions, &b.modes[0].dimensions);
        prop_assert_eq!(&d.strongly_accessible_dimension, &e.strongly_accessible_dimension);
        // Feedback gives a driftless system a drift, but one in the span of its fields.
        prop_assert_eq!(&d.accessible_dimension, &e.accessible_dimension);
        prop_assert_eq!(&a.involutive, &b.involutive);
        prop_assert_eq!(&a.static_feedback_linearizable, &b.static_feedback_linearizable);
        let (p, q) = (at_point(&a), at_point(&b));
        prop_assert_eq!(&p.dimensions.accessible_dimension, &q.dimensions.accessible_dimension);
        prop_assert_eq!(&p.linear_controllability_rank, &q.linear_controllability_rank);
        // Local controllability is the same; a sufficient test may see it in one form only.
        let verdicts = [p.stlc.verdict, q.stlc.verdict];
        let contradict = verdicts.contains(&Verdict::Yes) && verdicts.contains(&Verdict::No);
        prop_assert!(!contradict, "{} / {}", p.stlc.reason, q.stlc.reason);
    }

    #[test]
    fn irrational_coordinates_change_no_rank_and_no_verdict(k in 0..SYSTEMS.len(), planes in planes()) {
        let original = model(k);
        let (a, b) = (report(&original), report(&in_rotated_coordinates(&original, &planes)));
        prop_assert_eq!(&a.modes[0].dimensions.growth, &b.modes[0].dimensions.growth);
        prop_assert_eq!(&a.modes[0].dimensions.strong_growth, &b.modes[0].dimensions.strong_growth);
        let (p, q) = (at_point(&a), at_point(&b));
        prop_assert_eq!(&p.dimensions.growth, &q.dimensions.growth);
        prop_assert_eq!(&p.linear_controllability_rank, &q.linear_controllability_rank);
        for (v, w) in [(p.stlc.verdict, q.stlc.verdict), (p.stlc.with_bounded_inputs(), q.stlc.with_bounded_inputs())] {
            let contradict = [v, w].contains(&Verdict::Yes) && [v, w].contains(&Verdict::No);
            prop_assert!(!contradict, "{} / {}", p.stlc.reason, q.stlc.reason);
        }
        if let (Some(Answer::Known(v)), Some(Answer::Known(w))) = (&p.stabilizable, &q.stabilizable) {
            prop_assert_eq!(v, w);
        }
    }
}
