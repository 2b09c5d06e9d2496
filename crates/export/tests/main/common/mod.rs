//! Systems to be exported, and what the library itself computes of them.
#![allow(clippy::print_stderr)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use bracketry_export::{Export, ExportOptions, KeptParameters, Target, export};
use bracketry_symbolic::{Expr, Rational, Symbol};
use bracketry_system::System;

/// Numbers that are the same on every machine.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1 << 30) as f64 / (1u64 << 30) as f64
    }

    fn choose<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// Names that some language reserves, or that stand in the files.
const NAMES: [&str; 36] = [
    "lambda",
    "in",
    "end",
    "I",
    "double",
    "fn",
    "np",
    "ca",
    "x",
    "u",
    "t",
    "p",
    "y",
    "f",
    "dx",
    "STATES",
    "match",
    "f_x",
    "h",
    "t0",
    "t1",
    "θ",
    "function",
    "module",
    "const",
    "M_PI",
    "def",
    "struct",
    "reshape",
    "zeros",
    "float",
    "im",
    "self",
    "math",
    "int",
    "PARAMETERS",
];

fn expression(r: &mut Random, names: &[&str], depth: usize) -> String {
    if depth == 0 || r.below(8) == 0 {
        return match r.below(4) {
            0 => format!("{:.3}", r.between(0.1, 3.0)),
            _ => r.choose(names).to_owned(),
        };
    }
    let a = expression(r, names, depth - 1);
    let b = expression(r, names, depth - 1);
    match r.below(16) {
        0 | 1 => format!("({a} + {b})"),
        2 | 3 => format!("({a} - {b})"),
        4 | 5 => format!("({a})*({b})"),
        6 => format!("({a})/(2 + ({b})^2)"),
        7 => format!("-({a})"),
        8 => format!("({a})^{}", 2 + r.below(3)),
        9 => format!("sqrt(1 + ({a})^2)*atan2({b}, 1.5 + ({a})^2)"),
        10 => format!("{}({a})", r.choose(&["sin", "cos", "tanh", "atan", "sign", "abs"])),
        11 => format!("{}({a}, {b})", r.choose(&["min", "max"])),
        12 => format!("exp(-({a})^2)"),
        13 => format!("log(2 + ({a})^2)*(1 + ({b})^2)^(1/3)"),
        14 => format!("(3 + sin({a}))^(0.3*({b}))"),
        _ => format!("{}(0.3*sin({a}))", r.choose(&["asin", "acos", "tan", "sinh", "cosh"])),
    }
}

/// A system of random size, names, and equations.
pub(crate) fn random_system(seed: u64) -> System {
    let mut r = Random::new(seed);
    let mut names = NAMES.to_vec();
    let mut draw =
        |r: &mut Random, n: usize| -> Vec<&str> { (0..n).map(|_| names.remove(r.below(names.len()))).collect() };
    let (n, m, k) = (1 + r.below(4), r.below(3), r.below(4));
    let (states, inputs, parameters) = (draw(&mut r, n), draw(&mut r, m), draw(&mut r, k));
    let outputs = draw(&mut r, seed as usize % 3);
    let mut all: Vec<String> = [&states[..], &inputs, &parameters].concat().iter().map(ToString::to_string).collect();
    if m > 0 && seed.is_multiple_of(2) {
        all.push(format!("der({})", inputs[0]));
    }
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let quoted = |list: &[&str]| list.iter().map(|s| format!("\"{s}\"")).collect::<Vec<_>>().join(", ");
    let mut text =
        format!("name = \"random {seed}\"\nstates = [{}]\ninputs = [{}]\n", quoted(&states), quoted(&inputs));
    let mut table = |title: &str, names: &[&str], value: &mut dyn FnMut() -> String| {
        let _ = writeln!(text, "[{title}]");
        for name in names {
            let _ = writeln!(text, "\"{name}\" = {}", value());
        }
    };
    table("parameters", &parameters, &mut || format!("{:.3}", r.between(0.2, 2.0)));
    table("dynamics", &states, &mut || format!("\"{}\"", expression(&mut r, &all, 4)));
    table("outputs", &outputs, &mut || format!("\"{}\"", expression(&mut r, &all, 3)));
    System::parse("random.toml", &text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A model with what the library computes at some points.
pub(crate) struct Case {
    pub(crate) system: System,
    pub(crate) options: KeptParameters,
    /// What the module is called.
    pub(crate) name: String,
    /// x, u with derivatives of inputs, p.
    pub(crate) points: Vec<[Vec<f64>; 3]>,
    /// By point: f, h, the Jacobian of f by x, by u, that of h by x, by u, entry by entry.
    pub(crate) expected: Vec<Vec<f64>>,
}

/// Every model of the repository, and random ones.
pub(crate) fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let shipped = files.iter().filter(|f| std::fs::read_to_string(f).unwrap().contains("\n[dynamics]"));
    let mut systems: Vec<System> = shipped.map(|f| System::read(f).unwrap()).collect();
    assert!(systems.len() > 25, "{}", systems.len());
    systems.extend((0..30).map(random_system));
    systems.into_iter().enumerate().map(|(i, system)| case(i, system)).collect()
}

fn case(i: usize, system: System) -> Case {
    let mut r = Random::new(i as u64);
    let name = format!("m{i}");
    let names: Vec<String> = system.parameters.iter().map(|p| system.symbol_name(p.symbol).to_owned()).collect();
    let (options, kept) = match i % 3 {
        0 => (KeptParameters::None, Vec::new()),
        1 => (KeptParameters::All, names),
        // In the reverse order, and not all.
        _ => {
            let kept: Vec<String> = names.iter().rev().step_by(2).cloned().collect();
            (KeptParameters::Named(kept.clone()), kept)
        }
    };
    // Kept parameters have other values than in the model, but for those that are 0 or 1 to switch a term off or on.
    let mut changed = system.clone();
    let mut p = Vec::new();
    for name in &kept {
        let parameter = system.parameters.iter().find(|p| system.symbol_name(p.symbol) == name).unwrap();
        let value = parameter.value.clone() * (Rational::from(11) / Rational::from(10));
        let switch = parameter.value == Rational::ONE || parameter.value == Rational::ZERO;
        let value = if switch { parameter.value.clone() } else { value };
        p.push(value.to_f64().value());
        assert!(changed.set_parameter(name, value));
    }
    let base = system.point_values().map_or_else(Vec::new, |(x, u)| [x, u].concat());
    let (n, m) = (system.states.len(), system.arguments().len() - system.states.len());
    let at = |i: usize| base.get(i).copied().unwrap_or(0.0);
    let points: Vec<[Vec<f64>; 3]> = (0..4)
        .map(|_| {
            let x = (0..n).map(|i| at(i) + r.between(-0.7, 0.9)).collect();
            let u = (0..m).map(|i| at(n + i) + r.between(-0.7, 0.9)).collect();
            [x, u, p.clone()]
        })
        .collect();
    let expected = values(&changed, &points);
    Case { system, options, name, points, expected }
}

/// Values and derivatives of the equations as they are written.
fn values(system: &System, points: &[[Vec<f64>; 3]]) -> Vec<Vec<f64>> {
    let mut system = system.clone();
    let arguments = system.arguments();
    let (x, u): (&[Symbol], &[Symbol]) = arguments.split_at(system.states.len());
    let (f, h) = (system.dynamics.clone(), system.outputs.iter().map(|(_, e)| *e).collect::<Vec<Expr>>());
    let mut rows = [f.as_slice(), &h].concat();
    for list in [&f, &h] {
        for by in [x, u] {
            rows.extend(system.pool.jacobian(list, by).concat());
        }
    }
    let tape = system.compile(&arguments, &rows).unwrap();
    let value = |[x, u, _]: &[Vec<f64>; 3]| {
        let mut out = vec![0.0; rows.len()];
        tape.eval(&[x.as_slice(), u].concat(), &mut Vec::new(), &mut out);
        out
    };
    points.iter().map(value).collect()
}

impl Case {
    pub(crate) fn export(&self, target: Target) -> Export {
        let name = Some(self.name.clone());
        export(&self.system, &ExportOptions { target, parameters: self.options.clone(), name }).unwrap()
    }

    /// Functions to be called: f, h, their Jacobians, without h where there are no outputs.
    pub(crate) fn functions(&self) -> Vec<&'static str> {
        let all = ["f", "h", "f_jacobian", "h_jacobian"];
        all.into_iter().filter(|f| !self.system.outputs.is_empty() || !f.starts_with('h')).collect()
    }
}

