//! Monomials and polynomials modulo a prime, ordered by degree, then reverse lexicographically.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use bracketry_symbolic::Residue;

/// Most variables of a monomial.
pub(crate) const MAX_VARIABLES: usize = 24;

/// Exponents of up to [`MAX_VARIABLES`] variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Monomial {
    pub(crate) degree: u16,
    pub(crate) exponents: [u8; MAX_VARIABLES],
}

impl Monomial {
    pub(crate) const ONE: Self = Monomial { degree: 0, exponents: [0; MAX_VARIABLES] };

    pub(crate) fn variable(i: usize) -> Self {
        let mut m = Self::ONE;
        m.exponents[i] = 1;
        m.degree = 1;
        m
    }

    /// `None` where an exponent gets too large.
    pub(crate) fn times(&self, other: &Self) -> Option<Self> {
        let mut m = *self;
        m.degree += other.degree;
        for (a, b) in m.exponents.iter_mut().zip(&other.exponents) {
            *a = a.checked_add(*b)?;
        }
        Some(m)
    }

    pub(crate) fn divides(&self, other: &Self) -> bool {
        self.degree <= other.degree && self.exponents.iter().zip(&other.exponents).all(|(a, b)| a <= b)
    }

    /// `self / other`, which divides it.
    pub(crate) fn over(&self, other: &Self) -> Self {
        let mut m = *self;
        m.degree -= other.degree;
        for (a, b) in m.exponents.iter_mut().zip(&other.exponents) {
            *a -= b;
        }
        m
    }

    pub(crate) fn lcm(&self, other: &Self) -> Self {
        let mut m = Self::ONE;
        for (c, (a, b)) in m.exponents.iter_mut().zip(self.exponents.iter().zip(&other.exponents)) {
            *c = *a.max(b);
        }
        m.degree = m.exponents.iter().map(|&k| u16::from(k)).sum();
        m
    }

    pub(crate) fn coprime(&self, other: &Self) -> bool {
        self.exponents.iter().zip(&other.exponents).all(|(a, b)| *a == 0 || *b == 0)
    }
}

impl Ord for Monomial {
    fn cmp(&self, other: &Self) -> Ordering {
        self.degree.cmp(&other.degree).then_with(|| {
            let differing = self.exponents.iter().zip(&other.exponents).rev().find(|(a, b)| a != b);
            differing.map_or(Ordering::Equal, |(a, b)| b.cmp(a))
        })
    }
}

impl PartialOrd for Monomial {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Terms by falling monomial, without zeros.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polynomial<const C: u64> {
    pub(crate) terms: Vec<(Monomial, Residue<C>)>,
}

/// Terms that are still being added up.
pub(crate) type Sum<const C: u64> = BTreeMap<Monomial, Residue<C>>;

/// sum += c m p; `None` where an exponent gets too large.
pub(crate) fn add_multiple<const C: u64>(
    sum: &mut Sum<C>,
    p: &[(Monomial, Residue<C>)],
    m: &Monomial,
    c: Residue<C>,
) -> Option<()> {
    for (n, x) in p {
        let key = n.times(m)?;
        let value = *x * c;
        match sum.entry(key) {
            std::collections::btree_map::Entry::Vacant(e) => {
                e.insert(value);
            }
            std::collections::btree_map::Entry::Occupied(mut e) => {
                *e.get_mut() += value;
                if e.get().is_zero() {
                    e.remove();
                }
            }
        }
    }
    Some(())
}

impl<const C: u64> Polynomial<C> {
    pub(crate) fn from_sum(sum: Sum<C>) -> Self {
        Polynomial { terms: sum.into_iter().rev().filter(|t| !t.1.is_zero()).collect() }
    }

    pub(crate) fn to_sum(&self) -> Sum<C> {
        self.terms.iter().copied().collect()
    }

    pub(crate) fn lead(&self) -> Option<&Monomial> {
        self.terms.first().map(|t| &t.0)
    }

    /// With leading coefficient 1.
    pub(crate) fn monic(mut self) -> Self {
        if let Some(inverse) = self.terms.first().and_then(|t| t.1.inv()) {
            for t in &mut self.terms {
                t.1 *= inverse;
            }
        }
        self
    }

    /// `None` where an exponent gets too large.
    pub(crate) fn times(&self, other: &Self) -> Option<Self> {
        let mut sum = Sum::new();
        for (m, c) in &self.terms {
            add_multiple(&mut sum, &other.terms, m, *c)?;
        }
        Some(Self::from_sum(sum))
    }
}
