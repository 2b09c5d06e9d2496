//! Classes of systems with known answers about what the inputs reach and what feedback can do.

use serde_json::json;

use crate::hide::Hide;
use crate::model::Model;
use crate::random::Random;
use crate::{equations, local, outputs};

/// Draws a system of a class, and how it may be hidden.
pub(crate) type Class = fn(&mut Random) -> (Model, Hide);

/// All classes by name.
pub(crate) const CLASSES: [(&str, Class); 14] = [
    ("linear", linear),
    ("brunovsky", brunovsky),
    ("autonomous", autonomous),
    ("driftless", driftless),
    ("not-linearizable", not_linearizable),
    ("zero-dynamics", outputs::zero_dynamics),
    ("observability", outputs::observability),
    ("identifiability", outputs::identifiability),
    ("quadratic", local::quadratic),
    ("stlc", local::stlc),
    ("ranges", local::ranges),
    ("kinks", local::kinks),
    ("equilibria", equations::equilibria),
    ("denominators", equations::denominators),
];

/// States w' = A w that no input reaches.
#[derive(Default)]
pub(crate) struct Block {
    pub(crate) states: Vec<usize>,
    /// Real and imaginary parts, each as often as it occurs.
    pub(crate) eigenvalues: Vec<(f64, f64)>,
    /// Whether A is not zero.
    moves: bool,
}

impl Block {
    pub(crate) fn decays(&self) -> bool {
        self.eigenvalues.iter().all(|e| e.0 < 0.0)
    }
}

/// New states w' = A w with known eigenvalues, some of them in Jordan blocks.
pub(crate) fn block(model: &mut Model, size: usize, random: &mut Random) -> Block {
    let Block { mut states, mut eigenvalues, mut moves } = Block::default();
    while states.len() < size {
        let w = model.state();
        let x = model.name(w);
        let kind = if size - states.len() >= 2 { random.below(6) } else { 5 };
        if kind < 2 {
            let z = model.state();
            let y = model.name(z);
            let (re, im) = (random.of(&[-2, -1, -1, 0, 1]), random.between(1, 3));
            model.rate(w, format!("{re}*{x} + {im}*{y}"));
            model.rate(z, format!("-{im}*{x} + {re}*{y}"));
            eigenvalues.extend([(f64::from(re), im as f64), (f64::from(re), -(im as f64))]);
            states.extend([w, z]);
            moves = true;
            continue;
        }
        let (p, q) = (random.of(&[-5, -3, -2, -1, -1, 0, 1, 2]), random.between(1, 3));
        model.rate(w, format!("({p}/{q})*{x}"));
        eigenvalues.push((f64::from(p) / q as f64, 0.0));
        states.push(w);
        moves |= p != 0;
        if kind == 2 {
            let z = model.state();
            let y = model.name(z);
            model.add(w, &y);
            model.rate(z, format!("({p}/{q})*{y}"));
            eigenvalues.push((f64::from(p) / q as f64, 0.0));
            states.push(z);
            moves = true;
        }
    }
    Block { states, eigenvalues, moves }
}

/// What holds of a controllable part with `reached` states and a linear part that no input influences.
fn linear_truth(model: &mut Model, reached: usize, block: &Block) {
    let k = block.states.len();
    let accessible = reached + usize::from(block.moves);
    model.is("modes.0.accessible_dimension", accessible);
    model.is("modes.0.strongly_accessible_dimension", reached);
    model.count("modes.0.autonomous", k);
    model.is("at_point.equilibrium", true);
    model.is("at_point.accessible_dimension", reached);
    model.is("at_point.strongly_accessible_dimension", reached);
    model.is("at_point.linear_controllability_rank", reached);
    model.spectrum("at_point.uncontrollable_modes", &block.eigenvalues);
    model.is("at_point.stabilizable", block.decays());
    model.is("at_point.brockett_condition", block.eigenvalues.iter().all(|e| *e != (0.0, 0.0)));
    model.is("at_point.stlc.verdict", if k == 0 { "yes" } else { "no" });
    model.is("static_feedback_linearizable", k == 0);
    model.is("flatness.verdict", if k == 0 { "yes" } else { "no" });
}

/// Chains of integrators with lengths in falling order, with their inputs.
fn chains(model: &mut Model, most: usize, random: &mut Random) -> (Vec<Vec<usize>>, Vec<usize>) {
    let mut lengths: Vec<usize> = (0..random.between(1, 2)).map(|_| random.between(1, most)).collect();
    lengths.sort_by(|a, b| b.cmp(a));
    let list = lengths.iter().map(|&length| {
        let u = model.input();
        model.chain(length, &u)
    });
    (list.collect(), lengths.clone())
}

