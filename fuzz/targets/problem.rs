//! A problem file on one of three models.

#![no_main]

use bracketry_mpc::ControlProblem;
use bracketry_system::{Document, System};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = ControlProblem::parse("problem.toml", text, |name| {
        let model = match name {
            "pendulum_driven.toml" => include_str!("../../models/pendulum_driven.toml"),
            "cart_pole_friction.toml" => include_str!("../../models/cart_pole_friction.toml"),
            "spring_mass_friction.toml" => include_str!("../../models/spring_mass_friction.toml"),
            "double_integrator.toml" => include_str!("../../models/double_integrator.toml"),
            _ => return Err(Box::new(Document::new(name, "").missing("is not there", "name a model that is"))),
        };
        System::parse(name, model).map_err(Box::new)
    });
});
