//! Closed-loop costs of the problem files in `models/`, against those that CasADi with IPOPT gives for the same discretized
//! problems: `python benches/peers/control_references.py` prints them.

use crate::common::exact_plant;
use bracketry_mpc::closed_loop::RungeKuttaPlant;
use bracketry_mpc::problem::{ClosedLoopReport, Convergence, Feedback, Method};
use bracketry_mpc::{ControlProblem, Plant, SymbolicDynamics};

fn run(name: &str) -> ClosedLoopReport {
    run_problem(&ControlProblem::read(crate::common::model_path(&format!("{name}.toml"))).unwrap())
}

fn run_problem(problem: &ControlProblem) -> ClosedLoopReport {
    let switches = problem.plant.clone().set_valued_form().switches;
    let mut plant: Box<dyn Plant> = if switches.is_empty() {
        let dynamics = Box::new(SymbolicDynamics::new(&problem.plant).unwrap());
        Box::new(RungeKuttaPlant::new(dynamics, problem.plant_substeps))
    } else {
        Box::new(exact_plant(&problem.plant, &problem.x0))
    };
    problem.run(plant.as_mut()).unwrap().report
}

/// The closed-loop cost agrees with the reference to 0.1 %, with a solution at every sample.
fn costs(name: &str, reference: f64) -> ClosedLoopReport {
    let report = run(name);
    let cost = report.closed_loop_cost;
    assert!((cost / reference - 1.0).abs() < 1e-3, "{name}: {cost} in place of {reference}");
    assert_eq!(report.status.infeasible + report.status.fallback, 0, "{name}: {:?}", report.status);
    report
}

#[test]
fn double_integrator() {
    costs("double_integrator_rest", 5.210479);
}

#[test]
fn van_der_pol_oscillator() {
    costs("van_der_pol_rest", 4.187377);
}

#[test]
fn stirred_tank_reactor_at_its_unstable_steady_state() {
    let report = costs("cstr_set_point", 6.757788);
    assert!((report.x_final.get("c").unwrap() - 0.5).abs() < 1e-4);
}

#[test]
fn fed_batch_fermenter_with_an_economic_cost() {
    costs("fed_batch_production", -31.689603);
}

#[test]
fn six_oscillating_masses() {
    costs("oscillating_masses_rest", 297.778463);
}

#[test]
fn quadrotor_with_limited_thrust_and_tilt() {
    costs("quadrotor_flight", 17.998294);
}

#[test]
fn klatt_engell_reactor() {
    costs("klatt_engell_set_point", 0.070433);
}

#[test]
fn chain_of_masses_beside_a_wall() {
    costs("chain_of_masses_rest", 2.396714);
}

#[test]
fn spring_mass_with_friction() {
    // Smoothed friction gives 5.791814 and ends at 1.98475; the optimum on the exact flow is 5.791733 and 1.996371.
    let report = run("spring_mass_friction_target");
    assert!(report.closed_loop_cost <= 5.793, "{}", report.closed_loop_cost);
    assert!((report.x_final.get("x").unwrap() - 2.0).abs() <= 0.005, "{}", report.x_final.get("x").unwrap());
}

#[test]
fn cart_pole_with_friction() {
    // The reference smooths the friction in the controller, with a width of 0.05 m/s.
    costs("cart_pole_friction_swing_up", 2062.145902);
}

#[test]
fn cart_pole_with_smoothed_friction_in_the_controller() {
    let mut problem = ControlProblem::read(crate::common::model_path("cart_pole_friction_swing_up.toml")).unwrap();
    problem.method = Method::Sqp { convergence: Convergence::default(), first: Feedback::default() };
    let cost = run_problem(&problem).closed_loop_cost;
    assert!((cost / 2062.145902 - 1.0).abs() < 1e-3, "{cost}");
}
