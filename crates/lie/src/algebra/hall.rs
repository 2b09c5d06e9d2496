//! Philip Hall bases of free Lie algebras.

use std::ops::Range;

use bracketry_symbolic::{Pool, Symbol};

use crate::algebra::field::{Field, bracket, is_plain_zero};
use crate::algebra::word::Word;
use crate::budget::check_growth;
use crate::undecided::Undecided;

/// Most elements of a [`HallBasis`].
const MAX_ELEMENTS: usize = 100_000;

/// A basis with more elements than are formed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the Hall basis has more than {limit} elements")]
pub struct HallTooLarge {
    /// Elements that are allowed.
    pub limit: usize,
}

/// An element of a [`HallBasis`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HallElement {
    /// The numbers of `a` and `b` in `[a, b]`; none for a generator.
    pub factors: Option<(usize, usize)>,
    /// How often each generator occurs; the sum is the length.
    pub degrees: Vec<usize>,
}

impl HallElement {
    /// Number of letters.
    pub fn length(&self) -> usize {
        self.degrees.iter().sum()
    }
}

/// A Philip Hall basis of the free Lie algebra on some generators, up to a length or to given degrees.
///
/// Its elements, in order of length, are the generators and those `[a, b]` with `a < b` where `b` is a
/// generator or `b = [c, d]` with `c ≤ a` (M. Hall 1950; Serre 1965, IV.5).
/// Every bracket of the generators is a combination of elements with the same degrees, with integer
/// coefficients, and in the free algebra the elements are independent: whatever identity holds among brackets of
/// one system beyond antisymmetry and Jacobi's comes from the system.
///
/// ```
/// use bracketry_lie::algebra::HallBasis;
/// let basis = HallBasis::new(2, 4).unwrap();
/// let names: Vec<String> = (0..basis.len()).map(|i| basis.name(i, &["f", "g"])).collect();
/// assert_eq!(names, ["f", "g", "[f,g]", "[f,[f,g]]", "[g,[f,g]]",
///                    "[f,[f,[f,g]]]", "[g,[f,[f,g]]]", "[g,[g,[f,g]]]"]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HallBasis {
    generators: usize,
    elements: Vec<HallElement>,
    /// Where the elements of length k + 1 begin, and the end.
    starts: Vec<usize>,
}

impl HallBasis {
    /// All elements of at most `length` letters.
    ///
    /// # Errors
    /// [`HallTooLarge`] if there are more than a hundred thousand.
    pub fn new(generators: usize, length: usize) -> Result<HallBasis, HallTooLarge> {
        Self::bounded(generators, length, |_| true)
    }

    /// All elements in which generator i occurs at most `degrees[i]` times.
    ///
    /// # Errors
    /// [`HallTooLarge`] if there are more than a hundred thousand.
    pub fn with_degrees(degrees: &[usize]) -> Result<HallBasis, HallTooLarge> {
        let length = degrees.iter().fold(0usize, |s, &d| s.saturating_add(d));
        Self::bounded(degrees.len(), length, |found| found.iter().zip(degrees).all(|(f, d)| f <= d))
    }

