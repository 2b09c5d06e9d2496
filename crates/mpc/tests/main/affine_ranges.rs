//! A controller on an affine form keeps the new inputs within what the ranges of the old ones allow.

use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::{ControlProblem, SymbolicDynamics};
use bracketry_system::System;

/// An epidemic with contacts reduced by exp(−u): the new input v = exp(−u) lies in [e⁻², 1].
#[test]
fn the_new_input_of_an_epidemic_stays_in_its_range() {
    let model = "states = ['s', 'i']\ninputs = ['u']\nranges = { u = { min = 0, max = 2 } }\n[dynamics]\n\
        s = '-2*exp(-u)*s*i'\ni = '2*exp(-u)*s*i - i/2'\n";
    let affine = System::parse("sir", model).unwrap().affinize().unwrap().system;
    // As a model file, the way a user hands it on.
    let affine = System::parse("sir_affine", &affine.to_toml().unwrap()).unwrap();
    let v = affine.input_names()[0].clone();
    let problem = format!(
        "model = 'sir_affine.toml'\n[horizon]\nsteps = 10\ndt = 0.1\n[cost]\nstage = 'i^2 + 1e-6*{v}^2'\n[run]\nx0 = {{ s = 0.9, i = 0.1 }}\nsteps = 12\n"
    );
    let problem =
        ControlProblem::parse("problem.toml", &problem, |_| Ok(affine.clone())).map_err(|e| e.to_string()).unwrap();
    let dynamics = SymbolicDynamics::new(&problem.plant).unwrap();
    let mut plant = RungeKuttaPlant::new(Box::new(dynamics), problem.plant_substeps);
    let run = problem.run(&mut plant).unwrap();
    let least = (-2f64).exp();
    for u in &run.closed_loop.u {
        assert!(u[0] >= least - 1e-9 && u[0] <= 1.0 + 1e-9, "{u:?}");
    }
    // Fewest contacts from the start on.
    assert!((run.closed_loop.u[0][0] - least).abs() < 1e-6);
    let kept = &run.report.input_ranges;
    assert_eq!((kept.len(), kept[0].input.as_str()), (1, v.as_str()));
    assert!((kept[0].min.unwrap() - least).abs() < 1e-15 && kept[0].max == Some(1.0));
}
