//! The necessary condition for flatness by ruled manifolds.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol, UnivariatePolynomial};
use rustc_hash::FxHashMap;

use crate::algebra::field::VectorFields;
use crate::algebra::subsets::subsets;
use crate::linear::matrix::{RationalMatrix, semidefinite};

/// Points at which the condition is looked at.
const POINTS: usize = 6;
/// Larger right-hand sides, written out as trees, are not looked at.
const MAX_TREE: f64 = 1_000.0;
/// Most inputs.
const MAX_INPUTS: usize = 6;
/// Highest derivatives that are looked at for two inputs.
const MAX_ORDER: usize = 5;

/// A system x' = F(x, u) in general form.
#[derive(Clone, Debug)]
pub(crate) struct GeneralSystem {
    pub(crate) states: Vec<Symbol>,
    pub(crate) inputs: Vec<Symbol>,
    pub(crate) dynamics: Vec<Expr>,
}

impl GeneralSystem {
    /// Of x' = f + Σ u_i g_i whose inputs enter the derivatives of as many states alone and independently: the other
    /// states, with these as inputs. The system is this one with an integrator in front of each input, and flat just when
    /// this one is. `None` where the inputs enter otherwise, or nothing is left.
    fn below(pool: &mut Pool, fields: &VectorFields) -> Option<GeneralSystem> {
        let (n, m) = (fields.states.len(), fields.controls.len());
        if pool.rank(&fields.controls, &fields.bindings).ok()?.rank < m {
            return None;
        }
        let driven = |i: &usize| fields.controls.iter().any(|g| !pool.is_zero(g[*i]));
        let (inputs, others): (Vec<usize>, Vec<usize>) = (0..n).partition(driven);
        if inputs.len() != m || others.is_empty() {
            return None;
        }
        Some(GeneralSystem {
            states: others.iter().map(|&i| fields.states[i]).collect(),
            inputs: inputs.iter().map(|&i| fields.states[i]).collect(),
            dynamics: others.iter().map(|&i| fields.drift[i]).collect(),
        })
    }

    /// The same as fields, if it is affine in its inputs.
    fn fields(&self, pool: &mut Pool, of: &VectorFields) -> Option<VectorFields> {
        let jacobian = pool.jacobian(&self.dynamics, &self.inputs);
        let mut controls = vec![Vec::new(); self.inputs.len()];
        for row in jacobian {
            for (g, e) in controls.iter_mut().zip(row) {
                let e = pool.simplify(e);
                if self.inputs.iter().any(|&u| pool.depends_on(e, u)) {
                    return None;
                }
                g.push(e);
            }
        }
        let zero = pool.int(0);
        let rest: FxHashMap<Expr, Expr> = self.inputs.iter().map(|&u| (pool.sym(u), zero)).collect();
        let drift = pool.substitute_all(&self.dynamics, &rest);
        Some(VectorFields { states: self.states.clone(), drift, controls, bindings: of.bindings.clone() })
    }
}

/// Whether the system, the input fields of which are independent, is not flat because the system that is left without the
/// integrators in front of its inputs has no ruled manifold of velocities.
pub(crate) fn velocities_not_ruled(pool: &mut Pool, fields: &VectorFields) -> bool {
    let mut fields = fields.clone();
    while let Some(general) = GeneralSystem::below(pool, &fields) {
        match general.fields(pool, &fields) {
            Some(affine) => fields = affine,
            None => return not_ruled(pool, &general, &fields.bindings),
        }
    }
    false
}

/// Whether {(x, F(x, u))} is seen not to be ruled: at an open set of points (x, p) no line through p, in a direction a ≠ 0,
/// lies in the set of velocities at x. The system is not flat then (Rouchon 1994, Sluis 1993).
///
/// A line p + λ F_u α in the image of F(x, ·) needs second derivatives D²F(α, α) in the image of F_u, as differentiating
/// F(x, u(λ)) = p + λ F_u α twice shows. So it is excluded where these quadratic forms, modulo the image of F_u, have no common
/// real zero α ≠ 0; that is an open condition, tested in exact arithmetic at rational points. With two inputs that enter as many
/// equations affinely and independently, u(λ) is affine too, and the derivatives of higher order along α have to
/// vanish as well. Velocities that are rational at no such point decide nothing.
pub(crate) fn not_ruled(pool: &mut Pool, system: &GeneralSystem, bindings: &Bindings) -> bool {
    let m = system.inputs.len();
    if !(2..=MAX_INPUTS).contains(&m)
        || system.dynamics.len() <= m
        || system.dynamics.iter().any(|&e| pool.tree_size(e) > MAX_TREE)
    {
        return false;
    }
    let mut values: FxHashMap<Expr, Expr> = FxHashMap::default();
    for s in pool.symbols_of(&system.dynamics) {
        if let Some(value) = bindings.get(s).cloned() {
            let x = pool.sym(s);
            values.insert(x, pool.rational(value));
        } else if !system.states.contains(&s) && !system.inputs.contains(&s) {
            return false;
        }
    }
    let dynamics = pool.substitute_all(&system.dynamics, &values);
    let first = pool.jacobian(&dynamics, &system.inputs).concat();
    let second = pool.jacobian(&first, &system.inputs).concat();
    let affine: Vec<bool> = second.chunks(m * m).map(|h| h.iter().all(|&e| pool.is_zero(e))).collect();
    if affine.iter().all(|&a| a) {
        return false;
    }
    let graph = m == 2 && affine.iter().filter(|&&a| a).count() >= 2;
    let mut higher = if graph { second.clone() } else { Vec::new() };
    let mut all = [first, second].concat();
    if graph {
        for _ in 3..=MAX_ORDER {
            higher = pool.jacobian(&higher, &system.inputs).concat();
            all.extend(&higher);
        }
    }
    (0..POINTS).any(|k| {
        let Some(values) = values_at(pool, system, &all, k) else { return false };
        At { inputs: m, affine: &affine, graph, values: &values }.excludes_lines()
    })
}

