//! Vector fields along which given differentials vanish, in a form that can be read.

use bracketry_symbolic::{Bindings, Expr, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::algebra::field::Field;
use crate::algebra::integrals::fraction::{Values, common, expression, fractions};
use crate::algebra::integrals::search::{name_constants, parameter_values};
use crate::algebra::span::independent;
use crate::evidence::Evidence;
use crate::residues::unit_row;
use crate::residues::{Echelon, Fp, OFFSET};
use crate::undecided::Undecided;

/// Seed and spare points of the samples that coefficients are solved from.
const SEED: u64 = 0x6272_6163_6b65_7405;
const IDLE_POINTS: usize = 3;
/// Most unknown coefficients at once.
const MAX_COLUMNS: usize = 300;
/// Most candidates of one degree that are looked at.
const MAX_CANDIDATES: usize = 60;
/// Largest matrix whose minors are written out, and most nodes of it.
const MAX_MINOR: usize = 3;
const MAX_MINOR_NODES: usize = 600;
/// Most nodes of forms that are interpolated.
const MAX_RATIONAL_NODES: usize = 3000;
/// Most nodes of a component that is shown.
const MAX_SHOWN_NODES: usize = 200;

/// Independent vector fields X with ω(X) = 0 for every one-form ω of `forms` (one component per
/// variable each), at a generic point: with polynomial components, of low degree where there are
/// such, else by Cramer's rule.
///
/// There are n − rank of them; fewer are returned if some have no form short enough to be read.
/// Every field was verified exactly.
pub(crate) fn annihilator(
    pool: &mut Pool,
    variables: &[Symbol],
    forms: &[Field],
    bindings: &Bindings,
    evidence: &mut Evidence,
) -> Result<Vec<Field>, Undecided> {
    let n = variables.len();
    let unit = |pool: &mut Pool, i: usize| -> Field { (0..n).map(|j| pool.int(i64::from(i == j))).collect() };
    if forms.is_empty() {
        return Ok((0..n).map(|i| unit(pool, i)).collect());
    }
    let flat = forms.concat();
    let named = name_constants(pool, &flat, variables);
    let back: FxHashMap<Expr, Expr> = named.iter().map(|(&e, &s)| (s, e)).collect();
    let flat = pool.substitute_all(&flat, &named);
    let sample = pool.sample_in::<OFFSET>(&flat, bindings, 1, SEED)?;
    if sample.ambiguous_signs > 0 {
        return Err(bracketry_symbolic::Undecided::Sign.into());
    }
    let rows: Vec<Vec<Fp>> = sample.values[0].chunks(n).map(<[Fp]>::to_vec).collect();
    let span = Echelon::new(&rows, n);
    // A variable that the forms determine does not move.
    let moving: Vec<usize> = (0..n).filter(|&i| !span.contains(&unit_row(i, n))).collect();
    let mut reduced = Echelon::empty(moving.len());
    let mut forms: Vec<Field> = Vec::new();
    for (form, row) in flat.chunks(n).zip(&rows) {
        if reduced.insert(moving.iter().map(|&i| row[i]).collect()) {
            forms.push(moving.iter().map(|&i| form[i]).collect());
        }
    }
    let parameters: Vec<Symbol> =
        pool.symbols_of(&forms.concat()).into_iter().filter(|s| !variables.contains(s)).collect();
    let mut search = Search {
        all: variables.to_vec(),
        variables: moving.iter().map(|&i| variables[i]).collect(),
        wanted: moving.len() - forms.len(),
        base: parameter_values(parameters.len()),
        forms,
        parameters,
        bindings: bindings.clone(),
        found: Vec::new(),
    };
    for degree in [1, 2] {
        for generic in [true, false] {
            if generic || !search.parameters.is_empty() {
                search.polynomial(pool, degree, generic, evidence)?;
            }
        }
    }
    search.rational(pool, evidence)?;
    search.cramer(pool, evidence)?;
    let zero = pool.int(0);
    let mut fields = Vec::new();
    for short in search.found {
        let mut field = vec![zero; n];
        for (&i, e) in moving.iter().zip(pool.substitute_all(&short, &back)) {
            field[i] = e;
        }
        fields.push(field);
    }
    Ok(fields)
}

struct Search {
    all: Vec<Symbol>,
    /// Those that move.
    variables: Vec<Symbol>,
    wanted: usize,
    forms: Vec<Field>,
    parameters: Vec<Symbol>,
    base: Vec<u64>,
    bindings: Bindings,
    found: Vec<Field>,
}

/// A component and the product of atoms that it may contain.
type Column = (usize, Vec<usize>);

impl Search {
    fn done(&self) -> bool {
        self.found.len() == self.wanted
    }

    /// Fields whose components are polynomials of at most this degree.
    fn polynomial(
        &mut self,
        pool: &mut Pool,
        degree: usize,
        generic: bool,
        evidence: &mut Evidence,
    ) -> Result<(), Undecided> {
        if self.done() {
            return Ok(());
        }
        // Moving variables first: most symmetries need no other.
        let mut atoms = self.variables.clone();
        atoms.extend(self.all.iter().filter(|s| !self.variables.contains(s)));
        let mut products: Vec<Vec<usize>> = vec![Vec::new()];
        products.extend((0..atoms.len()).map(|i| vec![i]));
        if degree > 1 {
            products.extend((0..atoms.len()).flat_map(|j| (0..=j).map(move |i| vec![i, j])));
        }
        let mut columns: Vec<Column> =
            products.into_iter().flat_map(|p| (0..self.variables.len()).map(move |i| (i, p.clone()))).collect();
        columns.truncate(MAX_COLUMNS);
        if !evidence.allow_search(columns.len()) {
            return Ok(());
        }
        let mut given = self.bindings.clone();
        if generic {
            for (&s, &v) in self.parameters.iter().zip(&self.base) {
                given.bind(s, Rational::from(v));
            }
        }
        let atoms: Vec<Expr> = atoms.iter().map(|&s| pool.sym(s)).collect();
        let Ok(candidates) = combinations(pool, &self.forms, &atoms, &columns, &given) else { return Ok(()) };
        for c in candidates.into_iter().take(MAX_CANDIDATES) {
            if self.done() {
                break;
            }
            let support: Vec<usize> = (0..c.len()).filter(|&i| !c[i].is_zero()).collect();
            let c: Vec<Fp> = support.iter().map(|&i| c[i]).collect();
            let columns: Vec<Column> = support.iter().map(|&i| columns[i].clone()).collect();
            let (parameters, base): (&[Symbol], &[u64]) =
                if generic { (&self.parameters, &self.base) } else { (&[], &[]) };
            let mut vector = OnSupport {
                pool,
                forms: &self.forms,
                atoms: &atoms,
                columns: &columns,
                parameters,
                base,
                given: &given,
            };
            let Some(c) = fractions(&c, &mut vector) else { continue };
            let zero = pool.int(0);
            let mut field = vec![zero; self.variables.len()];
            for ((i, product), p) in columns.iter().zip(common(&c)) {
                let mut term = expression(pool, &p, parameters);
                for &a in product {
                    term = pool.mul(term, atoms[a]);
                }
                field[*i] = pool.add(field[*i], term);
            }
            let field: Field = field.into_iter().map(|e| pool.simplify(e)).collect();
            self.offer(pool, &field, evidence)?;
        }
        Ok(())
    }

    /// The solutions of the linear equations ω(X) = 0 with one free component each, interpolated
    /// as rational functions of the variables and freed of denominators.
    fn rational(&mut self, pool: &mut Pool, evidence: &mut Evidence) -> Result<(), Undecided> {
        let flat = self.forms.concat();
        let nodes = pool.reachable(&flat);
        let rational = |&e: &Expr| match pool.node(e) {
            Node::Num(_) | Node::Sym(_) | Node::Add(..) | Node::Mul(..) => true,
            Node::Pow(_, k) => pool.integer(k).is_some(),
            _ => false,
        };
        if self.done() || nodes.len() > MAX_RATIONAL_NODES || !nodes.iter().all(rational) {
            return Ok(());
        }
        let symbols = pool.symbols_of(&flat);
        let base = parameter_values(symbols.len());
        let width = self.variables.len();
        let mut vector =
            AtValues { pool, flat: &flat, width, symbols: &symbols, base: &base, free: 0, support: Vec::new() };
        let Some(null) = vector.solutions(&base) else { return Ok(()) };
        let mut fields: Vec<Field> = Vec::new();
        for (free, whole) in null.iter().enumerate() {
            vector.free = free;
            vector.support = (0..width).filter(|&i| !whole[i].is_zero()).collect();
            let c: Vec<Fp> = vector.support.iter().map(|&i| whole[i]).collect();
            let Some(c) = fractions(&c, &mut vector) else { continue };
            let zero = vector.pool.int(0);
            let mut field = vec![zero; width];
            for (&i, p) in vector.support.clone().iter().zip(common(&c)) {
                let e = expression(vector.pool, &p, &symbols);
                field[i] = vector.pool.simplify(e);
            }
            fields.push(field);
        }
        for field in fields {
            if !self.done() {
                self.offer(pool, &field, evidence)?;
            }
        }
        Ok(())
    }

    /// The solutions of the linear equations ω(X) = 0 with one free component each.
    fn cramer(&mut self, pool: &mut Pool, evidence: &mut Evidence) -> Result<(), Undecided> {
        let flat = self.forms.concat();
        let (k, n) = (self.forms.len(), self.variables.len());
        if self.done() || k > MAX_MINOR || pool.reachable(&flat).len() > MAX_MINOR_NODES {
            return Ok(());
        }
        let sample = pool.sample_in::<OFFSET>(&flat, &self.bindings, 1, SEED ^ 1)?;
        let rows: Vec<Vec<Fp>> = sample.values[0].chunks(n).map(<[Fp]>::to_vec).collect();
        let free: Vec<usize> = {
            let null = Echelon::new(&rows, n).null_space();
            null.iter().filter_map(|v| v.iter().rposition(|x| !x.is_zero())).collect()
        };
        let pivots: Vec<usize> = (0..n).filter(|j| !free.contains(j)).collect();
        let minor = |pool: &mut Pool, columns: &[usize]| {
            let matrix: Vec<Field> = self.forms.iter().map(|form| columns.iter().map(|&j| form[j]).collect()).collect();
            pool.determinant(&matrix, |_, e| e)
        };
        let denominator = minor(pool, &pivots);
        let mut fields: Vec<Field> = Vec::new();
        for &j in &free {
            let zero = pool.int(0);
            let mut whole = vec![zero; n];
            let mut unit = vec![zero; n];
            whole[j] = pool.simplify(denominator);
            unit[j] = pool.int(1);
            for (i, &p) in pivots.iter().enumerate() {
                let mut columns = pivots.clone();
                columns[i] = j;
                let m = minor(pool, &columns);
                let m = pool.neg(m);
                whole[p] = pool.simplify(m);
                let quotient = pool.div(m, denominator);
                unit[p] = pool.simplify(quotient);
            }
            let shorter = pool.reachable(&unit).len() <= pool.reachable(&whole).len();
            fields.push(if shorter { unit } else { whole });
        }
        for field in fields {
            if !self.done() && pool.reachable(&field).len() <= MAX_SHOWN_NODES {
                self.offer(pool, &field, evidence)?;
            }
        }
        Ok(())
    }

    /// Keeps a field if all forms vanish on it and it is independent of those kept so far.
    fn offer(&mut self, pool: &mut Pool, field: &[Expr], evidence: &mut Evidence) -> Result<(), Undecided> {
        let mut all = self.found.clone();
        all.push(field.to_vec());
        if independent(pool, &all, &self.bindings, evidence)?.len() < all.len() {
            return Ok(());
        }
        for form in &self.forms {
            let mut value = pool.int(0);
            for (&w, &x) in form.iter().zip(field) {
                let term = pool.mul(w, x);
                value = pool.add(value, term);
            }
            match pool.zero_test(value, &self.bindings) {
                bracketry_symbolic::ZeroTest::Zero(certificate) => evidence.add(&certificate),
                _ => return Ok(()),
            }
        }
        self.found = all;
        Ok(())
    }
}

/// The combinations of the columns on which all forms vanish.
fn combinations(
    pool: &mut Pool,
    forms: &[Field],
    atoms: &[Expr],
    columns: &[Column],
    bindings: &Bindings,
) -> Result<Vec<Vec<Fp>>, Undecided> {
    let mut roots = atoms.to_vec();
    roots.extend(forms.concat());
    let samples = pool.sample_in::<OFFSET>(&roots, bindings, columns.len() + IDLE_POINTS, SEED)?;
    let width = forms.first().map_or(1, Vec::len);
    let mut echelon = Echelon::empty(columns.len());
    let mut idle = 0;
    for values in &samples.values {
        let (x, omega) = values.split_at(atoms.len());
        let products: Vec<Fp> = columns.iter().map(|(_, p)| p.iter().fold(Fp::ONE, |value, &a| value * x[a])).collect();
        let mut fresh = false;
        for form in omega.chunks(width) {
            let row = columns.iter().zip(&products).map(|((i, _), &value)| form[*i] * value).collect();
            fresh |= echelon.insert(row);
        }
        idle = if fresh { 0 } else { idle + 1 };
        if idle == IDLE_POINTS {
            break;
        }
    }
    Ok(echelon.null_space())
}

/// The coefficients of the one combination of a few columns, as functions of the parameters.
struct OnSupport<'a> {
    pool: &'a mut Pool,
    forms: &'a [Field],
    atoms: &'a [Expr],
    columns: &'a [Column],
    parameters: &'a [Symbol],
    base: &'a [u64],
    given: &'a Bindings,
}

