//! Normal forms: the system in new coordinates moves like the original, and the form has its structure.

use std::fmt::Write as _;

use crate::simulated::rand_like::Lcg;
use crate::simulated::{assert_same_motion, disguised, found, model, parsed, to};
use bracketry_lie::forms::{
    BlockKind, Form, FormNote, FormOutcome, Obstacle, PartKind, TransformError, TransformOptions,
};
use bracketry_lie::transform;
use bracketry_system::System;

#[test]
fn chains_of_integrators_are_recovered_from_random_coordinates_and_feedback() {
    let one = ["z2", "z3", "v1"];
    let two = ["z2", "v1", "z4", "z5", "v2"];
    let four = ["z2", "z3", "z4", "v1"];
    for seed in 0..4 {
        for (chains, inputs) in [(&one[..], 1), (&two[..], 2), (&four[..], 1)] {
            let system = disguised(chains, inputs, &[("y", "z1")], true, seed);
            let form = found(&system, Form::Brunovsky);
            let n = chains.len();
            let lengths: Vec<usize> = form.blocks.iter().map(|b| b.states.len()).collect();
            assert_eq!(lengths.iter().sum::<usize>(), n);
            // Every rate is the next coordinate or a new input.
            for (k, &rate) in form.system.dynamics.iter().enumerate() {
                let name = form.system.pool.text(rate);
                assert!(name == format!("z{}", k + 2) || name.starts_with('v'), "{name}");
            }
            let x0: Vec<f64> = (0..n).map(|i| 0.1 + 0.07 * i as f64).collect();
            assert_same_motion(&system, &form, &x0);
        }
    }
}

#[test]
fn a_flexible_joint_is_a_chain_of_four() {
    let system = model("flexible_joint");
    let form = found(&system, Form::Brunovsky);
    assert_eq!(form.blocks.len(), 1);
    assert_eq!(form.blocks[0].states, ["z1", "z2", "z3", "z4"]);
    assert_eq!(form.coordinates.0[0].1.text(), "q1");
    assert!(form.inverse.is_some());
    assert_eq!(form.regular_at_point, Some(true));
    assert!(form.singular_set.as_ref().unwrap().is_nowhere());
    assert_same_motion(&system, &form, &[0.2, 0.1, 0.15, -0.2]);
}

#[test]
fn magnetic_levitation_keeps_its_singular_set_and_its_branch() {
    let system = model("magnetic_levitation");
    let form = found(&system, Form::Brunovsky);
    assert_eq!(form.singular_set.as_ref().unwrap().to_string(), "i = 0");
    assert_eq!(form.regular_at_point, Some(true));
    // i is a square root of the force: the branch is that of the point, i = 1.
    assert!(form.notes.iter().any(|n| matches!(n, FormNote::Branch { .. })), "{:?}", form.notes);
    assert_same_motion(&system, &form, &[0.011, 0.0, 1.1]);
}

#[test]
fn what_is_not_linearizable_names_the_distribution() {
    for name in ["ball_and_beam", "cart_pole", "acrobot"] {
        let result = to(&model(name), Form::Brunovsky);
        let FormOutcome::Impossible(Obstacle::NotInvolutive { .. }) = result.outcome else {
            panic!("{name}: {:?}", result.outcome)
        };
    }
    let apart = parsed("states = ['x', 'y']\ninputs = ['u']\ndynamics = { x = 'u', y = '-y' }");
    let FormOutcome::Impossible(why) = to(&apart, Form::Brunovsky).outcome else { panic!() };
    assert_eq!(why, Obstacle::NotReached { dimension: 1, states: 2 });
}

#[test]
fn a_pendulum_on_a_cart_has_internal_states_that_no_input_enters() {
    let text = std::fs::read_to_string("../../models/cart_pole.toml").unwrap();
    let system = parsed(&text.replace("[point]", "[outputs]\ny = \"p\"\n[point]"));
    let form = found(&system, Form::ByrnesIsidori);
    assert_eq!(form.blocks[0].kind, BlockKind::Output { output: "y".into() });
    assert_eq!(form.blocks[1].kind, BlockKind::Internal { free_of_inputs: true });
    let eta = &form.blocks[1].states;
    for (k, name) in form.system.state_names().iter().enumerate() {
        let uses = form.system.pool.depends_on(form.system.dynamics[k], form.system.inputs[0]);
        assert!(!(uses && eta.contains(name)));
    }
    assert_same_motion(&system, &form, &[0.1, 0.2, -0.1, 0.3]);
    let part = &form.parts[0];
    assert_eq!((part.kind, part.system.states.len()), (PartKind::ZeroDynamics, 2));
    // The pole of a cart that stands still: th'' = g/l sin(th).
    let (a, b) = (part.system.point_values().unwrap(), part.system.to_toml().unwrap());
    assert_eq!(a.0, [0.0, 0.0]);
    assert!(System::parse("again", &b).is_ok());
}