    /// `keep` must hold for the factors of what it holds for.
    fn bounded(generators: usize, length: usize, keep: impl Fn(&[usize]) -> bool) -> Result<HallBasis, HallTooLarge> {
        let mut basis = HallBasis { generators, elements: Vec::new(), starts: vec![0] };
        let too_large = HallTooLarge { limit: MAX_ELEMENTS };
        if generators > MAX_ELEMENTS {
            return Err(too_large);
        }
        if length > 0 {
            for i in 0..generators {
                let degrees: Vec<usize> = (0..generators).map(|j| usize::from(i == j)).collect();
                if keep(&degrees) {
                    basis.elements.push(HallElement { factors: None, degrees });
                }
            }
            basis.starts.push(basis.elements.len());
        }
        for l in 2..=length {
            // a < b, so b is no shorter.
            for short in 1..=l / 2 {
                let (of_a, of_b) = (basis.of_length(short), basis.of_length(l - short));
                for b in of_b {
                    let least = basis.elements[b].factors.map_or(0, |(c, _)| c);
                    for a in of_a.start.max(least)..of_a.end.min(b) {
                        let sum = basis.elements[a].degrees.iter().zip(&basis.elements[b].degrees);
                        let degrees: Vec<usize> = sum.map(|(x, y)| x + y).collect();
                        if keep(&degrees) {
                            basis.elements.push(HallElement { factors: Some((a, b)), degrees });
                        }
                    }
                    if basis.elements.len() > MAX_ELEMENTS {
                        return Err(too_large);
                    }
                }
            }
            basis.starts.push(basis.elements.len());
            // A longer element has a factor of more than l/2 letters.
            if basis.starts[l / 2] == basis.elements.len() {
                break;
            }
        }
        Ok(basis)
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// True without generators or for length 0.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Number of generators.
    pub fn generators(&self) -> usize {
        self.generators
    }

    /// The elements, in order of length; factors come before what they are factors of.
    pub fn elements(&self) -> &[HallElement] {
        &self.elements
    }

    /// Numbers of the elements with `length` letters.
    pub fn of_length(&self, length: usize) -> Range<usize> {
        match (length.checked_sub(1).and_then(|k| self.starts.get(k)), self.starts.get(length)) {
            (Some(&from), Some(&to)) => from..to,
            _ => self.len()..self.len(),
        }
    }

    /// Element `i` as a formal word.
    ///
    /// # Panics
    /// If there is no element `i`.
    pub fn word(&self, i: usize) -> Word {
        let element = &self.elements[i];
        match element.factors {
            Some((a, b)) => Word::bracket(self.word(a), self.word(b)),
            None => Word::Generator(element.degrees.iter().position(|d| *d == 1).unwrap_or_default()),
        }
    }

    /// Element `i` with the given names of the generators.
    ///
    /// # Panics
    /// If there is no element `i`.
    pub fn name(&self, i: usize, names: &[impl AsRef<str>]) -> String {
        self.word(i).name(names)
    }

    /// Every element as a vector field, for one field per generator.
    ///
    /// # Errors
    /// [`Undecided::TooLarge`] where the brackets take too many nodes.
    pub fn fields(&self, pool: &mut Pool, states: &[Symbol], generators: &[Field]) -> Result<Vec<Field>, Undecided> {
        let first = pool.len();
        let mut fields: Vec<Field> = Vec::with_capacity(self.len());
        for (i, element) in self.elements.iter().enumerate() {
            let field = match element.factors {
                Some((a, b)) => {
                    let (a, b) = (&fields[a], &fields[b]);
                    if is_plain_zero(pool, a) || is_plain_zero(pool, b) {
                        vec![pool.int(0); states.len()]
                    } else {
                        check_growth(pool, first, [a, b], 1)?;
                        bracket(pool, states, a, b)
                    }
                }
                None => match (self.word(i), generators) {
                    (Word::Generator(g), list) if g < list.len() => list[g].clone(),
                    _ => vec![pool.int(0); states.len()],
                },
            };
            fields.push(field);
        }
        Ok(fields)
    }
}

/// Number of elements of length `n` in a Hall basis on `generators` letters: Witt's formula (1937)
/// `1/n Σ_{d | n} μ(d) m^(n/d)`; `None` where it does not fit.
///
/// ```
/// use bracketry_lie::algebra::witt;
/// assert_eq!((1..=6).map(|n| witt(3, n).unwrap()).collect::<Vec<_>>(), [3, 3, 8, 18, 48, 116]);
/// ```
pub fn witt(generators: usize, n: usize) -> Option<u128> {
    if n == 0 {
        return Some(0);
    }
    let mut total: i128 = 0;
    for d in divisors(n) {
        let power = i128::try_from(generators).ok()?.checked_pow(u32::try_from(n / d).ok()?)?;
        total = total.checked_add(moebius(d) * power)?;
    }
    u128::try_from(total / n as i128).ok()
}

/// Number of elements with exactly these degrees: `1/n Σ_{d | all n_i} μ(d) (n/d)!/Π (n_i/d)!` with n = Σ n_i;
/// `None` where it does not fit.
///
/// ```
/// use bracketry_lie::algebra::witt_degrees;
/// assert_eq!(witt_degrees(&[1, 2]), Some(1)); // [g,[f,g]]
/// assert_eq!(witt_degrees(&[2, 2, 2]), Some(14));
/// ```
pub fn witt_degrees(degrees: &[usize]) -> Option<u128> {
    let n: usize = degrees.iter().sum();
    if n == 0 {
        return Some(0);
    }
    let common = degrees.iter().fold(0, |a, &b| gcd(a, b));
    let mut total: i128 = 0;
    for d in divisors(common) {
        let parts: Vec<usize> = degrees.iter().map(|k| k / d).collect();
        total = total.checked_add(moebius(d) * multinomial(&parts)?)?;
    }
    u128::try_from(total / n as i128).ok()
}

fn divisors(n: usize) -> impl Iterator<Item = usize> {
    (1..=n).filter(move |d| n.is_multiple_of(*d))
}

/// Möbius function: 0 with a square factor, else (−1)^(number of primes).
fn moebius(mut n: usize) -> i128 {
    let mut sign = 1;
    let mut p = 2;
    while p * p <= n {
        if n.is_multiple_of(p) {
            n /= p;
            if n.is_multiple_of(p) {
                return 0;
            }
            sign = -sign;
        }
        p += 1;
    }
    if n > 1 { -sign } else { sign }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// (Σ k)! / Π k! as a product of binomials.
fn multinomial(parts: &[usize]) -> Option<i128> {
    let (mut result, mut n) = (1_i128, 0_i128);
    for &k in parts {
        for j in 1..=k as i128 {
            n += 1;
            result = result.checked_mul(n)? / j;
        }
    }
    Some(result)
}
