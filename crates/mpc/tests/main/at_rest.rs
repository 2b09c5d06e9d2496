//! What a sample takes at rest, where the cost vanishes.

use bracketry_mpc::ControlProblem;
use bracketry_system::System;

/// A loop that has arrived solves no more programs for a sample than on its way, and stays where it is.
#[test]
fn a_sample_at_rest_takes_no_more_programs_than_one_in_motion() {
    let models = [
        ("dynamics = { x = 'v', v = 'u - sin(x)' }", "10*x^2 + v^2 + 0.1*u^2"),
        ("dynamics = { x = 'v', v = 'u*cos(x) - v^3' }", "x^2 + 0.1*v^2 + 0.01*u^2"),
        ("dynamics = { x = 'v + x^2', v = 'u' }", "1e4*x^2 + 1e3*v^2 + 1e2*u^2"),
    ];
    for (dynamics, cost) in models {
        let model = format!("states = ['x', 'v']\ninputs = ['u']\n{dynamics}");
        let problem = format!(
            "model = 'model.toml'\nhorizon = {{ steps = 20, dt = 0.1 }}\ncost = {{ stage = '{cost}' }}\n\
             solve = {{ method = 'sqp' }}\nconstraints = {{ u = {{ min = -5, max = 5 }} }}\nrun = {{ x0 = {{ x = 0.8 }} }}"
        );
        let problem =
            ControlProblem::parse("problem.toml", &problem, |name| System::parse(name, &model).map_err(Box::new));
        let mut controller = problem.unwrap().controller().unwrap();
        let mut plant = bracketry_sim::ExactPlant::new(
            &System::parse("model.toml", &model).unwrap(),
            &[0.8, 0.0],
            &bracketry_sim::SimulationSettings::default(),
        )
        .unwrap();
        let mut programs = Vec::new();
        for _ in 0..200 {
            let step = controller.step(plant.state()).unwrap().step.clone();
            programs.push(step.effort.programs);
            assert!(plant.hold(&step.u, 0.1).unwrap().is_finished());
        }
        let most = |of: &[usize]| of.iter().copied().max().unwrap_or(0);
        let (moving, resting) = (most(&programs[1..15]), most(&programs[150..]));
        assert!(resting <= moving.min(2), "{dynamics}: {moving} {resting} {programs:?}");
        assert!(plant.state().iter().all(|x| x.abs() < 1e-6), "{dynamics}: {:?}", plant.state());
    }
}
