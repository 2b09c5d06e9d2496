//! Gröbner bases modulo a prime (Buchberger 1965), with the criteria of Gebauer and Möller (1988) and the sugar strategy
//! (Giovini, Mora, Niesi, Robbiano, and Traverso 1991), and the values that solutions have.

use bracketry_symbolic::{Echelon, Residue};

use crate::observability::identifiability::monomial::{Monomial, Polynomial, Sum, add_multiple};

/// Why there is no basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoBasis {
    TooLarge,
    Stopped,
}

/// What is left of the work allowed, in products of terms, and when to stop.
pub(crate) struct Work<'a> {
    pub(crate) products: usize,
    pub(crate) stop: &'a dyn Fn() -> bool,
    since: usize,
}

impl<'a> Work<'a> {
    pub(crate) fn new(products: usize, stop: &'a dyn Fn() -> bool) -> Self {
        Work { products, stop, since: 0 }
    }

    fn spend(&mut self, n: usize) -> Result<(), NoBasis> {
        self.products = self.products.checked_sub(n).ok_or(NoBasis::TooLarge)?;
        self.since += n;
        if self.since > 100_000 {
            self.since = 0;
            if (self.stop)() {
                return Err(NoBasis::Stopped);
            }
        }
        Ok(())
    }
}

struct Pair {
    i: usize,
    j: usize,
    lcm: Monomial,
    sugar: u16,
}

struct Element<const C: u64> {
    polynomial: Polynomial<C>,
    lead: Monomial,
    sugar: u16,
    /// Its leading monomial is not a multiple of a later one.
    active: bool,
}

/// A Gröbner basis whose leading monomials do not divide each other.
pub(crate) struct Basis<const C: u64> {
    elements: Vec<Element<C>>,
}

impl<const C: u64> Basis<C> {
    /// The basis of the ideal of these polynomials.
    pub(crate) fn of(mut given: Vec<Polynomial<C>>, work: &mut Work<'_>) -> Result<Self, NoBasis> {
        let mut basis = Basis { elements: Vec::new() };
        let mut pairs: Vec<Pair> = Vec::new();
        given.sort_by_key(|p| (p.lead().map(|m| m.degree), p.terms.len()));
        for p in given {
            let sugar = p.lead().map_or(0, |m| m.degree);
            let p = basis.normal_form(&p, work)?;
            basis.insert(p, sugar, &mut pairs);
        }
        while let Some(k) = (0..pairs.len()).min_by_key(|&k| (pairs[k].sugar, pairs[k].lcm)) {
            let pair = pairs.swap_remove(k);
            let (a, b) = (&basis.elements[pair.i], &basis.elements[pair.j]);
            let mut sum = Sum::new();
            work.spend(a.polynomial.terms.len() + b.polynomial.terms.len())?;
            let too_large = NoBasis::TooLarge;
            add_multiple(&mut sum, &a.polynomial.terms, &pair.lcm.over(&a.lead), Residue::ONE).ok_or(too_large)?;
            add_multiple(&mut sum, &b.polynomial.terms, &pair.lcm.over(&b.lead), -Residue::ONE).ok_or(too_large)?;
            let p = basis.reduced(sum, work)?;
            basis.insert(p, pair.sugar, &mut pairs);
        }
        Ok(basis)
    }

    fn insert(&mut self, p: Polynomial<C>, sugar: u16, pairs: &mut Vec<Pair>) {
        let Some(&lead) = p.lead() else { return };
        let new = self.elements.len();
        // Chain criterion for the pairs so far.
        pairs.retain(|q| {
            !lead.divides(&q.lcm)
                || self.elements[q.i].lead.lcm(&lead) == q.lcm
                || self.elements[q.j].lead.lcm(&lead) == q.lcm
        });
        let candidates: Vec<(usize, Monomial)> =
            self.elements.iter().enumerate().filter(|(_, e)| e.active).map(|(i, e)| (i, e.lead.lcm(&lead))).collect();
        for (k, &(i, lcm)) in candidates.iter().enumerate() {
            // One pair of each least common multiple, none if a smaller one divides it or one of them is a product.
            let beaten = candidates.iter().enumerate().any(|(l, &(j, other))| {
                l != k && other.divides(&lcm) && (other != lcm || l < k || self.elements[j].lead.coprime(&lead))
            });
            if beaten || self.elements[i].lead.coprime(&lead) {
                continue;
            }
            let of = |s: u16, lead: &Monomial| s + lcm.degree - lead.degree;
            let sugar = of(sugar, &lead).max(of(self.elements[i].sugar, &self.elements[i].lead));
            pairs.push(Pair { i, j: new, lcm, sugar });
        }
        for e in &mut self.elements {
            if lead.divides(&e.lead) {
                e.active = false;
            }
        }
        self.elements.push(Element { polynomial: p.monic(), lead, sugar, active: true });
    }

