//! The search for cases, set by set.

use bracketry_symbolic::{Bindings, Expr, Function, Pool, Rational, Symbol, ZeroTest};
use rustc_hash::FxHashMap;

use crate::algebra::rational::parametric::{expression, quotient};
use crate::algebra::rational::polynomial::{Budget, Polynomial};
use crate::algebra::rational::readable::tidy;
use crate::answer::Answer;
use crate::evidence::Evidence;
use crate::parameters::aspect::{Aspect, AspectValue, Generic, Subject};
use crate::parameters::confirm::{Confirmed, point_with};
use crate::parameters::decompose::{Solution, components, solution};
use crate::parameters::factor::determinant;
use crate::parameters::limits::{Limits, possible_within};
use crate::parameters::report::{AspectCases, Incomplete, ParameterCase};
use crate::parameters::state_values::{StateValues, Uncovered};

/// Products of terms for the minors and factors of one set.
const MAX_PRODUCTS: usize = 400_000;
/// Sets that are looked at for one aspect.
const MAX_SETS: usize = 150;
/// Random states at which minors are taken.
const DRAWS: u64 = 3;
/// Choices of columns for a matrix that has more than rows.
const COLUMN_CHOICES: usize = 4;
/// Sets of columns among which they are chosen.
const MAX_COLUMN_SETS: usize = 2000;

pub(crate) struct Explorer<'a> {
    pub(crate) pool: &'a mut Pool,
    symbols: Vec<Symbol>,
    limits: Limits,
    depth: usize,
}

/// A set of parameters: where one after the other is given by those that are left.
#[derive(Clone, Default)]
struct Region {
    conditions: Vec<Expr>,
    solved: Vec<(Symbol, Expr)>,
    /// A parameter is given by a root, so that nothing further can be put in.
    root: bool,
}

/// What is known of an aspect so far.
struct Search {
    aspect: Aspect,
    seen: Vec<Region>,
    sets: Vec<(Region, AspectValue)>,
    open: Vec<Incomplete>,
    deeper: bool,
}

impl<'a> Explorer<'a> {
    pub(crate) fn new(pool: &'a mut Pool, symbols: &[Symbol], limits: Limits, depth: usize) -> Self {
        Explorer { pool, symbols: symbols.to_vec(), limits, depth }
    }

    /// The cases of an aspect.
    pub(crate) fn aspect(&mut self, subject: &Subject, aspect: Aspect, evidence: &mut Evidence) -> AspectCases {
        let mut search = Search { aspect, seen: Vec::new(), sets: Vec::new(), open: Vec::new(), deeper: false };
        let generic = match subject.generic(self.pool, aspect, evidence) {
            Ok(generic) => {
                let value = generic.value.clone();
                self.within(subject, &Region::default(), &generic, &mut search, evidence);
                Answer::Known(value)
            }
            Err(why) => {
                search.open.push(Incomplete::Undecided { reason: why.to_string() });
                Answer::Unknown(why.into())
            }
        };
        let cases = generic.known().map(|v| self.cases(subject, v, &mut search, evidence)).unwrap_or_default();
        let complete_up_to_conditions = search.open.is_empty();
        if search.deeper {
            search.open.push(Incomplete::MoreConditions);
        }
        AspectCases {
            aspect,
            generic,
            cases,
            complete: search.open.is_empty(),
            complete_up_to_conditions,
            open: search.open,
        }
    }

