//! The eigenvalues of an exact matrix: multiplicities and half-planes exactly, values to the accuracy of `f64`.

use std::cmp::Ordering;

use bracketry_numerics::eigen::eigenvalues;
use bracketry_symbolic::{Coefficient, Rational, Real, UnivariatePolynomial};
use dashu_int::IBig;
use dashu_int::ops::BitTest;
use nalgebra::DMatrix;

use crate::linear::matrix::{Matrix, RationalMatrix};

/// An eigenvalue.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Root {
    pub(crate) re: f64,
    pub(crate) im: f64,
    /// Its algebraic multiplicity.
    pub(crate) multiplicity: usize,
    /// The eigenvalue itself, where it is rational.
    pub(crate) exact: Option<Rational>,
}

/// The eigenvalues with the exact numbers of them in each half-plane, counted with multiplicity.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Spectrum {
    /// By falling real part, then falling imaginary part.
    pub(crate) roots: Vec<Root>,
    pub(crate) left: usize,
    pub(crate) on_axis: usize,
    pub(crate) right: usize,
}

/// The numbers of eigenvalues with negative, zero, and positive real part of a square matrix, counted with multiplicity.
pub fn half_planes(a: &RationalMatrix) -> [usize; 3] {
    let spectrum = Spectrum::of(a);
    [spectrum.left, spectrum.on_axis, spectrum.right]
}

impl Spectrum {
    /// Of a square matrix.
    pub(crate) fn of(a: &RationalMatrix) -> Self {
        // All signs of rational numbers are known.
        Self::of_polynomial(&a.characteristic_polynomial()).unwrap_or_default()
    }

    /// Of a square matrix of real numbers; `None` where a sign is not known, and for a large matrix that is not rational.
    pub(crate) fn of_reals(a: &Matrix<Real>) -> Option<Self> {
        match a.rational() {
            Some(a) => Some(Self::of(&a)),
            None if a.rows().len() > MAX_IRRATIONAL => None,
            None => Self::of_polynomial(&a.characteristic_polynomial()),
        }
    }

    /// The roots of p; `None` where a sign is not known. Yun's square-free factors have simple roots, whose number is the multiplicity; in
    /// each, the pairs ±z are split off as the common factor of even and odd part, and what remains has no root on the axis,
    /// so that Sturm's sequence along the axis counts its half-planes (Gantmacher 1959, vol. 2, ch. XV).
    pub(crate) fn of_polynomial<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Option<Self> {
        let mut spectrum = Spectrum::default();
        for (multiplicity, factor) in square_free_factors(p) {
            spectrum.add(factor, multiplicity)?;
        }
        spectrum.roots.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        Some(spectrum)
    }

    fn add<C: Coefficient>(&mut self, mut p: UnivariatePolynomial<C>, multiplicity: usize) -> Option<()> {
        let mut push = |re: f64, im: f64, exact: Option<Rational>| {
            self.roots.push(Root { re, im, multiplicity, exact });
        };
        if p.coefficients().first().is_some_and(C::is_zero) {
            push(0.0, 0.0, Some(Rational::ZERO));
            self.on_axis += multiplicity;
            p = UnivariatePolynomial::new(p.coefficients()[1..].to_vec());
        }
        let pairs = common_of_parts(&p);
        let mut rest = p;
        if pairs.degree() > 0 {
            let (squares, exact) = simple_roots(&pairs)?;
            let on_axis = squares.iter().filter(|square| square.im == 0.0 && square.re < 0.0).count();
            if !exact && on_axis != negative_roots(&pairs)? {
                return None;
            }
            self.on_axis += 2 * on_axis * multiplicity;
            self.left += (pairs.degree() - on_axis) * multiplicity;
            self.right += (pairs.degree() - on_axis) * multiplicity;
            for square in squares {
                if square.im == 0.0 && square.re < 0.0 {
                    let w = (-square.re).sqrt();
                    push(0.0, w, None);
                    push(0.0, -w, None);
                } else {
                    let z = nalgebra::Complex::new(square.re, square.im).sqrt();
                    let exact = square.exact.as_ref().and_then(square_root);
                    push(z.re, z.im, exact.clone());
                    push(-z.re, 0.0 - z.im, exact.map(|r| -r));
                }
            }
            let in_squares: Vec<C> = pairs.coefficients().iter().flat_map(|c| [c.clone(), C::ZERO]).collect();
            rest = rest.quotient(&UnivariatePolynomial::new(in_squares));
        }
        if rest.degree() > 0 {
            let left = roots_in_left_half_plane(&rest)?;
            self.left += left * multiplicity;
            self.right += (rest.degree() - left) * multiplicity;
            for root in simple_roots(&rest)?.0 {
                push(root.re, root.im, root.exact);
            }
        }
        Some(())
    }
}

