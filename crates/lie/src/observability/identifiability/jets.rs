//! Polynomial equations modulo a prime between parameters, initial states, and Taylor coefficients, which hold just where
//! the outputs have the Taylor coefficients that they have at a random point.

use std::collections::BTreeMap;

use bracketry_symbolic::Residue;

use crate::observability::expansion::Expansion;
use crate::observability::identifiability::monomial::{MAX_VARIABLES, Monomial, Polynomial, Sum};
use crate::observability::series::{SeriesProgram, Step};

/// Variables with exponents, ascending.
type Powers = Vec<(u16, u8)>;

/// A polynomial in many variables, of which each term has few.
pub(crate) type Sparse<const C: u64> = BTreeMap<Powers, Residue<C>>;

/// Longer coefficients become variables of their own.
const MAX_TERMS: usize = 24;
/// Equations longer than this are not put in for a variable.
const MAX_REST: usize = 40;
/// Most growth, in terms, that putting in an equation for a variable may cause.
const MAX_GROWTH: usize = 600;

/// Why there are no equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoEquations {
    /// A function that is no quotient of polynomials.
    NotRational,
    /// Too many variables or terms.
    TooLarge,
}

/// The equations, with the variables that were asked for.
pub(crate) struct Equations<const C: u64> {
    pub(crate) polynomials: Vec<Polynomial<C>>,
    pub(crate) variables: usize,
    /// Each direction that is no number, as a polynomial in the variables.
    pub(crate) asked: Vec<Option<Polynomial<C>>>,
}

fn constant<const C: u64>(c: Residue<C>) -> Sparse<C> {
    if c.is_zero() { Sparse::new() } else { std::iter::once((Vec::new(), c)).collect() }
}

fn variable<const C: u64>(v: u16) -> Sparse<C> {
    std::iter::once((vec![(v, 1)], Residue::ONE)).collect()
}

fn add<const C: u64>(sum: &mut Sparse<C>, m: Powers, c: Residue<C>) {
    let entry = sum.entry(m).or_insert(Residue::ZERO);
    *entry += c;
}

fn times_powers(a: &Powers, b: &Powers) -> Powers {
    let mut out: BTreeMap<u16, u8> = a.iter().copied().collect();
    for &(v, k) in b {
        let e = out.entry(v).or_insert(0);
        *e = e.saturating_add(k);
    }
    out.into_iter().collect()
}

fn add_product<const C: u64>(sum: &mut Sparse<C>, a: &Sparse<C>, b: &Sparse<C>, c: Residue<C>) {
    for (m, x) in a {
        for (n, y) in b {
            add(sum, times_powers(m, n), *x * *y * c);
        }
    }
    sum.retain(|_, c| !c.is_zero());
}

/// Builds the equations.
struct Builder<'a, const C: u64> {
    program: &'a SeriesProgram,
    series: &'a Expansion<'a, C>,
    next: u16,
    equations: Vec<Sparse<C>>,
    /// By step and order.
    coefficients: Vec<Vec<Sparse<C>>>,
}

impl<const C: u64> Builder<'_, C> {
    fn fresh(&mut self) -> Result<u16, NoEquations> {
        self.next = self.next.checked_add(1).filter(|n| *n < 2000).ok_or(NoEquations::TooLarge)?;
        Ok(self.next - 1)
    }

    fn at(&self, r: usize, k: usize) -> Sparse<C> {
        self.coefficients[r].get(k).cloned().unwrap_or_default()
    }

    /// Whether a polynomial is a number.
    fn number(p: &Sparse<C>) -> bool {
        p.keys().all(Vec::is_empty)
    }

    fn coefficient(&mut self, r: usize, k: usize, given: &[bool]) -> Result<Sparse<C>, NoEquations> {
        let numeric = constant(self.series.at(r, k));
        Ok(match &self.program.steps[r] {
            Step::Constant { .. } | Step::Input | Step::State { direction: None, .. } => numeric,
            Step::Parameter { direction, .. } | Step::State { direction: Some(direction), .. } if k == 0 => {
                if given[*direction] { numeric } else { variable(*direction as u16) }
            }
            Step::Parameter { .. } => Sparse::new(),
            Step::Unknown { .. } => variable(self.fresh()?),
            Step::State { state, .. } => {
                let rate = self.at(self.program.rates[*state], k - 1);
                let v = self.fresh()?;
                let mut equation = Sparse::new();
                add(&mut equation, vec![(v, 1)], Residue::new(k as u64));
                for (m, c) in rate {
                    add(&mut equation, m, -c);
                }
                self.equations.push(equation);
                variable(v)
            }
            Step::Add(a, b) => {
                let mut sum = self.at(*a, k);
                for (m, c) in self.at(*b, k) {
                    add(&mut sum, m, c);
                }
                sum.retain(|_, c| !c.is_zero());
                sum
            }
            Step::Mul(a, b) => {
                let mut sum = Sparse::new();
                for i in 0..=k {
                    let (x, y) = (self.at(*a, i), self.at(*b, k - i));
                    add_product(&mut sum, &x, &y, Residue::ONE);
                }
                sum
            }
            Step::Inverse(a) => {
                let a = *a;
                if (0..=k).all(|i| Self::number(&self.at(a, i))) {
                    return Ok(numeric);
                }
                if self.program.still[r] && k > 0 {
                    return Ok(Sparse::new());
                }
                let v = self.fresh()?;
                self.coefficients[r].push(variable(v));
                let mut equation = Sparse::new();
                for i in 0..=k {
                    let (x, y) = (self.at(a, i), self.at(r, k - i));
                    add_product(&mut equation, &x, &y, Residue::ONE);
                }
                self.coefficients[r].pop();
                if k == 0 {
                    add(&mut equation, Vec::new(), -Residue::ONE);
                }
                self.equations.push(equation);
                variable(v)
            }
            Step::Chain { .. } => return Err(NoEquations::NotRational),
        })
    }
}

