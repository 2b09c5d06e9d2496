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

/// The real-time loop of a chain of masses with bounded inputs and soft bounds, up to 40 states: no more iterations of the program at rest than on
/// the way there, however small the cost has become.
#[test]
fn a_program_at_rest_takes_no_more_iterations_than_one_in_motion() {
    for masses in [2, 8, 20] {
        let names = |of: char| (0..masses).map(move |i| format!("{of}{i}"));
        let list = names('x').chain(names('v')).map(|n| format!("'{n}'")).collect::<Vec<_>>().join(", ");
        let equation = |i: usize| {
            let left = if i == 0 { "0".to_owned() } else { format!("x{}", i - 1) };
            let right = if i + 1 == masses { "0".to_owned() } else { format!("x{}", i + 1) };
            let input = if i == 0 || i + 1 == masses { format!("u{}", usize::from(i > 0)) } else { "0".to_owned() };
            format!("x{i} = 'v{i}', v{i} = '4*({left} - 2*x{i} + {right}) - v{i} - 0.3*x{i}^3 + {input}'")
        };
        let equations = (0..masses).map(equation).collect::<Vec<_>>().join(", ");
        let model = format!("states = [{list}]\ninputs = ['u0', 'u1']\ndynamics = {{ {equations} }}");
        let cost = (0..masses).map(|i| format!("x{i}^2 + 0.1*v{i}^2")).collect::<Vec<_>>().join(" + ");
        let run = |deviation: f64| {
            let text = format!(
                "horizon = {{ steps = 10, dt = 0.1 }}\ncost = {{ stage = '{cost} + 0.1*u0^2 + 0.1*u1^2' }}\n\
                 solve = {{ method = 'rti' }}\nrun = {{ x0 = {{ x0 = {deviation:e}, v1 = {deviation:e} }}, steps = 25 }}\n\
                 constraints = {{ u0 = {{ min = -1, max = 1 }}, u1 = {{ min = -1, max = 1 }}, x0 = {{ max = 0.8, soft = [1, 1] }} }}"
            );
            let effort = crate::common::reports::run(&model, &text).effort;
            assert_eq!(effort.programs, 25);
            effort.interior_point_steps
        };
        let moving = run(0.5);
        for deviation in [1e-3, 1e-6, 1e-9, 1e-100, 0.0] {
            let resting = run(deviation);
            assert!(resting <= moving, "{masses} masses, {deviation}: {resting} iterations, {moving} in motion");
        }
    }
}
