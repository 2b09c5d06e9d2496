//! Which modes, and which crossings from one mode to another, are seen to occur.

use bracketry_symbolic::{Bindings, Expr, Pool, Rational, SplitMix64, Symbol, Tape};
use rustc_hash::FxHashMap;

use crate::modes::ModeFields;

/// Two modes that differ in the sign of one switching function.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    /// Number of the switching function.
    pub(crate) switch: usize,
    /// The modes in which it is positive and negative.
    pub(crate) modes: [usize; 2],
    /// A point of the surface at which all other switching functions have the signs of both modes.
    pub(crate) seen_at: Option<Vec<f64>>,
}

/// What is known of the modes of a system.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occurrence {
    /// Modes with a point in them.
    pub(crate) seen: Vec<bool>,
    /// Modes whose signs contradict each other.
    pub(crate) impossible: Vec<bool>,
    /// All pairs of modes that differ in one sign, without those of impossible modes.
    pub(crate) edges: Vec<Edge>,
}

/// Points that are drawn, and halvings of a segment between two of them.
const POINTS: usize = 96;
const HALVINGS: usize = 60;
/// Sizes of the boxes that points are drawn from.
const SIZES: [f64; 4] = [1.0, 10.0, 0.1, 1000.0];
/// Values nearer to zero, relative to the size of the box, have no sign.
const CLEAR: f64 = 1e-9;

impl Occurrence {
    /// Modes are seen at points drawn at random, crossings where a segment between two of these meets a surface.
    pub(crate) fn of(pool: &mut Pool, modes: &[ModeFields], bindings: &Bindings) -> Occurrence {
        let signs: Vec<Vec<i8>> = modes.iter().map(ModeFields::sign_list).collect();
        let impossible: Vec<bool> = modes.iter().map(|m| contradicts(pool, m, bindings)).collect();
        let mut edges = Vec::new();
        for (a, plus) in signs.iter().enumerate() {
            for i in (0..plus.len()).filter(|&i| plus[i] > 0) {
                let mut minus = plus.clone();
                minus[i] = -1;
                if let Some(b) = signs.iter().position(|s| *s == minus).filter(|&b| !impossible[a] && !impossible[b]) {
                    edges.push(Edge { switch: i, modes: [a, b], seen_at: None });
                }
            }
        }
        let mut found = Occurrence { seen: vec![false; modes.len()], impossible, edges };
        let mut groups: Vec<(Vec<Expr>, Vec<usize>)> = Vec::new();
        for (k, m) in modes.iter().enumerate() {
            match groups.iter_mut().find(|g| g.0 == m.surfaces) {
                Some(group) => group.1.push(k),
                None => groups.push((m.surfaces.clone(), vec![k])),
            }
        }
        let count = (4 * POINTS / groups.len()).clamp(12, POINTS);
        for (surfaces, members) in groups {
            let states = &modes[members[0]].fields.states;
            let Some(tape) = compiled(pool, states, &surfaces, bindings) else { continue };
            found.look(&tape, states.len(), &signs, &members, count);
        }
        found
    }

    /// Draws points for the modes `members`, whose switching functions are those of `tape`.
    fn look(&mut self, tape: &Tape, n: usize, signs: &[Vec<i8>], members: &[usize], count: usize) {
        let mut work = Vec::new();
        let mut values = |x: &[f64]| {
            let mut out = vec![0.0; tape.n_outputs()];
            tape.eval(x, &mut work, &mut out);
            out
        };
        let mut random = SplitMix64::new(0x6272_6163_6b65_7411);
        let mut last: Option<(Vec<f64>, Vec<f64>)> = None;
        for k in 0..count {
            let size = SIZES[k / 2 % SIZES.len()];
            let x: Vec<f64> = (0..n).map(|_| size * random.symmetric()).collect();
            let at = values(&x);
            let clear = CLEAR * size;
            for &m in members {
                self.seen[m] |= at.iter().zip(&signs[m]).all(|(v, &s)| v * f64::from(s) > clear);
            }
            if let Some((y, there)) = &last {
                for i in (0..at.len()).filter(|&i| at[i] * there[i] < 0.0) {
                    let z = root(&mut values, i, [&x, y], at[i]);
                    let around = values(&z);
                    for edge in self.edges.iter_mut().filter(|e| e.switch == i && members.contains(&e.modes[0])) {
                        let plus = &signs[edge.modes[0]];
                        let other = |(j, v): (usize, &f64)| j == i || v * f64::from(plus[j]) > clear;
                        if edge.seen_at.is_none() && around.iter().enumerate().all(other) {
                            edge.seen_at = Some(z.clone());
                        }
                    }
                }
            }
            last = Some((x, at));
        }
    }
}

/// A zero of the i-th value on the segment between points where it has opposite signs, `first` at the first.
fn root(values: &mut impl FnMut(&[f64]) -> Vec<f64>, i: usize, ends: [&Vec<f64>; 2], first: f64) -> Vec<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    let at = |c: f64| -> Vec<f64> { ends[0].iter().zip(ends[1]).map(|(a, b)| a + c * (b - a)).collect() };
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if values(&at(middle))[i] * first > 0.0 { low = middle } else { high = middle }
    }
    at(0.5 * (low + high))
}

/// Functions of the states with the parameters put in; none if one has no number.
pub(crate) fn compiled(pool: &mut Pool, states: &[Symbol], roots: &[Expr], bindings: &Bindings) -> Option<Tape> {
    let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
    for s in pool.symbols_of(roots) {
        if let Some(v) = bindings.get(s).cloned() {
            let (s, v) = (pool.sym(s), pool.rational(v));
            at.insert(s, v);
        }
    }
    let roots = pool.substitute_all(roots, &at);
    Tape::compile(pool, states, &roots).ok()
}

/// Whether two switching functions of the mode whose sum or difference is a number cannot both have their signs.
fn contradicts(pool: &mut Pool, mode: &ModeFields, bindings: &Bindings) -> bool {
    let signs = mode.sign_list();
    let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
    for s in pool.symbols_of(&mode.surfaces) {
        if let Some(v) = bindings.get(s).cloned() {
            let (s, v) = (pool.sym(s), pool.rational(v));
            at.insert(s, v);
        }
    }
    for i in 0..signs.len() {
        for j in 0..i {
            // σ_i s_i + σ_j s_j must be positive; it is ±(s_i ± s_j).
            let (a, b) = (mode.surfaces[i], mode.surfaces[j]);
            let same = signs[i] == signs[j];
            let both = if same { pool.add(a, b) } else { pool.sub(a, b) };
            let both = pool.substitute(both, &at);
            let both = pool.expand(both);
            if let Some(c) = pool.number(both)
                && c * Rational::from(signs[i]) <= Rational::ZERO
            {
                return true;
            }
        }
    }
    false
}
