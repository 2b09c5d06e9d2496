//! Sparse polynomials with rational coefficients.

use std::collections::BTreeMap;

use bracketry_symbolic::{Fp, Rational};
use dashu_int::ops::BitTest;

/// Exponents by atom, without trailing zeros; their order is the lexicographic monomial order.
pub(crate) type Monomial = Vec<u32>;

/// Longest coefficient in a remainder sequence, in bits.
const MAX_BITS: usize = 256;

/// What is left of the work allowed, in products of two terms.
pub(crate) struct Budget(usize);

impl Budget {
    pub(crate) fn new(products: usize) -> Self {
        Budget(products)
    }

    fn spend(&mut self, products: usize) -> Option<()> {
        self.0 = self.0.checked_sub(products)?;
        Some(())
    }
}

/// A polynomial in atoms that are numbered from 0. Operations give `None` when the budget is spent.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Polynomial {
    /// No coefficient is zero.
    terms: BTreeMap<Monomial, Rational>,
}

fn times(a: &[u32], b: &[u32]) -> Monomial {
    let (long, short) = if a.len() >= b.len() { (a, b) } else { (b, a) };
    long.iter().enumerate().map(|(i, &k)| k + short.get(i).copied().unwrap_or(0)).collect()
}

fn trimmed(mut m: Monomial) -> Monomial {
    while m.last() == Some(&0) {
        m.pop();
    }
    m
}

/// `a / b` where b divides a.
fn over(a: &[u32], b: &[u32]) -> Option<Monomial> {
    if b.len() > a.len() {
        return None;
    }
    let m = a.iter().enumerate().map(|(i, &k)| k.checked_sub(b.get(i).copied().unwrap_or(0)));
    m.collect::<Option<Monomial>>().map(trimmed)
}

fn gcd_of_integers(mut a: dashu_int::UBig, mut b: dashu_int::UBig) -> dashu_int::UBig {
    while b != dashu_int::UBig::ZERO {
        (a, b) = (b.clone(), a % b);
    }
    a
}

impl Polynomial {
    pub(crate) fn constant(c: &Rational) -> Self {
        Self::term(c, Vec::new())
    }

    pub(crate) fn term(c: &Rational, m: Monomial) -> Self {
        let mut p = Self::default();
        p.add_term(trimmed(m), c);
        p
    }

    pub(crate) fn atom(i: usize) -> Self {
        let mut m = vec![0; i + 1];
        m[i] = 1;
        Self::term(&Rational::ONE, m)
    }

    pub(crate) fn terms(&self) -> impl ExactSizeIterator<Item = (&Monomial, &Rational)> {
        self.terms.iter()
    }

