//! Common zeros of polynomials in parameters, as sets on which one parameter after the other is a rational function of
//! the rest.

use bracketry_symbolic::Rational;

use crate::algebra::rational::polynomial::{Budget, Polynomial};
use crate::parameters::factor::{Factor, RealZeros, factors, real_zeros, substituted};

/// Polynomials that vanish one after the other: each in the parameters that are left once those before are solved.
pub(crate) type Chain = Vec<Factor>;

/// Sets whose union holds all common zeros.
#[derive(Debug, Default)]
pub(crate) struct Components {
    pub(crate) chains: Vec<Chain>,
    /// There may be zeros that need more simultaneous conditions than were allowed.
    pub(crate) deeper: bool,
    /// Some sets were not found: the polynomials are too large, or not linear in any parameter.
    pub(crate) missing: bool,
}

/// More sets are not followed.
const MAX_CHAINS: usize = 60;

/// How a factor gives one of the parameters: v = −B/A where q = A v + B.
pub(crate) struct Solution {
    pub(crate) variable: usize,
    pub(crate) top: Polynomial,
    pub(crate) bottom: Polynomial,
}

/// The parameter that a polynomial is solved for: one with a constant coefficient if there is one.
pub(crate) fn solution(q: &Polynomial) -> Option<Solution> {
    let linear = q.support().into_iter().filter(|&v| q.degree(v) == 1);
    let variable = linear.min_by_key(|&v| (!q.coefficients(v)[1].is_constant(), q.coefficients(v)[1].len()))?;
    let [b, a] = &q.coefficients(variable)[..] else { return None };
    Some(Solution { variable, top: b.scaled(&-Rational::ONE), bottom: a.clone() })
}

/// One polynomial by its distinct factors: it vanishes where one of them does, nowhere without any.
type Factors = Vec<Factor>;

/// The common zeros of all `polynomials`, with up to `depth` conditions; `None` entries are zero everywhere.
pub(crate) fn components(polynomials: &[Polynomial], depth: usize, budget: &mut Budget) -> Components {
    let mut found = Components::default();
    let mut lists = Vec::new();
    for p in polynomials.iter().filter(|p| !p.is_zero()) {
        match factors(p, budget) {
            Some(list) => lists.push(list),
            // Without this polynomial there are only more zeros.
            None => found.missing |= lists.is_empty(),
        }
    }
    if lists.is_empty() {
        found.missing = true;
        return found;
    }
    follow(&lists, &[], depth, budget, &mut found);
    found
}

fn follow(lists: &[Factors], before: &[Factor], depth: usize, budget: &mut Budget, found: &mut Components) {
    if found.chains.len() >= MAX_CHAINS {
        found.missing = true;
        return;
    }
    let Some(first) = lists.first() else {
        if !found.chains.iter().any(|c| c == before) {
            found.chains.push(before.to_vec());
        }
        return;
    };
    let common: Factors = first.iter().filter(|q| lists.iter().all(|l| l.contains(q))).cloned().collect();
    for q in &common {
        branch(q, &[], before, depth, budget, found);
    }
    let rest: Vec<Factors> =
        lists.iter().map(|l| l.iter().filter(|q| !common.contains(q)).cloned().collect()).collect();
    let Some(shortest) = (0..rest.len()).min_by_key(|&i| rest[i].len()) else { return };
    for q in &rest[shortest] {
        let others: Vec<Factors> = rest.iter().enumerate().filter(|x| x.0 != shortest).map(|x| x.1.clone()).collect();
        branch(q, &others, before, depth, budget, found);
    }
}

/// Where q vanishes together with the others.
fn branch(
    q: &Factor,
    others: &[Factors],
    before: &[Factor],
    depth: usize,
    budget: &mut Budget,
    found: &mut Components,
) {
    match real_zeros(&q.polynomial, budget) {
        RealZeros::None => return,
        RealZeros::Together(list) => {
            let mut lists = others.to_vec();
            for m in &list {
                match factors(m, budget) {
                    Some(f) => lists.push(f),
                    None => found.missing = true,
                }
            }
            follow(&lists, before, depth, budget, found);
            return;
        }
        RealZeros::Open => {}
    }
    if depth == 0 {
        found.deeper = true;
        return;
    }
    let mut chain = before.to_vec();
    chain.push(q.clone());
    let Some(Solution { variable, top, bottom }) = solution(&q.polynomial) else {
        // Nothing can be put in for a parameter: a set of its own where nothing else has to vanish.
        if others.is_empty() {
            found.chains.push(chain);
        } else {
            found.missing = true;
        }
        return;
    };
    match restricted(others, variable, &top, &bottom, budget) {
        Some(lists) => follow(&lists, &chain, depth - 1, budget, found),
        None => found.missing = true,
    }
    // Where the coefficient of the parameter vanishes, the rest has to.
    if !bottom.is_constant() {
        let both = [&bottom, &top].map(|p| factors(p, budget));
        let [Some(a), Some(b)] = both else {
            found.missing = true;
            return;
        };
        let mut lists = others.to_vec();
        lists.push(a);
        if !top.is_zero() {
            lists.push(b);
        }
        follow(&lists, before, depth, budget, found);
    }
}

/// The other polynomials with the solution put in; those that vanish are left out.
fn restricted(
    others: &[Factors],
    variable: usize,
    top: &Polynomial,
    bottom: &Polynomial,
    budget: &mut Budget,
) -> Option<Vec<Factors>> {
    let mut lists = Vec::new();
    'polynomials: for list in others {
        let mut all = Factors::new();
        for q in list {
            let p = substituted(&q.polynomial, variable, top, bottom, budget)?;
            if p.is_zero() {
                continue 'polynomials;
            }
            for f in factors(&p, budget)? {
                if !all.contains(&f) {
                    all.push(f);
                }
            }
        }
        lists.push(all);
    }
    Some(lists)
}
