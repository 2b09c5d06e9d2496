//! Exponents of monomials.

use std::ops::RangeInclusive;

/// Exponents of the variables.
pub(crate) type Monomial = Vec<u32>;

/// More monomials are not listed; no program with that many is solved.
const MAX_LISTED: usize = 10_000;

/// All monomials of n variables with a degree in the range, by degree; none where they are too many.
pub(crate) fn monomials(n: usize, degrees: RangeInclusive<u32>) -> Option<Vec<Monomial>> {
    (count(n, *degrees.end()) <= MAX_LISTED).then(|| degrees.flat_map(|d| of_degree(n, d)).collect())
}

fn of_degree(n: usize, degree: u32) -> Vec<Monomial> {
    match n {
        0 => {
            if degree == 0 {
                vec![Vec::new()]
            } else {
                Vec::new()
            }
        }
        1 => vec![vec![degree]],
        _ => (0..=degree)
            .rev()
            .flat_map(|k| {
                of_degree(n - 1, degree - k).into_iter().map(move |rest| [k].into_iter().chain(rest).collect())
            })
            .collect(),
    }
}

pub(crate) fn product(a: &[u32], b: &[u32]) -> Monomial {
    a.iter().zip(b).map(|(i, j)| i + j).collect()
}

pub(crate) fn degree(m: &[u32]) -> u32 {
    m.iter().sum()
}

/// The number of monomials of n variables up to a degree, or any larger number than [`MAX_LISTED`] where there are more.
pub(crate) fn count(n: usize, degree: u32) -> usize {
    let mut count = 1;
    for k in 1..=degree as usize {
        count = count * (n + k) / k;
        if count > MAX_LISTED {
            break;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_monomials_as_binomial_coefficients_say() {
        for (n, d) in [(1, 5), (2, 4), (3, 3), (4, 2)] {
            assert_eq!(monomials(n, 0..=d).map(|list| list.len()), Some(count(n, d)), "{n} {d}");
        }
        for (n, d) in [(1, u32::MAX), (1000, 4), (10, 1000)] {
            assert_eq!(monomials(n, 0..=d), None, "{n} {d}");
        }
    }
}
