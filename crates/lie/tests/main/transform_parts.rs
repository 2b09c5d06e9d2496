//! Decompositions by accessibility and observability, observer form, and flat parametrization.

use crate::simulated::{assert_same_motion, disguised, found, model, parsed, to};
use bracketry_lie::forms::{BlockKind, Form, FormNote, FormOutcome, NormalForm, Obstacle, PartKind, TransformOptions};
use bracketry_lie::transform;

fn sizes(form: &NormalForm) -> Vec<usize> {
    form.blocks.iter().map(|b| b.states.len()).collect()
}

#[test]
fn what_no_input_influences_is_found_in_random_coordinates() {
    let two_and_two = ["z2 + z3*z1", "v1 + z4", "z4", "-2*z3 - z3^3"];
    let three_and_one = ["z2", "z3*z4", "v1 + z1^2", "-z4^2"];
    for seed in 0..5 {
        for (dynamics, d) in [(&two_and_two, 2), (&three_and_one, 3)] {
            let system = disguised(dynamics, 1, &[("y", "z1")], true, seed);
            let form = found(&system, Form::Accessible);
            assert_eq!(sizes(&form), [d, 4 - d]);
            assert_same_motion(&system, &form, &[0.1, 0.2, -0.1, 0.3]);
            let part = &form.parts[0];
            assert_eq!(
                (part.kind, part.system.states.len(), part.system.inputs.len()),
                (PartKind::Inaccessible, 4 - d, 0)
            );
        }
    }
}

#[test]
fn angular_momentum_is_apart() {
    // Two bodies joined by a motor: what one gains the other loses.
    let system = parsed(
        "states = ['a', 'wa', 'b', 'wb']\ninputs = ['u']\nparameters = { I = 2, J = 3 }\n\
         dynamics = { a = 'wa', wa = 'u/I', b = 'wb', wb = '-u/J' }",
    );
    let form = found(&system, Form::Accessible);
    assert_eq!(sizes(&form), [2, 2]);
    assert_same_motion(&system, &form, &[0.1, 0.2, 0.3, 0.4]);
    let momentum = &form.parts[0].system;
    assert!(momentum.outputs.is_empty() && momentum.to_toml().is_ok());
    let whole = found(&model("cart_pole"), Form::Accessible);
    assert_eq!(whole.blocks.iter().map(|b| b.kind.clone()).collect::<Vec<_>>(), [BlockKind::Accessible]);
}

#[test]
fn what_no_output_tells_is_found_in_random_coordinates() {
    let dynamics = ["z2", "v1 - z1^3", "z3*z1 + z4", "z2 + v1*z3"];
    for seed in 0..5 {
        let system = disguised(&dynamics, 1, &[("y", "z1")], false, seed);
        let form = found(&system, Form::Observable);
        assert_eq!(sizes(&form), [2, 2]);
        assert_same_motion(&system, &form, &[0.1, 0.2, -0.1, 0.3]);
        let part = &form.parts[0];
        assert_eq!((part.kind, part.system.states.len(), part.system.outputs.len()), (PartKind::Observable, 2, 1));
    }
}

#[test]
fn a_distance_does_not_tell_the_direction() {
    let system = parsed(
        "states = ['x', 'y', 'th']\ninputs = ['u', 'w']\n\
         dynamics = { x = 'u*cos(th)', y = 'u*sin(th)', th = 'w' }\noutputs = { d = 'x^2 + y^2' }\npoint = { x = 1, y = '1/2' }",
    );
    let form = found(&system, Form::Observable);
    assert_eq!(sizes(&form), [2, 1]);
    assert_same_motion(&system, &form, &[1.0, 0.5, 0.2]);
}

#[test]
fn observer_forms_are_recovered_from_random_coordinates() {
    let two = ["z2 - z1^2", "-z1 + z1^3 + v1*(1 + z1^2)"];
    let three = ["z2 + z1^2", "z3 - 2*z1", "z1^3 - z1 + v1"];
    let four = ["z2 - z1", "z3 + z1^2", "z4 + v1", "-z1"];
    for seed in 0..4 {
        for dynamics in [&two[..], &three[..], &four[..]] {
            let system = disguised(dynamics, 1, &[("y", "z1")], false, seed);
            let form = found(&system, Form::Observer);
            let n = dynamics.len();
            let x0: Vec<f64> = (0..n).map(|i| 0.1 + 0.07 * i as f64).collect();
            assert_same_motion(&system, &form, &x0);
            is_observer_form(&form);
        }
    }
}

