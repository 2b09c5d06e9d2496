//! A model file: read, written and read again; affine form, switching modes and compiled dynamics of small models.

#![no_main]

use bracketry_system::System;
use libfuzzer_sys::fuzz_target;

/// Models with more nodes than this are only read and written.
const SMALL: f64 = 120.0;

fuzz_target!(|text: &str| {
    let Ok(mut system) = System::parse("model.toml", text) else { return };
    let size: f64 =
        system.dynamics.iter().chain(system.outputs.iter().map(|(_, e)| e)).map(|&e| system.pool.tree_size(e)).sum();
    if size > 1e5 {
        return;
    }
    if let Ok(written) = system.to_toml() {
        let again = System::parse("written.toml", &written)
            .unwrap_or_else(|e| panic!("what was written cannot be read: {e}\n{written}"));
        assert_eq!(again.state_names(), system.state_names());
        assert_eq!(again.input_names(), system.input_names());
    }
    let _ = system.point_values();
    let _ = system.delay_values();
    if size > SMALL || system.states.len() > 4 || system.inputs.len() + system.input_derivatives.len() > 3 {
        return;
    }
    let (arguments, dynamics) = (system.arguments(), system.dynamics.clone());
    if let Ok(tape) = system.compile(&arguments, &dynamics) {
        let mut out = vec![0.0; tape.n_outputs()];
        tape.eval(&vec![0.5; tape.n_inputs()], &mut Vec::new(), &mut out);
    }
    let form = system.switched_form();
    let _ = form.switches.len();
    let _ = system.affine_form();
    if let Ok(affine) = system.affinize() {
        let mut affine = affine.system;
        assert!(
            !matches!(affine.affine_form(), Ok(None)) || !affine.switched_form().switches.is_empty(),
            "the affine system is not affine"
        );
    }
});