/// ω² > 0 where ±iω are the only pair ±z of roots of a polynomial.
pub(crate) fn squared_frequency<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Option<C> {
    let pairs = common_of_parts(p);
    let square = pairs.coefficients().first()?.times(&pairs.coefficients().get(1)?.inverse()?);
    (pairs.degree() == 1 && square.is_positive()).then_some(square)
}

/// The polynomial whose roots are the squares z² of the pairs ±z of roots: the common factor of even and odd part.
fn common_of_parts<C: Coefficient>(p: &UnivariatePolynomial<C>) -> UnivariatePolynomial<C> {
    let part =
        |parity: usize| UnivariatePolynomial::new(p.coefficients().iter().skip(parity).step_by(2).cloned().collect());
    part(0).gcd(&part(1))
}

/// The root of a rational number that is a square.
fn square_root(x: &Rational) -> Option<Rational> {
    let root = Rational::simplest_from_f64(x.to_f64().value().sqrt())?;
    (&root * &root == *x).then_some(root)
}

/// Yun's factors (1976) p_k with p = c Π p_k^k, those of degree 0 left out.
fn square_free_factors<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Vec<(usize, UnivariatePolynomial<C>)> {
    let mut factors = Vec::new();
    if p.degree() == 0 {
        return factors;
    }
    let derivative = p.derivative();
    let common = p.gcd(&derivative);
    let mut b = p.quotient(&common);
    let mut d = derivative.quotient(&common).sub(&b.derivative());
    let mut k = 1;
    while b.degree() > 0 {
        let factor = b.gcd(&d);
        b = b.quotient(&factor);
        d = d.quotient(&factor).sub(&b.derivative());
        if factor.degree() > 0 {
            factors.push((k, factor));
        }
        k += 1;
    }
    factors
}

/// Of a polynomial without roots on the imaginary axis: along x = iω its argument turns by π for each root in the left
/// half-plane more than in the right one, and the Cauchy index of its two parts by Sturm's sequence counts the turns.
fn roots_in_left_half_plane<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Option<usize> {
    let n = p.degree();
    // p(iω) = iⁿ (a(ω) − i b(ω)).
    let mut parts = [vec![C::ZERO; n + 1], vec![C::ZERO; n + 1]];
    for (k, c) in p.coefficients().iter().enumerate() {
        let down = n - k;
        parts[down % 2][k] = if (down / 2).is_multiple_of(2) { c.clone() } else { c.negative() };
    }
    let [a, b] = parts.map(UnivariatePolynomial::new);
    let chain = UnivariatePolynomial::signed_remainders(&a, &b);
    // left − right = V(−∞) − V(∞)
    Some((n + variations(&chain, true)? - variations(&chain, false)?) / 2)
}

/// Changes of sign of the polynomials at −∞ or ∞; `None` where a sign is not known.
pub(crate) fn variations<C: Coefficient>(chain: &[UnivariatePolynomial<C>], at_minus_infinity: bool) -> Option<usize> {
    let sign = |f: &UnivariatePolynomial<C>| -> Option<bool> {
        let positive = f.leading().sign()? == Ordering::Greater;
        Some(positive != (at_minus_infinity && !f.degree().is_multiple_of(2)))
    };
    let positive: Vec<bool> = chain.iter().map(sign).collect::<Option<_>>()?;
    Some(positive.windows(2).filter(|w| w[0] != w[1]).count())
}

