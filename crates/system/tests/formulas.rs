//! The formulas of every model in the repository, as they were stored.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::path::Path;

use bracketry_system::System;

#[test]
fn models_have_the_stored_formulas() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::fs::read_dir(crate_folder.join("../../models")).unwrap();
    let mut files: Vec<_> =
        folder.map(|f| f.unwrap().path()).filter(|p| p.extension().is_some_and(|x| x == "toml")).collect();
    files.sort();
    let mut found = String::new();
    for file in files {
        // Problem files and robots stand in the same folder.
        let Ok(system) = System::read(&file) else { continue };
        let _ = writeln!(found, "# {}", system.name);
        let rates = system.state_names().into_iter().zip(system.dynamics.iter().copied());
        for (name, e) in rates.chain(system.outputs.iter().cloned()) {
            let _ = writeln!(found, "{name}: {}", system.pool.latex(e));
        }
    }
    if std::env::var("WRITE").is_ok() {
        std::fs::write(crate_folder.join("tests/formulas.txt"), &found).unwrap();
    }
    let stored = std::fs::read_to_string(crate_folder.join("tests/formulas.txt")).unwrap();
    for (found, stored) in found.lines().zip(stored.lines()) {
        assert_eq!(found, stored);
    }
    assert_eq!(found.lines().count(), stored.lines().count());
}
