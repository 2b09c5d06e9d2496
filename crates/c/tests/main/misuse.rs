//! The functions as C calls them: the same inputs as from Rust, and codes for whatever is wrong.
#![allow(clippy::undocumented_unsafe_blocks, reason = "the arguments stand beside each call")]

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use bracketry_c::*;
use bracketry_mpc::ControlProblem;
use bracketry_system::System;

const MODEL: &str = "states = ['x', 'v']\ninputs = ['a']\nparameters = { k = 1 }\n\
    dynamics = { x = 'v', v = 'a - 0.1*k*v' }\noutputs = { y = 'x' }\n";
const PROBLEM: &str = "model = 'mass.toml'\nhorizon = { steps = 20, dt = 0.1 }\nlive_parameters = ['k']\n\
    references = { goal = 0 }\ncost = { stage = '(x - goal)^2 + 0.1*v^2 + 0.01*a^2' }\n\
    constraints = { a = { min = -1, max = 1 } }\nrun = { x0 = { x = 1 } }\n";

fn last() -> String {
    unsafe { CStr::from_ptr(bracketry_last_error()) }.to_str().unwrap().to_owned()
}

fn text(text: &str) -> CString {
    CString::new(text).unwrap()
}

fn made() -> *mut BracketryController {
    let mut code = BracketryCode::Panic;
    let handle = unsafe { bracketry_controller_from_text(text(PROBLEM).as_ptr(), text(MODEL).as_ptr(), &raw mut code) };
    assert_eq!(code, BracketryCode::Ok, "{}", last());
    handle
}

fn status() -> BracketryStatus {
    BracketryStatus {
        sample: 99,
        missed: 0,
        outcome: BracketryOutcome::Fallback,
        source: BracketrySource::Rest,
        reason: BracketryReason::None,
        prepare_seconds: 0.0,
        feedback_seconds: 0.0,
    }
}

#[test]
fn the_inputs_are_those_of_the_controller_in_rust() {
    let problem = ControlProblem::parse("p", PROBLEM, |f| System::parse(f, MODEL).map_err(Box::new)).unwrap();
    let (mut live, handle) = (problem.controller().unwrap(), made());
    let (mut y, mut u, mut s) = ([1.0, 0.0], [f64::NAN], status());
    for k in 0..60 {
        if k == 20 {
            let goal = text("goal");
            live.set_reference("goal", 0.3).unwrap();
            assert_eq!(unsafe { bracketry_controller_set_reference(handle, goal.as_ptr(), 0.3) }, BracketryCode::Ok);
        }
        if k == 30 {
            y[0] = f64::NAN;
        }
        let expected = live.step(&y).unwrap().step.u.clone();
        let code = unsafe {
            bracketry_controller_step(handle, 7.0 + 0.1 * k as f64, y.as_ptr(), 2, u.as_mut_ptr(), 1, &raw mut s)
        };
        assert_eq!((code, s.sample), (BracketryCode::Ok, k), "{}", last());
        assert_eq!(u[0].to_bits(), expected[0].to_bits(), "sample {k}");
        assert_eq!(s.outcome == BracketryOutcome::Fallback, k == 30);
        assert_eq!(s.reason == BracketryReason::Measurement, k == 30);
        y = if k == 30 { [0.3, 0.0] } else { [y[0] + 0.1 * y[1] + 0.005 * u[0], y[1] + 0.1 * u[0]] };
    }
    let prediction = live.prediction();
    unsafe {
        let horizon = bracketry_controller_horizon(handle);
        assert_eq!((horizon, prediction.steps()), (20, 20));
        let (mut xs, mut us) = (vec![0.0; 42], vec![0.0; 20]);
        let code = bracketry_controller_predict(handle, xs.as_mut_ptr(), 42, us.as_mut_ptr(), 20);
        assert_eq!(code, BracketryCode::Ok, "{}", last());
        assert_eq!((&xs[40..], us[19]), (prediction.x(20), prediction.u(19)[0]));
        // In two parts, without a clock, and after a reset.
        live.reset_to(&[0.5, 0.0]).unwrap();
        assert_eq!(bracketry_controller_reset_to(handle, [0.5, 0.0].as_ptr(), 2), BracketryCode::Ok);
        assert_eq!(bracketry_controller_prepare(handle), BracketryCode::Ok);
        let code = bracketry_controller_feedback(handle, [0.5, 0.0].as_ptr(), 2, u.as_mut_ptr(), 1, null_mut());
        assert_eq!((code, u[0]), (BracketryCode::Ok, live.step(&[0.5, 0.0]).unwrap().step.u[0]));
        assert_eq!(bracketry_controller_lost(handle, u.as_mut_ptr(), 1, &raw mut s), BracketryCode::Ok);
        assert_eq!((s.reason, u[0]), (BracketryReason::LostSample, live.lost().unwrap().step.u[0]));
        bracketry_controller_free(handle);
    }
}