/// The number of negative roots of a polynomial all of whose roots are simple and not 0 (Sturm).
fn negative_roots<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Option<usize> {
    let chain = UnivariatePolynomial::signed_remainders(p, &p.derivative());
    let at_zero = chain.iter().map(|f| f.coefficients().first()).filter(|c| c.is_some_and(|c| !c.is_zero()));
    let signs: Vec<Ordering> = at_zero.map(|c| c?.sign()).collect::<Option<_>>()?;
    Some(variations(&chain, true)? - signs.windows(2).filter(|w| w[0] != w[1]).count())
}

/// Most rows of a matrix that is not rational.
pub(crate) const MAX_IRRATIONAL: usize = 16;
/// Rounds of the iteration for complex roots, and the correction, relative to the root, at which it ends.
const ROUNDS: usize = 60;
const CONVERGED: f64 = 4.0 * f64::EPSILON;

/// The roots of a polynomial all of whose roots are simple, and whether it is rational; else they are those of one nearby.
fn simple_roots<C: Coefficient>(p: &UnivariatePolynomial<C>) -> Option<(Vec<Root>, bool)> {
    let nearby: Vec<Rational> = p.coefficients().iter().map(C::approximation).collect::<Option<_>>()?;
    let is_exact = p.coefficients().iter().zip(&nearby).all(|(c, x)| *c == C::of(x.clone()));
    let mut roots = roots_of_rational(&UnivariatePolynomial::new(nearby));
    if !is_exact {
        for root in &mut roots {
            root.exact = None;
        }
    }
    Some((roots, is_exact))
}

/// The roots of a polynomial all of whose roots are simple: real ones by bisection, the others by the iteration of Ehrlich (1967) and
/// Aberth (1973) from the eigenvalues of the companion matrix, with p/p' from exact values.
fn roots_of_rational(p: &UnivariatePolynomial) -> Vec<Root> {
    let real = p.roots();
    let mut roots: Vec<Root> =
        real.iter().map(|r| Root { re: r.value, im: 0.0, multiplicity: 1, exact: r.exact.clone() }).collect();
    // Rational roots are divided out.
    let mut rest = p.clone();
    for x in real.iter().filter_map(|r| r.exact.clone()) {
        rest = rest.quotient(&UnivariatePolynomial::new(vec![-x, Rational::ONE]));
    }
    let irrational = real.iter().filter(|r| r.exact.is_none()).count();
    let pairs = (rest.degree() - irrational) / 2;
    if pairs == 0 {
        return roots;
    }
    let mut found = aberth(&rest);
    // Of each conjugate pair the upper one; which roots are real is known.
    found.sort_by(|a, b| b.im.total_cmp(&a.im));
    for z in found.into_iter().take(pairs) {
        for im in [z.im, -z.im] {
            roots.push(Root { re: z.re, im, multiplicity: 1, exact: None });
        }
    }
    roots
}

type Complex = nalgebra::Complex<f64>;

fn aberth(p: &UnivariatePolynomial) -> Vec<Complex> {
    let coefficients = p.integer_coefficients();
    let mut z = first_guess(p);
    for _ in 0..ROUNDS {
        let mut moved = 0.0f64;
        for i in 0..z.len() {
            let Some(newton) = quotient(&coefficients, z[i]) else { continue };
            let others: Complex = (0..z.len()).filter(|&j| j != i && z[j] != z[i]).map(|j| (z[i] - z[j]).inv()).sum();
            let step = newton / (Complex::new(1.0, 0.0) - newton * others);
            if step.re.is_finite() && step.im.is_finite() {
                z[i] -= step;
                moved = moved.max(step.norm() / z[i].norm().max(f64::MIN_POSITIVE));
            }
        }
        if moved <= CONVERGED {
            break;
        }
    }
    z
}

