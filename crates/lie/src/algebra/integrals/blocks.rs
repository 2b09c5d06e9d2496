//! Functions of the model from which integrals are composed.

use bracketry_symbolic::{Expr, Func, Node, Pool, Rational, Symbol};

use super::ansatz::{Ansatz, Column};

use crate::algebra::field::Field;

/// Most columns of an ansatz; the work grows with the third power.
const MAX_COLUMNS: usize = 300;
/// The same for each common denominator.
const COLUMNS_OVER_DENOMINATOR: usize = 100;
/// Most nodes of the model that are searched for functions.
const MAX_NODES: usize = 20_000;
/// Most functions of each kind.
const MAX_CALLS: usize = 16;
const MAX_DIVISORS: usize = 8;
/// Ratios and angles are formed of pairs among at most this many states.
const MAX_PAIRED: usize = 6;
/// Largest degree of products.
const MAX_DEGREE: usize = 6;

/// What products and sums are made of.
#[derive(Default)]
pub(super) struct Blocks {
    /// States that are not integrals themselves.
    moving: Vec<Expr>,
    /// States that are.
    fixed: Vec<Expr>,
    /// Functions of the model, such as sin and cos of its angles.
    calls: Vec<Expr>,
    /// Reciprocals of what the model divides by.
    reciprocals: Vec<Expr>,
    /// exp(−λt) for a state t of constant rate, where another one grows like exp(λt).
    growth: Vec<Expr>,
    /// Logarithms, ratios and angles, of which only the derivative is needed.
    functions: Vec<Expr>,
}

impl Blocks {
    /// Looks through `expressions` for functions of `states` alone, `moving` of which are not integrals.
    pub(super) fn of(
        pool: &mut Pool,
        all: &[Symbol],
        states: &[Symbol],
        moving: &[bool],
        expressions: &[Expr],
    ) -> Blocks {
        let mut blocks = Blocks::default();
        for (&s, &m) in states.iter().zip(moving) {
            let x = pool.sym(s);
            if m { blocks.moving.push(x) } else { blocks.fixed.push(x) }
        }
        let mut nodes = pool.reachable(expressions);
        nodes.truncate(MAX_NODES);
        let mut sums: Vec<Expr> = Vec::new();
        for e in nodes {
            let inner = match pool.node(e) {
                Node::Call(_, a) | Node::Pow(a, _) => a,
                Node::Mul(a, b) => {
                    for o in [a, b] {
                        if matches!(pool.node(o), Node::Add(..)) && admissible(pool, o, all, states) {
                            push_new(&mut sums, o, MAX_DIVISORS);
                        }
                    }
                    continue;
                }
                _ => continue,
            };
            if admissible(pool, inner, all, states) {
                blocks.take(pool, e, inner);
            }
        }
        for &e in expressions {
            if matches!(pool.node(e), Node::Add(..)) && admissible(pool, e, all, states) {
                push_new(&mut sums, e, MAX_DIVISORS);
            }
        }
        for b in sums {
            blocks.divisor(pool, b);
        }
        blocks.pairs(pool);
        blocks
    }

    /// Takes in the function `e` of the admissible argument `inner`.
    fn take(&mut self, pool: &mut Pool, e: Expr, inner: Expr) {
        let mut calls: Vec<Expr> = Vec::new();
        match pool.node(e) {
            Node::Call(Func::Sin | Func::Cos | Func::Tan, _) => {
                calls.extend([pool.sin(inner), pool.cos(inner)]);
                if matches!(pool.node(e), Node::Call(Func::Tan, _)) {
                    self.divisor(pool, calls[1]);
                }
            }
            Node::Call(Func::Exp, _) => {
                calls.push(e);
                let minus = pool.neg(inner);
                let r = pool.call(Func::Exp, minus);
                push_new(&mut self.reciprocals, r, MAX_DIVISORS);
                push_new(&mut self.functions, inner, usize::MAX);
            }
            Node::Call(Func::Sinh | Func::Cosh, _) => {
                calls.extend([pool.call(Func::Sinh, inner), pool.call(Func::Cosh, inner)]);
            }
            Node::Call(Func::Tanh, _) => {
                calls.push(e);
                let c = pool.call(Func::Cosh, inner);
                let l = pool.call(Func::Log, c);
                push_new(&mut self.functions, l, usize::MAX);
            }
            Node::Call(Func::Sign | Func::Abs, _) => {}
            Node::Call(..) => calls.push(e),
            Node::Pow(b, k) => match pool.number(k).cloned() {
                Some(k) if k.is_int() && k < Rational::ZERO => self.divisor(pool, b),
                Some(k) if k.is_int() => {}
                Some(k) => {
                    calls.push(e);
                    if k < Rational::ZERO {
                        let next = pool.rational(k + Rational::ONE);
                        calls.push(pool.pow(b, next));
                    }
                    self.divisor(pool, b);
                }
                None => calls.push(e),
            },
            _ => {}
        }
        for c in calls {
            push_new(&mut self.calls, c, MAX_CALLS);
        }
    }

