//! First integrals of a distribution: functions that are constant along all its fields.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol, ZeroTest};
use rustc_hash::FxHashMap;

use super::ansatz::{Ansatz, Column};
use super::blocks::{Blocks, linear};
use super::fraction::{Polynomial, Values, common, expression, fractions, scramble};

use crate::algebra::field::{Field, is_plain_zero};
use crate::algebra::involutive::involutive_closure;
use crate::algebra::span::independent;
use crate::evidence::Evidence;
use crate::residues::unit_row;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// Independent functions φ with L_X φ = 0 for all fields X of a distribution.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Integrals {
    /// The functions that were found; their differentials are independent at a generic point.
    pub functions: Vec<Expr>,
    /// How many more exist near a generic point.
    pub missing: usize,
}

/// Most candidates of one ansatz that are looked at.
const MAX_CANDIDATES: usize = 60;

/// First integrals of the distribution spanned by `distribution` (fields with one component per
/// state) at a generic point.
///
/// By Frobenius' theorem there are exactly n − d of them, where d is the dimension of the
/// involutive closure. They are sought among the states, their linear combinations, and sums of
/// products of states and of functions that occur in the fields or in `known` (sines, powers,
/// logarithms, ratios, reciprocals of denominators). Coefficients are rational functions of the
/// parameters where that can be, else numbers. Every function returned was verified exactly;
/// `missing` says how many were not found.
///
/// ```
/// use bracketry_lie::Evidence;
/// use bracketry_lie::algebra::integrals;
/// use bracketry_symbolic::{Bindings, Pool};
/// let mut p = Pool::new();
/// let states = ["x", "y", "th", "w"].map(|s| p.symbol(s));
/// // The roll input of a planar VTOL aircraft keeps Huygens' center of oscillation where it is.
/// let roll = ["ep*cos(th)", "ep*sin(th)", "1", "0"].map(|s| p.parse(s).unwrap()).to_vec();
/// let found = integrals(&mut p, &states, &[roll], &[], &Bindings::new(), &mut Evidence::default()).unwrap();
/// let text: Vec<String> = found.functions.iter().map(|&e| p.text(e)).collect();
/// assert_eq!(text, ["w", "x - ep*sin(th)", "ep*cos(th) + y"]);
/// assert_eq!(found.missing, 0);
/// ```
///
/// # Errors
/// [`Undecided`] if a function in the fields cannot be evaluated exactly.
pub fn integrals(
    pool: &mut Pool,
    states: &[Symbol],
    distribution: &[Field],
    known: &[Expr],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Integrals, Undecided> {
    let closure = involutive_closure(pool, states, distribution, bindings, evidence)?;
    integrals_of_involutive(pool, states, &closure.basis, known, bindings, evidence)
}

/// Among which functions integrals are sought.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Among {
    /// Linear combinations of the states.
    States,
    /// All that [`integrals`] looks at.
    All,
}

