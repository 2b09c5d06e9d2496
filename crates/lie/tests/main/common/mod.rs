//! Systems for the tests.

use bracketry_lie::analysis::mode_fields;
use bracketry_lie::{Answer, Function, VectorFields};
use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use bracketry_system::{Parameter, Point, Quantities, System};

/// Functions as text.
pub(crate) fn answered(functions: &Answer<Vec<Function>>) -> Answer<Vec<String>> {
    functions.clone().map(|list| shown(&list))
}

/// What the items of a list display.
pub(crate) fn shown(list: &[impl std::fmt::Display]) -> Vec<String> {
    list.iter().map(ToString::to_string).collect()
}

/// A product T of elementary matrices, each of which adds a multiple `c` of column i to column j (counted modulo `n`), and its inverse.
pub(crate) fn elementary(n: usize, mixing: &[(usize, usize, i64)]) -> (Vec<Vec<i64>>, Vec<Vec<i64>>) {
    let mut to: Vec<Vec<i64>> = (0..n).map(|i| (0..n).map(|j| i64::from(i == j)).collect()).collect();
    let mut back = to.clone();
    for &(i, j, c) in mixing {
        let (i, j) = (i % n, j % n);
        if i != j {
            for row in &mut to {
                row[j] += c * row[i];
            }
            for k in 0..n {
                back[i][k] -= c * back[j][k];
            }
        }
    }
    (to, back)
}

/// `x' = rhs` from text; parameters with values; the point by name.
pub(crate) fn system(
    states: &[&str],
    inputs: &[&str],
    parameters: &[(&str, Rational)],
    dynamics: &[&str],
    outputs: &[&str],
    point: Option<&[(&str, &str)]>,
) -> System {
    let mut pool = Pool::new();
    let states: Vec<Symbol> = states.iter().map(|s| pool.symbol(s)).collect();
    let inputs: Vec<Symbol> = inputs.iter().map(|s| pool.symbol(s)).collect();
    let parameters = parameters
        .iter()
        .map(|(name, value)| Parameter {
            symbol: pool.symbol(name),
            value: value.clone(),
            min: None,
            max: None,
            unit: None,
            about: None,
        })
        .collect();
    let dynamics = dynamics.iter().map(|e| pool.parse(e).unwrap()).collect();
    let outputs = outputs.iter().map(|e| ((*e).to_owned(), pool.parse(e).unwrap())).collect();
    let mut at = |s: &Symbol, list: &[(&str, &str)]| {
        let value = list.iter().find(|(n, _)| *n == pool.name(*s)).map_or("0", |p| p.1);
        pool.parse(value).unwrap()
    };
    let point = point.map(|list| Point {
        states: states.iter().map(|s| at(s, list)).collect(),
        inputs: inputs.iter().map(|s| at(s, list)).collect(),
    });
    System {
        name: "test".into(),
        pool,
        states,
        inputs,
        input_ranges: Vec::new(),
        input_delays: Vec::new(),
        static_levels: Vec::new(),
        input_derivatives: Vec::new(),
        parameters,
        definitions: Vec::new(),
        period: None,
        algebraic: Vec::new(),
        eliminated: Vec::new(),
        canceled: Vec::new(),
        dynamics,
        outputs,
        point,
        quantities: Quantities::default(),
    }
}

pub(crate) fn ratio(p: i64, q: i64) -> Rational {
    Rational::from(p) / Rational::from(q)
}

/// The published plate with four integrators, object a uniform ellipse with semi-axes a, b.
pub(crate) fn plate(a: (i64, i64), b: (i64, i64), point: Option<&[(&str, &str)]>) -> System {
    system(
        &["x", "y", "phi", "vx", "vy", "w", "X", "Xd", "theta", "thetad"],
        &["Xdd", "thetadd"],
        &[("mu", ratio(3, 10)), ("g", ratio(981, 100)), ("a", ratio(a.0, a.1)), ("b", ratio(b.0, b.1))],
        &[
            "vx",
            "vy",
            "w",
            "-Xdd - sign(vx)*mu*g",
            "-g*sin(theta) - sign(vy)*mu*(g*cos(theta) + y*thetadd)",
            "-sign(vx)*mu*(sin(phi)^2*a^2/4 + cos(phi)^2*b^2/4)/(a^2/4 + b^2/4)*thetadd",
            "Xd",
            "Xdd",
            "thetad",
            "thetadd",
        ],
        &[],
        point,
    )
}

pub(crate) fn ellipse(point: Option<&[(&str, &str)]>) -> System {
    plate((15, 100), (10, 100), point)
}

pub(crate) fn disk(point: Option<&[(&str, &str)]>) -> System {
    plate((12, 100), (12, 100), point)
}

/// Drift and input fields of a smooth system.
pub(crate) fn fields(system: &mut System) -> VectorFields {
    let mut modes = mode_fields(system).unwrap();
    assert_eq!(modes.len(), 1);
    modes.remove(0).fields
}

pub(crate) fn texts(pool: &Pool, list: &[Expr]) -> Vec<String> {
    list.iter().map(|&e| pool.text(e)).collect()
}