#[test]
fn random_byrnes_isidori_forms_are_recovered() {
    let dynamics = ["z2", "v1 + z3*z1", "z1 - z3 + z4^2", "z2 - 2*z4"];
    for seed in 0..6 {
        let system = disguised(&dynamics, 1, &[("y", "z1")], true, seed);
        let form = found(&system, Form::ByrnesIsidori);
        assert_eq!(form.blocks[0].states, ["xi1", "xi2"]);
        assert_eq!(form.parts.len(), 1, "{:?}", form.notes);
        assert_eq!(form.parts[0].system.states.len(), 2);
        assert_same_motion(&system, &form, &[0.1, 0.2, -0.1, 0.05]);
    }
}

#[test]
fn outputs_without_a_vector_relative_degree_are_refused() {
    let unicycle = parsed(
        "states = ['x', 'y', 'th']\ninputs = ['u', 'w']\ndynamics = { x = 'u*cos(th)', y = 'u*sin(th)', th = 'w' }\n\
         outputs = { x = 'x', y = 'y' }",
    );
    let FormOutcome::Impossible(why) = to(&unicycle, Form::ByrnesIsidori).outcome else { panic!() };
    assert_eq!(why, Obstacle::NoRelativeDegree { rank: 1, outputs: 2 });
    let options = TransformOptions { outputs: vec!["x".into()], ..TransformOptions::default() };
    let result = transform(&unicycle, Form::ByrnesIsidori, &options).unwrap();
    let FormOutcome::NotFound(why) = result.outcome else { panic!() };
    assert_eq!(why, Obstacle::NotSquare { outputs: 1, inputs: 2 });
    let options = TransformOptions { outputs: vec!["z".into()], ..TransformOptions::default() };
    let error = transform(&unicycle, Form::ByrnesIsidori, &options).unwrap_err();
    assert!(matches!(error, TransformError::UnknownOutput { .. }), "{error}");
}

/// Dimensions of the four parts: controllable and observable, only controllable, only observable, neither.
fn dimensions(form: &bracketry_lie::forms::NormalForm) -> [usize; 4] {
    let of = |kind: &BlockKind| form.blocks.iter().find(|b| b.kind == *kind).map_or(0, |b| b.states.len());
    [
        BlockKind::ControllableObservable,
        BlockKind::ControllableUnobservable,
        BlockKind::UncontrollableObservable,
        BlockKind::UncontrollableUnobservable,
    ]
    .map(|k| of(&k))
}

#[test]
fn kalman_parts_are_recovered_from_random_unimodular_changes() {
    // z1, z2: both; z3: controllable; z4: observable; z5: neither.
    let a = [[0, 1, 0, 2, 0], [-2, -3, 0, 1, 0], [1, 0, -1, 1, 3], [0, 0, 0, -4, 0], [0, 0, 0, 2, 5]];
    let (b, c) = ([0, 1, 1, 0, 0], [1, 0, 0, 1, 0]);
    for seed in 0..12 {
        let mut lcg = Lcg(seed + 3);
        // A product of elementary matrices, and its inverse.
        let mut t = [[0i64; 5]; 5];
        let mut s = t;
        for i in 0..5 {
            (t[i][i], s[i][i]) = (1, 1);
        }
        for _ in 0..9 {
            let (i, j) = (lcg.below(5), lcg.below(5));
            if i == j {
                continue;
            }
            let k = lcg.int(2);
            for col in 0..5 {
                t[i][col] += k * t[j][col];
            }
            for row in &mut s {
                row[j] -= k * row[i];
            }
        }
        let times = |x: &[[i64; 5]; 5], y: &[[i64; 5]; 5]| {
            let mut p = [[0; 5]; 5];
            for (i, row) in p.iter_mut().enumerate() {
                for (j, e) in row.iter_mut().enumerate() {
                    *e = (0..5).map(|k| x[i][k] * y[k][j]).sum();
                }
            }
            p
        };
        let full = times(&times(&t, &a), &s);
        let mut text = "states = ['x1', 'x2', 'x3', 'x4', 'x5']\ninputs = ['u']\n[dynamics]\n".to_owned();
        for i in 0..5 {
            let terms: Vec<String> = (0..5).map(|j| format!("({})*x{}", full[i][j], j + 1)).collect();
            let gain: i64 = (0..5).map(|k| t[i][k] * b[k]).sum();
            writeln!(text, "x{} = '{} + ({gain})*u'", i + 1, terms.join(" + ")).unwrap();
        }
        let terms: Vec<String> =
            (0..5).map(|j| format!("({})*x{}", (0..5).map(|k| c[k] * s[k][j]).sum::<i64>(), j + 1)).collect();
        writeln!(text, "[outputs]\ny = '{}'", terms.join(" + ")).unwrap();
        let system = parsed(&text);
        let form = found(&system, Form::Kalman);
        assert_eq!(dimensions(&form), [2, 1, 1, 1], "{text}");
        assert_same_motion(&system, &form, &[0.1, -0.2, 0.3, 0.2, -0.1]);
        block_triangular(&form);
        // The minimal part has the transfer function 1/(s² + 3 s + 2).
        let minimal = &form.parts[0].system;
        let linear = bracketry_lie::linearize(minimal, &bracketry_lie::operating::LinearizeOptions::default()).unwrap();
        let mut poles: Vec<f64> = linear.poles.unwrap().iter().map(|p| p.re).collect();
        poles.sort_by(f64::total_cmp);
        assert_eq!(poles, [-2.0, -1.0]);
        assert_eq!((linear.controllability.rank, linear.observability.rank), (2, 2));
    }
}