/// Chains of integrators that uncontrollable modes act on, behind linear coordinates or nonlinear ones.
fn linear(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let (chains, lengths) = chains(&mut model, 3, random);
    let size = random.between(0, 3);
    let modes = block(&mut model, size, random);
    for &w in &modes.states {
        let (chain, c) = (random.below(chains.len()), random.coefficient());
        let term = format!("{c}*{}", model.name(w));
        let state = random.of(&chains[chain]);
        model.add(state, &term);
    }
    linear_truth(&mut model, lengths.iter().sum(), &modes);
    (model, random.of(&[Hide::Linear, Hide::Nonlinear]))
}

/// Chains of integrators in nonlinear coordinates with nonlinear feedback.
fn brunovsky(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let (_, lengths) = chains(&mut model, 4, random);
    linear_truth(&mut model, lengths.iter().sum(), &Block::default());
    model.is("feedback_linearization.controllability_indices", json!(lengths));
    (model, Hide::Nonlinear)
}

/// A controllable triangular part driven by a nonlinear part that no input influences.
fn autonomous(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let u = model.input();
    let reached = random.between(1, 3);
    let chain = model.chain(reached, &u);
    let (w, z) = (model.state(), model.state());
    let (a, b) = (model.name(w), model.name(z));
    let (first, second) = random.of(&[
        ("{b}", "-sin({a})"),
        ("{b} - {a}^3", "-{a} - {b}"),
        ("-{a} + {b}^2", "-2*{b}"),
        ("{a}*{b}", "-{b}"),
    ]);
    let fill = |text: &str| text.replace("{a}", &a).replace("{b}", &b);
    model.rate(w, fill(first));
    model.rate(z, fill(second));
    for (i, &x) in chain.iter().enumerate() {
        let known = model.name(chain[random.below(i + 1)]);
        let by = random.of(&[&a, &b]).clone();
        let c = random.coefficient();
        model.add(x, &format!("{c}*{known}*{by}"));
    }
    model.is("modes.0.accessible_dimension", reached + 1);
    model.is("modes.0.strongly_accessible_dimension", reached);
    model.count("modes.0.autonomous", 2);
    model.is("at_point.strongly_accessible_dimension", reached);
    model.is("at_point.accessible_dimension", reached);
    model.is("at_point.linear_controllability_rank", reached);
    model.is("at_point.stlc.verdict", "no");
    model.is("static_feedback_linearizable", false);
    model.is("flatness.verdict", "no");
    (model, Hide::Nonlinear)
}

/// The chained form with two inputs, with constants of the motion.
fn driftless(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let (u, v) = (model.input(), model.input());
    let n = random.between(3, 5);
    let states: Vec<usize> = (0..n).map(|_| model.state()).collect();
    model.rate(states[0], u.clone());
    model.rate(states[1], v);
    for k in 2..n {
        let before = model.name(states[k - 1]);
        model.rate(states[k], format!("{before}*{u}"));
    }
    let constants = random.of(&[0, 0, 1]);
    for _ in 0..constants {
        model.state();
    }
    let all = constants == 0;
    model.is("modes.0.accessible_dimension", n);
    model.is("modes.0.strongly_accessible_dimension", n);
    model.count("modes.0.autonomous", constants);
    model.is("involutive", false);
    model.is("static_feedback_linearizable", false);
    model.is("flatness.verdict", if all { "yes" } else { "no" });
    model.is("at_point.stlc.verdict", if all { "yes" } else { "no" });
    model.is("at_point.stabilizable", all);
    model.is("at_point.brockett_condition", false);
    model.is("at_point.strongly_accessible_dimension", n);
    (model, random.of(&[Hide::Driftless, Hide::Nonlinear]))
}

/// One input with a linearization that is controllable, and a square that spoils the second distribution.
fn not_linearizable(random: &mut Random) -> (Model, Hide) {
    let mut model = Model::default();
    let u = model.input();
    let n = random.between(3, 5);
    let chain = model.chain(n, &u);
    let (c, last) = (random.coefficient(), model.name(chain[n - 1]));
    let at = random.below(n - 2);
    model.add(chain[at], &format!("{c}*{last}^2"));
    model.is("modes.0.accessible_dimension", n);
    model.is("modes.0.strongly_accessible_dimension", n);
    model.count("modes.0.autonomous", 0);
    model.is("static_feedback_linearizable", false);
    model.is("flatness.verdict", "no");
    model.is("at_point.linear_controllability_rank", n);
    model.is("at_point.stabilizable", true);
    model.is("at_point.brockett_condition", true);
    model.is("at_point.stlc.verdict", "yes");
    (model, Hide::Nonlinear)
}
