//! The header in the repository is that of the functions.

use std::fs;
use std::path::Path;

/// The order in which they stand in the header.
const SOURCES: [&str; 5] = ["codes", "error", "controller", "changes", "names"];

#[test]
fn the_header_is_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for name in SOURCES {
        builder = builder.with_src(root.join(format!("src/{name}.rs")));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = root.join("include/bracketry.h");
    if std::env::var_os("BRACKETRY_WRITE_STORED").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let stored = fs::read_to_string(&path).unwrap_or_default();
    assert!(made == stored, "write it anew: BRACKETRY_WRITE_STORED=1 cargo test -p bracketry-c --test main header::");
    for function in ["new", "from_text", "free", "step", "prepare", "feedback", "reset", "set_reference", "predict"] {
        assert!(stored.contains(&format!("bracketry_controller_{function}(")), "{function}");
    }
    // Every file with functions is among them.
    for entry in fs::read_dir(root.join("src")).unwrap() {
        let path = entry.unwrap().path();
        let exports = fs::read_to_string(&path).unwrap().contains("no_mangle");
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert_eq!(exports, SOURCES.contains(&name), "{name}");
    }
}
