//! Exponents of monomials.

/// Exponents of the variables.
pub(crate) type Monomial = Vec<u32>;

/// All monomials of n variables with a degree in the range, by degree.
pub(crate) fn monomials(n: usize, degrees: std::ops::RangeInclusive<u32>) -> Vec<Monomial> {
    degrees.flat_map(|d| of_degree(n, d)).collect()
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

/// The number of monomials of n variables up to a degree; none where it is very large.
pub(crate) fn count(n: usize, degree: u32) -> usize {
    (1..=degree as usize).fold(1usize, |c, k| c.saturating_mul(n + k) / k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_monomials_as_binomial_coefficients_say() {
        for (n, d) in [(1, 5), (2, 4), (3, 3), (4, 2)] {
            assert_eq!(monomials(n, 0..=d).len(), count(n, d), "{n} {d}");
        }
    }
}
