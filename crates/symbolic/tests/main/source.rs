//! Emitted Rust, C and Python, compiled and run, give what the tape gives.
#![allow(clippy::print_stderr)]

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

use crate::common::{Kind, generator, point, random};
use bracketry_symbolic::{CompileError, Expr, Language, Pool, Symbol, Tape};

/// Functions with their arguments and results, and points at which to compare.
struct Suite {
    pool: Pool,
    functions: Vec<(Vec<Symbol>, Vec<Expr>)>,
    points: Vec<Vec<f64>>,
}

fn suite() -> Suite {
    let mut p = Pool::new();
    let mut rng = generator(11);
    let mut functions = Vec::new();
    let xyz = crate::common::NAMES.map(|n| p.symbol(n)).to_vec();
    for _ in 0..60 {
        let outputs = (0..3).map(|_| random(&mut p, &mut rng, 4, Kind::Any)).collect();
        functions.push((xyz.clone(), outputs));
    }
    // Names that some language reserves, that differ only where it does not tell them apart, or that locals would have.
    for names in [
        ["lambda", "double", "fn"],
        ["t0", "t1", "t0_"],
        ["θ", "der(u)", "der(u, 2)"],
        ["sin", "math", "out"],
        ["_", "1", "x'"],
        ["a.b", "a_b", "a b"],
        ["M_PI", "isnan", "abs"],
    ] {
        let symbols: Vec<Symbol> = names.iter().map(|n| p.symbol(n)).collect();
        let [a, b, c] = [0, 1, 2].map(|i| p.sym(symbols[i]));
        let (ab, sc) = (p.mul(a, b), p.sin(c));
        let e = p.add(ab, sc);
        functions.push((symbols, vec![e, a, b, c]));
    }
    let constants = [
        "1e300*1e300 - x",
        "-(1e300*1e300) + x",
        "x^64",
        "x^65",
        "x^-64",
        "x^(5/2)",
        "x^(-7/2)",
        "(-2.5)^x",
        "0.1",
        "-x*-0.1",
        "sign(-x)",
        "max(-2, -x)",
        "x^(1/3)",
    ];
    functions.push((xyz.clone(), constants.iter().map(|t| p.parse(t).unwrap()).collect()));
    functions.push((xyz, Vec::new()));
    let mut points: Vec<Vec<f64>> = (0..5).map(|_| point(&mut rng).to_vec()).collect();
    points.extend([vec![-0.7, 1.3, -2.2], vec![0.5, 0.5, 0.5], vec![1.0, -1.0, 2.0]]);
    Suite { pool: p, functions, points }
}

impl Suite {
    fn expected(&self) -> Vec<f64> {
        let mut all = Vec::new();
        for (arguments, outputs) in &self.functions {
            let tape = Tape::compile(&self.pool, arguments, outputs).unwrap();
            let mut out = vec![0.0; outputs.len()];
            for x in &self.points {
                tape.eval(x, &mut Vec::new(), &mut out);
                all.extend(&out);
            }
        }
        all
    }

    fn sources(&self, language: Language) -> Vec<String> {
        let function = |(i, (a, o)): (usize, &(Vec<Symbol>, Vec<Expr>))| {
            self.pool.source(language, &format!("g{i}"), a, o).unwrap()
        };
        self.functions.iter().enumerate().map(function).collect()
    }

    /// Compares printed numbers, one per line, with the tape.
    fn check(&self, printed: &str, language: Language) {
        let got: Vec<f64> = printed.lines().map(|l| l.trim().parse().unwrap()).collect();
        let expected = self.expected();
        assert_eq!(got.len(), expected.len());
        let (mut finite, mut at) = (0, 0);
        for (i, (arguments, outputs)) in self.functions.iter().enumerate() {
            for x in &self.points {
                for &o in outputs {
                    let (g, e) = (got[at], expected[at]);
                    at += 1;
                    finite += usize::from(e.is_finite());
                    // The same operations; only the last bits of library functions may differ, amplified by what follows.
                    let same = g == e || (g.is_nan() && e.is_nan()) || (g - e).abs() <= 1e-9 * e.abs().max(1e-3);
                    // Python raises an error where the others go on with an infinity or NaN.
                    let raised = language == Language::Python && g.is_nan();
                    assert!(same || raised, "f{i}{arguments:?}{x:?} {}: {g} but {e}", self.pool.text(o));
                }
            }
        }
        assert!(finite > 600, "{finite}");
    }
}

