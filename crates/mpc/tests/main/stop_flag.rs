//! Planning and running end with an error once the flag of the problem is raised, whatever the method.

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::{ControlProblem, MpcError, SymbolicDynamics};
use bracketry_system::System;

#[test]
fn a_raised_flag_stops_every_method() {
    for method in ["rti", "sqp", "plan", "stick-slip"] {
        let text = format!(
            "model = 'cart.toml'\nhorizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = 'x^2 + v^2 + u^2' }}\n\
             constraints = {{ u = {{ min = -5, max = 5 }} }}\nsolve = {{ method = '{method}' }}\nrun = {{ x0 = {{ x = 1 }}, steps = 5 }}"
        );
        let model = |_: &str| {
            let text = "states = ['x', 'v']\ninputs = ['u']\ndynamics = { x = 'v', v = 'u - 0.1*sign(v)' }";
            System::parse("cart.toml", text).map_err(Box::new)
        };
        let problem = ControlProblem::parse("problem", &text, model).unwrap();
        let mut plant = RungeKuttaPlant::new(Box::new(SymbolicDynamics::new(&problem.plant).unwrap()), 1);
        // In the third sample, whose controller it stops or at whose end the loop ends; then before a run.
        let mut last = 0;
        for from in [2, 0] {
            let during = problem.run_disturbed(&mut plant, |k, _| {
                last = k;
                if k >= from {
                    problem.stop.raise();
                }
            });
            assert!(matches!(during, Err(MpcError::Stopped)), "{method}: {:?}", during.map(|_| ()));
            assert!(last <= 3, "{method}: went on to sample {last}");
        }
    }
}