/// p(z)/p'(z) at the complex number z, whose parts are taken as exact: they are a + b i over a power of two, so that integers suffice.
/// `coefficients` are integers, those of a multiple of p.
fn quotient(coefficients: &[IBig], z: Complex) -> Option<Complex> {
    let exact = [Rational::try_from(z.re).ok()?, Rational::try_from(z.im).ok()?];
    let down = exact.iter().map(|x| x.denominator().bit_len() - 1).max()?;
    let [a, b] = exact.map(|x| x.numerator() * (IBig::ONE << (down + 1 - x.denominator().bit_len())));
    // 2^(k down) times the value of the leading k + 1 coefficients, and of the derivative.
    let (mut p, mut d) = ([IBig::ZERO; 2], [IBig::ZERO; 2]);
    let times = |[x, y]: &[IBig; 2]| [x * &a - y * &b, x * &b + y * &a];
    for (k, c) in coefficients.iter().rev().enumerate() {
        // (q z + c)' = q' z + q
        let [x, y] = times(&d);
        d = [x + (&p[0] << down), y + (&p[1] << down)];
        let [x, y] = times(&p);
        p = [x + (c << (k * down)), y];
    }
    let [[a, b], [c, d]] = [p, d];
    let size = &c * &c + &d * &d;
    if size == IBig::ZERO {
        return None;
    }
    let size = Rational::from(size);
    let number = |x: IBig| (Rational::from(x) / &size).to_f64().value();
    Some(Complex::new(number(&a * &c + &b * &d), number(b * c - a * d)))
}