    /// Takes in a factor or divisor of the model.
    fn divisor(&mut self, pool: &mut Pool, b: Expr) {
        let r = pool.powi(b, -1);
        push_new(&mut self.reciprocals, r, MAX_DIVISORS);
        let l = pool.call(Func::Log, b);
        push_new(&mut self.functions, l, usize::MAX);
        // ∫ ds/(1 + s²)
        for x in self.moving.clone() {
            let one = pool.int(1);
            let square = pool.powi(x, 2);
            let sum = pool.add(one, square);
            if sum == b {
                let a = pool.call(Func::Atan, x);
                push_new(&mut self.functions, a, usize::MAX);
            }
        }
    }

    /// Logarithms of the moving states, their reciprocals and ratios, and polar coordinates of pairs.
    fn pairs(&mut self, pool: &mut Pool) {
        let states: Vec<Expr> = self.moving.iter().copied().take(MAX_PAIRED).collect();
        let mut polar = Vec::new();
        for (i, &x) in states.iter().enumerate() {
            for &y in &states[i + 1..] {
                let ratio = pool.div(x, y);
                let inverse = pool.div(y, x);
                push_new(&mut self.functions, ratio, usize::MAX);
                push_new(&mut self.functions, inverse, usize::MAX);
                polar.push(pool.call(Func::Atan, inverse));
                let (a, b) = (pool.powi(x, 2), pool.powi(y, 2));
                let square = pool.add(a, b);
                polar.push(pool.call(Func::Log, square));
            }
        }
        for &x in &states {
            let l = pool.call(Func::Log, x);
            push_new(&mut self.functions, l, usize::MAX);
            let r = pool.powi(x, -1);
            push_new(&mut self.functions, r, usize::MAX);
        }
        for f in polar {
            push_new(&mut self.functions, f, usize::MAX);
        }
    }

    /// Looks for states of constant rate, and for states whose rate is a constant multiple of them plus the rest.
    pub(super) fn exponentials(&mut self, pool: &mut Pool, all: &[Symbol], states: &[Symbol], fields: &[Field]) {
        for y in fields {
            let constant =
                |pool: &Pool, e: Expr| !pool.is_zero(e) && !pool.symbols_of(&[e]).iter().any(|s| all.contains(s));
            let rates: Vec<Expr> = states.iter().zip(y).map(|(&s, &e)| pool.diff(e, s)).collect();
            for (&clock, &speed) in states.iter().zip(y) {
                if !constant(pool, speed) {
                    continue;
                }
                for &rate in &rates {
                    if constant(pool, rate) {
                        let t = pool.sym(clock);
                        let k = pool.div(rate, speed);
                        let k = pool.neg(k);
                        let exponent = pool.mul(k, t);
                        let e = pool.call(Func::Exp, exponent);
                        push_new(&mut self.growth, e, MAX_DIVISORS);
                    }
                }
            }
        }
    }

    /// Products of up to two states and functions of the model, and functions on their own.
    pub(super) fn quadratic(&self, pool: &Pool) -> Ansatz {
        let atoms = [&self.moving[..], &self.calls, &self.fixed].concat();
        self.products(pool, atoms, 2, MAX_COLUMNS, &self.functions)
    }

    /// Products of as many as fit, reciprocals among them.
    pub(super) fn products_of_many(&self, pool: &Pool) -> Ansatz {
        let atoms = [&self.moving[..], &self.calls, &self.reciprocals, &self.fixed].concat();
        self.products(pool, atoms, MAX_DEGREE, MAX_COLUMNS, &self.functions)
    }

    /// Polynomials in the moving states alone, of as high a degree as fits.
    pub(super) fn polynomial(&self, pool: &Pool) -> Ansatz {
        self.products(pool, self.moving.clone(), MAX_DEGREE, MAX_COLUMNS, &[])
    }

    /// Polynomials in the functions of the model and the states that are not arguments of them.
    pub(super) fn trigonometric(&self, pool: &Pool) -> Ansatz {
        let arguments = pool.symbols_of(&self.calls);
        let outside = |&&x: &&Expr| matches!(pool.node(x), Node::Sym(s) if !arguments.contains(&s));
        let mut atoms: Vec<Expr> = self.moving.iter().filter(outside).copied().collect();
        if self.calls.is_empty() || atoms.len() == self.moving.len() {
            return Ansatz::default();
        }
        atoms.extend(&self.calls);
        self.products(pool, atoms, MAX_DEGREE, MAX_COLUMNS, &[])
    }

