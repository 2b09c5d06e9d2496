//! Exported source, compiled and run, gives what the library computes.
#![allow(clippy::print_stderr)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::common::{Case, cases, compare, folder, python, run};
use bracketry_export::{ExportOptions, Target, export};
use bracketry_system::System;

/// `{1.0, 2.0}` with an entry where C wants one.
fn numbers(list: &[f64]) -> String {
    list.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ")
}

fn write(case: &Case, target: Target, folder: &Path) {
    for file in case.export(target).files {
        fs::write(folder.join(file.name), file.text).unwrap();
    }
}

#[test]
fn c_computes_what_the_library_computes() {
    let (cases, dir) = (cases(), folder("c"));
    let mut main = String::from("#include <stdio.h>\n");
    let mut calls = String::new();
    for case in &cases {
        write(case, Target::C, &dir);
        let name = &case.name;
        let _ = writeln!(main, "#include \"{name}.c\"");
        let (n, m, o) = (case.system.states.len(), case.points[0][1].len(), case.system.outputs.len());
        let _ = writeln!(
            calls,
            "typedef char size_of_{name}[{0}_STATES == {n} && {0}_INPUTS == {m} ? 1 : -1];",
            name.to_uppercase()
        );
        let _ = writeln!(calls, "static void run_{name}(void) {{");
        for point in &case.points {
            let [x, u, p] = point.each_ref().map(|list| if list.is_empty() { "0".to_owned() } else { numbers(list) });
            let _ = writeln!(calls, "{{ const double x[] = {{{x}}}, u[] = {{{u}}}, p[] = {{{p}}}; (void)p;");
            let p = if point[2].is_empty() { "" } else { ", p" };
            for function in case.functions() {
                let rows = if function.starts_with('f') { n } else { o };
                let sizes = if function.len() == 1 { vec![rows] } else { vec![rows * n, rows * m] };
                let outs: Vec<String> = (0..sizes.len()).map(|k| format!("out{k}")).collect();
                let _ = write!(calls, "{{ ");
                for (out, size) in outs.iter().zip(&sizes) {
                    let _ = write!(calls, "double {out}[{}]; ", (*size).max(1));
                }
                let _ = write!(calls, "{name}_{function}(0.5, x, u{p}, {}); ", outs.join(", "));
                for (out, size) in outs.iter().zip(&sizes) {
                    let _ = write!(calls, "show({out}, {size}); ");
                }
                let _ = writeln!(calls, "}}");
            }
            let _ = writeln!(calls, "}}");
        }
        let _ = writeln!(calls, "}}");
    }
    main.push_str(
        "static void show(const double *v, int n) { for (int i = 0; i < n; i++) printf(\"%.17g\\n\", v[i]); }\n",
    );
    main.push_str(&calls);
    main.push_str("int main(void) {\n");
    for case in &cases {
        let _ = writeln!(main, "run_{}();", case.name);
    }
    main.push_str("return 0;\n}\n");
    fs::write(dir.join("main.c"), main).unwrap();
    let options =
        ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off", "main.c", "-o", "main", "-lm"];
    if run(Path::new("cc"), &dir, &options).is_some() {
        compare(&cases, &run(&dir.join("main"), &dir, &[]).unwrap());
    }
    fs::remove_dir_all(dir).unwrap();
}

#[test]
fn c_as_one_file_compiles_alone_and_as_cpp() {
    let dir = folder("c-single");
    let made = crate::common::random_system(7);
    let made = export(&made, &ExportOptions::new(Target::C)).unwrap();
    fs::write(dir.join("model.c"), &made.single).unwrap();
    let strict = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-c", "model.c", "-o", "model.o"];
    run(Path::new("cc"), &dir, &[&["-std=c99"][..], &strict].concat());
    run(Path::new("c++"), &dir, &[&["-x", "c++"][..], &strict].concat());
    fs::remove_dir_all(dir).unwrap();
}

