//! Random exact coordinate changes and feedback.

use bracketry_symbolic::Expr;
use bracketry_system::System;
use rustc_hash::FxHashMap;
use std::fmt::Write as _;

use crate::random::Random;

/// What may hide a system.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hide {
    /// Linear coordinate changes and feedback.
    Linear,
    /// Polynomial and trigonometric ones.
    Nonlinear,
    /// Nonlinear ones of the coordinates alone.
    Coordinates,
    /// Nonlinear ones of the coordinates, and mixtures of the inputs that keep a drift of zero.
    Driftless,
}

/// Hides the system; the origin stays where it is.
pub(crate) fn hide(system: &mut System, how: Hide, random: &mut Random) {
    let linear = how == Hide::Linear;
    for _ in 0..random.between(1, 3) {
        shear(system, linear, random);
    }
    if random.once_in(2) {
        scale(system, random);
    }
    if how != Hide::Coordinates {
        feedback(system, how, random);
    }
    permute(system, random);
}

/// Irrational numbers, of the kinds that models have.
pub(crate) fn irrational(random: &mut Random) -> String {
    let (n, d) = (random.between(2, 60), random.between(2, 9));
    match random.below(8) {
        0 => format!("sqrt({n})"),
        1 => format!("(sqrt({n}) + sqrt({d}))"),
        2 => format!("sqrt({n}/{d})"),
        3 => format!("exp(1/{d})"),
        4 => format!("cos(1/{d})"),
        5 => format!("(2 + sin({n}/{d}))"),
        6 => format!("log({n})"),
        _ => format!("(1 + atan(1/{d}))"),
    }
}

/// Linear coordinate changes with irrational coefficients: x_i becomes c x_i, or x_i + c x_j, or two states are rotated.
pub(crate) fn hide_by_irrational_numbers(system: &mut System, random: &mut Random) {
    for _ in 0..random.between(1, 2) {
        let n = system.states.len();
        let i = random.below(n);
        let j = (i + 1 + random.below((n - 1).max(1))) % n;
        let c = irrational(random);
        // The new states, and the old ones in terms of the new.
        let [x, y] = [i, j].map(|k| system.state_names()[k].clone());
        let angle = format!("{}/{}", random.between(1, 5), random.between(2, 7));
        let [new, old] = match random.below(3) {
            _ if n == 1 => [[format!("{c}*{x}"), y.clone()], [format!("{x}/{c}"), y.clone()]],
            0 => [[format!("{c}*{x}"), y.clone()], [format!("{x}/{c}"), y.clone()]],
            1 => [[format!("{x} + {c}*{y}"), y.clone()], [format!("{x} - {c}*{y}"), y.clone()]],
            _ => [1, -1].map(|sign| {
                let (c, s) = (format!("cos({angle})"), format!("({sign})*sin({angle})"));
                [format!("{c}*{x} + {s}*{y}"), format!("{c}*{y} - {s}*{x}")]
            }),
        };
        let pool = &mut system.pool;
        let mut parsed = |texts: [String; 2]| texts.map(|t| pool.parse(&t).expect("a change that the program writes"));
        let (new, old) = (parsed(new), parsed(old));
        let rates = new.map(|e| pool.lie_derivative(e, &system.states, &system.dynamics));
        system.dynamics[i] = rates[0];
        let mut pairs = vec![(pool.sym(system.states[i]), old[0])];
        if i != j {
            system.dynamics[j] = rates[1];
            pairs.push((pool.sym(system.states[j]), old[1]));
        }
        replace(system, &pairs);
    }
}

