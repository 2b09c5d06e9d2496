//! Plans start from the guess at rest and from its motion, and the better one counts.

use crate::common::noise::Noise;
use crate::common::reports::run;

/// A car overtakes two slower ones, to the left or to the right of either.
#[test]
fn a_loop_finds_what_a_plan_finds() {
    let car = "states = [\"x\", \"y\", \"th\", \"v\"]\ninputs = [\"a\", \"d\"]\n\
               dynamics = { x = \"v*cos(th)\", y = \"v*sin(th)\", th = \"v*tan(d)/2.5\", v = \"a\" }";
    let mut noise = Noise::new(8);
    for _ in 0..4 {
        let (first, second) = (0.3 + 0.4 * noise.uniform(), -0.3 - 0.4 * noise.uniform());
        let (near, far) = (18.0 + 6.0 * noise.uniform(), 48.0 + 8.0 * noise.uniform());
        let of = |method: &str| {
            let text = format!(
                "horizon = {{ steps = 40, dt = 0.2 }}\n\
                 cost = {{ stage = \"0.1*(v - 10)^2 + 0.05*y^2 + 0.1*a^2 + 5*d^2 + th^2\" }}\n\
                 solve = {{ {method} }}\nrun = {{ x0 = {{ v = 10 }}, steps = 40 }}\n[constraints]\n\
                 a = {{ min = -5, max = 3 }}\nd = {{ min = -0.3, max = 0.3 }}\ny = {{ min = -4, max = 4 }}\n\
                 one = {{ expression = \"((x - {near:?} - 4*t)/6)^2 + ((y - {first:?})/2)^2\", min = 1 }}\n\
                 two = {{ expression = \"((x - {far:?} - 4*t)/6)^2 + ((y - {second:?})/2)^2\", min = 1 }}"
            );
            run(car, &text)
        };
        let (chosen, plan) = (of(""), of("method = \"plan\", margin = 0"));
        assert!(chosen.succeeded && plan.succeeded, "{chosen:?} {plan:?}");
        let (a, b) = (chosen.open_loop_cost, plan.open_loop_cost);
        assert!((a - b).abs() < 0.015 * a.max(b), "{a} {b}");
        assert!(chosen.closed_loop_cost < 1.1 * a, "{chosen:?}");
    }
}
