//! The models of the repository: their formulas are those that were stored, and compiling them leaves no trace.
//! `BRACKETRY_WRITE_STORED=1` stores them anew.

use std::fmt::Write as _;
use std::path::PathBuf;

use bracketry_symbolic::Tape;
use bracketry_system::System;

fn crate_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Problem files and robots, which stand in the same folder, are left out.
fn models() -> Vec<System> {
    let folder = std::fs::read_dir(crate_folder().join("../../models")).unwrap();
    let mut files: Vec<_> =
        folder.map(|f| f.unwrap().path()).filter(|p| p.extension().is_some_and(|x| x == "toml")).collect();
    files.sort();
    files.iter().filter_map(|file| System::read(file).ok()).collect()
}

#[test]
fn models_have_the_stored_formulas() {
    let mut found = String::new();
    for system in models() {
        let _ = writeln!(found, "# {}", system.name);
        let rates = system.state_names().into_iter().zip(system.dynamics.iter().copied());
        for (name, e) in rates.chain(system.outputs.iter().cloned()) {
            let _ = writeln!(found, "{name}: {}", system.pool.latex(e));
        }
    }
    let path = crate_folder().join("tests/formulas.txt");
    if std::env::var_os("BRACKETRY_WRITE_STORED").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    let stored = std::fs::read_to_string(path).unwrap();
    for (found, stored) in found.lines().zip(stored.lines()) {
        assert_eq!(found, stored);
    }
    assert_eq!(found.lines().count(), stored.lines().count());
}

#[test]
fn compiling_leaves_the_pool_alone_and_gives_the_same_bits() {
    for mut system in models() {
        let arguments = system.arguments();
        let mut expressions = system.dynamics.clone();
        expressions.extend(system.pool.jacobian(&system.dynamics, &arguments).concat());
        let nodes = system.pool.len();
        let compiled = system.compile(&arguments, &expressions).unwrap();
        assert_eq!(system.pool.len(), nodes);
        // The same in the system's own pool, among all that it holds.
        let valued = system.with_values(&expressions);
        let in_place = Tape::compile(&system.pool, &arguments, &valued).unwrap();
        for sample in 0..20 {
            let at: Vec<f64> = (0..arguments.len()).map(|k| (1.7 * f64::from(sample) + 0.9 * k as f64).sin()).collect();
            let value = |tape: &Tape| {
                let mut out = vec![0.0; expressions.len()];
                tape.eval(&at, &mut Vec::new(), &mut out);
                out.into_iter().map(|v| if v.is_nan() { f64::NAN.to_bits() } else { v.to_bits() }).collect::<Vec<u64>>()
            };
            assert_eq!(value(&compiled), value(&in_place), "{}", system.name);
        }
    }
}