/// A function g, its derivative, and points c at which g has irrational values.
type Beside = (&'static str, &'static str, [&'static str; 3]);

const BESIDE: [Beside; 8] = [
    ("sqrt(x)", "1/(2*sqrt(x))", ["2", "3/4", "7"]),
    ("sin(x)", "cos(x)", ["1", "1/3", "-2/5"]),
    ("exp(x)", "exp(x)", ["1", "1/2", "-1/3"]),
    ("log(x)", "1/x", ["2", "5/3", "1/2"]),
    ("atan(x)", "1/(1 + x^2)", ["1/2", "3", "-2/3"]),
    ("sqrt(1 + x^2)", "x/sqrt(1 + x^2)", ["1/2", "-2", "3/5"]),
    ("sqrt(x + 2)", "1/(2*sqrt(x + 2))", ["1/2", "5/7", "1"]),
    ("tanh(x)", "1 - tanh(x)^2", ["1/2", "1", "-2/3"]),
];

/// A state x becomes z with x = g(z) − g(c): the point lies at z = c, where the rates cancel exactly and not in rounding.
pub(crate) fn hide_beside_an_irrational_value(system: &mut System, random: &mut Random) {
    let i = random.below(system.states.len());
    let name = system.state_names()[i].clone();
    let (g, derivative, points) = random.of(&BESIDE);
    let c = random.of(&points);
    let at = |f: &str, x: &str| f.replace("exp", "E").replace('x', &format!("({x})")).replace('E', "exp");
    let pool = &mut system.pool;
    let mut parsed = |text: &str| pool.parse(text).expect("a change that the program writes");
    let old = parsed(&format!("{} - {}", at(g, &name), at(g, c)));
    let (slope, c) = (parsed(&at(derivative, &name)), parsed(c));
    let x = pool.sym(system.states[i]);
    replace(system, &[(x, old)]);
    system.dynamics[i] = system.pool.div(system.dynamics[i], slope);
    if let Some(point) = &mut system.point {
        point.states[i] = c;
    }
}

/// A function of these names that vanishes at the origin.
fn function(names: &[String], linear: bool, random: &mut Random) -> String {
    let c = random.coefficient();
    let a = &names[random.below(names.len())];
    let b = &names[random.below(names.len())];
    if linear {
        return format!("({c}*{a})");
    }
    match random.below(7) {
        0 => format!("({c}*{a})"),
        1 => format!("({c}*{a}*{b})"),
        2 => format!("({c}*{a}^2)"),
        3 => format!("({c}*{a}^3)"),
        4 => format!("({c}*sin({a}))"),
        5 => format!("({c}*(cos({a}) - 1))"),
        _ => format!("({c}*{a}*{b} + {b}^2)"),
    }
}

/// x_i becomes x_i + p of the other states.
fn shear(system: &mut System, linear: bool, random: &mut Random) {
    let names = system.state_names();
    if names.len() < 2 {
        return;
    }
    let i = random.below(names.len());
    let others: Vec<String> = names.iter().enumerate().filter(|n| n.0 != i).map(|n| n.1.clone()).collect();
    let text = function(&others, linear, random);
    let pool = &mut system.pool;
    let p = pool.parse(&text).expect("a function that the program writes");
    let along = pool.lie_derivative(p, &system.states, &system.dynamics);
    system.dynamics[i] = pool.add(system.dynamics[i], along);
    let x = pool.sym(system.states[i]);
    let old = pool.sub(x, p);
    replace(system, &[(x, old)]);
}

fn scale(system: &mut System, random: &mut Random) {
    let i = random.below(system.states.len());
    let (p, q) = (random.coefficient(), random.between(1, 3) as i64);
    let pool = &mut system.pool;
    let (c, inverse) = (pool.ratio(p, q), pool.ratio(q * p.signum(), p.abs()));
    system.dynamics[i] = pool.mul(c, system.dynamics[i]);
    let x = pool.sym(system.states[i]);
    let old = pool.mul(inverse, x);
    replace(system, &[(x, old)]);
}

fn feedback(system: &mut System, how: Hide, random: &mut Random) {
    let (states, inputs) = (system.state_names(), system.input_names());
    for (i, u) in inputs.iter().enumerate() {
        let linear = how == Hide::Linear;
        let gain = if linear || random.once_in(2) {
            format!("{}", random.coefficient())
        } else {
            let x = &states[random.below(states.len())];
            random.of(&["(1 + {}^2)", "(2 + cos({}))", "(1 + {}^2/2)"]).replace("{}", x)
        };
        let mut text = format!("{gain}*{u}");
        if how != Hide::Driftless && random.once_in(2) {
            let _ = write!(text, " + {}", function(&states, linear, random));
        }
        if let Some(later) = inputs.get(i + 1) {
            let c = if linear { random.coefficient().to_string() } else { function(&states, false, random) };
            let _ = write!(text, " + {c}*{later}");
        }
        let new = system.pool.parse(&text).expect("a feedback that the program writes");
        let old = system.pool.var(u);
        replace(system, &[(old, new)]);
    }
}

fn replace(system: &mut System, pairs: &[(Expr, Expr)]) {
    let map: FxHashMap<Expr, Expr> = pairs.iter().copied().collect();
    system.dynamics = system.pool.substitute_all(&system.dynamics, &map);
    for (_, output) in &mut system.outputs {
        *output = system.pool.substitute(*output, &map);
    }
}

fn permute(system: &mut System, random: &mut Random) {
    for i in (1..system.states.len()).rev() {
        let j = random.below(i + 1);
        system.states.swap(i, j);
        system.dynamics.swap(i, j);
    }
}
