//! Inputs that cannot move change nothing.

use crate::common::noise::Noise;
use crate::common::reports::run;
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
