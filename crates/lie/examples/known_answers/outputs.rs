//! Classes of systems with known answers about their outputs.

use serde_json::{Map, Value, json};

use crate::classes::block;
use crate::hide::Hide;
use crate::model::Model;
use crate::random::Random;

/// The form of Byrnes and Isidori: a chain behind the output, and zero dynamics with known eigenvalues.
pub(crate) fn zero_dynamics(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let u = model.input();
    let degree = random.between(1, 3);
    let chain = model.chain(degree, &u);
    let size = random.between(0, 3);
    let inner = block(&mut model, size, random);
    let y = model.name(chain[0]);
    for &w in &inner.states {
        let c = random.coefficient();
        let other = model.name(random.of(&inner.states));
        let term = random.of(&["{y}", "{y}*{w}", "{y}^2"]).replace("{y}", &y).replace("{w}", &other);
        model.add(w, &format!("{c}*{term}"));
        let name = model.name(w);
        model.add(chain[degree - 1], &format!("{c}*{name}^2"));
    }
    model.outputs.push(y);
    model.is("relative_degree", json!([degree]));
    model.is("vector_relative_degree", true);
    model.is("zero_dynamics.dimension", size);
    model.is("zero_dynamics.minimum_phase", inner.decays());
    model.is("at_point.relative_degree_defined", true);
    (model, Hide::Nonlinear)
}

/// A chain that begins with the output, and states that the output does not tell.
pub(crate) fn observability(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let u = model.input();
    let seen = random.between(1, 4);
    let chain = model.chain(seen, &u);
    for k in 0..seen {
        let name = model.name(chain[random.below(k + 1)]);
        let term = random.of(&["sin({x})", "{x}^2", "{x}^3", "2*{x}"]).replace("{x}", &name);
        model.add(chain[k], &term);
    }
    let hidden = random.between(0, 2);
    for _ in 0..hidden {
        let w = model.state();
        let (x, name) = (model.name(random.of(&chain)), model.name(w));
        let rate = random.of(&["-{w} + {x}", "{x}*{w}", "{x}^2 - {w}^3", "{x}*(1 + {w})"]);
        model.rate(w, rate.replace("{w}", &name).replace("{x}", &x));
    }
    model.outputs.push(model.name(chain[0]));
    model.is("observability.rank", seen);
    if hidden > 0 {
        model.count("observability.unobservable_directions", hidden);
    } else {
        model.is("observability.unobservable", json!([]));
    }
    (model, Hide::Coordinates)
}

/// A part of a model with parameters, of which it is known which the output tells.
struct Part {
    /// One rate per state; `x`, `z` stand for the states, `u` for the input.
    rates: &'static [&'static str],
    output: &'static str,
    /// Parameters, and whether each is identifiable.
    parameters: &'static [(&'static str, bool)],
    /// Rank for states and parameters together.
    rank: usize,
}

const PARTS: [Part; 9] = [
    Part { rates: &["-a*x + b*u"], output: "x", parameters: &[("a", true), ("b", true)], rank: 3 },
    Part { rates: &["-a*b*x + u"], output: "x", parameters: &[("a", false), ("b", false)], rank: 2 },
    Part { rates: &["-(a + b)*x + u"], output: "x", parameters: &[("a", false), ("b", false)], rank: 2 },
    Part { rates: &["-a*x + b*u"], output: "c*x", parameters: &[("a", true), ("b", false), ("c", false)], rank: 3 },
    Part { rates: &["-a*x/(b + x) + u"], output: "x", parameters: &[("a", true), ("b", true)], rank: 3 },
    Part { rates: &["a*x*(1 - x/b) + u"], output: "x", parameters: &[("a", true), ("b", true)], rank: 3 },
    Part { rates: &["a*x*(1 - x/b)"], output: "c*x", parameters: &[("a", true), ("b", false), ("c", false)], rank: 3 },
    Part {
        rates: &["-(a + b)*x + c*z + u", "b*x - c*z"],
        output: "x",
        parameters: &[("a", true), ("b", true), ("c", true)],
        rank: 5,
    },
    Part {
        rates: &["-(a + b)*x + c*z + u", "b*x - (c + d)*z"],
        output: "x",
        parameters: &[("a", false), ("b", false), ("c", false), ("d", false)],
        rank: 5,
    },
];

/// One or two parts, each with an output of its own.
pub(crate) fn identifiability(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let (mut rank, mut identifiable) = (0, Map::new());
    for k in 1..=random.between(1, 2) {
        let part = &PARTS[random.below(PARTS.len())];
        let u = model.input();
        let states: Vec<usize> = part.rates.iter().map(|_| model.state()).collect();
        let names: Vec<String> = states.iter().map(|&s| model.name(s)).collect();
        let fill = |text: &str| -> String {
            let name = |c: char| match c {
                'x' => names[0].clone(),
                'z' => names[1].clone(),
                'u' => u.clone(),
                'a'..='d' => format!("{c}{k}"),
                other => other.to_string(),
            };
            text.chars().map(name).collect()
        };
        for (&s, rate) in states.iter().zip(part.rates) {
            model.rate(s, fill(rate));
        }
        model.outputs.push(fill(part.output));
        for (i, (name, yes)) in part.parameters.iter().enumerate() {
            model.parameters.push((format!("{name}{k}"), i as i64 + 2));
            identifiable.insert(format!("{name}{k}"), json!(yes));
        }
        rank += part.rank;
    }
    model.is("observability.rank", model.states.len());
    model.is("observability.rank_with_parameters", rank);
    model.is("observability.identifiable", Value::Object(identifiable));
    (model, Hide::Coordinates)
}
