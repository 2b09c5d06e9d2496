//! Sizes come from what a problem is about, not from rounding errors in its numbers.

use crate::common::noise::Noise;
use crate::common::reports::{problem, run};

const MODEL: &str = "states = [\"h\", \"v\"]\ninputs = [\"u\"]\nparameters = { k = 1 }\n\
                     dynamics = { h = \"v\", v = \"k*u - 0.1*sin(h)\" }";

/// Where a number is zero but for rounding, everything is as with zero.
#[test]
fn what_is_zero_but_for_rounding_is_zero() {
    let of = |h: &str, v: &str, guess: &str| {
        format!(
            "horizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = \"(h - 1)^2 + 0.1*v^2 + 0.01*u^2\" }}\n\
             guess = {{ u = {guess} }}\nrun = {{ x0 = {{ h = {h}, v = {v} }}, steps = 40 }}"
        )
    };
    let exact = run(MODEL, &of("0", "0", "0"));
    assert!(exact.succeeded && exact.notes.is_empty(), "{:?}", exact.notes);
    for [h, v, guess] in [
        ["\"sin(pi)\"", "0", "0"],
        ["\"20*sin(pi)\"", "0", "0"],
        ["\"1e3*(0.1*3 - 0.3) - 1e-13\"", "\"cos(pi/2)\"", "0"],
        ["0", "\"-3*cos(pi/2)\"", "0"],
        ["0", "0", "\"sin(pi)\""],
        ["1.2246467991473532e-16", "0", "2.4e-15"],
    ] {
        let report = run(MODEL, &of(h, v, guess));
        assert!(report.succeeded && report.notes.is_empty(), "{h} {v} {guess}: {:?}", report.notes);
        assert!((report.closed_loop_cost / exact.closed_loop_cost - 1.0).abs() < 1e-6, "{h} {v} {guess}: {report:?}");
        assert_eq!(report.method, exact.method);
    }
}

/// States and inputs in small units keep their sizes: the plan does not depend on the unit.
#[test]
fn sizes_in_small_units_are_no_rounding() {
    let mut noise = Noise::new(2);
    for exponent in [0, -6, -12] {
        let unit = 10f64.powi(exponent);
        let (h, v) = (unit * (0.5 + noise.uniform()), unit * noise.uniform());
        let text = format!(
            "horizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = \"(h/{unit:e})^2 + 0.1*(v/{unit:e})^2 + 0.01*u^2\" }}\n\
             parameters = {{ k = {unit:e} }}\nrun = {{ x0 = {{ h = {h:e}, v = {v:e} }}, steps = 40 }}"
        );
        let p = problem(MODEL, &text);
        assert!((p.ocp.state_scale[0] / h - 1.0).abs() < 1.0, "{exponent}: {:?}", p.ocp.state_scale);
        assert!(p.ocp.state_scale[1] < 2.0 * unit, "{exponent}: {:?}", p.ocp.state_scale);
    }
}