#[test]
fn rust_computes_what_the_library_computes() {
    let (cases, dir) = (cases(), folder("rust"));
    let mut main = String::from("fn show(v: &[f64]) { for a in v { println!(\"{a}\"); } }\n");
    let mut calls = String::from("fn main() {\n");
    for case in &cases {
        write(case, Target::Rust, &dir);
        let name = &case.name;
        let _ = writeln!(main, "mod {name};");
        for point in &case.points {
            let [x, u, p] = point.each_ref().map(|list| numbers(list));
            let p = if point[2].is_empty() { String::new() } else { format!(", &[{p}]") };
            for function in case.functions() {
                let call = format!("{name}::{function}(0.5, &[{x}], &[{u}]{p})");
                let _ = if function.len() == 1 {
                    writeln!(calls, "show(&{call});")
                } else {
                    writeln!(calls, "{{ let (a, b) = {call}; show(a.as_flattened()); show(b.as_flattened()); }}")
                };
            }
        }
    }
    fs::write(dir.join("main.rs"), main + &calls + "}\n").unwrap();
    let options = ["--edition", "2024", "-D", "warnings", "-o", "main", "main.rs"];
    if run(Path::new("rustc"), &dir, &options).is_some() {
        compare(&cases, &run(&dir.join("main"), &dir, &[]).unwrap());
    }
    fs::remove_dir_all(dir).unwrap();
}

/// Without the standard library `f64` has no `sin`: a trait gives it, as the comment in the file says.
#[test]
fn rust_needs_no_standard_library() {
    let dir = folder("rust-core");
    let text = "states = ['v']\ninputs = ['u']\ndynamics = { v = 'sin(v)*log(2 + v^2) - u^(1/3)*sign(v)' }\n";
    let system = System::parse("block.toml", text).unwrap();
    let made = export(&system, &ExportOptions::new(Target::Rust)).unwrap();
    let source = made.single.replace("\n\n/// Names of the states", "\nuse super::Float;\n\n/// Names of the states");
    assert!(source.contains("use super::Float;"), "{source}");
    fs::write(dir.join("block.rs"), source).unwrap();
    let unary = ["sin", "cos", "ln", "abs", "sqrt"].map(|f| format!("fn {f}(self) -> f64 {{ self }} "));
    let library = format!(
        "#![no_std]\npub trait Float {{ {} fn powf(self, k: f64) -> f64; }}\n\
         impl Float for f64 {{ {} fn powf(self, k: f64) -> f64 {{ self * k }} }}\npub mod block;\n",
        unary.join("").replace("{ self }", ";"),
        unary.join("")
    );
    fs::write(dir.join("lib.rs"), library).unwrap();
    run(Path::new("rustc"), &dir, &["--edition", "2024", "--crate-type", "lib", "--emit", "metadata", "lib.rs"]);
    fs::remove_dir_all(dir).unwrap();
}

/// Calls all functions of all cases and prints what they give.
fn python_driver(cases: &[Case], suffix: &str, functions: &str) -> String {
    let mut main = String::from("import importlib\nimport numpy as np\nnp.seterr(all='ignore')\n");
    main.push_str("cases = [\n");
    for case in cases {
        let points: Vec<String> = case
            .points
            .iter()
            .map(|[x, u, p]| {
                let p = if p.is_empty() { String::new() } else { format!(", [{}]", numbers(p)) };
                format!("(0.5, [{}], [{}]{p})", numbers(x), numbers(u))
            })
            .collect();
        let _ = writeln!(main, "    ('{}{suffix}', {:?}, [{}]),", case.name, case.functions(), points.join(", "));
    }
    main.push_str("]\nfor module, functions, points in cases:\n    module = importlib.import_module(module)\n");
    main.push_str(functions);
    main
}

