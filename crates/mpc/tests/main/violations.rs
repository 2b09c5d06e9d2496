//! Where a run violates a bound or constraint most: by definition, on random runs, and in a closed loop.

use bracketry_mpc::ocp::{BoundSide, Bounded, Bounds, PathConstraint, Softness, VectorFunction};
use bracketry_mpc::{ControlProblem, Ocp, control};
use bracketry_system::System;
use proptest::prelude::*;

const CART: &str = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u' }\n";

proptest! {
    /// The largest violation is at the place that is named, and there is none larger anywhere.
    #[test]
    fn the_largest_violation_is_where_it_is_said_to_be(
        x in prop::collection::vec(prop::array::uniform2(-2.0..2.0), 6),
        u in prop::collection::vec(-2.0..2.0, 5),
        least in -2.0..0.0, most in 0.0..2.0,
    ) {
        let system = System::parse("cart.toml", CART).unwrap();
        let mut ocp = Ocp::new(2, 1, 5, 0.1);
        let bounds = Bounds { min: least, max: most, softness: Softness::Hard };
        ocp.state_bounds[0] = bounds;
        ocp.input_bounds[0] = (-1.5, 1.5);
        let function = VectorFunction::parse(&system, &[], &["x + v"]).unwrap();
        ocp.path_constraints.push(PathConstraint { name: "sum".into(), function, bounds, at_end: false });
        let x: Vec<Vec<f64>> = x.iter().map(|x| x.to_vec()).collect();
        let u: Vec<Vec<f64>> = u.iter().map(|u| vec![*u]).collect();
        let traces = ocp.constraint_traces(&x, &u);
        let beyond = |v: f64, (min, max): (f64, f64)| [(BoundSide::Min, min - v), (BoundSide::Max, v - max)];
        let mut all = Vec::new();
        for k in 1..x.len() {
            all.extend(beyond(x[k][0], (least, most)).map(|v| (Bounded::State(0), k, v)));
            all.extend(beyond(x[k][0] + x[k][1], (least, most)).map(|v| (Bounded::Constraint(0), k, v)));
        }
        for (k, u) in u.iter().enumerate() {
            all.extend(beyond(u[0], (-1.5, 1.5)).map(|v| (Bounded::Input(0), k, v)));
        }
        let largest = all.iter().fold(0.0, |w: f64, v| w.max(v.2.1));
        match ocp.worst_violation(&x, &u, &traces) {
            None => prop_assert_eq!(largest, 0.0),
            Some(found) => {
                prop_assert_eq!(found.by, largest);
                prop_assert!(all.contains(&(found.of, found.sample, (found.side, found.by))));
            }
        }
    }
}

#[test]
fn a_value_that_is_no_number_is_the_largest_violation() {
    let mut ocp = Ocp::new(1, 1, 2, 0.1);
    ocp.input_bounds[0] = (-1.0, 1.0);
    let x = vec![vec![0.0]; 3];
    let found = ocp.worst_violation(&x, &[vec![5.0], vec![f64::NAN]], &[]).unwrap();
    assert!(found.by.is_nan() && (found.of, found.sample) == (Bounded::Input(0), 1));
}

/// A named constraint that cannot be kept is named in the report, with the time of the largest violation.
#[test]
fn a_run_names_the_constraint_that_it_violates() {
    let text = "model = 'cart.toml'\nhorizon = { steps = 10, dt = 0.1 }\nsolve = { method = 'rti' }\n\
        cost = { stage = 'x^2 + u^2' }\nrun = { x0 = { x = 1, v = 1 }, steps = 10 }\n\
        constraints = { u = { min = -1, max = 1 }, reach = { expression = 'x + v', max = 1.5 } }\n";
    let problem = ControlProblem::parse("p.toml", text, |f| System::parse(f, CART).map_err(Box::new)).unwrap();
    let run = control(&problem).unwrap().run;
    let at = run.report.constraint_violation_at.unwrap();
    // Whatever the input, x + v falls by less than 1 over a sample: it is 2 at the start, which does not count.
    assert_eq!((at.name.as_str(), at.side, at.sample), ("reach", BoundSide::Max, 1));
    let x = &run.closed_loop.x[1];
    assert_eq!(run.report.constraint_violation_max, x[0] + x[1] - 1.5);
    assert_eq!(at.time, run.closed_loop.t[1]);
}