/// Values of expressions at the k-th of some rational points, of which angles have rational sines and cosines; `None` if one is
/// not rational.
fn values_at(pool: &mut Pool, system: &GeneralSystem, list: &[Expr], k: usize) -> Option<Vec<Rational>> {
    let number = |i: usize| {
        // Both signs, no two values alike.
        let size = 2 + (3 * i + 5 * k) % 11;
        let sign = if k >> (i % 3) & 1 == 1 { -1 } else { 1 };
        Rational::from(sign * size as i64) / Rational::from(1 + (i as i64 + 7 * k as i64) % 5)
    };
    let variables: Vec<Symbol> = system.states.iter().chain(&system.inputs).copied().collect();
    let mut functions: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut inside: Vec<Symbol> = Vec::new();
    for e in pool.reachable(list) {
        let Node::Call(f, a) = pool.node(e) else { continue };
        let Node::Sym(s) = pool.node(a) else { continue };
        let Some(i) = variables.iter().position(|&v| v == s) else { continue };
        let t = number(i);
        let norm = Rational::ONE + &t * &t;
        let (sin, cos) = (Rational::from(2) * &t / &norm, (Rational::ONE - &t * &t) / &norm);
        let value = match f {
            Func::Sin => sin,
            Func::Cos => cos,
            Func::Tan if cos != Rational::ZERO => sin / cos,
            Func::Exp => &t * &t,
            _ => return None,
        };
        // An angle and an exponent in one place have no rational values together.
        let exponential = f == Func::Exp;
        if functions
            .keys()
            .any(|&g| matches!(pool.node(g), Node::Call(h, b) if b == a && (h == Func::Exp) != exponential))
        {
            return None;
        }
        inside.push(s);
        let value = pool.rational(value);
        functions.insert(e, value);
    }
    let list = pool.substitute_all(list, &functions);
    if inside.iter().any(|&s| list.iter().any(|&e| pool.depends_on(e, s))) {
        return None;
    }
    let point: FxHashMap<Expr, Expr> =
        variables.iter().enumerate().map(|(i, &s)| (pool.sym(s), pool.rational(number(i)))).collect();
    let list = pool.substitute_all(&list, &point);
    list.into_iter()
        .map(|e| {
            let e = pool.simplify(e);
            pool.number(e).cloned()
        })
        .collect()
}

/// Derivatives of F at a point.
struct At<'a> {
    inputs: usize,
    /// Per component of F whether it is affine in the inputs.
    affine: &'a [bool],
    /// Whether there are values of higher order: two inputs enter two equations at least affinely.
    graph: bool,
    /// Those of first order, row by row, then those of second order and, where they count, of higher ones.
    values: &'a [Rational],
}