#[test]
fn python_computes_what_the_library_computes() {
    let Some(interpreter) = python("numpy") else { return };
    let (cases, dir) = (cases(), folder("python"));
    for case in &cases {
        write(case, Target::Python, &dir);
    }
    let functions = "    for point in points:
        for name in functions:
            values = getattr(module, name)(*point)
            n, k = len(module.STATES), len(module.INPUTS)
            rows = n if name[0] == 'f' else len(module.OUTPUTS)
            if len(name) == 1:
                assert values.shape == (rows,), (values.shape, rows)
            else:
                assert [v.shape for v in values] == [(rows, n), (rows, k)]
            for value in (values,) if len(name) == 1 else values:
                for number in value.ravel():
                    print(repr(float(number)))
";
    fs::write(dir.join("main.py"), python_driver(&cases, "", functions)).unwrap();
    compare(&cases, &run(&interpreter, &dir, &["-W", "error::SyntaxWarning", "main.py"]).unwrap());
    fs::remove_dir_all(dir).unwrap();
}

/// A vector with an entry too many or too few is an error in every function, also where the function uses none of its entries.
#[test]
fn python_refuses_vectors_of_another_length() {
    let Some(interpreter) = python("numpy") else { return };
    let (cases, dir) = (cases(), folder("python_lengths"));
    for case in &cases {
        write(case, Target::Python, &dir);
    }
    let functions = "    for name in functions:
        for wrong in range(1, len(points[0])):
            for change in (lambda v: v + [0.5], lambda v: v[:-1]):
                point = list(points[0])
                if change(point[wrong]) == point[wrong]:
                    continue
                point[wrong] = change(point[wrong])
                try:
                    getattr(module, name)(*point)
                except ValueError as e:
                    assert 'expected' in str(e), e
                else:
                    raise AssertionError((module.__name__, name, wrong))
";
    fs::write(dir.join("main.py"), python_driver(&cases, "", functions)).unwrap();
    run(&interpreter, &dir, &["main.py"]).unwrap();
    fs::remove_dir_all(dir).unwrap();
}

#[test]
fn casadi_computes_what_the_library_computes() {
    let Some(interpreter) = python("casadi") else { return };
    let (cases, dir) = (cases(), folder("casadi"));
    for case in &cases {
        write(case, Target::Casadi, &dir);
    }
    let functions = "    made = module.functions()
    assert list(made) == functions
    for point in points:
        for name in functions:
            values = made[name](*point)
            assert made[name].name_in()[:3] == ['t', 'x', 'u']
            for value in (values,) if len(name) == 1 else values:
                for number in np.array(value).ravel():
                    print(repr(float(number)))
";
    fs::write(dir.join("main.py"), python_driver(&cases, "_casadi", functions)).unwrap();
    compare(&cases, &run(&interpreter, &dir, &["-W", "error::SyntaxWarning", "main.py"]).unwrap());
    fs::remove_dir_all(dir).unwrap();
}

/// Reads exported Julia; it stands in for Julia itself, which is rarely installed where tests run.
const TRANSLATOR: &str = include_str!("common/julia.py");

#[test]
fn julia_read_by_a_translator_computes_what_the_library_computes() {
    let (cases, dir) = (cases(), folder("julia"));
    let mut main = String::from(TRANSLATOR);
    for case in &cases {
        write(case, Target::Julia, &dir);
        let module = case.name.to_uppercase();
        let _ = writeln!(main, "m = module(open('{module}.jl', encoding='utf-8').read(), '{module}')");
        for [x, u, p] in &case.points {
            let p = if p.is_empty() { String::new() } else { format!(", [{}]", numbers(p)) };
            for function in case.functions() {
                let call = format!("m['{function}'](0.5, [{}], [{}]{p})", numbers(x), numbers(u));
                let values = if function.len() == 1 { call } else { format!("sum({call}, [])") };
                let _ = writeln!(main, "for v in {values}: print(repr(float(v)))");
            }
        }
    }
    fs::write(dir.join("main.py"), main).unwrap();
    if let Some(interpreter) = python("math") {
        compare(&cases, &run(&interpreter, &dir, &["-W", "error::SyntaxWarning", "main.py"]).unwrap());
    }
    fs::remove_dir_all(dir).unwrap();
}
