//! What a sample takes at rest, where the cost vanishes.

use bracketry_mpc::ControlProblem;
use bracketry_system::System;

/// A loop that has arrived solves one program for a sample, also where something small keeps moving it.
#[test]
fn a_sample_at_rest_takes_one_program() {
    let models = [
        ("x = 'v', v = 'u - sin(x)'", "10*x^2 + v^2 + 0.1*u^2"),
        ("x = 'v', v = 'u*cos(x) - v^3'", "x^2 + 0.1*v^2 + 0.01*u^2"),
        ("x = 'v + x^2', v = 'u'", "1e4*x^2 + 1e3*v^2 + 1e2*u^2"),
        ("x = 'v', v = 'u + sin(x)'", "10*(x - 1)^2 + v^2 + 0.1*(u + sin(1))^2"),
    ];
    for (dynamics, cost) in models {
        for disturbance in [0.0, 1e-12, 1e-10, 1e-9, 1e-8] {
            let model = format!("states = ['x', 'v']\ninputs = ['u']\ndynamics = {{ {dynamics} }}");
            let problem = format!(
                "model = 'm'\nhorizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = '{cost}' }}\n\
                 solve = {{ method = 'sqp' }}\nconstraints = {{ u = {{ min = -5, max = 5 }} }}\nrun = {{ x0 = {{ x = 0.8 }} }}"
            );
            let system = |name: &str| System::parse(name, &model);
            let problem = ControlProblem::parse("p", &problem, |name| system(name).map_err(Box::new));
            let mut controller = problem.unwrap().controller().unwrap();
            let mut plant = crate::common::exact_plant(&system("m").unwrap(), &[0.8, 0.0]);
            let mut programs = Vec::new();
            for k in 0..160 {
                let mut y = plant.state().to_vec();
                y[0] += disturbance * f64::from(k).sin();
                let step = controller.step(&y).unwrap().step.clone();
                programs.push(step.effort.programs);
                assert!(plant.hold(&step.u, 0.1).unwrap().is_finished());
            }
            assert!(programs[120..].iter().all(|&n| n == 1), "{dynamics} {disturbance}: {programs:?}");
        }
    }
}