/// No input enters the uncontrollable parts, no controllable state either, and no unobservable state the observable parts.
fn block_triangular(form: &bracketry_lie::forms::NormalForm) {
    let [both, reached, seen, _] = dimensions(form);
    let s = &form.system;
    for (k, &rate) in s.dynamics.iter().enumerate() {
        for (j, &state) in s.states.iter().enumerate() {
            let uncontrollable = |i: usize| i >= both + reached;
            let observable = |i: usize| i < both || (i >= both + reached && i < both + reached + seen);
            let forbidden = (uncontrollable(k) && !uncontrollable(j)) || (observable(k) && !observable(j));
            assert!(!(forbidden && s.pool.depends_on(rate, state)), "{k} {j}");
        }
        assert!(!(k >= both + reached && s.pool.depends_on(rate, s.inputs[0])));
    }
}

#[test]
fn a_nonlinear_model_is_decomposed_around_its_equilibrium() {
    let text = "states = ['q', 'w', 'c']\ninputs = ['u']\nparameters = { g = 9.81 }\n\
        dynamics = { q = 'w', w = 'g*sin(q) + u', c = '-c + q*c^2' }\noutputs = { y = 'q + c' }\npoint = { q = 0, u = 0 }";
    let form = found(&parsed(text), Form::Kalman);
    assert_eq!(dimensions(&form), [2, 0, 1, 0]);
    assert!(form.notes.contains(&FormNote::Linearized));
    let moving = parsed(&text.replace("q = 0, u = 0", "w = 1"));
    let FormOutcome::NotFound(Obstacle::NotAtRest { .. }) = to(&moving, Form::Kalman).outcome else { panic!() };
    let tilted = parsed(&text.replace("q = 0, u = 0", "q = 'pi/6', u = '-9.81/2'"));
    let FormOutcome::NotFound(Obstacle::Irrational) = to(&tilted, Form::Kalman).outcome else { panic!() };
    let straight = parsed(&text.replace("q = 0, u = 0", "q = 'pi', u = 0"));
    let form = found(&straight, Form::Kalman);
    assert_eq!(form.system.point_values().unwrap().0, [0.0, 0.0, 0.0]);
}

#[test]
fn switching_models_and_curved_inputs_are_not_transformed_silently() {
    let friction = model("spring_mass_friction");
    let FormOutcome::NotFound(Obstacle::Switches { modes: 2 }) = to(&friction, Form::Brunovsky).outcome else {
        panic!()
    };
    let curved = parsed("states = ['x']\ninputs = ['u']\ndynamics = { x = 'u^3 + u' }");
    let FormOutcome::NotFound(Obstacle::NotAffine { .. }) = to(&curved, Form::Brunovsky).outcome else { panic!() };
    let late = parsed("states = ['x']\ninputs = ['u']\ndelays = { u = 0.1 }\ndynamics = { x = 'u - x' }");
    let FormOutcome::NotFound(Obstacle::Delay { .. }) = to(&late, Form::Brunovsky).outcome else { panic!() };
}

/// y = a + h(d) with h' = 0 at the point: a completes y and its derivatives to coordinates nearly everywhere, but not there; d does.
#[test]
fn internal_states_are_regular_at_the_point() {
    for (bend, slope, at) in [
        ("d^2", "2*d", "0"),
        ("(d - 1)^2", "2*(d - 1)", "1"),
        ("(d - sqrt(2))^3", "3*(d - sqrt(2))^2", "sqrt(2)"),
        ("cos(d)", "-sin(d)", "pi"),
    ] {
        for rate in ["e - d", "a*e"] {
            let system = parsed(&format!(
                "states = ['a', 'b', 'd', 'e']\ninputs = ['u']\n\
                 dynamics = {{ a = 'b - ({slope})*({rate})', b = '(2 + sin(a))*u', d = '{rate}', e = 'a - e' }}\n\
                 outputs = {{ y = 'a + {bend}' }}\n[point]\nd = '{at}'\n"
            ));
            let form = found(&system, Form::ByrnesIsidori);
            assert_eq!(form.regular_at_point, Some(true), "{bend}, {rate}");
        }
    }
}
