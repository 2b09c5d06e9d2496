//! Plants that fixed explicit steps do not follow: the loop goes over to error control, and says so.

use bracketry_mpc::problem::{ControlProblem, Note};
use bracketry_mpc::{Controlled, control};
use bracketry_system::System;

fn run(model: &str, problem: &str) -> Controlled {
    let problem = format!("model = 'model.toml'\n{problem}");
    control(
        &ControlProblem::parse("problem.toml", &problem, |name| System::parse(name, model).map_err(Box::new)).unwrap(),
    )
    .unwrap()
}

fn refined(run: &Controlled) -> Option<usize> {
    run.run.report.notes.iter().find_map(|note| match note {
        Note::PlantRefined(refined) => Some(refined.sample),
        _ => None,
    })
}

/// An actuator of any speed before an integrator: at every sample, the states are those of the closed form under the input applied.
#[test]
fn a_plant_of_any_stiffness_moves_as_its_equations_say() {
    let dt: f64 = 0.1;
    for (rate, substeps, stiff) in
        [(3.0_f64, 4, false), (300.0, 4, true), (3e4, 50, true), (3e6, 4, true), (3e6, 20_000, true)]
    {
        let model = format!("states = ['a', 'y']\ninputs = ['u']\ndynamics = {{ a = '{rate:?}*(u - a)', y = 'a' }}");
        let problem = format!(
            "horizon = {{ steps = 15, dt = {dt:?}, integrator = 'radau' }}\ncost = {{ stage = 'y^2 + 0.1*u^2' }}\n\
             constraints = {{ u = {{ min = -1, max = 1 }} }}\n\
             run = {{ x0 = {{ y = 1 }}, steps = 30, plant_substeps = {substeps} }}"
        );
        let run = run(&model, &problem);
        let (x, u) = (&run.run.closed_loop.x, &run.run.closed_loop.u);
        for (pair, u) in x.windows(2).zip(u) {
            let left = (pair[0][0] - u[0]) * (-rate * dt).exp();
            let y = pair[0][1] + u[0] * dt + (pair[0][0] - u[0] - left) / rate;
            assert!((pair[1][0] - u[0] - left).abs() < 1e-4 && (pair[1][1] - y).abs() < 1e-4, "{rate}: {pair:?} {u:?}");
        }
        assert_eq!(refined(&run), stiff.then_some(0), "{rate} {substeps}: {:?}", run.run.report.notes);
        assert!(run.run.report.succeeded, "{rate}: {:?}", run.run.report.notes);
        // The recorded motion goes through the samples.
        for (k, x) in x.iter().enumerate() {
            let recorded = run.recording.trajectory.sample(dt * k as f64);
            assert!(recorded.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-9), "{rate} {k}: {recorded:?} {x:?}");
        }
    }
}

/// A plant becomes stiff on its way; before, its fixed steps stay as they are.
#[test]
fn a_plant_is_followed_with_error_control_from_where_it_becomes_stiff() {
    let model = "states = ['s', 'x']\ninputs = ['u']\ndynamics = { s = 's', x = 's*(u - x)' }";
    let problem = "horizon = { steps = 10, dt = 0.1, integrator = 'radau' }\ncost = { stage = '(x - 1)^2 + 0.1*u^2' }\n\
                   run = { x0 = { s = 0.1 }, steps = 120, plant_substeps = 4 }";
    let run = run(model, problem);
    // The rate s of x is then 20 to 200 per second.
    let sample = refined(&run).unwrap();
    assert!((50..80).contains(&sample), "{sample}");
    assert!(run.run.report.x_final.0.iter().all(|(_, x)| x.is_finite()) && run.run.report.succeeded);
    let x = &run.run.closed_loop.x;
    assert!(x.iter().enumerate().all(|(k, x)| (x[0] / (0.1 * (0.1 * k as f64).exp()) - 1.0).abs() < 1e-5));
}

/// What has no solution in finite time stops the loop with a state that is no number.
#[test]
fn a_plant_that_escapes_is_reported() {
    let model = "states = ['x']\ninputs = ['u']\ndynamics = { x = 'x^3 + u' }";
    let problem = "horizon = { steps = 5, dt = 0.1 }\ncost = { stage = 'x^2 + u^2' }\nconstraints = { u = { min = -1, max = 1 } }\n\
                   run = { x0 = { x = 3 }, steps = 5 }";
    let run = run(model, problem);
    assert!(!run.run.report.succeeded);
    assert!(run.run.report.notes.iter().any(|note| matches!(note, Note::State { .. })));
}
