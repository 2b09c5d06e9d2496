//! The example in C, compiled and linked to both libraries, controls its plant.
#![allow(clippy::print_stderr)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// What Rust's standard library needs of the system.
const SYSTEM: [&str; 6] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-ldl", "-lm"];

/// Where cargo puts the libraries for tests.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// Compiles the example with these arguments of the linker, and runs it; none if there is no compiler.
fn run(name: &str, link: &[&str]) -> Option<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-I"]).arg(root.join("include"));
    compiler.arg(root.join("examples/cart_pole.c")).args(link).arg("-lm").arg("-o").arg(&program);
    let Ok(compiled) = compiler.output() else {
        eprintln!("skipped: `cc` is not installed");
        return None;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let run = Command::new(&program)
        .arg(root.join("examples/cart_pole.toml"))
        .env("LD_LIBRARY_PATH", libraries())
        .env("DYLD_LIBRARY_PATH", libraries())
        .output()
        .unwrap();
    std::fs::remove_file(program).unwrap();
    let (out, err) = (String::from_utf8(run.stdout).unwrap(), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{out}{err}");
    assert!(err.is_empty(), "{err}");
    Some(out)
}

#[test]
fn the_pole_is_swung_up_and_held_from_c() {
    // The names of libraries and the options of compilers are those of Unix.
    if cfg!(windows) {
        return;
    }
    let folder = libraries();
    let folder = folder.to_str().unwrap();
    let archive = format!("{folder}/libbracketry_c.a");
    let fixed =
        if cfg!(target_os = "linux") { [&[archive.as_str()][..], &SYSTEM].concat() } else { vec![archive.as_str()] };
    let (Some(fixed), Some(shared)) = (run("static", &fixed), run("dynamic", &["-L", folder, "-lbracketry_c"])) else {
        return;
    };
    assert!(fixed.contains("sample 250: lost_sample, input of the plan\n"), "{fixed}");
    assert_eq!(fixed, shared, "the same arithmetic in both libraries");
}

/// The loop of the guide, with the functions that it leaves to its reader.
#[test]
fn the_loop_of_the_guide_compiles() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = std::fs::read_to_string(root.join("../../docs/c.md")).unwrap();
    let code = guide.split("```c\n").nth(1).unwrap().split("```").next().unwrap();
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("guide-{}.c", std::process::id()));
    std::fs::write(&file, format!("int measure(double *, double *);\nvoid apply(const double *);\n{code}")).unwrap();
    let compiled = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-I"])
        .arg(root.join("include"))
        .arg(&file)
        .output();
    std::fs::remove_file(file).unwrap();
    match compiled {
        Ok(out) => assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr)),
        Err(_) => eprintln!("skipped: `cc` is not installed"),
    }
}