/// Eigenvalues of the companion matrix, of a variable scaled so that the roots have size 1 in the mean; where they are
/// not found, or fall together, points on a circle.
fn first_guess(p: &UnivariatePolynomial) -> Vec<Complex> {
    let n = p.degree();
    let leading = p.leading();
    let monic: Vec<Rational> = p.coefficients().iter().map(|c| c / &leading).collect();
    let log2 = monic[0].numerator().bit_len() as f64 - monic[0].denominator().bit_len() as f64;
    let scale = (log2 / n as f64).exp2();
    let power = |k: usize| scale.powi(k as i32 - n as i32);
    let companion = DMatrix::from_fn(n, n, |i, j| match (i, j) {
        (i, j) if j + 1 == n => -monic[i].to_f64().value() * power(i),
        (i, j) if i == j + 1 => 1.0,
        _ => 0.0,
    });
    let guesses = Some(companion).filter(|a| a.iter().all(|x| x.is_finite())).and_then(|a| eigenvalues(&a));
    let mut z: Vec<Complex> =
        guesses.unwrap_or_default().iter().map(|&(re, im)| Complex::new(re, im) * scale).collect();
    z.resize(n, Complex::new(0.0, 0.0));
    for i in 0..n {
        let apart = 1e-8 * scale;
        if z[i] == Complex::new(0.0, 0.0) || (0..i).any(|j| (z[i] - z[j]).norm() < apart) {
            // An angle that no symmetry of the roots shares.
            z[i] += Complex::from_polar(scale, 0.7 + std::f64::consts::TAU * i as f64 / n as f64) * 1e-3;
        }
    }
    z
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn polynomial(coefficients: &[i64]) -> UnivariatePolynomial {
        UnivariatePolynomial::new(coefficients.iter().map(|&c| Rational::from(c)).collect())
    }

    /// (x − r) for a real root r/q, (x² − 2a x + a² + b²) for a pair a ± ib.
    fn product(real: &[(i64, i64)], pairs: &[(i64, i64)]) -> UnivariatePolynomial {
        let linear = real.iter().map(|&(p, q)| polynomial(&[-p, q]));
        let quadratic = pairs.iter().map(|&(a, b)| polynomial(&[a * a + b * b, -2 * a, 1]));
        linear.chain(quadratic).fold(polynomial(&[1]), |p, f| p.mul(&f))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Polynomials with known roots: their multiplicities, half-planes, and values are found again.
        #[test]
        fn known_roots_are_found(real in prop::collection::vec((-6i64..7, 1i64..4), 0..6), pairs in prop::collection::vec((-3i64..4, 1i64..4), 0..4)) {
            let spectrum = Spectrum::of_polynomial(&product(&real, &pairs)).unwrap();
            let mut expected: Vec<(f64, f64)> = real.iter().map(|&(p, q)| (p as f64 / q as f64, 0.0)).collect();
            for &(a, b) in &pairs {
                expected.extend([(a as f64, b as f64), (a as f64, -b as f64)]);
            }
            prop_assert_eq!(spectrum.left, expected.iter().filter(|z| z.0 < 0.0).count());
            prop_assert_eq!(spectrum.on_axis, expected.iter().filter(|z| z.0 == 0.0).count());
            prop_assert_eq!(spectrum.right, expected.iter().filter(|z| z.0 > 0.0).count());
            for root in &spectrum.roots {
                let near = expected.iter().filter(|z| (z.0 - root.re).hypot(z.1 - root.im) <= 1e-12 * (1.0 + z.0.hypot(z.1))).count();
                prop_assert_eq!(near, root.multiplicity, "{:?} in {:?}", root, expected);
                prop_assert_eq!(root.exact.is_some(), root.im == 0.0);
            }
            prop_assert_eq!(spectrum.roots.iter().map(|r| r.multiplicity).sum::<usize>(), expected.len());
        }

        /// Half-planes of roots that are not rational agree with those of the eigenvalues, where these are clear.
        #[test]
        fn half_planes_agree_with_floating_point(entries in prop::collection::vec(-4i64..5, 25)) {
            let rows: Vec<Vec<Rational>> = entries.chunks(5).map(|r| r.iter().map(|&x| Rational::from(x)).collect()).collect();
            let spectrum = Spectrum::of(&RationalMatrix::new(rows, 5));
            let a = DMatrix::from_row_slice(5, 5, &entries.iter().map(|&x| x as f64).collect::<Vec<_>>());
            let numbers = eigenvalues(&a).unwrap_or_default();
            if numbers.len() == 5 && numbers.iter().all(|z| z.0.abs() > 1e-3) {
                prop_assert_eq!(spectrum.right, numbers.iter().filter(|z| z.0 > 0.0).count());
                prop_assert_eq!(spectrum.left, numbers.iter().filter(|z| z.0 < 0.0).count());
            }
        }
    }

    /// Wilkinson's polynomial, whose roots floating-point coefficients do not determine, and roots of very different size.
    #[test]
    fn ill_conditioned_roots_are_exact() {
        let p = product(&(1..=20).map(|k| (-k, 1)).collect::<Vec<_>>(), &[]);
        let roots = Spectrum::of_polynomial(&p).unwrap().roots;
        assert_eq!(roots.iter().map(|r| r.re).collect::<Vec<_>>(), (1..=20).map(|k| -f64::from(k)).collect::<Vec<_>>());
        let p = product(&[(-100_000, 1), (1, 2), (-1, 1), (-2, 1)], &[(-1, 1000)]);
        let spectrum = Spectrum::of_polynomial(&p).unwrap();
        assert_eq!((spectrum.left, spectrum.on_axis, spectrum.right), (5, 0, 1));
        let pair = spectrum.roots.iter().find(|r| r.im > 0.0).map(|r| (r.re, r.im));
        assert!(pair.is_some_and(|(re, im)| (re + 1.0).abs() < 1e-12 && (im - 1000.0).abs() < 1e-12), "{spectrum:?}");
    }

    /// Five oscillators with damping 1e-9 and frequencies next to each other: none is at zero, none is doubled.
    #[test]
    fn light_damping_is_seen() {
        let p = (1..=5).fold(polynomial(&[1]), |p, k| {
            p.mul(&UnivariatePolynomial::new(vec![
                Rational::from(1_000_000 + k),
                Rational::ONE / Rational::from(1_000_000_000),
                Rational::ONE,
            ]))
        });
        let spectrum = Spectrum::of_polynomial(&p).unwrap();
        assert_eq!((spectrum.left, spectrum.on_axis, spectrum.right), (10, 0, 0));
        assert!(
            spectrum.roots.iter().all(|r| r.multiplicity == 1 && (r.re + 0.5e-9).abs() < 1e-15 && r.im.abs() > 999.0)
        );
    }
}