#[test]
fn names_and_sizes_are_those_of_the_problem() {
    let handle = made();
    unsafe {
        let names = |kind: BracketryKind| -> Vec<&str> {
            let count = bracketry_controller_count(handle, kind as u32);
            (0..count)
                .map(|i| CStr::from_ptr(bracketry_controller_name(handle, kind as u32, i)).to_str().unwrap())
                .collect()
        };
        assert_eq!(names(BracketryKind::State), ["x", "v"]);
        assert_eq!(names(BracketryKind::Input), ["a"]);
        assert_eq!(names(BracketryKind::Measurement), ["x", "v"]);
        assert_eq!(names(BracketryKind::Reference), ["goal"]);
        assert_eq!(names(BracketryKind::Parameter), ["k"]);
        assert!(names(BracketryKind::Target).is_empty());
        assert_eq!((bracketry_controller_period(handle), bracketry_controller_horizon(handle)), (0.1, 20));
        // What is not there.
        assert_eq!((bracketry_controller_count(handle, 6), bracketry_controller_count(null_mut(), 0)), (0, 0));
        assert!(bracketry_controller_name(handle, 0, 2).is_null() && bracketry_controller_name(handle, 9, 0).is_null());
        assert!(bracketry_controller_period(null_mut()).is_nan());
        assert_eq!(bracketry_controller_horizon(null_mut()), 0);
        assert_eq!(CStr::from_ptr(bracketry_outcome_name(3)), c"played_out");
        assert_eq!(CStr::from_ptr(bracketry_source_name(17)), c"unknown");
        assert_eq!(CStr::from_ptr(bracketry_reason_name(BracketryReason::QpFailed as u32)), c"qp_failed");
        assert_eq!(CStr::from_ptr(bracketry_version()).to_str().unwrap(), env!("CARGO_PKG_VERSION"));
        bracketry_controller_free(handle);
        bracketry_controller_free(null_mut());
    }
}

#[test]
fn what_is_no_problem_gives_no_controller() {
    let mut code = BracketryCode::Ok;
    let mut refused = |problem: *const std::ffi::c_char, model: *const std::ffi::c_char| {
        let handle = unsafe { bracketry_controller_from_text(problem, model, &raw mut code) };
        assert!(handle.is_null());
        code
    };
    let (problem, model) = (text(PROBLEM), text(MODEL));
    assert_eq!(refused(null(), model.as_ptr()), BracketryCode::Null);
    assert_eq!(last(), "the problem is a null pointer");
    assert_eq!(refused(problem.as_ptr(), null()), BracketryCode::Null);
    assert_eq!(refused(c"\xff".as_ptr(), model.as_ptr()), BracketryCode::Text);
    assert_eq!(refused(text("model = 1").as_ptr(), model.as_ptr()), BracketryCode::Problem);
    assert!(last().contains("model"), "{}", last());
    assert_eq!(refused(problem.as_ptr(), c"states = ['x']".as_ptr()), BracketryCode::Problem);
    // Nobody has to take the code.
    assert!(unsafe { bracketry_controller_new(c"no/such/problem.toml".as_ptr(), null_mut()) }.is_null());
    assert!(last().contains("no/such/problem.toml"), "{}", last());
}