/// z_k' − z_(k+1) depends on z1 and the inputs only.
fn is_observer_form(form: &NormalForm) {
    let mut s = form.system.clone();
    for k in 0..s.states.len() {
        let mut rest = s.dynamics[k];
        if let Some(&next) = s.states.get(k + 1) {
            let next = s.pool.sym(next);
            rest = s.pool.sub(rest, next);
        }
        let rest = s.pool.simplify(rest);
        assert!(!s.states[1..].iter().any(|&z| s.pool.depends_on(rest, z)), "{}", s.pool.text(rest));
    }
}

#[test]
fn the_van_der_pol_oscillator_has_an_observer_form() {
    let system = parsed(
        "states = ['x', 'v']\ninputs = ['u']\nparameters = { mu = 0.7 }\n\
         dynamics = { x = 'v', v = 'mu*(1 - x^2)*v - x + u' }\noutputs = { y = 'x' }\npoint = {}",
    );
    let form = found(&system, Form::Observer);
    is_observer_form(&form);
    assert_same_motion(&system, &form, &[0.5, -0.2]);
    // z1' = z2 + mu (y − y³/3), z2' = −y + u
    let text = form.system.to_toml().unwrap();
    assert!(text.contains("z2 = \"-z1 + u\"") || text.contains("z2 = \"u - z1\""), "{text}");
}

#[test]
fn a_new_output_makes_the_injection_a_function_of_it() {
    // With z = exp(y): z1' = z2, z2' = −z1: y'' = −1 − y'².
    let system = parsed(
        "states = ['x', 'v']\ninputs = []\ndynamics = { x = 'v', v = '-1 - v^2' }\noutputs = { y = 'x' }\npoint = {}",
    );
    let form = found(&system, Form::Observer);
    assert!(form.notes.iter().any(|n| matches!(n, FormNote::OutputChanged { .. })), "{:?}", form.notes);
    is_observer_form(&form);
    assert_same_motion(&system, &form, &[0.1, 0.2]);
    // With z = exp(y) and z1' = z2, z2' = z3, z3' = −z1.
    let system = parsed(
        "states = ['x', 'v', 'a']\ninputs = []\ndynamics = { x = 'v', v = 'a', a = '-1 - 3*v*a - v^3' }\n\
         outputs = { y = 'x' }\npoint = {}",
    );
    let form = found(&system, Form::Observer);
    is_observer_form(&form);
    assert_same_motion(&system, &form, &[0.1, 0.2, 0.1]);
}

#[test]
fn what_has_no_observer_form_says_which_factor() {
    let cubic = parsed(
        "states = ['x', 'v']\ninputs = []\ndynamics = { x = 'v', v = '-x - v^3' }\noutputs = { y = 'x' }\npoint = {}",
    );
    let FormOutcome::Impossible(Obstacle::OutputInjection { order: 1 }) = to(&cubic, Form::Observer).outcome else {
        panic!()
    };
    let input = parsed(
        "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = '-x + u*v' }\noutputs = { y = 'x' }\npoint = {}",
    );
    let FormOutcome::Impossible(why) = to(&input, Form::Observer).outcome else { panic!() };
    assert_eq!(why, Obstacle::InputInjection { input: "u".into(), coordinate: 2 });
    let hidden = parsed("states = ['x', 'v']\ninputs = []\ndynamics = { x = '-x', v = '-v' }\noutputs = { y = 'x' }");
    let FormOutcome::Impossible(why) = to(&hidden, Form::Observer).outcome else { panic!() };
    assert_eq!(why, Obstacle::NotObservable { rank: 1, states: 2 });
}