/// [`integrals`] of independent fields that span an involutive distribution.
pub(crate) fn integrals_of_involutive(
    pool: &mut Pool,
    states: &[Symbol],
    basis: &[Field],
    known: &[Expr],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Integrals, Undecided> {
    integrals_among(pool, states, basis, known, bindings, Among::All, evidence)
}

/// [`integrals_of_involutive`] among some functions only.
pub(crate) fn integrals_among(
    pool: &mut Pool,
    states: &[Symbol],
    basis: &[Field],
    known: &[Expr],
    bindings: &Bindings,
    among: Among,
    evidence: &mut Evidence,
) -> Result<Integrals, Undecided> {
    let wanted = states.len().saturating_sub(basis.len());
    if wanted == 0 {
        return Ok(Integrals { functions: Vec::new(), missing: 0 });
    }
    if basis.is_empty() {
        let functions = states.iter().map(|&s| pool.sym(s)).collect();
        return Ok(Integrals { functions, missing: 0 });
    }
    let mut search = Search::new(pool, states, basis, known, bindings, wanted, evidence)?;
    search.run(pool, among, evidence)?;
    let names = search.constants_named;
    let functions: Vec<Expr> = pool.substitute_all(&search.found, &names);
    let missing = wanted - functions.len();
    Ok(Integrals { functions, missing })
}

struct Search {
    all: Vec<Symbol>,
    /// States on which an integral may depend: those along which no unit field lies in the distribution.
    states: Vec<Symbol>,
    /// Components of the fields along these.
    fields: Vec<Field>,
    known: Vec<Expr>,
    /// What is neither a state nor a number.
    parameters: Vec<Symbol>,
    /// Generic values of the parameters.
    base: Vec<u64>,
    /// Values of parameters that the caller gave.
    bindings: Bindings,
    /// Symbols put in place of constants such as sin(alpha), with what they stand for.
    constants_named: FxHashMap<Expr, Expr>,
    found: Vec<Expr>,
    differentials: Vec<Field>,
    wanted: usize,
}

impl Search {
    fn new(
        pool: &mut Pool,
        all: &[Symbol],
        basis: &[Field],
        known: &[Expr],
        bindings: &Bindings,
        wanted: usize,
        evidence: &mut Evidence,
    ) -> Result<Search, Undecided> {
        let flat = basis.concat();
        let mut roots = flat.clone();
        roots.extend(known);
        let named = name_constants(pool, &roots, all);
        let back: FxHashMap<Expr, Expr> = named.iter().map(|(&e, &s)| (s, e)).collect();
        let roots = pool.substitute_all(&roots, &named);
        let n = all.len();
        let fields: Vec<Field> = roots[..flat.len()].chunks(n).map(<[Expr]>::to_vec).collect();
        let known = roots[flat.len()..].to_vec();
        let parameters: Vec<Symbol> =
            pool.symbols_of(&roots[..flat.len()]).into_iter().filter(|s| !all.contains(s)).collect();
        let base = parameter_values(parameters.len());
        let flat: Vec<Expr> = roots[..flat.len()].to_vec();
        let samples = pool.sample_in::<OFFSET>(&flat, bindings, 1, scramble(2, 2))?;
        evidence.add_rank(&samples, n)?;
        let rows: Vec<Vec<Fp>> = samples.values[0].chunks(n).map(<[Fp]>::to_vec).collect();
        let echelon = Echelon::new(&rows, n);
        let kept: Vec<usize> = (0..n).filter(|&i| !echelon.contains(&unit_row(i, n))).collect();
        let mut projected = Echelon::empty(kept.len());
        let mut reduced = Vec::new();
        for (field, row) in fields.iter().zip(&rows) {
            if projected.insert(kept.iter().map(|&i| row[i]).collect()) {
                reduced.push(kept.iter().map(|&i| field[i]).collect());
            }
        }
        Ok(Search {
            all: all.to_vec(),
            states: kept.iter().map(|&i| all[i]).collect(),
            fields: reduced,
            known,
            parameters,
            base,
            bindings: bindings.clone(),
            constants_named: back,
            found: Vec::new(),
            differentials: Vec::new(),
            wanted,
        })
    }

    fn done(&self) -> bool {
        self.found.len() == self.wanted
    }

    fn run(&mut self, pool: &mut Pool, among: Among, evidence: &mut Evidence) -> Result<(), Undecided> {
        let states: Vec<Expr> = self.states.iter().map(|&s| pool.sym(s)).collect();
        let linear = linear(pool, &states);
        self.attempt(pool, &linear, true, evidence)?;
        let mut stages = vec![linear];
        if among == Among::All && !self.done() {
            stages.extend(self.nonlinear(pool));
            for stage in &stages[1..] {
                self.attempt(pool, stage, true, evidence)?;
            }
        }
        if !self.parameters.is_empty() {
            for stage in &stages {
                self.attempt(pool, stage, false, evidence)?;
            }
        }
        Ok(())
    }

    /// Ansätze of functions in the model, simple ones first.
    fn nonlinear(&self, pool: &mut Pool) -> Vec<Ansatz> {
        // A state that is an integral has component zero in all fields.
        let mut moving = Vec::new();
        for i in 0..self.states.len() {
            let mut moves = false;
            for y in &self.fields {
                moves |= !pool.is_zero(y[i]) && !pool.zero_test(y[i], &self.bindings).is_zero();
            }
            moving.push(moves);
        }
        let mut expressions = self.fields.concat();
        expressions.extend(&self.known);
        let mut blocks = Blocks::of(pool, &self.all, &self.states, &moving, &expressions);
        blocks.exponentials(pool, &self.all, &self.states, &self.fields);
        let mut stages = vec![blocks.quadratic(pool), blocks.polynomial(pool), blocks.trigonometric(pool)];
        stages.extend(blocks.over_denominators(pool));
        stages.push(blocks.products_of_many(pool));
        stages
    }

    /// Values of the parameters for a search: generic ones, or those that the caller gave.
    fn values(&self, generic: bool) -> Bindings {
        if generic { bound(&self.parameters, &self.base) } else { self.bindings.clone() }
    }

    /// Adds the integrals among the combinations of an ansatz.
    fn attempt(
        &mut self,
        pool: &mut Pool,
        ansatz: &Ansatz,
        generic: bool,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        if self.done() || ansatz.columns.is_empty() || !evidence.allow_search(ansatz.columns.len()) {
            return Ok(());
        }
        let values = self.values(generic);
        let roots = ansatz.roots(pool, &self.states, &self.fields);
        // A function that cannot be evaluated together with the others spoils this ansatz only.
        let Ok(candidates) = ansatz.constant_combinations(pool, &roots, &values) else { return Ok(()) };
        if candidates.is_empty() {
            return Ok(());
        }
        let Ok(gradients) = ansatz.gradients(pool, &self.states, &values, &self.found) else {
            return Ok(());
        };
        let Some((gradients, known)) = gradients.split_at_checked(ansatz.columns.len()) else { return Ok(()) };
        let mut independent = Echelon::new(known, self.states.len());
        for c in candidates.iter().take(MAX_CANDIDATES) {
            if self.done() {
                break;
            }
            let mut gradient = vec![Fp::ZERO; self.states.len()];
            for (&c, row) in c.iter().zip(gradients) {
                if !c.is_zero() {
                    for (g, &x) in gradient.iter_mut().zip(row) {
                        *g += c * x;
                    }
                }
            }
            if independent.contains(&gradient) {
                continue;
            }
            let Some(phi) = self.function(pool, ansatz, c, generic) else { continue };
            if self.offer(pool, phi, evidence)? {
                independent.insert(gradient);
            }
        }
        Ok(())
    }

    /// The combination of the columns of an ansatz with these coefficients, which hold at generic
    /// values of the parameters or at those given.
    fn function(&self, pool: &mut Pool, ansatz: &Ansatz, c: &[Fp], generic: bool) -> Option<Expr> {
        let support: Vec<usize> = (0..c.len()).filter(|&i| !c[i].is_zero()).collect();
        let c: Vec<Fp> = support.iter().map(|&i| c[i]).collect();
        let small = ansatz.restricted(&support);
        let roots = small.roots(pool, &self.states, &self.fields);
        let mut vector = OnSupport {
            pool,
            ansatz: &small,
            roots: &roots,
            parameters: Vec::new(),
            base: Vec::new(),
            given: Bindings::new(),
        };
        let c = if generic {
            vector.parameters.clone_from(&self.parameters);
            vector.base.clone_from(&self.base);
            c
        } else {
            // Of the parameters only those that the combination needs keep their values.
            vector.given = self.bindings.clone();
            let mut c = c;
            for (&s, &v) in self.parameters.iter().zip(&self.base) {
                vector.parameters.push(s);
                vector.base.push(v);
                if let Some(at) = vector.at(&vector.base.clone()) {
                    c = at;
                } else {
                    vector.parameters.pop();
                    vector.base.pop();
                }
            }
            c
        };
        let coefficients = common(&fractions(&c, &mut vector)?);
        let parameters = &vector.parameters.clone();
        if let Some(product) = powers(pool, &small, &coefficients) {
            return Some(product);
        }
        let mut sum = pool.int(0);
        for (i, p) in coefficients.iter().enumerate() {
            let coefficient = expression(pool, p, parameters);
            let column = small.expression(pool, i);
            let term = pool.mul(coefficient, column);
            sum = pool.add(sum, term);
        }
        // A sum of two states stays in their order.
        let single = |c: &Column| matches!(c, Column::Product(p) if p.len() == 1);
        if support.len() <= 2 && ansatz.columns.iter().all(single) {
            return Some(sum);
        }
        let phi = pool.simplify(sum);
        if pool.text_size(phi).negative {
            let minus = pool.neg(phi);
            return Some(pool.simplify(minus));
        }
        Some(phi)
    }

    /// Keeps `phi` if it is an integral and independent of those kept so far.
    fn offer(&mut self, pool: &mut Pool, phi: Expr, evidence: &mut Evidence) -> Result<bool, Undecided> {
        for y in &self.fields {
            let l = pool.lie_derivative(phi, &self.states, y);
            if pool.is_zero(l) {
                continue;
            }
            match pool.zero_test(l, &self.bindings) {
                ZeroTest::Zero(certificate) => evidence.add(&certificate),
                ZeroTest::NonZero | ZeroTest::Unknown(_) => return Ok(false),
            }
        }
        let d = pool.gradient(phi, &self.states);
        if is_plain_zero(pool, &d) {
            return Ok(false);
        }
        let mut all = self.differentials.clone();
        all.push(d);
        if independent(pool, &all, &self.bindings, evidence)?.len() < all.len() {
            return Ok(false);
        }
        self.differentials = all;
        self.found.push(phi);
        Ok(true)
    }
}

/// The coefficients of the one combination of a few columns, as functions of the parameters.
struct OnSupport<'a> {
    pool: &'a mut Pool,
    ansatz: &'a Ansatz,
    roots: &'a [Expr],
    parameters: Vec<Symbol>,
    base: Vec<u64>,
    /// Values of what is not a parameter here.
    given: Bindings,
}

