//! Dependencies between crates point downward only, and users of the library build nothing of the command.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use toml::Table;

/// The layers from the lowest up: each crate may use those before it.
const LAYERS: [&str; 22] = [
    "bracketry-numerics",
    "bracketry-symbolic",
    "bracketry-files",
    "bracketry-plot",
    "bracketry-native",
    "bracketry-system",
    "bracketry-export",
    "bracketry-lie",
    "bracketry-sim",
    "bracketry-certify",
    "bracketry-steer",
    "bracketry-stiffness",
    "bracketry-mpc",
    "bracketry-c",
    "bracketry-diagnose",
    "bracketry-experiment",
    "bracketry-plate",
    "bracketry-report",
    "bracketry",
    "bracketry-trials",
    "bracketry-cli",
    "bracketry-python",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn manifest(path: &Path) -> Table {
    fs::read_to_string(path).unwrap().parse().unwrap()
}

/// All manifests of the workspace with the names of their crates.
fn manifests() -> Vec<(String, Table)> {
    let crates = fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let folders = crates.chain([root().to_owned()]).filter(|folder| folder.join("Cargo.toml").exists());
    let named = |folder: std::path::PathBuf| {
        let manifest = manifest(&folder.join("Cargo.toml"));
        (manifest["package"]["name"].as_str().unwrap().to_owned(), manifest)
    };
    folders.map(named).collect()
}

fn dependencies(manifest: &Table) -> Vec<String> {
    manifest["dependencies"].as_table().unwrap().keys().cloned().collect()
}

#[test]
fn every_crate_uses_only_crates_below_it() {
    let floor = |name: &str| LAYERS.iter().position(|f| *f == name);
    let manifests = manifests();
    assert_eq!(manifests.len(), LAYERS.len(), "a new crate has its place in LAYERS");
    for (name, manifest) in manifests {
        let own = floor(&name).unwrap_or_else(|| panic!("{name} has no place in LAYERS"));
        for used in dependencies(&manifest).iter().filter(|d| d.starts_with("bracketry")) {
            assert!(floor(used).unwrap() < own, "{name} uses {used}, which stands above it");
        }
    }
}

#[test]
fn only_tests_and_examples_draw_at_random_for_trials() {
    for (name, manifest) in manifests() {
        let used = dependencies(&manifest);
        let trials = used.iter().any(|d| d == "bracketry-trials");
        assert!(!trials, "{name} builds the generators of trials for its users");
    }
    // A dev-dependency with a version would have to be published before the crate that its tests are of.
    let trials = &manifest(&root().join("Cargo.toml"))["workspace"]["dependencies"]["bracketry-trials"];
    assert!(trials.get("version").is_none());
}

/// Those that no feature has to ask for.
fn required(manifest: &Table) -> Vec<String> {
    let optional = |name: &String| manifest["dependencies"][name].get("optional").is_some();
    dependencies(manifest).into_iter().filter(|name| !optional(name)).collect()
}

/// The packages that a package of the lock file brings along, itself included, by what `of` says of the manifests of the workspace.
fn brought_along(package: &str, of: fn(&Table) -> Vec<String>) -> BTreeSet<String> {
    let lock = manifest(&root().join("Cargo.lock"));
    let packages = lock["package"].as_array().unwrap();
    let manifests = manifests();
    let mut seen = BTreeSet::new();
    let mut open = vec![package.to_owned()];
    while let Some(name) = open.pop() {
        if !seen.insert(name.clone()) {
            continue;
        }
        if let Some((_, manifest)) = manifests.iter().find(|(n, _)| *n == name) {
            // Members list what their tests need in the lock file too.
            open.extend(of(manifest));
            continue;
        }
        for p in packages.iter().filter(|p| p["name"].as_str() == Some(&name)) {
            let uses = p.get("dependencies").and_then(toml::Value::as_array).into_iter().flatten();
            open.extend(uses.map(|d| d.as_str().unwrap().split(' ').next().unwrap().to_owned()));
        }
    }
    seen
}

#[test]
fn without_features_the_library_is_expressions_models_and_analysis() {
    let brought = brought_along("bracketry", required);
    let own: Vec<&str> = brought.iter().filter_map(|name| name.strip_prefix("bracketry-")).collect();
    assert_eq!(own, ["files", "lie", "numerics", "symbolic", "system"]);
    for name in ["clarabel", "cranelift-codegen", "resvg", "roxmltree", "zip", "rand"] {
        assert!(!brought.contains(name), "{name} is in the tree of an analysis");
    }
}

#[test]
fn a_user_of_the_library_builds_nothing_of_the_command() {
    let brought = brought_along("bracketry", dependencies);
    assert!(brought.contains("clarabel"), "the walk through the lock file found nothing");
    for name in ["clap", "clap_mangen", "anstream", "indicatif", "zstd", "bzip2", "aes"] {
        assert!(!brought.contains(name), "{name} is in the tree of the library");
    }
    // Cranelift's linker of machine code brings anyhow; no crate of ours asks for it.
    for (name, manifest) in manifests().into_iter().filter(|(name, _)| name != "bracketry-cli") {
        assert!(!dependencies(&manifest).iter().any(|d| d == "anyhow"), "{name} uses anyhow");
    }
}

/// The Rust files below a folder.
fn sources(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
}

/// Reports print expressions that results hold; a pool of their own would be one for expressions read from text.
/// A library without a test program of its own has no tests in its sources: nothing would compile them, and nobody would notice.
#[test]
fn no_test_stands_where_none_is_compiled() {
    let mut without = 0;
    for folder in fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path()) {
        let Ok(text) = fs::read_to_string(folder.join("Cargo.toml")) else { continue };
        let manifest: Table = text.parse().unwrap();
        if manifest.get("lib").and_then(|lib| lib.get("test")?.as_bool()) != Some(false) {
            continue;
        }
        without += 1;
        for file in sources(&folder.join("src")) {
            let text = fs::read_to_string(&file).unwrap();
            assert!(!text.contains("cfg(test)") && !text.contains("#[test]"), "{}", file.display());
        }
    }
    assert!(without > 10, "{without} libraries");
}

#[test]
fn reports_read_no_expression_from_text() {
    for folder in ["crates/report/src", "crates/cli/src"] {
        for path in sources(&root().join(folder)) {
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap();
            for reads in ["Pool::new", "pool.parse", "parse_with"] {
                assert!(!code.contains(reads), "{} has `{reads}`", path.display());
            }
        }
    }
}

/// Reports print what was found before: they start no analysis, simulation, fit, or solver of their own.
#[test]
fn reports_compute_nothing() {
    let found_elsewhere = [
        "analyze(",
        "analyze_affine(",
        "affinize(",
        "transform(",
        "linearize(",
        "trim(",
        "identifiability(",
        "simulate(",
        "diagnose(",
        "control(",
        "steer(",
        "certify(",
        "identify(",
        "compensate(",
        "solve(",
    ];
    for path in sources(&root().join("crates/report/src")) {
        let text = fs::read_to_string(&path).unwrap();
        let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        for line in lines.filter(|line| !line.contains("fn ")) {
            for call in found_elsewhere {
                let at = line.match_indices(call).find(|(at, _)| {
                    !line[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.' || c == '"')
                });
                assert!(at.is_none(), "{} calls `{call}`: {line}", path.display());
            }
        }
    }
}