    pub(crate) fn len(&self) -> usize {
        self.terms.len()
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    pub(crate) fn is_constant(&self) -> bool {
        self.terms.keys().all(Vec::is_empty)
    }

    fn add_term(&mut self, m: Monomial, c: &Rational) {
        use std::collections::btree_map::Entry;
        if *c == Rational::ZERO {
            return;
        }
        match self.terms.entry(m) {
            Entry::Vacant(e) => {
                e.insert(c.clone());
            }
            Entry::Occupied(mut e) => {
                *e.get_mut() += c;
                if *e.get() == Rational::ZERO {
                    e.remove();
                }
            }
        }
    }

    pub(crate) fn add(&mut self, other: &Self, factor: &Rational) {
        for (m, c) in &other.terms {
            self.add_term(m.clone(), &(c * factor));
        }
    }

    pub(crate) fn scaled(&self, factor: &Rational) -> Self {
        let mut p = Self::default();
        p.add(self, factor);
        p
    }

    pub(crate) fn mul(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        budget.spend(self.len() * other.len())?;
        let mut p = Self::default();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                p.add_term(times(a, b), &(x * y));
            }
        }
        Some(p)
    }

    pub(crate) fn pow(&self, k: u32, budget: &mut Budget) -> Option<Self> {
        let mut p = Self::constant(&Rational::ONE);
        for _ in 0..k {
            p = p.mul(self, budget)?;
        }
        Some(p)
    }

    /// The atoms that occur.
    pub(crate) fn support(&self) -> Vec<usize> {
        let n = self.terms.keys().map(Vec::len).max().unwrap_or(0);
        (0..n).filter(|&i| self.degree(i) > 0).collect()
    }

    /// Highest exponent of atom `i`.
    pub(crate) fn degree(&self, i: usize) -> u32 {
        self.terms.keys().map(|m| m.get(i).copied().unwrap_or(0)).max().unwrap_or(0)
    }

    /// The coefficients of the powers of atom `i`, from the constant one.
    pub(crate) fn coefficients(&self, i: usize) -> Vec<Self> {
        let mut all = vec![Self::default(); self.degree(i) as usize + 1];
        for (m, c) in &self.terms {
            let mut rest = m.clone();
            let k = rest.get_mut(i).map_or(0, std::mem::take);
            all[k as usize].add_term(trimmed(rest), c);
        }
        all
    }

    /// The derivative by atom `i`.
    pub(crate) fn derivative(&self, i: usize) -> Self {
        let mut p = Self::default();
        for (m, c) in &self.terms {
            let Some(&k) = m.get(i).filter(|k| **k > 0) else { continue };
            let mut m = m.clone();
            m[i] = k - 1;
            p.add_term(trimmed(m), &(c * Rational::from(k)));
        }
        p
    }

    /// The coefficient of 1.
    pub(crate) fn constant_term(&self) -> Rational {
        self.terms.get(&Vec::new()).cloned().unwrap_or(Rational::ZERO)
    }

    /// Without the terms of a total degree above `most`.
    pub(crate) fn truncated(mut self, most: u32) -> Self {
        self.terms.retain(|m, _| m.iter().sum::<u32>() <= most);
        self
    }

    /// The term that is last in the lexicographic order.
    pub(crate) fn leading(&self) -> Option<(&Monomial, &Rational)> {
        self.terms.last_key_value()
    }

    /// The largest monomial that divides every term.
    pub(crate) fn monomial_content(&self) -> Monomial {
        let mut keys = self.terms.keys();
        let Some(first) = keys.next() else { return Vec::new() };
        let mut content = first.clone();
        for m in keys {
            for (i, k) in content.iter_mut().enumerate() {
                *k = (*k).min(m.get(i).copied().unwrap_or(0));
            }
        }
        trimmed(content)
    }

    pub(crate) fn divided_by_monomial(&self, by: &[u32]) -> Option<Self> {
        let terms = self.terms.iter().map(|(m, c)| Some((over(m, by)?, c.clone())));
        Some(Polynomial { terms: terms.collect::<Option<_>>()? })
    }

    /// `c` and `p` with `self = c·p`, p with coprime integer coefficients of which the leading one is positive.
    pub(crate) fn primitive(&self) -> (Rational, Self) {
        use dashu_int::{IBig, UBig};
        let Some((_, lead)) = self.terms.last_key_value() else { return (Rational::ONE, self.clone()) };
        let (mut top, mut bottom) = (UBig::ZERO, UBig::ONE);
        for c in self.terms.values() {
            let (_, size) = c.numerator().clone().into_parts();
            top = gcd_of_integers(size, top);
            let q = c.denominator().clone();
            bottom = &bottom * &q / gcd_of_integers(bottom.clone(), q);
        }
        let mut content = Rational::from(IBig::from(top)) / Rational::from(IBig::from(bottom));
        if *lead < Rational::ZERO {
            content = -content;
        }
        let p = self.scaled(&(Rational::ONE / &content));
        (content, p)
    }

    /// The quotient by `d` if the division leaves no remainder.
    pub(crate) fn exact_quotient(&self, d: &Self, budget: &mut Budget) -> Option<Self> {
        let (lead, c) = d.terms.last_key_value()?;
        let mut rest = self.clone();
        let mut quotient = Self::default();
        while let Some((m, x)) = rest.terms.last_key_value() {
            let factor = x / c;
            let shift = over(m, lead)?;
            budget.spend(d.len())?;
            let minus = -factor.clone();
            for (e, y) in &d.terms {
                rest.add_term(times(e, &shift), &(y * &minus));
            }
            quotient.add_term(shift, &factor);
        }
        Some(quotient)
    }

    /// A greatest common divisor (primitive remainder sequence, one atom after the other).
    pub(crate) fn gcd(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        if self.is_zero() || other.is_zero() {
            return Some(if self.is_zero() { other.clone() } else { self.clone() }.primitive().1);
        }
        if self.seen_coprime(other) {
            return Some(Self::constant(&Rational::ONE));
        }
        let (mine, theirs) = (self.support(), other.support());
        let Some(&v) = mine.iter().chain(&theirs).next() else { return Some(Self::constant(&Rational::ONE)) };
        match (mine.contains(&v), theirs.contains(&v)) {
            (true, false) => self.content_in(v, budget)?.gcd(other, budget),
            (false, true) => other.content_in(v, budget)?.gcd(self, budget),
            _ => {
                let (c, d) = (self.content_in(v, budget)?, other.content_in(v, budget)?);
                let common = c.gcd(&d, budget)?;
                let (mut a, mut b) = (self.exact_quotient(&c, budget)?, other.exact_quotient(&d, budget)?);
                if a.degree(v) < b.degree(v) {
                    std::mem::swap(&mut a, &mut b);
                }
                while !b.is_zero() && b.degree(v) > 0 {
                    let r = a.pseudo_remainder(&b, v, budget)?;
                    a = b;
                    b = if r.is_zero() { r } else { r.primitive_in(v, budget)? };
                }
                // A remainder without v: the primitive parts have nothing in common.
                let last = if b.is_zero() { a.primitive_in(v, budget)? } else { Self::constant(&Rational::ONE) };
                Some(common.mul(&last, budget)?.primitive().1)
            }
        }
    }

    /// True if modular images show that there is no common divisor but constants: whatever atom is
    /// kept while the others get values, the images are coprime.
    fn seen_coprime(&self, other: &Self) -> bool {
        let theirs = other.support();
        self.support().into_iter().filter(|v| theirs.contains(v)).all(|v| match (self.image(v), other.image(v)) {
            (Some(a), Some(b)) => coprime(a, b),
            _ => false,
        })
    }

    /// Coefficients of the powers of atom `v`, from the constant one, modulo a prime with values for
    /// the other atoms; `None` if the degree falls.
    fn image(&self, v: usize) -> Option<Vec<Fp>> {
        let mut list = vec![Fp::ZERO; self.degree(v) as usize + 1];
        for (m, c) in &self.terms {
            let mut value = Fp::from_rational(c)?;
            for (i, &k) in m.iter().enumerate().filter(|x| x.0 != v && *x.1 > 0) {
                // Any values will do, as long as they are the same for both polynomials.
                value *= Fp::new(0x9e37_79b9_7f4a_7c15_u64.wrapping_mul(i as u64 + 1) >> 3).pow(u64::from(k));
            }
            list[m.get(v).map_or(0, |&k| k as usize)] += value;
        }
        list.last().is_some_and(|c| *c != Fp::ZERO).then_some(list)
    }

    /// Stops where the coefficients have become long.
    fn check_coefficients(self) -> Option<Self> {
        let short = |n: &dashu_int::IBig| n.bit_len() <= MAX_BITS;
        self.terms.values().all(|c| short(c.numerator())).then_some(self)
    }

    /// Greatest common divisor of the coefficients of the powers of atom `v`.
    pub(crate) fn content_in(&self, v: usize, budget: &mut Budget) -> Option<Self> {
        let mut content = Self::default();
        for c in self.coefficients(v) {
            content = content.gcd(&c, budget)?;
            if content.is_constant() && !content.is_zero() {
                break;
            }
        }
        Some(content)
    }

    fn primitive_in(&self, v: usize, budget: &mut Budget) -> Option<Self> {
        let content = self.content_in(v, budget)?;
        Some(self.exact_quotient(&content, budget)?.primitive().1)
    }

    /// What is left of a multiple of `self` modulo `d`, in atom `v`.
    fn pseudo_remainder(&self, d: &Self, v: usize, budget: &mut Budget) -> Option<Self> {
        let k = d.degree(v);
        let lead = d.coefficients(v).pop()?;
        let mut rest = self.clone();
        while !rest.is_zero() && rest.degree(v) >= k {
            let mut shift = vec![0; v + 1];
            shift[v] = rest.degree(v) - k;
            let top = rest.coefficients(v).pop()?.mul(&Self::term(&Rational::ONE, shift), budget)?;
            let minus = d.mul(&top, budget)?;
            rest = rest.mul(&lead, budget)?;
            rest.add(&minus, &-Rational::ONE);
            rest = rest.check_coefficients()?;
        }
        Some(rest)
    }
}

/// Whether two polynomials in one variable have a constant greatest common divisor (Euclid).
fn coprime(mut a: Vec<Fp>, mut b: Vec<Fp>) -> bool {
    while b.len() > 1 {
        let Some(inverse) = b.last().and_then(|c| c.inv()) else { return false };
        while a.len() >= b.len() {
            let (top, shift) = (a[a.len() - 1] * inverse, a.len() - b.len());
            for (i, &c) in b.iter().enumerate() {
                a[shift + i] -= top * c;
            }
            a.pop();
        }
        while a.last() == Some(&Fp::ZERO) {
            a.pop();
        }
        std::mem::swap(&mut a, &mut b);
    }
    !b.is_empty()
}