#[test]
fn a_unicycle_is_parametrized_by_its_position() {
    let system = parsed(
        "states = ['x', 'y', 'th']\ninputs = ['u', 'w']\ndynamics = { x = 'u*cos(th)', y = 'u*sin(th)', th = 'w' }\n\
         outputs = { px = 'x', py = 'y' }\npoint = { u = 1 }",
    );
    let form = found(&system, Form::Flat);
    assert_eq!(sizes(&form), [2, 2]);
    assert_eq!(form.parts[0].kind, PartKind::Extended);
    assert_eq!(form.regular_at_point, Some(true));
    let names: Vec<&str> = form.system.outputs.iter().map(|o| o.0.as_str()).collect();
    assert_eq!(names, ["x", "y", "th", "u", "w"]);
    assert_same_motion(&form.parts[0].system, &form, &[0.1, 0.2, 0.3, 1.2]);
}

#[test]
fn a_flexible_joint_and_an_aircraft_are_parametrized() {
    let joint = found(&model("flexible_joint"), Form::Flat);
    let names: Vec<&str> = joint.system.outputs.iter().map(|o| o.0.as_str()).collect();
    assert_eq!(names, ["q1", "w1", "q2", "w2", "u"]);
    let options = TransformOptions::default();
    let result = transform(&model("ball_and_beam"), Form::Flat, &options).unwrap();
    let FormOutcome::Impossible(Obstacle::NotFlat { .. }) = result.outcome else { panic!("{:?}", result.outcome) };
}

#[test]
fn a_flexible_joint_has_an_observer_form() {
    let system = model("flexible_joint");
    let form = found(&system, Form::Observer);
    is_observer_form(&form);
    assert_same_motion(&system, &form, &[0.2, 0.1, 0.15, -0.2]);
}

#[test]
fn a_search_ends_with_its_time() {
    let options =
        TransformOptions { time_limit: Some(std::time::Duration::from_millis(1)), ..TransformOptions::default() };
    for to in Form::ALL {
        let result = transform(&model("car_with_trailers"), to, &options).unwrap();
        assert!(result.seconds < 5.0, "{to:?}: {}", result.seconds);
    }
}

/// Twenty Lie derivatives of a chain of sines are too long to write.
#[test]
fn long_derivatives_end_in_time() {
    let names: Vec<String> = (0..20).map(|i| format!("x{i}")).collect();
    let rates: Vec<String> = (0..19).map(|i| format!("x{i} = 'sin(x{})'", i + 1)).collect();
    let rates = rates.join("\n");
    let text =
        format!("states = {names:?}\ninputs = ['u']\noutputs = {{ y = 'x0' }}\n[dynamics]\nx19 = 'u'\n{rates}\n");
    let options =
        TransformOptions { time_limit: Some(std::time::Duration::from_secs(1)), ..TransformOptions::default() };
    let result = transform(&parsed(&text), Form::Observer, &options).unwrap();
    assert!(matches!(result.outcome, FormOutcome::NotFound(_)));
}

#[test]
fn a_car_has_a_chained_form() {
    let system = model("kinematic_car");
    let form = found(&system, Form::Chained);
    let text = form.system.to_toml().unwrap();
    for rate in ["z1 = \"v1\"", "z2 = \"v2\"", "z3 = \"z2*v1\"", "z4 = \"z3*v1\""] {
        assert!(text.contains(rate), "{text}");
    }
    assert_same_motion(&system, &form, &[0.1, 0.2, 0.3, 0.1]);
    let FormOutcome::Impossible(why) = to(&model("duffing"), Form::Chained).outcome else { panic!() };
    assert!(matches!(why, Obstacle::Drift | Obstacle::NotTwoInputs { .. }), "{why}");
}

#[test]
fn an_angle_around_pi_has_a_branch_without_a_jump() {
    let system = parsed(
        "states = ['x', 'y', 'th']\ninputs = ['u', 'w']\ndynamics = { x = 'u*cos(th)', y = 'u*sin(th)', th = 'w' }\n\
         outputs = { px = 'x', py = 'y' }\npoint = { th = 'pi', u = 1 }",
    );
    let form = found(&system, Form::Flat);
    for th in [3.1, 3.2] {
        assert_same_motion(&form.parts[0].system, &form, &[0.1, 0.2, th, 1.2]);
    }
}
