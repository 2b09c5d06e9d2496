//! Vector fields and their bracket.

use bracketry_symbolic::{Bindings, Expr, Node, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::Error;

/// A vector field: one component per state.
pub type Field = Vec<Expr>;

/// The Lie bracket `[a, b] = Db·a − Da·b`.
///
/// With this sign `[a, b]` is the commutator of `a` and `b` as derivations:
/// `L_[a,b] h = L_a L_b h − L_b L_a h`. All three slices have one entry per state.
///
/// ```
/// use bracketry_symbolic::Pool;
/// let mut p = Pool::new();
/// let states = ["x", "y", "th"].map(|s| p.symbol(s));
/// let drive = ["cos(th)", "sin(th)", "0"].map(|s| p.parse(s).unwrap());
/// let turn = ["0", "0", "1"].map(|s| p.parse(s).unwrap());
/// let sideways = bracketry_lie::bracket(&mut p, &states, &drive, &turn);
/// assert_eq!(sideways.iter().map(|&e| p.text(e)).collect::<Vec<_>>(), ["sin(th)", "-cos(th)", "0"]);
/// ```
pub fn bracket(pool: &mut Pool, states: &[Symbol], a: &[Expr], b: &[Expr]) -> Field {
    let along_a = derivatives_along(pool, states, a, b);
    let along_b = derivatives_along(pool, states, b, a);
    subtract(pool, &along_a, &along_b)
}

/// Up to this many nodes the partial derivatives of a field are formed one by one.
const FEW_NODES: usize = 300;

/// The derivatives of `functions` along `field`.
///
/// The gradients of large expressions would take as many sweeps, and products, as there are
/// states. One sweep with the chain rule at every node takes a few new nodes for each.
fn derivatives_along(pool: &mut Pool, states: &[Symbol], field: &[Expr], functions: &[Expr]) -> Vec<Expr> {
    if functions.iter().all(|&h| pool.number(h).is_some()) {
        return vec![pool.int(0); functions.len()];
    }
    let nodes = pool.reachable(functions);
    if nodes.len() < FEW_NODES {
        let along = states.iter().zip(field).filter(|(_, v)| !pool.is_zero(**v));
        let (states, field): (Vec<Symbol>, Vec<Expr>) = along.map(|(&s, &v)| (s, v)).unzip();
        return functions.iter().map(|&h| pool.lie_derivative(h, &states, &field)).collect();
    }
    let zero = pool.int(0);
    let component: FxHashMap<Symbol, Expr> = states.iter().copied().zip(field.iter().copied()).collect();
    let mut along: FxHashMap<Expr, Expr> = FxHashMap::default();
    for e in nodes {
        let d = match pool.node(e) {
            Node::Num(_) | Node::Pi => zero,
            Node::Sym(s) => component.get(&s).copied().unwrap_or(zero),
            Node::Add(a, b) => pool.add(along[&a], along[&b]),
            Node::Mul(a, b) => {
                let p = pool.mul(along[&a], b);
                let q = pool.mul(a, along[&b]);
                pool.add(p, q)
            }
            node @ (Node::Pow(..) | Node::Call(..) | Node::Call2(..)) => {
                let moving: Vec<Expr> = node.operands().filter(|o| !pool.is_zero(along[o])).collect();
                let mut total = zero;
                for o in moving {
                    let argument = pool.symbol(ARGUMENT);
                    let x = pool.sym(argument);
                    let of_argument = pool.rebuild(e, |other| if other == o { x } else { other });
                    let partial = pool.diff(of_argument, argument);
                    let partial = pool.substitute(partial, &std::iter::once((x, o)).collect());
                    let term = pool.mul(partial, along[&o]);
                    total = pool.add(total, term);
                    if node.operands().all(|other| other == o) {
                        break;
                    }
                }
                total
            }
        };
        along.insert(e, d);
    }
    functions.iter().map(|h| along[h]).collect()
}

/// Stands for an operand while the partial derivative by it is formed. No model can use the name.
const ARGUMENT: &str = "an operand";

/// `ad_f^k g = [f, [f, … [f, g]]]` with `k` brackets.
pub fn adjoint(pool: &mut Pool, states: &[Symbol], f: &[Expr], g: &[Expr], k: usize) -> Field {
    (0..k).fold(g.to_vec(), |y, _| bracket(pool, states, f, &y))
}

/// True if every component is the number 0; a structural test that needs no evaluation.
pub(crate) fn is_plain_zero(pool: &Pool, field: &[Expr]) -> bool {
    field.iter().all(|&e| pool.is_zero(e))
}

pub(crate) fn subtract(pool: &mut Pool, a: &[Expr], b: &[Expr]) -> Field {
    a.iter().zip(b).map(|(&x, &y)| pool.sub(x, y)).collect()
}

/// The control-affine system `x' = f(x) + Σ u_i g_i(x)`.
#[derive(Clone, Debug)]
pub struct VectorFields {
    /// The coordinates.
    pub states: Vec<Symbol>,
    /// f, one entry per state; all zero for a driftless system.
    pub drift: Field,
    /// g_1 … g_m, each with one entry per state.
    pub controls: Vec<Field>,
    /// Exact values of parameters. Symbols that are neither states nor bound are generic.
    pub bindings: Bindings,
}

impl VectorFields {
    /// Checks that there are states and that every field has one component per state.
    ///
    /// # Errors
    /// [`Error::NoStates`] or [`Error::Dimension`].
    pub fn new(
        states: Vec<Symbol>,
        drift: Field,
        controls: Vec<Field>,
        bindings: Bindings,
    ) -> Result<VectorFields, Error> {
        if states.is_empty() {
            return Err(Error::NoStates);
        }
        for field in std::iter::once(&drift).chain(&controls) {
            if field.len() != states.len() {
                return Err(Error::Dimension { expected: states.len(), found: field.len() });
            }
        }
        Ok(VectorFields { states, drift, controls, bindings })
    }

    /// The family of several systems with the same states between which one may switch:
    /// its accessibility algebra is generated by the fields of all of them, and its strong
    /// algebra is the ideal generated by all input fields and all differences of drifts.
    ///
    /// Both are those of the single system with the first drift and, as controls, all
    /// controls and all differences to the first drift.
    ///
    /// # Errors
    /// [`Error::NoStates`] for an empty family, [`Error::Dimension`] if the states differ in number.
    pub fn switched(pool: &mut Pool, family: &[VectorFields]) -> Result<VectorFields, Error> {
        let Some((first, others)) = family.split_first() else { return Err(Error::NoStates) };
        let mut controls = first.controls.clone();
        for member in others {
            for g in &member.controls {
                if !controls.contains(g) {
                    controls.push(g.clone());
                }
            }
        }
        for member in others {
            if member.drift.len() != first.drift.len() {
                return Err(Error::Dimension { expected: first.drift.len(), found: member.drift.len() });
            }
            let difference = subtract(pool, &member.drift, &first.drift);
            if !is_plain_zero(pool, &difference) && !controls.contains(&difference) {
                controls.push(difference);
            }
        }
        VectorFields::new(first.states.clone(), first.drift.clone(), controls, first.bindings.clone())
    }
}