    /// The sets on which the verdict is not what those around them let expect.
    fn cases(
        &mut self,
        subject: &Subject,
        generic: &AspectValue,
        search: &mut Search,
        evidence: &mut Evidence,
    ) -> Vec<ParameterCase> {
        let mut sets = std::mem::take(&mut search.sets);
        sets.sort_by_key(|s| s.0.solved.len());
        let mut kept: Vec<(Region, AspectValue)> = Vec::new();
        let mut cases = Vec::new();
        for (region, value) in sets {
            let around: Vec<&(Region, AspectValue)> =
                kept.iter().filter(|k| k.0.solved.len() < region.solved.len() && self.lies_in(&region, &k.0)).collect();
            if AspectValue::expected(generic, &around.iter().map(|k| (k.0.solved.len(), &k.1)).collect::<Vec<_>>())
                .is_some_and(|expected| *expected == value)
            {
                continue;
            }
            cases.push(self.case(subject, &region, &value, search.aspect, evidence));
            kept.push((region, value));
        }
        cases
    }

    /// Looks for the sets within a region, on which the verdict is `generic`, where it may differ.
    fn within(
        &mut self,
        subject: &Subject,
        region: &Region,
        generic: &Generic,
        search: &mut Search,
        evidence: &mut Evidence,
    ) {
        let free: Vec<Symbol> =
            self.symbols.iter().copied().filter(|s| !region.solved.iter().any(|x| x.0 == *s)).collect();
        if free.is_empty() {
            return;
        }
        if region.root {
            if generic.value.may_fall() {
                let condition = Function::new(self.pool, region.conditions[region.conditions.len() - 1]);
                search.note(Incomplete::Nonlinear { condition });
            }
            return;
        }
        let here = self.specialized(subject, region);
        for matrix in &generic.matrices {
            let mut budget = Budget::new(MAX_PRODUCTS);
            let minors = match self.minors(&here, matrix, &free, &mut budget) {
                Ok(minors) => minors,
                Err(why) => {
                    search.note(why);
                    self.simple_candidates(subject, region, &free, search, evidence);
                    continue;
                }
            };
            let left = self.depth - region.solved.len();
            let found = components(&minors, left, &mut budget);
            search.deeper |= found.deeper;
            if found.missing {
                search.note(Incomplete::TooLarge);
            }
            for chain in found.chains {
                let mut child = Some(region.clone());
                for q in &chain {
                    child = child.and_then(|r| self.narrowed(&r, &q.polynomial, &free));
                    if !q.irreducible {
                        let condition = expression(self.pool, &q.polynomial, &free);
                        search.note(Incomplete::Nonlinear { condition: Function::new(self.pool, condition) });
                    }
                }
                if let Some(child) = child {
                    self.visit(subject, &child, search, evidence);
                } else {
                    let q = &chain[chain.len() - 1].polynomial;
                    let condition = expression(self.pool, q, &free);
                    search.note(Incomplete::Nonlinear { condition: Function::new(self.pool, condition) });
                }
            }
        }
    }

    /// Equal parameters and zeros, where minors are out of reach.
    fn simple_candidates(
        &mut self,
        subject: &Subject,
        region: &Region,
        free: &[Symbol],
        search: &mut Search,
        evidence: &mut Evidence,
    ) {
        if region.solved.len() >= self.depth {
            return;
        }
        let mut list: Vec<Polynomial> = (0..free.len()).map(Polynomial::atom).collect();
        for i in 0..free.len() {
            for j in i + 1..free.len() {
                for sign in [-1, 1] {
                    let mut p = Polynomial::atom(i);
                    p.add(&Polynomial::atom(j), &Rational::from(sign));
                    list.push(p);
                }
            }
        }
        for q in list {
            if let Some(child) = self.narrowed(region, &q, free) {
                // One condition each: sets within them are not looked for.
                self.judge(subject, &child, search, evidence);
            }
        }
    }