impl At<'_> {
    fn excludes_lines(&self) -> bool {
        let (n, m) = (self.affine.len(), self.inputs);
        let (first, second) = self.values.split_at(n * m);
        let jacobian: Vec<Vec<Rational>> = first.chunks(m).map(<[Rational]>::to_vec).collect();
        let left = RationalMatrix::new(jacobian.clone(), m).transposed().null_space();
        // F_u has full rank just when its left null space has the least dimension.
        if left.len() != n - m {
            return false;
        }
        let hessians: Vec<&[Rational]> = second[..n * m * m].chunks(m * m).collect();
        let forms: Vec<Vec<Vec<Rational>>> = left
            .iter()
            .map(|weights| {
                let mut form = vec![vec![Rational::ZERO; m]; m];
                for (w, h) in weights.iter().zip(&hessians) {
                    for i in 0..m {
                        for j in 0..m {
                            form[i][j] += w * &h[i * m + j];
                        }
                    }
                }
                form
            })
            .collect();
        no_common_zero(&forms, m) || (self.graph && self.excludes_lines_by_higher_orders(&jacobian, &hessians))
    }

    /// For two inputs of which two equations are affine: whether the forms of all orders have no common real zero.
    fn excludes_lines_by_higher_orders(&self, jacobian: &[Vec<Rational>], hessians: &[&[Rational]]) -> bool {
        let n = self.affine.len();
        let mut orders: Vec<Vec<&[Rational]>> = vec![hessians.to_vec()];
        let mut at = n * 2 + n * 4;
        for order in 3..=MAX_ORDER {
            let size = 1 << order;
            orders.push(self.values[at..at + n * size].chunks(size).collect());
            at += n * size;
        }
        let affine: Vec<usize> = (0..n).filter(|&i| self.affine[i]).collect();
        let independent = subsets(affine.len(), 2).any(|p| {
            let (a, b) = (&jacobian[affine[p[0]]], &jacobian[affine[p[1]]]);
            &a[0] * &b[1] != &a[1] * &b[0]
        });
        if !independent {
            return false;
        }
        let forms = orders.iter().flatten().map(|derivatives| {
            // Σ over all index sequences, of which those with as many ones make one coefficient.
            let order = derivatives.len().trailing_zeros() as usize;
            let mut c = vec![Rational::ZERO; order + 1];
            for (index, x) in derivatives.iter().enumerate() {
                c[order - index.count_ones() as usize] += x;
            }
            c
        });
        binary_forms_without_common_zero(forms)
    }
}

/// Whether binary forms Σ c_k t^k s^(d−k), given by their coefficients, have no common real zero but the origin.
fn binary_forms_without_common_zero(forms: impl Iterator<Item = Vec<Rational>>) -> bool {
    let mut common = UnivariatePolynomial::new(Vec::new());
    let mut at_infinity = true;
    for c in forms {
        at_infinity &= c.last().is_none_or(|x| *x == Rational::ZERO);
        let p = UnivariatePolynomial::new(c);
        if p.is_zero() {
            continue;
        }
        common = if common.is_zero() { p } else { common.gcd(&p) };
    }
    !common.is_zero() && !at_infinity && common.roots().is_empty()
}

/// Whether quadratic forms of `dimension` variables are seen to have no common real zero but the origin: a combination of them
/// is semidefinite, and on its kernel the forms have none.
fn no_common_zero(forms: &[Vec<Vec<Rational>>], dimension: usize) -> bool {
    if dimension == 0 {
        return true;
    }
    if dimension == 2 {
        let binary = |q: &Vec<Vec<Rational>>| vec![q[1][1].clone(), &q[0][1] + &q[1][0], q[0][0].clone()];
        return binary_forms_without_common_zero(forms.iter().map(binary));
    }
    let zero = |q: &Vec<Vec<Rational>>| q.iter().flatten().all(|x| *x == Rational::ZERO);
    let forms: Vec<&Vec<Vec<Rational>>> = forms.iter().filter(|q| !zero(q)).collect();
    let mut combinations: Vec<Vec<Vec<Rational>>> = forms.iter().map(|q| (*q).clone()).collect();
    for (i, p) in forms.iter().enumerate() {
        for q in &forms[i + 1..] {
            for c in [-3, -2, -1, 1, 2, 3] {
                combinations.push(sum(p, q, &Rational::from(c)));
            }
        }
    }
    for q in combinations {
        let opposite = sum(&q, &q, &Rational::from(-2));
        if zero(&q) || !(semidefinite(q.clone()) == Some(true) || semidefinite(opposite) == Some(true)) {
            continue;
        }
        let kernel = RationalMatrix::new(q, dimension).null_space();
        let restricted: Vec<Vec<Vec<Rational>>> = forms
            .iter()
            .map(|q| {
                let image: Vec<Vec<Rational>> =
                    kernel.iter().map(|v| RationalMatrix::new((*q).clone(), dimension).times(v)).collect();
                kernel.iter().map(|u| image.iter().map(|w| dot(u, w)).collect()).collect()
            })
            .collect();
        return no_common_zero(&restricted, kernel.len());
    }
    false
}

fn dot(a: &[Rational], b: &[Rational]) -> Rational {
    a.iter().zip(b).fold(Rational::ZERO, |s, (x, y)| s + x * y)
}

fn sum(p: &[Vec<Rational>], q: &[Vec<Rational>], c: &Rational) -> Vec<Vec<Rational>> {
    p.iter().zip(q).map(|(a, b)| a.iter().zip(b).map(|(x, y)| x + c * y).collect()).collect()
}
