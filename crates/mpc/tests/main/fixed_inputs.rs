//! Inputs that cannot move change nothing, and a model may have no inputs at all.

use crate::common::noise::Noise;
use crate::common::reports::{problem, run};
use bracketry_mpc::control;
use bracketry_mpc::problem::ClosedLoopReport;

/// A pole on a cart, hanging, to be swung up; `idle` inputs are fixed, each at a value that its equation takes away again.
fn swing_up(mass: f64, length: f64, idle: &[f64]) -> ClosedLoopReport {
    let each =
        |text: &dyn Fn(usize, &f64) -> String| -> String { idle.iter().enumerate().map(|(i, v)| text(i, v)).collect() };
    let names = each(&|i, _| format!(", \"idle{i}\""));
    let taken = each(&|i, value| format!(" + idle{i} - {value:?}"));
    let bounds = each(&|i, value| format!(", idle{i} = {{ min = {value:?}, max = {value:?} }}"));
    let model = format!(
        "states = [\"x\", \"th\", \"v\", \"w\"]\ninputs = [\"u\"{names}]\nparameters = {{ m = {mass:?}, l = {length:?}, g = 9.81 }}\n\
         definitions = {{ a = \"(u{taken} + m*sin(th)*(l*w^2 - g*cos(th)))/(1 + m*sin(th)^2)\" }}\n\
         dynamics = {{ x = \"v\", th = \"w\", v = \"a\", w = \"(g*sin(th) - a*cos(th))/l\" }}"
    );
    run(
        &model,
        &format!(
            "horizon = {{ steps = 60, dt = 0.03 }}\n\
             cost = {{ stage = \"x^2 + 10*(1 - cos(th)) + 0.01*(v^2 + w^2) + 0.001*u^2\", terminal = \"50*(1 - cos(th)) + w^2\" }}\n\
             constraints = {{ u = {{ min = -30, max = 30 }}{bounds} }}\nrun = {{ x0 = {{ th = \"pi\" }}, steps = 80 }}"
        ),
    )
}

/// A hanging pole is a stationary guess, and a maximum. Whether a plan leaves it does not depend on inputs that cannot move.
#[test]
fn fixed_inputs_change_no_plan() {
    let mut noise = Noise::new(45);
    for idle in [&[0.0][..], &[-1.5], &[2.0, 0.0]] {
        let (mass, length) = (0.1 + 0.2 * noise.uniform(), 0.4 + 0.2 * noise.uniform());
        let (without, with) = (swing_up(mass, length, &[]), swing_up(mass, length, idle));
        assert_eq!((without.method, with.method), ("sqp", "sqp"), "{with:?}");
        let costs = [&without, &with].map(|r| (r.open_loop_cost, r.closed_loop_cost));
        assert!((costs[0].0 / costs[1].0 - 1.0).abs() < 1e-6, "{costs:?}");
        assert!((costs[0].1 / costs[1].1 - 1.0).abs() < 1e-4, "{costs:?}");
        assert!(with.x_final.get("th").is_some_and(|th| th.cos() > 0.99), "{with:?}");
    }
}

/// A range far smaller than the size of an input leaves an input to decide on.
#[test]
fn narrow_ranges_converge_to_fixed_inputs() {
    let cost = |width: f64| {
        let text = format!(
            "horizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = \"x^2 + u^2 + v^2\" }}\n\
             constraints = {{ u = {{ min = -2, max = 2 }}, v = {{ min = 0.5, max = {:?} }} }}\ntrust = {{ v = 10 }}\n\
             solve = {{ method = \"sqp\" }}\nrun = {{ x0 = {{ x = 1 }}, steps = 20 }}",
            0.5 + width
        );
        let report = run("states = [\"x\"]\ninputs = [\"u\", \"v\"]\ndynamics = { x = \"sin(x) + u + v\" }", &text);
        assert!(report.succeeded, "{report:?}");
        report.open_loop_cost
    };
    let fixed = cost(0.0);
    for width in [1e-1, 1e-3, 1e-6] {
        assert!((cost(width) - fixed).abs() <= 2.0 * width * fixed, "{width}: {} {fixed}", cost(width));
    }
}

/// The decay of a state with an unknown rate, without any input: the rate and the time that fit.
#[test]
fn free_values_need_no_inputs() {
    let mut noise = Noise::new(7);
    for _ in 0..4 {
        let (rate, start) = (0.5 + 2.0 * noise.uniform(), 1.0 + noise.uniform());
        let model = "states = [\"x\"]\ninputs = []\nparameters = { k = 1 }\ndynamics = { x = \"-k*x\" }";
        let of_rate = format!(
            "horizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = \"(x - {start:?}*exp(-{rate:?}*t))^2\" }}\n\
             parameters = {{ k = {{ free = true, min = 0.1, max = 10, guess = 1 }} }}\nrun = {{ x0 = {{ x = {start:?} }} }}"
        );
        let report = run(model, &of_rate);
        let found = report.found.as_ref().and_then(|f| f.parameters.get("k").copied());
        assert!(report.succeeded && found.is_some_and(|k| (k - rate).abs() < 1e-4), "{rate}: {report:?}");
        let of_time = format!(
            "horizon = {{ steps = 10, end_time = {{ free = true, guess = 1, min = 0.1, max = 10 }} }}\n\
             cost = {{ terminal = \"(x - {:?})^2\" }}\nrun = {{ x0 = {{ x = {start:?} }} }}",
            start * (-rate).exp()
        );
        let report = run(model, &of_time);
        let found = report.found.as_ref().and_then(|f| f.end_time);
        assert!(report.succeeded && found.is_some_and(|t| (t - rate).abs() < 1e-3), "{rate}: {report:?}");
    }
    // Nothing to decide on at all: the plan is the motion.
    for method in ["rti", "sqp", "plan"] {
        let text = format!(
            "horizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = \"x^2\" }}\nsolve = {{ method = \"{method}\" }}\n\
             run = {{ x0 = {{ x = 1 }} }}"
        );
        let run = control(&problem("states = [\"x\"]\ninputs = []\ndynamics = { x = \"-x\" }", &text)).unwrap().run;
        let end = run.report.x_final.get("x").copied().unwrap();
        assert!(run.report.succeeded && (end - (-1.0_f64).exp()).abs() < 1e-6, "{method}: {end}");
    }
}