    /// The region where a polynomial in the free parameters vanishes too.
    fn narrowed(&mut self, region: &Region, q: &Polynomial, free: &[Symbol]) -> Option<Region> {
        let mut next = region.clone();
        next.conditions.push(expression(self.pool, q, free));
        let (s, value) = if let Some(Solution { variable, top, bottom }) = solution(q) {
            let (top, bottom) = (expression(self.pool, &top, free), expression(self.pool, &bottom, free));
            let value = self.pool.div(top, bottom);
            (free[variable], tidy(self.pool, value))
        } else {
            next.root = true;
            self.root(q, free)?
        };
        let x = self.pool.sym(s);
        let map: FxHashMap<Expr, Expr> = std::iter::once((x, value)).collect();
        for (_, e) in &mut next.solved {
            let put = self.pool.substitute(*e, &map);
            *e = tidy(self.pool, put);
        }
        next.solved.push((s, value));
        if next.solved.len() > 1 && !next.root {
            next.conditions = self.plain_conditions(&next);
        }
        Some(next)
    }

    /// A parameter as a root of a polynomial of degree 2 in it.
    fn root(&mut self, q: &Polynomial, free: &[Symbol]) -> Option<(Symbol, Expr)> {
        let v = q.support().into_iter().find(|&v| q.degree(v) == 2)?;
        let [c, b, a] = &q.coefficients(v)[..] else { return None };
        let [c, b, a] = [c, b, a].map(|p| expression(self.pool, p, free));
        let pool = &mut *self.pool;
        let (square, four) = (pool.powi(b, 2), pool.int(-4));
        let product = pool.mul(a, c);
        let product = pool.mul(four, product);
        let discriminant = pool.add(square, product);
        let root = pool.sqrt(discriminant);
        let top = pool.sub(root, b);
        let two = pool.int(2);
        let bottom = pool.mul(two, a);
        Some((free[v], pool.div(top, bottom)))
    }

    /// What vanishes on a region, each function in the parameters that it gives and those that are left.
    fn plain_conditions(&mut self, region: &Region) -> Vec<Expr> {
        let mut list: Vec<(Symbol, Expr)> = region.solved.clone();
        list.sort_by_key(|x| self.symbols.iter().position(|s| *s == x.0));
        let symbols = self.symbols.clone();
        let mut plain = Vec::with_capacity(list.len());
        for (s, e) in list {
            let x = self.pool.sym(s);
            let difference = self.pool.sub(x, e);
            plain.push(match quotient(self.pool, difference, &symbols, &mut Budget::new(MAX_PRODUCTS)) {
                Some((top, _)) => expression(self.pool, &top.primitive().1, &symbols),
                None => difference,
            });
        }
        plain
    }

    fn map_of(&mut self, region: &Region) -> FxHashMap<Expr, Expr> {
        region.solved.iter().map(|&(s, e)| (self.pool.sym(s), e)).collect()
    }

    fn specialized(&mut self, subject: &Subject, region: &Region) -> Subject {
        let map = self.map_of(region);
        if map.is_empty() { subject.clone() } else { subject.with(self.pool, &map) }
    }

    /// Whether all conditions of `outer` hold on `inner`.
    fn lies_in(&mut self, inner: &Region, outer: &Region) -> bool {
        let map = self.map_of(inner);
        outer.solved.iter().all(|&(s, e)| {
            let x = self.pool.sym(s);
            let difference = self.pool.sub(x, e);
            let value = self.pool.substitute(difference, &map);
            self.pool.is_zero(value) || matches!(self.pool.zero_test(value, &Bindings::new()), ZeroTest::Zero(_))
        })
    }

    /// Decides on a region that was not seen yet, and looks within it.
    fn visit(&mut self, subject: &Subject, region: &Region, search: &mut Search, evidence: &mut Evidence) {
        if let Some(generic) = self.judge(subject, region, search, evidence) {
            self.within(subject, region, &generic, search, evidence);
        }
    }