    /// What is left modulo the elements so far.
    pub(crate) fn normal_form(&self, p: &Polynomial<C>, work: &mut Work<'_>) -> Result<Polynomial<C>, NoBasis> {
        self.reduced(p.to_sum(), work)
    }

    fn reduced(&self, mut sum: Sum<C>, work: &mut Work<'_>) -> Result<Polynomial<C>, NoBasis> {
        let mut terms = Vec::new();
        while let Some((m, c)) = sum.pop_last() {
            if c.is_zero() {
                continue;
            }
            let divisor = self.elements.iter().filter(|e| e.active && e.lead.divides(&m));
            match divisor.min_by_key(|e| e.polynomial.terms.len()) {
                Some(e) => {
                    work.spend(e.polynomial.terms.len() + 4)?;
                    let shift = m.over(&e.lead);
                    add_multiple(&mut sum, &e.polynomial.terms[1..], &shift, -c).ok_or(NoBasis::TooLarge)?;
                }
                None => terms.push((m, c)),
            }
            work.spend(1)?;
        }
        Ok(Polynomial { terms })
    }

    /// The monomials that are no multiples of leading ones; `None` if there are more than `most`.
    pub(crate) fn standard_monomials(&self, variables: usize, most: usize) -> Option<Vec<Monomial>> {
        let standard = |m: &Monomial| !self.elements.iter().any(|e| e.active && e.lead.divides(m));
        let mut list = vec![Monomial::ONE];
        if !standard(&Monomial::ONE) {
            return Some(Vec::new());
        }
        let mut from = 0;
        while from < list.len() {
            let m = list[from];
            from += 1;
            // Each monomial once: by a variable that is not before the last one in it.
            let last = (0..variables).rev().find(|&i| m.exponents[i] > 0).unwrap_or(0);
            for i in last..variables {
                let next = m.times(&Monomial::variable(i))?;
                if standard(&next) {
                    list.push(next);
                    if list.len() > most {
                        return None;
                    }
                }
            }
        }
        Some(list)
    }

    /// Coefficients, from the constant one, of the monic polynomial of least degree that vanishes at the value of `p` in
    /// every solution, given the standard monomials.
    pub(crate) fn minimal_polynomial(
        &self,
        p: &Polynomial<C>,
        standard: &[Monomial],
        work: &mut Work<'_>,
    ) -> Result<Vec<Residue<C>>, NoBasis> {
        let d = standard.len();
        let mut echelon: Echelon<Residue<C>> = Echelon::empty(2 * d + 1);
        let mut power = Polynomial { terms: vec![(Monomial::ONE, Residue::ONE)] };
        let p = self.normal_form(p, work)?;
        for k in 0..=d {
            let mut row = vec![Residue::ZERO; 2 * d + 1];
            for (m, c) in &power.terms {
                if let Some(i) = standard.iter().position(|s| s == m) {
                    row[i] = *c;
                }
            }
            row[d + k] = Residue::ONE;
            work.spend(d * d)?;
            let rest = echelon.reduce(row);
            if rest[..d].iter().all(|c| c.is_zero()) {
                let relation = &rest[d..=d + k];
                let inverse = relation[k].inv().unwrap_or(Residue::ONE);
                return Ok(relation.iter().map(|&c| c * inverse).collect());
            }
            echelon.insert(rest);
            work.spend(power.terms.len() * p.terms.len())?;
            power = self.normal_form(&power.times(&p).ok_or(NoBasis::TooLarge)?, work)?;
        }
        Err(NoBasis::TooLarge)
    }
}