#[test]
fn bad_arguments_have_codes_and_change_nothing() {
    let (handle, fresh) = (made(), made());
    let (good, mut u, mut s) = ([1.0, 0.0], [77.0, 77.0], status());
    let (goal, k, x, a, nothing) = (text("goal"), text("k"), text("x"), text("a"), text("nothing"));
    unsafe {
        let mut step = |handle, t: f64, y: *const f64, n, u: *mut f64, m| {
            bracketry_controller_step(handle, t, y, n, u, m, &raw mut s)
        };
        let p = u.as_mut_ptr();
        let check = |code: BracketryCode, expected: BracketryCode, word: &str| {
            assert_eq!(code, expected, "{}", last());
            assert!(last().contains(word), "{word}: {}", last());
        };
        check(step(null_mut(), 0.0, good.as_ptr(), 2, p, 1), BracketryCode::Null, "controller");
        check(step(handle, 0.0, null(), 2, p, 1), BracketryCode::Null, "y is a null pointer");
        check(step(handle, 0.0, good.as_ptr(), 2, null_mut(), 1), BracketryCode::Null, "u is a null pointer");
        check(step(handle, 0.0, good.as_ptr(), 1, p, 1), BracketryCode::Length, "measurement");
        check(step(handle, 0.0, good.as_ptr(), 2, p, 2), BracketryCode::Length, "u has the length 2; it has to be 1");
        check(step(handle, 0.0, good.as_ptr(), usize::MAX, p, 1), BracketryCode::Length, "not a valid array length");
        check(step(handle, 0.0, good.as_ptr().byte_add(1), 1, p, 1), BracketryCode::Null, "aligned");
        check(step(handle, f64::NAN, good.as_ptr(), 2, p, 1), BracketryCode::Time, "NaN");
        check(bracketry_controller_set_reference(handle, goal.as_ptr(), f64::NAN), BracketryCode::Value, "finite");
        check(bracketry_controller_set_reference(handle, null(), 1.0), BracketryCode::Null, "name");
        check(bracketry_controller_set_reference(handle, nothing.as_ptr(), 1.0), BracketryCode::Name, "goal");
        check(
            bracketry_controller_set_reference_ahead(handle, goal.as_ptr(), null(), 3),
            BracketryCode::Null,
            "values",
        );
        check(
            bracketry_controller_set_reference_ahead(handle, goal.as_ptr(), null(), 0),
            BracketryCode::Length,
            "values",
        );
        let parameters = |names: &[*const std::ffi::c_char], values: &[f64]| {
            bracketry_controller_set_parameters(handle, names.as_ptr(), values.as_ptr(), names.len())
        };
        check(parameters(&[k.as_ptr()], &[f64::INFINITY]), BracketryCode::Value, "finite");
        check(parameters(&[k.as_ptr(), x.as_ptr()], &[9.0, 1.0]), BracketryCode::Name, "k");
        check(parameters(&[k.as_ptr(), null()], &[9.0, 1.0]), BracketryCode::Null, "names");
        check(
            bracketry_controller_set_parameters(handle, null(), good.as_ptr(), 1),
            BracketryCode::Null,
            "names is a null pointer",
        );
        check(bracketry_controller_set_bounds(handle, a.as_ptr(), 2.0, 1.0), BracketryCode::Value, "");
        check(bracketry_controller_set_bounds(handle, a.as_ptr(), f64::NAN, 1.0), BracketryCode::Value, "bound");
        check(bracketry_controller_set_target(handle, x.as_ptr(), 1.0), BracketryCode::Name, "x");
        check(bracketry_controller_reset_to(handle, good.as_ptr(), 1), BracketryCode::Length, "initial state");
        check(
            bracketry_controller_reset_to(handle, [1.0, f64::NAN].as_ptr(), 2),
            BracketryCode::Value,
            "initial state",
        );
        check(bracketry_controller_predict(handle, p, 2, p, 1), BracketryCode::Length, "x has the length 2");
        check(
            bracketry_controller_feedback(handle, good.as_ptr(), 3, p, 1, null_mut()),
            BracketryCode::Length,
            "measurement",
        );
        check(bracketry_controller_lost(handle, p, 0, null_mut()), BracketryCode::Length, "u has the length 0");
        check(bracketry_controller_prepare(null_mut()), BracketryCode::Null, "controller");
        check(bracketry_controller_reset(null_mut()), BracketryCode::Null, "controller");
        assert_eq!((u, s), ([77.0, 77.0], status()), "nothing is written");
        // The controller is as it was.
        let (mut got, mut expected) = ([0.0], [0.0]);
        for (handle, u) in [(handle, &mut got), (fresh, &mut expected)] {
            let code = bracketry_controller_step(handle, 0.0, good.as_ptr(), 2, u.as_mut_ptr(), 1, null_mut());
            assert_eq!(code, BracketryCode::Ok, "{}", last());
        }
        assert_eq!(got, expected);
        // A sample that has been answered, and one too far ahead.
        let again = bracketry_controller_step(handle, 0.0, good.as_ptr(), 2, p, 1, null_mut());
        assert_eq!(again, BracketryCode::Time, "{}", last());
        let far = bracketry_controller_step(handle, 1e9, good.as_ptr(), 2, p, 1, null_mut());
        assert_eq!(far, BracketryCode::Time, "{}", last());
        bracketry_controller_free(handle);
        bracketry_controller_free(fresh);
    }
}