fn directory(name: &str) -> PathBuf {
    let d = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("source-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&d).unwrap();
    d
}

/// Runs a program to its end; `None`, with a message, if it is not installed.
fn run(program: &str, arguments: &[&str]) -> Option<String> {
    let Ok(out) = Command::new(program).args(arguments).output() else {
        eprintln!("skipped: `{program}` is not installed");
        return None;
    };
    assert!(out.status.success(), "{program}: {}", String::from_utf8_lossy(&out.stderr));
    assert!(out.stderr.is_empty(), "{program} warns: {}", String::from_utf8_lossy(&out.stderr));
    Some(String::from_utf8(out.stdout).unwrap())
}

#[test]
fn rust_source_computes_what_the_tape_computes() {
    let (suite, d) = (suite(), directory("rust"));
    let mut text = suite.sources(Language::Rust).join("\n") + "\nfn main() {\n";
    for (i, _) in suite.functions.iter().enumerate() {
        for x in &suite.points {
            let _ = writeln!(text, "for v in g{i}({:?}, {:?}, {:?}) {{ println!(\"{{v}}\"); }}", x[0], x[1], x[2]);
        }
    }
    text.push_str("}\n");
    let (file, program) = (d.join("f.rs"), d.join("f"));
    std::fs::write(&file, text).unwrap();
    let arguments = ["--edition", "2024", "-D", "warnings", "-o", program.to_str().unwrap(), file.to_str().unwrap()];
    if run("rustc", &arguments).is_some() {
        suite.check(&run(program.to_str().unwrap(), &[]).unwrap(), Language::Rust);
    }
    std::fs::remove_dir_all(d).unwrap();
}

#[test]
fn c_source_computes_what_the_tape_computes() {
    let (suite, d) = (suite(), directory("c"));
    let mut text = suite.sources(Language::C).join("\n") + "\n#include <stdio.h>\nint main(void) {\ndouble o[16];\n";
    for (i, (_, outputs)) in suite.functions.iter().enumerate() {
        for x in &suite.points {
            let _ = write!(text, "g{i}({:?}, {:?}, {:?}, o);", x[0], x[1], x[2]);
            let _ = writeln!(text, "for (int i = 0; i < {}; i++) printf(\"%.17g\\n\", o[i]);", outputs.len());
        }
    }
    text.push_str("return 0;\n}\n");
    let (file, program) = (d.join("f.c"), d.join("f"));
    std::fs::write(&file, text).unwrap();
    let arguments = [
        "-std=c99",
        "-Wall",
        "-O1",
        "-ffp-contract=off",
        "-o",
        program.to_str().unwrap(),
        file.to_str().unwrap(),
        "-lm",
    ];
    if run("cc", &arguments).is_some() {
        suite.check(&run(program.to_str().unwrap(), &[]).unwrap(), Language::C);
    }
    std::fs::remove_dir_all(d).unwrap();
}

#[test]
fn python_source_computes_what_the_tape_computes() {
    let (suite, d) = (suite(), directory("python"));
    let mut text = suite.sources(Language::Python).join("\n\n");
    for (i, (_, outputs)) in suite.functions.iter().enumerate() {
        for x in &suite.points {
            let n = outputs.len();
            let _ = writeln!(text, "try:\n    r = g{i}({:?}, {:?}, {:?})", x[0], x[1], x[2]);
            let _ = writeln!(text, "except (ZeroDivisionError, ValueError, OverflowError):\n    r = {n} * (math.nan,)");
            let _ = writeln!(text, "assert len(r) == {n}\nfor v in r:\n    print(repr(float(v)))");
        }
    }
    let file = d.join("f.py");
    std::fs::write(&file, text).unwrap();
    if let Some(printed) = run("python3", &[file.to_str().unwrap()]) {
        suite.check(&printed, Language::Python);
    }
    std::fs::remove_dir_all(d).unwrap();
}

#[test]
fn each_common_subexpression_is_assigned_once() {
    let mut p = Pool::new();
    let e = p.parse("sin(x*y)^2 + 1/(1 + sin(x*y))").unwrap();
    let arguments = [p.symbol("x"), p.symbol("y")];
    let text = p.source(Language::Rust, "f", &arguments, &[e, e]).unwrap();
    assert_eq!(
        text,
        "#[allow(clippy::all, non_snake_case, unused_variables, unused_parens)]
pub fn f(x: f64, y: f64) -> [f64; 2] {
    let t0 = f64::sin(x * y);
    let t1 = t0 * t0 + 1.0 / (1.0 + t0);
    [t1, t1]
}
"
    );
}

#[test]
fn unbound_names_are_refused() {
    let mut p = Pool::new();
    let e = p.parse("x + k").unwrap();
    let x = p.symbol("x");
    for l in Language::ALL {
        assert_eq!(p.source(l, "f", &[x], &[e]), Err(CompileError::Unbound { name: "k".into() }));
    }
}