/// Compares printed numbers, one per line, with what the library computes.
pub(crate) fn compare(cases: &[Case], printed: &str) {
    let got: Vec<f64> = printed.lines().map(|l| l.trim().parse().unwrap_or_else(|_| panic!("{l}"))).collect();
    let expected: Vec<f64> = cases.iter().flat_map(|c| c.expected.iter().flatten().copied()).collect();
    assert_eq!(got.len(), expected.len());
    let (mut at, mut finite) = (0, 0);
    for case in cases {
        for (point, expected) in case.points.iter().zip(&case.expected) {
            for (i, &e) in expected.iter().enumerate() {
                let g = got[at];
                at += 1;
                finite += usize::from(e.is_finite());
                // Languages differ in what is no number: Python's functions fail where others overflow.
                let none = !g.is_finite() && !e.is_finite();
                let close = none || (g - e).abs() <= 1e-12 * e.abs().max(1.0);
                assert!(close, "{} at {point:?}: entry {i} is {g}, not {e}", case.system.name);
            }
        }
    }
    assert!(finite > 10000 && finite * 100 > expected.len() * 99, "{finite} of {}", expected.len());
}

/// A folder of its own for a test.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("export-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a program in a folder to its end; none, with a message, if it is not installed.
pub(crate) fn run(program: &Path, folder: &Path, arguments: &[&str]) -> Option<String> {
    let Ok(out) = Command::new(program).args(arguments).current_dir(folder).output() else {
        eprintln!("skipped: `{}` is not installed", program.display());
        return None;
    };
    assert!(out.status.success(), "{}: {}", program.display(), String::from_utf8_lossy(&out.stderr));
    assert!(out.stderr.is_empty(), "{} warns: {}", program.display(), String::from_utf8_lossy(&out.stderr));
    Some(String::from_utf8(out.stdout).unwrap())
}

/// A Python with the package: that of `BRACKETRY_PYTHON`, else `python3`; none, with a message, if neither has it.
pub(crate) fn python(package: &str) -> Option<PathBuf> {
    let named = std::env::var_os("BRACKETRY_PYTHON").filter(|v| !v.is_empty()).map(PathBuf::from);
    let has = |python: &PathBuf| {
        let tried = Command::new(python).args(["-c", &format!("import {package}")]).output();
        tried.is_ok_and(|o| o.status.success())
    };
    let found = named.into_iter().chain([PathBuf::from("python3")]).find(has);
    if found.is_none() {
        eprintln!("skipped: neither BRACKETRY_PYTHON nor python3 is a Python with {package}");
    }
    found
}