    /// Products of as many as fit over one common denominator, for each.
    pub(super) fn over_denominators(&self, pool: &mut Pool) -> Vec<Ansatz> {
        let mut denominators = self.growth.clone();
        denominators.extend(&self.reciprocals);
        for &x in &self.moving {
            let r = pool.powi(x, -1);
            push_new(&mut denominators, r, usize::MAX);
            denominators.push(pool.powi(x, -2));
        }
        denominators.truncate(2 * MAX_DIVISORS);
        denominators
            .into_iter()
            .map(|m| {
                let atoms = [&self.moving[..], &self.calls, &self.fixed].concat();
                let mut ansatz = self.products(pool, atoms, MAX_DEGREE, COLUMNS_OVER_DENOMINATOR, &[]);
                let index = ansatz.atoms.len();
                ansatz.atoms.push(m);
                for column in &mut ansatz.columns {
                    if let Column::Product(p) = column {
                        p.push(index);
                    }
                }
                ansatz.columns.insert(0, Column::Product(vec![index]));
                ansatz
            })
            .collect()
    }

    /// All products of `atoms` up to a degree, as many as fit, then `functions`.
    fn products(&self, pool: &Pool, atoms: Vec<Expr>, degree: usize, most: usize, functions: &[Expr]) -> Ansatz {
        let constant: Vec<bool> = atoms.iter().map(|&a| self.is_fixed(pool, a)).collect();
        let exclusive = |p: &[usize], k: usize| p.iter().any(|&j| related(pool, &atoms, j, k));
        // A product of fixed atoms alone is worth keeping only as a factor of one that moves.
        let last_moving = constant.iter().rposition(|fixed| !fixed);
        let mut columns: Vec<Vec<usize>> = Vec::new();
        let mut last: Vec<Vec<usize>> = vec![Vec::new()];
        let room = most.saturating_sub(functions.len());
        'fill: for _ in 0..degree {
            let mut next = Vec::new();
            for p in &last {
                for k in p.last().copied().unwrap_or(0)..atoms.len() {
                    if exclusive(p, k) {
                        continue;
                    }
                    let fixed = constant[k] && p.iter().all(|&i| constant[i]);
                    if fixed && Some(k) > last_moving {
                        break;
                    }
                    let mut q = p.clone();
                    q.push(k);
                    if !fixed {
                        if columns.len() == room {
                            break 'fill;
                        }
                        columns.push(q.clone());
                    }
                    next.push(q);
                }
            }
            last = next;
        }
        let mut columns: Vec<Column> = columns.into_iter().map(Column::Product).collect();
        columns.extend((0..functions.len().min(most)).map(Column::Function));
        Ansatz { atoms, functions: functions.to_vec(), columns }
    }

    /// Whether `e` depends on no moving state.
    fn is_fixed(&self, pool: &Pool, e: Expr) -> bool {
        let symbols = pool.symbols_of(&[e]);
        !self.moving.iter().any(|&x| matches!(pool.node(x), Node::Sym(s) if symbols.contains(&s)))
    }
}

/// The states.
pub(super) fn linear(pool: &Pool, states: &[Expr]) -> Ansatz {
    let columns = (0..states.len()).map(|i| Column::Product(vec![i])).collect();
    debug_assert!(states.iter().all(|&s| matches!(pool.node(s), Node::Sym(_))));
    Ansatz { atoms: states.to_vec(), functions: Vec::new(), columns }
}

/// Whether the product of two atoms is a combination of others: cos² beside sin², b·(1/b), exp(a)·exp(−a).
fn related(pool: &Pool, atoms: &[Expr], j: usize, k: usize) -> bool {
    let (a, b) = (atoms[j], atoms[k]);
    match (pool.node(a), pool.node(b)) {
        (Node::Call(Func::Cos, u), Node::Call(Func::Cos, v))
        | (Node::Call(Func::Cosh, u), Node::Call(Func::Cosh, v)) => u == v,
        (Node::Pow(u, _), _) if u == b => true,
        (_, Node::Pow(v, _)) if v == a => true,
        (Node::Call(Func::Exp, u), Node::Call(Func::Exp, v)) => u != v && opposite(pool, u, v),
        _ => false,
    }
}

fn opposite(pool: &Pool, u: Expr, v: Expr) -> bool {
    let negated = |x: Expr, y: Expr| matches!(pool.node(x), Node::Mul(c, r) if r == y && pool.integer(c) == Some(-1));
    negated(u, v) || negated(v, u)
}

/// Whether `e` depends on states, and on none but the admitted ones.
fn admissible(pool: &Pool, e: Expr, all: &[Symbol], admitted: &[Symbol]) -> bool {
    let symbols = pool.symbols_of(&[e]);
    symbols.iter().any(|s| admitted.contains(s)) && symbols.iter().all(|s| !all.contains(s) || admitted.contains(s))
}

fn push_new(list: &mut Vec<Expr>, e: Expr, most: usize) {
    if list.len() < most && !list.contains(&e) {
        list.push(e);
    }
}