impl Values for OnSupport<'_> {
    fn base(&self) -> &[u64] {
        self.base
    }

    fn at(&mut self, values: &[u64]) -> Option<Vec<Fp>> {
        let mut bindings = self.given.clone();
        for (&s, &v) in self.parameters.iter().zip(values) {
            bindings.bind(s, Rational::from(v));
        }
        let mut found = combinations(self.pool, self.forms, self.atoms, self.columns, &bindings).ok()?;
        if found.len() == 1 { found.pop() } else { None }
    }
}

/// A solution of the linear equations that forms with rational coefficients make, as a function
/// of the values of all symbols.
struct AtValues<'a> {
    pool: &'a mut Pool,
    flat: &'a [Expr],
    width: usize,
    symbols: &'a [Symbol],
    base: &'a [u64],
    /// Which of the solutions, and its components that are not zero.
    free: usize,
    support: Vec<usize>,
}

impl AtValues<'_> {
    fn solutions(&mut self, values: &[u64]) -> Option<Vec<Vec<Fp>>> {
        let mut bindings = Bindings::new();
        for (&s, &v) in self.symbols.iter().zip(values) {
            bindings.bind(s, Rational::from(v));
        }
        let samples = self.pool.sample_in::<OFFSET>(self.flat, &bindings, 1, SEED).ok()?;
        let rows: Vec<Vec<Fp>> = samples.values.first()?.chunks(self.width).map(<[Fp]>::to_vec).collect();
        Some(Echelon::new(&rows, self.width).null_space())
    }
}

impl Values for AtValues<'_> {
    fn base(&self) -> &[u64] {
        self.base
    }

    fn at(&mut self, values: &[u64]) -> Option<Vec<Fp>> {
        let whole = self.solutions(values)?;
        let whole = whole.get(self.free)?;
        Some(self.support.iter().map(|&i| whole[i]).collect())
    }
}
