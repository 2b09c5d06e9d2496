//! The known systems of `benches/peers/problems`: their files are valid, and first plans cost what IPOPT finds for the same discretized
//! problem from the same guess (`python benches/peers/known_systems.py --references`).

use crate::common::exact_plant;
use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::problem::{ClosedLoopReport, Convergence, Feedback, Method};
use bracketry_mpc::{ControlProblem, Plant, SymbolicDynamics};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn folder(kind: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../benches/peers/problems").join(kind)
}

fn references() -> Value {
    let text = std::fs::read_to_string(folder("references.json")).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()["problems"].take()
}

/// The run of one sample.
fn first_sample(kind: &str, name: &str, method: Method) -> ClosedLoopReport {
    let mut problem = ControlProblem::read(folder(kind).join(format!("{name}.toml"))).unwrap();
    problem.method = method;
    problem.samples = 1;
    let mut plant: Box<dyn Plant> = if problem.plant.is_smooth() {
        let dynamics = Box::new(SymbolicDynamics::new(&problem.plant).unwrap());
        Box::new(RungeKuttaPlant::new(dynamics, problem.plant_substeps))
    } else {
        Box::new(exact_plant(&problem.plant, &problem.x0))
    };
    problem.run(plant.as_mut()).unwrap().report
}

#[test]
fn every_problem_is_valid_and_has_a_reference() {
    let references = references();
    let mut counts = [0, 0];
    for (count, kind) in counts.iter_mut().zip(["smooth", "friction"]) {
        for entry in std::fs::read_dir(folder(kind)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let problem = ControlProblem::read(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_eq!(problem.system.is_smooth(), kind == "smooth", "{name}");
            assert_eq!(references[&name]["kind"], kind, "{name}");
            *count += 1;
        }
    }
    assert!(counts[0] >= 50 && counts[1] >= 35, "{counts:?}");
}

#[test]
fn smooth_plans_cost_what_ipopt_finds() {
    let references = references();
    let quick = "batch_reactor brachistochrone cart_pole_kelly chen_allgower container_crane evaporator free_flying_robot hicks_ray hiv_chemotherapy hoisting_crane hot_rod isothermal_cstr \
                 lotka_volterra_bounds lotka_volterra_fishing luus_cstr magnetic_levitation moving_obstacle orbit_transfer parallel_parking park_ramirez \
                 pendubot_swing_up pendulum_weak_motor planar_quadrotor_flip pvtol pvtol_flip quadruple_tank rayleigh \
                 rayleigh_mixed rendezvous satellite_reorientation seir_vaccination van_der_pol zermelo";
    for name in quick.split_whitespace() {
        let method = Method::Sqp { convergence: Convergence::default(), first: Feedback::default() };
        let cost = first_sample("smooth", name, method).open_loop_cost;
        let reference = references[name]["same_guess"].as_f64().unwrap();
        assert!((cost - reference).abs() <= 1e-3 * reference.abs(), "{name}: {cost} in place of {reference}");
    }
}

#[test]
fn plans_with_friction_cost_no_more_than_those_of_ipopt_on_the_exact_flow() {
    let references = references();
    let quick = "incline_up pendulum_hold rack_and_pinion rail slider_viscous spring_mass_stiff two_blocks valve";
    for name in quick.split_whitespace() {
        let cost = first_sample("friction", name, Method::StickSlip { iterations: 100 }).open_loop_cost;
        let reference = references[name]["on_sharp_flow"].as_f64().unwrap();
        assert!(cost <= 1.001 * reference, "{name}: {cost}, IPOPT {reference}");
    }
}