/// The equations for the outputs' coefficients up to the `heights`; `given` directions have the value of the point.
pub(crate) fn equations<const C: u64>(
    program: &SeriesProgram,
    series: &Expansion<'_, C>,
    given: &[bool],
    heights: &[usize],
) -> Result<Equations<C>, NoEquations> {
    let steps = program.steps.len();
    let directions = given.len();
    let mut b = Builder {
        program,
        series,
        next: directions as u16,
        equations: Vec::new(),
        coefficients: vec![Vec::new(); steps],
    };
    let last = heights.iter().copied().max().unwrap_or(0);
    for k in 0..=last {
        for r in 0..steps {
            let mut p = b.coefficient(r, k, given)?;
            if p.len() > MAX_TERMS {
                let v = b.fresh()?;
                add(&mut p, vec![(v, 1)], -Residue::ONE);
                b.equations.push(p);
                p = variable(v);
            }
            b.coefficients[r].push(p);
        }
    }
    for (&r, &height) in program.outputs.iter().zip(heights) {
        for k in 0..=height {
            let mut p = b.at(r, k);
            add(&mut p, Vec::new(), -series.at(r, k));
            b.equations.push(p);
        }
    }
    let mut list = b.equations;
    for p in &mut list {
        p.retain(|_, c| !c.is_zero());
    }
    list.retain(|p| !p.is_empty());
    let asked: Vec<Option<Sparse<C>>> = given.iter().zip(0..).map(|(&g, v)| (!g).then(|| variable(v))).collect();
    finish(list, asked)
}

/// Puts in what linear equations give for variables, and numbers those that are left.
fn finish<const C: u64>(
    mut list: Vec<Sparse<C>>,
    mut asked: Vec<Option<Sparse<C>>>,
) -> Result<Equations<C>, NoEquations> {
    while let Some((i, v)) = cheapest(&list) {
        let equation = list.swap_remove(i);
        let Some(lead) = equation.get(&vec![(v, 1)]).and_then(|c| c.inv()) else { continue };
        let rest: Sparse<C> =
            equation.into_iter().filter(|t| t.0 != vec![(v, 1)]).map(|(m, c)| (m, -(c * lead))).collect();
        for p in list.iter_mut().chain(asked.iter_mut().flatten()) {
            if p.keys().any(|m| m.iter().any(|x| x.0 == v)) {
                *p = put_in(p, v, &rest);
            }
        }
        list.retain(|p| !p.is_empty());
    }
    let mut used: Vec<u16> =
        list.iter().chain(asked.iter().flatten()).flat_map(|p| p.keys().flatten().map(|x| x.0)).collect();
    used.sort_unstable();
    used.dedup();
    if used.len() > MAX_VARIABLES {
        return Err(NoEquations::TooLarge);
    }
    let convert = |p: &Sparse<C>| -> Polynomial<C> {
        let mut sum = Sum::new();
        for (m, c) in p {
            let mut n = Monomial::ONE;
            for &(v, k) in m {
                let place = used.partition_point(|&u| u < v);
                n.exponents[place] = k;
                n.degree += u16::from(k);
            }
            sum.insert(n, *c);
        }
        Polynomial::from_sum(sum)
    };
    Ok(Equations {
        polynomials: list.iter().map(convert).collect(),
        variables: used.len(),
        asked: asked.iter().map(|p| p.as_ref().map(convert)).collect(),
    })
}

/// The equation and the variable that it gives with the least growth.
fn cheapest<const C: u64>(list: &[Sparse<C>]) -> Option<(usize, u16)> {
    let mut occurrences: BTreeMap<u16, usize> = BTreeMap::new();
    for m in list.iter().flat_map(BTreeMap::keys) {
        for &(v, _) in m {
            *occurrences.entry(v).or_default() += 1;
        }
    }
    let mut best: Option<(usize, usize, u16)> = None;
    for (i, p) in list.iter().enumerate().filter(|(_, p)| p.len() <= MAX_REST) {
        let degree: usize = p.keys().map(|m| m.iter().map(|x| usize::from(x.1)).sum()).max().unwrap_or(0);
        for m in p.keys() {
            let [(v, 1)] = m[..] else { continue };
            if p.keys().filter(|n| n.iter().any(|x| x.0 == v)).count() != 1 {
                continue;
            }
            let others = occurrences.get(&v).copied().unwrap_or(0).saturating_sub(1);
            let cost = others * p.len().saturating_sub(2) * if degree > 1 { degree * degree } else { 1 };
            if best.is_none_or(|b| (cost, i) < (b.0, b.1)) {
                best = Some((cost, i, v));
            }
        }
    }
    best.filter(|b| b.0 <= MAX_GROWTH).map(|b| (b.1, b.2))
}

/// A polynomial with another one in place of a variable.
fn put_in<const C: u64>(p: &Sparse<C>, v: u16, rest: &Sparse<C>) -> Sparse<C> {
    let mut sum = Sparse::new();
    for (m, c) in p {
        let exponent = m.iter().find(|x| x.0 == v).map_or(0, |x| x.1);
        let others: Powers = m.iter().copied().filter(|x| x.0 != v).collect();
        let mut term: Sparse<C> = std::iter::once((others, *c)).collect();
        for _ in 0..exponent {
            let mut next = Sparse::new();
            add_product(&mut next, &term, rest, Residue::ONE);
            term = next;
        }
        for (n, x) in term {
            add(&mut sum, n, x);
        }
    }
    sum.retain(|_, c| !c.is_zero());
    sum
}