/// Number of distinct roots, in an extension of the field, of a polynomial of small degree.
pub(crate) fn distinct_roots<const C: u64>(p: &[Residue<C>]) -> usize {
    let derivative: Vec<Residue<C>> = p.iter().enumerate().skip(1).map(|(k, &c)| c * Residue::new(k as u64)).collect();
    let (mut a, mut b) = (p.to_vec(), derivative);
    let trim = |v: &mut Vec<Residue<C>>| {
        while v.last().is_some_and(|c| c.is_zero()) {
            v.pop();
        }
    };
    trim(&mut a);
    trim(&mut b);
    let degree = a.len().saturating_sub(1);
    while let Some(inverse) = b.last().and_then(|c| c.inv()) {
        while a.len() >= b.len() {
            let (c, shift) = (a[a.len() - 1] * inverse, a.len() - b.len());
            for (i, &x) in b.iter().enumerate() {
                a[shift + i] -= c * x;
            }
            trim(&mut a);
        }
        std::mem::swap(&mut a, &mut b);
    }
    degree - a.len().saturating_sub(1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    type P = Polynomial<1>;

    /// Polynomials by their terms: coefficient and exponents.
    fn polynomial(terms: &[(i64, &[u8])]) -> P {
        let mut sum = Sum::new();
        for (c, e) in terms {
            let mut m = Monomial::ONE;
            for (i, &k) in e.iter().enumerate() {
                m.exponents[i] = k;
                m.degree += u16::from(k);
            }
            sum.insert(m, Residue::from_i64(*c));
        }
        P::from_sum(sum)
    }

    fn values(given: Vec<P>, variables: usize) -> (usize, Vec<usize>) {
        let never = || false;
        let mut work = Work::new(10_000_000, &never);
        let basis = Basis::of(given, &mut work).unwrap();
        let standard = basis.standard_monomials(variables, 100).unwrap();
        let counts = (0..variables).map(|i| {
            let x = Polynomial { terms: vec![(Monomial::variable(i), Residue::ONE)] };
            distinct_roots(&basis.minimal_polynomial(&x, &standard, &mut work).unwrap())
        });
        let counts = counts.collect();
        (standard.len(), counts)
    }

    /// x + y = 5, x y = 6: two solutions, both coordinates with two values.
    #[test]
    fn symmetric_functions_have_as_many_solutions_as_permutations() {
        let given = vec![polynomial(&[(1, &[1, 0]), (1, &[0, 1]), (-5, &[])]), polynomial(&[(1, &[1, 1]), (-6, &[])])];
        assert_eq!(values(given, 2), (2, vec![2, 2]));
        // The elementary symmetric functions of three variables: 6 solutions, 3 values each.
        let given = vec![
            polynomial(&[(1, &[1, 0, 0]), (1, &[0, 1, 0]), (1, &[0, 0, 1]), (-6, &[])]),
            polynomial(&[(1, &[1, 1, 0]), (1, &[1, 0, 1]), (1, &[0, 1, 1]), (-11, &[])]),
            polynomial(&[(1, &[1, 1, 1]), (-6, &[])]),
        ];
        assert_eq!(values(given, 3), (6, vec![3, 3, 3]));
    }

    /// (x − 1)² = 0, y = x²: one solution of multiplicity two.
    #[test]
    fn multiple_solutions_count_once() {
        let given =
            vec![polynomial(&[(1, &[2, 0]), (-2, &[1, 0]), (1, &[])]), polynomial(&[(1, &[0, 1]), (-1, &[2, 0])])];
        assert_eq!(values(given, 2), (2, vec![1, 1]));
    }

    /// Random points: the polynomials that vanish at k points in general position of the plane have k solutions.
    #[test]
    fn cyclic_four_has_no_finite_set_of_solutions_and_cyclic_three_has_six() {
        let cyclic3 = vec![
            polynomial(&[(1, &[1, 0, 0]), (1, &[0, 1, 0]), (1, &[0, 0, 1])]),
            polynomial(&[(1, &[1, 1, 0]), (1, &[0, 1, 1]), (1, &[1, 0, 1])]),
            polynomial(&[(1, &[1, 1, 1]), (-1, &[])]),
        ];
        assert_eq!(values(cyclic3, 3).0, 6);
        let cyclic4 = vec![
            polynomial(&[(1, &[1, 0, 0, 0]), (1, &[0, 1, 0, 0]), (1, &[0, 0, 1, 0]), (1, &[0, 0, 0, 1])]),
            polynomial(&[(1, &[1, 1, 0, 0]), (1, &[0, 1, 1, 0]), (1, &[0, 0, 1, 1]), (1, &[1, 0, 0, 1])]),
            polynomial(&[(1, &[1, 1, 1, 0]), (1, &[0, 1, 1, 1]), (1, &[1, 0, 1, 1]), (1, &[1, 1, 0, 1])]),
            polynomial(&[(1, &[1, 1, 1, 1]), (-1, &[])]),
        ];
        let never = || false;
        let basis = Basis::of(cyclic4, &mut Work::new(10_000_000, &never)).unwrap();
        assert!(basis.standard_monomials(4, 200).is_none());
    }
}