    /// Decides on a region, and notes it.
    fn judge(
        &mut self,
        subject: &Subject,
        region: &Region,
        search: &mut Search,
        evidence: &mut Evidence,
    ) -> Option<Generic> {
        let seen = std::mem::take(&mut search.seen);
        let known = seen
            .iter()
            .any(|r| r.solved.len() == region.solved.len() && self.lies_in(region, r) && self.lies_in(r, region));
        search.seen = seen;
        if known {
            return None;
        }
        if search.seen.len() >= MAX_SETS {
            search.note(Incomplete::TooLarge);
            return None;
        }
        search.seen.push(region.clone());
        if self.pool.reached_limit().is_some() {
            search.note(Incomplete::Time);
            return None;
        }
        let here = self.specialized(subject, region);
        let first = here.roots_of(search.aspect);
        if let Err(bracketry_symbolic::Undecided::DivisionByZero) = self.pool.sample(&first, &Bindings::new(), 1, 11) {
            return None;
        }
        let generic = match here.generic(self.pool, search.aspect, evidence) {
            Ok(generic) => generic,
            Err(why) => {
                search.note(Incomplete::Undecided { reason: why.to_string() });
                return None;
            }
        };
        search.sets.push((region.clone(), generic.value.clone()));
        Some(generic)
    }

    fn case(
        &mut self,
        subject: &Subject,
        region: &Region,
        value: &AspectValue,
        aspect: Aspect,
        evidence: &mut Evidence,
    ) -> ParameterCase {
        let confirmed_at = if region.root {
            Confirmed::default()
        } else {
            point_with(self.pool, subject, aspect, value, &self.symbols, &region.solved, evidence)
        };
        let within_limits = possible_within(self.pool, &region.conditions, &self.symbols, &self.limits);
        let named = |x: &(Symbol, Expr)| (self.pool.name(x.0).to_owned(), Function::new(self.pool, x.1));
        ParameterCase {
            conditions: Function::list(self.pool, &region.conditions),
            solved: region.solved.iter().map(named).collect(),
            value: value.clone(),
            confirmed_at,
            within_limits,
        }
    }

    /// Maximal minors at random states, as polynomials in the free parameters; their common zeros hold all values at
    /// which the matrix loses rank for all states.
    fn minors(
        &mut self,
        here: &Subject,
        matrix: &[Vec<Expr>],
        free: &[Symbol],
        budget: &mut Budget,
    ) -> Result<Vec<Polynomial>, Incomplete> {
        let roots: Vec<Expr> = matrix.concat();
        let states = &here.fields.states;
        let values = StateValues::new(self.pool, states, &roots)
            .map_err(|Uncovered(e)| Incomplete::Function { function: Function::new(self.pool, e) })?;
        let constant = !self.pool.symbols_of(&roots).iter().any(|s| states.contains(s));
        let mut minors: Vec<Polynomial> = Vec::new();
        for draw in 0..if constant { 1 } else { DRAWS } {
            let map = values.draw(self.pool, draw + 1);
            let mut rows = Vec::with_capacity(matrix.len());
            for row in matrix {
                let row = self.pool.substitute_all(row, &map);
                rows.push(self.polynomials(&row, free, budget)?);
            }
            let columns = choices(&rows);
            for set in columns {
                let square: Vec<Vec<Polynomial>> =
                    rows.iter().map(|r| set.iter().map(|&j| r[j].clone()).collect()).collect();
                let Some(minor) = determinant(square, budget) else {
                    if minors.is_empty() {
                        return Err(Incomplete::TooLarge);
                    }
                    return Ok(minors);
                };
                if minor.is_constant() && !minor.is_zero() {
                    return Ok(vec![minor]);
                }
                if !minor.is_zero() {
                    minors.push(minor);
                }
            }
        }
        if minors.is_empty() { Err(Incomplete::TooLarge) } else { Ok(minors) }
    }