impl Values for OnSupport<'_> {
    fn base(&self) -> &[u64] {
        &self.base
    }

    fn at(&mut self, values: &[u64]) -> Option<Vec<Fp>> {
        let mut bindings = self.given.clone();
        for (&s, &v) in self.parameters.iter().zip(values) {
            bindings.bind(s, Rational::from(v));
        }
        let mut found = self.ansatz.constant_combinations(self.pool, self.roots, &bindings).ok()?;
        if found.len() == 1 { found.pop() } else { None }
    }
}

fn bound(symbols: &[Symbol], values: &[u64]) -> Bindings {
    let mut bindings = Bindings::new();
    for (&s, &v) in symbols.iter().zip(values) {
        bindings.bind(s, Rational::from(v));
    }
    bindings
}

/// A sum of multiples of logarithms as the product of powers whose logarithm it is.
fn powers(pool: &mut Pool, ansatz: &Ansatz, coefficients: &[Polynomial]) -> Option<Expr> {
    let mut product = pool.int(1);
    for (column, c) in ansatz.columns.iter().zip(coefficients) {
        let Column::Function(k) = column else { return None };
        let Node::Call(Func::Log, argument) = pool.node(ansatz.functions[*k]) else { return None };
        let (exponents, c) = c.first_key_value().filter(|_| c.len() == 1)?;
        if exponents.iter().any(|&e| e != 0) {
            return None;
        }
        let exponent = pool.rational(c.clone());
        let power = pool.pow(argument, exponent);
        product = pool.mul(product, power);
    }
    Some(product)
}