    /// The entries of a row times their common denominator.
    fn polynomials(
        &mut self,
        row: &[Expr],
        free: &[Symbol],
        budget: &mut Budget,
    ) -> Result<Vec<Polynomial>, Incomplete> {
        let mut quotients = Vec::with_capacity(row.len());
        for &e in row {
            let e = self.pool.simplify(e);
            let q = quotient(self.pool, e, free, budget).ok_or_else(|| self.not_rational(e))?;
            quotients.push(q);
        }
        let mut common = Polynomial::constant(&Rational::ONE);
        for (_, bottom) in &quotients {
            let list = factors_of(bottom, &common, budget).ok_or(Incomplete::TooLarge)?;
            common = common.mul(&list, budget).ok_or(Incomplete::TooLarge)?;
        }
        let entry = |(top, bottom): &(Polynomial, Polynomial), budget: &mut Budget| {
            let share = common.exact_quotient(bottom, budget)?;
            top.mul(&share, budget)
        };
        quotients.iter().map(|q| entry(q, budget).ok_or(Incomplete::TooLarge)).collect()
    }

    /// Why an expression is no quotient of polynomials that fit.
    fn not_rational(&mut self, e: Expr) -> Incomplete {
        use bracketry_symbolic::Node;
        let found = self.pool.reachable(&[e]).into_iter().find(|&n| match self.pool.node(n) {
            Node::Call(..) | Node::Call2(..) | Node::Pi => true,
            Node::Pow(_, k) => self.pool.integer(k).is_none(),
            _ => false,
        });
        match found {
            Some(n) => Incomplete::Function { function: Function::new(self.pool, n) },
            None => Incomplete::TooLarge,
        }
    }
}

/// What `common` lacks to be a multiple of `p`.
fn factors_of(p: &Polynomial, common: &Polynomial, budget: &mut Budget) -> Option<Polynomial> {
    let shared = p.gcd(common, budget)?;
    p.exact_quotient(&shared, budget)
}

/// Sets of columns for maximal minors: from different starts, so that few zeros are shared by chance.
fn choices(rows: &[Vec<Polynomial>]) -> Vec<Vec<usize>> {
    let (r, n) = (rows.len(), rows.first().map_or(0, Vec::len));
    if r == n {
        return vec![(0..n).collect()];
    }
    let all = crate::algebra::subsets::subsets(n, r).take(MAX_COLUMN_SETS);
    let mut list = Vec::new();
    for set in all {
        let square: Vec<Vec<Polynomial>> =
            rows.iter().map(|row| set.iter().map(|&j| row[j].clone()).collect()).collect();
        let empty_row = square.iter().any(|row| row.iter().all(Polynomial::is_zero));
        let empty_column = (0..r).any(|j| square.iter().all(|row| row[j].is_zero()));
        if !empty_row && !empty_column {
            list.push(set);
        }
    }
    // A few from all over the list.
    let step = list.len().div_ceil(COLUMN_CHOICES).max(1);
    let many = list.len() > 3 * COLUMN_CHOICES;
    list.into_iter().enumerate().filter(|(i, _)| !many || i % step == 0).map(|x| x.1).collect()
}

impl Search {
    fn note(&mut self, why: Incomplete) {
        if !self.open.contains(&why) {
            self.open.push(why);
        }
    }
}

impl AspectValue {
    /// What sets around a set let expect there, given with their numbers of conditions: a rank is the least of all; else
    /// the verdict of the smallest sets, if these agree.
    fn expected<'a>(generic: &'a AspectValue, around: &[(usize, &'a AspectValue)]) -> Option<&'a AspectValue> {
        if let AspectValue::Dimension(_) = generic {
            let size = |v: &AspectValue| if let AspectValue::Dimension(d) = v { *d } else { usize::MAX };
            return around.iter().map(|a| a.1).chain([generic]).min_by_key(|v| size(v));
        }
        let Some(most) = around.iter().map(|a| a.0).max() else { return Some(generic) };
        let mut innermost = around.iter().filter(|a| a.0 == most).map(|a| a.1);
        let first = innermost.next()?;
        innermost.all(|v| v == first).then_some(first)
    }

    /// Whether a special value may be lower still.
    fn may_fall(&self) -> bool {
        !matches!(self, AspectValue::Dimension(0))
    }
}