/// Values of parameters that stand for generic ones.
pub(crate) fn parameter_values(count: usize) -> Vec<u64> {
    (0..count).map(|k| scramble(1, k as u64 + 1)).collect()
}

/// A symbol for every largest sub-expression that is constant but not a rational function of
/// parameters, such as sin(alpha): a sample gives each its own value at every point.
pub(crate) fn name_constants(pool: &mut Pool, roots: &[Expr], states: &[Symbol]) -> FxHashMap<Expr, Expr> {
    let nodes = pool.reachable(roots);
    let mut depends: FxHashMap<Expr, bool> = FxHashMap::default();
    let mut named = FxHashMap::default();
    for &e in &nodes {
        let node = pool.node(e);
        let here = match node {
            Node::Sym(s) => states.contains(&s),
            _ => node.operands().any(|o| depends[&o]),
        };
        depends.insert(e, here);
    }
    for e in nodes {
        let transcendental = match pool.node(e) {
            Node::Pi | Node::Call(..) | Node::Call2(..) => true,
            Node::Pow(_, k) => pool.integer(k).is_none(),
            _ => false,
        };
        if transcendental && !depends[&e] {
            let name = format!("constant {}", pool.text(e));
            let symbol = pool.var(&name);
            named.insert(e, symbol);
        }
    }
    named
}
